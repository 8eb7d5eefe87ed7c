"""Every registered shape, unmoved and moved, as a `subject`; `solid` and `sheet` are parts of them."""

from __future__ import annotations

from functools import cache

import pytest

from .examples import MOTIONS, every_example
from .subject import Subject

SHAPES = dict(every_example())
ALL = [(name, motion) for name in SHAPES for motion in MOTIONS]


def _fast() -> set[tuple[str, str]]:
    """Return one motion for each example, in turn; a kind that has one example is there unmoved, and moved."""
    kinds = [name.rpartition("-")[0] for name in SHAPES]
    turn = {name: number + kinds.index(kind) for number, (name, kind) in enumerate(zip(SHAPES, kinds, strict=True))}
    single = {name for name, kind in zip(SHAPES, kinds, strict=True) if kinds.count(kind) == 1}
    still, *others = MOTIONS
    return {
        *((name, list(MOTIONS)[turn[name] % len(MOTIONS)]) for name in SHAPES.keys() - single),
        *((name, motion) for name in single for motion in (still, others[turn[name] % len(others)])),
    }


FAST = _fast()
"""(example, motion) of the fast tests; the deep ones take all."""


@cache
def subject_of(name: str, motion: str) -> Subject:
    return Subject(f"{name}-{motion}", MOTIONS[motion](SHAPES[name]))


def _named(pairs):
    params = [pair if pair in FAST else pytest.param(pair, marks=pytest.mark.deep) for pair in pairs]
    return {"params": params, "ids": ["-".join(pair) for pair in pairs], "scope": "session"}


@pytest.fixture(**_named(ALL))
def subject(request) -> Subject:
    return subject_of(*request.param)


@pytest.fixture(**_named([pair for pair in ALL if not SHAPES[pair[0]].is_sheet]))
def solid(request) -> Subject:
    return subject_of(*request.param)


@pytest.fixture(**_named([pair for pair in ALL if SHAPES[pair[0]].is_sheet]))
def sheet(request) -> Subject:
    return subject_of(*request.param)
