"""Expansion of an OpenMC or MCNP geometry: cells in universes and lattices become bodies, one for each place.

`UniverseExpansion` walks from the root universe down. Every cell is intersected with the bounds of its place
(`PlaceBounds`), and places without volume are left out. The content of a lattice element is expanded once for equal
surroundings, as a block about the element's centre, and translated to the other elements.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import field

from ..._util.files import MAX_PROBLEMS, Problem, SceneFileError
from ..._util.records import dataclass
from ..._util.text import format_count
from ...geometry.shape import Solid, Union
from ...geometry.transform import Motion
from ...materials.material import Material
from ...materials.presets import matte
from ..importers import BodyLimits, LegendEntry, palette_color
from . import geometry
from .geometry import VOID as VOID_NAME, CellGeometry, UniverseCell, find_enclosure, is_bounded_with, lattice_fillings
from .lattices import Index, Lattice
from .placement import UNBOUNDED, AxisTurn, Extent, ExtentEnd, Point, UniversePlacement
from .region import PlacedSurfaces, RegionPart, SolidBuilder, SurfaceSide, bind_surfaces
from .region_expression import list_half_spaces
from .surfaces import FlatSurface
from .universe_block import (
    CellBodies,
    CellPiece,
    EmptyPlaces,
    PlaceBounds,
    PlacePath,
    UniverseBlock,
    flatten_block,
    place_name,
)
from .values import VACUUM_DENSITIES, is_place_name, join_limited

VOID_MATERIAL = Material(
    (0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name=VOID_NAME, properties=VACUUM_DENSITIES
)
"""The material of void: invisible, light goes straight through."""

ExpansionProgress = Callable[[int, int], None]


@dataclass
class UniverseExpansion:
    """Expands one geometry into blocks and these into `bodies`, and counts bodies, materials and empty places.

    Parameters
    ----------
    path
        The file, for messages.
    geometry
        The geometry.
    most
        Most bodies.
    void
        Whether cells without material become invisible bodies.
    progress
        Called with the number of bodies so far and their expected number.

    """

    path: str | os.PathLike[str]
    geometry: CellGeometry
    most: BodyLimits
    void: bool
    progress: ExpansionProgress | None = None
    whole: UniverseBlock[CellPiece] = field(default_factory=UniverseBlock)
    blocks: dict[tuple[int, AxisTurn, Motion, PlaceBounds], UniverseBlock[CellPiece]] = field(default_factory=dict)
    open_lattices: set[int] = field(default_factory=set)  # without outer universe, in cells that reach beyond them
    problems: dict[int, Problem] = field(default_factory=dict)  # first problem of each cell
    outside: int = 0  # places in elements outside lattices
    steps: int = 0  # comparisons of sides so far, which max_comparisons limits
    maker: SolidBuilder = field(default_factory=SolidBuilder)
    looks: dict[int | None, Material] = field(default_factory=lambda: {None: VOID_MATERIAL})
    filled_cells: list[Solid] = field(default_factory=list)  # the root's cells that universes fill
    repeating: dict[int, bool] = field(default_factory=dict)  # by lattice: is its outer universe periodic
    turning: dict[int, bool] = field(default_factory=dict)  # by universe: has it rotations but quarter turns
    block: UniverseBlock[CellPiece] = field(init=False)  # the block under construction
    bodies: CellBodies = field(init=False)
    way: PlacePath = ()  # path to `block`
    body_count: int = 0  # bodies so far
    singles: int = 0  # bodies so far that are no translated copies

    def __post_init__(self) -> None:
        self.block = self.whole
        self.unmoved = {number: numbered.surface for number, numbered in self.geometry.surfaces.items()}

    def run(self) -> None:
        """Expand the geometry. Raise SceneFileError for too many bodies or numbers out of the range of float64."""
        # Before anything is built: a few lines of XML may mean a billion pins
        geometry.check_body_count(self.path, self.geometry, self.most.bodies)
        if self.progress is not None:
            self.progress(0, self.geometry.body_count)
        self._universe(self.geometry.root, UniversePlacement(), PlaceBounds(), ())
        self._bodies()
        if self.problems:
            raise SceneFileError(self.path, self.problems.values())

    def _bodies(self) -> None:
        """List the bodies of all blocks; build the outermost bodies of each piece, to report errors in them."""
        pieces, flat = flatten_block(self.whole)
        self.bodies = CellBodies(self.whole, pieces, flat)
        for number in self.bodies.outermost():
            piece, path = self.whole.at(number)
            with self._reporting(self.geometry.cells[piece.cell], path):
                self.bodies.shape(number)

    def _universe(self, number: int, place: UniversePlacement, context: PlaceBounds, path: PlacePath) -> None:
        """Expand the cells of a universe at a place within bounds."""
        surfaces = PlacedSurfaces(place, self.unmoved)
        for cell in self.geometry.universes[number]:
            with self._reporting(cell, path):
                self._cell(cell, place, context, path, surfaces)

    def _cell(
        self,
        cell: UniverseCell,
        place: UniversePlacement,
        context: PlaceBounds,
        path: PlacePath,
        surfaces: PlacedSurfaces,
    ) -> None:
        """Expand a cell at a place: count it as empty, add its body, or expand what fills it."""
        parts = () if cell.region is None else (bind_surfaces(cell.region, surfaces),)
        inner = self._narrowed(cell, context, place, parts)
        self.block.empty_places.visit(cell, inner is None)
        if inner is None:
            return
        if cell.fill is None:
            self._body(cell, inner, path)
        else:
            # Of the root's cells only: those within them fill them
            if self.block is self.whole and not path:
                self.filled_cells.append(self._solid(inner))
            inside = place.inner(cell.translation, cell.rotation)
            if not cell.rotation.motion.is_identity:
                entry = place.entry(cell.translation, cell.rotation)
                inner = inner.entering(entry, place.outer, inside.outer)
            self._filled(cell, inside, inner, (*path, *cell.step))

    def _narrowed(
        self,
        cell: UniverseCell,
        context: PlaceBounds,
        place: UniversePlacement,
        parts: Iterable[RegionPart],
        extent: Extent = UNBOUNDED,
    ) -> PlaceBounds | None:
        """Return bounds with further parts, None if nothing is left; raise SceneFileError if the work is too much."""
        further = tuple(parts)
        # Bodies alone do not bound the work: a cell of many half-spaces is compared anew in each element of a lattice
        self.steps += context.cost(place.outer, further)
        if self.steps > geometry.max_comparisons(self.most.singles):
            raise geometry.effort_limit_error(self.path, cell, self.most.singles)
        return context.and_(place.outer, further, extent)

    def _filled(self, cell: UniverseCell, place: UniversePlacement, context: PlaceBounds, path: PlacePath) -> None:
        """Expand the universe or lattice that fills a cell, within the bounds of the cell."""
        lattice = self.geometry.lattice_of(cell)
        if lattice is None:
            assert cell.fill is not None
            self._universe(cell.fill, place, context, path)
            return
        room = ElementRoom.of(lattice, place, context)
        # The elements in the order of the file, so that numbers of bodies follow it
        for index, universe in lattice.universes.items():
            is_there = self._element(cell, lattice, index, universe, place, context, path, room)
            self.block.empty_places.visit(lattice, not is_there)
        # What lies around the lattice in its cell, which is nothing where the cell has the size of the lattice
        outside = self._narrowed(cell, context, place, [prism.placed(place).outside() for prism in lattice.hull])
        if outside is None:
            return
        if lattice.outer is None:
            # OpenMC loses particles there, so a remark names the lattice
            self.open_lattices.add(lattice.id)
        elif self._repeats(lattice, lattice.outer):
            # A periodic universe looks the same from every element: one copy fills all space around the lattice.
            center = lattice.center(next(iter(lattice.universes)))
            self._universe(lattice.outer, place.inner(center), outside, (*path, f"{lattice.label} outer"))
        else:
            self._tiles(cell, lattice, lattice.outer, place, outside, path)

    def _element(
        self,
        cell: UniverseCell,
        lattice: Lattice,
        index: Index,
        universe: int,
        place: UniversePlacement,
        context: PlaceBounds,
        path: PlacePath,
        room: ElementRoom | None,
    ) -> bool:
        """Expand the universe of one lattice element; return False if no part of it is within the bounds."""
        inside, way = place.inner(lattice.center(index)), (*path, f"{lattice.label} [{', '.join(map(str, index))}]")
        is_clear = room is not None and room.has(inside.shift)
        if room is not None and is_clear and universe in room.blocks:
            self._count(room.blocks[universe].count, cell)
            self.block.place(room.blocks[universe], inside.shift, way)
            return True
        prism = lattice.prism(index).placed(place)
        inner = self._narrowed(cell, context, place, prism.sides(), prism.extent)
        # What stands once in a lattice of the root has nothing to share with
        if (
            inner is not None
            and self.block is self.whole
            and lattice.tally[universe] == 1
            and universe != lattice.outer
        ):
            self._universe(universe, inside, inner, way)
        elif inner is not None:
            block = self._shared(cell, universe, inside, inner, way)
            if room is not None and is_clear and block is not None:
                room.blocks[universe] = block
        return inner is not None

    def _shared(
        self, cell: UniverseCell, universe: int, place: UniversePlacement, context: PlaceBounds, path: PlacePath
    ) -> UniverseBlock[CellPiece] | None:
        """Expand a universe in an element as a block, shared by elements with equal bounds about their centres.

        Return the block; None where content cannot be shared.
        """
        # Parts behind other motions, and rotated content, are not the same about every centre
        if not context.is_before(place.outer) or self._turns(universe):
            self._universe(universe, place, context, path)
            return None
        x, y, z = place.shift
        about = context.moved((-x, -y, -z))
        key = universe, place.turn, place.outer, about
        block = self.blocks.get(key)
        if block is None:
            block = self.blocks[key] = UniverseBlock()
            outer_block, outer_way = self.block, self.way
            self.block, self.way = block, (*outer_way, *path)
            self._universe(universe, UniversePlacement(place.turn, outer=place.outer), about, ())
            self.block, self.way = outer_block, outer_way
        else:
            self._count(block.count, cell)
        self.block.place(block, place.shift, path)
        return block

    def _turns(self, universe: int) -> bool:
        """Return True if a universe contains a rotation by an angle that is no multiple of 90 degrees."""
        if universe not in self.turning:
            self.turning[universe] = any(not cell.rotation.motion.is_identity for cell in self._all_cells(universe))
        return self.turning[universe]

    def _all_cells(self, universe: int) -> Iterator[UniverseCell]:
        """Yield the cells of a universe and of all universes within it."""
        visited, pending = {universe}, [universe]
        while pending:
            for cell in self.geometry.universes[pending.pop()]:
                yield cell
                lattice = self.geometry.lattice_of(cell)
                inner = lattice_fillings(lattice) if lattice is not None else ([] if cell.fill is None else [cell.fill])
                pending.extend(number for number in inner if number not in visited)
                visited.update(inner)

    def _tiles(
        self,
        cell: UniverseCell,
        lattice: Lattice,
        outer: int,
        place: UniversePlacement,
        context: PlaceBounds,
        path: PlacePath,
    ) -> None:
        """Expand the outer universe element by element, as far as the cell around the lattice reaches.

        Report a problem if the cell is unbounded. Raise SceneFileError for too many places.
        """
        tiles = lattice.tiles_around(context.extent_before(place.outer, tight=True).placed(place.back))
        if tiles is None:
            message = (
                "must be bounded on all sides by planes, ellipsoids or elliptic cylinders, because the outer "
                f"universe {outer} of {lattice} that fills it is repeated without end"
            )
            self._report(cell, str(cell), message)
            return
        # Checked before the first element: a small lattice in a large box may repeat its outer universe a billion times
        count = max(tiles.count - lattice.size, 0) * self.geometry.count(outer)
        self.outside += count
        if self.outside > geometry.PLACES_FOR_A_BODY * self.most.singles:
            where = f"{cell}, in which the outer universe {outer} of {lattice} is repeated"
            raise geometry.body_limit_error(self.path, count, self.most.singles, cell.element, where, "up to ")
        room = ElementRoom.of(lattice, place, context)
        for index in tiles.indices:
            if index not in lattice.universes:
                self._element(cell, lattice, index, outer, place, context, path, room)

    def _repeats(self, lattice: Lattice, outer: int) -> bool:
        """Return True if the outer universe is periodic in the lattice (`is_periodic`)."""
        if lattice.id not in self.repeating:
            self.repeating[lattice.id] = is_periodic(self.geometry, outer, lattice)
        return self.repeating[lattice.id]

    def _body(self, cell: UniverseCell, context: PlaceBounds, path: PlacePath) -> None:
        """Add the body of a cell to the current block, unless the cell is void and void is left out."""
        # The first of several stands for all places; a remark names such cells
        material = cell.materials[0]
        if material is None and not self.void:
            return
        self._count(1, cell)
        self.singles += 1
        if self.singles > self.most.singles:
            raise geometry.single_body_limit_error(self.path, self.singles, self.most.singles, cell)
        if material is not None and material not in self.looks:
            found = self.geometry.material(material)
            name = self.geometry.material_names[material]
            self.looks[material] = matte(palette_color(material), name=name, properties=found.properties)
        # A cell that an export wrote is at the place that its name states
        title, path = (cell.name, ()) if is_place_name(cell.name) else (str(cell), path)
        self.block.add(CellPiece(title, path, self.looks[material], cell.id, context), material)

    def _count(self, count: int, cell: UniverseCell) -> None:
        """Count bodies that a cell adds and report progress. Raise SceneFileError if there are too many."""
        before, self.body_count = self.body_count, self.body_count + count
        if self.body_count > self.most.bodies:
            where = f"{cell} and the outer universes around it"
            raise geometry.body_limit_error(
                self.path, self.body_count, self.most.bodies, cell.element, where, "at least "
            )
        # Blocks are counted at once, so a multiple of 256 may be passed over
        if self.progress is not None and self.body_count // 256 > before // 256:
            self.progress(self.body_count, self.geometry.body_count)

    def _solid(self, context: PlaceBounds) -> Solid:
        return self.maker.solid((motion, group.parts) for motion, group in context.groups)

    @property
    def materials(self) -> dict[int | None, int]:
        """The number of bodies of each material."""
        return self.whole.materials

    @property
    def legend(self) -> tuple[LegendEntry, ...]:
        """The materials by number, void at the end; names only where the file has some."""
        entries, names = [], self.geometry.material_names
        for number, count in sorted(self.materials.items(), key=lambda item: (item[0] is None, item[0] or 0)):
            if number is None:
                entries.append(LegendEntry(None, "", None, count))
            else:
                listed = self.geometry.material(number)
                name = names[number] if listed.name else ""
                entries.append(LegendEntry(listed.id, name, palette_color(number), count))
        return tuple(entries)

    @property
    def empty_places(self) -> EmptyPlaces:
        """Counts of places that have no volume."""
        return self.whole.empty_places

    def facts(self) -> Iterator[str]:
        """Yield notes about the size of the model and about boundary conditions, which change no shape."""
        surfaces = self.geometry.surfaces.values()
        cells = [cell for cell in self.geometry.cells.values() if cell.step]
        sizes = (
            (cells, "cell"), ({surface.id for surface in surfaces}, "surface"),
            ({cell.universe for cell in cells}, "universe"), (self.geometry.lattices, "lattice"),
        )  # fmt: skip
        yield ", ".join(format_count(len(items), what) for items, what in sizes)
        empty = self.empty_places.places
        without = f"; {format_count(empty, 'place')} without volume left out" if empty else ""
        yield format_count(len(self.bodies), "body") + without
        for kind in sorted({surface.boundary for surface in surfaces} - {geometry.TRANSMISSION}):
            numbers = sorted({surface.id for surface in surfaces if surface.boundary == kind})
            yield f"boundary {kind}: surface{'s' if len(numbers) > 1 else ''} {join_limited(numbers)}"

    @property
    def is_enclosed(self) -> bool:
        """True if boundary conditions enclose all cells."""
        return any(True for _ in self._enclosure())

    @property
    def domain(self) -> Solid | None:
        """The region that bodies fill: the enclosure of boundary conditions and the root's cells that universes fill.

        None if void is left out or neither exists.
        """
        if not self.void:
            return None
        parts = [*self._enclosure(), *self.filled_cells]
        return Union(tuple(parts)) if len(parts) > 1 else (parts[0] if parts else None)

    def _enclosure(self) -> Iterator[Solid]:
        """Yield the region within boundary conditions if it is bounded, else nothing."""
        region, place = find_enclosure(self.geometry), UniversePlacement()
        if region is None:
            return
        context = PlaceBounds().and_(
            place.outer, (bind_surfaces(region, PlacedSurfaces(place, self.unmoved)),), UNBOUNDED
        )
        solid = None if context is None else self._solid(context)
        if solid is not None and is_bounded_with(solid, lambda: self.bodies.boxes):
            yield solid

    @contextmanager
    def _reporting(self, cell: UniverseCell, path: PlacePath) -> Iterator[None]:
        """Record numbers of a cell that float64 cannot express, so that the other cells are checked too."""
        try:
            yield
        except SceneFileError:
            raise
        except (OverflowError, ValueError) as error:
            reason = "a number is too large" if isinstance(error, OverflowError) else error
            where = place_name(str(cell), (*self.way, *path))
            self._report(cell, where, f"cannot be expressed in double precision: {reason}")

    def _report(self, cell: UniverseCell, where: str, message: str) -> None:
        """Record the first problem of a cell. Raise SceneFileError once there are `MAX_PROBLEMS`."""
        self.problems.setdefault(cell.id, Problem(cell.element.line, cell.element.column, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            raise SceneFileError(self.path, self.problems.values())


@dataclass
class ElementRoom:
    """Where elements of a lattice lie clear of the cells around it, so that their contents are copies of each other.

    An element is clear if its origin lies strictly between `low` and `high` along each axis, and the part of its box
    that is within `around` on the inner side of all curved surfaces. The first clear element of each universe adds its
    block.
    """

    low: tuple[ExtentEnd, ...]
    high: tuple[ExtentEnd, ...]
    around: Extent
    element: Extent
    """A box around the element about its origin."""
    curved: list[SurfaceSide]
    blocks: dict[int, UniverseBlock[CellPiece]] = field(default_factory=dict)

    @classmethod
    def of(cls, lattice: Lattice, place: UniversePlacement, context: PlaceBounds) -> ElementRoom | None:
        """Return the room within bounds; None if these have unions, or planes that are not across an axis."""
        parts = [part for _, group in context.groups for part in group.parts if not _is_across_axis(part)]
        curved = [part for part in parts if isinstance(part, SurfaceSide) and not isinstance(part.surface, FlatSurface)]
        if not context.is_before(place.outer) or len(curved) < len(parts):
            return None
        center, element = place.point(lattice.first.origin), lattice.first.prism.placed(place).extent
        around = context.extent_before(place.outer)
        # Along an axis without end all elements are cut alike. The origin need not be the middle of an element
        lows = zip(center, element.low, around.low, strict=True)
        low = [None if bottom is None or a is None else a + (c - bottom) for c, bottom, a in lows]
        highs = zip(center, element.high, around.high, strict=True)
        high = [None if top is None or b is None else b - (top - c) for c, top, b in highs]
        x, y, z = center
        origin = element.placed(UniversePlacement(shift=(-x, -y, -z)))
        return cls(tuple(low), tuple(high), around, origin, curved)

    def has(self, center: Point) -> bool:
        """Return True if the element around a centre is clear."""
        ends = zip(self.low, center, self.high, strict=True)
        if not all((low is None or low < c) and (high is None or c < high) for low, c, high in ends):
            return False
        # As `Conjunction.and_` leaves out curved sides that contain the whole box
        box = self.around.common(self.element.placed(UniversePlacement(shift=center))) if self.curved else self.around
        return all(side.of(box) < 0 for side in self.curved)


def _is_across_axis(part: RegionPart) -> bool:
    return isinstance(part, SurfaceSide) and isinstance(part.surface, FlatSurface) and part.surface.axis is not None


def is_periodic(geometry: CellGeometry, universe: int, lattice: Lattice) -> bool:
    """Return True if a universe surely looks the same after every step from element to element of a lattice.

    It does if all its surfaces do; then its place among the elements does not matter.
    """
    surfaces: set[int] = set()
    visited, pending, turned = {universe}, [universe], False
    while pending:
        for cell in geometry.universes[pending.pop()]:
            # A lattice within could be periodic too, but with steps of its own
            if geometry.lattice_of(cell) is not None:
                return False
            turned = turned or cell.is_rotated
            if cell.region is not None:
                surfaces |= {half.surface for half in list_half_spaces(cell.region)}
            if cell.fill is not None and cell.fill not in visited:
                visited.add(cell.fill)
                pending.append(cell.fill)
    # Rotated content repeats along rotated steps
    if turned and surfaces:
        return False
    unmoved = [geometry.surfaces[number].surface for number in surfaces]
    return all(
        surface.placed(UniversePlacement(shift=step)) == surface for surface in unmoved for step in lattice.first.ways
    )
