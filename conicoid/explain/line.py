"""The ray of an explanation, in fractions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from .numbers import along, as_float, dot, root, told
from .polynomial import Polynomial

_UNIT = Fraction(1, 1 << 48)


@dataclass(frozen=True)
class Line:
    """o + t d for t_min < t < t_max."""

    origin: tuple[Fraction, ...]
    direction: tuple[Fraction, ...]
    t_min: float
    t_max: float

    @classmethod
    def of(cls, origin: Sequence[float], direction: Sequence[float], t_min: float, t_max: float) -> Line:
        """From floats, exactly."""
        return cls(tuple(map(Fraction, origin)), tuple(map(Fraction, direction)), t_min, t_max)

    @property
    def square(self) -> Fraction:
        """d·d"""
        return dot(self.direction, self.direction)

    @property
    def is_unit(self) -> bool:
        """Is the direction a unit vector, but for its rounding?"""
        return abs(self.square - 1) < _UNIT

    @property
    def interval(self) -> str:
        """The interval of t."""
        return f"{told(self.t_min)} < t < {told(self.t_max)}"

    def at(self, t: Fraction | float) -> list[Fraction]:
        """The point at t."""
        return along(self.origin, Fraction(t), self.direction)

    def holds(self, t: float | Fraction) -> bool:
        """Is t within the interval?"""
        return self.t_min < t < self.t_max

    def roots(self, polynomial: Polynomial) -> list[Fraction]:
        """Where it meets a surface, in order; touching counts once."""
        a, b, c = polynomial.on_ray(self.origin, self.direction)
        if not a:
            return [-c / (2 * b)] if b else []
        discriminant = b * b - a * c
        if discriminant < 0:
            return []
        apart = root(discriminant)
        return sorted({(-b - apart) / a, (-b + apart) / a})


def nearest(values: Sequence[Fraction]) -> list[float]:
    """Fractions as floats."""
    return [as_float(value) for value in values]


EVERYWHERE = -math.inf, math.inf
