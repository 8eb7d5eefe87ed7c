"""The bodies of a prescription, and which of their faces light meets at which row."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..shapes.base import Shape
from ..shapes.body import Body
from ..shapes.conic import ConicSheet
from ..shapes.lens import Lens
from ..shapes.looks import matte, mirror
from ..shapes.stop import Stop

if TYPE_CHECKING:
    from .prescriptions import Prescription

FRONT, BACK = 0, 1
_SCREEN = 1.5
"""How much wider than the widest surface, and than its opening, the screen of a stop is."""


@dataclass(frozen=True)
class Elements:
    """`bodies`, and for each row the (body, face) pairs that light may meet there; none for a mere plane in air."""

    bodies: tuple[Body, ...]
    faces: tuple[tuple[tuple[int, int], ...], ...]


def elements_of(system: Prescription) -> Elements:
    """Lenses between neighbouring rows with glass between them, mirrors, and a screen around a stop in air."""
    bodies: list[Body] = []
    faces: list[list[tuple[int, int]]] = [[] for _ in system.rows]
    lenses, mirrors = itertools.count(1), itertools.count(1)
    for i, row in enumerate(system.rows):
        if row.reflects:
            if not system.media[i].is_air:
                raise ValueError(f"prescription: rows[{i}]: a mirror in glass (a Mangin mirror) is not supported")
            faces[i].append((len(bodies), 0))
            bodies.append(Body(sheet_of(system, i), mirror(), f"mirror {next(mirrors)}"))
        elif not system.media[i + 1].is_air:
            _check_element(system, i)
            first, second = (FRONT, BACK) if (row.thickness or 0.0) > 0 else (BACK, FRONT)
            faces[i].append((len(bodies), first))
            faces[i + 1].append((len(bodies), second))
            bodies.append(Body(_lens(system, i), system.media[i + 1].material(), f"lens {next(lenses)}"))
        elif row.stop and system.media[i].is_air:
            opening = system.diameters[i]
            screen = Stop(opening, _SCREEN * max(opening, *system.diameters))
            bodies.append(Body(_at(screen, system, i), matte("black"), "stop"))
    return Elements(tuple(bodies), tuple(map(tuple, faces)))


def sheet_of(system: Prescription, i: int, *, whole: bool = False) -> ConicSheet:
    """The surface of a row as an open sheet; `whole` without its hole."""
    row = system.rows[i]
    sheet = ConicSheet(row.radius, row.conic, system.diameters[i], 0.0 if whole else row.hole)
    placed: ConicSheet = _at(sheet, system, i)
    return placed


def _check_element(system: Prescription, i: int) -> None:
    """Refuse glass without a second surface, and without a thickness."""
    if i + 1 == len(system.rows):
        raise ValueError(f"prescription: rows[{i}]: the last medium must be air, got {system.media[i + 1].name}")
    if not system.rows[i].thickness:
        raise ValueError(f"prescription: rows[{i}]: thickness must not be 0 in {system.media[i + 1].name}")


def _group(system: Prescription, i: int) -> tuple[int, int]:
    """(first row, last row) of the cemented group that the glass behind row i is part of."""
    first, last = i, i + 1
    while first and not system.media[first].is_air and not system.rows[first].reflects:
        first -= 1
    while last < len(system.rows) - 1 and not system.media[last + 1].is_air and not system.rows[last].reflects:
        last += 1
    return first, last


def _lens(system: Prescription, i: int) -> Any:
    """The element behind row i, as wide as the widest surface of its group, with flat rings around narrower ones."""
    first, last = _group(system, i)
    edge = max(system.diameters[first : last + 1])
    thickness = system.rows[i].thickness or 0.0
    low, high = (i, i + 1) if thickness > 0 else (i + 1, i)
    front, back = system.rows[low], system.rows[high]
    apertures = [None if system.diameters[k] == edge else system.diameters[k] for k in (low, high)]
    try:
        lens = Lens(front.radius, back.radius, abs(thickness), edge, front.conic, back.conic, *apertures)
    except ValueError as error:
        raise ValueError(f"prescription: rows[{i}] and rows[{i + 1}]: {error}") from None
    if thickness < 0:
        lens = lens.translate((0.0, 0.0, thickness))
    return _at(lens, system, i, first)


def _at(shape: Shape, system: Prescription, i: int, first: int | None = None) -> Any:
    """A shape moved to the vertex of row i, by the thicknesses one after the other, so that nothing is rounded."""
    start = i if first is None else first
    for row in system.rows[start:i]:
        shape = shape.translate((0.0, 0.0, row.thickness or 0.0))
    return shape.translate((0.0, 0.0, system.vertices[start])) if system.vertices[start] else shape
