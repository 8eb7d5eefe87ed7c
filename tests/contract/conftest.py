"""Every registered shape, unmoved and moved, as a `subject`; `solid` and `sheet` are parts of them."""

from functools import cache

import pytest

from ..samples import marked
from .examples import MOTIONS, every_example, sample_of_kinds
from .subject import Subject

SHAPES = dict(every_example())
ALL = [(name, motion) for name in SHAPES for motion in MOTIONS]


def _fast() -> set[tuple[str, str]]:
    """Return one motion for each example, in turn. A kind with one example is there unmoved and moved."""
    kinds = [name.rpartition("-")[0] for name in SHAPES]
    turn = {name: number + kinds.index(kind) for number, (name, kind) in enumerate(zip(SHAPES, kinds, strict=True))}
    single = {name for name, kind in zip(SHAPES, kinds, strict=True) if kinds.count(kind) == 1}
    still, *others = MOTIONS
    return {
        *((name, list(MOTIONS)[turn[name] % len(MOTIONS)]) for name in SHAPES.keys() - single),
        *((name, motion) for name in single for motion in (still, others[turn[name] // 2 % len(others)])),
    }


FAST = _fast()
"""(example, motion) of the fast tests; deep ones take all."""
SAMPLES = [sample_of_kinds(turn) for turn in range(2)]
"""The fast tests of a file take the even and the odd examples of a kind in turn."""


@cache
def subject_of(name: str, motion: str) -> Subject:
    return Subject(f"{name}-{motion}", MOTIONS[motion](SHAPES[name]))


SUBJECTS = {
    "subject": ALL,
    "solid": [pair for pair in ALL if not SHAPES[pair[0]].is_sheet],
    "sheet": [pair for pair in ALL if SHAPES[pair[0]].is_sheet],
}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run each test with all subjects of its argument."""
    for argument in SUBJECTS.keys() & set(metafunc.fixturenames):
        sample = SAMPLES[list(vars(metafunc.module)).index(metafunc.function.__name__) % 2]
        cases = marked(("-".join(pair), pair in FAST and pair[0] in sample) for pair in SUBJECTS[argument])
        metafunc.parametrize(argument, cases, indirect=True, scope="session")


@pytest.fixture(scope="session")
def subject(request) -> Subject:
    return subject_of(*request.param.rpartition("-")[::2])


@pytest.fixture(scope="session")
def solid(request) -> Subject:
    return subject_of(*request.param.rpartition("-")[::2])


@pytest.fixture(scope="session")
def sheet(request) -> Subject:
    return subject_of(*request.param.rpartition("-")[::2])
