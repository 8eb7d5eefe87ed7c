"""Beams through a prescription: spots in the image plane, and ray fans."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.hints import check_choice, with_call_hints
from ..._util.validation import check_integer, check_number, describe_kind
from ...queries.rays import Rays
from .medium import check_wavelength
from .prescriptions import Prescription
from .ray_trace import trace

Floats = npt.NDArray[np.float64]
MOST_RINGS = 1000
_INSIDE = 1 - 1e-9
"""Rays at the rim of the pupil go by so much inside of it: what a rim does to a ray upon it is nobody's question."""


@dataclass(frozen=True, eq=False)
class Spot:
    """Where a beam meets the image plane.

    points: (n, 2) x and y of the rays that arrive. pupil: (n, 2) where they went through the entrance pupil, whose
    rim is at 1. wavelengths: (n,) in μm. centroid: (2,). rms: the root mean square distance from the centroid.
    radius: the greatest. vignetted: the share of rays that did not arrive. field: as it was asked for.
    """

    points: Floats
    pupil: Floats
    wavelengths: Floats
    vignetted: float
    field: float

    @property
    def centroid(self) -> Floats:
        """The mean of the points."""
        return np.asarray(self.points.mean(axis=0))

    @property
    def rms(self) -> float:
        """The root of the mean squared distance from the centroid."""
        return math.sqrt(float(((self.points - self.centroid) ** 2).sum(axis=1).mean()))

    @property
    def radius(self) -> float:
        """The greatest distance from the centroid."""
        return float(np.hypot(*(self.points - self.centroid).T).max())

    def __repr__(self) -> str:
        return f"Spot({len(self.points)} rays, rms {self.rms:.4g}, radius {self.radius:.4g}, field {self.field:g})"


@dataclass(frozen=True, eq=False)
class RayFan:
    """Transverse errors of a row of rays across the pupil.

    pupil: (n,) from -1 to 1. error: (n, 2) x and y in the image plane, from the chief ray's; NaN of rays that do not
    arrive. axis, field, wavelength: as asked for.
    """

    pupil: Floats
    error: Floats
    axis: str
    field: float
    wavelength: float


@with_call_hints
def beam(system: Prescription, field: Any = 0.0, *, pupil: Any) -> Rays:
    """Rays of one field through points of the entrance pupil.

    system: a `Prescription`. field: degrees off the axis, or the height of a near object.
    pupil: (n, 2), x and y in units of the pupil's radius.
    """
    angle = _field(system, "beam", field)
    disc = np.asarray(pupil, dtype=np.float64)
    if disc.ndim != 2 or disc.shape[1] != 2 or not np.isfinite(disc).all():
        raise ValueError(f"beam: pupil must be finite and of shape (n, 2), got shape {disc.shape}")
    through = np.column_stack([disc * (_INSIDE * system.aperture / 2), np.full(len(disc), system.pupil)])
    if not math.isinf(system.object_distance):
        start = np.array([0.0, angle, -system.object_distance])
        return Rays(np.broadcast_to(start, through.shape), through - start)
    slope = math.tan(math.radians(angle))
    way = np.array([0.0, slope, 1.0])
    low = float(system.scene.bounds[0][2]) if system.bodies else 0.0
    first = min(0.0, low) - system.aperture
    way /= np.linalg.norm(way)
    return Rays(through - ((system.pupil - first) / way[2]) * way, way)


def rings(count: int) -> Floats:
    """Points of a disc on rings of equal distances, 6 k on the k-th, and the middle: (1 + 3 count (count + 1), 2)."""
    points = [np.zeros((1, 2))]
    for k in range(1, count + 1):
        angles = 2 * math.pi * (np.arange(6 * k) + 0.5 * (k % 2)) / (6 * k)
        points.append(k / count * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.concatenate(points)


@with_call_hints
def spot(system: Prescription, field: Any = 0.0, *, wavelength: Any = None, count: Any = 12, z: Any = None) -> Spot:
    """The spot of a field in the image plane.

    system: a `Prescription`. field: degrees off the axis; of a near object its height.
    wavelength: in μm, the primary one where left out, or "all" of the prescription's.
    count: of rings of rays in the pupil, `rings` of 6, 12, 18 ... z: of the plane, that of the image where left out.
    Raises ValueError where no ray arrives.
    """
    angle = _field(system, "spot", field)
    disc = rings(check_integer("spot", "count", count, 1, MOST_RINGS))
    plane = system.image if z is None else check_number("spot", "z", z)
    waves = system.wavelengths if isinstance(wavelength, str) and wavelength == "all" else (wavelength,)
    rays = beam(system, angle, pupil=disc)
    points, where, colours = [], [], []
    for given in waves:
        wave = system.wavelength if given is None else check_wavelength("spot", given)
        found = trace(system, rays, wave)
        points.append(found.at(plane)[found.arrived, :2])
        where.append(disc[found.arrived])
        colours.append(np.full(len(points[-1]), wave))
    arrived = np.concatenate(points)
    if not len(arrived):
        raise ValueError(f"spot: field must be one of which a ray arrives, got {angle:g}")
    lost = 1 - len(arrived) / (len(disc) * len(waves))
    return Spot(arrived, np.concatenate(where), np.concatenate(colours), lost, angle)


@with_call_hints
def ray_fan(
    system: Prescription, field: Any = 0.0, *, axis: Any = "y", wavelength: Any = None, count: Any = 41
) -> RayFan:
    """Transverse ray errors across the pupil.

    system: a `Prescription`. field: degrees off the axis; of a near object its height.
    axis: "y", the fan in the plane of the field, or "x", the one across it. wavelength: in μm. count: of rays.
    Errors are those from the chief ray, the one through the pupil's middle; where that is obstructed, as in a
    telescope, from where it would go.
    """
    angle = _field(system, "ray_fan", field)
    across = check_choice("ray_fan", "axis", axis, ("x", "y"))
    number_of = check_integer("ray_fan", "count", count, 2, 100_000)
    wave = system.wavelength if wavelength is None else check_wavelength("ray_fan", wavelength)
    line = np.linspace(-1, 1, number_of)
    disc = np.zeros((number_of + 1, 2))
    disc[1:, "xy".index(across)] = line
    rays = beam(system, angle, pupil=disc)
    found = trace(system, rays, wave).at(system.image)[1:, :2]
    chief = trace(system, rays[:1], wave, obstructions=False).at(system.image)[0, :2]
    return RayFan(line, found - chief, across, angle, wave)


def _field(system: Any, owner: str, field: Any) -> float:
    """Check the system and the field."""
    if not isinstance(system, Prescription):
        told = (
            "co.optics.prescription(rows) makes one" if not isinstance(system, str) else "co.optics.load_zmx reads it"
        )
        raise TypeError(f"{owner}: system must be a Prescription, got {describe_kind(system)}; {told}")
    angle = check_number(owner, "field", field)
    if math.isinf(system.object_distance) and abs(angle) >= 90:
        raise ValueError(f"{owner}: field must be below 90 degrees, got {angle:g}")
    return angle
