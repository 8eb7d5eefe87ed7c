"""Boolean combinations of solids, and sheets clipped by solids."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from .._util.arrays import BoxEnds
from .._util.validation import describe_kind, format_value
from ..materials.material import Material
from ..materials.presets import as_material
from .bounds.aabb import enclose_boxes, intersect_boxes, is_empty
from .bounds.intersection import NO_CUTS, NO_KNOWN_BOXES, Cuts, KnownBoxes, cut_bounds
from .shape import Sheet, Solid
from .transform import IDENTITY_MOTION, Motion


class Boolean(Solid, abstract=True):
    """A combination of solids, of any depth: nothing here calls itself from level to level."""

    operands: tuple[Solid, ...]

    def bounds_under(self, outer: Motion) -> BoxEnds:
        return region_bounds(self, outer)

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        return region_bounds(Complement(self), outer)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Boolean):
            return NotImplemented
        return self is other or list(_flatten_tree(self)) == list(_flatten_tree(other))

    def __hash__(self) -> int:
        return hash(tuple(_flatten_tree(self)))

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild_tree, (list(_flatten_tree(self)),)

    def __repr__(self) -> str:
        shown = ", ".join(map(_short_repr, self.operands[:8]))
        more = f", ... {len(self.operands) - 8} more" if len(self.operands) > 8 else ""
        return f"{type(self).__name__}(({shown}{more})){self.motion.calls}"


@dataclass(frozen=True, eq=False, repr=False)
class Union(Boolean):
    """Inside any of the `operands`: ``a | b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", check_solids("Union", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(Boolean):
    """Inside all `operands`: ``a & b``. Faces: those of the operands, numbered on from left to right."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", check_solids("Intersection", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Difference(Boolean):
    """Inside the first of the `operands` and outside the others: ``a - b``. A cut shows the cutter's face number."""

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", check_solids("Difference", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Complement(Boolean):
    """Outside the operand: ``~a``; contains exactly the points that `a` does not."""

    operand: Solid

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", check_solids("Complement", (self.operand,))[0])

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)


@dataclass(frozen=True, eq=False, repr=False)
class Painted(Boolean):
    """The solid `operand`, its faces in a material of their own, which they keep in any Boolean combination.

    ``body - bore.painted(red)`` has red cuts. The material is the body's everywhere else; what light does
    inside a transparent body, too. Where paint is put on paint the inner one stays. A colour is the matte material.
    """

    operand: Solid
    material: Material

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", check_solids("Painted", (self.operand,))[0])
        object.__setattr__(self, "material", as_material("Painted", self.material))

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)

    def __repr__(self) -> str:
        return f"Painted({_short_repr(self.operand)}, {self.material!r}){self.motion.calls}"


def _short_repr(solid: Solid) -> str:
    """An operand, for the repr of what it is of."""
    return f"{type(solid).__name__}(...){solid.motion.calls}" if isinstance(solid, Boolean) else repr(solid)


def _flatten_tree(solid: Solid) -> Iterator[Any]:
    """A tree as a flat sequence, parents first: what makes two of them equal."""
    pending = [solid]
    while pending:
        node = pending.pop()
        if isinstance(node, Boolean):
            yield type(node), node.motion, len(node.operands), getattr(node, "material", None)
            pending.extend(reversed(node.operands))
        else:
            yield node


def _rebuild_tree(spelled: Sequence[Any]) -> Solid:
    """The tree of a flat sequence, for pickle and copy: from its end, as operands come before their parents."""
    done: list[Solid] = []
    for part in reversed(spelled):
        if isinstance(part, Solid):
            done.append(part)
            continue
        kind, motion, count, material = part
        operands = tuple(done.pop() for _ in range(count))
        if issubclass(kind, (Union, Intersection, Difference)):
            done.append(kind(operands, motion=motion))
        elif issubclass(kind, Painted):
            done.append(kind(operands[0], material, motion=motion))
        else:
            done.append(kind(operands[0], motion=motion))
    return done[0]


@dataclass(frozen=True, slots=True)
class _CsgNode:
    """A solid under a motion, its inside or its outside, cut by planes from further up in the tree."""

    solid: Solid
    motion: Motion
    inside: bool
    cuts: Cuts = NO_CUTS
    depth: int = 0

    @property
    def children(self) -> list[_CsgNode]:
        """The operands; of a `Difference` all but the first turned, of a `Complement` its one (De Morgan)."""
        solid = self.solid
        assert isinstance(solid, Boolean)
        motion, turned = solid.motion.then(self.motion), not self.inside
        first = turned if isinstance(solid, Complement) else self.inside
        rest = turned if isinstance(solid, Difference) else self.inside
        return [_CsgNode(part, motion, rest if k else first) for k, part in enumerate(solid.operands)]

    @property
    def meets(self) -> bool:
        """Whether it is what its children have in common, and not what they make together."""
        return isinstance(self.solid, (Complement, Painted)) or isinstance(self.solid, Union) != self.inside


_CUT_DEPTH_LIMIT = 8
_CUT_WIDTH_LIMIT = 256
"""So many levels down and operands wide planes are handed on: what lies deeper seldom needs them."""


def region_bounds(solid: Solid, outer: Motion, known: KnownBoxes = NO_KNOWN_BOXES) -> BoxEnds:
    """Bounds of a Boolean tree: unions surround, intersections cut, complements are carried inward (De Morgan).

    An intersection in an intersection is one. Its planes cut its quadrics, and those of unions in it.
    `known`: bounds of its primitives, where these are at hand.
    """
    results: list[BoxEnds] = []
    pending: list[_CsgNode | tuple[Callable[[list[BoxEnds]], BoxEnds], int]] = [_CsgNode(solid, outer, True)]
    while pending:
        node = pending.pop()
        if not isinstance(node, _CsgNode):
            combined, count = node
            parts = results[-count:]
            del results[-count:]
            results.append(combined(parts))
            continue
        primitives, unions = _split_conjuncts(node)
        box, cuts = cut_bounds([(n.solid, n.motion, n.inside) for n in primitives], node.cuts, bool(unions), known)
        results.append(box)
        if is_empty(box) or not unions:
            continue
        pending.append((intersect_boxes, 1 + len(unions)))
        for union_ in unions:
            children = union_.children
            handed_on = cuts if node.depth < _CUT_DEPTH_LIMIT and len(children) <= _CUT_WIDTH_LIMIT else NO_CUTS
            pending.append((enclose_boxes, len(children)))
            pending.extend(replace(child, cuts=handed_on, depth=node.depth + 1) for child in children)
    return results[0]


def _split_conjuncts(node: _CsgNode) -> tuple[list[_CsgNode], list[_CsgNode]]:
    """The primitives, and the unions, that a solid is the intersection of."""
    primitives, unions, pending = [], [], [node]
    while pending:
        part = pending.pop()
        if not isinstance(part.solid, Boolean):
            primitives.append(part)
        elif part.meets:
            pending.extend(reversed(part.children))
        else:
            unions.append(part)
    return primitives, unions


@dataclass(frozen=True)
class ClippedSheet(Sheet):
    """The part of a sheet inside (``keep`` = "inside") or outside ("outside") every one of the solids."""

    base: Sheet
    solid: Solid
    keep: Literal["inside", "outside"] = "inside"

    def __post_init__(self) -> None:
        if not isinstance(self.base, Sheet):
            raise TypeError(f"ClippedSheet: base must be a sheet, got {describe_kind(self.base)}")
        object.__setattr__(self, "solid", check_solids("ClippedSheet", (self.solid,))[0])
        if not isinstance(self.keep, str) or self.keep not in ("inside", "outside"):
            raise ValueError(f"ClippedSheet: keep must be 'inside' or 'outside', got {format_value(self.keep)}")

    def bounds_under(self, outer: Motion) -> BoxEnds:
        motion = self.motion.then(outer)
        clip = self.solid if self.keep == "inside" else Complement(self.solid)
        return intersect_boxes([self.base.bounds_under(motion), clip.bounds_under(motion)])


def check_solids(owner: str, operands: Any) -> tuple[Solid, ...]:
    """`operands` as a tuple of at least one solid; a sheet is a TypeError."""
    if isinstance(operands, (str, bytes)) or not isinstance(operands, Iterable):
        raise TypeError(f"{owner}: operands must be a list of solids, got {describe_kind(operands)}")
    items = tuple(operands)
    if not items:
        raise ValueError(f"{owner}: operands must hold at least one solid, got none")
    for item in items:
        if isinstance(item, Sheet):
            raise TypeError(
                f"{owner}: {type(item).__name__} is a sheet: only `sheet & solid` and `sheet - solid` clip it"
            )
        if not isinstance(item, Solid) or not getattr(item, "combines", True):
            raise TypeError(f"{owner}: operands must be solids, got {describe_kind(item)}")
    return items


def _merge_operands(kind: type, shapes: Sequence[Solid]) -> tuple[Solid, ...]:
    """Operands with unmoved ones of the same kind opened up, so that a | b | c is one node."""
    parts: list[Solid] = []
    for shape in shapes:
        opened = isinstance(shape, kind) and isinstance(shape, Boolean) and shape.motion == IDENTITY_MOTION
        parts.extend(shape.operands if isinstance(shape, Boolean) and opened else (shape,))
    return tuple(parts)


def union(a: Solid, b: Solid) -> Union:
    return Union(_merge_operands(Union, (a, b)) if isinstance(b, Solid) else (a, b))


def intersection(a: Solid, b: Any) -> Intersection | ClippedSheet:
    if isinstance(b, Sheet):
        return clip(b, a, keep_inside=True)
    return Intersection(_merge_operands(Intersection, (a, b)) if isinstance(b, Solid) else (a, b))


def difference(a: Solid, b: Solid) -> Difference:
    first = a.operands if isinstance(a, Difference) and a.motion == IDENTITY_MOTION else (a,)
    return Difference((*first, b))


def clip(sheet: Sheet, solid: Any, *, keep_inside: bool) -> ClippedSheet:
    if not isinstance(solid, Solid):
        raise TypeError(f"{type(sheet).__name__}: only a solid can clip it, got {describe_kind(solid)}")
    return ClippedSheet(sheet, solid, "inside" if keep_inside else "outside")
