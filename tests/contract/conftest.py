"""Every registered shape, unmoved and moved, as a `subject`; `solid` and `sheet` are parts of them."""

from __future__ import annotations

from functools import cache

import pytest

from .examples import MOTIONS, every_example
from .subject import Subject

SHAPES = dict(every_example())
ALL = [(name, motion) for name in SHAPES for motion in MOTIONS]


@cache
def subject_of(name: str, motion: str) -> Subject:
    return Subject(f"{name}-{motion}", MOTIONS[motion](SHAPES[name]))


def _named(pairs):
    return {"params": pairs, "ids": ["-".join(pair) for pair in pairs], "scope": "session"}


@pytest.fixture(**_named(ALL))
def subject(request) -> Subject:
    return subject_of(*request.param)


@pytest.fixture(**_named([pair for pair in ALL if not SHAPES[pair[0]].is_sheet]))
def solid(request) -> Subject:
    return subject_of(*request.param)


@pytest.fixture(**_named([pair for pair in ALL if SHAPES[pair[0]].is_sheet]))
def sheet(request) -> Subject:
    return subject_of(*request.param)
