"""Painted faces: their colors in cuts, combinations and motions, for straight rays and in pictures."""

import numpy as np
import pytest

import conicoid as co

RED, GREEN, BLUE, GREY = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.25, 0.25, 0.25)
PLATE = co.Box((-2, -2, -1), (2, 2, 1))
BORE = co.Cylinder((0, 0, -1), (0, 0, 1), 1)
POCKET = co.Cylinder((0, 0, 0), (0, 0, 1), 1)


def color_along(shape, x=0.0, y=0.0, towards=(0, 0, -1)):
    """Return the color of a grey body along a far ray through (x, y, 0)."""
    there = np.array((x, y, 0.0))
    camera = co.OrthographicCamera(there - 20 * np.array(towards, dtype=float), there, up=(0.1, 1, 0.3), height=1e-9)
    scene = co.Scene([co.Body(shape, co.matte(GREY))], [co.AmbientLight(1)], camera, background=(1, 1, 1))
    return tuple(scene.render(1, 1, 1).pixels[0, 0].tolist())


def on_the_wall(shape, turn, down=True):
    """Return the hit of a vertical ray at radius 1, 0.8 beyond the middle, at an angle in degrees."""
    x, y = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return color_along(shape, 0.6 * x, 0.6 * y, towards=(0.5 * x, 0.5 * y, -1 if down else 1))


LEFT, RIGHT = (POCKET.scale((0.5, 0.5, 1)).translate((x, 0, 0)) for x in (-1, 1))
RED_BALL, RED_POCKET = co.Sphere(1.5).painted(co.matte(RED)), POCKET.painted(co.matte(RED))
BESIDE = PLATE - RED_POCKET.scale(0.5).translate((1, 0, 0.5))
WEST, EAST = co.Box((-2, -2, -1), (0.5, 2, 1)), co.Box((-0.5, -2, -1), (2, 2, 1)).painted(co.matte(RED))
"""Both halves have the same top."""
TILES = POCKET.painted(co.matte(co.Checker(RED, BLUE, scale=0.5)))
"""The pocket's floor has uv = (x, y) / radius: squares of half a radius."""
SEEN = {
    "a cut": (PLATE - BORE.painted(co.matte(RED)), {(1.5, 1.5): GREY, (0, 0): (1, 1, 1)}),
    "cuts of three paints": (
        PLATE - LEFT.painted(co.matte(RED)) - RIGHT.painted(co.matte(BLUE)) - POCKET.scale(0.25).translate((0, 1.5, 0.75)),
        {(-1, 0): RED, (0, 0): GREY, (1, 0): BLUE, (0, 1.5): GREY},
    ),
    "a union": (PLATE | RED_BALL, {(0, 0): RED, (1.5, 0): GREY}),
    "an intersection: the top of the plate, the ball's side": (RED_BALL & PLATE, {(0, 0): GREY, (1.4, 0): RED}),
    "an intersection of painted ones": (RED_BALL & PLATE.painted(co.matte(BLUE)), {(0, 0): BLUE}),
    "the inner paint": ((PLATE - RED_POCKET).painted(co.matte(GREEN)), {(0, 0): RED, (1.5, 0): GREEN}),
    "the innermost paint": (RED_BALL.painted(co.matte(GREEN)).painted(co.matte(BLUE)), {(0, 0): RED}),
    "a complement": (PLATE & ~RED_POCKET, {(0, 0): RED, (1.5, 0): GREY}),
    "a painted complement": (~(~(PLATE & ~RED_POCKET)).painted(co.matte(GREEN)), {(0, 0): RED, (1.5, 0): GREEN}),
    "moved": (BESIDE, {(-1, 0): GREY, (1, 0): RED}),
    "turned": (BESIDE.rotate((0, 0, 1), 180), {(-1, 0): RED, (1, 0): GREY}),
    "mirrored": (BESIDE.painted(co.matte(GREEN)).scale((-1, 1, 1)), {(-1, 0): RED, (1, 0): GREEN}),
    "coinciding, the painted one second": (WEST | EAST, {(-1, 0): GREY, (0, 0): GREY, (1, 0): RED}),
    "coinciding, the painted one first": (EAST | WEST, {(-1, 0): GREY, (0, 0): RED, (1, 0): RED}),
    "tiles": (PLATE - TILES, {
        (-0.75, 0.25): RED, (-0.25, 0.25): BLUE, (0.25, 0.25): RED, (0.75, 0.25): BLUE,
        (-0.75, -0.25): BLUE, (-0.25, -0.25): RED, (0.25, -0.25): BLUE, (0.75, -0.25): RED,
    }),
    "tiles that are moved": (
        PLATE - TILES.translate((0.5, 0, 0)), {(-0.25, 0.25): RED, (0.25, 0.25): BLUE, (0.75, 0.25): RED, (1.25, 0.25): BLUE}),
}  # fmt: skip


@pytest.mark.parametrize("name", SEEN)
def test_the_first_wall_has_its_own_paint(name):
    shape, colors = SEEN[name]
    assert {place: color_along(shape, *place) for place in colors} == colors


@pytest.mark.parametrize("turn", [0, 60, 200])
def test_a_slanted_ray_sees_the_paint_of_a_bore(turn):
    assert on_the_wall(PLATE - BORE.painted(co.matte(RED)), turn) == RED


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


def test_checkers_on_the_wall_of_a_bore():
    """Its uv is angle / 360 and height."""
    wall = PLATE - BORE.painted(co.matte(co.Checker(RED, BLUE, scale=(0.5, 0.5))))
    low, high = ([on_the_wall(wall, turn, down) for turn in (60, 240)] for down in (True, False))
    assert sorted(low) == [BLUE, RED]
    assert low == high[::-1]


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


def test_invalid_paint_is_refused():
    assert co.Sphere().painted("red") == co.Sphere().painted(co.matte("red"))
    assert co.Painted(co.Sphere(), np.array([1, 0, 0.5])).material == co.matte((1, 0, 0.5))
    for call, message in (
        (lambda: co.Sphere().painted(3), r"Painted: material must be a Material .* or a colour, got int"),
        (lambda: co.Painted(co.Disc((0, 0, 0), (0, 0, 1), 1), co.matte()), r"Painted: Disc is a sheet"),
        (lambda: co.Spheres([(0, 0, 0)], [1]).painted(co.matte()), r"Painted: operands must be solids, got Spheres"),
    ):
        with pytest.raises(TypeError, match=message):
            call()


def test_light_through_a_painted_face_of_glass_takes_its_tint():
    """The upper face of a slab of index 1 tints, and the lower one does not.

    A shadow ray met the body's own material on both.
    """
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
