"""From cells in universes in lattices to bodies that stand in the world, one for each place of each cell."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from ...shapes.body import Body
from ...shapes.material import Material, matte
from ..errors import Problem, SceneFileError
from .context import Context
from .geometry import Cell, Geometry
from .lattices import Index, Lattice
from .narrowing import bound
from .palette import color_of
from .placement import Placement
from .region import halves
from .solids import SolidMaker
from .surfaces import Surface

BYTES_PER_BODY = 16_000
"""Memory that a body takes in a scene that is made ready to trace, measured on assemblies of pins."""
TILES_FOR_A_BODY = 8
VOID = Material((0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0)
"""Invisible: light goes straight through."""

Path = tuple[str, ...]
Progress = Callable[[int, int], None]


def too_many(path: str | os.PathLike[str], count: str, number: int, max_bodies: int) -> SceneFileError:
    """What refuses a geometry that would not fit."""
    size = f"about {number * BYTES_PER_BODY / 1e9:,.3g} GB"
    message = f"expands into {count} bodies, {size} in memory; the limit is {max_bodies:,} (max_bodies)"
    return SceneFileError(path, [Problem(0, 0, "geometry", message)])


@dataclass
class Expansion:
    """Expands one geometry into `bodies`, and counts what it finds on the way."""

    path: str | os.PathLike[str]
    geometry: Geometry
    max_bodies: int
    void: bool
    progress: Progress | None = None
    bodies: list[Body] = field(default_factory=list)
    materials: Counter[int | None] = field(default_factory=Counter)
    empty: int = 0  # places without volume
    open_lattices: set[int] = field(default_factory=set)  # without an outer universe, in cells that reach beyond
    maker: SolidMaker = field(default_factory=SolidMaker)
    looks: dict[int | None, Material] = field(default_factory=lambda: {None: VOID})

    def run(self) -> None:
        """Raises SceneFileError where there are too many bodies, or a number leaves the range of float64."""
        count = self.geometry.body_count
        if count > self.max_bodies:
            raise too_many(self.path, f"{count:,}", count, self.max_bodies)
        if self.progress is not None:
            self.progress(0, count)
        self._universe(self.geometry.root, Placement(), Context(), ())

    def _universe(self, number: int, place: Placement, context: Context, path: Path) -> None:
        surfaces = _Placed(self.geometry, place)
        for cell in self.geometry.universes[number]:
            parts = () if cell.region is None else (bound(cell.region, surfaces),)
            inner = context.and_(place.outer, parts)
            if inner is None:
                self.empty += 1
            elif cell.fill is None:
                self._body(cell, inner, path)
            else:
                self._filled(cell, place.inner(cell.translation, cell.rotation), inner, (*path, f"cell {cell.id}"))

    def _filled(self, cell: Cell, place: Placement, context: Context, path: Path) -> None:
        """What fills a cell, within the cell."""
        lattice = self.geometry.lattice_of(cell)
        if lattice is None:
            assert cell.fill is not None
            self._universe(cell.fill, place, context, path)
            return
        for index, universe in lattice.universes.items():
            self.empty += not self._element(lattice, index, universe, place, context, path)
        outside = context.and_(place.outer, [prism.placed(place).outside() for prism in lattice.hull])
        if outside is None:
            return
        if lattice.outer is None:
            self.open_lattices.add(lattice.id)
        elif _repeats(self.geometry, lattice.outer, lattice):
            center = lattice.center(next(iter(lattice.universes)))
            self._universe(lattice.outer, place.inner(center), outside, (*path, f"lattice {lattice.id} outer"))
        else:
            self._tiles(cell, lattice, lattice.outer, place, outside, path)

    def _element(
        self, lattice: Lattice, index: Index, universe: int, place: Placement, context: Context, path: Path
    ) -> bool:
        """One element with its universe; false where nothing of it is in the context."""
        prism = lattice.prism(index).placed(place)
        inner = context.and_(place.outer, prism.sides(), prism.extent)
        if inner is not None:
            step = f"lattice {lattice.id} [{', '.join(map(str, index))}]"
            self._universe(universe, place.inner(lattice.center(index)), inner, (*path, step))
        return inner is not None

    def _tiles(self, cell: Cell, lattice: Lattice, outer: int, place: Placement, context: Context, path: Path) -> None:
        """The outer universe, element by element, as far as the cell around the lattice reaches."""
        indices = lattice.indices_around(context.extent_before(place.outer).placed(place.back))
        if indices is None:
            message = (
                "must be bounded on all sides by planes across the axes, spheres or cylinders, because the outer "
                f"universe {outer} of {lattice} that fills it is repeated without end"
            )
            raise self._wrong(cell, str(cell), message)
        for count, index in enumerate(indices):
            if count > TILES_FOR_A_BODY * self.max_bodies:
                raise too_many(self.path, f"over {count:,}", count, self.max_bodies)
            if index not in lattice.universes:
                self._element(lattice, index, outer, place, context, path)

    def _body(self, cell: Cell, context: Context, path: Path) -> None:
        material = cell.materials[0]
        if material is None and not self.void:
            return
        if len(self.bodies) >= self.max_bodies:
            raise too_many(self.path, f"more than {self.max_bodies:,}", self.max_bodies, self.max_bodies)
        name = f"{cell} @ {', '.join(path)}" if path else str(cell)
        try:
            shape = self.maker.solid((motion, group.parts) for motion, group in context.groups)
        except (OverflowError, ValueError) as error:
            raise self._wrong(cell, name, f"cannot be expressed in double precision: {error}") from None
        if material is not None and material not in self.looks:
            self.looks[material] = matte(color_of(material))
        self.bodies.append(Body(shape, self.looks[material], name))
        self.materials[material] += 1
        if self.progress is not None and len(self.bodies) % 256 == 0:
            self.progress(len(self.bodies), self.geometry.body_count)

    def _wrong(self, cell: Cell, where: str, message: str) -> SceneFileError:
        return SceneFileError(self.path, [Problem(cell.element.line, cell.element.column, where, message)])


class _Placed(dict[int, Surface]):
    """The surfaces of a geometry at a place, moved there when first asked for."""

    def __init__(self, geometry: Geometry, place: Placement) -> None:
        super().__init__()
        self.geometry = geometry
        self.place = place

    def __missing__(self, number: int) -> Surface:
        self[number] = self.geometry.surfaces[number].surface.placed(self.place)
        return self[number]


def _repeats(geometry: Geometry, universe: int, lattice: Lattice) -> bool:
    """Whether a universe surely looks the same after every step from element to element.

    It does if all surfaces in it do; then its place among the elements does not matter.
    """
    surfaces: set[int] = set()
    seen, pending, turned = {universe}, [universe], False
    while pending:
        for cell in geometry.universes[pending.pop()]:
            if geometry.lattice_of(cell) is not None:
                return False
            turned = turned or cell.is_rotated
            if cell.region is not None:
                surfaces |= {half.surface for half in halves(cell.region)}
            if cell.fill is not None and cell.fill not in seen:
                seen.add(cell.fill)
                pending.append(cell.fill)
    if turned and surfaces:
        return False
    found = [geometry.surfaces[number].surface for number in surfaces]
    return all(surface.placed(Placement(shift=step)) == surface for surface in found for step in lattice.steps)
