"""Tubes, parts of balls, polycones and flat solids, lowered together: each as it becomes alone, to the bit."""

from __future__ import annotations

import random

import pytest

import conicoid as co

from ...samples import in_turn
from .test_recorded import MOTIONS, SOLIDS, check, number, point, size, together


def turn(rng: random.Random) -> tuple[float, float]:
    """From an angle to another: plain ones, such as 30 and 90, others, and at times half a turn."""
    first = rng.choice((0.0, 30.0, 90.0, 180 * rng.random()))
    return first, first + rng.choice((90.0, 180.0, 200.0, 1.0 + 350 * rng.random()))


def polar(rng: random.Random) -> tuple[float, float]:
    low = rng.choice((0.0, 30.0, 90 * rng.random()))
    return low, rng.choice((90.5, 150.0, 180.0, 180 - low, 91 + 80 * rng.random()))


def ranges(rng: random.Random) -> tuple[float, float]:
    low = number(rng)
    return low, low + size(rng)


KINDS = {
    "Tube": lambda r: co.Tube(point(r), point(r), 0.25, 0.5 + size(r)),
    "part of a Tube": lambda r: co.Tube(point(r), point(r), 0.25, 0.5 + size(r), *turn(r), point(r)),
    "part of a Cone": lambda r: co.Cone(point(r), point(r), size(r), size(r), *turn(r), point(r)),
    "part of a pointed Cone": lambda r: co.Cone(point(r), point(r), size(r), 0.0, *turn(r), point(r)),
    "shell": lambda r: co.SphereSection(1 + size(r), size(r) / 6, center=point(r)),
    "polar range": lambda r: co.SphereSection(1 + size(r), 0.5, polar(r), center=point(r)),
    "both ranges": lambda r: co.SphereSection(size(r), 0.0, polar(r), *turn(r)),
    "Polycone": lambda r: co.Polycone([(-1, size(r) / 6, 1 + size(r)), (number(r) / 9, 0, size(r)), (1, 0.5, 2)]),
    "part of a Polycone": lambda r: co.Polycone([(-6, 0, size(r)), (number(r), 0.05, size(r)), (6, 0.05, 2)], *turn(r)),
    "Trapezoid": lambda r: co.Trapezoid((size(r), size(r)), (size(r), size(r)), ranges(r), (number(r), number(r))),
    "pointed Trapezoid": lambda r: co.Trapezoid((size(r), size(r)), (0, 0), ranges(r), (number(r), number(r))),
    "Wedge": lambda r: co.Wedge(size(r), size(r), size(r), size(r), number(r)),
    "RegularPrism": lambda r: co.RegularPrism(6, size(r), ranges(r), rng_angle(r)),
    "prism by its sides": lambda r: co.RegularPrism(5, size(r), ranges(r), rng_angle(r), "sides"),
    "Pyramid": lambda r: co.Pyramid(4, size(r), ranges(r), r.choice((0.0, size(r))), rng_angle(r)),
    "Parallelepiped": lambda r: co.Parallelepiped(point(r), point(r), point(r), point(r)),
}  # fmt: skip


def rng_angle(rng: random.Random) -> float:
    return rng.choice((0.0, 30.0, 45.0, 720 * rng.random() - 360))


@pytest.mark.parametrize(("kind", "motion"), in_turn(KINDS, MOTIONS))
def test_each_is_what_it_is_alone(kind, motion):
    rng = random.Random(f"{kind} {motion}")
    check([MOTIONS[motion](rng)(KINDS[kind](rng)) for _ in range(16)], 16)


UPRIGHT = {
    "Wedge": lambda r: co.Wedge(size(r), size(r), size(r)),
    "RegularPrism": lambda r: co.RegularPrism(6, size(r), (0.0, size(r)), 30.0),
    **{kind: KINDS[kind] for kind in ("Tube", "shell", "polar range", "Polycone")},
}


@pytest.mark.parametrize("kind", UPRIGHT)
def test_their_formulas_are_recorded(kind):
    """They look at no digits of their numbers: of many of one kind most are lowered together."""
    rng = random.Random(f"most {kind}")
    found = together([UPRIGHT[kind](rng).translate(point(rng)) for _ in range(120)], 120)
    assert len(found) >= 90


@pytest.mark.parametrize("built", SOLIDS)
def test_booleans_of_parts_of_several_cells(built):
    """Numbers that no face has share a row of the map, but not with another primitive."""
    rng = random.Random(built)
    parts = [KINDS[kind] for kind in ("Tube", "part of a Tube", "polar range")]
    shapes = [MOTIONS["turned"](rng)(SOLIDS[built](rng, *(part(rng) for part in parts))) for _ in range(12)]
    check(shapes, 12)
