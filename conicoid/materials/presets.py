"""Presets: named constructors of materials, metals by complex index, and the conversion of values to materials."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from .._util.arrays import VectorLike
from .._util.validation import check_number, check_numbers, describe_kind
from .coating import Coating
from .color import Amount, Color, check_color, linear_rgb
from .dispersion import Index
from .material import GLASS, NO_PROPERTIES, Material, MaterialMaker, record_maker, typical_roughness
from .texture import PATTERNS, Pattern, Texture

# Surfaces for all pictures.


def matte(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    ambient: float = 1.0,
    diffuse: float = 1.0,
    *,
    roughness: float | Texture = 0.0,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a material with Lambert's law alone.

    Parameters
    ----------
    color : Color or pattern
        Diffuse reflectance: linear rgb, a text in sRGB, or a Checker or texture.
    ambient, diffuse : float
        Factors of the ambient light, and of the light of other lights.
    roughness : float or Texture
        Over 0, light transport uses Oren and Nayar's law of this σ instead.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
        color=color, ambient=ambient, diffuse=diffuse, roughness=roughness, name=name, properties=properties
    )
    return record_maker(material, matte, {})


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
    """Make a plastic with Phong's highlight (R·E)^shininess.

    Parameters
    ----------
    color : Color or pattern
        Diffuse reflectance: linear rgb, a text in sRGB, or a Checker or texture.
    specular : Amount
        Strength of highlights, in [0, 1]: one number, or a colour.
    shininess : float
        > 0; the greater, the smaller the highlight.
    ambient, diffuse : float
        Factors of the ambient light, and of the light of other lights.
    reflectivity : Amount
        Mirrored share of light, in [0, 1]: one number, or a colour.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
        color, ambient, diffuse, specular, shininess, "phong", reflectivity, name=name, properties=properties
    )
    return record_maker(material, phong, {})


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
    """Make a plastic with the half-vector highlight (H·N)^shininess.

    Parameters
    ----------
    color : Color or pattern
        Diffuse reflectance: linear rgb, a text in sRGB, or a Checker or texture.
    specular : Amount
        Strength of highlights, in [0, 1]: one number, or a colour.
    shininess : float
        > 0; the greater, the smaller the highlight.
    ambient, diffuse : float
        Factors of the ambient light, and of the light of other lights.
    reflectivity : Amount
        Mirrored share of light, in [0, 1]: one number, or a colour.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
        color, ambient, diffuse, specular, shininess, "blinn_phong", reflectivity, name=name, properties=properties
    )
    return record_maker(material, blinn_phong, {})


def lacquer(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    specular: Amount = 0.8,
    shininess: float = 300.0,
    reflectivity: Amount = 0.04,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a colour under clear lacquer: a sharp highlight, and reflections that grow towards the rim.

    Parameters
    ----------
    color : Color or pattern
        Diffuse reflectance: linear rgb, a text in sRGB, or a Checker or texture.
    specular : Amount
        Strength of highlights, in [0, 1]: one number, or a colour.
    shininess : float
        > 0; the greater, the smaller the highlight.
    reflectivity : Amount
        Mirrored share of light at normal incidence, in [0, 1]: one number, or a colour.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
        color,
        specular=specular,
        shininess=shininess,
        reflectivity=reflectivity,
        fresnel=True,
        name=name,
        properties=properties,
    )
    return record_maker(material, lacquer, {})


# Mirrors, glass and metals.


def mirror(
    reflectivity: Amount = 0.95, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make a mirror: all its light comes along the mirrored ray.

    Parameters
    ----------
    reflectivity : Amount
        Mirrored share of light, in [0, 1]: one number, or a colour.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    black = (0.0, 0.0, 0.0)
    # Black without ambient and diffuse light: the mirrored ray is the only source.
    material = Material(black, ambient=0.0, diffuse=0.0, reflectivity=reflectivity, name=name, properties=properties)
    return record_maker(material, mirror, {})


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
    """Make a clear dielectric with a sharp highlight; with the index WATER it is water.

    Parameters
    ----------
    refractive_index : Index
        Of the inside against vacuum, > 0; or the name of a glass, a formula or a function, as in `Material`.
    absorption : Amount
        Per unit length inside, for each channel: light fades by exp(-absorption · length).
    transparency : Amount
        Share of the light that is not mirrored and passes each wall, in [0, 1]: one number, or a colour.
    specular : Amount
        Strength of the highlights of lights, in [0, 1]: one number, or a colour.
    roughness, dispersion, coating
        For light transport and `co.optics.trace_paths`, as in `Material`.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
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
    return record_maker(material, glass, {})


def metal(
    color: Color = (0.9, 0.6, 0.3),
    shininess: float = 200.0,
    reflectivity: float = 1.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a polished metal: highlight and reflections (times `reflectivity`) in its own tint, whiter towards the rim.

    Parameters
    ----------
    color : Color
        The tint: linear rgb or a text in sRGB.
    shininess : float
        > 0; the greater, the smaller the highlight.
    reflectivity : float
        Mirrored share of light, in [0, 1].
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    # Highlights keep the tint; `reflectivity` scales the reflections alone.
    share = check_number("metal", "reflectivity", reflectivity)
    r, g, b = linear_rgb(color, "metal", "color")
    tint = (share * r, share * g, share * b)
    material = Material(
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
    return record_maker(material, metal, {"reflectivity": share})


# Materials for light transport; Whitted's pictures approximate them.


def glow(
    emission: Amount = 1.0,
    color: Color | Pattern = (0.0, 0.0, 0.0),
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a surface that emits light in light transport: a lamp.

    Parameters
    ----------
    emission : Amount
        Radiance, >= 0: one number, or a colour. A colour brighter than white is three numbers.
    color : Color or pattern
        Diffuse reflectance besides.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return record_maker(Material(color, emission=emission, name=name, properties=properties), glow, {})


def plastic(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    refractive_index: float = 1.5,
    roughness: float | Texture = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a colour under a clear coat, by Fresnel's formulas: paint, varnish, porcelain.

    Parameters
    ----------
    color : Color or pattern
        Reflectance under the coat: linear rgb, a text in sRGB, or a Checker or texture.
    refractive_index : float
        Of the coat, >= 1.
    roughness : float or Texture
        Of the coat: the α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    index = check_number("plastic", "refractive_index", refractive_index)
    if not index >= 1:
        raise ValueError(f"plastic: refractive_index must be >= 1, got {index}")
    # Fresnel's reflectance at normal incidence, for Whitted's pictures.
    at_normal = ((index - 1) / (index + 1)) ** 2
    material = Material(
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
    return record_maker(material, plastic, {"refractive_index": index})


def fog(
    scattering: Amount = 1.0,
    absorption: Amount = 0.0,
    anisotropy: float = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a homogeneous medium without a surface that scatters light in light transport: fog, smoke, milk in water.

    Parameters
    ----------
    scattering, absorption : Amount
        Per unit length, for each channel.
    anisotropy : float
        Mean cosine of the scattering angle, in ]-1, 1[ (Henyey and Greenstein).
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    material = Material(
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
    return record_maker(material, fog, {})


def shininess_of(roughness: float) -> float:
    """Return the exponent of a half-vector highlight as wide: 2 / α² - 2 (Walter and others 2007), cut to [1, 1000]."""
    return min(1000.0, max(1.0, 2 / max(roughness, 1e-3) ** 2 - 2))


# Metals by their complex refractive index, and some by name.


def conductor(
    index: VectorLike = (0.3, 1.02, 1.15),
    extinction: VectorLike = (3.205, 2.577, 2.5),
    roughness: float | Texture = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """Make a metal by its complex refractive index n + ik.

    Parameters
    ----------
    index, extinction : VectorLike
        n > 0 and k >= 0 for red, green and blue; the defaults are those of copper.
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(conductor, index, extinction, roughness, name, properties)


def _conductor(
    maker: MaterialMaker, index: Any, extinction: Any, roughness: Any, name: str | None, properties: Mapping[str, Any]
) -> Material:
    """Make a metal; Whitted's pictures show its reflectance at normal incidence, ((n - 1)² + k²) / ((n + 1)² + k²)."""
    owner = maker.__name__
    n, k = check_numbers(owner, "index", index, 3), check_numbers(owner, "extinction", extinction, 3)
    share = [((a - 1) ** 2 + b * b) / max((a + 1) ** 2 + b * b, 1e-300) for a, b in zip(n, k, strict=True)]
    tint = (min(1.0, share[0]), min(1.0, share[1]), min(1.0, share[2]))
    rough = typical_roughness(owner, roughness)
    material = Material(
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
    # Named metals need no arguments: their constructor implies the index.
    own = {"index": material.metal_index, "extinction": material.metal_extinction} if maker is conductor else {}
    return record_maker(material, maker, own)


def gold(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make gold, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    Parameters
    ----------
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(gold, (0.21, 0.43, 1.31), (3.272, 2.455, 1.849), roughness, name, properties)


def silver(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make silver, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    Parameters
    ----------
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(silver, (0.06, 0.06, 0.05), (4.152, 3.586, 2.869), roughness, name, properties)


def copper(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make copper, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    Parameters
    ----------
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(copper, (0.3, 1.02, 1.15), (3.205, 2.577, 2.5), roughness, name, properties)


def aluminium(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make aluminium, by its complex refractive index at 650, 550 and 450 nm: Rakić, Applied Optics 34, 1995.

    Parameters
    ----------
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(aluminium, (1.3456, 0.96521, 0.61722), (7.4746, 6.3995, 5.3031), roughness, name, properties)


def iron(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Make iron, by its complex refractive index at 650, 550 and 450 nm: Johnson and Christy, Phys. Rev. B 9, 1974.

    Parameters
    ----------
    roughness : float or Texture
        The α of GGX in [0, 1], or a texture of it.
    name, properties
        The user's own, as in `Material`.

    Returns
    -------
    Material
    """
    return _conductor(iron, (2.9114, 2.9497, 2.5845), (3.0893, 2.9318, 2.767), roughness, name, properties)


# The registry of constructors, and the conversion of values to materials.

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
"""The registry of presets: one line adds a constructor to scene files, to `repr` and to hints."""
CONSTRUCTORS = {f.__name__: f for f in _PRESETS}
"""Name -> constructor, for scene files that name a look instead of a list of fields."""


def as_material(owner: str, value: Any) -> Material:
    """Return `value` as a material: a Material, or the matte one of a colour, a Checker or a texture.

    Parameters
    ----------
    owner : str
        Name of the object, for messages.
    value
        The value of the user.

    Raises
    ------
    TypeError
        If the value is of another kind.
    ValueError
        If a text or numbers are no colour.
    """
    if isinstance(value, Material):
        return value
    if isinstance(value, PATTERNS):
        return matte(value)
    if isinstance(value, str):
        return _material_of_color(owner, value)
    if isinstance(value, (tuple, list, np.ndarray)):
        return matte(check_color(owner, "material", value))
    raise TypeError(
        f"{owner}: material must be a Material such as matte('red'), or a colour, got {describe_kind(value)}"
    )


@lru_cache(maxsize=256)
def _material_of_color(owner: str, color: str) -> Material:
    """Return the matte material of a colour's name.

    "gold" and "silver" are CSS colours: only a call makes the metals of these names.
    """
    return matte(check_color(owner, "material", color))
