"""What light of one wavelength meets in a scene: the media and walls of its bodies, by their materials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...kernels import tables as table
from ...kernels.body.media import AFTER, BEFORE, BLOCKER, CLEAR, OPAQUE
from ...materials.coating import Coating
from ...materials.color import amount_rgb
from ...materials.dispersion import LINE_D, index_at
from ...materials.fresnel import Fresnel, fresnel
from ...materials.material import DEFAULT_MATERIAL, Material
from ...queries.hits import Hits
from ...queries.rays import Rays
from .refraction import reflect, refract

_CHANNELS = (0.45, 0.55, 0.65)
"""Where blue, green and red are in μm, for amounts that are colours: linear between them, and constant beyond."""


def amount_at(amount: Any, wavelength: Any) -> Any:
    """An amount of a material, one number or a colour, at wavelengths."""
    r, g, b = amount_rgb(amount)
    return np.full(np.shape(wavelength), r) if r == g == b else np.interp(wavelength, _CHANNELS, (b, g, r))


def material_index(material: Material, wavelength: Any) -> Any:
    """The refractive index of a material at wavelengths: one number goes with its `dispersion`, if there is one."""
    index = index_at(material.refractive_index, wavelength)
    if material.dispersion and isinstance(material.refractive_index, float):
        index = index + material.dispersion * (1 / np.square(wavelength) - 1 / LINE_D**2)
    return index


def metal_at(material: Material, wavelength: Any) -> Any:
    """n + ik of what is opaque, at wavelengths: of a metal by its three channels, else its refractive index."""
    if material.metal_index is None or material.metal_extinction is None:
        return index_at(material.refractive_index, wavelength)
    n = np.interp(wavelength, _CHANNELS, material.metal_index[::-1])
    return n + 1j * np.interp(wavelength, _CHANNELS, material.metal_extinction[::-1])


def absorption_at(material: Material, wavelength: Any, unit: float) -> Any:
    """What fades per unit of length: the material's absorption, and 4πk/λ of a complex index; unit: μm in one."""
    rate = amount_at(material.absorption, wavelength)
    index = index_at(material.refractive_index, wavelength)
    return rate + 4 * np.pi * np.imag(index) / wavelength * unit if np.iscomplexobj(index) else rate


class SceneMedia:
    """The bodies of a scene as light meets them. Body -1 is vacuum."""

    def __init__(self, scene: Any, unit: float) -> None:
        self.prepared = scene.prepared
        self.unit = unit
        self.kinds = self.prepared.kinds

    @cached_property
    def materials(self) -> list[Material]:
        """The different ones; the paints of single faces follow those of bodies."""
        known: dict[Material, None] = {}
        for made in (*(m for m, _ in self.prepared.labels.distinct), *self.prepared.lowered.face_paint.values()):
            known[DEFAULT_MATERIAL if made is None else made] = None
        return list(known)

    @cached_property
    def _numbers(self) -> dict[Material, int]:
        return {material: number for number, material in enumerate(self.materials)}

    @cached_property
    def _of_body(self) -> Any:
        """The number of each body's material, and -1 for no body in the last place."""
        made = self.prepared.labels.materials_of(np.arange(self.prepared.lowered.body_count))
        found = [self._numbers[DEFAULT_MATERIAL if one is None else one] for one in made.tolist()]
        return np.array([*found, -1], np.int64)

    @cached_property
    def _paints(self) -> tuple[Any, Any]:
        """(rows of painted faces, rising; the numbers of their materials)"""
        paints = self.prepared.lowered.face_paint
        rows = sorted(paints)
        return np.array(rows, np.int64), np.array([self._numbers[paints[row]] for row in rows], np.int64)

    def inside(self, bodies: Any) -> Any:
        """The number of the material inside of bodies, -1 for vacuum."""
        return self._of_body[bodies]

    def clear(self, bodies: Any) -> Any:
        """The transparent solids among bodies, -1 for others: what light is inside of."""
        kinds = np.append(self.kinds, np.int8(OPAQUE))
        return np.where(kinds[bodies] == CLEAR, bodies, -1)

    def walls(self, bodies: Any, faces: Any) -> Any:
        """The number of the material of faces of bodies: their paint, where they have one."""
        numbers, (rows, painted) = self._of_body[bodies], self._paints
        if not len(rows):
            return numbers
        geometry = self.prepared.geometry
        first = geometry.integers[geometry.places[table.BODY_FACE] + np.maximum(bodies, 0)]
        at = first + faces
        place = np.minimum(np.searchsorted(rows, at), len(rows) - 1)
        return np.where((bodies >= 0) & (faces >= 0) & (rows[place] == at), painted[place], numbers)

    def each(self, numbers: Any, wavelength: Any, what: Callable[[Material, Any], Any], otherwise: Any) -> Any:
        """A quantity of materials at wavelengths, an item for each number; `otherwise` is that of vacuum."""
        result = np.full(np.shape(numbers), otherwise)
        for number in np.unique(numbers[numbers >= 0]).tolist():
            of = numbers == number
            result[of] = what(self.materials[number], wavelength[of])
        return result

    def index(self, numbers: Any, wavelength: Any) -> Any:
        """The complex index of materials, 1 of vacuum."""
        return self.each(numbers, wavelength, material_index, 1.0 + 0j)

    def absorption(self, numbers: Any, wavelength: Any) -> Any:
        """What fades per unit of length."""
        return self.each(numbers, wavelength, lambda m, w: absorption_at(m, w, self.unit), 0.0)

    def faded(self, weight: Any, numbers: Any, wavelength: Any, length: Any) -> Any:
        """What is left of light after lengths within materials (Beer); nothing at infinity of what fades at all."""
        rate = self.absorption(numbers, wavelength)
        return weight * np.exp(-np.where(rate > 0, rate * np.where(rate > 0, length, 0.0), 0.0))

    def unseen(self, wall: Any, before: Any, after: Any, wavelength: Any) -> Any:
        """Does light pass the wall of a transparent solid as if nothing were there? By numbers of materials.

        As in pictures (`kernels/body/media.py`), for one wavelength: the material is the same on both sides, or
        index and absorption are, and the wall itself neither takes any light away nor is coated.
        """
        same = before == after
        rest = np.flatnonzero(~same)
        wall, before, after, w = wall[rest], before[rest], after[rest], wavelength[rest]
        alike = self.index(before, w) == self.index(after, w)
        alike &= self.absorption(before, w) == self.absorption(after, w)
        alike &= self.each(wall, w, lambda m, at: amount_at(m.transparency, at), 1.0) == 1.0
        alike &= self.each(wall, w, lambda m, at: np.full(len(at), float(m.coating is None)), 1.0) == 1.0
        same[rest] = alike
        return same


# The walls that light notices along rays, and how it parts there.

_CASES = ((True, None, None), (False, True, True), (False, True, False), (False, False, None))
"""Kinds of walls: is it opaque, that of a solid, entered? None is either."""


@dataclass
class WallHits:
    """The first walls that light notices; arrays of one item for each ray, flat."""

    hits: Hits
    before: Any  # transparent bodies that the ray is in, -1 for none; of a miss the given one
    after: Any
    wall: Any  # the number of the wall's material
    opaque: Any  # bool


def find_walls(scene: Any, media: SceneMedia, rays: Rays, medium: Any, wavelength: Any) -> WallHits:
    """What rays meet; `medium`: the bodies that they are in, which counts where they meet nothing.

    The rule of Whitted's pictures (`render/integrators/whitted.py`): what coincides is taken together, an opaque
    surface is always noticed, and so is a transparent one unless what is before and after it is the same to light.
    """
    rows, t_min = np.arange(rays.size), np.zeros(rays.size)
    parts: list[tuple[Any, Hits, Any, Any, Any, Any]] = []
    while len(rows) or not parts:
        hits = scene.first_hit(rays if not parts else rays[rows], t_min=t_min)
        sides, body = hits._sides, hits.body
        before, after = media.clear(sides[BEFORE]), media.clear(sides[AFTER])
        opaque = sides[BLOCKER] >= 0
        wall = np.where(
            opaque & (sides[BLOCKER] != body), media.inside(sides[BLOCKER]), media.walls(body, hits.face)
        )  # fmt: skip
        on = hits.hit & ~opaque & (np.append(media.kinds, np.int8(0))[body] == CLEAR)
        some = np.flatnonzero(on)
        on[some] = media.unseen(
            wall[some], media.inside(before[some]), media.inside(after[some]), wavelength[rows[some]]
        )  # fmt: skip
        here = np.flatnonzero(~on)
        if not parts and len(here) == rays.size:
            return WallHits(hits, np.where(hits.hit, before, medium), after, wall, opaque)
        parts.append((rows[here], hits[here], before[here], after[here], wall[here], opaque[here]))
        rows, t_min = rows[on], hits.t[on]
    order = np.argsort(np.concatenate([part[0] for part in parts]), kind="stable")
    hits = Hits.concatenate([part[1] for part in parts])[order]
    before, after, wall, opaque = (np.concatenate([part[k] for part in parts])[order] for k in range(2, 6))
    return WallHits(hits, np.where(hits.hit, before, medium), after, wall, opaque)


@dataclass
class LightSplit:
    """How light parts at walls: shares that are mirrored and let through, and where they go. What is missing stays."""

    mirrored: Any
    passed: Any
    reflected: Any  # directions
    refracted: Any


def split_light(media: SceneMedia, met: WallHits, directions: Any, wavelength: Any) -> LightSplit:
    """How light along unit directions parts at the walls that it has met; all must be hits."""
    hits, normals = met.hits, met.hits.normal
    cosine = np.clip(abs((directions * normals).sum(axis=1)), 0.0, 1.0)
    n1 = media.index(media.inside(met.before), wavelength)
    n2 = media.index(media.inside(met.after), wavelength)
    is_solid = np.append(media.kinds, np.int8(0))[hits.body] == CLEAR
    mirrored, passed = np.zeros(len(cosine)), np.zeros(len(cosine))
    for number in np.unique(met.wall).tolist():
        material = media.materials[number]
        for opaque, solid, entering in _CASES:
            of = (met.wall == number) & (met.opaque == opaque)
            of &= True if solid is None else is_solid == solid
            of &= True if entering is None else hits.entering == entering
            rows = np.flatnonzero(of)
            if len(rows):
                at = wavelength[rows], cosine[rows], n1[rows].real
                kind = _opaque if opaque else _wall if solid else _pane
                mirrored[rows], passed[rows] = kind(material, *at, n2[rows], entering is not False)
    eta = n1.real / n2.real
    refracted, total = refract(directions, normals, np.where(met.opaque, 1.0, eta))
    passed = np.where(total, 0.0, passed)
    return LightSplit(mirrored, passed, reflect(directions, normals), refracted)


def _opaque(material: Material, w: Any, cosine: Any, n1: Any, beyond: Any, outside: bool) -> tuple[Any, Any]:
    """Of what lets nothing through: by its complex index or coat, else by its reflectivity."""
    del beyond, outside
    index = metal_at(material, w)
    if material.coating is not None:
        return material.coating.at(w, cosine, n1, index).reflectance, 0.0
    if np.iscomplexobj(index):
        return fresnel(cosine, n1, index).reflectance, 0.0
    return _mirror(material, w, cosine), 0.0


def _mirror(material: Material, w: Any, cosine: Any) -> Any:
    """The reflectivity of a material, with Schlick's rise towards grazing angles where it has that."""
    share = amount_at(material.reflectivity, w)
    return share + (1 - share) * (1 - cosine) ** 5 if material.fresnel else share


def _at_wall(coating: Coating | None, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> Fresnel:
    if coating is None:
        return fresnel(cosine, n1, n2)
    return (coating if outside else coating.reversed()).at(w, cosine, n1, n2)


def _wall(material: Material, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> tuple[Any, Any]:
    """Of the wall of a transparent solid."""
    found = _at_wall(material.coating, w, cosine, n1, n2, outside)
    return found.reflectance, found.transmittance * amount_at(material.transparency, w)


def _pane(material: Material, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> tuple[Any, Any]:
    """Of a transparent sheet: its films, or its reflectivity."""
    if material.coating is not None:
        return _wall(material, w, cosine, n1, n2, outside)
    share = _mirror(material, w, cosine)
    return share, (1 - share) * amount_at(material.transparency, w)
