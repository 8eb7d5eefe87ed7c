"""Single surfaces of a body before they are rounded: of the primitive alone that one belongs to.

A volume may be a Boolean of thousands of primitives, of which one is asked for.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from itertools import accumulate

from ...shapes.base import PrimitiveSolid, Shape
from ...shapes.cells import Cell, Not, Tree
from ...shapes.motion import STILL, Motion
from ...shapes.steps import Step
from ...shapes.surface import Surface
from .parts import part_of
from .plan import primitives
from .trees import Faces, world_tree


@dataclass
class _Leaves:
    """The primitives of a body, and the numbers of the first surface of each; surfaces that were asked for."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, list[Surface]] = field(default_factory=dict)


def exact_surface(shape: Shape, number: int) -> Surface:
    """A surface of a body, by its number among those of all its primitives."""
    if "part" in shape.kept:
        return part_of(shape).exact[number]
    leaves: _Leaves | None = shape.kept.get("leaves")
    if leaves is None:
        moved = primitives(shape)
        if not all(isinstance(leaf, PrimitiveSolid) for leaf, _ in moved):
            return part_of(shape).exact[number]
        counts = (len(_surfaces(leaf.tree())) for leaf, _ in moved)  # type: ignore[attr-defined]
        leaves = shape.kept["leaves"] = _Leaves(moved, [0, *accumulate(counts)])
    which = bisect_right(leaves.first, number) - 1
    if which not in leaves.known:
        leaf, steps = leaves.moved[which]
        tree = world_tree(replace(leaf, motion=Motion(steps)), STILL, Faces())  # type: ignore[arg-type]
        leaves.known[which] = _surfaces(tree)
    return leaves.known[which][number - leaves.first[which]]


def _surfaces(tree: Tree) -> list[Surface]:
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
