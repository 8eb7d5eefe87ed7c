"""The answer to `trace_paths`: segments of light as flat arrays."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.errstate import ignore_fp_errors
from ..._util.foreign_names import with_attribute_hints
from ..._util.hints import frozen_with_hints, with_call_hints
from ..._util.text import format_count
from ..._util.validation import check_flag, check_integer, check_nonnegative, check_positive, describe_kind, real_array
from ...materials.dispersion import LINE_D, check_wavelengths
from ...queries.id_arrays import number_fields
from ...queries.ray_queries import as_rays
from ...queries.rays import LazyRays, Rays
from .interface import LightSplit, SceneMedia, WallHits, find_walls, split_light

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@frozen_with_hints
@dataclass(frozen=True)
class Balance:
    """Where the light of some rays went, as sums of weights: `given` is the sum of the others.

    escaped: to infinity; in_media: absorbed on the way through media; at_walls: absorbed by surfaces and coats;
    not_followed: what arrived at the last walls, and what was too weak.
    """

    given: float
    escaped: float
    in_media: float
    at_walls: float
    not_followed: float


@with_attribute_hints
@frozen_with_hints
@dataclass(frozen=True, eq=False, repr=False)
class Paths:
    """Segments of light, from wall to wall, level by level: those of the rays first. Row k of each array is segment k.

    start, end   float64 (n, 3): the points between which it goes; NaN is the end of one that escapes
    direction    float64 (n, 3): unit
    length       float64: inf of one that escapes
    body         int32: the transparent body that it goes through, -1 for none; of several that are the same to light,
                 between which there is no wall, the last
    index        float64: the refractive index there, at its wavelength
    optical_path float64: index · length
    weight       float64: the light at its start, as a share of its ray's, or times the weight that was given
    arriving     float64: what is left of that at its end
    deposited    float64: what the wall at its end keeps of it
    lost         float64: what was not followed any further
    parent       int64: the segment that it comes from, -1 of those of the rays
    ray          int64: the flat index of its ray
    level        int64: how many walls it has met before
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
        vars(self).update(number_fields(vars(self)))

    @property
    def optical_path(self) -> FloatArray:
        return self.index * self.length

    @property
    def escaped(self) -> npt.NDArray[np.bool_]:
        """bool (n,): those that meet no wall any more."""
        return self.wall < 0

    @property
    def optical_path_from_start(self) -> FloatArray:
        """float64 (n,): the sum of index · length from the ray's origin to the end of each segment."""
        total = self.optical_path
        for level in range(1, int(self.level.max(initial=0)) + 1):
            rows = np.flatnonzero(self.level == level)
            total[rows] += total[self.parent[rows]]
        return total

    def balance(self) -> Balance:
        """Where the light went: what escaped, was absorbed and was not followed, which together are what was given."""
        escaped = self.escaped
        return Balance(
            float(self.weight[self.level == 0].sum()),
            float(self.arriving[escaped].sum()),
            float((self.weight - self.arriving).sum()),
            float(self.deposited.sum()),
            float(self.lost.sum()),
        )

    def chain(self, segment: int) -> IntArray:
        """int64: the segments from a ray's first one to the given one, along its parents.

        segment: its row.
        """
        at = check_integer("Paths", "segment", segment, 0, len(self) - 1)
        found = [at]
        while self.parent[at] >= 0:
            at = int(self.parent[at])
            found.append(at)
        return np.array(found[::-1], np.int64)

    @ignore_fp_errors
    def lines(self, beyond: float = 1.0) -> FloatArray:
        """float64 (n, 2, 3): both ends of each segment, to be drawn.

        beyond: how far one that escapes is to be drawn.
        """
        far = check_positive("Paths", "beyond", beyond)
        ends = np.where(self.escaped[:, None], self.start + far * self.direction, self.end)
        return np.stack([self.start, ends], axis=1)

    def __len__(self) -> int:
        return len(self.length)

    def __repr__(self) -> str:
        rays = format_count(int((self.level == 0).sum()), "ray", "rays")
        return f"Paths({format_count(len(self), 'segment', 'segments')} of {rays})"


# Light along many paths at once: mirrored, refracted, split and absorbed, level by level.

_MICROMETRES = 1000.0
_DEEPEST = 1_000_000
_ROUNDING = 2.0**-50  # of the light at a wall that keeps nothing


@dataclass(frozen=True)
class _Light:
    """Light on its way: rays, and arrays with an item for each."""

    rays: Rays
    medium: Any  # the transparent body that it is thought to be in
    weight: Any
    least: Any  # weaker light is not followed
    wavelength: Any
    parent: Any
    ray: Any
    mirrored: Any


@with_call_hints
@ignore_fp_errors
def trace_paths(
    scene: Any, rays: Any, depth: int = 8, split: bool = True, *, wavelength: Any = LINE_D, weight: Any = 1.0,
    least: float = 0.0, seed: int = 0, unit: float = _MICROMETRES,
) -> Paths:  # fmt: skip
    """All segments of light that starts along rays: at every wall it parts by Fresnel's formulas and Snell's law.

    scene: a `co.Scene`. What bodies do to light is said by their materials (docs/optics.md): `refractive_index`,
        `absorption`, `coating` and `transparency` of clear ones; the complex index of metals, `coating` and
        `reflectivity` of others.
    rays: `co.Rays` of any shape; segments know them by their flat index.
    depth: how many walls a path may meet; light that arrives at one more is not followed.
    split: True follows the mirrored and the refracted light of each wall, False one of them, chosen at random in
        proportion, which has the weight of both.
    wavelength: in μm, in vacuum, one for all rays or one for each. It is n_d's without one.
    weight: of the light of each ray, one or one for each.
    least: light weaker than this share of its ray's is not followed.
    seed: of the choices of split=False, which are the same again with the same rays.
    unit: how many μm a unit of length of the scene has, for media of complex index: 1000 is a millimetre.

    Spawned rays know the surface that they start on, at every wall: there is no small distance. Light is unpolarised.
    Raises ValueError for a wavelength outside of the range of a material that is met.
    """
    if not hasattr(scene, "prepared"):
        raise TypeError(f"trace_paths: scene must be a Scene, got {describe_kind(scene)}")
    if not isinstance(rays, Rays | LazyRays):
        raise TypeError(f"trace_paths: rays must be a Rays, co.Rays(origins, directions), got {describe_kind(rays)}")
    light = _start_light(
        as_rays("trace_paths", rays, None), wavelength, weight, check_nonnegative("trace_paths", "least", least)
    )
    walls = check_integer("trace_paths", "depth", depth, 0, _DEEPEST)
    follow_both = check_flag("trace_paths", "split", split)
    chosen_by = check_integer("trace_paths", "seed", seed, 0)
    random = None if follow_both else np.random.default_rng(chosen_by)
    media = SceneMedia(scene, check_positive("trace_paths", "unit", unit))
    light = replace(light, medium=_starts(scene, media, light.rays))
    parts, done = [], 0
    for level in range(walls + 1):
        found, light = _step(scene, media, light, level, done, level == walls, random)
        parts.append(found)
        done += len(found["length"])
        if not light.rays.size:
            break
    return Paths(**{name: np.concatenate([each[name] for each in parts]) for name in parts[0]})


def _start_light(rays: Rays, wavelength: Any, weight: Any, least: float) -> _Light:
    """The light of rays before its first wall."""
    each = functools.partial(_one_each, rays)
    waves = each("wavelength", check_wavelengths("trace_paths", wavelength))
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
    """Values for each ray, flat; a ValueError where they do not fit."""
    try:
        return np.broadcast_to(values, rays.shape).reshape(-1).astype(float)
    except ValueError:
        expected = f"one number, or one for each ray {rays.shape}"
        raise ValueError(f"trace_paths: {field} must be {expected}, got shape {values.shape}") from None


def _unit(directions: Any) -> Any:
    """Directions at unit length, scaled first so that no square overflows."""
    scaled = directions / np.abs(directions).max(axis=1, initial=0.0, keepdims=True)
    return scaled / np.sqrt((scaled * scaled).sum(axis=1, keepdims=True))


def _starts(scene: Any, media: SceneMedia, rays: Rays) -> Any:
    """The transparent bodies that rays start in: it matters for those that meet nothing."""
    return media.clear(scene.body_at(rays.origins)) if rays.size else np.zeros(0, np.int64)


def _step(
    scene: Any, media: SceneMedia, light: _Light, level: int, done: int, last: bool, random: Any
) -> tuple[dict[str, Any], _Light]:
    """(the segments of a level, the light that goes on from their ends)"""
    rays, w = light.rays, light.wavelength
    met = find_walls(scene, media, rays, light.medium, w)
    hits, count = met.hits, rays.size
    inside, length = media.inside(met.before), np.asarray(hits.t)
    arriving = media.faded(light.weight, inside, w, length)
    at_wall = np.flatnonzero(hits.hit)
    deposited, lost = np.zeros(count), np.zeros(count)
    segments = dict(
        start=np.array(rays.origins), end=np.array(hits.point), direction=np.array(rays.directions),
        length=length + 0.0, body=np.asarray(met.before, np.int32), index=media.index(inside, w).real,
        weight=light.weight, arriving=arriving, deposited=deposited, lost=lost, parent=light.parent, ray=light.ray,
        level=np.full(count, level), wavelength=w, wall=np.array(hits.body), surface=np.array(hits.surface),
        mirrored=light.mirrored,
    )  # fmt: skip
    if last:
        lost[at_wall] = arriving[at_wall]
        return segments, _nothing(light)
    here = WallHits(hits[at_wall], *(values[at_wall] for values in (met.before, met.after, met.wall, met.opaque)))
    parted = split_light(media, here, rays.directions[at_wall], w[at_wall])
    there = arriving[at_wall]
    back, on = there * parted.mirrored, there * parted.passed
    kept = there - back - on
    deposited[at_wall] = np.where(kept > _ROUNDING * there, kept, 0.0)
    if random is not None:
        back, on = _choose_branch(back, on, random)
    goes = [(weight > 0) & (weight >= light.least[at_wall]) for weight in (back, on)]
    lost[at_wall] = np.where(goes[0], 0.0, back) + np.where(goes[1], 0.0, on)
    return segments, _split_level(light, here, parted, (back, on), (goes[0], goes[1]), at_wall, done)


def _nothing(light: _Light) -> _Light:
    """No light any more."""
    arrays = (light.medium, light.weight, light.least, light.wavelength, light.parent, light.ray, light.mirrored)
    return _Light(light.rays[:0], *(values[:0] for values in arrays))


def _choose_branch(back: Any, on: Any, random: Any) -> tuple[Any, Any]:
    """All light to one of both sides, in proportion."""
    both = back + on
    mirrored = random.random(len(both)) * both < back
    return np.where(mirrored, both, 0.0), np.where(mirrored, 0.0, both)


def _split_level(
    light: _Light,
    met: WallHits,
    parted: LightSplit,
    weights: tuple[Any, Any],
    goes: tuple[Any, Any],
    at_wall: Any,
    done: int,
) -> _Light:
    """The light that goes on: what is mirrored, then what is refracted."""
    parts, numbers = [], []
    for goes_on, directions in zip(goes, (parted.reflected, parted.refracted), strict=True):
        rows = np.flatnonzero(goes_on)
        numbers.append(rows)
        parts.append(met.hits[rows].spawn(_unit(directions[rows])))
    rows = np.concatenate(numbers)
    first = len(numbers[0])
    medium = np.concatenate([met.before[numbers[0]], met.after[numbers[1]]])
    weight = np.concatenate([weights[0][numbers[0]], weights[1][numbers[1]]])
    of = at_wall[rows]
    return _Light(
        Rays.concatenate(parts), medium, weight, light.least[of], light.wavelength[of], done + of, light.ray[of],
        np.arange(len(rows)) < first,
    )  # fmt: skip
