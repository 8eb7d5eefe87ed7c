"""Rays through any scene: refracted, reflected or stopped by what the bodies are made of, without splitting."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine.answers.rays import Rays
from ..scene import Scene
from ..shading.optics import reflect, refract
from ..shapes.calls import explained
from ..shapes.labels import counted
from ..shapes.material import Material
from ..shapes.validate import integer, what
from .media import index_of
from .row_media import D_LINE, check_wavelength

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
MOST_SURFACES = 1000
_BODIES = 4096


@dataclass(eq=False)
class Followed:
    """Rays that left a scene.

    points: (met + 1, n, 3), where they started and what they met; of rays that left earlier the last one repeated.
    rays: (n,), as they leave. arrived: (n,), False where a ray was absorbed or does not come to an end.
    """

    points: Floats
    rays: Rays
    arrived: Bools

    def __repr__(self) -> str:
        met = counted(len(self.points) - 1, "wall", "walls")
        rays = counted(len(self.arrived), "ray", "rays")
        return f"Followed({int(self.arrived.sum()):,} of {rays} left, {met} met at most)"


@dataclass(eq=False)
class _State:
    """Where rays are: inside of which bodies, and which of them go on."""

    inside: Bools
    going: Bools
    arrived: Bools = field(init=False)

    def __post_init__(self) -> None:
        self.arrived = np.ones(len(self.going), bool)


@explained
def follow(scene: Scene, rays: Rays, wavelength: Any = D_LINE, most: int = 100) -> Followed:
    """Follow rays until they leave a scene.

    A ray is refracted where it enters or leaves a transparent body (where bodies overlap, the one listed first
    counts), reflected by an opaque body that mirrors and in total reflection, and absorbed by any other.
    scene: of bodies with materials. rays: of any number. wavelength: in μm.
    most: of surfaces that a ray may meet, 1,000 at most; one that has not left by then has not arrived.
    Raises TypeError or ValueError for anything else.
    """
    if not isinstance(scene, Scene) or not isinstance(rays, Rays):
        raise TypeError(f"follow: scene must be a Scene and rays be Rays, got {what(scene)} and {what(rays)}")
    wave, most = check_wavelength("follow", wavelength), integer("follow", "most", most, 1, MOST_SURFACES)
    if len(scene) > _BODIES:
        raise ValueError(f"follow: scene must have {_BODIES:,} bodies at most, got {len(scene):,}")
    optics = [_Optics.of(scene.body(i).material or Material(), wave) for i in range(len(scene))]
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    n = len(rays.origins)
    state = _State(_containing(scene, rays.origins), np.ones(n, bool))
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
        rays = hits.spawn(_turned(scene, rays, hits, state, optics))
    state.arrived &= ~state.going
    return Followed(np.stack(points), Rays(*last), state.arrived)


def _containing(scene: Scene, points: Floats) -> Bools:
    """(points, bodies): which solids hold the point that a ray starts at: the first one that does."""
    found = np.zeros((len(points), max(1, len(scene))), bool)
    body = np.asarray(scene.body_at(points))
    found[np.flatnonzero(body >= 0), body[body >= 0]] = True
    return found


@dataclass(frozen=True)
class _Optics:
    """What a body does with light."""

    clear: bool
    mirrors: bool
    index: float

    @classmethod
    def of(cls, material: Material, wavelength: float) -> _Optics:
        clear = bool(np.max(np.asarray(_amount(material.transparency))) > 0)
        mirrors = bool(np.max(np.asarray(_amount(material.reflectivity))) > 0) or material.metal_index is not None
        if not clear:
            return cls(False, mirrors, 1.0)
        return cls(True, False, float(np.real(index_of(material, wavelength))))


def _amount(value: Any) -> Any:
    """A number, or the numbers of a colour."""
    return value if isinstance(value, float | int) else tuple(value)


def _turned(scene: Scene, rays: Rays, hits: Any, state: _State, optics: list[_Optics]) -> Floats:
    """The directions in which rays go on, and what they are inside of then."""
    indices = np.array([one.index for one in optics])
    clear, mirrors = np.array([one.clear for one in optics]), np.array([one.mirrors for one in optics])
    body = np.where(hits.hit, hits.body, 0)
    dark = state.going & ~clear[body] & ~mirrors[body]
    state.going &= ~dark
    state.arrived &= ~dark
    crossed = _crossed(scene, rays, hits, state.inside)
    before, behind = _index(state.inside, indices), _index(crossed, indices)
    with np.errstate(invalid="ignore"):
        mirrored = reflect(rays.directions, hits.normal)
        bent, total = refract(rays.directions, hits.normal, before / behind)
    back = mirrors[body] | total
    pane = np.array([scene.body(i).shape.is_sheet for i in range(len(scene))])[body] & clear[body]
    state.inside = np.where((state.going & ~back & ~pane)[:, None], crossed, state.inside)
    ways = np.where(back[:, None], mirrored, np.where(pane[:, None], rays.directions, bent))
    return np.where(state.going[:, None], ways, rays.directions)


def _crossed(scene: Scene, rays: Rays, hits: Any, inside: Bools) -> Bools:
    """What rays are inside of beyond the first wall: all bodies with a wall at the same t change."""
    found = inside.copy()
    near = np.where(hits.hit, np.nextafter(hits.t, math.inf), 0.0)
    walls = scene.crossings(rays, t_max=near)
    ray = np.repeat(np.arange(len(near)), np.diff(walls.offsets))
    here = walls.t == np.asarray(hits.t)[ray]
    found[ray[here], walls.body[here]] = walls.entering[here]
    return found


def _index(inside: Bools, indices: Floats) -> Floats:
    """The index of the first body that a ray is in, 1 in none."""
    first = inside.argmax(axis=1)
    return np.where(inside.any(axis=1), indices[first], 1.0)
