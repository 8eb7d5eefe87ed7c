"""Focal lengths and principal planes, by real rays so near the axis that aberrations vanish."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.dataclass import dataclass
from ..._util.validation import describe_kind
from ...materials.dispersion import LINE_D
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike, is_scene
from .medium import check_wavelength
from .prescriptions import Prescription
from .ray_trace import follow, trace

Floats = npt.NDArray[np.float64]

_NEAR = 1e-4
"""Height of the rays, in diameters of the aperture. The remaining error grows with its fourth power."""
_PARALLEL = 1e-13
"""Rays of lower slope count as parallel: the system is afocal."""


@dataclass(frozen=True)
class CardinalPoints:
    """Cardinal points of a lens system; all places are z in the frame of the scene.

    Parameters
    ----------
    focal_length : float
        The effective focal length: over 0 if the system collects light, infinite if it is afocal.
    back_focal_length : float
        From the last vertex to the rear focus, along the light.
    front_focal_length : float
        From the first vertex to the front focus, below 0 if that lies in front.
    front_focus, rear_focus : float
        The focal points.
    front_principal, rear_principal : float
        The principal planes.
    wavelength : float
        In μm.
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
    """Rays parallel to the axis from one side: f, their focus, the last vertex, and their final direction along z."""

    focal_length: float
    focus: float
    vertex: float
    way: float


def cardinal_points(system: Prescription | SceneLike, wavelength: float | None = None) -> CardinalPoints:
    """Compute focal lengths, focal points and principal planes, by real rays.

    Two rays near the axis come from each side, at the heights h and 2 h. Their error, which grows with h², is
    extrapolated to 0.

    Parameters
    ----------
    system : Prescription or Scene
        A scene must be finite, of transparent and mirroring bodies about the z axis, with light along +z.
    wavelength : float, optional
        In μm; the default is the primary one of a prescription, the line d of a scene.

    Returns
    -------
    CardinalPoints

    Raises
    ------
    ValueError
        If no ray near the axis gets through.
    """
    if not isinstance(system, Prescription) and not is_scene(system):
        raise TypeError(f"cardinal_points: system must be a Prescription or a Scene, got {describe_kind(system)}")
    default = system.wavelength if isinstance(system, Prescription) else LINE_D
    wave = default if wavelength is None else check_wavelength("cardinal_points", wavelength)
    # Light from behind gives the front focus, light from the front the rear focus.
    trace_side = _of_prescription if isinstance(system, Prescription) else _of_scene
    front, rear = (trace_side(system, wave, backwards) for backwards in (True, False))
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


def focal_length(system: Prescription | SceneLike, wavelength: float | None = None) -> float:
    """Compute the effective focal length; `cardinal_points` also has the back focal length and the principal planes.

    Parameters
    ----------
    system : Prescription or Scene
        A scene must be about the z axis.
    wavelength : float, optional
        In μm; the default is the primary one of a prescription, the line d of a scene.

    Returns
    -------
    float
        Over 0 if the system collects light, infinite if it is afocal.
    """
    return cardinal_points(system, wavelength).focal_length


def _of_prescription(system: Any, wave: float, backwards: bool) -> _Side:
    """Trace the two rays through a prescription."""
    height, room = _NEAR * system.aperture, system.aperture
    rows = system.rows
    reflections = sum(row.reflects for row in rows)
    way = 1.0
    # In front of all bodies, so that no ray starts inside of one.
    start = min(0.0, float(system.scene.bounds[0][2])) - room if system.bodies else 0.0
    if backwards:
        way = -1.0 if reflections % 2 == 0 else 1.0
        start = system.vertices[-1] - way * room
    rays = _parallel(height, start, way)
    traced = trace(system, rays, wave, backwards=backwards)
    if not traced.arrived.all():
        # A central obstruction, as in a telescope, stops rays near the axis: trace them without it.
        traced = trace(system, rays, wave, obstructions=False, backwards=backwards)
    if not traced.arrived.all():
        raise ValueError("cardinal_points: no ray near the axis gets through: rows must let one pass")
    return _extrapolate(traced.rays, height, system.vertices[traced.rows[-1] if traced.rows else 0])


def _of_scene(scene: Any, wave: float, backwards: bool) -> _Side:
    """Trace the two rays through a scene."""
    low, high = np.asarray(scene.bounds)
    if not np.isfinite([low, high]).all() or (low > high).any():
        raise ValueError("cardinal_points: system must be a scene of finite size, with bodies")
    size = float(np.max(high - low))
    height, way = _NEAR * size, -1.0 if backwards else 1.0
    # Outside of the scene, by its own size.
    start = float(high[2]) + size if backwards else float(low[2]) - size
    traced = follow(scene, _parallel(height, start, way), wave)
    if not traced.arrived.all() or len(traced.points) < 2:
        raise ValueError("cardinal_points: rays near the z axis do not get through the scene")
    return _extrapolate(traced.rays, height, _limit(traced.points[-1, :, 2]))


def _parallel(height: float, start: float, way: float) -> Rays:
    """Return rays at once and twice a height above the axis."""
    return Rays([(0.0, height, start), (0.0, 2 * height, start)], (0.0, 0.0, way))


def _extrapolate(rays: Rays, height: float, vertex: float) -> _Side:
    """Extrapolate from two rays at the heights h and 2 h to the height 0."""
    y, z = rays.origins[:, 1], rays.origins[:, 2]
    slope = rays.directions[:, 1] / np.abs(rays.directions[:, 2])
    way = math.copysign(1.0, float(rays.directions[0, 2]))
    if np.abs(slope).max() < _PARALLEL:
        return _Side(math.inf, math.nan, vertex, way)
    # f = -height / slope, for each ray.
    lengths = -np.array([height, 2 * height]) / slope
    foci = z - way * y / slope
    return _Side(_limit(lengths), _limit(foci), vertex, way)


def _limit(values: Floats) -> float:
    """Return the limit for h = 0 of a value with an error in h², from its values at h and 2 h."""
    return float((4 * values[0] - values[1]) / 3)
