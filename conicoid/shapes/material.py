"""Materials: one record for every look, and named constructors for the usual ones."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import FunctionType
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from .calls import explained
from .color import Amount, Color, checked_amount, checked_color, linear_rgb
from .fixed import fixed
from .other_names import hinted
from .properties import NO_PROPERTIES, Properties
from .texture import PATTERNS, Pattern
from .validate import nonnegative, number, numbers, positive, shown, what
from .vector import Vector, VectorLike

Highlight: TypeAlias = Literal["phong", "blinn_phong"]

VACUUM = 1.0
AIR = 1.0003
WATER = 1.33
GLASS = 1.52
"""Refractive indices: speed of light in vacuum over speed in the medium (the ray tracing notes)."""


@hinted
@fixed
@dataclass(frozen=True)
class Material:
    """What happens to light at a body, in linear rgb. An amount is one number or a colour.

    With L to the light, E to the eye, N the normal on the eye's side, R = 2 (N·L) N - L and
    H = (L + E) / |L + E|, a surface sends to the eye

        color (ambient · A + diffuse · Σ I N·L) (1 - F) (1 - transparency)
        + specular Σ I h + F · (what comes along the mirrored ray) + (1 - F) transparency · (what comes through)

    summed over lights of intensity I that are not hidden, A being the ambient light and
    h = (R·E)^shininess ("phong") or (H·N)^shininess ("blinn_phong").

    color: diffuse reflectance, or a Checker or texture.
    highlight: "phong" or "blinn_phong", the formula of h.
    reflectivity: F of an opaque surface; with `fresnel` it is the value at normal incidence, and
        F = reflectivity + (1 - reflectivity) (1 - cos θ)⁵ (Schlick 1994).
    transparency: over 0 a solid is a dielectric: F is Fresnel's for unpolarised light, the ray is
        refracted by Snell's law, and total reflection has F = 1. A transparent sheet is a pane too
        thin to bend rays. `transparency` as a colour tints at each wall.
    refractive_index: of the inside, against `VACUUM` = 1 outside of all bodies.
    absorption: per unit length inside, for each channel: light fades by exp(-absorption · length) (Beer).

    What follows is for light transport ("path", "direct"); what it means there of the fields above says docs/light.md.

    emission: radiance that the surface sends to all sides by itself, from both of its sides.
    roughness: 0 is smooth. Of what mirrors or refracts the α of Trowbridge and Reitz's distribution (GGX), of matte
        surfaces the σ of Oren and Nayar's law; in [0, 1].
    coat: the refractive index of a clear coat over the colour; 1 is none.
    metal_index, metal_extinction: the complex refractive index n + ik of a metal for red, green and blue.
    scattering: per unit length inside, for each channel: how often light is scattered there (fog, milk).
    anisotropy: the mean cosine of such a turn, in ]-1, 1[: 0 to all sides alike, over 0 rather forward.
    dispersion: by how much the refractive index grows towards blue: Cauchy's B in μm² of
        n(λ) = refractive_index + B (1/λ² - 1/λ_d²), λ_d = 0.5876 μm.

    What follows changes no picture. It is kept in scene files and pickles, `hits.material` gives it back, and path
    lengths, line integrals and volumes go by it:

    name: what the material is called.
    properties: the user's own values by name (a density, attenuation by energy, a number in another program): numbers,
        texts, arrays of them, and mappings from names to numbers or texts; kept as a mapping that cannot be changed.
    """

    color: Color | Pattern = (0.8, 0.8, 0.8)
    ambient: float = 1.0
    diffuse: float = 1.0
    specular: Amount = 0.0
    shininess: float = 50.0
    highlight: Highlight = "blinn_phong"
    reflectivity: Amount = 0.0
    fresnel: bool = False
    transparency: Amount = 0.0
    refractive_index: float = 1.0
    absorption: Amount = 0.0
    name: str | None = None
    properties: Mapping[str, Any] = NO_PROPERTIES
    emission: Amount = dataclasses.field(default=0.0, kw_only=True)
    roughness: float = dataclasses.field(default=0.0, kw_only=True)
    coat: float = dataclasses.field(default=1.0, kw_only=True)
    metal_index: Vector | None = dataclasses.field(default=None, kw_only=True)
    metal_extinction: Vector | None = dataclasses.field(default=None, kw_only=True)
    scattering: Amount = dataclasses.field(default=0.0, kw_only=True)
    anisotropy: float = dataclasses.field(default=0.0, kw_only=True)
    dispersion: float = dataclasses.field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        name, infinity = "Material", float("inf")
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise ValueError(f"{name}: name must be a non-empty text or None, got {shown(self.name)}")
        if not isinstance(self.properties, Properties):
            object.__setattr__(self, "properties", Properties(self.properties, owner=name))
        color = self.color if isinstance(self.color, PATTERNS) else checked_color(name, "color", self.color)
        object.__setattr__(self, "color", color)
        for field in ("specular", "reflectivity", "transparency"):
            object.__setattr__(self, field, _amount(self, field, 1.0))
        for field in ("absorption", "emission", "scattering"):
            object.__setattr__(self, field, _amount(self, field, infinity))
        for field, value in _checked_transport(self).items():
            object.__setattr__(self, field, value)
        for field in ("ambient", "diffuse"):
            value = number(name, field, getattr(self, field))
            if value < 0:
                raise ValueError(f"{name}: {field} must be >= 0, got {value}")
            object.__setattr__(self, field, value)
        object.__setattr__(self, "shininess", positive(name, "shininess", self.shininess))
        object.__setattr__(self, "refractive_index", _index(self))
        if not isinstance(self.highlight, str) or self.highlight not in get_args(Highlight):
            raise ValueError(f"{name}: highlight must be 'phong' or 'blinn_phong', got {shown(self.highlight)}")
        if not isinstance(self.fresnel, bool):
            raise ValueError(f"{name}: fresnel must be true or false, got {shown(self.fresnel)}")

    def __repr__(self) -> str:
        """The call that makes it, without what it leaves out."""
        maker, given = spelled(self)
        shown_fields = ", ".join(f"{name}={value!r}" for name, value in given.items())
        return f"{maker}({shown_fields})"

    @property
    def exactly(self) -> str:
        """All that it says, to the bit: in equal words where it is the same, however it was made."""
        fields = [getattr(self, field.name) for field in dataclasses.fields(self) if field.name != "properties"]
        assert isinstance(self.properties, Properties)
        return f"{fields!r} {self.properties.written}"


def _checked_transport(material: Material) -> dict[str, Any]:
    """The fields of light transport that are no amounts."""
    name = "Material"
    roughness = number(name, "roughness", material.roughness)
    if not 0 <= roughness <= 1:
        raise ValueError(f"{name}: roughness must be in [0, 1], got {roughness}")
    coat = number(name, "coat", material.coat)
    if not coat >= 1:
        raise ValueError(f"{name}: coat must be an index of refraction >= 1, got {coat}")
    anisotropy = number(name, "anisotropy", material.anisotropy)
    if not -1 < anisotropy < 1:
        raise ValueError(f"{name}: anisotropy must be in ]-1, 1[, got {anisotropy}")
    found = dict(roughness=roughness, coat=coat, anisotropy=anisotropy)
    found["dispersion"] = nonnegative(name, "dispersion", material.dispersion)
    return found | _metal(material)


def _metal(material: Material) -> dict[str, Any]:
    """The complex index of a metal, both parts or none."""
    parts = dict(metal_index=material.metal_index, metal_extinction=material.metal_extinction)
    if all(part is None for part in parts.values()):
        return parts
    found: dict[str, Any] = {}
    for field, part in parts.items():
        if part is None:
            raise ValueError(f"Material: metal_index and metal_extinction go together, got no {field}")
        rgb = numbers("Material", field, part, 3)
        for i, value in enumerate(rgb):
            if not (value > 0 if field == "metal_index" else value >= 0):
                least = "> 0" if field == "metal_index" else ">= 0"
                raise ValueError(f"Material: {field}[{i}] must be {least}, got {value}")
        found[field] = (rgb[0], rgb[1], rgb[2])
    return found


def _amount(material: Material, field: str, most: float) -> Amount:
    value = getattr(material, field)
    try:
        return checked_amount("Material", field, value, most=most)
    except ValueError as error:
        raise ValueError(f"{error}{_meant_as_name(material, value)}") from None


def _index(material: Material) -> float:
    """The refractive index, one number."""
    value = material.refractive_index
    try:
        return positive("Material", "refractive_index", value)
    except ValueError as error:
        several = isinstance(value, list | tuple | dict) or bool(getattr(value, "ndim", 0))
        hint = "; a scene is of one wavelength: make one for each, scene.replace(name, material=co.glass(index))"
        raise ValueError(f"{error}{hint if several else _meant_as_name(material, value)}") from None


def _meant_as_name(material: Material, value: Any) -> str:
    """What to tell of a text that is no colour and no number."""
    if not isinstance(value, str) or value.startswith("#") or material.name is not None:
        return ""
    return f"; a name is given by its argument, name={shown(value)}"


def spelled(material: Material) -> tuple[str, dict[str, Any]]:
    """The name of the function, or of the class, that made a material, and the arguments that were not its defaults."""
    maker, own = vars(material).get("_made", ("Material", {}))
    given = {}
    for name, default in _defaults(maker).items():
        value = own[name] if name in own else getattr(material, name)
        if repr(value) != default:
            given[name] = value
    return maker, given


@functools.cache
def _defaults(maker: str) -> dict[str, str]:
    """The arguments of what makes materials, and the reprs of their defaults."""
    return {name: repr(one.default) for name, one in inspect.signature(MAKERS[maker]).parameters.items()}


def renamed(material: Material, name: str) -> Material:
    """The same under another name, made by the same function."""
    return _made_by(dataclasses.replace(material, name=name), *vars(material).get("_made", ("Material", {})))


def _made_by(material: Material, maker: str, own: Mapping[str, Any]) -> Material:
    """A material that knows which function made it, and `own`, those of its arguments that are no fields.

    It is said again by its repr and in scene files; equality does not ask for it.
    """
    object.__setattr__(material, "_made", (maker, dict(own)))
    return material


DEFAULT = Material()
"""The material of bodies that are given none: matte light grey."""


@explained
def matte(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    ambient: float = 1.0,
    diffuse: float = 1.0,
    *,
    roughness: float = 0.0,
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
    return _made_by(made, "matte", {})


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
    return _made_by(made, "phong", {})


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
    return _made_by(made, "blinn_phong", {})


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
    return _made_by(made, "lacquer", {})


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
    return _made_by(made, "mirror", {})


@explained
def glass(
    refractive_index: float = GLASS,
    absorption: Amount = 0.0,
    transparency: Amount = 1.0,
    specular: Amount = 0.6,
    *,
    roughness: float = 0.0,
    dispersion: float = 0.0,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A clear dielectric with a sharp highlight; of index WATER it is water.

    refractive_index: of the inside against vacuum, > 0.
    absorption: per unit length inside, for each channel: light fades by exp(-absorption · length).
    transparency: the share of light that passes each wall unless mirrored, in [0, 1]: one number, or a colour.
    specular: how strong the highlights of lights are, in [0, 1]: one number, or a colour.
    roughness, dispersion: of light transport, as in `Material`.
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
        name=name,
        properties=properties,
    )
    return _made_by(made, "glass", {})


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
    return _made_by(made, "metal", {"reflectivity": share})


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
    return _made_by(Material(color, emission=emission, name=name, properties=properties), "glow", {})


@explained
def plastic(
    color: Color | Pattern = (0.8, 0.8, 0.8),
    refractive_index: float = 1.5,
    roughness: float = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A colour under a clear coat, by Fresnel's formulas: paint, varnish, porcelain.

    color: the reflectance under the coat, linear rgb, a text in sRGB or a Checker.
    refractive_index: of the coat, >= 1.
    roughness: of the coat, the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    index = number("plastic", "refractive_index", refractive_index)
    if not index >= 1:
        raise ValueError(f"plastic: refractive_index must be >= 1, got {index}")
    at_normal = ((index - 1) / (index + 1)) ** 2
    rough = number("plastic", "roughness", roughness)
    made = Material(
        color, specular=0.5, shininess=_shininess(rough), reflectivity=at_normal, fresnel=True, coat=index,
        roughness=rough, name=name, properties=properties,
    )  # fmt: skip
    return _made_by(made, "plastic", {"refractive_index": index})


@explained
def conductor(
    index: VectorLike = (0.3, 1.02, 1.15),
    extinction: VectorLike = (3.205, 2.577, 2.5),
    roughness: float = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A metal by its complex refractive index n + ik.

    index, extinction: n > 0 and k >= 0 for red, green and blue; left out, those of copper.
    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("conductor", index, extinction, roughness, name, properties)


def _conductor(
    maker: str, index: Any, extinction: Any, roughness: Any, name: str | None, properties: Mapping[str, Any]
) -> Material:
    """A metal; Whitted's pictures show its reflectance at normal incidence, ((n - 1)² + k²) / ((n + 1)² + k²)."""
    n, k = numbers(maker, "index", index, 3), numbers(maker, "extinction", extinction, 3)
    share = [((a - 1) ** 2 + b * b) / max((a + 1) ** 2 + b * b, 1e-300) for a, b in zip(n, k, strict=True)]
    tint = (min(1.0, share[0]), min(1.0, share[1]), min(1.0, share[2]))
    rough = number(maker, "roughness", roughness)
    made = Material(
        tint, 0.4, 0.4, specular=tint, shininess=_shininess(rough), reflectivity=tint, fresnel=True, roughness=rough,
        metal_index=(n[0], n[1], n[2]), metal_extinction=(k[0], k[1], k[2]), name=name, properties=properties,
    )  # fmt: skip
    own = {"index": made.metal_index, "extinction": made.metal_extinction} if maker == "conductor" else {}
    return _made_by(made, maker, own)


def _shininess(roughness: float) -> float:
    """The exponent of a half-vector highlight about as wide: 2 / α² - 2 (Walter and others 2007)."""
    return min(1000.0, max(1.0, 2 / max(roughness, 1e-3) ** 2 - 2))


@explained
def gold(roughness: float = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES) -> Material:
    """Gold, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("gold", (0.21, 0.43, 1.31), (3.272, 2.455, 1.849), roughness, name, properties)


@explained
def silver(
    roughness: float = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Silver, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("silver", (0.06, 0.06, 0.05), (4.152, 3.586, 2.869), roughness, name, properties)


@explained
def copper(
    roughness: float = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Copper, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("copper", (0.3, 1.02, 1.15), (3.205, 2.577, 2.5), roughness, name, properties)


@explained
def aluminium(
    roughness: float = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Aluminium, by its complex refractive index at 650, 550 and 450 nm: Rakić, Applied Optics 34, 1995.

    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("aluminium", (1.3456, 0.96521, 0.61722), (7.4746, 6.3995, 5.3031), roughness, name, properties)


@explained
def iron(roughness: float = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES) -> Material:
    """Iron, by its complex refractive index at 650, 550 and 450 nm: Johnson and Christy, Phys. Rev. B 9, 1974.

    roughness: the α of GGX in [0, 1].
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("iron", (2.9114, 2.9497, 2.5845), (3.0893, 2.9318, 2.767), roughness, name, properties)


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
    return _made_by(made, "fog", {})


_ALL = (
    matte, phong, blinn_phong, lacquer, mirror, glass, metal, glow, plastic, conductor, gold, silver, copper, aluminium,
    iron, fog,
)  # fmt: skip
CONSTRUCTORS = {f.__name__: f for f in _ALL}
"""Name -> function, for scene files that name a look instead of listing the fields."""
MAKERS: dict[str, Callable[..., Material]] = {"Material": Material, **CONSTRUCTORS}
_FUNCTIONS = tuple(MAKERS.values())


def as_material(owner: str, value: Any, hint: str = "") -> Material:
    """`value` as a material: a Material, or the matte one of a colour, a Checker or a texture.

    hint: what else may have been meant by a text that is no colour.
    Raises TypeError for anything else, ValueError for what is no colour.
    """
    if isinstance(value, Material):
        return value
    if isinstance(value, PATTERNS):
        return matte(value)
    if isinstance(value, str) and value in CONSTRUCTORS:
        expected = f"materials are made by functions: co.{value}(...), without quotes"
        raise ValueError(f"{owner}: material must be a Material or a colour, got {value!r}; {expected}")
    if isinstance(value, str):
        return _of_color(owner, value, hint)
    if isinstance(value, (tuple, list, np.ndarray)):
        return matte(checked_color(owner, "material", value))
    raise TypeError(f"{owner}: material must be a Material such as matte('red'), or a colour, got {no_material(value)}")


@lru_cache(maxsize=256)
def _of_color(owner: str, color: str, hint: str) -> Material:
    """The matte material of a colour's text."""
    try:
        return matte(checked_color(owner, "material", color))
    except ValueError as error:
        raise ValueError(f"{error}{hint if not color.startswith('#') else ''}") from None


def no_material(value: Any) -> str:
    """What stands in place of a material; of what makes one, how it is meant."""
    hint = f"; call it: {value.__name__}(...)" if isinstance(value, type | FunctionType) and value in _FUNCTIONS else ""
    return what(value) + hint
