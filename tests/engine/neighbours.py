"""Scenes in which bodies that are moved together have walls in common, now these and now others.

Between such bodies stand others that stay, so that what is moved is in several pieces of the tables, each of which comes
to its place by another step: one surface more, often, which is also as far as the two sides of a box are from another.
"""

from __future__ import annotations

import conicoid as co

GROUPS = (("2", "4"), ("6", "8", "10"), ("12", "13"), ("15", "16"), ("18", "20"))
"""Two of these are of bodies that come one after the other, which are one piece."""
_BODIES, _OFTEN = 22, (0.3, 0.1, 0.15, 0.15, 0.3)
_UNIT = 2.0**-20
"""All walls are at whole numbers of these, which sums and differences do not round."""


def _whole(rng, low, high, size=3):
    """Random numbers of which no two are the same but by rare chance."""
    return rng.integers(int(low / _UNIT), int(high / _UNIT), size) * _UNIT


def touching(rng, count, axis):
    """Boxes of which most have a wall across an axis in common with the one before; a ball for each, often the same."""
    boxes, balls = [], []
    for number in range(count):
        low, size = _whole(rng, -4, 4), _whole(rng, 0.25, 2)
        if number and rng.random() < 0.95:
            low[axis] = boxes[-1][rng.integers(0, 2)][axis] - rng.integers(0, 2) * size[axis]
        boxes.append((low, low + size))
        balls.append(low if not balls or rng.random() < 0.5 else balls[rng.integers(0, number)])
    shapes = [co.Box(low.tolist(), high.tolist()) for low, high in boxes]
    return shapes, [co.Sphere(0.125, balls[which].tolist()) for which in rng.permutation(count).tolist()]


def _put(rng, group, kinds):
    """What a group is exchanged for: for each body one of its own kind, with walls in common across an axis or other."""
    axis = rng.integers(0, 3) if rng.random() < 0.1 else GROUPS.index(group) % 3
    boxes, balls = touching(rng, len(group), axis)
    return [box - ball if name in kinds else box for name, box, ball in zip(group, boxes, balls, strict=True)]


def neighbours(rng):
    """(scene, names of the bodies that have a ball taken out)."""
    kinds = {str(number) for number in range(_BODIES) if rng.random() < 0.2}
    shapes = {}
    for group in GROUPS:
        shapes.update(zip(group, _put(rng, group, kinds), strict=True))
    for number in range(_BODIES):
        at = _whole(rng, -4, 4).tolist()
        shapes.setdefault(str(number), co.Box(at, (5, 6, 7)) if number == 7 else co.Sphere(0.25, at))
    return co.Scene([co.Body(shapes[str(number)], name=str(number)) for number in range(_BODIES)]), kinds


def rearranged(scene, rng, kinds):
    """One or two groups moved as they are, or with other walls in common than before, or some of a group alone.

    All in one preparation.
    """
    for which in rng.choice(len(GROUPS), rng.integers(1, 3), replace=False, p=_OFTEN).tolist():
        group, how = GROUPS[which], rng.random()
        if how < 0.4:
            step = tuple(_whole(rng, -1, 1).tolist())
            for name in group[how > 0.36 :]:
                scene = scene.moved(name, step)
        else:
            for name, shape in zip(group, _put(rng, group, kinds), strict=True):
                scene = scene.replace(name, shape)
    return scene
