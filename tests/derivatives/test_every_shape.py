"""Derivatives of hits by every number of every shape, against differences of first hits of shapes with other numbers.

What hits are is judged by `tests/reference`. Differences of second and of fourth order agree where there is a derivative.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..contract.examples import MOTIONS, every_example
from ..samples import sampled

EXAMPLES = dict(every_example())
FIELDS = ("t", "point", "normal", "uv")
STEP = 2.0**-16
SMOOTH, KINK, SHARE, CLOSE = 1e-4, 1e-4, 0.05, 1e-8
"""Differences of both orders, and of both sides, are so near; derivatives are nearer to those of fourth order, by a share."""
OPEN = {"Conic-4": ("",), "Lens-4": ("",), "SphereSection-6": ("",), "Revolution": ("[1]",), "Polycone": ("",),
        "Cylinder-4": ("angle",), "Cone-6": ("angle",), "Tube-4": ("angle",), "SphereSection-5": ("angle",),
        "SphereSection": ("range[0]", "range[1]")}  # fmt: skip
"""Ends of the names of numbers that have no derivative: of walls that are one for these numbers alone, of heights by which a
level wall becomes a cone, of a rim at an equator, of walls that are planes at half a turn or a right angle."""
TILTS = ("start", "end", "normal", "offsets", "coefficients", "outline", "scale_at_top", "z_range", "vertices")
"""Parts of the names of numbers by which `uv` may have no derivative, since they tilt an axis or bend a plane."""


def rays_at(shape: Any, count: int, seed: int) -> tuple[Any, Any]:
    """Rays through the part of a shape that is near its middle, or near that of what a complement leaves out."""
    random = np.random.default_rng(seed)
    low, high = (np.clip(end, -4, 4) for end in shape.bounds)
    if isinstance(shape, co.Solid) and np.isinf(shape.bounds).all() and np.isfinite((~shape).bounds).all():
        low, high = (~shape).bounds
    inside = random.uniform(low - 0.1, high + 0.1, (count, 3))
    directions = random.normal(size=(count, 3)) * random.uniform(0.5, 2, (count, 1))
    return inside - directions * random.uniform(2, 6, (count, 1)), directions


def wrong(name: str, motion: str, numbers: int) -> tuple[list[str], int]:
    """(what is wrong with derivatives by some numbers and by the rays, how many were compared)."""
    shape, seed = MOTIONS[motion](EXAMPLES[name]), zlib.crc32(f"{name} {motion}".encode())
    scene = co.Scene([co.Body(shape, name="it")])
    parameters, random = co.parameters(scene), np.random.default_rng(seed)
    hits = scene.first_hit(*rays_at(shape, 60, seed))
    hits = hits[hits.hit]
    ways = random.normal(size=(2, *hits.point.shape))
    values, found, compared = np.array(parameters.values), [], 0
    changes = list(np.eye(len(values))[random.permutation(len(values))[:numbers]])
    if isinstance(shape, co.Polygon):  # which stays flat where all corners move alike
        changes += [np.array([name.endswith(f"[{k}]") for name in parameters.names], float) for k in range(3)]
    changes.append(np.zeros(len(values)))  # the rays alone
    for change in changes:
        try:
            scenes = {side: parameters.scene(values + side * STEP * change) for side in (1, -1, 2, -2)}
        except ValueError:
            continue  # at the end of what is allowed: a full turn, a pole, a polygon that is flat no more
        ends = {
            side: there.first_hit(
                hits.rays.origins + side * STEP * ways[0], hits.rays.directions + side * STEP * ways[1]
            )
            for side, there in scenes.items()
        }
        same = np.all([(end.face == hits.face) & (end.body == hits.body) for end in ends.values()], axis=0)
        own = hits.jvp(parameters, change, d_origins=ways[0], d_directions=ways[1])
        number = parameters.names[int(change.argmax())] if change.any() else "the rays"
        ends_open = [end for start, end in OPEN.items() if name.startswith(start)]
        is_open = any(number.endswith(end) for end in ends_open)
        for field in FIELDS:
            at = {side: getattr(end, field)[same] for side, end in ({0: hits} | ends).items()}
            one, two = ((at[k] - at[-k]) / (2 * k * STEP) for k in (1, 2))
            slope, derived = (4 * one - two) / 3, getattr(own, field)[same]
            size_of, apart = 1 + np.abs(slope), np.abs(slope - one)
            smooth = (apart < SMOOTH * size_of) & (np.abs(at[1] - 2 * at[0] + at[-1]) < KINK * STEP * size_of)
            undefined = np.isnan(derived) & (is_open or (field == "uv" and any(part in number for part in TILTS)))
            bad = smooth & ~undefined & ~(np.abs(derived - slope) <= SHARE * apart + CLOSE * size_of)
            compared += int((smooth & ~undefined).sum())
            if bad.any():
                found.append(f"{field} by {number}: {derived[bad][:2]}, by differences {slope[bad][:2]}")
    return found, compared


@pytest.mark.parametrize("name", sampled(EXAMPLES, 4))
def test_by_some_numbers(name):
    found, compared = wrong(name, sorted(MOTIONS)[len(name) % len(MOTIONS)], 4)
    assert not found
    assert compared or name.startswith(tuple(OPEN))


@pytest.mark.deep
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", EXAMPLES)
def test_by_every_number(name, motion):
    found, compared = wrong(name, motion, 1000)
    assert not found
    assert compared or name.startswith(tuple(OPEN))
