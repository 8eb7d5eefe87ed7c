"""The kinds of value that stand in a scene file: each reads itself from a node and describes itself to editors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

from ..shapes.color import grey_hint
from .nodes import Listing, Node, Scalar, Table, integer, is_nothing, is_null, is_text, number, shown, truth
from .reading import BAD, Reader

Schema = dict[str, Any]


class Kind(ABC):
    """What may stand in a place. `phrase` completes the sentence "must be ..."."""

    phrase: str

    @abstractmethod
    def read(self, node: Node, reader: Reader, where: str) -> Any:
        """The value of a node, or BAD after a report."""

    @abstractmethod
    def schema(self) -> Schema:
        """JSON Schema of the values."""

    @abstractmethod
    def fits(self, node: Node) -> bool:
        """Whether a node looks like this kind: what `OneOf` chooses by."""


class Number(Kind):
    """A float64, infinities included; the class that takes it says where they are not."""

    phrase = "a number"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        try:
            value = number(node)
        except OverflowError:
            return reader.expected(node, where, "a number that float64 can hold")
        if value is None:
            quoted = isinstance(node, Scalar) and not node.plain
            return reader.report(
                node, where, f"must be {self.phrase}, got {shown(node)}{' in quotes' if quoted else ''}"
            )
        return reader.expected(node, where, "a number, not NaN") if math.isnan(value) else value

    def schema(self) -> Schema:
        return {"type": "number"}

    def fits(self, node: Node) -> bool:
        return isinstance(node, Scalar) and not is_text(node) and not is_null(node)


class Integer(Kind):
    """A whole number."""

    phrase = "an integer"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        value = integer(node)
        return reader.expected(node, where, self.phrase) if value is None else value

    def schema(self) -> Schema:
        return {"type": "integer"}

    def fits(self, node: Node) -> bool:
        return integer(node) is not None


class Flag(Kind):
    """A truth value."""

    phrase = "true or false"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        value = truth(node)
        return reader.expected(node, where, self.phrase) if value is None else value

    def schema(self) -> Schema:
        return {"type": "boolean"}

    def fits(self, node: Node) -> bool:
        return truth(node) is not None


class Text(Kind):
    """A word that is not a number, a truth value or null, or anything in quotes; not empty."""

    phrase = "a text"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if isinstance(node, Scalar) and is_text(node) and node.text:
            return node.text
        return reader.report(node, where, f"must be {self.phrase}, got {shown(node)}{quotes_hint(node)}")

    def schema(self) -> Schema:
        return {"type": "string", "minLength": 1}

    def fits(self, node: Node) -> bool:
        return is_text(node)


class Choice(Kind):
    """One of a few given texts."""

    def __init__(self, values: tuple[str, ...]) -> None:
        self.values = values
        self.phrase = " or ".join(repr(value) for value in values)

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if isinstance(node, Scalar) and is_text(node) and node.text in self.values:
            return node.text
        return reader.expected(node, where, self.phrase)

    def schema(self) -> Schema:
        return {"enum": list(self.values)}

    def fits(self, node: Node) -> bool:
        return is_text(node)


class Several(Kind):
    """A list of one kind, of any length."""

    def __init__(self, item: Kind) -> None:
        self.item = item
        self.phrase = f"a list of items, each {item.phrase}"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if not isinstance(node, Listing):
            return reader.expected(node, where, self.phrase)
        values = tuple(self.item.read(item, reader, f"{where}[{i}]") for i, item in enumerate(node.items))
        return BAD if any(value is BAD for value in values) else values

    def schema(self) -> Schema:
        return {"type": "array", "items": self.item.schema()}

    def fits(self, node: Node) -> bool:
        return isinstance(node, Listing)


class Fixed(Several):
    """A list of one kind and of given length: points, intervals, matrices."""

    def __init__(self, item: Kind, count: int) -> None:
        super().__init__(item)
        self.count = count
        self.phrase = f"{count} numbers" if isinstance(item, Number) else f"{count} items, each {item.phrase}"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if not isinstance(node, Listing):
            return reader.expected(node, where, self.phrase)
        if len(node.items) != self.count:
            return reader.report(node, where, f"must be {self.phrase}, got {len(node.items)}: {shown(node)}")
        return super().read(node, reader, where)

    def schema(self) -> Schema:
        return super().schema() | {"minItems": self.count, "maxItems": self.count}

    def fits(self, node: Node) -> bool:
        return isinstance(node, Listing) and len(node.items) == self.count


class Named(Kind):
    """A mapping from names to values of one kind."""

    def __init__(self, item: Kind) -> None:
        self.item = item
        self.phrase = f"a mapping, each value {item.phrase}"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if not isinstance(node, Table):
            return reader.expected(node, where, self.phrase)
        values = {name: self.item.read(item, reader, f"{where}.{name}") for name, item in node.entries.items()}
        return BAD if any(value is BAD for value in values.values()) else values

    def schema(self) -> Schema:
        return {"type": "object", "additionalProperties": self.item.schema()}

    def fits(self, node: Node) -> bool:
        return isinstance(node, Table)


class Maybe(Kind):
    """A value or null, which must be written: where nothing stands, something may have been forgotten."""

    def __init__(self, item: Kind) -> None:
        self.item = item
        self.phrase = item.phrase

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if is_nothing(node):
            return reader.report(node, where, f"must be {self.phrase}, or null, got nothing{comment_hint(node)}")
        return None if is_null(node) else self.item.read(node, reader, where)

    def schema(self) -> Schema:
        return {"anyOf": [self.item.schema(), {"type": "null"}]}

    def fits(self, node: Node) -> bool:
        return is_null(node) or self.item.fits(node)


class OneOf(Kind):
    """Any of several kinds; the first that a node looks like reads it."""

    def __init__(self, items: tuple[Kind, ...]) -> None:
        self.items = items
        self.phrase = ", or ".join(item.phrase for item in items)

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        for item in self.items:
            if item.fits(node):
                return item.read(node, reader, where)
        texts = any(isinstance(item, Text) for item in self.items)
        colors = texts and any(isinstance(item, Fixed) and item.count == 3 for item in self.items)
        hint = comment_hint(node) if texts else ""
        value = integer(node) if colors and integer(node) is not None else number(node) if colors else None
        hint += grey_hint(value) if value is not None else ""
        return reader.report(node, where, f"must be {self.phrase}, got {shown(node)}{hint}")

    def schema(self) -> Schema:
        return {"anyOf": [item.schema() for item in self.items]}

    def fits(self, node: Node) -> bool:
        return any(item.fits(node) for item in self.items)


def quotes_hint(node: Node) -> str:
    """What to do where a text is wanted and YAML sees something else."""
    if isinstance(node, Scalar) and node.plain and node.text:
        return " (quote it)"
    if isinstance(node, Scalar) and not node.plain and not node.text:
        return ", which is empty (leave it out where there is none)"
    return comment_hint(node)


def comment_hint(node: Node) -> str:
    """What to do about a colour like #ff0000 without quotes."""
    told = " (# begins a comment: put a text that begins with it in quotes; what has no value is left out)"
    return told if is_nothing(node) else ""
