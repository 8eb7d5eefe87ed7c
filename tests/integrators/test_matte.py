"""Direct light in lanes: the same to the bit as ray by ray, which any glass in a scene asks for."""

import math

import numpy as np
import pytest

import conicoid as co

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
    """Where their places at infinity are no numbers: 0 times infinity."""
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
    """There is no way from it to the point where it is; its neighbours see it at a right angle to their normals."""
    light = co.PointLight((0, 0, 0), 1, falloff="inverse_square")
    camera = co.OrthographicCamera((0, 0, 1), (0, 0, 0), up=(0, 1, 0), height=2)
    scene = co.Scene([co.Body(co.Box((-1, -1, -1), (1, 1, 0)), GREY)], [light], camera, "black")
    assert np.isfinite(scene.render(3, 3, 1, "direct").pixels).all()


def test_a_point_over_a_floor_and_its_shadow():
    """I cos(a) / d² of intensity I, times the albedo: 1 / π of Lambert's law is in the unit of intensity."""
    floor = co.Body(co.Box((-9, -9, -1), (9, 9, 0)), co.matte((0.5, 0.25, 1)))
    roof = co.Body(co.Sphere(0.5, (4, 0, 1)), co.matte("white"))
    scene = co.Scene([floor, roof], lights=[co.PointLight((4, 0, 3), 2, falloff="inverse_square")], background="black")
    for x, y, shade in ((0, 0, 1), (4, 4, 1), (4, 0.1, 0), (1, -3, 1)):
        camera = co.OrthographicCamera((x, y, 0.01), (x, y, 0), up=(0, 1, 0), height=1e-6)
        square = (x - 4) ** 2 + y**2 + 9
        light = shade * 2 * 3 / math.sqrt(square) / square
        seen = scene.render(1, 1, 1, "direct", camera=camera).pixels[0, 0].tolist()
        assert seen == pytest.approx([0.5 * light, 0.25 * light, light], rel=1e-5)
