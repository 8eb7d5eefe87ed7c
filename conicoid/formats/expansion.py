"""What a scene file grows to when its references and aliases are written out, and how much of that is borne.

Twenty lines of references that double make a million parts, each of which takes time to place. So the parts of a
file are counted before anything is made of them, and may be many only where the file is long.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any

from ..shapes import Shape
from .fields import fields_of
from .kinds import Fixed, Flag, Integer, Kind, Maybe, Number, OneOf, Several, Text

FREE_PARTS, PARTS_PER_VALUE, MAX_PARTS = 1 << 15, 4, 1_000_000
STEP_PARTS, STEP_COMPOSED = 2, 4
"""Parts that take as long as a step of a part's motion, and as one that a motion is put together from."""
PARTS = "parts and steps of motion, references written out,"


class Allowance:
    """How many parts all bodies of a file may have together, and how many steps its motions.

    values: how many stand in the file, keys among them; what an alias stands for counts once.
    """

    def __init__(self, values: int) -> None:
        self.parts = self.steps = 0
        self.most = most_parts(values)

    def take(self, parts: int = 0, steps: int = 0) -> bool:
        """Whether so many more parts, and steps to be composed, can be borne."""
        self.parts += parts
        self.steps += steps * STEP_COMPOSED
        return max(self.parts, self.steps) <= self.most


def most_parts(values: int) -> int:
    """How many parts a file of so many values may have."""
    return min(MAX_PARTS, max(FREE_PARTS, PARTS_PER_VALUE * values))


class Sizes:
    """How many parts shapes are made of, fully written out; a part that is shared is counted once for each use."""

    def __init__(self) -> None:
        self.known: dict[int, tuple[Shape, int]] = {}  # by id: the shape, kept alive, and its parts
        self.below: dict[int, tuple[Any, int]] = {}  # by id: operands, which shapes that are moved share, and theirs

    def __call__(self, shape: Shape) -> int:
        """Primitives, Booleans and, `STEP_PARTS` each, steps of motion. No recursion."""
        names = shape_fields(type(shape))
        own = 1 + STEP_PARTS * len(shape.motion.steps)
        if not names:
            return own
        operands = getattr(shape, names[0]) if len(names) == 1 else None
        known = self.below.get(id(operands)) if operands is not None else None
        if known is not None:
            return own + known[1]
        pending = [shape]
        while pending:
            top = pending[-1]
            parts = parts_of(top)
            unknown = [part for part in parts if id(part) not in self.known]
            if unknown:
                pending.extend(unknown)
                continue
            below = sum(self.known[id(part)][1] for part in parts)
            self.known[id(top)] = top, 1 + STEP_PARTS * len(top.motion.steps) + below
            pending.pop()
        size = self.known[id(shape)][1]
        if operands is not None:
            self.below[id(operands)] = operands, size - own
        return size


def expanded_parts(shapes: Iterable[Shape]) -> int:
    """The parts of all shapes together, as `Allowance` counts those of bodies."""
    size = Sizes()
    return sum(1 + size(shape) for shape in shapes)


def parts_of(shape: Shape) -> list[Shape]:
    """The shapes that a shape's fields hold."""
    held = [getattr(shape, name) for name in shape_fields(type(shape))]
    flat = [item for value in held for item in (value if isinstance(value, tuple) else (value,))]
    return [item for item in flat if isinstance(item, Shape)]


@cache
def shape_fields(cls: type[Shape]) -> tuple[str, ...]:
    """The fields of a class that may hold shapes: those that are not plainly numbers or texts."""
    return tuple(name for name, field in fields_of(cls).items() if not _is_plain(field.kind))


def _is_plain(kind: Kind) -> bool:
    if isinstance(kind, OneOf):
        return all(map(_is_plain, kind.items))
    return _is_plain(kind.item) if isinstance(kind, (Several, Fixed, Maybe)) else isinstance(kind, _PLAIN)


_PLAIN = (Number, Integer, Flag, Text)
