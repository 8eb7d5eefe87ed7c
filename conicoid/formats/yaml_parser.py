"""Text of a scene file -> a tree of nodes that know their line and column.

libyaml finds the structure (its events), nothing else: no tag is obeyed, no object is made. Depth,
and the number of values that aliases expand to, are limited; the tree is built without recursion.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import yaml  # type: ignore[import-untyped]

from .errors import Problem
from .nodes import Listing, Node, Scalar, Table, shortened

MAX_DEPTH = 250
MAX_NODES = 1_000_000


class Unreadable(Exception):
    """The text has no tree; `problem` says why and where."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.problem = Problem(line, column, "", message)
        super().__init__(message)


def parse(text: str) -> tuple[Node | None, list[Problem]]:
    """The one document of `text` (None if there is none) and its repeated keys.

    Raises `Unreadable` for what is not YAML and for what passes the limits.
    """
    _check_directives(text)
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        return _Builder().build(yaml.parse(_joined_surrogates(text), Loader=loader))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (0, 0)
        reason = " ".join(part for part in (error.context, error.problem) if part)
        hint = " (indent with spaces, not tabs)" if mark and text[mark.index : mark.index + 1] == "\t" else ""
        raise Unreadable(line, column, f"not YAML: {reason or 'cannot be read'}{hint}") from None
    except yaml.reader.ReaderError as error:
        line, column = place(text, error.position)
        raise Unreadable(line, column, f"not YAML: {error.reason} (character U+{_code(error.character):04X})") from None
    except yaml.YAMLError as error:
        raise Unreadable(0, 0, f"not YAML: {str(error)[:200]}") from None


def place(text: str, position: int) -> tuple[int, int]:
    """Line and column, from 1, of a position in a text."""
    return text.count("\n", 0, position) + 1, position - (text.rfind("\n", 0, position) + 1) + 1


class _Builder:
    """Builds nodes from events with a stack of its own, so that depth costs no recursion."""

    def __init__(self) -> None:
        self.stack: list[Listing | Table] = []
        self.pending: list[Scalar | None] = []  # the key that waits for its value, per open collection
        self.names: list[str | None] = []  # the anchor of each open collection
        self.anchors: dict[str, Node] = {}
        self.open_anchors: set[str] = set()
        self.problems: list[Problem] = []
        self.root: Node | None = None
        self.count = 0

    def build(self, events: Iterator[Any]) -> tuple[Node | None, list[Problem]]:
        documents = 0
        for event in events:
            line, column = event.start_mark.line + 1, event.start_mark.column + 1
            if isinstance(event, yaml.ScalarEvent):
                _refuse_tag(event, line, column)
                node = Scalar(line, column, event.value, plain=event.implicit[0])
                self._anchor(event.anchor, node)
                self._add(node)
            elif isinstance(event, yaml.CollectionStartEvent):
                _refuse_tag(event, line, column)
                self._open(event, line, column)
            elif isinstance(event, yaml.CollectionEndEvent):
                self._close()
            elif isinstance(event, yaml.AliasEvent):
                self._add(self._alias(event.anchor, line, column), line, column)
            elif isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise Unreadable(line, column, "a scene file holds one document, found a second one")
        return self.root, self.problems

    def _open(self, event: Any, line: int, column: int) -> None:
        if len(self.stack) >= MAX_DEPTH:
            raise Unreadable(line, column, f"nested deeper than {MAX_DEPTH} levels")
        node = Table(line, column) if isinstance(event, yaml.MappingStartEvent) else Listing(line, column)
        if event.anchor:
            self.open_anchors.add(event.anchor)
        self.stack.append(node)
        self.pending.append(None)
        self.names.append(event.anchor)

    def _close(self) -> None:
        node = self.stack.pop()
        self.pending.pop()
        anchor = self.names.pop()
        self.open_anchors.discard(anchor or "")
        self._anchor(anchor, node)
        self.count -= node.size - 1  # its parts were counted one by one
        self._add(node)

    def _alias(self, anchor: str, line: int, column: int) -> Node:
        name = shortened(anchor)
        if anchor in self.open_anchors:
            raise Unreadable(line, column, f"alias *{name} lies inside what it stands for")
        if anchor not in self.anchors:
            raise Unreadable(line, column, f"alias *{name} has no anchor &{name} before it")
        return self.anchors[anchor]

    def _anchor(self, anchor: str | None, node: Node) -> None:
        if anchor:
            self.anchors[anchor] = node

    def _add(self, node: Node, line: int = 0, column: int = 0) -> None:
        """Put a finished node where it belongs and count it, with all that it stands for."""
        self.count += node.size
        if self.count > MAX_NODES:
            place_ = (line or node.line, column or node.column)
            raise Unreadable(
                *place_, f"more than {MAX_NODES:,} values, aliases expanded (bulk data belongs in a .npy file)"
            )
        if not self.stack:
            self.root = node
            return
        parent = self.stack[-1]
        parent.size += node.size
        if isinstance(parent, Listing):
            parent.items.append(node)
        elif (key := self.pending[-1]) is None:
            if not isinstance(node, Scalar):
                raise Unreadable(
                    line or node.line, column or node.column, "a key must be a word, found a list or mapping"
                )
            self.pending[-1] = node
        else:
            self.pending[-1] = None
            self._enter(parent, key, node)

    def _enter(self, parent: Table, key: Scalar, node: Node) -> None:
        if key.text in parent.entries:
            first = parent.keys[key.text].line
            message = f"key {shortened(key.text)!r} is given twice (first in line {first})"
            self.problems.append(Problem(key.line, key.column, "", message))
            return
        parent.entries[key.text] = node
        parent.keys[key.text] = key


def _refuse_tag(event: Any, line: int, column: int) -> None:
    if event.tag is not None:
        raise Unreadable(line, column, f"tags such as {shortened(str(event.tag))!r} are not allowed in scene files")


def _check_directives(text: str) -> None:
    """Only a %YAML line may stand before the document (libyaml is slow on many %TAG lines)."""
    found = re.search(r"^%(?!YAML 1\.).*", text, re.MULTILINE)
    if found and not re.search(r"^[ \t]*[^\s#%]", text[: found.start()], re.MULTILINE):
        message = f"directive {shortened(found.group().strip())!r} is not allowed in scene files"
        raise Unreadable(*place(text, found.start()), message)


def _joined_surrogates(text: str) -> str:
    """JSON writes a character beyond U+FFFF as two escapes; YAML as one character."""
    if not re.search(r"\\u[dD][89abAB]", text):
        return text

    def joined(match: re.Match[str]) -> str:
        if match.group(1) is None:
            return match.group()
        high, low = int(match.group(1), 16), int(match.group(2), 16)
        return chr(0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00))

    return re.sub(
        r"\\(?:u([dD][89abAB]{hex})\\u([dD][c-fC-F]{hex})|.)".replace("{hex}", "[0-9a-fA-F]{2}"), joined, text
    )


def _code(character: Any) -> int:
    return character if isinstance(character, int) else ord(character)
