"""Solids as Boolean formulas over polynomials in (x, y, z)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .frames import Affine, transposed
from .precision import number

Term = tuple[Any, int, int]
Truth = bool | None
"""None: it depends on perturbations within the stated band."""


@dataclass(frozen=True, eq=False)
class Surface:
    """sum of k X_i X_j over the terms (k, i, j), with X = (x, y, z, 1) in the frame `own` of world points.

    `face` is the documented number of the face, None where it is not compared.
    """

    terms: tuple[Term, ...]
    own: Affine
    face: int | None = None
    exact: bool = True
    """False where a motion was baked into the surface, which rounds its coordinates once."""

    @cached_property
    def columns(self) -> Any:
        return transposed(self.own.rows)

    @cached_property
    def float_columns(self) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(map(float, column)) for column in self.columns)

    @cached_property
    def float_terms(self) -> tuple[tuple[float, int, int], ...]:
        return tuple((float(k), i, j) for k, i, j in self.terms)

    @cached_property
    def bend(self) -> float:
        """At least half of the norm of the hessian in the world; 0 for a plane."""
        own = sum(abs(k) for k, _, j in self.float_terms if j < 3)
        return own * sum(x * x for column in self.float_columns for x in column)


@dataclass(frozen=True, eq=False)
class Below:
    """surface <= 0"""

    surface: Surface

    def truth(self, below: Callable[[Surface], Truth]) -> Truth:
        return below(self.surface)

    def surfaces(self) -> Iterator[Surface]:
        yield self.surface


@dataclass(frozen=True, eq=False)
class AllOf:
    parts: tuple[Any, ...]

    def truth(self, below: Callable[[Surface], Truth]) -> Truth:
        values = [part.truth(below) for part in self.parts]
        return False if False in values else None if None in values else True

    def surfaces(self) -> Iterator[Surface]:
        for part in self.parts:
            yield from part.surfaces()


@dataclass(frozen=True, eq=False)
class AnyOf:
    parts: tuple[Any, ...]

    def truth(self, below: Callable[[Surface], Truth]) -> Truth:
        values = [part.truth(below) for part in self.parts]
        return True if True in values else None if None in values else False

    def surfaces(self) -> Iterator[Surface]:
        for part in self.parts:
            yield from part.surfaces()


@dataclass(frozen=True, eq=False)
class Not:
    part: Any

    def truth(self, below: Callable[[Surface], Truth]) -> Truth:
        value = self.part.truth(below)
        return None if value is None else not value

    def surfaces(self) -> Iterator[Surface]:
        yield from self.part.surfaces()


Formula = Below | AllOf | AnyOf | Not


def quadric(own: Affine, squares: Any, constant: Any, z: Any = 0, y: Any = 0, face: int | None = 0) -> Below:
    """sum of squares[i] X_i² + y Y + z Z + constant <= 0 in the own frame."""
    terms = [(number(k), i, i) for i, k in enumerate(squares)]
    terms += [(number(y), 1, 3), (number(z), 2, 3), (number(constant), 3, 3)]
    return Below(Surface(tuple(t for t in terms if t[0]), own, face))


def plane(own: Affine, normal: Any, offset: Any, face: int | None = None) -> Below:
    """normal·x <= offset in the own frame."""
    terms = [(number(n), i, 3) for i, n in enumerate(normal)] + [(-number(offset), 3, 3)]
    return Below(Surface(tuple(t for t in terms if t[0]), own, face))


def slab(own: Affine, z_range: Any, faces: tuple[int | None, int | None] = (1, 2)) -> tuple[Below, ...]:
    """low <= z <= high; no inequality for an infinite end."""
    if z_range is None:
        return ()
    low, high = z_range
    parts = []
    if low != float("-inf"):
        parts.append(plane(own, (0, 0, -1), -number(low), faces[0]))
    if high != float("inf"):
        parts.append(plane(own, (0, 0, 1), high, faces[1]))
    return tuple(parts)


def carried(formula: Any, back: Affine, exact: bool = False) -> Any:
    """The formula moved by the inverse of `back`, a map from the world to where the formula was."""
    if isinstance(formula, Below):
        old = formula.surface
        return Below(Surface(old.terms, old.own.after(back), old.face, exact))
    if isinstance(formula, Not):
        return Not(carried(formula.part, back, exact))
    return type(formula)(tuple(carried(part, back, exact) for part in formula.parts))


def unnumbered(formula: Any) -> Any:
    """The formula without face numbers."""
    if isinstance(formula, Below):
        old = formula.surface
        return Below(Surface(old.terms, old.own, None, old.exact))
    if isinstance(formula, Not):
        return Not(unnumbered(formula.part))
    return type(formula)(tuple(unnumbered(part) for part in formula.parts))
