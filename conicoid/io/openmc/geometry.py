"""A geometry as its file says it: cells, universes and lattices, referring to each other by number."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property

from ..._util.arrays import BoxEnds
from ..._util.file_errors import Problem, SceneFileError
from ...geometry.bounds.aabb import enclose_boxes
from ...geometry.labels import format_bytes, format_count
from ...geometry.shape import Solid
from ...materials.properties import Properties
from ..xml_tree import XmlElement
from .lattices import Lattice
from .materials import OpenmcMaterial
from .placement import NO_ROTATION, CellRotation, Point
from .region import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from .surfaces import OpenmcSurface
from .values import UnknownName, format_title

VOID = "void"
"""What the material of empty cells is called."""
UniverseNode = tuple[str, int]
"""A universe or a lattice, by its number: ("universe", 3)."""


@dataclass(frozen=True)
class UniverseCell:
    """A region of a universe, with a material (None: void) or filled with a universe or lattice.

    `region` None is all of space. What fills is rotated, then translated.
    """

    id: int
    name: str
    universe: int
    region: Region | None
    fill: int | None
    materials: tuple[int | None, ...]
    translation: Point
    rotation: CellRotation
    skew: float  # how far a given matrix is from a rotation
    element: XmlElement = field(repr=False, compare=False)

    @property
    def is_rotated(self) -> bool:
        return self.rotation != NO_ROTATION

    @property
    def step(self) -> tuple[str, ...]:
        """What it is called on the way to what fills it."""
        return (f"cell {self.id}",)

    def __str__(self) -> str:
        return format_title("cell", self.id, self.name)


@dataclass(frozen=True)
class CellGeometry:
    """All of a file, checked: every number that is referred to exists, and nothing contains itself."""

    surfaces: dict[int, OpenmcSurface]
    cells: dict[int, UniverseCell]
    universes: dict[int, list[UniverseCell]]
    lattices: dict[int, Lattice]
    materials: dict[int, OpenmcMaterial] | None  # None where there is no list of materials
    root: int
    counts: dict[UniverseNode, int]  # how many bodies a universe or a lattice has, all that fill it expanded
    element: XmlElement = field(repr=False, compare=False)
    unread: tuple[UnknownName, ...] = ()
    world: Region | None = None  # where the root's cells are to be, where the file says that

    def lattice_of(self, cell: UniverseCell) -> Lattice | None:
        """The lattice that fills a cell; universes come first where both have the number (as in OpenMC)."""
        if cell.fill is None or cell.fill in self.universes:
            return None
        return self.lattices[cell.fill]

    def count(self, universe: int) -> int:
        """How many bodies a universe has."""
        return self.counts["universe", universe]

    def count_in(self, cell: UniverseCell) -> int:
        """How many bodies a cell gives in one place."""
        if cell.fill is None:
            return 1
        return self.counts["universe" if cell.fill in self.universes else "lattice", cell.fill]

    def material(self, number: int) -> OpenmcMaterial:
        """The material of a number; one without a name where there is no list of materials."""
        known = (self.materials or {}).get(number)
        return OpenmcMaterial(number, "", Properties({"id": number})) if known is None else known

    @cached_property
    def material_names(self) -> dict[int, str]:
        """What the material of each number is called, of those that cells have: no two alike, and none "void"."""
        used = {number for cell in self.cells.values() for number in cell.materials[:1] if number is not None}
        given = {number: self.material(number).name or f"material {number}" for number in sorted(used)}
        times = Counter([*given.values(), VOID])
        names: dict[int, str] = {}
        taken = {name for name, count in times.items() if count == 1} | {VOID}
        for number, name in given.items():
            names[number] = name
            while times[name] > 1 and names[number] in {*taken, name}:
                names[number] += f" (material {number})"
            taken.add(names[number])
        return names

    @property
    def body_count(self) -> int:
        """How many bodies there are at most, before those without volume are left out."""
        return self.count(self.root)

    def where_most_are(self, limit: int) -> UniverseCell | Lattice | None:
        """What is filled so that there are more bodies than a limit, the innermost such; None if no filling does it."""
        found: UniverseCell | Lattice | None = None
        universe = self.root
        while self.count(universe) > limit:
            cell = max(self.universes[universe], key=self.count_in)
            lattice = self.lattice_of(cell)
            if cell.fill is None:
                break
            found = cell if lattice is None else lattice
            inside = [cell.fill] if lattice is None else lattice_fillings(lattice)
            universe = max(inside, key=self.count)
        return found


def lattice_fillings(lattice: Lattice) -> Counter[int]:
    """How often each universe stands in a lattice, the outer one counted once."""
    return lattice.tally + Counter([] if lattice.outer is None else [lattice.outer])


# What the boundary conditions of a geometry enclose: particles stay in there, so cells are to fill it.

TRANSMISSION = "transmission"
"""The boundary condition of a surface that particles go through."""


def find_enclosure(geometry: CellGeometry) -> Region | None:
    """The sides of all surfaces with a boundary condition on which the root's cells lie.

    Or what the file says; None where there is no such surface, or where cells lie on both sides of one.
    """
    if geometry.world is not None:
        return geometry.world
    sides: dict[int, bool] = {}
    for cell in geometry.universes[geometry.root]:
        for half in () if cell.region is None else list_half_spaces(cell.region):
            if geometry.surfaces[half.surface].boundary == TRANSMISSION:
                continue
            if sides.setdefault(half.surface, half.positive) != half.positive:
                return None
    parts = tuple(HalfSpaceNode(surface, positive) for surface, positive in sides.items())
    return IntersectionNode(parts) if parts else None


def is_bounded_with(solid: Solid, others: Callable[[], Iterable[BoxEnds]]) -> bool:
    """Has a solid an end wherever all the others, around which there are boxes, have one together?"""
    ends = solid.bounds
    if all(map(math.isfinite, (*ends[0], *ends[1]))):
        return True
    known = enclose_boxes(list(others()))
    pairs = zip((*ends[0], *ends[1]), (*known[0], *known[1]), strict=True)
    return all(math.isfinite(end) or not math.isfinite(other) for end, other in pairs)


# How many bodies universes and lattices have, counted from the innermost outward before anything is expanded.

FillCounts = dict[UniverseNode, Counter[UniverseNode]]


def count_fillings(universes: dict[int, list[UniverseCell]], lattices: dict[int, Lattice]) -> FillCounts:
    """What fills each universe and lattice, and how often; what does not exist is passed over."""
    inside: FillCounts = {}
    for number, cells in universes.items():
        counts: Counter[UniverseNode] = Counter()
        inside["universe", number] = counts
        for cell in cells:
            if cell.fill is not None:
                node = ("universe" if cell.fill in universes else "lattice", cell.fill)
                counts[node] += node[0] == "universe" or cell.fill in lattices
    for number, lattice in lattices.items():
        filled = lattice_fillings(lattice)
        inside["lattice", number] = Counter({("universe", u): times for u, times in filled.items() if u in universes})
    return {node: +counts for node, counts in inside.items()}


def sort_universes(inside: FillCounts) -> list[UniverseNode]:
    """The nodes, each after those that fill it, without recursion; those in circles, and around them, are missing."""
    users: dict[UniverseNode, list[UniverseNode]] = {}
    for node, fills in inside.items():
        for fill in fills:
            users.setdefault(fill, []).append(node)
    waiting = {node: len(fills) for node, fills in inside.items()}
    ready = [node for node, count in waiting.items() if not count]
    order = []
    while ready:
        node = ready.pop()
        order.append(node)
        for user in users.get(node, ()):
            waiting[user] -= 1
            if not waiting[user]:
                ready.append(user)
    return order


def count_bodies(
    universes: dict[int, list[UniverseCell]], inside: FillCounts, order: list[UniverseNode]
) -> dict[UniverseNode, int]:
    """How many bodies each node has, if all are filled as the file says."""
    counts: dict[UniverseNode, int] = {}
    for node in order:
        own = sum(cell.fill is None for cell in universes[node[1]]) if node[0] == "universe" else 0
        counts[node] = own + sum(times * counts[fill] for fill, times in inside[node].items())
    return counts


def nesting_depth(inside: FillCounts, order: list[UniverseNode]) -> int:
    """Levels of universes within universes."""
    depths: dict[UniverseNode, int] = {}
    for node in order:
        below = max((depths[fill] for fill in inside[node]), default=0)
        depths[node] = below + (node[0] == "universe")
    return max(depths.values(), default=0)


def find_circle(inside: FillCounts, order: list[UniverseNode]) -> str:
    """One way round: universe 1 → universe 2 → universe 1; empty if there is none."""
    left = set(inside) - set(order)
    if not left:
        return ""
    node = min(left, key=lambda item: (item[0] != "universe", item[1]))
    way: dict[UniverseNode, None] = {}
    while node not in way:
        way[node] = None
        node = min(fill for fill in inside[node] if fill in left)
    ring = [*list(way)[list(way).index(node) :], node]
    shown = ring if len(ring) <= 20 else ring[:20]
    return " → ".join(f"{kind} {number}" for kind, number in shown) + ("" if shown is ring else " → ...")


# What refuses geometries that would not fit into memory or never be done, in the words of the user's limit.

BYTES_PER_PLACE, BYTES_PER_BODY = 600, 4_000
"""Memory that a body takes while a scene is made ready to trace, if it is another one moved, and if it is not.

Measured on cores of many assemblies of pins.
"""
PLACES_FOR_A_BODY = 1
"""Places outside of lattices that are looked at, most of them in vain perhaps, for each body that is allowed."""
STEPS_FOR_A_BODY, FEWEST_STEPS = 20, 50_000
"""Comparisons of sides for each body that is allowed, and at least so many. Where it is not another one moved, a pin
takes about 20, by hexagons 150."""


def body_limit_error(
    path: str | os.PathLike[str], count: int, max_bodies: int, element: XmlElement, where: str = "", bound: str = ""
) -> SceneFileError:
    """Refuses what expands into `bound` (such as "up to") `count` bodies, with the place where most of them are."""
    most = f", most of them through {where}" if where else ""
    message = (
        f"expands into {bound}{_format_bodies(count)}, {_format_size(count)}{most}; the limit is {max_bodies:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def single_body_limit_error(path: str | os.PathLike[str], count: int, most: int, cell: UniverseCell) -> SceneFileError:
    """Refuses bodies that are worked out one by one."""
    element, size = cell.element, format_bytes(count * BYTES_PER_BODY)
    message = (
        f"has at least {_format_bodies(count)} that are no others moved, {size} in memory; the limit is {most:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def effort_limit_error(path: str | os.PathLike[str], cell: UniverseCell, max_bodies: int) -> SceneFileError:
    """Refuses what has too many sides at too many places."""
    element = cell.element
    message = (
        "stands in regions of so many half-spaces, at so many places, that to compare them takes over "
        f"{max_comparisons(max_bodies):,} steps: raise the limit (max_bodies), or write simpler regions"
    )
    return SceneFileError(path, [Problem(element.line, element.column, str(cell), message)])


def max_comparisons(max_bodies: int) -> int:
    """How many comparisons are allowed."""
    return max(STEPS_FOR_A_BODY * max_bodies, FEWEST_STEPS)


def check_body_count(path: str | os.PathLike[str], geometry: CellGeometry, max_bodies: int) -> None:
    """Raises SceneFileError where there are too many bodies, before any is made."""
    count = geometry.body_count
    if count <= max_bodies:
        return
    most = geometry.where_most_are(max_bodies)
    where = ""
    if isinstance(most, Lattice):
        where = f"{most} of {most.size:,} elements"
    elif most is not None:
        where = f"{most}, which is filled with {_format_bodies(geometry.count_in(most))}"
    raise body_limit_error(path, count, max_bodies, geometry.element if most is None else most.element, where)


def _format_bodies(count: int) -> str:
    """1,234,567 bodies, or a power of ten where that would be longer than a line."""
    return format_count(count, "body", "bodies") if count < 10**66 else f"about 1e{len(str(count)) - 1} bodies"


def _format_size(count: int) -> str:
    if count > 10**66:
        return "more than any memory holds"
    return f"at least {format_bytes(count * BYTES_PER_PLACE)} in memory"
