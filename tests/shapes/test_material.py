"""Materials, textures, lights, colours, the clear sky; materials by index of many bodies."""

import dataclasses
import math
import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid.materials.color import amount_rgb, check_amount, check_color, linear_rgb, srgb_decode, srgb_encode
from conicoid.materials.light import as_background, as_lights
from conicoid.materials.presets import CONSTRUCTORS

# --- Materials, textures, lights and backgrounds: errors name the wrong field


@pytest.mark.parametrize("name", CONSTRUCTORS)
def test_named_constructors_give_equal_records_that_survive_their_fields(name):
    material = CONSTRUCTORS[name]()
    assert material == CONSTRUCTORS[name]()
    assert hash(material) == hash(CONSTRUCTORS[name]())
    fields = {field.name: getattr(material, field.name) for field in dataclasses.fields(co.Material)}
    assert co.Material(**fields) == material


@pytest.mark.parametrize(("material", "field", "value"), [
    (co.phong("red"), "highlight", "phong"), (co.blinn_phong("red"), "highlight", "blinn_phong"), (co.mirror(0.9), "reflectivity", 0.9),
    (co.glass(co.materials.WATER), "refractive_index", 1.33), (co.matte("red"), "specular", 0), (co.metal((1, 0.5, 0.2)), "fresnel", True),
    (co.metal((1, 0.5, 0.2), reflectivity=0.5), "reflectivity", (0.5, 0.25, 0.1)), (co.Material(color=[1, 0, 0]), "color", (1.0, 0.0, 0.0)),
    (co.Checker("red", [0, 0, 1], scale=[2, 1]), "scales", (2.0, 1.0, 1.0)), (co.Checker(scale=2), "scales", (2.0, 2.0, 2.0)),
    (co.PointLight((0, 0, 0), intensity=[10, 2, 3]), "intensity", (10.0, 2.0, 3.0)),
])  # fmt: skip
def test_fields_of_constructors(material, field, value):
    assert getattr(material, field) == value


REFUSED = [
    # bad lights and backgrounds name the field
    (lambda: co.PointLight((0, 0)), ValueError, "PointLight: position must be 3 numbers"),
    (
        lambda: co.PointLight((0, 0, 0), falloff="linear"),
        ValueError,
        "PointLight: falloff must be 'none' or 'inverse_square'",
    ),
    (lambda: co.PointLight((0, 0, 0), intensity=-1), ValueError, "PointLight: intensity must be >= 0"),
    (lambda: co.DirectionalLight((0, 0, 0)), ValueError, "DirectionalLight: direction must not be zero"),
    (lambda: co.SpotLight((0, 0, 0), (0, 0, 1), angle=0), ValueError, r"SpotLight: angle must be in \(0, 180\], got 0"),
    (
        lambda: co.SpotLight((0, 0, 0), (0, 0, 1), 9, 10),
        ValueError,
        r"SpotLight: soft_edge must be in \[0, angle = 9\]",
    ),
    (lambda: co.AmbientLight("reddish"), ValueError, "AmbientLight: intensity must be"),
    (lambda: co.Sky(zenith=(-1, 0, 0)), ValueError, r"Sky: zenith\[0\] must be >= 0"),
    (lambda: as_background("reddish"), ValueError, "Scene: background must be"),
    # another object as a light or background is a type error
    (
        lambda: as_lights([co.AmbientLight(), "sun"]),
        TypeError,
        r"Scene: lights\[1\] must be one of .*PointLight.*, got str",
    ),
    (lambda: as_background(3), TypeError, "Scene: background"),
    # materials, textures and surroundings name the field
    (lambda: co.Material(color=(1, 2, 0)), ValueError, r"Material: color\[1\] must be in \[0, 1\], got 2.0"),
    (lambda: co.Material(ambient=-1), ValueError, "Material: ambient must be >= 0, got -1.0"),
    (lambda: co.Material(diffuse="much"), ValueError, "Material: diffuse must be a number, got 'much'"),
    (lambda: co.Material(shininess=0), ValueError, "Material: shininess must be > 0, got 0.0"),
    (lambda: co.Material(refractive_index=math.nan), ValueError, "Material: refractive_index"),
    (lambda: co.Material(reflectivity=1.5), ValueError, r"Material: reflectivity must be in \[0, 1\], got 1.5"),
    (lambda: co.Material(transparency=(0, 0)), ValueError, "Material: transparency must be 3 numbers"),
    (lambda: co.Material(absorption=-2), ValueError, "Material: absorption must be >= 0, got -2.0"),
    (
        lambda: co.Material(highlight="gouraud"),
        ValueError,
        "Material: highlight must be 'phong' or 'blinn_phong', got 'gouraud'",
    ),
    (lambda: co.Material(fresnel=1), ValueError, "Material: fresnel must be true or false, got 1"),
    (lambda: co.Checker(scale=0), ValueError, "Checker: scale must be > 0, got 0.0"),
    (lambda: co.Checker(scale=(1, -1)), ValueError, r"Checker: scale\[1\] must be > 0, got -1.0"),
    (lambda: co.Checker(scale=(1, 1, 1, 1)), ValueError, "Checker: scale must be 3 numbers, got 4"),
    (lambda: co.Checker(a="reddish"), ValueError, "Checker: a must be"),
    (lambda: co.Checker(space="yes"), ValueError, "Checker: space must be true or false"),
    (lambda: co.materials.clear_sky(sun=(0, 0, -1)), ValueError, "clear_sky: sun must not be below the horizon"),
    (lambda: co.materials.clear_sky(turbidity=1), ValueError, r"clear_sky: turbidity must be in \[2, 10\], got 1.0"),
    (
        lambda: co.materials.clear_sky(height=2),
        ValueError,
        "clear_sky: height must be a whole number from 4 to 4096, got 2",
    ),
    (
        lambda: co.Environment(np.ones((4, 8))),
        ValueError,
        r"Environment: pixels must have shape \(height, width, 3\), got \(4, 8\)",
    ),
    (
        lambda: co.Environment(-np.ones((4, 8, 3))),
        ValueError,
        r"Environment: pixels\[0, 0, 0\] must be finite and >= 0, got -1.0",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED)
def test_invalid_materials_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()


# --- Colors: sRGB by the standard's formula, names, and refusals


def srgb_of(linear: float) -> float:
    """Apply IEC 61966-2-1 to one number at a time."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * math.pow(linear, 1 / 2.4) - 0.055


def test_encoding_follows_the_standard():
    values = np.linspace(0, 1, 1001)
    assert np.abs(srgb_encode(values) - [srgb_of(v) for v in values]).max() < 1e-15
    assert srgb_encode(0.0) == 0
    assert srgb_encode(1.0) == pytest.approx(1, abs=1e-15)


def test_middle_grey():
    """0.5 of sRGB is ((0.5 + 0.055) / 1.055)^2.4 = 0.21404114 of light."""
    assert srgb_decode(0.5) == pytest.approx(0.21404114048223255, rel=1e-15)


def test_every_byte_survives_decoding_and_encoding():
    byte = np.arange(256)
    assert (np.rint(255 * srgb_encode(srgb_decode(byte / 255))) == byte).all()


def test_texts_are_srgb():
    half = ((0x80 / 255 + 0.055) / 1.055) ** 2.4
    assert linear_rgb("#ff0080") == pytest.approx((1, 0, half), rel=1e-15)
    assert linear_rgb("#f08") == linear_rgb("#ff0088")
    assert linear_rgb("white") == (1, 1, 1)
    assert linear_rgb("SteelBlue") == linear_rgb("#4682b4")
    assert linear_rgb((0.1, 0.2, 0.3)) == (0.1, 0.2, 0.3)


def test_colours_stay_as_written():
    assert check_color("M", "c", "#ff0080") == "#ff0080"
    assert check_color("M", "c", [1, 0, 0.5]) == (1.0, 0.0, 0.5)
    assert check_amount("M", "c", np.float32(0.5)) == 0.5
    assert amount_rgb(0.25) == (0.25, 0.25, 0.25)


@pytest.mark.parametrize(
    "bad", ["reddish", "#12345", "#gggggg", "", "hsl(0, 0%, 0%)", (1, 0), (1, 0, 2), (0, math.nan, 0), None, 1]
)
def test_invalid_colours_are_refused_by_name(bad):
    with pytest.raises(ValueError, match="Material: color"):
        check_color("Material", "color", bad)


# --- The clear sky: blue away from the sun, brightest at it, and lit ground below


def at(image, direction):
    """Return the pixel of a direction."""
    height, width, _ = image.pixels.shape
    x, y, z = np.array(direction) / np.linalg.norm(direction)
    row = min(height - 1, int(np.arccos(z) / np.pi * height))
    return image.pixels[row, int(np.arctan2(y, x) / (2 * np.pi) % 1 * width) % width]


def test_the_zenith_has_the_luminance_and_chromaticity_of_the_formula():
    """The zenith has the luminance of the formula in kcd/m². r, g and b make it up by Rec. 709."""
    sky = co.materials.clear_sky((1, 0, 1), 3.0, intensity=1.0, height=512)
    r, g, b = at(sky, (1e-6, 0, 1))
    chi = (4 / 9 - 3 / 120) * (np.pi - 2 * np.pi / 4)
    luminance = (4.0453 * 3 - 4.9710) * np.tan(chi) - 0.2155 * 3 + 2.4192
    assert 0.2126 * r + 0.7152 * g + 0.0722 * b == pytest.approx(luminance, rel=0.02)
    assert b > g > r


def test_it_is_brightest_at_the_sun():
    sky = co.materials.clear_sky((1, 1, 1), 3.0, height=64)
    light = sky.pixels[:32].mean(axis=2)
    row, column = np.unravel_index(light.argmax(), light.shape)
    theta, phi = (row + 0.5) / 64 * 180, (column + 0.5) / 128 * 360
    assert phi == pytest.approx(45, abs=4)
    assert theta >= 50  # near the sun, on the side of the horizon


def test_the_ground_sends_back_its_share():
    """Radiance is ρ E / π below the horizon, E = ∫ L cos, linear in the reflectance."""
    dark, bright = (co.materials.clear_sky(ground=(k, k, k), height=32).pixels[-1, 0] for k in (0.1, 0.4))
    assert bright == pytest.approx(4 * dark, rel=1e-6)
    assert (co.materials.clear_sky(ground="black", height=32).pixels[16:] == 0).all()


# --- Materials by index of many bodies in one entry: the same as if each body had its own


RED, BLUE = co.matte("red", name="red"), co.matte("blue", name="blue")
PLACES = 3.0 * np.arange(6)[:, None] * (1, 0, 0)
INDEX = [1, 1, 0, 1, 2, 2]
ENTRIES = {
    "Spheres": co.Spheres(PLACES, 1),
    "Boxes": co.Boxes(PLACES - 1, PLACES + 1),
    "Discs": co.Discs(PLACES, (0, 0, 1), 1),
}


def scene(name: str) -> co.Scene:
    many = co.Body(ENTRIES[name], materials=[RED, "blue", None], material_index=INDEX, name="many")
    return co.Scene([co.Body(co.Sphere(1, (0, 9, 0)), BLUE), many, co.Sphere(1, (0, -9, 0))])


def apart(one: co.Scene) -> co.Scene:
    return co.Scene([co.Body(body.shape, body.material) for body in one])


@pytest.mark.parametrize("name", ENTRIES)
def test_each_body_has_its_own(name: str) -> None:
    one = scene(name)
    blue = co.matte("blue")
    assert [body.material for body in one] == [BLUE, blue, blue, RED, blue, None, None, None]
    assert one.materials == (BLUE, blue, RED, None)
    hits = one.first_hit(np.array([*(PLACES + (0, 0, 5)), (0, 9, 5)]), (0, 0, -1))
    assert hits.material.tolist() == [blue, blue, RED, blue, None, None, BLUE]
    assert hits.name.tolist() == ["many"] * 6 + [None]
    assert hits[2:4].detached().material.tolist() == [RED, blue]


@pytest.mark.parametrize("name", ENTRIES)
def test_pictures_are_those_of_the_bodies_apart(name: str) -> None:
    one = scene(name)
    camera = co.Camera((8, -20, 12), (7, 0, 0))
    pictures = [each.render(width=60, height=40, camera=camera).pixels for each in (one, apart(one))]
    assert np.array_equal(*pictures)
    assert len(np.unique(pictures[0].reshape(-1, 3), axis=0)) > 20
    if name == "Boxes":
        assert np.array_equal(*(each.section("z", 0.5).pixels for each in (one, apart(one))))


@pytest.mark.parametrize("count", [1, 30])
def test_values(count: int, tmp_path) -> None:
    """Such entries are equal, and come back from pickles and scene files, inline and beside the scene."""
    shape = co.Spheres(np.tile(PLACES, (count, 1)), 1)
    body = co.Body(shape, materials=[RED, BLUE, None], material_index=np.tile(INDEX, count))
    other = co.Body(shape, materials=[RED, BLUE, None], material_index=np.tile(INDEX[::-1], count))
    assert body == pickle.loads(pickle.dumps(body)) != other
    assert hash(body) == hash(pickle.loads(pickle.dumps(body)))
    co.save(co.Scene([body, other]), tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml").bodies == (body, other)
    assert len(list(tmp_path.glob("scene-materials-*.npy"))) == (2 if count > 1 else 0)


def test_one_material_for_each_needs_no_index() -> None:
    body = co.Body(co.Spheres(PLACES[:2], 1), materials=["red", "blue"])
    assert [one.material for one in co.Scene([body])] == [co.matte("red"), co.matte("blue")]


@pytest.mark.parametrize(("make", "message"), [
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0] * 5), r"material_index must have shape \(6,\)"),
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0] * 5 + [1]), r"material_index\[5\] must be at least 0 and below 1, got 1"),
    (lambda shape: co.Body(shape, materials=["red"]), "materials must be as many as bodies .* got 1 materials for 6 bodies"),
    (lambda shape: co.Body(shape, "red", materials=["red"]), "material must be left out where materials are given"),
    (lambda shape: co.Body(shape, materials=["red", "blu"], material_index=INDEX), r"materials\[1\]: material must be .* got 'blu'"),
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0.5] * 6), "material_index must be integers"),
    (lambda shape: co.Body(shape, material_index=[0] * 6), "material_index must be left out, or go with materials"),
    (lambda shape: co.Body(shape.single(0), materials=["red"]), "materials are for many bodies in one entry"),
])  # fmt: skip
def test_refusals(make, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=f"^Body: {message}"):
        make(ENTRIES["Boxes"])
