"""Overlaps: stretches of rays in two bodies at once, which sums over bodies count twice, and the reports of them."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from .._util.records import unique_sorted
from .._util.text import format_count, near_name
from .._util.validation import format_value
from ..geometry.labels import Labels
from ..kernels.crossings import ROUNDING_OVERLAP, count_overlaps, row_owners
from ..kernels.threads import KernelRange, run_chunks

COUNT_BOTH, REFUSE_OVERLAPS = "both", "error"
_RAYS = 1 << 13  # rays that a thread takes at a time
_THIN_OVERLAP = 1e-5
"""Thinner overlaps are ignored, since walls given with few digits leave them: a share of the longest stretch."""


def check_overlaps(owner: str, overlaps: Any) -> str | None:
    """Return `overlaps`. Raise ValueError unless it is "both", "error" or None."""
    if overlaps is not None and overlaps not in (COUNT_BOTH, REFUSE_OVERLAPS):
        found = f"{format_value(overlaps)}{near_name(overlaps, (COUNT_BOTH, REFUSE_OVERLAPS))}"
        raise ValueError(f"{owner}: overlaps must be 'both', 'error' or None, got {found}")
    return overlaps


def report_overlaps(owner: str, spans: Any, overlaps: str | None, kinds: Any, counts: Any) -> None:
    """Raise ValueError for overlaps if `overlaps` is "error"; if it is None, log them once for each scene.

    kinds: the group of each row, within which lengths are summed, or None for a single group; counts: mask of the rows
    that contribute, or None for all.
    """
    if not len(spans.body) or is_silent(spans._labels, overlaps):
        return
    counted = np.zeros(0, np.int8) if counts is None else np.ascontiguousarray(counts).view(np.int8)
    rows_of_rays = spans.offsets[:-1], spans.offsets[1:]
    work = KernelRange(count_overlaps, (*rows_of_rays, spans.t_enter, spans.t_exit, counted), ())
    if not any(found for _, _, found in run_chunks(work, len(spans), _RAYS)):
        return
    rows = np.arange(len(spans.body)) if counts is None else np.flatnonzero(counts)
    pairs = _find_overlaps(spans, rows)
    if len(pairs[0]) and kinds is not None:  # sorting by group is only needed where some overlap exists
        pairs = _find_overlaps(spans, rows[np.lexsort((rows, kinds[rows], row_owners(spans.offsets)[rows]))], kinds)
    if not len(pairs[0]):
        return
    if overlaps == REFUSE_OVERLAPS:
        raise ValueError(_overlap_message(owner, spans, *pairs) + "; co.check(scene) finds all")
    options = "; overlaps='both' says that it is meant, and overlaps='error' refuses it"
    log_once(spans._labels, lambda: _overlap_message(owner, spans, *pairs) + options)


def is_silent(labels: Labels, overlaps: str | None) -> bool:
    """Return whether nobody hears of overlaps any more."""
    return overlaps == COUNT_BOTH or (overlaps is None and has_note(labels))


def _find_overlaps(spans: Any, rows: Any, kinds: Any = None) -> tuple[Any, Any]:
    """Return pairs of rows that overlap, at least one a ray and group; `rows` are sorted by ray, group and start.

    Each row is compared with the one before it that ends last in its ray and group. A neighbour would not do: a thin
    one, whose overlaps do not count, may stand between two others.
    """
    ray, count = row_owners(spans.offsets)[rows], len(rows)
    begins = np.ones(count, np.int64)
    begins[1:] = ray[1:] != ray[:-1]
    if kinds is not None:
        begins[1:] |= kinds[rows[1:]] != kinds[rows[:-1]]
    group, order = np.cumsum(begins), np.argsort(spans.t_exit[rows], kind="stable")
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    latest = order[np.maximum.accumulate(group * count + rank)[:-1] % max(count, 1)]
    one, other, same = rows[latest], rows[1:], group[1:] == group[:-1]
    start, end = spans.t_enter[other], spans.t_exit[one]
    common = np.minimum(end, spans.t_exit[other]) - start
    stretches = spans.t_exit - spans.t_enter
    longest = stretches.max(initial=0.0, where=np.isfinite(stretches))
    far = np.maximum(np.abs(start), np.abs(end))
    thick = np.isinf(common) | ((common > _THIN_OVERLAP * longest) & (common > ROUNDING_OVERLAP * far))
    overlap = same & (common > 0) & thick
    return one[overlap], other[overlap]


def _overlap_message(owner: str, spans: Any, one: Any, other: Any) -> str:
    """Return a message on the number of rays with overlaps, and on the first overlap."""
    ray = row_owners(spans.offsets)[one]
    rays, first = format_count(len(unique_sorted(ray)), "ray goes", "rays go"), int(ray[0])
    origin, direction = (tuple(part.reshape(-1, 3)[first].tolist()) for part in spans.rays)
    names = spans.name
    rows = sorted((int(one[0]), int(other[0])), key=lambda k: int(spans.body[k]))
    pair = " and ".join(_body_label(int(spans.body[k]), names[k]) for k in rows)
    return (
        f"{owner}: {rays} through two bodies at once, and such a stretch counts for each: {pair} overlap on the "
        f"ray from {origin} along {direction}"
    )


def _body_label(number: int, name: Any) -> str:
    """Return "body 3" with the name if there is one."""
    return f"body {number}" + (f" {format_value(name)}" if name else "")


# Notes beside a result, once for each scene: in the log, or, in a task on a worker, returned to the caller's process.

_task_notes = threading.local()


@contextlib.contextmanager
def collect_notes() -> Iterator[list[str]]:
    """Collect the notes of this thread within the block instead of logging them."""
    before, notes = getattr(_task_notes, "notes", None), list[str]()
    _task_notes.notes = notes
    try:
        yield notes
    finally:
        _task_notes.notes = before


def log_once(labels: Labels, text: Callable[[], str]) -> None:
    """Log a text once for each scene, which `labels` identify; within `collect_notes` collect the first text."""
    if has_note(labels):
        return
    notes = getattr(_task_notes, "notes", None)
    if notes is not None:
        notes.append(text())
    else:
        vars(labels)["_overlaps_noted"] = True
        import logging

        logging.getLogger("conicoid").warning("%s", text())


def has_note(labels: Labels) -> bool:
    """Return whether the scene has its note, so that nobody needs another."""
    return bool(vars(labels).get("_overlaps_noted") or getattr(_task_notes, "notes", None))
