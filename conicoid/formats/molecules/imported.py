"""A file of a molecule as bodies, by the options of all imports."""

from __future__ import annotations

import os

import numpy as np

from ..imports.imported import Imported, LegendEntry, counted
from ..imports.options import Options
from .elements import COLORS, SYMBOLS
from .files import read_atoms
from .styles import Look, bodies_of

MANY = 20_000
"""Atoms that are shown as balls alone: bonds could not be told apart."""


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """Balls and sticks, or balls of van der Waals' radii where there are many atoms; and the cell of a crystal."""
    options.refuse_others("a molecule", "strict")
    atoms = read_atoms(path)
    look = Look("ball and stick" if len(atoms) <= MANY else "space filling", {}, {})
    bodies = bodies_of(atoms, look, True)
    made = len(atoms) + (0 if look.style == "space filling" else 2 * len(atoms.bonds))
    if options.max_bodies is not None and made > options.max_bodies:
        raise ValueError(f"{os.fspath(path)}: {counted(made, 'body')}, more than max_bodies = {options.max_bodies:,}")
    legend = []
    for number, count in zip(*np.unique(atoms.numbers, return_counts=True), strict=True):
        legend.append(LegendEntry(None, SYMBOLS[number], COLORS[number], int(count)))
    facts = (f"{counted(len(atoms), 'atom')}: {atoms.formula:.200}", f"shown in the style {look.style!r}")
    names = {material: material.name for body in bodies for material in (body.materials or ()) if material.name}
    return Imported(bodies, tuple(legend), (*facts, *atoms.remarks), atoms.remarks, names)
