"""Zemax lens files for `co.load`: the scene of a prescription, by the options of all imports."""

from __future__ import annotations

import os

from ..formats.imports.imported import Imported, counted, only_named
from ..formats.imports.options import Options
from .zmx import load_zmx


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """The bodies of a lens file; its notes tell what was passed over. `load_zmx` gives the prescription itself."""
    options.refuse_others("a Zemax lens file", "strict", "only")
    system = load_zmx(path)
    if len(system.bodies) > options.most.alone:
        raise ValueError(f"load: max_bodies must be at least {len(system.bodies)} for this file")
    first = f"{counted(len(system.rows), 'surface')}, {counted(len(system.bodies), 'body')}"
    found = Imported(system.bodies, (), (first, *system.left_out), system.left_out)
    return found if options.only is None else only_named(found, options.only)
