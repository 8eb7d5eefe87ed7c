"""MCNP's regions: blank is an intersection and binds before ":", "#" is a complement and binds first."""

from __future__ import annotations

import re
from collections.abc import Callable

from ..nodes import shortened
from ..openmc.region import LONGEST_REGION, MAX_HALF_SPACES, MAX_PARENTHESES, Both, Either, Half, Region
from .numbers import integer

DEEPEST = 60
"""Levels of unions within intersections within unions."""
_HALF = re.compile(r"([-+]?)([0-9]{1,9})(?:\.([0-9]{1,2}))?")


class Regions:
    """Reads regions; `side` gives the negative side of a surface or facet, `cell` the region of a cell."""

    def __init__(self, side: Callable[[int, int | None], Region], cell: Callable[[int], Region]) -> None:
        self.side, self.cell = side, cell
        self.left = MAX_HALF_SPACES

    def read(self, words: list[str]) -> Region:
        """The region of some words. Raises ValueError."""
        reader = _Reader(self, words)
        region = reader.union()
        if reader.word:
            raise ValueError(f"region: a ')' without its '(' (at {shortened(reader.word, 20)!r})")
        self.left -= reader.count
        if depth(region) > DEEPEST:
            raise ValueError(f"region: nests deeper than {DEEPEST} levels, with the cells that it refers to")
        return region


class _Reader:
    """Recursive descent over words."""

    def __init__(self, regions: Regions, words: list[str]) -> None:
        self.regions, self.words = regions, words
        self.at, self.inside, self.count = 0, 0, 0

    @property
    def word(self) -> str:
        return self.words[self.at] if self.at < len(self.words) else ""

    def union(self) -> Region:
        parts = [self.intersection()]
        while self.word == ":":
            self.at += 1
            parts.append(self.intersection())
        return joined(Either, parts)

    def intersection(self) -> Region:
        parts = [self.operand()]
        while self.word not in ("", ":", ")"):
            parts.append(self.operand())
        return joined(Both, parts)

    def operand(self) -> Region:
        word = self.word
        self.at += 1
        if word == "#":
            return negated(self.complemented())
        if word == "(":
            return self.parenthesis()
        found = _HALF.fullmatch(word)
        if found is None:
            raise ValueError(
                f"region: {shortened(word, 20)!r} is no surface, '#' or '('" if word else "region: ends early"
            )
        side = self.regions.side(int(found[2]), None if found[3] is None else int(found[3]))
        side = side if found[1] == "-" else negated(side)
        self._counted(side)
        return side

    def complemented(self) -> Region:
        word = self.word
        if word in ("(", "#"):
            return self.operand()
        self.at += 1
        region = self.regions.cell(integer("the cell after '#'", word))
        self._counted(region)
        return region

    def parenthesis(self) -> Region:
        if self.inside >= MAX_PARENTHESES:
            raise ValueError(f"region: parentheses nest deeper than {MAX_PARENTHESES} levels")
        self.inside += 1
        region = self.union()
        if self.word != ")":
            raise ValueError("region: a ')' is missing")
        self.at += 1
        self.inside -= 1
        return region

    def _counted(self, region: Region) -> None:
        self.count += size(region)
        if self.count > min(LONGEST_REGION, self.regions.left):
            raise ValueError(
                f"region: has too many half-spaces: at most {LONGEST_REGION:,} stand in one region, "
                f"and {MAX_HALF_SPACES:,} in those of a file together"
            )


def joined(kind: type[Both] | type[Either], parts: list[Region]) -> Region:
    """One node of a kind, nodes of the same kind among the parts opened up."""
    opened: list[Region] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))


def negated(region: Region) -> Region:
    """The complement, carried down to the half-spaces."""
    if isinstance(region, Half):
        return Half(region.surface, not region.positive)
    kind = Either if isinstance(region, Both) else Both
    return kind(tuple(map(negated, region.parts)))


def renumbered(region: Region, number: Callable[[int], int]) -> Region:
    """With other surfaces in their place."""
    if isinstance(region, Half):
        return Half(number(region.surface), region.positive)
    return type(region)(tuple(renumbered(part, number) for part in region.parts))


def size(region: Region) -> int:
    return 1 if isinstance(region, Half) else sum(map(size, region.parts))


def depth(region: Region) -> int:
    return 0 if isinstance(region, Half) else 1 + max(map(depth, region.parts))
