"""What is known of places that are turned: boxes around them are never too narrow, and what they leave out is counted."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.transform import IDENTITY_MOTION, Motion
from conicoid.io.openmc.placement import Extent
from conicoid.io.openmc.region import SurfaceSide
from conicoid.io.openmc.surfaces import FlatSurface, RoundSurface
from conicoid.io.openmc.universe_block import PlaceBounds, _carry_extent
from conicoid.numerics import bigfloat as ex

from .models import put

ZERO, ONE = Fraction(0), Fraction(1)


def wall(axis: int, end: Fraction, above: bool) -> SurfaceSide:
    normal = tuple(ONE if i == axis else ZERO for i in range(3))
    return SurfaceSide(FlatSurface(normal, end), above)  # type: ignore[arg-type]


def ball(x: int) -> SurfaceSide:
    return SurfaceSide(RoundSurface(None, (Fraction(x), ZERO, ZERO), ONE), False)


@pytest.mark.parametrize("far", [1e2, 1e6, 1e8, 1e10, 1e12])
def test_boxes_carried_between_turns_hold_their_corners(far: float) -> None:
    """The shifts of both motions cancel; corners are carried in 3000 bits."""
    outer = IDENTITY_MOTION.rotate((1, 2, 3), 20).translate((far, 0.3 * far, -0.7 * far))
    inner = IDENTITY_MOTION.rotate("z", 30).translate((0.1, 0.2, 0.3)).then(outer)
    low, high = (Fraction(-1), Fraction(-2), Fraction(-3)), (Fraction(1), Fraction(1), Fraction(2))
    box = _carry_extent(Extent(low, high), inner, outer)
    rows, shift = inner.affine
    back, back_shift = outer.inverse
    for corner in product(*zip(low, high, strict=True)):
        there = ex.plus(ex.apply(rows, ex.exact_row(corner)), shift)
        for place, a, b in zip(ex.plus(ex.apply(back, there), back_shift), box.low, box.high, strict=True):
            assert a is not None
            assert b is not None
            assert ex.exact(a) <= place <= ex.exact(b)


def test_parts_of_other_groups_count_as_work() -> None:
    turn = Motion().rotate("z", 30)
    around = PlaceBounds().and_(IDENTITY_MOTION, [ball(0), wall(0, ZERO, True)])
    assert around is not None
    parts = [ball(1)]
    assert around.cost(turn, parts) == PlaceBounds().cost(turn, parts) + 2


def test_what_is_about_the_axis_of_a_turn_is_said_before_it() -> None:
    """A ball on the axis and a wall across it; a wall along it stays outside."""
    entry = Motion().rotate("z", 30).translate((0.0, 0.0, 0.5))
    height, along = wall(2, ONE / 2, False), wall(0, ONE / 2, False)
    around = PlaceBounds().and_(IDENTITY_MOTION, [ball(0), height, along])
    assert around is not None
    groups = dict(around.entering(entry, IDENTITY_MOTION, entry).groups)
    assert groups[IDENTITY_MOTION].parts == (along,)
    shifted = RoundSurface(None, (ZERO, ZERO, Fraction(-1, 2)), ONE)
    assert set(groups[entry].parts) == {SurfaceSide(shifted, False), wall(2, ZERO, False)}
    beside = dict(around.entering(Motion().rotate("x", 30), IDENTITY_MOTION, Motion().rotate("x", 30)).groups)
    assert along in beside[Motion().rotate("x", 30)].parts


def test_bounds_of_turned_places_hold_every_body(tmp_path: Path) -> None:
    """Along the anti-diagonal shifts cancel along an axis of the world: what rounding takes is of their length."""
    count, x, y = 12, 4 / 7, 3 / 7
    universes = " ".join("1" if i + j == count - 1 else "2" for i in range(count) for j in range(count))
    text = f"""<geometry><surface id="1" type="sphere" coeffs="0 0 0 0.001"/>
<cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="void" region="1"/>
<cell id="3" universe="2" material="void"/>
<lattice id="4" dimension="{count} {count}" pitch="{x} {y}" lower_left="{-6 * x} {-6 * y}" universes="{universes}"/>
<cell id="5" universe="5" fill="4"/><cell id="6" fill="5" rotation="0.8 -0.6 0 0.6 0.8 0 0 0 1"/></geometry>"""
    scene = co.load_openmc(put(text, tmp_path), void=False)
    low, high = scene.bounds
    bounds = np.array([body.shape.bounds for body in scene.bodies])
    assert len(bounds) == count
    assert (low <= bounds[:, 0]).all()
    assert (high >= bounds[:, 1]).all()
