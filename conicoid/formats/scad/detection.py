"""Whether a file is OpenSCAD's: by its suffix, or by its first call."""

from __future__ import annotations

import re

_CALLS = "group|multmatrix|union|difference|intersection|color|cube|sphere|cylinder|polyhedron|linear_extrude|"
_CALLS += "rotate_extrude|hull|minkowski|render"
_FIRST = re.compile(rf"\A\ufeff?(\s|//[^\n]*\n|/\*.*?\*/)*[%#!*]?({_CALLS})\s*\(", re.S)


def is_csg(head: str, suffix: str) -> bool:
    """Is a text one, by its first call, or by the name of the file?"""
    return suffix in (".csg", ".scad") or _FIRST.match(head) is not None
