"""Cell geometries of OpenMC and MCNP as read from a file, their counts of bodies, and their limits.

`CellGeometry` holds surfaces, cells, universes and lattices, which refer to each other by number. Bodies are counted
from the innermost universe outward before anything is expanded, so that geometries which would not fit into memory are
refused at once.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from dataclasses import field
from functools import cached_property
from typing import TypeVar

from ..._util.arrays import BoxEnds
from ..._util.files import Problem, SceneFileError
from ..._util.records import dataclass
from ..._util.text import format_bytes, format_count
from ...geometry.bounds.aabb import enclose_boxes
from ...geometry.shape import Solid
from ...materials.material import Properties
from ..xml_tree import XmlElement
from .lattices import Lattice
from .placement import NO_ROTATION, CellRotation, Point
from .region_expression import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from .surfaces import OpenmcSurface
from .values import OpenmcMaterial, UnknownName, format_title, join_limited

VOID = "void"
"""Name of the material of empty cells."""
UniverseNode = tuple[str, int]
"""A universe or a lattice with its number, such as ("universe", 3)."""


@dataclass(frozen=True)
class UniverseCell:
    """A cell: a region of a universe, with materials (None is void) or filled with a universe or lattice.

    `region` is None for all of space. The filling is rotated, then translated (cm).
    """

    id: int
    name: str
    universe: int
    region: Region | None
    fill: int | None
    materials: tuple[int | None, ...]
    translation: Point
    rotation: CellRotation
    skew: float  # distance of the file's matrix from a rotation
    element: XmlElement = field(repr=False, compare=False)

    @property
    def is_rotated(self) -> bool:
        """True if the filling is rotated."""
        return self.rotation != NO_ROTATION

    @property
    def step(self) -> tuple[str, ...]:
        """The part that the cell adds to the paths of its content."""
        return (f"cell {self.id}",)

    def __str__(self) -> str:
        return format_title("cell", self.id, self.name)


@dataclass(frozen=True)
class CellGeometry:
    """A checked geometry: every number that something refers to exists, and no universe contains itself."""

    surfaces: dict[int, OpenmcSurface]
    cells: dict[int, UniverseCell]
    universes: dict[int, list[UniverseCell]]
    lattices: dict[int, Lattice]
    materials: dict[int, OpenmcMaterial] | None  # None if the file has no list of materials
    root: int  # number of the root universe
    counts: dict[UniverseNode, int]  # bodies of a universe or lattice with all its content expanded
    element: XmlElement = field(repr=False, compare=False)
    unread: tuple[UnknownName, ...] = ()
    left_out: tuple[str, ...] = ()  # remarks about cells and universes that are left out
    world: Region | None = None  # region that the root's cells must fill, if the file defines it

    def lattice_of(self, cell: UniverseCell) -> Lattice | None:
        """Return the lattice that fills a cell, or None.

        If a universe and a lattice have the same number, the universe fills the cell, as in OpenMC.
        """
        if cell.fill is None or cell.fill in self.universes:
            return None
        return self.lattices[cell.fill]

    def count(self, universe: int) -> int:
        """Return the number of bodies of a universe."""
        return self.counts["universe", universe]

    def count_in(self, cell: UniverseCell) -> int:
        """Return the number of bodies of a cell at one place."""
        if cell.fill is None:
            return 1
        return self.counts["universe" if cell.fill in self.universes else "lattice", cell.fill]

    def material(self, number: int) -> OpenmcMaterial:
        """Return the material with a number; a nameless one if the file does not list it."""
        found = (self.materials or {}).get(number)
        return OpenmcMaterial(number, "", Properties({"id": number})) if found is None else found

    @cached_property
    def material_names(self) -> dict[int, str]:
        """Unique names, none of them "void", of the materials that cells have, by number."""
        used = {number for cell in self.cells.values() for number in cell.materials[:1] if number is not None}
        listed = {number: self.material(number).name or f"material {number}" for number in sorted(used)}
        times = Counter([*listed.values(), VOID])
        names: dict[int, str] = {}
        used_names = {name for name, count in times.items() if count == 1} | {VOID}
        for number, name in listed.items():
            names[number] = name
            # A name with a number in it may be another material's name
            while times[name] > 1 and names[number] in {*used_names, name}:
                names[number] += f" (material {number})"
            used_names.add(names[number])
        return names

    @property
    def body_count(self) -> int:
        """The number of bodies before places without volume are left out."""
        return self.count(self.root)

    def where_most_are(self, limit: int) -> UniverseCell | Lattice | None:
        """Return the innermost cell or lattice whose filling has more bodies than a limit; None if none has."""
        innermost: UniverseCell | Lattice | None = None
        universe = self.root
        while self.count(universe) > limit:
            cell = max(self.universes[universe], key=self.count_in)
            lattice = self.lattice_of(cell)
            if cell.fill is None:
                break
            innermost = cell if lattice is None else lattice
            inside = [cell.fill] if lattice is None else lattice_fillings(lattice)
            universe = max(inside, key=self.count)
        return innermost


def lattice_fillings(lattice: Lattice) -> Counter[int]:
    """Return how often each universe stands in a lattice; the outer universe adds one."""
    return lattice.tally + Counter([] if lattice.outer is None else [lattice.outer])


def omission_notes(omitted: Mapping[int, str]) -> Iterator[str]:
    """Yield a remark for each reason why cells are left out; `omitted` has the reasons by the numbers of cells."""
    groups: dict[str, list[int]] = {}
    for number in sorted(omitted):
        groups.setdefault(omitted[number], []).append(number)
    for reason, cells in groups.items():
        yield f"{reason}: cell{'s' if len(cells) > 1 else ''} {join_limited(cells)} left out"


# The enclosure of boundary conditions: particles stay in it, so cells must fill it.

TRANSMISSION = "transmission"
"""The boundary condition of a surface that particles cross."""


def find_enclosure(geometry: CellGeometry) -> Region | None:
    """Return the region that boundary conditions enclose, or the world region that the file defines.

    This is the intersection of the sides, on which the root's cells lie, of all surfaces with a boundary condition.
    None if there is no such surface, or if cells lie on both sides of one.
    """
    if geometry.world is not None:
        return geometry.world
    sides: dict[int, bool] = {}
    for cell in geometry.universes[geometry.root]:
        for half in () if cell.region is None else list_half_spaces(cell.region):
            if geometry.surfaces[half.surface].boundary == TRANSMISSION:
                continue
            # Particles that come from the other side are not kept out, so the surface encloses nothing
            if sides.setdefault(half.surface, half.positive) != half.positive:
                return None
    parts = tuple(HalfSpaceNode(surface, positive) for surface, positive in sides.items())
    return IntersectionNode(parts) if parts else None


def is_bounded_with(solid: Solid, others: Callable[[], Iterable[BoxEnds]]) -> bool:
    """Return True if a solid is bounded in every direction in which the union of other boxes is bounded."""
    ends = solid.bounds
    if all(map(math.isfinite, (*ends[0], *ends[1]))):
        return True
    box = enclose_boxes(list(others()))
    pairs = zip((*ends[0], *ends[1]), (*box[0], *box[1]), strict=True)
    return all(math.isfinite(end) or not math.isfinite(other) for end, other in pairs)


# Counts of bodies in universes and lattices

FillCounts = dict[UniverseNode, Counter[UniverseNode]]
"""For each node, how often other nodes fill it."""


def count_fillings(universes: dict[int, list[UniverseCell]], lattices: dict[int, Lattice]) -> FillCounts:
    """Return how often universes and lattices fill each universe and lattice; numbers that do not exist are skipped."""
    inside: FillCounts = {}
    for number, cells in universes.items():
        counts: Counter[UniverseNode] = Counter()
        inside["universe", number] = counts
        for cell in cells:
            if cell.fill is not None:
                node = ("universe" if cell.fill in universes else "lattice", cell.fill)
                # A filling that does not exist is reported when its cell is checked
                counts[node] += node[0] == "universe" or cell.fill in lattices
    for number, lattice in lattices.items():
        filled = lattice_fillings(lattice)
        inside["lattice", number] = Counter({("universe", u): times for u, times in filled.items() if u in universes})
    return {node: +counts for node, counts in inside.items()}


_Key = TypeVar("_Key", bound=Hashable)


def topological_order(needs: Mapping[_Key, Collection[_Key]]) -> list[_Key]:
    """Return the keys in an order in which each is after those that it needs; keys that contain circles are missing.

    This is a loop in place of a recursion, as needs may nest deeply.
    """
    users: dict[_Key, list[_Key]] = {}
    for user, others in needs.items():
        for other in others:
            users.setdefault(other, []).append(user)
    waiting = {key: len(others) for key, others in needs.items()}
    # Reversed for `pop`, so that keys without needs keep their order
    ready = [key for key in reversed([*needs]) if not waiting[key]]
    order = []
    while ready:
        key = ready.pop()
        order.append(key)
        for user in users.get(key, ()):
            waiting[user] -= 1
            if not waiting[user]:
                ready.append(user)
    return order


def count_bodies(
    universes: dict[int, list[UniverseCell]], inside: FillCounts, order: list[UniverseNode]
) -> dict[UniverseNode, int]:
    """Return the number of bodies of each node, all fillings expanded."""
    counts: dict[UniverseNode, int] = {}
    for node in order:
        own = sum(cell.fill is None for cell in universes[node[1]]) if node[0] == "universe" else 0
        counts[node] = own + sum(times * counts[fill] for fill, times in inside[node].items())
    return counts


def nesting_depth(inside: FillCounts, order: list[UniverseNode]) -> int:
    """Return the number of levels of universes within universes."""
    depths: dict[UniverseNode, int] = {}
    for node in order:
        below = max((depths[fill] for fill in inside[node]), default=0)
        depths[node] = below + (node[0] == "universe")
    return max(depths.values(), default=0)


def find_circle(inside: FillCounts, order: list[UniverseNode]) -> str:
    """Return one circle, such as "universe 1 → universe 2 → universe 1"; empty if there is none."""
    cyclic = set(inside) - set(order)
    if not cyclic:
        return ""
    # Every node left has a filling that is left, so this walk must come back to one of its nodes.
    node = min(cyclic, key=lambda item: (item[0] != "universe", item[1]))
    walk: dict[UniverseNode, None] = {}
    while node not in walk:
        walk[node] = None
        node = min(fill for fill in inside[node] if fill in cyclic)
    ring = [*list(walk)[list(walk).index(node) :], node]
    shown = ring if len(ring) <= 20 else ring[:20]
    return " → ".join(f"{kind} {number}" for kind, number in shown) + ("" if shown is ring else " → ...")


# Limits: errors for geometries that would not fit into memory or take too long, in terms of the user's limit

BYTES_PER_PLACE, BYTES_PER_BODY = 600, 4_000
"""Memory of a body during preparation, in bytes, for a translated copy and for any other body.

Measured on cores of many assemblies of pins.
"""
PLACES_FOR_A_BODY = 1
"""Most places outside lattices that are examined, for each body that the limit allows; many may be empty."""
STEPS_FOR_A_BODY, FEWEST_STEPS = 20, 50_000
"""Most comparisons of sides for each body that the limit allows, and a lower bound on that limit. A pin that is no
translated copy takes about 20 comparisons, in hexagonal lattices 150."""


def body_limit_error(
    path: str | os.PathLike[str], count: int, max_bodies: int, element: XmlElement, where: str = "", bound: str = ""
) -> SceneFileError:
    """Return the error for an expansion into too many bodies.

    Parameters
    ----------
    path
        The file.
    count
        The number of bodies.
    max_bodies
        The limit.
    element
        The element that the error refers to.
    where
        The cell or lattice with most of the bodies.
    bound
        Text before the count, such as "up to ".

    """
    most = f", most of them through {where}" if where else ""
    message = (
        f"expands into {bound}{_format_bodies(count)}, {_format_size(count)}{most}; the limit is {max_bodies:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def single_body_limit_error(path: str | os.PathLike[str], count: int, most: int, cell: UniverseCell) -> SceneFileError:
    """Return the error for too many bodies that are no translated copies."""
    element, size = cell.element, format_bytes(count * BYTES_PER_BODY)
    message = (
        f"has at least {_format_bodies(count)} that are no others moved, {size} in memory; the limit is {most:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def effort_limit_error(path: str | os.PathLike[str], cell: UniverseCell, max_bodies: int) -> SceneFileError:
    """Return the error for a cell whose regions have too many sides at too many places."""
    element = cell.element
    message = (
        "stands in regions of so many half-spaces, at so many places, that to compare them takes over "
        f"{max_comparisons(max_bodies):,} steps: raise the limit (max_bodies), or write simpler regions"
    )
    return SceneFileError(path, [Problem(element.line, element.column, str(cell), message)])


def max_comparisons(max_bodies: int) -> int:
    """Return the largest number of comparisons of sides."""
    return max(STEPS_FOR_A_BODY * max_bodies, FEWEST_STEPS)


def check_body_count(path: str | os.PathLike[str], geometry: CellGeometry, max_bodies: int) -> None:
    """Raise SceneFileError if there are too many bodies, before any is built."""
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
    """Return a text such as "1,234,567 bodies"; a power of ten for numbers that are longer than a line."""
    return format_count(count, "body", "bodies") if count < 10**66 else f"about 1e{len(str(count)) - 1} bodies"


def _format_size(count: int) -> str:
    if count > 10**66:
        return "more than any memory holds"
    return f"at least {format_bytes(count * BYTES_PER_PLACE)} in memory"
