"""Stretches of rays that lie in two bodies at once, which sums over bodies count twice: they are told of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...shapes.labels import counted
from ...shapes.suggestion import close_to
from ...shapes.validate import shown
from ..arrays.owners import owners
from .notes import tell_once

if TYPE_CHECKING:
    from .spans import Spans

BOTH, ERROR = "both", "error"
_THIN, _ROUNDED = 1e-5, 1e-9
"""Of the longest stretch, and of the distance: less is what numbers with few digits leave between walls."""


def checked_overlaps(owner: str, overlaps: Any) -> str | None:
    """How stretches within two bodies count; a ValueError for anything but "both", "error" and None."""
    if overlaps is not None and overlaps not in (BOTH, ERROR):
        close = close_to(overlaps, (BOTH, ERROR)) if isinstance(overlaps, str) else ""
        meant = f" (did you mean {close!r}?)" if close else ""
        raise ValueError(f"{owner}: overlaps must be 'both', 'error' or None, got {shown(overlaps)}{meant}")
    return overlaps


def tell_overlaps(owner: str, spans: Spans, overlaps: str | None, kinds: Any, counts: Any) -> None:
    """Refuse overlaps of stretches that are added up, for "error"; for None log them, once for a scene.

    kinds: what each stretch is added up with, a number, or None where all are added up; counts: which count at all.
    """
    if overlaps == BOTH or not len(spans.body):
        return
    rows = np.arange(len(spans.body)) if counts is None else np.flatnonzero(counts)
    found = _overlapping(spans, rows)
    if len(found[0]) and kinds is not None:
        found = _overlapping(spans, rows[np.lexsort((rows, kinds[rows], _rays(spans)[rows]))], kinds)
    if not len(found[0]):
        return
    if overlaps == ERROR:
        raise ValueError(_told(owner, spans, *found) + "; co.check(scene) finds all")
    tell_once(spans._labels, lambda: _told(owner, spans, *found) + _MEANT)


_MEANT = "; overlaps='both' says that it is meant, and overlaps='error' refuses it"


def _overlapping(spans: Spans, rows: Any, kinds: Any = None) -> tuple[Any, Any]:
    """Neighbours among some rows, sorted by ray and start, that overlap. If any two of a ray do, two neighbours do."""
    one, other = rows[:-1], rows[1:]
    ray = _rays(spans)
    same = ray[one] == ray[other]
    if kinds is not None:
        same &= kinds[one] == kinds[other]
    start, end = spans.t_enter[other], spans.t_exit[one]
    common = np.minimum(end, spans.t_exit[other]) - start
    stretches = spans.t_exit - spans.t_enter
    longest = stretches.max(initial=0.0, where=np.isfinite(stretches))
    far = np.maximum(np.abs(start), np.abs(end))
    thick = np.isinf(common) | ((common > _THIN * longest) & (common > _ROUNDED * far))
    found = same & (common > 0) & thick
    return one[found], other[found]


def _rays(spans: Spans) -> Any:
    """The flat ray of every row."""
    return owners(spans.offsets)


def _told(owner: str, spans: Spans, one: Any, other: Any) -> str:
    """What is told of the first overlap."""
    ray = _rays(spans)[one]
    rays, first = counted(len(np.unique(ray)), "ray goes", "rays go"), int(ray[0])
    origin, direction = (tuple(part.reshape(-1, 3)[first].tolist()) for part in spans.rays)
    names = spans.name
    rows = sorted((int(one[0]), int(other[0])), key=lambda k: int(spans.body[k]))
    pair = " and ".join(_body(int(spans.body[k]), names[k]) for k in rows)
    return (
        f"{owner}: {rays} through two bodies at once, and such a stretch counts for each: {pair} overlap on the "
        f"ray from {origin} along {direction}"
    )


def _body(number: int, name: Any) -> str:
    return f"body {number}" + (f" {shown(name)}" if name else "")
