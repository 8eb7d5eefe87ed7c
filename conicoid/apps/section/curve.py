"""Curves of second order in a plane, with parameters: points, velocities, and crossings with other conics.

A point of a parameter is projected onto its conic by Newton's method, in coordinates about the window. So it lies on
the curve to rounding, however far away the centre is.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import field
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass

Floats6: TypeAlias = tuple[float, float, float, float, float, float]
Pair: TypeAlias = tuple[float, float]
NEAR = 1e-3
"""Relative tolerance for roots of crossings that are complex, or off the curve. Breaks too many are harmless."""
_LEAD = 1e-9
"""Share of the largest coefficient of a resultant below which a leading one is left out: roots are refined later."""
_STEPS = 4
"""Newton steps of a crossing."""


def form_value(conic: Any, points: Any) -> Any:
    """Return a x² + 2 b xy + c y² + 2 d x + 2 e y + f at points (..., 2)."""
    a, b, c, d, e, f = conic
    x, y = points[..., 0], points[..., 1]
    return (a * x + 2 * (b * y + d)) * x + (c * y + 2 * e) * y + f


def form_gradient(conic: Any, points: Any) -> FloatArray:
    """Return half the gradient at points (..., 2), (..., 2)."""
    a, b, c, d, e, _ = conic
    x, y = points[..., 0], points[..., 1]
    first = a * x + b * y + d
    gradient = np.empty((*first.shape, 2))
    gradient[..., 0], gradient[..., 1] = first, b * x + c * y + e
    return gradient


def project_onto(conic: Floats6, points: FloatArray) -> FloatArray:
    """Move points near a conic onto it, by two Newton steps along the gradient."""
    for _ in range(2):
        slope = form_gradient(conic, points)
        square = 2 * (slope[..., 0] * slope[..., 0] + slope[..., 1] * slope[..., 1])
        step = np.where(square > 0, form_value(conic, points) / np.where(square > 0, square, 1), 0.0)
        points = points - step[..., None] * slope
    return points


def refine_crossings(one: Any, other: Any, points: FloatArray) -> FloatArray:
    """Move points onto the crossings of two conics nearby; where they only touch, points stay on the first.

    one, other: six rows of coefficients, one column for each point.
    """
    start = points
    for _ in range(_STEPS):
        p, q = 2 * form_gradient(one, points), 2 * form_gradient(other, points)
        det = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        size = np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1)
        steep = np.abs(det) > 1e-9 * size  # at a touch the system is singular: no step
        f, g = form_value(one, points), form_value(other, points)
        safe = np.where(steep, det, 1.0)
        step = np.stack([(f * q[:, 1] - g * p[:, 1]) / safe, (g * p[:, 0] - f * q[:, 0]) / safe], axis=1)
        points = np.where(steep[:, None], points - step, points)
    # Points that diverge go back to where they began.
    good: Any = np.isfinite(points).all(axis=1)
    return np.where(good[:, None], points, start)


def second_order(conic: Any, x: Pair, y: Pair) -> Any:
    """Return the bilinear form of the quadratic part."""
    a, b, c, *_ = conic
    return a * x[0] * y[0] + b * (x[0] * y[1] + x[1] * y[0]) + c * x[1] * y[1]


def half_slope(conic: Any, at: Pair, x: Pair) -> Any:
    """Return half the slope at a place, along x."""
    return second_order(conic, at, x) + conic[3] * x[0] + conic[4] * x[1]


def _at(conic: Any, at: Pair) -> float:
    """Return the value of a conic at one place."""
    return float(form_value(conic, np.array(at)))


def real_roots_of(polynomial: Any) -> Any:
    """Return the complex roots of a polynomial, whose leading coefficients may be zero; none if all are."""
    numbers = np.array(polynomial)
    most = np.abs(numbers).max(initial=0.0)
    if not (most > 0 and np.isfinite(most)):
        return np.zeros(0)
    numbers = numbers / most
    numbers[np.abs(numbers) < 1e-300] = 0.0
    return np.roots(numbers)


@dataclass(frozen=True, eq=False)
class Curve(ABC):
    """A curve on a conic, with a parameter."""

    key: tuple[Any, ...]
    """Equal for curves that coincide."""
    conic: Floats6
    """The conic that the curve lies on, about the middle of the window."""
    closed: ClassVar[bool] = False

    @property
    def corners(self) -> tuple[float, ...]:
        """Parameters at which the curve is broken, besides its crossings."""
        return ()

    @property
    @abstractmethod
    def kind(self) -> str:
        """The kind in a word: line, ellipse, parabola or hyperbola."""

    def handle(self, h: float) -> float:
        """Return the length of the handles of a Bézier over h of the parameter, in velocities."""
        return h / 3

    @abstractmethod
    def plain(self, t: Any) -> FloatArray:
        """Return the points (n, 2) by the formula alone, without projection."""

    @abstractmethod
    def velocity(self, t: Any) -> FloatArray:
        """Return the derivatives (n, 2) of `plain`."""

    @abstractmethod
    def parameter(self, points: Any) -> FloatArray:
        """Return the parameters (n,) of points (n, 2) on the curve."""

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """Return (parameters near which conics (n, 6) may cross the curve, the index of the conic for each)."""
        by_conic = [(k, self.roots_with(tuple(others[k].tolist()))) for k in range(len(others))]
        # An empty array keeps the type if there are no conics.
        t = np.concatenate([np.zeros(0), *(roots for _, roots in by_conic)])
        return t, np.repeat(np.arange(len(others)), [len(roots) for _, roots in by_conic])

    def roots_with(self, other: Any) -> FloatArray:
        """Return the parameters near which one conic may cross the curve."""
        raise NotImplementedError

    def points(self, t: Any) -> FloatArray:
        """Return the points (n, 2) of parameters (n,), on the curve to rounding."""
        return self.onto(self.plain(np.asarray(t, float)))

    def onto(self, points: FloatArray) -> FloatArray:
        """Move points (n, 2) that the formula gives onto the curve."""
        return project_onto(self.conic, points)

    def own(self, points: FloatArray) -> FloatArray:
        """Return those of points (n, 2) of the conic that are on the curve."""
        return points

    def starts(self, others: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points (n, 2) of the curve from which crossings with conics (m, 6) are refined, and these (n, 6)."""
        with np.errstate(all="ignore"):
            t, which = self.candidates(others)
            good = np.isfinite(t)
            return self.points(t[good]), others[which[good]]

    def box(self) -> tuple[float, float, float, float]:
        """Return (left, bottom, right, top) of a box around the curve."""
        return -math.inf, -math.inf, math.inf, math.inf


def crossings(curves: Sequence[Curve], others: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the points (n, 2) where each curve is crossed by its conics (m, 6), and perhaps where they come near it.

    The points of all curves are refined together.
    """
    starts = [curve.starts(conics) for curve, conics in zip(curves, others, strict=True)]
    counts = [len(points) for points, _ in starts]
    own = np.repeat(np.array([curve.conic for curve in curves]), counts, axis=0)
    points, conics = (np.concatenate(parts) for parts in zip(*starts, strict=True))
    with np.errstate(all="ignore"):
        places = refine_crossings(own.T, conics.T, points)
    parts = np.split(places, np.cumsum(counts)[:-1])
    return [curve.own(part[np.isfinite(part).all(axis=1)]) for curve, part in zip(curves, parts, strict=True)]


@dataclass(frozen=True, eq=False)
class StraightLine(Curve):
    """The line base + t direction. The direction has length 1, and the base is the point nearest to the middle."""

    kind = "line"
    base: Pair = field(init=False)
    direction: Pair = field(init=False)

    def __post_init__(self) -> None:
        _, _, _, d, e, f = self.conic
        size = math.hypot(d, e)
        distance = -f / 2 / size
        vars(self).update(base=(distance * (d / size), distance * (e / size)), direction=(-e / size, d / size))

    def plain(self, t: Any) -> FloatArray:
        return np.array(self.base) + np.asarray(t)[:, None] * np.array(self.direction)

    def velocity(self, t: Any) -> FloatArray:
        return np.broadcast_to(np.array(self.direction), (len(t), 2))

    def parameter(self, points: Any) -> FloatArray:
        return (points - np.array(self.base)) @ np.array(self.direction)

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """Return the roots of a t² + 2 b t + c on the line; its vertex where it only comes near zero."""
        rows, d, base = others.T, self.direction, self.base
        a, b, c = second_order(rows, d, d), half_slope(rows, base, d), form_value(rows, np.array(base))
        square = b * b - a * c
        # At the base itself b vanishes, so c counts by the size of its terms: a curve that touches there is near, too
        size = form_value(np.abs(rows), np.abs(base))
        real = square >= -NEAR * (b * b + NEAR * np.abs(a) * size)
        # The larger root as q / a and the smaller as c / q: neither cancels.
        q = -(b + np.copysign(np.sqrt(np.maximum(square, 0.0)), b))
        t = np.concatenate([np.where(real, q / a, np.nan), np.where(real, c / q, np.nan)])
        return t, np.tile(np.arange(len(others)), 2)


@dataclass(frozen=True, eq=False)
class Graph(Curve):
    """A root y(t) of the conic over a line: the places base + unit (t axis + y (axis turned to the left)).

    The conic is A y² + 2 (B t + D) y + C t² + 2 E t + F, with B² - A C and the rest of the discriminant from exact
    numbers. So parabolas, and ellipses and hyperbolas that look like parabolas or lines in the window, keep their
    digits: neither a centre nor an axis enters.
    """

    kind: str = ""
    base: Pair = (0.0, 0.0)
    axis: Pair = (1.0, 0.0)
    unit: float = 1.0
    numbers: Floats6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """A to F, in the order of other conics in y and t: A, B, C, D, E, F."""
    square: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The coefficients of t², t and 1 in the discriminant."""
    sign: float = 1.0
    """Of its root."""
    whole: tuple[Pair, Pair, Pair] | None = None
    """For an ellipse: its centre, the direction of its first half-axis, and both half-axes."""

    @property
    def _frame(self) -> tuple[Pair, Pair]:
        """The vectors of t and y."""
        x, y = self.unit * self.axis[0], self.unit * self.axis[1]
        return (x, y), (-y, x)

    def _roots(self, t: Any) -> Any:
        """Return y; NaN where there is none."""
        a, b, c, d, e, f = self.numbers
        p, q, r = self.square
        middle, value = b * t + d, (c * t + 2 * e) * t + f
        with np.errstate(all="ignore"):
            root = self.sign * np.sqrt((p * t + q) * t + r)
            # Of the two forms of a root, the one in which nothing cancels.
            return np.where(middle * root > 0, -value / (middle + root), (root - middle) / a)

    def plain(self, t: Any) -> FloatArray:
        along, over = self._frame
        return np.array(self.base) + np.outer(t, along) + np.outer(self._roots(np.asarray(t)), over)

    def velocity(self, t: Any) -> FloatArray:
        a, b, c, d, e, _ = self.numbers
        y, (along, over) = self._roots(np.asarray(t)), self._frame
        with np.errstate(all="ignore"):
            return np.array(along) + np.outer(-(b * y + c * t + e) / (a * y + b * t + d), over)

    def parameter(self, points: Any) -> FloatArray:
        return (points - np.array(self.base)) @ np.array(self.axis) / self.unit

    def roots_with(self, other: Any) -> FloatArray:
        """Return the roots of the resultant by y, of degree four, of both signs."""
        along, over = self._frame
        base = self.base
        a, b, c, d, e, f = self.numbers
        middle, value = np.array([b, d]), np.array([c, 2 * e, f])
        high = second_order(other, over, over)
        other_middle = np.array([second_order(other, along, over), half_slope(other, base, over)])
        other_value = np.array([
            second_order(other, along, along), 2 * half_slope(other, base, along), _at(other, base)
        ])  # fmt: skip
        mixed = np.convolve(middle, other_value) - np.convolve(other_middle, value)
        if high == 0 and not other_middle.any():
            # Lines along y, as the axis of a parabola: its resultant with A = 0 is zero, whatever crosses it.
            square, rest = np.array([0.0, 0.0, *other_value]), other_middle
        elif high == 0:
            # Here the resultant has the factor A, which may be zero itself.
            square, rest = a * np.convolve(other_value, other_value), other_middle
        else:
            difference, rest = a * other_value - high * value, a * other_middle - high * middle
            square = np.convolve(difference, difference)
        resultant = square - 4 * np.convolve(rest, mixed)
        # In the window |t| < 1, where small leading coefficients do not count. Their roots, far away, would cost digits
        # of the others.
        large = np.abs(resultant) > _LEAD * np.abs(resultant).max()
        roots = real_roots_of(resultant[large.argmax() :])
        # A nearly double root comes out complex: its real part is kept as a candidate.
        return roots.real[np.abs(roots.imag) <= NEAR * (1 + np.abs(roots))]


# --- Curves with a centre: ellipses, and branches of hyperbolas


@dataclass(frozen=True, eq=False)
class _Central(Curve):
    """The curve center + r C(t0 + t) axis + s S(t0 + t) (axis turned to the left).

    C and S are cosine and sine, or hyperbolic cosine and sine.

    t = 0 is a place on the curve near the middle of the window. Places and parameters are computed from there. Curves
    of a far centre or a long half-axis are a `Graph`.
    """

    center: Pair
    axis: Pair
    radii: Pair
    start: Pair = field(init=False)
    """C(t0) and S(t0)."""
    base: Pair = field(init=False)
    """The place of t = 0."""

    def __post_init__(self) -> None:
        c, s = self._own(-np.array(self.center)[None])
        # t = 0 is a place near the middle of the window, which has the coordinates 0.
        start = self._nearest(float(c[0]), float(s[0]))
        place = self.onto(np.array(self.center)[None] + self._put(*map(np.array, start)))
        vars(self).update(start=start, base=(float(place[0, 0]), float(place[0, 1])))

    @abstractmethod
    def _nearest(self, c: float, s: float) -> Pair:
        """Return C and S of a place on the curve near the place whose C and S are c and s."""

    @property
    def _sides(self) -> tuple[Pair, Pair]:
        """The two half-axes as vectors."""
        (x, y), (r, s) = self.axis, self.radii
        return (r * x, r * y), (-s * y, s * x)

    def _put(self, c: Any, s: Any) -> FloatArray:
        """Return differences of places from differences of C and S."""
        a, b = self._sides
        return np.asarray(c).reshape(-1, 1) * np.array(a) + np.asarray(s).reshape(-1, 1) * np.array(b)

    def _own(self, offsets: Any) -> tuple[Any, Any]:
        """Return C and S of differences of places: the inverse of `_put`."""
        (x, y), (r, s) = self.axis, self.radii
        return (offsets[:, 0] * x + offsets[:, 1] * y) / r, (offsets[:, 1] * x - offsets[:, 0] * y) / s

    def _terms(self, other: Any) -> Any:
        """Return another conic's (value at the centre, half the slopes along both half-axes, three quadratic terms)."""
        a, b = self._sides
        c = self.center
        return (
            form_value(other, np.array(c)), half_slope(other, c, a), half_slope(other, c, b), second_order(other, a, a),
            second_order(other, a, b), second_order(other, b, b),
        )  # fmt: skip


class Ellipse(_Central):
    """An ellipse, with an angle in radians as parameter."""

    kind, closed = "ellipse", True

    def handle(self, h: float) -> float:
        return 4 / 3 * math.tan(h / 4)

    def _nearest(self, c: float, s: float) -> Pair:
        length = math.hypot(c, s)
        return (c / length, s / length) if length > 0 else (1.0, 0.0)

    def plain(self, t: Any) -> FloatArray:
        (c, s), sine, less = self.start, np.sin(t), -2 * np.sin(np.asarray(t) / 2) ** 2
        return np.array(self.base) + self._put(c * less - s * sine, s * less + c * sine)

    def velocity(self, t: Any) -> FloatArray:
        (c, s), sine, cosine = self.start, np.sin(t), np.cos(t)
        return self._put(-c * sine - s * cosine, c * cosine - s * sine)

    def parameter(self, points: Any) -> FloatArray:
        (c, s), (x, y) = self.start, self._own(points - np.array(self.base))
        return np.arctan2(c * y - s * x, 1 + c * x + s * y)

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """Return the zeros of f = constant + 2 Re(first z + second z²), z = exp(i t).

        Conics with a constant too large for a zero are skipped. If second = 0, as for lines and between circles, an
        arccosine gives the angle. Otherwise z is a root of a polynomial of degree four.
        """
        second, first, constant = self._waves(others.T)
        reach = 2 * (np.abs(first) + np.abs(second))
        # |f - constant| <= reach on the whole ellipse.
        meets = np.abs(constant) <= reach * (1 + NEAR)
        simple = meets & (np.abs(second) <= 1e-15 * np.maximum(np.abs(first), np.abs(constant)))
        turn = np.arccos(np.clip(-constant / (2 * np.abs(first)), -1, 1))[simple]
        middle = -np.angle(first)[simple]
        rest = np.flatnonzero(meets & ~simple)
        roots = [self._roots_of(second[k], first[k], constant[k]) for k in rest]
        t = np.concatenate([middle + turn, middle - turn, *roots]) - math.atan2(self.start[1], self.start[0])
        one = np.flatnonzero(simple)
        return t, np.concatenate([one, one, np.repeat(rest, [len(part) for part in roots])])

    def _waves(self, other: Any) -> tuple[Any, Any, Any]:
        """Return (second, first, constant): the Fourier coefficients of another conic along the ellipse."""
        f, along, over, aa, ab, bb = self._terms(other)
        return (aa - bb) / 4 - 0.5j * ab, along - 1j * over, f + (aa + bb) / 2

    def _roots_of(self, second: Any, first: Any, constant: Any) -> FloatArray:
        """Return the angles of the roots z that are near the unit circle."""
        z = real_roots_of([second, first, constant, np.conj(first), np.conj(second)])
        # Roots on the unit circle are real angles.
        return np.angle(z[np.abs(np.abs(z) - 1) < NEAR])

    def box(self) -> tuple[float, float, float, float]:
        a, b = self._sides
        x, y = math.hypot(a[0], b[0]), math.hypot(a[1], b[1])
        return self.center[0] - x, self.center[1] - y, self.center[0] + x, self.center[1] + y


@dataclass(frozen=True, eq=False)
class Hyperbola(_Central):
    """One branch of a hyperbola, by hyperbolic cosine and sine of its parameter.

    With `open_at` its half-axes are far below the window, which holds its centre: two arms along the asymptotes. Then
    t = 0 is the vertex, from where nothing cancels, and pieces within this distance of it stand for themselves.
    """

    kind = "hyperbola"
    open_at: float = 0.0

    def handle(self, h: float) -> float:
        return 4 / 3 * math.tanh(h / 4)

    def _nearest(self, c: float, s: float) -> Pair:
        return (1.0, 0.0) if self.open_at else (math.hypot(1.0, s), s)

    @property
    def corners(self) -> tuple[float, ...]:
        end = math.asinh(self.open_at / math.hypot(*self.radii))
        return (-end, 0.0, end) if self.open_at else ()

    def onto(self, points: FloatArray) -> FloatArray:
        # Newton's steps would be noise near the vertex, where the slope of the conic vanishes
        return points if self.open_at else super().onto(points)

    def plain(self, t: Any) -> FloatArray:
        (c, s), sine, more = self.start, np.sinh(t), 2 * np.sinh(np.asarray(t) / 2) ** 2
        return np.array(self.base) + self._put(c * more + s * sine, s * more + c * sine)

    def velocity(self, t: Any) -> FloatArray:
        (c, s), sine, cosine = self.start, np.sinh(t), np.cosh(t)
        return self._put(c * sine + s * cosine, s * sine + c * cosine)

    def parameter(self, points: Any) -> FloatArray:
        (c, s), (x, y) = self.start, self._own(points - np.array(self.base))
        return np.arcsinh(c * y - s * x)

    def roots_with(self, other: Any) -> FloatArray:
        """Return the crossings from the positive roots w = exp(t) of a polynomial of degree four.

        Where these would lose their digits, crossings with the asymptotes are candidates, too.
        """
        f, along, over, aa, ab, bb = self._terms(other)
        # cosh and sinh as (w ± 1/w) / 2, and the whole times w².
        second = (aa + bb) / 4
        w = real_roots_of([second + ab / 2, along + over, f + (aa - bb) / 2, along - over, second - ab / 2])
        result: FloatArray = np.log(w.real[(w.real > 0) & (np.abs(w.imag) < NEAR * np.abs(w))]) - math.asinh(
            self.start[1]
        )
        arms = [self._roots_on_arm(other, turn) for turn in (-1, 1)] if self.open_at else []
        return np.concatenate([result, *arms])

    def _roots_on_arm(self, other: Any, turn: int) -> FloatArray:
        """Return the crossings with one asymptote, near which those with the arm are."""
        a, b = self._sides
        x, y = a[0] + turn * b[0], a[1] + turn * b[1]
        length = math.hypot(x, y)
        way = x / length, y / length
        roots = real_roots_of([
            second_order(other, way, way), 2 * half_slope(other, self.center, way), _at(other, self.center)
        ])  # fmt: skip
        far = roots.real[(roots.real > 0) & (np.abs(roots.imag) < NEAR * np.abs(roots))]
        return turn * np.arcsinh(far / length)

    def own(self, points: FloatArray) -> FloatArray:
        here = self._own(points - np.array(self.center))[0] > 0  # and not on the other branch
        return points[here]
