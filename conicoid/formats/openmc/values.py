"""The values of an element, each an attribute or a child element, as OpenMC allows either.

Numbers are kept as the decimal fractions that were written: sums such as lower_left + i pitch are
then exact, and what coincides on paper coincides in the scene.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from fractions import Fraction

from ..errors import Problem
from ..nodes import shortened
from .xml_tree import Element

_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}")
LONGEST = 400


class Mistake(Exception):
    """One mistake in an element; it ends the reading of that element."""

    def __init__(self, element: Element, where: str, message: str) -> None:
        self.problem = Problem(element.line, element.column, where, message)


class Values:
    """Reads the values of one element, which messages call `where`."""

    def __init__(self, element: Element, where: str) -> None:
        self.element = element
        self.where = where

    def mistake(self, message: str) -> Mistake:
        return Mistake(self.element, self.where, message)

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
        return None if value is None else value.split()

    def integer(self, name: str) -> int:
        return self.integer_word(name, self.required(name))

    def optional_integer(self, name: str) -> int | None:
        value = self.text(name)
        return None if value is None else self.integer_word(name, value)

    def integers(self, name: str) -> list[int]:
        return [self.integer_word(name, word) for word in self.required(name).split()]

    def integer_word(self, name: str, word: str) -> int:
        if not _INTEGER.fullmatch(word):
            raise self.mistake(f"{name} must be an integer, got {_shown(word)}")
        return int(word)

    def numbers(self, name: str, *counts: int) -> tuple[Fraction, ...]:
        """As many numbers as one of `counts`."""
        words = self.required(name).split()
        if len(words) not in counts:
            expected = " or ".join(map(str, counts))
            plural = "" if counts == (1,) else "s"
            raise self.mistake(f"{name} must be {expected} number{plural}, got {len(words)}")
        return tuple(self._number(name, word) for word in words)

    def _number(self, name: str, word: str) -> Fraction:
        if not _NUMBER.fullmatch(word) or len(word) > LONGEST:
            raise self.mistake(f"{name} must be a number, got {_shown(word)}")
        nearest = float(word)
        zero = not re.search("[1-9]", re.split("[eE]", word)[0])
        if math.isinf(nearest) or (nearest == 0 and not zero):
            raise self.mistake(f"{name} must be in the range of double precision, got {_shown(word)}")
        return Fraction(0) if zero else Fraction(word)


def _shown(word: str) -> str:
    return repr(shortened(word)) if word else "nothing"


def listed(items: Iterable[object], most: int = 10) -> str:
    """Items with commas between, the first few of many."""
    texts = [str(item) for item in items]
    return ", ".join(texts[:most]) + (f" and {len(texts) - most} more" if len(texts) > most else "")
