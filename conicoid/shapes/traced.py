"""Formulas recorded while they are worked out, to be worked out again for many other bodies (`engine.tapes`).

`Plain` and `Wide` are a float and a number of 3000 bits that remember by which operation they came about. What is made
of them is recorded on a `Tape`; what is made of other numbers alone is a constant of it. A test of a value is recorded
with its outcome, as the line of operations goes on from there for bodies where it turns out alike. Whatever else looks
at a value (`float`, `math.frexp`, a dictionary) gets a TypeError, and there is no tape of that formula.
"""

from __future__ import annotations

import math
from typing import Any, NoReturn

from . import number
from .number import Number, Symbol, exact

NEGATIVE, ZERO, POSITIVE, NO_NUMBER = 1, 2, 4, 8
"""Signs, of which a test names the ones that are expected."""


class Tape:
    """Operations in the order in which they were asked for, and what they need."""

    def __init__(self) -> None:
        self.code: list[tuple[str, int, int, int, int]] = []  # operation, register written, operands
        self.numbers: dict[bytes, tuple[int, float]] = {}  # floats that are constants, by their bits
        self.constants: dict[tuple[int, int, int], tuple[int, Number]] = {}
        self.written: list[int] = []
        self.wides = self.plains = self.wide_outputs = self.inputs = 0
        self._made: dict[tuple[str, int, int, int], Any] = {}  # what an operation gave: it is not done twice
        self._tested: set[tuple[str, int, int]] = set()

    @property
    def zero(self) -> Plain:
        return self._float(0.0)

    def plain(self, which: str, value: float, a: int = 0, b: int = 0, c: int = 0) -> Plain:
        """What an operation gives, a float."""
        made: Plain | None = self._made.get((which, a, b, c))
        if made is None:
            made = self._made[which, a, b, c] = Plain(self, self.plains, value)
            self.code.append((which, self.plains, a, b, c))
            self.plains += 1
        return made

    def wide(self, which: str, value: Number, a: int = 0, b: int = 0) -> Wide:
        """What an operation gives, a number."""
        made: Wide | None = self._made.get((which, a, b, 0))
        if made is None:
            made = self._made[which, a, b, 0] = Wide(self, self.wides, value)
            self.code.append((which, self.wides, a, b, 0))
            self.wides += 1
        return made

    def made(self, which: str, register: int) -> Any:
        """What an operation has given, if it was done."""
        return self._made.get((which, register, 0, 0))

    def input(self, value: float) -> Plain:
        """The next of a body's numbers, which the tape begins with."""
        self.inputs += 1
        return self.plain("input", value, self.inputs - 1)

    def sine_cosine(self, angle: int, sine: Number, cosine: Number) -> tuple[Wide, Wide]:
        """What the operation gives that fills two registers."""
        made = self.wide("sine and cosine", sine, angle)
        other = self._made.get(("cosine", angle, 0, 0))
        if other is None:
            other = self._made["cosine", angle, 0, 0] = Wide(self, self.wides, cosine)
            self.wides += 1
        return made, other

    def given(self, value: Number, column: int) -> Wide:
        """A number of many digits that a body comes with."""
        return self.wide("given", value, column)

    def test(self, which: str, register: int, sign: int, expected: int) -> bool:
        """Record that the sign is among those expected, or that it is not; which of the two holds now."""
        holds = bool(sign & expected)
        found = expected if holds else 15 - expected
        if (which, register, found) not in self._tested:
            self._tested.add((which, register, found))
            self.code.append((which, 0, register, found, 0))
        return holds

    def write(self, value: Any) -> None:
        """The next output: a float, or one that was recorded."""
        self.written.append(self._float(value).register)

    def write_wide(self, value: Any) -> None:
        """The next output among the numbers of many digits."""
        self.code.append(("write wide", self.wide_outputs, self._number(exact(value)).register, 0, 0))
        self.wide_outputs += 1

    def _float(self, value: Any) -> Plain:
        if isinstance(value, Plain):
            return value
        if isinstance(value, Symbol):
            raise TypeError("a number of many digits where a float is needed")
        value = float(value)
        row, _ = self.numbers.setdefault(value.hex().encode(), (len(self.numbers), value))
        return self.plain("number", value, row)

    def _number(self, value: Number) -> Wide:
        if isinstance(value, Wide):
            return value
        key = value.mantissa, value.exponent, value.off
        row, _ = self.constants.setdefault(key, (len(self.constants), value))
        return self.wide("constant", value, row)


def _sign(x: float) -> int:
    return POSITIVE if x > 0 else NEGATIVE if x < 0 else ZERO if x == 0 else NO_NUMBER


class Plain(Symbol):
    """A float64 of a formula that is being recorded. No `float`, so that nothing can take it for a constant."""

    __slots__ = ("register", "tape", "value")

    def __init__(self, tape: Tape, register: int, value: float) -> None:
        self.tape, self.register, self.value = tape, register, value

    def _both(self, which: str, value: float, a: Any, b: Any) -> Plain:
        return self.tape.plain(which, value, self.tape._float(a).register, self.tape._float(b).register)

    def __add__(self, other: Any) -> Any:
        return (
            self._both("plain add", self.value + _value(other), self, other)
            if _is_plain(other)
            else self.exact() + other
        )

    def __radd__(self, other: Any) -> Any:
        return (
            self._both("plain add", _value(other) + self.value, other, self)
            if _is_plain(other)
            else other + self.exact()
        )

    def __sub__(self, other: Any) -> Any:
        if not _is_plain(other):
            return self.exact() - other
        return self._both("plain subtract", self.value - _value(other), self, other)

    def __rsub__(self, other: Any) -> Any:
        if not _is_plain(other):
            return other - self.exact()
        return self._both("plain subtract", _value(other) - self.value, other, self)

    def __mul__(self, other: Any) -> Any:
        if not _is_plain(other):
            return self.exact() * other
        return self._both("plain multiply", self.value * _value(other), self, other)

    def __rmul__(self, other: Any) -> Any:
        if not _is_plain(other):
            return other * self.exact()
        return self._both("plain multiply", _value(other) * self.value, other, self)

    def __truediv__(self, other: Any) -> Any:
        if not _is_plain(other):
            return self.exact() / other
        return self._both("plain divide", self.value / _value(other), self, other)

    def __rtruediv__(self, other: Any) -> Any:
        if not _is_plain(other):
            return other / self.exact()
        return self._both("plain divide", _value(other) / self.value, other, self)

    def __neg__(self) -> Plain:
        return self.tape.plain("plain negate", -self.value, self.register)

    def __abs__(self) -> Plain:
        return self.tape.plain("plain size", abs(self.value), self.register)

    def _is(self, expected: int) -> bool:
        return self.tape.test("plain sign", self.register, _sign(self.value), expected)

    def __bool__(self) -> bool:
        return not self._is(ZERO)

    def __eq__(self, other: object) -> bool:
        return _compared(self, other, ZERO)

    def __ne__(self, other: object) -> bool:
        return not _compared(self, other, ZERO)

    def __lt__(self, other: Any) -> bool:
        return _compared(self, other, NEGATIVE)

    def __gt__(self, other: Any) -> bool:
        return _compared(self, other, POSITIVE)

    def __le__(self, other: Any) -> bool:
        return _compared(self, other, NEGATIVE | ZERO)

    def __ge__(self, other: Any) -> bool:
        return _compared(self, other, POSITIVE | ZERO)

    __hash__ = None  # type: ignore[assignment]

    def exact(self) -> Wide:
        """The same as a number of many digits."""
        return self.tape.wide("widen", exact(self.value), self.register)

    def rounded(self) -> Plain:
        return self

    def root(self) -> Any:
        """The square root, rounded."""
        return self.tape.plain("plain root", math.sqrt(self.value), self.register)

    def above(self) -> Any:
        """The next float above."""
        return self.tape.plain("above", math.nextafter(self.value, math.inf), self.register)

    def above_if(self, lost: Any) -> Any:
        """The next float above where what was lost is positive, else itself."""
        if _value(lost) > 0:
            return self._both("above if", math.nextafter(self.value, math.inf), self, lost)
        return self._both("above if", self.value, self, lost)

    def larger(self, other: Any, first: bool = True) -> Any:
        """The larger of two floats; this one comes first, or second, which counts among zeros."""
        a, b = (self, other) if first else (other, self)
        return self._both("greater", max(_value(a), _value(b)), a, b)

    def leading(self, other: Any) -> Any:
        """Itself, or another where it is zero."""
        return self._both("leading", self.value or _value(other), self, other)

    def unit_sign(self) -> Any:
        """-1 for negative numbers, else 1."""
        return self.tape.plain("unit sign", -1.0 if self.value < 0 else 1.0, self.register)

    def counted(self, value: Any) -> Any:
        """One more, where the value is not zero."""
        return self._both("count", self.value + (1.0 if _value(value) else 0.0), self, value)

    def choose(self, then: Any, otherwise: Any) -> Any:
        """The first of two where this is 2 or more, else the second."""
        first, second = self.tape._float(then).register, self.tape._float(otherwise).register
        return self.tape.plain("several", _value(then if self.value >= 2 else otherwise), first, second, self.register)

    def power(self) -> Any:
        """2^n that brings it between 1/2 and 1."""
        return self.tape.plain("power", math.ldexp(1.0, -math.frexp(self.value)[1]), self.register)

    def sine_cosine(self) -> tuple[Number, Number]:
        """Of an angle in degrees: constants for multiples of 30, else numbers."""
        degrees = self.value % 360.0
        turn = round(degrees / 30.0) % 12 if 30.0 * round(self.value / 30.0) == self.value else 12
        self.tape.code.append(("turn", 0, self.register, turn, 0))
        s, c = number.sin_cos_degrees(self.value)
        if turn < 12:
            return s, c
        return self.tape.sine_cosine(self.register, s, c)


def _is_plain(value: Any) -> bool:
    return isinstance(value, (Plain, float, int))


def _value(value: Any) -> float:
    return value.value if isinstance(value, Plain) else float(value)


def _compared(a: Any, b: Any, expected: int) -> bool:
    """Is the sign of a - b among those expected?"""
    if isinstance(b, (float, int)) and math.isinf(b):  # what is recorded is finite
        return bool(expected & (NEGATIVE if b > 0 else POSITIVE))
    if not isinstance(b, (float, int, Symbol, Number)) and not hasattr(b, "numerator"):
        return False
    difference = a - b
    return bool(
        difference._is(expected) if isinstance(difference, (Plain, Wide)) else _sign(float(difference)) & expected
    )


class Wide(Number, Symbol):
    """A number of 3000 bits of a formula that is being recorded."""

    __slots__ = ("divisor", "less", "register", "tape", "value", "whole")

    def __init__(self, tape: Tape, register: int, value: Number) -> None:
        self.tape, self.register, self.value = tape, register, value
        self.whole: Wide | None = None  # of a difference or a quotient, what something was taken from, or divided
        self.less: Any = None
        self.divisor: Any = None

    @property
    def _unseen(self) -> NoReturn:
        raise TypeError("the digits of a number that is being recorded")

    mantissa = exponent = off = _unseen

    def _both(self, which: str, value: Number, a: Number, b: Number) -> Wide:
        return self.tape.wide(which, value, self.tape._number(a).register, self.tape._number(b).register)

    def __add__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return self
        if isinstance(other, Wide):
            if self.is_negative_of(other) or other.is_negative_of(self):
                return number.ZERO
            for whole, part in ((self, other), (other, self)):
                if whole.whole is not None and part is whole.less:  # (a - b) + b
                    return whole.whole
        return self._both("add", self.value + _digits(other), self, other)

    def is_negative_of(self, other: Wide) -> bool:
        """Did it come about as that?"""
        return self.tape.made("negate", other.register) is self

    __radd__ = __add__

    def __sub__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return self
        if other is self:
            return number.ZERO
        made = self._both("subtract", self.value - _digits(other), self, other)
        if isinstance(other, Wide):
            made.whole, made.less = self, other
        return made

    def __rsub__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return -self
        return self._both("subtract", _digits(other) - self.value, other, self)

    def __mul__(self, other: Any) -> Number:
        other = exact(other)
        if not isinstance(other, Wide):
            if number.is_nothing(other) or other == 1:
                return self if other == 1 else number.ZERO
            if other == -1:
                return -self
        else:
            for ratio, factor in ((self, other), (other, self)):
                if ratio.whole is not None and factor is ratio.divisor:  # (a / b) b
                    return ratio.whole
        return self._both("multiply", self.value * _digits(other), self, other)

    __rmul__ = __mul__

    def __pow__(self, power: int) -> Number:
        if power != 2:
            raise TypeError("only squares are recorded")
        return self * self

    def __truediv__(self, other: Any) -> Number:
        other = exact(other)
        if not isinstance(other, Wide) and other == 1:
            return self
        made = self._both("divide", self.value / _digits(other), self, other)
        if isinstance(other, Wide):
            made.whole, made.divisor = self, other
        return made

    def __rtruediv__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return number.ZERO
        return self._both("divide", _digits(other) / self.value, other, self)

    def __neg__(self) -> Wide:
        return self.tape.wide("negate", -self.value, self.register)

    def __abs__(self) -> Wide:
        return self.tape.wide("size", abs(self.value), self.register)

    def _is(self, expected: int) -> bool:
        value = self.value
        sign = ZERO if not value else POSITIVE if value.mantissa > 0 else NEGATIVE
        return self.tape.test("sign", self.register, sign, expected)

    def __bool__(self) -> bool:
        return not self._is(ZERO)

    def __eq__(self, other: object) -> bool:
        return _compared(self, other, ZERO)

    def __ne__(self, other: object) -> bool:
        return not _compared(self, other, ZERO)

    def __lt__(self, other: Any) -> bool:
        return _compared(self, other, NEGATIVE)

    def __gt__(self, other: Any) -> bool:
        return _compared(self, other, POSITIVE)

    def __le__(self, other: Any) -> bool:
        return _compared(self, other, NEGATIVE | ZERO)

    def __ge__(self, other: Any) -> bool:
        return _compared(self, other, POSITIVE | ZERO)

    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> NoReturn:
        raise TypeError("a number that is being recorded has no float: number.rounded")

    def exact(self) -> Wide:
        return self

    def settled(self) -> Wide:
        """It is only known better so: what the tape works out is the number itself, within its bounds."""
        self.value = number.settled(self.value)
        return self

    def rounded(self) -> Plain:
        """The nearest float64."""
        return self.tape.plain("round", float(self.value), self.register)

    def root(self) -> Wide:
        """The square root."""
        return self.tape.wide("root", number.sqrt(self.value), self.register)


def _digits(value: Number) -> Number:
    return value.value if isinstance(value, Wide) else value
