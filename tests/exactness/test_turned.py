"""Motions by irrational numbers that leave a surface rational, and differences below the resolution of float64."""

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.exact_crossings import surface_form

from ..reference.routes import in_doubt

# --- Motions by irrational numbers that leave a surface rational: exact methods find it rational


UP = (0, 0, 1)
ROUND = {
    "cylinder": co.Cylinder((0, 0, -1), UP, 1),
    "cone": co.Cone((0, 0, -1), UP, 2, 1),
    "ellipsoid": co.Ellipsoid((1, 1, 0.5)),
    "barrel": co.Ellipsoid((1, 1, 2), z_range=(-1, 1)),
    "double cone": co.DoubleCone(2, z_range=(-1, 2)),
    "paraboloid": co.EllipticParaboloid(1, 1, z_range=(-math.inf, 2)),
    "one sheet": co.OneSheetHyperboloid(1, 1, 4, z_range=(-2, 2)),
    "two sheets": co.TwoSheetHyperboloid(1, 1, 4, z_range=(-2, 2)),
}
ANGLES = [15, 105, 16, 45, 1e-3, 33.3, -75]


def forms(shape):
    scene = co.Scene([shape])
    return [surface_form(surface) for surface in scene._prepared.lowered.exact]


@pytest.mark.parametrize("name", ROUND)
@pytest.mark.parametrize("degrees", ANGLES)
def test_a_turn_about_the_own_axis_changes_nothing(name, degrees):
    """The coefficients are integers again. Rays from lattice points, with tangents among them, cross as before."""
    still = ROUND[name]
    turned = still.rotate(UP, degrees)
    assert all(form.off is None for form in forms(turned))
    rng = np.random.default_rng(7)
    origins = rng.integers(-3, 4, (300, 3)).astype(float)
    directions = rng.integers(-2, 3, (300, 3)).astype(float)
    some = directions.any(axis=1)
    origins, directions = origins[some], directions[some]
    found = co.Scene([turned]).crossings(origins, directions, t_min=-np.inf)
    expected = co.Scene([still]).crossings(origins, directions, t_min=-np.inf)
    assert found.offsets.tolist() == expected.offsets.tolist()
    assert found.face.tolist() == expected.face.tolist()
    assert (abs(found.t - expected.t) <= found.t_error + expected.t_error).all()
    assert (found.t_error <= 1e-14 * (1 + abs(found.t))).all()


RATIONAL = {
    "45 about an axis": co.Ellipsoid((1, 2, 3)).rotate(UP, 45),
    "120 about a diagonal": co.Ellipsoid((1, 2, 3)).rotate((1, 1, 1), 120),
    "180 about an oblique axis": co.Ellipsoid((1, 2, 3)).rotate((1, 2, 3), 180),
    "there and back": co.Ellipsoid((1, 2, 3)).rotate((1, 2, 2), 20).translate((1, 0, 0)).rotate((1, 2, 2), -20),
    "a third": co.Ellipsoid((1, 2, 3)).scale(3).translate((1, 2, 3)),
    "oblique axis": co.Cylinder((0, 0, 0), (1, 2, 3), 1),
    "a plane by 120": co.Plane((1, 0, 0), 0.1).rotate((1, 1, 1), 120),
    "15 and 75 about a rational axis": co.HyperbolicParaboloid(1, 2).rotate((1, 2, 2), 15).rotate((1, 2, 2), 75),
}


@pytest.mark.parametrize("name", [name for name in RATIONAL if name not in ("there and back", "oblique axis")])
def test_rational_surfaces_are_recognised(name):
    assert all(form.off is None for form in forms(RATIONAL[name]))


def test_the_wall_of_an_oblique_cylinder_is_rational():
    """The wall is |x|² - (a·x)² / a·a = r².

    Its caps are at irrational heights from the origin unless they pass through lattice points.
    """
    assert all(form.off is None for form in forms(RATIONAL["oblique axis"]))


def test_a_translation_that_was_turned_is_not():
    """The shift by cos 20 is irrational, unlike the second-order part. An agreement of 45 bits must not count."""
    assert any(form.off is not None for form in forms(RATIONAL["there and back"]))


def test_a_plane_at_an_irrational_distance_is_not():
    (form,) = forms(co.Plane((1, 0, 0), 1).rotate(UP, 45))
    assert form.off is not None


def test_long_chains_of_motions_are_composed_as_they_grow():
    """No product is computed before its first use. Then each motion continues from the product before it."""
    shape = co.Sphere()
    for k in range(60):
        shape = shape.rotate((1, 2, 3), 6)
        assert "affine" not in shape.motion.__dict__
        if k % 7 == 0:
            assert shape.motion.matrix is shape.motion.matrix
            assert "affine" in shape.motion.__dict__
    matrix = shape.motion.matrix
    assert np.array_equal(matrix, np.eye(4))  # 60 times 6 degrees


def test_motions_in_a_chain_are_multiplied_once(noted_calls):
    from conicoid.geometry import transform as motion

    calls = noted_calls(motion.Rotate, "affine")
    shape = co.Sphere()
    for _ in range(30):
        shape = shape.rotate((1, 2, 3), 0.01)
    co.Scene([shape])
    assert len(calls) <= 60


# --- Differences below the resolution of float64: slivers between surfaces that round to the same record, and turns of
# wedges


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
    """All reach from x = -1 to 1 along the x axis. They are moved by 1 and by 1 + 2^-60, which rounds to 1."""
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
    """The tubes surround an oblique axis far from the origin.

    The square of that distance hides the square of the radii.
    """
    start, end = (1.0, 2.0, 3.0), (5.0, 10.0, 4.0)
    tube = co.Cylinder(start, end, 2e-90) - co.Cylinder(start, end, 1e-90)
    # Through (3, 6, 3.5), halfway, across (4, 8, 1)
    assert [entering for _, entering in ends(tube, (4.0, 5.5, 3.5), (-2, 1, 0))] == [True, False, True, False]
    assert not co.Scene([tube]).contains((3.0, 6.0, 3.5))


def test_a_full_turn_is_one_that_rounds_to_360() -> None:
    """0.1 and 360.1 are 360 + 1.7e-14 apart as fractions, and 360 in float64."""
    whole = co.Cylinder((0, 0, 0), (0, 0, 1), 1, 0.1, 360.1, reference=(1, 0, 0))
    plain = co.Cylinder((0, 0, 0), (0, 0, 1), 1)
    random = np.random.default_rng(2)
    origins, directions = random.normal(size=(2, 200, 3))
    expected, found = (co.Scene([shape]).crossings(origins, directions) for shape in (plain, whole))
    assert (found.t == expected.t).all()
    assert set(found.face.tolist()) <= {0, 1, 2}
    assert ends(whole, (-2.0, 0.0, 0.5), (1, 0, 0)) == [(1, True), (3, False)]


def test_half_a_turn_is_one_that_rounds_to_180() -> None:
    """From 0.1 to 180.1 there is one wall, the plane of the start angle: face 3 on both sides of the axis."""
    first, last = 0.1, 180.1
    assert last - first == 180
    half = co.Cylinder((0, 0, 0), (0, 0, 1), 1, first, last, reference=(1, 0, 0))
    scene = co.Scene([half])
    s, c = math.sin(math.radians(first)), math.cos(math.radians(first))
    for along in (0.5, -0.5):
        hits = scene.first_hit((along * c + s, along * s - c, 0.5), (-s, c, 0))
        assert hits.face == 3
        assert hits.t == pytest.approx(1, abs=1e-15)
    # From end to end within the wall's plane: half open, as every plane; never half of it
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
    """Motions within the domain have an inverse that brings a shape back to the same surfaces.

    Errors refuse those beyond it.
    """
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


# --- Planes that are parallel but for a last digit meet some 1e16 away: no anchor may lie there


def almost_slabs(random: np.random.Generator, sides: int) -> list[tuple[list[float], float]]:
    """Return half-spaces of a slab or a prism of thickness 2 about the origin. Each normal's opposite is some ulps off."""
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    found = []
    for normal in turn[:sides]:
        opposite = [-c * (1 + k * 2.0**-52) for c, k in zip(normal, random.integers(-2, 3, 3), strict=True)]
        found += [(normal.tolist(), 1.0), (opposite, 1.0)]
    return found


def entry(halves: list[tuple[list[Fraction], Fraction]], origin: list[float], direction: list[float]) -> float:
    """Return where a ray from outside enters an intersection of half-spaces, rounded once; inf if it misses."""
    first, last = Fraction(0), Fraction(100)
    for normal, offset in halves:
        height = offset - sum(n * Fraction(x) for n, x in zip(normal, origin, strict=True))
        rate = sum(n * Fraction(x) for n, x in zip(normal, direction, strict=True))
        if rate > 0:
            last = min(last, height / rate)
        elif rate < 0:
            first = max(first, height / rate)
        elif height < 0:
            return math.inf
    return float(first) if first < last else math.inf


@pytest.mark.parametrize("count", [1, 20])
@pytest.mark.parametrize("sides", [1, 2])
def test_planes_that_are_parallel_but_for_a_last_digit(sides: int, count: int) -> None:
    """Half a turn about (1, 2, 3), x -> (a·x) a / 7 - x, is a rational matrix. Many bodies of a form share a tape."""
    random, axis, distance = np.random.default_rng(sides), (1, 2, 3), 20
    turn = [[Fraction(a * b, 7) - (i == k) for k, b in enumerate(axis)] for i, a in enumerate(axis)]
    block = [([sense * float(i == k) for i in range(3)], 4.0) for k in range(3) for sense in (1, -1)]
    shapes, bodies = [], []
    for body in range(count):
        slabs = almost_slabs(random, sides)
        prism = co.Polyhedron([normal for normal, _ in slabs], [offset for _, offset in slabs])
        part = prism & co.Box((-4, -4, -4), (4, 4, 4))
        shapes.append(part.rotate(axis, 180).translate((distance * body, 0, 0)))
        halves = []
        for normal, offset in slabs + block:
            turned = [sum(t * Fraction(n) for t, n in zip(row, normal, strict=True)) for row in turn]
            halves.append((turned, Fraction(offset) + turned[0] * distance * body))
        bodies.append(halves)
    scene = co.Scene(shapes)
    towards = np.repeat(distance * np.arange(count), 200 // count)
    origins = random.uniform(-4, 4, (len(towards), 3)) + np.column_stack([towards, 0 * towards, 0 * towards + 30.0])
    targets = random.uniform(-1, 1, (len(towards), 3)) + np.column_stack([towards, 0 * towards, 0 * towards])
    hits = scene.first_hit(origins, targets - origins)
    rays = zip((towards // distance).tolist(), origins.tolist(), (targets - origins).tolist(), strict=True)
    expected = [entry(bodies[body], origin, direction) for body, origin, direction in rays]
    assert hits.t == pytest.approx(expected, rel=1e-14)
    assert in_doubt(scene, hits.rays).mean() < 0.02
