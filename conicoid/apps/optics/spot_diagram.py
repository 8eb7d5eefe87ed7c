"""Beams through a prescription: spots in the image plane, and ray fans."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..._util.dataclass import dataclass
from ..._util.text import check_choice
from ..._util.validation import check_integer, check_number, describe_kind
from ...queries.rays import Rays
from .medium import check_wavelength
from .prescriptions import Prescription
from .ray_trace import trace

Floats = npt.NDArray[np.float64]
MOST_RINGS = 1000
_INSIDE = 1 - 1e-9
"""Radius of the outermost rays, in radii of the pupil: a ray exactly on a rim would be undecided."""


@dataclass(frozen=True, eq=False)
class Spot:
    """A spot: the points of a beam in the image plane.

    Parameters
    ----------
    points : ndarray (n, 2)
        x and y of the rays that arrive.
    pupil : ndarray (n, 2)
        Their places in the entrance pupil, whose rim is at 1.
    wavelengths : ndarray (n,)
        In μm.
    vignetted : float
        Share of rays that did not arrive.
    field : float
        The field of the beam.
    """

    points: Floats
    pupil: Floats
    wavelengths: Floats
    vignetted: float
    field: float

    @property
    def centroid(self) -> Floats:
        """Mean of the points, (2,)."""
        return np.asarray(self.points.mean(axis=0))

    @property
    def rms(self) -> float:
        """Root mean square distance from the centroid."""
        return math.sqrt(float(((self.points - self.centroid) ** 2).sum(axis=1).mean()))

    @property
    def radius(self) -> float:
        """Greatest distance from the centroid."""
        return float(np.hypot(*(self.points - self.centroid).T).max())

    def __repr__(self) -> str:
        return f"Spot({len(self.points)} rays, rms {self.rms:.4g}, radius {self.radius:.4g}, field {self.field:g})"


@dataclass(frozen=True, eq=False)
class RayFan:
    """Transverse errors of a row of rays across the pupil.

    Parameters
    ----------
    pupil : ndarray (n,)
        Places in the pupil, from -1 to 1.
    error : ndarray (n, 2)
        x and y in the image plane, from the chief ray's; NaN of rays that do not arrive.
    axis, field, wavelength
        The arguments of `ray_fan`.
    """

    pupil: Floats
    error: Floats
    axis: str
    field: float
    wavelength: float


def beam(system: Prescription, field: float = 0.0, *, pupil: npt.ArrayLike) -> Rays:
    """Make the rays of one field through points of the entrance pupil.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis, or the height of a near object.
    pupil : array_like (n, 2)
        x and y in units of the pupil's radius.

    Returns
    -------
    Rays
        (n,)
    """
    angle = _field(system, "beam", field)
    disc = np.asarray(pupil, dtype=np.float64)
    if disc.ndim != 2 or disc.shape[1] != 2 or not np.isfinite(disc).all():
        raise ValueError(f"beam: pupil must be finite and of shape (n, 2), got shape {disc.shape}")
    # The points in the plane of the entrance pupil.
    through = np.column_stack([disc * (_INSIDE * system.aperture / 2), np.full(len(disc), system.pupil)])
    if not math.isinf(system.object_distance):
        start = np.array([0.0, angle, -system.object_distance])
        return Rays(np.broadcast_to(start, through.shape), through - start)
    slope = math.tan(math.radians(angle))
    way = np.array([0.0, slope, 1.0])
    low = float(system.scene.bounds[0][2]) if system.bodies else 0.0
    # Rays start in front of all bodies.
    first = min(0.0, low) - system.aperture
    way /= np.linalg.norm(way)
    return Rays(through - ((system.pupil - first) / way[2]) * way, way)


def rings(count: int) -> Floats:
    """Return points of a disc on equidistant rings, 6 k on the k-th, and the middle: (1 + 3 count (count + 1), 2)."""
    points = [np.zeros((1, 2))]
    for k in range(1, count + 1):
        # Odd rings are turned by half a step, so that rays do not line up.
        angles = 2 * math.pi * (np.arange(6 * k) + 0.5 * (k % 2)) / (6 * k)
        points.append(k / count * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.concatenate(points)


def spot(
    system: Prescription,
    field: float = 0.0,
    *,
    wavelength: float | Literal["all"] | None = None,
    count: int = 12,
    z: float | None = None,
) -> Spot:
    """Compute the spot of a field in the image plane.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis; of a near object its height.
    wavelength : float or "all", optional
        In μm; the default is the primary one. "all" is all of the prescription's.
    count : int
        Number of rings of rays in the pupil, with 6, 12, 18 ... rays.
    z : float, optional
        Of the plane; the default is that of the image.

    Returns
    -------
    Spot

    Raises
    ------
    ValueError
        If no ray arrives.
    """
    angle = _field(system, "spot", field)
    disc = rings(check_integer("spot", "count", count, 1, MOST_RINGS))
    plane = system.image if z is None else check_number("spot", "z", z)
    waves = system.wavelengths if isinstance(wavelength, str) and wavelength == "all" else (wavelength,)
    rays = beam(system, angle, pupil=disc)
    points, places, colours = [], [], []
    for choice in waves:
        wave = system.wavelength if choice is None else check_wavelength("spot", choice)
        traced = trace(system, rays, wave)
        points.append(traced.at(plane)[traced.arrived, :2])
        places.append(disc[traced.arrived])
        colours.append(np.full(len(points[-1]), wave))
    arrived = np.concatenate(points)
    if not len(arrived):
        raise ValueError(f"spot: field must be one with a ray that arrives, got {angle:g}")
    # Over all wavelengths.
    lost = 1 - len(arrived) / (len(disc) * len(waves))
    return Spot(arrived, np.concatenate(places), np.concatenate(colours), lost, angle)


def ray_fan(
    system: Prescription,
    field: float = 0.0,
    *,
    axis: Literal["x", "y"] = "y",
    wavelength: float | None = None,
    count: int = 41,
) -> RayFan:
    """Compute transverse ray errors across the pupil.

    Errors are those from the chief ray, the one through the pupil's middle. If that is obstructed, as in a telescope,
    it is traced without the obstruction.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis; of a near object its height.
    axis : {"y", "x"}
        "y" is the fan in the plane of the field, "x" the one across it.
    wavelength : float, optional
        In μm; the default is the primary one.
    count : int
        Number of rays.

    Returns
    -------
    RayFan
    """
    angle = _field(system, "ray_fan", field)
    across = check_choice("ray_fan", "axis", axis, ("x", "y"))
    number_of = check_integer("ray_fan", "count", count, 2, 100_000)
    wave = system.wavelength if wavelength is None else check_wavelength("ray_fan", wavelength)
    line = np.linspace(-1, 1, number_of)
    disc = np.zeros((number_of + 1, 2))
    # Ray 0 is the chief ray, through the middle of the pupil.
    disc[1:, "xy".index(across)] = line
    rays = beam(system, angle, pupil=disc)
    points = trace(system, rays, wave).at(system.image)[1:, :2]
    chief = trace(system, rays[:1], wave, obstructions=False).at(system.image)[0, :2]
    return RayFan(line, points - chief, across, angle, wave)


def _field(system: Any, owner: str, field: Any) -> float:
    """Check the system and the field. Return the field."""
    if not isinstance(system, Prescription):
        raise TypeError(f"{owner}: system must be a Prescription, got {describe_kind(system)}")
    angle = check_number(owner, "field", field)
    if math.isinf(system.object_distance) and abs(angle) >= 90:
        raise ValueError(f"{owner}: field must be below 90 degrees, got {angle:g}")
    return angle
