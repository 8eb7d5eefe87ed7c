"""Random cases for certified answers: those of `tests/oracle`, over the whole documented domain."""

from __future__ import annotations

import dataclasses
import math
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..oracle.cases import Case
from ..oracle.draws import scale
from ..oracle.samples import KINDS, motion, random_case
from .families import LEAST, MOST

Random = np.random.Generator
SQUARED = {
    "EllipticParaboloid", "HyperbolicParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone",
    "EllipticCylinder", "HyperbolicCylinder", "Quadric", "DoubleCone",
}  # fmt: skip
"""Kinds whose parameters go with the inverse square of the size."""
STILL_ONLY = {"Spheres"}
"""A motion of bulk spheres rounds their centres and radii: what is exact then is what the library has rounded."""


def generator(name: str, index: int) -> Random:
    return np.random.default_rng([20261121, zlib.crc32(name.encode()), index])


def ordinary(kind: str, random: Random) -> Case:
    """Scales 1e-6 to 1e6, moved in three cases of five."""
    if kind in STILL_ONLY:
        return KINDS[kind](random, scale(random))
    return tidied(random_case(kind, random))


def extreme(kind: str, random: Random) -> Case:
    """Sizes towards the ends of the domain: 1e-95 to 1e95, or 1e-45 to 1e45 where parameters are inverse squares."""
    while True:
        most = 45.0 if kind in SQUARED or kind in ("NestedBooleans",) or _combined(kind) else 92.0
        size = float(10 ** (random.choice([-1, 1]) * random.uniform(most / 2, most)))
        case = KINDS[kind](random, size)
        if kind not in STILL_ONLY and random.random() < 0.4 and np.linalg.norm(case.center) <= 40 * case.size:
            case = dataclasses.replace(case, steps=motion(random, case.size))
        if all(number == 0 or LEAST <= abs(number) <= MOST for number in numbers_of(case)):
            return tidied(case)


def _combined(kind: str) -> bool:
    return kind in ("Union", "Intersection", "Difference", "Complement", "ClippedSheet")


def numbers_of(case: Case) -> Iterator[float]:
    """Every finite number that a user writes for it."""
    yield from _flat(list(case.parameters.values()))
    yield from _flat([step[1:] for step in case.steps])
    for operand in case.operands:
        yield from numbers_of(operand)


def _flat(value: Any) -> Iterator[float]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple, np.ndarray)):
        for item in value:
            yield from _flat(item)
    elif isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value):
        yield float(value)


def tidied(case: Case) -> Case:
    """Angles to 2^-20 degrees, so that their difference is a float64: what it rounds to is no question here."""
    parameters = dict(case.parameters)
    if "start_angle" in parameters:
        first, last = (round(parameters[name] * 2**20) / 2**20 for name in ("start_angle", "end_angle"))
        parameters |= {"start_angle": first, "end_angle": min(last, first + 360)}
    return dataclasses.replace(case, parameters=parameters, operands=tuple(map(tidied, case.operands)))
