"""Rectangles to send rays through: small where what rays find differs from corner to corner."""

from __future__ import annotations

import numpy as np

from .chords import Family
from .frames import FittedBox
from .hull import Hull, Rectangles, Sight

_FIRST = 16  # there is a first rectangle for so many rays
_THIN = 4  # or for so many, while hulls still take away much of the area
_CLEARLY_LESS = 0.9
_ROUNDS = 6
_SPLIT = 12  # at most one in so many rectangles is quartered in a round
_WORSE = 2.0  # those that differ by so many times the average
_CORNER_RAYS = 9  # around four quarters
_MOST = 1 << 19
"""Rectangles in memory; beyond, each gets more rays."""


def refined(family: Family, hull: Hull) -> Rectangles:
    """Rectangles that cover the shape's shadow, in number about half of the family's rays that are left.

    The rays that decide this are not used again: what is estimated on the rectangles stays unbiased.
    """
    sight, most = family.sight, min(family.left, 2 * _MOST)
    rectangles = _covering(hull, family.box, sight, most)
    scores = family.ranges(rectangles) if len(rectangles) <= most // _FIRST else np.zeros(len(rectangles))
    for _ in range(_ROUNDS if scores.any() else 0):
        worst = np.argsort(-scores, kind="stable")[: max(1, len(scores) // _SPLIT)]
        worst = worst[scores[worst] > _WORSE * scores.mean()]
        if 2 * len(scores) + (6 + _CORNER_RAYS) * len(worst) > min(family.left, 2 * _MOST):
            break
        parts = hull.seen(rectangles[worst].halved().halved(), sight)
        scores = np.concatenate([np.delete(scores, worst), family.ranges(parts)])
        rectangles = rectangles.without(worst) + parts
    return _filled(rectangles, hull, sight, min(family.left // 2, _MOST))


def _covering(hull: Hull, box: FittedBox, sight: Sight, rays: int) -> Rectangles:
    """Equal rectangles that cover the shape's shadow along an axis; none where there is no shadow."""
    half = np.delete(box.half, sight.axis)[None]
    rectangles = hull.seen(Rectangles(-half, 2 * half), sight)
    while len(rectangles):
        smaller = hull.seen(rectangles.halved(), sight)
        thinner = smaller.areas.sum() < _CLEARLY_LESS * rectangles.areas.sum()
        if len(smaller) > rays // (_THIN if thinner else _FIRST) or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


def _filled(rectangles: Rectangles, hull: Hull, sight: Sight, most: int) -> Rectangles:
    """All of them halved as often as `most` allows."""
    while len(rectangles):
        smaller = hull.seen(rectangles.halved(), sight)
        if len(smaller) > most or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles
