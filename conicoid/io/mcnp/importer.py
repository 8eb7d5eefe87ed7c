"""From cards to a checked geometry in the records of OpenMC's: every mistake is collected, with its line."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from ..._util.file_errors import MAX_PROBLEMS, Problem, SceneFileError, printable
from ..importers import (
    ImportOptions,
    ImportResult,
    LegendEntry,
    format_count,
    limit_notes,
    palette_color,
    select_bodies,
)
from ..openmc import geometry
from ..openmc.expansion import UniverseExpansion
from ..openmc.geometry import VOID, CellGeometry, lattice_fillings
from ..openmc.importer import MAX_NESTING
from ..openmc.region import IntersectionNode, Region
from ..openmc.values import join_limited
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .cards import Card, CellCard, DataCards, McnpMaterials, read_cards, read_cell_card
from .regions import RegionReader, join_regions, negate_region, sort_cells
from .surfaces import SurfaceCard, SurfaceSheets, read_surface_card
from .transformations import FrameChange
from .universes import UniverseBuilder, read_trcl


class _DependentError(ValueError):
    """What only follows from another mistake, which is told."""


@dataclass(frozen=True)
class DeckGeometry:
    """A deck's geometry, its title, and remarks."""

    geometry: CellGeometry
    title: str
    notes: tuple[str, ...]
    remarks: tuple[str, ...]


def read_deck(path: str | os.PathLike[str]) -> DeckGeometry:
    """Raises SceneFileError with every mistake found."""
    return _DeckReader(path).read()


@dataclass
class _DeckReader:
    """Reads one deck."""

    path: str | os.PathLike[str]
    problems: list[Problem] = field(default_factory=list)
    cards: dict[int, CellCard] = field(default_factory=dict)
    data: DataCards = field(default_factory=DataCards)
    sheets: SurfaceSheets = field(default_factory=SurfaceSheets)
    regions: dict[int, Region | None] = field(default_factory=dict)  # None: all of space
    unmoved: dict[int, Region | None] = field(default_factory=dict)  # before the TRCL
    changes: dict[int, FrameChange] = field(default_factory=dict)  # by cell
    broken_surfaces: set[int] = field(default_factory=set)
    broken_cells: set[int] = field(default_factory=set)
    remarks: list[str] = field(default_factory=list)

    def read(self) -> DeckGeometry:
        deck = read_cards(self.path)
        for card in deck.data:
            with self._telling(card, card.text.split()[0]):
                self.data.read(card)
        for card in deck.surfaces:
            self._surface(card)
        for card in deck.cells:
            self._cell_card(card)
        if not deck.cells:
            self._report(1, "", "holds no cells")
        self._per_cell()
        self._changes()
        self._regions()
        made = self._universes()
        self._raise()
        notes = tuple(self._left_out(made))
        remarks = (*deck.remarks, *self.data.remarks, *self._skewed(), *self.remarks)
        return DeckGeometry(self._geometry(made), deck.title, notes, remarks)

    def _surface(self, card: Card) -> None:
        where = f"surface {card.text.split()[0].lstrip('*+')[:20]}"
        with self._telling(card, where):
            try:
                found = read_surface_card(card)
                self._add_surface(found)
            except ValueError:
                digits = where.removeprefix("surface ")
                self.broken_surfaces |= {int(digits)} if digits.isdecimal() and len(digits) < 10 else set()
                raise

    def _add_surface(self, found: SurfaceCard) -> None:
        if found.number in self.sheets.facets:
            raise ValueError("its number is taken by another surface")
        change = None
        if found.change is not None:
            change = self.data.changes.get(found.change)
            if change is None:
                raise ValueError(f"the transformation tr{found.change} is not in the data block")
        self.sheets.add(found, change)

    def _cell_card(self, card: Card) -> None:
        digits = card.text.split()[0][:20]
        with self._telling(card, f"cell {digits}"):
            try:
                found = read_cell_card(card, self.cards)
                if found.number in self.cards:
                    raise ValueError("its number is taken by another cell")
                self.cards[found.number] = found
            except ValueError:
                self.broken_cells |= {int(digits)} if digits.isdecimal() and len(digits) < 16 else set()
                raise

    def _per_cell(self) -> None:
        """What the data block says of cells, in their order."""
        for name, (card, values) in self.data.cells.items():
            with self._telling(card, name):
                if len(values) > len(self.cards) and not self.broken_cells:
                    raise ValueError(f"has {len(values):,} entries for {len(self.cards):,} cells")
                for number, value in zip(list(self.cards), values, strict=False):
                    cell = self.cards[number]
                    if value is not None and name not in cell.given and (value or name.startswith("imp")):
                        word = str(value.numerator) if value.denominator == 1 else str(float(value))
                        self.cards[number] = replace(cell, given={**cell.given, name: [word]})

    def _changes(self) -> None:
        for number, cell in self.cards.items():
            with self._telling(cell.card, f"cell {number}"):
                change = read_trcl(cell, self.data.changes)
                if change is not None:
                    self.changes[number] = change

    def _regions(self) -> None:
        reader = RegionReader(self._side, self._region)
        order, circle = sort_cells({n: cell.region for n, cell in self.cards.items()})
        for number in circle:
            self.broken_cells.add(number)
            self._report(self.cards[number].card.line, f"cell {number}", "region: refers to itself, by '#'")
        for number in order:
            cell = self.cards[number]
            with self._telling(cell.card, f"cell {number}"):
                try:
                    region = reader.read(cell.region) if cell.region else None
                except ValueError:
                    self.broken_cells.add(number)
                    raise
                change = self.changes.get(number)
                self.unmoved[number] = region
                self.regions[number] = region if change is None or region is None else self.sheets.moved(region, change)

    def _side(self, number: int, facet: int | None) -> Region:
        """The negative side of a surface; 1000 c + s is surface s as TRCL moves it with cell c."""
        if number in self.sheets.facets:
            return self.sheets.side(number, facet)
        change = self.changes.get(number // 1000)
        if change is not None and number % 1000 in self.sheets.facets:
            return self.sheets.moved(self.sheets.side(number % 1000, facet), change)
        if number in self.broken_surfaces:
            raise _DependentError
        raise ValueError(f"region: refers to unknown surface {number}")

    def _region(self, number: int) -> Region:
        if number in self.broken_cells:
            raise _DependentError
        if number not in self.cards:
            raise ValueError(f"region: '#{number}' refers to an unknown cell")
        region = self.regions.get(number)
        if region is None:
            raise ValueError(f"region: cell {number} is all of space: nothing is outside of it")
        return region

    def _universes(self) -> UniverseBuilder:
        made = UniverseBuilder(self.sheets.found, McnpMaterials(self.data.materials), self.data.changes)
        for number, cell in self.cards.items():
            if number in self.broken_cells:
                made.broken.add(made.universe_of(cell))
                continue
            with self._telling(cell.card, f"cell {number}"):
                try:
                    region = self.unmoved if "lat" in cell.given else self.regions
                    made.add(cell, region[number], self.changes.get(number))
                except ValueError:
                    made.broken.add(made.universe_of(cell))
                    raise
        for cell, message in made.missing():
            self._report(cell.card.line, f"cell {cell.number}", message)
        return made

    def _left_out(self, made: UniverseBuilder) -> Iterator[str]:
        if made.outside:
            yield f"importance 0, outside: cell{'s' if len(made.outside) > 1 else ''} {join_limited(made.outside)}"

    def _skewed(self) -> Iterator[str]:
        for what, changes in (("tr", self.data.changes), ("trcl of cell ", self.changes)):
            for number, change in changes.items():
                if change.skew > 1e-9:
                    yield f"{what}{number}: its matrix is {change.skew:.2g} away from a rotation; it is applied so"
                if change.is_free:
                    yield f"{what}{number}: gives one axis; MCNP chooses the other two, and may choose others"

    def _geometry(self, made: UniverseBuilder) -> CellGeometry:
        root = XmlElement("deck", 1, 1, {})
        inside = geometry.count_fillings(made.cells, made.lattices)
        order = geometry.sort_universes(inside)
        circle = geometry.find_circle(inside, order)
        if circle:
            self._report(1, "", f"has universes that contain themselves: {made.readable(circle)}")
        elif geometry.nesting_depth(inside, order) > MAX_NESTING:
            self._report(1, "", f"nests universes deeper than {MAX_NESTING} levels")
        if 0 not in made.cells:
            self._report(1, "", "has no cells outside of universes, of an importance above 0")
        self._raise()
        counts = geometry.count_bodies(made.cells, inside, order)
        used = {n for lattice in made.lattices.values() for n in lattice_fillings(lattice)}
        used |= {cell.fill for cells in made.cells.values() for cell in cells if cell.fill is not None}
        idle = sorted(n for n in made.cells.keys() - used - {0})
        if idle:
            self.remarks.append(f"universe{'s' if len(idle) > 1 else ''} {join_limited(idle)}: fills no cell")
        world = [negate_region(region) for n in made.root_outside if (region := self.regions[n]) is not None]
        cells = {cell.id: cell for cells in made.cells.values() for cell in cells}
        whole = join_regions(IntersectionNode, world) if world else None
        materials = made.materials.named()
        return CellGeometry(
            self.sheets.found, cells, made.cells, made.lattices, materials, 0, counts, root, world=whole
        )  # fmt: skip

    @contextmanager
    def _telling(self, card: Card, where: str) -> Iterator[None]:
        try:
            yield
        except _DependentError:
            pass
        except (ValueError, OverflowError, ZeroDivisionError) as error:
            message = str(error) if type(error) is ValueError else f"numbers are out of range ({error})"
            self._report(card.line, where, message)

    def _report(self, line: int, where: str, message: str) -> None:
        self.problems.append(Problem(line, 1, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            self._raise()

    def _raise(self) -> None:
        if self.problems:
            raise SceneFileError(self.path, self.problems)


# A deck as bodies, the legend of their colours, and what there is to say about it.


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """A cell gives one body for each place where it stands, such as "cell 5 @ cell 9, cell 2, lattice [3, 4, 0]".

    Raises `SceneFileError`, a ValueError, that lists the mistakes found with their lines; also for tori, which are no
    quadrics, and for more bodies than `options` allows, which are counted before they are made.
    """
    options.refuse_others("an MCNP deck", "void", "strict", "only")
    deck = read_deck(path)
    expansion = UniverseExpansion(path, deck.geometry, options.most, options.void, options.progress)
    expansion.run()
    remarks = (*deck.remarks, *_remarks(expansion))
    notes = (*_facts(deck, expansion), *deck.notes, *remarks)
    geometry, looks = deck.geometry, expansion.looks
    names = {looks[n]: VOID if n is None else geometry.material_names[n] for n in expansion.materials}
    found = ImportResult(expansion.bodies, _legend(expansion), notes, remarks, names, domain=expansion.domain)
    return found if options.only is None else select_bodies(found, options.only)


def _legend(expansion: UniverseExpansion) -> tuple[LegendEntry, ...]:
    geometry, entries = expansion.geometry, []
    for key, count in sorted(expansion.materials.items(), key=lambda item: (item[0] is None, item[0] or 0)):
        if key is None:
            entries.append(LegendEntry(None, "", None, count))
        else:
            entries.append(
                LegendEntry(geometry.material(key).id, geometry.material_names[key], palette_color(key), count)
            )
    return tuple(entries)


def _facts(deck: DeckGeometry, expansion: UniverseExpansion) -> Iterator[str]:
    """How large the model is, and what changes no shape."""
    geometry = deck.geometry
    if deck.title:
        yield f"title: {printable(shorten(deck.title, 80))}"
    numbers = {surface.id for surface in geometry.surfaces.values()}
    cells = [cell for cell in geometry.cells.values() if cell.step]
    universes = {cell.universe for cell in cells}
    sizes = ((cells, "cell"), (numbers, "surface"), (universes, "universe"), (geometry.lattices, "lattice"))
    yield ", ".join(format_count(len(items), what) for items, what in sizes)
    empty = expansion.left_out.places
    without = f"; {format_count(empty, 'place')} without volume left out" if empty else ""
    yield format_count(len(expansion.bodies), "body") + without
    yield from _boundaries(geometry)


def _boundaries(geometry: CellGeometry) -> Iterator[str]:
    """Boundary conditions are about particles: they change no shape."""
    kinds = Counter(surface.boundary for surface in geometry.surfaces.values())
    for kind in sorted(set(kinds) - {"transmission"}):
        numbers = sorted({surface.id for surface in geometry.surfaces.values() if surface.boundary == kind})
        yield f"boundary {kind}: surface{'s' if len(numbers) > 1 else ''} {join_limited(numbers)}"


def _remarks(expansion: UniverseExpansion) -> Iterator[str]:
    """What is not as the file says, or may not be meant."""
    geometry = expansion.geometry
    yield from limit_notes(expansion.left_out.notes(geometry))
    yield from limit_notes(
        f"{geometry.lattices[key]}: the cell around it may reach beyond it, where nothing is"
        for key in sorted(expansion.open_lattices)
    )
    if expansion.void and geometry.world is None:
        yield "no cell outside of universes has importance 0: it is not known where the model ends"
    elif expansion.void and not expansion.is_enclosed:
        yield "the cells of importance 0 leave the model open on some side"
