"""Every kind of shape against exact arithmetic: hits, misses, order, faces, times within their bounds.

Rays at random and aimed to be hard (`families`), at ordinary scales and towards the ends of the documented domain
(`cases`), and on small whole numbers, where tangencies and coincidences are exact (`nice`).
"""

from __future__ import annotations

import pytest

from ..oracle.samples import KINDS
from .suites import MILLION, SAMPLE, Suite, score

LOOSEST = 16


def check(kind: str, suite: Suite) -> None:
    total, plain = score(kind, suite)
    assert total.rays > 0.9 * suite.rays
    assert total.crossings > 0.1 * total.rays
    total.check()
    assert plain.slackness <= LOOSEST


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_sample(kind: str) -> None:
    check(kind, SAMPLE)


@pytest.mark.deep
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_million_rays(kind: str) -> None:
    check(kind, MILLION)
