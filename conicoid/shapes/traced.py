"""Formulas recorded while they are worked out, to be worked out again for many other bodies (`engine.tapes`).

`Plain` and `Wide` are a float and a number of 3000 bits that remember by which operation they came about. What is made
of them is recorded on a `recorder.Tape`; what is made of other numbers alone is a constant of it. A test of a value is
recorded with its outcome, as the line of operations goes on from there for bodies where it turns out alike. Whatever
else looks at a value (`float`, `math.frexp`, a dictionary) gets a TypeError, and there is no tape of that formula.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
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

    def _one(self, which: str, work: Callable[[float], float]) -> Plain:
        """What an operation gives, worked out where that was not done before."""
        made: Plain | None = self.tape.made(which, self.register)
        return self.tape.plain(which, work(self.value), self.register) if made is None else made

    def _both(self, which: str, work: Callable[[float, float], float], a: Any, b: Any) -> Plain:
        """The same of two."""
        first, second = self.tape.plain_of(a), self.tape.plain_of(b)
        made: Plain | None = self.tape.made(which, first.register, second.register)
        if made is None:
            return self.tape.plain(which, work(first.value, second.value), first.register, second.register)
        return made

    def __add__(self, other: Any) -> Any:
        return self._both("plain add", operator.add, self, other) if _is_plain(other) else self.exact() + other

    def __radd__(self, other: Any) -> Any:
        return self._both("plain add", operator.add, other, self) if _is_plain(other) else other + self.exact()

    def __sub__(self, other: Any) -> Any:
        return self._both("plain subtract", operator.sub, self, other) if _is_plain(other) else self.exact() - other

    def __rsub__(self, other: Any) -> Any:
        return self._both("plain subtract", operator.sub, other, self) if _is_plain(other) else other - self.exact()

    def __mul__(self, other: Any) -> Any:
        return self._both("plain multiply", operator.mul, self, other) if _is_plain(other) else self.exact() * other

    def __rmul__(self, other: Any) -> Any:
        return self._both("plain multiply", operator.mul, other, self) if _is_plain(other) else other * self.exact()

    def __truediv__(self, other: Any) -> Any:
        return self._both("plain divide", operator.truediv, self, other) if _is_plain(other) else self.exact() / other

    def __rtruediv__(self, other: Any) -> Any:
        return self._both("plain divide", operator.truediv, other, self) if _is_plain(other) else other / self.exact()

    def __neg__(self) -> Plain:
        return self._one("plain negate", operator.neg)

    def __abs__(self) -> Plain:
        return self._one("plain size", abs)

    def _is(self, expected: int) -> bool:
        return self.tape.test("plain sign", self.register, _sign(self.value), expected)

    def exact(self) -> Wide:
        """The same as a number of many digits."""
        made: Wide | None = self.tape.made("widen", self.register)
        return self.tape.wide("widen", exact(self.value), self.register) if made is None else made

    def rounded(self) -> Plain:
        return self

    def root(self) -> Any:
        """The square root, rounded."""
        return self._one("plain root", math.sqrt)

    def above(self) -> Any:
        """The next float above."""
        return self._one("above", _next)

    def above_if(self, lost: Any) -> Any:
        """The next float above where what was lost is positive, else itself."""
        return self._both("above if", lambda value, less: _next(value) if less > 0 else value, self, lost)

    def larger(self, other: Any, first: bool = True) -> Any:
        """The larger of two floats; this one comes first, or second, which counts among zeros."""
        a, b = (self, other) if first else (other, self)
        return self._both("greater", max, a, b)

    def leading(self, other: Any) -> Any:
        """Itself, or another where it is zero."""
        return self._both("leading", lambda value, second: value or second, self, other)

    def unit_sign(self) -> Any:
        """-1 for negative numbers, else 1."""
        return self._one("unit sign", lambda value: -1.0 if value < 0 else 1.0)

    def counted(self, value: Any) -> Any:
        """One more, where the value is not zero."""
        return self._both("count", lambda count, each: count + (1.0 if each else 0.0), self, value)

    def choose(self, then: Any, otherwise: Any) -> Any:
        """The first of two where this is 2 or more, else the second."""
        first, second = self.tape.plain_of(then).register, self.tape.plain_of(otherwise).register
        return self.tape.plain("several", _value(then if self.value >= 2 else otherwise), first, second, self.register)

    def power(self) -> Any:
        """2^n that brings it between 1/2 and 1."""
        return self._one("power", lambda value: math.ldexp(1.0, -math.frexp(value)[1]))

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


def _next(value: float) -> float:
    return math.nextafter(value, math.inf)


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

    __slots__ = ("divisor", "factors", "less", "register", "tape", "value", "whole")

    def __init__(self, tape: Tape, register: int, value: Number) -> None:
        self.tape, self.register, self.value = tape, register, value
        self.whole: Wide | None = None  # of a difference or a quotient, what something was taken from, or divided
        self.less: Any = None
        self.divisor: Any = None
        self.factors: tuple[tuple[Wide, Wide], ...] = ()  # of a product, each with the other one

    @property
    def _unseen(self) -> NoReturn:
        raise TypeError("the digits of a number that is being recorded")

    mantissa = exponent = off = _unseen

    def _one(self, which: str, work: Callable[[Number], Number]) -> Wide:
        """What an operation gives, worked out where that was not done before."""
        made: Wide | None = self.tape.made(which, self.register)
        return self.tape.wide(which, work(self.value), self.register) if made is None else made

    def _both(self, which: str, work: Callable[[Number, Number], Number], a: Number, b: Number) -> Wide:
        """The same of two."""
        first, second = self.tape.wide_of(a), self.tape.wide_of(b)
        made: Wide | None = self.tape.made(which, first.register, second.register)
        if made is None:
            return self.tape.wide(which, work(first.value, second.value), first.register, second.register)
        return made

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
        return self._both("add", operator.add, self, other)

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
        made = self._both("subtract", operator.sub, self, other)
        if isinstance(other, Wide):
            made.whole, made.less = self, other
        return made

    def __rsub__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return -self
        return self._both("subtract", operator.sub, other, self)

    def __mul__(self, other: Any) -> Number:
        other = exact(other)
        if not isinstance(other, Wide):
            if number.is_nothing(other) or other == 1:
                return self if other == 1 else number.ZERO
            if other == -1:
                return -self
        else:
            for ratio, factor in ((self, other), (other, self)):
                if ratio.whole is None:
                    continue
                if factor is ratio.divisor:  # (a / b) b
                    return ratio.whole
                for one, more in factor.factors:
                    if one is ratio.divisor:  # (a / b) (b c)
                        return ratio.whole * more
        made = self._both("multiply", operator.mul, self, other)
        if isinstance(other, Wide):
            made.factors = (self, other), (other, self)
        return made

    __rmul__ = __mul__

    def __pow__(self, power: int) -> Number:
        if power != 2:
            raise TypeError("only squares are recorded")
        return self * self

    def __truediv__(self, other: Any) -> Number:
        other = exact(other)
        if not isinstance(other, Wide) and other == 1:
            return self
        made = self._both("divide", operator.truediv, self, other)
        if isinstance(other, Wide):
            made.whole, made.divisor = self, other
        return made

    def __rtruediv__(self, other: Any) -> Number:
        other = exact(other)
        if number.is_nothing(other):
            return number.ZERO
        return self._both("divide", operator.truediv, other, self)

    def __neg__(self) -> Wide:
        return self._one("negate", operator.neg)

    def __abs__(self) -> Wide:
        return self._one("size", abs)

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
        made: Plain | None = self.tape.made("round", self.register)
        return self.tape.plain("round", float(self.value), self.register) if made is None else made

    def root(self) -> Wide:
        """The square root."""
        return self._one("root", number.sqrt)
