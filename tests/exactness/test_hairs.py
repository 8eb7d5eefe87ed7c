"""What differs by less than a float64 can tell: slivers between surfaces that round to the same record, and turns of wedges."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

HAIR = 2.0**-60


def ends(shape: co.Shape, origin, direction) -> list[tuple[float, bool]]:
    found = co.Scene([shape]).crossings(origin, direction, t_min=-math.inf)
    return list(zip(found.t.tolist(), found.entering.tolist(), strict=True))


@pytest.mark.parametrize(
    "solid",
    [co.Sphere(), co.Ellipsoid((1, 2, 3)), co.Box(), co.Cylinder((0, 0, -1), (0, 0, 1), 1)],
    ids=lambda solid: type(solid).__name__,
)
def test_a_solid_without_itself_moved_by_a_hair(solid: co.Shape) -> None:
    """All reach from x = -1 to 1 along the x axis, and are moved by 1 and by 1 + 2^-60, which rounds to 1."""
    first = solid.translate((1, 0, 0))
    second = first.translate((HAIR, 0, 0))
    ray = (-5.0, 0.0, 0.0), (1, 0, 0)
    assert ends(first - second, *ray) == [(5, True), (5, False)]
    assert ends(second - first, *ray) == [(7, True), (7, False)]
    assert ends(first - first, *ray) == []
    assert ends(first & second, *ray) == [(5, True), (7, False)]
    # The hair is there for points too: 0 is in the first alone
    scene = co.Scene([first - second, second])
    assert scene.body_at([(0.0, 0, 0), (1.0, 0, 0), (-1.0, 0, 0)]).tolist() == [0, 1, -1]


def test_thin_tubes_within_one_another() -> None:
    """Around an oblique axis at a distance from the origin, whose square hides that of the radii."""
    start, end = (1.0, 2.0, 3.0), (5.0, 10.0, 4.0)
    tube = co.Cylinder(start, end, 2e-90) - co.Cylinder(start, end, 1e-90)
    # Through (3, 6, 3.5), halfway, across (4, 8, 1)
    assert [entering for _, entering in ends(tube, (4.0, 5.5, 3.5), (-2, 1, 0))] == [True, False, True, False]
    assert not co.Scene([tube]).contains((3.0, 6.0, 3.5))


def test_a_full_turn_is_one_that_rounds_to_360() -> None:
    """0.1 and 360.1 are 360 + 1.7e-14 apart, as fractions; 360 as float64."""
    whole = co.Cylinder((0, 0, 0), (0, 0, 1), 1, 0.1, 360.1, reference=(1, 0, 0))
    plain = co.Cylinder((0, 0, 0), (0, 0, 1), 1)
    random = np.random.default_rng(2)
    origins, directions = random.normal(size=(2, 200, 3))
    expected, found = (co.Scene([shape]).crossings(origins, directions) for shape in (plain, whole))
    assert (found.t == expected.t).all()
    assert set(found.face.tolist()) <= {0, 1, 2}
    assert ends(whole, (-2.0, 0.0, 0.5), (1, 0, 0)) == [(1, True), (3, False)]


def test_half_a_turn_is_one_that_rounds_to_180() -> None:
    """0.1 to 180.1: one wall, the plane of the start angle; face 3 on both sides of the axis."""
    first, last = 0.1, 180.1
    assert last - first == 180
    half = co.Cylinder((0, 0, 0), (0, 0, 1), 1, first, last, reference=(1, 0, 0))
    scene = co.Scene([half])
    s, c = math.sin(math.radians(first)), math.cos(math.radians(first))
    for along in (0.5, -0.5):
        hits = scene.first_hit((along * c + s, along * s - c, 0.5), (-s, c, 0))
        assert hits.face == 3
        assert hits.t == pytest.approx(1, abs=1e-15)
    # From end to end within the wall's plane: half open, as for every plane; never half of it
    assert len(ends(half, (-2 * c, -2 * s, 0.5), (c, s, 0))) in (0, 2)


def test_turns_that_do_not_round_keep_both_walls() -> None:
    turn = math.nextafter(360, 0)
    slit = co.Cylinder((0, 0, 0), (0, 0, 1), 1, 0, turn, reference=(1, 0, 0))
    assert ends(slit, (-2.0, 0.0, 0.5), (1, 0, 0))[0] == (1, True)
    # Across the slit at x = 0.5: it is 0.5 tan(5.7e-14 degrees) = 5e-16 wide
    found = co.Scene([slit]).crossings((0.5, -3.0, 0.5), (0, 1, 0))
    assert found.face.tolist() == [0, 4, 3, 0]
    assert found.entering.tolist() == [True, False, True, False]
    gap = 0.5 * math.tan(math.radians(360 - turn))
    assert 2.5e-16 < gap < 1e-15
    assert (np.abs(found.t[1:3] - 3) <= gap + found.t_error[1:3]).all()


@pytest.mark.parametrize(
    "shape",
    [co.Sphere(), co.Box(), co.Cylinder((0, 0, 0), (1, 2, 3), 1), co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0.5))],
)
def test_motions_over_many_decades(shape: co.Shape) -> None:
    """Within the domain they work, and its own inverse brings a shape back to the same surfaces; beyond they are refused."""
    long = shape.scale((1e-50, 1, 1e50)).rotate((1, 2, 3), 40)
    back = long.rotate((1, 2, 3), -40).scale((1e50, 1, 1e-50))
    low, high = long.bounds
    assert np.isfinite(low).all()
    assert np.isfinite(high).all()
    scene, other = co.Scene([shape]), co.Scene([back])
    random = np.random.default_rng(4)
    origins, directions = random.normal(size=(2, 300, 3))
    assert np.allclose(scene.first_hit(origins, directions).t, other.first_hit(origins, directions).t, rtol=1e-14)
    with pytest.raises(
        ValueError, match=rf"{type(shape).__name__}: (inverse of )?motion must have entries of magnitude up to 1e\+100"
    ):
        long.scale((1e-60, 1, 1e60)).scale((1e-60, 1, 1e60))
