"""What textures say of a surface beside its colour: how rough it is, bumps, normals."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, TypeAlias, get_args

from .._util.arrays import Vector
from .._util.foreign_names import with_attribute_hints
from .._util.hints import frozen_with_hints
from .._util.user_warnings import warn
from .._util.validation import check_nonnegative, check_number, check_numbers, check_positive, format_value
from .coating import Coating
from .color import Amount, Color, check_amount, check_color
from .dispersion import Index, check_index, glass_hint
from .properties import NO_PROPERTIES, Properties
from .texture import PATTERNS, TEXTURES, ImageTexture, Pattern, Texture, mean_grey

_TEXTURE_KINDS = "an ImageTexture, Gradient, Noise, Wood or Brick"


def check_roughness(owner: str, value: Any) -> Any:
    """A number in [0, 1], or a texture of such."""
    if isinstance(value, TEXTURES):
        return value
    rough = check_number(owner, "roughness", value)
    if not 0 <= rough <= 1:
        raise ValueError(f"{owner}: roughness must be in [0, 1], got {rough}")
    return rough


def typical_roughness(owner: str, value: Any) -> float:
    """One number, of a texture its mean."""
    rough = check_roughness(owner, value)
    return rough if isinstance(rough, float) else mean_grey(rough)


def check_bump_and_normal(material: Any) -> dict[str, Any]:
    """Bumps and normals of a material."""
    bump, normal = material.bump, material.normal
    if bump is not None and not isinstance(bump, TEXTURES):
        raise TypeError(f"Material: bump must be a texture ({_TEXTURE_KINDS}) or None, got {format_value(bump)}")
    if normal is not None and not isinstance(normal, ImageTexture):
        raise TypeError(f"Material: normal must be an ImageTexture of normals or None, got {format_value(normal)}")
    if normal is not None and not normal.data:
        hint = "its numbers are no colours: ImageTexture(..., data=True)"
        raise ValueError(f"Material: normal must be a texture of plain data; {hint}")
    return dict(bump_height=check_number("Material", "bump_height", material.bump_height))


# Materials: one record for every look, and named constructors for the usual ones.

Highlight: TypeAlias = Literal["phong", "blinn_phong"]

VACUUM = 1.0
AIR = 1.0003
WATER = 1.33
GLASS = 1.52
"""Refractive indices: speed of light in vacuum over speed in the medium (the ray tracing notes)."""


@with_attribute_hints
@frozen_with_hints
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
    refractive_index: of the inside, against `VACUUM` = 1 outside of all bodies: a number, the name of a glass such as
        "N-BK7", a formula of `co.optics`, or a function of the wavelength in μm (docs/optics.md). Pictures take n_d.
    absorption: per unit length inside, for each channel: light fades by exp(-absorption · length) (Beer).

    What follows is for light transport ("path", "direct"); what it means there of the fields above says docs/light.md.

    emission: radiance that the surface sends to all sides by itself, from both of its sides.
    roughness: 0 is smooth. Of what mirrors or refracts the α of Trowbridge and Reitz's distribution (GGX), of matte
        surfaces the σ of Oren and Nayar's law; in [0, 1]. A texture says it by how bright it is.
    coat: the refractive index of a clear coat over the colour; 1 is none.
    metal_index, metal_extinction: the complex refractive index n + ik of a metal for red, green and blue.
    scattering: per unit length inside, for each channel: how often light is scattered there (fog, milk).
    anisotropy: the mean cosine of such a turn, in ]-1, 1[: 0 to all sides alike, over 0 rather forward.
    dispersion: by how much the refractive index grows towards blue: Cauchy's B in μm² of
        n(λ) = refractive_index + B (1/λ² - 1/λ_d²), λ_d = 0.5876 μm. Of an index that depends on the wavelength it is
        the B through n_F and n_C unless it is given.

    coating: thin films on its walls, a `co.optics.Coating`; `co.optics.trace_paths` goes by it, pictures do not.

    And for all pictures:

    bump: a texture whose brightness is a height over the surface, times `bump_height`, which bends its normal.
    normal: an `ImageTexture` with `data=True` of normals: 2 c - 1 along growing u, growing v and the surface's normal.

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
        for field in ("specular", "reflectivity", "transparency"):
            object.__setattr__(self, field, _amount(self, field, 1.0))
        for field in ("absorption", "emission", "scattering"):
            object.__setattr__(self, field, _amount(self, field, infinity))
        for field, value in _checked_transport(self).items():
            object.__setattr__(self, field, value)
        for field in ("ambient", "diffuse"):
            value = check_number(name, field, getattr(self, field))
            if value < 0:
                raise ValueError(f"{name}: {field} must be >= 0, got {value}")
            object.__setattr__(self, field, value)
        object.__setattr__(self, "shininess", check_positive(name, "shininess", self.shininess))
        object.__setattr__(self, "refractive_index", _checked_refractive_index(self))
        if not isinstance(self.highlight, str) or self.highlight not in get_args(Highlight):
            raise ValueError(f"{name}: highlight must be 'phong' or 'blinn_phong', got {format_value(self.highlight)}")
        if self.coating is not None and not isinstance(self.coating, Coating):
            raise ValueError(f"{name}: coating must be a co.optics.Coating or None, got {format_value(self.coating)}")
        if not isinstance(self.fresnel, bool):
            raise ValueError(f"{name}: fresnel must be true or false, got {format_value(self.fresnel)}")

    def __repr__(self) -> str:
        """The call that makes it, without what it leaves out."""
        maker, given = constructor_call(self)
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
    coat = check_number(name, "coat", material.coat)
    if not coat >= 1:
        raise ValueError(f"{name}: coat must be an index of refraction >= 1, got {coat}")
    anisotropy = check_number(name, "anisotropy", material.anisotropy)
    if not -1 < anisotropy < 1:
        raise ValueError(f"{name}: anisotropy must be in ]-1, 1[, got {anisotropy}")
    found: dict[str, Any] = dict(roughness=check_roughness(name, material.roughness))
    found |= dict(coat=coat, anisotropy=anisotropy) | check_bump_and_normal(material)
    found["dispersion"] = check_nonnegative(name, "dispersion", material.dispersion)
    return found | _checked_metal(material)


def _checked_metal(material: Material) -> dict[str, Any]:
    """The complex index of a metal, both parts or none."""
    parts = dict(metal_index=material.metal_index, metal_extinction=material.metal_extinction)
    if all(part is None for part in parts.values()):
        return parts
    found: dict[str, Any] = {}
    for field, part in parts.items():
        if part is None:
            raise ValueError(f"Material: metal_index and metal_extinction go together, got no {field}")
        rgb = check_numbers("Material", field, part, 3)
        for i, value in enumerate(rgb):
            if not (value > 0 if field == "metal_index" else value >= 0):
                least = "> 0" if field == "metal_index" else ">= 0"
                raise ValueError(f"Material: {field}[{i}] must be {least}, got {value}")
        found[field] = (rgb[0], rgb[1], rgb[2])
    return found


def _refuse_items(material: Material, name: object) -> NoReturn:
    raise TypeError(
        f"'Material' object has no items: material.properties[{format_value(name)}] is what it keeps by that name"
    )


def _warn_and_compare(material: Material, other: object) -> Any:
    """Equality of all fields. That a text equals no material is told, as it may be meant for its name."""
    if isinstance(other, str):
        told = f"material.name == {format_value(other)} compares names, and scene.materials[name] is the one of a name"
        warn(f"Material: a material equals no text, got {format_value(other)}: {told}")
    return _equal_fields(material, other)


_equal_fields = Material.__eq__
setattr(Material, "__eq__", _warn_and_compare)  # noqa: B010 - the one that dataclass made is called by it
setattr(Material, "__getitem__", _refuse_items)  # noqa: B010 - else checkers would let items be asked for


def _amount(material: Material, field: str, most: float) -> Amount:
    value = getattr(material, field)
    try:
        return check_amount("Material", field, value, most=most)
    except ValueError as error:
        raise ValueError(f"{error}{_name_hint(material, value)}") from None


def _checked_refractive_index(material: Material) -> Index:
    """The refractive index: one number, or what gives one for each wavelength."""
    value = material.refractive_index
    try:
        return check_index("Material", value)
    except ValueError as error:
        several = isinstance(value, list | tuple | dict) or bool(getattr(value, "ndim", 0))
        hint = "; a scene is of one wavelength: make one for each, scene.replace(name, material=co.glass(index))"
        hint += "; or co.optics.Tabulated(wavelengths, n) is a table of them"
        name = _name_hint(material, value) + glass_hint(value)
        raise ValueError(f"{error}{hint if several else name}") from None


def _name_hint(material: Material, value: Any) -> str:
    """What to tell of a text that is no colour and no number."""
    if not isinstance(value, str) or value.startswith("#") or material.name is not None:
        return ""
    return f"; a name is given by its argument, name={format_value(value)}"


MaterialMaker: TypeAlias = Callable[..., Material]
"""A function that makes materials, such as `matte`, or the class itself."""


def rename_material(material: Material, name: str) -> Material:
    """The same under another name, made by the same function."""
    return record_maker(dataclasses.replace(material, name=name), *_maker_of(material))


def record_maker(material: Material, maker: MaterialMaker, own: Mapping[str, Any]) -> Material:
    """Store on a material the function that made it, and return the material.

    `own` holds the arguments of the function that are no fields of the material. The repr and scene files write the
    call from both; equality ignores them. Pickles name the function by its module.
    """
    object.__setattr__(material, "_made", (maker, dict(own)))
    return material


def _maker_of(material: Material) -> tuple[MaterialMaker, dict[str, Any]]:
    made: tuple[MaterialMaker, dict[str, Any]] = vars(material).get("_made", (Material, {}))
    return made


def constructor_call(material: Material) -> tuple[str, dict[str, Any]]:
    """Return the name of the function, or of the class, that made a material, and its arguments without defaults."""
    maker, own = _maker_of(material)
    given = {}
    for name, default in _defaults(maker).items():
        value = own[name] if name in own else getattr(material, name)
        if repr(value) != default:
            given[name] = value
    return maker.__name__, given


@functools.cache
def _defaults(maker: MaterialMaker) -> dict[str, str]:
    """Argument of a function that makes materials -> the repr of its default."""
    return {name: repr(one.default) for name, one in inspect.signature(maker).parameters.items()}


DEFAULT_MATERIAL = Material()
"""The material of bodies that are given none: matte light grey."""
