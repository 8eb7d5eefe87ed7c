"""How a Boolean body is built: its nodes with places for the primitives, which are alike in many bodies."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from ...shapes.base import PrimitiveSolid, Shape
from ...shapes.material import Material
from ...shapes.region import Boolean, Painted
from ...shapes.steps import Step


@dataclass(slots=True)
class Plan:
    """How a Boolean body is built, and its primitives from left to right with the steps that move each."""

    key: tuple[Hashable, ...]
    leaves: list[tuple[Shape, tuple[Step, ...]]]
    painted: list[tuple[int, int, Material]]  # first and last leaf, from the innermost paint outward


@cache
def is_a(kind: Any, of: Any) -> bool:
    """`issubclass`, which is asked of every node, from a table."""
    return issubclass(kind, of)


def plan_of(solid: Boolean, still: bool = False) -> Plan | None:
    """The plan of a solid; None where there is more in it than primitives and Boolean nodes.

    still: without the solid's own motion, which comes last among the steps of every leaf.
    """
    key: list[Hashable] = []
    leaves: list[tuple[Shape, tuple[Step, ...]]] = []
    painted: list[tuple[int, int, Material]] = []
    pending: list[tuple[Any, tuple[Step, ...], int]] = [(solid, (), -1)]
    while pending:
        node, steps, first = pending.pop()
        if first >= 0:
            painted.append((first, len(leaves), node.material))
            continue
        mine = () if still and node is solid else node.motion.steps
        inner = mine + steps if mine else steps
        kind: Any = type(node)
        if is_a(kind, Boolean):
            operands = node.operands
            key.append((kind, len(operands)))
            if kind is Painted:
                pending.append((node, steps, len(leaves)))
            pending.extend((part, inner, -1) for part in reversed(operands))
        elif is_a(kind, PrimitiveSolid):
            key.append(kind)
            leaves.append((node, inner))
        else:
            return None
    return Plan(tuple(key), leaves, painted)


def primitives(shape: Shape) -> list[tuple[Shape, tuple[Step, ...]]]:
    """The primitives of a shape with the steps that move each: its own where it is one."""
    plan = plan_of(shape) if isinstance(shape, Boolean) else None
    return [(shape, shape.motion.steps)] if plan is None else plan.leaves


def folded(key: Sequence[Hashable], leaves: Sequence[Any], combined: Callable[[Any, list[Any]], Any]) -> Any:
    """What a plan makes of something for each of its leaves: combined(kind of node, operands), from the leaves up."""
    results: list[Any] = []
    rest = list(leaves)
    for entry in reversed(key):  # nodes come before their operands
        if not isinstance(entry, tuple):
            results.append(rest.pop())
            continue
        kind, count = entry
        parts = results[-count:][::-1]
        del results[-count:]
        results.append(combined(kind, parts))
    return results[0]
