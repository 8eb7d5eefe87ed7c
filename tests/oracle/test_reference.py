"""Every shape against 90 digits: hits, misses, t, sense and face, over twelve decades of scale.

Scales 1e-6 to 1e6, distances up to a million sizes, grazing rays (2^-1 to 2^-49 above and below a
surface), rays along axes and asymptotes, rays from inside; moved, mirrored, stretched and sheared
shapes. `trace.py` states the band in which an answer is not certain, `compare.py` the bound of t.
"""

from __future__ import annotations

import pytest

import conicoid as co

from .compare import Score, compare
from .rays import rays
from .samples import KINDS, generator, random_case


def score_of(kind: str, cases: int, rays_per_case: int, first: int = 0) -> Score:
    """The comparison of a number of random cases of a shape."""
    score = Score()
    for index in range(first, first + cases):
        random = generator(kind, index)
        case = random_case(kind, random)
        score.add(compare(case, co, *rays(case, rays_per_case, random)))
    return score


def check(score: Score) -> None:
    assert not score.failures, f"{len(score.failures)} of {score.rays} rays fail\n\n" + "\n\n".join(score.failures[:5])
    assert score.wrong_hits == score.wrong_misses == 0
    assert score.crossings > score.rays / 10
    assert score.median < 1e-15
    assert max(score.steep_errors) <= 1e-13


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_sample(kind: str) -> None:
    check(score_of(kind, cases=5, rays_per_case=30))


@pytest.mark.deep
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_ten_thousand_rays(kind: str) -> None:
    check(score_of(kind, cases=200, rays_per_case=55, first=100))
