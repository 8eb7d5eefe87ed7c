"""How many points a second are located: in the order of a slice, of a voxel grid, and in none.

    python benchmarks/points.py [--bodies 1000] [--points 8000000] [--threads N]

asks `body_at`, `contains` and `bodies_at` about capped quadrics in a lattice (drums, frustums, barrels and cooling
towers, each turned its own way) and prints millions of points a second, the best of three; behind those that come in
the order of a slice or a grid, the share of the aim that the slower of `body_at` and `contains` reaches: 30 millions on
two threads. After the table the certified bounds of `distance`, of a tenth of the points.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from comparison.harness import machine

import conicoid as co
from conicoid.kernels.threads import thread_count

QUERIES = ("body_at", "contains", "bodies_at")
AIM = 30.0
"""Millions of points a second, in order, on two threads."""
SHAPES = (
    co.Cylinder((0, 0, -0.3), (0, 0, 0.3), 0.3),
    co.Cone((0, 0, -0.3), (0, 0, 0.3), 0.35, 0.1),
    co.Ellipsoid((0.4, 0.3, 0.45), z_range=(-0.2, 0.3)),
    co.OneSheetHyperboloid(9, 16, 4, z_range=(-0.3, 0.3)),
)


def lattice(count: int) -> co.Scene:
    """Return about so many bodies, at whole places from 0 on."""
    side = max(1, round(count ** (1 / 3)))
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return co.Scene([
        SHAPES[k % len(SHAPES)].rotate((1 + k % 3, 2, 3 - k % 2), 37 * k).translate(tuple(place.tolist()))
        for k, place in enumerate(places.astype(float))
    ])  # fmt: skip


def questions(side: float, count: int) -> dict[str, Any]:
    """Return points over the lattice, by their order."""
    n, wide = max(8, round(count ** (1 / 3))), max(8, round(count**0.5))
    axis, long_axis = np.linspace(-0.5, side - 0.5, n), np.linspace(-0.5, side - 0.5, wide)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    flat = np.stack(np.meshgrid(long_axis, long_axis, [side / 2 - 0.4], indexing="xy"), axis=-1)[:, :, 0]
    order = np.random.default_rng(0).permutation(n**3)
    return {
        "a slice": flat,
        "a voxel grid": grid,
        "a grid, flat": grid.reshape(-1, 3),
        "in no order": grid.reshape(-1, 3)[order],
    }


def rate(ask: Any, points: Any) -> float:
    """Millions of points a second, the best of three."""
    best = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        ask(points)
        best = min(best, time.perf_counter() - begin)
    return float(points.size / 3 / best / 1e6)


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--points", type=int, default=8_000_000)
    parser.add_argument("--threads", type=int)
    given = parser.parse_args()
    co.set_threads(given.threads)
    scene = lattice(given.bodies)
    scene.prepare()
    side = round(given.bodies ** (1 / 3))
    scene.body_at(np.zeros((64, 3)))
    print("\n".join(machine([])))
    print(f"{len(scene.bodies)} capped quadrics, Mpoint/s, {thread_count()} threads")
    print(f"{'':14}" + "".join(f"{query:>10}" for query in QUERIES) + f"{'aim':>10}")
    for name, points in questions(side, given.points).items():
        rates = [rate(getattr(scene, query), points) for query in QUERIES]
        share = f"{min(rates[:2]) / AIM:9.2f}x" if name != "in no order" else ""
        print(f"{name:14}" + "".join(f"{each:10.1f}" for each in rates) + share)
    for name, points in questions(side, given.points // 10).items():
        print(f"distance, {name:14}{rate(scene.distance, points):9.2f}")


if __name__ == "__main__":
    main()
