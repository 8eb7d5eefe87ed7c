"""Expressions of GDML: sums, products, powers, comparisons and functions of names, in fractions; nothing is executed.

What fractions cannot say, roots and sines, is a float's value. Numbers that become too long are rounded to floats.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

MAX_EXPRESSION_LENGTH, MAX_EXPRESSION_DEPTH = 2000, 50
"""Letters of an expression; brackets within brackets."""
_BITS = 1500

_TOKEN = re.compile(
    r"\s*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([A-Za-z_][\w.:]*)|(\*\*|&&|\|\||[<>=!]=|[-+*/^()<>!,]))", re.ASCII
)

_NUMBER = re.compile(r"\s*(-?)((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)\s*", re.ASCII)


class ExpressionError(ValueError):
    """What is wrong with an expression."""


def _binary_function(function: Callable[[float, float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 2, lambda a, b: Fraction(function(float(a), float(b)))


def _unary_function(function: Callable[[float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 1, lambda a: Fraction(function(float(a)))


def _exact_root(value: Fraction) -> Fraction:
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
    "abs": (1, abs),
    "min": (2, min),
    "max": (2, max),
    "pow": (2, power),
    "sqrt": (1, _exact_root),
    "sin": _unary_function(math.sin),
    "cos": _unary_function(math.cos),
    "tan": _unary_function(math.tan),
    "asin": _unary_function(math.asin),
    "acos": _unary_function(math.acos),
    "atan": _unary_function(math.atan),
    "atan2": _binary_function(math.atan2),
    "sinh": _unary_function(math.sinh),
    "cosh": _unary_function(math.cosh),
    "tanh": _unary_function(math.tanh),
    "exp": _unary_function(math.exp),
    "log": _unary_function(math.log),
    "log10": _unary_function(math.log10),
}

_LEVELS: tuple[tuple[str, ...], ...] = (("||",), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/"))


def evaluate(text: str, names: Mapping[str, Fraction]) -> Fraction:
    """The value of an expression. Raises ExpressionError for what is none, KeyError for an unknown name."""
    if len(text) <= _MAX_PLAIN_LENGTH:  # most are a number or a name
        known = names.get(text)
        if known is None:
            known = _plain_number(text)
        if known is not None:
            return known
    return _ExpressionParser(text, names).value()


_MAX_PLAIN_LENGTH = 40


@lru_cache(1 << 14)
def _plain_number(text: str) -> Fraction | None:
    """The value of a number with a sign perhaps; None for other expressions."""
    found = _NUMBER.fullmatch(text)
    return None if found is None else (-parse_number(found[2]) if found[1] == "-" else parse_number(found[2]))


class _ExpressionParser:
    """Recursive descent, of bounded depth."""

    def __init__(self, text: str, names: Mapping[str, Fraction]) -> None:
        if len(text) > MAX_EXPRESSION_LENGTH:
            raise ExpressionError(f"is longer than {MAX_EXPRESSION_LENGTH:,} letters")
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
            found = _check_size(_OPERATORS[self.take()](found, self.level(number + 1)))
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
            found = _check_size(power(found, sign * self.atom()))
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
            return parse_number(token)
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
        return _check_size(function(*values))

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > MAX_EXPRESSION_DEPTH:
            raise ExpressionError(f"nests deeper than {MAX_EXPRESSION_DEPTH} levels")


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


def parse_number(token: str) -> Fraction:
    """A number as written; one that no float can hold is refused."""
    if abs(float(token)) > 1e300:
        raise ExpressionError("has a number above 1e300")
    _, _, exponent = token.lower().partition("e")
    if exponent and abs(int(exponent)) > 340:
        return Fraction(0)
    return Fraction(token)


def _check_size(value: Fraction) -> Fraction:
    if value.numerator.bit_length() <= _BITS and value.denominator.bit_length() <= _BITS:
        return value
    return Fraction(float(value))


# Names that GDML's expressions know without a definition: units, in mm, ns, MeV and radians, and π.

PI = Fraction("3.14159265358979323846264338327950288")
"""So exact that angles which come back from radians are the floats on paper."""

_MM = {
    "fm": "1e-12", "fermi": "1e-12", "angstrom": "1e-7", "Ang": "1e-7", "nm": "1e-6", "nanometer": "1e-6",
    "um": "1e-3", "micrometer": "1e-3", "mm": "1", "millimeter": "1", "cm": "10", "centimeter": "10", "dm": "100",
    "m": "1000", "meter": "1000", "km": "1e6", "kilometer": "1e6", "in": "25.4", "inch": "25.4",
    "mm2": "1", "cm2": "100", "m2": "1e6", "mm3": "1", "cm3": "1000", "m3": "1e9", "L": "1e6", "dL": "1e5", "cL": "1e4",
    "mL": "1e3", "liter": "1e6", "barn": "1e-22",
}  # fmt: skip
_OTHER_UNITS = {
    "ns": "1", "nanosecond": "1", "ps": "1e-3", "us": "1e3", "ms": "1e6", "s": "1e9", "second": "1e9", "Hz": "1e-9",
    "kHz": "1e-6", "MHz": "1e-3", "eV": "1e-6", "keV": "1e-3", "MeV": "1", "GeV": "1e3", "TeV": "1e6", "PeV": "1e9",
    "electronvolt": "1e-6", "kiloelectronvolt": "1e-3", "megaelectronvolt": "1", "gigaelectronvolt": "1e3",
    "joule": "6.241509074e12", "J": "6.241509074e12", "kelvin": "1", "K": "1", "mole": "1", "mol": "1", "volt": "1e-6",
    "kilovolt": "1e-3", "megavolt": "1", "tesla": "1e-3", "gauss": "1e-7", "kilogauss": "1e-4", "perCent": "0.01",
    "perThousand": "1e-3", "perMillion": "1e-6", "mg": "1e-3", "milligram": "1e-3", "g": "1", "gram": "1", "kg": "1e3",
    "kilogram": "1e3", "pascal": "1", "Pa": "1", "hPa": "100", "kPa": "1e3", "MPa": "1e6", "bar": "1e5",
    "mbar": "100", "atmosphere": "101325", "atm": "101325", "becquerel": "1e-9", "curie": "37",
}  # fmt: skip
"""Pressures in pascal and masses in grams, since only ratios within each count here."""

UNIT_VALUES: dict[str, Fraction] = {name: Fraction(value) for name, value in (_MM | _OTHER_UNITS).items()} | {
    "rad": Fraction(1), "radian": Fraction(1), "mrad": Fraction(1, 1000), "milliradian": Fraction(1, 1000),
    "deg": PI / 180, "degree": PI / 180, "pi": PI, "PI": PI, "twopi": 2 * PI, "TWOPI": 2 * PI, "halfpi": PI / 2,
    "HALFPI": PI / 2, "pi2": PI * PI, "e": Fraction("2.718281828459045235360287"), "g/cm3": Fraction(1, 1000),
}  # fmt: skip


def to_degrees(radians: Fraction) -> Fraction:
    """An angle in degrees; to the float that it is on paper, where it came through radians in double precision."""
    return Fraction(float(radians * 180 / PI))
