"""Surfaces and regions of OpenMC: solids as Boolean trees of half-spaces, and tests whether regions are disjoint.

`ExportSurfaceTable` numbers surfaces, each once. `RegionWriter` makes regions, with complements carried inward (De
Morgan).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from fractions import Fraction
from typing import TypeAlias

from ..._util.records import dataclass
from ...geometry.cell import All, Cell, Not, Tree
from ...geometry.general_quadric import Quadric
from ...geometry.shape import Boolean, PrimitiveSolid, Solid
from ...geometry.surface import PlaneSurface, Surface
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics import bigfloat as ex
from ..openmc.region import Conjunction, PartUnion, RegionPart, bind_surfaces
from ..openmc.region_expression import (
    LONGEST_REGION,
    MAX_PARENTHESES,
    HalfSpaceNode,
    IntersectionNode,
    Region,
    UnionNode,
    count_half_spaces,
    negate_region,
    region_depth,
)
from ..openmc.surfaces import Surface as ReadSurface, build_surface
from .exporters import UnsupportedExport, format_numbers, shorten_fraction

# Surfaces: planes, cylinders, cones and spheres where possible, else general quadrics.

SurfaceNumbers = tuple[Fraction, ...]
_AXES = "xyz"


@dataclass
class ExportSurfaceTable:
    """The surfaces of a file, numbered by kind and coefficients.

    `rounded` holds the numbers of surfaces with a coefficient that is no float64, `boundaries` the boundary types.
    """

    numbers: dict[tuple[str, SurfaceNumbers], int] = field(default_factory=dict)
    rounded: set[int] = field(default_factory=set)
    boundaries: dict[int, str] = field(default_factory=dict)
    surfaces: dict[int, ReadSurface] = field(default_factory=dict)
    """The surfaces as an importer builds them, by number."""

    def half(self, surface: Surface, inside: int) -> HalfSpaceNode:
        """Return the side of a surface that is inside: f <= 0 for +1, f >= 0 for -1."""
        element = _plane(surface) if isinstance(surface, PlaneSurface) else _curved(surface.coefficients())
        return self.add(element, inside)

    def half_of_quadric(self, quadric: Quadric) -> HalfSpaceNode:
        """Return the inside of a quadric without a motion, by the coefficients of its definition."""
        q = quadric.symmetric
        terms = (q[0][0], q[1][1], q[2][2], q[0][1], q[0][2], q[1][2], q[0][3], q[1][3], q[2][3], q[3][3])
        return self.add(_general([ex.exact(term) for term in terms]), 1)

    def add(self, element: _SurfaceElement, inside: int) -> HalfSpaceNode:
        """Return a side of a surface, which gets a number unless an equal one has it."""
        key = element.kind, element.numbers
        number = self.numbers.setdefault(key, len(self.numbers) + 1)
        if number not in self.surfaces:
            self.surfaces[number] = build_surface(element.kind, element.numbers)
        if not element.is_exact:
            self.rounded.add(number)
        return HalfSpaceNode(number, element.sense * inside < 0)

    def elements(self, factor: Fraction) -> list[str]:
        """Return a line of XML for each surface, with lengths multiplied by a factor."""
        lines = []
        for (kind, numbers), number in self.numbers.items():
            boundary = f' boundary="{self.boundaries[number]}"' if number in self.boundaries else ""
            coefficients = format_numbers(_scaled(kind, numbers, factor))
            lines.append(f'<surface id="{number}" type="{kind}" coeffs="{coefficients}"{boundary}/>')
        return lines


def _scaled(kind: str, numbers: SurfaceNumbers, factor: Fraction) -> SurfaceNumbers:
    """Return the coefficients of a surface that is larger by a factor; squared slopes and normals stay."""
    if factor == 1:
        return numbers
    powers = {"plane": (0, 0, 0, 1), "quadric": (0, 0, 0, 0, 0, 0, 1, 1, 1, 2)}.get(kind, (1,) * len(numbers))
    if kind.endswith("cone"):
        powers = (1, 1, 1, 0)
    return tuple(value * factor**power for value, power in zip(numbers, powers, strict=True))


@dataclass(frozen=True)
class _SurfaceElement:
    """A surface element; `sense` is -1 if its inside is the outside of the surface that it was made of."""

    kind: str
    numbers: SurfaceNumbers
    sense: int
    is_exact: bool


def _make_surface_element(kind: str, numbers: list[ex.BigFloat], sense: int) -> _SurfaceElement:
    short = [shorten_fraction(number) for number in numbers]
    return _SurfaceElement(kind, tuple(value for value, _ in short), sense, all(is_exact for _, is_exact in short))


def _plane(surface: PlaneSurface) -> _SurfaceElement:
    """Return a plane with its first component above 0, so that both sides of one plane give one element."""
    normal, offset = ex.exact_row(surface.normal), ex.exact(surface.offset)
    along = [i for i in range(3) if normal[i]]
    sense = 1 if normal[along[0]] > 0 else -1
    if len(along) == 1 and not ex.cancelling_sum((normal[along[0]] * sense, -ex.ONE)):
        return _make_surface_element(f"{_AXES[along[0]]}-plane", [offset * sense], sense)
    return _make_surface_element("plane", [number * sense for number in (*normal, offset)], sense)


def _curved(terms: tuple[ex.BigFloat, ...]) -> _SurfaceElement:
    """Return a quadric by its terms (xx, yy, zz, xy, xz, yz, x, y, z, 1), the mixed and linear ones halved."""
    squares, mixed, linear = terms[:3], terms[3:6], terms[6:9]
    if not any(mixed):
        for axis in (None, 2, 1, 0):
            element = _of_revolution(squares, linear, terms[9], axis)
            if element is not None:
                return element
    return _general(list(terms))


def _of_revolution(squares: ex.Row | tuple[ex.BigFloat, ...], linear: tuple[ex.BigFloat, ...], constant: ex.BigFloat,
                   axis: int | None) -> _SurfaceElement | None:  # fmt: skip
    """Return a sphere (`axis` None), or a cylinder or cone about an axis of coordinates; None if it is none."""
    across = [i for i in range(3) if i != axis]
    lead = squares[across[0]]
    if not lead or any(ex.cancelling_sum((squares[i], -lead)) for i in across):
        return None
    sense = 1 if lead > 0 else -1
    if axis is not None and bool(squares[axis]) == 0 and linear[axis]:
        return None  # a paraboloid
    used = across if axis is None or not squares[axis] else [0, 1, 2]
    center = [ex.cancelling_sum((-linear[i] / squares[i],)) if i in used else ex.ZERO for i in range(3)]
    height = ex.cancelling_sum((constant / lead, *(-center[i] * center[i] * squares[i] / lead for i in used)))
    if axis is None or not squares[axis]:  # |x - c|² + height = 0
        if not height < 0:
            return None
        radius = ex.cancelling_sum((ex.sqrt(-height),))
        kind = "sphere" if axis is None else f"{_AXES[axis]}-cylinder"
        return _make_surface_element(kind, [*(center[i] for i in across), radius], sense)
    slope = ex.cancelling_sum((-squares[axis] / lead,))
    if height or not slope > 0:
        return None
    return _make_surface_element(f"{_AXES[axis]}-cone", [*center, slope], sense)


def _general(terms: list[ex.BigFloat]) -> _SurfaceElement:
    """Return a quadric by all ten coefficients, the mixed and linear ones doubled.

    If they are no floats they are scaled so that the largest of second degree is 1.
    """
    xx, yy, zz, xy, xz, yz, x, y, z, constant = terms
    numbers = [xx, yy, zz, 2 * xy, 2 * yz, 2 * xz, 2 * x, 2 * y, 2 * z, constant]
    element = _make_surface_element("quadric", numbers, 1)
    if not element.is_exact:
        lead = max(numbers[:6], key=abs)
        size = lead if lead > 0 else -lead
        element = _make_surface_element("quadric", [ex.cancelling_sum((number / size,)) for number in numbers], 1)
    return element


# Solids as regions of half-spaces.

MAX_REGION_DEPTH = 100
"""Most levels of Booleans within Booleans."""
MAX_REGION_LENGTH = LONGEST_REGION


class RegionWriter:
    """Makes regions of solids; regions of equal primitives are computed once."""

    def __init__(self, table: ExportSurfaceTable) -> None:
        self.table = table
        self._cache: dict[tuple[Solid, Motion, bool], Region] = {}

    def of(self, solid: Solid, outer: Motion = IDENTITY_MOTION) -> Region:
        """Return the region of a solid under a further motion. Raise UnsupportedExport if OpenMC cannot hold it."""
        region = self._region_of(solid, outer, True, 0)
        count = count_half_spaces(region)
        if count > MAX_REGION_LENGTH:
            raise UnsupportedExport(f"its region has {count:,} half-spaces, more than {MAX_REGION_LENGTH:,}")
        if region_depth(region) > MAX_PARENTHESES:
            raise UnsupportedExport(f"its region nests deeper than {MAX_PARENTHESES} levels")
        return region

    def _region_of(self, solid: Solid, outer: Motion, inside: bool, depth: int) -> Region:
        """Return the region inside or outside of a solid."""
        if isinstance(solid, Boolean):
            if depth >= MAX_REGION_DEPTH:
                raise UnsupportedExport(f"it nests Booleans deeper than {MAX_REGION_DEPTH} levels")
            motion = solid.motion.then(outer)
            sides = zip(solid.operands, solid._sides(len(solid.operands), inside), strict=True)
            parts = [self._region_of(operand, motion, side, depth + 1) for operand, side in sides]
            return join_regions(IntersectionNode if solid._is_intersection(inside) else UnionNode, parts)
        if not isinstance(solid, PrimitiveSolid):
            raise UnsupportedExport(f"{type(solid).__name__} is no solid of planes and quadrics")
        key = solid, outer, inside
        if key not in self._cache:
            self._cache[key] = self._primitive(solid, outer, inside)
        return self._cache[key]

    def _primitive(self, solid: PrimitiveSolid, outer: Motion, inside: bool) -> Region:
        motion = solid.under(outer)
        # A quadric that is not moved keeps the coefficients that its user wrote, where some is of second degree.
        if (
            isinstance(solid, Quadric)
            and motion.is_identity
            and any(solid.symmetric[i][j] for i in range(3) for j in range(3))
        ):
            half = self.table.half_of_quadric(solid)
            return half if inside else negate_region(half)
        return self._tree(solid.tree(), motion, inside)

    def _tree(self, tree: Tree, motion: Motion, inside: bool) -> Region:
        if isinstance(tree, Cell):
            parts: list[Region] = []
            for face in tree.faces:
                half = self.table.half(face.surface.moved(motion), face.inside)
                parts.append(half if inside else negate_region(half))
            return join_regions(IntersectionNode if inside else UnionNode, parts)
        if isinstance(tree, Not):
            return self._tree(tree.part, motion, not inside)
        kind = IntersectionNode if isinstance(tree, All) == inside else UnionNode
        return join_regions(kind, [self._tree(part, motion, inside) for part in tree.parts])


def join_regions(kind: type[IntersectionNode] | type[UnionNode], parts: Iterable[Region]) -> Region:
    """Return one node of a kind, with nodes of the same kind opened up, and each part once.

    Raise UnsupportedExport if there are no parts.
    """
    terms: dict[Region, None] = {}
    for part in parts:
        terms.update(dict.fromkeys(part.parts if isinstance(part, kind) else (part,)))
    if not terms:
        raise UnsupportedExport("a part of it is empty, or all of space")
    return next(iter(terms)) if len(terms) == 1 else kind(tuple(terms))


def list_conjuncts(region: Region) -> tuple[Region, ...]:
    """Return the parts that a region is the intersection of."""
    return region.parts if isinstance(region, IntersectionNode) else (region,)


def format_region(region: Region) -> str:
    """Return a region as OpenMC writes it: -1 2 (3 | -4)."""
    return "".join(_pieces(region, False))


def _pieces(region: Region, within: bool) -> Iterator[str]:
    if isinstance(region, HalfSpaceNode):
        yield f"{'' if region.positive else '-'}{region.surface}"
        return
    between = " " if isinstance(region, IntersectionNode) else " | "
    if within:
        yield "("
    for k, part in enumerate(region.parts):
        if k:
            yield between
        yield from _pieces(part, True)
    if within:
        yield ")"


# Tests whether regions are disjoint. True is certain; False means unknown.

_MAX_SPLITS, _MAX_BRANCHES = 3, 8
"""Most unions that are split, and most parts of a union that is split."""
RegionSides: TypeAlias = tuple[frozenset[Region], list[frozenset[Region]]]


def are_disjoint_sides(one: RegionSides, other: RegionSides) -> bool:
    """Return True if one region is within a part and the other outside of it; a quick test of equal half-spaces."""
    return any(out <= other[0] for out in one[1]) or any(out <= one[0] for out in other[1])


@dataclass
class EmptinessTest:
    """Tests whether regions are surely empty: balls, cylinders and planes are compared as in imports."""

    table: ExportSurfaceTable
    _bound: dict[int, tuple[Region, RegionPart]] = field(default_factory=dict)
    _complements: dict[int, tuple[Region, Region]] = field(default_factory=dict)

    def complement(self, region: Region) -> Region:
        """Return the complement of a region: the same object each time."""
        return negate_region(region, self._complements)

    def sides(self, region: Region | None) -> RegionSides:
        """Return the parts that a region is the intersection of, and the same for the complement of each part."""
        parts = () if region is None else list_conjuncts(region)
        return frozenset(parts), [frozenset(list_conjuncts(self.complement(part))) for part in parts]

    def is_empty(self, *regions: Region) -> bool:
        """Return True if the intersection of regions surely has no volume."""
        parts = [bind_surfaces(each, self.table.surfaces, self._bound) for each in regions]
        return _is_empty_intersection(parts, _MAX_SPLITS)


def _is_empty_intersection(parts: list[RegionPart], splits: int) -> bool:
    """Return True if an intersection is surely empty; up to `splits` unions, the smallest first, are split."""
    conjunction = Conjunction().and_(parts)
    if conjunction is None:
        return True
    unions = sorted(
        (part for part in conjunction.parts if isinstance(part, PartUnion)), key=lambda union: len(union.parts)
    )
    if not unions or splits == 0 or len(unions[0].parts) > _MAX_BRANCHES:
        return False
    others = [part for part in conjunction.parts if part is not unions[0]]
    return all(_is_empty_intersection([*others, piece], splits - 1) for piece in unions[0].parts)
