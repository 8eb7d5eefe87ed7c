"""Which surfaces are one, as it is seen before a turn that they have in common.

The walls of crystals in a module that is turned, or of boxes in a row at an angle, coincide by the hundred. Their exact
names would say so, at a millisecond each. But before the turn they have numbers that nothing was rounded in; those that
are equal there, under the same steps of a motion, are equal after it.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from ...shapes.base import PrimitiveSolid, Shape
from ...shapes.steps import Step, Translate
from ..tables import PLANE, PLANE_SIZE
from .alone import Alone
from .pattern import SIZES
from .plan import primitives

FEWEST = 64
"""Surfaces that are worth it; of fewer, exact names are as quick."""

_Moved: TypeAlias = tuple[Shape, tuple[Step, ...], tuple[Step, ...]]
"""A primitive, its translations before anything else, and the other steps."""


def said_before_turns(shapes: Mapping[int, Shape], asked: Mapping[int, list[int]]) -> dict[tuple[int, int], Hashable]:
    """What is equal for surfaces that are surely one, by the numbers of bodies and of surfaces of each.

    asked: of each body, which of its surfaces. Those of which it is not seen are left out.
    """
    moved = {
        number: list(map(_parted, primitives(shape)))
        for number, shape in shapes.items() if "said" not in shape.kept
    }  # fmt: skip
    alone = Alone()
    alone.prepare_primitives((leaf, first) for parts in moved.values() if _turned(parts) for leaf, first, _ in parts)
    for number, parts in moved.items():
        names: list[Hashable] = []
        for leaf, first, rest in parts if _turned(parts) else ():
            numbers, _, kinds = alone.of(leaf, first)
            names += _names(numbers, kinds, rest)
        shapes[number].kept["said"] = names
    return {
        (number, own): names[own]
        for number, some in asked.items() for names in (shapes[number].kept["said"],) for own in some
        if own < len(names) and names[own] is not None
    }  # fmt: skip


def _turned(parts: list[_Moved]) -> bool:
    """Is any of the primitives of a solid more than moved elsewhere?"""
    return any(rest for _, _, rest in parts) and all(isinstance(leaf, PrimitiveSolid) for leaf, _, _ in parts)


def _parted(moved: tuple[Shape, tuple[Step, ...]]) -> _Moved:
    """A primitive with its steps in two parts."""
    leaf, steps = moved
    count = next((k for k, step in enumerate(steps) if type(step) is not Translate), len(steps))
    return leaf, steps[:count], steps[count:]


def _names(numbers: list[float], kinds: tuple[int, ...], rest: tuple[Step, ...]) -> list[Hashable]:
    """Of each surface of a primitive before a turn; None where something was rounded, or there is none."""
    names: list[Hashable] = []
    at = 0
    for kind in kinds:
        size = SIZES[kind]
        record, lost, sense = numbers[at : at + size], numbers[at + size : at + 2 * size], numbers[at + 2 * size]
        at += 2 * size + 1
        if not rest or any(lost):
            names.append(None)
        elif kind == PLANE:
            names.append((rest, *_plane(record)))
        else:
            names.append((rest, kind, sense, *(number + 0.0 for number in record)))
    return names


def _plane(record: list[float]) -> tuple[Hashable, ...]:
    """A plane of a record, whatever its anchor."""
    normal, height, anchor = record[:3], record[3], record[4:PLANE_SIZE]
    along = [axis for axis in range(3) if normal[axis]]
    if len(along) == 1 and not height:
        return along[0], anchor[along[0]] + 0.0
    terms = (Fraction(n) * Fraction(a) for n, a in zip(normal, anchor, strict=True) if n and a)
    return *(number + 0.0 for number in normal), sum(terms, Fraction(-height))


def owners(first: np.ndarray, surfaces: np.ndarray) -> dict[int, list[int]]:
    """Which surfaces of which bodies these are; first: of each body, the number of its first."""
    bodies = np.searchsorted(first, surfaces, side="right") - 1
    found: dict[int, list[int]] = {}
    for body, own in zip(bodies.tolist(), (surfaces - first[bodies]).tolist(), strict=True):
        found.setdefault(body, []).append(own)
    return found
