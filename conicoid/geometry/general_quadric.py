"""`Quadric`, the general quadric by its matrix or coefficients, and the exact classification of quadrics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from .._util.arrays import BoxEnds, Matrix4, Vector
from .._util.records import dataclass
from .._util.validation import check_matrix4, check_number, format_value
from ..numerics import bigfloat as ex, rational
from .bounds.quadric_extent import dual_support, quadric_ends
from .bounds.support import along_normal, half_space_bounds, plane_through, plane_uv
from .cell import UV, Cell, Face, transform_uv
from .principal_axes import Symmetric, eigen_decomposition, principal_quadric
from .shape import PrimitiveSolid
from .surface import UPRIGHT, PlaneSurface, QuadricSurface, Surface
from .transform import IDENTITY_MOTION, Motion, Translate


@dataclass(frozen=True)
class Quadric(PrimitiveSolid):
    """(x, y, z, 1) Q (x, y, z, 1)ᵀ <= 0, by its `matrix` or by named `coefficients`.

    Only the symmetric part of the matrix counts. Coefficients are xx, yy, zz, xy, yz, xz, x, y, z, constant;
    missing ones are 0, and xy multiplies x·y once. Without second-order terms it is a half-space. Pairs of
    planes, lines, points, all of space and nothing are legal; a constant alone is not.

    Face 0. uv: (angle of (x, y) / 360, z) about the center or, of paraboloids and cylinders, a point of the
    axis; of a half-space, the coordinates that `HalfSpace` has.
    Sources: the ray tracing notes (general quadric and its normal) and the Clemson notes (symmetric matrix).
    """

    matrix: Matrix4 | None = None
    coefficients: dict[str, float] | None = None

    def __post_init__(self) -> None:
        if (self.matrix is None) == (self.coefficients is None):
            present = "neither" if self.matrix is None else "both"
            raise ValueError(f"Quadric: exactly one of matrix and coefficients must be given, got {present}")
        if isinstance(self.matrix, Mapping):
            raise ValueError(
                "Quadric: matrix must be 4 x 4 numbers, got a mapping; Quadric(coefficients={...}) takes it"
            )
        if self.matrix is not None:
            object.__setattr__(self, "matrix", check_matrix4("Quadric", "matrix", self.matrix))
        else:
            object.__setattr__(self, "coefficients", check_coefficients("Quadric", self.coefficients))
        q = self.symmetric
        if not any(q[i][j] for i in range(3) for j in range(4)):
            field = "matrix" if self.matrix is not None else "coefficients"
            raise ValueError(f"Quadric: {field} must hold more than a constant, got {float(q[3][3])} alone")

    @property
    def symmetric(self) -> Symmetric:
        """Q, exact."""
        if self.matrix is not None:
            return symmetric_part(self.matrix)
        return matrix_of_coefficients(self.coefficients or {})

    @cached_property
    def surface(self) -> Surface:
        """The quadric about its principal axes; a plane if it has no second-order terms."""
        q = self.symmetric
        if any(q[i][j] for i in range(3) for j in range(3)):
            return principal_quadric(q)
        return plane_through((2 * q[0][3], 2 * q[1][3], 2 * q[2][3]), -q[3][3])

    def _with_motion(self, motion: Motion) -> Quadric:
        moved = super()._with_motion(motion)
        if "surface" in vars(self):  # its axes take ten milliseconds
            vars(moved)["surface"] = self.surface
        return moved

    @cached_property
    def classification(self) -> Classification:
        """The exact kind of the quadric, with its center, axes and semi-axes in the world."""
        return classify(self.symmetric, self.motion)

    def tree(self) -> Cell:
        return Cell((Face(self.surface, 0, self._uv()),))

    def _uv(self) -> UV:
        if isinstance(self.surface, PlaneSurface):
            return plane_uv(self.surface)
        x, y, z = map(ex.rounded, self.surface.anchor)
        upright = UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
        return transform_uv(upright, Motion((Translate((x, y, z)),)))

    def support(self, direction: Vector) -> float:
        surface = self.surface
        if isinstance(surface, PlaneSurface):
            x, y, z = (float(c) for c in surface.normal)
            multiple = along_normal((x, y, z), direction)
            return math.inf if multiple is None or multiple < 0 else float(multiple * surface.offset)
        u = ex.exact_row(direction)
        rows = ex.exact_row(surface.rows[0]), ex.exact_row(surface.rows[1]), ex.exact_row(surface.rows[2])
        # u·x = (W u)·y + u·anchor, the rows of W being orthonormal
        reach = dual_support(surface, ex.apply(rows, u))
        return float(reach) if isinstance(reach, float) else float(ex.dot(u, ex.exact_row(surface.anchor), reach))

    def ends(self, motion: Motion) -> list[float]:
        """Return the bounds by the dual quadric in 3000 bits, rounded outward; an end is infinite exactly if it is."""
        return _surface_ends(self.surface.moved(motion))

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds of f >= 0."""
        ends = _surface_ends(self.surface.reversed().moved(self.under(outer)))
        return np.array(ends[:3]), np.array(ends[3:])


def _surface_ends(surface: Surface) -> list[float]:
    if isinstance(surface, PlaneSurface):
        return [end for side in half_space_bounds(surface, above=False) for end in side.tolist()]
    return quadric_ends(surface)


# Classification of quadrics, decided exactly: the kind, and center, axes and semi-axes, rounded once.
#
# The file also checks the named coefficients of a quadric. `principal_axes.py` computes the axes.

COEFFICIENT_NAMES = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
_PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2)} | {
    "x": (0, 3),
    "y": (1, 3),
    "z": (2, 3),
    "constant": (3, 3),
}

_HALF = Fraction(1, 2)


class Coefficients(dict[str, float]):
    """The nonzero coefficients in the order of `COEFFICIENT_NAMES`, a dict that is hashable and immutable."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__({name: values[name] for name in COEFFICIENT_NAMES if values.get(name, 0.0) != 0})

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))

    def __reduce__(self) -> tuple[Any, ...]:
        return Coefficients, (dict(self),)

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("Coefficients cannot be changed")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse


def check_coefficients(owner: str, value: Any) -> Coefficients:
    """Return a mapping from names to numbers as `Coefficients`. Missing ones are 0; unknown names raise ValueError."""
    if not isinstance(value, Mapping):
        raise ValueError(
            f"{owner}: coefficients must be a mapping such as {{'xx': 1, 'constant': -1}}, got {format_value(value)}"
        )
    for name in value:
        if name not in COEFFICIENT_NAMES:
            raise ValueError(
                f"{owner}: coefficients must be named {', '.join(COEFFICIENT_NAMES)}, got {format_value(name)}"
            )
    return Coefficients({name: check_number(owner, f"coefficients.{name}", value[name]) for name in value})


def matrix_of_coefficients(values: Mapping[str, float]) -> Symmetric:
    """Return the symmetric 4 × 4 matrix; half of a mixed or linear coefficient is on either side of the diagonal."""
    rows = [[Fraction(0)] * 4 for _ in range(4)]
    for name, value in values.items():
        i, j = _PLACES[name]
        rows[i][j] += ex.rational(value) * _HALF
        rows[j][i] += ex.rational(value) * _HALF
    return tuple(tuple(row) for row in rows)


def symmetric_part(matrix: Iterable[Iterable[float]]) -> Symmetric:
    """Return (Q + Qᵀ) / 2, exact."""
    rows = [[ex.rational(value) for value in row] for row in matrix]
    return tuple(tuple((rows[i][j] + rows[j][i]) * _HALF for j in range(4)) for i in range(4))


# --- Kinds of quadrics

SPHERE, ELLIPSOID = "sphere", "ellipsoid"
ONE_SHEET, TWO_SHEETS = "one-sheet hyperboloid", "two-sheet hyperboloid"
CONE = "elliptic cone"
BOWL, SADDLE = "elliptic paraboloid", "hyperbolic paraboloid"
TUBE, TROUGHS, TROUGH = "elliptic cylinder", "hyperbolic cylinder", "parabolic cylinder"
CROSSING, PARALLEL, DOUBLE = "crossing planes", "parallel planes", "double plane"
LINE, POINT, PLANE, EMPTY = "line", "point", "plane", "empty"

KINDS = (
    SPHERE, ELLIPSOID, ONE_SHEET, TWO_SHEETS, CONE, BOWL, SADDLE, TUBE, TROUGHS, TROUGH,
    CROSSING, PARALLEL, DOUBLE, LINE, POINT, PLANE, EMPTY,
)  # fmt: skip
DEGENERATE = KINDS[KINDS.index(CROSSING) :]

# (numbers of positive and negative eigenvalues of A, the same of the 4 × 4 matrix), up to the sign of both matrices
BY_SIGNS = {
    ((3, 0), (3, 1)): ELLIPSOID, ((3, 0), (4, 0)): EMPTY, ((3, 0), (3, 0)): POINT,
    ((2, 1), (2, 2)): ONE_SHEET, ((2, 1), (3, 1)): TWO_SHEETS, ((2, 1), (2, 1)): CONE,
    ((2, 0), (3, 1)): BOWL, ((2, 0), (2, 1)): TUBE, ((2, 0), (3, 0)): EMPTY, ((2, 0), (2, 0)): LINE,
    ((1, 1), (2, 2)): SADDLE, ((1, 1), (2, 1)): TROUGHS, ((1, 1), (1, 2)): TROUGHS, ((1, 1), (1, 1)): CROSSING,
    ((1, 0), (2, 1)): TROUGH, ((1, 0), (1, 1)): PARALLEL, ((1, 0), (2, 0)): EMPTY, ((1, 0), (1, 0)): DOUBLE,
    ((0, 0), (1, 1)): PLANE,
}  # fmt: skip

# The side where the polynomial is negative, with the sign of the table above, and the side where it is positive
SIDES = {
    SPHERE: ("within", "outside"), ELLIPSOID: ("within", "outside"),
    ONE_SHEET: ("around the last axis", "away from the last axis"),
    TWO_SHEETS: ("within the two sheets", "between the two sheets"),
    CONE: ("within the nappes", "outside the nappes"),
    BOWL: ("within the bowl", "outside the bowl"),
    SADDLE: ("where the last axis points", "where the last axis points"),
    TUBE: ("within", "outside"), TROUGH: ("within", "outside"),
    TROUGHS: ("between the branches", "within the branches"),
    CROSSING: ("the two wedges about the first axis", "the two wedges about the first axis"),
    PARALLEL: ("between the planes", "beyond the planes"),
    DOUBLE: ("the plane alone", "all of space"), LINE: ("the line alone", "all of space"),
    POINT: ("the point alone", "all of space"), EMPTY: ("nothing", "all of space"),
    PLANE: ("where the last axis points", "where the last axis points"),
}  # fmt: skip


@dataclass(frozen=True)
class Classification:
    """The kind, place and measures of a quadric; numbers that are not exact are rounded once.

    kind        one of `KINDS`; crossing planes and all kinds after them are degenerate
    inside      the side that is inside, in words
    center      the center; for a cylinder the point of its axis (for a pair of planes or a line, of the common or
                middle line or plane) nearest to the origin; for a cone the apex; for paraboloids the vertex; for the
                parabolic cylinder and the plane the point of the line of vertices or of the plane nearest to the
                origin; None if there is no point at all
    axes        three unit vectors, right-handed. The last axis is unlike the others: for hyperboloids and cones the
                one with the other sign, for cylinders the ruling, for paraboloids the direction in which they open
                (for the parabolic cylinder the second axis), for a body of revolution its axis, for a plane its
                normal, towards the inside. The first axis is the longest semi-axis, the real one of a hyperbolic
                cylinder, or the normal of parallel planes
    semi_axes   along the first axes: half lengths, imaginary ones too; for paraboloids and the parabolic cylinder the
                radii of curvature at the vertex; for a cone the half-axes of the section at distance 1 from the apex;
                for crossing planes the slope; for parallel planes half their distance
    revolution  True for a surface of revolution
    """

    kind: str
    inside: str
    center: Vector | None = None
    axes: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    semi_axes: tuple[float, ...] = ()
    revolution: bool = False

    @property
    def degenerate(self) -> bool:
        """True for planes, lines, points and nothing."""
        return self.kind in DEGENERATE

    def __str__(self) -> str:
        words = [f"{self.kind} of revolution" if self.revolution and self.kind != SPHERE else self.kind]
        if self.center is not None:
            words.append(f"{_CENTERS.get(self.kind, 'center')} {_format_point(self.center)}")
        if self.semi_axes:
            words.append(
                f"{_MEASURES.get(self.kind, 'semi-axes')} {', '.join(_format_number(a) for a in self.semi_axes)}"
            )
        if self.center is not None and self.kind not in (SPHERE, POINT):
            words.append(f"axes {' '.join(_format_point(axis) for axis in self.axes)}")
        return "; ".join([*words, f"inside: {self.inside}"])


_CENTERS = {CONE: "apex", BOWL: "vertex", SADDLE: "vertex", TROUGH: "vertex", POINT: "at"} | dict.fromkeys(
    (TUBE, TROUGHS, LINE, PLANE, DOUBLE, PARALLEL, CROSSING), "through"
)
_MEASURES = dict.fromkeys((BOWL, SADDLE, TROUGH), "radii of curvature") | {
    CONE: "half-axes at distance 1",
    CROSSING: "slope",
    PARALLEL: "half distance",
    SPHERE: "radius",
}


def _format_number(value: float) -> str:
    return repr(value).removesuffix(".0")


def _format_point(point: Vector) -> str:
    return f"({', '.join(_format_number(c) for c in point)})"


# The kind of xᵀA x + 2 b·x + c <= 0, and its center, axes and semi-axes
#
# The kind follows from the numbers of positive and negative eigenvalues of A and of the 4 × 4 matrix. They are counted
# in rational numbers, so the last bit of a coefficient distinguishes a cone from a hyperboloid. Center and vertex are
# rational as well; axes and semi-axes come from 3000 bits, and all are rounded once.

_EQUAL_SHARE = ex.power_of_two(-200)
"""Eigenvalues of a moved quadric with a relative difference below this are equal."""
_CENTER_NOISE = ex.power_of_two(-ex.CANCELLED)
"""Coordinates of a center below this share of its size are rounding."""


def classify(matrix: Symmetric, motion: Motion = IDENTITY_MOTION) -> Classification:
    """Return the classification of (x, 1) matrix (x, 1)ᵀ <= 0, not a constant, after a motion.

    The kind is computed before the motion, so it is exact.
    """
    kind, sense = _kind_and_sense(matrix)
    null = rational.null_space([row[:3] for row in matrix[:3]])
    keeps_axes = motion.shift is not None or motion.is_identity
    if not motion.is_identity:
        linear, _ = motion.affine
        forward = [[ex.fraction(entry) for entry in row] for row in linear]
        null = [[rational.dot(row, vector) for row in forward] for vector in null]
        matrix = _substitute_rows(matrix, *motion.inverse)
    if sense < 0:
        matrix = tuple(tuple(-entry for entry in row) for row in matrix)
    return _PlacedQuadric(kind, sense, matrix, null, keeps_axes).classification()


def classify_surface(surface: QuadricSurface) -> Classification:
    """Return the classification of a quadric in the world.

    The kind is computed in the surface's own coordinates, in which its numbers are as written.
    """
    own = [[Fraction(0)] * 4 for _ in range(4)]
    for k, (square, linear) in enumerate(zip(surface.squares, surface.linear, strict=True)):
        own[k][k], own[k][3], own[3][k] = ex.fraction(square), ex.fraction(linear), ex.fraction(linear)
    own[3][3] = -ex.fraction(surface.constant)
    kind, sense = _kind_and_sense(tuple(map(tuple, own)))
    rows = tuple(ex.exact_row(row) for row in surface.rows)
    shift = ex.apply((rows[0], rows[1], rows[2]), ex.exact_row(surface.anchor))
    matrix = _substitute_rows(tuple(map(tuple, own)), rows, [-value for value in shift])
    null = rational.null_space([row[:3] for row in own[:3]])
    is_exact = surface.rows is UPRIGHT and not any(map(ex.is_rounded, surface.anchor))
    if not is_exact:
        forward = [[ex.fraction(entry) for entry in row] for row in ex.inverse((rows[0], rows[1], rows[2]))]
        null = [[rational.dot(row, vector) for row in forward] for vector in null]
    if sense < 0:
        matrix = tuple(tuple(-entry for entry in row) for row in matrix)
    return _PlacedQuadric(kind, sense, matrix, null, is_exact).classification()


def _kind_and_sense(matrix: Symmetric) -> tuple[str, int]:
    """Return (the kind, -1 if only the negative polynomial has the signs of `BY_SIGNS`, else 1)."""
    (p, n), (q, m) = rational.inertia([row[:3] for row in matrix[:3]]), rational.inertia(matrix)
    kind = BY_SIGNS[((n, p), (m, q)) if n > p else ((p, n), (q, m))]
    return SPHERE if kind == ELLIPSOID and _is_scalar(matrix) else kind, -1 if n > p else 1


def _is_scalar(matrix: Symmetric) -> bool:
    a = matrix
    return not (a[0][1] or a[0][2] or a[1][2]) and a[0][0] == a[1][1] == a[2][2]


def _substitute_rows(matrix: Symmetric, rows: Iterable[ex.Row], shift: Iterable[ex.BigFloat]) -> Symmetric:
    """Return the matrix of the quadric of all x with rows x + shift on the quadric of `matrix`."""
    back = [[*(ex.fraction(c) for c in row), ex.fraction(t)] for row, t in zip(rows, shift, strict=True)]
    back.append([Fraction(0), Fraction(0), Fraction(0), Fraction(1)])
    columns = list(zip(*back, strict=True))
    return tuple(tuple(row) for row in rational.matmul(rational.matmul(columns, matrix), back))


@dataclass(frozen=True)
class _PlacedQuadric:
    """A quadric in the world, its matrix with the signs of `BY_SIGNS`.

    `null` spans the kernel of A. `is_exact` is True if the matrix is exact, as without a motion or after a translation.
    """

    kind: str
    sense: int
    matrix: Symmetric
    null: list[list[Fraction]]
    is_exact: bool

    def classification(self) -> Classification:
        inside = SIDES[self.kind][self.sense < 0]
        if self.kind == TROUGHS:
            inside = SIDES[TROUGHS][(self._constant > 0) == (self.sense > 0)]
        if self.kind == EMPTY:
            return Classification(EMPTY, inside)
        values, rows = eigen_decomposition(self.matrix, 3 - len(self.null))
        squares = [ex.exact(value) for value in values]
        same = self._equal(squares)
        kind = self.kind
        if kind in (SPHERE, ELLIPSOID):
            kind = SPHERE if (_is_scalar(self.matrix) if self.is_exact else _all_equal(squares)) else ELLIPSOID
        order = self._order(squares, same)
        axes = self._axes([rows[k] for k in order])
        measures = self._measures([abs(squares[k]) for k in order])
        if kind == SPHERE:
            measures = measures[:1]
        center = (
            ex.exact_row(self._center) if self.is_exact else _denoise_point(self._center, max([ex.ZERO, *measures]))
        )
        return Classification(
            kind,
            inside,
            _round_vector(center),
            (_round_vector(axes[0]), _round_vector(axes[1]), _round_vector(axes[2])),
            tuple(float(m) for m in measures),
            same or kind == SPHERE,
        )

    @cached_property
    def _solution(self) -> tuple[list[Fraction], list[Fraction]]:
        """(the x nearest to the origin with A x + b in the kernel of A, that A x + b)."""
        a, b = [list(row[:3]) for row in self.matrix[:3]], [row[3] for row in self.matrix[:3]]
        size = len(self.null)
        bordered = [[*a[i], *(vector[i] for vector in self.null)] for i in range(3)]
        bordered += [[*vector, *([Fraction(0)] * size)] for vector in self.null]
        solution = rational.solve(bordered, [*(-entry for entry in b), *([Fraction(0)] * size)])
        gradient = [-sum((solution[3 + k] * self.null[k][i] for k in range(size)), Fraction(0)) for i in range(3)]
        return solution[:3], gradient

    def _value(self, x: list[Fraction]) -> Fraction:
        point = [*x, Fraction(1)]
        return rational.dot(point, [rational.dot(row, point) for row in self.matrix])

    @cached_property
    def _constant(self) -> Fraction:
        """The polynomial at the center."""
        return self._value(self._solution[0])

    @property
    def _opens(self) -> bool:
        return self.kind in (BOWL, SADDLE, TROUGH, PLANE)

    @property
    def _center(self) -> list[Fraction]:
        x, gradient = self._solution
        if not self._opens:
            return x
        t = -self._value(x) / (2 * rational.dot(gradient, gradient))
        return [c + t * g for c, g in zip(x, gradient, strict=True)]

    def _equal(self, squares: list[ex.BigFloat]) -> bool:
        """Return True if two nonzero eigenvalues are equal."""
        if len(self.null) > 1 or self.kind in DEGENERATE:
            return False
        if self.is_exact:
            return rational.has_equal_eigenvalues([row[:3] for row in self.matrix[:3]])
        nonzero = [s for s in squares if s]
        largest = max(abs(s) for s in nonzero)
        gaps = [abs(a - b) for i, a in enumerate(nonzero) for b in nonzero[:i]]
        return bool(min(gaps) <= _EQUAL_SHARE * largest)

    def _order(self, squares: list[ex.BigFloat], same: bool) -> list[int]:
        """Return the indices of the eigenvalues of the first, second and last axis."""
        if self.kind in (TROUGHS, CROSSING, SADDLE):
            first_is_positive = self.kind == SADDLE or (self.kind == TROUGHS and self._constant < 0)
            return sorted(range(3), key=lambda k: (not squares[k], (squares[k] > 0) != first_is_positive))
        order = sorted(range(3), key=lambda k: (not squares[k], squares[k] < 0, squares[k]))
        if self.kind in (ELLIPSOID, SPHERE) and same:
            a, b, c = (squares[k] for k in order)
            if b - a > c - b:  # the first is unlike the others: it becomes the last
                order = [order[1], order[2], order[0]]
        return order

    def _axes(self, rows: list[Any]) -> tuple[ex.Row, ex.Row, ex.Row]:
        first = _orient_axis(ex.exact_row(rows[0]))
        if not self._opens:
            last = _orient_axis(ex.exact_row(rows[2]))
            return first, ex.cross(last, first), last
        gradient = self._solution[1]
        x, y, z = (ex.exact(-g) for g in gradient)
        opening = ex.unit((x, y, z))
        if self.kind == TROUGH:
            return first, opening, ex.cross(first, opening)
        if self.kind == PLANE:
            least = min(range(3), key=lambda i: abs(opening[i]))
            first = ex.unit(ex.cross(opening, ex.IDENTITY[least]))
        return first, ex.cross(opening, first), opening

    def _measures(self, sizes: list[ex.BigFloat]) -> list[ex.BigFloat]:
        root, kind = ex.sqrt, self.kind
        sizes = [s for s in sizes if s]
        if kind in (BOWL, SADDLE, TROUGH):
            gradient = self._solution[1]
            slope = root(ex.exact(rational.dot(gradient, gradient)))
            return [slope / s for s in sizes]
        if kind == CONE:
            return [root(sizes[2] / s) for s in sizes[:2]]
        if kind == CROSSING:
            return [root(sizes[0] / sizes[1])]
        if kind in (PLANE, LINE, POINT, DOUBLE):
            return []
        constant = abs(ex.exact(self._constant))
        return [root(constant / s) for s in sizes]


def _all_equal(squares: list[ex.BigFloat]) -> bool:
    return bool(max(squares) - min(squares) <= _EQUAL_SHARE * max(abs(s) for s in squares))


def _orient_axis(row: ex.Row) -> ex.Row:
    """Return the vector or its opposite, so that its first nonzero component is positive."""
    sign = next((c for c in row if c), ex.ONE)
    return row if sign > 0 else (-row[0], -row[1], -row[2])


def _denoise_point(point: list[Fraction], size: ex.BigFloat) -> ex.Row:
    """Return a point in 3000 bits, with 0 for coordinates that are only rounding."""
    x, y, z = (ex.exact(c) for c in point)
    noise = _CENTER_NOISE * max(size, abs(x), abs(y), abs(z))
    x, y, z = (ex.ZERO if abs(c) < noise else c for c in (x, y, z))
    return x, y, z


def _round_vector(row: ex.Row) -> Vector:
    x, y, z = (float(c) + 0.0 for c in row)
    return x, y, z
