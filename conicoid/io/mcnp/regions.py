"""Parser of MCNP's regions: a blank is an intersection, ":" a union, "#" a complement, in falling precedence # blank :.

A complement is of a parenthesis or of a cell ("#5"). `sort_cells` orders cells so that complements refer back only.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from itertools import pairwise

from ..openmc.geometry import topological_order
from ..openmc.region import (
    LONGEST_REGION,
    MAX_HALF_SPACES,
    MAX_PARENTHESES,
    HalfSpaceNode,
    IntersectionNode,
    Region,
    UnionNode,
    join_regions,
)
from ..scene_file.nodes import shorten
from .cards import parse_integer

MAX_REGION_DEPTH = 60
"""Most levels of unions within intersections within unions."""
# A signed surface, perhaps with a facet: "-3", "3.2".
_HALF = re.compile(r"([-+]?)([0-9]{1,9})(?:\.([0-9]{1,2}))?")


class RegionReader:
    """Reader of regions: `side` returns the negative side of a surface or facet, `cell` the region of a cell.

    `budget` is the number of half-spaces that the regions still to be read may have together.
    """

    def __init__(self, side: Callable[[int, int | None], Region], cell: Callable[[int], Region]) -> None:
        self.side, self.cell = side, cell
        self.budget = MAX_HALF_SPACES

    def read(self, words: list[str]) -> Region:
        """Return the region of the words of a cell card. Raise ValueError for a wrong or too large region."""
        reader = _RegionWords(self, words)
        region = reader.union()
        # The parser of unions ends early only at a ')'
        if reader.word:
            raise ValueError(f"region: a ')' without its '(' (at {shorten(reader.word, 20)!r})")
        self.budget -= reader.count
        # Later stages walk regions by recursion
        if region_depth(region) > MAX_REGION_DEPTH:
            raise ValueError(f"region: nests deeper than {MAX_REGION_DEPTH} levels, with the cells that it refers to")
        return region


class _RegionWords:
    """A recursive descent parser over words, with one method for each level of precedence."""

    def __init__(self, regions: RegionReader, words: list[str]) -> None:
        self.regions, self.words = regions, words
        self.at, self.inside, self.count = 0, 0, 0

    @property
    def word(self) -> str:
        """The current word; empty at the end."""
        return self.words[self.at] if self.at < len(self.words) else ""

    def union(self) -> Region:
        """Return operands joined by ':'."""
        parts = [self.intersection()]
        while self.word == ":":
            self.at += 1
            parts.append(self.intersection())
        return join_regions(UnionNode, parts)

    def intersection(self) -> Region:
        """Return operands separated by blanks."""
        parts = [self.operand()]
        while self.word not in ("", ":", ")"):
            parts.append(self.operand())
        return join_regions(IntersectionNode, parts)

    def operand(self) -> Region:
        """Return a surface's side, a complement or a parenthesis."""
        word = self.word
        self.at += 1
        if word == "#":
            # Complements are pushed down to the surfaces at once, so that regions hold half-spaces, unions and
            # intersections only
            return negate_region(self.complement_operand())
        if word == "(":
            return self.parenthesis()
        # "3" and "+3" are the positive side
        match = _HALF.fullmatch(word)
        if match is None:
            raise ValueError(
                f"region: {shorten(word, 20)!r} is no surface, '#' or '('" if word else "region: ends early"
            )
        # `side` is the negative side, a region of one or more half-spaces; the positive side is its complement.
        side = self.regions.side(int(match[2]), None if match[3] is None else int(match[3]))
        side = side if match[1] == "-" else negate_region(side)
        self._count_region(side)
        return side

    def complement_operand(self) -> Region:
        """Return the region after '#'; the caller takes its complement."""
        word = self.word
        # "##5" is cell 5 itself
        if word in ("(", "#"):
            return self.operand()
        self.at += 1
        region = self.regions.cell(parse_integer("the cell after '#'", word))
        self._count_region(region)
        return region

    def parenthesis(self) -> Region:
        """Return the region up to ')', after '('."""
        # The parser is recursive, and files are written by strangers
        if self.inside >= MAX_PARENTHESES:
            raise ValueError(f"region: parentheses nest deeper than {MAX_PARENTHESES} levels")
        self.inside += 1
        region = self.union()
        if self.word != ")":
            raise ValueError("region: a ')' is missing")
        self.at += 1
        self.inside -= 1
        return region

    def _count_region(self, region: Region) -> None:
        """Add the half-spaces of a region. Raise ValueError if there are too many.

        Surfaces may have several facets and complements repeat whole cells, so words alone do not bound the size.
        """
        self.count += count_half_spaces(region)
        if self.count > min(LONGEST_REGION, self.regions.budget):
            raise ValueError(
                f"region: has too many half-spaces: at most {LONGEST_REGION:,} stand in one region, "
                f"and {MAX_HALF_SPACES:,} in those of a file together"
            )


def negate_region(region: Region) -> Region:
    """Return the complement, pushed down to the half-spaces (De Morgan)."""
    if isinstance(region, HalfSpaceNode):
        return HalfSpaceNode(region.surface, not region.positive)
    kind = UnionNode if isinstance(region, IntersectionNode) else IntersectionNode
    return kind(tuple(map(negate_region, region.parts)))


def renumber_region(region: Region, number: Callable[[int], int]) -> Region:
    """Return the region with the number of each surface replaced."""
    if isinstance(region, HalfSpaceNode):
        return HalfSpaceNode(number(region.surface), region.positive)
    return type(region)(tuple(renumber_region(part, number) for part in region.parts))


def count_half_spaces(region: Region) -> int:
    """Return the number of half-spaces of a region."""
    return 1 if isinstance(region, HalfSpaceNode) else sum(map(count_half_spaces, region.parts))


def region_depth(region: Region) -> int:
    """Return the number of levels of nested unions and intersections."""
    return 0 if isinstance(region, HalfSpaceNode) else 1 + max(map(region_depth, region.parts))


# Order of cells: each after the cells that its region refers to by '#n'


def sort_cells(regions: Mapping[int, list[str]]) -> tuple[list[int], list[int]]:
    """Return cells in an order without forward references, and the cells left over, which refer to themselves.

    `regions` holds the words of each cell's region.
    """
    needs = {number: _complements(words) & regions.keys() for number, words in regions.items()}
    order = topological_order(needs)
    sorted_cells = set(order)
    return order, [number for number in regions if number not in sorted_cells]


def _complements(words: list[str]) -> set[int]:
    """Return the numbers of cells after '#'."""
    pairs = pairwise(words)
    return {int(number) for word, number in pairs if word == "#" and number.isdecimal() and len(number) < 16}
