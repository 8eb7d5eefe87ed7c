"""Single surfaces of a body before they are rounded: of the primitive alone that one belongs to.

A volume may be a Boolean of thousands of primitives, of which one is asked for.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import accumulate
from typing import TypeAlias

import numpy as np

from ..geometry.cell import Cell, Not, Tree
from ..geometry.shape import PrimitiveSolid, Shape
from ..geometry.surface import Surface
from ..geometry.transform import IDENTITY_MOTION, Motion, Step, Translate
from ..kernels.tables import PLANE, PLANE_SIZE
from .csg_batch import placed_primitives
from .instances import PrimitiveCache
from .lower_shape import BodyFaces, lower_shape, world_tree
from .pattern import SIZES


@dataclass
class _ShapeLeaves:
    """The primitives of a body, and the numbers of the first surface of each; surfaces that were asked for."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, list[Surface]] = field(default_factory=dict)


def exact_surface(shape: Shape, number: int) -> Surface:
    """A surface of a body, by its number among those of all its primitives."""
    if "part" in shape.kept:
        return lower_shape(shape).exact[number]
    leaves: _ShapeLeaves | None = shape.kept.get("leaves")
    if leaves is None:
        moved = placed_primitives(shape)
        if not all(isinstance(leaf, PrimitiveSolid) for leaf, _ in moved):
            return lower_shape(shape).exact[number]
        counts = (len(_tree_surfaces(leaf.tree())) for leaf, _ in moved)  # type: ignore[attr-defined]
        leaves = shape.kept["leaves"] = _ShapeLeaves(moved, [0, *accumulate(counts)])
    which = bisect_right(leaves.first, number) - 1
    if which not in leaves.known:
        leaf, steps = leaves.moved[which]
        tree = world_tree(replace(leaf, motion=Motion(steps)), IDENTITY_MOTION, BodyFaces())  # type: ignore[arg-type]
        leaves.known[which] = _tree_surfaces(tree)
    return leaves.known[which][number - leaves.first[which]]


def _tree_surfaces(tree: Tree) -> list[Surface]:
    """Those of all cells, from left to right."""
    found: list[Surface] = []
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            found += [face.surface for face in part.faces]
        else:
            pending.extend(reversed((part.part,) if isinstance(part, Not) else part.parts))
    return found


# Which surfaces are one, as it is seen before a turn that they have in common.
#
# The walls of crystals in a module that is turned, or of boxes in a row at an angle, coincide by the hundred. Their
# exact
# names would say so, at a millisecond each. But before the turn they have numbers that nothing was rounded in; those
# that
# are equal there, under the same steps of a motion, are equal after it.

FEWEST_SURFACES = 64
"""Surfaces that are worth it; of fewer, exact names are as quick."""

_PlacedPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...], tuple[Step, ...]]
"""A primitive, its translations before anything else, and the other steps."""


def names_before_rotation(
    shapes: Mapping[int, Shape], asked: Mapping[int, list[int]]
) -> dict[tuple[int, int], Hashable]:
    """What is equal for surfaces that are surely one, by the numbers of bodies and of surfaces of each.

    asked: of each body, which of its surfaces. Those of which it is not seen are left out.
    """
    moved = {
        number: list(map(_split_steps, placed_primitives(shape)))
        for number, shape in shapes.items() if "said" not in shape.kept
    }  # fmt: skip
    alone = PrimitiveCache()
    alone.prepare_primitives(
        (leaf, first) for parts in moved.values() if _is_rotated(parts) for leaf, first, _ in parts
    )
    for number, parts in moved.items():
        names: list[Hashable] = []
        for leaf, first, rest in parts if _is_rotated(parts) else ():
            numbers, _, kinds = alone.of(leaf, first)
            names += _names_of_surfaces(numbers, kinds, rest)
        shapes[number].kept["said"] = names
    return {
        (number, own): names[own]
        for number, some in asked.items() for names in (shapes[number].kept["said"],) for own in some
        if own < len(names) and names[own] is not None
    }  # fmt: skip


def _is_rotated(parts: list[_PlacedPrimitive]) -> bool:
    """Is any of the primitives of a solid more than moved elsewhere?"""
    return any(rest for _, _, rest in parts) and all(isinstance(leaf, PrimitiveSolid) for leaf, _, _ in parts)


def _split_steps(moved: tuple[Shape, tuple[Step, ...]]) -> _PlacedPrimitive:
    """A primitive with its steps in two parts."""
    leaf, steps = moved
    count = next((k for k, step in enumerate(steps) if type(step) is not Translate), len(steps))
    return leaf, steps[:count], steps[count:]


def _names_of_surfaces(numbers: list[float], kinds: tuple[int, ...], rest: tuple[Step, ...]) -> list[Hashable]:
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
            names.append((rest, *_anchorless_plane(record)))
        else:
            names.append((rest, kind, sense, *(number + 0.0 for number in record)))
    return names


def _anchorless_plane(record: list[float]) -> tuple[Hashable, ...]:
    """A plane of a record, whatever its anchor."""
    normal, height, anchor = record[:3], record[3], record[4:PLANE_SIZE]
    along = [axis for axis in range(3) if normal[axis]]
    if len(along) == 1 and not height:
        return along[0], anchor[along[0]] + 0.0
    terms = (Fraction(n) * Fraction(a) for n, a in zip(normal, anchor, strict=True) if n and a)
    return *(number + 0.0 for number in normal), sum(terms, Fraction(-height))


def surface_owners(first: np.ndarray, surfaces: np.ndarray) -> dict[int, list[int]]:
    """Which surfaces of which bodies these are; first: of each body, the number of its first."""
    bodies = np.searchsorted(first, surfaces, side="right") - 1
    found: dict[int, list[int]] = {}
    for body, own in zip(bodies.tolist(), (surfaces - first[bodies]).tolist(), strict=True):
        found.setdefault(body, []).append(own)
    return found
