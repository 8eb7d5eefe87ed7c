"""Painted faces: what a ray sees of them in cuts, combinations and motions, straight and in pictures."""

import numpy as np
import pytest

import conicoid as co

RED, GREEN, BLUE, GREY = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.25, 0.25, 0.25)
PLATE = co.Box((-2, -2, -1), (2, 2, 1))
BORE = co.Cylinder((0, 0, -1), (0, 0, 1), 1)
POCKET = co.Cylinder((0, 0, 0), (0, 0, 1), 1)


def seen(shape, x=0.0, y=0.0, towards=(0, 0, -1)):
    """The colour of a grey body along a ray through (x, y, 0) that comes from far away."""
    there = np.array((x, y, 0.0))
    camera = co.OrthographicCamera(there - 20 * np.array(towards, dtype=float), there, up=(0.1, 1, 0.3), height=1e-9)
    scene = co.Scene([co.Body(shape, co.matte(GREY))], [co.AmbientLight(1)], camera, background=(1, 1, 1))
    return tuple(scene.render(1, 1, 1).pixels[0, 0].tolist())


def on_the_wall(shape, turn, down=True):
    """What a ray from above (or below) meets at radius 1, 0.8 below (or above) the middle, at an angle in degrees."""
    x, y = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return seen(shape, 0.6 * x, 0.6 * y, towards=(0.5 * x, 0.5 * y, -1 if down else 1))


@pytest.mark.parametrize("turn", [0, 60, 200])
def test_a_cut_shows_the_cutters_paint(turn):
    """Through the mouth of the bore a slanted ray meets its wall, a straight one nothing."""
    shape = PLATE - BORE.painted(co.matte(RED))
    assert on_the_wall(shape, turn) == RED
    assert seen(shape, 1.5, 1.5) == GREY
    assert seen(shape) == (1, 1, 1)


def test_each_cut_has_its_own_paint():
    left, right = (POCKET.scale((0.5, 0.5, 1)).translate((x, 0, 0)) for x in (-1, 1))
    shape = (
        PLATE
        - left.painted(co.matte(RED))
        - right.painted(co.matte(BLUE))
        - POCKET.scale(0.25).translate((0, 1.5, 0.75))
    )
    assert [seen(shape, x) for x in (-1, 0, 1)] == [RED, GREY, BLUE]
    assert seen(shape, 0, 1.5) == GREY


def test_unions_and_intersections_keep_paint():
    ball = co.Sphere(1.5)
    assert seen(PLATE | ball.painted(co.matte(RED))) == RED
    assert seen(PLATE | ball.painted(co.matte(RED)), 1.5) == GREY
    common = ball.painted(co.matte(RED)) & PLATE
    assert seen(common) == GREY  # the top of the plate
    assert seen(common, 1.4) == RED  # the ball's own side, below that top
    assert seen(ball.painted(co.matte(RED)) & PLATE.painted(co.matte(BLUE))) == BLUE


def test_the_inner_paint_stays():
    shape = (PLATE - POCKET.painted(co.matte(RED))).painted(co.matte(GREEN))
    assert seen(shape) == RED
    assert seen(shape, 1.5) == GREEN
    assert seen(co.Sphere().painted(co.matte(RED)).painted(co.matte(GREEN)).painted(co.matte(BLUE))) == RED


def test_complements_keep_paint():
    shape = PLATE & ~POCKET.painted(co.matte(RED))
    assert seen(shape) == RED
    assert seen(~(~shape).painted(co.matte(GREEN)), 1.5) == GREEN


def test_paint_moves_along():
    pocket = POCKET.painted(co.matte(RED)).scale(0.5).translate((1, 0, 0.5))
    assert [seen(PLATE - pocket, x) for x in (-1, 1)] == [GREY, RED]
    turned = (PLATE - pocket).rotate((0, 0, 1), 180)
    assert [seen(turned, x) for x in (-1, 1)] == [RED, GREY]
    mirrored = (PLATE - pocket).painted(co.matte(GREEN)).scale((-1, 1, 1))
    assert [seen(mirrored, x) for x in (-1, 1)] == [RED, GREEN]


def test_where_faces_coincide_the_first_is_seen():
    """Both halves have the same top; the painted one is listed second, then first."""
    left, right = co.Box((-2, -2, -1), (0.5, 2, 1)), co.Box((-0.5, -2, -1), (2, 2, 1)).painted(co.matte(RED))
    assert [seen(left | right, x) for x in (-1, 0, 1)] == [GREY, GREY, RED]
    assert [seen(right | left, x) for x in (-1, 0, 1)] == [GREY, RED, RED]


def test_a_body_painted_all_over_is_one_of_that_material():
    camera = co.Camera((3, -5, 4), (0, 0, 0))
    lights = [co.PointLight((-4, -6, 8)), co.AmbientLight(0.2)]
    finish = co.lacquer("#b3131b")
    shape = PLATE - POCKET
    pictures = [
        co.Scene([body], lights, camera, co.Sky()).render(24, 18, 4).pixels
        for body in (co.Body(shape, finish), co.Body(shape.painted(finish), co.matte(GREY)))
    ]
    assert (pictures[0] == pictures[1]).all()


def test_checkers_on_the_uv_of_painted_faces():
    """The pocket's floor has uv = (x, y) / radius: squares of half a radius; its wall angle / 360 and height."""
    floor = PLATE - POCKET.painted(co.matte(co.Checker(RED, BLUE, scale=0.5)))
    assert [seen(floor, x, 0.25) for x in (-0.75, -0.25, 0.25, 0.75)] == [RED, BLUE, RED, BLUE]
    assert [seen(floor, x, -0.25) for x in (-0.75, -0.25, 0.25, 0.75)] == [BLUE, RED, BLUE, RED]
    wall = PLATE - BORE.painted(co.matte(co.Checker(RED, BLUE, scale=(0.5, 0.5))))
    low, high = ([on_the_wall(wall, turn, down) for turn in (60, 240)] for down in (True, False))
    assert sorted(low) == [BLUE, RED]
    assert low == high[::-1]


def test_checkers_move_with_paint():
    pocket = POCKET.painted(co.matte(co.Checker(RED, BLUE, scale=0.5))).translate((0.5, 0, 0))
    assert [seen(PLATE - pocket, x, 0.25) for x in (-0.25, 0.25, 0.75, 1.25)] == [RED, BLUE, RED, BLUE]


def test_a_picture_round_trips_to_the_bit(tmp_path):
    tiles = co.blinn_phong(co.Checker("#ffcc00", "#203040", scale=(0.125, 0.25)))
    bore = co.Cylinder((0, 0, -2), (0, 0, 2), 0.4).painted(tiles)
    part = ((co.Box() & co.Sphere(1.35)) - bore - bore.rotate((0, 1, 0), 90)).painted(co.lacquer("#2b5f93"))
    corner = co.Box((0, -2, 0), (2, 0, 2)).painted(co.matte("#b3131b"))
    scene = co.Scene(
        [co.Body((part - corner).rotate((1, 2, 3), 20), co.matte(GREY))], camera=co.Camera((3, -4, 3), (0, 0, 0))
    )
    co.save(scene, tmp_path / "scene.yaml")
    again = co.load(tmp_path / "scene.yaml")
    assert again == scene
    assert (again.render(48, 36, 4).pixels == scene.render(48, 36, 4).pixels).all()


def test_what_paint_is_refused_on():
    assert co.Sphere().painted("red") == co.Sphere().painted(co.matte("red"))
    assert co.Painted(co.Sphere(), np.array([1, 0, 0.5])).material == co.matte((1, 0, 0.5))
    for call, told in (
        (lambda: co.Sphere().painted(3), r"Painted: material must be a Material .* or a colour, got int"),
        (lambda: co.Painted(co.Disc((0, 0, 0), (0, 0, 1), 1), co.matte()), r"Painted: Disc is a sheet"),
        (lambda: co.Spheres([(0, 0, 0)], [1]).painted(co.matte()), r"Painted: operands must be solids, got Spheres"),
    ):
        with pytest.raises(TypeError, match=told):
            call()


def test_light_through_a_painted_face_of_glass_takes_its_tint():
    """A slab of index 1: its upper face tints, the lower one does not; a shadow ray met the body's own material on both."""
    tint = (1.0, 0.5, 0.25)
    clear, tinted = (
        co.Material("black", transparency=share, refractive_index=1.0, absorption=1e-9) for share in (1.0, tint)
    )
    top = co.HalfSpace((0, 0, 1), 1.5).painted(tinted)
    slab = co.Body(co.Box((-5, -5, 1), (5, 5, 2)) & top, clear)
    floor = co.Body(co.Plane((0, 0, 1), 0), co.matte((1.0, 1.0, 1.0)))
    view = co.OrthographicCamera((0, -1e-3, 1e-4), (0, 0, 0), up=(0, 0, 1), height=1e-9)
    scene = co.Scene([slab, floor], [co.DirectionalLight((0, 0, -1), 1.0)], view, "black")
    assert scene.render(1, 1, 1).pixels[0, 0] == pytest.approx(tint, rel=1e-6)
