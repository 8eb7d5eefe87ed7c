"""Parser and evaluator of GDML expressions, in fractions; nothing is executed.

Expressions consist of numbers, names, units, sums, products, powers, comparisons and functions. Results that are no
fractions, such as roots and sines, have the value of a float. Numbers that become too long are rounded to floats.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

MAX_EXPRESSION_LENGTH, MAX_EXPRESSION_DEPTH = 2000, 50
"""Most characters of an expression, and most levels of nested brackets."""
_BITS = 1500
"""Most bits of a numerator or denominator before a result is rounded to a float."""

_TOKEN = re.compile(
    r"\s*+(?:((?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?)|([A-Za-z_][\w.:]*)|(\*\*|&&|\|\||[<>=!]=|[-+*/^()<>!,]))",
    re.ASCII,
)

_NUMBER = re.compile(r"\s*+(-?)((?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d{1,4})?)\s*+", re.ASCII)


class ExpressionError(ValueError):
    """Raised for an invalid expression; its message follows the name of an attribute, as in "z divides by zero"."""


def _binary_function(function: Callable[[float, float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 2, lambda a, b: Fraction(function(float(a), float(b)))


def _unary_function(function: Callable[[float], float]) -> tuple[int, Callable[..., Fraction]]:
    return 1, lambda a: Fraction(function(float(a)))


def _exact_root(value: Fraction) -> Fraction:
    """Return the square root: exact if it is a fraction, else a float's value."""
    if value < 0:
        raise ExpressionError("takes the square root of a negative number")
    # Lengths such as sqrt(2^2) stay whole numbers, and walls that are computed in two ways coincide
    above, below = math.isqrt(value.numerator), math.isqrt(value.denominator)
    if above * above == value.numerator and below * below == value.denominator:
        return Fraction(above, below)
    return Fraction(math.sqrt(value))


def power(base: Fraction, exponent: Fraction) -> Fraction:
    """Return base to the power of exponent, exact for whole exponents up to 64 in size. Raise ExpressionError."""
    # A larger exponent would give a fraction of thousands of digits, from a text of a few
    if exponent.denominator == 1 and abs(exponent) <= 64:
        if not base and exponent < 0:
            raise ExpressionError("divides by zero")
        return base ** int(exponent)
    result = float(base) ** float(exponent)
    if isinstance(result, complex):
        raise ExpressionError("raises a negative number to a broken power")
    return Fraction(result)


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

# Binary operators from the loosest to the tightest binding.
_LEVELS: tuple[tuple[str, ...], ...] = (("||",), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/"))


def evaluate(text: str, names: Mapping[str, Fraction]) -> Fraction:
    """Return the value of an expression.

    Parameters
    ----------
    text
        The expression.
    names
        Values of names, units among them.

    Raises
    ------
    ExpressionError
        The expression is invalid.
    KeyError
        A name is unknown.

    """
    if len(text) <= _MAX_PLAIN_LENGTH:  # most expressions are a number or a name
        value = names.get(text)
        if value is None:
            value = _plain_number(text)
        if value is not None:
            return value
    return _ExpressionParser(text, names).value()


_MAX_PLAIN_LENGTH = 40


@lru_cache(1 << 14)
def _plain_number(text: str) -> Fraction | None:
    """Return the value of a number with or without a minus sign; None for other expressions."""
    match = _NUMBER.fullmatch(text)
    return None if match is None else (-parse_number(match[2]) if match[1] == "-" else parse_number(match[2]))


class _ExpressionParser:
    """A recursive descent parser of bounded depth, which evaluates while it parses."""

    def __init__(self, text: str, names: Mapping[str, Fraction]) -> None:
        if len(text) > MAX_EXPRESSION_LENGTH:
            raise ExpressionError(f"is longer than {MAX_EXPRESSION_LENGTH:,} letters")
        self.names, self.at, self.depth = names, 0, 0
        self.tokens = _tokens(text)

    def value(self) -> Fraction:
        """Return the value of the whole expression. Raise ExpressionError or KeyError."""
        try:
            result = self.level(0)
        except ZeroDivisionError:
            raise ExpressionError("divides by zero") from None
        except (OverflowError, ValueError) as error:
            if isinstance(error, ExpressionError):
                raise
            raise ExpressionError("is no finite number") from None
        if self.at < len(self.tokens):
            raise ExpressionError(f"has {self.tokens[self.at]!r} where it should end or go on with an operator")
        return result

    @property
    def next(self) -> str:
        """The current token; empty at the end."""
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        """Return the current token and go on."""
        token = self.next
        self.at += 1
        return token

    def expect(self, token: str) -> None:
        """Take a token that must follow."""
        if self.take() != token:
            raise ExpressionError(f"lacks a {token!r}")

    def level(self, number: int) -> Fraction:
        """Evaluate the operators of one level of precedence, from left to right."""
        if number == len(_LEVELS):
            return self.signed()
        result = self.level(number + 1)
        while self.next in _LEVELS[number]:
            result = _check_size(_OPERATORS[self.take()](result, self.level(number + 1)))
        return result

    def signed(self) -> Fraction:
        """Evaluate a value after signs and negations."""
        sign = self.next
        # A minus binds looser than a power: -2^2 is -4
        if sign not in ("-", "+", "!"):
            return self.powers()
        self.deeper()
        self.take()
        value = self.signed()
        self.depth -= 1
        return -value if sign == "-" else Fraction(not value) if sign == "!" else value

    def powers(self) -> Fraction:
        """Evaluate powers from left to right, as CLHEP does: 2^3^2 is 64."""
        result = self.atom()
        while self.next in ("^", "**"):
            self.take()
            sign = -1 if self.next == "-" else 1
            if self.next in ("-", "+"):
                self.take()
            result = _check_size(power(result, sign * self.atom()))
        return result

    def atom(self) -> Fraction:
        """Evaluate a number, a name, a call or a bracket."""
        token = self.take()
        if token == "(":
            self.deeper()
            result = self.level(0)
            self.expect(")")
            self.depth -= 1
            return result
        if token[:1].isdigit() or token[:1] == ".":
            return parse_number(token)
        if token[:1].isalpha() or token[:1] == "_":
            return self.call(token) if self.next == "(" else self.names[token]
        raise ExpressionError("ends too early" if not token else f"has {token!r} where a number should be")

    def call(self, name: str) -> Fraction:
        """Evaluate a call of a function."""
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
        # CLHEP tells functions apart by their count of arguments as well
        if len(values) != count:
            raise ExpressionError(f"gives {name} {len(values)} numbers in place of {count}")
        return _check_size(function(*values))

    def deeper(self) -> None:
        """Enter one more level of nesting; the caller leaves it by `depth`."""
        self.depth += 1
        if self.depth > MAX_EXPRESSION_DEPTH:
            raise ExpressionError(f"nests deeper than {MAX_EXPRESSION_DEPTH} levels")


# && and || evaluate both sides, so that an error on either side is an error.
_OPERATORS: dict[str, Callable[[Fraction, Fraction], Fraction]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
    "<": lambda a, b: Fraction(a < b), "<=": lambda a, b: Fraction(a <= b), ">": lambda a, b: Fraction(a > b),
    ">=": lambda a, b: Fraction(a >= b), "==": lambda a, b: Fraction(a == b), "!=": lambda a, b: Fraction(a != b),
    "&&": lambda a, b: Fraction(bool(a) and bool(b)), "||": lambda a, b: Fraction(bool(a) or bool(b)),
}  # fmt: skip


def _tokens(text: str) -> list[str]:
    """Split an expression into tokens. Raise ExpressionError for characters that begin none."""
    tokens, at = [], 0
    stripped = text.strip()
    while at < len(stripped):
        # Numbers before names, so that 2e3 is one number
        match = _TOKEN.match(stripped, at)
        if match is None:
            raise ExpressionError(f"has {stripped[at : at + 20].strip()!r} in it")
        tokens.append(match[1] or match[2] or match[3])
        at = match.end()
    return tokens


def parse_number(token: str) -> Fraction:
    """Return the exact value of a decimal number. Raise ExpressionError above 1e300, as floats end soon after."""
    # Before the fraction is made: 1e999999999 would have a billion digits
    if abs(float(token)) > 1e300:
        raise ExpressionError("has a number above 1e300")
    _, _, exponent = token.lower().partition("e")
    if exponent and abs(int(exponent)) > 340:  # below any float; the fraction would have very many digits
        return Fraction(0)
    return Fraction(token)


def _check_size(value: Fraction) -> Fraction:
    """Return the value, rounded to a float if it has more than `_BITS` bits, so that expressions take bounded time."""
    if value.numerator.bit_length() <= _BITS and value.denominator.bit_length() <= _BITS:
        return value
    return Fraction(float(value))


# Predefined names: units, in mm, ns, MeV and radians, and π

PI = Fraction("3.14159265358979323846264338327950288")
"""Precise enough that degrees converted to radians and back are the same floats."""

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
"""Pressures in pascal and masses in grams: only ratios within each matter here."""

# CLHEP's system of units, that of Geant4, but for the gram, which is 1: mm, ns, MeV, positron charge, kelvin, mole,
# radian
UNIT_VALUES: dict[str, Fraction] = {name: Fraction(value) for name, value in (_MM | _OTHER_UNITS).items()} | {
    "rad": Fraction(1), "radian": Fraction(1), "mrad": Fraction(1, 1000), "milliradian": Fraction(1, 1000),
    "deg": PI / 180, "degree": PI / 180, "pi": PI, "PI": PI, "twopi": 2 * PI, "TWOPI": 2 * PI, "halfpi": PI / 2,
    "HALFPI": PI / 2, "pi2": PI * PI, "e": Fraction("2.718281828459045235360287"), "g/cm3": Fraction(1, 1000),
}  # fmt: skip


def to_degrees(radians: Fraction) -> Fraction:
    """Return an angle in degrees: as it is if it was written in degrees or in parts of π, else rounded to a float.

    The float is the one that was converted to radians, if one was.
    """
    degrees = radians * 180 / PI
    rounded = Fraction(float(degrees))
    # Sums of angles that are fractions are rounded once, so that walls which coincide on paper get one angle
    return degrees if degrees.denominator < _LEAST_OF_PI else rounded


_LEAST_OF_PI = 1 << 64
"""Degrees with a larger denominator have the digits of π in it: they were written in radians."""
