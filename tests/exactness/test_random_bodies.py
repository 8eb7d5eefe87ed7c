"""Every kind of shape against exact arithmetic, on hard rays: every query, every route, bounces.

Shapes have ordinary scales or sizes towards the ends of the documented domain. Rays graze, run through edges and
corners, along axes, rulings and asymptotes, start on surfaces and far away.
"""

import pytest

from ..reference.judge import Score
from ..reference.random_items import KINDS, extreme, ordinary
from ..reference.suite import random_score, total
from ..samples import drawn

LOOSEST = 16


def check(score: Score) -> None:
    assert score.rows > 0.1 * score.rays
    score.check()


def sample(kind, sort, count: int) -> Score:
    """Return the score of the first random bodies of a kind, up to one that is not empty."""
    scores: list[Score] = []
    while not any(score.rows for score in scores) and len(scores) < 4:
        scores.append(random_score(kind, sort, len(scores), count))
    return total(scores)


@pytest.mark.parametrize("kind", KINDS)
def test_at_ordinary_scales(kind):
    score = sample(kind, ordinary, 80)
    check(score)
    assert score.slackness <= LOOSEST


@pytest.mark.parametrize("kind", KINDS)
def test_towards_the_ends_of_the_domain(kind):
    check(sample(kind, extreme, 60))


@pytest.mark.deep
@pytest.mark.parametrize("kind", KINDS)
def test_more_bodies(kind):
    for sort, numbers in ((ordinary, drawn(range(100, 230), 3, kind)), (extreme, drawn(range(100, 170), 2, kind))):
        score = total([random_score(kind, sort, number, 500) for number in numbers])
        score.check()
        assert sort is extreme or score.slackness <= LOOSEST
