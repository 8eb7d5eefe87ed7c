"""Rays through a prescription, surface by surface, and rays through any scene without splitting; cardinal points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import unit_rows
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import check_integer, describe_kind
from ...materials.dispersion import LINE_D
from ...queries.rays import Rays
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike, is_scene
from .interface import SceneMedia, find_walls, split_light
from .medium import check_wavelength
from .prescriptions import Prescription, row_sheet
from .refraction import reflect, refract

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Trace:
    """Rays after a prescription.

    Parameters
    ----------
    points : ndarray (surfaces + 1, n, 3)
        Start of each ray and its points on the surfaces; NaN from its loss on.
    rays : Rays
        (n,), behind the last surface.
    arrived : ndarray (n,) of bool
        Whether a ray hit all surfaces, in order and nothing else.
    optical_path : ndarray (n,)
        Σ index × length from the start to the last surface.
    rows : tuple of int
        The rows of the surfaces, in order.
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
        """Return the points of the rays behind the last surface in a plane.

        Parameters
        ----------
        z : float
            Height of the plane.

        Returns
        -------
        ndarray (n, 3)
            NaN for lost rays.
        """
        origins, ways = self.rays.origins, self.rays.directions
        with np.errstate(divide="ignore", invalid="ignore"):
            points = origins + ((z - origins[:, 2]) / ways[:, 2])[:, None] * ways
        points[~self.arrived] = np.nan
        return np.asarray(points)


def trace(
    system: Prescription,
    rays: Rays,
    wavelength: float | None = None,
    *,
    obstructions: bool = True,
    backwards: bool = False,
) -> Trace:
    """Trace rays through all surfaces of a prescription, in their order. Totally reflected rays are lost.

    Parameters
    ----------
    system : Prescription
        The lens system.
    rays : Rays
        (n,), before the first surface, or with `backwards` behind the last one.
    wavelength : float, optional
        In μm; the default is the primary one.
    obstructions : bool
        Whether a stop's screen, an edge or another lens or mirror on the way stops a ray. If False, each surface is
        traced alone, without holes.
    backwards : bool
        Trace from the last surface to the first.

    Returns
    -------
    Trace

    Raises
    ------
    TypeError, ValueError
        For arguments of another kind.
    """
    if not isinstance(system, Prescription) or not isinstance(rays, Rays):
        raise TypeError(
            "trace: system must be a Prescription and rays be Rays, got "
            f"{describe_kind(system)} and {describe_kind(rays)}"
        )
    wave = system.wavelength if wavelength is None else check_wavelength("trace", wavelength)
    # Planes in air have no faces: rays pass them unchanged.
    order = [i for i, faces in enumerate(system.elements.faces) if faces]
    # Backwards, the media change places as well (below)
    order = order[::-1] if backwards else order
    rays = Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    arrived, path = np.ones(len(rays.origins), bool), np.zeros(len(rays.origins))
    points = [rays.origins]
    for i in order:
        hits = _RowHits.of(system, i, rays, obstructions)
        arrived &= hits.on_surface
        before, after = system.media[i].index(wave), system.media[i + 1].index(wave)
        before, after = (after, before) if backwards else (before, after)
        # t counts in lengths of the direction
        path += before * hits.hits.t * np.linalg.norm(rays.directions, axis=1)
        if system.rows[i].reflects:
            ways = reflect(rays.directions, hits.hits.normal)
        else:
            ways, total = refract(rays.directions, hits.hits.normal, before / after)
            # A sequential design has no place for a ray that turns back
            arrived &= ~total
        # Spawned rays know their surface, so that they do not hit it again.
        rays = hits.hits.spawn(ways)
        points.append(np.where(arrived[:, None], hits.hits.point, np.nan))
    path[~arrived] = math.nan
    return Trace(np.stack(points), rays, arrived, path, tuple(order))


@dataclass(frozen=True, eq=False)
class _RowHits:
    """The first hits of rays, and the mask of those on the intended surface."""

    hits: Any
    on_surface: Bools

    @classmethod
    def of(cls, system: Prescription, i: int, rays: Rays, obstructions: bool) -> _RowHits:
        """Return the hits on the surface of row i."""
        # The surface alone: nothing stands before it, and it has no edge
        if not obstructions:
            # A ray that was spawned from a miss stays lost, in this scene of one surface too
            hits = _hit_of_row(system, i).first_hit(rays)
            return cls(hits, np.asarray(hits.hit))
        hits = system.scene.first_hit(rays)
        on_surface = _hit_of_scene(hits, system.elements.faces[i])
        row = system.rows[i]
        if row.stop and row.diameter is not None:
            # The stop may be a glass surface wider than its opening.
            on_surface &= np.hypot(hits.point[:, 0], hits.point[:, 1]) <= row.diameter / 2
        return cls(hits, on_surface)


def _hit_of_scene(hits: Any, faces: Sequence[tuple[int, int]]) -> Bools:
    """Return whether hits are on one of some faces of bodies."""
    on_face = np.zeros(hits.shape, bool)
    for body, face in faces:
        on_face |= (hits.body == body) & (hits.face == face)
    return on_face


def _hit_of_row(system: Prescription, i: int) -> SceneLike:
    """Return the surface of row i as a scene; it is made once."""
    surfaces: dict[int, SceneLike] = vars(system).setdefault("_surfaces", {})
    if i not in surfaces:
        surfaces[i] = extension("Scene")([row_sheet(system, i, whole=True)])
    return surfaces[i]


# Rays through any scene: refracted, reflected or stopped by the materials of its bodies, without splitting.

RayFloats = npt.NDArray[np.float64]
RayBools = npt.NDArray[np.bool_]
MOST_SURFACES = 1000


@dataclass(eq=False)
class RayPaths:
    """Rays after a scene.

    Parameters
    ----------
    points : ndarray (walls + 1, n, 3)
        Their starts and their points on walls; a ray that has left repeats its last point.
    rays : Rays
        (n,), outside of the scene, with unit directions.
    arrived : ndarray (n,) of bool
        False if a ray was absorbed or does not leave.
    """

    points: RayFloats
    rays: Rays
    arrived: RayBools

    def __repr__(self) -> str:
        walls = format_count(len(self.points) - 1, "wall", "walls")
        rays = format_count(len(self.arrived), "ray", "rays")
        return f"RayPaths({int(self.arrived.sum()):,} of {rays} left, {walls} at most)"


def follow(scene: SceneLike, rays: Rays, wavelength: float = LINE_D, most: int = 100) -> RayPaths:
    """Follow rays until they leave a scene.

    A ray is refracted at the wall of a transparent body, reflected by an opaque body that mirrors and in total
    reflection, and absorbed by any other. The rules of walls are those of `trace_paths`, which splits light there.

    Parameters
    ----------
    scene : Scene
        Bodies with materials.
    rays : Rays
        Any number.
    wavelength : float
        In μm.
    most : int
        The most walls of a ray, 1,000 at most; a ray that has not left by then has not arrived.

    Returns
    -------
    RayPaths

    Raises
    ------
    TypeError, ValueError
        For arguments of another kind.
    """
    if not is_scene(scene) or not isinstance(rays, Rays):
        raise TypeError(
            f"follow: scene must be a Scene and rays be Rays, got {describe_kind(scene)} and {describe_kind(rays)}"
        )
    wave, most = check_wavelength("follow", wavelength), check_integer("follow", "most", most, 1, MOST_SURFACES)
    media = SceneMedia(scene, 1.0)
    origins, directions = rays.origins.reshape(-1, 3).copy(), unit_rows(rays.directions.reshape(-1, 3))[0]
    going, rays, arrived = np.arange(len(origins)), Rays(origins, directions), np.ones(len(origins), bool)
    points = [origins.copy()]
    # A bound, since a ray may go round between two mirrors for ever
    for _ in range(most):
        walls = find_walls(scene, media, rays, -1, np.full(len(going), wave))
        hit = np.asarray(walls.hits.hit)
        # Rays that leave keep this line
        origins[going[~hit]], directions[going[~hit]] = rays.origins[~hit], rays.directions[~hit]
        going, rays, walls = going[hit], rays[hit], walls.select(hit)
        if not len(going):
            break
        points.append(points[-1].copy())
        points[-1][going] = walls.hits.point
        shares = split_light(media, walls, rays.directions, np.full(len(going), wave))
        on = shares.passed > 0
        # Of a transparent wall only total reflection turns the ray back
        kept = on | (shares.mirrored > np.where(walls.opaque, 0.0, _TOTAL))
        arrived[going[~kept]] = False
        going = going[kept]
        rays = walls.hits[kept].spawn(np.where(on[:, None], shares.refracted, shares.reflected)[kept])
    arrived[going] = False
    return RayPaths(np.stack(points), Rays(origins, directions), arrived)


_TOTAL = 1 - 1e-12
"""A larger share is that of total reflection."""


# Focal lengths and principal planes, by real rays so near the axis that aberrations vanish.

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
