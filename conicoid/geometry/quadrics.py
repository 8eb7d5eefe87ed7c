"""The quadric solids in their canonical frames.

Solids with elliptic sections across z are sx x² + sy y² <= g(z) with g(z) = g0 + g1 z + g2 z², cut by
low <= z <= high: `EllipticSolid` has their cell, caps, uv and bounds. The saddle and the hyperbolic and parabolic
cylinders may be cut by a box: `BoxedQuadric`.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

from .._util.arrays import FloatArray, Interval, Vector, VectorLike, ignore_fp_errors
from .._util.records import dataclass
from .._util.validation import check_fields, check_interval, check_positive, check_vector, format_value
from ..numerics import bigfloat as ex
from ..numerics.portable_math import (
    hypot,
    is_finite,
    negative_indicator,
    portable_max,
    portable_scale,
    portable_sqrt,
    select_if_several,
)
from .bounds.intersection import BoundsKind
from .bounds.support import (
    boxed_supports,
    elliptic_support,
    elliptic_supports,
    inverse_root,
    inverse_roots,
    inverse_square_pairs,
    sum_up,
)
from .cell import PLAIN_UV, UV, Cell, Face, cartesian_uv, cylindrical_uv, transform_uv
from .primitives import Box, axis_row
from .shape import PrimitiveSolid
from .surface import PlaneSurface, QuadricSurface
from .transform import IDENTITY_MOTION, Motion, Translate

EllipticProfile: TypeAlias = tuple[Any, Any, Any]


class EllipticSolid(PrimitiveSolid, abstract=True):
    """A solid sx x² + sy y² <= g(z) about the z axis of its own frame, within `z_range`.

    Faces: 0 the curved surface (both nappes or bowls of it), 1 the cap at z_range[0], 2 the cap at
    z_range[1]. uv: on face 0 (angle of (x, y) about z / 360, height scaled from the range to [0, 1]);
    the range counts from where the surface begins, and if it is infinite v is z itself.
    On the caps (x, y) in units of the half-axes of the cap's ellipse.
    Source: the Clemson notes, "parameterization".
    """

    A: float
    E: float
    z_range: Interval | None

    def __post_init__(self) -> None:
        """Check the numbers, and that z_range leaves a part of the solids that are not at every height."""
        numbers = {name: check_positive for name in ("A", "E", "H", "slope") if name in vars(self)}
        check_fields(self, **numbers, z_range=check_interval)
        if self.profile[0] < 0 or self.profile[1]:
            self.check_range()

    @property
    def squares(self) -> tuple[Any, Any]:
        """(sx, sy), exact and positive."""
        return self.A, self.E

    @property
    @abstractmethod
    def profile(self) -> EllipticProfile:
        """(g0, g1, g2), exact."""

    @property
    def extent(self) -> Interval:
        """The heights with g >= 0, if they are an interval; else all of z."""
        return -math.inf, math.inf

    def check_range(self) -> None:
        """Raise ValueError if the range holds nothing of the solid or only a point: if g <= 0 in all of it."""
        if self.z_range is None or self._reaches_into(*self.z_range):
            return
        name, (low, high) = type(self).__name__, self.z_range
        raise ValueError(
            f"{name}: z_range must leave a part of the solid, which has nothing in it, got ({low}, {high})"
        )

    def _reaches_into(self, low: float, high: float) -> bool:
        """Return True if g > 0 somewhere in the open range, decided exactly."""
        _, g1, g2 = (Fraction(g) for g in self.profile)
        summit = -g1 / (2 * g2) if g2 else Fraction(0)
        places = [Fraction(z) for z in (low, high) if math.isfinite(z)]
        # Between two ends without a section, an ellipsoid may still reach into the range
        if g2 < 0 and low < summit < high:
            places.append(summit)
        if any(self._g(z) > 0 for z in places):
            return True
        # Towards infinity the term of the highest power decides
        endless = [sense for z, sense in ((low, -1), (high, 1)) if math.isinf(z)]
        return any(g2 > 0 or (g2 == 0 and sense * g1 > 0) for sense in endless)

    @cached_property
    def widths(self) -> tuple[float, float]:
        """The half-axes of the section with g = 1."""
        sx, sy = self.squares
        return inverse_root(sx), inverse_root(sy)

    @property
    def heights(self) -> Interval:
        """The part of the extent in the range; low > high if there is none."""
        (low, high), (bottom, top) = self.z_range or (-math.inf, math.inf), self.extent
        return portable_max(low, bottom), -portable_max(-high, -top)

    def tree(self) -> Cell:
        sx, sy = self.squares
        g0, g1, g2 = self.profile
        # Linear terms of a surface are halves: it is squares·x² + 2 linear·x <= constant
        side = QuadricSurface((sx, sy, -g2), (0.0, 0.0, -g1 / 2), g0)
        low, high = self.heights
        return Cell((Face(side, 0, cylindrical_uv(low, high) if low < high else PLAIN_UV), *self.caps))

    @cached_property
    def caps(self) -> list[Face]:
        """The planes of the range, without planes that the surface does not reach."""
        caps = []
        for number, z, sense in ((1, self.z_range[0], -1.0), (2, self.z_range[1], 1.0)) if self.z_range else ():
            # A plane beyond the end of an ellipsoid would be a face that no ray meets
            if is_finite(z) and not self._beyond(z, sense):
                plane = PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z))
                caps.append(Face(plane, number, self._cap_uv(z)))
        return caps

    def _beyond(self, z: float, sense: float) -> bool:
        """Return True if z is beyond an end of the surface: g is concave, <= 0 at z and falls outward."""
        _, g1, g2 = self.profile
        return bool(g2 <= 0 and self._g(z) <= 0 and sense * (g1 + 2 * ex.rational(g2) * ex.rational(z)) < 0)

    def _cap_uv(self, z: float) -> Any:
        square = self._g(z)
        if square <= 0:
            return PLAIN_UV
        (x, y), size = self.widths, portable_sqrt(ex.rounded(square))
        return cartesian_uv((x * size, 0.0, 0.0), (0.0, y * size, 0.0))

    def _g(self, z: float | Fraction) -> Any:
        g0, g1, g2 = (ex.rational(g) for g in self.profile)
        height = ex.rational(z)
        return g0 + height * (g1 + height * g2)

    @property
    def _has_batch_support(self) -> bool:
        return True

    def support(self, direction: Vector) -> float:
        return float(self._supports([self], np.array([[direction]]))[0, 0])

    @classmethod
    def _supports(cls, shapes: Sequence[Any], directions: FloatArray) -> FloatArray:
        if cls.widths is EllipticSolid.widths:
            widths = inverse_roots(np.array([shape.squares for shape in shapes], np.float64))
            for shape, own in zip(shapes, widths.tolist(), strict=True):
                vars(shape)["widths"] = tuple(own)
        found = elliptic_supports(*cls._section_rows(shapes), directions)
        for shape, way in np.argwhere(np.isnan(found)).tolist():
            width_x, width_y, profile, low, high = shapes[shape]._section
            direction = tuple(directions[shape, way].tolist())
            found[shape, way] = elliptic_support(width_x, width_y, profile, low, high, direction)
        return found

    @property
    def _section(self) -> tuple[float, float, EllipticProfile, float, float]:
        """The half-axes of the section with g = 1, g, and the ends of the heights."""
        return *self.widths, self.profile, *self.heights

    @classmethod
    def _section_rows(cls, shapes: Sequence[Any]) -> tuple[FloatArray, FloatArray]:
        """Return the numbers of sections (n, 7) as floats, and what g0, g1 and g2 (n, 3) are above theirs."""
        known = [shape._section for shape in shapes]
        rows = [(x, y, *map(float, profile), low, high) for x, y, profile, low, high in known]
        rests = [[float(g - Fraction(float(g))) if isinstance(g, Fraction) else 0.0 for g in each[2]] for each in known]
        return np.array(rows), np.array(rests)


_DEFAULT_RADII: Vector = (1.0, 2.0, 3.0)


@dataclass(frozen=True)
class Ellipsoid(EllipticSolid):
    """(x / a)² + (y / b)² + (z / c)² <= 1 about `center`, (a, b, c) = `radii`.

    `z_range` cuts it: low <= z <= high, measured from the center. `coefficients` = (A, E, H), if
    given, stand instead of the radii and are kept to the bit: A x² + E y² + H z² <= 1.

    Faces: 0 the ellipsoid, 1 the cut at low, 2 the cut at high.
    uv: (angle of (x, y) / 360, height scaled from the lowest to the highest point of face 0 to [0, 1]);
    on the cuts (x, y) in units of the half-axes of the cut.
    Sources: the ray tracing notes (canonical quadric 1) and the graphics textbook (ALLIPS, ALLOID).
    """

    radii: VectorLike = _DEFAULT_RADII
    center: VectorLike = (0.0, 0.0, 0.0)
    z_range: Interval | None = None
    coefficients: Vector | None = field(default=None, kw_only=True)
    bounds_kind: ClassVar[BoundsKind] = "round"

    def __post_init__(self) -> None:
        radii = check_vector("Ellipsoid", "radii", self.radii)
        # The quick test first: scenes have millions of ellipsoids
        for i, r in enumerate(radii):
            if not r > 0:
                check_positive("Ellipsoid", f"radii[{i}]", r)
        if self.coefficients is not None:
            given, radii = radii, self._from_coefficients()
            if self.radii is not _DEFAULT_RADII and given != radii:  # `dataclasses.replace` passes both
                raise ValueError(f"Ellipsoid: radii must be left out where coefficients are given, got {given}")
        object.__setattr__(self, "radii", radii)
        check_fields(self, center=check_vector, z_range=check_interval)
        self.check_range()

    def _from_coefficients(self) -> Vector:
        a, e, h = check_vector("Ellipsoid", "coefficients", self.coefficients)
        a, e, h = (check_positive("Ellipsoid", name, value) for name, value in zip("AEH", (a, e, h), strict=True))
        object.__setattr__(self, "coefficients", (a, e, h))
        return inverse_root(a), inverse_root(e), inverse_root(h)

    @classmethod
    def from_coefficients(
        cls,
        A: float,
        E: float,
        H: float,
        center: VectorLike = (0.0, 0.0, 0.0),
        z_range: tuple[float, float] | None = None,
    ) -> Ellipsoid:
        """Return A x² + E y² + H z² <= 1 about `center`, cut by `z_range`.

        Parameters
        ----------
        A, E, H : float
            The coefficients, > 0, which are kept to the bit.
        center, z_range
            As for `Ellipsoid`.
        """
        given = (
            check_positive("Ellipsoid", "A", A),
            check_positive("Ellipsoid", "E", E),
            check_positive("Ellipsoid", "H", H),
        )
        return cls(center=center, z_range=z_range, coefficients=given)

    @property
    def placement(self) -> Motion:
        return Motion((Translate(self.center),))

    @cached_property
    def equation(self) -> tuple[Any, Any, Any, Any]:
        """(sx, sy, sz, k) of sx x² + sy y² + sz z² <= k, exact. A ball has sx = sy = sz = 1."""
        if self.coefficients is not None:
            return (*self.coefficients, 1.0)
        # By the largest square, so that equal radii give the coefficients of a ball, all exactly 1
        largest = ex.rational(portable_scale(self.radii)) ** 2
        sx, sy, sz = (largest / ex.rational(r) ** 2 for r in self.radii)
        return sx, sy, sz, largest

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.equation[0], self.equation[1]

    @cached_property
    def widths(self) -> tuple[float, float]:
        if self.coefficients is not None:
            return inverse_root(self.coefficients[0]), inverse_root(self.coefficients[1])
        # The largest radius has the square 1, which no recording could tell from a number beside it
        largest = portable_scale(self.radii)
        widths = []
        for radius, square in zip(self.radii, self.squares, strict=False):
            is_less = negative_indicator(radius - largest)
            below = inverse_root(square + ex.rational(1.0 - is_less))
            widths.append(select_if_several(2.0 * is_less, below, radius / largest))
        return widths[0], widths[1]

    @property
    def profile(self) -> EllipticProfile:
        _, _, sz, k = self.equation
        return k, 0, -sz

    @property
    def extent(self) -> Interval:
        return -self.radii[2], self.radii[2]

    def _reaches_into(self, low: float, high: float) -> bool:
        """Return the same without fractions for radii: then g > 0 is |z| < c, exactly."""
        if self.coefficients is not None:
            return super()._reaches_into(low, high)
        bottom, top = self.extent
        return low < top and high > bottom

    @property
    def _has_batch_support(self) -> bool:
        return self.z_range is not None

    def support(self, direction: Vector) -> float:
        if self.z_range is not None:
            return super().support(direction)
        a, b, c = self.radii
        return hypot(a * direction[0], b * direction[1], c * direction[2])

    @property
    def _section(self) -> tuple[float, float, EllipticProfile, float, float]:
        steep = 1 / Fraction(self.radii[2]) ** 2 if self.coefficients is None else Fraction(self.coefficients[2])
        return *self.radii[:2], (1, 0, -steep), *self.heights

    @classmethod
    def _section_rows(cls, shapes: Sequence[Any]) -> tuple[FloatArray, FloatArray]:
        if any(shape.coefficients is not None for shape in shapes):
            return super()._section_rows(shapes)
        radii, ends = np.array([shape.radii for shape in shapes]), np.array([shape.z_range for shape in shapes])
        height = radii[:, 2:]
        steep, rest = inverse_square_pairs(height)
        one, zero = np.ones_like(height), np.zeros_like(height)
        low, high = np.maximum(ends[:, :1], -height), np.minimum(ends[:, 1:], height)
        return np.hstack([radii[:, :2], one, zero, -steep, low, high]), np.hstack([zero, zero, -rest])


@dataclass(frozen=True)
class EllipticCylinder(EllipticSolid):
    """A x² + E y² <= 1, cut by `z_range`: a cylinder about z with the half-axes 1 / sqrt(A) and 1 / sqrt(E).

    Faces: 0 side, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 5a.
    """

    A: float
    E: float
    z_range: Interval | None = None

    profile = 1, 0, 0

    @property
    def _has_batch_support(self) -> bool:
        return False

    def support(self, direction: Vector) -> float:
        """Return the support along a direction: `elliptic_support` where g = 1, in floats, which a recording takes."""
        wide, uz = hypot(direction[0] * self.widths[0], direction[1] * self.widths[1]), direction[2]
        reaches = [sum_up((uz * z, wide)) for z in self.z_range or () if is_finite(z)]
        for z, slope in zip(self.z_range or (-math.inf, math.inf), (0.0 - uz, uz), strict=True):
            if not is_finite(z):
                if slope > 0:
                    return math.inf
                reaches += [] if slope < 0 else [wide]
        return functools.reduce(portable_max, reaches, -math.inf)


@dataclass(frozen=True)
class EllipticCone(EllipticSolid):
    """A x² + E y² - H z² <= 0, cut by `z_range`: both nappes about z, the apex at the origin.

    At z = h the section has the half-axes |h| sqrt(H / A) and |h| sqrt(H / E).
    Faces: 0 both nappes, 1 the cap at z_range[0], 2 the cap at z_range[1]. The apex has the axis for its normal.
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 4.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    @property
    def profile(self) -> EllipticProfile:
        return 0, 0, self.H


@dataclass(frozen=True)
class EllipticParaboloid(EllipticSolid):
    """A x² + E y² - z <= 0, cut by `z_range`: a bowl with its vertex at the origin, open upward.

    At z = h the section has the half-axes sqrt(h / A) and sqrt(h / E).
    Faces: 0 the paraboloid, 1 the cut at z_range[0], 2 the cut at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from [max(0, low), high] to [0, 1]), v = z while there is no
    upper end; on the cuts (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 2a.
    """

    A: float
    E: float
    z_range: Interval | None = None

    profile, extent = (0, 1, 0), (0.0, math.inf)


@dataclass(frozen=True)
class OneSheetHyperboloid(EllipticSolid):
    """A x² + E y² - H z² <= 1, cut by `z_range`: the solid within the one-sheeted hyperboloid about z.

    At z = h the section has the half-axes sqrt((1 + H h²) / A) and sqrt((1 + H h²) / E).
    Faces: 0 the hyperboloid, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 3a.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    @property
    def profile(self) -> EllipticProfile:
        return 1, 0, self.H


@dataclass(frozen=True)
class TwoSheetHyperboloid(EllipticSolid):
    """A x² + E y² - H z² <= -1, cut by `z_range`: the two bowls about z, with vertices at z = ±1 / sqrt(H).

    At z = h the sections have the half-axes sqrt((H h² - 1) / A) and sqrt((H h² - 1) / E).
    Faces: 0 both bowls, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 3b.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    @property
    def profile(self) -> EllipticProfile:
        return -1, 0, self.H


@dataclass(frozen=True)
class DoubleCone(EllipticSolid):
    """x² + y² <= slope² z²: both nappes about z, `slope` > 0; with a `z_range` across the apex, the bow tie.

    Faces: 0 both nappes, 1 the cap at z_range[0], 2 the cap at z_range[1]. The apex has the axis for its normal.
    uv: (angle / 360, height scaled from the range to [0, 1]), v = z without one; on the caps (x, y) / radius.
    Source: the graphics textbook (PICA; the bow tie becomes the truncated cone as the range slides along the axis).
    """

    slope: float = 1.0
    z_range: Interval | None = None

    @property
    def squares(self) -> tuple[Any, Any]:
        return 1.0, 1.0

    @property
    def profile(self) -> EllipticProfile:
        return 0, 0, ex.rational(self.slope) ** 2


# Quadrics without a bounded part of their own, which a box may cut


_CORNER_MARGIN = 2.0**-30
"""More than the rounding of a corner and of a polynomial there, as a share of its terms."""


class BoxedQuadric(PrimitiveSolid, abstract=True):
    """A quadric solid in its own frame, optionally the part of it in the box `within` (of that frame).

    Faces: 0 the quadric, 1 to 6 the faces of the box in its own order (low x, high x, low y, ...).
    uv of face 0: two of the box's own coordinates scaled to [0, 1], or of the shape's, unscaled, without
    a box; which two, the shape says. uv of the others: as on the box.
    """

    within: Box | None

    def __post_init__(self) -> None:
        check_fields(self, **{name: check_positive for name in ("A", "E", "G") if name in vars(self)})
        self.check_within()

    @ignore_fp_errors
    def check_within(self) -> None:
        """Raise ValueError for anything but None and a box that holds a part of the solid."""
        owner, box = type(self).__name__, self.within
        if box is None:
            return
        if not isinstance(box, Box):
            raise ValueError(f"{owner}: within must be a Box or None, got {type(box).__name__}")
        if self._holds_corner(box):  # nearly always, in a thirtieth of the time that a support takes
            return
        if self._supports([self], np.array([[[0.0, 0.0, 1.0]]]))[0, 0] == -math.inf:
            raise ValueError(
                f"{owner}: within must hold a part of the solid, which has nothing in it, got {format_value(box)}"
            )

    def _holds_corner(self, box: Box) -> bool:
        """Return True if a corner of a box is certainly inside the quadric."""
        matrix, surface = box.under(IDENTITY_MOTION).matrix, self.surface
        corners = np.array([*itertools.product(*zip(box.low, box.high, strict=True))])
        squares, linear = (np.array([*map(float, row)]) for row in (surface.squares, surface.linear))
        constant = float(surface.constant)
        x = corners @ matrix[:3, :3].T + matrix[:3, 3]
        size = np.abs(corners) @ np.abs(matrix[:3, :3]).T + np.abs(matrix[:3, 3])
        values = (x * x) @ squares + 2 * (x @ linear) - constant
        sizes = (size * size) @ np.abs(squares) + 2 * (size @ np.abs(linear)) + abs(constant)
        return bool((values < -_CORNER_MARGIN * sizes).any())

    @property
    @abstractmethod
    def surface(self) -> QuadricSurface:
        """The quadric, its rows the identity and its anchor the origin."""

    @property
    @abstractmethod
    def uv_axes(self) -> tuple[int, int]:
        """The two coordinates that are u and v on face 0."""

    def unbounded_support(self, direction: Vector) -> float:
        """Return the support without a box: by default that of all of space, the convex hull of a saddle."""
        return math.inf if any(direction) else 0.0

    def tree(self) -> Cell:
        if self.within is None:
            return Cell((Face(self.surface, 0, _coordinates(self.uv_axes)),))
        motion = self.within.under(IDENTITY_MOTION)
        uv = _coordinates(self.uv_axes, self.within)
        faces = [Face(self.surface, 0, transform_uv(uv, motion))]
        for face in self.within.tree().faces:
            surface, number = face.surface.moved(motion), face.number + 1
            faces.append(dataclasses.replace(face, surface=surface, number=number, uv=transform_uv(face.uv, motion)))
        return Cell(tuple(faces))

    @property
    def _has_batch_support(self) -> bool:
        return self.within is not None

    def support(self, direction: Vector) -> float:
        if self.within is None:
            return self.unbounded_support(direction)
        return float(self._supports([self], np.array([[direction]]))[0, 0])

    @classmethod
    @ignore_fp_errors
    def _supports(cls, shapes: Sequence[Any], directions: FloatArray) -> FloatArray:
        boxes, surfaces = [shape.within for shape in shapes], [shape.surface for shape in shapes]
        each = zip(shapes, directions.tolist(), strict=True)
        whole = [[shape.unbounded_support(way) for way in ways] for shape, ways in each]
        cut = boxed_supports(
            np.array([[*map(float, (*one.squares, *one.linear, one.constant))] for one in surfaces]),
            np.array([box.under(IDENTITY_MOTION).matrix[:3] for box in boxes]),
            np.array([(box.low, box.high) for box in boxes]),
            directions,
        )
        return np.minimum(cut, whole)


def _coordinates(axes: tuple[int, int], box: Box | None = None) -> UV:
    """Return the uv map of two coordinates, scaled over the box if there is one."""
    first, second = axes
    if box is None:
        return cartesian_uv(axis_row(first, 1.0), axis_row(second, 1.0))
    edges = [b - a for a, b in zip(box.low, box.high, strict=True)]
    return cartesian_uv(axis_row(first, edges[first]), axis_row(second, edges[second]), box.low)


@dataclass(frozen=True)
class HyperbolicParaboloid(BoxedQuadric):
    """A x² - E y² - z <= 0, cut by the box `within`: the part above the saddle z = A x² - E y².

    Faces: 0 the saddle, 1 to 6 the faces of the box. uv on the saddle: (x, y), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 2b.
    """

    A: float
    E: float
    within: Box | None = None

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((self.A, -self.E, 0.0), (0.0, 0.0, -0.5), 0.0)

    uv_axes = 0, 1


@dataclass(frozen=True)
class HyperbolicCylinder(BoxedQuadric):
    """A x² - E y² <= 1, cut by the box `within`: the part between the two walls x = ±sqrt((1 + E y²) / A).

    Faces: 0 both walls, 1 to 6 the faces of the box. uv on the walls: (y, z), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 5b.
    """

    A: float
    E: float
    within: Box | None = None

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((self.A, -self.E, 0.0), constant=1.0)

    uv_axes = 1, 2


@dataclass(frozen=True)
class ParabolicCylinder(BoxedQuadric):
    """x² - 2 G y <= 0, cut by the box `within`: a trough along z, open towards y, its bottom the z axis.

    Faces: 0 the trough, 1 to 6 the faces of the box. uv on the trough: (x, z), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 5c.
    """

    G: float
    within: Box | None = None

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((1.0, 0.0, 0.0), (0.0, -self.G, 0.0), 0.0)

    uv_axes = 0, 2

    def unbounded_support(self, direction: Vector) -> float:
        """Return the maximum of u_x x + u_y y, at x = -G u_x / u_y: -G u_x² / (2 u_y), finite for u_y < 0, u_z = 0."""
        x, y, z = direction
        if z != 0 or y > 0 or (y == 0 and x != 0):
            return math.inf
        return -self.G * x * x / (2 * y) if y else 0.0
