"""Outlines of slices: through the roots of rays in the plane, with the bodies on both sides, of the right kinds."""

import math

import numpy as np
import pytest

import conicoid as co
from benchmarks.same_answers import solids
from conicoid.apps.section import outline

from ..samples import deep, deeper

BALL = co.Sphere()


def planes(rng: np.random.Generator, count: int):
    """Return corners and sides of windows about the origin, across axes and oblique."""
    yield (-2.0, -2.0, 0.25), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)
    yield (0.0, -2.0, -2.0), (0.0, 4.0, 0.0), (0.0, 0.0, 4.0)
    for _ in range(count):
        u, v, _ = np.linalg.qr(rng.normal(size=(3, 3)))[0] * 4.5
        yield -0.5 * u - 0.5 * v + rng.normal(scale=0.2, size=3), u, v


def place(cut: co.section.Slice, points):
    """Return coordinates of points in the plane, along u and v."""
    sides = [side / math.sqrt(side @ side) for side in (cut.u, cut.v)]
    return np.stack([points @ side for side in sides], axis=-1)


def rays_in(cut: co.section.Slice, rng: np.random.Generator, count: int):
    """Return lines in the plane: across, up and oblique."""
    s, t, angle = rng.uniform(0, 1, (count, 1)), rng.uniform(0, 1, (count, 1)), rng.uniform(0, 2 * np.pi, (count, 1))
    angle[: count // 2] = 0
    return co.Rays(cut.corner + s * cut.u + t * cut.v, np.cos(angle) * cut.u + np.sin(angle) * cut.v)


def within(outline, where) -> bool:
    """Return whether a place is between the ends of a piece."""
    t = float(outline._curve.parameter((where - outline._origin)[None])[0])
    turns = (0, 2 * math.pi, -2 * math.pi) if outline.kind == "ellipse" else (0,)
    slack = 1e-7 * (1 + abs(t))
    return any(outline._begin - slack <= t + turn <= outline._stop + slack for turn in turns)


def check_roots(cut: co.section.Slice, scene: co.Scene, rng: np.random.Generator, count: int) -> int:
    """Check that every crossing of rays in the plane is on an outline of its surface and its body, to 1e-12.

    Return how many.
    """
    found = scene.crossings(rays_in(cut, rng, count), t_min=-np.inf)
    left, right, bottom, top = cut.extent
    size, checked = max(right - left, top - bottom), 0
    for where, surface, body, error in zip(
        place(cut, found.point), found.surface, found.body, found.t_error, strict=True
    ):
        inside = left < where[0] < right and bottom < where[1] < top
        if not inside or error * size > 1e-13:  # a grazing ray: the root itself is not so exact
            continue
        own = [one for one in cut.outlines if surface in one.surfaces and body in one.bodies and within(one, where)]
        assert own, (where, surface, body)
        # The root has its error, and points of a small window far from the origin are rounded by its distance.
        assert min(one.distance(where) for one in own) <= (1e-12 + error) * size + 1e-15 * np.abs(cut.corner).max()
        checked += 1
    return checked


def check_sides(cut: co.section.Slice, scene: co.Scene) -> int:
    """Check that the bodies of an outline are a little to its left and right. Return at how many places."""
    left, right, bottom, top = cut.extent
    size, checked = max(right - left, top - bottom), 0
    for one in cut.outlines:
        places = one.points(7)
        if np.linalg.norm(np.diff(places, axis=0), axis=1).sum() < 1e-3 * size:
            continue
        ahead = places[2:] - places[:-2]
        length = np.linalg.norm(ahead, axis=1, keepdims=True)
        normal = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / length
        for turn, expected in ((1, one.left), (-1, one.right)):
            beside = places[1:-1] + turn * 1e-6 * size * normal - (left, bottom)
            u, v = cut.u / (right - left), cut.v / (top - bottom)
            at = scene.bodies_at(cut.corner + beside[:, :1] * u + beside[:, 1:] * v)
            assert all(tuple(bodies.tolist()) == expected for bodies in at), (one, turn, list(at))
            checked += 5
    return checked


@pytest.mark.parametrize(("count", "rays"), [(2, 60), deep((40, 400))])
@pytest.mark.parametrize("name", solids())
def test_outlines_pass_through_the_roots(name: str, count: int, rays: int):
    rng = np.random.default_rng(sum(map(ord, name)))
    scene = co.Scene([solids()[name], co.Sphere(0.75, (0.5, 0.25, 0.125))])
    for corner, u, v in planes(rng, count):
        cut = scene.slice(origin=corner, u=u, v=v, pixels=16)
        checked = check_roots(cut, scene, rng, rays), check_sides(cut, scene)
        assert min(checked) > 5 or count > 2


def test_walls_cross_walls_of_other_batches(monkeypatch):
    """Sixteen balls stand in a square grid, each overlapping its neighbours. The batch size is three."""
    monkeypatch.setattr(outline, "_WALLS", 3)
    scene = co.Scene([co.Sphere(0.6, (x, y, 0.1)) for x in range(4) for y in range(4)])
    cut = scene.slice(origin=(-1, -1, 0), u=(5, 0, 0), v=(0, 5, 0), pixels=16)
    assert check_roots(cut, scene, np.random.default_rng(17), 30) > 50
    assert check_sides(cut, scene) > 5 * 16


def only(cut: co.section.Slice):
    """Return the single outline of a slice."""
    (one,) = cut.outlines
    return one


def test_a_ball_is_cut_in_a_circle():
    # At the height 3 over the centre of a ball of radius 5: a circle of radius 4.
    one = only(co.Scene([co.Sphere(5, (1, 2, 0))]).slice(origin=(-9, -9, 3), u=(20, 0, 0), v=(0, 20, 0), pixels=8))
    assert one.is_closed
    assert one.kind == "ellipse"
    assert one.radii == pytest.approx((4, 4), rel=1e-15)
    assert one.center == pytest.approx([1, 2], rel=1e-15)
    assert (one.left, one.right, one.bodies) == ((0,), (), (0,))


def test_a_cylinder_is_cut_in_an_ellipse():
    # At 60 degrees between plane and circle the half-axes are r and r / cos 60 = 2 r.
    c, s = 0.5, math.sqrt(0.75)
    pipe = co.EllipticCylinder(1, 1)
    one = only(co.Scene([pipe]).slice(origin=(-4 * c, -3, -4 * s), u=(8 * c, 0, 8 * s), v=(0, 6, 0), pixels=8))
    assert sorted(one.radii) == pytest.approx([1, 2], rel=1e-14)


@pytest.mark.parametrize(("rise", "kind", "pieces"), [(0.5, "ellipse", 1), (1.0, "parabola", 1), (2.0, "hyperbola", 2)])
def test_kinds_of_sections_of_a_cone(rise: float, kind: str, pieces: int):
    # z² = x² + y² by the plane z = rise x + 1: steeper than the cone, as steep, or less steep.
    u = np.array([1, 0, rise])
    outlines = (
        co.Scene([co.EllipticCone(1, 1, 1)])
        .slice(origin=(-9, -9, 1 - 9 * rise), u=18 * u, v=(0, 18, 0), pixels=8)
        .outlines
    )
    assert [one.kind for one in outlines] == [kind] * pieces
    for one in outlines:
        places = one.points(50)
        x = places[:, 0] / math.sqrt(1 + rise**2) * 1.0
        # along u the place of the world's origin of x is 0 where rise * z is left out: u·(0, 0, 1) / |u| = rise / |u|
        x = x - rise / (1 + rise**2)
        y = places[:, 1]
        assert x**2 + y**2 == pytest.approx((rise * x + 1) ** 2, rel=1e-11)


def test_planes_through_an_apex_and_along_rulings_cut_lines():
    cone = co.Scene([co.EllipticCone(1, 1, 1)]).slice(origin=(-2, 0, -2), u=(4, 0, 0), v=(0, 0, 4), pixels=8)
    assert {one.kind for one in cone.outlines} == {"line"}
    assert sorted(round(math.degrees(math.atan2(*(one.end - one.start)))) % 180 for one in cone.outlines) in (
        [45, 135], [45, 45, 135, 135],
    )  # fmt: skip
    pipe = co.Scene([co.EllipticCylinder(1, 1)]).slice(origin=(-2, 0.6, -2), u=(4, 0, 0), v=(0, 0, 4), pixels=8)
    assert sorted(one.start[0] for one in pipe.outlines) == pytest.approx([-0.8, 0.8], rel=1e-15)


def test_touched_bodies_have_no_outline():
    assert co.Scene([BALL]).slice(origin=(-2, -2, 1), u=(4, 0, 0), v=(0, 4, 0), pixels=8).outlines == ()
    assert (
        co.Scene([co.EllipticCylinder(1, 1)]).slice(origin=(-2, 1, -2), u=(4, 0, 0), v=(0, 0, 4), pixels=8).outlines
        == ()
    )


def test_a_cap_that_touches_a_pole_has_no_outline():
    """Caps z = ±1 of the hole touch the ball in the middle of their sections. The walls of the hole end at ±sqrt(3)/2."""
    bored = co.Sphere(1) - co.Cylinder((0, 0, -1), (0, 0, 1), 0.5)
    outlines = co.Scene([bored]).slice("y", 0).outlines
    assert len(outlines) == 4
    ends = np.abs([end for one in outlines for end in (one.start, one.end)])
    assert ends == pytest.approx(np.tile([0.5, math.sqrt(0.75)], (8, 1)), abs=1e-15)


def test_a_wall_that_touches_the_plane_takes_no_other_away():
    """Along the line of contact the wall has no sign of its own, and beside it that of its outside."""
    can, block = co.Cylinder((0, 0, -1), (0, 0, 1), 1), co.Box((-2, -3, -2), (2, 1, 2))
    assert co.Scene([can]).slice("y", at=1).outlines == ()
    assert len(co.Scene([can, block]).slice("y", at=1).outlines) == 4
    beside = co.Box((0, 0, -2), (2, 3, 2)) - can  # its wall x = 0 lies in the line of contact
    outlines = co.Scene([beside]).slice("y", at=1).outlines
    assert sorted(sorted([*one.start, *one.end]) for one in outlines) == [
        [-2, -2, 0, 2], [-2, 0, 0, 2], [-2, 2, 2, 2], [0, 2, 2, 2]
    ]  # fmt: skip


@pytest.mark.parametrize("turn", [0, 90, 180])
def test_walls_along_the_axis_of_a_parabola_cut_it(turn):
    """z = x² - 1/2 in the box |x| <= 1 ends at z = 1/2."""
    bowl = (co.Box() - co.EllipticParaboloid(1, 1).translate((0, 0, -0.5))).rotate("y", turn)
    (found,) = (one for one in co.Scene([bowl]).slice("y").outlines if one.kind == "parabola")
    (s, c) = {0: (0, 1), 90: (1, 0), 180: (0, -1)}[turn]
    ends = [(x * c + 0.5 * s, 0.5 * c - x * s) for x in (-1, 1)]
    assert np.array(sorted([tuple(found.start), tuple(found.end)])) == pytest.approx(np.array(sorted(ends)), abs=1e-14)


ALMOST = {
    "paraboloid": co.EllipticParaboloid(1, 2), "two sheets": co.TwoSheetHyperboloid(1, 2, 1),
    "one sheet": co.OneSheetHyperboloid(1, 1, 2), "cone": co.EllipticCone(1, 1, 1), "flat": co.EllipticCone(1e-3, 1, 1),
    "elliptic": co.EllipticCylinder(1, 1), "parabolic": co.ParabolicCylinder(1), "hyperbolic": co.HyperbolicCylinder(1, 0.5),
    "saddle": co.HyperbolicParaboloid(1, 2), "can": co.Cylinder((0, 0, -3), (0, 0, 3), 1),
    "long": co.Ellipsoid((1, 1000, 1)),
}  # fmt: skip
"""Shapes whose sections along axes are parabolas, lines, or almost lines."""


def almost(seed: int):
    """Return a shape turned by little and a window at its wall, along axes or oblique, of any size, with a ball."""
    rng = np.random.default_rng(seed)
    shape = list(ALMOST.values())[seed % len(ALMOST)].rotate(
        rng.normal(size=3) if seed % 2 else (1, 2, 3), rng.choice([-1, 1]) * 10.0 ** rng.uniform(-17, 1.5)
    )
    size = 10.0 ** rng.uniform(-3, 3)
    frame = np.eye(3)[rng.permutation(3)] if seed % 3 else np.linalg.qr(rng.normal(size=(3, 3)))[0]
    u, v = frame[0] * size, frame[1] * size * rng.choice([0.25, 1, 3])
    found = co.Scene([shape]).crossings(co.Rays(rng.normal(size=(9, 3)), rng.normal(size=(9, 3))), t_min=-np.inf).point
    near = found[np.abs(found).max(axis=1) < 1000]
    middle = (near[0] if len(near) else np.zeros(3)) + rng.normal(scale=0.2, size=3) * size
    scene = co.Scene([shape, co.Sphere(0.3 * size, middle + 0.1 * size)])
    return scene, scene.slice(origin=middle - u / 2 - v / 2, u=u, v=v, pixels=8), rng


@pytest.mark.parametrize(("seeds", "rays"), [
    (range(46), 30), *deeper(((seed,), 200) for seed in range(1000, 4000)),
])  # fmt: skip
def test_conics_that_are_almost_parabolas_or_lines(seeds, rays):
    """Centers and half-axes of their sections are up to 1e17 windows long."""
    checked = np.zeros(2, int)
    for seed in seeds:
        scene, cut, rng = almost(seed)
        checked += check_roots(cut, scene, rng, rays), check_sides(cut, scene)
    assert min(checked) > (500 if rays == 30 else 0)


@pytest.mark.parametrize("degrees", [s * 10.0**-k for k in (1, 5, 9, 12, 14, 15, 16) for s in (1, -1)])
@pytest.mark.parametrize(
    "shape", [co.EllipticParaboloid(1, 1), co.TwoSheetHyperboloid(1, 1, 1), co.EllipticCylinder(1, 1)]
)
def test_outlines_of_turned_shapes_are_near_those_at_rest(shape, degrees):
    """To first order in the turn the outlines are those at rest."""
    window = {"origin": (-4, 0.7, -4), "u": (8, 0, 0), "v": (0, 0, 8), "pixels": 8}
    rest = co.Scene([shape]).slice(**window).outlines
    turned = co.Scene([shape.rotate("x", degrees)]).slice(**window).outlines
    assert len(turned) == len(rest)
    assert turned

    def ends(outlines):
        ordered = sorted(outlines, key=lambda one: one.points(3)[1].sum())
        return [np.sort(np.stack([one.start, one.end]), axis=0) for one in ordered]

    assert np.array(ends(turned)) == pytest.approx(np.array(ends(rest)), abs=0.2 * abs(degrees) + 1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z", (1, 1, 0), (1, 2, 3)])
@pytest.mark.parametrize("degrees", [1e-100, 1e-20, 1e-16, 1e-9, 37])
def test_a_plane_cuts_a_parabolic_cylinder_in_parabolas_or_lines(degrees, axis):
    """The turn may be very small: the determinant is zero, and so are both of its terms but for 1e-204."""
    windows = (
        ((-4, -4, 0.3), (8, 0, 0), (0, 8, 0)), ((0.2, -4, -4), (0, 8, 0), (0, 0, 8)), ((-4, 0.7, -4), (8, 0, 0), (0, 0, 8)),
        ((-4, -3, -4), (8, 0, 0), (0, 6, 8)), ((1, 1, 1), (2, 1, 2), (1, 2, -2)), ((-0.5, -3, -1), (2, 0, 1), (-1, 0, 2)),
    )  # fmt: skip
    scene = co.Scene([co.ParabolicCylinder(1).rotate(axis, degrees)])
    cuts = [scene.slice(origin=origin, u=u, v=v, pixels=8) for origin, u, v in windows]
    kinds = {one.kind for cut in cuts for one in cut.outlines}
    assert kinds, axis
    assert kinds <= {"parabola", "line"}, axis


@pytest.mark.parametrize("off", [s * 10.0**-k for k in (2, 4, 5, 6, 8, 10, 13, 15, 17, 30) for s in (1, -1)])
def test_a_plane_beside_the_apex_cuts_a_cone_in_a_hyperbola(off):
    """At y = off: (z - 0.2)² = (x - 0.3)² + off², two branches through the whole window, however near the apex is."""
    scene = co.Scene([co.EllipticCone(1, 1, 1).translate((0.3, off, 0.2)), co.Box((-9, -9, -9), (0.25, 9, 9))])
    cut = scene.slice(origin=(-2, 0, -2), u=(4, 0, 0), v=(0, 0, 4), pixels=8)
    assert check_roots(cut, scene, np.random.default_rng(7), 60) > 60
    found = [one for one in cut.outlines if one.kind == "hyperbola"]
    # Each branch ends at the corners of the window, and at x = 1/4 the box begins
    lengths = sum(np.linalg.norm(np.diff(one.points(500), axis=0), axis=1).sum() for one in found)
    assert lengths == pytest.approx(2 * math.sqrt(2) * (1.7 + 2 + 1.8 + 1.8 - 0.05 * 2 + 0.1) / 2, rel=0.1)
    for one in found:
        x, z = one.points(200).T
        assert np.abs(np.abs(z - 0.2) - np.hypot(x - 0.3, off)).max() < 1e-14
        assert one.left != one.right


def test_an_oblique_plane_through_an_apex_is_rounded():
    """The corner and sides of the window miss the apex (1/2, 1/2, 1/2) by 1e-15."""
    scene = co.Scene([co.EllipticCone(0.5, 0.5, 1).translate((0.5, 0.5, 0.5))])
    cut = scene.slice(origin=(-1.65, -2.2, -0.6), u=(1.5, 3, 3), v=(2.8, 1.4, -2.8), pixels=8)
    assert check_roots(cut, scene, np.random.default_rng(1), 60) > 60


@pytest.mark.parametrize("turn", [0, 90])
@pytest.mark.parametrize(("a", "e"), [(1, 1), (1, 2), (2, 1)])
def test_a_hyperbola_far_from_the_window_has_the_sign_of_its_middle(a, e, turn):
    far = co.HyperbolicCylinder(a, e).scale(500).rotate("z", turn)
    assert len(co.Scene([co.Box() & far]).slice("z", pixels=8).outlines) == 4
    assert co.Scene([co.Box() - far]).slice("z", pixels=8).outlines == ()


def test_a_body_that_touches_the_middle_of_a_piece_is_on_no_side():
    """The trough x² <= y holds of the plane y = 0 a line, which crosses the box's sides in their middles."""
    cut = co.Scene([co.Box(), co.ParabolicCylinder(0.5)]).slice(origin=(-2, 0, -2), u=(4, 0, 0), v=(0, 0, 4), pixels=8)
    assert [{one.left, one.right} for one in cut.outlines] == [{(), (0,)}] * 4


def test_walls_that_coincide_but_for_rounding_are_one_curve():
    """One bowl is larger by a rounding of its scale: the intersection and the union of both have the outline of one."""
    bowl = co.EllipticParaboloid(1, 1).scale(0.5).rotate("z", 1e-5)
    other = co.EllipticParaboloid(1, 1).scale(0.001).scale(1000).scale(0.5).rotate("z", 1e-5)

    def length(body, window):
        origin, u, v = window
        found = co.Scene([body]).slice(origin=origin, u=u, v=v, pixels=8).outlines
        return sum(np.linalg.norm(np.diff(one.points(2000), axis=0), axis=1).sum() for one in found)

    for window in planes(np.random.default_rng(3), 20):
        expected = length(bowl, window)
        assert [length(body, window) for body in (bowl & other, bowl | other)] == pytest.approx(
            [expected] * 2, abs=1e-3
        )


def test_a_lens_ends_where_its_walls_cross():
    # Unit balls about (±1/2, 0, 0) cross on the circle of radius sqrt(3)/2; two thirds of a half circle of each are
    # visible.
    lens = co.Scene([co.Sphere(1, (-0.5, 0, 0)) & co.Sphere(1, (0.5, 0, 0))]).slice("z", pixels=8)
    assert len(lens.outlines) == 2
    for one in lens.outlines:
        ends = sorted([one.start.tolist(), one.end.tolist()], key=lambda end: end[1])
        assert ends[0] == pytest.approx([0, -math.sqrt(0.75)], abs=1e-15)
        assert ends[1] == pytest.approx([0, math.sqrt(0.75)], abs=1e-15)
        assert np.linalg.norm(np.diff(one.points(2001), axis=0), axis=1).sum() == pytest.approx(
            2 * math.pi / 3, rel=1e-6
        )


def test_walls_that_coincide_are_one_outline():
    capsule = co.Cylinder((0, 0, -1), (0, 0, 0), 1) | BALL
    one = only(co.Scene([capsule]).slice("z", pixels=8))  # the circle of both
    assert one.is_closed
    assert len(one.surfaces) == 2
    shared = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1))]).slice("z", at=0.5, pixels=8)
    between = [one for one in shared.outlines if one.left and one.right]
    assert len(between) == 1
    assert sorted([between[0].left, between[0].right]) == [(0,), (1,)]
    assert between[0].bodies == (0, 1)


def test_hidden_walls_are_distinguished():
    scene = co.Scene([co.Box((-1, -1, -1), (1, 1, 1)), co.Sphere(1, (1, 0, 0))])
    cut = scene.slice("z", pixels=64)
    hidden = [one for one in cut.outlines if one.left[:1] == one.right[:1]]
    assert [one.bodies for one in hidden] == [(1,)]  # the half of the circle within the box
    assert hidden[0].start[0] == pytest.approx(1, rel=1e-15)
    assert cut.overlapping.sum() > 0
    assert not cut.undefined.any()


def test_sheets_are_drawn_where_they_are():
    disc = only(co.Scene([co.Disc((0, 0, 0), (1, 0, 0), 2)]).slice("z", pixels=8))
    assert sorted([disc.start[1], disc.end[1]]) == [-2, 2]


def test_a_far_center_costs_no_digit():
    # A circle of radius 2^40 whose centre is 2^40 away: over the window it is all but a line. x = 2^40 - sqrt(2^80 - y²).
    scene = co.Scene([co.Sphere(2.0**40, (2.0**40, 0, 0))])
    cut = scene.slice(origin=(-1, -1, 0), u=(2, 0, 0), v=(0, 2, 0), pixels=8)
    (one,) = cut.outlines
    x, y = one.points(9).T
    assert x == pytest.approx(y * y / 2.0**41, abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(plane="w"), "plane must be 'x', 'y' or 'z', got 'w'"),
        (dict(origin=(0, 0, 0)), "origin, u and v must be given together"),
        (dict(origin=(0, 0, 0), u=(1, 0, 0), v=(1, 1, 0)), "u and v must be at right angles"),
        (dict(origin=(0, 0, 0), u=(1, 0, 0), v=(0, 0, 0)), "u and v must not be zero"),
        (dict(plane="z", u=(1, 0, 0)), "leave out the axis"),
        (dict(origin=(0, 0, 0), u=(1, 0, 0), v=(0, 1, 0), at=1), "origin gives the place"),
        (dict(plane="z", pixels=0), "pixels must be a whole number"),
    ],
)
def test_invalid_slices_are_refused(arguments, message):
    scene = co.Scene([BALL])
    with pytest.raises(ValueError, match=message):
        scene.slice(**arguments)


@pytest.mark.parametrize("size", [1e-90, 1e90])
def test_bodies_of_extreme_size(size):
    """The squares of such lengths are beyond float64. A hollow ball has a section of two circles."""
    cut = co.Scene([co.Sphere(size) - co.Sphere(size / 2)]).slice("y", pixels=40)
    outer, inner = sorted((one for one in cut.outlines), key=lambda one: -one.radii[0])
    assert outer.radii == pytest.approx((size, size), rel=1e-15)
    assert inner.radii == pytest.approx((size / 2, size / 2), rel=1e-15)
    assert outer.is_closed
    assert inner.is_closed
