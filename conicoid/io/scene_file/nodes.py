"""The tree of a scene file, with lines and columns, the values of its plain words, and the types of its values.

Plain words follow the core schema of YAML 1.2 (section 10.3): `no` is a text and `1e-9` a number, unlike in YAML 1.1.
Nodes keep the words as written and look up values on demand, so that a message can show the word of the file.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Final, Protocol, TypeAlias, TypeVar

from ..._util.files import MAX_PROBLEMS, Problem, Suggestions


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


# The types of values in a scene file, and `NodeReader`, which collects the problems of a file.
#
# A `ValueType` reads its value from a node and describes itself by JSON Schema. `fields.py` makes types from type
# hints.

# Problems.

Value = TypeVar("Value")


class BadValue:
    """Stands for a value that could not be read and whose problem is reported."""


BAD: Final = BadValue()


class TooManyProblems(Exception):
    """Raised after so many problems that reading stops."""


class NodeReader:
    """Collects problems. Reading continues after a problem, so that a user sees all of them at once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.takes_any_file = False
        """True if image files may lie outside of the folder."""
        self.problems: list[Problem] = []
        self.suggestions = Suggestions()
        self.colors: dict[str, Any] = {}
        """The materials of the colours that bodies have, so that equal ones share one."""
        self.materials: dict[str, Any] = {}
        """The materials of the scene by name; BAD for one that could not be read."""
        self.shape: Callable[[Node, str, type], Any] = _no_shape
        """Reads a shape of a class or its subclasses; `ShapeReader`, which knows the named shapes, sets it."""

    def report(self, node: HasPosition, where: str, message: str) -> BadValue:
        """Record a problem and return BAD. Raise TooManyProblems after `MAX_PROBLEMS`."""
        self.problems.append(Problem(node.line, node.column, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            raise TooManyProblems
        return BAD

    def report_mismatch(self, node: Node, where: str, what: str) -> BadValue:
        """Report that `what` was expected here, with the value that was found."""
        return self.report(node, where, f"must be {what}, got {describe_node(node)}")

    def unknown(self, node: Node, where: str, what: str, name: str, known: Collection[str]) -> BadValue:
        """Report an unknown name, with a suggestion."""
        return self.report(node, where, f"unknown {what} {shorten(name)!r}{self.suggestions(name, known)}")

    def entries(
        self, node: Node, where: str, known: Iterable[str], required: Iterable[str] = ()
    ) -> dict[str, Node] | BadValue:
        """Return the known entries of a mapping; null counts as an empty mapping.

        Report unknown and missing keys, and return BAD then.
        """
        if is_null(node):  # `{Box:}` without fields
            node = MappingNode(node.line, node.column)
        names = list(known)
        if not isinstance(node, MappingNode):
            listed = ", ".join(names)
            return self.report_mismatch(node, where, f"a mapping with {listed}" if len(listed) < 200 else "a mapping")
        found = {name: value for name, value in node.entries.items() if name in names}
        good = len(found) == len(node.entries)
        for key in () if good else node.heads:  # suggestions cost time, and nearly all mappings are good
            if key.text not in found:
                left = [other for other in names if other not in node.entries]
                self.unknown(key, where, "key", key.text, left)
        if missing := [name for name in required if name not in node.entries]:
            good = False
            self.report(node, where, f"{' and '.join(missing)} must be given")
        return found if good else BAD

    def only_entry(self, node: Node) -> tuple[str, ScalarNode, Node] | None:
        """Return (name, key, value) of a mapping with one entry, or None for anything else."""
        if not isinstance(node, MappingNode) or len(node.entries) != 1:
            return None
        ((name, value),) = node.entries.items()
        return name, node.heads[0], value

    def build(self, node: Node, where: str, make: Callable[[], Value]) -> Value | BadValue:
        """Return make(), or report its ValueError or TypeError at the field that the message names."""
        try:
            return make()
        except RecursionError:
            return self.report(node, where, "nested too deeply")
        except (ValueError, TypeError, ArithmeticError) as error:
            return self.report(*_locate_problem(node, where, str(error)))


def _no_shape(node: Node, where: str, base: type) -> Any:
    raise LookupError(
        f"{where}: a reader without a scene has no shapes, it cannot read a {base.__name__} in line {node.line}"
    )


def _locate_problem(node: Node, where: str, message: str) -> tuple[Node, str, str]:
    """Return the arguments of `report` for an error such as "Ellipsoid: radii[1] must be > 0, got -2.0".

    The node is the one that the message names, `radii[1]`, if it exists, else the whole node.
    """
    # Messages begin with the class, then the field and indices: the same path leads to the node.
    message = re.sub(r"^\w+: ", "", message)
    target: Any = node
    match = re.match(r"(\w+)((?:\[\d+\])*)", message)
    if match and isinstance(target, MappingNode) and match.group(1) in target.entries:
        target = target.entries[match.group(1)]
        for index in re.findall(r"\d+", match.group(2)):
            items = getattr(target, "items", [])
            target = items[int(index)] if int(index) < len(items) else target
    return target, where, message


# Types of values.

Schema = dict[str, Any]


class ValueType(ABC):
    """A type of value. `phrase` completes the sentence "must be ..."."""

    phrase: str

    @abstractmethod
    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        """Return the value of a node, or BAD after a report."""

    @abstractmethod
    def schema(self) -> Schema:
        """Return the JSON Schema of the values."""

    @abstractmethod
    def fits(self, node: Node) -> bool:
        """Return True if a node looks like this type, by which `UnionType` chooses."""


class NumberType(ValueType):
    """A float64, infinities included; the class that takes the number checks whether it may be infinite."""

    phrase = "a number"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        try:
            value = parse_float(node)
        except OverflowError:
            return reader.report_mismatch(node, where, "a number that float64 can hold")
        if value is None:
            return reader.report_mismatch(node, where, self.phrase)
        return reader.report_mismatch(node, where, "a number, not NaN") if math.isnan(value) else value

    def schema(self) -> Schema:
        return {"type": "number"}

    def fits(self, node: Node) -> bool:
        return isinstance(node, ScalarNode) and not is_text(node) and not is_null(node)


class _WordType(ValueType):
    """The values of plain words that `parse` does not return None for; `name` is the type in JSON Schema."""

    name: str
    parse: Callable[[Node], Any]

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        value = self.parse(node)
        return reader.report_mismatch(node, where, self.phrase) if value is None else value

    def schema(self) -> Schema:
        return {"type": self.name}

    def fits(self, node: Node) -> bool:
        return self.parse(node) is not None


class IntegerType(_WordType):
    """A whole number."""

    phrase, name, parse = "an integer", "integer", staticmethod(parse_int)


class BoolType(_WordType):
    """A boolean."""

    phrase, name, parse = "true or false", "boolean", staticmethod(parse_bool)


class TextType(ValueType):
    """A word that is not a number, a boolean or null, or any quoted word; not empty."""

    phrase = "a text"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if isinstance(node, ScalarNode) and is_text(node) and node.text:
            return node.text
        return reader.report_mismatch(node, where, self.phrase)

    def schema(self) -> Schema:
        return {"type": "string", "minLength": 1}

    def fits(self, node: Node) -> bool:
        return is_text(node)


class ChoiceType(ValueType):
    """One of a few texts."""

    def __init__(self, values: tuple[str, ...]) -> None:
        self.values = values
        self.phrase = " or ".join(repr(value) for value in values)

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if isinstance(node, ScalarNode) and is_text(node) and node.text in self.values:
            return node.text
        return reader.report_mismatch(node, where, self.phrase)

    def schema(self) -> Schema:
        return {"enum": list(self.values)}

    def fits(self, node: Node) -> bool:
        return is_text(node)


class ListType(ValueType):
    """A list of one type, of any length."""

    def __init__(self, item: ValueType) -> None:
        self.item = item
        self.phrase = f"a list of items, each {item.phrase}"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if not isinstance(node, SequenceNode):
            return reader.report_mismatch(node, where, self.phrase)
        values = tuple(self.item.read(item, reader, f"{where}[{i}]") for i, item in enumerate(node.items))
        return BAD if any(value is BAD for value in values) else values

    def schema(self) -> Schema:
        return {"type": "array", "items": self.item.schema()}

    def fits(self, node: Node) -> bool:
        return isinstance(node, SequenceNode)


class FixedListType(ListType):
    """A list of one type and of fixed length: points, intervals, matrices."""

    def __init__(self, item: ValueType, count: int) -> None:
        super().__init__(item)
        self.count = count
        self.phrase = f"{count} numbers" if isinstance(item, NumberType) else f"{count} items, each {item.phrase}"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if not isinstance(node, SequenceNode):
            return reader.report_mismatch(node, where, self.phrase)
        if len(node.items) != self.count:
            return reader.report(node, where, f"must be {self.phrase}, got {len(node.items)}: {describe_node(node)}")
        return super().read(node, reader, where)

    def schema(self) -> Schema:
        return super().schema() | {"minItems": self.count, "maxItems": self.count}

    def fits(self, node: Node) -> bool:
        return isinstance(node, SequenceNode) and len(node.items) == self.count


class MappingType(ValueType):
    """A mapping from names to values of one type."""

    def __init__(self, item: ValueType) -> None:
        self.item = item
        self.phrase = f"a mapping, each value {item.phrase}"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if not isinstance(node, MappingNode):
            return reader.report_mismatch(node, where, self.phrase)
        values = {name: self.item.read(item, reader, f"{where}.{name}") for name, item in node.entries.items()}
        return BAD if any(value is BAD for value in values.values()) else values

    def schema(self) -> Schema:
        return {"type": "object", "additionalProperties": self.item.schema()}

    def fits(self, node: Node) -> bool:
        return isinstance(node, MappingNode)


class OptionalType(ValueType):
    """A value or null. An empty place is a problem, as something may have been forgotten there."""

    def __init__(self, item: ValueType) -> None:
        self.item = item
        self.phrase = item.phrase

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if is_empty_node(node):
            return reader.report_mismatch(node, where, f"{self.phrase}, or null")
        return None if is_null(node) else self.item.read(node, reader, where)

    def schema(self) -> Schema:
        return {"anyOf": [self.item.schema(), {"type": "null"}]}

    def fits(self, node: Node) -> bool:
        return is_null(node) or self.item.fits(node)


class UnionType(ValueType):
    """One of several types; the first that fits a node reads it."""

    def __init__(self, items: tuple[ValueType, ...]) -> None:
        self.items = items
        self.phrase = ", or ".join(item.phrase for item in items)

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        for item in self.items:
            if item.fits(node):
                return item.read(node, reader, where)
        return reader.report_mismatch(node, where, self.phrase)

    def schema(self) -> Schema:
        return {"anyOf": [item.schema() for item in self.items]}

    def fits(self, node: Node) -> bool:
        return any(item.fits(node) for item in self.items)
