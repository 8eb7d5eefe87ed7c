"""Named constructors of materials: matte, shining, clear, glowing. Metals by their complex index are in `metals`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .calls import explained
from .coating import Coating
from .color import Amount, Color, linear_rgb
from .dispersion import Index
from .material import GLASS, Material, made_by
from .properties import NO_PROPERTIES
from .relief import typical_roughness
from .texture import Pattern, Texture
from .validate import number


@explained
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
    return made_by(made, "matte", {})


@explained
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
    return made_by(made, "phong", {})


@explained
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
    return made_by(made, "blinn_phong", {})


@explained
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
        color, specular=specular, shininess=shininess, reflectivity=reflectivity, fresnel=True,
        name=name, properties=properties,
    )  # fmt: skip
    return made_by(made, "lacquer", {})


@explained
def mirror(
    reflectivity: Amount = 0.95, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """A mirror: all that it sends on comes along the mirrored ray.

    reflectivity: the share of light that it mirrors, in [0, 1]: one number, or a colour.
    name, properties: the user's own, as in `Material`.
    """
    black = (0.0, 0.0, 0.0)
    made = Material(black, ambient=0.0, diffuse=0.0, reflectivity=reflectivity, name=name, properties=properties)
    return made_by(made, "mirror", {})


@explained
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
    roughness, dispersion, coating: of light transport and `co.trace_paths`, as in `Material`.
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
    return made_by(made, "glass", {})


@explained
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
    share = number("metal", "reflectivity", reflectivity)
    r, g, b = linear_rgb(color, "metal", "color")
    tint = (share * r, share * g, share * b)
    made = Material(
        color, 0.4, 0.4, specular=color, shininess=shininess, reflectivity=tint, fresnel=True,
        name=name, properties=properties,
    )  # fmt: skip
    return made_by(made, "metal", {"reflectivity": share})


@explained
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
    return made_by(Material(color, emission=emission, name=name, properties=properties), "glow", {})


@explained
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
    index = number("plastic", "refractive_index", refractive_index)
    if not index >= 1:
        raise ValueError(f"plastic: refractive_index must be >= 1, got {index}")
    at_normal = ((index - 1) / (index + 1)) ** 2
    made = Material(
        color, specular=0.5, shininess=shininess_of(typical_roughness("plastic", roughness)), reflectivity=at_normal,
        fresnel=True, coat=index, roughness=roughness, name=name, properties=properties,
    )  # fmt: skip
    return made_by(made, "plastic", {"refractive_index": index})


@explained
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
        (0.0, 0.0, 0.0), 0.0, 0.0, transparency=1.0, absorption=absorption, scattering=scattering,
        anisotropy=anisotropy, name=name, properties=properties,
    )  # fmt: skip
    return made_by(made, "fog", {})


def shininess_of(roughness: float) -> float:
    """The exponent of a half-vector highlight about as wide: 2 / α² - 2 (Walter and others 2007)."""
    return min(1000.0, max(1.0, 2 / max(roughness, 1e-3) ** 2 - 2))
