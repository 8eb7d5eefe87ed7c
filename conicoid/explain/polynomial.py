"""A surface as a polynomial about the world's origin, exact, and as an equation to be read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, isqrt
from typing import TYPE_CHECKING, TypeAlias

from ..engine.tables import SPHERE
from ..shapes import exact as ex
from ..shapes.classification import Classification
from ..shapes.classify import classify, classify_surface
from ..shapes.surface import PlaneSurface, QuadricSurface
from .numbers import MINUS, as_float, dot, short

if TYPE_CHECKING:
    from ..engine.prepared import Prepared

Point: TypeAlias = Sequence[Fraction]
_NAMES = ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z", "constant")
_TERMS = ("x²", "y²", "z²", "xy", "xz", "yz", "x", "y", "z", "")


@dataclass(frozen=True)
class Polynomial:
    """A x² + E y² + H z² + 2B xy + 2C xz + 2F yz + 2D x + 2G y + 2I z + J, in the letters of the ray tracing notes.

    ten: (A, E, H, B, C, F, D, G, I, J), exact, or to 3000 bits where they are irrational.
    """

    ten: tuple[Fraction, ...]

    @property
    def is_flat(self) -> bool:
        """Is it of the first degree?"""
        return not any(self.ten[:6])

    @property
    def coefficients(self) -> dict[str, float]:
        """The coefficients as `Quadric(coefficients=)` takes them, rounded once; those that are 0 are left out."""
        whole = [value * (1 if k < 3 or k == 9 else 2) for k, value in enumerate(self.ten)]
        return {name: as_float(value) for name, value in zip(_NAMES, whole, strict=True) if value}

    def half_gradient(self, point: Point) -> list[Fraction]:
        """(Ax + By + Cz + D, Bx + Ey + Fz + G, Cx + Fy + Hz + I)"""
        return [value + part for value, part in zip(self._times(point), self.ten[6:9], strict=True)]

    def _times(self, vector: Point) -> list[Fraction]:
        a, e, h, b, c, f, *_ = self.ten
        return [dot(row, vector) for row in ((a, b, c), (b, e, f), (c, f, h))]

    def value(self, point: Point) -> Fraction:
        """At a point; <= 0 on the inner side."""
        return self.on_ray(point, (Fraction(0),) * 3)[2]

    def on_ray(self, origin: Point, direction: Point) -> tuple[Fraction, Fraction, Fraction]:
        """(a, b, c) of a t² + 2 b t + c at o + t d: uᵗQu, uᵗQp and pᵗQp of the Clemson notes."""
        first = self.ten[6:9]
        a = dot(self._times(direction), direction)
        b = dot(self._times(direction), origin) + dot(first, direction)
        c = dot(self._times(origin), origin) + 2 * dot(first, origin) + self.ten[9]
        return a, b, c

    @cached_property
    def _centered(self) -> tuple[list[Fraction], list[Fraction], Fraction] | None:
        """(squares, center, k) of sum s (x - c)² = k, where there are no products and no linear term alone."""
        squares, mixed, linear, constant = self.ten[:3], self.ten[3:6], self.ten[6:9], self.ten[9]
        if any(mixed) or any(b and not s for s, b in zip(squares, linear, strict=True)) or not any(squares):
            return None
        center = [-b / s if s else Fraction(0) for s, b in zip(squares, linear, strict=True)]
        k = sum((s * c * c for s, c in zip(squares, center, strict=True)), -constant)
        return list(squares), center, k

    @property
    def equation(self) -> str:
        """The equation of the surface, numbers to six digits."""
        found = self._centered
        if self.is_flat:
            return f"{joined(self._plane())} = 0"
        if found is None:
            return f"{self._sum()} = 0"
        squares, center, k = found
        same = {s for s in squares if s}
        if len(same) == 1 and k:
            common = same.pop()
            squares, k = [s / common for s in squares], k / common
        terms = [
            (s, f"({name} {MINUS if c > 0 else '+'} {short(abs(as_float(c)))})²" if c else f"{name}²")
            for s, c, name in zip(squares, center, "xyz", strict=True)
            if s
        ]
        return f"{joined(terms)} = {short(as_float(k))}"

    def _plane(self) -> list[tuple[Fraction, str]]:
        """The terms of a plane: whole numbers without a common divisor, or x alone."""
        whole = [2 * half for half in self.ten[6:9]] + [self.ten[9]]
        axes = [value for value in whole[:3] if value]
        common = Fraction(1)
        if len(axes) == 1:
            common = axes[0]
        elif all(value.denominator == 1 for value in whole):
            common = Fraction(gcd(*(value.numerator for value in whole)))
        return [(value / common, name) for value, name in zip(whole, ("x", "y", "z", ""), strict=True) if value]

    def _sum(self) -> str:
        whole = [value * (1 if k < 3 or k == 9 else 2) for k, value in enumerate(self.ten)]
        return joined([(value, name) for value, name in zip(whole, _TERMS, strict=True) if value])


def joined(terms: Sequence[tuple[Fraction, str]], told_as: Callable[[float], str] = short) -> str:
    """Terms as a sum: 2 x² − y + 3."""
    text = ""
    for value, name in terms:
        if not value:
            continue
        size, under = told_as(abs(as_float(value))), told_as(abs(as_float(1 / value)))
        factor = name if size == "1" and name else f"{size} {name}".strip()
        if name and len(under) + 4 < len(size):
            factor = f"{name}/{under}"
        sign = (f"{MINUS}" if value < 0 else "") if not text else (f" {MINUS} " if value < 0 else " + ")
        text += sign + factor
    return text or "0"


@dataclass(frozen=True)
class Source:
    """A surface of the scene's table before it was rounded, and of which kind its record is."""

    number: int
    kind: int
    exact: PlaneSurface | QuadricSurface

    @classmethod
    def of(cls, scene: Prepared, number: int) -> Source:
        """The surface of a number, worked out once for each scene."""
        known = scene.sources.get(number)
        if known is None:
            known = cls(number, int(scene.lowered.tables.surface_kind[number]), exact_surface(scene, number))
            scene.sources[number] = known
        assert isinstance(known, Source)
        return known

    @cached_property
    def polynomial(self) -> Polynomial:
        """As the record has it: a plane's normal leads with a positive number, a sphere's squares are 1.

        An ellipsoid that is given by its radii has 1 on the right.
        """
        found = self.exact
        if isinstance(found, PlaneSurface):
            normal, offset = [ex.fraction(n) for n in found.normal], ex.fraction(found.offset)
            sense = -1 if next(n for n in found.normal if float(n)) < 0 else 1
            halves = [sense * n / 2 for n in normal]
            return Polynomial((*[Fraction(0)] * 6, *halves, -sense * offset))
        ten = [ex.fraction(value) for value in found.coefficients()]
        factor = ten[0] if self.kind == SPHERE else _of_radii(found)
        return Polynomial(tuple(value / factor for value in ten))

    @cached_property
    def classification(self) -> Classification:
        """Which quadric or plane it is, as it stands in the world."""
        if not isinstance(self.exact, PlaneSurface):
            return classify_surface(self.exact)
        x, y, z = self.polynomial.ten[6:9]
        rows = [(Fraction(0), Fraction(0), Fraction(0), half) for half in (x, y, z)]
        return classify((*rows, (x, y, z, self.polynomial.ten[9])))


def _of_radii(surface: QuadricSurface) -> Fraction:
    """What an ellipsoid's equation is to be divided by: its constant, if that makes 1 / r² of all squares."""
    squares, constant = [ex.fraction(s) for s in surface.squares], ex.fraction(surface.constant)
    if any(map(ex.is_rounded, (*surface.squares, surface.constant))) or any(map(float, surface.linear)):
        return Fraction(1)
    if constant <= 0 or min(squares) <= 0 or not all(_is_square(constant / s) for s in squares):
        return Fraction(1)
    return constant


def _is_square(value: Fraction) -> bool:
    up, down = isqrt(value.numerator), isqrt(value.denominator)
    return up * up == value.numerator and down * down == value.denominator


def exact_surface(scene: Prepared, surface: int) -> PlaneSurface | QuadricSurface:
    """A surface of the scene's table before it was rounded; a bulk ball is as its record says."""
    exact = scene.lowered.exact
    if surface < len(exact):
        found: PlaneSurface | QuadricSurface = exact[surface]
        return found
    x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
    return QuadricSurface((1.0, 1.0, 1.0), constant=Fraction(r) ** 2, anchor=(x, y, z))
