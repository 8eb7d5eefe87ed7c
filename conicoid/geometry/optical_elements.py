"""Optical elements as solids: lenses, cemented groups of lenses, the mirror on a substrate, and prisms.

Lenses and mirrors are solids of revolution between two conics or planes.
"""

from __future__ import annotations

import itertools
import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from .._util.arrays import Vector
from .._util.records import dataclass
from .._util.validation import (
    check_fields,
    check_nonnegative,
    check_number,
    check_positive,
    describe_kind,
    format_value,
    optional,
)
from ..materials.coating import Coating
from ..materials.material import Material
from ..materials.presets import glass
from ..numerics import bigfloat as ex
from ..numerics.portable_math import is_finite
from .body import Body
from .bounds.support import corners_support, plane_uv
from .cell import All, Cell, Face, Not, Tree, cylindrical_uv
from .conic import ConicEnds, ConicWall, check_radius, check_reach, conic_reaches, round_tube
from .shape import PrimitiveSolid, Solid
from .surface import PlaneSurface


@dataclass(frozen=True)
class Lens(ConicEnds, PrimitiveSolid):
    """front(r) <= z <= thickness + back(r), r <= diameter / 2: two conics with their vertices on the z axis.

    Each is z = c r² / (1 + sqrt(1 - (1 + k) c² r²)), c = 1 / R. `front_radius` and `back_radius` are the radii of
    curvature R, over 0 where the centre lies on the side of z = +infinity, so that 50 and -50 make a biconvex lens;
    infinity is a plane. `front_conic` and `back_conic` are the conic constants k, `thickness` that on the axis,
    `diameter` that of the edge. `front_aperture` and `back_aperture`, where given, are diameters beyond which the
    face goes on as a flat ring. Faces that cross within the edge are refused.
    Faces: 0 front, 1 back, 2 edge, 3 ring around the front, 4 ring around the back.
    uv: (angle / 360, height from vertex to rim in [0, 1]) on the conics and on the edge, (x, y) / (diameter / 2) on
    flat faces.
    """

    front_radius: float
    back_radius: float
    thickness: float
    diameter: float
    front_conic: float = 0.0
    back_conic: float = 0.0
    front_aperture: float | None = None
    back_aperture: float | None = None

    def __post_init__(self) -> None:
        for side in ("front", "back"):
            _check_side(self, side)
        check_fields(self, thickness=check_positive)
        _check_glass(self)

    @cached_property
    def front(self) -> ConicWall:
        """The wall at z = 0."""
        semi = (self.front_aperture or self.diameter) / 2
        return ConicWall(self.front_radius, self.front_conic, 0.0, semi, self.diameter / 2, 0, 3, 5)

    @cached_property
    def back(self) -> ConicWall:
        """The wall at z = thickness."""
        semi = (self.back_aperture or self.diameter) / 2
        return ConicWall(self.back_radius, self.back_conic, self.thickness, semi, self.diameter / 2, 1, 4, 5)

    def tree(self) -> Tree:
        return tree_between_walls(self.front, self.back, 0.0)

    @property
    def _ends(self) -> tuple[tuple[ConicWall, bool, float], ...]:
        # A front of positive radius bulges towards -z, out of the lens; so does a back of negative radius, towards +z
        return (self.front, self.front_radius > 0, 0.0), (self.back, self.back_radius < 0, 0.0)


@dataclass(frozen=True)
class Mirror(ConicEnds, PrimitiveSolid):
    """A mirror with its substrate: from z = c r² / (1 + sqrt(1 - (1 + k) c² r²)) to the plane z = thickness.

    c is 1 / `radius_of_curvature`: with light along +z, a mirror of a negative radius collects it. k is
    `conic_constant`. A `thickness` below 0 puts the substrate on the other side, for light along -z.
    hole / 2 <= r <= diameter / 2. A substrate that the conic goes through is refused.
    Faces: 0 the mirror, 1 back, 2 edge, 3 wall of the hole. uv: (angle / 360, height from vertex to rim in [0, 1]) on
    the conic, the edge and the hole, (x, y) / (diameter / 2) on flat faces.
    """

    radius_of_curvature: float
    conic_constant: float = 0.0
    diameter: float = 1.0
    thickness: float = 0.1
    hole: float = 0.0

    def __post_init__(self) -> None:
        check_fields(
            self,
            radius_of_curvature=check_radius,
            conic_constant=check_number,
            diameter=check_positive,
            thickness=check_number,
            hole=check_nonnegative,
        )
        names = "radius_of_curvature and conic_constant give"
        check_reach("Mirror", "diameter", self.radius_of_curvature, self.conic_constant, self.diameter, names)
        if not self.hole < self.diameter:
            raise ValueError(f"Mirror: hole must be below diameter = {self.diameter:g}, got {self.hole:g}")
        _check_substrate(self)

    @property
    def front(self) -> ConicWall:
        """The mirror, its vertex at the origin."""
        r = self.diameter / 2
        return ConicWall(self.radius_of_curvature, self.conic_constant, 0.0, r, r, 0, 4, 4)

    @property
    def back(self) -> ConicWall:
        """The plane behind the mirror."""
        r = self.diameter / 2
        return ConicWall(math.inf, 0.0, self.thickness, r, r, 1, 4, 4)

    def tree(self) -> Tree:
        walls = (self.front, self.back)
        # A negative thickness puts the plane below the mirror
        low, high = walls if self.thickness > 0 else walls[::-1]
        return tree_between_walls(low, high, self.hole / 2)

    @property
    def _ends(self) -> tuple[tuple[ConicWall, bool, float], ...]:
        hollow = (self.radius_of_curvature > 0) == (self.thickness > 0)
        return (self.back, False, 0.0), (self.front, hollow, self.hole / 2)


def tree_between_walls(low: ConicWall, high: ConicWall, hole: float) -> Tree:
    """Return the tree of points above one wall and below another, within their edge and outside a hole."""
    lows, low_planes = low.sides(above=True, reach=_highest(high))
    highs, high_planes = high.sides(above=False, reach=_lowest(low))
    bottom, top = ex.rounded(low.rim), ex.rounded(high.rim)
    # A biconvex lens may end in a sharp edge of no height
    heights = cylindrical_uv(bottom, top) if bottom < top else cylindrical_uv(0.0, 1.0)
    edge = Cell(
        (Face(round_tube(low.edge), 2, heights), *sorted((*low_planes, *high_planes), key=lambda face: face.number))
    )
    holes = [Not(Cell((Face(round_tube(hole), 3, heights),)))] if hole > 0 else []
    return All((*lows, *highs, edge, *holes))


def _highest(wall: ConicWall) -> ex.BigFloat:
    """Return the greatest height of a wall."""
    vertex, rim = ex.exact(wall.vertex), wall.rim
    return rim if rim - vertex > 0 else vertex


def _lowest(wall: ConicWall) -> ex.BigFloat:
    """Return the least height of a wall."""
    vertex, rim = ex.exact(wall.vertex), wall.rim
    return rim if rim - vertex < 0 else vertex


def _check_side(lens: Any, side: str) -> None:
    """Check the numbers of one face, and that it reaches the edge or its aperture."""
    radius, conic, aperture = f"{side}_radius", f"{side}_conic", f"{side}_aperture"
    check_fields(lens, **{radius: check_radius, conic: check_number, "diameter": check_positive})
    check_fields(lens, **{aperture: optional(check_positive)})
    given = getattr(lens, aperture)
    field, width = ("diameter", lens.diameter) if given is None else (aperture, given)
    if width > lens.diameter:
        raise ValueError(f"Lens: {aperture} must not be over diameter = {lens.diameter:g}, got {width:g}")
    bent = getattr(lens, radius), getattr(lens, conic)
    # A smaller aperture leaves a flat ring, which is how a strongly bent lens gets a wide edge
    less = "" if given is not None else f" ({aperture} may be less)"
    check_reach("Lens", field, *bent, width, f"{radius} and {conic} give{less}")


def _check_glass(lens: Lens) -> None:
    """Raise ValueError if the faces cross. `_stations` are the distances where the glass can be thinnest."""
    for distance in _stations(lens.front, lens.back):
        left = _height(lens.back, distance) - _height(lens.front, distance)
        if left < 0:
            fields = "thickness, diameter, front_radius, back_radius and the conics front_conic and back_conic, within"
            raise ValueError(
                f"Lens: {fields} front_aperture and back_aperture, must leave glass everywhere: "
                f"at {distance:.6g} from the axis the faces have crossed by {-ex.rounded(left):.6g}"
            )


def _check_substrate(mirror: Mirror) -> None:
    """Raise ValueError if the conic reaches the back, or if there is no substrate."""
    rim = mirror.front.rim
    left = ex.exact(mirror.thickness) - rim if mirror.thickness > 0 else rim - ex.exact(mirror.thickness)
    # Zero is allowed at the rim alone, where the substrate ends in an edge
    if mirror.thickness == 0 or left < 0:
        place = "beyond the rim, which radius_of_curvature, conic_constant and diameter put at"
        raise ValueError(
            f"Mirror: thickness must not be 0, and lie {place} z = {ex.rounded(rim):.6g}, "
            f"got {format_value(mirror.thickness)}"
        )


def _height(wall: ConicWall, distance: float) -> ex.BigFloat:
    return ex.exact(wall.vertex) + wall.sag(min(distance, wall.semi))


def _stations(a: ConicWall, b: ConicWall) -> list[float]:
    """Return the distances from the axis at which two walls may be nearest to each other.

    These are the axis, the apertures, the edge, and the distance of equal slopes: r / sqrt(R² - (1 + k) r²) of the same
    sign agree at R₁² - (1 + k₁) r² = R₂² - (1 + k₂) r².
    """
    distances = [0.0, a.semi, b.semi, a.edge]
    # Two conics of equal constants have equal slopes on the axis only, or everywhere
    if not (a.is_plane or b.is_plane) and a.conic != b.conic:
        square = (Fraction(a.radius) ** 2 - Fraction(b.radius) ** 2) / (Fraction(a.conic) - Fraction(b.conic))
        if 0 < square < Fraction(min(a.semi, b.semi)) ** 2:
            distance = math.sqrt(square)
            distances += [d for d in (distance,) if is_finite(d) and conic_reaches(a.radius, a.conic, d)]
    return distances


# Cemented lenses


@dataclass(frozen=True)
class LensGroup:
    """Elements cemented to each other: ``co.Scene([*group])`` has each of them as a body.

    The wall between two elements is one surface of the scene, as both have the same numbers from the same vertex. So
    there is no gap and no overlap, and a ray that starts on the wall does not cross it again, whichever glass it
    enters. The first vertex is at the origin, the axis is z.

    Parameters
    ----------
    radii : sequence of float (n + 1,)
        Radii of curvature from first to last, as for `Lens`; infinity is a plane.
    thicknesses : sequence of float (n,)
        Thicknesses on the axis.
    diameter : float
        The diameter of the edge of all elements.
    materials : sequence (n,)
        Materials, refractive indices of glasses, or their names such as "N-BK7".
    conics : sequence of float (n + 1,), optional
        Conic constants, 0 by default.
    names : sequence of str (n,), optional
        Names of the bodies.
    coatings : sequence of co.optics.Coating or None (n + 1,), optional
        Coats of the surfaces from first to last, each with its outermost film first.

    Raises
    ------
    ValueError
        For sequences of another length, and for an element that is no `Lens`.
    """

    radii: Sequence[float]
    thicknesses: Sequence[float]
    diameter: float
    materials: Sequence[Any]
    conics: Sequence[float] | None = None
    names: Sequence[str] | None = None
    coatings: Sequence[Coating | None] | None = None

    def __post_init__(self) -> None:
        thicknesses = _check_row("thicknesses", self.thicknesses, None)
        n = len(thicknesses)
        object.__setattr__(
            self, "thicknesses", tuple(check_positive("LensGroup", "thicknesses", t) for t in thicknesses)
        )
        radii = _check_row("radii", self.radii, n + 1)
        object.__setattr__(self, "radii", tuple(check_number("LensGroup", "radii", r, finite=False) for r in radii))
        conics = (0.0,) * (n + 1) if self.conics is None else _check_row("conics", self.conics, n + 1)
        vars(self).update(
            conics=tuple(check_number("LensGroup", "conics", k) for k in conics),
            diameter=check_positive("LensGroup", "diameter", self.diameter),
            materials=tuple(map(_material, _check_row("materials", self.materials, n))),
        )
        if self.names is not None:
            names = _check_row("names", self.names, n)
            if not all(isinstance(name, str) and name for name in names):
                raise TypeError(f"LensGroup: names must be non-empty texts, got {format_value(self.names)}")
            object.__setattr__(self, "names", names)
        if self.coatings is not None:
            object.__setattr__(self, "coatings", _check_row("coatings", self.coatings, n + 1))
        # Built once here, so that a wrong element is refused when the group is made
        _ = self.bodies

    def __len__(self) -> int:
        return len(self.thicknesses)

    def __iter__(self) -> Iterator[Body]:
        return iter(self.bodies)

    @property
    def lenses(self) -> tuple[Lens, ...]:
        """The elements, each in its place, without their coats."""
        return tuple(self._element(i) for i in range(len(self)))

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The elements with their materials, first to last."""
        coats = self.coatings or (None,) * (len(self) + 1)
        return tuple(
            Body(coat_faces(lens, material, dict(enumerate(coats[i : i + 2]))), material, name)
            for i, (lens, material, name) in enumerate(
                zip(self.lenses, self.materials, self.names or (None,) * len(self), strict=True)
            )
        )

    def _element(self, i: int) -> Lens:
        """Return the element with a number, in its place."""
        (front, back), (first, second) = self.radii[i : i + 2], (self.conics or ())[i : i + 2]
        try:
            lens = Lens(front, back, self.thicknesses[i], self.diameter, first, second)
        except ValueError as error:
            raise ValueError(f"LensGroup: radii, thicknesses, diameter and conics: element {i}: {error}") from None
        # One exact step after the other, so that walls of neighbours get the same place
        for thickness in self.thicknesses[:i]:
            lens = lens.translate((0.0, 0.0, thickness))
        return lens


def coat_faces(lens: Solid, material: Material, coats: Mapping[int, Coating | None]) -> Solid:
    """Return a lens of a material whose faces have coats; `coats` has them by the numbers of faces."""
    for face, coat in coats.items():
        if coat is not None:
            lens = lens.painted(replace(material, coating=coat), (face,))
    return lens


def Doublet(
    radii: Sequence[float],
    thicknesses: Sequence[float],
    diameter: float,
    materials: Sequence[Any],
    conics: Sequence[float] | None = None,
    names: Sequence[str] | None = None,
    coatings: Sequence[Coating | None] | None = None,
) -> LensGroup:
    """Return a cemented doublet, a `LensGroup` of two elements.

    Parameters
    ----------
    radii : sequence of float (3,)
        Radii of curvature.
    thicknesses : sequence of float (2,)
        Thicknesses on the axis.
    diameter : float
        The diameter of the edge.
    materials : sequence (2,)
        Materials, refractive indices or names of glasses.
    conics : sequence of float (3,), optional
        Conic constants, 0 by default.
    names : sequence of str (2,), optional
        Names of the bodies.
    coatings : sequence of co.optics.Coating or None (3,), optional
        Coats of the surfaces.

    Raises
    ------
    ValueError
        As for `LensGroup`.
    """
    if len(_check_row("thicknesses", thicknesses, None)) != 2:
        raise ValueError(f"Doublet: thicknesses must be 2 numbers, got {format_value(thicknesses)}")
    return LensGroup(radii, thicknesses, diameter, materials, conics, names, coatings)


def _check_row(field: str, value: Any, count: int | None) -> tuple[Any, ...]:
    """Return a sequence of `count` entries as a tuple; None allows any number but 0. Raise otherwise."""
    if not isinstance(value, list | tuple | np.ndarray) or (isinstance(value, np.ndarray) and value.ndim != 1):
        raise TypeError(f"LensGroup: {field} must be a list, got {describe_kind(value)}")
    row = tuple(value)
    if len(row) != (count or len(row)) or not row:
        expected = "1 or more entries" if count is None else f"{count} entries to go with thicknesses"
        raise ValueError(f"LensGroup: {field} must be {expected}, got {len(row)}")
    return row


def _material(value: Any) -> Material:
    """Return a material, or the glass of a refractive index, which is a number, a name or a formula."""
    if isinstance(value, Material):
        return value
    return glass(
        value if isinstance(value, str) or callable(value) else check_positive("LensGroup", "materials", value)
    )


# Prisms of glass: the triangular prism, the penta prism and the corner cube


class FlatGlass(PrimitiveSolid, abstract=True):
    """A convex solid whose planes and corners are known to thousands of bits. Face i is plane i."""

    @abstractmethod
    def planes(self) -> list[PlaneSurface]:
        """Return the planes, outward, in the order of their numbers."""

    @abstractmethod
    def corners(self) -> Sequence[ex.Row]:
        """Return the corners, in any order."""

    def tree(self) -> Cell:
        return Cell(tuple(Face(surface, i, plane_uv(surface)) for i, surface in enumerate(self.planes())))

    def support(self, direction: Vector) -> float:
        return corners_support(self.corners(), direction)


@dataclass(frozen=True)
class Prism(FlatGlass):
    """A triangular prism, its edges along x: |x| <= length / 2, y >= -h / 2, |z| cos(a / 2) <= (h / 2 - y) sin(a / 2).

    a is `apex_angle` in degrees, between 0 and 180, at the edge y = h / 2, z = 0; both faces that meet there are
    `side` wide, so h = side cos(a / 2). 60 is the equilateral prism, 90 the right-angle or Porro prism, whose base is
    its hypotenuse.
    Faces: 0 towards -z, 1 towards +z, 2 base, 3 end at low x, 4 end at high x. uv: Cartesian coordinates on the plane
    as of `HalfSpace`.
    """

    apex_angle: float
    side: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "apex_angle", check_number("Prism", "apex_angle", self.apex_angle))
        if not 0 < self.apex_angle < 180:
            raise ValueError(f"Prism: apex_angle must be between 0 and 180 degrees, got {self.apex_angle:g}")
        check_fields(self, side=check_positive, length=check_positive)

    def _sizes(self) -> tuple[ex.BigFloat, ex.BigFloat, ex.BigFloat, ex.BigFloat]:
        """Return (sine and cosine of half the apex angle, half the height, half the base)."""
        s, c = ex.sin_cos_degrees(self.apex_angle / 2)
        side = ex.exact(self.side)
        return s, c, side * c / ex.exact(2.0), side * s

    def planes(self) -> list[PlaneSurface]:
        s, c, half, _ = self._sizes()
        end = self.length / 2
        return [
            PlaneSurface((0.0, s, -c), s * half, (0.0, half, 0.0)),
            PlaneSurface((0.0, s, c), s * half, (0.0, half, 0.0)),
            PlaneSurface((0.0, -1.0, 0.0), half, (0.0, -half, 0.0)),
            PlaneSurface((-1.0, 0.0, 0.0), end, (-end, 0.0, 0.0)),
            PlaneSurface((1.0, 0.0, 0.0), end, (end, 0.0, 0.0)),
        ]

    def corners(self) -> Sequence[ex.Row]:
        _, _, half, base = self._sizes()
        ends = (ex.exact(self.length / 2), -ex.exact(self.length / 2))
        return [(x, y, z) for x in ends for y, z in ((half, ex.ZERO), (-half, base), (-half, -base))]


@dataclass(frozen=True)
class PentaPrism(FlatGlass):
    """A penta prism: |x| <= length / 2, y >= 0, z >= 0, y <= side + (sqrt 2 - 1) z, z <= side + (sqrt 2 - 1) y.

    Light that enters along +z leaves along -y, however the prism is tilted about x: faces 2 and 3, which are at 45
    degrees and must be coated as mirrors, turn it by 90. The openings are `side` wide in y and z, `length` in x.
    y + z <= (1 + sqrt 2) side cuts off the part that a full beam does not need.
    Faces: 0 z = 0, 1 y = 0, 2 mirror opposite of 0, 3 mirror opposite of 1, 4 the fifth, 5 and 6 the ends at low and
    high x. uv: Cartesian coordinates on the plane as of `HalfSpace`.
    """

    side: float
    length: float

    def __post_init__(self) -> None:
        check_fields(self, side=check_positive, length=check_positive)

    def planes(self) -> list[PlaneSurface]:
        a, root, end = ex.exact(self.side), ex.sqrt(ex.exact(2.0)), self.length / 2
        lean = root - ex.ONE
        return [
            PlaneSurface((0.0, 0.0, -1.0), 0.0),
            PlaneSurface((0.0, -1.0, 0.0), 0.0),
            PlaneSurface((0.0, -lean, 1.0), a, (0.0, 0.0, a)),
            PlaneSurface((0.0, 1.0, -lean), a, (0.0, a, 0.0)),
            PlaneSurface((0.0, 1.0, 1.0), a + a * root, (0.0, a, a * root)),
            PlaneSurface((-1.0, 0.0, 0.0), end, (-end, 0.0, 0.0)),
            PlaneSurface((1.0, 0.0, 0.0), end, (end, 0.0, 0.0)),
        ]

    def corners(self) -> Sequence[ex.Row]:
        a, zero, far = ex.exact(self.side), ex.ZERO, ex.exact(self.side) * ex.sqrt(ex.exact(2.0))
        section = ((zero, zero), (a, zero), (far, a), (a, far), (zero, a))
        ends = (ex.exact(self.length / 2), -ex.exact(self.length / 2))
        return [(x, y, z) for x, (y, z) in itertools.product(ends, section)]


@dataclass(frozen=True)
class CornerCube(FlatGlass):
    """The corner of a cube, a retroreflector: z >= 0, and sqrt 2 (x cos p + y sin p) + z <= height, p = 0, 120, 240.

    The three mirrors are perpendicular to each other and meet at (0, 0, height). Light that enters through the triangle
    z = 0 returns parallel to its incoming direction. A round one is ``CornerCube(height) & Cylinder(...)``.
    Faces: 0 the front z = 0, 1 to 3 the mirrors. uv: Cartesian coordinates on the plane as of `HalfSpace`.
    """

    height: float

    def __post_init__(self) -> None:
        check_fields(self, height=check_positive)

    def planes(self) -> list[PlaneSurface]:
        root, top = ex.sqrt(ex.exact(2.0)), (0.0, 0.0, self.height)
        normals = [(root * ex.sin_cos_degrees(p)[1], root * ex.sin_cos_degrees(p)[0], 1.0) for p in (0, 120, 240)]
        return [PlaneSurface((0.0, 0.0, -1.0), 0.0), *(PlaneSurface(n, self.height, top) for n in normals)]

    def corners(self) -> Sequence[ex.Row]:
        far, zero = ex.exact(self.height) * ex.sqrt(ex.exact(2.0)), ex.ZERO
        turns = [ex.sin_cos_degrees(p) for p in (60, 180, 300)]
        return [(zero, zero, ex.exact(self.height)), *((far * c, far * s, zero) for s, c in turns)]
