"""Many bodies of one kind in one entry of a scene, from arrays: their base class `Bulk`, and each kind."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, NoReturn, Self

import numpy as np
import numpy.typing as npt

from .._util.arrays import BoxEnds, FloatArray, ignore_fp_errors, matmul_rows, two_sum
from .._util.records import dataclass
from .._util.validation import DOMAIN, as_integer, format_value, is_outside_domain, real_array
from .bounds.aabb import EVERYWHERE
from .primitives import Box, Cone, Cylinder, Sphere
from .quadrics import Ellipsoid
from .shape import Shape, Sheet, Solid, Union
from .sheets import CLEAR_AREA, Disc, Triangle
from .transform import Motion

_LAST_SHARE = 1e-9
"""A body whose end in floats is within this share of sizes and places of the outermost end may be the outermost one."""
_MAX_LAST = 256
"""If more bodies than this may be outermost, their common box is wider instead of exact."""


class Bulk(Shape, abstract=True):
    """N bodies of one kind with consecutive ids, like N single shapes in the list.

    It is a scene entry only and does not combine with ``| & - ~``. A motion moves all bodies. `single` returns one.
    """

    combines: ClassVar[bool] = False
    columns: ClassVar[dict[str, tuple[str, ...]]] = {}
    """Field -> the headings of its numbers in a table: one for a number, three for a vector."""
    leaves: ClassVar[tuple[tuple[str | float, ...], ...]] = ()
    kind: ClassVar[Any]
    """For each primitive of a single shape: the fields and constants of its numbers, in order."""

    def single(self, index: int) -> Shape:
        """Return body `index` as a shape of its own under the same motion: a `kind` of the fields in `leaves`."""
        fields = (self.row(index, part) for part in self.leaves[0] if isinstance(part, str))
        solid: Shape = self.kind(*fields, motion=self.motion)
        return solid

    def check_rows(self) -> None:
        """Raise ValueError, by `refuse`, for impossible bodies; all numbers are finite and in the domain."""

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return about how far the bodies reach along the rows of a matrix (3, 3), down and up: two arrays (N, 3)."""
        raise NotImplementedError

    @ignore_fp_errors
    def __post_init__(self) -> None:
        owner = type(self).__name__
        given = {name: real_array(owner, name, getattr(self, name)) for name in self.columns}
        count = _count_rows(owner, given, self.columns)
        for name, values in given.items():
            column = _broadcast(values, count, len(self.columns[name]))
            _check_numbers(owner, name, column)
            # Prepared tables are kept with the shape, so its numbers must not change
            column.flags.writeable = False
            object.__setattr__(self, name, column)
        self.check_rows()

    def refuse(self, field: str, bad: Any, expected: str) -> None:
        """Raise ValueError for the first body whose `field` is `bad` (N,), with the `expected` value.

        For example: "Cylinders: radii[3] must be > 0, got -1.0".
        """
        rows = np.flatnonzero(bad)
        if len(rows):
            value = getattr(self, field)[rows[0]]
            raise ValueError(f"{type(self).__name__}: {field}[{rows[0]}] must be {expected}, got {value}")

    def __len__(self) -> int:
        return len(getattr(self, next(iter(self.columns))))

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        same = (np.array_equal(getattr(self, name), getattr(other, name)) for name in self.columns)
        return self.motion == other.motion and all(same)

    def __hash__(self) -> int:
        # Some bytes of one field are enough for a hash
        first = getattr(self, next(reversed(self.columns)))
        return hash((type(self), len(self), self.motion, first.tobytes()[:64]))

    def row(self, index: int, name: str) -> Any:
        """Return the field `name` of body `index` as a float, or as a tuple of three."""
        return _to_python(getattr(self, name)[self._place(index)])

    def _place(self, index: Any) -> int:
        """Return the index of one body as an int; raise TypeError or IndexError if there is no such body."""
        place = as_integer(index)
        if place is None:
            raise TypeError(f"{type(self).__name__}.single: index must be a whole number, got {format_value(index)}")
        if not 0 <= place < len(self):
            raise IndexError(
                f"{type(self).__name__}.single: index must be at least 0 and "
                f"below {len(self)}, got {format_value(index)}"
            )
        return place

    def numbers(self, leaf: int) -> FloatArray:
        """Return the numbers (N, n) of primitive number `leaf` of each body, in the order of its fields."""
        parts = [
            self._flat(part) if isinstance(part, str) else np.full((len(self), 1), part) for part in self.leaves[leaf]
        ]
        return np.concatenate(parts, axis=1)

    def _flat(self, name: str) -> FloatArray:
        """Return the numbers (N, n) of a field."""
        values: FloatArray = getattr(self, name)
        return values if values.ndim == 2 else values[:, None]

    @classmethod
    def headings(cls) -> tuple[str, ...]:
        """Return the headings of `table`."""
        return tuple(heading for headings in cls.columns.values() for heading in headings)

    def table(self) -> FloatArray:
        """Return all numbers except the motion, (N, columns)."""
        return np.concatenate([self._flat(name) for name in self.columns], axis=1)

    @classmethod
    def of_table(cls, table: FloatArray) -> Self:
        """Return the bodies of a `table`."""
        fields: dict[str, Any] = {}
        at = 0
        for name, headings in cls.columns.items():
            values = table[:, at : at + len(headings)]
            fields[name] = values if len(headings) > 1 else values[:, 0]
            at += len(headings)
        return cls(**fields)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the box around the boxes of all bodies.

        If hundreds of bodies end at one place, it is wider by 1e-9 of its size.
        """
        if len(self) == 0:
            return EVERYWHERE[1], EVERYWHERE[0]
        motion = self.motion.then(outer)
        matrix = motion.matrix
        down, up = self.reaches(matrix[:3, :3])
        ends = np.concatenate([down - matrix[:3, 3], up + matrix[:3, 3]], axis=1)
        # Floats find the bodies that may be outermost; the exact bounds of these alone give the ends
        size = _LAST_SHARE * (np.abs(ends).max(initial=0.0) + np.abs(matrix[:3, 3]).max(initial=0.0))
        last = [np.flatnonzero(column >= column.max() - size) for column in ends.T]
        known: dict[int, FloatArray] = {}
        result = np.empty(6)
        for side, which in enumerate(last):
            # A flat grid has a whole layer at one end, too many bodies to build one by one
            if len(which) > _MAX_LAST:
                result[side] = ends[:, side].max() + size
                continue
            for index in which.tolist():
                if index not in known:
                    low, high = self.single(index).bounds_under(outer)
                    # 0.0 - x, not -x, which makes -0.0 of 0.0
                    known[index] = np.concatenate([0.0 - low, high])
            result[side] = max(known[index][side] for index in which.tolist())
        return 0.0 - result[:3], result[3:] + 0.0

    def __or__(self, other: Any) -> NoReturn:
        raise _combination_error(self)

    __and__ = __sub__ = __ror__ = __rand__ = __rsub__ = __or__

    def __invert__(self) -> NoReturn:
        raise _combination_error(self)


def _combination_error(shape: Bulk) -> TypeError:
    name = type(shape).__name__
    return TypeError(
        f"{name}: does not combine with other shapes, it is an entry of a scene; {name}(...).single(i) does"
    )


def points_reach(points: Sequence[FloatArray], rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return `Bulk.reaches` of the hulls of points, arrays (N, 3)."""
    placed = [matmul_rows(each, rows.T) for each in points]
    return np.max([-each for each in placed], axis=0), np.max(placed, axis=0)


def balls_reach(
    centers: Iterable[FloatArray], radii: Iterable[FloatArray], rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return `Bulk.reaches` of the hulls of balls."""
    size = np.sqrt((rows**2).sum(axis=1))
    pairs = [
        (matmul_rows(center, rows.T), radius[:, None] * size) for center, radius in zip(centers, radii, strict=True)
    ]
    return np.max([reach - at for at, reach in pairs], axis=0), np.max([reach + at for at, reach in pairs], axis=0)


def discs_reach(
    centers: Iterable[FloatArray], normals: FloatArray, radii: Iterable[FloatArray], rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return `Bulk.reaches` of the hulls of discs across normals (N, 3), which may have any length."""
    unit = normals / np.sqrt((normals**2).sum(axis=1))[:, None]
    along = matmul_rows(unit, rows.T)
    across = np.sqrt(np.maximum((rows**2).sum(axis=1) - along**2, 0.0))
    pairs = [
        (matmul_rows(center, rows.T), radius[:, None] * across) for center, radius in zip(centers, radii, strict=True)
    ]
    return np.max([reach - at for at, reach in pairs], axis=0), np.max([reach + at for at, reach in pairs], axis=0)


def _to_python(value: Any) -> Any:
    plain = value.tolist()
    return tuple(plain) if isinstance(plain, list) else plain


def _count_rows(owner: str, arrays: dict[str, FloatArray], columns: dict[str, tuple[str, ...]]) -> int:
    """Return the number of bodies of some arrays: 1 if each of them has the numbers of a single body."""
    counts: dict[str, int] = {}
    for name, values in arrays.items():
        width = len(columns[name])
        own = 1 if width == 1 else 2
        if values.size == 0 and values.ndim <= own:
            counts[name] = 0
        elif values.ndim == own and (width == 1 or values.shape[1] == width):
            counts[name] = len(values)
        elif values.ndim != own - 1 or (width > 1 and values.shape != (width,)):
            one, many = ("one number", "(N,)") if width == 1 else (f"{width} numbers", f"(N, {width})")
            raise ValueError(f"{owner}: {name} must have shape {many}, or be {one} for all, got shape {values.shape}")
    different = sorted(set(counts.values()))
    if len(different) > 1:
        lengths = ", ".join(f"{name} of {count:,}" for name, count in counts.items())
        raise ValueError(f"{owner}: arrays must be of equally many bodies, got {lengths}")
    return different[0] if different else 1


def _broadcast(values: FloatArray, count: int, width: int) -> FloatArray:
    """Return a copy of the values, repeated for each body."""
    shape = (count,) if width == 1 else (count, width)
    return np.array(np.broadcast_to(values.reshape(shape) if values.size == 0 and count == 0 else values, shape))


def _check_numbers(owner: str, field: str, values: FloatArray) -> None:
    """Raise ValueError for the first body with a number that is not finite or not in the domain."""
    for bad, expected in ((~np.isfinite(values), "finite"), (is_outside_domain(values), DOMAIN)):
        rows = np.flatnonzero(bad if values.ndim == 1 else bad.any(axis=1))
        if len(rows):
            raise ValueError(
                f"{owner}: {field}[{rows[0]}] must be {expected}, got {format_value(_to_python(values[rows[0]]))}"
            )


@dataclass(frozen=True, eq=False)
class Spheres(Bulk, Solid):
    """N balls |x - centers[i]|² <= radii[i]² as N bodies with consecutive ids.

    `centers` (N, 3), `radii` (N,) or one number for all. A scene entry only: it does not combine with ``| & - ~``, as
    `Sphere` does. uv and face as for `Sphere`.
    """

    centers: Any
    radii: Any
    columns: ClassVar = {"centers": ("x", "y", "z"), "radii": ("radius",)}

    @ignore_fp_errors
    def __post_init__(self) -> None:
        centers = _floats("centers", self.centers)
        if centers.size == 0:
            centers = centers.reshape(0, 3)
        if centers.ndim != 2 or centers.shape[1] != 3:
            raise ValueError(f"Spheres: centers must have shape (N, 3), got {centers.shape}")
        radii = _floats("radii", self.radii)
        if radii.ndim == 0:
            radii = np.full(len(centers), float(radii))
        if radii.shape != (len(centers),):
            raise ValueError(
                f"Spheres: radii must have shape ({len(centers)},) as there are centers, got {radii.shape}"
            )
        for field, values in (("centers", centers), ("radii", radii)):
            bad = np.flatnonzero(~np.isfinite(np.atleast_2d(values.T)).all(axis=0))
            if len(bad):
                raise ValueError(f"Spheres: {field}[{bad[0]}] must be finite, got {values[bad[0]]}")
            bad = np.flatnonzero(np.atleast_2d(is_outside_domain(values).T).any(axis=0))
            if len(bad):
                raise ValueError(f"Spheres: {field}[{bad[0]}] must be {DOMAIN}, got {values[bad[0]]}")
        small = np.flatnonzero(radii <= 0)
        if len(small):
            raise ValueError(f"Spheres: radii[{small[0]}] must be > 0, got {radii[small[0]]}")
        for field, values in (("centers", centers), ("radii", radii)):
            values.flags.writeable = False
            object.__setattr__(self, field, values)

    def single(self, index: int) -> Sphere:
        return Sphere(self.row(index, "radii"), self.row(index, "centers"), motion=self.motion)

    def placed(self, outer: Motion) -> tuple[FloatArray, FloatArray, float | None]:
        """Return (centers in the world, linear part (3, 3), its factor if it is a similarity, else None)."""
        motion = self.motion.then(outer)
        if motion.is_identity:
            return self.centers, np.eye(3), 1.0
        matrix = motion.matrix
        linear = matrix[:3, :3]
        if np.array_equal(linear, np.eye(3)):
            return self.centers + matrix[:3, 3], linear, 1.0
        gram = matmul_rows(linear, linear.T)
        factor = float(np.sqrt(gram[0, 0]))
        similar = np.allclose(gram, gram[0, 0] * np.eye(3), rtol=0, atol=1e-15 * gram[0, 0])
        return matmul_rows(self.centers, linear.T) + matrix[:3, 3], linear, factor if similar else None

    def bounds_under(self, outer: Motion) -> BoxEnds:
        if len(self) == 0:
            return EVERYWHERE[1], EVERYWHERE[0]
        motion = self.motion.then(outer)
        shift = np.zeros(3) if motion.is_identity else motion.shift
        if shift is not None:
            ends = (_sum_up(sign * self.centers, sign * np.array(shift), self.radii[:, None]) for sign in (-1.0, 1.0))
            low, high = (end.max(axis=0) for end in ends)
            return 0.0 - low, high + 0.0
        centers, linear, _ = self.placed(outer)
        reach = self.radii[:, None] * np.sqrt((linear**2).sum(axis=1))
        low, high = (centers - reach).min(axis=0), (centers + reach).max(axis=0)
        return np.where(low == 0, 0.0, np.nextafter(low, -np.inf)), np.where(high == 0, 0.0, np.nextafter(high, np.inf))


def _sum_up(one: FloatArray, other: FloatArray, third: FloatArray) -> FloatArray:
    """Return the sum of three, or the next float if it is below the exact sum. An end that is exactly 0 is 0."""
    first, lost = two_sum(one, other)
    total, more = two_sum(first, third)
    small, least = two_sum(lost, more)
    total, rest = two_sum(total, small)
    return np.where(rest + least > 0, np.nextafter(total, np.inf), total)


def _floats(field: str, values: Any) -> FloatArray:
    return np.array(real_array("Spheres", field, values))


# Many shapes of one kind in one entry of a scene.
#
# Solids: cylinders, capsules, cones, ellipsoids and boxes. Sheets: discs and triangles.

_START, _END = ("start x", "start y", "start z"), ("end x", "end y", "end z")


@dataclass(frozen=True, eq=False)
class Cylinders(Bulk, Solid):
    """N closed circular cylinders from starts[i] to ends[i] as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `radii` (N,) or one number for all. A scene entry only: it does not
    combine with ``| & - ~``. Faces and uv as for `Cylinder` without angles.
    """

    starts: Any
    ends: Any
    radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "radii": ("radius",)}
    leaves: ClassVar = (("starts", "ends", "radii", 0.0, 360.0),)
    kind: ClassVar = Cylinder

    def check_rows(self) -> None:
        self.refuse("radii", self.radii <= 0, "> 0")
        self.refuse("ends", (self.starts == self.ends).all(axis=1), "another point than its start")

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return discs_reach((self.starts, self.ends), self.ends - self.starts, (self.radii, self.radii), rows)


@dataclass(frozen=True, eq=False)
class Capsules(Bulk, Solid):
    """N capsules, all points within radii[i] of the line from starts[i] to ends[i], as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `radii` (N,) or one number for all. A scene entry only: it does not
    combine with ``| & - ~``. Each is ``Cylinder(start, end, radius) | Sphere(radius, start) | Sphere(radius, end)``:
    face 0 is the side, 3 the ball at the start, 4 the one at the end, with the uv of these.
    """

    starts: Any
    ends: Any
    radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "radii": ("radius",)}
    leaves: ClassVar = (("starts", "ends", "radii", 0.0, 360.0), ("radii", "starts"), ("radii", "ends"))

    check_rows = Cylinders.check_rows

    def single(self, index: int) -> Union:
        start, end, radius = (self.row(index, name) for name in self.columns)
        return Union((Cylinder(start, end, radius), Sphere(radius, start), Sphere(radius, end)), motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return balls_reach((self.starts, self.ends), (self.radii, self.radii), rows)


@dataclass(frozen=True, eq=False)
class Cones(Bulk, Solid):
    """N closed cones or frustums from starts[i] to ends[i] as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `start_radii`, `end_radii` (N,) or one number for all, not both 0. A
    scene entry only: it does not combine with ``| & - ~``. Faces and uv as for `Cone` without angles.
    """

    starts: Any
    ends: Any
    start_radii: Any
    end_radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "start_radii": ("start radius",), "end_radii": ("end radius",)}
    leaves: ClassVar = (("starts", "ends", "start_radii", "end_radii", 0.0, 360.0),)
    kind: ClassVar = Cone

    def check_rows(self) -> None:
        self.refuse("start_radii", self.start_radii < 0, ">= 0")
        self.refuse("end_radii", self.end_radii < 0, ">= 0")
        self.refuse("end_radii", (self.start_radii == 0) & (self.end_radii == 0), "> 0 where start_radii is 0")
        self.refuse("ends", (self.starts == self.ends).all(axis=1), "another point than its start")

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return discs_reach((self.starts, self.ends), self.ends - self.starts, (self.start_radii, self.end_radii), rows)


@dataclass(frozen=True, eq=False)
class Ellipsoids(Bulk, Solid):
    """N ellipsoids about centers[i] with half-axes radii[i] along x, y and z, as N bodies with consecutive ids.

    `centers`, `radii` (N, 3) or three numbers for all. A scene entry only: it does not combine with ``| & - ~``. Faces
    and uv as for `Ellipsoid`.
    """

    centers: Any
    radii: Any
    columns: ClassVar = {"centers": ("x", "y", "z"), "radii": ("radius x", "radius y", "radius z")}
    leaves: ClassVar = (("radii", "centers"),)
    kind: ClassVar = Ellipsoid

    def check_rows(self) -> None:
        self.refuse("radii", (self.radii <= 0).any(axis=1), "> 0")

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        at, reach = matmul_rows(self.centers, rows.T), np.sqrt(matmul_rows(self.radii**2, rows.T**2))
        return reach - at, reach + at


@dataclass(frozen=True, eq=False)
class Boxes(Bulk, Solid):
    """N boxes from lows[i] to highs[i], edges along the axes, as N bodies with consecutive ids.

    `lows`, `highs` (N, 3) or one corner for all. A scene entry only: it does not combine with ``| & - ~``. Faces and uv
    as for `Box`.
    """

    lows: Any
    highs: Any
    columns: ClassVar = {"lows": ("low x", "low y", "low z"), "highs": ("high x", "high y", "high z")}
    leaves: ClassVar = (("lows", "highs"),)
    kind: ClassVar = Box

    def check_rows(self) -> None:
        bad = np.flatnonzero(~(self.lows < self.highs).all(axis=1))
        if len(bad):
            low, high = self.row(int(bad[0]), "lows"), self.row(int(bad[0]), "highs")
            raise ValueError(f"Boxes: highs[{bad[0]}] must be > lows[{bad[0]}] = {low} in each component, got {high}")

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        at, half = (
            matmul_rows((self.lows + self.highs) / 2, rows.T),
            matmul_rows((self.highs - self.lows) / 2, np.abs(rows.T)),
        )
        return half - at, half + at


# Sheets


@dataclass(frozen=True, eq=False)
class Discs(Bulk, Sheet):
    """N discs about centers[i] across normals[i] as N bodies with consecutive ids.

    `centers`, `normals` (N, 3) or three numbers for all, `radii` (N,) or one number for all. A scene entry only: solids
    do not clip it. Face and uv as for `Disc`.
    """

    centers: Any
    normals: Any
    radii: Any
    columns: ClassVar = {
        "centers": ("x", "y", "z"),
        "normals": ("normal x", "normal y", "normal z"),
        "radii": ("radius",),
    }
    leaves: ClassVar = (("centers", "normals", "radii"),)
    kind: ClassVar = Disc

    def check_rows(self) -> None:
        self.refuse("radii", self.radii <= 0, "> 0")
        self.refuse("normals", (self.normals == 0).all(axis=1), "another vector than zero")

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return discs_reach((self.centers,), self.normals, (self.radii,), rows)


@dataclass(frozen=True, eq=False)
class Triangles(Bulk, Sheet):
    """N triangles a[i], b[i], c[i] as N bodies with consecutive ids; `Triangles.of_mesh` takes vertices and faces.

    `a`, `b`, `c` (N, 3) or one corner for all. A scene entry only: solids do not clip it. Face and uv as for
    `Triangle`.
    """

    a: Any
    b: Any
    c: Any
    columns: ClassVar = {"a": ("a x", "a y", "a z"), "b": ("b x", "b y", "b z"), "c": ("c x", "c y", "c z")}
    leaves: ClassVar = (("a", "b", "c"),)
    kind: ClassVar = Triangle

    @classmethod
    def of_mesh(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Triangles:
        """Return the triangles of a mesh.

        Parameters
        ----------
        vertices : array (V, 3)
            The points.
        faces : array (N, 3)
            Indices of the three corners of each triangle.

        Raises
        ------
        ValueError
            For arrays of another shape, and for an index that is no integer or has no point.
        """
        points = real_array("Triangles", "vertices", vertices)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"Triangles: vertices must have shape (V, 3), got {points.shape}")
        given = real_array("Triangles", "faces", faces)
        given = given.reshape(-1, 3) if given.size == 0 else given
        if given.ndim != 2 or given.shape[1] != 3:
            raise ValueError(f"Triangles: faces must have shape (N, 3), got {given.shape}")
        uneven = np.flatnonzero((given != np.floor(given)).any(axis=1))
        if len(uneven):
            raise ValueError(f"Triangles: faces[{uneven[0]}] must be integers, got {given[uneven[0]]}")
        corners = np.clip(given, -1, len(points)).astype(np.int64)
        bad = np.flatnonzero(((corners < 0) | (corners >= len(points))).any(axis=1))
        if len(bad):
            these = ", ".join(f"{index:g}" for index in given[bad[0]].tolist())
            raise ValueError(f"Triangles: faces[{bad[0]}] must be at least 0 and below {len(points)}, got ({these})")
        return cls(*(points[corners[:, k]] for k in range(3)))

    def check_rows(self) -> None:
        x, y = (self.b - self.a).T, (self.c - self.a).T
        clear = np.zeros(len(self), bool)
        for i, j in ((1, 2), (2, 0), (0, 1)):
            one, other = x[i] * y[j], x[j] * y[i]
            clear |= np.abs(one - other) > CLEAR_AREA * (np.abs(one) + np.abs(other))
        # Floats leave these open: the single triangle decides exactly
        for index in np.flatnonzero(~clear).tolist():
            try:
                self.single(index)
            except ValueError:
                corners = ", ".join(str(self.row(index, name)) for name in self.columns)
                corner = f"a[{index}], b[{index}], c[{index}]"
                raise ValueError(f"Triangles: {corner} must not lie on a line, got {corners}") from None

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return points_reach((self.a, self.b, self.c), rows)
