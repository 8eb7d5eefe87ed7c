"""The values of an element, each an attribute or a child element, as OpenMC allows either.

Numbers are kept as the decimal fractions that were written: sums such as lower_left + i pitch are
then exact, and what coincides on paper coincides in the scene.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import TypeVar

from ..decimals import is_beyond_float64
from ..errors import Problem
from ..nodes import shortened
from .words import MOST_WORDS, count_words, tally
from .xml_tree import Element

_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}")
LONGEST = 400
Value = TypeVar("Value")
Other = TypeVar("Other")


class Mistake(Exception):
    """What is wrong in one element, which is of no use."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)


class Values:
    """Reads the values of one element, which messages call `where`.

    The first mistake in a value is raised; `attempt` keeps it, so that the other values are looked at as well, and
    `finish` then raises all that were kept.
    """

    def __init__(self, element: Element, kind: str) -> None:
        self.element = element
        self.where = self.kind = kind
        self.kept: list[Problem] = []

    def mistake(self, message: str) -> Mistake:
        return Mistake([Problem(self.element.line, self.element.column, self.where, message)])

    def tell(self, message: str) -> None:
        """Keep a mistake."""
        self.kept.extend(self.mistake(message).problems)

    def attempt(self, read: Callable[[], Value], otherwise: Other) -> Value | Other:
        """What `read` returns; where it finds a mistake, that is kept, and `otherwise` taken."""
        try:
            return read()
        except Mistake as mistake:
            self.kept.extend(mistake.problems)
            return otherwise

    def finish(self) -> None:
        """Raise the mistakes that were kept, if any."""
        if self.kept:
            raise Mistake(self.kept)

    def title(self) -> tuple[int, str]:
        """The number and the name, by which messages call the element from now on."""
        name = self.text("name") or ""
        found = len(self.kept)
        number = self.attempt(lambda: self.integer("id"), 0)
        if len(self.kept) == found:
            self.where = titled(self.kind, number, name)
        return number, name

    def text(self, name: str) -> str | None:
        """The value without space around it, or None where there is none. Attributes come first."""
        if name in self.element.attributes:
            return self.element.attributes[name].strip()
        found = self.element.all(name)
        return found[0].text.strip() if found else None

    def required(self, name: str) -> str:
        value = self.text(name)
        if value is None:
            raise self.mistake(f"needs the attribute or element {name!r}")
        return value

    def words(self, name: str) -> list[str] | None:
        value = self.text(name)
        if value is None:
            return None
        words = value.split(None, MOST_WORDS)
        if len(words) > MOST_WORDS:
            raise self.mistake(f"{name} has more than {MOST_WORDS:,} words")
        return words

    def integer(self, name: str) -> int:
        return self.integer_word(name, self.required(name))

    def optional_integer(self, name: str) -> int | None:
        value = self.text(name)
        return None if value is None else self.integer_word(name, value)

    def integers(self, name: str) -> list[int]:
        self.required(name)
        return [self.integer_word(name, word) for word in self.words(name) or ()]

    def integer_tally(self, name: str) -> Counter[int]:
        """How often each integer stands in a list that may be long."""
        counts: Counter[int] = Counter()
        words = tally(self.required(name))
        if words is None:
            raise self.mistake(f"{name} has more than {MOST_WORDS:,} different words")
        for word, count in words.items():
            counts[self.integer_word(name, word)] += count
        return counts

    def integer_word(self, name: str, word: str) -> int:
        if not _INTEGER.fullmatch(word):
            raise self.mistake(f"{name} must be an integer, got {shown(word)}")
        return int(word)

    def numbers(self, name: str, *counts: int) -> tuple[Fraction, ...]:
        """As many numbers as one of `counts`."""
        text = self.required(name)
        words = text.split(None, max(counts))
        if len(words) not in counts:
            expected = " or ".join(map(str, counts))
            plural = "" if counts == (1,) else "s"
            raise self.mistake(f"{name} must be {expected} number{plural}, got {count_words(text)}")
        return tuple(self._number(name, word) for word in words)

    def _number(self, name: str, word: str) -> Fraction:
        if len(word) > LONGEST or not _NUMBER.fullmatch(word):
            raise self.mistake(f"{name} must be a number, got {shown(word)}")
        nearest = float(word)
        if is_beyond_float64(word, nearest):
            raise self.mistake(f"{name} must be in the range of double precision, got {shown(word)}")
        return Fraction(word) if nearest else Fraction(0)


def titled(kind: str, number: int, name: str) -> str:
    """surface 3 'top'; what a terminal would obey is escaped."""
    return f"{kind} {number} {shortened(name)!r}" if name else f"{kind} {number}"


def shown(word: str) -> str:
    """A word as it was found, shortened and escaped."""
    return repr(shortened(word)) if word else "nothing"


def listed(items: Iterable[object], most: int = 10) -> str:
    """Items with commas between, the first few of many."""
    texts = [str(item) for item in items]
    return ", ".join(texts[:most]) + (f" and {len(texts) - most} more" if len(texts) > most else "")
