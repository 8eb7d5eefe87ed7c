"""A deck as bodies, the legend of their colours, and what there is to say about it."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator

from ..errors import printable
from ..imports.imported import Imported, LegendEntry, counted, first_few, only_named
from ..imports.options import Options
from ..nodes import shortened
from ..openmc.expansion import Expansion
from ..openmc.geometry import VOID, Geometry
from ..openmc.palette import color_of
from ..openmc.values import listed
from .reading import Read, read_deck


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """A cell gives one body for each place where it stands, such as "cell 5 @ cell 9, cell 2, lattice [3, 4, 0]".

    Raises `SceneFileError`, a ValueError, that lists the mistakes found with their lines; also for tori, which are no
    quadrics, and for more bodies than `options` allows, which are counted before they are made.
    """
    options.refuse_others("an MCNP deck", "void", "strict", "only")
    deck = read_deck(path)
    expansion = Expansion(path, deck.geometry, options.most, options.void, options.progress)
    expansion.run()
    remarks = (*deck.remarks, *_remarks(expansion))
    notes = (*_facts(deck, expansion), *deck.notes, *remarks)
    geometry, looks = deck.geometry, expansion.looks
    names = {looks[n]: VOID if n is None else geometry.material_names[n] for n in expansion.materials}
    found = Imported(expansion.bodies, _legend(expansion), notes, remarks, names, domain=expansion.domain)
    return found if options.only is None else only_named(found, options.only)


def _legend(expansion: Expansion) -> tuple[LegendEntry, ...]:
    geometry, entries = expansion.geometry, []
    for key, count in sorted(expansion.materials.items(), key=lambda item: (item[0] is None, item[0] or 0)):
        if key is None:
            entries.append(LegendEntry(None, "", None, count))
        else:
            entries.append(LegendEntry(geometry.material(key).id, geometry.material_names[key], color_of(key), count))
    return tuple(entries)


def _facts(deck: Read, expansion: Expansion) -> Iterator[str]:
    """How large the model is, and what changes no shape."""
    geometry = deck.geometry
    if deck.title:
        yield f"title: {printable(shortened(deck.title, 80))}"
    numbers = {surface.id for surface in geometry.surfaces.values()}
    cells = [cell for cell in geometry.cells.values() if cell.step]
    universes = {cell.universe for cell in cells}
    sizes = ((cells, "cell"), (numbers, "surface"), (universes, "universe"), (geometry.lattices, "lattice"))
    yield ", ".join(counted(len(items), what) for items, what in sizes)
    empty = expansion.left_out.places
    without = f"; {counted(empty, 'place')} without volume left out" if empty else ""
    yield counted(len(expansion.bodies), "body") + without
    yield from _boundaries(geometry)


def _boundaries(geometry: Geometry) -> Iterator[str]:
    """Boundary conditions are about particles: they change no shape."""
    kinds = Counter(surface.boundary for surface in geometry.surfaces.values())
    for kind in sorted(set(kinds) - {"transmission"}):
        numbers = sorted({surface.id for surface in geometry.surfaces.values() if surface.boundary == kind})
        yield f"boundary {kind}: surface{'s' if len(numbers) > 1 else ''} {listed(numbers)}"


def _remarks(expansion: Expansion) -> Iterator[str]:
    """What is not as the file says, or may not be meant."""
    geometry = expansion.geometry
    yield from first_few(expansion.left_out.notes(geometry))
    yield from first_few(
        f"{geometry.lattices[key]}: the cell around it may reach beyond it, where nothing is"
        for key in sorted(expansion.open_lattices)
    )
    if expansion.void and geometry.world is None:
        yield "no cell outside of universes has importance 0: it is not known where the model ends"
    elif expansion.void and not expansion.is_enclosed:
        yield "the cells of importance 0 leave the model open on some side"
