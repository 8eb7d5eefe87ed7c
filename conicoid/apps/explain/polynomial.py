"""Exact surfaces and rays as fractions: numbers in words, polynomials of surfaces, sources of surfaces, the ray."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from math import gcd
from typing import TypeAlias

from ..._util.records import dataclass
from ...geometry.general_quadric import Classification, classify, classify_surface
from ...geometry.surface import PlaneSurface, QuadricSurface
from ...kernels.tables import SPHERE
from ...numerics import bigfloat as ex
from ...numerics.rational import dot
from ...prepare.prepared_scene import PreparedScene

# Numbers in words, and square roots of fractions.

_DIGITS = Context(prec=80, Emin=-(10**9), Emax=10**9)
"""Square roots have 80 digits, without underflow or overflow."""
MINUS = "−"


def format_float(value: float) -> str:
    """Return a float in the shortest decimals that round to it, with ∞ and the sign −."""
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    # + 0.0 turns −0 into 0
    text = repr(float(value) + 0.0).removesuffix(".0")
    return text.replace("-", MINUS, 1) if text.startswith("-") else text


def format_fraction(value: Fraction) -> str:
    """Return a fraction in words, rounded to a float once."""
    return format_float(as_float(value))


def format_vector(values: Iterable[float | Fraction]) -> str:
    """Return numbers as (x, y, z)."""
    return f"({', '.join(format_float(as_float(value)) for value in values)})"


def as_float(value: float | Fraction) -> float:
    """Return the nearest float; infinite beyond the largest."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def sqrt_fraction(value: Fraction) -> Fraction:
    """Return √value, exact for squares of fractions, otherwise to 80 digits."""
    # Fractions are in lowest terms: a square has a square above and below
    up, down = math.isqrt(value.numerator), math.isqrt(value.denominator)
    if up * up == value.numerator and down * down == value.denominator:
        return Fraction(up, down)
    quotient = _DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator))
    return Fraction(_DIGITS.sqrt(quotient))


def format_short(value: float) -> str:
    """Return a float in words for equations: in full if that is short, otherwise to six digits."""
    text = format_float(value)
    return text if len(text) <= 9 else f"{value:.6g}".replace("-", MINUS, 1)


# A surface as an exact polynomial about the world's origin, and as a readable equation.

Point: TypeAlias = Sequence[Fraction]
_NAMES = ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z", "constant")
_TERMS = ("x²", "y²", "z²", "xy", "xz", "yz", "x", "y", "z", "")


@dataclass(frozen=True)
class Polynomial:
    """A x² + E y² + H z² + 2B xy + 2C xz + 2F yz + 2D x + 2G y + 2I z + J, in the letters of the ray tracing notes.

    ten   (A, E, H, B, C, F, D, G, I, J), exact, or to 3000 bits where they are irrational
    """

    ten: tuple[Fraction, ...]

    @property
    def is_flat(self) -> bool:
        """Whether the polynomial is of the first degree."""
        return not any(self.ten[:6])

    @property
    def coefficients(self) -> dict[str, float]:
        """The coefficients as `Quadric(coefficients=)` takes them, rounded once, without zeros."""
        whole = [value * (1 if k < 3 or k == 9 else 2) for k, value in enumerate(self.ten)]
        return {name: as_float(value) for name, value in zip(_NAMES, whole, strict=True) if value}

    def half_gradient(self, point: Point) -> list[Fraction]:
        """Return (Ax + By + Cz + D, Bx + Ey + Fz + G, Cx + Fy + Hz + I) at a point."""
        return [value + part for value, part in zip(self._times(point), self.ten[6:9], strict=True)]

    def _times(self, vector: Point) -> list[Fraction]:
        """Return the product of the symmetric 3 × 3 matrix of the second degree and a vector."""
        a, e, h, b, c, f, *_ = self.ten
        return [dot(row, vector) for row in ((a, b, c), (b, e, f), (c, f, h))]

    def value(self, point: Point) -> Fraction:
        """Return the value at a point; <= 0 on the inner side."""
        return self.on_ray(point, (Fraction(0),) * 3)[2]

    def on_ray(self, origin: Point, direction: Point) -> tuple[Fraction, Fraction, Fraction]:
        """Return (a, b, c) of a t² + 2 b t + c at o + t d: uᵗQu, uᵗQp and pᵗQp of the Clemson notes."""
        first = self.ten[6:9]
        a = dot(self._times(direction), direction)
        b = dot(self._times(direction), origin) + dot(first, direction)
        c = dot(self._times(origin), origin) + 2 * dot(first, origin) + self.ten[9]
        return a, b, c

    @cached_property
    def _centered(self) -> tuple[list[Fraction], list[Fraction], Fraction] | None:
        """(squares, center, k) of Σ s (x - c)² = k; None with a product, or with a linear term without its square."""
        squares, mixed, linear, constant = self.ten[:3], self.ten[3:6], self.ten[6:9], self.ten[9]
        if any(mixed) or any(b and not s for s, b in zip(squares, linear, strict=True)) or not any(squares):
            return None
        center = [-b / s if s else Fraction(0) for s, b in zip(squares, linear, strict=True)]
        k = sum((s * c * c for s, c in zip(squares, center, strict=True)), -constant)
        return list(squares), center, k

    @property
    def equation(self) -> str:
        """The readable equation of the surface, numbers to six digits."""
        found = self._centered
        if self.is_flat:
            return f"{join_terms(self._plane())} = 0"
        if found is None:
            return f"{self._sum()} = 0"
        squares, center, k = found
        # Equal squares are divided out: x² + y² = 4, not 2 x² + 2 y² = 8
        same = {s for s in squares if s}
        if len(same) == 1 and k:
            common = same.pop()
            squares, k = [s / common for s in squares], k / common
        terms = [
            (s, f"({name} {MINUS if c > 0 else '+'} {format_short(abs(as_float(c)))})²" if c else f"{name}²")
            for s, c, name in zip(squares, center, "xyz", strict=True)
            if s
        ]
        return f"{join_terms(terms)} = {format_short(as_float(k))}"

    def _plane(self) -> list[tuple[Fraction, str]]:
        """Return the terms of a plane: x alone, or whole numbers without a common divisor where all are whole."""
        # The terms of the first degree are halved in `ten`
        whole = [2 * half for half in self.ten[6:9]] + [self.ten[9]]
        axes = [value for value in whole[:3] if value]
        common = Fraction(1)
        if len(axes) == 1:
            common = axes[0]
        elif all(value.denominator == 1 for value in whole):
            common = Fraction(gcd(*(value.numerator for value in whole)))
        return [(value / common, name) for value, name in zip(whole, ("x", "y", "z", ""), strict=True) if value]

    def _sum(self) -> str:
        """Return all ten terms as a sum."""
        whole = [value * (1 if k < 3 or k == 9 else 2) for k, value in enumerate(self.ten)]
        return join_terms([(value, name) for value, name in zip(whole, _TERMS, strict=True) if value])


def join_terms(terms: Sequence[tuple[Fraction, str]], number_text: Callable[[float], str] = format_short) -> str:
    """Return terms as a sum: 2 x² − y + 3. A factor whose reciprocal is shorter divides: x/3."""
    text = ""
    for value, name in terms:
        if not value:
            continue
        size, under = number_text(abs(as_float(value))), number_text(abs(as_float(1 / value)))
        factor = name if size == "1" and name else f"{size} {name}".strip()
        # x/3 is easier to read than 0.333333 x
        if name and len(under) + 4 < len(size):
            factor = f"{name}/{under}"
        sign = (f"{MINUS}" if value < 0 else "") if not text else (f" {MINUS} " if value < 0 else " + ")
        text += sign + factor
    return text or "0"


@dataclass(frozen=True)
class SurfaceSource:
    """A surface of the scene's table before rounding, with its number and the kind of its record."""

    number: int
    kind: int
    exact: PlaneSurface | QuadricSurface

    @classmethod
    def of(cls, scene: PreparedScene, number: int) -> SurfaceSource:
        """Return the surface of a number; a scene keeps those that were computed."""
        known = scene.sources.get(number)
        if known is None:
            known = cls(number, int(scene.lowered.tables.surface_kind[number]), exact_surface(scene, number))
            scene.sources[number] = known
        assert isinstance(known, SurfaceSource)
        return known

    @cached_property
    def polynomial(self) -> Polynomial:
        """The polynomial, scaled for reading.

        The first component of a plane's normal that is not 0 is positive. Squares of a sphere are 1. The equation of an
        ellipsoid with radii has 1 on the right.
        """
        found = self.exact
        if isinstance(found, PlaneSurface):
            normal, offset = [ex.fraction(n) for n in found.normal], ex.fraction(found.offset)
            # The exact surface may have either sign and any scale: these are chosen for reading
            sense = -1 if next(n for n in found.normal if float(n)) < 0 else 1
            halves = [sense * n / 2 for n in normal]
            return Polynomial((*[Fraction(0)] * 6, *halves, -sense * offset))
        ten = [ex.fraction(value) for value in found.coefficients()]
        factor = ten[0] if self.kind == SPHERE else _of_radii(found)
        return Polynomial(tuple(value / factor for value in ten))

    @cached_property
    def classification(self) -> Classification:
        """The kind of quadric or plane, with its place in the world."""
        if not isinstance(self.exact, PlaneSurface):
            return classify_surface(self.exact)
        x, y, z = self.polynomial.ten[6:9]
        rows = [(Fraction(0), Fraction(0), Fraction(0), half) for half in (x, y, z)]
        return classify((*rows, (x, y, z, self.polynomial.ten[9])))


def _of_radii(surface: QuadricSurface) -> Fraction:
    """Return the divisor of an ellipsoid's equation: its constant, if all squares become 1 / r² with rational r.

    It is 1 for other quadrics.
    """
    squares, constant = [ex.fraction(s) for s in surface.squares], ex.fraction(surface.constant)
    # A rounded or shifted quadric is not given by radii
    if any(map(ex.is_rounded, (*surface.squares, surface.constant))) or any(map(float, surface.linear)):
        return Fraction(1)
    if constant <= 0 or min(squares) <= 0 or any(sqrt_fraction(constant / s) ** 2 != constant / s for s in squares):
        return Fraction(1)
    return constant


def exact_surface(scene: PreparedScene, surface: int) -> PlaneSurface | QuadricSurface:
    """Return a surface of the scene's table before rounding; that of a bulk ball is its record, which is exact."""
    exact = scene.lowered.exact
    if surface < len(exact):
        return exact[surface]
    x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
    return QuadricSurface((1.0, 1.0, 1.0), constant=Fraction(r) ** 2, anchor=(x, y, z))


# The ray of an explanation, in fractions.

_UNIT = Fraction(1, 1 << 48)
"""Rounding of the squared length of a unit vector is smaller than this."""


@dataclass(frozen=True)
class ExactRay:
    """The ray o + t d for t_min < t < t_max."""

    origin: tuple[Fraction, ...]
    direction: tuple[Fraction, ...]
    t_min: float
    t_max: float

    @classmethod
    def of(cls, origin: Sequence[float], direction: Sequence[float], t_min: float, t_max: float) -> ExactRay:
        """Return the ray of some floats, exactly."""
        return cls(tuple(map(Fraction, origin)), tuple(map(Fraction, direction)), t_min, t_max)

    @property
    def square(self) -> Fraction:
        """d·d"""
        return dot(self.direction, self.direction)

    @property
    def is_unit(self) -> bool:
        """Whether the direction is a unit vector up to rounding."""
        return abs(self.square - 1) < _UNIT

    @property
    def interval(self) -> str:
        """The interval of t in words."""
        return f"{format_float(self.t_min)} < t < {format_float(self.t_max)}"

    def at(self, t: Fraction | float) -> list[Fraction]:
        """Return the point at t."""
        return [o + Fraction(t) * d for o, d in zip(self.origin, self.direction, strict=True)]

    def holds(self, t: float | Fraction) -> bool:
        """Return True if t is within the interval."""
        return self.t_min < t < self.t_max

    def roots(self, polynomial: Polynomial) -> list[Fraction]:
        """Return the t of its crossings with a surface in order, also outside of the interval; touching counts once."""
        a, b, c = polynomial.on_ray(self.origin, self.direction)
        if not a:
            return [-c / (2 * b)] if b else []
        discriminant = b * b - a * c
        if discriminant < 0:
            return []
        # Sorted without equal ones: the sign of a may turn the order
        root = sqrt_fraction(discriminant)
        return sorted({(-b - root) / a, (-b + root) / a})
