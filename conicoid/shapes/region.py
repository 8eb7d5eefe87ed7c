"""Boolean combinations of solids, and sheets clipped by solids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .base import Sheet, Solid
from .motion import STILL, Motion
from .vector import Box

EVERYWHERE: Box = (np.full(3, -np.inf), np.full(3, np.inf))


@dataclass(frozen=True)
class Union(Solid):
    """Inside any operand: ``a | b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Union", self.operands))

    def bounds_under(self, outer: Motion) -> Box:
        return around([part.bounds_under(self.motion.then(outer)) for part in self.operands])


@dataclass(frozen=True)
class Intersection(Solid):
    """Inside every operand: ``a & b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Intersection", self.operands))

    def bounds_under(self, outer: Motion) -> Box:
        return common([part.bounds_under(self.motion.then(outer)) for part in self.operands])


@dataclass(frozen=True)
class Difference(Solid):
    """Inside the first operand and outside the others: ``a - b``. A cut shows the cutter's face number."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Difference", self.operands))

    def bounds_under(self, outer: Motion) -> Box:
        motion = self.motion.then(outer)
        holes = [Complement(part).bounds_under(motion) for part in self.operands[1:]]
        return common([self.operands[0].bounds_under(motion), *holes])


@dataclass(frozen=True)
class Complement(Solid):
    """Outside the operand: ``~a``; contains exactly the points that `a` does not."""

    operand: Solid

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", solids("Complement", (self.operand,))[0])

    @property
    def operands(self) -> tuple[Solid, ...]:
        return (self.operand,)

    def bounds_under(self, outer: Motion) -> Box:
        """Infinite, but for the complement of a complement (De Morgan carries it inward)."""
        motion = self.motion.then(outer)
        inner, motion = self.operand, self.operand.motion.then(motion)
        if isinstance(inner, Complement):
            return inner.operand.bounds_under(motion)
        if isinstance(inner, Union):
            return common([Complement(part).bounds_under(motion) for part in inner.operands])
        if isinstance(inner, Intersection):
            return around([Complement(part).bounds_under(motion) for part in inner.operands])
        if isinstance(inner, Difference):
            rest = [part.bounds_under(motion) for part in inner.operands[1:]]
            return around([Complement(inner.operands[0]).bounds_under(motion), *rest])
        return inner.outside_bounds_under(self.motion.then(outer))


@dataclass(frozen=True)
class ClippedSheet(Sheet):
    """The part of a sheet inside (``keep`` = "inside") or outside ("outside") every one of the solids."""

    base: Sheet
    solid: Solid
    keep: str = "inside"

    def __post_init__(self) -> None:
        if not isinstance(self.base, Sheet):
            raise TypeError(f"ClippedSheet: base must be a sheet, got {type(self.base).__name__}")
        object.__setattr__(self, "solid", solids("ClippedSheet", (self.solid,))[0])
        if self.keep not in ("inside", "outside"):
            raise ValueError(f"ClippedSheet: keep must be 'inside' or 'outside', got {self.keep!r}")

    def bounds_under(self, outer: Motion) -> Box:
        motion = self.motion.then(outer)
        clip = self.solid if self.keep == "inside" else Complement(self.solid)
        return common([self.base.bounds_under(motion), clip.bounds_under(motion)])


def solids(owner: str, operands: Any) -> tuple[Solid, ...]:
    """`operands` as a tuple of at least one solid; a sheet is a TypeError."""
    items = tuple(operands)
    if not items:
        raise ValueError(f"{owner}: operands must hold at least one solid, got none")
    for item in items:
        if isinstance(item, Sheet):
            raise TypeError(
                f"{owner}: {type(item).__name__} is a sheet: only `sheet & solid` and `sheet - solid` clip it"
            )
        if not isinstance(item, Solid) or not getattr(item, "combines", True):
            raise TypeError(f"{owner}: operands must be solids, got {type(item).__name__}")
    return items


def _flat(kind: type, shapes: Sequence[Solid]) -> tuple[Solid, ...]:
    """Operands with unmoved ones of the same kind opened up, so that a | b | c is one node."""
    parts: list[Solid] = []
    for shape in shapes:
        opened = isinstance(shape, kind) and shape.motion == STILL
        parts.extend(shape.operands if opened else (shape,))  # type: ignore[attr-defined]
    return tuple(parts)


def union(a: Solid, b: Solid) -> Union:
    return Union(_flat(Union, (a, b)) if isinstance(b, Solid) else (a, b))


def intersection(a: Solid, b: Any) -> Intersection | ClippedSheet:
    if isinstance(b, Sheet):
        return clip(b, a, keep_inside=True)
    return Intersection(_flat(Intersection, (a, b)) if isinstance(b, Solid) else (a, b))


def difference(a: Solid, b: Solid) -> Difference:
    first = a.operands if isinstance(a, Difference) and a.motion == STILL else (a,)
    return Difference((*first, b))


def clip(sheet: Sheet, solid: Any, *, keep_inside: bool) -> ClippedSheet:
    if not isinstance(solid, Solid):
        raise TypeError(
            f"{type(sheet).__name__} is a sheet: it can be clipped by a solid, not by {type(solid).__name__}"
        )
    return ClippedSheet(sheet, solid, "inside" if keep_inside else "outside")


def around(boxes: Sequence[Box]) -> Box:
    """The box around boxes; empty ones (low > high) do not count."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for a, b in boxes:
        if (a <= b).all():
            low, high = np.minimum(low, a), np.maximum(high, b)
    return low, high


def common(boxes: Sequence[Box]) -> Box:
    """The box common to boxes; (inf, -inf) where they have no point in common."""
    low = np.max([a for a, _ in boxes], axis=0)
    high = np.min([b for _, b in boxes], axis=0)
    if (low > high).any():
        return np.full(3, np.inf), np.full(3, -np.inf)
    return low, high
