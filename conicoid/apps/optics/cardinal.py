"""Focal lengths and principal planes, by real rays so near the axis that no aberration is left."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.hints import with_call_hints
from ..._util.validation import describe_kind
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike, is_scene
from .medium import D_LINE, check_wavelength
from .prescriptions import Prescription
from .ray_trace import follow, trace

Floats = npt.NDArray[np.float64]

_NEAR = 1e-4
"""The height of the rays, in diameters of the aperture. What is left of aberrations is of its fourth power."""
_PARALLEL = 1e-13


@dataclass(frozen=True)
class CardinalPoints:
    """What a lens is to rays near its axis; all places are z, in the frame of the scene.

    focal_length: the effective one, over 0 of what collects light, infinite of what is afocal.
    back_focal_length: from the last vertex to the rear focus, along the light. front_focal_length: from the first
    vertex to the front focus, below 0 where that lies in front. front_focus, rear_focus: the focal points.
    front_principal, rear_principal: the principal planes. wavelength: in μm.
    """

    focal_length: float
    back_focal_length: float
    front_focal_length: float
    front_focus: float
    rear_focus: float
    front_principal: float
    rear_principal: float
    wavelength: float


@dataclass(frozen=True)
class _Side:
    """Rays that came in parallel to the axis: f, where they meet it, the last vertex, and which way they went."""

    focal_length: float
    focus: float
    vertex: float
    way: float


@with_call_hints
def cardinal_points(system: Prescription | SceneLike, wavelength: Any = None) -> CardinalPoints:
    """Focal lengths, focal points and principal planes, by real rays.

    system: a `Prescription`, or a `Scene` of transparent and mirroring bodies about the z axis, finite, with light
    along +z. wavelength: in μm; the primary one of a prescription, the line d of a scene, where left out.
    Two rays near the axis from each side, at the heights h and 2 h; the error of both, which grows with h², is
    taken out. Raises ValueError where no ray near the axis gets through.
    """
    if not isinstance(system, Prescription) and not is_scene(system):
        raise TypeError(f"cardinal_points: system must be a Prescription or a Scene, got {describe_kind(system)}")
    default = system.wavelength if isinstance(system, Prescription) else D_LINE
    wave = default if wavelength is None else check_wavelength("cardinal_points", wavelength)
    front, rear = (_side(system, wave, backwards) for backwards in (True, False))
    f = rear.focal_length
    return CardinalPoints(
        f,
        (rear.focus - rear.vertex) * rear.way,
        front.focus - front.vertex,
        front.focus,
        rear.focus,
        front.focus - front.way * front.focal_length,
        rear.focus - rear.way * f,
        wave,
    )


@with_call_hints
def focal_length(system: Prescription | SceneLike, wavelength: Any = None) -> float:
    """The effective focal length: over 0 of what collects light, infinite of what is afocal.

    system: a `Prescription`, or a `Scene` about the z axis. wavelength: in μm. See `cardinal_points`, which has the
    back focal length and the principal planes as well.
    """
    return cardinal_points(system, wavelength).focal_length


def _side(system: Prescription | SceneLike, wave: float, backwards: bool) -> _Side:
    """Rays along the axis from one side: forwards, or backwards."""
    if isinstance(system, Prescription):
        return _of_prescription(system, wave, backwards)
    return _of_scene(system, wave, backwards)


def _of_prescription(system: Prescription, wave: float, backwards: bool) -> _Side:
    height, room = _NEAR * system.aperture, system.aperture
    rows = system.rows
    turns = sum(row.reflects for row in rows)
    way = 1.0
    start = min(0.0, float(system.scene.bounds[0][2])) - room if system.bodies else 0.0
    if backwards:
        way = -1.0 if turns % 2 == 0 else 1.0
        start = system.vertices[-1] - way * room
    rays = _parallel(height, start, way)
    found = trace(system, rays, wave, backwards=backwards)
    if not found.arrived.all():
        found = trace(system, rays, wave, obstructions=False, backwards=backwards)
    if not found.arrived.all():
        raise ValueError("cardinal_points: rays near the axis do not get through: rows must let them")
    return _extrapolate(found.rays, height, system.vertices[found.rows[-1] if found.rows else 0])


def _of_scene(scene: SceneLike, wave: float, backwards: bool) -> _Side:
    low, high = np.asarray(scene.bounds)
    if not np.isfinite([low, high]).all() or (low > high).any():
        raise ValueError("cardinal_points: system must be a scene of finite size, with bodies")
    size = float(np.max(high - low))
    height, way = _NEAR * size, -1.0 if backwards else 1.0
    start = float(high[2]) + size if backwards else float(low[2]) - size
    found = follow(scene, _parallel(height, start, way), wave)
    if not found.arrived.all() or len(found.points) < 2:
        raise ValueError("cardinal_points: rays near the z axis do not get through the scene")
    return _extrapolate(found.rays, height, _limit(found.points[-1, :, 2]))


def _parallel(height: float, start: float, way: float) -> Rays:
    """Rays at once and twice a height above the axis."""
    return Rays([(0.0, height, start), (0.0, 2 * height, start)], (0.0, 0.0, way))


def _extrapolate(rays: Rays, height: float, vertex: float) -> _Side:
    """What follows from two rays, of which the second comes in at twice the height of the first."""
    y, z = rays.origins[:, 1], rays.origins[:, 2]
    slope = rays.directions[:, 1] / np.abs(rays.directions[:, 2])
    way = math.copysign(1.0, float(rays.directions[0, 2]))
    if np.abs(slope).max() < _PARALLEL:
        return _Side(math.inf, math.nan, vertex, way)
    lengths = -np.array([height, 2 * height]) / slope
    foci = z - way * y / slope
    return _Side(_limit(lengths), _limit(foci), vertex, way)


def _limit(values: Floats) -> float:
    """The limit for h = 0 of what differs from it by a multiple of h², from its values at h and 2 h."""
    return float((4 * values[0] - values[1]) / 3)
