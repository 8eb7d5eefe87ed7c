"""Lamps in Whitted's pictures: as bright as closed forms say, with penumbrae, and the same to the bit."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
NO_LIGHT = [co.AmbientLight(0)]
FLOOR = co.Body(co.Plane((0, 0, 1), 0), co.matte(WHITE))


def at(x=0.0, y=0.0):
    """A view of one point of the floor, under whatever is over it."""
    return co.OrthographicCamera((x, y - 1e-3, 1e-4), (x, y, 0), up=(0, 0, 1), height=1e-9)


def color(items, camera=None, samples=1024, lights=NO_LIGHT, **options):
    scene = co.Scene([FLOOR, *items], lights, camera or at(), BLACK)
    return scene.render(1, 1, samples, **options).pixels[0, 0]


def square(side, height):
    return co.Polygon([(x * side / 2, y * side / 2, height) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


CORNER = 1.5 / math.sqrt(1 + 1.5**2)


@pytest.mark.parametrize(
    ("shape", "factor"),
    [
        (co.Sphere(1, (0, 0, 2)), 1 / 4),
        (co.Disc((0, 0, 2), (0, 0, 1), 1), 1 / 5),
        (square(3, 1), 4 / math.pi * CORNER * math.atan(CORNER)),
        (co.Cylinder((0, 0, 2), (0, 0, 3), 1), 1 / 5),  # only its lower cap is seen
    ],
    ids=["ball", "disc", "square", "cylinder"],
)
def test_form_factors(shape, factor):
    """Radiance L and a form factor F give a white floor L F."""
    lamp = co.Body(shape, co.glow((3, 2, 0)))
    assert color([lamp], samples=4096) == pytest.approx(np.array((3, 2, 0)) * factor, rel=5e-3)


@pytest.mark.parametrize("share", [-1.2, -0.7, -0.2, 0.0, 0.5, 0.9, 1.2])
def test_the_penumbra_of_a_disc(share):
    """A half-plane halfway up hides what of the disc is at X < -x: a segment, (1/2 + (s √(1-s²) + asin s) / π) of it."""
    radius, height = 0.1, 10.0
    lamp = co.Body(co.Disc((0, 0, height), (0, 0, 1), radius), co.glow(1000))
    hides = co.Body(co.Polygon([(-9, -9, 5), (0, -9, 5), (0, 9, 5), (-9, 9, 5)]), co.matte(BLACK))
    s = min(1.0, max(-1.0, share))
    part = 0.5 + (s * math.sqrt(1 - s * s) + math.asin(s)) / math.pi
    full = 1000 * radius**2 / (radius**2 + height**2)
    seen = color([lamp, hides], at(share * radius), samples=4096)
    assert seen == pytest.approx([part * full] * 3, abs=4e-3 * full)


def test_many_lamps_add_up():
    """Each gives a floor under it, h below and aside by d, L R² h / (h² + d²)^{3/2}, about."""
    lamps = [co.Body(co.Sphere(0.05, (k, 0.5, 3)), co.glow(500 + 50 * k)) for k in range(20)]
    expected = sum((500 + 50 * k) * 0.05**2 / (9.25 + k * k) * 3 / math.sqrt(9.25 + k * k) for k in range(20))
    assert color(lamps, samples=1 << 13) == pytest.approx([expected] * 3, rel=0.01)
    few = sum((500 + 50 * k) * 0.05**2 / (9.25 + k * k) * 3 / math.sqrt(9.25 + k * k) for k in range(6))
    assert color(lamps[:6], samples=1 << 10) == pytest.approx([few] * 3, rel=0.005)


def test_lamps_and_lights_add_up():
    lamp = co.Body(co.Sphere(1, (0, 0, 2)), co.glow(1))
    light = co.PointLight((3, 0, 4), 2)
    seen = color([lamp], samples=2048, lights=[light, co.AmbientLight(0.1)])
    assert seen == pytest.approx([0.25 + 2 * 0.8 + 0.1] * 3, rel=3e-3)


def test_lamps_are_seen_in_mirrors_and_light_what_is_seen_there():
    """A mirror at 45° over the camera's ray: beyond it is a wall, that a disc lights as it does the floor."""
    wall = co.Body(co.Plane((-1, 0, 0), -2), co.matte(WHITE))
    mirror = co.Body(co.Disc((0, 0, 5), (1, 0, -1), 0.01), co.mirror(1.0))
    lamp = co.Body(co.Disc((0, 0, 5), (1, 0, 0), 1).translate((-0.5, 0, 0)), co.glow(1))
    view = co.OrthographicCamera((0, 0, 4.9), (0, 0, 5), up=(0, 1, 0), height=1e-9)
    seen = co.Scene([wall, mirror, lamp], NO_LIGHT, view, BLACK).render(1, 1, 4096).pixels[0, 0]
    whole = 1 / (1 + 2.5**2)  # less what the mirror hides: a disc of 0.01 that is 2 away, aslant
    assert seen == pytest.approx([whole] * 3, rel=5e-3)


def test_a_pane_dims_a_lamp_as_it_does_a_light():
    lamp = co.Body(co.Sphere(0.01, (0, 0, 4)), co.glow(1e5))
    pane = co.Body(co.Disc((0, 0, 2), (0, 0, 1), 1), co.Material(transparency=(1, 0.5, 0.25)))
    clear, dimmed = color([lamp], samples=64), color([lamp, pane], samples=64)
    assert dimmed / clear == pytest.approx([1, 0.5, 0.25], rel=1e-3)


def test_where_a_scene_has_no_lights_its_lamps_stand_for_them():
    lamp = co.Body(co.Disc((0, 0, 4), (0, 0, 1), 1), co.glow(1))
    hides = co.Body(co.Disc((0, 0, 2), (0, 0, 1), 3), co.matte(BLACK))
    dark, lit = (color(items, samples=256, lights=[]) for items in ([lamp, hides], [lamp]))
    ambient = dark.mean()
    assert 0 < ambient < 1
    assert lit - dark == pytest.approx([1 / 17] * 3, rel=5e-3)


def test_the_same_to_the_bit_whatever_is_asked_at_once(tmp_path):
    scene = co.Scene(
        [FLOOR, co.Sphere(0.6, (0, 0, 0.6)), co.Body(co.Sphere(0.7, (1, -2, 3)), co.glow(5))],
        NO_LIGHT, co.Camera((0, -6, 3), (0, 0, 0.5)), BLACK,
    )  # fmt: skip
    one = scene.render(70, 50, 4).pixels
    assert (scene.render(70, 50, 4, resume=tmp_path / "picture.part").pixels == one).all()
    assert (scene.render(70, 50, 4, seed=1).pixels != one).any()
    assert len(np.unique(one)) > 500


def test_what_glows_and_is_no_lamp_that_is_drawn_from_gives_no_light():
    """As it says in docs/pictures.md: a box shines and lights nothing."""
    assert color([co.Body(co.Box((-1, -1, 2), (1, 1, 3)), co.glow(1))], samples=4).max() == 0
