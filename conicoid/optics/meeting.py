"""The walls that light notices along rays, and how it parts there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.answers.hits import Hits
from ..engine.answers.rays import Rays
from ..engine.body.sides import AFTER, BEFORE, BLOCKER, CLEAR
from ..shading.optics import reflect, refract
from ..shapes.coating import Coating
from ..shapes.fresnel import Fresnel, fresnel
from ..shapes.material import Material
from .media import Media, amount_at, metal_at

_CASES = ((True, None, None), (False, True, True), (False, True, False), (False, False, None))
"""Kinds of walls: is it opaque, that of a solid, entered? None is either."""


@dataclass
class Met:
    """The first walls that light notices; arrays of one item for each ray, flat."""

    hits: Hits
    before: Any  # transparent bodies that the ray is in, -1 for none; of a miss the given one
    after: Any
    wall: Any  # the number of the wall's material
    opaque: Any  # bool


def meet(scene: Any, media: Media, rays: Rays, medium: Any, wavelength: Any) -> Met:
    """What rays meet; `medium`: the bodies that they are in, which counts where they meet nothing.

    The rule is that of Whitted's pictures (`integrators/whitted.py`): what coincides is taken together, an opaque
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
            return Met(hits, np.where(hits.hit, before, medium), after, wall, opaque)
        parts.append((rows[here], hits[here], before[here], after[here], wall[here], opaque[here]))
        rows, t_min = rows[on], hits.t[on]
    order = np.argsort(np.concatenate([part[0] for part in parts]), kind="stable")
    hits = Hits.concatenate([part[1] for part in parts])[order]
    before, after, wall, opaque = (np.concatenate([part[k] for part in parts])[order] for k in range(2, 6))
    return Met(hits, np.where(hits.hit, before, medium), after, wall, opaque)


@dataclass
class Parted:
    """How light parts at walls: shares that are mirrored and let through, and where they go. What is missing stays."""

    mirrored: Any
    passed: Any
    reflected: Any  # directions
    refracted: Any


def part(media: Media, met: Met, directions: Any, wavelength: Any) -> Parted:
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
    return Parted(mirrored, passed, reflect(directions, normals), refracted)


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
