"""What is told of answers beside them, once for each scene: in the log, or, in a task, to the one who asked."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator

from ...shapes.labels import Labels

_task = threading.local()


@contextlib.contextmanager
def gathered() -> Iterator[list[str]]:
    """What this thread tells within the block, which is not logged here."""
    before, notes = getattr(_task, "notes", None), list[str]()
    _task.notes = notes
    try:
        yield notes
    finally:
        _task.notes = before


def tell_once(labels: Labels, text: Callable[[], str]) -> None:
    """Log a text, of the first answer of a scene alone, which its labels stand for; a task has one for its asker."""
    notes = getattr(_task, "notes", None)
    if notes is not None:
        notes.extend([] if notes else [text()])
    elif not vars(labels).get("_told_overlaps"):
        vars(labels)["_told_overlaps"] = True
        import logging

        logging.getLogger("conicoid").warning("%s", text())
