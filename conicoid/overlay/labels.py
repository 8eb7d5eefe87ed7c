"""Names of bodies, each where most of its entry is seen; the largest first, as long as there is room."""

from __future__ import annotations

import unicodedata
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..formats.errors import printable
from .seen import grid_of_hits
from .sheet import Sheet, in_font

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene

_FINEST = 512  # rays along the longer side
_MOST, _LONGEST = 60, 40
_LEAST = 6  # rays that must see an entry
_SIZE = 14
_SHIFTS = ((0, 0), (0, -1.2), (0, 1.2), (0, -2.4), (0, 2.4))
Box = tuple[float, float, float, float]
Ints = npt.NDArray[np.int32]


def draw_labels(sheet: Sheet, scene: Scene, camera: AnyCamera) -> None:
    """The name of each entry that is seen, or the number of its first body where it has none."""
    step = max(1.0, max(sheet.width, sheet.height) / _FINEST)
    hits = grid_of_hits(scene, camera, sheet.width, sheet.height, step)
    entries = np.where(hits.hit, np.append(scene.lowered.body_item, -1)[hits.body], -1)
    depths = _depths(entries)
    taken: list[Box] = []
    found, counts = np.unique(entries[entries >= 0], return_counts=True)
    for k in np.argsort(-counts, kind="stable")[:_MOST].tolist():
        if counts[k] < _LEAST:
            return
        own = np.where(entries == found[k], depths, -1)
        deepest = np.argwhere(own == own.max())
        row, column = deepest[np.argmin(((deepest - deepest.mean(axis=0)) ** 2).sum(axis=1))]
        place = camera.project(hits.point[row, column], sheet.width, sheet.height)
        _put(sheet, _text(scene, int(found[k])), place.tolist(), taken)


def _depths(entries: Ints) -> Ints:
    """How many steps each pixel is away from the next that shows another entry, or from the edge."""
    depths = np.zeros(entries.shape, np.int32)
    inner = np.zeros(entries.shape, bool)
    middle = entries[1:-1, 1:-1]
    inner[1:-1, 1:-1] = (middle == entries[:-2, 1:-1]) & (middle == entries[2:, 1:-1])
    inner[1:-1, 1:-1] &= (middle == entries[1:-1, :-2]) & (middle == entries[1:-1, 2:])
    while inner.any():
        depths += inner
        across = inner[1:-1, :-2] & inner[1:-1, 2:]
        inner[1:-1, 1:-1] &= inner[:-2, 1:-1] & inner[2:, 1:-1] & across
    return depths


def _text(scene: Scene, entry: int) -> str:
    name = drawable(scene.bodies[entry].name or str(int(np.searchsorted(scene.lowered.body_item, entry))))
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"


def drawable(text: str) -> str:
    """A text in letters that the font has, which are ASCII and a few signs: without accents, others by number."""
    return "".join(c if in_font(c) else _plain(c) for c in printable(text))


def _plain(letter: str) -> str:
    base = "".join(c for c in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(c))
    return base.encode("ascii", "backslashreplace").decode()


def _put(sheet: Sheet, text: str, place: list[float], taken: list[Box]) -> None:
    """Draw a text near a place, where it covers no other; nowhere if there is no such room."""
    width, height = (size + 4 * sheet.unit for size in sheet.size_of(text, _SIZE))
    x = min(max(place[0], width / 2), max(width / 2, sheet.width - width / 2))
    for across, down in _SHIFTS:
        left, y = x + across * width, place[1] + down * height
        y = min(max(y, height / 2), max(height / 2, sheet.height - height / 2))
        box = (left - width / 2, y - height / 2, left + width / 2, y + height / 2)
        if not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken):
            taken.append(box)
            sheet.text((left, y), text, "#101010", _SIZE)
            return
