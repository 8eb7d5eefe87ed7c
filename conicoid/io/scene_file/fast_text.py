"""Fast parsing of bodies of a scene file that differ only in numbers and words: one is parsed, the others are matched.

A long file has thousands of bodies that are written alike. The text of one body, from its dash to the next, is parsed
by itself. Its plain numbers and plain words become slots of a regular expression; all other text must be the same. Any
text that the expression matches, from dash to dash, is an item with the same tree, except for the words in the slots:

- A slot takes only text that a parser reads as one word in any case: it consists of characters that end no word, and
  the same characters surround it. All else that decides a parser's steps (indentation, brackets, quotes) is equal.
- The item has no anchor, so nothing outside depends on it; and no alias, tag or block text, which are no plain words.
- A parser reaches each dash of a list in the same state, whatever items came before. So the matched items are cut out,
  and the remaining text is parsed. There the dash after each cut must begin an item of `bodies`.

If any of this fails, or the text has a mistake, the whole text is parsed as if this module did not exist.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from . import yaml_parser
from .nodes import DECIMAL, MappingNode, Node, ScalarNode, SequenceNode, is_text
from .yaml_parser import YamlDocument, YamlError, join_surrogates

_LEAST = 20
"""Least bodies of a file in which patterns are worth a search."""
_SEEN = 3
"""Number of bodies of one outline after which one becomes a pattern."""
_MOST_PATTERNS, _MOST_OUTLINES, _LONGEST = 16, 10_000, 4_000
"""Most patterns of a file, most outlines that are remembered, most characters of a pattern."""
_STEP = 2_000
"""Bodies between two reports of progress."""

_HEAD = re.compile(r"bodies:[ ]*+\r?\n(?:[ ]*+(?:#[^\n]*+)?\r?\n)*+(?=([ ]*+)- )")
"""The key of the bodies, up to the line of the first body, whose indentation is the group."""
_SECTION = re.compile(r"\n(?=[^ \-#\r\n\t])")
"""The end of a line before another section."""
_OUTLINE = re.compile(r"[-+.0-9eE]+|: +[^][{},\n]*")
"""Parts of an item that its outline leaves out: numbers, and values on the line of their key."""
_LETTERS = r"[A-Za-z0-9_./()=+-]"
_WORD = rf"[A-Za-z_](?:{_LETTERS}| ++(?={_LETTERS}))*+"
_BETWEEN = {"'": "[ -&(-~]*+", '"': r"[ !#-\[\]-~]*+"}
"""Characters between quotes of either kind that stand for themselves: printable ASCII without quote or escape."""


class PatternItem(NamedTuple):
    """An item that matches a pattern: the words in its slots, and its line."""

    pattern: TextPattern
    words: tuple[str, ...]
    line: int

    @property
    def column(self) -> int:
        """The column where it begins, which all items of a pattern share."""
        return self.pattern.item.column

    def read(self) -> Node:
        """Return its tree, which is valid until the next `read` of the pattern.

        Lines and columns are not exact; `written` returns exact ones.
        """
        return self.pattern.fill(self.words, self.line)

    def written(self) -> Node:
        """Return its tree as a parser makes it."""
        return self.pattern.copy(self.pattern.item, self.words, self.line)


DocumentItem: TypeAlias = Node | PatternItem


@dataclass
class PatternDocument(YamlDocument):
    """A document whose tree may lack some bodies."""

    bodies: list[DocumentItem] | None = None
    """All bodies in their order; None if all of them are in the tree."""


@dataclass
class _PatternSlot:
    """A place where the items of a pattern have words of their own."""

    node: ScalarNode
    begin: int
    """The position in the text of the pattern, quotes included."""
    length: int
    column: int


class TextPattern:
    """A parsed item, and the slots where other items have words of their own."""

    def __init__(self, item: MappingNode, text: str, indent: str, places: list[_PatternSlot], size: int) -> None:
        self.item, self.places, self.size = item, places, size
        self.rows = text.count("\n")
        self.number_of = {id(place.node): k for k, place in enumerate(places)}
        self.row_of = [place.node.line - 1 for place in places]
        self.is_number = [place.node.plain and _is_decimal(place.node.text) for place in places]
        parts, end = [], 0
        for place in places:
            opening = "" if place.node.plain else text[place.begin]
            allowed = _BETWEEN[opening] if opening else DECIMAL if _is_decimal(place.node.text) else _WORD
            # Atomic groups: a word is matched as a whole, and a mismatch after it costs no backtracking.
            parts += [re.escape(text[end : place.begin] + opening), f"((?>{allowed}))", re.escape(opening)]
            end = place.begin + place.length
        self.match = re.compile("".join(parts) + re.escape(text[end:]) + f"(?={indent}- )").match

    def fill(self, words: tuple[str, ...], line: int) -> Node:
        """Return the pattern's own nodes with other words; only the lines of the words are set."""
        for place, row, word in zip(self.places, self.row_of, words, strict=True):
            node = place.node
            node.text, node.line = word, line + row
        return self.item

    def copy(self, node: Node, words: tuple[str, ...], line: int) -> Node:
        """Return new nodes with other words, with their lines and columns in the file.

        The recursion is as deep as the item, at most `yaml_parser.MAX_DEPTH` levels.
        """
        at = node.line if id(node) not in self.number_of else self.row_of[self.number_of[id(node)]] + 1
        column = node.column + self._shift(at, node.column, words)
        at += line - 1
        if type(node) is ScalarNode:
            k = self.number_of.get(id(node))
            return ScalarNode(at, column, node.text if k is None else words[k], node.plain)
        if type(node) is SequenceNode:
            return SequenceNode(at, column, [self.copy(item, words, line) for item in node.items], node.size)
        assert isinstance(node, MappingNode)
        entries = {name: self.copy(value, words, line) for name, value in node.entries.items()}
        heads = [self.copy(key, words, line) for key in node.heads]
        return MappingNode(at, column, entries, heads, node.size)  # type: ignore[arg-type]

    def _shift(self, row: int, column: int, words: tuple[str, ...]) -> int:
        """Return how many characters longer the words before a column of a row are than those of the pattern."""
        shift = 0
        for place, at, word in zip(self.places, self.row_of, words, strict=True):
            if at + 1 == row and place.column < column:
                shift += len(word) + (0 if place.node.plain else 2) - place.length
        return shift


def parse_patterned_document(text: str, progress: Callable[[int], Any] | None = None) -> PatternDocument:
    """Return the document of `yaml_parser.parse_document`, with bodies that are alike outside of the tree.

    Raise the same errors.
    """
    document = _find_patterns(text, progress)
    return document or PatternDocument(**vars(yaml_parser.parse_document(text, progress)))


def _find_patterns(text: str, progress: Callable[[int], Any] | None) -> PatternDocument | None:
    """Return a document with bodies outside of its tree; None if the whole text is to be parsed."""
    cut = _TextCut(text)
    if not cut.is_worth_it:
        return None
    cut.go_through(progress)
    if not cut.alike:
        return None
    removed = len(text) - sum(map(len, cut.left))
    report = progress and (lambda done: progress(done + removed))
    try:
        rest = yaml_parser.parse_document("".join(cut.left), report, cut.line_numbers())
    except YamlError:
        return None
    bodies = cut.put_back(rest)
    return None if bodies is None else PatternDocument(rest.root, rest.problems, rest.distinct + cut.size, bodies)


class _TextCut:
    """A text, from which bodies that match patterns are cut."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.left: list[str] = []
        """The pieces of text that remain to be parsed."""
        self.first_lines: list[tuple[int, int]] = []
        """For each piece its first line and its number of lines."""
        self.items: list[PatternItem | int] = []
        """For each body, in order: the item if it is cut out, or the line if it remains."""
        self.alike = self.size = 0
        """The number of bodies that are cut out, and of their values."""
        self.patterns = _PatternTable()
        key = 0 if text.startswith("bodies:") else text.find("\nbodies:") + 1
        head = _HEAD.match(text, key)
        # Lines are counted by \n here, and a parser must count the same lines.
        breaks = text.count("\r") == text.count("\r\n") and not (
            not text.isascii() and any(each in text for each in "\x85\u2028\u2029")
        )
        self.is_worth_it = False
        if head and breaks and join_surrogates(text) is text:
            self.begin, self.indent = head.end(), head.group(1)
            self.line = text.count("\n", 0, self.begin) + 1
            section = _SECTION.search(text, self.begin)
            self.end = section.end() if section else len(text)
            self.is_worth_it = text.count(f"\n{self.indent}- ", self.begin, self.end) >= _LEAST

    def go_through(self, progress: Callable[[int], Any] | None) -> None:
        """Match all bodies. The last one remains in any case: no dash after it marks its end."""
        text, indent, dash = self.text, self.indent, f"\n{self.indent}- "
        patterns = self.patterns
        begin = rest = self.begin
        line = rest_line = self.line
        self._leave(0, begin, 1)
        while True:
            if progress is not None and len(self.items) % _STEP == 0:
                progress(begin)
            pattern, match = patterns.of(text, begin)
            if pattern is not None and match is not None:
                if rest < begin:
                    self._leave(rest, begin, rest_line)
                self.items.append(PatternItem(pattern, match.groups(), line))
                self.alike, self.size = self.alike + 1, self.size + pattern.size
                line += pattern.rows
                begin = rest = match.end()
                rest_line = line
                continue
            self.items.append(line)
            end = text.find(dash, begin, self.end)
            if end < 0:
                break
            patterns.learn(text[begin : end + 1], indent)
            line += text.count("\n", begin, end + 1)
            begin = end + 1
        self._leave(rest, len(text), rest_line)

    def _leave(self, begin: int, end: int, line: int) -> None:
        """Add a piece of text that remains to be parsed."""
        piece = self.text[begin:end]
        self.left.append(piece)
        self.first_lines.append((line, piece.count("\n")))

    def line_numbers(self) -> list[int]:
        """Return the line numbers of the remaining text in the whole text."""
        numbers = [k for first, count in self.first_lines for k in range(first, first + count)]
        last = sum(self.first_lines[-1])
        return [*numbers, last, last + 1]

    def put_back(self, document: YamlDocument) -> list[DocumentItem] | None:
        """Return all bodies; None if the remaining ones are not the items of `bodies`, so that the cuts are not valid.

        The first and the last body remain, and the one after each cut. A node of a list begins in the line of its dash
        only where a parser waits for the next item of the list.
        """
        root = document.root
        bodies = root.entries.get("bodies") if type(root) is MappingNode else None
        if type(root) is not MappingNode or type(bodies) is not SequenceNode:
            return None
        left = iter(bodies.items)
        put: list[DocumentItem] = []
        for item in self.items:
            if type(item) is PatternItem:
                put.append(item)
                continue
            node = next(left, None)
            if node is None or node.line != item:
                return None
            put.append(node)
        is_whole = next(left, None) is None and root.size + self.size <= yaml_parser.MAX_NODES
        return put if is_whole else None


class _PatternTable:
    """The patterns of a text so far, the last used first."""

    def __init__(self) -> None:
        self.known: list[TextPattern] = []
        self.outlines: dict[str, int] = {}
        """How often each outline occurred."""

    def of(self, text: str, begin: int) -> tuple[TextPattern, re.Match[str]] | tuple[None, None]:
        """Return the pattern that the item at a position matches, with the match; the last used one is tried first."""
        for k, pattern in enumerate(self.known):
            match = pattern.match(text, begin)
            if match:
                if k:
                    self.known.insert(0, self.known.pop(k))
                return pattern, match
        return None, None

    def learn(self, item: str, indent: str) -> None:
        """Count the outline of an item, and make the item a pattern if it is the `_SEEN`-th of its outline."""
        if len(self.known) >= _MOST_PATTERNS or len(self.outlines) >= _MOST_OUTLINES or len(item) > _LONGEST:
            return
        outline = _OUTLINE.sub(":", item)
        seen = self.outlines[outline] = self.outlines.get(outline, 0) + 1
        if seen == _SEEN:
            pattern = _pattern(item, indent)
            if pattern is not None:
                self.known.insert(0, pattern)


def _pattern(text: str, indent: str) -> TextPattern | None:
    """Return a pattern of an item, from its dash to the next; None for an item that is not plain enough."""
    if "&" in text:  # perhaps an anchor
        return None
    try:
        document = yaml_parser.parse_document(text)
    except YamlError:
        return None
    root = document.root
    item = root.items[0] if type(root) is SequenceNode and len(root.items) == 1 else None
    if document.problems or type(item) is not MappingNode:
        return None
    rows = [0]  # positions where lines begin
    for row in text.split("\n"):
        rows.append(rows[-1] + len(row) + 1)
    places = []
    for node in _values(item):
        begin = rows[node.line - 1] + node.column - 1
        opening = "" if node.plain else text[begin]
        written = opening + node.text + opening
        # Escapes, tags and blocks differ from the text of their node.
        if opening not in ("", *_BETWEEN) or not text.startswith(written, begin):
            return None
        if opening or is_text(node) or _is_decimal(node.text):
            places.append(_PatternSlot(node, begin, len(written), node.column))
    places.sort(key=lambda place: place.begin)
    return TextPattern(item, text, indent, places, item.size)


def _values(node: Node) -> Iterator[ScalarNode]:
    """Yield the words below a node that are not keys."""
    pending = [node]
    while pending:
        top = pending.pop()
        if isinstance(top, ScalarNode):
            yield top
        else:
            pending += top.items if isinstance(top, SequenceNode) else top.entries.values()


def _is_decimal(text: str) -> bool:
    return re.fullmatch(DECIMAL, text) is not None
