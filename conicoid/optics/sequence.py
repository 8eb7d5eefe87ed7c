"""Rays through a prescription, surface by surface, through the scene's own bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine.answers.rays import Rays
from ..scene import Scene
from ..shading.optics import reflect, refract
from ..shapes.calls import explained
from ..shapes.labels import counted
from ..shapes.validate import what
from .elements import sheet_of
from .prescriptions import Prescription
from .row_media import check_wavelength

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Trace:
    """Rays that went through a prescription.

    points: (surfaces + 1, n, 3), where each ray started and where it met the surfaces; NaN from where it was lost.
    rays: (n,), as they leave the last surface. arrived: (n,), whether a ray met all surfaces, in order and nothing
    else. optical_path: (n,), Σ index × length from the start to the last surface. rows: the rows that were met.
    """

    points: Floats
    rays: Rays
    arrived: Bools
    optical_path: Floats
    rows: tuple[int, ...]

    def __repr__(self) -> str:
        rays = counted(len(self.arrived), "ray", "rays")
        return f"Trace({int(self.arrived.sum()):,} of {rays} arrived, {counted(len(self.rows), 'surface', 'surfaces')})"

    def at(self, z: float) -> Floats:
        """Where the rays, which leave the last surface, meet the plane of a height `z`: (n, 3), NaN if lost."""
        origins, ways = self.rays.origins, self.rays.directions
        with np.errstate(divide="ignore", invalid="ignore"):
            found = origins + ((z - origins[:, 2]) / ways[:, 2])[:, None] * ways
        found[~self.arrived] = np.nan
        return np.asarray(found)


@explained
def trace(
    system: Prescription, rays: Rays, wavelength: Any = None, *, obstructions: bool = True, backwards: bool = False
) -> Trace:
    """Send rays through all surfaces of a prescription, in their order.

    system: a `Prescription`. rays: (n,), before the first surface, or `backwards` behind the last one.
    wavelength: in μm, the primary one if None. obstructions: whether rays are lost that meet a stop's screen, an edge
    or another lens or mirror on their way; if False, each surface alone is met, without holes.
    Totally reflected rays are lost. Raises TypeError or ValueError for anything else.
    """
    if not isinstance(system, Prescription) or not isinstance(rays, Rays):
        raise TypeError(f"trace: system must be a Prescription and rays be Rays, got {what(system)} and {what(rays)}")
    wave = system.wavelength if wavelength is None else check_wavelength("trace", wavelength)
    order = [i for i, faces in enumerate(system.elements.faces) if faces]
    order = order[::-1] if backwards else order
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    arrived, path = np.ones(len(rays.origins), bool), np.zeros(len(rays.origins))
    points = [rays.origins]
    for i in order:
        met = _Met.of(system, i, rays, obstructions)
        arrived &= met.wanted
        before, behind = system.media[i].index(wave), system.media[i + 1].index(wave)
        before, behind = (behind, before) if backwards else (before, behind)
        path += before * met.hits.t * np.linalg.norm(rays.directions, axis=1)
        if system.rows[i].reflects:
            ways = reflect(rays.directions, met.hits.normal)
        else:
            ways, total = refract(rays.directions, met.hits.normal, before / behind)
            arrived &= ~total
        rays = met.hits.spawn(ways)
        points.append(np.where(arrived[:, None], met.hits.point, np.nan))
    path[~arrived] = math.nan
    return Trace(np.stack(points), rays, arrived, path, tuple(order))


@dataclass(frozen=True, eq=False)
class _Met:
    """The first hits of rays, and which of them are those of the surface that they were sent to."""

    hits: Any
    wanted: Bools

    @classmethod
    def of(cls, system: Prescription, i: int, rays: Rays, obstructions: bool) -> _Met:
        """The hits on the surface of row i."""
        if not obstructions:
            hits = _alone(system, i).first_hit(rays.origins, rays.directions)
            return cls(hits, np.asarray(hits.hit))
        hits = system.scene.first_hit(rays)
        wanted = _among(hits, system.elements.faces[i])
        row = system.rows[i]
        if row.stop and row.diameter is not None:
            wanted &= np.hypot(hits.point[:, 0], hits.point[:, 1]) <= row.diameter / 2
        return cls(hits, wanted)


def _among(hits: Any, faces: Sequence[tuple[int, int]]) -> Bools:
    """Whether hits are on one of some faces of bodies."""
    found = np.zeros(hits.shape, bool)
    for body, face in faces:
        found |= (hits.body == body) & (hits.face == face)
    return found


def _alone(system: Prescription, i: int) -> Scene:
    """The surface of row i as a scene of its own, made once."""
    known: dict[int, Scene] = vars(system).setdefault("_surfaces", {})
    if i not in known:
        known[i] = Scene([sheet_of(system, i, whole=True)])
    return known[i]
