"""Boolean bodies from the rows of their primitives: bodies that are built alike are put together at once.

How a body is built is a `Plan`: its tree of Boolean nodes with places for the primitives. What primitives have become
(`Form`: pattern and tree of cells) and the plan give the body's pattern, and where each of its columns comes from.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ...shapes.cells import Cell, Not, Tree
from ..tables import CELL, REGION, Floats
from .assembly import UNBOUNDED, Assembly, Slot
from .bounds import box_columns
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, Pattern
from .plan import folded
from .rows import Rows, blocks
from .trees import cells, combined, widened


@dataclass(frozen=True, eq=False)
class Form:
    """What primitives of one kind have become. There is one of each (`Forms`)."""

    pattern: Pattern
    tree: Tree | None


class Forms:
    """The forms that there are."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Form] = {}

    def of(self, pattern: Pattern, tree: Tree | None) -> Form:
        """The one of a pattern and a tree."""
        return self._known.setdefault((pattern, tree), Form(pattern, tree))


FORMS = Forms()


@dataclass
class Composition:
    """The pattern of bodies of one plan and these forms, and where the columns of their rows come from."""

    pattern: Pattern
    sources: list[tuple[int, int, int]] = field(default_factory=list)
    """Up to the boxes of leaves: (part, first column, last column)."""
    boxes: list[int] = field(default_factory=list)
    """For each leaf of the program the part whose box holds it; -1 for none."""
    faces: list[int] = field(default_factory=list)
    """The first face of each part."""

    @classmethod
    def of(cls, key: Sequence[Hashable], forms: Sequence[Form]) -> Composition:
        """Put the trees of the forms together as the plan says; what was put together of late is known."""
        return _known_composition(tuple(key), tuple(forms))

    @classmethod
    def put_together(cls, key: Sequence[Hashable], forms: Sequence[Form]) -> Composition:
        """`of`, done anew."""
        trees, faces, count = [], [], 0
        for part, form in enumerate(forms):
            assert form.tree is not None
            trees.append(_placed(form.tree, part, count, form.pattern))
            faces.append(count)
            count += len(form.pattern.angular)
        tree = folded(key, trees, combined)
        held = {id(cell): part for part, of in enumerate(trees) for cell in cells(of)}
        assembly = Assembly()
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, held)
        angular = [bool(turns) for form in forms for turns in form.pattern.angular]
        maps, rows, sources = [], 0, []
        for form in forms:
            maps += (form.pattern.maps + rows).tolist()
            rows += form.pattern.map_rows
        for slot in assembly.surfaces:
            assert isinstance(slot, Slot)
            _, column, sense = forms[slot.part].pattern.records[slot.number]
            sources.append((slot.part, column, sense + 1))
        for part, form in enumerate(forms):
            sources.append((part, form.pattern.uv_at, form.pattern.bounds_at))
        boxes = [-1 if box is UNBOUNDED else box for box in assembly.leaf_bounds]
        return cls(Pattern.of(assembly, kind, index, angular, maps), sources, boxes, faces)

    def rows(self, parts: Sequence[Rows], boxes: Floats, frames: Floats) -> Rows:
        """Rows of bodies from those of their parts, their boxes and their frames."""
        grown = {part: _table(_grown(parts[part])) for part in set(self.boxes) if part >= 0}
        if -1 in self.boxes:
            grown[-1] = _table(np.broadcast_to(np.array(UNBOUNDED), (len(boxes), BOX_NUMBERS)))
        sources = [(parts[part], first, last) for part, first, last in self.sources]
        sources += [(grown[part], 0, BOX_NUMBERS) for part in self.boxes]
        return Rows.joined([*sources, (_table(boxes), 0, BOX_NUMBERS), (_table(frames), 0, FRAME_NUMBERS)])


def _grown(rows: Rows) -> Floats:
    """The boxes of parts as those of leaves, which are wider."""
    found = np.empty((len(rows), BOX_NUMBERS))
    for some in blocks(len(rows)):
        found[some] = widened(box_columns(rows[some]))
    return found


def _table(values: Floats) -> Rows:
    """A table with all of its columns, in their order."""
    return Rows.of(values, np.arange(values.shape[1], dtype=np.int32))


@lru_cache(maxsize=64)
def _known_composition(key: tuple[Hashable, ...], forms: tuple[Form, ...]) -> Composition:
    """There is one form of each kind, and nobody changes a composition."""
    return Composition.put_together(key, forms)


def _placed(tree: Tree, part: int, first_face: int, pattern: Pattern) -> Tree:
    """The tree of a form as one part of a body."""
    if isinstance(tree, Cell):
        return Cell(
            tuple(
                dataclasses.replace(
                    face,
                    surface=Slot(int(pattern.kinds[face.surface]), part, face.surface),  # type: ignore[arg-type, call-overload]
                    number=first_face + face.number,
                )
                for face in tree.faces
            )
        )
    if isinstance(tree, Not):
        return Not(_placed(tree.part, part, first_face, pattern))
    return type(tree)(tuple(_placed(each, part, first_face, pattern) for each in tree.parts))
