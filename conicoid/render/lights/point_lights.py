"""Point, spot and parallel lights as records, and their light at a point."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline
from ...kernels.numbers.elementary import acos
from ...kernels.numbers.vectors import dot
from ...materials.color import amount_rgb
from ...materials.light import AmbientLight, DirectionalLight, Light, PointLight, SpotLight
from ...numerics.portable_math import hypot

LIGHT_RECORD = np.dtype(
    [
        ("parallel", "i8"),
        ("position", "f8", (3,)),
        ("axis", "f8", (3,)),
        ("intensity", "f8", (3,)),
        ("fades", "i8"),
        ("outer", "f8"),
        ("inner", "f8"),
    ],
    align=True,
)


def lower_lights(lights: Iterable[Light]) -> tuple[npt.NDArray[np.void], tuple[float, float, float]]:
    """Return (records of the lights that have a direction, the rgb sum of the ambient ones)."""
    items = list(lights)
    ambient = np.zeros(3)
    for light in items:
        if isinstance(light, AmbientLight):
            ambient += amount_rgb(light.intensity)
    directed = [light for light in items if not isinstance(light, AmbientLight)]
    records = np.zeros(len(directed), dtype=LIGHT_RECORD)
    for record, light in zip(records, directed, strict=True):
        _fill(record, light)
    return records, (float(ambient[0]), float(ambient[1]), float(ambient[2]))


def _fill(record: Any, light: DirectionalLight | PointLight | SpotLight) -> None:
    """Fill the record of a light; a light without a cone has angles of inf."""
    record["intensity"] = amount_rgb(light.intensity)
    record["outer"] = record["inner"] = math.inf
    if isinstance(light, DirectionalLight):
        record["parallel"], record["axis"] = 1, _unit(light.direction)
        return
    record["position"], record["fades"] = light.position, light.falloff == "inverse_square"
    if isinstance(light, SpotLight):
        record["axis"] = _unit(light.direction)
        record["outer"] = math.radians(light.angle)
        record["inner"] = math.radians(light.angle - light.soft_edge)


def _unit(direction: tuple[float, float, float]) -> tuple[float, ...]:
    """Return a direction at unit length; scaled first, so that no square overflows."""
    scaled = [component / max(map(abs, direction)) for component in direction]
    length = hypot(*scaled)
    return tuple(component / length for component in scaled)


@inline
def light_direction(light: Any, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return (lx, ly, lz, end): the ray from a point along l reaches the light at the parameter `end`."""
    if light.parallel == 1:
        return -light.axis[0], -light.axis[1], -light.axis[2], math.inf
    return light.position[0] - x, light.position[1] - y, light.position[2] - z, 1.0


@inline
def light_share(light: Any, lx: float, ly: float, lz: float, distance: float) -> float:
    """Return the share of the intensity that arrives along unit -l from a distance: by falloff and the spot's cone."""
    result = 1.0
    if light.fades == 1:
        result = 1.0 / (distance * distance)
    if light.outer < math.inf:
        cosine = -dot(lx, ly, lz, light.axis[0], light.axis[1], light.axis[2])
        angle = acos(min(1.0, max(-1.0, cosine)))
        if angle > light.outer:
            result = 0.0
        elif angle > light.inner:
            s = (light.outer - angle) / (light.outer - light.inner)
            result *= s * s * (3.0 - 2.0 * s)
    return result
