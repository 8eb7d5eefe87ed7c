"""Scenes whose bodies are lowered together have the tables of scenes whose bodies are lowered one by one, to the bit.

The scenes are random, with what makes lowering hard: bodies on a grid that share walls, the same motion used by many,
motions that lead there and back, copies of one shape, and Booleans of them.
"""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare import batch_lowering as together_module, lowering
from conicoid.prepare.tape import recording_cache as recordings

from ..samples import drawn
from .tapes.test_recorded import KINDS, MOTIONS, SOLIDS


def solids_of(rng: random.Random) -> list[Any]:
    """Shapes of two or three kinds, as many as are lowered together, in no order."""
    made: list[Any] = []
    for _ in range(rng.randint(2, 3)):
        kind, motion = rng.choice(list(KINDS)), MOTIONS[rng.choice(list(MOTIONS))]
        shared = motion(rng)
        for _ in range(rng.randint(6, 14)):
            move = shared if rng.random() < 0.5 else motion(rng)
            made.append(move(KINDS[kind](rng)))
    if rng.random() < 0.5:
        built = SOLIDS[rng.choice(list(SOLIDS))]
        kinds = [rng.choice(("Sphere on a grid", "Box on a grid", "upright Cylinder", "Ellipsoid")) for _ in range(3)]
        made += [built(rng, *(KINDS[kind](rng) for kind in kinds)).rotate("z", 90) for _ in range(8)]
    made += [rng.choice(made).translate((1.0, 0.0, -2.0)) for _ in range(3)]
    rng.shuffle(made)
    return made


def columns(shapes: list[Any]) -> dict[str, Any]:
    """All that lowering makes of shapes, by name."""
    lowered = lowering.lower([co.Body(shape) for shape in shapes]).limited()
    found: dict[str, Any] = {name: getattr(lowered.tables, name) for name in lowered.tables._fields}
    for name in ("boxes", "frames", "body_frame", "body_item"):
        found[name] = getattr(lowered, name)
    for name in ("planes", "spheres", "quadrics", "vertices"):
        found[f"rest of {name}"] = getattr(lowered.rest, name)
    return found


def assert_same_tables(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    shapes = solids_of(random.Random(seed))
    together = columns(shapes)
    with monkeypatch.context() as patched:
        patched.setattr(recordings, "FEWEST", 10**9)
        patched.setattr(together_module, "_FEWEST_OF_PLAN", 10**9)
        alone = columns(solids_of(random.Random(seed)))
    for name, column in alone.items():
        assert column.dtype == together[name].dtype, name
        assert np.ascontiguousarray(column).tobytes() == np.ascontiguousarray(together[name]).tobytes(), (seed, name)


@pytest.mark.parametrize("seed", range(12))
def test_tables_are_the_same_to_the_bit(seed, monkeypatch):
    assert_same_tables(seed, monkeypatch)


@pytest.mark.parametrize("seed", range(12, 18))
def test_tables_of_bodies_in_blocks_are_the_same_to_the_bit(seed, monkeypatch):
    """As many bodies at a time as make a recording worth while, with some left over that are too few."""
    monkeypatch.setattr(together_module, "_AT_ONCE", recordings.FEWEST // 2 + seed % 5)
    assert_same_tables(seed, monkeypatch)


@pytest.mark.deep
def test_tables_of_more_scenes_are_the_same_to_the_bit(monkeypatch):
    for seed in drawn(range(18, 10_000), 100):
        assert_same_tables(seed, monkeypatch)
