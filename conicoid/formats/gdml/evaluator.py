"""Expressions of GDML: sums, products, powers, comparisons and functions of names, in fractions; nothing is executed.

What fractions cannot say, roots and sines, is a float's value. Numbers that become too long are rounded to floats.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

LONGEST, DEEPEST = 2000, 50
"""Letters of an expression; brackets within brackets."""
_BITS = 1500

_TOKEN = re.compile(
    r"\s*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([A-Za-z_][\w.:]*)|(\*\*|&&|\|\||[<>=!]=|[-+*/^()<>!,]))", re.ASCII
)

_NUMBER = re.compile(r"\s*(-?)((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)\s*", re.ASCII)


class ExpressionError(ValueError):
    """What is wrong with an expression."""


def _two(function: Callable[[float, float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 2, lambda a, b: Fraction(function(float(a), float(b)))


def _one(function: Callable[[float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 1, lambda a: Fraction(function(float(a)))


def _root(value: Fraction) -> Fraction:
    """The exact root, where it is a fraction."""
    if value < 0:
        raise ExpressionError("takes the square root of a negative number")
    above, below = math.isqrt(value.numerator), math.isqrt(value.denominator)
    if above * above == value.numerator and below * below == value.denominator:
        return Fraction(above, below)
    return Fraction(math.sqrt(value))


def power(base: Fraction, exponent: Fraction) -> Fraction:
    """Exact for small whole exponents."""
    if exponent.denominator == 1 and abs(exponent) <= 64:
        if not base and exponent < 0:
            raise ExpressionError("divides by zero")
        return base ** int(exponent)
    found = float(base) ** float(exponent)
    if isinstance(found, complex):
        raise ExpressionError("raises a negative number to a broken power")
    return Fraction(found)


_FUNCTIONS: dict[str, tuple[int, Callable[..., Fraction]]] = {
    "abs": (1, abs), "min": (2, min), "max": (2, max), "pow": (2, power), "sqrt": (1, _root), "sin": _one(math.sin),
    "cos": _one(math.cos), "tan": _one(math.tan), "asin": _one(math.asin), "acos": _one(math.acos),
    "atan": _one(math.atan), "atan2": _two(math.atan2), "sinh": _one(math.sinh), "cosh": _one(math.cosh),
    "tanh": _one(math.tanh), "exp": _one(math.exp), "log": _one(math.log), "log10": _one(math.log10),
}  # fmt: skip

_LEVELS: tuple[tuple[str, ...], ...] = (("||",), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/"))


def evaluate(text: str, names: Mapping[str, Fraction]) -> Fraction:
    """The value of an expression. Raises ExpressionError for what is none, KeyError for an unknown name."""
    if len(text) <= _SHORT:  # most are a number or a name
        known = names.get(text)
        if known is None:
            known = _plain(text)
        if known is not None:
            return known
    return _Parser(text, names).value()


_SHORT = 40


@lru_cache(1 << 14)
def _plain(text: str) -> Fraction | None:
    """The value of a number with a sign perhaps; None for other expressions."""
    found = _NUMBER.fullmatch(text)
    return None if found is None else (-number(found[2]) if found[1] == "-" else number(found[2]))


class _Parser:
    """Recursive descent, of bounded depth."""

    def __init__(self, text: str, names: Mapping[str, Fraction]) -> None:
        if len(text) > LONGEST:
            raise ExpressionError(f"is longer than {LONGEST:,} letters")
        self.names, self.at, self.depth = names, 0, 0
        self.tokens = _tokens(text)

    def value(self) -> Fraction:
        """All of it."""
        try:
            found = self.level(0)
        except ZeroDivisionError:
            raise ExpressionError("divides by zero") from None
        except (OverflowError, ValueError) as error:
            if isinstance(error, ExpressionError):
                raise
            raise ExpressionError("is no finite number") from None
        if self.at < len(self.tokens):
            raise ExpressionError(f"has {self.tokens[self.at]!r} where it should end or go on with an operator")
        return found

    @property
    def next(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        token = self.next
        self.at += 1
        return token

    def expect(self, token: str) -> None:
        if self.take() != token:
            raise ExpressionError(f"lacks a {token!r}")

    def level(self, number: int) -> Fraction:
        """Operators of a level, from left to right."""
        if number == len(_LEVELS):
            return self.signed()
        found = self.level(number + 1)
        while self.next in _LEVELS[number]:
            found = _bounded(_OPERATORS[self.take()](found, self.level(number + 1)))
        return found

    def signed(self) -> Fraction:
        sign = self.next
        if sign not in ("-", "+", "!"):
            return self.powers()
        self.deeper()
        self.take()
        value = self.signed()
        self.depth -= 1
        return -value if sign == "-" else Fraction(not value) if sign == "!" else value

    def powers(self) -> Fraction:
        """From left to right, as CLHEP does: 2^3^2 is 64."""
        found = self.atom()
        while self.next in ("^", "**"):
            self.take()
            sign = -1 if self.next == "-" else 1
            if self.next in ("-", "+"):
                self.take()
            found = _bounded(power(found, sign * self.atom()))
        return found

    def atom(self) -> Fraction:
        token = self.take()
        if token == "(":
            self.deeper()
            found = self.level(0)
            self.expect(")")
            self.depth -= 1
            return found
        if token[:1].isdigit() or token[:1] == ".":
            return number(token)
        if token[:1].isalpha() or token[:1] == "_":
            return self.call(token) if self.next == "(" else self.names[token]
        raise ExpressionError("ends too early" if not token else f"has {token!r} where a number should be")

    def call(self, name: str) -> Fraction:
        if name not in _FUNCTIONS:
            raise ExpressionError(f"calls {name!r}; functions are {', '.join(_FUNCTIONS)}")
        count, function = _FUNCTIONS[name]
        self.expect("(")
        self.deeper()
        values = [self.level(0)]
        while self.next == ",":
            self.take()
            values.append(self.level(0))
        self.expect(")")
        self.depth -= 1
        if len(values) != count:
            raise ExpressionError(f"gives {name} {len(values)} numbers in place of {count}")
        return _bounded(function(*values))

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            raise ExpressionError(f"nests deeper than {DEEPEST} levels")


_OPERATORS: dict[str, Callable[[Fraction, Fraction], Fraction]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
    "<": lambda a, b: Fraction(a < b), "<=": lambda a, b: Fraction(a <= b), ">": lambda a, b: Fraction(a > b),
    ">=": lambda a, b: Fraction(a >= b), "==": lambda a, b: Fraction(a == b), "!=": lambda a, b: Fraction(a != b),
    "&&": lambda a, b: Fraction(bool(a) and bool(b)), "||": lambda a, b: Fraction(bool(a) or bool(b)),
}  # fmt: skip


def _tokens(text: str) -> list[str]:
    found, at = [], 0
    stripped = text.strip()
    while at < len(stripped):
        match = _TOKEN.match(stripped, at)
        if match is None:
            raise ExpressionError(f"has {stripped[at : at + 20].strip()!r} in it")
        found.append(match[1] or match[2] or match[3])
        at = match.end()
    return found


def number(token: str) -> Fraction:
    """A number as written; one that no float can hold is refused."""
    if abs(float(token)) > 1e300:
        raise ExpressionError("has a number above 1e300")
    _, _, exponent = token.lower().partition("e")
    if exponent and abs(int(exponent)) > 340:
        return Fraction(0)
    return Fraction(token)


def _bounded(value: Fraction) -> Fraction:
    if value.numerator.bit_length() <= _BITS and value.denominator.bit_length() <= _BITS:
        return value
    return Fraction(float(value))
