"""Boolean combinations of solids, and sheets clipped by solids."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .base import Sheet, Solid
from .material import Material
from .motion import STILL, Motion
from .vector import Box

EVERYWHERE: Box = (np.full(3, -np.inf), np.full(3, np.inf))


class Boolean(Solid, abstract=True):
    """A combination of solids, of any depth: nothing here calls itself from level to level."""

    operands: tuple[Solid, ...]

    def bounds_under(self, outer: Motion) -> Box:
        return region_bounds(self, outer)

    def outside_bounds_under(self, outer: Motion) -> Box:
        return region_bounds(Complement(self), outer)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Boolean):
            return NotImplemented
        return self is other or list(_spelled(self)) == list(_spelled(other))

    def __hash__(self) -> int:
        return hash(tuple(_spelled(self)))

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{type(part).__name__}(...)" if isinstance(part, Boolean) else repr(part) for part in self.operands[:8]
        )
        more = f", ... {len(self.operands) - 8} more" if len(self.operands) > 8 else ""
        return f"{type(self).__name__}(({shown}{more}))"


@dataclass(frozen=True, eq=False, repr=False)
class Union(Boolean):
    """Inside any operand: ``a | b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Union", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(Boolean):
    """Inside every operand: ``a & b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Intersection", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Difference(Boolean):
    """Inside the first operand and outside the others: ``a - b``. A cut shows the cutter's face number."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", solids("Difference", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Complement(Boolean):
    """Outside the operand: ``~a``; contains exactly the points that `a` does not."""

    operand: Solid

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", solids("Complement", (self.operand,))[0])

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)


@dataclass(frozen=True, eq=False, repr=False)
class Painted(Boolean):
    """The same solid, its faces in a material of their own, which they keep in any Boolean combination.

    ``body - bore.painted(red)`` has red cuts. The material is the body's everywhere else; what light does
    inside a transparent body, too. Where paint is put on paint the inner one stays.
    """

    operand: Solid
    material: Material

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", solids("Painted", (self.operand,))[0])
        if not isinstance(self.material, Material):
            raise TypeError(f"Painted: material must be a Material, got {type(self.material).__name__}")

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)


def _spelled(solid: Solid) -> Iterator[Any]:
    """A tree as a flat sequence, parents first: what makes two of them equal."""
    pending = [solid]
    while pending:
        node = pending.pop()
        if isinstance(node, Boolean):
            yield type(node), node.motion, len(node.operands), getattr(node, "material", None)
            pending.extend(reversed(node.operands))
        else:
            yield node


def region_bounds(solid: Solid, outer: Motion) -> Box:
    """Bounds of a Boolean tree: unions surround, intersections cut, complements are carried inward (De Morgan)."""
    results: list[Box] = []
    pending: list[tuple[Solid, Motion, bool, bool]] = [(solid, outer, True, False)]
    while pending:
        node, motion, inside, combine = pending.pop()
        if not isinstance(node, Boolean):
            results.append(node.bounds_under(motion) if inside else node.outside_bounds_under(motion))
        elif combine:
            parts = results[-len(node.operands) :]
            del results[-len(node.operands) :]
            joined = isinstance(node, Union) == inside
            results.append(
                parts[0] if isinstance(node, (Complement, Painted)) else (around if joined else common)(parts)
            )
        else:
            motion_inside = node.motion.then(motion)
            pending.append((node, motion, inside, True))
            for k in range(len(node.operands) - 1, -1, -1):
                turned = isinstance(node, Complement) or (isinstance(node, Difference) and k > 0)
                pending.append((node.operands[k], motion_inside, inside != turned, False))
    return results[0]


@dataclass(frozen=True)
class ClippedSheet(Sheet):
    """The part of a sheet inside (``keep`` = "inside") or outside ("outside") every one of the solids."""

    base: Sheet
    solid: Solid
    keep: Literal["inside", "outside"] = "inside"

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
        opened = isinstance(shape, kind) and isinstance(shape, Boolean) and shape.motion == STILL
        parts.extend(shape.operands if isinstance(shape, Boolean) and opened else (shape,))
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
