"""Roughness, bumps and normals by textures: against slopes in closed form, plain materials, and white furnaces."""

import math

import numpy as np
import pytest

import conicoid as co

from ..samples import deep

WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
DOWN = co.OrthographicCamera((0.1, 0.2, 3), (0.1, 0.2, 0), up=(0, 1, 0), height=0.2)
SLOPE = co.materials.Gradient(BLACK, WHITE, along="x", length=2, offset=-1)
LAMP = (0.48, 0.6, 0.64)


def seen(item, light=None, camera=DOWN, background=BLACK, **options):
    scene = co.Scene([item], [light or co.AmbientLight(0)], camera, background)
    return scene.render(3, 3, 1, **options).pixels


def flat(**properties):
    return co.Body(co.Box((-2, -2, -1), (2, 2, 0)), co.Material(WHITE, **properties))


@pytest.mark.parametrize("integrator", ["whitted", "path", "direct"])
@pytest.mark.parametrize("height", [1.0, -0.5, 3.0])
def test_an_even_slope_tilts_the_normal(integrator, height):
    """Height h over the length 2: the normal is along (-h / 2, 0, 1)."""
    normal = np.array((-height / 2, 0, 1)) / math.hypot(height / 2, 1)
    light = co.DirectionalLight(tuple(-part for part in LAMP))
    pixels = seen(flat(bump=SLOPE, bump_height=height), light, integrator=integrator)
    assert pixels == pytest.approx(max(0.0, float(normal @ LAMP)), rel=1e-5)


@pytest.mark.parametrize("integrator", ["whitted", "path"])
def test_a_sloped_mirror_reflects_by_its_slope(integrator):
    """The sky is linear in √z. A ray straight down goes on along 2 (n·z) n - z."""
    n = np.array((-0.2, 0, 1)) / math.hypot(0.2, 1)
    z = 2 * n[2] * n[2] - 1
    item = co.Body(co.Box((-2, -2, -1), (2, 2, 0)), co.Material(BLACK, reflectivity=1.0, bump=SLOPE, bump_height=0.4))
    pixels = seen(item, background=co.Sky(zenith=WHITE, horizon=BLACK), integrator=integrator)
    assert pixels == pytest.approx(math.sqrt(z), rel=1e-5)


@pytest.mark.parametrize("integrator", ["whitted", "path"])
@pytest.mark.parametrize(("code", "normal"), [((0.8, 0.5, 0.9), (0.6, 0, 0.8)), ((0.5, 0.2, 0.9), (0, -0.6, 0.8))])
def test_maps_of_normals_go_by_the_surface_s_own_coordinates(integrator, code, normal):
    """On a cylinder about z, u grows towards y for a view from x, v towards z, and x is outward."""
    image = np.broadcast_to(np.array(code, np.float32), (4, 4, 3))
    map_of = co.materials.ImageTexture(image, data=True)
    post = co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 1), co.Material(WHITE, normal=map_of))
    view = co.OrthographicCamera((3, 0, 0.1), (0, 0, 0.1), height=1e-6)
    light = co.DirectionalLight((-LAMP[2], -LAMP[0], -LAMP[1]))
    expected = normal[0] * LAMP[0] + normal[1] * LAMP[1] + normal[2] * LAMP[2]
    assert seen(post, light, view, integrator=integrator) == pytest.approx(expected, rel=1e-4)


def test_light_from_behind_the_true_surface_is_none():
    """The bumps of a sheet lean towards a lamp below it."""
    sheet = co.Body(co.Disc((0, 0, 0), (0, 0, 1), 5), co.Material(WHITE, bump=SLOPE, bump_height=-9.0))
    light = co.DirectionalLight((-0.9, 0, 0.2))
    for integrator in ("whitted", "path"):
        assert seen(sheet, light, integrator=integrator).max() == 0
    assert seen(sheet, co.DirectionalLight((-0.9, 0, -0.2))).min() > 0.5


NOISE = co.materials.Noise((0, 0, 0), WHITE, scale=0.2)
BUMPS = dict(bump=NOISE, bump_height=0.3)
ROUGH = co.materials.Noise((0, 0, 0), WHITE, scale=0.15)


@pytest.mark.parametrize(
    "material",
    [
        co.Material(WHITE, **BUMPS),
        deep(co.Material(BLACK, reflectivity=1.0, **BUMPS)),
        deep(co.Material(BLACK, diffuse=0.0, transparency=1.0, refractive_index=1.5, **BUMPS)),
        co.matte(WHITE, roughness=ROUGH),
        deep(co.glass(1.5, roughness=ROUGH, specular=0)),
        deep(co.plastic(WHITE, roughness=ROUGH)),
        co.Material(WHITE, coat=1.5, reflectivity=0.04, fresnel=True, roughness=ROUGH, **BUMPS),
        co.Material(BLACK, diffuse=0.0, transparency=1.0, refractive_index=1.5, roughness=ROUGH, **BUMPS),
    ],
    ids=["matte bumps", "mirror bumps", "glass bumps", "matte", "glass", "plastic", "plastic bumps", "all of glass"],
)
def test_bodies_without_absorption_are_invisible_in_a_white_furnace(material):
    view = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=1.6)
    scene = co.Scene([co.Body(co.Sphere(1), material)], [], view, WHITE)
    image = scene.render(16, 16, 256, "path", depth=100, layers="error")
    pixels = image.pixels.mean(axis=2)
    spread = max(1e-6, float(pixels.std())) / 16
    assert pixels.mean() == pytest.approx(1.0, abs=5 * spread + 1e-6)
    assert spread < 0.01


@pytest.mark.parametrize("make", [co.materials.gold, lambda roughness: co.glass(1.5, roughness=roughness)])
def test_a_texture_of_one_value_is_that_value(make):
    """0.25 is one of the steps of roughness, so the picture is the same to the bit."""
    one = co.materials.Noise((0.25,) * 3, (0.25,) * 3)
    pictures = []
    for roughness in (0.25, one):
        ball = co.Body(co.Sphere(1), make(roughness=roughness))
        scene = co.Scene([ball], [], co.Camera((0, -4, 1), (0, 0, 0)), co.Sky())
        pictures.append(scene.render(16, 12, 4, "path").pixels)
    assert (pictures[0] == pictures[1]).all()


def test_between_two_steps_it_is_between_them():
    """0.3 lies 0.3 · 256 - 64 = 12.8 of 17 from 0.25 to (9/16)². The picture is the mean of 64 pictures of both."""
    shares = {}
    for roughness in (0.25, (9 / 16) ** 2, co.materials.Noise((0.3,) * 3, (0.3,) * 3)):
        view = co.OrthographicCamera((0, 0.6, 5), (0, 0.6, 0), up=(0, 1, 0), height=1e-6)
        ball = co.Body(co.Sphere(1), co.materials.gold(roughness=roughness))
        scene = co.Scene([ball], [co.DirectionalLight((0.1, -0.5, -1))], view, BLACK)
        shares[str(roughness)[:4]] = scene.render(1, 1, 1 << 14, "direct").pixels[0, 0, 0]
    low, high, between = shares.values()
    assert between == pytest.approx(low + 12.8 / 17 * (high - low), rel=0.01)


def test_scene_files_keep_them(tmp_path):
    material = co.plastic("red", roughness=co.materials.Noise(BLACK, (0.5,) * 3, scale=0.1))
    bumpy = co.Material(bump=co.materials.Brick(), bump_height=0.01, roughness=co.materials.Wood())
    scene = co.Scene([co.Body(co.Sphere(1), material), co.Body(co.Sphere(2), bumpy)])
    co.save(scene, tmp_path / "scene.yaml")
    back = co.load(tmp_path / "scene.yaml")
    assert [body.material for body in back.bodies] == [material, bumpy]


@pytest.mark.parametrize(
    ("properties", "error", "message"),
    [
        (dict(bump="red"), TypeError, "Material: bump must be a texture"),
        (dict(bump=NOISE, bump_height=math.inf), ValueError, "Material: bump_height must be finite"),
        (dict(normal=NOISE), TypeError, "Material: normal must be an ImageTexture"),
        (
            dict(normal=co.materials.ImageTexture(np.zeros((2, 2, 3)))),
            ValueError,
            "Material: normal must be a texture of plain",
        ),
        (dict(roughness=1.5), ValueError, r"Material: roughness must be in \[0, 1\], got 1.5"),
        (dict(roughness="red"), ValueError, "Material: roughness must be a number"),
    ],
)
def test_refusals(properties, error, message):
    with pytest.raises(error, match=message):
        co.Material(**properties)
