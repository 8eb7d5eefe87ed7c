"""Steady heat in a drilled block, by walks on spheres: no mesh, only how far the nearest wall is.

The temperature at a point is the mean over the walls of where a random walk from it first meets them. It leaves the
ball that touches the nearest wall as likely in all directions, so it jumps there at once, again and again, until it is
beside a wall. (M. E. Muller: Some continuous methods for the Dirichlet problem, Ann. Math. Statist. 27, 1956.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co

BESIDE = 1e-4
"""A walk ends this near a wall."""
BORES = [
    co.Cylinder((-1.5, 0, -0.4), (-1.5, 0, 0.4), 0.55),
    co.Cylinder((0.35, -1, 0), (0.35, 1, 0), 0.25),
    co.Cone((1.6, 0.1, -0.4), (1.6, 0.1, 0.4), 0.45, 0.25),
]
BLOCK = co.Box((-2.5, -1, -0.4), (2.5, 1, 0.4)) - BORES[0] - BORES[1] - BORES[2]
FACES_OF_A_BOX = 6
COLORS = np.array([(0.01, 0.02, 0.2), (0.15, 0.05, 0.5), (0.7, 0.05, 0.25), (1.0, 0.4, 0.02), (1.0, 0.95, 0.6)])


def jump(points: Any, away: Any, rng: np.random.Generator) -> Any:
    """Anywhere on the spheres about points with these radii."""
    sides = rng.normal(size=points.shape)
    return points + (away / np.linalg.norm(sides, axis=1))[:, None] * sides


def heat(scene: co.Scene, points: Any, wall: Callable[[Any], Any], walks: int, seed: int = 0) -> tuple[Any, Any]:
    """(temperature, its standard error) at points inside of a scene's one body; `wall` knows those of nearest walls."""
    rng = np.random.default_rng(seed)
    at = np.repeat(np.asarray(points, float), walks, axis=0)
    left = np.arange(len(at))
    while len(left):
        away = scene.distance(at[left]).lower.copy()  # never too far
        small = away < BESIDE  # beside a wall, or beside an edge, where bounds are less than the distance
        away[small] = np.abs(scene.distance(at[left[small]], exact=True).distance)
        left, away = left[away >= BESIDE], away[away >= BESIDE]
        at[left] = jump(at[left], away, rng)
    found = wall(scene.distance(at, exact=True)).reshape(len(points), walks)
    return found.mean(axis=1), found.std(axis=1) / np.sqrt(walks)


def temperature(nearest: co.Distances) -> Any:
    """Of the block: its outside is cold, its bores are hot."""
    return np.where(nearest.face < FACES_OF_A_BOX, 0.0, 1.0)


def shell(inner: float, outer: float, radius: Any) -> Any:
    """Between two spheres, a hot one and a cold one: the solution in closed form."""
    return (1 / radius - 1 / outer) / (1 / inner - 1 / outer)


def colored(values: Any) -> Any:
    """Colours for numbers from 0 to 1."""
    places = np.linspace(0, 1, len(COLORS))
    return np.stack([np.interp(values, places, COLORS[:, k]) for k in range(3)], axis=-1)


def smoothed(values: Any) -> Any:
    """The mean of each pixel and its neighbours, where those have values (NaN elsewhere): nine times as many walks."""
    wide = np.pad(values, 1, constant_values=np.nan)
    rows, columns = values.shape
    parts = np.stack([wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)])
    known = np.isfinite(parts)
    total, count = np.where(known, parts, 0.0).sum(axis=0), known.sum(axis=0)
    return np.where(np.isfinite(values), total / np.maximum(count, 1), np.nan)


def walked(scene: co.Scene, points: Any, wall: Callable[[Any], Any], walks: int) -> Any:
    """Temperatures of a picture of points (rows, columns, 3); NaN outside of the body."""
    values = np.full(points.shape[:2], np.nan)
    inside = scene.contains(points)
    for row in range(len(points)):  # some hundred thousand walks at a time
        if inside[row].any():
            values[row, inside[row]] = heat(scene, points[row, inside[row]], wall, walks, row)[0]
    return smoothed(values)


def in_plane(center: tuple[float, float], size: tuple[float, float], height: int) -> Any:
    """Points of z = 0 in the middles of pixels, the uppermost row first."""
    step = size[1] / height
    x = center[0] + (np.arange(round(size[0] / step)) + 0.5) * step - size[0] / 2
    y = center[1] - (np.arange(height) + 0.5) * step + size[1] / 2
    return np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1)


def painted(values: Any) -> Any:
    """Colours with a darker line where a temperature is a tenth."""
    tenths = np.floor(10 * np.clip(values, 0, 0.999))
    line = np.zeros(values.shape, bool)
    line[:, 1:] |= np.abs(np.diff(tenths, axis=1)) == 1
    line[1:] |= np.abs(np.diff(tenths, axis=0)) == 1
    pixels = colored(np.nan_to_num(values)) * np.where(line, 0.55, 1.0)[..., None]
    return np.where(np.isfinite(values)[..., None], pixels, 0.8)


def picture(height: int = 168, walks: int = 200) -> co.Image:
    """The block's middle; and between two spheres walks (left) beside the closed form (right)."""
    block = walked(co.Scene([BLOCK]), in_plane((0, 0), (5.1, 2.1), height), temperature, walks)
    points = in_plane((0, 0), (4.2, 4.2), height)
    radius, half = np.linalg.norm(points, axis=-1), height // 2
    exactly = np.where((radius > 1) & (radius < 2), shell(1, 2, np.clip(radius, 1, 2)), np.nan)
    hollow = co.Scene([co.Sphere(2) - co.Sphere(1)])
    found = walked(hollow, points[:, : half + 1], lambda nearest: nearest.face == 1, walks)[:, :half]
    ring = np.concatenate([painted(found), painted(exactly[:, half:])], axis=1)
    ring[:, half] = 1.0
    gap = np.ones((height, height // 12, 3))
    return co.Image(np.concatenate([painted(block), gap, ring], axis=1))


if __name__ == "__main__":
    hollow = co.Scene([co.Sphere(2) - co.Sphere(1)])
    places = np.array([(1.25, 0, 0), (0, 1.5, 0), (0, 0, 1.75)])
    for place, value, error in zip(places, *heat(hollow, places, lambda d: d.face == 1, 4000), strict=True):
        print(f"{place}: {value:.4f} +- {error:.4f}, exactly {shell(1, 2, np.linalg.norm(place)):.4f}")
    picture().save("walk_on_spheres.png")
