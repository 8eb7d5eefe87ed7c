"""Plans of Boolean bodies: how each is built of its primitives, and the forms in which these are lowered."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..geometry.cell import Tree
from ..geometry.shape import Boolean, Painted, PrimitiveSolid, Shape
from ..geometry.transform import Step
from ..materials.material import Material
from .pattern import BodyPattern


@dataclass(slots=True)
class CsgPlan:
    """The structure of a Boolean body, and its primitives from left to right with the steps that move each."""

    key: tuple[Hashable, ...]
    leaves: list[tuple[Shape, tuple[Step, ...]]]
    painted: list[tuple[int, int, Material]]  # (first leaf, last leaf, material), from the innermost paint outward


@cache
def is_subclass(kind: Any, of: Any) -> bool:
    """Cached `issubclass`: it is called for every node."""
    return issubclass(kind, of)


def csg_plan(solid: Boolean, still: bool = False) -> CsgPlan | None:
    """Build the plan of a solid; None where it holds more than primitives and Boolean nodes.

    With `still` the solid's own motion, which comes last among the steps of every leaf, is left out.
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
        if is_subclass(kind, Boolean):
            operands = node.operands
            key.append((kind, len(operands)))
            if kind is Painted:
                pending.append((node, steps, len(leaves)))
            pending.extend((part, inner, -1) for part in reversed(operands))
        elif is_subclass(kind, PrimitiveSolid):
            key.append(kind)
            leaves.append((node, inner))
        else:
            return None
    return CsgPlan(tuple(key), leaves, painted)


def placed_primitives(shape: Shape) -> list[tuple[Shape, tuple[Step, ...]]]:
    """List the primitives of a shape with the steps that move each; the shape itself where it has no plan."""
    plan = csg_plan(shape) if isinstance(shape, Boolean) else None
    return [(shape, shape.motion.steps)] if plan is None else plan.leaves


def fold_plan(key: Sequence[Hashable], leaves: Sequence[Any], combined: Callable[[Any, list[Any]], Any]) -> Any:
    """Fold a plan over one value for each leaf, from the leaves up: `combined(node type, operands)`."""
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


@dataclass(frozen=True, eq=False)
class PrimitiveForm:
    """The lowered structure of primitives of one kind. There is one object of each (`PrimitiveForms`)."""

    pattern: BodyPattern
    tree: Tree | None


class PrimitiveForms:
    """A registry of forms: equal pattern and tree give the same object."""

    def __init__(self) -> None:
        self._cache: dict[Hashable, PrimitiveForm] = {}

    def of(self, pattern: BodyPattern, tree: Tree | None) -> PrimitiveForm:
        """Return the form of a pattern and a tree."""
        return self._cache.setdefault((pattern, tree), PrimitiveForm(pattern, tree))


FORMS = PrimitiveForms()
