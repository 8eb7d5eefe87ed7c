"""What light of one wavelength meets in a scene: the media and walls of its bodies, by their materials."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from ..engine import tables as table
from ..engine.body.sides import CLEAR, OPAQUE
from ..shapes.color import amount_rgb
from ..shapes.dispersion import LINE_D, index_at
from ..shapes.material import DEFAULT, Material

_CHANNELS = (0.45, 0.55, 0.65)
"""Where blue, green and red are in μm, for amounts that are colours: linear between them, and constant beyond."""


def amount_at(amount: Any, wavelength: Any) -> Any:
    """An amount of a material, one number or a colour, at wavelengths."""
    r, g, b = amount_rgb(amount)
    return np.full(np.shape(wavelength), r) if r == g == b else np.interp(wavelength, _CHANNELS, (b, g, r))


def index_of(material: Material, wavelength: Any) -> Any:
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


class Media:
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
            known[DEFAULT if made is None else made] = None
        return list(known)

    @cached_property
    def _numbers(self) -> dict[Material, int]:
        return {material: number for number, material in enumerate(self.materials)}

    @cached_property
    def _of_body(self) -> Any:
        """The number of each body's material, and -1 for no body in the last place."""
        made = self.prepared.labels.materials_of(np.arange(self.prepared.lowered.body_count))
        found = [self._numbers[DEFAULT if one is None else one] for one in made.tolist()]
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
        return self.each(numbers, wavelength, index_of, 1.0 + 0j)

    def absorption(self, numbers: Any, wavelength: Any) -> Any:
        """What fades per unit of length."""
        return self.each(numbers, wavelength, lambda m, w: absorption_at(m, w, self.unit), 0.0)

    def faded(self, weight: Any, numbers: Any, wavelength: Any, length: Any) -> Any:
        """What is left of light after lengths within materials (Beer); nothing at infinity of what fades at all."""
        rate = self.absorption(numbers, wavelength)
        return weight * np.exp(-np.where(rate > 0, rate * np.where(rate > 0, length, 0.0), 0.0))

    def unseen(self, wall: Any, before: Any, after: Any, wavelength: Any) -> Any:
        """Does light pass the wall of a transparent solid as if nothing were there? By numbers of materials.

        As `shading/media.py` says it for pictures, but for one wavelength: the material is the same on both sides, or
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
