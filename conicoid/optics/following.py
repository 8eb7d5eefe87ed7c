"""Rays through any scene: refracted, reflected or stopped by what the bodies are made of, without splitting."""

from __future__ import annotations

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
    """Which rays go on, and which of the others arrived."""

    going: Bools
    arrived: Bools = field(init=False)

    def __post_init__(self) -> None:
        self.arrived = np.ones(len(self.going), bool)


@explained
def follow(scene: Scene, rays: Rays, wavelength: Any = D_LINE, most: int = 100) -> Followed:
    """Follow rays until they leave a scene.

    A ray is refracted where it enters or leaves a transparent body, reflected by an opaque body that mirrors and in
    total reflection, and absorbed by any other. Where bodies overlap a transparent one counts before an opaque one,
    then the one listed first, as for `hits.before`.
    scene: of bodies with materials. rays: of any number. wavelength: in μm.
    most: of surfaces that a ray may meet, 1,000 at most; one that has not left by then has not arrived.
    Raises TypeError or ValueError for anything else.
    """
    if not isinstance(scene, Scene) or not isinstance(rays, Rays):
        raise TypeError(f"follow: scene must be a Scene and rays be Rays, got {what(scene)} and {what(rays)}")
    wave, most = check_wavelength("follow", wavelength), integer("follow", "most", most, 1, MOST_SURFACES)
    optics = [_Optics.of(scene.body(i).material or Material(), wave) for i in range(len(scene))]
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    n = len(rays.origins)
    state = _State(np.ones(n, bool))
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
