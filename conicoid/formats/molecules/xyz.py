"""XYZ files: how many atoms, a comment, and a line for each atom: symbol (or number), x, y, z in Å.

The comment of an extended file may say `Lattice="ax ay az bx by bz cx cy cz"`. Of several frames the first is read.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import Problem, SceneFileError
from .atoms import Atoms
from .elements import SYMBOLS, number_of

_LATTICE = re.compile(r"\blattice\s*=\s*(?:\"([^\"]*)\"|'([^']*)'|\{([^}]*)\})", re.I)


def read_xyz(path: Path) -> Atoms:
    """The atoms of the first frame. Raises SceneFileError with lines."""
    with open(path, encoding="utf-8", errors="replace") as file:
        head = [file.readline(), file.readline()]
        count = int(head[0]) if re.fullmatch(r"\s*\d{1,9}\s*", head[0]) else None
        if count is None:
            raise _mistake(path, 1, "the number of atoms must stand here, alone")
        lines = [line for line, _ in zip(file, range(count), strict=False)]
        more = any(line.strip() for line in file)
    if len(lines) < count:
        raise _mistake(path, len(lines) + 3, f"must be atom {len(lines) + 1} of {count}, and is the end of the file")
    rows = [line.split(None, 4)[:4] for line in lines]
    short = next((k for k, row in enumerate(rows) if len(row) < 4), None)
    if short is not None:
        raise _mistake(path, short + 3, f"must be a symbol and three numbers, got {lines[short].strip()!r:.80}")
    positions = _numbers(path, rows)
    numbers = _elements(path, [row[0] for row in rows])
    return Atoms(positions, numbers, cell=_cell(path, head[1]), remarks=_remarks(more))


def _remarks(more: bool) -> tuple[str, ...]:
    return ("the first of several frames is read",) if more else ()


def _numbers(path: Path, rows: list[list[str]]) -> Any:
    """(N, 3) places."""
    try:
        columns = [np.array([row[k] for row in rows], np.float64) for k in (1, 2, 3)]
        found = np.stack(columns, axis=1)
    except ValueError:
        found = None
    if found is not None and np.isfinite(found).all():
        return found
    for k, row in enumerate(rows):
        for text in row[1:]:
            if not _is_number(text):
                raise _mistake(path, k + 3, f"x, y and z must be finite numbers, got {text!r:.40}")
    return found


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _elements(path: Path, texts: list[str]) -> Any:
    """(N,) atomic numbers."""
    known = {text: number_of(text) for text in set(texts)}
    for text in known:
        if known[text] is None and text.isdecimal() and int(text[:4]) < len(SYMBOLS):
            known[text] = int(text)
    wrong = next((k for k, text in enumerate(texts) if known[text] is None), None)
    if wrong is not None:
        raise _mistake(path, wrong + 3, f"must begin with an element's symbol or number, got {texts[wrong]!r:.40}")
    return np.array([known[text] for text in texts], np.int64)


def _cell(path: Path, comment: str) -> Any:
    """The unit cell that a comment says; None where it says none."""
    found = _LATTICE.search(comment)
    if found is None:
        return None
    words = (found[1] or found[2] or found[3] or "").split()
    if len(words) != 9 or not all(_is_number(word) for word in words):
        raise _mistake(path, 2, f"Lattice must be nine finite numbers, got {' '.join(words)!r:.80}")
    return np.array([float(word) for word in words]).reshape(3, 3)


def _mistake(path: Path, line: int, message: str) -> SceneFileError:
    return SceneFileError(path, [Problem(line, 1, "molecule", message)])
