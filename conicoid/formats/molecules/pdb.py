"""PDB files, by their columns (wwPDB, "Atomic Coordinate Entry Format", version 3.3): atoms, unit cell, CONECT.

Of several models the first is read, of alternate places of an atom that which is named first. The element stands in
columns 77 and 78; where a file has none there, it follows from the atom's name in columns 13 to 16, in which symbols of
one letter begin in 14.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import Problem, SceneFileError
from .atoms import Atoms
from .bonds import bonds_by_distance
from .cells import cell_of
from .elements import number_of

_WIDTH = 80


def read_pdb(path: Path) -> Atoms:
    """The atoms of the first model. Raises SceneFileError with lines."""
    lines = path.read_bytes().splitlines()
    numbers = [k for k, line in enumerate(lines) if line.startswith((b"ATOM  ", b"HETATM"))]
    ends = [k for k, line in enumerate(lines) if line.startswith(b"ENDMDL")]
    remarks = []
    if ends:
        before = len(numbers)
        numbers = [k for k in numbers if k < ends[0]]
        if len(numbers) < before:
            remarks.append("the first of several models is read")
    rows = _columns([lines[k] for k in numbers])
    kept = _first_places(rows)
    if not kept.all():
        remarks.append(f"{int((~kept).sum()):,} alternate places of atoms are left out")
    rows, line_of = rows[kept], np.array(numbers, np.int64)[kept] + 1
    positions = np.column_stack([_floats(path, rows, line_of, begin) for begin in (30, 38, 46)])
    elements = _elements(path, rows, line_of)
    bonds = _connected(lines, rows, positions, elements)
    return Atoms(positions, elements, bonds, _cell(path, lines), _labels(rows), tuple(remarks))


def _columns(lines: list[bytes]) -> Any:
    """(N, 80) bytes of lines, filled with blanks."""
    rows = np.array([line[:_WIDTH] for line in lines], f"S{_WIDTH}").view(np.uint8).reshape(-1, _WIDTH)
    return np.where(rows == 0, ord(" "), rows).astype(np.uint8)


def _texts(rows: Any, begin: int, end: int) -> Any:
    """(N,) texts of columns, counted from 0, without blanks around them."""
    return np.char.strip(np.ascontiguousarray(rows[:, begin:end]).view(f"S{end - begin}").reshape(-1))


def _first_places(rows: Any) -> Any:
    """Which atoms are not alternate places of one before: those with no letter, or the first of their name."""
    letters = rows[:, 16]
    if (letters == ord(" ")).all():
        return np.ones(len(rows), bool)
    whole = np.ascontiguousarray(np.delete(rows[:, 12:27], 4, axis=1)).view("S14").reshape(-1)
    _, first = np.unique(whole, return_index=True)
    kept = letters == ord(" ")
    kept[first] = True
    return kept


def _floats(path: Path, rows: Any, line_of: Any, begin: int) -> Any:
    texts = _texts(rows, begin, begin + 8)
    try:
        found = texts.astype(np.float64)
    except ValueError:
        found = np.array([_number(text) for text in texts.tolist()])
    bad = np.flatnonzero(~np.isfinite(found))
    if len(bad):
        told = texts[bad[0]].decode("utf-8", "replace")
        where = f"columns {begin + 1} to {begin + 8}"
        raise _mistake(path, int(line_of[bad[0]]), f"{where} must be a finite number, got {told!r}")
    return found


def _number(text: bytes) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _elements(path: Path, rows: Any, line_of: Any) -> Any:
    """(N,) atomic numbers."""
    given, names = _texts(rows, 76, 78), np.ascontiguousarray(rows[:, 12:16]).view("S4").reshape(-1)
    keys, place = np.unique(np.char.add(np.char.add(given, b"|"), names), return_inverse=True)
    found = np.zeros(len(keys), np.int64)
    for k, key in enumerate(keys.tolist()):
        symbol, _, name = key.decode("ascii", "replace").partition("|")
        number = number_of(symbol) if symbol else _of_name(name.ljust(4))
        if number is None:
            line = int(line_of[np.flatnonzero(place == k)[0]])
            raise _mistake(path, line, f"columns 77 and 78 must be an element's symbol, got {symbol!r}")
        found[k] = number
    return found[place]


def _of_name(name: str) -> int:
    """The element of an atom's name; 0 where it tells none."""
    first = name[:2].strip(" 0123456789'\"*")
    return number_of(first) or number_of(name.strip(" 0123456789'\"*")[:1]) or 0


def _labels(rows: Any) -> tuple[str, ...]:
    """Such as "CA LEU 12 A": atom, residue, its number and chain."""
    parts = [_texts(rows, *columns) for columns in ((12, 16), (17, 20), (22, 27), (21, 22))]
    joined = parts[0]
    for part in parts[1:]:
        joined = np.char.add(np.char.add(joined, b" "), part)
    return tuple(text.decode("ascii", "replace").strip() for text in joined.tolist())


def _connected(lines: list[bytes], rows: Any, positions: Any, elements: Any) -> Any:
    """Bonds of CONECT records with those by distance; None where there are no records. One told twice is double."""
    told: dict[tuple[int, int], int] = {}
    lines = [line for line in lines if line.startswith(b"CONECT")]
    if not lines:
        return None
    serial = {text: k for k, text in reversed(list(enumerate(_texts(rows, 6, 11).tolist())))}
    for line in lines:
        first = serial.get(line[6:11].strip())
        for begin in range(11, 31, 5):
            other = serial.get(line[begin : begin + 5].strip())
            if first is not None and other is not None and first < other:
                told[first, other] = told.get((first, other), 0) + 1
    for first, other in bonds_by_distance(positions, elements).tolist():
        told.setdefault((first, other), 1)
    return [(first, other, min(order, 3)) for (first, other), order in sorted(told.items())]


def _cell(path: Path, lines: list[bytes]) -> Any:
    """The unit cell of a CRYST1 record; None for none, and for 1 1 1, which stands for none."""
    for k, line in enumerate(lines):
        if line.startswith(b"CRYST1"):
            places = ((6, 15), (15, 24), (24, 33), (33, 40), (40, 47), (47, 54))
            numbers = [_number(line[begin:end]) for begin, end in places]
            if numbers[:3] == [1.0, 1.0, 1.0]:
                return None
            cell = cell_of(*numbers)
            if cell is None:
                raise _mistake(path, k + 1, "CRYST1 must hold three lengths and three angles of a cell")
            return cell
    return None


def _mistake(path: Path, line: int, message: str) -> SceneFileError:
    return SceneFileError(path, [Problem(line, 1, "molecule", message)])
