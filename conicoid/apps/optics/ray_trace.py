"""Rays through a prescription, surface by surface, through the scene's own bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.hints import with_call_hints
from ..._util.text import format_count
from ..._util.validation import check_integer, describe_kind
from ...materials.material import Material
from ...queries.extensions import extension
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike, is_scene
from .interface import material_index
from .medium import D_LINE, check_wavelength
from .prescriptions import Prescription, row_sheet
from .refraction import reflect, refract

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
        rays = format_count(len(self.arrived), "ray", "rays")
        return (
            f"Trace({int(self.arrived.sum()):,} of {rays} arrived, "
            f"{format_count(len(self.rows), 'surface', 'surfaces')})"
        )

    def at(self, z: float) -> Floats:
        """Where the rays, which leave the last surface, meet the plane of a height `z`: (n, 3), NaN if lost."""
        origins, ways = self.rays.origins, self.rays.directions
        with np.errstate(divide="ignore", invalid="ignore"):
            found = origins + ((z - origins[:, 2]) / ways[:, 2])[:, None] * ways
        found[~self.arrived] = np.nan
        return np.asarray(found)


@with_call_hints
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
        raise TypeError(
            "trace: system must be a Prescription and rays be Rays, got "
            f"{describe_kind(system)} and {describe_kind(rays)}"
        )
    wave = system.wavelength if wavelength is None else check_wavelength("trace", wavelength)
    order = [i for i, faces in enumerate(system.elements.faces) if faces]
    order = order[::-1] if backwards else order
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    arrived, path = np.ones(len(rays.origins), bool), np.zeros(len(rays.origins))
    points = [rays.origins]
    for i in order:
        met = _RowHits.of(system, i, rays, obstructions)
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
class _RowHits:
    """The first hits of rays, and which of them are those of the surface that they were sent to."""

    hits: Any
    wanted: Bools

    @classmethod
    def of(cls, system: Prescription, i: int, rays: Rays, obstructions: bool) -> _RowHits:
        """The hits on the surface of row i."""
        if not obstructions:
            hits = _hit_of_row(system, i).first_hit(rays.origins, rays.directions)
            return cls(hits, np.asarray(hits.hit))
        hits = system.scene.first_hit(rays)
        wanted = _hit_of_scene(hits, system.elements.faces[i])
        row = system.rows[i]
        if row.stop and row.diameter is not None:
            wanted &= np.hypot(hits.point[:, 0], hits.point[:, 1]) <= row.diameter / 2
        return cls(hits, wanted)


def _hit_of_scene(hits: Any, faces: Sequence[tuple[int, int]]) -> Bools:
    """Whether hits are on one of some faces of bodies."""
    found = np.zeros(hits.shape, bool)
    for body, face in faces:
        found |= (hits.body == body) & (hits.face == face)
    return found


def _hit_of_row(system: Prescription, i: int) -> SceneLike:
    """The surface of row i as a scene of its own, made once."""
    known: dict[int, SceneLike] = vars(system).setdefault("_surfaces", {})
    if i not in known:
        known[i] = extension("Scene")([row_sheet(system, i, whole=True)])
    return known[i]


# Rays through any scene: refracted, reflected or stopped by what the bodies are made of, without splitting.

RayFloats = npt.NDArray[np.float64]
RayBools = npt.NDArray[np.bool_]
MOST_SURFACES = 1000


@dataclass(eq=False)
class Followed:
    """Rays that left a scene.

    points: (met + 1, n, 3), where they started and what they met; of rays that left earlier the last one repeated.
    rays: (n,), as they leave. arrived: (n,), False where a ray was absorbed or does not come to an end.
    """

    points: RayFloats
    rays: Rays
    arrived: RayBools

    def __repr__(self) -> str:
        met = format_count(len(self.points) - 1, "wall", "walls")
        rays = format_count(len(self.arrived), "ray", "rays")
        return f"Followed({int(self.arrived.sum()):,} of {rays} left, {met} met at most)"


@dataclass(eq=False)
class _RayState:
    """Which rays go on, and which of the others arrived."""

    going: RayBools
    arrived: RayBools = field(init=False)

    def __post_init__(self) -> None:
        self.arrived = np.ones(len(self.going), bool)


@with_call_hints
def follow(scene: SceneLike, rays: Rays, wavelength: Any = D_LINE, most: int = 100) -> Followed:
    """Follow rays until they leave a scene.

    A ray is refracted where it enters or leaves a transparent body, reflected by an opaque body that mirrors and in
    total reflection, and absorbed by any other. Where bodies overlap a transparent one counts before an opaque one,
    then the one listed first, as for `hits.before`.
    scene: of bodies with materials. rays: of any number. wavelength: in μm.
    most: of surfaces that a ray may meet, 1,000 at most; one that has not left by then has not arrived.
    Raises TypeError or ValueError for anything else.
    """
    if not is_scene(scene) or not isinstance(rays, Rays):
        raise TypeError(
            f"follow: scene must be a Scene and rays be Rays, got {describe_kind(scene)} and {describe_kind(rays)}"
        )
    wave, most = check_wavelength("follow", wavelength), check_integer("follow", "most", most, 1, MOST_SURFACES)
    optics = [_WallOptics.of(scene.body(i).material or Material(), wave) for i in range(len(scene))]
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    n = len(rays.origins)
    state = _RayState(np.ones(n, bool))
    points, last = [rays.origins], [rays.origins.copy(), rays.directions.copy()]
    for _ in range(most):
        hits = scene.first_hit(rays)
        gone = state.going & ~np.asarray(hits.hit)
        for kept, now in zip(last, rays, strict=True):
            kept[gone] = now[gone]
        met = state.going = state.going & ~gone
        if not met.any():
            break
        points.append(np.where(met[:, None], hits.point, points[-1]))
        rays = hits.spawn(_turn_rays(scene, rays, hits, state, optics))
    state.arrived &= ~state.going
    return Followed(np.stack(points), Rays(*last), state.arrived)


@dataclass(frozen=True)
class _WallOptics:
    """What a body does with light."""

    clear: bool
    mirrors: bool
    index: float

    @classmethod
    def of(cls, material: Material, wavelength: float) -> _WallOptics:
        clear = bool(np.max(np.asarray(_amount(material.transparency))) > 0)
        mirrors = bool(np.max(np.asarray(_amount(material.reflectivity))) > 0) or material.metal_index is not None
        if not clear:
            return cls(False, mirrors, 1.0)
        return cls(True, False, float(np.real(material_index(material, wavelength))))


def _amount(value: Any) -> Any:
    """A number, or the numbers of a colour."""
    return value if isinstance(value, float | int) else tuple(value)


def _turn_rays(scene: SceneLike, rays: Rays, hits: Any, state: _RayState, optics: list[_WallOptics]) -> RayFloats:
    """The directions in which rays go on."""
    indices = np.array([*(one.index for one in optics), 1.0])  # the last, -1, is that of none
    clear, mirrors = np.array([one.clear for one in optics]), np.array([one.mirrors for one in optics])
    body = np.where(hits.hit, hits.body, 0)
    dark = state.going & ~clear[body] & ~mirrors[body]
    state.going &= ~dark
    state.arrived &= ~dark
    before, behind = indices[hits.before], indices[hits.after]
    with np.errstate(invalid="ignore"):
        mirrored = reflect(rays.directions, hits.normal)
        bent, total = refract(rays.directions, hits.normal, before / behind)
    back = mirrors[body] | total
    pane = np.array([scene.body(i).shape.is_sheet for i in range(len(scene))])[body] & clear[body]
    ways = np.where(back[:, None], mirrored, np.where(pane[:, None], rays.directions, bent))
    return np.where(state.going[:, None], ways, rays.directions)
