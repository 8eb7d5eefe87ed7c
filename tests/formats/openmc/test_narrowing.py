"""Leaving out what says nothing new changes no point's answer."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from conicoid.io.openmc.region import Conjunction, PartIntersection, PartUnion, RegionPart, SurfaceSide
from conicoid.io.openmc.surfaces import ConeSurface, FlatSurface, RoundSurface

from ...samples import sampled

ZERO, ONE = Fraction(0), Fraction(1)


def quarter(random: np.random.Generator, reach: int = 8) -> Fraction:
    return Fraction(int(random.integers(-reach, reach + 1)), 4)


def side(random: np.random.Generator) -> SurfaceSide:
    """Any kind of side, on a grid of quarters so that coincidences are common."""
    x, y, z = (quarter(random) for _ in range(3))
    kind, positive = random.integers(8), bool(random.integers(2))
    if kind < 3:
        return SurfaceSide(FlatSurface(tuple(ONE * int(i == kind) for i in range(3)), x), positive)  # type: ignore[arg-type]
    if kind == 3:
        return SurfaceSide(FlatSurface((ONE, quarter(random, 2), -ONE), x), positive)
    if kind == 4:
        return SurfaceSide(ConeSurface(2, (x, y, z), ONE), positive)
    axis = None if kind == 5 else int(random.integers(3))
    center = tuple(ZERO if i == axis else c for i, c in enumerate((x, y, z)))
    return SurfaceSide(RoundSurface(axis, center, quarter(random, 6) + Fraction(7, 4)), positive)  # type: ignore[arg-type]


def part(random: np.random.Generator, depth: int) -> RegionPart:
    if depth == 0 or random.random() < 0.6:
        return side(random)
    pieces = tuple(part(random, depth - 1) for _ in range(random.integers(2, 4)))
    return PartUnion(pieces) if random.random() < 0.6 else PartIntersection(pieces)


def inside(item: RegionPart, points: np.ndarray) -> np.ndarray:
    if isinstance(item, SurfaceSide):
        surface = item.surface
        if isinstance(surface, FlatSurface):
            values = points @ [float(n) for n in surface.normal] - float(surface.offset)
        elif isinstance(surface, RoundSurface):
            own = points - [float(c) for c in surface.center]
            values = (own[:, list(surface.cross_axes)] ** 2).sum(axis=1) - float(surface.radius) ** 2
        else:
            assert isinstance(surface, ConeSurface)
            own = points - [float(c) for c in surface.apex]
            values = own[:, 0] ** 2 + own[:, 1] ** 2 - float(surface.square) * own[:, 2] ** 2
        return values > 0 if item.positive else values < 0
    parts = [inside(piece, points) for piece in item.parts]
    return np.all(parts, axis=0) if isinstance(item, PartIntersection) else np.any(parts, axis=0)


@pytest.mark.parametrize("seed", sampled(range(150), 4))
def test_what_is_left_says_the_same(seed: int) -> None:
    """In one go and step by step, as a hierarchy does it; on points that are on no surface."""
    random = np.random.default_rng(seed)
    parts = [part(random, 2) for _ in range(random.integers(1, 9))]
    points = random.uniform(-4, 4, (4000, 3))
    points = np.concatenate([points, random.uniform(-1, 1, (2000, 3))])
    expected = inside(PartIntersection(tuple(parts)), points)
    at_once = Conjunction().and_(parts)
    stepwise: Conjunction | None = Conjunction()
    for item in parts:
        stepwise = None if stepwise is None else stepwise.and_([item])
    for found in (at_once, stepwise):
        if found is None:
            assert not expected.any()
            continue
        answer = inside(PartIntersection(found.parts), points) if found.parts else np.ones(len(points), bool)
        assert (answer == expected).all()
        for i in range(3):
            low, high = found.extent.low[i], found.extent.high[i]
            assert low is None or (points[expected, i] >= float(low)).all()
            assert high is None or (points[expected, i] <= float(high)).all()


def cylinder(radius: str, x: str = "0", axis: int | None = 2) -> RoundSurface:
    return RoundSurface(axis, (Fraction(x), ZERO, ZERO), Fraction(radius))


def planes(axis: int, low: str, high: str) -> list[SurfaceSide]:
    normal = tuple(ONE * int(i == axis) for i in range(3))
    return [
        SurfaceSide(FlatSurface(normal, Fraction(low)), True),
        SurfaceSide(FlatSurface(normal, Fraction(high)), False),
    ]  # type: ignore[arg-type]


def kept(*parts: RegionPart) -> set[tuple[object, bool]] | None:
    found = Conjunction().and_(parts)
    return None if found is None else {(s.surface, s.positive) for s in found.parts if isinstance(s, SurfaceSide)}


def test_a_pin_in_its_element_needs_no_walls() -> None:
    pin = SurfaceSide(cylinder("0.4"), False)
    assert kept(pin, *planes(0, "-0.63", "0.63"), *planes(1, "-0.63", "0.63")) == {(pin.surface, False)}


def test_walls_that_touch_stay() -> None:
    pin = SurfaceSide(cylinder("0.63"), False)
    assert len(kept(pin, *planes(0, "-0.63", "0.63")) or ()) == 3


def test_a_vessel_around_an_element_vanishes_and_one_that_cuts_it_stays() -> None:
    walls = [*planes(0, "-1", "1"), *planes(1, "-1", "1")]
    assert len(kept(*walls, SurfaceSide(cylinder("1.5"), False)) or ()) == 4
    assert len(kept(*walls, SurfaceSide(cylinder("1.4"), False)) or ()) == 5
    assert kept(*walls, SurfaceSide(cylinder("1.5"), True)) is None
    assert kept(*walls, SurfaceSide(cylinder("0.5", "1.6"), False)) is None
    assert len(kept(*walls, SurfaceSide(cylinder("0.5", "1.6"), True)) or ()) == 4


def test_a_vessel_that_hides_a_wall_vanishes_around_what_lies_within_it() -> None:
    """An assembly that it cuts has no outer wall any more; the pins inside do not meet it."""
    vessel = SurfaceSide(cylinder("10"), False)
    assembly = Conjunction().and_([vessel, *planes(0, "5", "12"), *planes(1, "-1", "1"), *planes(2, "-3", "3")])
    assert assembly is not None
    assert SurfaceSide(FlatSurface((ONE, ZERO, ZERO), Fraction(12)), False) not in assembly.parts
    inner = assembly.and_([*planes(0, "6", "7"), *planes(1, "0", "1")])
    outer = assembly.and_([*planes(0, "9", "10"), *planes(1, "0", "1")])
    assert inner is not None
    assert outer is not None
    assert vessel not in inner.parts
    assert vessel in outer.parts


def test_round_solids_beside_planes_are_as_fractions_say() -> None:
    """Far from a plane floats decide; where it touches, fractions do."""
    random = np.random.default_rng(7)
    touching = 0
    for _ in range(3000):
        solid, plane = side(random).surface, side(random).surface
        if not isinstance(solid, RoundSurface) or not isinstance(plane, FlatSurface):
            continue
        height = sum((n * c for n, c in zip(plane.normal, solid.center, strict=True)), -plane.offset)
        reach = solid.radius**2 * sum(n * n for n in plane.normal)
        beside = height**2 > reach and not (solid.axis is not None and plane.normal[solid.axis])
        touching += height**2 == reach
        assert solid.side_of_plane(plane) == (0 if not beside else 1 if height > 0 else -1)
    assert touching > 10


def test_balls_that_are_apart_or_within() -> None:
    a, b = cylinder("1", "0", None), cylinder("0.25", "1.5", None)
    assert kept(SurfaceSide(a, False), SurfaceSide(b, False)) is None
    assert kept(SurfaceSide(a, False), SurfaceSide(b, True)) == {(a, False)}
    c = cylinder("2", "0.5", None)
    assert kept(SurfaceSide(a, False), SurfaceSide(c, False)) == {(a, False)}
    assert kept(SurfaceSide(a, False), SurfaceSide(c, True)) is None


def test_equal_planes_are_kept_once_and_opposite_sides_have_no_volume() -> None:
    low, high = planes(0, "0", "1")
    assert kept(low, high, *planes(0, "-1", "1")) == {(low.surface, True), (high.surface, False)}
    assert kept(low, SurfaceSide(low.surface, False)) is None
