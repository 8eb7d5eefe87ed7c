"""Bodies that are written alike, made together: what they have in common is read once, and their numbers in columns.

What is plain in one of them is plain in all, as they are of one pattern; what their numbers decide is looked at for all
at once. Nothing is reported or counted here. A body of which anything is in doubt is left to `PlainBodies`, and all of
a pattern are where there is something to warn of, or more to them than is plain.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias

from ..shapes import Shape
from ..shapes.body import Body
from ..shapes.carried import made_of, said
from ..shapes.many_motions import Steps, motions, same, scaled, transformed, translated, turned
from ..shapes.motion import AXES, STILL, Motion
from ..shapes.steps import STAYS
from ..shapes.warned import Warned, refused
from .alike import Alike, Item, Pattern
from .nodes import Listing, Node, Scalar, Table, is_text
from .plain_bodies import (
    DEEPEST,
    MadeBy,
    PlainBodies,
    Unusual,
    followed,
    made_by,
    matrix_of,
    number,
    text_of,
    vector_of,
)
from .shape_nodes import MAX_STEPS, moved_by

_LEAST = 8
"""Bodies of a pattern that are worth it."""
_DOUBT = (Unusual, Warned, ValueError, TypeError, ArithmeticError)
_DOUBTFUL: Any = object()


class Made(NamedTuple):
    """A body as it was made, and what is to be counted of it."""

    body: Body
    parts: int
    steps: int
    """Of its motions."""
    name_line: int


@dataclass
class _Same:
    """The shape that all have."""

    shape: Shape


_Shapes: TypeAlias = _Same | list[Shape | None]
"""The shape of each; None where it is in doubt."""


def made_together(first: int, items: Sequence[Item], plain: PlainBodies) -> dict[int, Made]:
    """Bodies by their places, of which the first is said: those that could be made with others."""
    groups: dict[Any, list[int]] = {}
    words_of: dict[int, _Words] = {}
    for place, item in enumerate(items):
        if type(item) is Alike:
            words = words_of.get(id(item.pattern))
            if words is None:
                words = words_of[id(item.pattern)] = _Words(item.pattern)
            groups.setdefault((words, words.key(item.words)), []).append(place)
    found: dict[int, Made] = {}
    for (words, _), places in groups.items():
        if len(places) >= _LEAST:
            group = _Group(words, [items[place] for place in places], plain)  # type: ignore[misc]
            found.update((first + places[k], made) for k, made in group.made())
    return found


class _Words:
    """What stands in the places of a pattern: numbers, the body's name and material, or what tells bodies apart."""

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        own = [id(pattern.item.entries.get(name)) for name in ("name", "material")]
        self.numbers = [k for k, is_number in enumerate(pattern.is_number) if is_number]
        others = [k for k, place in enumerate(pattern.places) if id(place.node) not in own and not pattern.is_number[k]]
        self.key: Callable[[Sequence[str]], Any] = itemgetter(*others) if others else _nothing


def _nothing(_: Sequence[str]) -> None:
    """What bodies are told apart by that differ in numbers, names and materials alone."""


class _Group:
    """Bodies of one pattern that have the same words, but for numbers and their names and materials."""

    def __init__(self, words: _Words, items: Sequence[Alike], plain: PlainBodies) -> None:
        self.pattern, self.items, self.plain, self.count = words.pattern, items, plain, len(items)
        self.columns = list(zip(*[item.words for item in items], strict=True))
        places = self.pattern.places
        self.numbers = {
            id(places[k].node): self.columns[k]
            for k in words.numbers
            if self.columns[k].count(self.columns[k][0]) < self.count
        }
        """The words of numbers that are not the same in all."""
        self.varied: dict[int, bool] = {}
        self.steps = 0

    def made(self) -> Iterator[tuple[int, Made]]:
        """Bodies by their numbers among those of the group, without those that are in doubt."""
        plain, first = self.plain, self.items[0]
        self.pattern.filled(first.words, first.line)
        plain.lasting, plain.steps = False, 0
        try:
            with refused():
                bodies = self._bodies()
        except _DOUBT:
            return
        finally:
            plain.lasting = True
        steps, entries = self.steps + plain.steps, self.pattern.item.entries
        row = self.pattern.row_of[self._place_of(entries["name"])] if "name" in entries else 0
        parts = 0
        for k, (item, body) in enumerate(zip(self.items, bodies, strict=True)):
            if body.shape is not None and body.name is not _DOUBTFUL and body.material is not _DOUBTFUL:
                parts = parts or 1 + plain.shapes.size(body.shape)  # it is that of all
                yield k, Made(body, parts, steps, item.line + row)

    def _bodies(self) -> list[Body]:
        """All of them, as `PlainBodies.read` reads one."""
        entries = self.pattern.item.entries
        if "shape" not in entries or not entries.keys() <= {"shape", "name", "material", "move"}:
            raise Unusual
        shapes = self._shapes(entries["shape"], 0)
        names = self._words(entries["name"], str) if "name" in entries else repeat(None)
        materials = self._words(entries["material"], self._material) if "material" in entries else repeat(None)
        if "move" in entries:
            shapes = self._moved(shapes, entries["move"])
        each: Iterable[Shape | None]
        if isinstance(shapes, _Same):
            is_named = any(shapes.shape is named for named in self.plain.shapes.built.values())
            each = [shapes.shape] * self.count if is_named else self._twins(shapes.shape, repeat(shapes.shape.motion))
        else:
            each = shapes
        return made_of(
            Body, self.count, shape=each, material=materials, name=names, materials=repeat(None),
            material_index=repeat(None),
        )  # fmt: skip

    def _material(self, word: str) -> Any:
        return self.plain.material(Scalar(0, 0, word, False))

    def _words(self, node: Node, meaning: Callable[[str], Any]) -> list[Any]:
        """What the words at a node mean, texts all of them; `_DOUBTFUL` for others."""
        text_of(node)
        words, found = self.columns[self._place_of(node)], dict[str, Any]()
        for word in dict.fromkeys(words):
            try:
                found[word] = meaning(text_of(Scalar(0, 0, word, node.plain)))  # type: ignore[union-attr]
            except _DOUBT:
                found[word] = _DOUBTFUL
        return list(map(found.__getitem__, words))

    def _place_of(self, node: Node) -> int:
        place = self.pattern.number_of.get(id(node))
        if place is None:
            raise Unusual
        return place

    def _varies(self, node: Node) -> bool:
        """Are there numbers at a node, or below it, that are not the same in all?"""
        if type(node) is Scalar:
            return id(node) in self.numbers
        known = self.varied.get(id(node))
        if known is None:
            below = node.items if isinstance(node, Listing) else node.entries.values()  # type: ignore[union-attr]
            known = self.varied[id(node)] = any(self._varies(each) for each in below)
        return known

    def _values(self, node: Node) -> list[Any]:
        """What stands at a node in each: numbers, or tuples of what stands below."""
        if isinstance(node, Listing):
            return list(zip(*map(self._values, node.items), strict=True)) or [()] * self.count
        words = self.numbers.get(id(node))
        return [number(node)] * self.count if words is None else list(map(float, words))

    def _shapes(self, node: Node, depth: int) -> _Shapes:
        """The shapes at a node, as `PlainBodies.shape` reads one."""
        if not self._varies(node):
            return _Same(self.plain.shape(node, depth))
        if type(node) is not Table or len(node.entries) - ("move" in node.entries) != 1 or depth > DEEPEST:
            raise Unusual
        head = next(name for name in node.entries if name != "move")
        value = node.entries[head]
        shapes = self._shapes(value, depth + 1) if head == "shape" else self._built(made_by(head), value, depth)
        return self._moved(shapes, node.entries["move"]) if "move" in node.entries else shapes

    def _built(self, made: MadeBy | None, node: Node, depth: int) -> _Shapes:
        """Primitives of their fields, or combinations of their operands."""
        if made is None:
            raise Unusual
        if not self._varies(node):
            return _Same(self.plain.built(made, node, depth))
        if made.fields:
            given = self.plain.values(made, node)
            assert isinstance(node, Table)
            own = {name: self._values(value) for name, value in node.entries.items() if self._varies(value)}
            make = functools.partial(made.make, **{name: given[name] for name in given if name not in own})
            names = tuple(own)
            return _each(lambda *row: make(**dict(zip(names, row, strict=True))), zip(*own.values(), strict=True))
        if not made.several:
            return _each(made.make, zip(self._listed(node, depth), strict=True))
        if type(node) is not Listing:
            raise Unusual
        rows = zip(*[self._listed(item, depth) for item in node.items], strict=True)
        return _each(lambda *row: made.make(row), rows)

    def _listed(self, node: Node, depth: int) -> list[Shape | None]:
        """The operands at a node."""
        shapes = self._shapes(node, depth + 1)
        return [shapes.shape] * self.count if isinstance(shapes, _Same) else shapes

    def _moved(self, shapes: _Shapes, node: Node) -> _Shapes:
        """The shapes after all steps of a list."""
        if type(node) is not Listing or len(node.items) > MAX_STEPS:
            raise Unusual
        of_all = isinstance(shapes, _Same)
        example = shapes.shape if isinstance(shapes, _Same) else next((one for one in shapes if one is not None), None)
        if example is None:
            raise Unusual
        before = example.motion
        self.steps += len(before.steps) + len(node.items)
        if not self._varies(node):
            motion = functools.reduce(followed, node.items, STILL)
            if isinstance(shapes, _Same):
                return _Same(moved_by(shapes.shape, motion))
            return _each(lambda shape: moved_by(shape, motion), zip(shapes, strict=True))
        then, good = motions(self.count, [self._step(step) for step in node.items], before.reach if of_all else STAYS)
        if isinstance(shapes, _Same):
            moved = self._twins(shapes.shape, map(before.then, then) if before.steps else then)
        elif before.steps:
            moved = _each(moved_by, zip(shapes, then, strict=True))
        else:
            kept = zip(shapes, then, strict=True)
            moved = [None if shape is None else shape._with_motion(motion) for shape, motion in kept]
        return [shape if fine else None for shape, fine in zip(moved, good.tolist(), strict=True)]

    def _twins(self, shape: Shape, moved: Iterable[Motion]) -> list[Shape | None]:
        """A shape under motions that were checked."""
        fields: dict[str, Iterable[Any]] = {name: repeat(value) for name, value in said(shape).items()}
        return made_of(type(shape), self.count, **{**fields, "motion": moved})

    def _step(self, node: Node) -> Steps:
        """A step of each, as `followed` reads one."""
        if not self._varies(node):
            (step,) = followed(STILL, node).steps
            return same(step)
        if type(node) is not Table or len(node.entries) != 1:
            raise Unusual
        ((verb, value),) = node.entries.items()
        if verb == "translate":
            vector_of(value)
            return translated(self._values(value))
        if verb == "scale" and type(value) is Scalar:
            return scaled([(factor, factor, factor) for factor in self._values(value)])
        if verb == "scale":
            vector_of(value)
            return scaled(self._values(value))
        if verb == "transform":
            matrix_of(value)
            return transformed(self._values(value))
        if verb != "rotate" or type(value) is not Table or value.entries.keys() != {"axis", "degrees"}:
            raise Unusual
        axis, degrees = value.entries["axis"], value.entries["degrees"]
        number(degrees)
        if type(axis) is Scalar and axis.text in AXES and is_text(axis):
            return turned([AXES[axis.text]] * self.count, self._values(degrees))
        vector_of(axis)
        return turned(self._values(axis), self._values(degrees))


def _each(make: Callable[..., Shape], rows: Iterable[tuple[Any, ...]]) -> list[Shape | None]:
    """Shapes of rows, which hold shapes or what they are made of; None for a row that is in doubt."""
    made: list[Shape | None] = []
    for row in rows:
        try:
            made.append(None if None in row else make(*row))
        except (ValueError, TypeError, ArithmeticError):
            made.append(None)
    return made
