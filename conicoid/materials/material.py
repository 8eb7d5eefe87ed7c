"""Material: the record of a look, the checks of its fields, and the constructor that a material remembers."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeAlias, get_args

from .._util.arrays import Vector
from .._util.dataclass import dataclass
from .._util.validation import (
    check_fields,
    check_nonnegative,
    check_number,
    check_numbers,
    check_positive,
    format_value,
    warn,
)
from .coating import Coating
from .color import Amount, Color, check_amount, check_color
from .dispersion import Index, check_index
from .properties import NO_PROPERTIES, Properties
from .texture import PATTERNS, TEXTURES, ImageTexture, Pattern, Texture, mean_grey

_TEXTURE_KINDS = "an ImageTexture, Gradient, Noise, Wood or Brick"


# Checks of fields that may be textures.


def check_roughness(owner: str, value: Any) -> Any:
    """Return a number in [0, 1], or a texture of such numbers."""
    if isinstance(value, TEXTURES):
        return value
    rough = check_number(owner, "roughness", value)
    if not 0 <= rough <= 1:
        raise ValueError(f"{owner}: roughness must be in [0, 1], got {rough}")
    return rough


def typical_roughness(owner: str, value: Any) -> float:
    """Return one number: the roughness itself, or the mean of a texture."""
    rough = check_roughness(owner, value)
    return rough if isinstance(rough, float) else mean_grey(rough)


def check_bump_and_normal(material: Any) -> dict[str, Any]:
    """Check the textures of bumps and normals. Return the fields to set."""
    bump, normal = material.bump, material.normal
    if bump is not None and not isinstance(bump, TEXTURES):
        raise TypeError(f"Material: bump must be a texture ({_TEXTURE_KINDS}) or None, got {format_value(bump)}")
    if normal is not None and not isinstance(normal, ImageTexture):
        raise TypeError(f"Material: normal must be an ImageTexture of normals or None, got {format_value(normal)}")
    if normal is not None and not normal.data:
        hint = "its numbers are no colours: ImageTexture(..., data=True)"
        raise ValueError(f"Material: normal must be a texture of plain data; {hint}")
    return dict(bump_height=check_number("Material", "bump_height", material.bump_height))


# The record. The named constructors for usual looks are in presets.py.

Highlight: TypeAlias = Literal["phong", "blinn_phong"]

VACUUM = 1.0
AIR = 1.0003
WATER = 1.33
GLASS = 1.52
"""Refractive indices: the speed of light in vacuum over the speed in the medium (the ray tracing notes)."""


@dataclass(frozen=True)
class Material:
    """The response of a body to light, in linear rgb. An amount is one number or a colour.

    With L to the light, E to the eye, N the normal on the eye's side, R = 2 (N·L) N - L and
    H = (L + E) / |L + E|, a surface sends to the eye

        color (ambient · A + diffuse · Σ I N·L) (1 - F) (1 - transparency)
        + specular Σ I h + F · (light along the mirrored ray) + (1 - F) transparency · (light along the refracted ray)

    summed over lights of intensity I that are not hidden. A is the ambient light, and
    h = (R·E)^shininess ("phong") or (H·N)^shininess ("blinn_phong").

    Light transport ("path", "direct") also uses the fields from `emission` to `dispersion`; docs/lighting.md explains
    the meaning of the other fields there. `name` and `properties` change no picture. Scene files and pickles keep
    them, `hits.material` returns them, and path lengths, line integrals and volumes use them.

    Parameters
    ----------
    color : Color or pattern
        Diffuse reflectance, or a Checker or texture.
    ambient, diffuse : float
        Factors of the ambient light, and of the light of other lights; >= 0.
    specular : Amount
        Strength of highlights, in [0, 1].
    shininess : float
        Exponent of h, > 0.
    highlight : {"phong", "blinn_phong"}
        Formula of h.
    reflectivity : Amount
        F of an opaque surface. With `fresnel` it is the value at normal incidence, and
        F = reflectivity + (1 - reflectivity) (1 - cos θ)⁵ (Schlick 1994).
    fresnel : bool
        Whether F depends on the angle of incidence θ.
    transparency : Amount
        Over 0 a solid is a dielectric: F is Fresnel's for unpolarised light, Snell's law refracts the ray, and total
        reflection has F = 1. A transparent sheet is a pane too thin to bend rays. As a colour it tints at each wall.
    refractive_index : Index
        Of the inside, against `VACUUM` = 1 outside of all bodies: a number, the name of a glass such as "N-BK7", a
        formula of `co.optics`, or a function of the wavelength in μm (docs/light-paths.md). Pictures take n_d.
    absorption : Amount
        Per unit length inside, for each channel: light fades by exp(-absorption · length) (Beer).
    name : str, optional
        Name of the material.
    properties : Mapping[str, Any]
        The user's own values by name (a density, attenuation by energy, a number in another program): numbers, texts,
        arrays of them, and mappings from names to numbers or texts. They become a mapping that cannot change.
    emission : Amount
        Radiance that the surface sends to all sides by itself, from both of its sides.
    roughness : float or Texture
        In [0, 1]; 0 is smooth. For surfaces that mirror or refract, the α of Trowbridge and Reitz's distribution
        (GGX); for matte surfaces, the σ of Oren and Nayar's law. The brightness of a texture is its value.
    coat : float
        Refractive index of a clear coat over the colour, >= 1; 1 is none.
    metal_index, metal_extinction : Vector, optional
        Complex refractive index n + ik of a metal for red, green and blue; both or none.
    scattering : Amount
        Per unit length inside, for each channel: the rate of scattering (fog, milk).
    anisotropy : float
        Mean cosine of the scattering angle, in ]-1, 1[: 0 is isotropic, over 0 is forward.
    dispersion : float
        Cauchy's B in μm² of n(λ) = refractive_index + B (1/λ² - 1/λ_d²), λ_d = 0.5876 μm: the growth of the index
        towards blue. Without it, a refractive index that depends on the wavelength has the B through n_F and n_C.
    bump : Texture, optional
        A texture whose brightness times `bump_height` is a height over the surface. It bends the normal, in all
        pictures.
    bump_height : float
        Factor of `bump`.
    normal : ImageTexture, optional
        Normals, with `data=True`: 2 c - 1 along growing u, growing v and the surface's normal. All pictures use it.
    coating : Coating, optional
        Thin films on the walls, a `co.optics.Coating`. `co.optics.trace_paths` uses it, pictures do not.

    Raises
    ------
    ValueError, TypeError
        If a field is out of range or of another kind; the message names it.
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
    refractive_index: Index = 1.0
    absorption: Amount = 0.0
    name: str | None = None
    properties: Mapping[str, Any] = NO_PROPERTIES
    emission: Amount = dataclasses.field(default=0.0, kw_only=True)
    roughness: float | Texture = dataclasses.field(default=0.0, kw_only=True)
    coat: float = dataclasses.field(default=1.0, kw_only=True)
    metal_index: Vector | None = dataclasses.field(default=None, kw_only=True)
    metal_extinction: Vector | None = dataclasses.field(default=None, kw_only=True)
    scattering: Amount = dataclasses.field(default=0.0, kw_only=True)
    anisotropy: float = dataclasses.field(default=0.0, kw_only=True)
    dispersion: float = dataclasses.field(default=0.0, kw_only=True)
    bump: Texture | None = dataclasses.field(default=None, kw_only=True)
    bump_height: float = dataclasses.field(default=1.0, kw_only=True)
    normal: ImageTexture | None = dataclasses.field(default=None, kw_only=True)
    coating: Coating | None = dataclasses.field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        name, infinity = "Material", float("inf")
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise ValueError(f"{name}: name must be a non-empty text or None, got {format_value(self.name)}")
        if not isinstance(self.properties, Properties):
            object.__setattr__(self, "properties", Properties(self.properties, owner=name))
        color = self.color if isinstance(self.color, PATTERNS) else check_color(name, "color", self.color)
        object.__setattr__(self, "color", color)
        # Shares of light are at most 1.
        for field in ("specular", "reflectivity", "transparency"):
            object.__setattr__(self, field, _amount(self, field, 1.0))
        # Rates and radiances have no upper bound.
        for field in ("absorption", "emission", "scattering"):
            object.__setattr__(self, field, _amount(self, field, infinity))
        vars(self).update(_checked_transport(self))
        check_fields(self, ambient=check_nonnegative, diffuse=check_nonnegative, shininess=check_positive)
        object.__setattr__(self, "refractive_index", check_index("Material", self.refractive_index))
        if not isinstance(self.highlight, str) or self.highlight not in get_args(Highlight):
            raise ValueError(f"{name}: highlight must be 'phong' or 'blinn_phong', got {format_value(self.highlight)}")
        if self.coating is not None and not isinstance(self.coating, Coating):
            raise ValueError(f"{name}: coating must be a co.optics.Coating or None, got {format_value(self.coating)}")
        if not isinstance(self.fresnel, bool):
            raise ValueError(f"{name}: fresnel must be true or false, got {format_value(self.fresnel)}")

    def __repr__(self) -> str:
        """Return the call that makes the material, without arguments that have their defaults."""
        maker, given = constructor_call(self)
        shown_fields = ", ".join(f"{name}={value!r}" for name, value in given.items())
        return f"{maker}({shown_fields})"

    @property
    def exact_text(self) -> str:
        """Text of all fields, to the bit: equal for equal materials, whichever constructor made them."""
        fields = [getattr(self, field.name) for field in dataclasses.fields(self) if field.name != "properties"]
        assert isinstance(self.properties, Properties)
        return f"{fields!r} {self.properties.exact_text}"


def _checked_transport(material: Material) -> dict[str, Any]:
    """Return the checked fields of light transport that are no amounts."""
    name = "Material"
    coat = check_number(name, "coat", material.coat)
    if not coat >= 1:
        raise ValueError(f"{name}: coat must be an index of refraction >= 1, got {coat}")
    anisotropy = check_number(name, "anisotropy", material.anisotropy)
    if not -1 < anisotropy < 1:
        raise ValueError(f"{name}: anisotropy must be in ]-1, 1[, got {anisotropy}")
    checked: dict[str, Any] = dict(roughness=check_roughness(name, material.roughness))
    checked |= dict(coat=coat, anisotropy=anisotropy) | check_bump_and_normal(material)
    checked["dispersion"] = check_nonnegative(name, "dispersion", material.dispersion)
    return checked | _checked_metal(material)


def _checked_metal(material: Material) -> dict[str, Any]:
    """Return the complex index of a metal, both parts or none."""
    parts = dict(metal_index=material.metal_index, metal_extinction=material.metal_extinction)
    if all(part is None for part in parts.values()):
        return parts
    checked: dict[str, Any] = {}
    for field, part in parts.items():
        if part is None:
            raise ValueError(f"Material: metal_index and metal_extinction go together, got no {field}")
        rgb = check_numbers("Material", field, part, 3)
        for i, value in enumerate(rgb):
            if not (value > 0 if field == "metal_index" else value >= 0):
                least = "> 0" if field == "metal_index" else ">= 0"
                raise ValueError(f"Material: {field}[{i}] must be {least}, got {value}")
        checked[field] = (rgb[0], rgb[1], rgb[2])
    return checked


def _warn_and_compare(material: Material, other: object) -> Any:
    """Compare all fields. Warn if the other is a text, as the user may mean the material's name."""
    if isinstance(other, str):
        hint = f"material.name == {format_value(other)} compares names, and scene.materials[name] is the one of a name"
        warn(f"Material: a material equals no text, got {format_value(other)}: {hint}")
    return _equal_fields(material, other)


_equal_fields = Material.__eq__
# Set here, not in the class: `_warn_and_compare` calls the method that dataclass generates.
setattr(Material, "__eq__", _warn_and_compare)  # noqa: B010


def _amount(material: Material, field: str, most: float) -> Amount:
    """Return an amount in [0, most]."""
    return check_amount("Material", field, getattr(material, field), most=most)


# The constructor of a material, for its repr and for scene files.

MaterialMaker: TypeAlias = Callable[..., Material]
"""A constructor of materials, such as `matte`, or the class itself."""


def rename_material(material: Material, name: str) -> Material:
    """Return the same material with another name; its recorded constructor stays."""
    return record_maker(dataclasses.replace(material, name=name), *_maker_of(material))


def record_maker(material: Material, maker: MaterialMaker, own: Mapping[str, Any]) -> Material:
    """Store on a material the constructor that made it, and return the material.

    `own` holds the arguments of the constructor that are no fields of the material. The repr and scene files write the
    call from both; equality ignores them. Pickles name the constructor by its module.
    """
    # Not a field of the dataclass, so that equality and hashes ignore it.
    object.__setattr__(material, "_made", (maker, dict(own)))
    return material


def _maker_of(material: Material) -> tuple[MaterialMaker, dict[str, Any]]:
    """Return the recorded constructor and its own arguments; the class for a material without a record."""
    return vars(material).get("_made", (Material, {}))


def constructor_call(material: Material) -> tuple[str, dict[str, Any]]:
    """Return the name of the constructor of a material, and its arguments that differ from their defaults."""
    maker, own = _maker_of(material)
    arguments = {}
    for name, default in _defaults(maker).items():
        # Arguments of the constructor come from its record, all others are fields.
        value = own[name] if name in own else getattr(material, name)
        if repr(value) != default:
            arguments[name] = value
    return maker.__name__, arguments


@functools.cache
def _defaults(maker: MaterialMaker) -> dict[str, str]:
    """Return argument -> repr of its default, of a constructor of materials."""
    return {name: repr(one.default) for name, one in inspect.signature(maker).parameters.items()}


DEFAULT_MATERIAL = Material()
"""The material of bodies without one: matte light grey."""
