"""Solids as regions of half-spaces: Boolean trees of cells, complements carried inward (De Morgan)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ....shapes.base import PrimitiveSolid, Solid
from ....shapes.cells import All, Cell, Not, Tree
from ....shapes.motion import STILL, Motion
from ....shapes.quadric import Quadric
from ....shapes.region import Boolean, Complement, Difference, Painted, Union
from ...openmc.region import LONGEST_REGION, MAX_PARENTHESES, Both, Either, Half, Region, halves
from ..exported import Unsayable
from .surfaces import Table

DEEPEST = 100
"""Booleans within Booleans."""
MOST = LONGEST_REGION


class Regions:
    """Makes regions of solids; primitives that come again are worked out once."""

    def __init__(self, table: Table) -> None:
        self.table = table
        self._known: dict[tuple[Solid, Motion, bool], Region] = {}

    def of(self, solid: Solid, outer: Motion = STILL) -> Region:
        """The region of a solid under a further motion. Raises Unsayable."""
        found = self._of(solid, outer, True, 0)
        count = sum(1 for _ in halves(found))
        if count > MOST:
            raise Unsayable(f"its region has {count:,} half-spaces, more than {MOST:,}")
        if _depth(found) > MAX_PARENTHESES:
            raise Unsayable(f"its region nests deeper than {MAX_PARENTHESES} levels")
        return found

    def _of(self, solid: Solid, outer: Motion, inside: bool, depth: int) -> Region:
        if isinstance(solid, Boolean):
            if depth >= DEEPEST:
                raise Unsayable(f"it nests Booleans deeper than {DEEPEST} levels")
            motion = solid.motion.then(outer)
            if isinstance(solid, (Complement, Painted)):
                sense = inside if isinstance(solid, Painted) else not inside
                return self._of(solid.operands[0], motion, sense, depth + 1)
            parts = []
            for k, operand in enumerate(solid.operands):
                turned = isinstance(solid, Difference) and k > 0
                parts.append(self._of(operand, motion, inside != turned, depth + 1))
            return joined(Either if isinstance(solid, Union) == inside else Both, parts)
        if not isinstance(solid, PrimitiveSolid):
            raise Unsayable(f"{type(solid).__name__} is no solid of planes and quadrics")
        key = solid, outer, inside
        if key not in self._known:
            self._known[key] = self._primitive(solid, outer, inside)
        return self._known[key]

    def _primitive(self, solid: PrimitiveSolid, outer: Motion, inside: bool) -> Region:
        motion = solid.under(outer)
        if (
            isinstance(solid, Quadric)
            and motion.is_identity
            and any(solid.symmetric[i][j] for i in range(3) for j in range(3))
        ):
            half = self.table.half_of_quadric(solid)
            return half if inside else negated(half)
        return self._tree(solid.tree(), motion, inside)

    def _tree(self, tree: Tree, motion: Motion, inside: bool) -> Region:
        if isinstance(tree, Cell):
            parts: list[Region] = []
            for face in tree.faces:
                half = self.table.half(face.surface.moved(motion), face.inside)
                parts.append(half if inside else negated(half))
            return joined(Both if inside else Either, parts)
        if isinstance(tree, Not):
            return self._tree(tree.part, motion, not inside)
        kind = Both if isinstance(tree, All) == inside else Either
        return joined(kind, [self._tree(part, motion, inside) for part in tree.parts])


def joined(kind: type[Both] | type[Either], parts: Iterable[Region]) -> Region:
    """One node of a kind, those of the same kind in it opened up, and each part once."""
    opened: dict[Region, None] = {}
    for part in parts:
        opened.update(dict.fromkeys(part.parts if isinstance(part, kind) else (part,)))
    if not opened:
        raise Unsayable("a part of it is empty, or all of space")
    return next(iter(opened)) if len(opened) == 1 else kind(tuple(opened))


def negated(region: Region) -> Region:
    """What is not in a region."""
    if isinstance(region, Half):
        return Half(region.surface, not region.positive)
    kind = Either if isinstance(region, Both) else Both
    return kind(tuple(negated(part) for part in region.parts))


def conjuncts(region: Region) -> tuple[Region, ...]:
    """What a region is the intersection of."""
    return region.parts if isinstance(region, Both) else (region,)


def text_of(region: Region) -> str:
    """As OpenMC writes it: -1 2 (3 | -4)."""
    return "".join(_pieces(region, False))


def _pieces(region: Region, within: bool) -> Iterator[str]:
    if isinstance(region, Half):
        yield f"{'' if region.positive else '-'}{region.surface}"
        return
    between = " " if isinstance(region, Both) else " | "
    if within:
        yield "("
    for k, part in enumerate(region.parts):
        if k:
            yield between
        yield from _pieces(part, True)
    if within:
        yield ")"


def _depth(region: Region) -> int:
    if isinstance(region, Half):
        return 0
    return 1 + max(_depth(part) for part in region.parts)
