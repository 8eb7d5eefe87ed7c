"""Curves of second order in a plane, each with its parameter: points, tangents, and where others cross it.

A point that a parameter gives is carried onto its conic by Newton's method, in coordinates about the window: so it lies
on the curve to rounding however far away the centre is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ..shapes.vector import FloatArray

Floats6: TypeAlias = tuple[float, float, float, float, float, float]
Pair: TypeAlias = tuple[float, float]
NEAR = 1e-3
"""Share by which a root of a crossing may be complex, or off, and still be looked at: breaks too many are harmless."""
_STEPS = 4


def value(conic: Any, points: Any) -> Any:
    """a x² + 2 b xy + c y² + 2 d x + 2 e y + f at points (..., 2)."""
    a, b, c, d, e, f = conic
    x, y = points[..., 0], points[..., 1]
    return (a * x + 2 * (b * y + d)) * x + (c * y + 2 * e) * y + f


def gradient(conic: Any, points: Any) -> FloatArray:
    """Half the gradient, (..., 2)."""
    a, b, c, d, e, _ = conic
    x, y = points[..., 0], points[..., 1]
    result: FloatArray = np.stack([a * x + b * y + d, b * x + c * y + e], axis=-1)
    return result


def carried_onto(conic: Floats6, points: FloatArray) -> FloatArray:
    """Points that are near to a conic, on it."""
    for _ in range(2):
        slope = gradient(conic, points)
        square = 2 * (slope * slope).sum(axis=-1)
        step = np.where(square > 0, value(conic, points) / np.where(square > 0, square, 1), 0.0)
        points = points - step[..., None] * slope
    return points


def meeting(one: Floats6, other: Any, points: FloatArray) -> FloatArray:
    """Points near to where a conic crosses others, there; those where they only touch stay on the first.

    other: six rows, a column for each point.
    """
    start = points
    for _ in range(_STEPS):
        p, q = 2 * gradient(one, points), 2 * gradient(other, points)
        det = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        size = np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1)
        steep = np.abs(det) > 1e-9 * size
        f, g = value(one, points), value(other, points)
        safe = np.where(steep, det, 1.0)
        step = np.stack([(f * q[:, 1] - g * p[:, 1]) / safe, (g * p[:, 0] - f * q[:, 0]) / safe], axis=1)
        points = np.where(steep[:, None], points - step, points)
    good: Any = np.isfinite(points).all(axis=1)
    return np.where(good[:, None], points, start)


def second_order(conic: Any, x: Pair, y: Pair) -> Any:
    """The bilinear form of the part of second order."""
    a, b, c, *_ = conic
    return a * x[0] * y[0] + b * (x[0] * y[1] + x[1] * y[0]) + c * x[1] * y[1]


def half_slope(conic: Any, at: Pair, x: Pair) -> Any:
    """Half the slope at a place, along x."""
    return second_order(conic, at, x) + conic[3] * x[0] + conic[4] * x[1]


def _at(conic: Any, at: Pair) -> float:
    return float(value(conic, np.array(at)))


def roots_of(polynomial: list[Any]) -> Any:
    """The complex roots, of numbers that may vanish."""
    numbers = np.array(polynomial)
    most = np.abs(numbers).max(initial=0.0)
    if not (most > 0 and np.isfinite(most)):
        return np.zeros(0)
    numbers = numbers / most
    numbers[np.abs(numbers) < 1e-300] = 0.0
    return np.roots(numbers)


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve. key: the same for curves that coincide; conic: it lies on, in floats about the middle of the window."""

    key: tuple[Any, ...]
    conic: Floats6
    kind: ClassVar[str]
    closed: ClassVar[bool] = False

    def plain(self, t: Any) -> FloatArray:
        """Points (n, 2) by the formula alone."""
        raise NotImplementedError

    def velocity(self, t: Any) -> FloatArray:
        """Derivatives (n, 2) of `plain`."""
        raise NotImplementedError

    def parameter(self, points: Any) -> FloatArray:
        """Of points (n, 2) on the curve."""
        raise NotImplementedError

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """(parameters near to which some of the conics (n, 6) may cross it, of each which it is)."""
        found = [(k, self.roots_with(tuple(others[k].tolist()))) for k in range(len(others))]
        t = np.concatenate([np.zeros(0), *(roots for _, roots in found)])
        return t, np.repeat(np.arange(len(others)), [len(roots) for _, roots in found])

    def roots_with(self, other: Any) -> FloatArray:
        """The same for one conic."""
        raise NotImplementedError

    def points(self, t: Any) -> FloatArray:
        """Points (n, 2) of parameters (n,), on the curve to rounding."""
        return carried_onto(self.conic, self.plain(np.asarray(t, float)))

    def crossings(self, others: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(parameters, points) where conics (n, 6) cross it, and perhaps some where they come near."""
        with np.errstate(all="ignore"):
            t, which = self.candidates(others)
            good = np.isfinite(t)
            found = meeting(self.conic, others[which[good]].T, self.points(t[good]))
        found = found[np.isfinite(found).all(axis=1)]
        return self.parameter(found), found

    def box(self) -> tuple[float, float, float, float]:
        """(left, bottom, right, top)"""
        return -math.inf, -math.inf, math.inf, math.inf


@dataclass(frozen=True, eq=False)
class StraightLine(Curve):
    """base + t direction, of length 1; the base is nearest to the middle."""

    kind = "line"
    base: Pair = field(init=False)
    direction: Pair = field(init=False)

    def __post_init__(self) -> None:
        _, _, _, d, e, f = self.conic
        size = math.hypot(d, e)
        away = -f / 2 / size
        object.__setattr__(self, "base", (away * (d / size), away * (e / size)))
        object.__setattr__(self, "direction", (-e / size, d / size))

    def plain(self, t: Any) -> FloatArray:
        points: FloatArray = np.array(self.base) + np.asarray(t)[:, None] * np.array(self.direction)
        return points

    def velocity(self, t: Any) -> FloatArray:
        return np.broadcast_to(np.array(self.direction), (len(t), 2))

    def parameter(self, points: Any) -> FloatArray:
        result: FloatArray = (points - np.array(self.base)) @ np.array(self.direction)
        return result

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """Roots of a t² + 2 b t + c; where it comes near to zero its middle."""
        rows, d, base = others.T, self.direction, self.base
        a, b, c = second_order(rows, d, d), half_slope(rows, base, d), value(rows, np.array(base))
        square = b * b - a * c
        real = square > -NEAR * b * b
        q = -(b + np.copysign(np.sqrt(np.maximum(square, 0.0)), b))
        t = np.concatenate([np.where(real, q / a, np.nan), np.where(real, c / q, np.nan)])
        return t, np.tile(np.arange(len(others)), 2)


@dataclass(frozen=True, eq=False)
class Parabola(Curve):
    """λ η² + 2 δ η + 2 ε ξ + φ = 0, by η; across: the direction of η, that of ξ is to its left."""

    kind = "parabola"
    across: Pair
    numbers: tuple[float, float, float, float]

    @property
    def _coefficients(self) -> tuple[Pair, Pair, Pair]:
        """Points of η⁰, η¹, η²."""
        (x, y), (square, over, along, f) = self.across, self.numbers
        low, middle, high = -f / along / 2, -over / along, -square / along / 2
        return (-low * y, low * x), (x - middle * y, y + middle * x), (-high * y, high * x)

    def plain(self, t: Any) -> FloatArray:
        low, middle, high = map(np.array, self._coefficients)
        points: FloatArray = low + np.asarray(t)[:, None] * (middle + np.asarray(t)[:, None] * high)
        return points

    def velocity(self, t: Any) -> FloatArray:
        _, middle, high = map(np.array, self._coefficients)
        slopes: FloatArray = middle + 2 * np.asarray(t)[:, None] * high
        return slopes

    def parameter(self, points: Any) -> FloatArray:
        result: FloatArray = points @ np.array(self.across)
        return result

    def roots_with(self, other: Any) -> FloatArray:
        low, middle, high = self._coefficients
        found = roots_of([
            second_order(other, high, high), 2 * second_order(other, middle, high),
            second_order(other, middle, middle) + 2 * half_slope(other, low, high), 2 * half_slope(other, low, middle),
            _at(other, low),
        ])  # fmt: skip
        size = np.abs(found).max(initial=0.0)
        result: FloatArray = found.real[np.abs(found.imag) <= NEAR * np.abs(found) + 1e-9 * size]
        return result
