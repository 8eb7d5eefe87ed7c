"""An OpenMC geometry as bodies, the legend of their colours, and what there is to say about it."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator

from ...shapes.material import Material
from ..errors import SHOWN
from ..imports.imported import Imported, LegendEntry, counted, first_few, only_named
from ..imports.options import Most, Options
from ..nodes import shortened
from .expansion import Expansion, Progress
from .geometry import Geometry
from .palette import color_of
from .reading import read_geometry
from .values import listed


def read(
    path: str | os.PathLike[str], *, void: bool = True, max_bodies: int | None = None, progress: Progress | None = None
) -> Imported:
    """The bodies of an OpenMC geometry: a geometry.xml (with the materials.xml beside it) or a model.xml.

    A cell gives one body for each place where it stands, named such as "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]".
    With `void`, cells without material are bodies too, invisible, so that `scene.body_at` finds every cell.
    progress(done, most) is called with numbers of bodies: first with none done, then now and then.
    Raises `SceneFileError`, a ValueError, that lists the mistakes found with their lines; also for tori and meshes,
    which are no quadrics, and for more than `max_bodies` bodies, which are counted before they are made; if that is
    not given, for more than 4,000,000, or 500,000 that are no others moved.
    """
    geometry = read_geometry(path)
    expansion = Expansion(path, geometry, Most.of(max_bodies), void, progress)
    expansion.run()
    names = _material_names(expansion)
    facts, remarks = tuple(_facts(expansion)), tuple(_remarks(expansion))
    legend = _legend(expansion)
    return Imported(expansion.bodies, legend, facts + remarks, remarks, names, domain=expansion.domain)


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """`read` by the options of all imports."""
    options.refuse_others("an OpenMC geometry", "void", "strict", "only")
    found = read(path, void=options.void, max_bodies=options.max_bodies, progress=options.progress)
    return found if options.only is None else only_named(found, options.only)


def _legend(expansion: Expansion) -> tuple[LegendEntry, ...]:
    geometry, entries = expansion.geometry, []
    given = {number: geometry.material(number).name for number in geometry.material_names}
    names = {number: name for number, name in geometry.material_names.items() if given[number]}
    for number, count in sorted(expansion.materials.items(), key=lambda item: (item[0] is None, item[0] or 0)):
        color = None if number is None else color_of(number)
        entries.append(LegendEntry(number, "" if number is None else names.get(number, ""), color, count))
    return tuple(entries)


def _material_names(expansion: Expansion) -> dict[Material, str]:
    """What a scene file calls each material: material 2 'Zircaloy', as the legend does."""
    geometry, looks = expansion.geometry, expansion.looks
    return {looks[n]: "void" if n is None else str(geometry.material(n)) for n in expansion.materials}


def _facts(expansion: Expansion) -> Iterator[str]:
    """How large the model is, and what changes no shape."""
    geometry = expansion.geometry
    sizes = (
        (geometry.cells, "cell"), (geometry.surfaces, "surface"),
        (geometry.universes, "universe"), (geometry.lattices, "lattice"),
    )  # fmt: skip
    yield ", ".join(counted(len(items), what) for items, what in sizes)
    empty = expansion.left_out.places
    without = f"; {counted(empty, 'place')} without volume left out" if empty else ""
    yield counted(len(expansion.bodies), "body") + without
    yield from _boundaries(geometry)


def _remarks(expansion: Expansion) -> Iterator[str]:
    """What is not as the file says, or may not be meant."""
    geometry = expansion.geometry
    yield from first_few(expansion.left_out.notes(geometry))
    yield from first_few(_cells(geometry))
    yield from first_few(
        f"{geometry.lattices[number]}: the cell around it may reach beyond it, and there is no outer universe"
        for number in sorted(expansion.open_lattices)
    )
    yield from first_few(_names(geometry))
    yield from map(str, geometry.unread[:SHOWN])
    if len(geometry.unread) > SHOWN:
        yield f"... and {len(geometry.unread) - SHOWN:,} more names that are not read"
    yield from _undefined(expansion)
    if geometry.materials is None:
        yield "no list of materials: they are known by number only"


def _names(geometry: Geometry) -> Iterator[str]:
    """Materials that are told apart by more than their names in the file."""
    for number, name in geometry.material_names.items():
        given = geometry.material(number).name
        if given and given != name:
            yield f"{geometry.material(number)}: is called {shortened(name)!r}, since another has its name"


def _undefined(expansion: Expansion) -> Iterator[str]:
    """Where a check of the scene does not look for points in no cell."""
    told, open_ = "undefined regions (points in no cell)", "boundary conditions do not enclose the model"
    if not expansion.void:
        yield f"{told} cannot be looked for: void is left out"
    elif expansion.domain is None:
        yield f"{told} cannot be looked for: {open_}, and no universe fills any of its cells"
    elif not expansion.is_enclosed:
        yield f"{told} can be looked for in filled cells only: {open_}"


def _cells(geometry: Geometry) -> Iterator[str]:
    """What is not done as a cell says."""
    for cell in geometry.cells.values():
        if len(cell.materials) > 1:
            given = listed("void" if material is None else material for material in cell.materials)
            yield f"{cell}: has a material for each place ({given}); the first is taken for all"
        if cell.skew > 1e-9:
            yield f"{cell}: its rotation matrix is {cell.skew:.2g} away from a rotation; it is applied as it is"


def _boundaries(geometry: Geometry) -> Iterator[str]:
    """Boundary conditions are about particles: they change no shape."""
    kinds = Counter(surface.boundary for surface in geometry.surfaces.values())
    for kind in sorted(set(kinds) - {"transmission"}):
        numbers = [surface.id for surface in geometry.surfaces.values() if surface.boundary == kind]
        yield f"boundary {kind}: surface{'s' if len(numbers) > 1 else ''} {listed(numbers)}"
