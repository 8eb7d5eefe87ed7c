"""A GDML file as bodies, by the options of all imports."""

from __future__ import annotations

import os
from collections.abc import Iterator

from ..imports.imported import Imported, LegendEntry, counted, first_few, only_named
from ..imports.options import Options
from .expansion import DEEPEST, Expansion
from .geometry import Geometry, read_geometry, remarks_of
from .materials import THIN


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """Each volume at each of its places is a body, less the volumes in it, named by the path to it."""
    options.refuse_others("a GDML file", "void", "strict", "only", "depth", "entities")
    geometry = read_geometry(path, options.entities)
    levels = DEEPEST + 1 if options.depth is None else options.depth
    expansion = Expansion(geometry, options.void, levels, options.most, options.progress)
    expansion.run()
    facts, remarks = tuple(_facts(geometry, expansion)), tuple(_remarks(geometry))
    names = {
        expansion.looks[material]: "no material" if material is None else material.title
        for material in expansion.materials
    }
    found = Imported(expansion.bodies, _legend(expansion), facts + remarks, remarks, names)
    return found if options.only is None else only_named(found, options.only)


def _legend(expansion: Expansion) -> tuple[LegendEntry, ...]:
    entries = []
    for material, count in sorted(expansion.materials.items(), key=lambda item: item[0].number if item[0] else 0):
        if material is None:
            entries.append(LegendEntry(None, "no material", None, count))
        else:
            entries.append(LegendEntry(material.number, material.name, material.color, count))
    return tuple(entries)


def _facts(geometry: Geometry, expansion: Expansion) -> Iterator[str]:
    structures = [geometry.structure]
    solids, volumes = (sum(len(part) for part in parts) for parts in (
        [one.solids for one in structures], [one.volumes for one in structures],
    ))  # fmt: skip
    files = f", {counted(len(geometry.modules), 'module')}" if geometry.modules else ""
    yield f"{counted(solids, 'solid')}, {counted(volumes, 'volume')}{files}"
    filled = f"; {counted(expansion.filled, 'volume')} that others fill left out" if expansion.filled else ""
    yield counted(len(expansion.bodies), "body") + filled
    thin = [material.name for material in expansion.materials if material is not None and material.is_thin]
    if thin:
        yield f"invisible, gases and what is thinner than {THIN:g} g/cm3: {', '.join(thin[:8])}"


def _remarks(geometry: Geometry) -> Iterator[str]:
    """What is left out or not as it says, the first few of each kind."""
    for remarks in remarks_of(geometry):
        yield from first_few(remarks)
