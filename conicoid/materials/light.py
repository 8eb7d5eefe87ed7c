"""Lights. Intensities are linear, one number or a colour times a number; see `falloff` for the distance.

A light of intensity I on a matte surface of reflectance c at angle θ gives c I cos θ.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, get_args

from .._util.arrays import VectorLike
from .._util.dataclass import dataclass
from .._util.validation import check_degrees, check_fields, check_list, check_vector, format_value, warn
from .color import BRIGHT, Amount, check_amount, look_like_bytes

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
