"""The curve in which a plane cuts a surface: a conic, by its kind, with a parameter along each of its branches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from .polynomial import Polynomial

ELLIPSE, HYPERBOLA, PARABOLA, LINE = "ellipse", "hyperbola", "parabola", "line"
_NOTHING = 1e-12
"""Share of the largest coefficient that counts as zero."""


@dataclass(frozen=True)
class Branch:
    """One connected piece of a conic, x(s) = center + frame (p(s), q(s)) in the plane, s from `first` to `last`.

    ellipse    (p, q) = (a cos s, b sin s)
    hyperbola  (a cosh s, b sinh s); a may be negative
    parabola   (s, a s² + b)
    line       (s, a)
    """

    kind: str
    center: tuple[float, float]
    frame: tuple[tuple[float, float], tuple[float, float]]
    a: float
    b: float
    first: float
    last: float

    @property
    def is_closed(self) -> bool:
        return self.kind == ELLIPSE

    def own(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(p, q) at parameters."""
        if self.kind == ELLIPSE:
            return self.a * np.cos(s), self.b * np.sin(s)
        if self.kind == HYPERBOLA:
            return self.a * np.cosh(s), self.b * np.sinh(s)
        if self.kind == PARABOLA:
            return s, self.a * s * s + self.b
        return s, np.full_like(s, self.a)

    def points(self, s: FloatArray) -> FloatArray:
        """(n, 2) places in the plane."""
        p, q = self.own(np.asarray(s, np.float64))
        return np.asarray(np.stack([p, q], axis=-1) @ np.array(self.frame) + np.array(self.center))

    def normals(self, s: FloatArray) -> FloatArray:
        """(n, 2) unit vectors across the curve."""
        s = np.asarray(s, np.float64)
        if self.kind == ELLIPSE:
            p, q = self.b * np.cos(s), self.a * np.sin(s)
        elif self.kind == HYPERBOLA:
            p, q = self.b * np.cosh(s), -self.a * np.sinh(s)
        elif self.kind == PARABOLA:
            p, q = -2 * self.a * s, np.ones_like(s)
        else:
            p, q = np.zeros_like(s), np.ones_like(s)
        across = np.stack([p, q], axis=-1) @ np.array(self.frame)
        return np.asarray(across / np.linalg.norm(across, axis=-1, keepdims=True))


def restrict_to_plane(
    polynomial: Polynomial, origin: Sequence[float], axes: Sequence[Sequence[float]]
) -> tuple[float, ...]:
    """(A, B, C, D, E, F) of A x² + 2B xy + C y² + 2D x + 2E y + F on the plane origin + x axes[0] + y axes[1].

    The largest of them is 1 or -1.
    """
    at, first, second = (tuple(map(Fraction, v)) for v in (origin, *axes))
    both = tuple(x + y for x, y in zip(first, second, strict=True))
    a, d, f = polynomial.on_ray(at, first)
    c, e, _ = polynomial.on_ray(at, second)
    b = (polynomial.on_ray(at, both)[0] - a - c) / 2
    largest = max(map(abs, (a, b, c, d, e, f))) or Fraction(1)
    return tuple(float(value / largest) for value in (a, b, c, d, e, f))


def branches(coefficients: Sequence[float], reach: float) -> list[Branch]:
    """The branches of a conic, as far as they lie within `reach` of the origin of the plane, or a little beyond."""
    a, b, c, d, e, f = coefficients
    # In units of the reach all coefficients tell how much their terms matter
    a, b, c, d, e = a * reach * reach, b * reach * reach, c * reach * reach, d * reach, e * reach
    values, rows = np.linalg.eigh(np.array([[a, b], [b, c]]))
    order = np.argsort(-np.abs(values))
    (l1, l2), frame = values[order], rows[:, order].T
    g, h = frame @ (d, e)
    largest = max(abs(l1), abs(g), abs(h), abs(f))
    if largest == 0.0:
        return []
    nothing = _NOTHING * largest
    if abs(l1) <= nothing:
        found = _straight(frame, float(g), float(h), f, nothing)
    elif abs(l2) <= nothing:
        found = _without_center(frame, float(l1), float(g), float(h), f, nothing)
    else:
        found = _with_center(frame, float(l1), float(l2), float(g), float(h), f, nothing)
    return [_scaled(branch, reach) for branch in found]


def _frame(rows: FloatArray) -> tuple[tuple[float, float], tuple[float, float]]:
    (p, q), (u, v) = rows.tolist()
    return (p, q), (u, v)


def _scaled(branch: Branch, by: float) -> Branch:
    """In units of the plane."""
    (x, y), kind = branch.center, branch.kind
    angles = kind in (ELLIPSE, HYPERBOLA)
    first, last = (branch.first, branch.last) if angles else (branch.first * by, branch.last * by)
    a, b = (branch.a / by, branch.b * by) if kind == PARABOLA else (branch.a * by, branch.b * by)
    return Branch(kind, (x * by, y * by), branch.frame, a, b, first, last)


def _line(frame: FloatArray, at: float) -> Branch:
    """The line q = at of a frame."""
    return Branch(LINE, (0.0, 0.0), _frame(frame), at, 0.0, -3.0, 3.0)


def _straight(frame: FloatArray, g: float, h: float, f: float, nothing: float) -> list[Branch]:
    """2 g p + 2 h q + f = 0"""
    size = math.hypot(g, h)
    if size <= nothing:
        return []
    across = np.array([g, h]) @ frame / size
    along = np.array([-across[1], across[0]])
    return [_line(np.array([along, across]), -f / (2 * size))] if abs(f) <= 6 * size else []


def _without_center(frame: FloatArray, l1: float, g: float, h: float, f: float, nothing: float) -> list[Branch]:
    """l1 p² + 2 g p + 2 h q + f = 0: a parabola, or two lines."""
    if abs(h) <= nothing:
        discriminant = g * g - l1 * f
        if discriminant <= 0.0:
            return []
        turned = np.array([frame[1], frame[0]])
        return [_line(turned, (-g + sign * math.sqrt(discriminant)) / l1) for sign in (-1, 1)]
    middle = -g / l1
    center = np.array([middle, 0.0]) @ frame
    rise, foot = -l1 / (2 * h), -(f - g * g / l1) / (2 * h)
    return [Branch(PARABOLA, (float(center[0]), float(center[1])), _frame(frame), rise, foot, -4.0, 4.0)]


def _with_center(frame: FloatArray, l1: float, l2: float, g: float, h: float, f: float, nothing: float) -> list[Branch]:
    """l1 p² + l2 q² + 2 g p + 2 h q + f = 0: an ellipse, a hyperbola, or two lines that cross."""
    own = np.array([-g / l1, -h / l2])
    x, y = (own @ frame).tolist()
    k = g * g / l1 + h * h / l2 - f
    if abs(k) <= nothing:
        if l1 * l2 > 0:
            return []
        slope = math.sqrt(-l1 / l2)
        return [_through((x, y), np.array([1.0, sign * slope]) @ frame) for sign in (-1, 1)]
    if k / l1 > 0 and k / l2 > 0:
        return [Branch(ELLIPSE, (x, y), _frame(frame), math.sqrt(k / l1), math.sqrt(k / l2), 0.0, 2 * math.pi)]
    if k / l1 < 0 and k / l2 < 0:
        return []
    real, other = (0, 1) if k / l1 > 0 else (1, 0)
    sizes = math.sqrt(abs(k / l1)), math.sqrt(abs(k / l2))
    turned = np.array([frame[real], frame[other]])
    far = math.asinh((3.0 + math.hypot(x, y)) / sizes[other])
    return [Branch(HYPERBOLA, (x, y), _frame(turned), sign * sizes[real], sizes[other], -far, far) for sign in (-1, 1)]


def _through(point: tuple[float, float], along: FloatArray) -> Branch:
    """A line through a point."""
    along = along / np.linalg.norm(along)
    across = np.array([-along[1], along[0]])
    return _line(np.array([along, across]), float(across @ point))


# Which parts of a conic are walls of a body: those across which a short ray meets it.

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
class DrawingPlane:
    """origin + x axes[0] + y axes[1], with orthonormal axes, of which `reach` about the origin is drawn."""

    origin: FloatArray
    axes: FloatArray
    reach: float

    def points(self, places: FloatArray) -> FloatArray:
        """Places (n, 2) of the plane in the world."""
        return _flush_tiny(places @ self.axes + self.origin)

    def directions(self, places: FloatArray) -> FloatArray:
        """Vectors (n, 2) of the plane in the world."""
        return _flush_tiny(places @ self.axes)

    def places(self, points: Any) -> FloatArray:
        """Points of the world, dropped onto the plane: (n, 2)."""
        return np.asarray((np.asarray(points) - self.origin) @ self.axes.T)


def _flush_tiny(values: FloatArray) -> FloatArray:
    """Without what is too small for a ray."""
    return np.where(np.abs(values) < _LEAST, 0.0, values)


def wall_arcs(scene: Any, surface: int, branch: Branch, plane: DrawingPlane) -> list[Arc]:
    """The arcs of a branch that are walls of the only body of a scene."""
    s = _parameters(branch, plane.reach)
    here = is_wall(scene, branch, s, plane)
    if here.all():
        return [Arc(surface, branch, float(s[0]), float(s[-1]))]
    turns = np.flatnonzero(here[1:] != here[:-1])
    if not len(turns):
        return []
    ends = _refine_ends(scene, branch, s[turns], s[turns + 1], here[turns], plane).tolist()
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


def is_wall(scene: Any, branch: Branch, s: FloatArray, plane: DrawingPlane) -> Any:
    """bool for each parameter: is there a wall of the scene's body? Short rays go both ways: it may be one-sided."""
    places, across = branch.points(s), plane.directions(branch.normals(s))
    short, points = _SHORT * plane.reach, plane.points(places)
    met = scene.occluded(_flush_tiny(points - short * across), across, 0.0, 2 * short)
    met |= scene.occluded(_flush_tiny(points + short * across), -across, 0.0, 2 * short)
    return np.asarray(met) & (np.abs(places).max(axis=1) <= 2 * plane.reach)


def _refine_ends(
    scene: Any, branch: Branch, low: FloatArray, high: FloatArray, here: Any, plane: DrawingPlane
) -> FloatArray:
    """Where walls begin and end between pairs of parameters, by halving."""
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        same = is_wall(scene, branch, middle, plane) == here
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
