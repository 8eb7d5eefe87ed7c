"""Expressions of regions: half-spaces, intersections and unions, and the parser that OpenMC and MCNP share.

OpenMC's expressions have half-spaces `3`, `+3`, `-3`, operators `~`, `&`, `|` and parentheses. `~` binds tighter than
`&`, and `&` tighter than `|`. A blank between two operands is an intersection; it may be left out if the next operand
starts unmistakably. Complements are pushed down to the half-spaces while the text is parsed (De Morgan), as OpenMC
does.
"""

from __future__ import annotations

import dataclasses
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import TypeAlias

from ..scene_file.nodes import shorten

MAX_PARENTHESES = 30
MAX_HALF_SPACES = 2_000_000
"""Most half-spaces in all regions of a file."""
LONGEST_REGION = 200_000
"""Most half-spaces in one region."""
# A half-space, or a parenthesis or operator; numbers of more than 18 digits are no tokens.
_TOKEN = re.compile(r"\s*([-+]?[0-9]{1,18}(?![0-9])|[()|&~])")


@dataclasses.dataclass(frozen=True, slots=True)
class HalfSpaceNode:
    """One side of a surface, by the number that the file gives it."""

    surface: int
    positive: bool


@dataclasses.dataclass(frozen=True, slots=True)
class IntersectionNode:
    """The points in every part."""

    parts: tuple[Region, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class UnionNode:
    """The points in at least one part."""

    parts: tuple[Region, ...]


Region: TypeAlias = HalfSpaceNode | IntersectionNode | UnionNode


def parse_region(text: str, most: int = MAX_HALF_SPACES) -> Region:
    """Return the region of an expression.

    Parameters
    ----------
    text
        The expression, not blank.
    most
        Most half-spaces.

    Raises
    ------
    ValueError
        The expression is wrong or too long; the message says where.

    """
    return _OpenmcRegion(text, most).whole()


def list_half_spaces(region: Region) -> Iterator[HalfSpaceNode]:
    """Yield all half-spaces of a region, from left to right."""
    if isinstance(region, HalfSpaceNode):
        yield region
    else:
        for part in region.parts:
            yield from list_half_spaces(part)


class RegionParser(ABC):
    """A recursive descent parser with one method for each level of precedence.

    `word` is the current word, empty at the end. Subclasses scan words and read those that stand for regions.
    `negated` is True within an odd number of complements: unions then become intersections and conversely.
    """

    union_sign: str
    intersection_sign: str
    """The sign beside blanks; empty if there is none."""
    complement_sign: str

    def __init__(self, most: int) -> None:
        self.most = most
        self.count = 0
        self.word = ""
        self.depth = 0
        """Open parentheses."""
        self.advance()

    @abstractmethod
    def advance(self) -> None:
        """Read the next word."""

    @abstractmethod
    def leaf(self, negated: bool, is_complement: bool) -> Region:
        """Return the region of the current word, which is no parenthesis, and go on; negated if `negated`.

        `is_complement`: a complement sign stands before the word.
        """

    @abstractmethod
    def wrong(self, what: str) -> ValueError:
        """Return an error at the current place."""

    def whole(self) -> Region:
        """Return the region of all words."""
        region = self._union(False)
        # The parser of unions ends early only at a ')'
        if self.word:
            raise self.wrong("a ')' without its '('")
        return region

    def _union(self, negated: bool) -> Region:
        """Return operands joined by the sign of unions."""
        parts = [self._intersection(negated)]
        while self.word == self.union_sign:
            self.advance()
            parts.append(self._intersection(negated))
        return join_regions(IntersectionNode if negated else UnionNode, parts)

    def _intersection(self, negated: bool) -> Region:
        """Return operands joined by blanks or the sign of intersections."""
        parts = [self._operand(negated)]
        # An operand without an operator before it belongs to the intersection too.
        while self.word not in ("", self.union_sign, ")"):
            if self.word == self.intersection_sign:
                self.advance()
            parts.append(self._operand(negated))
        return join_regions(UnionNode if negated else IntersectionNode, parts)

    def _operand(self, negated: bool) -> Region:
        """Return a leaf or a parenthesis, after any number of complement signs."""
        # Complements are pushed down to the half-spaces at once. In a loop, since a file may stack thousands
        is_complement = self.word == self.complement_sign
        while self.word == self.complement_sign:
            negated = not negated
            self.advance()
        if self.word != "(":
            return self.leaf(negated, is_complement)
        if self.depth >= MAX_PARENTHESES:
            raise self.wrong(f"parentheses nest deeper than {MAX_PARENTHESES} levels")
        self.depth += 1
        self.advance()
        region = self._union(negated)
        if self.word != ")":
            raise self.wrong("a ')' is missing")
        self.depth -= 1
        self.advance()
        return region

    def charge(self, half_spaces: int) -> None:
        """Count half-spaces. Raise ValueError if there are too many."""
        self.count += half_spaces
        if self.count > self.most:
            raise ValueError(
                f"region: has too many half-spaces: at most {LONGEST_REGION:,} stand in one region, "
                f"and {MAX_HALF_SPACES:,} in those of a file together"
            )


class _OpenmcRegion(RegionParser):
    """The parser of OpenMC's expressions."""

    union_sign, intersection_sign, complement_sign = "|", "&", "~"

    def __init__(self, text: str, most: int) -> None:
        self.text = text
        self.at = 0
        self.half_spaces: dict[tuple[str, bool], HalfSpaceNode] = {}
        super().__init__(most)

    def advance(self) -> None:
        match = _TOKEN.match(self.text, self.at)
        if match is not None:
            self.word, self.at = match[1], match.end()
            return
        self.word = ""
        rest = self.text[self.at :].strip()
        if rest:
            raise self.wrong(f"{shorten(rest, 20)!r} is no half-space, '~', '&', '|' or parenthesis")
        self.at = len(self.text)

    def leaf(self, negated: bool, is_complement: bool) -> HalfSpaceNode:
        digits = self.word.lstrip("-+")
        if not digits.isdigit():
            raise self.wrong("a surface, '~' or '(' must stand here")
        self.charge(1)
        # A complement exchanges the sides
        positive = self.word.startswith("-") == negated
        # Equal half-spaces are one object, which saves memory
        half = self.half_spaces.get((digits, positive))
        if half is None:
            half = self.half_spaces[digits, positive] = HalfSpaceNode(int(digits), positive)
        self.advance()
        return half

    def wrong(self, what: str) -> ValueError:
        # The text just before the mistake finds it in a region of several lines
        before = " ".join(self.text[max(self.at - 1000, 0) : self.at].split())
        place = f"after '{before if len(before) <= 40 else '...' + before[-37:]}'" if before else "at the beginning"
        return ValueError(f"region: {what} ({place})")


def join_regions(kind: type[IntersectionNode] | type[UnionNode], parts: list[Region]) -> Region:
    """Return one node of a kind; parts of the same kind are merged into it."""
    opened: list[Region] = []
    for part in parts:
        # Flat nodes keep the depth small in long regions of many parentheses
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))


def negate_region(region: Region, known: dict[int, tuple[Region, Region]] | None = None) -> Region:
    """Return the complement of a region, pushed down to the half-spaces (De Morgan).

    `known` holds complements by the identity of their regions, which it keeps: one region in many places stays one.
    """
    found = None if known is None else known.get(id(region))
    if found is not None:
        return found[1]
    if isinstance(region, HalfSpaceNode):
        result: Region = HalfSpaceNode(region.surface, not region.positive)
    else:
        kind = UnionNode if isinstance(region, IntersectionNode) else IntersectionNode
        result = kind(tuple(negate_region(part, known) for part in region.parts))
    if known is not None:
        known[id(region)], known[id(result)] = (region, result), (result, region)
    return result


def count_half_spaces(region: Region | None) -> int:
    """Return the number of half-spaces of a region; all of space (None) has none."""
    return 0 if region is None else sum(1 for _ in list_half_spaces(region))


def region_depth(region: Region) -> int:
    """Return the number of levels of nested unions and intersections."""
    return 0 if isinstance(region, HalfSpaceNode) else 1 + max(map(region_depth, region.parts))


def renumber_region(region: Region, number: Callable[[int], int]) -> Region:
    """Return the region with the number of each surface replaced."""
    if isinstance(region, HalfSpaceNode):
        return HalfSpaceNode(number(region.surface), region.positive)
    return type(region)(tuple(renumber_region(part, number) for part in region.parts))
