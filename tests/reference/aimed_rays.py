"""Rays that are hard: far, grazing, through edges and corners, along axes, rulings and asymptotes, from surfaces.

Places are found in floats and in bulk, because many hard places matter more than exact ones (`whole_rays` has those).
"""

import itertools
import math
from collections.abc import Callable

import numpy as np

from .forms import PAIRS
from .numbers import ONE, ZERO, number
from .quadratics import Table
from .random_shapes import LEAST, MOST, Random
from .trace import Array, Trace

Pair = tuple[Array, Array]


def directions(random: Random, count: int) -> Array:
    v = random.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


class Aim:
    """Bodies as targets of rays; places are relative to an anchor, in units of a power of two."""

    def __init__(self, table: Table, center: Array, size: float, random: Random) -> None:
        self.table, self.random = table, random
        self.anchor, self.exponent = np.asarray(center, float), math.frexp(size)[1]
        unit = number(2.0**self.exponent)
        axes = [[unit if i == j else ZERO for j in range(3)] for i in range(3)]
        back = [(*axis, number(x)) for axis, x in zip(axes, self.anchor.tolist(), strict=True)]
        back.append((ZERO, ZERO, ZERO, ONE))
        self.matrices = np.zeros((len(table.forms), 4, 4))
        for form, matrix in zip(table.forms, self.matrices, strict=True):
            k = [x.fraction for x in form.carried(back).k]
            largest = max(map(abs, k))
            for (i, j), x in zip(PAIRS, k, strict=True):
                share = x / largest if x else x
                matrix[i, j] = matrix[j, i] = int(share.p) / int(share.q) / (1 if i == j else 2)
        for count in (200, 1000):
            self._look(self._through(count))
            if len(self.boundary) > 20:
                break
        self.edges, self.corners = self._corners(2), self._corners(3)

    def world(self, places: Array) -> Array:
        return self.anchor + np.ldexp(places, self.exponent)

    def _through(self, count: int) -> Pair:
        """Return rays through a ball of the size."""
        target = directions(self.random, count) * 0.6 * self.random.random((count, 1))
        d = directions(self.random, count)
        return target - 3 * d, d

    def _look(self, rays: Pair) -> None:
        """Find points of the boundary and points inside."""
        places, d = rays
        found = Trace(self.table, self.world(places), d).crossings
        t = np.ldexp(found.t, -self.exponent)
        near = np.abs(t) < 100
        places = places[found.ray] + t[:, None] * d[found.ray]
        pair = np.flatnonzero((np.diff(found.ray) == 0) & found.entering[:-1] & near[:-1] & near[1:])
        self.boundary, self.form, self.inside = places[near], found.surface[near], (places[pair] + places[pair + 1]) / 2
        if not len(self.boundary):
            self.boundary, self.form = np.zeros((1, 3)), np.zeros(1, int)
        self.inside = self.inside if len(pair) else np.zeros((1, 3))

    def gradient(self, form: Array, places: Array) -> Array:
        m = self.matrices[form]
        return np.einsum("nij,nj->ni", m[:, :3, :3], places) + m[:, :3, 3]

    def value(self, form: Array, places: Array) -> Array:
        x = np.concatenate([places, np.ones((len(places), 1))], axis=1)
        return np.einsum("ni,nij,nj->n", x, self.matrices[form], x)

    def _corners(self, count: int) -> Array:
        """Find points on several surfaces at once, by Newton's method with least steps from the boundary."""
        sets = list(itertools.combinations(range(len(self.matrices)), count))
        if not sets:
            return self.boundary
        picked = np.array(sets)[self.random.integers(len(sets), size=1000)]
        x = self.boundary[self.random.integers(len(self.boundary), size=1000)]
        with np.errstate(all="ignore"):
            for _ in range(12):
                rows = np.stack([2 * self.gradient(picked[:, k], x) for k in range(count)], axis=1)
                size = np.linalg.norm(rows, axis=2)
                off = np.stack([self.value(picked[:, k], x) for k in range(count)], axis=1) / size
                rows /= size[..., None]
                gram = np.nan_to_num(rows @ rows.transpose(0, 2, 1), posinf=0, neginf=0) + 1e-12 * np.eye(count)
                step = np.einsum("nki,nkj,nj->ni", rows, np.linalg.inv(gram), off)
                x = np.where(np.abs(x - step) < 1e3, x - step, 0.0)
            good = np.isfinite(x).all(axis=1) & (np.linalg.norm(x, axis=1) < 5) & (np.abs(step).max(axis=1) < 1e-12)
        return x[good] if good.any() else self.boundary

    def pick(self, places: Array, count: int) -> tuple[Array, Array]:
        """Return (some of the places, their indices)."""
        index = self.random.integers(len(places), size=count)
        return places[index], index

    def normals(self, index: Array) -> Array:
        """Return unit normals of boundary points, and some direction where the gradient vanishes."""
        g = self.gradient(self.form[index], self.boundary[index])
        size = np.linalg.norm(g, axis=1, keepdims=True)
        return np.where(size > 0, g / np.where(size > 0, size, 1), directions(self.random, len(index)))


def _from_afar(aim: Aim, places: Array, d: Array, away: Array) -> Pair:
    """Return rays from so many sizes before the places."""
    return aim.world(places - d * away[:, None]), d


def _distance(aim: Aim, count: int, decades: float = 1.0) -> Array:
    return 10 ** aim.random.uniform(-0.5, decades, count)


def aimed(aim: Aim, count: int) -> Pair:
    places, _ = aim.pick(aim.boundary, count)
    spread = directions(aim.random, count) * 10 ** aim.random.uniform(-4, 0, (count, 1))
    return _from_afar(
        aim,
        places + spread * aim.random.integers(0, 2, (count, 1)),
        directions(aim.random, count),
        _distance(aim, count),
    )


def far(aim: Aim, count: int) -> Pair:
    places, _ = aim.pick(aim.boundary, count)
    d = directions(aim.random, count)
    return _from_afar(aim, places + 0.3 * directions(aim.random, count), d, _distance(aim, count, 8.0))


def grazing(aim: Aim, count: int) -> Pair:
    """Return rays along a tangent, 2^-k sizes above or below the surface, k to 60, or on it to the nearest float."""
    places, index = aim.pick(aim.boundary, count)
    normals = aim.normals(index)
    tangent = np.cross(normals, directions(aim.random, count))
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    k = aim.random.integers(1, 61, count)
    offset = np.where(aim.random.random(count) < 0.1, 0.0, aim.random.choice([-1.0, 1.0], count) * 2.0**-k)
    decades = 8.0 if aim.random.random() < 0.3 else 1.0
    return _from_afar(aim, places + normals * offset[:, None], tangent, _distance(aim, count, decades))


def edges(aim: Aim, count: int) -> Pair:
    """Return rays through edges and corners, or ulps beside them, from any side or along the edge."""
    half = count // 2
    places = np.concatenate([aim.pick(aim.edges, count - half)[0], aim.pick(aim.corners, half)[0]])
    nudge = directions(aim.random, count) * (2.0 ** -aim.random.integers(30, 60, (count, 1)))
    places = places + nudge * aim.random.integers(0, 2, (count, 1))
    d = directions(aim.random, count)
    along, _ = aim.pick(aim.edges, count)
    chord = along - places
    size = np.linalg.norm(chord, axis=1, keepdims=True)
    between = (aim.random.random((count, 1)) < 0.2) & (size > 1e-9)
    return _from_afar(aim, places, np.where(between, chord / np.where(size > 0, size, 1), d), _distance(aim, count))


def parallel(aim: Aim, count: int) -> Pair:
    """Return rays along the axes of the world, or along and across normals of surfaces, to the nearest float."""
    axes = np.eye(3)[aim.random.integers(3, size=count)] * aim.random.choice([-1.0, 1.0], (count, 1))
    mixed = axes + np.roll(axes, 1, axis=1) * aim.random.normal(size=(count, 1))
    places, index = aim.pick(aim.boundary, count)
    normals = aim.normals(index)
    across = np.cross(normals, aim.normals(aim.random.integers(len(aim.boundary), size=count)))
    across = np.where(np.abs(across).max(axis=1, keepdims=True) > 1e-3, across, axes)
    kinds = np.stack([axes, axes, mixed, normals, across])
    d = kinds[aim.random.integers(len(kinds), size=count), np.arange(count)]
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    beside = directions(aim.random, count) * 10 ** aim.random.uniform(-9, -1, (count, 1))
    return _from_afar(aim, places + beside * aim.random.integers(0, 2, (count, 1)), d, _distance(aim, count))


def asymptotic(aim: Aim, count: int) -> Pair:
    """Return rays along which the second-order part vanishes: rulings and asymptotes."""
    places, index = aim.pick(aim.boundary, count)
    form = aim.matrices[aim.form[index]][:, :3, :3]
    u, v = directions(aim.random, count), directions(aim.random, count)
    a, b, c = (np.einsum("ni,nij,nj->n", p, form, q) for p, q in ((v, v), (u, v), (u, u)))
    with np.errstate(all="ignore"):
        root = np.sqrt(b * b - a * c)
        d = u + v * ((-b + aim.random.choice([-1, 1], count) * root) / a)[:, None]
        size = np.linalg.norm(d, axis=1, keepdims=True)
        d = np.where(np.isfinite(size) & (size > 1e-6), d / size, directions(aim.random, count))
    beside = directions(aim.random, count) * 10 ** aim.random.uniform(-9, -1, (count, 1))
    return _from_afar(aim, places + beside * aim.random.integers(0, 2, (count, 1)), d, _distance(aim, count))


def starting(aim: Aim, count: int) -> Pair:
    """Return rays from the surface to the nearest float, or from just beside it."""
    places, _ = aim.pick(np.concatenate([aim.boundary, aim.boundary, aim.edges]), count)
    beside = directions(aim.random, count) * 10 ** aim.random.uniform(-17, -1, (count, 1))
    return aim.world(places + beside * aim.random.integers(0, 2, (count, 1))), directions(aim.random, count)


def within(aim: Aim, count: int) -> Pair:
    return aim.world(aim.pick(aim.inside, count)[0]), directions(aim.random, count)


FAMILIES: dict[str, tuple[float, Callable[[Aim, int], Pair]]] = {
    "aimed": (0.3, aimed),
    "far": (0.1, far),
    "grazing": (0.2, grazing),
    "edges": (0.1, edges),
    "parallel": (0.1, parallel),
    "asymptotic": (0.05, asymptotic),
    "starting": (0.1, starting),
    "within": (0.05, within),
}


def rays(aim: Aim, count: int) -> Pair:
    """Return a mixture, within the documented domain.

    Half of the directions have length 1, most others 10^U(-3, 3), some any.
    """
    share = sum(weight for weight, _ in FAMILIES.values())
    parts = [family(aim, max(2, round(count * weight / share))) for weight, family in FAMILIES.values()]
    origins, d = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    decades = aim.random.choice([0.0, 3.0, 95.0], len(d), p=[0.5, 0.45, 0.05])
    return in_domain(origins, d * 10 ** (decades * aim.random.uniform(-1, 1, len(d)))[:, None])


def in_domain(origins: Array, d: Array) -> Pair:
    """Replace numbers under 1e-100 by zero, and drop rays with numbers over 1e100 or without a direction."""
    origins, d = (np.where(np.abs(x) < LEAST, 0.0, x) for x in (origins, d))
    good = (np.abs(origins) <= MOST).all(axis=1) & (np.abs(d) <= MOST).all(axis=1) & (d != 0).any(axis=1)
    return origins[good], d[good]
