"""Parser of region expressions: half-spaces `3`, `+3`, `-3`, operators `~`, `&`, `|` and parentheses.

`~` binds tighter than `&`, and `&` tighter than `|`. A blank between two operands is an intersection; it may be left
out if the next operand starts unmistakably. Complements are pushed down to the half-spaces while the text is parsed
(De Morgan), as OpenMC does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from ..scene_file.nodes import shorten

MAX_PARENTHESES = 30
MAX_HALF_SPACES = 2_000_000
"""Most half-spaces in all regions of a file."""
LONGEST_REGION = 200_000
"""Most half-spaces in one region."""
# A half-space, or a parenthesis or operator; numbers of more than 18 digits are no tokens.
_TOKEN = re.compile(r"\s*(?:([-+]?)([0-9]{1,18})(?![0-9])|([()|&~]))")


@dataclass(frozen=True, slots=True)
class HalfSpaceNode:
    """One side of a surface, by the number that the file gives it."""

    surface: int
    positive: bool


@dataclass(frozen=True, slots=True)
class IntersectionNode:
    """The points in every part."""

    parts: tuple[Region, ...]


@dataclass(frozen=True, slots=True)
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
    return _RegionParser(text, most).whole()


def list_half_spaces(region: Region) -> Iterator[HalfSpaceNode]:
    """Yield all half-spaces of a region, from left to right."""
    if isinstance(region, HalfSpaceNode):
        yield region
    else:
        for part in region.parts:
            yield from list_half_spaces(part)


class _RegionParser:
    """A recursive descent parser with one method for each level of precedence; `inside` counts open parentheses.

    `negated` is True within an odd number of complements: unions then become intersections and conversely.
    """

    def __init__(self, text: str, most: int) -> None:
        self.text = text
        self.most = most
        self.count = 0
        self.known: dict[tuple[str, bool], HalfSpaceNode] = {}
        self.at = 0
        self.inside = 0
        self.sign, self.digits, self.symbol = "", "", ""
        self._advance()

    def whole(self) -> Region:
        """Return the region of the whole text."""
        region = self._union(False)
        if self.symbol or self.digits:
            raise self._wrong("a ')' without its '('")
        return region

    def _union(self, negated: bool) -> Region:
        """Return operands joined by `|`."""
        parts = [self._intersection(negated)]
        while self.symbol == "|":
            self._advance()
            parts.append(self._intersection(negated))
        return _join_nodes(IntersectionNode if negated else UnionNode, parts)

    def _intersection(self, negated: bool) -> Region:
        """Return operands joined by `&` or blanks."""
        parts = [self._operand(negated)]
        # An operand without an operator before it belongs to the intersection too.
        while self.symbol in ("&", "(", "~") or self.digits:
            if self.symbol == "&":
                self._advance()
            parts.append(self._operand(negated))
        return _join_nodes(UnionNode if negated else IntersectionNode, parts)

    def _operand(self, negated: bool) -> Region:
        """Return a half-space or a parenthesis, after any number of `~`."""
        while self.symbol == "~":
            negated = not negated
            self._advance()
        if self.digits:
            half = self._half(self.digits, (self.sign != "-") != negated)  # a complement exchanges the sides
            self._advance()
            return half
        if self.symbol != "(":
            raise self._wrong("a surface, '~' or '(' must stand here")
        if self.inside >= MAX_PARENTHESES:
            raise self._wrong(f"parentheses nest deeper than {MAX_PARENTHESES} levels")
        self.inside += 1
        self._advance()
        region = self._union(negated)
        if self.symbol != ")":
            raise self._wrong("a ')' is missing")
        self.inside -= 1
        self._advance()
        return region

    def _half(self, digits: str, positive: bool) -> HalfSpaceNode:
        """Return a half-space; equal half-spaces are one object, which saves memory."""
        self.count += 1
        if self.count > self.most:
            raise ValueError(
                f"region: has too many half-spaces: at most {LONGEST_REGION:,} stand in one region, "
                f"and {MAX_HALF_SPACES:,} in those of a file together"
            )
        known = self.known.get((digits, positive))
        if known is None:
            known = self.known[digits, positive] = HalfSpaceNode(int(digits), positive)
        return known

    def _advance(self) -> None:
        """Read the next token; at the end of the text all of its parts are empty."""
        match = _TOKEN.match(self.text, self.at)
        if match is None:
            self.sign = self.digits = self.symbol = ""
            rest = self.text[self.at :].strip()
            if rest:
                raise self._wrong(f"{shorten(rest, 20)!r} is no half-space, '~', '&', '|' or parenthesis")
            self.at = len(self.text)
            return
        self.sign, self.digits, self.symbol = (match[i] or "" for i in (1, 2, 3))
        self.at = match.end()

    def _wrong(self, what: str) -> ValueError:
        """Return an error with the text before the current position."""
        before = " ".join(self.text[max(self.at - 1000, 0) : self.at].split())
        place = f"after '{before if len(before) <= 40 else '...' + before[-37:]}'" if before else "at the beginning"
        return ValueError(f"region: {what} ({place})")


def _join_nodes(kind: type[IntersectionNode] | type[UnionNode], parts: list[Region]) -> Region:
    """Return one node of a kind; parts of the same kind are merged into it."""
    opened: list[Region] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))
