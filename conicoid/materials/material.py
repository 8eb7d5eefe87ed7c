"""`Material`, the record of a look, and `Properties`, the user's own values of it: density, attenuation, any other."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import numbers
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from .._util.arrays import Vector
from .._util.records import dataclass
from .._util.validation import (
    check_fields,
    check_nonnegative,
    check_number,
    check_numbers,
    check_positive,
    describe_kind,
    format_value,
    real_array,
    warn,
)
from .coating import Coating
from .color import Amount, Color, check_amount, check_color
from .dispersion import Index, check_index
from .texture import PATTERNS, TEXTURES, ImageTexture, Pattern, Texture, mean_grey

_DIMENSIONS = 2
_LARGEST_INTEGER = 10**18  # scene files read shorter numbers as integers
_MOST_LETTERS = 8
_EXPECTED = "a number, a text, true or false, an array of numbers or texts, or a mapping from names to numbers or texts"


class Properties(Mapping[str, Any]):
    """An immutable mapping from names to values, so that materials can be compared and used as keys.

    A value is a number, a text, a truth value, an array of numbers of one or two dimensions (stored as read-only
    float64), a list of texts (stored as a tuple), or a mapping from names to numbers, texts and truth values.
    Infinite numbers are allowed, NaN is not.

    Parameters
    ----------
    values : Mapping[str, Any]
        The values by name.
    owner : str
        Name of the object, for messages.

    Raises
    ------
    ValueError, TypeError
        For any other value; the message has its name.
    """

    __slots__ = ("_hash", "_values")

    def __init__(self, values: Mapping[str, Any] = {}, *, owner: str = "Properties") -> None:
        field = f"{owner}: properties"
        self._values = {name: _value(f"{field}[{name!r}]", value, True) for name, value in _named(field, values)}
        _check_density(field, self._values.get("density"))
        self._hash: int | None = None

    @classmethod
    def _of(cls, values: dict[str, Any]) -> Properties:
        """Return the properties of values that are already checked."""
        result = cls()
        result._values = values
        return result

    def __getitem__(self, name: str) -> Any:
        try:
            return self._values[name]
        except (KeyError, TypeError):
            names = ", ".join(map(repr, self._values)) or "none"
            raise KeyError(f"no property {format_value(name)}; properties: {names}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Mapping) or self._values.keys() != other.keys():
            return False
        return all(_same(value, other[name]) for name, value in self._values.items())

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset((name, _hashed(value)) for name, value in self._values.items()))
        return self._hash

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{name!r}: {_text(value, _MOST_LETTERS)}" for name, value in self._values.items()) + "}"

    @property
    def exact_text(self) -> str:
        """Text of all values, however long: equal for values that are equal to the bit."""
        return ", ".join(f"{name!r}: {_text(value, None)}" for name, value in self._values.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return Properties, (dict(self._values),)


def _check_density(field: str, value: Any) -> None:
    """Check the one property with a fixed meaning: a density is >= 0 and no truth value."""
    wrong = isinstance(value, bool) or (isinstance(value, int | float | np.ndarray) and bool(np.any(np.less(value, 0))))
    if wrong:
        raise ValueError(f"{field}['density'] must be >= 0, got {format_value(value)}")


def _named(field: str, values: Any) -> Iterator[tuple[str, Any]]:
    """Yield (name, value). Raise TypeError if `values` is no mapping, or a name no text."""
    if not isinstance(values, Mapping):
        raise TypeError(f"{field} must be a mapping from names to values, got {describe_kind(values)}")
    for name, value in values.items():
        if not isinstance(name, str) or not name:
            raise TypeError(f"{field} must have non-empty texts as names, got {format_value(name)}")
        yield name, value


def _value(field: str, value: Any, nested: bool) -> Any:
    """Return a value in its stored form."""
    # Scalars of NumPy become Python's, so that equal values have equal texts.
    if isinstance(value, (np.generic, np.ndarray)) and value.ndim == 0:
        value = value.item()
    if isinstance(value, str):
        if not value:
            raise ValueError(f"{field} must not be an empty text")
        return str(value)
    # Before numbers, as bool is an integer type.
    if isinstance(value, bool):
        return value
    if isinstance(value, numbers.Real):
        return _number(field, value)
    if nested and isinstance(value, Mapping):
        return Properties._of({name: _value(f"{field}[{name!r}]", item, False) for name, item in _named(field, value)})
    if nested and isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (bytes, bytearray)):
        return _array(field, value)
    raise TypeError(f"{field} must be {_EXPECTED if nested else 'a number or a text'}, got {describe_kind(value)}")


def _number(field: str, value: Any) -> int | float:
    """Return an int of at most 18 digits, or a float that is not NaN."""
    if isinstance(value, numbers.Integral):
        if abs(int(value)) >= _LARGEST_INTEGER:
            raise ValueError(f"{field} must be an integer of at most 18 digits, or a float, got {format_value(value)}")
        return int(value)
    try:
        result = float(value)
    except OverflowError:
        result = math.nan
    if math.isnan(result):
        raise ValueError(f"{field} must be a number that float64 holds, not NaN, got {format_value(value)}")
    return result


def _array(field: str, values: Any) -> Any:
    """Return a tuple of texts, or a read-only array of float64."""
    if len(values) and all(isinstance(item, str) for item in values):
        if not all(values):
            raise ValueError(f"{field} must not hold empty texts")
        return tuple(map(str, values))
    array = np.array(real_array("", field, values, "an array of numbers, or a list of texts"), order="C")
    if array.ndim > _DIMENSIONS:
        raise ValueError(f"{field} must have at most {_DIMENSIONS} dimensions, got shape {array.shape}")
    if np.isnan(array).any():
        raise ValueError(f"{field} must not hold NaN")
    array.flags.writeable = False
    return array


def _same(one: Any, other: Any) -> bool:
    """Compare two values, arrays among them."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, tuple) and isinstance(other, list):
        return list(one) == other
    return bool(one == other)


def _hashed(value: Any) -> Any:
    """Return a hashable form of a value: equal for equal values."""
    if isinstance(value, np.ndarray):
        return value.shape, (value + 0.0).tobytes()  # -0 is 0
    return value


def _text(value: Any, most: int | None) -> str:
    """Return the repr of a value; long arrays and lists are shortened if `most` is a number."""
    if isinstance(value, Properties):
        return repr(value) if most is not None else "{" + value.exact_text + "}"
    if isinstance(value, np.ndarray) and (most is None or value.size <= most):
        return repr(value.tolist())
    if isinstance(value, np.ndarray):
        return f"<array of {' x '.join(map(str, value.shape))} numbers>"
    if isinstance(value, tuple) and most is not None and len(value) > most:
        return f"<{len(value)} texts>"
    return repr(value)


NO_PROPERTIES = Properties()


# Material: the record of a look, the checks of its fields, and the constructor that a material remembers.

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
