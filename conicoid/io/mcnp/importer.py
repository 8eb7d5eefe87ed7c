"""Import of MCNP decks: cards become a checked `CellGeometry`, which is expanded like an OpenMC geometry.

`read_deck` reads a deck and collects all errors with their lines; `RegionReader` reads the regions of cells;
`import_file` expands the deck into bodies, legend and notes.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field, replace
from itertools import pairwise

from ..._util.files import MAX_PROBLEMS, Problem, SceneFileError, printable
from ..._util.records import dataclass
from ..importers import ImportOptions, ImportResult, OmittedPart, limit_notes, select_bodies
from ..openmc import geometry
from ..openmc.expansion import UniverseExpansion
from ..openmc.geometry import VOID, CellGeometry, lattice_fillings
from ..openmc.importer import MAX_NESTING
from ..openmc.region_expression import (
    LONGEST_REGION,
    MAX_HALF_SPACES,
    IntersectionNode,
    Region,
    RegionParser,
    count_half_spaces,
    join_regions,
    negate_region,
    region_depth,
)
from ..openmc.values import join_limited
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .cards import Card, CellCard, DataCards, McnpMaterials, parse_integer, read_cards, read_cell_card
from .surfaces import SurfaceCard, SurfaceSheets, read_surface_card
from .transformations import FrameChange
from .universes import UniverseBuilder, read_trcl


class _DependentError(ValueError):
    """Raised for an error that only follows from another one, which is reported already."""


@dataclass(frozen=True)
class DeckGeometry:
    """A deck's geometry, its title, notes and remarks."""

    geometry: CellGeometry
    title: str
    notes: tuple[str, ...]
    remarks: tuple[str, ...]


def read_deck(path: str | os.PathLike[str], root: str | os.PathLike[str] | None = None) -> DeckGeometry:
    """Return the geometry of a deck and of the files within `root` that it reads.

    None is the folder of the deck. Raise SceneFileError with all errors in it.
    """
    return _DeckReader(path, root).read()


@dataclass
class _DeckReader:
    """Reader of one deck. Numbers of broken cells and surfaces are noted, so that references report no second error."""

    path: str | os.PathLike[str]
    root: str | os.PathLike[str] | None
    problems: list[Problem] = field(default_factory=list)
    cards: dict[int, CellCard] = field(default_factory=dict)
    data: DataCards = field(default_factory=DataCards)
    sheets: SurfaceSheets = field(default_factory=SurfaceSheets)
    regions: dict[int, Region | None] = field(default_factory=dict)  # by cell; None is all of space
    unmoved: dict[int, Region | None] = field(default_factory=dict)  # regions before TRCL
    changes: dict[int, FrameChange] = field(default_factory=dict)  # TRCL by cell
    broken_surfaces: set[int] = field(default_factory=set)
    broken_cells: set[int] = field(default_factory=set)
    unsupported: dict[int, str] = field(default_factory=dict)  # surfaces that cannot be expressed -> what they are
    omitted: dict[int, str] = field(default_factory=dict)  # cells with such surfaces -> the reason
    remarks: list[str] = field(default_factory=list)

    def read(self) -> DeckGeometry:
        """Read the deck: transformations first, as surfaces and cells need them."""
        deck = read_cards(self.path, self.root)
        for card in deck.data:
            with self._reporting(card, card.text.split()[0]):
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
        builder = self._universes()
        self._raise()
        notes = tuple(self._left_out(builder))
        omissions = limit_notes(geometry.omission_notes(self.omitted))
        remarks = (*deck.remarks, *self.data.remarks, *omissions, *self._skewed(), *self.remarks)
        return DeckGeometry(self._geometry(builder), deck.title, notes, remarks)

    def _surface(self, card: Card) -> None:
        where = f"surface {card.text.split()[0].lstrip('*+')[:20]}"
        digits = where.removeprefix("surface ")
        with self._reporting(card, where):
            try:
                self._add_surface(read_surface_card(card))
            except OmittedPart as error:
                self.unsupported[int(digits)] = f"surface {digits} {error}"
            except ValueError:
                # Cells that use it would report it once more, each
                self.broken_surfaces |= {int(digits)} if digits.isdecimal() and len(digits) < 10 else set()
                raise

    def _add_surface(self, surface: SurfaceCard) -> None:
        # The later card would silently change all cells before it
        if surface.number in self.sheets.facets:
            raise ValueError("its number is taken by another surface")
        change = None
        if surface.change is not None:
            change = self.data.changes.get(surface.change)
            if change is None:
                raise ValueError(f"the transformation tr{surface.change} is not in the data block")
        self.sheets.add(surface, change)
        if surface.form.remark:
            self.remarks.append(f"surface {surface.number} {surface.form.remark}")

    def _cell_card(self, card: Card) -> None:
        digits = card.text.split()[0][:20]
        with self._reporting(card, f"cell {digits}"):
            try:
                cell = read_cell_card(card, self.cards)
                if cell.number in self.cards:
                    first = self.cards[cell.number].card
                    # The first may be no cell: a continued line that lacks blanks
                    raise ValueError(f"its number is taken by the cell of line {first.line}{first.hint}")
                self.cards[cell.number] = cell
            except ValueError:
                self.broken_cells |= {int(digits)} if digits.isdecimal() and len(digits) < 16 else set()
                raise

    def _per_cell(self) -> None:
        """Add the parameters of cells that the data block lists in the order of cells; cell cards take precedence."""
        for name, (card, values) in self.data.cells.items():
            with self._reporting(card, name):
                # Fewer entries are allowed: the other cells keep their defaults. Broken cells are not counted among the
                # cards
                if len(values) > len(self.cards) and not self.broken_cells:
                    raise ValueError(f"has {len(values):,} entries for {len(self.cards):,} cells")
                for number, value in zip(list(self.cards), values, strict=False):
                    cell = self.cards[number]
                    # 0 is the default of all but the importance, for which it means the outside world
                    if value is not None and name not in cell.keywords and (value or name.startswith("imp")):
                        word = str(value.numerator) if value.denominator == 1 else str(float(value))
                        self.cards[number] = replace(cell, keywords={**cell.keywords, name: [word]})

    def _changes(self) -> None:
        """Read the transformations of cells."""
        for number, cell in self.cards.items():
            with self._reporting(cell.card, f"cell {number}"):
                change = read_trcl(cell, self.data.changes)
                if change is not None:
                    self.changes[number] = change

    def _regions(self) -> None:
        """Read the regions of cells, each after those to which it refers."""
        reader = RegionReader(self._side, self._region)
        order, circle = sort_cells({n: cell.region for n, cell in self.cards.items()})
        for number in circle:
            self.broken_cells.add(number)
            self._report(self.cards[number].card.line, f"cell {number}", "region: refers to itself, by '#'")
        for number in order:
            cell = self.cards[number]
            with self._reporting(cell.card, f"cell {number}"):
                try:
                    region = reader.read(cell.region) if cell.region else None
                except OmittedPart as error:
                    self.omitted[number] = str(error)
                    continue
                except ValueError:
                    self.broken_cells.add(number)
                    raise
                change = self.changes.get(number)
                self.unmoved[number] = region
                # '#n' is the complement of the moved cell
                self.regions[number] = region if change is None or region is None else self.sheets.moved(region, change)

    def _side(self, number: int, facet: int | None) -> Region:
        """Return the negative side of a surface or facet.

        Number 1000 c + s names surface s, moved by TRCL with cell c.
        """
        if number in self.sheets.facets:
            return self.sheets.side(number, facet)
        # MCNP names a mesh of tetrahedra by the surface 0
        reason = self.unsupported.get(number) if number else "surface 0 stands for a mesh (EMBED)"
        # MCNP numbers the surfaces that TRCL makes, so that other cells may name them
        change = self.changes.get(number // 1000)
        if change is not None:
            reason = reason or self.unsupported.get(number % 1000)
        if reason is not None:
            raise OmittedPart(reason)
        if change is not None and number % 1000 in self.sheets.facets:
            return self.sheets.moved(self.sheets.side(number % 1000, facet), change)
        if number in self.broken_surfaces:
            raise _DependentError
        raise ValueError(f"region: refers to unknown surface {number}")

    def _region(self, number: int) -> Region:
        """Return the region of a cell after '#'."""
        if number in self.broken_cells:
            raise _DependentError
        if number in self.omitted:
            raise OmittedPart(self.omitted[number])
        if number not in self.cards:
            raise ValueError(f"region: '#{number}' refers to an unknown cell")
        region = self.regions.get(number)
        if region is None:
            raise ValueError(f"region: cell {number} is all of space: nothing is outside of it")
        return region

    def _universes(self) -> UniverseBuilder:
        """Build cells, universes and lattices."""
        builder = UniverseBuilder(self.sheets.found, McnpMaterials(self.data.materials), self.data.changes)
        for number, cell in self.cards.items():
            if number in self.broken_cells:
                builder.broken.add(builder.universe_of(cell))
                continue
            if number in self.omitted:
                builder.cells.setdefault(builder.universe_of(cell), [])
                continue
            with self._reporting(cell.card, f"cell {number}"):
                try:
                    builder.add(cell, self.unmoved[number], self.regions[number], self.changes.get(number))
                except ValueError:
                    builder.broken.add(builder.universe_of(cell))
                    raise
        for cell, message in builder.missing():
            self._report(cell.card.line, f"cell {cell.number}", message)
        self.remarks += builder.crowded()
        return builder

    def _left_out(self, builder: UniverseBuilder) -> Iterator[str]:
        cells = builder.outside
        if cells:
            yield f"importance 0, outside: cell{'s' if len(cells) > 1 else ''} {join_limited(cells)}"

    def _skewed(self) -> Iterator[str]:
        """Yield remarks about transformations that are no rotations, or that the file leaves open."""
        for what, changes in (("tr", self.data.changes), ("trcl of cell ", self.changes)):
            for number, change in changes.items():
                if change.skew > 1e-9:
                    yield f"{what}{number}: its matrix is {change.skew:.2g} away from a rotation; it is applied so"
                if change.is_free:
                    yield f"{what}{number}: gives one axis; MCNP chooses the other two, and may choose others"

    def _geometry(self, builder: UniverseBuilder) -> CellGeometry:
        """Return the checked geometry. Raise SceneFileError for circles, too many levels, or an empty world."""
        root = XmlElement("deck", 1, 1, {})
        inside = geometry.count_fillings(builder.cells, builder.lattices)
        order = geometry.topological_order(inside)
        circle = geometry.find_circle(inside, order)
        if circle:
            self._report(1, "", f"has universes that contain themselves: {builder.readable(circle)}")
        elif geometry.nesting_depth(inside, order) > MAX_NESTING:
            self._report(1, "", f"nests universes deeper than {MAX_NESTING} levels")
        if 0 not in builder.cells:
            self._report(1, "", "has no cells outside of universes, of an importance above 0")
        self._raise()
        counts = geometry.count_bodies(builder.cells, inside, order)
        used = {n for lattice in builder.lattices.values() for n in lattice_fillings(lattice)}
        used |= {cell.fill for cells in builder.cells.values() for cell in cells if cell.fill is not None}
        idle = sorted(n for n in builder.cells.keys() - used - {0})
        if idle:
            self.remarks.append(f"universe{'s' if len(idle) > 1 else ''} {join_limited(idle)}: fills no cell")
        # The model ends where cells of importance 0 begin.
        world = [negate_region(region) for n in builder.root_outside if (region := self.regions[n]) is not None]
        cells = {cell.id: cell for cells in builder.cells.values() for cell in cells}
        whole = join_regions(IntersectionNode, world) if world else None
        materials = builder.materials.named()
        return CellGeometry(
            self.sheets.found, cells, builder.cells, builder.lattices, materials, 0, counts, root, world=whole
        )  # fmt: skip

    @contextmanager
    def _reporting(self, card: Card, where: str) -> Iterator[None]:
        """Record an error of a card, so that the other cards are checked too."""
        try:
            yield
        except _DependentError:
            pass
        except (ValueError, OverflowError, ZeroDivisionError) as error:
            message = str(error) if type(error) is ValueError else f"numbers are out of range ({error})"
            self._report(card.line, where, message + card.hint)

    def _report(self, line: int, where: str, message: str) -> None:
        self.problems.append(Problem(line, 1, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            self._raise()

    def _raise(self) -> None:
        if self.problems:
            raise SceneFileError(self.path, self.problems)


# Regions: a blank is an intersection, ":" a union, "#" a complement of a parenthesis or of a cell ("#5")

MAX_REGION_DEPTH = 60
"""Most levels of unions within intersections within unions."""
# A signed surface, perhaps with a facet: "-3", "3.2".
_HALF = re.compile(r"([-+]?)([0-9]{1,9})(?:\.([0-9]{1,2}))?")


class RegionReader:
    """Reader of regions: `side` returns the negative side of a surface or facet, `cell` the region of a cell.

    `budget` is the number of half-spaces that the regions still to be read may have together.
    """

    def __init__(self, side: Callable[[int, int | None], Region], cell: Callable[[int], Region]) -> None:
        self.side, self.cell = side, cell
        self.budget = MAX_HALF_SPACES

    def read(self, words: list[str]) -> Region:
        """Return the region of the words of a cell card. Raise ValueError for a wrong or too large region."""
        parser = _McnpRegion(self, words)
        region = parser.whole()
        self.budget -= parser.count
        # Later stages walk regions by recursion
        if region_depth(region) > MAX_REGION_DEPTH:
            raise ValueError(f"region: nests deeper than {MAX_REGION_DEPTH} levels, with the cells that it refers to")
        return region


class _McnpRegion(RegionParser):
    """The parser of the words of a cell card."""

    union_sign, intersection_sign, complement_sign = ":", "", "#"

    def __init__(self, regions: RegionReader, words: list[str]) -> None:
        self.regions, self.words = regions, iter(words)
        super().__init__(min(LONGEST_REGION, regions.budget))

    def advance(self) -> None:
        self.word = next(self.words, "")

    def leaf(self, negated: bool, is_complement: bool) -> Region:
        if is_complement:
            region = self.regions.cell(parse_integer("the cell after '#'", self.word))
        else:
            match = _HALF.fullmatch(self.word)
            if match is None:
                raise self.wrong(f"{shorten(self.word, 20)!r} is no surface, '#' or '('" if self.word else "ends early")
            region = self.regions.side(int(match[2]), None if match[3] is None else int(match[3]))
            # "3" and "+3" are the positive side, the complement of the negative one
            negated = negated != (match[1] != "-")
        # Surfaces may have several facets and complements repeat whole cells, so words alone do not bound the size
        self.charge(count_half_spaces(region))
        self.advance()
        return negate_region(region) if negated else region

    def wrong(self, what: str) -> ValueError:
        return ValueError(f"region: {what}")


# Order of cells: each after the cells that its region refers to by '#n'


def sort_cells(regions: Mapping[int, list[str]]) -> tuple[list[int], list[int]]:
    """Return cells in an order without forward references, and the cells left over, which refer to themselves.

    `regions` holds the words of each cell's region.
    """
    needs = {number: _complements(words) & regions.keys() for number, words in regions.items()}
    order = geometry.topological_order(needs)
    sorted_cells = set(order)
    return order, [number for number in regions if number not in sorted_cells]


def _complements(words: list[str]) -> set[int]:
    """Return the numbers of cells after '#'."""
    pairs = pairwise(words)
    return {int(number) for word, number in pairs if word == "#" and number.isdecimal() and len(number) < 16}


# Import as bodies, legend and notes


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import an MCNP deck.

    A cell becomes one body for each of its places, named such as "cell 5 @ cell 9, cell 2, lattice [3, 4, 0]".

    Parameters
    ----------
    path
        The file.
    options
        Options of the import; `void`, `strict`, `only` and `root` apply.

    Raises
    ------
    SceneFileError
        A ValueError that lists all errors with their lines; also for more bodies than `options` allows, which are
        counted before they are built. Cells with tori, which are no quadrics, are left out with a remark.
    ValueError
        An option does not apply to MCNP, or `only` names no body.

    """
    options.refuse_others("an MCNP deck", "void", "strict", "only", "root")
    deck = read_deck(path, options.root)
    expansion = UniverseExpansion(path, deck.geometry, options.most, options.void, options.progress)
    expansion.run()
    remarks = (*deck.remarks, *_remarks(expansion))
    title = (f"title: {printable(shorten(deck.title, 80))}",) if deck.title else ()
    notes = (*title, *expansion.facts(), *deck.notes, *remarks)
    geometry, looks = deck.geometry, expansion.looks
    names = {looks[n]: VOID if n is None else geometry.material_names[n] for n in expansion.materials}
    result = ImportResult(expansion.bodies, expansion.legend, notes, remarks, names, domain=expansion.domain, unit="cm")
    return result if options.only is None else select_bodies(result, options.only)


def _remarks(expansion: UniverseExpansion) -> Iterator[str]:
    """Yield remarks about parts that differ from the file, or that the file may not intend."""
    geometry = expansion.geometry
    yield from limit_notes(expansion.empty_places.notes(geometry))
    yield from limit_notes(
        f"{geometry.lattices[key]}: the cell around it may reach beyond it, where nothing is"
        for key in sorted(expansion.open_lattices)
    )
    if expansion.void and geometry.world is None:
        yield "no cell outside of universes has importance 0: it is not known where the model ends"
    elif expansion.void and not expansion.is_enclosed:
        yield "the cells of importance 0 leave the model open on some side"
