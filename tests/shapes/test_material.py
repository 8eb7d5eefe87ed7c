"""Materials, textures, lights and backgrounds: records that say what is wrong with them."""

from __future__ import annotations

import dataclasses
import math

import pytest

import conicoid as co
from conicoid.materials.background import as_background
from conicoid.materials.light import as_lights
from conicoid.materials.material import Material
from conicoid.materials.presets import CONSTRUCTORS


def test_constants_are_those_of_the_source():
    assert (co.materials.VACUUM, co.materials.AIR, co.materials.WATER, co.materials.GLASS) == (1.0, 1.0003, 1.33, 1.52)


@pytest.mark.parametrize("name", CONSTRUCTORS)
def test_named_constructors_give_equal_records_that_survive_their_fields(name):
    material = CONSTRUCTORS[name]()
    assert material == CONSTRUCTORS[name]()
    assert hash(material) == hash(CONSTRUCTORS[name]())
    fields = {field.name: getattr(material, field.name) for field in dataclasses.fields(Material)}
    assert Material(**fields) == material


def test_constructors_choose_the_model():
    assert co.phong("red").highlight == "phong"
    assert co.blinn_phong("red").highlight == "blinn_phong"
    assert co.glass(co.materials.WATER).refractive_index == 1.33
    assert co.mirror(0.9).reflectivity == 0.9
    assert co.metal((1, 0.5, 0.2), reflectivity=0.5).reflectivity == (0.5, 0.25, 0.1)
    assert co.metal((1, 0.5, 0.2)).fresnel
    assert co.matte("red").specular == 0


def test_sequences_become_tuples():
    assert Material(color=[1, 0, 0]).color == (1.0, 0.0, 0.0)
    assert co.Checker("red", [0, 0, 1], scale=[2, 1]).scales == (2.0, 1.0, 1.0)
    assert co.Checker(scale=2).scales == (2.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (dict(color=(1, 2, 0)), r"Material: color\[1\] must be in \[0, 1\], got 2.0"),
        (dict(ambient=-1), "Material: ambient must be >= 0, got -1.0"),
        (dict(diffuse="much"), "Material: diffuse must be a number, got 'much'"),
        (dict(shininess=0), "Material: shininess must be > 0, got 0.0"),
        (dict(refractive_index=math.nan), "Material: refractive_index"),
        (dict(reflectivity=1.5), r"Material: reflectivity must be in \[0, 1\], got 1.5"),
        (dict(transparency=(0, 0)), "Material: transparency must be 3 numbers"),
        (dict(absorption=-2), "Material: absorption must be >= 0, got -2.0"),
        (dict(highlight="gouraud"), "Material: highlight must be 'phong' or 'blinn_phong', got 'gouraud'"),
        (dict(fresnel=1), "Material: fresnel must be true or false, got 1"),
    ],
)
def test_bad_materials_name_the_field(fields, message):
    with pytest.raises(ValueError, match=message):
        Material(**fields)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (dict(scale=0), "Checker: scale must be > 0, got 0.0"),
        (dict(scale=(1, -1)), r"Checker: scale\[1\] must be > 0, got -1.0"),
        (dict(scale=(1, 1, 1, 1)), "Checker: scale must be 3 numbers, got 4"),
        (dict(a="reddish"), "Checker: a must be"),
        (dict(space="yes"), "Checker: space must be true or false"),
    ],
)
def test_bad_checkers_name_the_field(fields, message):
    with pytest.raises(ValueError, match=message):
        co.Checker(**fields)


def test_intensities_may_exceed_one():
    assert co.PointLight((0, 0, 0), intensity=[10, 2, 3]).intensity == (10.0, 2.0, 3.0)


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
    # what is no light or background is a type error
    (
        lambda: as_lights([co.AmbientLight(), "sun"]),
        TypeError,
        r"Scene: lights\[1\] must be one of .*PointLight.*, got str",
    ),
    (lambda: as_background(3), TypeError, "Scene: background"),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED)
def test_what_is_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
