"""Lights and backgrounds.

Intensities are linear, one number or a colour times a number; see `falloff` for the distance.
A light of intensity I on a matte surface of reflectance c at angle θ gives c I cos θ.
"""

from __future__ import annotations

import os
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np

from .._util.arrays import FloatArray, VectorLike, ignore_fp_errors
from .._util.records import dataclass
from .._util.validation import (
    as_integer,
    check_degrees,
    check_fields,
    check_list,
    check_nonnegative,
    check_number,
    check_path as checked_path,
    check_vector,
    describe_kind,
    format_value,
    optional,
    warn,
)
from .color import BRIGHT, BYTE, Amount, Color, check_amount, check_color, linear_rgb, look_like_bytes, srgb_decode
from .image_file import image_array, read_pixels
from .texture import ImagePath

Falloff: TypeAlias = Literal["none", "inverse_square"]
"""none: the same at any distance; inverse_square: intensity / distance², so intensity at distance 1."""


@dataclass(frozen=True)
class AmbientLight:
    """Light from everywhere, without shadows. Several add up.

    Parameters
    ----------
    intensity : Amount
        Linear: one number or a colour.
    """

    intensity: Amount = 0.2

    def __post_init__(self) -> None:
        _check(self, "intensity")


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light, as of the sun.

    Parameters
    ----------
    direction : VectorLike
        Direction in which the light travels.
    intensity : Amount
        Linear: one number or a colour.
    """

    direction: VectorLike
    intensity: Amount = 1.0

    def __post_init__(self) -> None:
        _check(self, "intensity", "direction")


@dataclass(frozen=True)
class PointLight:
    """Light from one point to all sides.

    Parameters
    ----------
    position : VectorLike
        The point.
    intensity : Amount
        Linear: one number or a colour.
    falloff : {"none", "inverse_square"}
        "none" is the same at any distance. "inverse_square" is intensity / distance², so intensity at distance 1.
    """

    position: VectorLike
    intensity: Amount = 1.0
    falloff: Falloff = "none"

    def __post_init__(self) -> None:
        _check(self, "intensity", "position", "falloff")


@dataclass(frozen=True)
class SpotLight:
    """A cone of light.

    It is full within `angle - soft_edge` degrees of the axis and zero beyond `angle`. Between them it falls smoothly,
    as 3s² - 2s³ of the angle's share s of the edge.

    Parameters
    ----------
    position : VectorLike
        The tip of the cone.
    direction : VectorLike
        The axis of the cone.
    angle : float
        Degrees from the axis to the rim, in (0, 180].
    soft_edge : float
        Degrees of the edge, in [0, angle].
    intensity, falloff
        As in `PointLight`.
    """

    position: VectorLike
    direction: VectorLike
    angle: float = 30.0
    soft_edge: float = 5.0
    intensity: Amount = 1.0
    falloff: Falloff = "none"

    def __post_init__(self) -> None:
        _check(self, "intensity", "position", "direction", "falloff")
        check_fields(self, angle=check_degrees, soft_edge=check_degrees)
        if not 0 < self.angle <= 180:
            raise ValueError(f"SpotLight: angle must be in (0, 180], got {self.angle} degrees")
        if not 0 <= self.soft_edge <= self.angle:
            limits = f"[0, angle = {self.angle:g}]"
            raise ValueError(f"SpotLight: soft_edge must be in {limits}, got {self.soft_edge} degrees")


# All kinds of lights, and their checks.

Light: TypeAlias = AmbientLight | DirectionalLight | PointLight | SpotLight
LIGHTS: dict[str, type[Light]] = {kind.__name__: kind for kind in get_args(Light)}
"""Name in scene files -> class."""


def as_lights(lights: Any) -> tuple[Light, ...]:
    """Return checked lights as a tuple; one light stands for a list of it."""
    return check_list("Scene", "lights", lights, LIGHTS)


def _warn_of_bytes(light: Light, owner: str, intensity: Amount) -> None:
    """Warn about a colour in bytes, unless distance weakens the light."""
    # Near an inverse square light, intensities of hundreds are normal.
    fades = getattr(light, "falloff", "none") == "inverse_square"
    if isinstance(intensity, tuple) and not fades and look_like_bytes(intensity, BRIGHT):
        warn(
            f"{owner}: intensity {intensity} is linear light, {max(intensity):g} times white; bytes are divided by 255"
        )


def _check(light: Light, *fields: str) -> None:
    """Check and normalise the named fields of a frozen light."""
    owner = type(light).__name__
    for field in fields:
        value = getattr(light, field)
        if field == "intensity":
            # Lights may be brighter than white, so there is no upper bound.
            value = check_amount(owner, field, value, most=float("inf"))
            _warn_of_bytes(light, owner, value)
        elif field == "falloff":
            if not isinstance(value, str) or value not in get_args(Falloff):
                raise ValueError(f"{owner}: falloff must be 'none' or 'inverse_square', got {format_value(value)}")
        else:
            value = check_vector(owner, field, value, nonzero=field == "direction")
        object.__setattr__(light, field, value)


# Backgrounds, for rays that hit nothing: one colour, a sky that changes with height, an image, a clear sky by day.


def _light(owner: str, field: str, value: Any) -> Color:
    """Return a colour that may be brighter than white; refuse three bytes, as they would make everything white."""
    color = check_color(owner, field, value, most=float("inf"))
    if not isinstance(color, str) and look_like_bytes(color):
        # Three whole numbers up to 255 are most likely bytes.
        expected = "linear light, where 1 is white, or a Sky with an intensity"
        raise ValueError(f"{owner}: {field} must be {expected}, got {color}")
    if not isinstance(color, str) and BRIGHT < max(color) <= BYTE:
        warn(
            f"{owner}: {field} {color} is linear light, {max(color):g} times white; co.Sky(..., intensity=...) says so"
        )
    return color


@dataclass(frozen=True)
class Sky:
    """A sky from `ground` straight down over `horizon` to `zenith` straight up (the z axis).

    Between them it is linear in the square root of |direction's z|, so that most of the change is near the horizon.

    Parameters
    ----------
    zenith, horizon : Color
        Colours straight up and at the horizon.
    ground : Color, optional
        Colour straight down. Without it the lower half has the colour of the horizon.
    intensity : float
        Factor of all colours, >= 0.
    """

    zenith: Color = (0.28, 0.45, 0.75)
    horizon: Color = (0.85, 0.9, 0.95)
    ground: Color | None = None
    intensity: float = 1.0

    def __post_init__(self) -> None:
        check_fields(self, zenith=_light, horizon=_light, ground=optional(_light), intensity=check_nonnegative)


def _read(path: str | os.PathLike[str]) -> Any:
    """Return the linear light of an image file."""
    try:
        return read_pixels(path).linear(is_data=False)
    except ValueError as error:
        raise ValueError(f"Environment: pixels: file {error}") from None


@dataclass(frozen=True, eq=False)
class Environment:
    """An image of all directions around a scene, equirectangular, that lights it in light transport.

    Whitted's pictures show the mean colours of its top, middle and bottom.

    Parameters
    ----------
    pixels : array_like or path
        (height, width, 3): linear radiance >= 0, bytes (uint8) of sRGB, or an `Image`. Or the name of a file, an .exr
        of linear light, or a .png, .jpg or .webp, which is read at once. A scene file may name those in its own
        folder, or below. The first row is straight up, +z. Rows go from left to right as one sees them from within,
        with -x in their middle and -y left of it: a picture of an `EquirectangularCamera` that looks along -x shows its
        scene again.
    intensity : float
        Factor of the radiance, >= 0.
    rotation : float
        Degrees about z that turn the image, counter-clockwise as seen from above, to the nearest whole pixel.

    Raises
    ------
    ValueError
        If a file cannot be read, or pixels have another shape or are not finite and >= 0.
    """

    pixels: ImagePath | Any
    intensity: float = 1.0
    rotation: float = 0.0
    file: ClassVar[ImagePath | None] = None
    """The file of the pixels, if they came from one."""

    def __post_init__(self) -> None:
        if isinstance(self.pixels, str | os.PathLike):
            object.__setattr__(self, "file", ImagePath(os.path.abspath(checked_path("Environment", self.pixels))))
            radiance: Any = _read(self.pixels)
        else:
            radiance = image_array("Environment", "pixels", self.pixels)
        radiance = srgb_decode(radiance / 255) if radiance.dtype == np.uint8 else radiance
        if radiance.ndim != 3 or radiance.shape[2] != 3 or radiance.size == 0:
            raise ValueError(f"Environment: pixels must have shape (height, width, 3), got {radiance.shape}")
        bad = np.argwhere(~(np.isfinite(radiance) & (radiance >= 0)))
        if len(bad):
            place = tuple(int(k) for k in bad[0])
            raise ValueError(f"Environment: pixels{list(place)} must be finite and >= 0, got {radiance[place]}")
        check_fields(self, intensity=check_nonnegative, rotation=check_degrees)
        pixels = np.array(radiance, np.float64)
        # Frozen: equality and hashes depend on the pixels.
        pixels.flags.writeable = False
        object.__setattr__(self, "pixels", pixels)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Environment) and self._key() == other._key() and np.array_equal(self.pixels, other.pixels)
        )

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[Any, ...]:
        """Return the values that equality and hashes use; the sum stands for the pixels."""
        pixels: Any = self.pixels
        # A cheap key: equality also compares all pixels.
        return pixels.shape, float(pixels.sum()), self.intensity, self.rotation

    @property
    def radiance(self) -> FloatArray:
        """Radiance (height, width, 3) with intensity and rotation; the angle about z grows along a row."""
        pixels: Any = self.pixels
        rotated: FloatArray = np.roll(pixels[:, ::-1], round(self.rotation / 360 * pixels.shape[1]), axis=1)
        return self.intensity * rotated


Background: TypeAlias = Color | Sky | Environment
DEFAULT_BACKGROUND = Sky((0.62, 0.72, 0.84), (0.94, 0.95, 0.96))
"""The sky of scenes without a background."""


def as_background(value: Any) -> Background | None:
    """Return a checked background: a colour, a Sky, an Environment, or None for the default."""
    if value is None or isinstance(value, Sky | Environment):
        return value
    if not isinstance(value, str) and not hasattr(value, "__len__"):
        raise TypeError(
            f"Scene: background must be a colour, a Sky, an Environment or None, got {describe_kind(value)}"
        )
    return _light("Scene", "background", value)


# The light of a clear sky by day
#
# Preetham, Shirley and Smits, A practical analytic model for daylight, SIGGRAPH 1999. Luminance and chromaticity follow
# Perez, F(θ, γ) = (1 + A e^(B / cos θ)) (1 + C e^(D γ) + E cos² γ), over the angle θ from the zenith and γ from the
# sun; the five numbers of each are linear in the turbidity.

_PEREZ = {
    "Y": ((0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)),
    "x": ((-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)),
    "y": ((-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)),
}
"""Coefficients A to E of Perez, each a slope over the turbidity and a constant (appendix A.2)."""
_ZENITH = {
    "x": (
        (0.00166, -0.00375, 0.00209, 0.0), (-0.02903, 0.06377, -0.03202, 0.00394),
        (0.11693, -0.21196, 0.06052, 0.25886),
    ),
    "y": (
        (0.00275, -0.00610, 0.00317, 0.0), (-0.04214, 0.08970, -0.04153, 0.00516),
        (0.15346, -0.26756, 0.06670, 0.26688),
    ),
}  # fmt: skip
"""Chromaticity straight up: rows are powers 2, 1, 0 of the turbidity, columns powers 3 to 0 of the sun's angle."""
# From CIE XYZ to linear rgb (Rec. 709 primaries).
_TO_RGB = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.969266, 1.8760108, 0.041556], [0.0556434, -0.2040259, 1.0572252]]
)
_LEAST = 0.02  # the formula divides by the cosine: lower directions take the light of this one


@ignore_fp_errors
def clear_sky(
    sun: VectorLike = (1.0, 0.0, 1.0),
    turbidity: float = 3.0,
    ground: Color = (0.2, 0.2, 0.2),
    intensity: float = 0.1,
    height: int = 128,
) -> Environment:
    """Return a clear sky by day, without the disc of the sun; add a `DirectionalLight` for the sun itself.

    Parameters
    ----------
    sun : VectorLike
        Direction to the sun, not below the horizon.
    turbidity : float
        Haze of the air, from 2, clear, to 10.
    ground : Color
        Reflectance of everything below the horizon; the sky lights it.
    intensity : float
        Radiance for each thousand candela per square metre of luminance. A sky has 5 to 30 of these.
    height : int
        Rows of the image, 4 to 4096; there are twice as many columns.

    Returns
    -------
    Environment
        The sky as an image of all directions.

    Raises
    ------
    ValueError
        If the sun is below the horizon, or a number is out of range.
    """
    x, y, z = check_vector("clear_sky", "sun", sun, nonzero=True)
    haze = check_number("clear_sky", "turbidity", turbidity)
    if z < 0:
        raise ValueError(f"clear_sky: sun must not be below the horizon, got {(x, y, z)}")
    if not 2 <= haze <= 10:
        raise ValueError(f"clear_sky: turbidity must be in [2, 10], got {haze}")
    scale = check_nonnegative("clear_sky", "intensity", intensity)
    reflectance = linear_rgb(check_color("clear_sky", "ground", ground))
    rows = as_integer(height)
    if rows is None or not 4 <= rows <= 4096:
        raise ValueError(f"clear_sky: height must be a whole number from 4 to 4096, got {format_value(height)}")
    towards = np.array([x, y, z]) / np.sqrt(x * x + y * y + z * z)
    directions, weights = _directions(rows)
    upper = directions[..., 2] > 0
    light = np.where(upper[..., None], _radiance(directions, towards, haze), 0.0)
    # The ground reflects the irradiance of the sky as a Lambertian surface.
    irradiance = (light * (weights * np.maximum(directions[..., 2], 0))[..., None]).sum(axis=(0, 1))
    light[~upper] = np.array(reflectance) * irradiance / np.pi
    return Environment(scale * light.astype(np.float32).astype(np.float64))  # the same bits on all machines


def _directions(height: int) -> tuple[FloatArray, FloatArray]:
    """Return the directions of pixel centres, (height, 2 height, 3), and the solid angle of each pixel."""
    theta = (np.arange(height) + 0.5) / height * np.pi
    phi = (np.arange(2 * height) + 0.5) / height * np.pi
    s, c = np.sin(theta)[:, None], np.cos(theta)[:, None]
    directions = np.stack([s * np.cos(phi), s * np.sin(phi), np.broadcast_to(c, (height, 2 * height))], axis=-1)
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    weights = np.broadcast_to(((edges[:-1] - edges[1:]) * np.pi / height)[:, None], (height, 2 * height))
    return directions, weights


def _perez(numbers: Any, haze: float, cosine: Any, gamma: Any) -> Any:
    """Return F(θ, γ) of Perez."""
    a, b, c, d, e = (slope * haze + constant for slope, constant in numbers)
    return (1 + a * np.exp(b / cosine)) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)


def _at_zenith(haze: float, theta: float) -> dict[str, float]:
    """Return luminance Y in kcd/m² and chromaticity x and y straight up."""
    chi = (4 / 9 - haze / 120) * (np.pi - 2 * theta)
    zenith = {"Y": (4.0453 * haze - 4.9710) * float(np.tan(chi)) - 0.2155 * haze + 2.4192}
    for name, rows in _ZENITH.items():
        zenith[name] = sum(
            power * sum(k * theta ** (3 - j) for j, k in enumerate(row))
            for power, row in zip((haze * haze, haze, 1.0), rows, strict=True)
        )
    return zenith


def _radiance(directions: FloatArray, sun: FloatArray, haze: float) -> FloatArray:
    """Return linear rgb of directions, (height, width, 3)."""
    theta = float(np.arccos(min(1.0, sun[2])))
    gamma = np.arccos(np.clip((directions * sun).sum(axis=-1), -1, 1))
    cosine = np.maximum(directions[..., 2], _LEAST)
    zenith = _at_zenith(haze, theta)
    channels = {}
    for name, numbers in _PEREZ.items():
        channels[name] = zenith[name] * _perez(numbers, haze, cosine, gamma) / _perez(numbers, haze, 1.0, theta)
    luminance, x, y = channels["Y"], channels["x"], channels["y"]
    xyz = (luminance / y * x, luminance, luminance / y * (1 - x - y))
    rgb = np.stack([sum(k * part for k, part in zip(row, xyz, strict=True)) for row in _TO_RGB.tolist()], axis=-1)
    return np.maximum(rgb, 0.0)
