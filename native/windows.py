"""An import library for Windows: the functions of python3.dll that the extension takes, by the names in python.h."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

HEADER = Path(__file__).with_name("python.h")
_DECLARED = re.compile(r"^PYTHON ([^;]+);", re.MULTILINE)
_FUNCTION = re.compile(r"(\w+)\(")


def stable_names() -> tuple[set[str], set[str]]:
    """Return the functions and the objects of Python's stable ABI that python.h declares."""
    functions, objects = set(), set()
    for declared in _DECLARED.findall(HEADER.read_text(encoding="utf-8")):
        found = _FUNCTION.search(declared)
        if found:
            functions.add(found[1])
        else:
            objects |= {part.split()[-1].lstrip("*") for part in declared.split(",")}
    return functions, objects


def import_library(folder: Path) -> Path:
    """Make the import library in a folder."""
    functions, objects = stable_names()
    names = [*sorted(functions), *(f"{name} DATA" for name in sorted(objects))]
    definition, library = folder / "python3.def", folder / "python3.lib"
    definition.write_text("\n".join(["LIBRARY python3.dll", "EXPORTS", *names, ""]), encoding="utf-8")
    tool = [sys.executable, "-m", "ziglang", "dlltool", "-m", "i386:x86-64", "-d", str(definition), "-l", str(library)]
    subprocess.run(tool, check=True)
    return library
