"""From shapes to Boolean trees of cells in the world, with faces numbered through a whole body."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from ...shapes.base import PrimitiveSolid, Solid
from ...shapes.cells import UV, All, Any_, Cell, Not, Tree
from ...shapes.material import Material
from ...shapes.motion import Motion
from ...shapes.region import Boolean, Complement, Difference, Painted, Union
from ...shapes.row_vectors import product
from ..culling.slack import BOUNDS, WALL
from ..tables import Floats


@dataclass
class Faces:
    """The uv maps of a body's faces, in the order of their numbers, and boxes around its cells."""

    rows: list[Floats] = field(default_factory=list)
    paints: dict[int, Material] = field(default_factory=dict)
    """Material of a face, where it is not the body's."""
    primitives: list[tuple[PrimitiveSolid, Motion, Tree]] = field(default_factory=list)

    def bounds(self) -> dict[int, Floats]:
        """id of a cell -> (6,) low, high: outside of it the cell does not matter to its body."""
        boxes: dict[int, Floats] = {}
        for solid, outer, tree in self.primitives:
            low, high = solid.bounds_under(outer)
            boxes.update((id(cell), _widened(low, high)) for cell in _cells(tree))
        return boxes

    def put(self, number: int, uv: UV, inverse: Floats) -> None:
        """Set the uv map of a face, by a number within the body."""
        while len(self.rows) <= number:
            self.rows.append(np.zeros(13))
        self.rows[number] = np.concatenate([[float(uv.angular)], (product(np.array(uv.matrix), inverse)).ravel()])


def world_tree(solid: Solid, outer: Motion, faces: Faces) -> Tree:
    """The tree of a solid moved by `outer`; its faces take the next numbers."""
    results: list[Tree] = []
    pending: list[tuple[Solid, Motion, int]] = [(solid, outer, -1)]
    while pending:
        node, motion, first_face = pending.pop()
        if isinstance(node, PrimitiveSolid):
            tree = _moved(node.tree(), node.under(motion), faces, len(faces.rows))
            faces.primitives.append((node, motion, tree))
            results.append(tree)
        elif not isinstance(node, Boolean):
            raise TypeError(f"{type(node).__name__} cannot be part of a Boolean combination")
        elif first_face >= 0:
            parts = results[-len(node.operands) :]
            del results[-len(node.operands) :]
            results.append(_combined(node, parts))
            if isinstance(node, Painted):
                for face in range(first_face, len(faces.rows)):
                    faces.paints.setdefault(face, node.material)
        else:
            pending.append((node, motion, len(faces.rows)))
            inner = node.motion.then(motion)
            pending.extend((part, inner, -1) for part in reversed(node.operands))
    return results[0]


def _combined(node: Boolean, parts: list[Tree]) -> Tree:
    """The tree of a Boolean node from those of its operands."""
    if isinstance(node, Complement):
        return negation(parts[0])
    if isinstance(node, Painted):
        return parts[0]
    if isinstance(node, Union):
        return _joined(Any_, parts)
    if isinstance(node, Difference):
        return _joined(All, [parts[0], *(negation(part) for part in parts[1:])])
    return _joined(All, parts)


def negation(tree: Tree) -> Tree:
    """The complement of a tree, of which there are never two in a row."""
    return tree.part if isinstance(tree, Not) else Not(tree)


def _joined(kind: type[All] | type[Any_], parts: list[Tree]) -> Tree:
    """One node of a kind, nodes of the same kind among its parts opened up."""
    opened: list[Tree] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))


def _moved(tree: Tree, motion: Motion, faces: Faces, first: int) -> Tree:
    """A primitive's tree carried to the world, face numbers raised by `first`."""
    if isinstance(tree, Cell):
        moved = []
        for face in tree.faces:
            number = first + face.number
            faces.put(number, face.uv, motion.inverse_matrix)
            moved.append(dataclasses.replace(face, surface=face.surface.moved(motion), number=number))
        return Cell(tuple(moved))
    if isinstance(tree, Not):
        return negation(_moved(tree.part, motion, faces, first))
    return _joined(type(tree), [_moved(part, motion, faces, first) for part in tree.parts])


def _cells(tree: Tree) -> list[Cell]:
    """All cells of a primitive, which may be culled where a ray misses the primitive's box.

    None where its tree has a complement: it might be inside although all of its cells are not.
    """
    cells, pending = [], [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Not):
            return []
        if isinstance(part, Cell):
            cells.append(part)
        else:
            pending.extend(part.parts)
    return cells


def _widened(low: Floats, high: Floats) -> Floats:
    """A box grown by some ulps; (inf, -inf) for an empty one."""
    if (low > high).any():
        return np.concatenate([np.full(3, np.inf), np.full(3, -np.inf)])
    size = np.maximum(np.where(np.isfinite(low), np.abs(low), 0.0), np.where(np.isfinite(high), np.abs(high), 0.0))
    margin = BOUNDS * size + WALL
    return np.concatenate([low - margin, high + margin])
