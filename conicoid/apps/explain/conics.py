"""Sections of surfaces with a plane: conics by branches, each with a parameter, and the arcs that are walls of a body.

A section is restricted to the plane exactly and classified in floats. Short rays decide which parts of it are walls.
"""

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
    """One connected piece of a conic, x(s) = center + (p(s), q(s)) frame in the plane, s from `first` to `last`.

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
        """Whether the branch is an ellipse."""
        return self.kind == ELLIPSE

    def own(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return p (n,) and q (n,) at parameters."""
        if self.kind == ELLIPSE:
            return self.a * np.cos(s), self.b * np.sin(s)
        if self.kind == HYPERBOLA:
            return self.a * np.cosh(s), self.b * np.sinh(s)
        if self.kind == PARABOLA:
            return s, self.a * s * s + self.b
        return s, np.full_like(s, self.a)

    def points(self, s: FloatArray) -> FloatArray:
        """Return the places (n, 2) in the plane at parameters."""
        p, q = self.own(np.asarray(s, np.float64))
        return np.asarray(np.stack([p, q], axis=-1) @ np.array(self.frame) + np.array(self.center))

    def normals(self, s: FloatArray) -> FloatArray:
        """Return unit vectors (n, 2) across the curve at parameters."""
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
    """Return (A, B, C, D, E, F) of A x² + 2B xy + C y² + 2D x + 2E y + F on the plane origin + x axes[0] + y axes[1].

    The largest of them is 1 or -1.
    """
    at, first, second = (tuple(map(Fraction, v)) for v in (origin, *axes))
    both = tuple(x + y for x, y in zip(first, second, strict=True))
    a, d, f = polynomial.on_ray(at, first)
    c, e, _ = polynomial.on_ray(at, second)
    # The mixed term, from the form on the sum of both axes: a + 2 b + c
    b = (polynomial.on_ray(at, both)[0] - a - c) / 2
    largest = max(map(abs, (a, b, c, d, e, f))) or Fraction(1)
    return tuple(float(value / largest) for value in (a, b, c, d, e, f))


def branches(coefficients: Sequence[float], reach: float) -> list[Branch]:
    """Return the branches of a conic within `reach` of the origin of the plane, or a little beyond."""
    a, b, c, d, e, f = coefficients
    # In units of the reach, coefficients are the sizes of their terms
    a, b, c, d, e = a * reach * reach, b * reach * reach, c * reach * reach, d * reach, e * reach
    # Principal axes, the larger eigenvalue first
    values, rows = np.linalg.eigh(np.array([[a, b], [b, c]]))
    order = np.argsort(-np.abs(values))
    (l1, l2), frame = values[order], rows[:, order].T
    g, h = frame @ (d, e)
    largest = max(abs(l1), abs(g), abs(h), abs(f))
    if largest == 0.0:
        return []
    tolerance = _NOTHING * largest
    if abs(l1) <= tolerance:
        pieces = _straight_branch(frame, float(g), float(h), f, tolerance)
    elif abs(l2) <= tolerance:
        pieces = _without_center(frame, float(l1), float(g), float(h), f, tolerance)
    else:
        pieces = _with_center(frame, float(l1), float(l2), float(g), float(h), f, tolerance)
    return [_scale_branch(branch, reach) for branch in pieces]


def _frame(rows: FloatArray) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return a (2, 2) array as tuples."""
    (p, q), (u, v) = rows.tolist()
    return (p, q), (u, v)


def _scale_branch(branch: Branch, by: float) -> Branch:
    """Return a branch scaled from units of the reach to those of the plane."""
    (x, y), kind = branch.center, branch.kind
    angles = kind in (ELLIPSE, HYPERBOLA)
    first, last = (branch.first, branch.last) if angles else (branch.first * by, branch.last * by)
    a, b = (branch.a / by, branch.b * by) if kind == PARABOLA else (branch.a * by, branch.b * by)
    return Branch(kind, (x * by, y * by), branch.frame, a, b, first, last)


def _line(frame: FloatArray, at: float) -> Branch:
    """Return the line q = at of a frame."""
    return Branch(LINE, (0.0, 0.0), _frame(frame), at, 0.0, -3.0, 3.0)


def _straight_branch(frame: FloatArray, g: float, h: float, f: float, tolerance: float) -> list[Branch]:
    """Return the line 2 g p + 2 h q + f = 0."""
    size = math.hypot(g, h)
    if size <= tolerance:
        return []
    across = np.array([g, h]) @ frame / size
    along = np.array([-across[1], across[0]])
    # A line farther than 3 reaches from the origin is outside of every window
    return [_line(np.array([along, across]), -f / (2 * size))] if abs(f) <= 6 * size else []


def _without_center(frame: FloatArray, l1: float, g: float, h: float, f: float, tolerance: float) -> list[Branch]:
    """Return the branches of l1 p² + 2 g p + 2 h q + f = 0: a parabola, or two lines."""
    if abs(h) <= tolerance:
        discriminant = g * g - l1 * f
        if discriminant <= 0.0:
            return []
        swapped = np.array([frame[1], frame[0]])
        return [_line(swapped, (-g + sign * math.sqrt(discriminant)) / l1) for sign in (-1, 1)]
    # The vertex: l1 (p - middle)² + 2 h q + (f - g² / l1) = 0
    middle = -g / l1
    center = np.array([middle, 0.0]) @ frame
    rise, foot = -l1 / (2 * h), -(f - g * g / l1) / (2 * h)
    return [Branch(PARABOLA, (float(center[0]), float(center[1])), _frame(frame), rise, foot, -4.0, 4.0)]


def _with_center(
    frame: FloatArray, l1: float, l2: float, g: float, h: float, f: float, tolerance: float
) -> list[Branch]:
    """Return the branches of l1 p² + l2 q² + 2 g p + 2 h q + f = 0: ellipse, hyperbola, or two lines that cross."""
    own = np.array([-g / l1, -h / l2])
    x, y = (own @ frame).tolist()
    # l1 p² + l2 q² = k about the center
    k = g * g / l1 + h * h / l2 - f
    if abs(k) <= tolerance:
        # A single point has no branch
        if l1 * l2 > 0:
            return []
        # Two lines through the center
        slope = math.sqrt(-l1 / l2)
        return [_line_through((x, y), np.array([1.0, sign * slope]) @ frame) for sign in (-1, 1)]
    if k / l1 > 0 and k / l2 > 0:
        return [Branch(ELLIPSE, (x, y), _frame(frame), math.sqrt(k / l1), math.sqrt(k / l2), 0.0, 2 * math.pi)]
    if k / l1 < 0 and k / l2 < 0:
        return []
    # The axis that the hyperbola crosses comes first
    real, other = (0, 1) if k / l1 > 0 else (1, 0)
    sizes = math.sqrt(abs(k / l1)), math.sqrt(abs(k / l2))
    ordered = np.array([frame[real], frame[other]])
    # Beyond these parameters both branches are outside of the window
    far = math.asinh((3.0 + math.hypot(x, y)) / sizes[other])
    return [Branch(HYPERBOLA, (x, y), _frame(ordered), sign * sizes[real], sizes[other], -far, far) for sign in (-1, 1)]


def _line_through(point: tuple[float, float], along: FloatArray) -> Branch:
    """Return the line through a point along a vector."""
    along = along / np.linalg.norm(along)
    across = np.array([-along[1], along[0]])
    return _line(np.array([along, across]), float(across @ point))


# The parts of a conic that are walls of a body: a short ray across them hits it.

_SAMPLES, _HALVINGS = 512, 22
"""Parameters that are tested along a branch, and halvings that refine each end of an arc."""
_SHORT = 1e-7
"""Half the length of a short ray, as a share of the drawing's reach."""
_LEAST = 1e-100
"""Smaller components are set to 0, as rays refuse them."""


@dataclass(frozen=True)
class Arc:
    """A part of a branch that is a wall of a body, from s = first to last, on the surface of a number."""

    surface: int
    branch: Branch
    first: float
    last: float


@dataclass(frozen=True)
class DrawingPlane:
    """The plane origin + x axes[0] + y axes[1], with orthonormal axes; the drawing shows `reach` about the origin."""

    origin: FloatArray
    axes: FloatArray
    reach: float

    def points(self, places: FloatArray) -> FloatArray:
        """Return places (n, 2) of the plane as points (n, 3) of the world."""
        return _flush_tiny(places @ self.axes + self.origin)

    def directions(self, places: FloatArray) -> FloatArray:
        """Return vectors (n, 2) of the plane as vectors (n, 3) of the world."""
        return _flush_tiny(places @ self.axes)

    def places(self, points: Any) -> FloatArray:
        """Return points (n, 3) of the world projected onto the plane, (n, 2)."""
        return np.asarray((np.asarray(points) - self.origin) @ self.axes.T)


def _flush_tiny(values: FloatArray) -> FloatArray:
    """Set components that are too small for a ray to 0."""
    return np.where(np.abs(values) < _LEAST, 0.0, values)


def wall_arcs(scene: Any, surface: int, branch: Branch, plane: DrawingPlane) -> list[Arc]:
    """Return the arcs of a branch that are walls of the only body of a scene."""
    s = _parameters(branch, plane.reach)
    here = is_wall(scene, branch, s, plane)
    if here.all():
        return [Arc(surface, branch, float(s[0]), float(s[-1]))]
    changes = np.flatnonzero(here[1:] != here[:-1])
    if not len(changes):
        return []
    ends = _refine_ends(scene, branch, s[changes], s[changes + 1], here[changes], plane).tolist()
    # Arcs are pairs of ends; the first and the last parameter are ends if they lie on a wall
    ends = ([float(s[0])] if here[0] else []) + ends + ([float(s[-1])] if here[-1] else [])
    arcs = [Arc(surface, branch, a, b) for a, b in zip(ends[::2], ends[1::2], strict=True)]
    if branch.is_closed and here[0] and here[-1] and len(arcs) > 1:  # s = first lies within an arc of the ellipse
        last = arcs.pop()
        arcs[0] = Arc(surface, branch, last.first - (branch.last - branch.first), arcs[0].last)
    return arcs


def _parameters(branch: Branch, reach: float) -> FloatArray:
    """Return the parameters to test, in rising order; more of them in the window of an ellipse much larger than it."""
    s = np.linspace(branch.first, branch.last, _SAMPLES + 1)
    if branch.kind != ELLIPSE or max(branch.a, branch.b) < 8 * reach:
        return s
    (x, y), (along, across) = branch.center, branch.frame
    # The window's middle in the frame of the ellipse: parameters by both coordinates
    p, q = -(x * along[0] + y * along[1]), -(x * across[0] + y * across[1])
    window = np.linspace(-2 * reach, 2 * reach, _SAMPLES)
    more = [np.arcsin(np.clip((q + window) / branch.b, -1, 1)), np.arccos(np.clip((p + window) / branch.a, -1, 1))]
    both = [more[0], np.pi - more[0], more[1], -more[1]]
    return np.unique(np.concatenate([s, *(each % (2 * np.pi) for each in both)]))


def is_wall(scene: Any, branch: Branch, s: FloatArray, plane: DrawingPlane) -> Any:
    """Return (n,) bool: is there a wall of the scene's body at each parameter?

    Short rays go both ways, as the body may be a one-sided sheet.
    """
    places, across = branch.points(s), plane.directions(branch.normals(s))
    # A short ray across the curve in each sense, from before it to behind it
    short, points = _SHORT * plane.reach, plane.points(places)
    hits = scene.occluded(_flush_tiny(points - short * across), across, 0.0, 2 * short)
    hits |= scene.occluded(_flush_tiny(points + short * across), -across, 0.0, 2 * short)
    return np.asarray(hits) & (np.abs(places).max(axis=1) <= 2 * plane.reach)


def _refine_ends(
    scene: Any, branch: Branch, low: FloatArray, high: FloatArray, here: Any, plane: DrawingPlane
) -> FloatArray:
    """Return the parameters (n,) between pairs low and high where a wall begins or ends, by halving."""
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        same = is_wall(scene, branch, middle, plane) == here
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
