"""What of a solid is turned by angles, which surfaces cannot say without rounding: it fills a cell, as a universe.

OpenMC turns what fills a cell by three angles or a matrix, and then shifts it. So a solid that is an intersection of
parts, some of them under further turns and shifts, is a cell with the unturned parts, filled with a universe that is
turned, in which there is a cell with the turned ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from ....shapes.base import Solid
from ....shapes.motion import STILL, Motion
from ....shapes.quadric import Quadric
from ....shapes.region import Boolean, Complement, Difference, Intersection
from ....shapes.steps import Rotate, Step, Transform, Translate
from ...openmc.placement import Rows, inverse
from ..numbers import decimal, words


@dataclass(frozen=True)
class Level:
    """How what fills a cell is placed: the texts of the attributes `rotation` and `translation`."""

    rotation: str = ""
    translation: str = ""

    @property
    def attributes(self) -> str:
        """As they stand in an element."""
        told = [(name, getattr(self, name)) for name in ("rotation", "translation")]
        return "".join(f' {name}="{value}"' for name, value in told if value)


@dataclass(frozen=True)
class Nested:
    """A solid as parts in universes within universes: `levels` lead from each to the next; the first is the root."""

    parts: tuple[tuple[Solid, ...], ...]
    levels: tuple[tuple[Level, ...], ...]


def nested(solid: Solid) -> Nested | None:
    """A solid by levels; None where nothing of it is turned, or where that is said otherwise than by angles."""
    groups: dict[tuple[Step, ...], list[Solid]] = {}
    for operand in _parts(solid):
        own, outer = _split(operand)
        groups.setdefault(outer, []).append(own)
    if set(groups) == {()}:
        return None
    chain = sorted(groups, key=len)
    if chain[0] != ():
        chain.insert(0, ())
    levels = []
    for around, inner in pairwise(chain):
        if around and inner[-len(around) :] != around:
            return None
        further = _levels(inner[: len(inner) - len(around)])
        if further is None:
            return None
        levels.append(further)
    return Nested(tuple(tuple(groups.get(steps, ())) for steps in chain), tuple(levels))


def _parts(solid: Solid, outer: Motion = STILL) -> Iterator[Solid]:
    """What a solid is the intersection of, under a further motion."""
    if not isinstance(solid, Intersection | Difference):
        yield _under(solid, outer)
        return
    motion = solid.motion.then(outer)
    for k, operand in enumerate(solid.operands):
        if k and isinstance(solid, Difference):
            yield Complement(_under(operand, motion))
        else:
            yield from _parts(operand, motion)


def _under(solid: Solid, outer: Motion) -> Solid:
    return solid._moved(solid.motion.then(outer)) if outer.steps else solid


def _split(solid: Solid) -> tuple[Solid, tuple[Step, ...]]:
    """A solid before its turns by odd angles and what follows them, and these.

    A quadric of ten coefficients that was shifted is one too: about the origin it would have others, rounded.
    """
    if isinstance(solid, Complement) and solid.motion.is_identity:
        own, outer = _split(solid.operand)
        return Complement(own), outer
    steps = solid.motion.steps
    if isinstance(solid, Quadric) and steps and isinstance(steps[0], Translate):
        return solid._moved(STILL), steps
    first = next((k for k, step in enumerate(steps) if _is_odd(step)), len(steps))
    if isinstance(solid, Boolean) and first < len(steps):
        first = 0
    if first == len(steps):
        return solid, ()
    return solid._moved(Motion(steps[:first]) if first else STILL), steps[first:]


def _is_odd(step: Step) -> bool:
    """Does a step turn by anything but multiples of 90 degrees?"""
    if isinstance(step, Rotate):
        return step.degrees % 90 != 0 or sum(map(bool, step.axis)) > 1
    return isinstance(step, Transform) and not _is_exchange(step)


def _is_exchange(step: Transform) -> bool:
    rows = [row[:3] for row in step.matrix[:3]]
    lines = [*rows, *zip(*rows, strict=True)]
    return all(sorted(map(abs, line)) == [0, 0, 1] for line in lines)


def _levels(steps: tuple[Step, ...]) -> tuple[Level, ...] | None:
    """Steps as fillings, the outermost first; None where they are others than turns and shifts."""
    found: list[Level] = []
    pending = list(steps)
    while pending:
        rotation, shift = "", ""
        if isinstance(pending[0], Transform):
            matrix = pending.pop(0).matrix  # type: ignore[union-attr]
            if any(row[3] for row in matrix[:3]):
                return None
            rows: Rows = tuple(tuple(map(Fraction, row[:3])) for row in matrix[:3])  # type: ignore[assignment]
            back = inverse(rows)
            if back is None:
                return None
            rotation = words(_plain(value) for row in back for value in row)
        else:
            angles = [Fraction(0)] * 3
            for axis in (2, 1, 0):
                if pending and isinstance(pending[0], Rotate) and _along(pending[0]) == axis:
                    step = pending.pop(0)
                    sign = 1 if step.axis[axis] > 0 else -1  # type: ignore[union-attr]
                    angles[axis] = sign * decimal(step.degrees)  # type: ignore[union-attr]
            rotation = words(angles) if any(angles) else ""
        if pending and isinstance(pending[0], Translate):
            shift = words(pending.pop(0).offset)  # type: ignore[union-attr]
        if not rotation and not shift:
            return None
        found.append(Level(rotation, shift))
    return tuple(reversed(found))


def _plain(value: Fraction) -> float | Fraction:
    return float(value) if Fraction(float(value)) == value else value


def _along(step: Rotate) -> int | None:
    """The axis of coordinates that a turn is about."""
    along = [i for i in range(3) if step.axis[i]]
    return along[0] if len(along) == 1 else None
