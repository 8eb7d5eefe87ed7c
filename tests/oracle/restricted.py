"""A surface on a ray: its roots, and where a displacement of the surface could move them.

Roots and signs are exact to 90 digits. How wide the undecided stretches are need not be: the widths
(`kappa`, gradients) are floats. `trace.py` says what they mean.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .formula import Surface
from .precision import ZERO, dot, length, mp, plus, vector

BAND = 2.0**-49
BAKED = 2.0**-52
PLAIN = 1e-4
"""Steps this small against everything around them need no further thought."""


@dataclass(frozen=True, eq=False)
class Line:
    """origin + t direction, exact values of floats."""

    origin: tuple[Any, ...]
    direction: tuple[Any, ...]
    speed: Any

    def at(self, t: Any) -> tuple[Any, ...]:
        return plus(self.origin, self.direction, t)


def line(origin: Sequence[Any], direction: Sequence[Any]) -> Line:
    d = vector(direction)
    return Line(vector(origin), d, length(d))


@dataclass(frozen=True)
class Crossing:
    """`cosine` = normal · unit direction, negative where the ray enters; `bend`: |hessian f| / |grad f|, a bound of
    how fast the unit outward `normal` turns along the surface."""

    t: Any
    entering: bool
    face: int | None
    cosine: Any
    normal: tuple[Any, ...] = ()
    bend: Any = ZERO


class Restricted:
    """f(t) = a t² + 2 b t + c."""

    def __init__(self, surface: Surface, on: Line, size: Any, frames: dict[int, Any]) -> None:
        self.surface, self.line, self.size = surface, on, size
        key = id(surface.own)
        if key not in frames:
            frames[key] = (surface.own.point(on.origin), surface.own.vector(on.direction))
        self.o, self.d = frames[key]
        self.a, self.b, self.c = self._coefficients()
        self.speed, self.extent = float(on.speed), float(size)
        self.bend = surface.bend

    def _coefficients(self) -> tuple[Any, Any, Any]:
        o, d = self.o, self.d
        a = b = c = ZERO
        for k, i, j in self.surface.terms:
            if j < 3:
                a += k * d[i] * d[j]
                b += k * o[i] * d[i] if i == j else k * (o[i] * d[j] + d[i] * o[j]) / 2
                c += k * o[i] * o[j]
            elif i < 3:
                b += k * d[i] / 2
                c += k * o[i]
            else:
                c += k
        return a, b, c

    @cached_property
    def roots(self) -> list[Any]:
        """Simple real roots; a double root is no crossing."""
        return quadratic_roots(self.a, self.b, self.c)

    @cached_property
    def _below_at_first(self) -> bool:
        """f <= 0 towards t = -inf."""
        return bool(self.a < 0 if self.a else self.b > 0 if self.b else self.c <= 0)

    def below(self, t: Any) -> bool:
        """f(t) <= 0; the sign changes at every root."""
        return self._below_at_first ^ bool(sum(root < t for root in self.roots) % 2) or t in self.roots

    def value(self, t: Any) -> Any:
        return (self.a * t + 2 * self.b) * t + self.c

    def gradient(self, t: Any) -> tuple[Any, ...]:
        """World gradient: own gradient carried back by the transposed rows."""
        x = (*plus(self.o, self.d, t), mp.one)
        own = [ZERO] * 4
        for k, i, j in self.surface.terms:
            own[i] += k * x[j]
            own[j] += k * x[i]
        return tuple(sum((r * g for r, g in zip(column, own, strict=False)), ZERO) for column in self.surface.columns)

    def steepness(self, t: Any) -> float:
        """|grad f|"""
        x = (*map(float, plus(self.o, self.d, t)), 1.0)
        own = [0.0] * 4
        for k, i, j in self.surface.float_terms:
            own[i] += k * x[j]
            own[j] += k * x[i]
        return math.hypot(*(sum(r * g for r, g in zip(c, own, strict=False)) for c in self.surface.float_columns))

    def kappa(self, t: Any) -> float:
        """How far from zero f may be at t for a displaced surface to pass there."""
        eta = BAND * (abs(float(t)) * self.speed + self.extent)
        if not self.surface.exact:
            eta += BAKED * math.hypot(*map(float, self.line.at(t)))
        return eta * self.steepness(t) + eta * eta * self.bend

    def crossing(self, t: Any, sign: int, face: int | None) -> Crossing:
        """The crossing at a root with the normal sign · grad f."""
        gradient = self.gradient(t)
        size = mp.norm(gradient) or mp.one
        normal = tuple(sign * g / size for g in gradient)
        cosine = dot(normal, self.line.direction) / self.line.speed
        return Crossing(t, bool(cosine < 0), face, cosine, normal, 2 * self.bend / size)

    def doubtful(self, reach: Any) -> list[tuple[Any, Any]]:
        """The stretches of ]-reach, reach[ where |f| <= kappa, and every root with them."""
        plain = self._plain_steps(reach)
        return self._searched(reach) if plain is None else plain

    def _plain_steps(self, reach: Any) -> list[tuple[Any, Any]] | None:
        """kappa / |f'| around each root, where that is small against all else; None where it is not."""
        a, bend, speed = float(self.a), self.bend, self.speed
        if bend and abs(a) < 1e-6 * bend * speed * speed:
            return None
        if not self.roots:
            return self._no_roots(reach) if bend else None
        found = []
        gap = float(self.roots[1] - self.roots[0]) if len(self.roots) == 2 else math.inf
        for root in self.roots:
            slope, kappa = abs(float(2 * (self.a * root + self.b))), self.kappa(root)
            if not bend and slope < 1e-6 * self.steepness(root) * speed:
                return None
            if kappa > PLAIN * slope * min(gap, abs(float(root)) + self.extent / speed):
                return None
            step = kappa / slope
            found.append((root - step, root + step))
        return found

    def _no_roots(self, reach: Any) -> list[tuple[Any, Any]] | None:
        vertex = -self.b / self.a
        if abs(vertex) >= reach or abs(float(self.value(vertex))) <= 8 * self.kappa(vertex):
            return None
        return []

    def _searched(self, reach: Any) -> list[tuple[Any, Any]]:
        """The ends of the stretches with kappa linear in |t|, its slope taken at the roots, the vertex
        and the origin; between two such ends the true kappa decides, at the middle.
        """
        cuts = sorted({-reach, ZERO, reach} | {t for g in self._slopes(reach) for t in self._ends(g) if abs(t) < reach})
        found: list[tuple[Any, Any]] = []
        for low, high in itertools.pairwise(cuts):
            if self._open_between(low, high):
                if found and found[-1][1] == low:
                    found[-1] = (found[-1][0], high)
                else:
                    found.append((low, high))
        return found

    def _slopes(self, reach: Any) -> set[float]:
        """|grad f| at the places near which a displacement may matter."""
        if not self.bend:
            return {self.steepness(ZERO)}
        places = [ZERO, *self.roots]
        if self.a:
            places.append(-self.b / self.a)
        return {self.steepness(t) for t in places if abs(t) < reach}

    def _ends(self, slope: float) -> list[Any]:
        """Roots of f = ± slope (BAND (|t| speed + size) + BAKED (|o| + |t| speed)), each on its side of t = 0."""
        baked = 0.0 if self.surface.exact else BAKED
        fixed = mp.mpf(slope * (BAND * self.extent + baked * math.hypot(*map(float, self.line.origin))))
        rate = mp.mpf(slope * (BAND + baked) * self.speed)
        found = []
        for above in (1, -1):
            for side in (1, -1):
                roots = quadratic_roots(self.a, self.b - above * side * rate / 2, self.c - above * fixed)
                found += [t for t in roots if t * side > 0]
        return found

    def _open_between(self, low: Any, high: Any) -> bool:
        """The stretch holds a root, or a displaced surface may pass its middle."""
        return any(low <= root <= high for root in self.roots) or self.open_at((low + high) / 2)

    def open_at(self, t: Any) -> bool:
        return abs(float(self.value(t))) <= self.kappa(t)


def quadratic_roots(a: Any, b: Any, c: Any) -> list[Any]:
    """Simple real roots of a t² + 2 b t + c, by the formula that does not cancel."""
    if not a:
        return [-c / (2 * b)] if b else []
    disc = b * b - a * c
    if disc <= 0:
        return []
    q = -(b + mp.sign(b) * mp.sqrt(disc)) if b else mp.sqrt(disc)
    return sorted((q / a, c / q))
