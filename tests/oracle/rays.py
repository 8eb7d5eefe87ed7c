"""Rays that are hard on a shape: far, grazing, axis-parallel, along asymptotes, from inside."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from .cases import Case
from .draws import Random, direction
from .formula import Formula, Surface
from .precision import mp
from .restricted import Line, Restricted, line
from .sheets import SheetOracle, sheet_crossings
from .trace import exact_crossings

Pair = tuple[np.ndarray, np.ndarray]


class Aim:
    """Where a case is and which surfaces it has."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.center, self.size = case.world_center, case.world_size
        self.known: list[np.ndarray] = []
        reference = case.reference()
        if isinstance(reference, SheetOracle):
            self.formula: Formula | None = reference.clip
            self.surfaces: list[Surface] = [reference.surface]
        else:
            self.formula = reference
            self.surfaces = list(dict.fromkeys(reference.surfaces()))

    def target(self, random: Random) -> np.ndarray:
        """A point in a ball around the case, denser towards the middle, or near a point known to be on it."""
        if self.known and random.random() < 0.5:
            point = self.known[random.integers(len(self.known))]
            return point + direction(random) * self.size * 10 ** random.uniform(-4, -1)
        return self.center + direction(random) * self.size * 0.4 * random.random()

    def look(self, random: Random, tries: int = 25) -> None:
        """Find a few points of the shape itself, with random lines through the ball."""
        reference, size = self.case.reference(), mp.mpf(self.size)
        for _ in range(tries):
            through = line(self.target(random), direction(random))
            if isinstance(reference, SheetOracle):
                times = [c.crossing.t for c in sheet_crossings(reference, through, size, 4 * size) if c.on]
            else:
                times = [c.t for c in exact_crossings(reference, _restricted(reference, through, self.size), 4 * size)]
            self.known += [np.array([float(x) for x in through.at(t)]) for t in times]

    def distance(self, random: Random) -> float:
        """One to a million sizes."""
        return float(self.size * 10 ** random.uniform(0, 6))

    def on_surface(self, random: Random) -> tuple[np.ndarray, np.ndarray] | None:
        """A point of one of the surfaces near the case, and the unit normal there."""
        surface = self.surfaces[random.integers(len(self.surfaces))]
        target, d = self.target(random), direction(random)
        through = line(target, d)
        on = Restricted(surface, through, mp.mpf(self.size), {})
        roots = [t for t in on.roots if abs(t) < 4 * self.size]
        if not roots:
            return None
        t = roots[random.integers(len(roots))]
        normal = np.array([float(g / _largest(on.gradient(t))) for g in on.gradient(t)])
        if not normal.any():
            return None
        return target + float(t) * d, normal / np.linalg.norm(normal)

    def interior(self, random: Random) -> np.ndarray | None:
        """A point inside, by the exact crossings of a random line."""
        if self.formula is None:
            return None
        through = line(self.target(random), direction(random))
        found = exact_crossings(self.formula, _restricted(self.formula, through, self.size), 10 * mp.mpf(self.size))
        if len(found) < 2:
            return None
        pairs = [(a.t, b.t) for a, b in itertools.pairwise(found) if a.entering]
        if not pairs:
            return None
        low, high = pairs[random.integers(len(pairs))]
        return np.array([float(x) for x in through.at(low + (high - low) * float(random.random()))])


def _restricted(formula: Formula, through: Line, size: float) -> dict[Surface, Restricted]:
    frames: dict[int, Any] = {}
    return {s: Restricted(s, through, mp.mpf(size), frames) for s in dict.fromkeys(formula.surfaces())}


def _largest(v: tuple[Any, ...]) -> Any:
    return max(abs(x) for x in v) or mp.one


def aimed(aim: Aim, random: Random) -> Pair:
    target, d = aim.target(random), direction(random)
    return target - d * aim.distance(random), d


def grazing(aim: Aim, random: Random) -> Pair:
    """Past a point of the surface, along a tangent, 2^-k of the size above or below it."""
    found = aim.on_surface(random)
    if found is None:
        return aimed(aim, random)
    point, normal = found
    tangent = np.cross(normal, direction(random))
    tangent /= np.linalg.norm(tangent)
    offset = normal * aim.size * random.choice([-1, 1]) * 2.0 ** -random.integers(1, 50)
    away = aim.distance(random) if random.random() < 0.5 else aim.size * random.uniform(0.5, 4)
    return point + offset - tangent * away, tangent


def rows_of(aim: Aim, random: Random) -> np.ndarray:
    """Columns: the directions of the own axes of one of the surfaces in the world."""
    own = aim.surfaces[random.integers(len(aim.surfaces))].own
    return np.array([[float(x) for x in row] for row in own.inverse().rows])


def parallel(aim: Aim, random: Random) -> Pair:
    """Along an axis of the world or of the shape, or in one of their planes."""
    axes = np.eye(3) if random.random() < 0.5 else rows_of(aim, random)
    i = int(random.integers(3))
    d = axes[:, i] * random.choice([-1.0, 1.0])
    if random.random() < 0.3:
        d = d + axes[:, i - 1] * float(random.normal())
    d = d / (1.0 if random.random() < 0.5 else np.linalg.norm(d))
    return aim.target(random) - d / np.linalg.norm(d) * aim.distance(random), d


def asymptotic(aim: Aim, random: Random) -> Pair:
    """Where the second-order part of a surface vanishes: along rulings and asymptotes, to one rounding."""
    surface = aim.surfaces[random.integers(len(aim.surfaces))]
    form = np.zeros((3, 3))
    for k, i, j in surface.terms:
        if j < 3:
            form[i, j] += float(k) / 2
            form[j, i] += float(k) / 2
    if not form.any():
        return parallel(aim, random)
    form /= np.abs(form).max()
    u, v = direction(random), direction(random)
    a, b, c = v @ form @ v, u @ form @ v, u @ form @ u
    if b * b - a * c <= 0 or a == 0:
        return parallel(aim, random)
    own = u + v * (-b + random.choice([-1, 1]) * np.sqrt(b * b - a * c)) / a
    d = np.array([[float(x) for x in row] for row in surface.own.inverse().rows]) @ own
    d /= np.linalg.norm(d)
    found = aim.on_surface(random) if random.random() < 0.5 else None
    target = aim.target(random) if found is None else found[0]
    return target - d * aim.distance(random) * 1e-3, d


def inside_out(aim: Aim, random: Random) -> Pair:
    point = aim.interior(random)
    return aimed(aim, random) if point is None else (point, direction(random))


STRATA: dict[str, tuple[float, Callable[[Aim, Random], Pair]]] = {
    "aimed": (0.35, aimed),
    "grazing": (0.25, grazing),
    "parallel": (0.15, parallel),
    "asymptotic": (0.1, asymptotic),
    "inside": (0.15, inside_out),
}


def rays(case: Case, count: int, random: Random) -> Pair:
    """(count, 3) origins and directions; directions of lengths 10^U(-3, 3), some of length one."""
    aim = Aim(case)
    aim.look(random)
    names = list(STRATA)
    weights = np.array([STRATA[name][0] for name in names])
    picked = random.choice(len(names), size=count, p=weights / weights.sum())
    pairs = [STRATA[names[i]][1](aim, random) for i in picked]
    origins, directions = (np.array([p[k] for p in pairs], dtype=float).reshape(count, 3) for k in (0, 1))
    lengths = np.where(random.random(count) < 0.5, 1.0, 10 ** random.uniform(-3, 3, count))
    return origins, directions * lengths[:, None]
