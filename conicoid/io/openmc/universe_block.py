"""Blocks of bodies: the content of a universe, translated to all its places, and the bounds of each place.

Their user is who imports lattices of pins, or detectors of equal volumes. A body of a block that is translated takes
0.3 µs to import, and one that is expanded at its own place 400 µs: a core of 1.5 million pins takes half a second.

`PlaceBounds` groups the parts of these regions by the motion that takes them to the world. `AxialMotion` recognises
rotations about a line along an axis: planes across this line and surfaces of revolution about it are the same before
and after such a rotation. A part of this kind can be moved to the group of the rotated content, where it needs no
motion of its own and where fractions show how it lies to the other parts.
"""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from ..._util.arrays import matmul_rows, unique_sorted
from ..._util.records import dataclass
from ...geometry.instances import Coordinates, InstanceBlock, InstanceList, Ints, Shift, ShiftTable
from ...geometry.shape import Solid
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...materials.material import Material
from ...numerics.bigfloat import fraction, is_rounded
from .geometry import CellGeometry, UniverseCell
from .lattices import Lattice
from .placement import ORIGIN, UNBOUNDED, Extent, ExtentEnd, Point, UniversePlacement
from .region import Conjunction, PlacedSurfaces, RegionPart, SolidBuilder, SurfaceSide, pair_cost
from .surfaces import ConeSurface, FlatSurface, RoundSurface, Surface


@dataclass(frozen=True)
class AxialMotion:
    """A motion x ↦ A x + shift where A leaves the coordinate along `axis` as it is and mixes the other two only."""

    axis: int
    shift: Point
    rigid: bool
    """Whether the motion preserves distances."""

    @classmethod
    def of(cls, motion: Motion) -> AxialMotion | None:
        """Return a motion as an `AxialMotion`, or None if it is none or its shift is no exact fraction."""
        rows, shift = motion.affine
        # A shift of cosines is rounded, and a plane moved back by it would be another plane
        if any(map(is_rounded, shift)):
            return None
        for axis in range(3):
            others = [i for i in range(3) if i != axis]
            if rows[axis][axis] == 1 and not any(rows[axis][i] or rows[i][axis] for i in others):
                x, y, z = (fraction(value) for value in shift)
                factor = motion.similarity
                return cls(axis, (x, y, z), factor is not None and factor == 1)
        return None

    def undone(self, part: RegionPart) -> RegionPart | None:
        """Return the part that the motion takes to `part`; None if it is not exact in fractions."""
        if isinstance(part, SurfaceSide):
            # One surface that cannot be undone keeps the whole part where it is
            surface = self._surface(part.surface)
            return None if surface is None else SurfaceSide(surface, part.positive)
        parts = [self.undone(piece) for piece in part.parts]
        exact = tuple(piece for piece in parts if piece is not None)
        return type(part)(exact) if len(exact) == len(parts) else None

    def _surface(self, surface: Surface) -> Surface | None:
        """Return the surface that the motion takes to `surface`: a plane across the axis, or round about it."""
        if isinstance(surface, FlatSurface):
            if surface.axis != self.axis:
                return None
            # Across the axis nothing turns, so only the shift along the axis counts
            return replace(surface, offset=surface.offset - surface.normal[self.axis] * self.shift[self.axis])
        if isinstance(surface, RoundSurface) and surface.axis in (self.axis, None):
            center = self._on_axis(surface.center)
            if center is None:
                return None
            return replace(surface, center=(Fraction(0),) * 3 if surface.axis is not None else center)
        if isinstance(surface, ConeSurface) and surface.axis == self.axis:
            apex = self._on_axis(surface.apex)
            return None if apex is None else replace(surface, apex=apex)
        return None

    def _on_axis(self, point: Point) -> Point | None:
        """Return the point that the motion takes to `point` if that lies on the axis of rotation, else None."""
        across = (point[i] == self.shift[i] for i in range(3) if i != self.axis)
        # A motion that scales would change radii, and off the axis a turn moves the centre by rounded numbers
        if not (self.rigid and all(across)):
            return None
        x, y, z = (point[i] - self.shift[i] if i == self.axis else Fraction(0) for i in range(3))
        return x, y, z


# Bounds of a place


@dataclasses.dataclass(frozen=True, slots=True)
class PlaceBounds:
    """The intersection of groups of parts; each group stands before one motion to the world."""

    groups: tuple[tuple[Motion, Conjunction], ...] = ()

    def and_(self, motion: Motion, parts: Iterable[RegionPart], extent: Extent = UNBOUNDED) -> PlaceBounds | None:
        """Return the bounds with further parts before `motion`, the innermost motion; None if nothing is left.

        Parts of other groups that contain the whole box around the new group are left out. This stays correct: nothing
        is left out of the new group because of them, and nothing is added to them once another motion is innermost.
        """
        before = dict(self.groups)
        narrowed = before.get(motion, Conjunction()).and_(parts, extent)
        if narrowed is None:
            return None
        # Nearly all places: one group, whose parts have been compared with each other
        if self.is_before(motion):
            return PlaceBounds(((motion, narrowed),))
        groups: list[tuple[Motion, Conjunction]] = []
        for other, conjunction in (before | {motion: narrowed}).items():
            rest = conjunction if other == motion else conjunction.inside(_carry_extent(narrowed.extent, motion, other))
            if rest is None:
                return None
            # A group without parts bounds nothing, but later parts join the innermost one
            if rest.parts or other == motion:
                groups.append((other, rest))
        return PlaceBounds(tuple(groups))

    def entering(self, entry: Motion, before: Motion, after: Motion) -> PlaceBounds:
        """Return the bounds within a cell that applies `entry` to its content; `after` is `entry`, then `before`.

        Parts that the rotation leaves as they are move from the group of `before`, so far the innermost motion, to the
        group of `after`, which the parts of the content will join.
        """
        about = AxialMotion.of(entry)
        groups = dict(self.groups)
        outside = groups.pop(before, None)
        if about is None or outside is None:
            return self
        pairs = [(part, about.undone(part)) for part in outside.parts]
        inside = Conjunction().and_(turned for _, turned in pairs if turned is not None)
        # Rebuilt rather than filtered, since the box of a group belongs to its parts
        stay = Conjunction().and_(part for part, turned in pairs if turned is None)
        if inside is None or stay is None:  # only now fractions show that nothing is left
            return self
        if stay.parts:
            groups[before] = stay
        return PlaceBounds(tuple((groups | {after: inside}).items()))

    def moved(self, shift: Point) -> PlaceBounds:
        """Return the bounds translated by `shift` before their motions."""
        return PlaceBounds(tuple((motion, conjunction.moved(shift)) for motion, conjunction in self.groups))

    def is_before(self, motion: Motion) -> bool:
        """Return True if all parts stand before this motion."""
        return all(other == motion for other, _ in self.groups)

    def cost(self, motion: Motion, parts: Iterable[RegionPart]) -> int:
        """Return a bound on the sides and pairs of sides that `and_` compares."""
        others = sum(conjunction.size for other, conjunction in self.groups if other != motion)
        return others + pair_cost(dict(self.groups).get(motion, Conjunction()), parts)

    def extent_before(self, motion: Motion, tight: bool = False) -> Extent:
        """Return a box around the bounds, in the coordinates before a motion; a tight one knows slanted planes."""
        whole = UNBOUNDED
        for other, conjunction in self.groups:
            extent = conjunction.tight_extent if tight else conjunction.extent
            whole = whole.common(extent if other == motion else _carry_extent(extent, other, motion, 1e-12))
        return whole


def _carry_extent(extent: Extent, motion: Motion, back: Motion, threshold: float = 0.0) -> Extent:
    """Return a box around an extent after `motion` and the inverse of `back`, widened by a bound on rounding.

    Entries of the matrix below `threshold` in size are taken as zeros that rounding has changed.
    """
    matrix = matmul_rows(back.inverse_matrix, motion.matrix)
    far = np.abs(back.inverse_matrix[:3, :3]) @ np.abs(motion.matrix[:3, 3]) + np.abs(back.inverse_matrix[:3, 3])
    linear = np.where(np.abs(matrix[:3, :3]) < threshold, 0.0, matrix[:3, :3])
    low = np.array([-math.inf if end is None else float(end) for end in extent.low])
    high = np.array([math.inf if end is None else float(end) for end in extent.high])
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    # `rounding` bounds the rounding of large shifts that cancel in the product.
    for row, shift, rounding in zip(linear, matrix[:3, 3], 2.0**-48 * far, strict=True):
        used = row != 0
        ends = np.stack([row[used] * low[used], row[used] * high[used]])
        # Far above rounding: a box that is a little too large keeps a part that could be left out, and nothing else
        size = 1e-9 * (np.abs(ends).max(initial=0.0) + abs(shift)) + rounding
        lows.append(_end(ends.min(axis=0).sum() + shift - size))
        highs.append(_end(ends.max(axis=0).sum() + shift + size))
    return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))


def _end(value: float) -> ExtentEnd:
    return Fraction(value) if math.isfinite(value) else None


# Blocks of bodies: the content of a universe or volume, expanded once and translated to all its places.
#
# `UniverseBlock` holds pieces and placements of other blocks; `flatten_block` lists its bodies; `BlockBodies` is the
# lazy list of these bodies. `EmptyPlaces` counts places that are left out because they have no volume.


@dataclass
class EmptyPlaces:
    """For each cell and each lattice, the number of places (elements) and how many of them have no volume."""

    cells: Counter[int] = field(default_factory=Counter)
    empty_cells: Counter[int] = field(default_factory=Counter)
    elements: Counter[int] = field(default_factory=Counter)
    empty_elements: Counter[int] = field(default_factory=Counter)

    def visit(self, item: UniverseCell | Lattice, is_empty: bool) -> None:
        """Count a place of a cell, or an element of a lattice."""
        places, empty = (
            (self.cells, self.empty_cells) if isinstance(item, UniverseCell) else (self.elements, self.empty_elements)
        )
        places[item.id] += 1
        empty[item.id] += is_empty

    def add(self, other: EmptyPlaces) -> None:
        """Add the counts of another part of the model."""
        if not other.cells and not other.elements:
            return
        for counter, more in zip(vars(self).values(), vars(other).values(), strict=True):
            counter.update(more)

    @property
    def places(self) -> int:
        """The number of places of cells and of elements that are left out."""
        return self.empty_cells.total() + self.empty_elements.total()

    def notes(self, geometry: CellGeometry) -> Iterator[str]:
        """Yield a line for each cell and each lattice with places that are left out."""
        for number, empty in (+self.empty_cells).items():
            where = _format_counts(empty, self.cells[number], "place")
            yield f"{geometry.cells[number]}: has no volume {where}, left out there"
        for number, empty in (+self.empty_elements).items():
            where = _format_counts(empty, self.elements[number], "element")
            yield f"{where} of {geometry.lattices[number]} nothing lies in the cell around it, left out"


def _format_counts(empty: int, total: int, what: str) -> str:
    """Return a text such as "in 3 of 264 places"."""
    if empty == total:
        return f"in its only {what}" if total == 1 else f"in any of its {total:,} {what}s"
    return f"in {empty:,} of {total:,} {what}s"


# Blocks: bodies, and blocks within them, each with its shift, for content that stands at many places.
#
# Two elements of a lattice that lose the same parts to the cells around them are translated copies of each other, and
# so are equal volumes of GDML. A block holds its bodies about its centre. Shifts are fractions, so that a body has the
# numbers that it would have if it had been built at its place.

PlacePath: TypeAlias = tuple[str, ...]
"""Names of the cells, elements or volumes that lead to a place, outermost first."""


@dataclass(eq=False)
class BlockPiece:
    """A body of a block, with the path to it within the block."""

    title: str
    path: PlacePath
    material: Material

    count: ClassVar[int] = 1

    @property
    def form(self) -> Hashable:
        """A key: pieces of equal form are equal bodies in their blocks."""
        return id(self)


@dataclass(eq=False)
class CellPiece(BlockPiece):
    """A cell cut by the bounds of its surroundings, about the centre of its block."""

    cell: int
    context: PlaceBounds

    @property
    def form(self) -> Hashable:
        """Cell and bounds: a pin that nothing cuts equals others, whatever its surroundings lose."""
        return self.cell, self.context


P = TypeVar("P", bound=BlockPiece)


@dataclasses.dataclass(eq=False, slots=True)
class BlockPlacement(Generic[P]):
    """A block within another, translated by a shift."""

    block: UniverseBlock[P]
    shift: Point
    path: PlacePath

    @property
    def count(self) -> int:
        """The number of its bodies."""
        return self.block.count


@dataclass(eq=False)
class UniverseBlock(Generic[P]):
    """Pieces and placed blocks in the order of their bodies, with counts of bodies, materials and empty places."""

    items: list[P | BlockPlacement[P]] = field(default_factory=list)
    count: int = 0
    materials: defaultdict[Any, int] = field(default_factory=lambda: defaultdict(int))

    @cached_property
    def empty_places(self) -> EmptyPlaces:
        """The counts of its places that are left out; few blocks have any."""
        return EmptyPlaces()

    def add(self, piece: P, material: Any) -> None:
        """Append a body of a material."""
        self.items.append(piece)
        self.count += 1
        self.materials[material] += 1

    def place(self, block: UniverseBlock[P], shift: Point, path: PlacePath) -> None:
        """Append all bodies of another block, translated."""
        # Empty blocks have no items, but their empty places are counted
        if block.count:
            self.items.append(BlockPlacement(block, shift, path))
        self.count += block.count
        for material, times in block.materials.items():
            self.materials[material] += times
        if "empty_places" in vars(block):
            self.empty_places.add(block.empty_places)

    def take(self, other: UniverseBlock[P]) -> None:
        """Append the items of another block as items of this block."""
        self.items += other.items
        self.count += other.count
        for material, times in other.materials.items():
            self.materials[material] += times
        if "empty_places" in vars(other):
            self.empty_places.add(other.empty_places)

    @cached_property
    def _ends(self) -> list[int]:
        """For each item the number after its last body; to be used only once the block is complete."""
        return list(accumulate(item.count for item in self.items))

    def at(self, number: int) -> tuple[P, PlacePath]:
        """Return the piece of a body, by number, and the path to it."""
        block: UniverseBlock[P] = self
        path: PlacePath = ()
        while True:
            index = bisect_right(block._ends, number)
            item = block.items[index]
            if not isinstance(item, BlockPlacement):
                return item, (*path, *item.path)
            number -= block._ends[index] - item.count
            block, path = item.block, (*path, *item.path)

    def find(self, name: str, way: PlacePath = ()) -> int | None:
        """Return the number of the body with a name, or None; `way` is the path to this block."""
        for end, item in zip(self._ends, self.items, strict=True):
            path = (*way, *item.path)
            if not isinstance(item, BlockPlacement):
                if self.path_name(item.title, path) == name:
                    return end - 1
            elif self.may_lead(path, name):
                number = item.block.find(name, path)
                if number is not None:
                    return end - item.count + number
        return None

    @staticmethod
    def path_name(title: str, path: PlacePath) -> str:
        """Return the name of a piece at the end of a path."""
        return place_name(title, path)

    @staticmethod
    def may_lead(path: PlacePath, name: str) -> bool:
        """Return True if a body with the name may be in the block at the end of a path."""
        return f" @ {', '.join(path)}" in name


def place_name(title: str, path: PlacePath) -> str:
    """Return the name of a cell at a place, such as "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]"."""
    return f"{title} @ {', '.join(path)}" if path else title


@dataclass
class FlatBlock:
    """The bodies of a block in order: the index of the piece of each body, and its shift."""

    pieces: Ints
    shifts: ShiftTable


def flatten_block(block: UniverseBlock[P]) -> tuple[list[P], FlatBlock]:
    """Return the different pieces (by `form`) and the bodies of a block."""
    pieces: list[P] = []
    forms: dict[Hashable, int] = {}
    flat_blocks: dict[int, FlatBlock] = {}
    pending = [block]
    while pending:  # a loop in place of recursion: universes may be many levels deep
        last = pending[-1]
        inner = {id(item.block): item.block for item in last.items if isinstance(item, BlockPlacement)}
        missing = [each for key, each in inner.items() if key not in flat_blocks]
        if missing:
            pending += reversed(missing)
        elif id(pending.pop()) not in flat_blocks:
            flat_blocks[id(last)] = _flatten(last, pieces, forms, flat_blocks)
    return pieces, flat_blocks[id(block)]


def _flatten(
    block: UniverseBlock[P], pieces: list[P], forms: dict[Hashable, int], flat_blocks: dict[int, FlatBlock]
) -> FlatBlock:
    """Flatten one block whose inner blocks are in `flat_blocks`; add its new pieces to `pieces` and `forms`."""

    def number_of(piece: P) -> int:
        number = forms.setdefault(piece.form, len(pieces))
        if number == len(pieces):
            pieces.append(piece)
        return number

    # Most blocks of a detector are one body
    if len(block.items) == 1 and not isinstance(only := block.items[0], BlockPlacement):
        return FlatBlock(np.array([number_of(only)], np.int32), _NO_SHIFT)
    # Keys are numerators and denominators, as fractions are slow to look up.
    tables: list[dict[tuple[int, int], int]] = [{}, {}, {}]
    known: dict[tuple[int, int, tuple[int, int]], list[int]] = {}  # rows of a lattice share shifts
    numbers, index = np.empty(block.count, np.int32), np.empty((3, block.count), np.int32)
    begin, own, zero = 0, list[int](), list[list[int]]()  # `own`: pieces of the block itself, which no shift moves
    for item in block.items:
        end = begin + item.count
        if isinstance(item, BlockPlacement):
            flat = flat_blocks[id(item.block)]
            numbers[begin:end] = flat.pieces
            for axis, (table, values, row, by) in enumerate(
                zip(tables, flat.shifts.values, flat.shifts.index, item.shift, strict=True)
            ):
                key = axis, id(values), by.as_integer_ratio()
                if key not in known:
                    moved = values if not by else [value + by if value else by for value in values]
                    known[key] = [table.setdefault(value.as_integer_ratio(), len(table)) for value in moved]
                places = known[key]
                index[axis, begin:end] = places[0] if len(places) == 1 else np.array(places, np.int32)[row]
        else:
            numbers[begin] = number_of(item)
            zero = zero or [[table.setdefault((0, 1), len(table))] for table in tables]
            own.append(begin)
        begin = end
    if own:
        index[:, own] = zero
    x, y, z = (tuple(Fraction(*ratio) for ratio in table) for table in tables)
    return FlatBlock(numbers, ShiftTable((x, y, z), index))


_NO_SHIFT = ShiftTable(((Fraction(0),),) * 3, np.zeros((3, 1), np.int32))


# Bodies of an imported geometry: pieces, each at all its places

RIGID_TOLERANCE = Fraction(1, 1 << 30)
"""Least thickness that rounding cannot turn inside out, as a share of the distance from the origin."""


def plane_gaps(planes: Iterable[tuple[Point, Fraction]]) -> tuple[list[Fraction], Fraction]:
    """Return the distances between neighbours among parallel planes, and the largest offset.

    Planes are (normal, offset); both are divided by the largest component of the normal.
    """
    offsets: defaultdict[Point, set[Fraction]] = defaultdict(set)
    for normal, offset in planes:
        size = max(map(abs, normal))
        x, y, z = (n / size for n in normal)
        sign = 1 if (x, y, z) > ORIGIN else -1  # opposite normals are parallel planes too
        offsets[sign * x, sign * y, sign * z].add(sign * offset / size)
    gaps = [high - low for some in offsets.values() for low, high in pairwise(sorted(some))]
    return gaps, max((abs(offset) for some in offsets.values() for offset in some), default=Fraction(0))


_MOST_HELD = 1 << 14
"""Most moved surfaces that bodies share."""
_BLOCK = 64, 1 << 13
"""Least and most bodies of a block (`InstanceList.blocks`)."""


class BlockBodies(InstanceList, Generic[P]):
    """The bodies of a block as a lazy list: each is built on demand from fractions, every number rounded once."""

    def __init__(self, whole: UniverseBlock[P], pieces: list[P], flat: FlatBlock) -> None:
        super().__init__(flat.pieces, flat.shifts, [piece.material for piece in pieces])
        self._whole, self._pieces = whole, pieces

    def name(self, number: int) -> str:
        """Return the name of a body: the name of its piece and the path to it."""
        piece, path = self._whole.at(number)
        return self._whole.path_name(piece.title, path)

    def number(self, name: str) -> int | None:
        """Return the number of the body with a name, or None."""
        return self._whole.find(name)

    def blocks(self) -> list[InstanceBlock]:
        """Return the placed blocks of a size within `_BLOCK`, the largest ones (`InstanceList.blocks`)."""
        found: list[InstanceBlock] = []
        forms: dict[int, int] = {}
        pending, first = list(reversed(self._whole.items)), 0
        while pending:
            item = pending.pop()
            if isinstance(item, BlockPlacement) and item.count > _BLOCK[1]:
                pending.extend(reversed(item.block.items))
                continue
            if isinstance(item, BlockPlacement) and item.count >= _BLOCK[0]:
                found.append(InstanceBlock(first, item.count, forms.setdefault(id(item.block), len(forms))))
            first += item.count
        return found

    def outermost(self) -> Iterator[int]:
        """Yield for each piece its first body and the bodies with the largest shifts along the axes.

        Coordinates are extreme there, so building these bodies checks that the numbers of all are in range.
        """
        members = [numbers for numbers in self.members if len(numbers)]
        if not members:
            return
        order, sizes = np.concatenate(members), np.array(list(map(len, members)))
        first, group = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(members)), sizes)
        found = [first]
        for values, index in zip(self.shifts.values, self.shifts.index, strict=True):
            places = _ranks(values)[index[order]]
            for extreme in (np.minimum, np.maximum):
                ends = np.flatnonzero(places == extreme.reduceat(places, first)[group])
                found.append(ends[np.diff(group[ends], prepend=-1) > 0])  # of equal places the first body
        yield from order[unique_sorted(*found)].tolist()

    @cached_property
    def farthest(self) -> Fraction:
        """The largest absolute shift along an axis."""
        return max((abs(value) for values in self.shifts.values for value in values), default=Fraction(0))


def _ranks(values: Sequence[Fraction]) -> npt.NDArray[np.int64]:
    """Return the rank of each value in sorted order."""
    ranks = np.empty(len(values), np.int64)
    # Whole numbers decide nearly all comparisons, and are quick to compare
    keys = [((value.numerator << 64) // value.denominator, value) for value in values]
    ranks[sorted(range(len(values)), key=keys.__getitem__)] = np.arange(len(values))
    return ranks


class CellBodies(BlockBodies[CellPiece]):
    """The bodies of an OpenMC or MCNP geometry: cells cut by their surroundings."""

    def __init__(self, whole: UniverseBlock[CellPiece], pieces: list[CellPiece], flat: FlatBlock) -> None:
        super().__init__(whole, pieces, flat)
        self._maker, self._moved = SolidBuilder(), SolidBuilder()
        self._movers: dict[Shift, PlacedSurfaces] = {}

    def shape_at(self, kind: int, shift: Shift) -> Solid:
        """Build a piece, translated by a shift."""
        return self._solid(self._pieces[kind].context, shift)

    def motion(self, kind: int) -> Motion:
        """Return the motion that all parts of a piece share; the identity if they have several."""
        groups = self._pieces[kind].context.groups
        return groups[0][0] if len(groups) == 1 else IDENTITY_MOTION

    def unrotated_shape(self, kind: int, shift: Shift) -> Solid:
        """Build a piece before its shared motion (see `InstanceList.unrotated_shape`)."""
        context = self._pieces[kind].context
        if len(context.groups) == 1:
            context = PlaceBounds(((IDENTITY_MOTION, context.groups[0][1]),))
        return self._solid(context, shift)

    def _solid(self, context: PlaceBounds, shift: Shift) -> Solid:
        """Build the solid of place bounds, translated by a shift."""
        groups, maker = [(motion, group.parts) for motion, group in context.groups], self._maker
        if shift != ORIGIN:
            # Pieces around one another have surfaces in common. The last so many of these are held
            if len(self._moved.curved) + len(self._moved.convex) > _MOST_HELD:
                self._moved, self._movers = SolidBuilder(), {}
            mover = self._movers.get(shift)
            if mover is None:
                mover = self._movers[shift] = PlacedSurfaces(UniversePlacement(shift=shift))
            maker, groups = self._moved, [(motion, tuple(map(mover.move, parts))) for motion, parts in groups]
        return maker.solid(groups)

    def is_rigid(self, kind: int) -> bool:
        """Return True if no part of a piece is so thin that rounding may close it at any of its places.

        Normals of slanted planes must also be exact floats, so that equal distances along them are equal planes.
        """
        context = self._pieces[kind].context
        if len(context.groups) > 1:
            return False
        planes: list[tuple[Point, Fraction]] = []
        least: list[Fraction] = []
        reach = [self.farthest]
        for _, group in context.groups:
            for side in _part_sides(group.parts):
                surface = side.surface
                if isinstance(surface, FlatSurface):
                    if surface.axis is None and any(Fraction(float(n)) != n for n in surface.normal):
                        return False
                    planes.append((surface.normal, surface.offset))
                elif isinstance(surface, RoundSurface):
                    least.append(surface.radius)
                    reach += map(abs, surface.center)
        gaps, farthest = plane_gaps(planes)
        return min([*least, *gaps], default=Fraction(1)) > RIGID_TOLERANCE * max(*reach, farthest)

    def coordinates(self, kind: int) -> Coordinates | None:
        """Return the places of planes across axes and the centers of curved surfaces; None for a slanted plane."""
        found: Coordinates = (set(), set(), set())
        for _, group in self._pieces[kind].context.groups:
            for side in _part_sides(group.parts):
                surface = side.surface
                if not isinstance(surface, FlatSurface):
                    for some, value in zip(found, surface.origin, strict=True):
                        some.add(value)
                elif surface.axis is None:
                    return None
                else:
                    found[surface.axis].add(surface.end)
        return found


def _part_sides(parts: tuple[RegionPart, ...]) -> Iterator[SurfaceSide]:
    """Yield all sides of region parts."""
    for part in parts:
        if isinstance(part, SurfaceSide):
            yield part
        else:
            yield from _part_sides(part.parts)
