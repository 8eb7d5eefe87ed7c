"""Text of a scene file -> a tree of nodes that know their line and column.

libyaml finds the structure (its events), nothing else: no tag is obeyed, no object is made. Depth,
and the number of values that aliases expand to, are limited; the tree is built without recursion.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml  # type: ignore[import-untyped]

from .errors import Problem
from .nodes import Listing, Node, Scalar, Table, shortened
from .yaml_text import Unreadable, check_directives, joined_surrogates, line_numbers, place

__all__ = ["MAX_DEPTH", "MAX_EXPANDED", "MAX_NODES", "Document", "Unreadable", "document", "parse"]

MAX_DEPTH = 250
MAX_NODES, MAX_EXPANDED = 4_000_000, 1_000_000
"""Values of a file, with aliases written out, and how many of them these may add."""
_STEP = 10_000
"""Events from one report of progress to the next."""


@dataclass
class Document:
    """The one document of a text: None if there is none, and its repeated keys."""

    root: Node | None = None
    problems: list[Problem] = field(default_factory=list)
    distinct: int = 0
    """Values that stand in it, keys among them: an alias is none."""


_COLON = re.compile(r"\w:[\[{]?$")
"""The end of what stands before a mistake: a colon with nothing behind it."""


def parse(text: str) -> tuple[Node | None, list[Problem]]:
    """The root of the one document of `text`, None if there is none, and its repeated keys."""
    found = document(text)
    return found.root, found.problems


def document(text: str, progress: Callable[[int], Any] | None = None, lines: Sequence[int] | None = None) -> Document:
    """The one document of `text`; progress(characters) is called now and then.

    lines: the numbers of its lines, where they are not 1, 2, 3 and so on.
    Raises `Unreadable` for what is not YAML and for what passes the limits.
    """
    check_directives(text)
    try:
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)(joined_surrogates(text))
        try:
            return _Tree(lines or line_numbers(text)).built(loader.get_event, progress)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (0, 0)
        reason = " ".join(part for part in (error.context, error.problem) if part)
        hint = " (indent with spaces, not tabs)" if mark and text[mark.index : mark.index + 1] == "\t" else ""
        if not hint and mark and _COLON.search(text[: mark.index + 1]):
            hint = " (a blank follows a colon: {radius: 1}, and {Sphere: {radius: 1}})"
        raise Unreadable(line, column, f"not YAML: {reason or 'cannot be read'}{hint}") from None
    except yaml.reader.ReaderError as error:
        line, column = place(text, error.position)
        raise Unreadable(line, column, f"not YAML: {error.reason} (character U+{_code(error.character):04X})") from None
    except yaml.YAMLError as error:
        raise Unreadable(0, 0, f"not YAML: {str(error)[:200]}") from None


class _Tree:
    """Nodes from events, with a stack of its own, so that depth costs no recursion."""

    def __init__(self, lines: Sequence[int]) -> None:
        self.lines = lines
        self.made = Document()
        self.stack: list[tuple[Listing | Table, str | None]] = []  # the open collections, and their anchors
        self.pending: list[Scalar | None] = []  # the key that waits for its value, per open collection
        self.open_anchors: set[str] = set()
        self.anchors: dict[str, Node] = {}
        self.twice: dict[int, dict[str, Scalar]] = {}  # the keys of open collections in which one is repeated
        self.words: dict[str, str] = {}  # one text for all keys that are equal
        self.count = self.documents = 0

    def built(self, next_event: Callable[[], Any], progress: Callable[[int], Any] | None) -> Document:
        """The document of all events. A scalar, as most of millions are, is made here."""
        made, lines, events = self.made, self.lines, 0
        scalar, alias, ended = yaml.ScalarEvent, yaml.AliasEvent, yaml.StreamEndEvent
        starts, ends = (yaml.MappingStartEvent, yaml.SequenceStartEvent), (yaml.MappingEndEvent, yaml.SequenceEndEvent)
        node: Node
        while (kind := type(event := next_event())) is not ended:
            events += 1
            if progress is not None and events % _STEP == 0:
                progress(event.start_mark.index)
            mark = event.start_mark
            line, column = lines[mark.line], mark.column + 1
            if kind is scalar:
                if event.tag is not None:
                    _refuse_tag(event.tag, line, column)
                node = Scalar(line, column, event.value, event.implicit[0])
                if event.anchor:
                    self.anchors[event.anchor] = node
                made.distinct += 1
            elif kind in starts:
                self._open(event, Table(line, column) if kind is starts[0] else Listing(line, column))
                continue
            elif kind in ends:
                node = self._closed()
                line, column = node.line, node.column
            elif kind is alias:
                node = self._aliased(event.anchor, line, column)
            else:
                self._between(kind, line, column)
                continue
            self._put(node, line, column)
        return made

    def _open(self, event: Any, opened: Table | Listing) -> None:
        """A collection begins."""
        if event.tag is not None:
            _refuse_tag(event.tag, opened.line, opened.column)
        if len(self.stack) >= MAX_DEPTH:
            raise Unreadable(opened.line, opened.column, f"nested deeper than {MAX_DEPTH} levels")
        self.stack.append((opened, event.anchor))
        if event.anchor:
            self.open_anchors.add(event.anchor)
        self.pending.append(None)
        self.made.distinct += 1

    def _closed(self) -> Node:
        """The collection that ends."""
        node, anchor = self.stack.pop()
        self.pending.pop()
        if anchor:
            self.open_anchors.discard(anchor)
            self.anchors[anchor] = node
        self.twice.pop(id(node), None)
        self.count -= node.size - 1  # its parts were counted one by one
        return node

    def _aliased(self, anchor: str, line: int, column: int) -> Node:
        """What an alias stands for."""
        if anchor in self.open_anchors:
            raise Unreadable(line, column, f"alias *{shortened(anchor)} lies inside what it stands for")
        if anchor not in self.anchors:
            told = f"alias *{shortened(anchor)} has no anchor &{shortened(anchor)} before it"
            raise Unreadable(line, column, told)
        return self.anchors[anchor]

    def _between(self, kind: Any, line: int, column: int) -> None:
        """A document, or all of it, begins or ends."""
        self.documents += kind is yaml.DocumentStartEvent
        if self.documents > 1:
            raise Unreadable(line, column, "a scene file holds one document, found a second one")

    def _put(self, node: Node, line: int, column: int) -> None:
        """Count a node that is finished, with all that it stands for, and put it where it belongs."""
        self.count += node.size
        if self.count > MAX_NODES or self.count - self.made.distinct > MAX_EXPANDED:
            most = f"{MAX_NODES:,} values" if self.count > MAX_NODES else f"{MAX_EXPANDED:,} values, aliases expanded"
            raise Unreadable(line, column, f"more than {most} (bulk data belongs in a .npy file)")
        if not self.stack:
            self.made.root = node
            return
        parent = self.stack[-1][0]
        parent.size += node.size
        if type(parent) is Listing:
            parent.items.append(node)
        elif (key := self.pending[-1]) is None:
            if type(node) is not Scalar:
                raise Unreadable(line, column, "a key must be a word, found a list or mapping")
            node.text = self.words.setdefault(node.text, node.text)
            self.pending[-1] = node
        else:
            self.pending[-1] = None
            assert isinstance(parent, Table)
            if key.text not in parent.entries:
                parent.entries[key.text] = node
                parent.heads.append(key)
                if id(parent) in self.twice:
                    self.twice[id(parent)][key.text] = key
            else:
                self._told_twice(parent, key)

    def _told_twice(self, parent: Table, key: Scalar) -> None:
        """A key stands twice in a mapping."""
        if id(parent) not in self.twice:
            self.twice[id(parent)] = parent.keys
        first = self.twice[id(parent)][key.text].line
        message = f"key {shortened(key.text)!r} is given twice (first in line {first})"
        self.made.problems.append(Problem(key.line, key.column, "", message))


def _refuse_tag(tag: Any, line: int, column: int) -> None:
    raise Unreadable(line, column, f"tags such as {shortened(str(tag))!r} are not allowed in scene files")


def _code(character: Any) -> int:
    return character if isinstance(character, int) else ord(character)
