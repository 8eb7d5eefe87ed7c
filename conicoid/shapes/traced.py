"""Formulas recorded while they are worked out, to be worked out again for many other bodies (`engine.tapes`).

`Plain` and `Wide` are a float and a number of 3000 bits that remember by which operation they came about. What is made
of them is recorded on a `recorder.Tape`; what is made of other numbers alone is a constant of it. A test of a value is
recorded with its outcome, as the line of operations goes on from there for bodies where it turns out alike. Whatever
else looks at a value (`float`, `math.frexp`, a dictionary) gets a TypeError, and there is no tape of that formula.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

from . import number, sines
from .number import Number, Symbol, exact

if TYPE_CHECKING:
    from .recorder import Tape

NEGATIVE, ZERO, POSITIVE, NO_NUMBER = 1, 2, 4, 8
"""Signs, of which a test names the ones that are expected."""


def _sign(x: float) -> int:
    return POSITIVE if x > 0 else NEGATIVE if x < 0 else ZERO if x == 0 else NO_NUMBER


class _Compared:
    """What both kinds have in common: to compare them is to test the sign of a difference."""

    __slots__ = ()

    def _is(self, expected: int) -> bool:
        """Is its sign among those expected? That is recorded."""
        raise NotImplementedError

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


class Plain(_Compared, Symbol):
    """A float64 of a formula that is being recorded. No `float`, so that nothing can take it for a constant."""

    __slots__ = ("register", "tape", "value")

    def __init__(self, tape: Tape, register: int, value: float) -> None:
        self.tape, self.register, self.value = tape, register, value

    def _both(self, which: str, value: float, a: Any, b: Any) -> Plain:
        return self.tape.plain(which, value, self.tape.plain_of(a).register, self.tape.plain_of(b).register)

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
        first, second = self.tape.plain_of(then).register, self.tape.plain_of(otherwise).register
        return self.tape.plain("several", _value(then if self.value >= 2 else otherwise), first, second, self.register)

    def power(self) -> Any:
        """2^n that brings it between 1/2 and 1."""
        return self.tape.plain("power", math.ldexp(1.0, -math.frexp(self.value)[1]), self.register)

    def sine_cosine(self) -> tuple[Number, Number]:
        """Of an angle in degrees: constants for multiples of 30, else numbers."""
        degrees = self.value % 360.0
        turn = round(degrees / 30.0) % 12 if 30.0 * round(self.value / 30.0) == self.value else 12
        self.tape.code.append(("turn", 0, self.register, turn, 0))
        s, c = sines.sin_cos_degrees(self.value)
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


class Wide(_Compared, Number, Symbol):  # type: ignore[misc]
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
        return self.tape.wide(which, value, self.tape.wide_of(a).register, self.tape.wide_of(b).register)

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
