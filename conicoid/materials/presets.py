"""Named constructors of materials: matte, shining, clear, glowing. Metals by their complex index are in `metals`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np

from .._util.arrays import VectorLike
from .._util.hints import with_call_hints
from .._util.validation import check_number, check_numbers, describe_kind
from .coating import Coating
from .color import Amount, Color, check_color, linear_rgb
from .dispersion import Index
from .material import GLASS, Material, MaterialMaker, record_maker, typical_roughness
from .properties import NO_PROPERTIES
from .texture import PATTERNS, Pattern, Texture


@with_call_hints
def matte(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    ambient: float = 1.0,
    diffuse: float = 1.0,
    *,
    roughness: float | Texture = 0.0,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Lambert's law alone.

    color: diffuse reflectance, linear rgb, a text in sRGB or a Checker or texture.
    ambient, diffuse: how much of the ambient light, and of that of other lights, it sends on.
    roughness: over 0, in light transport, Oren and Nayar's law in its place, of that σ.
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        color=color, ambient=ambient, diffuse=diffuse, roughness=roughness, name=name, properties=properties
    )
    return record_maker(made, matte, {})


@with_call_hints
def phong(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    specular: Amount = 0.5,
    shininess: float = 50.0,
    ambient: float = 1.0,
    diffuse: float = 1.0,
    reflectivity: Amount = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A plastic with Phong's highlight (R·E)^shininess.

    color: diffuse reflectance, linear rgb, a text in sRGB or a Checker or texture.
    specular: how strong highlights are, in [0, 1]: one number, or a colour.
    shininess: > 0; the greater, the smaller the highlight.
    ambient, diffuse: how much of the ambient light, and of that of other lights, it sends on.
    reflectivity: the share of light that it mirrors, in [0, 1]: one number, or a colour.
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        color, ambient, diffuse, specular, shininess, "phong", reflectivity, name=name, properties=properties
    )
    return record_maker(made, phong, {})


@with_call_hints
def blinn_phong(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    specular: Amount = 0.5,
    shininess: float = 100.0,
    ambient: float = 1.0,
    diffuse: float = 1.0,
    reflectivity: Amount = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A plastic with the half-vector highlight (H·N)^shininess.

    color: diffuse reflectance, linear rgb, a text in sRGB or a Checker or texture.
    specular: how strong highlights are, in [0, 1]: one number, or a colour.
    shininess: > 0; the greater, the smaller the highlight.
    ambient, diffuse: how much of the ambient light, and of that of other lights, it sends on.
    reflectivity: the share of light that it mirrors, in [0, 1]: one number, or a colour.
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        color, ambient, diffuse, specular, shininess, "blinn_phong", reflectivity, name=name, properties=properties
    )
    return record_maker(made, blinn_phong, {})


@with_call_hints
def lacquer(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    specular: Amount = 0.8,
    shininess: float = 300.0,
    reflectivity: Amount = 0.04,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A colour under clear lacquer: a sharp highlight, and reflections that grow towards the rim.

    color: diffuse reflectance, linear rgb, a text in sRGB or a Checker or texture.
    specular: how strong highlights are, in [0, 1]: one number, or a colour.
    shininess: > 0; the greater, the smaller the highlight.
    reflectivity: the share of light that it mirrors at normal incidence, in [0, 1]: one number, or a colour.
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        color,
        specular=specular,
        shininess=shininess,
        reflectivity=reflectivity,
        fresnel=True,
        name=name,
        properties=properties,
    )
    return record_maker(made, lacquer, {})


@with_call_hints
def mirror(
    reflectivity: Amount = 0.95, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """A mirror: all that it sends on comes along the mirrored ray.

    reflectivity: the share of light that it mirrors, in [0, 1]: one number, or a colour.
    name, properties: the user's own, as in `Material`.
    """
    black = (0.0, 0.0, 0.0)
    made = Material(black, ambient=0.0, diffuse=0.0, reflectivity=reflectivity, name=name, properties=properties)
    return record_maker(made, mirror, {})


@with_call_hints
def glass(
    refractive_index: Index = GLASS,
    absorption: Amount = 0.0,
    transparency: Amount = 1.0,
    specular: Amount = 0.6,
    *,
    roughness: float | Texture = 0.0,
    dispersion: float = 0.0,
    coating: Coating | None = None,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A clear dielectric with a sharp highlight; of index WATER it is water.

    refractive_index: of the inside against vacuum, > 0; or the name of a glass, a formula or a function, as in
        `Material`.
    absorption: per unit length inside, for each channel: light fades by exp(-absorption · length).
    transparency: the share of light that passes each wall unless mirrored, in [0, 1]: one number, or a colour.
    specular: how strong the highlights of lights are, in [0, 1]: one number, or a colour.
    roughness, dispersion, coating: of light transport and `co.optics.trace_paths`, as in `Material`.
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        (0.0, 0.0, 0.0),
        ambient=0.0,
        diffuse=0.0,
        specular=specular,
        shininess=1000.0,
        transparency=transparency,
        refractive_index=refractive_index,
        absorption=absorption,
        roughness=roughness,
        dispersion=dispersion,
        coating=coating,
        name=name,
        properties=properties,
    )
    return record_maker(made, glass, {})


@with_call_hints
def metal(
    color: Color = (0.9, 0.6, 0.3),
    shininess: float = 200.0,
    reflectivity: float = 1.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A polished metal: highlight and reflections (times `reflectivity`) in its own tint, whiter towards the rim.

    color: the tint, linear rgb or a text in sRGB.
    shininess: > 0; the greater, the smaller the highlight.
    reflectivity: the share of light that it mirrors, in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    share = check_number("metal", "reflectivity", reflectivity)
    r, g, b = linear_rgb(color, "metal", "color")
    tint = (share * r, share * g, share * b)
    made = Material(
        color,
        0.4,
        0.4,
        specular=color,
        shininess=shininess,
        reflectivity=tint,
        fresnel=True,
        name=name,
        properties=properties,
    )
    return record_maker(made, metal, {"reflectivity": share})


@with_call_hints
def glow(
    emission: Amount = 1.0,
    color: Color | Pattern = (0.0, 0.0, 0.0),
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A surface that gives light, in light transport: a lamp.

    emission: its radiance, >= 0: one number, or a colour; a colour brighter than white is three numbers.
    color: its diffuse reflectance besides.
    name, properties: the user's own, as in `Material`.
    """
    return record_maker(Material(color, emission=emission, name=name, properties=properties), glow, {})


@with_call_hints
def plastic(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    refractive_index: float = 1.5,
    roughness: float | Texture = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A colour under a clear coat, by Fresnel's formulas: paint, varnish, porcelain.

    color: the reflectance under the coat, linear rgb, a text in sRGB or a Checker.
    refractive_index: of the coat, >= 1.
    roughness: of the coat, the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    index = check_number("plastic", "refractive_index", refractive_index)
    if not index >= 1:
        raise ValueError(f"plastic: refractive_index must be >= 1, got {index}")
    at_normal = ((index - 1) / (index + 1)) ** 2
    made = Material(
        color,
        specular=0.5,
        shininess=shininess_of(typical_roughness("plastic", roughness)),
        reflectivity=at_normal,
        fresnel=True,
        coat=index,
        roughness=roughness,
        name=name,
        properties=properties,
    )
    return record_maker(made, plastic, {"refractive_index": index})


@with_call_hints
def fog(
    scattering: Amount = 1.0,
    absorption: Amount = 0.0,
    anisotropy: float = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A homogeneous medium without a surface, which scatters light in light transport: fog, smoke, milk in water.

    scattering, absorption: per unit length, for each channel.
    anisotropy: the mean cosine of a turn, in ]-1, 1[ (Henyey and Greenstein).
    name, properties: the user's own, as in `Material`.
    """
    made = Material(
        (0.0, 0.0, 0.0),
        0.0,
        0.0,
        transparency=1.0,
        absorption=absorption,
        scattering=scattering,
        anisotropy=anisotropy,
        name=name,
        properties=properties,
    )
    return record_maker(made, fog, {})


def shininess_of(roughness: float) -> float:
    """The exponent of a half-vector highlight about as wide: 2 / α² - 2 (Walter and others 2007)."""
    return min(1000.0, max(1.0, 2 / max(roughness, 1e-3) ** 2 - 2))


# Metals by their complex refractive index, and some by name.


@with_call_hints
def conductor(
    index: VectorLike = (0.3, 1.02, 1.15),
    extinction: VectorLike = (3.205, 2.577, 2.5),
    roughness: float | Texture = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A metal by its complex refractive index n + ik.

    index, extinction: n > 0 and k >= 0 for red, green and blue; left out, those of copper.
    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(conductor, index, extinction, roughness, name, properties)


def _conductor(
    maker: MaterialMaker, index: Any, extinction: Any, roughness: Any, name: str | None, properties: Mapping[str, Any]
) -> Material:
    """A metal; Whitted's pictures show its reflectance at normal incidence, ((n - 1)² + k²) / ((n + 1)² + k²)."""
    owner = maker.__name__
    n, k = check_numbers(owner, "index", index, 3), check_numbers(owner, "extinction", extinction, 3)
    share = [((a - 1) ** 2 + b * b) / max((a + 1) ** 2 + b * b, 1e-300) for a, b in zip(n, k, strict=True)]
    tint = (min(1.0, share[0]), min(1.0, share[1]), min(1.0, share[2]))
    rough = typical_roughness(owner, roughness)
    made = Material(
        tint,
        0.4,
        0.4,
        specular=tint,
        shininess=shininess_of(rough),
        reflectivity=tint,
        fresnel=True,
        roughness=roughness,
        metal_index=(n[0], n[1], n[2]),
        metal_extinction=(k[0], k[1], k[2]),
        name=name,
        properties=properties,
    )
    own = {"index": made.metal_index, "extinction": made.metal_extinction} if maker is conductor else {}
    return record_maker(made, maker, own)


@with_call_hints
def gold(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Gold, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(gold, (0.21, 0.43, 1.31), (3.272, 2.455, 1.849), roughness, name, properties)


@with_call_hints
def silver(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Silver, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(silver, (0.06, 0.06, 0.05), (4.152, 3.586, 2.869), roughness, name, properties)


@with_call_hints
def copper(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Copper, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(copper, (0.3, 1.02, 1.15), (3.205, 2.577, 2.5), roughness, name, properties)


@with_call_hints
def aluminium(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Aluminium, by its complex refractive index at 650, 550 and 450 nm: Rakić, Applied Optics 34, 1995.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(aluminium, (1.3456, 0.96521, 0.61722), (7.4746, 6.3995, 5.3031), roughness, name, properties)


@with_call_hints
def iron(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Iron, by its complex refractive index at 650, 550 and 450 nm: Johnson and Christy, Phys. Rev. B 9, 1974.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor(iron, (2.9114, 2.9497, 2.5845), (3.0893, 2.9318, 2.767), roughness, name, properties)


# What makes materials, by name, and what is taken for a material.

_PRESETS = (
    matte,
    phong,
    blinn_phong,
    lacquer,
    mirror,
    glass,
    metal,
    glow,
    plastic,
    conductor,
    gold,
    silver,
    copper,
    aluminium,
    iron,
    fog,
)
"""The registry of presets: one line makes a function known to scene files, to `repr` and to hints."""
CONSTRUCTORS = {f.__name__: f for f in _PRESETS}
"""Name -> function, for scene files that name a look instead of listing the fields."""


def as_material(owner: str, value: Any, hint: str = "") -> Material:
    """`value` as a material: a Material, or the matte one of a colour, a Checker or a texture.

    hint: what else may have been meant by a text that is no colour.
    Raises TypeError for anything else, ValueError for what is no colour.
    """
    if isinstance(value, Material):
        return value
    if isinstance(value, PATTERNS):
        return matte(value)
    if isinstance(value, str):
        return _material_of_color(owner, value, hint)
    if isinstance(value, (tuple, list, np.ndarray)):
        return matte(check_color(owner, "material", value))
    raise TypeError(
        f"{owner}: material must be a Material such as matte('red'), or a colour, got {describe_non_material(value)}"
    )


@lru_cache(maxsize=256)
def _material_of_color(owner: str, color: str, hint: str) -> Material:
    """The matte material of a colour's text: also of "gold" and "silver", which are metals where they are called."""
    try:
        return matte(check_color(owner, "material", color))
    except ValueError as error:
        if color in CONSTRUCTORS:
            expected = f"materials are made by functions: co.{color}(...), without quotes"
            raise ValueError(f"{owner}: material must be a Material or a colour, got {color!r}; {expected}") from None
        raise ValueError(f"{error}{hint if not color.startswith('#') else ''}") from None


def describe_non_material(value: Any) -> str:
    """What stands in place of a material; of what makes one, how it is meant."""
    makes_materials = isinstance(value, type | FunctionType) and value in (Material, *_PRESETS)
    return describe_kind(value) + (f"; call it: {value.__name__}(...)" if makes_materials else "")
