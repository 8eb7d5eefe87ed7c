"""Which parts of a conic are walls of a body: those across which a short ray meets it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .conics import ELLIPSE, Branch

_SAMPLES, _HALVINGS = 512, 22
_SHORT = 1e-7
"""How long a short ray is, as a share of what is drawn."""
_LEAST = 1e-100
"""Smaller components are no ray's."""


@dataclass(frozen=True)
class Arc:
    """A part of a branch that is a wall of a body, from s = first to last."""

    surface: int
    branch: Branch
    first: float
    last: float


@dataclass(frozen=True)
class Plane:
    """origin + x axes[0] + y axes[1], with orthonormal axes, of which `reach` about the origin is drawn."""

    origin: FloatArray
    axes: FloatArray
    reach: float

    def points(self, places: FloatArray) -> FloatArray:
        """Places (n, 2) of the plane in the world."""
        return _settled(places @ self.axes + self.origin)

    def directions(self, places: FloatArray) -> FloatArray:
        """Vectors (n, 2) of the plane in the world."""
        return _settled(places @ self.axes)

    def places(self, points: Any) -> FloatArray:
        """Points of the world, dropped onto the plane: (n, 2)."""
        return np.asarray((np.asarray(points) - self.origin) @ self.axes.T)


def _settled(values: FloatArray) -> FloatArray:
    """Without what is too small for a ray."""
    return np.where(np.abs(values) < _LEAST, 0.0, values)


def walls(scene: Any, surface: int, branch: Branch, plane: Plane) -> list[Arc]:
    """The arcs of a branch that are walls of the only body of a scene."""
    s = _parameters(branch, plane.reach)
    here = is_wall(scene, branch, s, plane)
    if here.all():
        return [Arc(surface, branch, float(s[0]), float(s[-1]))]
    turns = np.flatnonzero(here[1:] != here[:-1])
    if not len(turns):
        return []
    ends = _refined(scene, branch, s[turns], s[turns + 1], here[turns], plane).tolist()
    ends = ([float(s[0])] if here[0] else []) + ends + ([float(s[-1])] if here[-1] else [])
    found = [Arc(surface, branch, a, b) for a, b in zip(ends[::2], ends[1::2], strict=True)]
    if branch.is_closed and here[0] and here[-1] and len(found) > 1:  # an ellipse's parameter begins within an arc
        last = found.pop()
        found[0] = Arc(surface, branch, last.first - (branch.last - branch.first), found[0].last)
    return found


def _parameters(branch: Branch, reach: float) -> FloatArray:
    """Parameters close enough everywhere, also of an ellipse that is far larger than what is drawn."""
    s = np.linspace(branch.first, branch.last, _SAMPLES + 1)
    if branch.kind != ELLIPSE or max(branch.a, branch.b) < 8 * reach:
        return s
    (x, y), (along, across) = branch.center, branch.frame
    p, q = -(x * along[0] + y * along[1]), -(x * across[0] + y * across[1])
    window = np.linspace(-2 * reach, 2 * reach, _SAMPLES)
    more = [np.arcsin(np.clip((q + window) / branch.b, -1, 1)), np.arccos(np.clip((p + window) / branch.a, -1, 1))]
    both = [more[0], np.pi - more[0], more[1], -more[1]]
    return np.unique(np.concatenate([s, *(each % (2 * np.pi) for each in both)]))


def is_wall(scene: Any, branch: Branch, s: FloatArray, plane: Plane) -> Any:
    """bool for each parameter: is there a wall of the scene's body? Short rays go both ways: it may be one-sided."""
    places, across = branch.points(s), plane.directions(branch.normals(s))
    short, points = _SHORT * plane.reach, plane.points(places)
    met = scene.occluded(_settled(points - short * across), across, 0.0, 2 * short)
    met |= scene.occluded(_settled(points + short * across), -across, 0.0, 2 * short)
    return np.asarray(met) & (np.abs(places).max(axis=1) <= 2 * plane.reach)


def _refined(scene: Any, branch: Branch, low: FloatArray, high: FloatArray, here: Any, plane: Plane) -> FloatArray:
    """Where walls begin and end between pairs of parameters, by halving."""
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        same = is_wall(scene, branch, middle, plane) == here
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
