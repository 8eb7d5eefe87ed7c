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
    HalfSpaceNode,
    Region,
    RegionParser,
    count_half_spaces,
    negate_region,
    region_depth,
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
        parser = _McnpRegion(self, words)
        region = parser.whole()
        self.budget -= parser.count
        # Later stages walk regions by recursion
        if region_depth(region) > MAX_REGION_DEPTH:
            raise ValueError(f"region: nests deeper than {MAX_REGION_DEPTH} levels, with the cells that it refers to")
        return region


class _McnpRegion(RegionParser):
    """The parser of the words of a cell card."""

    union_sign, intersection_sign, complement_sign = ":", "", "#"

    def __init__(self, regions: RegionReader, words: list[str]) -> None:
        self.regions, self.words = regions, iter(words)
        super().__init__(min(LONGEST_REGION, regions.budget))

    def advance(self) -> None:
        self.word = next(self.words, "")

    def leaf(self, negated: bool, is_complement: bool) -> Region:
        if is_complement:
            region = self.regions.cell(parse_integer("the cell after '#'", self.word))
        else:
            match = _HALF.fullmatch(self.word)
            if match is None:
                raise self.wrong(f"{shorten(self.word, 20)!r} is no surface, '#' or '('" if self.word else "ends early")
            region = self.regions.side(int(match[2]), None if match[3] is None else int(match[3]))
            # "3" and "+3" are the positive side, the complement of the negative one
            negated = negated != (match[1] != "-")
        # Surfaces may have several facets and complements repeat whole cells, so words alone do not bound the size
        self.charge(count_half_spaces(region))
        self.advance()
        return negate_region(region) if negated else region

    def wrong(self, what: str) -> ValueError:
        return ValueError(f"region: {what}")


def renumber_region(region: Region, number: Callable[[int], int]) -> Region:
    """Return the region with the number of each surface replaced."""
    if isinstance(region, HalfSpaceNode):
        return HalfSpaceNode(number(region.surface), region.positive)
    return type(region)(tuple(renumber_region(part, number) for part in region.parts))


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
