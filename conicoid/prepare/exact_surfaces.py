"""Exact surfaces of a body, one at a time, from the primitive alone that a surface belongs to.

A volume may be a Boolean shape of thousands of primitives, and only one of them is needed. The second part finds
surfaces that coincide before a rotation that they have in common.
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
from .csg_plan import placed_primitives
from .instances import PrimitiveCache
from .lower_shape import BodyFaces, lower_shape, world_tree
from .pattern import SIZES


@dataclass
class _ShapeLeaves:
    """The primitives of a body, the number of the first surface of each, and the surfaces computed so far."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, list[Surface]] = field(default_factory=dict)


def exact_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body, by its number among those of all its primitives."""
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
    """List the surfaces of all cells, from left to right."""
    found: list[Surface] = []
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            found += [face.surface for face in part.faces]
        else:
            pending.extend(reversed((part.part,) if isinstance(part, Not) else part.parts))
    return found


# Coincident surfaces in the frame before a common rotation, where they compare exactly
#
# The walls of crystals in a rotated module, or of boxes in an oblique row, coincide by the hundred. Exact names would
# show it, at a millisecond each. But before the rotation their numbers are exact (nothing was rounded), and surfaces
# that are equal there are equal after the same steps of a motion.

FEWEST_SURFACES = 64
"""For fewer surfaces exact names are as quick."""

_PlacedPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...], tuple[Step, ...]]
"""A primitive, its leading translations, and the other steps."""


def names_before_rotation(
    shapes: Mapping[int, Shape], requested: Mapping[int, list[int]]
) -> dict[tuple[int, int], Hashable]:
    """Return keys that are equal only for surfaces that are certainly equal, by (body, surface).

    Parameters
    ----------
    shapes : Mapping[int, Shape]
        The shapes of bodies, by body number.
    requested : Mapping[int, list[int]]
        For each body, which of its surfaces.

    Returns
    -------
    dict[tuple[int, int], Hashable]
        Surfaces of unknown key are left out.
    """
    moved = {
        number: list(map(_split_steps, placed_primitives(shape)))
        for number, shape in shapes.items() if "unrotated names" not in shape.kept
    }  # fmt: skip
    primitives = PrimitiveCache()
    primitives.prepare_primitives(
        (leaf, first) for parts in moved.values() if _is_rotated(parts) for leaf, first, _ in parts
    )
    for number, parts in moved.items():
        names: list[Hashable] = []
        for leaf, first, rest in parts if _is_rotated(parts) else ():
            numbers, _, kinds = primitives.of(leaf, first)
            names += _names_of_surfaces(numbers, kinds, rest)
        shapes[number].kept["unrotated names"] = names
    return {
        (number, own): names[own]
        for number, some in requested.items() for names in (shapes[number].kept["unrotated names"],) for own in some
        if own < len(names) and names[own] is not None
    }  # fmt: skip


def _is_rotated(parts: list[_PlacedPrimitive]) -> bool:
    """Return whether a solid consists of primitives, and at least one of them is more than translated."""
    return any(rest for _, _, rest in parts) and all(isinstance(leaf, PrimitiveSolid) for leaf, _, _ in parts)


def _split_steps(moved: tuple[Shape, tuple[Step, ...]]) -> _PlacedPrimitive:
    """Split the steps of a primitive after the leading translations."""
    leaf, steps = moved
    count = next((k for k, step in enumerate(steps) if type(step) is not Translate), len(steps))
    return leaf, steps[:count], steps[count:]


def _names_of_surfaces(numbers: list[float], kinds: tuple[int, ...], rest: tuple[Step, ...]) -> list[Hashable]:
    """Name each surface of a primitive before the rotation; None where it was rounded, or no rotation follows."""
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
    """Describe the plane of a record independently of its anchor."""
    normal, height, anchor = record[:3], record[3], record[4:PLANE_SIZE]
    along = [axis for axis in range(3) if normal[axis]]
    if len(along) == 1 and not height:
        return along[0], anchor[along[0]] + 0.0
    # The offset n·a - height, exact.
    terms = (Fraction(n) * Fraction(a) for n, a in zip(normal, anchor, strict=True) if n and a)
    return *(number + 0.0 for number in normal), sum(terms, Fraction(-height))


def surface_owners(first: np.ndarray, surfaces: np.ndarray) -> dict[int, list[int]]:
    """Map bodies to their surfaces among these; `first` gives the first surface of each body."""
    bodies = np.searchsorted(first, surfaces, side="right") - 1
    found: dict[int, list[int]] = {}
    for body, own in zip(bodies.tolist(), (surfaces - first[bodies]).tolist(), strict=True):
        found.setdefault(body, []).append(own)
    return found
