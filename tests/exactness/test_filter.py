"""The filter: its arithmetic keeps its bounds, and what it decides is what exact arithmetic decides."""

from __future__ import annotations

import dataclasses
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

from ..oracle.rays import rays
from ..oracle.samples import KINDS, generator, random_case
from .exact import ExactRay
from .oracle import Oracle
from .shapes import exact_shape
from .traced import crossings
from .wide import Wide, exact


def numbers(random: np.random.Generator, count: int) -> Wide:
    high = random.normal(size=count) * 2.0 ** random.integers(-40, 40, count)
    high[random.random(count) < 0.1] = 0.0
    low = np.where(random.random(count) < 0.5, high * 2.0**-54 * random.uniform(-1, 1, count), 0.0)
    error = np.where(random.random(count) < 0.5, np.abs(high) * 2.0 ** random.uniform(-110, -10, count), 0.0)
    return Wide(high, low, error)


def middle(x: Wide, i: int) -> Fraction:
    return Fraction(float(x.high[i])) + Fraction(float(x.low[i]))


def held(result: Wide, i: int, exact_value: Fraction) -> bool:
    return abs(middle(result, i) - exact_value) <= Fraction(float(result.error[i]))


@pytest.mark.parametrize("corner", [-1, 0, 1])
def test_arithmetic_keeps_its_bounds(corner: int) -> None:
    """With the operands anywhere within their errors, at the ends above all."""
    random = np.random.default_rng(5)
    x, y = numbers(random, 2000), numbers(random, 2000)
    with np.errstate(all="ignore"):
        total, difference, product, quotient = x + y, x - y, x * y, x / y
        root = Wide(np.abs(x.high), np.sign(x.high) * x.low, x.error).sqrt()
    for i in range(2000):
        a = middle(x, i) + corner * Fraction(float(x.error[i]))
        b = middle(y, i) - corner * Fraction(float(y.error[i]))
        assert held(total, i, a + b)
        assert held(difference, i, a - b)
        assert held(product, i, a * b)
        if np.isfinite(quotient.error[i]):
            assert held(quotient, i, a / b)
        if abs(x.high[i]) * 0.99 > x.error[i]:
            square = abs(middle(x, i)) + corner * Fraction(float(x.error[i]))
            s, e = middle(root, i), Fraction(float(root.error[i]))
            assert max(s - e, 0) ** 2 <= square <= (s + e) ** 2


def test_signs_are_certain() -> None:
    x = Wide(np.array([1.0, -1.0, 1.0, 0.0, 0.0, np.nan]), np.zeros(6), np.array([0.5, 0.5, 1.0, 0.0, 1e-300, 0.0]))
    assert x.positive.tolist() == [True, False, False, False, False, False]
    assert x.negative.tolist() == [False, True, False, False, False, False]
    assert x.zero.tolist() == [False, False, False, True, False, False]
    tiny = exact(np.array([1e-200])) * exact(np.array([1e-200]))
    assert not tiny.zero.any()


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_decided_rays_are_right(kind: str) -> None:
    easy = 0
    for index in range(2):
        random = generator(kind, 800 + index)
        case = dataclasses.replace(random_case(kind, random), **({"steps": ()} if kind == "Spheres" else {}))
        origins, directions = rays(case, 40, random)
        oracle = Oracle(exact_shape(case), case.world_center, case.world_size)
        answers = oracle.answers(origins, directions)
        for i in np.flatnonzero(~answers.hard):
            rows = slice(answers.offsets[i], answers.offsets[i + 1])
            expected = crossings(oracle.shape, ExactRay(origins[i], directions[i]))
            told = zip(*(getattr(answers, n)[rows] for n in ("entering", "face", "body", "form", "sign")), strict=True)
            assert [(c.entering, c.face, c.body, c.root.index, c.root.sign) for c in expected] == list(told)
            for c, high, low, slack in zip(
                expected, answers.high[rows], answers.low[rows], answers.slack[rows], strict=True
            ):
                with ctx.workprec(500):
                    assert abs(arb(float(high)) + arb(float(low)) - c.root.at(300)) <= arb(float(slack))
            easy += 1
    assert easy > 60
