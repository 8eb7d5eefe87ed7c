"""Light along many paths at once: mirrored, refracted, split and absorbed, level by level."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..engine.answers.lazy_rays import LazyRays
from ..engine.answers.rays import Rays
from ..engine.queries.queries import as_rays
from ..shapes.arrays import real_array
from ..shapes.calls import explained
from ..shapes.calm import calm
from ..shapes.dispersion import LINE_D, checked_wavelengths
from ..shapes.validate import flag, integer, nonnegative, positive, what
from .media import Media
from .meeting import Met, Parted, meet, part
from .paths import Paths

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


@explained
@calm
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
        raise TypeError(f"trace_paths: scene must be a Scene, got {what(scene)}")
    if not isinstance(rays, Rays | LazyRays):
        raise TypeError(f"trace_paths: rays must be a Rays, co.Rays(origins, directions), got {what(rays)}")
    light = _begun(as_rays("trace_paths", rays, None), wavelength, weight, nonnegative("trace_paths", "least", least))
    walls = integer("trace_paths", "depth", depth, 0, _DEEPEST)
    follow_both = flag("trace_paths", "split", split)
    chosen_by = integer("trace_paths", "seed", seed, 0)
    random = None if follow_both else np.random.default_rng(chosen_by)
    media = Media(scene, positive("trace_paths", "unit", unit))
    light = replace(light, medium=_starts(scene, media, light.rays))
    parts, done = [], 0
    for level in range(walls + 1):
        found, light = _step(scene, media, light, level, done, level == walls, random)
        parts.append(found)
        done += len(found["length"])
        if not light.rays.size:
            break
    return Paths(**{name: np.concatenate([each[name] for each in parts]) for name in parts[0]})


def _begun(rays: Rays, wavelength: Any, weight: Any, least: float) -> _Light:
    """The light of rays before its first wall."""
    each = functools.partial(_one_each, rays)
    waves = each("wavelength", checked_wavelengths("trace_paths", wavelength))
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


def _starts(scene: Any, media: Media, rays: Rays) -> Any:
    """The transparent bodies that rays start in: it matters for those that meet nothing."""
    return media.clear(scene.body_at(rays.origins)) if rays.size else np.zeros(0, np.int64)


def _step(
    scene: Any, media: Media, light: _Light, level: int, done: int, last: bool, random: Any
) -> tuple[dict[str, Any], _Light]:
    """(the segments of a level, the light that goes on from their ends)"""
    rays, w = light.rays, light.wavelength
    met = meet(scene, media, rays, light.medium, w)
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
    here = Met(hits[at_wall], *(values[at_wall] for values in (met.before, met.after, met.wall, met.opaque)))
    parted = part(media, here, rays.directions[at_wall], w[at_wall])
    there = arriving[at_wall]
    back, on = there * parted.mirrored, there * parted.passed
    kept = there - back - on
    deposited[at_wall] = np.where(kept > _ROUNDING * there, kept, 0.0)
    if random is not None:
        back, on = _chosen(back, on, random)
    goes = [(weight > 0) & (weight >= light.least[at_wall]) for weight in (back, on)]
    lost[at_wall] = np.where(goes[0], 0.0, back) + np.where(goes[1], 0.0, on)
    return segments, _parted(light, here, parted, (back, on), (goes[0], goes[1]), at_wall, done)


def _nothing(light: _Light) -> _Light:
    """No light any more."""
    arrays = (light.medium, light.weight, light.least, light.wavelength, light.parent, light.ray, light.mirrored)
    return _Light(light.rays[:0], *(values[:0] for values in arrays))


def _chosen(back: Any, on: Any, random: Any) -> tuple[Any, Any]:
    """All light to one of both sides, in proportion."""
    both = back + on
    mirrored = random.random(len(both)) * both < back
    return np.where(mirrored, both, 0.0), np.where(mirrored, 0.0, both)


def _parted(
    light: _Light, met: Met, parted: Parted, weights: tuple[Any, Any], goes: tuple[Any, Any], at_wall: Any, done: int
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
