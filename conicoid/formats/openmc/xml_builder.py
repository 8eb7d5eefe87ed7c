"""The parser of XML that nobody vouches for: elements are made of what expat reports, without a layer between."""

from __future__ import annotations

from typing import Any

from defusedxml.expatreader import DefusedExpatParser

from .xml_tree import Element

MAX_DEPTH = 32
MAX_ELEMENTS = 1_000_000


class TooMuch(Exception):
    """A limit is passed."""


class Builder(DefusedExpatParser):  # type: ignore[misc]
    """Makes a tree."""

    root: Element

    def __init__(self, **given: Any) -> None:
        self._parser: Any = None
        super().__init__(**given)
        self.open: list[Element] = []
        self.count = 0

    @property
    def place(self) -> tuple[int, int]:
        """Line and column of what is being read, from 1."""
        return self.getLineNumber() or 0, (self.getColumnNumber() or 0) + 1

    def reset(self) -> None:
        """Have everything reported here, and not to a handler of SAX."""
        super().reset()
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        at, open_ones = self._parser, self.open
        element = Element(name, at.CurrentLineNumber, at.CurrentColumnNumber + 1, attributes)
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise TooMuch(f"has more than {MAX_ELEMENTS:,} elements")
        if len(open_ones) >= MAX_DEPTH:
            raise TooMuch(f"nests its elements deeper than {MAX_DEPTH} levels")
        if open_ones:
            open_ones[-1].children.append(element)
        else:
            self.root = element
        open_ones.append(element)

    def _end(self, _: str) -> None:
        self.open.pop()

    def _text(self, data: str) -> None:
        self.open[-1].pieces.append(data)
