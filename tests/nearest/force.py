"""The nearest wall by force, in extended precision: points all over the wall, and Newton's method from the nearest.

Walls are found by halving segments from inside to outside. From each of the nearest points the conditions of Lagrange
are solved for one, two or three surfaces near it. A solution counts if the body is on one side of it and not on
another. The search shares no code with the package.
"""

from itertools import combinations

import numpy as np

EPSILON = np.longdouble(2) ** -30


class Walls:
    """Points of the walls of a field."""

    def __init__(self, field, rng, count=6000, size=2.5):
        self.field, self.rng = field, rng
        every = rng.uniform(-size, size, (200_000, 3)).astype(np.longdouble)
        inside = every[field(every) <= 0]
        if not len(inside):
            raise ValueError("the body is empty, or nearly")
        a = inside[rng.integers(0, len(inside), 2 * count)]
        b = a + rng.normal(size=(2 * count, 3)) * rng.choice([0.03, 0.2, 1, 3], (2 * count, 1))
        out = field(b) > 0
        self.points = self.halved(a[out], b[out])[:count]

    def halved(self, a, b):
        """Return points of the wall between points inside and points outside."""
        for _ in range(64):
            middle = (a + b) / 2
            inside = (self.field(middle) <= 0)[:, None]
            a, b = np.where(inside, middle, a), np.where(inside, b, middle)
        return (a + b) / 2

    def has_both_sides(self, points, within, sides=96):
        """Return which points have points inside and outside at a distance, in some directions."""
        away = self.rng.normal(size=(sides, 1, 3))
        beside = points[None] + within * away / np.linalg.norm(away, axis=-1, keepdims=True)
        value = self.field(beside.reshape(-1, 3)).reshape(sides, -1)
        return (value <= 0).any(axis=0) & (value > 0).any(axis=0)

    def is_wall(self, points, within=EPSILON):
        """Return whether there are points inside and outside within 2^-30 of each.

        Tips of needles need many directions.
        """
        found = self.has_both_sides(points, within)
        for i in np.flatnonzero(~found):
            found[i] = self.has_both_sides(points[i : i + 1], within, 30_000)[0]
        return found

    def first_wall(self, points, halved):
        """Return the index of the first point on a wall; the `halved` one is on a wall."""
        found = self.has_both_sides(points, EPSILON)
        for i in range(halved):
            if found[i] or self.has_both_sides(points[i : i + 1], EPSILON, 30_000)[0]:
                return i
        return halved

    def nearest(self, x):
        """Return (distance, point, whether Newton's method found it) of the nearest wall to a point."""
        x = np.asarray(x, np.longdouble)
        away = np.linalg.norm((self.points - x).astype(float), axis=1)
        first = self.points[np.argsort(away)[:400]]
        starts = [first[0]]
        for point in first[1:]:
            if len(starts) < 6 and min(np.linalg.norm((point - s).astype(float)) for s in starts) > 0.05:
                starts.append(point)
        found = [first[0]]
        for start in starts:
            near = []
            for A, b, c in self.field.surfaces():
                value, g = start @ A @ start + b @ start + c, 2 * A @ start + b
                if abs(value) < 0.3 * (np.sqrt(g @ g) + 0.1):
                    near.append((A, b, c))
            for count in (1, 2, 3):
                for chosen in combinations(near, count):
                    point = stationary(x, start, chosen)
                    if point is not None:
                        found.append(point)
        found = np.array(found)
        distances = np.sqrt(((found - x) ** 2).sum(axis=1))
        nearest = np.argsort(distances, kind="stable")
        k = nearest[self.first_wall(found[nearest], int(np.flatnonzero(nearest == 0)[0]))]
        return distances[k], found[k], bool(k > 0)


def stationary(x, start, surfaces):
    """Return, by Newton's method from a start, a point of some surfaces at a stationary distance from x, or None."""
    p, count = start, len(surfaces)
    rows = np.array([2 * A @ p + b for A, b, _ in surfaces], dtype=float)
    multipliers = np.linalg.lstsq(rows.T, (x - p).astype(float), rcond=None)[0].astype(np.longdouble)
    for _ in range(40):
        gradients = [2 * A @ p + b for A, b, _ in surfaces]
        values = [p @ A @ p + b @ p + c for A, b, c in surfaces]
        residual = np.concatenate([p - x + sum(m * g for m, g in zip(multipliers, gradients, strict=True)), values])
        jacobian = np.zeros((3 + count, 3 + count), np.longdouble)
        jacobian[:3, :3] = np.eye(3) + sum(m * 2 * s[0] for m, s in zip(multipliers, surfaces, strict=True))
        jacobian[:3, 3:], jacobian[3:, :3] = np.array(gradients).T, np.array(gradients)
        try:
            step = np.linalg.solve(jacobian.astype(float), -residual.astype(float))
        except np.linalg.LinAlgError:
            return None
        length = np.linalg.norm(step[:3])
        if not np.isfinite(length):
            return None
        scale = min(1.0, 0.5 / max(length, 1e-300))
        p, multipliers = p + scale * step[:3], multipliers + scale * step[3:]
        if length < 1e-17 * (1 + float(np.abs(p).max())):
            break
    gradients = [2 * A @ p + b for A, b, _ in surfaces]
    values = [p @ A @ p + b @ p + c for A, b, c in surfaces]
    off = max((abs(v) / (np.sqrt(g @ g) + 1e-30) for v, g in zip(values, gradients, strict=True)), default=0)
    return p if off < 1e-15 and np.linalg.norm((p - start).astype(float)) < 1.5 else None
