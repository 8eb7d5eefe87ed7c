"""The tree of a scene file, with lines and columns, and the values of its plain words.

Plain words follow the core schema of YAML 1.2 (section 10.3): `no` is a text and `1e-9` a number, unlike in YAML 1.1.
Nodes keep the words as written and look up values on demand, so that a message can show the word of the file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, TypeAlias


def is_beyond_float64(word: str, value: float) -> bool:
    """Return True if a finite number that is not 0 became infinite or 0 in `value`, its nearest float64."""
    return (value == 0 or math.isinf(value)) and re.search("[1-9]", re.split("[eE]", word, maxsplit=1)[0]) is not None


# Nodes.


@dataclass(slots=True, eq=False)
class ScalarNode:
    """One word. A plain word may be a number, a boolean or null; a quoted word is a text."""

    line: int
    column: int
    text: str
    plain: bool
    size: ClassVar[int] = 1


@dataclass(slots=True, eq=False)
class SequenceNode:
    """A sequence. `size` counts the node and all nodes below, with aliases expanded."""

    line: int
    column: int
    items: list[Node] = field(default_factory=list)
    size: int = 1


@dataclass(slots=True, eq=False)
class MappingNode:
    """A mapping with texts as keys, in the order of the file. `heads` holds the nodes of the keys."""

    line: int
    column: int
    entries: dict[str, Node] = field(default_factory=dict)
    heads: list[ScalarNode] = field(default_factory=list)
    size: int = 1

    @property
    def keys(self) -> dict[str, ScalarNode]:
        """The nodes of the keys by their text; made on each call, as few mappings need it."""
        return {key.text: key for key in self.heads}


class HasPosition(Protocol):
    """Anything with a place in the text, from line 1 and column 1."""

    @property
    def line(self) -> int: ...
    @property
    def column(self) -> int: ...


Node: TypeAlias = ScalarNode | SequenceNode | MappingNode


_NULL = re.compile(r"null|Null|NULL|~|")
_TRUE = re.compile(r"true|True|TRUE")
_FALSE = re.compile(r"false|False|FALSE")
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"([-+]?)\.(?:inf|Inf|INF)")
_NAN = re.compile(r"\.(?:nan|NaN|NAN)")
DECIMAL = r"-?(?:[0-9]{1,17}(?:\.[0-9]{0,20})?|0?\.[0-9]{1,20})(?:[eE][-+]?[0-9]{1,2})?"
"""Pattern of decimals that float64 holds, none too large or too small: it covers nearly all numbers of files."""
_MEANING = re.compile(
    "|".join(f"(?:{one.pattern})" for one in (_NULL, _TRUE, _FALSE, _INTEGER, _FLOAT, _INFINITE, _NAN))
)


def is_null(node: Node) -> bool:
    """Return True for null, written or empty."""
    return isinstance(node, ScalarNode) and node.plain and _NULL.fullmatch(node.text) is not None


def is_empty_node(node: Node) -> bool:
    """Return True for an empty place: neither a word nor null is written."""
    return isinstance(node, ScalarNode) and node.plain and not node.text


def parse_bool(node: Node) -> bool | None:
    """Return a boolean, or None for anything else."""
    if not isinstance(node, ScalarNode) or not node.plain:
        return None
    if _TRUE.fullmatch(node.text):
        return True
    return False if _FALSE.fullmatch(node.text) else None


def parse_float(node: Node) -> float | None:
    """Return a plain number as the nearest float (±inf and NaN as written), or None for anything else.

    Raise OverflowError for a number beyond the range of float64, or so small that it would become 0.
    """
    if not isinstance(node, ScalarNode) or not node.plain or len(text := node.text) > 1000:
        return None
    if _FLOAT.fullmatch(text):
        value = float(text)
        if (value == 0 or math.isinf(value)) and is_beyond_float64(text, value):
            raise OverflowError(text)
        return value
    if _INTEGER.fullmatch(text):
        return float(int(text, 0))
    if match := _INFINITE.fullmatch(text):
        return -math.inf if match.group(1) == "-" else math.inf
    return math.nan if _NAN.fullmatch(text) else None


def parse_int(node: Node) -> int | None:
    """Return a plain integer of at most 19 characters, or None for anything else."""
    if isinstance(node, ScalarNode) and node.plain and len(node.text) <= 19 and _INTEGER.fullmatch(node.text):
        return int(node.text.lstrip("+"), 0 if "x" in node.text or "o" in node.text else 10)
    return None


def is_text(node: Node) -> bool:
    """Return True for a quoted word, and for a plain one that is not a number, a boolean or null."""
    if not isinstance(node, ScalarNode):
        return False
    if not node.plain:
        return True
    return _MEANING.fullmatch(node.text) is None


def shorten(text: str, width: int = 60) -> str:
    """Return a text cut to `width` characters, with "..." at the end."""
    return text if len(text) <= width else text[: width - 3] + "..."


def describe_node(node: Node) -> str:
    """Return the value of a node for messages: on one line, shortened."""
    return shorten("".join(_pieces(node, 64)))


def _pieces(node: Node, budget: int) -> Iterator[str]:
    """Yield pieces of the description of a node: at most `budget` items, and a quarter as many in each of them."""
    if isinstance(node, ScalarNode):
        text = shorten(node.text)
        yield (text or "nothing (# begins a comment)") if is_null(node) or not is_text(node) else repr(text)
    elif budget <= 1:
        yield "..."
    elif isinstance(node, SequenceNode):
        yield "["
        for i, item in enumerate(node.items[:budget]):
            yield ", " if i else ""
            yield from _pieces(item, budget // 4)
        yield "]"
    else:
        yield "{"
        for i, (key, item) in enumerate(list(node.entries.items())[:budget]):
            yield f"{', ' if i else ''}{shorten(key)}: "
            yield from _pieces(item, budget // 4)
        yield "}"
