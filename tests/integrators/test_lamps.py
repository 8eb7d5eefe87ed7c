"""Direct light: lamps in Whitted's pictures by closed forms, and light in lanes with the same bits."""

import math

import numpy as np
import pytest

import conicoid as co

# --- Lamps in Whitted's pictures: the brightness of closed forms, penumbrae, and the same bits everywhere


WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
NO_LIGHT = [co.AmbientLight(0)]
FLOOR = co.Body(co.Plane((0, 0, 1), 0), co.matte(WHITE))


def at(x=0.0, y=0.0):
    """Return a view of one point of the floor, under any bodies over it."""
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
    """A lamp of radiance L with a form factor F gives a white floor L F."""
    lamp = co.Body(shape, co.glow((3, 2, 0)))
    assert color([lamp], samples=4096) == pytest.approx(np.array((3, 2, 0)) * factor, rel=5e-3)


@pytest.mark.parametrize("share", [-1.2, -0.7, -0.2, 0.0, 0.5, 0.9, 1.2])
def test_the_penumbra_of_a_disc(share):
    """A half-plane halfway up hides the part of the disc at X < -x, a segment: (1/2 + (s √(1-s²) + asin s) / π) of it."""
    radius, height = 0.1, 10.0
    lamp = co.Body(co.Disc((0, 0, height), (0, 0, 1), radius), co.glow(1000))
    hides = co.Body(co.Polygon([(-9, -9, 5), (0, -9, 5), (0, 9, 5), (-9, 9, 5)]), co.matte(BLACK))
    s = min(1.0, max(-1.0, share))
    part = 0.5 + (s * math.sqrt(1 - s * s) + math.asin(s)) / math.pi
    full = 1000 * radius**2 / (radius**2 + height**2)
    radiance = color([lamp, hides], at(share * radius), samples=4096)
    assert radiance == pytest.approx([part * full] * 3, abs=4e-3 * full)


def test_many_lamps_add_up():
    """Each lamp, h above the floor and aside by d, gives about L R² h / (h² + d²)^{3/2}."""
    lamps = [co.Body(co.Sphere(0.05, (k, 0.5, 3)), co.glow(500 + 50 * k)) for k in range(20)]
    expected = sum((500 + 50 * k) * 0.05**2 / (9.25 + k * k) * 3 / math.sqrt(9.25 + k * k) for k in range(20))
    assert color(lamps, samples=1 << 13) == pytest.approx([expected] * 3, rel=0.01)
    few = sum((500 + 50 * k) * 0.05**2 / (9.25 + k * k) * 3 / math.sqrt(9.25 + k * k) for k in range(6))
    assert color(lamps[:6], samples=1 << 10) == pytest.approx([few] * 3, rel=0.005)


def test_lamps_and_lights_add_up():
    lamp = co.Body(co.Sphere(1, (0, 0, 2)), co.glow(1))
    light = co.PointLight((3, 0, 4), 2)
    radiance = color([lamp], samples=2048, lights=[light, co.AmbientLight(0.1)])
    assert radiance == pytest.approx([0.25 + 2 * 0.8 + 0.1] * 3, rel=3e-3)


def test_lamps_in_mirrors_are_visible_and_light_mirrored_bodies():
    """A mirror stands at 45° over the camera's ray. Beyond it is a wall, which a disc lights as it does the floor."""
    wall = co.Body(co.Plane((-1, 0, 0), -2), co.matte(WHITE))
    mirror = co.Body(co.Disc((0, 0, 5), (1, 0, -1), 0.01), co.mirror(1.0))
    lamp = co.Body(co.Disc((0, 0, 5), (1, 0, 0), 1).translate((-0.5, 0, 0)), co.glow(1))
    view = co.OrthographicCamera((0, 0, 4.9), (0, 0, 5), up=(0, 1, 0), height=1e-9)
    radiance = co.Scene([wall, mirror, lamp], NO_LIGHT, view, BLACK).render(1, 1, 4096).pixels[0, 0]
    whole = 1 / (1 + 2.5**2)  # less the part behind the mirror: a disc of 0.01 at a distance of 2, aslant
    assert radiance == pytest.approx([whole] * 3, rel=5e-3)


def test_a_pane_dims_a_lamp_as_it_does_a_light():
    lamp = co.Body(co.Sphere(0.01, (0, 0, 4)), co.glow(1e5))
    pane = co.Body(co.Disc((0, 0, 2), (0, 0, 1), 1), co.Material(transparency=(1, 0.5, 0.25)))
    clear, dimmed = color([lamp], samples=64), color([lamp, pane], samples=64)
    assert dimmed / clear == pytest.approx([1, 0.5, 0.25], rel=1e-3)


def test_lamps_replace_missing_lights():
    lamp = co.Body(co.Disc((0, 0, 4), (0, 0, 1), 1), co.glow(1))
    hides = co.Body(co.Disc((0, 0, 2), (0, 0, 1), 3), co.matte(BLACK))
    dark, lit = (color(items, samples=256, lights=[]) for items in ([lamp, hides], [lamp]))
    ambient = dark.mean()
    assert 0 < ambient < 1
    assert lit - dark == pytest.approx([1 / 17] * 3, rel=5e-3)


def test_pictures_are_equal_to_the_bit_in_any_combination(tmp_path):
    scene = co.Scene(
        [FLOOR, co.Sphere(0.6, (0, 0, 0.6)), co.Body(co.Sphere(0.7, (1, -2, 3)), co.glow(5))],
        NO_LIGHT, co.Camera((0, -6, 3), (0, 0, 0.5)), BLACK,
    )  # fmt: skip
    one = scene.render(70, 50, 4).pixels
    assert (scene.render(70, 50, 4, resume=tmp_path / "picture.part").pixels == one).all()
    assert (scene.render(70, 50, 4, seed=1).pixels != one).any()
    assert len(np.unique(one)) > 500


def test_glowing_bodies_that_are_no_lamps_give_no_light():
    """docs/pictures.md says so: a box glows and lights nothing."""
    assert color([co.Body(co.Box((-1, -1, 2), (1, 1, 3)), co.glow(1))], samples=4).max() == 0


# --- Direct light in lanes: the same bits as ray by ray, which any glass in a scene requires


GREY = co.matte((0.7, 0.5, 0.3))
BODIES = {
    "balls": [co.Body(co.Sphere(0.4, (x, y, 0.1 * x * y)), GREY) for x in range(-3, 4) for y in range(-3, 4)],
    "walls": [
        co.Body(co.Box((-3, -3, -1), (3, 3, 0)) - co.Cylinder((0, 0, -2), (0, 0, 1), 1), GREY),
        co.Body(co.Cone((1, 1, 1.5), (1, 1, 0), 0, 0.5), co.matte("red")), co.Body(co.Disc((-1, 1, 1), (1, 0, 2), 0.7), GREY),
    ],
    "of many kinds": [
        co.Body(co.Sphere(1, (-1.5, 0, 0)), co.matte("red")), co.Body(co.Sphere(1, (1.5, 0, 0)), co.matte(co.Checker("white", "black"))),
        co.Body(co.Sphere(1, (0, 1.5, 0)), co.matte("blue", roughness=0.4)), co.Body(co.Sphere(1, (0, -1.5, 0)), co.materials.gold(0.3)),
        co.Body(co.Box((-4, -4, -3), (4, 4, -2)), co.phong("green")),
    ],
}  # fmt: skip
LIGHTS = {
    "a point": co.PointLight((2, -3, 6), 9, falloff="inverse_square"),
    "a point that does not fade": co.PointLight((2, -3, 6), 0.5),
    "the sun": co.DirectionalLight((1, 2, -3), 0.8),
}
CAMERA = co.Camera((1, -6, 9), (0, 0, 0), field_of_view=45)
OUT_OF_SIGHT = co.Body(co.Sphere(0.1, (0, 0, 500)), co.glass(1.5))


@pytest.mark.parametrize("bodies", BODIES)
@pytest.mark.parametrize("light", LIGHTS)
def test_as_ray_by_ray(bodies, light):
    settings = dict(camera=CAMERA, lights=[LIGHTS[light]], background="black")
    together, alone = (
        co.Scene([*BODIES[bodies], *more], **settings).render(70, 50, 3, "direct").pixels
        for more in ((), (OUT_OF_SIGHT,))
    )
    assert (together > 0).mean() > 0.2
    assert np.array_equal(together, alone)


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("up", [(0, 0, 1), (1, 0, 0)])
def test_rays_along_an_axis_that_meet_nothing(light, up):
    """Their places at infinity are not numbers: 0 times infinity."""
    camera = co.OrthographicCamera((0, -9, 0), (0, 0, 0), up=up, height=4)
    settings = dict(camera=camera, lights=[LIGHTS[light]], background="black")
    ball = co.Body(co.Sphere(1), GREY)
    together, alone = (
        co.Scene([ball, *more], **settings).render(24, 24, 4, "direct").pixels for more in ((), (OUT_OF_SIGHT,))
    )
    assert np.isfinite(together).all()
    assert (together[0] == 0).all()
    assert (together > 0).any()
    assert np.array_equal(together, alone)


def test_a_light_on_the_wall_that_it_lights():
    """The light has no way to the point where it is. Its neighbours see it at a right angle to their normals."""
    light = co.PointLight((0, 0, 0), 1, falloff="inverse_square")
    camera = co.OrthographicCamera((0, 0, 1), (0, 0, 0), up=(0, 1, 0), height=2)
    scene = co.Scene([co.Body(co.Box((-1, -1, -1), (1, 1, 0)), GREY)], [light], camera, "black")
    assert np.isfinite(scene.render(3, 3, 1, "direct").pixels).all()


def test_a_point_over_a_floor_and_its_shadow():
    """The point has I cos(a) / d² of intensity I, times the albedo: 1 / π of Lambert's law is in the unit of intensity."""
    floor = co.Body(co.Box((-9, -9, -1), (9, 9, 0)), co.matte((0.5, 0.25, 1)))
    roof = co.Body(co.Sphere(0.5, (4, 0, 1)), co.matte("white"))
    scene = co.Scene([floor, roof], lights=[co.PointLight((4, 0, 3), 2, falloff="inverse_square")], background="black")
    for x, y, shade in ((0, 0, 1), (4, 4, 1), (4, 0.1, 0), (1, -3, 1)):
        camera = co.OrthographicCamera((x, y, 0.01), (x, y, 0), up=(0, 1, 0), height=1e-6)
        square = (x - 4) ** 2 + y**2 + 9
        light = shade * 2 * 3 / math.sqrt(square) / square
        radiance = scene.render(1, 1, 1, "direct", camera=camera).pixels[0, 0].tolist()
        assert radiance == pytest.approx([0.5 * light, 0.25 * light, light], rel=1e-5)
