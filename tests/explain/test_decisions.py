"""Which formulas decided: certain rays, doubtful ones with the places of all crossings, and those that take exact arithmetic."""

from __future__ import annotations

import mpmath
import pytest

import conicoid as co


def test_a_certain_ray_has_the_bound_of_its_hit():
    found = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0))
    assert (found.decision.first, found.decision.all, found.decision.places) == ("floats", "floats", ())
    assert found.decision.t_error == found.hit.t_error
    # 0.36 is not 0.6² exactly: t* = 3 − √(1 − 0.6²) with the float 0.6
    with mpmath.workdps(50):
        exact = 3 - mpmath.sqrt(1 - mpmath.mpf(0.6) ** 2)
        assert abs(mpmath.mpf(float(found.hit.t)) - exact) <= found.decision.t_error


@pytest.mark.parametrize("power", [36, 44, 50])
def test_a_grazing_ray_is_located_to_thirty_digits(power):
    """At the height 1 − 2^−k a unit ball is crossed at 5 ∓ √(1 − h²); the float formulas leave that in doubt."""
    height = 1 - 2.0**-power
    found = co.Scene([co.Sphere(1)]).explain((-5, height, 0), (1, 0, 0))
    assert found.decision.first == found.decision.all == "certified"
    assert [place.surface for place in found.decision.places] == [0, 0]
    with mpmath.workdps(60):
        half = mpmath.sqrt(1 - mpmath.mpf(height) ** 2)
        for place, exact in zip(found.decision.places, (5 - half, 5 + half), strict=True):
            assert abs(mpmath.mpf(place.high) + mpmath.mpf(place.low) - exact) <= place.error <= 1e-20
            assert place.t == float(exact)
    ranks = [place.rank for place in found.decision.places]
    assert ranks == sorted(set(ranks))
    assert [c.t for c in found.crossings] == [place.t for place in found.decision.places]
    assert "the float formulas leave it in doubt; decided by numbers in two floats" in found.text


def test_two_roots_that_are_one():
    """Unit balls about 0 and (1, 0, 0), along z at x = 1/2: both are met at 5 ∓ √3/2; only exact arithmetic can tell."""
    scene = co.Scene([co.Sphere(1), co.Sphere(1, (1, 0, 0))])
    found = scene.explain((0.5, 0, 5), (0, 0, -1))
    assert found.decision.first == "exact"
    first, second, third, last = found.decision.places
    assert {first.surface, second.surface} == {third.surface, last.surface} == {0, 1}
    assert first.rank == second.rank < third.rank == last.rank
    assert first.t == second.t == pytest.approx(5 - 3**0.5 / 2, rel=1e-15)
    assert "decided by exact arithmetic, since error bounds left it open" in found.text
    assert found.hit.body == 0


def test_what_comes_after_the_first_hit_may_be_in_doubt():
    """A plate is hit first; beyond it a ball is grazed."""
    scene = co.Scene([co.Box((-3, -1, -1), (-2, 2, 1)), co.Sphere(1)])
    found = scene.explain((-5, 1 - 2.0**-44, 0), (1, 0, 0))
    assert (found.decision.first, found.decision.all) == ("floats", "certified")
    assert "crossings behind it are in doubt" in found.text
    assert [c.body for c in found.crossings] == [0, 0, 1, 1]


def test_where_the_float_formulas_say_otherwise_that_is_told():
    """A ray through an edge of a turned cube: two faces are left at places that differ by less than their errors."""
    scene = co.Scene([co.Box((-1, -1, -1), (1, 1, 1)).rotate((1, 2, 3), 40)])
    found = scene.explain((8.00624797748944, 14.562531536778334, 16.736100761092338), (-2, -4, -4))
    step = found.bodies[0]
    assert step.doubtful
    assert found.decision.all == "certified"
    assert [c.t for c in step.crossings] == scene.crossings(found.hit.rays).t.tolist()
    assert step.floats != step.crossings
    assert "by the float formulas alone it would be: " in found.text
    # The two faces that meet in the edge are next to each other in the order of all crossings
    last = step.crossings[-1]
    near = [place for place in found.decision.places if abs(place.t - last.t) < 1e-12]
    assert len(near) == 2
    assert abs(near[0].rank - near[1].rank) <= 1


def test_cancelling_terms_are_worked_out_again():
    """A cone almost along a ruling: a is 2^-20 of its terms, so it is computed in two floats; a = 1 − slope², halved."""
    slope = 1 + 2.0**-20
    step = co.Scene([co.EllipticCone(1, 1, 1)]).explain((0.5, 0, 0), (1, 0, slope), t_min=-10).surfaces[0]
    assert step.careful
    assert step.board.numbers["a"] == 1 - slope * slope
    assert 2 * step.a == pytest.approx(1 - slope * slope, rel=1e-15)


def test_a_far_away_direction_is_scaled():
    """t is that of the ray as given, also where the kernels scale it: 2.2 / 10⁴⁰."""
    found = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1e40, 0, 0))
    assert float(found.hit.t) == pytest.approx(2.2e-40, rel=1e-15)
    assert found.surfaces[0].board.numbers["t0"] == pytest.approx(2.2e-40, rel=1e-15)
