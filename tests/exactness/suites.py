"""How many cases and rays of each sort make a suite, and their scores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import conicoid as co

from .aim import Aim
from .cases import extreme, generator, ordinary
from .families import rays
from .judge import Judge, Score
from .nice import lattice_rays, nice_case
from .oracle import Oracle
from .shapes import exact_shape


@dataclass(frozen=True)
class Suite:
    """(cases, rays each) of each sort; `first` is the number of the first case."""

    ordinary: tuple[int, int]
    extreme: tuple[int, int]
    nice: tuple[int, int]
    first: int = 0

    @property
    def rays(self) -> int:
        return sum(cases * each for cases, each in (self.ordinary, self.extreme, self.nice))


SAMPLE = Suite(ordinary=(2, 800), extreme=(2, 400), nice=(8, 60))
MILLION = Suite(ordinary=(42, 17000), extreme=(22, 9000), nice=(200, 800), first=100)


def aimed_score(kind: str, sort: Any, number: int, count: int) -> Score:
    random = generator(f"{kind} {sort.__name__}", number)
    case = sort(kind, random)
    aim = Aim(case, random)
    return Judge(co, aim.oracle, [case], *rays(aim, count)).run()


def nice_score(kind: str, number: int, count: int) -> Score:
    random = generator(f"{kind} nice", number)
    case = nice_case(kind, random)
    oracle = Oracle(exact_shape(case), (0, 0, 0), 8.0)
    return Judge(co, oracle, [case], *lattice_rays(random, count)).run()


def score(kind: str, suite: Suite) -> tuple[Score, Score]:
    """(all of it, the ordinary cases alone)"""
    total, plain = Score(), Score()
    for sort, (cases, count), into in ((ordinary, suite.ordinary, plain), (extreme, suite.extreme, total)):
        for number in range(suite.first, suite.first + cases):
            into.add(aimed_score(kind, sort, number, count))
    for number in range(suite.first, suite.first + suite.nice[0]):
        total.add(nice_score(kind, number, suite.nice[1]))
    total.add(plain)
    return total, plain
