"""Numbers as Fortran reads them, kept as the decimal fractions that were written; and shortcuts nR, nI, nM, nJ."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction

from ..decimals import is_beyond_float64
from ..nodes import shortened

LONGEST = 400
MOST = 1_000_000
"""Entries of one card, shortcuts written out."""
_NUMBER = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[ed]?([-+][0-9]+)|[ed]([0-9]+))?")
_SHORT = re.compile(r"([0-9]{0,9})(r|i|j)|(.+)m")
_INTEGER = re.compile(r"[-+]?[0-9]{1,15}")


def number(word: str) -> Fraction:
    """1.5, 1.5e-3, 1.5d-3 or 1.5-3. Raises ValueError."""
    found = _NUMBER.fullmatch(word) if len(word) <= LONGEST else None
    if found is None:
        raise ValueError(f"{shortened(word, 40)!r} is no number")
    exponent = found[2] or found[3]
    plain = found[1] + (f"e{exponent}" if exponent else "")
    nearest = float(plain)
    if is_beyond_float64(plain, nearest):
        raise ValueError(f"{shortened(word, 40)!r} is beyond double precision")
    return Fraction(plain) if nearest else Fraction(0)


def integer(what: str, word: str | Fraction) -> int:
    """A whole number. Raises ValueError."""
    if isinstance(word, Fraction):
        if word.denominator != 1:
            raise ValueError(f"{what} must be an integer, got {float(word):g}")
        return int(word)
    if not _INTEGER.fullmatch(word):
        raise ValueError(f"{what} must be an integer, got {shortened(word, 40)!r}")
    return int(word)


def numbers(words: Iterable[str]) -> list[Fraction]:
    """The entries of a card, none of them jumped over. Raises ValueError."""
    found = entries(words)
    values = [value for value in found if value is not None]
    if len(values) < len(found):
        raise ValueError("jumps over an entry (nJ) that has no default here")
    return values


def entries(words: Iterable[str]) -> list[Fraction | None]:
    """The entries of a card with shortcuts written out; None where one is jumped over. Raises ValueError."""
    result: list[Fraction | None] = []
    steps = 0
    for word in words:
        short = _SHORT.fullmatch(word)
        if short is None or (short[2] is None and _NUMBER.fullmatch(short[3]) is None):
            value = number(word)
            _interpolate(result, steps, value)
            result.append(value)
            steps = 0
        elif steps:
            raise ValueError(f"a number must follow the shortcut {steps}i, got {shortened(word, 40)!r}")
        elif short[2] == "j":
            result += [None] * _times(short[1], result)
        elif not result or result[-1] is None:
            raise ValueError(f"the shortcut {shortened(word, 40)!r} needs a number before it")
        elif short[2] == "r":
            result += [result[-1]] * _times(short[1], result)
        elif short[2] == "i":
            steps = _times(short[1], result)
        else:
            result.append(result[-1] * number(short[3]))
        if len(result) > MOST:
            raise ValueError(f"has more than {MOST:,} entries")
    if steps:
        raise ValueError(f"a number must follow the shortcut {steps}i")
    return result


def _times(word: str, before: list[Fraction | None]) -> int:
    times = int(word or 1)
    if times + len(before) > MOST:
        raise ValueError(f"has more than {MOST:,} entries")
    return times


def _interpolate(result: list[Fraction | None], steps: int, end: Fraction) -> None:
    """Insert so many numbers between the last one and `end`."""
    if steps:
        start = result[-1]
        assert start is not None
        result += [start + (end - start) * i / (steps + 1) for i in range(1, steps + 1)]
