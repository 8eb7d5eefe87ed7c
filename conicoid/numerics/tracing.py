"""Formulas recorded while they are worked out, to be worked out again for many other bodies (`engine.tapes`).

`Plain` and `Wide` are a float and a number of 3000 bits that remember by which operation they came about. What is made
of them is recorded on a `recorder.Tape`; what is made of other numbers alone is a constant of it. A test of a value is
recorded with its outcome, as the line of operations goes on from there for bodies where it turns out alike. Whatever
else looks at a value (`float`, `math.frexp`, a dictionary) gets a TypeError, and there is no tape of that formula.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable
from typing import Any, NoReturn

from . import bigfloat
from .bigfloat import BigFloat, Symbol, exact

NEGATIVE, ZERO, POSITIVE, NO_NUMBER = 1, 2, 4, 8
"""Signs, of which a test names the ones that are expected."""


def _sign(x: float) -> int:
    return POSITIVE if x > 0 else NEGATIVE if x < 0 else ZERO if x == 0 else NO_NUMBER


class _TracedComparison:
    """What both kinds have in common: to compare them is to test the sign of a difference."""

    __slots__ = ()

    def _is(self, expected: int) -> bool:
        """Is its sign among those expected? That is recorded."""
        raise NotImplementedError

    def __bool__(self) -> bool:
        return not self._is(ZERO)

    def __eq__(self, other: object) -> bool:
        return _trace_comparison(self, other, ZERO)

    def __ne__(self, other: object) -> bool:
        return not _trace_comparison(self, other, ZERO)

    def __lt__(self, other: Any) -> bool:
        return _trace_comparison(self, other, NEGATIVE)

    def __gt__(self, other: Any) -> bool:
        return _trace_comparison(self, other, POSITIVE)

    def __le__(self, other: Any) -> bool:
        return _trace_comparison(self, other, NEGATIVE | ZERO)

    def __ge__(self, other: Any) -> bool:
        return _trace_comparison(self, other, POSITIVE | ZERO)

    __hash__ = None  # type: ignore[assignment]


class TracedFloat(_TracedComparison, Symbol):
    """A float64 of a formula that is being recorded. No `float`, so that nothing can take it for a constant."""

    __slots__ = ("register", "tape", "value")

    def __init__(self, tape: Tape, register: int, value: float) -> None:
        self.tape, self.register, self.value = tape, register, value

    def _one(self, which: str, work: Callable[[float], float]) -> TracedFloat:
        """What an operation gives, worked out where that was not done before."""
        made: TracedFloat | None = self.tape.made(which, self.register)
        return self.tape.plain(which, work(self.value), self.register) if made is None else made

    def _both(self, which: str, work: Callable[[float, float], float], a: Any, b: Any) -> TracedFloat:
        """The same of two."""
        first, second = self.tape.plain_of(a), self.tape.plain_of(b)
        made: TracedFloat | None = self.tape.made(which, first.register, second.register)
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

    def __neg__(self) -> TracedFloat:
        return self._one("plain negate", operator.neg)

    def __abs__(self) -> TracedFloat:
        return self._one("plain size", abs)

    def _is(self, expected: int) -> bool:
        return self.tape.test("plain sign", self.register, _sign(self.value), expected)

    def exact(self) -> TracedBig:
        """The same as a number of many digits."""
        made: TracedBig | None = self.tape.made("widen", self.register)
        return self.tape.wide("widen", exact(self.value), self.register) if made is None else made

    def rounded(self) -> TracedFloat:
        return self

    def root(self) -> Any:
        """The square root, rounded."""
        return self._one("plain root", math.sqrt)

    def above(self) -> Any:
        """The next float above."""
        return self._one("above", _next_above)

    def above_if(self, lost: Any) -> Any:
        """The next float above where what was lost is positive, else itself."""
        return self._both("above if", lambda value, less: _next_above(value) if less > 0 else value, self, lost)

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

    def sine_cosine(self) -> tuple[BigFloat, BigFloat]:
        """Of an angle in degrees: constants for multiples of 30, else numbers."""
        degrees = self.value % 360.0
        turn = round(degrees / 30.0) % 12 if 30.0 * round(self.value / 30.0) == self.value else 12
        self.tape.code.append(("turn", 0, self.register, turn, 0))
        s, c = bigfloat.sin_cos_degrees(self.value)
        if turn < 12:
            return s, c
        return self.tape.sine_cosine(self.register, s, c)


def _is_plain(value: Any) -> bool:
    return isinstance(value, (TracedFloat, float, int))


def _value(value: Any) -> float:
    return value.value if isinstance(value, TracedFloat) else float(value)


def _next_above(value: float) -> float:
    return math.nextafter(value, math.inf)


def _trace_comparison(a: Any, b: Any, expected: int) -> bool:
    """Is the sign of a - b among those expected?"""
    if isinstance(b, (float, int)) and math.isinf(b):  # what is recorded is finite
        return bool(expected & (NEGATIVE if b > 0 else POSITIVE))
    if not isinstance(b, (float, int, Symbol, BigFloat)) and not hasattr(b, "numerator"):
        return False
    difference = a - b
    return bool(
        difference._is(expected)
        if isinstance(difference, (TracedFloat, TracedBig))
        else _sign(float(difference)) & expected
    )


class TracedBig(_TracedComparison, BigFloat, Symbol):  # type: ignore[misc]
    """A number of 3000 bits of a formula that is being recorded."""

    __slots__ = ("divisor", "factors", "less", "register", "tape", "value", "whole")

    def __init__(self, tape: Tape, register: int, value: BigFloat) -> None:
        self.tape, self.register, self.value = tape, register, value
        self.whole: TracedBig | None = None  # of a difference or a quotient, what something was taken from, or divided
        self.less: Any = None
        self.divisor: Any = None
        self.factors: tuple[tuple[TracedBig, TracedBig], ...] = ()  # of a product, each with the other one

    @property
    def _unseen(self) -> NoReturn:
        raise TypeError("the digits of a number that is being recorded")

    mantissa = exponent = off = _unseen

    def _one(self, which: str, work: Callable[[BigFloat], BigFloat]) -> TracedBig:
        """What an operation gives, worked out where that was not done before."""
        made: TracedBig | None = self.tape.made(which, self.register)
        return self.tape.wide(which, work(self.value), self.register) if made is None else made

    def _both(self, which: str, work: Callable[[BigFloat, BigFloat], BigFloat], a: BigFloat, b: BigFloat) -> TracedBig:
        """The same of two."""
        first, second = self.tape.wide_of(a), self.tape.wide_of(b)
        made: TracedBig | None = self.tape.made(which, first.register, second.register)
        if made is None:
            return self.tape.wide(which, work(first.value, second.value), first.register, second.register)
        return made

    def __add__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return self
        if isinstance(other, TracedBig):
            if self.is_negative_of(other) or other.is_negative_of(self):
                return bigfloat.ZERO
            for whole, part in ((self, other), (other, self)):
                if whole.whole is not None and part is whole.less:  # (a - b) + b
                    return whole.whole
        return self._both("add", operator.add, self, other)

    def is_negative_of(self, other: TracedBig) -> bool:
        """Did it come about as that?"""
        return self.tape.made("negate", other.register) is self

    __radd__ = __add__

    def __sub__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return self
        if other is self:
            return bigfloat.ZERO
        made = self._both("subtract", operator.sub, self, other)
        if isinstance(other, TracedBig):
            made.whole, made.less = self, other
        return made

    def __rsub__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return -self
        return self._both("subtract", operator.sub, other, self)

    def __mul__(self, other: Any) -> BigFloat:
        other = exact(other)
        if not isinstance(other, TracedBig):
            if bigfloat.is_nothing(other) or other == 1:
                return self if other == 1 else bigfloat.ZERO
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
        if isinstance(other, TracedBig):
            made.factors = (self, other), (other, self)
        return made

    __rmul__ = __mul__

    def __pow__(self, power: int) -> BigFloat:
        if power != 2:
            raise TypeError("only squares are recorded")
        return self * self

    def __truediv__(self, other: Any) -> BigFloat:
        other = exact(other)
        if not isinstance(other, TracedBig) and other == 1:
            return self
        made = self._both("divide", operator.truediv, self, other)
        if isinstance(other, TracedBig):
            made.whole, made.divisor = self, other
        return made

    def __rtruediv__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return bigfloat.ZERO
        return self._both("divide", operator.truediv, other, self)

    def __neg__(self) -> TracedBig:
        return self._one("negate", operator.neg)

    def __abs__(self) -> TracedBig:
        return self._one("size", abs)

    def _is(self, expected: int) -> bool:
        value = self.value
        sign = ZERO if not value else POSITIVE if value.mantissa > 0 else NEGATIVE
        return self.tape.test("sign", self.register, sign, expected)

    def __float__(self) -> NoReturn:
        raise TypeError("a number that is being recorded has no float: number.rounded")

    def exact(self) -> TracedBig:
        return self

    def settled(self) -> TracedBig:
        """It is only known better so: what the tape works out is the number itself, within its bounds."""
        self.value = bigfloat.settled(self.value)
        return self

    def rounded(self) -> TracedFloat:
        """The nearest float64."""
        made: TracedFloat | None = self.tape.made("round", self.register)
        return self.tape.plain("round", float(self.value), self.register) if made is None else made

    def root(self) -> TracedBig:
        """The square root."""
        return self._one("root", bigfloat.sqrt)


# The tape that a formula is recorded on while it is worked out by the numbers of `traced`.

_BITS = struct.Struct("d").pack
Operation = tuple[str, int, int, int, int]
"""Which, the register written, operands."""


class Tape:
    """Operations in the order in which they were asked for, and what they need."""

    def __init__(self) -> None:
        self.code: list[Operation] = []
        self.wide_makers: list[int] = []  # of each register of a kind, the place of the operation that writes it
        self.plain_makers: list[int] = []
        self.numbers: dict[bytes, tuple[int, float]] = {}  # floats that are constants, by their bits
        self.constants: dict[tuple[int, int, int], tuple[int, BigFloat]] = {}
        self.written: list[int] = []
        self.wide_outputs = self.inputs = 0
        self._made: dict[tuple[str, int, int, int], Any] = {}  # what an operation gave: it is not done twice
        self._tested: set[tuple[str, int, int]] = set()

    @property
    def wides(self) -> int:
        """How many registers there are for numbers of many digits."""
        return len(self.wide_makers)

    @property
    def plains(self) -> int:
        """How many registers there are for floats."""
        return len(self.plain_makers)

    @property
    def zero(self) -> TracedFloat:
        return self.plain_of(0.0)

    def plain(self, which: str, value: float, a: int = 0, b: int = 0, c: int = 0) -> TracedFloat:
        """What an operation gives, a float."""
        made: TracedFloat | None = self._made.get((which, a, b, c))
        if made is None:
            register = len(self.plain_makers)
            made = self._made[which, a, b, c] = TracedFloat(self, register, value)
            self.plain_makers.append(len(self.code))
            self.code.append((which, register, a, b, c))
        return made

    def wide(self, which: str, value: BigFloat, a: int = 0, b: int = 0) -> TracedBig:
        """What an operation gives, a number."""
        made: TracedBig | None = self._made.get((which, a, b, 0))
        if made is None:
            register = len(self.wide_makers)
            made = self._made[which, a, b, 0] = TracedBig(self, register, value)
            self.wide_makers.append(len(self.code))
            self.code.append((which, register, a, b, 0))
        return made

    def made(self, which: str, a: int, b: int = 0) -> Any:
        """What an operation has given, if it was done."""
        return self._made.get((which, a, b, 0))

    def input(self, value: float) -> TracedFloat:
        """The next of a body's numbers, which the tape begins with."""
        self.inputs += 1
        return self.plain("input", value, self.inputs - 1)

    def sine_cosine(self, angle: int, sine: BigFloat, cosine: BigFloat) -> tuple[TracedBig, TracedBig]:
        """What the operation gives that fills two registers."""
        made = self.wide("sine and cosine", sine, angle)
        other = self._made.get(("cosine", angle, 0, 0))
        if other is None:
            other = self._made["cosine", angle, 0, 0] = TracedBig(self, len(self.wide_makers), cosine)
            self.wide_makers.append(len(self.code) - 1)
        return made, other

    def given(self, value: BigFloat, column: int) -> TracedBig:
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
        self.written.append(self.plain_of(value).register)

    def write_wide(self, value: Any) -> None:
        """The next output among the numbers of many digits."""
        self.code.append(("write wide", self.wide_outputs, self.wide_of(exact(value)).register, 0, 0))
        self.wide_outputs += 1

    def plain_of(self, value: Any) -> TracedFloat:
        """A float, as one of the tape's own."""
        if isinstance(value, TracedFloat):
            return value
        if isinstance(value, Symbol):
            raise TypeError("a number of many digits where a float is needed")
        value = float(value)
        row, _ = self.numbers.setdefault(_BITS(value), (len(self.numbers), value))
        return self.plain("number", value, row)

    def wide_of(self, value: BigFloat) -> TracedBig:
        """A number of many digits, as one of the tape's own."""
        if isinstance(value, TracedBig):
            return value
        key = value.mantissa, value.exponent, value.off
        row, _ = self.constants.setdefault(key, (len(self.constants), value))
        return self.wide("constant", value, row)
