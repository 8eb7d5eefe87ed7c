"""Distances against force: every one is within its bound."""

import numpy as np

import conicoid as co

from .bodies import BODIES
from .force import EPSILON, Walls

ROUNDED = 4e-16
"""The tolerance for the oracle's own numbers and for the answers' last digits."""
TOUCHING = np.longdouble(2) ** -26
"""Where two walls touch, floats know the contact to the root of their last digit. Near one a search may end there, with
that error.
"""


def points_about(walls, rng, count):
    """Return points far and near, beside walls, on edges of a lattice, on axes and in planes of symmetry."""
    k = max(1, count // 5)
    chosen = walls.points[rng.integers(0, len(walls.points), k)].astype(float)
    lattice = rng.integers(-8, 9, (k, 3)) / 4
    axes = np.zeros((k, 3))
    axes[np.arange(k), rng.integers(0, 3, k)] = rng.uniform(-2, 2, k)
    return np.concatenate([
        rng.uniform(-2.5, 2.5, (k, 3)), chosen + rng.normal(size=(k, 3)) * 10.0 ** rng.uniform(-9, 0, (k, 1)), lattice, axes,
        rng.normal(size=(k, 3)) * 10.0 ** rng.uniform(0, 3, (k, 1)),
    ])  # fmt: skip


def faults(name, rng, count, forced, body=None, widest=0.0):
    """Return the faults of the distances of `count` points of a body; force searches `forced` of them.

    `widest` is the share of points that may have a wide error, which is true all the same.
    """
    shape, field = body or BODIES[name]
    walls = Walls(field, rng)
    x = points_about(walls, rng, count)
    scene = co.Scene([shape])
    bound, found = scene.distance(x), scene.distance(x, exact=True)
    away = np.abs(found.distance)
    yield from _check_points(name, x, away, found, walls, widest)
    value = field(x.astype(np.longdouble))
    for i in np.flatnonzero((away < np.inf) & (away > found.error) & ((value <= 0) != (found.distance < 0))):
        yield f"{name}: the sign of {found.distance[i]} at {x[i].tolist()}"
    for i in np.flatnonzero(bound.lower > away + found.error):
        yield f"{name}: the bound {bound.lower[i]} is above {away[i]} at {x[i].tolist()}"
    for i in range(0, len(x), 64):
        part = x[i : i + 64]
        least = np.sqrt(((part[:, None] - walls.points[None].astype(float)) ** 2).sum(-1).min(axis=1))
        for j in np.flatnonzero(least * (1 + 1e-14) + 1e-15 < found.lower[i : i + 64]):
            yield f"{name}: a wall at {least[j]}, below {found.lower[i + j]}, from {part[j].tolist()}"
    for i in rng.permutation(len(x))[:forced]:
        least, at, sure = walls.nearest(x[i])
        slack = ROUNDED * (np.abs(x[i]).max() + np.abs(at).max())
        if least + slack < found.lower[i]:
            yield f"{name}: a wall at {least}, {at.astype(float)}, below {found.lower[i]}, from {x[i].tolist()}"
        if sure and least > away[i] + found.error[i] + slack and least < away[i] + 1e-3:
            yield f"{name}: {away[i]} where force finds {least} at {at.astype(float)} from {x[i].tolist()}"
        if bound.lower[i] > least + slack:
            yield f"{name}: the bound {bound.lower[i]} is above {least} at {x[i].tolist()}"


def _check_points(name, x, away, found, walls, widest):
    """Check that the nearest points are on walls, at their distance, with a normal of the wall."""
    apart = np.sqrt(((found.point.astype(np.longdouble) - x) ** 2).sum(axis=1))
    proved = found.body >= 0
    for i in np.flatnonzero(~proved & (found.error < np.inf)):
        yield f"{name}: no wall is told, and yet an error of {found.error[i]}, from {x[i].tolist()}"
    for i in np.flatnonzero(proved & ~(np.abs(apart - away) <= found.error + ROUNDED * np.abs(x).max(axis=1))):
        yield f"{name}: {away[i]} to a point at {apart[i]} from {x[i].tolist()}"
    sharp = found.error <= 1e-11 * (1 + np.abs(x).max(axis=1))
    wide = np.flatnonzero(~sharp)
    if len(wide) > widest * len(x):
        yield f"{name}: {len(wide)} of {len(x)} errors are wide, such as {found.error[wide[0]]} at {x[wide[0]].tolist()}"
    near = proved & (np.abs(x).max(axis=1) < 50)  # a farther point is less exact than its distance
    points = found.point.astype(np.longdouble)
    for rows, within in ((near & sharp, EPSILON), (near & ~sharp, TOUCHING)):
        for i in np.flatnonzero(rows)[~walls.is_wall(points[rows], within)]:
            yield f"{name}: no wall at {found.point[i].tolist()}, from {x[i].tolist()}"
    unit = np.linalg.norm(found.normal, axis=1)
    for i in np.flatnonzero(proved & ~(np.abs(unit - 1) < 1e-12)):
        yield f"{name}: a normal {found.normal[i]} at {found.point[i].tolist()}"
