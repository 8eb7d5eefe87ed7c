"""From shapes to Boolean trees of cells in the world, with faces numbered through a whole body."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from ...shapes.base import PrimitiveSolid, Solid
from ...shapes.cells import UV, All, Any_, Cell, Not, Tree
from ...shapes.material import Material
from ...shapes.motion import FloatRows, Motion
from ...shapes.region import Boolean, Complement, Difference, Painted, Union
from ..culling.slack import BOUNDS, WALL
from ..tables import Floats

EMPTY = np.array([np.inf] * 3 + [-np.inf] * 3)


@dataclass(frozen=True, eq=False)
class MapRow:
    """The four numbers of a row of a map to uv, from coordinates of the world."""

    numbers: tuple[float, ...]
    made_of: tuple[object, ...] = ()
    """What it was known by, which is held as long as it."""


_NO_MAP = MapRow((0.0, 0.0, 0.0, 0.0))
"""Of numbers that no face has."""


@dataclass
class Faces:
    """The uv maps of a body's faces, in the order of their numbers, and boxes around its cells."""

    rows: list[tuple[bool, tuple[MapRow, ...]]] = field(default_factory=list)
    """(is u an angle, the rows of the map from world coordinates: three for an angle, else two) of each face."""
    paints: dict[int, Material] = field(default_factory=dict)
    """Material of a face, where it is not the body's."""
    primitives: list[tuple[PrimitiveSolid, Motion, Tree]] = field(default_factory=list)
    _known: dict[tuple[int, int, int], MapRow] = field(default_factory=dict)

    def bounds(self) -> dict[int, tuple[float, ...]]:
        """id of a cell -> low, high: outside of them the cell does not matter to its body."""
        boxes: dict[int, tuple[float, ...]] = {}
        for solid, outer, tree in self.primitives:
            box = tuple(widened(np.array(solid.bounds_under(outer)).reshape(1, 6))[0].tolist())
            boxes.update((id(cell), box) for cell in cells(tree))
        return boxes

    def put(self, number: int, uv: UV, motion: Motion) -> None:
        """Set the uv map of a face, by a number within the body; `motion` carries its coordinates to the world."""
        while len(self.rows) <= number:
            self.rows.append((False, (_NO_MAP, _NO_MAP)))
        own = uv.matrix if uv.angular else uv.matrix[:2]
        self.rows[number] = uv.angular, tuple(self._in_world(row, motion) for row in own)

    def maps(self) -> tuple[list[tuple[float, ...]], list[tuple[int, int, int]]]:
        """Each row of the maps once, and for each face which rows are its own; of a flat one the third is its first.

        Rows are one where shapes make them once, for several faces, and not where numbers happen to agree: so how many
        a body has is told by how it is built.
        """
        places: dict[int, int] = {}
        distinct: list[tuple[float, ...]] = []
        for _, rows in self.rows:
            for row in rows:
                if places.setdefault(id(row), len(distinct)) == len(distinct):
                    distinct.append(row.numbers)
        return distinct, [(*(places[id(row)] for row in (*rows, rows[0])[:3]),) for _, rows in self.rows]  # type: ignore[misc]

    def _in_world(self, own: tuple[float, float, float, float], motion: Motion) -> MapRow:
        """A row of a map after the motion is undone: the same object for the same row and motion of one primitive.

        Of one primitive, as two are two even where they are one object that is used twice.
        """
        key = len(self.primitives), id(own), id(motion)
        if key not in self._known:
            self._known[key] = MapRow(_composed(own, motion.inverse_rows), (own, motion))
        return self._known[key]


def _composed(own: tuple[float, float, float, float], then: FloatRows) -> tuple[float, ...]:
    """A row of an affine map after another map; the sums are those of a product of 4 × 4 matrices."""
    (a, b, c, d), last = own, (0.0, 0.0, 0.0, 1.0)
    return tuple(((a * then[0][k] + b * then[1][k]) + c * then[2][k]) + d * last[k] for k in range(4))


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
            results.append(combined(type(node), parts))
            if isinstance(node, Painted):
                for face in range(first_face, len(faces.rows)):
                    faces.paints.setdefault(face, node.material)
        else:
            pending.append((node, motion, len(faces.rows)))
            inner = node.motion.then(motion)
            pending.extend((part, inner, -1) for part in reversed(node.operands))
    return results[0]


def combined(kind: type[Boolean], parts: list[Tree]) -> Tree:
    """The tree of a Boolean node of a kind from those of its operands."""
    if kind is Complement:
        return negation(parts[0])
    if kind is Painted:
        return parts[0]
    if kind is Union:
        return _joined(Any_, parts)
    if kind is Difference:
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
            faces.put(number, face.uv, motion)
            moved.append(dataclasses.replace(face, surface=face.surface.moved(motion), number=number))
        return Cell(tuple(moved))
    if isinstance(tree, Not):
        return negation(_moved(tree.part, motion, faces, first))
    return _joined(type(tree), [_moved(part, motion, faces, first) for part in tree.parts])


def cells(tree: Tree) -> list[Cell]:
    """All cells of a primitive, which may be culled where a ray misses the primitive's box.

    None where its tree has a complement: it might be inside although all of its cells are not.
    """
    found, pending = [], [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Not):
            return []
        if isinstance(part, Cell):
            found.append(part)
        else:
            pending.extend(part.parts)
    return found


def widened(boxes: Floats) -> Floats:
    """Boxes (n, 6) grown by some ulps; (inf, -inf) where they are empty."""
    low, high = boxes[:, :3], boxes[:, 3:]
    size = np.maximum(np.where(np.isfinite(low), np.abs(low), 0.0), np.where(np.isfinite(high), np.abs(high), 0.0))
    margin = BOUNDS * size + WALL
    grown = np.concatenate([low - margin, high + margin], axis=1)
    return np.where(np.asarray((low > high).any(axis=1))[:, None], EMPTY, grown)
