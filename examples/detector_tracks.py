"""Straight tracks from a collision through the detector: how much of each part they cross, on average.

    python examples/detector_tracks.py [TRACKS]
    CONICOID_DEVICE=cuda python examples/detector_tracks.py 1_000_000_000

Batches bound the memory, whatever the number of tracks. With CuPy and a GPU tracks are made on the card, and sums alone
leave it.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

import conicoid as co
import detector

BATCH = 1 << 21
VERTEX = 0.003, 0.001, -0.002
"""The place of the collision, beside the walls of the quarter that is cut away, so that floats decide all tracks."""


def parts() -> co.Scene:
    """The detector, without the floor and the lamp of its picture."""
    return co.Scene(detector.scene().bodies[:-2])


def mean_lengths(scene: co.Scene, tracks: int, arrays: Any = np, seed: int = 0) -> Any:
    """Mean length in each body of tracks in all directions; `arrays` is NumPy or CuPy."""
    random, total = arrays.random.default_rng(seed), 0.0
    for begin in range(0, tracks, BATCH):
        directions = random.standard_normal((min(BATCH, tracks - begin), 3))
        lengths = scene.lengths(arrays.zeros_like(directions) + arrays.asarray(VERTEX), directions)
        total = total + arrays.asarray(lengths).sum(axis=0)
        print(f"\r{begin + len(directions):,} tracks", end="", file=sys.stderr)
    print(file=sys.stderr)
    return total / tracks


def main(tracks: int = 200_000) -> None:
    """Print a line for each part."""
    on_card = os.environ.get("CONICOID_DEVICE") == "cuda" and find_spec("cupy") is not None
    found = mean_lengths(parts(), tracks, import_module("cupy") if on_card else np)
    for number, length in enumerate(found.tolist()):
        print(f"part {number:2}: {length:.4f} m")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
