"""The classes that need Optiland: a tracer backend, and a geometry that is a Conicoid solid.

All light is Optiland's (sources, Fresnel's splitting, scatter, detectors). One Conicoid scene finds the first surface
of a ray, through its tree, without an epsilon: a ray knows the surface that it starts on.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from optiland.nonsequential.backends.numpy_backend import NumpyBackend
from optiland.nonsequential.components.base import _get_transform
from optiland.nonsequential.components.geometry.analytic.annulus import AnnularPlaneGeometry
from optiland.nonsequential.components.geometry.analytic.conic import ConicGeometry
from optiland.nonsequential.components.geometry.analytic.frustum import CylindricalFrustumGeometry
from optiland.nonsequential.components.geometry.analytic.plane import FinitePlaneGeometry
from optiland.nonsequential.components.geometry.analytic.sphere import SphereGeometry
from optiland.nonsequential.components.geometry.base import AABB

from ..._util.validation import describe_kind
from ...geometry.body import Body
from ...geometry.conic import ConicSheet, Stop
from ...geometry.primitives import Cone, Sphere
from ...geometry.shape import Shape, Solid
from ...geometry.sheets import Polygon, Wall
from ...queries.rays import Rays
from ...queries.result import extension

Floats = npt.NDArray[np.float64]
HitArrays = tuple[Floats, Floats, npt.NDArray[np.int32], Floats]

_GAP = 1e-9
"""Optiland's tolerance for the start of a ray, in mm; here for rays without a known start surface."""


class SolidGeometry(SphereGeometry):
    """A Conicoid solid as a geometry of Optiland, in the component's own frame: any Boolean, any quadric.

    Optiland's `Volume.intersection` and `difference` refuse Booleans; here ``a & b`` and ``a - b`` are traced. It also
    works with Optiland's own backends, which call it ray by ray. In front of its walls is the outside: `material_front`
    of a component surrounds the solid, `material_back` is inside. In Optiland's own records it is the ball around it.

    Parameters
    ----------
    shape : Solid
        Of finite size.
    """

    def __init__(self, shape: Solid) -> None:
        if not isinstance(shape, Solid):
            raise TypeError(f"optiland_component: solid must be a solid, got {describe_kind(shape)}")
        low, high = shape.bounds
        if not np.isfinite([low, high]).all() or (low > high).any():
            raise ValueError("optiland_component: solid must be of finite size and not empty")
        super().__init__(radius=float(np.linalg.norm(np.maximum(abs(low), abs(high)))))
        self.shape, self._scene = shape, extension("Scene")([shape])

    def ray_intersect(self, origins: Any, directions: Any) -> tuple[Any, Any, Any, Any]:
        """Return distances, normals towards the rays, mask of hits, and inward normals; in the component's frame.

        Parameters
        ----------
        origins, directions : array_like (n, 3)
            Directions of unit length.
        """
        # Optiland gives no start surface here, so rays begin at its tolerance.
        hits = self._scene.first_hit(np.asarray(origins), np.asarray(directions), t_min=_GAP)
        outward = np.where(hits.hit[:, None], hits.normal, 0.0)
        return hits.t, _facing(outward, directions), hits.hit, -outward

    def bounding_box(self, transform: Any) -> Any:
        """Return the box around the solid, moved by a `transform` (translation, rotation)."""
        low, high = self.shape.transform(_matrix(transform)).bounds
        return AABB(low, high)


class Backend(NumpyBackend):
    """A `TracerBackend` of Optiland's: ``scene.trace(rays, backend=co.optics.OptilandBackend(seed=1))``.

    Conicoid traces conics, planes within a circle or a rectangle, rings, cylindrical and conical edges, balls and
    `SolidGeometry`. Optiland itself traces anything else (meshes), and the nearer hit counts.

    Parameters
    ----------
    seed : int, optional
        Of Optiland's random numbers.
    """

    def __init__(self, seed: int | None = None) -> None:
        super().__init__(seed)
        self._cache: _ShapeCache | None = None
        self._start = _StartSurfaces()

    def trace(self, scene: Any, *arguments: Any, **keywords: Any) -> Any:
        """Run Optiland's simulation of a `scene`; `arguments` and `keywords` are those of Optiland's backends."""
        # Ray numbers begin anew with each simulation.
        self._cache, self._start = None, _StartSurfaces()
        return super().trace(scene, *arguments, **keywords)

    def intersect_scene(self, rays: Any, components: list[Any]) -> HitArrays:
        """Return the nearest hit of each ray: distance, normal towards the ray, component number, front-to-back normal.

        Parameters
        ----------
        rays
            A bundle of Optiland.
        components : list
            The components of its scene.
        """
        cache = self._cache
        if cache is None or cache.components != components:
            cache = self._cache = _ShapeCache(components)
        t, facing, which, geometric = self._of_conicoid(rays, cache)
        # Components without a Conicoid shape: a nearer hit of Optiland replaces ours.
        for i in cache.other_components:
            distance, normals, hit, across = components[i].intersect(rays)
            nearer = hit & (distance < t)
            t, which = np.where(nearer, distance, t), np.where(nearer, i, which).astype(np.int32)
            facing = np.where(nearer[:, None], normals, facing)
            geometric = np.where(nearer[:, None], across, geometric)
        return t, facing, which, geometric

    def _of_conicoid(self, rays: Any, cache: _ShapeCache) -> HitArrays:
        """Return the nearest hits among the components that Conicoid traces."""
        origins = np.stack([rays.x, rays.y, rays.z], axis=1)
        directions = np.stack([rays.L, rays.M, rays.N], axis=1)
        starts = self._start.of(rays.ray_id, origins)
        bundle = Rays._spawned(origins, directions, starts, cache.home)
        # A known start surface needs no tolerance.
        hits = cache.scene.first_hit(bundle, t_min=np.where(starts < 0, _GAP, 0.0))
        hit = hits.hit & np.asarray(rays.alive)
        normals = np.where(hit[:, None], hits.normal, 0.0)
        body = np.where(hit, hits.body, 0)
        t = np.where(hit, hits.t, np.inf)
        self._start.keep(rays.ray_id, hit, hits.surface, origins + np.where(hit, t, 0.0)[:, None] * directions)
        geometric = cache.senses[body][:, None] * normals
        which = np.where(hit, cache.numbers[body], -1).astype(np.int32)
        return t, _facing(normals, directions), which, geometric


class _StartSurfaces:
    """For each ray number, its last hit: surface and point."""

    def __init__(self) -> None:
        self.surfaces: npt.NDArray[np.int32] = np.zeros(0, np.int32)
        self.points: Floats = np.zeros((0, 3))

    def of(self, ids: Any, origins: Floats) -> npt.NDArray[np.int32]:
        """Return the start surfaces of rays: those of their last hit, if they start there; -1 for none."""
        if ids is None:
            return np.full(len(origins), -1, np.int32)
        self._grow(int(ids.max(initial=-1)) + 1)
        # A ray that does not start at its last hit has no start surface.
        there = np.abs(self.points[ids] - origins).max(axis=1) <= _GAP * (1 + np.abs(origins).max(axis=1))
        return np.where(there, self.surfaces[ids], -1).astype(np.int32)

    def keep(self, ids: Any, hit: Any, surfaces: Any, points: Floats) -> None:
        """Store the hits of rays."""
        if ids is not None:
            self.surfaces[ids], self.points[ids] = np.where(hit, surfaces, -1), points

    def _grow(self, size: int) -> None:
        """Make room for ray numbers below `size`; at least double, so that many rounds stay cheap."""
        more = size - len(self.surfaces)
        if more > 0:
            more = max(more, len(self.surfaces))
            self.surfaces = np.concatenate([self.surfaces, np.full(more, -1, np.int32)])
            self.points = np.concatenate([self.points, np.full((more, 3), np.nan)])


class _ShapeCache:
    """The components of an Optiland scene as one scene of Conicoid, and the numbers of all others."""

    def __init__(self, components: list[Any]) -> None:
        self.components = list(components)
        bodies, numbers, senses, self.other_components = [], [], [], list[int]()
        for i, component in enumerate(components):
            entry = shape_of(component.geometry)
            if entry is None:
                self.other_components.append(i)
                continue
            shape, sense = entry
            bodies.append(Body(shape.transform(_matrix(_get_transform(component.cs)))))
            numbers.append(i)
            senses.append(sense)
        self.scene = extension("Scene")(bodies)
        # One dummy entry without bodies, so that indexing works.
        self.numbers = np.array(numbers or [0], np.int32)
        self.senses = np.array(senses or [0.0])
        # The mark of rays of this scene, taken from one spawned ray.
        self.home = self.scene.first_hit((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).spawn((0.0, 0.0, 1.0))._home


def shape_of(geometry: Any) -> tuple[Shape, float] | None:
    """Return a geometry of Optiland as a shape, and the sign of its normal; None for an unknown one.

    The sign is +1 if the normal points from front to back, else -1.
    """
    if isinstance(geometry, SolidGeometry):
        return geometry.shape, -1.0
    try:
        if type(geometry) is SphereGeometry and geometry.aperture_radius is None:
            return Wall(Sphere(float(geometry.radius))), -1.0
        if isinstance(geometry, ConicGeometry):
            radius = float(geometry.radius) or math.inf
            conic = 0.0 if math.isinf(radius) else float(geometry.conic)
            return ConicSheet(radius, conic, 2 * float(geometry.aperture_radius)), -1.0
        if isinstance(geometry, FinitePlaneGeometry):
            return _finite_plane(geometry)
        if isinstance(geometry, AnnularPlaneGeometry):
            outer, inner = float(geometry.outer_radius), float(geometry.inner_radius)
            ring = Stop(2 * inner, 2 * outer) if inner > 0 else ConicSheet(math.inf, 0.0, 2 * outer)
            return ring.translate((0.0, 0.0, float(geometry.z_offset))), -1.0
        if isinstance(geometry, CylindricalFrustumGeometry):
            front, back = (float(z) for z in (geometry.z_front, geometry.z_back))
            ends = (0.0, 0.0, front), (0.0, 0.0, back)
            return Wall(Cone(*ends, float(geometry.r_front), float(geometry.r_back)), 0), 1.0
    except (TypeError, ValueError):
        return None  # valid in Optiland only, such as an aperture beyond the conic
    return None


def _finite_plane(geometry: Any) -> tuple[Shape, float]:
    """Return a disc, or a rectangle about the origin."""
    if geometry.aperture_radius is not None:
        return ConicSheet(math.inf, 0.0, 2 * float(geometry.aperture_radius)), -1.0
    x, y = float(geometry.width) / 2, float(geometry.height) / 2
    return Polygon(((-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0))), 1.0


def _facing(normals: Floats, directions: Any) -> Floats:
    """Return normals turned towards the rays."""
    along = (normals * np.asarray(directions)).sum(axis=1, keepdims=True)
    return np.where(along > 0, -normals, normals)


def _matrix(transform: Any) -> Floats:
    """Return (translation, rotation) as a matrix (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.asarray(transform[1], float), np.asarray(transform[0], float)
    return matrix
