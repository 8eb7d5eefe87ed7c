"""What runs on a worker: a function of what tasks share and of its own arguments, on as many threads as it may use."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..engine.answers.notes import gathered
from ..engine.threads import limited_to
from ..shapes.carried import aligned
from .edition import edition
from .recipe import Reference, found


class Done(NamedTuple):
    """What a task brings back; `seconds` are those of the work itself, without what is made ready for it.

    notes: what would have been logged here, for the one who asked.
    """

    value: Any
    seconds: float
    notes: tuple[str, ...] = ()


class Missing(NamedTuple):
    """The answer of a worker that lacks a recipe."""

    worker: str


def run(
    asked: str, references: tuple[Reference, ...], threads: int | None, call: Callable[..., Any], *arguments: Any
) -> Done | Missing:
    """call(*shared, *arguments) with what the references stand for.

    Raises ValueError where this process has another edition than the one who asked.
    """
    if edition() != asked:
        raise ValueError(f"executor: the worker {here()} has conicoid {edition()}, and this process has {asked}")
    shared: list[Any] = []
    for reference in references:
        thing = found(reference)
        if not thing:
            return Missing(here())
        shared += thing
    with limited_to(threads), np.errstate(all="ignore"), gathered() as notes:
        ready = getattr(call, "ready", None)
        if ready is not None:
            ready(*shared)
        began = time.perf_counter()
        value = call(*shared, *map(aligned, arguments))
        return Done(value, time.perf_counter() - began, tuple(notes))


def here() -> str:
    """Machine and number of the process, for messages."""
    return f"{platform.node()}:{os.getpid()}"


def prepared_first(call: Callable[..., Any]) -> Callable[..., Any]:
    """A call whose first argument is a scene that is to be prepared, which is not part of its time."""
    call.ready = lambda scene, *_: scene.prepared  # type: ignore[attr-defined]
    return call
