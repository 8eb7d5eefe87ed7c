"""Families of rays, each hard in its own way. Every one gives (count, 3) origins and directions, or fewer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .aim import Aim, Array, directions

Pair = tuple[Array, Array]
LEAST, MOST = 1e-100, 1e100


def _seen(aim: Aim, places: Array, d: Array, away: Array) -> Pair:
    """Rays from so many sizes before the places."""
    return aim.world(places - d * away[:, None]), d


def _distance(aim: Aim, count: int, decades: float = 1.0) -> Array:
    return 10 ** aim.random.uniform(-0.5, decades, count)


def aimed(aim: Aim, count: int) -> Pair:
    places, _ = aim.pick(aim.boundary, count)
    spread = directions(aim.random, count) * 10 ** aim.random.uniform(-4, 0, (count, 1))
    return _seen(
        aim,
        places + spread * aim.random.integers(0, 2, (count, 1)),
        directions(aim.random, count),
        _distance(aim, count),
    )


def far(aim: Aim, count: int) -> Pair:
    places, _ = aim.pick(aim.boundary, count)
    d = directions(aim.random, count)
    return _seen(aim, places + 0.3 * directions(aim.random, count), d, _distance(aim, count, 8.0))


def grazing(aim: Aim, count: int) -> Pair:
    """Along a tangent, 2^-k sizes above or below the surface, k to 60, or on it as nearly as floats say."""
    places, index = aim.pick(aim.boundary, count)
    normals = aim.normals(index)
    tangent = np.cross(normals, directions(aim.random, count))
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    k = aim.random.integers(1, 61, count)
    offset = np.where(aim.random.random(count) < 0.1, 0.0, aim.random.choice([-1.0, 1.0], count) * 2.0**-k)
    decades = 8.0 if aim.random.random() < 0.3 else 1.0
    return _seen(aim, places + normals * offset[:, None], tangent, _distance(aim, count, decades))


def edges(aim: Aim, count: int) -> Pair:
    """Through edges and corners, or ulps beside them, from any side or along the edge."""
    half = count // 2
    places = np.concatenate([aim.pick(aim.edges, count - half)[0], aim.pick(aim.corners, half)[0]])
    nudge = directions(aim.random, count) * (2.0 ** -aim.random.integers(30, 60, (count, 1)))
    places = places + nudge * aim.random.integers(0, 2, (count, 1))
    d = directions(aim.random, count)
    along, _ = aim.pick(aim.edges, count)
    chord = along - places
    size = np.linalg.norm(chord, axis=1, keepdims=True)
    between = (aim.random.random((count, 1)) < 0.2) & (size > 1e-9)
    return _seen(aim, places, np.where(between, chord / np.where(size > 0, size, 1), d), _distance(aim, count))


def parallel(aim: Aim, count: int) -> Pair:
    """Along the axes of the world, or along and across normals of surfaces, as nearly as floats say."""
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
    return _seen(aim, places + beside * aim.random.integers(0, 2, (count, 1)), d, _distance(aim, count))


def asymptotic(aim: Aim, count: int) -> Pair:
    """Where the second-order part vanishes: along rulings and asymptotes."""
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
    return _seen(aim, places + beside * aim.random.integers(0, 2, (count, 1)), d, _distance(aim, count))


def starting(aim: Aim, count: int) -> Pair:
    """From the surface as nearly as floats say, or from just beside it."""
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
    """A mixture, within the documented domain; half of the directions of length 1, most others of 10^U(-3, 3), some of any."""
    share = sum(weight for weight, _ in FAMILIES.values())
    parts = [family(aim, max(2, round(count * weight / share))) for weight, family in FAMILIES.values()]
    origins, d = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    decades = aim.random.choice([0.0, 3.0, 95.0], len(d), p=[0.5, 0.45, 0.05])
    return in_domain(origins, d * 10 ** (decades * aim.random.uniform(-1, 1, len(d)))[:, None])


def in_domain(origins: Array, d: Array) -> Pair:
    """Numbers under 1e-100 become zero; rays with numbers over 1e100 or without a direction go."""
    origins, d = (np.where(np.abs(x) < LEAST, 0.0, x) for x in (origins, d))
    good = (np.abs(origins) <= MOST).all(axis=1) & (np.abs(d) <= MOST).all(axis=1) & (d != 0).any(axis=1)
    return origins[good], d[good]
