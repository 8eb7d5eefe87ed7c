"""The letters of a scene file before they are parsed: what is refused of them, and where they stand."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from ..._util.file_errors import Problem, SceneFileError, unreadable_error
from ..._util.safe_files import open_regular
from .nodes import MappingNode, Node, ScalarNode, SequenceNode, shorten

_BREAKS = "\n\r\x85\u2028\u2029"
"""What ends a line in YAML."""


class YamlError(Exception):
    """The text has no tree; `problem` says why and where."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.problem = Problem(line, column, "", message)
        super().__init__(message)


def line_and_column(text: str, position: int) -> tuple[int, int]:
    """Line and column, from 1, of a position in a text."""
    return text.count("\n", 0, position) + 1, position - (text.rfind("\n", 0, position) + 1) + 1


def line_numbers(text: str) -> list[int]:
    """A number for each line that a parser may see, and one more."""
    return list(range(1, 3 + sum(text.count(each) for each in _BREAKS)))


def check_directives(text: str) -> None:
    """Only a %YAML line may stand before the document (libyaml is slow on many %TAG lines)."""
    if not text.startswith("%") and "\n%" not in text:
        return
    found = re.search(r"^%(?!YAML 1\.).*", text, re.MULTILINE)
    if found and not re.search(r"^[ \t]*[^\s#%]", text[: found.start()], re.MULTILINE):
        message = f"directive {shorten(found.group().strip())!r} is not allowed in scene files"
        raise YamlError(*line_and_column(text, found.start()), message)


def join_surrogates(text: str) -> str:
    """JSON writes a character beyond U+FFFF as two escapes; YAML as one character."""
    if "\\" not in text or not re.search(r"\\u[dD][89abAB]", text):
        return text

    def joined(match: re.Match[str]) -> str:
        if match.group(1) is None:
            return match.group()
        high, low = int(match.group(1), 16), int(match.group(2), 16)
        return chr(0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00))

    return re.sub(
        r"\\(?:u([dD][89abAB]{hex})\\u([dD][c-fC-F]{hex})|.)".replace("{hex}", "[0-9a-fA-F]{2}"), joined, text
    )


# Text of a scene file -> a tree of nodes that know their line and column.
#
# libyaml finds the structure (its events), nothing else: no tag is obeyed, no object is made. Depth,
# and the number of values that aliases expand to, are limited; the tree is built without recursion.

MAX_DEPTH = 250
MAX_NODES, MAX_EXPANDED = 4_000_000, 1_000_000
"""Values of a file, with aliases written out, and how many of them these may add."""
_EVENT_STEP = 10_000
"""Events from one report of progress to the next."""


@dataclass
class YamlDocument:
    """The one document of a text: None if there is none, and its repeated keys."""

    root: Node | None = None
    problems: list[Problem] = field(default_factory=list)
    distinct: int = 0
    """Values that stand in it, keys among them: an alias is none."""


_COLON = re.compile(r"\w:[\[{]?$")
"""The end of what stands before a mistake: a colon with nothing behind it."""


def parse_yaml(text: str) -> tuple[Node | None, list[Problem]]:
    """The root of the one document of `text`, None if there is none, and its repeated keys."""
    found = parse_document(text)
    return found.root, found.problems


def parse_document(
    text: str, progress: Callable[[int], Any] | None = None, lines: Sequence[int] | None = None
) -> YamlDocument:
    """The one document of `text`; progress(characters) is called now and then.

    lines: the numbers of its lines, where they are not 1, 2, 3 and so on.
    Raises `Unreadable` for what is not YAML and for what passes the limits.
    """
    check_directives(text)
    try:
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)(join_surrogates(text))
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
        raise YamlError(line, column, f"not YAML: {reason or 'cannot be read'}{hint}") from None
    except yaml.reader.ReaderError as error:
        line, column = line_and_column(text, error.position)
        raise YamlError(line, column, f"not YAML: {error.reason} (character U+{_code(error.character):04X})") from None
    except yaml.YAMLError as error:
        raise YamlError(0, 0, f"not YAML: {str(error)[:200]}") from None


class _Tree:
    """Nodes from events, with a stack of its own, so that depth costs no recursion."""

    def __init__(self, lines: Sequence[int]) -> None:
        self.lines = lines
        self.made = YamlDocument()
        self.stack: list[tuple[SequenceNode | MappingNode, str | None]] = []  # the open collections, and their anchors
        self.pending: list[ScalarNode | None] = []  # the key that waits for its value, per open collection
        self.open_anchors: set[str] = set()
        self.anchors: dict[str, Node] = {}
        self.twice: dict[int, dict[str, ScalarNode]] = {}  # the keys of open collections in which one is repeated
        self.words: dict[str, str] = {}  # one text for all keys that are equal
        self.count = self.documents = 0

    def built(self, next_event: Callable[[], Any], progress: Callable[[int], Any] | None) -> YamlDocument:
        """The document of all events. A scalar, as most of millions are, is made here."""
        made, lines, events = self.made, self.lines, 0
        scalar, alias, ended = yaml.ScalarEvent, yaml.AliasEvent, yaml.StreamEndEvent
        starts, ends = (yaml.MappingStartEvent, yaml.SequenceStartEvent), (yaml.MappingEndEvent, yaml.SequenceEndEvent)
        node: Node
        while (kind := type(event := next_event())) is not ended:
            events += 1
            if progress is not None and events % _EVENT_STEP == 0:
                progress(event.start_mark.index)
            mark = event.start_mark
            line, column = lines[mark.line], mark.column + 1
            if kind is scalar:
                if event.tag is not None:
                    _refuse_tag(event.tag, line, column)
                node = ScalarNode(line, column, event.value, event.implicit[0])
                if event.anchor:
                    self.anchors[event.anchor] = node
                made.distinct += 1
            elif kind in starts:
                self._open(event, MappingNode(line, column) if kind is starts[0] else SequenceNode(line, column))
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

    def _open(self, event: Any, opened: MappingNode | SequenceNode) -> None:
        """A collection begins."""
        if event.tag is not None:
            _refuse_tag(event.tag, opened.line, opened.column)
        if len(self.stack) >= MAX_DEPTH:
            raise YamlError(opened.line, opened.column, f"nested deeper than {MAX_DEPTH} levels")
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
            raise YamlError(line, column, f"alias *{shorten(anchor)} lies inside what it stands for")
        if anchor not in self.anchors:
            told = f"alias *{shorten(anchor)} has no anchor &{shorten(anchor)} before it"
            raise YamlError(line, column, told)
        return self.anchors[anchor]

    def _between(self, kind: Any, line: int, column: int) -> None:
        """A document, or all of it, begins or ends."""
        self.documents += kind is yaml.DocumentStartEvent
        if self.documents > 1:
            raise YamlError(line, column, "a scene file holds one document, found a second one")

    def _put(self, node: Node, line: int, column: int) -> None:
        """Count a node that is finished, with all that it stands for, and put it where it belongs."""
        self.count += node.size
        if self.count > MAX_NODES or self.count - self.made.distinct > MAX_EXPANDED:
            most = f"{MAX_NODES:,} values" if self.count > MAX_NODES else f"{MAX_EXPANDED:,} values, aliases expanded"
            raise YamlError(line, column, f"more than {most} (bulk data belongs in a .npy file)")
        if not self.stack:
            self.made.root = node
            return
        parent = self.stack[-1][0]
        parent.size += node.size
        if type(parent) is SequenceNode:
            parent.items.append(node)
        elif (key := self.pending[-1]) is None:
            if type(node) is not ScalarNode:
                raise YamlError(line, column, "a key must be a word, found a list or mapping")
            node.text = self.words.setdefault(node.text, node.text)
            self.pending[-1] = node
        else:
            self.pending[-1] = None
            assert isinstance(parent, MappingNode)
            if key.text not in parent.entries:
                parent.entries[key.text] = node
                parent.heads.append(key)
                if id(parent) in self.twice:
                    self.twice[id(parent)][key.text] = key
            else:
                self._told_twice(parent, key)

    def _told_twice(self, parent: MappingNode, key: ScalarNode) -> None:
        """A key stands twice in a mapping."""
        if id(parent) not in self.twice:
            self.twice[id(parent)] = parent.keys
        first = self.twice[id(parent)][key.text].line
        message = f"key {shorten(key.text)!r} is given twice (first in line {first})"
        self.made.problems.append(Problem(key.line, key.column, "", message))


def _refuse_tag(tag: Any, line: int, column: int) -> None:
    raise YamlError(line, column, f"tags such as {shorten(str(tag))!r} are not allowed in scene files")


def _code(character: Any) -> int:
    return character if isinstance(character, int) else ord(character)


# From a path to the text of a scene file, or one clear reason why there is none.

MAX_SCENE_BYTES = 64 << 20


def read_scene_text(path: str | os.PathLike[str]) -> str:
    """The text of a scene file. Raises SceneFileError for anything that is no text of bearable size."""
    try:
        raw = _read_bytes(Path(path))
        return _decode(raw)
    except OSError as error:
        raise unreadable_error(path, error) from None
    except _TextError as error:
        raise SceneFileError(path, [Problem(error.line, error.column, "", str(error))]) from None


class _TextError(Exception):
    def __init__(self, message: str, line: int = 0, column: int = 0) -> None:
        super().__init__(message)
        self.line, self.column = line, column


def _read_bytes(path: Path) -> bytes:
    if "\0" in str(path):
        raise _TextError("cannot be read: a path cannot hold a zero character")
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise _TextError("is a directory, not a scene file")
    if not stat.S_ISREG(status.st_mode):
        raise _TextError("is not a regular file")
    with open_regular(path) as file:
        raw = file.read(min(status.st_size, MAX_SCENE_BYTES) + 1)
    if len(raw) > MAX_SCENE_BYTES:
        size, most = max(status.st_size, len(raw)) >> 20, MAX_SCENE_BYTES >> 20
        raise _TextError(
            f"is too large: {size} MB, a scene file has at most {most} MB (bulk data belongs in a .npy file)"
        )
    return raw


def _decode(raw: bytes) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise _TextError("is in UTF-16 or UTF-32, a scene file must be in UTF-8")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, column = raw.count(b"\n", 0, error.start) + 1, error.start - raw.rfind(b"\n", 0, error.start)
        message = f"is not a text in UTF-8: byte 0x{raw[error.start]:02x}"
        raise _TextError(
            "looks like a binary file: " + message if b"\0" in raw[:4096] else message, line, column
        ) from None
    if "\0" in text:
        position = text.index("\0")
        line, column = text.count("\n", 0, position) + 1, position - text.rfind("\n", 0, position)
        raise _TextError("looks like a binary file: it holds a zero byte", line, column)
    return text
