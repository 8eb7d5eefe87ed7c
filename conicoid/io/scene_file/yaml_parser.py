"""Read the text of a scene file, and parse it into a tree of nodes that know their line and column.

libyaml finds the structure (its events) and nothing else: no tag is obeyed, no object is made. Depth, and the number of
values that aliases expand to, are limited; the tree is built without recursion.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from ..._util.files import Problem, SceneFileError, check_name, read_regular, unreadable_error
from ..._util.records import dataclass
from .nodes import MappingNode, Node, ScalarNode, SequenceNode, shorten

# The text before it is parsed.


class YamlError(Exception):
    """Raised for a text that cannot be parsed; `problem` holds the reason and the place."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.problem = Problem(line, column, "", message)
        super().__init__(message)


def line_and_column(text: str, position: int) -> tuple[int, int]:
    """Return line and column, from 1, of a position in a text."""
    return text.count("\n", 0, position) + 1, position - (text.rfind("\n", 0, position) + 1) + 1


def check_directives(text: str) -> None:
    """Raise YamlError for a directive other than %YAML 1.x before the document: libyaml is slow on many %TAG lines."""
    # The rare case is found by a search of plain text
    if not text.startswith("%") and "\n%" not in text:
        return
    found = re.search(r"^%(?!YAML 1\.).*", text, re.MULTILINE)
    if found and not re.search(r"^[ \t]*[^\s#%]", text[: found.start()], re.MULTILINE):
        message = f"directive {shorten(found.group().strip())!r} is not allowed in scene files"
        raise YamlError(*line_and_column(text, found.start()), message)


def join_surrogates(text: str) -> str:
    """Return a text with pairs of escaped surrogates joined.

    JSON writes a character beyond U+FFFF as two escapes; YAML writes it as one character.
    """
    # Most files have no such escape, and a search costs less than a substitution
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


# From text to a tree.

MAX_DEPTH = 250
MAX_NODES, MAX_EXPANDED = 4_000_000, 1_000_000
"""Most values of a file with aliases written out, and most values that aliases may add."""
_EVENT_STEP = 10_000
"""Events from one report of progress to the next."""


@dataclass
class YamlDocument:
    """The single document of a text: its root, None if there is none, and problems with repeated keys."""

    root: Node | None = None
    problems: list[Problem] = field(default_factory=list)
    distinct: int = 0
    """The number of values written in the text, keys included; aliases do not count."""


_COLON = re.compile(r"\w:[\[{]?$")
"""The end of a text before a mistake: a word and a colon without a blank after it."""


def parse_document(text: str, progress: Callable[[int], Any] | None = None, first_line: int = 1) -> YamlDocument:
    """Parse the single document of `text`.

    `progress` is called as progress(characters) now and then. `first_line` is the number of the first line. Raise
    YamlError for text that is not YAML or exceeds the limits.
    """
    check_directives(text)
    try:
        # libyaml where it is installed: the parser in Python takes many times as long
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)(join_surrogates(text))
        try:
            return _TreeBuilder(first_line).build(loader.get_event, progress)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (0, 0)
        reason = " ".join(part for part in (error.context, error.problem) if part)
        found = text[mark.index : mark.index + 1] if mark else ""
        place = f" at {found!r}" if found else ""
        raise YamlError(line, column, f"not YAML: {reason or 'cannot be read'}{place}") from None
    except yaml.reader.ReaderError as error:
        line, column = line_and_column(text, error.position)
        raise YamlError(line, column, f"not YAML: {error.reason} (character U+{_code(error.character):04X})") from None
    except yaml.YAMLError as error:
        raise YamlError(0, 0, f"not YAML: {str(error)[:200]}") from None


class _TreeBuilder:
    """Builds nodes from events with a stack of its own, so that depth costs no recursion."""

    def __init__(self, first_line: int) -> None:
        self.first_line = first_line
        self.document = YamlDocument()
        self.open_anchors: set[str] = set()
        self.anchors: dict[str, Node] = {}
        self.twice: dict[int, dict[str, ScalarNode]] = {}  # by id: keys of open mappings with a repeated key
        self.documents = 0

    def build(self, next_event: Callable[[], Any], progress: Callable[[int], Any] | None) -> YamlDocument:
        """Return the document of all events.

        Raise YamlError beyond the limits, for a tag, for a key that is no word, and for a second document. A file has
        up to millions of events, so that the usual ones are handled here without a call.
        """
        first_line = self.first_line
        events = count = expanded = 0  # finished nodes with aliases expanded, and those that the aliases added
        parent: Any = None
        key: ScalarNode | None = None  # the key of `parent` that waits for its value
        stack: list[tuple[Any, ScalarNode | None, int, str | None]] = []  # what each open collection interrupts
        words: dict[str, str] = {}  # equal keys share one text, which saves memory
        scalar, alias, ended = yaml.ScalarEvent, yaml.AliasEvent, yaml.StreamEndEvent
        kinds = {yaml.MappingStartEvent: MappingNode, yaml.SequenceStartEvent: SequenceNode}
        ends = (yaml.MappingEndEvent, yaml.SequenceEndEvent)
        node: Node
        while (kind := type(event := next_event())) is not ended:
            events += 1
            if progress is not None and events % _EVENT_STEP == 0:
                progress(event.start_mark.index)
            mark = event.start_mark
            line, column = mark.line + first_line, mark.column + 1
            if kind is scalar:
                if event.tag is not None:
                    _refuse_tag(event.tag, line, column)
                node = ScalarNode(line, column, event.value, event.implicit[0])
                if event.anchor:
                    self.anchors[event.anchor] = node
                count += 1
            elif kind in kinds:
                if event.tag is not None:
                    _refuse_tag(event.tag, line, column)
                # Later readers recurse
                if len(stack) >= MAX_DEPTH:
                    raise YamlError(line, column, f"nested deeper than {MAX_DEPTH} levels")
                if event.anchor:
                    self.open_anchors.add(event.anchor)
                stack.append((parent, key, count, event.anchor))
                parent, key = kinds[kind](line, column), None
                continue
            elif kind in ends:
                node = closed = parent
                parent, key, before, anchor = stack.pop()
                count += 1
                closed.size, line, column = count - before, closed.line, closed.column
                if anchor:
                    self.open_anchors.discard(anchor)
                    self.anchors[anchor] = node
                if self.twice:
                    self.twice.pop(id(node), None)
            elif kind is alias:
                node = self._resolve_alias(event.anchor, line, column)
                count += node.size
                expanded += node.size
            else:
                self._between(kind, line, column)
                continue
            if count > MAX_NODES or expanded - len(stack) > MAX_EXPANDED:
                most = f"{MAX_NODES:,} values" if count > MAX_NODES else f"{MAX_EXPANDED:,} values, aliases expanded"
                raise YamlError(line, column, f"more than {most} (bulk data belongs in a .npy file)")
            if type(parent) is SequenceNode:
                parent.items.append(node)
            elif parent is None:
                self.document.root = node
            elif key is None:
                if type(node) is not ScalarNode:
                    raise YamlError(line, column, "a key must be a word, found a list or mapping")
                node.text = words.setdefault(node.text, node.text)
                key = node
            else:
                if key.text not in parent.entries:
                    parent.entries[key.text] = node
                    parent.heads.append(key)
                    if id(parent) in self.twice:
                        self.twice[id(parent)][key.text] = key
                else:
                    self._report_repeated_key(parent, key)
                key = None
        self.document.distinct = count - expanded
        return self.document

    def _resolve_alias(self, anchor: str, line: int, column: int) -> Node:
        """Return the node of an anchor. Raise YamlError if it is unknown, or open: that would be a circle."""
        if anchor in self.open_anchors:
            raise YamlError(line, column, f"alias *{shorten(anchor)} lies inside what it stands for")
        if anchor not in self.anchors:
            message = f"alias *{shorten(anchor)} has no anchor &{shorten(anchor)} before it"
            raise YamlError(line, column, message)
        return self.anchors[anchor]

    def _between(self, kind: Any, line: int, column: int) -> None:
        """Note the begin or end of the stream or of a document. Raise YamlError for a second document."""
        self.documents += kind is yaml.DocumentStartEvent
        if self.documents > 1:
            raise YamlError(line, column, "a scene file holds one document, found a second one")

    def _report_repeated_key(self, parent: MappingNode, key: ScalarNode) -> None:
        """Report a key that a mapping has already; the first value stays."""
        if id(parent) not in self.twice:
            self.twice[id(parent)] = parent.keys
        first = self.twice[id(parent)][key.text].line
        message = f"key {shorten(key.text)!r} is given twice (first in line {first})"
        self.document.problems.append(Problem(key.line, key.column, "", message))


def _refuse_tag(tag: Any, line: int, column: int) -> None:
    raise YamlError(line, column, f"tags such as {shorten(str(tag))!r} are not allowed in scene files")


def _code(character: Any) -> int:
    """Return the code of a character, which may be a number or a text."""
    return character if isinstance(character, int) else ord(character)


# From a path to the text.

MAX_SCENE_BYTES = 64 << 20


def read_scene_text(path: str | os.PathLike[str]) -> str:
    """Return the text of a scene file. Raise SceneFileError for a file that is no text in UTF-8, or too large."""
    try:
        raw = _read_bytes(Path(path))
        return _decode(raw)
    except OSError as error:
        raise unreadable_error(path, error) from None
    except _TextError as error:
        raise SceneFileError(path, [Problem(error.line, error.column, "", str(error))]) from None


class _TextError(Exception):
    """Raised for a file without a readable text; the message gives the reason."""

    def __init__(self, message: str, line: int = 0, column: int = 0) -> None:
        super().__init__(message)
        self.line, self.column = line, column


def _read_bytes(path: Path) -> bytes:
    """Return the bytes of a regular file of at most `MAX_SCENE_BYTES`."""
    if "\0" in str(path):
        raise _TextError("cannot be read: a path cannot hold a zero character")
    check_name(path)
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise _TextError("is a directory, not a scene file")
    if not stat.S_ISREG(status.st_mode):
        raise _TextError("is not a regular file")
    raw = read_regular(path, MAX_SCENE_BYTES)
    if len(raw) > MAX_SCENE_BYTES:
        size, most = max(status.st_size, len(raw)) >> 20, MAX_SCENE_BYTES >> 20
        raise _TextError(
            f"is too large: {size} MB, a scene file has at most {most} MB (bulk data belongs in a .npy file)"
        )
    return raw


def _decode(raw: bytes) -> str:
    """Return bytes as text in UTF-8, with or without a byte order mark."""
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
