"""Media and walls of a scene for light of one wavelength: indices, absorption, and the splitting of light at walls."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from ..._util.records import dataclass
from ...kernels import tables as table
from ...kernels.body.media import AFTER, BEFORE, BLOCKER, CLEAR, OPAQUE
from ...materials.coating import Coating, Fresnel, fresnel
from ...materials.color import amount_rgb
from ...materials.dispersion import LINE_D, index_at
from ...materials.material import DEFAULT_MATERIAL, Material
from ...queries.hits import Hits
from ...queries.rays import Rays
from .refraction import reflect, refract

_CHANNELS = (0.45, 0.55, 0.65)
"""Wavelengths of blue, green and red in μm, for amounts that are colours: linear between them, constant beyond."""


def amount_at(amount: Any, wavelength: Any) -> Any:
    """Return an amount of a material, one number or a colour, at wavelengths."""
    r, g, b = amount_rgb(amount)
    return np.full(np.shape(wavelength), r) if r == g == b else np.interp(wavelength, _CHANNELS, (b, g, r))


def material_index(material: Material, wavelength: Any) -> Any:
    """Return the refractive index of a material at wavelengths; `dispersion` is added to a constant index."""
    index = index_at(material.refractive_index, wavelength)
    if material.dispersion and isinstance(material.refractive_index, float):
        index = index + material.dispersion * (1 / np.square(wavelength) - 1 / LINE_D**2)
    return index


def metal_at(material: Material, wavelength: Any) -> Any:
    """Return the index of an opaque material at wavelengths: n + ik by the channels of a metal, else its own index."""
    if material.metal_index is None or material.metal_extinction is None:
        return index_at(material.refractive_index, wavelength)
    n = np.interp(wavelength, _CHANNELS, material.metal_index[::-1])
    return n + 1j * np.interp(wavelength, _CHANNELS, material.metal_extinction[::-1])


def absorption_at(material: Material, wavelength: Any, unit: float) -> Any:
    """Return the absorption per unit of length: the material's, and 4πk/λ of a complex index; unit: μm in a unit."""
    rate = amount_at(material.absorption, wavelength)
    index = index_at(material.refractive_index, wavelength)
    return rate + 4 * np.pi * np.imag(index) / wavelength * unit if np.iscomplexobj(index) else rate


class SceneMedia:
    """The materials of a scene's bodies for light. Body -1 is vacuum."""

    def __init__(self, scene: Any, unit: float) -> None:
        self.prepared = scene._prepared
        self.unit = unit
        self.kinds = self.prepared.kinds

    @cached_property
    def materials(self) -> list[Material]:
        """The distinct materials; the paints of single faces follow those of bodies."""
        distinct: dict[Material, None] = {}
        for made in (*(m for m, _ in self.prepared.labels.distinct), *self.prepared.lowered.face_paint.values()):
            distinct[DEFAULT_MATERIAL if made is None else made] = None
        return list(distinct)

    @cached_property
    def _numbers(self) -> dict[Material, int]:
        """Material -> its number."""
        return {material: number for number, material in enumerate(self.materials)}

    @cached_property
    def _of_body(self) -> Any:
        """The number of each body's material, with -1 for no body in the last place."""
        made = self.prepared.labels.materials_of(np.arange(self.prepared.lowered.body_count))
        found = [self._numbers[DEFAULT_MATERIAL if one is None else one] for one in made.tolist()]
        return np.array([*found, -1], np.int64)

    @cached_property
    def _paints(self) -> tuple[Any, Any]:
        """(rows of painted faces, rising; the numbers of their materials)."""
        paints = self.prepared.lowered.face_paint
        rows = sorted(paints)
        return np.array(rows, np.int64), np.array([self._numbers[paints[row]] for row in rows], np.int64)

    def inside(self, bodies: Any) -> Any:
        """Return the number of the material inside of bodies, -1 for vacuum."""
        return self._of_body[bodies]

    def clear(self, bodies: Any) -> Any:
        """Return the numbers of bodies, with -1 for all but transparent solids, which alone have light inside."""
        # Body -1 indexes the last entry, which is not clear.
        kinds = np.append(self.kinds, np.int8(OPAQUE))
        return np.where(kinds[bodies] == CLEAR, bodies, -1)

    def walls(self, bodies: Any, faces: Any) -> Any:
        """Return the number of the material of faces of bodies: the face's paint, if it has one."""
        numbers, (rows, painted) = self._of_body[bodies], self._paints
        if not len(rows):
            return numbers
        geometry = self.prepared.geometry
        first = geometry.integers[geometry.places[table.BODY_FACE] + np.maximum(bodies, 0)]
        at = first + faces
        place = np.minimum(np.searchsorted(rows, at), len(rows) - 1)
        return np.where((bodies >= 0) & (faces >= 0) & (rows[place] == at), painted[place], numbers)

    def each(self, numbers: Any, wavelength: Any, quantity: Callable[[Material, Any], Any], otherwise: Any) -> Any:
        """Return a quantity of materials at wavelengths, an item for each number; `otherwise` is that of vacuum."""
        result = np.full(np.shape(numbers), otherwise)
        for number in np.unique(numbers[numbers >= 0]).tolist():
            members = numbers == number
            result[members] = quantity(self.materials[number], wavelength[members])
        return result

    def index(self, numbers: Any, wavelength: Any) -> Any:
        """Return the complex index of materials, 1 for vacuum."""
        return self.each(numbers, wavelength, material_index, 1.0 + 0j)

    def absorption(self, numbers: Any, wavelength: Any) -> Any:
        """Return the absorption per unit of length."""
        return self.each(numbers, wavelength, lambda m, w: absorption_at(m, w, self.unit), 0.0)

    def attenuate(self, weight: Any, numbers: Any, wavelength: Any, length: Any) -> Any:
        """Return the remaining light after lengths within materials (Beer); 0 after infinity in an absorbing one."""
        rate = self.absorption(numbers, wavelength)
        # A rate of 0 times an infinite length would be NaN.
        return weight * np.exp(-np.where(rate > 0, rate * np.where(rate > 0, length, 0.0), 0.0))

    def is_unseen(self, wall: Any, before: Any, after: Any, wavelength: Any) -> Any:
        """Return whether light passes the wall of a transparent solid unchanged. Arguments are numbers of materials.

        The rule is that of pictures (`kernels/body/media.py`), for one wavelength: the material is the same on both
        sides, or index and absorption are, and the wall itself neither takes any light away nor is coated.
        """
        same = before == after
        rest = np.flatnonzero(~same)
        wall, before, after, w = wall[rest], before[rest], after[rest], wavelength[rest]
        # Rows of equal materials need no comparison of numbers.
        is_invisible = self.index(before, w) == self.index(after, w)
        is_invisible &= self.absorption(before, w) == self.absorption(after, w)
        is_invisible &= self.each(wall, w, lambda m, at: amount_at(m.transparency, at), 1.0) == 1.0
        is_invisible &= self.each(wall, w, lambda m, at: np.full(len(at), float(m.coating is None)), 1.0) == 1.0
        same[rest] = is_invisible
        return same


# The walls that affect light along rays, and the splitting of light there.

_CASES = ((True, None, None), (False, True, True), (False, True, False), (False, False, None))
"""Kinds of walls: opaque, of a solid, entered. None is either."""


@dataclass
class WallHits:
    """The first walls that affect light; flat arrays with one item for each ray."""

    hits: Hits
    before: Any  # transparent bodies that the ray is in, -1 for none; of a miss the `medium` of `find_walls`
    after: Any
    wall: Any  # the number of the wall's material
    opaque: Any  # bool

    def select(self, some: Any) -> WallHits:
        """Return the walls of some rays."""
        return WallHits(self.hits[some], self.before[some], self.after[some], self.wall[some], self.opaque[some])


def find_walls(scene: Any, media: SceneMedia, rays: Rays, medium: Any, wavelength: Any) -> WallHits:
    """Find the first wall of each ray; `medium`: the bodies that the rays are in, used for rays without a hit.

    The rule is that of Whitted's pictures (`render/integrators/whitted.py`): coincident surfaces count as one, an
    opaque surface always affects light, and so does a transparent one, unless the media before and after it are the
    same to light.
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
        on[some] = media.is_unseen(
            wall[some], media.inside(before[some]), media.inside(after[some]), wavelength[rows[some]]
        )  # fmt: skip
        here = np.flatnonzero(~on)
        # The usual case: no ray passed a wall unchanged, so no rows must be merged.
        if not parts and len(here) == rays.size:
            return WallHits(hits, np.where(hits.hit, before, medium), after, wall, opaque)
        parts.append((rows[here], hits[here], before[here], after[here], wall[here], opaque[here]))
        # These rays pass the wall unchanged: search on from there.
        rows, t_min = rows[on], hits.t[on]
    # Back into the order of the rays.
    order = np.argsort(np.concatenate([part[0] for part in parts]), kind="stable")
    hits = Hits.concatenate([part[1] for part in parts])[order]
    before, after, wall, opaque = (np.concatenate([part[k] for part in parts])[order] for k in range(2, 6))
    return WallHits(hits, np.where(hits.hit, before, medium), after, wall, opaque)


@dataclass
class LightSplit:
    """The splitting of light at walls: mirrored and transmitted shares, and directions. The wall keeps the rest."""

    mirrored: Any
    passed: Any
    reflected: Any  # directions
    refracted: Any


def split_light(media: SceneMedia, wall_hits: WallHits, directions: Any, wavelength: Any) -> LightSplit:
    """Split light along unit directions at its walls; all rays must be hits."""
    hits, normals = wall_hits.hits, wall_hits.hits.normal
    cosine = np.clip(abs((directions * normals).sum(axis=1)), 0.0, 1.0)
    n1 = media.index(media.inside(wall_hits.before), wavelength)
    n2 = media.index(media.inside(wall_hits.after), wavelength)
    is_solid = np.append(media.kinds, np.int8(0))[hits.body] == CLEAR
    mirrored, passed = np.zeros(len(cosine)), np.zeros(len(cosine))
    for number in np.unique(wall_hits.wall).tolist():
        material = media.materials[number]
        for opaque, solid, entering in _CASES:
            members = (wall_hits.wall == number) & (wall_hits.opaque == opaque)
            members &= True if solid is None else is_solid == solid
            members &= True if entering is None else hits.entering == entering
            rows = np.flatnonzero(members)
            if len(rows):
                at = wavelength[rows], cosine[rows], n1[rows].real
                kind = _opaque if opaque else _wall if solid else _pane
                mirrored[rows], passed[rows] = kind(material, *at, n2[rows], entering is not False)
    eta = n1.real / n2.real
    refracted, total = refract(directions, normals, np.where(wall_hits.opaque, 1.0, eta))
    # Rounding must not let light through in total reflection.
    passed = np.where(total, 0.0, passed)
    return LightSplit(mirrored, passed, reflect(directions, normals), refracted)


def _opaque(material: Material, w: Any, cosine: Any, n1: Any, beyond: Any, outside: bool) -> tuple[Any, Any]:
    """Return the shares of an opaque wall: by its complex index or coat, else by its reflectivity."""
    index = metal_at(material, w)
    if material.coating is not None:
        return material.coating.at(w, cosine, n1, index).reflectance, 0.0
    if np.iscomplexobj(index):
        return fresnel(cosine, n1, index).reflectance, 0.0
    return _mirror(material, w, cosine), 0.0


def _mirror(material: Material, w: Any, cosine: Any) -> Any:
    """Return the reflectivity of a material, with Schlick's rise towards grazing angles if it has that."""
    share = amount_at(material.reflectivity, w)
    return share + (1 - share) * (1 - cosine) ** 5 if material.fresnel else share


def _at_wall(coating: Coating | None, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> Fresnel:
    """Return Fresnel's shares of a wall, or those of its films; they are reversed for light from inside."""
    if coating is None:
        return fresnel(cosine, n1, n2)
    return (coating if outside else coating.reversed()).at(w, cosine, n1, n2)


def _wall(material: Material, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> tuple[Any, Any]:
    """Return the shares of the wall of a transparent solid."""
    shares = _at_wall(material.coating, w, cosine, n1, n2, outside)
    return shares.reflectance, shares.transmittance * amount_at(material.transparency, w)


def _pane(material: Material, w: Any, cosine: Any, n1: Any, n2: Any, outside: bool) -> tuple[Any, Any]:
    """Return the shares of a transparent sheet: by its films, or its reflectivity."""
    if material.coating is not None:
        return _wall(material, w, cosine, n1, n2, outside)
    share = _mirror(material, w, cosine)
    return share, (1 - share) * amount_at(material.transparency, w)
