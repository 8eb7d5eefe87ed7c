"""Text of a scene file -> a tree of nodes that know their line and column.

libyaml finds the structure (its events), nothing else: no tag is obeyed, no object is made. Depth,
and the number of values that aliases expand to, are limited; the tree is built without recursion.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import yaml  # type: ignore[import-untyped]

from .errors import Problem
from .nodes import Listing, Node, Scalar, Table, shortened

MAX_DEPTH = 250
MAX_NODES, MAX_EXPANDED = 4_000_000, 1_000_000
"""Values of a file, with aliases written out, and how many of them these may add."""
_STEP = 10_000
"""Events from one report of progress to the next."""


class Unreadable(Exception):
    """The text has no tree; `problem` says why and where."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.problem = Problem(line, column, "", message)
        super().__init__(message)


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


def document(text: str, progress: Callable[[int], Any] | None = None) -> Document:
    """The one document of `text`; progress(characters) is called now and then.

    Raises `Unreadable` for what is not YAML and for what passes the limits.
    """
    _check_directives(text)
    try:
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)(_joined_surrogates(text))
        try:
            return _built(loader.get_event, progress)
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


def place(text: str, position: int) -> tuple[int, int]:
    """Line and column, from 1, of a position in a text."""
    return text.count("\n", 0, position) + 1, position - (text.rfind("\n", 0, position) + 1) + 1


def _built(next_event: Callable[[], Any], progress: Callable[[int], Any] | None) -> Document:
    """Nodes from events, with a stack of its own, so that depth costs no recursion.

    One function, as each of its lines is run for each of millions of events.
    """
    made = Document()
    stack: list[tuple[Listing | Table, str | None]] = []  # the open collections, and their anchors
    open_anchors: set[str] = set()
    pending: list[Scalar | None] = []  # the key that waits for its value, per open collection
    anchors: dict[str, Node] = {}
    twice: dict[int, dict[str, Scalar]] = {}  # the keys of open collections in which one is repeated
    words: dict[str, str] = {}  # one text for all keys that are equal, and below one number for all nodes of a line
    count = documents = events = 0
    line = 0
    node: Node
    scalar, alias, ended = yaml.ScalarEvent, yaml.AliasEvent, yaml.StreamEndEvent
    starts, ends = (yaml.MappingStartEvent, yaml.SequenceStartEvent), (yaml.MappingEndEvent, yaml.SequenceEndEvent)
    while (kind := type(event := next_event())) is not ended:
        events += 1
        if progress is not None and events % _STEP == 0:
            progress(event.start_mark.index)
        mark = event.start_mark
        line, column = (line if mark.line + 1 == line else mark.line + 1), mark.column + 1
        if kind is scalar:
            if event.tag is not None:
                _refuse_tag(event, line, column)
            node = Scalar(line, column, event.value, event.implicit[0])
            if event.anchor:
                anchors[event.anchor] = node
            made.distinct += 1
        elif kind in starts:
            if event.tag is not None:
                _refuse_tag(event, line, column)
            if len(stack) >= MAX_DEPTH:
                raise Unreadable(line, column, f"nested deeper than {MAX_DEPTH} levels")
            opened = Table(line, column) if kind is starts[0] else Listing(line, column)
            stack.append((opened, event.anchor))
            if event.anchor:
                open_anchors.add(event.anchor)
            pending.append(None)
            made.distinct += 1
            continue
        elif kind in ends:
            node, anchor = stack.pop()
            pending.pop()
            if anchor:
                open_anchors.discard(anchor)
                anchors[anchor] = node
            twice.pop(id(node), None)
            line, column = node.line, node.column
            count -= node.size - 1  # its parts were counted one by one
        elif kind is alias:
            node = _aliased(event.anchor, anchors, open_anchors, line, column)
        else:
            documents += kind is yaml.DocumentStartEvent
            if documents > 1:
                raise Unreadable(line, column, "a scene file holds one document, found a second one")
            continue
        # The node is finished: count it, with all that it stands for, and put it where it belongs
        count += node.size
        if count > MAX_NODES or count - made.distinct > MAX_EXPANDED:
            most = f"{MAX_NODES:,} values" if count > MAX_NODES else f"{MAX_EXPANDED:,} values, aliases expanded"
            raise Unreadable(line, column, f"more than {most} (bulk data belongs in a .npy file)")
        if not stack:
            made.root = node
            continue
        parent = stack[-1][0]
        parent.size += node.size
        if type(parent) is Listing:
            parent.items.append(node)
        elif (key := pending[-1]) is None:
            if type(node) is not Scalar:
                raise Unreadable(line, column, "a key must be a word, found a list or mapping")
            node.text = words.setdefault(node.text, node.text)
            pending[-1] = node
        else:
            pending[-1] = None
            assert isinstance(parent, Table)
            if key.text not in parent.entries:
                parent.entries[key.text] = node
                parent.heads.append(key)
                if id(parent) in twice:
                    twice[id(parent)][key.text] = key
                continue
            if id(parent) not in twice:
                twice[id(parent)] = parent.keys
            first = twice[id(parent)][key.text].line
            message = f"key {shortened(key.text)!r} is given twice (first in line {first})"
            made.problems.append(Problem(key.line, key.column, "", message))
    return made


def _aliased(anchor: str, anchors: dict[str, Node], open_anchors: set[str], line: int, column: int) -> Node:
    """What an alias stands for."""
    if anchor in open_anchors:
        raise Unreadable(line, column, f"alias *{shortened(anchor)} lies inside what it stands for")
    if anchor not in anchors:
        raise Unreadable(line, column, f"alias *{shortened(anchor)} has no anchor &{shortened(anchor)} before it")
    return anchors[anchor]


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
