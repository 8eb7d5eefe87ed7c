"""Light along many paths: `trace_paths`, and its result, segments of light as flat arrays."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import ignore_fp_errors
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import check_flag, check_integer, check_nonnegative, check_positive, describe_kind, real_array
from ...geometry.body import Body
from ...geometry.entries import LENGTH_UNITS
from ...geometry.shape import Shape
from ...materials.dispersion import LINE_D, check_light
from ...queries.ray_queries import as_rays
from ...queries.rays import LazyRays, Rays
from ...queries.scene_protocol import SceneLike, is_scene
from .interface import LightSplit, SceneMedia, WallHits, find_walls, split_light

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Balance:
    """The light of some rays by its fate, as sums of weights: `emitted` is the sum of the others.

    escaped: to infinity; in_media: absorbed on the way through media; at_walls: absorbed by surfaces and coats;
    not_followed: light that arrived at the last walls, and light that was too weak.
    """

    emitted: float
    escaped: float
    in_media: float
    at_walls: float
    truncated: float


@dataclass(frozen=True, eq=False, repr=False)
class Paths:
    """Segments of light, from wall to wall, level by level: those of the rays first. Row k of each array is segment k.

    start, end   float64 (n, 3): its end points; NaN is the end of one that escapes
    direction    float64 (n, 3): unit
    length       float64: inf of one that escapes
    body         int32: the transparent body around it, -1 for none; of several that are the same to light, between
                 which there is no wall, the last
    index        float64: the refractive index there, at its wavelength
    optical_path float64: index · length
    weight       float64: the light at its start, as a share of its ray's, or times the given weight
    arriving     float64: the remaining light at its end
    deposited    float64: the light that the wall at its end absorbs
    lost         float64: the light that was not followed any further
    parent       int64: the segment before it, -1 of those of the rays
    ray          int64: the flat index of its ray
    level        int64: number of walls before it
    wavelength   float64: in μm, in vacuum
    wall         int32: the body whose wall it ends on, -1 for one that escapes
    surface      int32: the surface that it ends on, -1 likewise
    mirrored     bool: it began by reflection
    """

    start: FloatArray
    end: FloatArray
    direction: FloatArray
    length: FloatArray
    body: npt.NDArray[np.int32]
    index: FloatArray
    weight: FloatArray
    arriving: FloatArray
    deposited: FloatArray
    lost: FloatArray
    parent: IntArray
    ray: IntArray
    level: IntArray
    wavelength: FloatArray
    wall: npt.NDArray[np.int32]
    surface: npt.NDArray[np.int32]
    mirrored: npt.NDArray[np.bool_]

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.flags.writeable = False

    @property
    def optical_path(self) -> FloatArray:
        """float64 (n,): index · length."""
        return self.index * self.length

    @property
    def escaped(self) -> npt.NDArray[np.bool_]:
        """bool (n,): segments that end on no wall."""
        return self.wall < 0

    @property
    def optical_path_from_start(self) -> FloatArray:
        """float64 (n,): the sum of index · length from the ray's origin to the end of each segment."""
        total = self.optical_path
        # Parents come a level earlier, so their totals are complete.
        for level in range(1, int(self.level.max(initial=0)) + 1):
            rows = np.flatnonzero(self.level == level)
            total[rows] += total[self.parent[rows]]
        return total

    def balance(self) -> Balance:
        """Return the light that escaped, was absorbed and was not followed; together these are the emitted light.

        Returns
        -------
        Balance
        """
        escaped = self.escaped
        return Balance(
            float(self.weight[self.level == 0].sum()),
            float(self.arriving[escaped].sum()),
            float((self.weight - self.arriving).sum()),
            float(self.deposited.sum()),
            float(self.lost.sum()),
        )

    def chain(self, segment: int) -> IntArray:
        """Return the segments from a ray's first one to the given one, along its parents.

        Parameters
        ----------
        segment : int
            Its row.

        Returns
        -------
        ndarray of int64
        """
        at = check_integer("Paths", "segment", segment, 0, len(self) - 1)
        rows = [at]
        while self.parent[at] >= 0:
            at = int(self.parent[at])
            rows.append(at)
        return np.array(rows[::-1], np.int64)

    @ignore_fp_errors
    def lines(self, beyond: float = 1.0) -> FloatArray:
        """Return both ends of each segment, for a drawing.

        Parameters
        ----------
        beyond : float
            Length of the drawn part of a segment that escapes.

        Returns
        -------
        ndarray (n, 2, 3)
        """
        far = check_positive("Paths", "beyond", beyond)
        ends = np.where(self.escaped[:, None], self.start + far * self.direction, self.end)
        return np.stack([self.start, ends], axis=1)

    def __len__(self) -> int:
        return len(self.length)

    def __repr__(self) -> str:
        rays = format_count(int((self.level == 0).sum()), "ray", "rays")
        return f"Paths({format_count(len(self), 'segment', 'segments')} of {rays})"


# The tracer: light is mirrored, refracted, split and absorbed, level by level.

_MICROMETRES = 1000.0
_DEEPEST = 1_000_000
_ROUNDING = 2.0**-50  # of the light at a wall that keeps nothing


@dataclass(frozen=True)
class _Light:
    """Light on its way: rays, and arrays with an item for each."""

    rays: Rays
    medium: Any  # the transparent body that it is in
    weight: Any
    least: Any  # weaker light is not followed
    wavelength: Any
    parent: Any
    ray: Any
    mirrored: Any


@ignore_fp_errors
def trace_paths(
    scene: SceneLike | Shape | Body, rays: Rays, depth: int = 8, split: bool = True, *,
    wavelength: npt.ArrayLike = LINE_D, weight: npt.ArrayLike = 1.0, least: float = 0.0, seed: int = 0,
    unit: float | None = None,
) -> Paths:  # fmt: skip
    """Trace all segments of light along rays: every wall splits it by Fresnel's formulas and Snell's law.

    Materials define the optics of bodies (docs/light-paths.md): `refractive_index`, `absorption`, `coating` and
    `transparency` of transparent ones; the complex index of metals, `coating` and `reflectivity` of others. Spawned
    rays know the surface that they start on, at every wall: there is no small distance. Light is unpolarised.

    Parameters
    ----------
    scene : Scene
        The bodies.
    rays : Rays
        Of any shape; segments have their flat index.
    depth : int
        The most walls of a path; light that arrives at one more is not followed.
    split : bool
        True follows the mirrored and the refracted light of each wall. False follows one of them, chosen at random in
        proportion, with the weight of both.
    wavelength : float or array_like
        In μm, in vacuum, one for all rays or one for each. The default is that of n_d.
    weight : float or array_like
        Of the light of each ray, one or one for each.
    least : float
        Light weaker than this share of its ray's is not followed.
    seed : int
        Of the choices of split=False; the same seed and rays give the same choices.
    unit : float, optional
        Micrometres in a unit of length of the scene, for media of complex index: 1000 is a millimetre. The default is
        that of `scene.unit`, or a millimetre where the scene states none.

    Returns
    -------
    Paths

    Raises
    ------
    ValueError
        For a wavelength outside of the range of a material on the way.
    """
    if not is_scene(scene):
        raise TypeError(f"trace_paths: scene must be a Scene, got {describe_kind(scene)}")
    if not isinstance(rays, Rays | LazyRays):
        raise TypeError(f"trace_paths: rays must be a Rays, co.Rays(origins, directions), got {describe_kind(rays)}")
    light = _start_light(
        as_rays("trace_paths", rays, None), wavelength, weight, check_nonnegative("trace_paths", "least", least)
    )
    walls = check_integer("trace_paths", "depth", depth, 0, _DEEPEST)
    follow_both = check_flag("trace_paths", "split", split)
    checked_seed = check_integer("trace_paths", "seed", seed, 0)
    random = None if follow_both else np.random.default_rng(checked_seed)
    if unit is None:
        unit = _MICROMETRES if scene.unit is None else float(1000 * LENGTH_UNITS[scene.unit])
    media = SceneMedia(scene, check_positive("trace_paths", "unit", unit))
    light = replace(light, medium=_starts(scene, media, light.rays))
    parts, done = [], 0
    for level in range(walls + 1):
        segments, light = _step(scene, media, light, level, done, level == walls, random)
        parts.append(segments)
        done += len(segments["length"])
        if not light.rays.size:
            break
    return Paths(**{name: np.concatenate([each[name] for each in parts]) for name in parts[0]})


def _start_light(rays: Rays, wavelength: Any, weight: Any, least: float) -> _Light:
    """Return the light of rays before its first wall."""
    each = functools.partial(_one_each, rays)
    waves = each("wavelength", check_light("trace_paths", wavelength))
    weights = each("weight", real_array("trace_paths", "weight", weight))
    bad = weights[~(np.isfinite(weights) & (weights >= 0))]
    if bad.size:
        raise ValueError(f"trace_paths: weight must be finite and >= 0, got {bad[0]}")
    count = rays.size
    flat = Rays._spawned(
        rays.origins.reshape(-1, 3), _unit(rays.directions.reshape(-1, 3)), rays._starts, rays._home
    )  # fmt: skip
    none = np.full(count, -1, np.int64)
    return _Light(flat, none, weights, least * weights, waves, none, np.arange(count), np.zeros(count, np.bool_))


def _one_each(rays: Rays, field: str, values: Any) -> Any:
    """Return values for each ray, flat. Raise ValueError if they do not fit."""
    try:
        return np.broadcast_to(values, rays.shape).reshape(-1).astype(float)
    except ValueError:
        expected = f"one number, or one for each ray {rays.shape}"
        raise ValueError(f"trace_paths: {field} must be {expected}, got shape {values.shape}") from None


def _unit(directions: Any) -> Any:
    """Return directions at unit length, scaled first so that no square overflows."""
    scaled = directions / np.abs(directions).max(axis=1, initial=0.0, keepdims=True)
    return scaled / np.sqrt((scaled * scaled).sum(axis=1, keepdims=True))


def _starts(scene: Any, media: SceneMedia, rays: Rays) -> Any:
    """Return the transparent bodies that rays start in: needed for rays without a hit."""
    return media.clear(scene.body_at(rays.origins)) if rays.size else np.zeros(0, np.int64)


def _step(
    scene: Any, media: SceneMedia, light: _Light, level: int, done: int, last: bool, random: Any
) -> tuple[dict[str, Any], _Light]:
    """Return (the segments of a level, the light that goes on from their ends)."""
    rays, w = light.rays, light.wavelength
    walls = find_walls(scene, media, rays, light.medium, w)
    hits, count = walls.hits, rays.size
    inside, length = media.inside(walls.before), np.asarray(hits.t)
    arriving = media.attenuate(light.weight, inside, w, length)
    at_wall = np.flatnonzero(hits.hit)
    deposited, lost = np.zeros(count), np.zeros(count)
    segments = dict(
        start=np.array(rays.origins), end=np.array(hits.point), direction=np.array(rays.directions),
        length=length + 0.0, body=np.asarray(walls.before, np.int32), index=media.index(inside, w).real,
        weight=light.weight, arriving=arriving, deposited=deposited, lost=lost, parent=light.parent, ray=light.ray,
        level=np.full(count, level), wavelength=w, wall=np.array(hits.body), surface=np.array(hits.surface),
        mirrored=light.mirrored,
    )  # fmt: skip
    if last:
        lost[at_wall] = arriving[at_wall]
        return segments, _nothing(light)
    wall_hits = walls.select(at_wall)
    shares = split_light(media, wall_hits, rays.directions[at_wall], w[at_wall])
    there = arriving[at_wall]
    back, on = there * shares.mirrored, there * shares.passed
    absorbed = there - back - on
    # Rounding of shares that add up to 1 is no absorption.
    deposited[at_wall] = np.where(absorbed > _ROUNDING * there, absorbed, 0.0)
    if random is not None:
        back, on = _choose_branch(back, on, random)
    goes = [(weight > 0) & (weight >= light.least[at_wall]) for weight in (back, on)]
    lost[at_wall] = np.where(goes[0], 0.0, back) + np.where(goes[1], 0.0, on)
    return segments, _split_level(light, wall_hits, shares, (back, on), (goes[0], goes[1]), at_wall, done)


def _nothing(light: _Light) -> _Light:
    """Return no light."""
    arrays = (light.medium, light.weight, light.least, light.wavelength, light.parent, light.ray, light.mirrored)
    return _Light(light.rays[:0], *(values[:0] for values in arrays))


def _choose_branch(back: Any, on: Any, random: Any) -> tuple[Any, Any]:
    """Give all light to one of both sides, at random in proportion."""
    # A branch with the weight of both keeps the expectation of each.
    both = back + on
    mirrored = random.random(len(both)) * both < back
    return np.where(mirrored, both, 0.0), np.where(mirrored, 0.0, both)


def _split_level(
    light: _Light,
    walls: WallHits,
    shares: LightSplit,
    weights: tuple[Any, Any],
    goes: tuple[Any, Any],
    at_wall: Any,
    done: int,
) -> _Light:
    """Return the light that goes on: the mirrored, then the refracted part."""
    parts, numbers = [], []
    for goes_on, directions in zip(goes, (shares.reflected, shares.refracted), strict=True):
        rows = np.flatnonzero(goes_on)
        numbers.append(rows)
        parts.append(walls.hits[rows].spawn(_unit(directions[rows])))
    rows = np.concatenate(numbers)
    first = len(numbers[0])
    # Mirrored light stays before the wall, refracted light is behind it.
    medium = np.concatenate([walls.before[numbers[0]], walls.after[numbers[1]]])
    weight = np.concatenate([weights[0][numbers[0]], weights[1][numbers[1]]])
    of = at_wall[rows]
    return _Light(
        Rays.concatenate(parts), medium, weight, light.least[of], light.wavelength[of], done + of, light.ray[of],
        np.arange(len(rows)) < first,
    )  # fmt: skip
