"""Bodies of a scene file that differ in their numbers and words alone: one of them is parsed, the others are matched.

A long file has thousands of bodies written alike. The text of one, from its dash to the next, is parsed by itself; the
values in it that are plain numbers or plain words become places of a regular expression, all else must be as it is.
What the expression matches from its dash to the next is an item with the same tree, but for the words in these places:

- A place takes what a parser reads as one word whatever the word is: of letters that end none, and parted by the same
  letters before and behind. What else decides of a parser's steps (indentation, brackets, quotes) is the same text.
- No anchor is in it, so nothing outside depends on it; and no alias, tag or block of text, which are no plain words.
- A parser comes to a dash of one list in one state, whatever items were before. So these items are cut out, and what
  is left is parsed; there the dash behind each cut must be that of an item of `bodies`, or all of this is not done.

Where anything is otherwise, or is a mistake, the whole text is parsed, as it would be without this.
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
"""Bodies of a file in which it is worth to look for such that are alike."""
_SEEN = 3
"""Bodies of one outline after which one is taken for a pattern."""
_MOST_PATTERNS, _MOST_OUTLINES, _LONGEST = 16, 10_000, 4_000
"""Patterns of a file, outlines that are remembered, letters of a pattern."""
_STEP = 2_000
"""Bodies from one report of progress to the next."""

_HEAD = re.compile(r"bodies:[ ]*+\r?\n(?:[ ]*+(?:#[^\n]*+)?\r?\n)*+(?=([ ]*+)- )")
"""The key of the bodies, up to the line of the first."""
_SECTION = re.compile(r"\n(?=[^ \-#\r\n\t])")
"""The end of a line before another section."""
_OUTLINE = re.compile(r"[-+.0-9eE]+|: +[^][{},\n]*")
"""What is left out of an item to see roughly how it is built."""
_LETTERS = r"[A-Za-z0-9_./()=+-]"
_WORD = rf"[A-Za-z_](?:{_LETTERS}| ++(?={_LETTERS}))*+"
_BETWEEN = {"'": "[ -&(-~]*+", '"': r"[ !#-\[\]-~]*+"}
"""What may stand between quotes of either kind without meaning anything but itself."""


class PatternItem(NamedTuple):
    """An item of a pattern: the words in its places, and its line."""

    pattern: TextPattern
    words: tuple[str, ...]
    line: int

    @property
    def column(self) -> int:
        """Where it begins, as others of its pattern do."""
        return self.pattern.item.column

    def read(self) -> Node:
        """Its tree, until the pattern is asked for another; lines and columns stand in what `written` gives."""
        return self.pattern.filled(self.words, self.line)

    def written(self) -> Node:
        """Its tree as a parser makes it."""
        return self.pattern.copied(self.pattern.item, self.words, self.line)


DocumentItem: TypeAlias = Node | PatternItem


@dataclass
class PatternDocument(YamlDocument):
    """A document of which some bodies are not in the tree."""

    bodies: list[DocumentItem] | None = None
    """All of them in their order; None where they are all in the tree."""


@dataclass
class _PatternSlot:
    """Where the items of a pattern may have words of their own."""

    node: ScalarNode
    begin: int
    """In the text of the pattern, quotes included."""
    length: int
    column: int


class TextPattern:
    """An item that was parsed, and the places where others have words of their own."""

    def __init__(self, item: MappingNode, text: str, indent: str, places: list[_PatternSlot], size: int) -> None:
        self.item, self.places, self.size = item, places, size
        self.rows = text.count("\n")
        self.number_of = {id(place.node): k for k, place in enumerate(places)}
        self.row_of = [place.node.line - 1 for place in places]
        self.is_number = [place.node.plain and _is_decimal(place.node.text) for place in places]
        parts, end = [], 0
        for place in places:
            opening = "" if place.node.plain else text[place.begin]
            taken = _BETWEEN[opening] if opening else DECIMAL if _is_decimal(place.node.text) else _WORD
            parts += [re.escape(text[end : place.begin] + opening), f"((?>{taken}))", re.escape(opening)]
            end = place.begin + place.length
        self.match = re.compile("".join(parts) + re.escape(text[end:]) + f"(?={indent}- )").match

    def filled(self, words: tuple[str, ...], line: int) -> Node:
        """The pattern's own nodes, with other words and, for these, their lines."""
        for place, row, word in zip(self.places, self.row_of, words, strict=True):
            node = place.node
            node.text, node.line = word, line + row
        return self.item

    def copied(self, node: Node, words: tuple[str, ...], line: int) -> Node:
        """New nodes with other words, and where these would stand. No deeper than `_DEEPEST`."""
        at = node.line if id(node) not in self.number_of else self.row_of[self.number_of[id(node)]] + 1
        column = node.column + self._shift(at, node.column, words)
        at += line - 1
        if type(node) is ScalarNode:
            k = self.number_of.get(id(node))
            return ScalarNode(at, column, node.text if k is None else words[k], node.plain)
        if type(node) is SequenceNode:
            return SequenceNode(at, column, [self.copied(item, words, line) for item in node.items], node.size)
        assert isinstance(node, MappingNode)
        entries = {name: self.copied(value, words, line) for name, value in node.entries.items()}
        heads = [self.copied(key, words, line) for key in node.heads]
        return MappingNode(at, column, entries, heads, node.size)  # type: ignore[arg-type]

    def _shift(self, row: int, column: int, words: tuple[str, ...]) -> int:
        """By how much words before a column of a row are longer than those of the pattern."""
        shift = 0
        for place, at, word in zip(self.places, self.row_of, words, strict=True):
            if at + 1 == row and place.column < column:
                shift += len(word) + (0 if place.node.plain else 2) - place.length
        return shift


def parse_patterned_document(text: str, progress: Callable[[int], Any] | None = None) -> PatternDocument:
    """What `yaml_parser.document` gives, and raises, without the trees of bodies that are alike."""
    found = _find_patterns(text, progress)
    return found or PatternDocument(**vars(yaml_parser.parse_document(text, progress)))


def _find_patterns(text: str, progress: Callable[[int], Any] | None) -> PatternDocument | None:
    """None where the whole text is to be parsed."""
    cut = _TextCut(text)
    if not cut.is_worth_it:
        return None
    cut.go_through(progress)
    if not cut.alike:
        return None
    removed = len(text) - sum(map(len, cut.left))
    told = progress and (lambda done: progress(done + removed))
    try:
        found = yaml_parser.parse_document("".join(cut.left), told, cut.line_numbers())
    except YamlError:
        return None
    bodies = cut.put_back(found)
    return None if bodies is None else PatternDocument(found.root, found.problems, found.distinct + cut.size, bodies)


class _TextCut:
    """A text without those of its bodies that are alike."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.left: list[str] = []
        """What is to be parsed, piece by piece."""
        self.first_lines: list[tuple[int, int]] = []
        """For each piece its first line, and how many lines there are."""
        self.items: list[PatternItem | int] = []
        """For each body, in order: one that is cut out, or the line of one that is left."""
        self.alike = self.size = 0
        """How many are cut out, and how many values they have."""
        self.patterns = _PatternTable()
        key = 0 if text.startswith("bodies:") else text.find("\nbodies:") + 1
        head = _HEAD.match(text, key)
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
        """All bodies. The last is left in any case: nothing behind it says where it ends."""
        text, indent, dash = self.text, self.indent, f"\n{self.indent}- "
        patterns = self.patterns
        begin = kept = self.begin
        line = kept_line = self.line
        self._leave(0, begin, 1)
        while True:
            if progress is not None and len(self.items) % _STEP == 0:
                progress(begin)
            pattern, match = patterns.of(text, begin)
            if pattern is not None and match is not None:
                if kept < begin:
                    self._leave(kept, begin, kept_line)
                self.items.append(PatternItem(pattern, match.groups(), line))
                self.alike, self.size = self.alike + 1, self.size + pattern.size
                line += pattern.rows
                begin = kept = match.end()
                kept_line = line
                continue
            self.items.append(line)
            end = text.find(dash, begin, self.end)
            if end < 0:
                break
            patterns.learn(text[begin : end + 1], indent)
            line += text.count("\n", begin, end + 1)
            begin = end + 1
        self._leave(kept, len(text), kept_line)

    def _leave(self, begin: int, end: int, line: int) -> None:
        """A piece of text that is to be parsed."""
        piece = self.text[begin:end]
        self.left.append(piece)
        self.first_lines.append((line, piece.count("\n")))

    def line_numbers(self) -> list[int]:
        """Those that the lines of what is left have in the whole."""
        numbers = [k for first, count in self.first_lines for k in range(first, first + count)]
        last = sum(self.first_lines[-1])
        return [*numbers, last, last + 1]

    def put_back(self, found: YamlDocument) -> list[DocumentItem] | None:
        """All bodies; None where those that are left are not the items of `bodies`, so that what was cut out is none.

        The first and the last are left, and the one behind each cut. No node of a list begins in the line of its dash
        but in a place where a parser waits for the list's next item.
        """
        root = found.root
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
    """Those of a text so far."""

    def __init__(self) -> None:
        self.known: list[TextPattern] = []
        self.outlines: dict[str, int] = {}
        """How often an outline was seen."""

    def of(self, text: str, begin: int) -> tuple[TextPattern, re.Match[str]] | tuple[None, None]:
        """The pattern of the item that begins there, the last that was asked for first."""
        for k, pattern in enumerate(self.known):
            match = pattern.match(text, begin)
            if match:
                if k:
                    self.known.insert(0, self.known.pop(k))
                return pattern, match
        return None, None

    def learn(self, item: str, indent: str) -> None:
        """Take an item for a pattern where there were others of its outline."""
        if len(self.known) >= _MOST_PATTERNS or len(self.outlines) >= _MOST_OUTLINES or len(item) > _LONGEST:
            return
        outline = _OUTLINE.sub(":", item)
        seen = self.outlines[outline] = self.outlines.get(outline, 0) + 1
        if seen == _SEEN:
            pattern = _pattern(item, indent)
            if pattern is not None:
                self.known.insert(0, pattern)


def _pattern(text: str, indent: str) -> TextPattern | None:
    """A pattern of an item, from its dash to the next; None for one that is not plain enough."""
    if "&" in text:
        return None
    try:
        found = yaml_parser.parse_document(text)
    except YamlError:
        return None
    root = found.root
    item = root.items[0] if type(root) is SequenceNode and len(root.items) == 1 else None
    if found.problems or type(item) is not MappingNode:
        return None
    rows = [0]
    for row in text.split("\n"):
        rows.append(rows[-1] + len(row) + 1)
    places = []
    for node in _values(item):
        begin = rows[node.line - 1] + node.column - 1
        opening = "" if node.plain else text[begin]
        written = opening + node.text + opening
        if opening not in ("", *_BETWEEN) or not text.startswith(written, begin):
            return None
        if opening or is_text(node) or _is_decimal(node.text):
            places.append(_PatternSlot(node, begin, len(written), node.column))
    places.sort(key=lambda place: place.begin)
    return TextPattern(item, text, indent, places, item.size)


def _values(node: Node) -> Iterator[ScalarNode]:
    """The words below a node that are no keys."""
    pending = [node]
    while pending:
        top = pending.pop()
        if isinstance(top, ScalarNode):
            yield top
        else:
            pending += top.items if isinstance(top, SequenceNode) else top.entries.values()


def _is_decimal(text: str) -> bool:
    return re.fullmatch(DECIMAL, text) is not None
