"""Tracing of formulas: a formula is recorded once on a `Tape`, which is then played for many other bodies.

`TracedFloat` and `TracedBig` are a float and a number of 3000 bits that remember the operation of their origin.
Results of them are recorded on the tape; results of other numbers alone are constants of it. A test of a value is
recorded with its outcome, as the following operations hold for bodies with the same outcome. Any other use of a value
(`float`, `math.frexp`, a dictionary) raises TypeError, and that formula has no tape. `prepare/tape` plays tapes.
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
"""Signs, as bits: a test has a set of expected ones."""


def _sign(x: float) -> int:
    """Return the sign of a float as one of these bits."""
    return POSITIVE if x > 0 else NEGATIVE if x < 0 else ZERO if x == 0 else NO_NUMBER


class _TracedComparison:
    """Comparisons of both kinds of numbers: each is a test of the sign of a difference."""

    __slots__ = ()

    def _is(self, expected: int) -> bool:
        """Record and return whether the sign is among the expected ones."""
        raise NotImplementedError

    def __bool__(self) -> bool:
        return not self._is(ZERO)

    def __eq__(self, other: object) -> bool:
        return _trace_comparison(self, other, ZERO)

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
    """A float64 of a recorded formula. It is no `float`, so that nothing can take it for a constant."""

    __slots__ = ("register", "tape", "value")

    def __init__(self, tape: Tape, register: int, value: float) -> None:
        self.tape, self.register, self.value = tape, register, value

    def _one(self, which: str, work: Callable[[float], float]) -> TracedFloat:
        """Return the result of an operation; compute and record it if it is new."""
        result: TracedFloat | None = self.tape.recorded_result(which, self.register)
        return self.tape.plain(which, work(self.value), self.register) if result is None else result

    def _binary(self, which: str, work: Callable[[float, float], float], a: Any, b: Any) -> TracedFloat:
        """Return the result of an operation with two operands."""
        first, second = self.tape.plain_of(a), self.tape.plain_of(b)
        result: TracedFloat | None = self.tape.recorded_result(which, first.register, second.register)
        if result is None:
            return self.tape.plain(which, work(first.value, second.value), first.register, second.register)
        return result

    def __add__(self, other: Any) -> Any:
        return self._binary("plain add", operator.add, self, other) if _is_plain(other) else self.exact() + other

    def __radd__(self, other: Any) -> Any:
        return self._binary("plain add", operator.add, other, self) if _is_plain(other) else other + self.exact()

    def __sub__(self, other: Any) -> Any:
        return self._binary("plain subtract", operator.sub, self, other) if _is_plain(other) else self.exact() - other

    def __rsub__(self, other: Any) -> Any:
        return self._binary("plain subtract", operator.sub, other, self) if _is_plain(other) else other - self.exact()

    def __mul__(self, other: Any) -> Any:
        return self._binary("plain multiply", operator.mul, self, other) if _is_plain(other) else self.exact() * other

    def __rmul__(self, other: Any) -> Any:
        return self._binary("plain multiply", operator.mul, other, self) if _is_plain(other) else other * self.exact()

    def __truediv__(self, other: Any) -> Any:
        return self._binary("plain divide", operator.truediv, self, other) if _is_plain(other) else self.exact() / other

    def __rtruediv__(self, other: Any) -> Any:
        return self._binary("plain divide", operator.truediv, other, self) if _is_plain(other) else other / self.exact()

    def __neg__(self) -> TracedFloat:
        return self._one("plain negate", operator.neg)

    def __abs__(self) -> TracedFloat:
        return self._one("plain size", abs)

    def _is(self, expected: int) -> bool:
        return self.tape.test("plain sign", self.register, _sign(self.value), expected)

    def exact(self) -> TracedBig:
        """Return the same number as a `TracedBig`."""
        result: TracedBig | None = self.tape.recorded_result("widen", self.register)
        return self.tape.wide("widen", exact(self.value), self.register) if result is None else result

    def rounded(self) -> TracedFloat:
        return self

    def root(self) -> Any:
        """Return the square root, rounded."""
        return self._one("plain root", math.sqrt)

    def above(self) -> Any:
        """Return the next float above."""
        return self._one("above", _next_above)

    def above_if(self, lost: Any) -> Any:
        """Return the next float above if the loss is positive, else the number itself."""
        return self._binary("above if", lambda value, less: _next_above(value) if less > 0 else value, self, lost)

    def larger(self, other: Any, first: bool = True) -> Any:
        """Return the larger of two floats; `first` is their order, which matters for signed zeros."""
        a, b = (self, other) if first else (other, self)
        return self._binary("greater", max, a, b)

    def leading(self, other: Any) -> Any:
        """Return the number itself, or another one if it is zero."""
        return self._binary("leading", lambda value, second: value or second, self, other)

    def unit_sign(self) -> Any:
        """Return -1 for negative numbers, else 1."""
        return self._one("unit sign", lambda value: -1.0 if value < 0 else 1.0)

    def counted(self, value: Any) -> Any:
        """Return one more if the value is not zero."""
        return self._binary("count", lambda count, each: count + (1.0 if each else 0.0), self, value)

    def choose(self, then: Any, otherwise: Any) -> Any:
        """Return the first of two numbers if this is 2 or more, else the second."""
        first, second = self.tape.plain_of(then).register, self.tape.plain_of(otherwise).register
        return self.tape.plain("several", _value(then if self.value >= 2 else otherwise), first, second, self.register)

    def power(self) -> Any:
        """Return 2^n that brings the number between 1/2 and 1."""
        return self._one("power", lambda value: math.ldexp(1.0, -math.frexp(value)[1]))

    def sine_cosine(self) -> tuple[BigFloat, BigFloat]:
        """Return sine and cosine of an angle in degrees: constants for multiples of 30, else numbers."""
        degrees = self.value % 360.0
        turn = round(degrees / 30.0) % 12 if 30.0 * round(self.value / 30.0) == self.value else 12
        # A test: the recording holds for angles that are the same multiple of 30, or none.
        self.tape.code.append(("turn", 0, self.register, turn, 0))
        s, c = bigfloat.sin_cos_degrees(self.value)
        if turn < 12:
            return s, c
        return self.tape.sine_cosine(self.register, s, c)


def _is_plain(value: Any) -> bool:
    """Return whether a value is a float, recorded or not."""
    return isinstance(value, (TracedFloat, float, int))


def _value(value: Any) -> float:
    """Return the value of a float, recorded or not."""
    return value.value if isinstance(value, TracedFloat) else float(value)


def _next_above(value: float) -> float:
    """Return the next float above."""
    return math.nextafter(value, math.inf)


def _trace_comparison(a: Any, b: Any, expected: int) -> bool:
    """Return whether the sign of a - b is among the expected ones."""
    if isinstance(b, (float, int)) and math.isinf(b):  # recorded numbers are finite
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
    """A number of 3000 bits of a recorded formula."""

    __slots__ = ("divisor", "factors", "less", "register", "tape", "value", "whole")

    def __init__(self, tape: Tape, register: int, value: BigFloat) -> None:
        self.tape, self.register, self.value = tape, register, value
        # Operands of the last operation, so that (a - b) + b is a, and (a / b) b as well: no cancellation is recorded.
        self.whole: TracedBig | None = None  # the minuend of a difference, or the dividend of a quotient
        self.less: Any = None  # the subtrahend
        self.divisor: Any = None
        self.factors: tuple[tuple[TracedBig, TracedBig], ...] = ()  # of a product, each with the other one

    @property
    def _unseen(self) -> NoReturn:
        """Raise TypeError: a recorded formula must not depend on digits."""
        raise TypeError("a recorded number has no digits")

    mantissa = exponent = off = _unseen

    def _one(self, which: str, work: Callable[[BigFloat], BigFloat]) -> TracedBig:
        """Return the result of an operation; compute and record it if it is new."""
        result: TracedBig | None = self.tape.recorded_result(which, self.register)
        return self.tape.wide(which, work(self.value), self.register) if result is None else result

    def _binary(
        self, which: str, work: Callable[[BigFloat, BigFloat], BigFloat], a: BigFloat, b: BigFloat
    ) -> TracedBig:
        """Return the result of an operation with two operands."""
        first, second = self.tape.wide_of(a), self.tape.wide_of(b)
        result: TracedBig | None = self.tape.recorded_result(which, first.register, second.register)
        if result is None:
            return self.tape.wide(which, work(first.value, second.value), first.register, second.register)
        return result

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
        return self._binary("add", operator.add, self, other)

    def is_negative_of(self, other: TracedBig) -> bool:
        """Return whether the number was made as the negative of another."""
        return self.tape.recorded_result("negate", other.register) is self

    __radd__ = __add__

    def __sub__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return self
        # x - x is 0 on paper, whatever the value.
        if other is self:
            return bigfloat.ZERO
        result = self._binary("subtract", operator.sub, self, other)
        if isinstance(other, TracedBig):
            result.whole, result.less = self, other
        return result

    def __rsub__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return -self
        return self._binary("subtract", operator.sub, other, self)

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
        result = self._binary("multiply", operator.mul, self, other)
        if isinstance(other, TracedBig):
            result.factors = (self, other), (other, self)
        return result

    __rmul__ = __mul__

    def __pow__(self, power: int) -> BigFloat:
        if power != 2:
            raise TypeError("only squares are recorded")
        return self * self

    def __truediv__(self, other: Any) -> BigFloat:
        other = exact(other)
        if not isinstance(other, TracedBig) and other == 1:
            return self
        result = self._binary("divide", operator.truediv, self, other)
        if isinstance(other, TracedBig):
            result.whole, result.divisor = self, other
        return result

    def __rtruediv__(self, other: Any) -> BigFloat:
        other = exact(other)
        if bigfloat.is_nothing(other):
            return bigfloat.ZERO
        return self._binary("divide", operator.truediv, other, self)

    def __neg__(self) -> TracedBig:
        return self._one("negate", operator.neg)

    def __abs__(self) -> TracedBig:
        return self._one("size", abs)

    def _is(self, expected: int) -> bool:
        value = self.value
        sign = ZERO if not value else POSITIVE if value.mantissa > 0 else NEGATIVE
        return self.tape.test("sign", self.register, sign, expected)

    def __float__(self) -> NoReturn:
        raise TypeError("a recorded number has no float: use bigfloat.rounded")

    def exact(self) -> TracedBig:
        return self

    def settled(self) -> TracedBig:
        """Return the number with its value settled; the tape stays as it is, since it computes with bounds."""
        self.value = bigfloat.settled(self.value)
        return self

    def rounded(self) -> TracedFloat:
        """Return the nearest float64."""
        result: TracedFloat | None = self.tape.recorded_result("round", self.register)
        return self.tape.plain("round", float(self.value), self.register) if result is None else result

    def ball(self, radius: BigFloat) -> BigFloat:
        return self._binary("ball", bigfloat.ball, self, exact(radius))

    def root(self) -> TracedBig:
        """Return the square root."""
        return self._one("root", bigfloat.sqrt)


# The tape of a formula. It is written while the formula is computed with traced numbers.

_BITS = struct.Struct("d").pack
Operation = tuple[str, int, int, int, int]
"""The operation's name, the register of its result, operands."""


class Tape:
    """The operations of a formula in their order, and their constants."""

    def __init__(self) -> None:
        self.code: list[Operation] = []
        self.wide_makers: list[int] = []  # for each register of a kind, the place of the operation that writes it
        self.plain_makers: list[int] = []
        self.numbers: dict[bytes, tuple[int, float]] = {}  # constant floats by their bits, as -0 and 0 differ
        self.constants: dict[tuple[int, int, int], tuple[int, BigFloat]] = {}
        self.written: list[int] = []
        self.wide_outputs = self.inputs = 0
        self._results: dict[tuple[str, int, int, int], Any] = {}  # results of operations: none is recorded twice
        self._tested: set[tuple[str, int, int]] = set()

    @property
    def wides(self) -> int:
        """Number of registers for numbers of 3000 bits."""
        return len(self.wide_makers)

    @property
    def plains(self) -> int:
        """Number of registers for floats."""
        return len(self.plain_makers)

    @property
    def zero(self) -> TracedFloat:
        """The constant 0."""
        return self.plain_of(0.0)

    def plain(self, which: str, value: float, a: int = 0, b: int = 0, c: int = 0) -> TracedFloat:
        """Record an operation, unless it is known. Return its result, a float."""
        result: TracedFloat | None = self._results.get((which, a, b, c))
        if result is None:
            register = len(self.plain_makers)
            result = self._results[which, a, b, c] = TracedFloat(self, register, value)
            self.plain_makers.append(len(self.code))
            self.code.append((which, register, a, b, c))
        return result

    def wide(self, which: str, value: BigFloat, a: int = 0, b: int = 0) -> TracedBig:
        """Record an operation, unless it is known. Return its result, a number of 3000 bits."""
        result: TracedBig | None = self._results.get((which, a, b, 0))
        if result is None:
            register = len(self.wide_makers)
            result = self._results[which, a, b, 0] = TracedBig(self, register, value)
            self.wide_makers.append(len(self.code))
            self.code.append((which, register, a, b, 0))
        return result

    def recorded_result(self, which: str, a: int, b: int = 0) -> Any:
        """Return the result of an operation, or None if it is not recorded."""
        return self._results.get((which, a, b, 0))

    def input(self, value: float) -> TracedFloat:
        """Record the next of a body's numbers; the tape begins with these."""
        self.inputs += 1
        return self.plain("input", value, self.inputs - 1)

    def sine_cosine(self, angle: int, sine: BigFloat, cosine: BigFloat) -> tuple[TracedBig, TracedBig]:
        """Record the operation that fills two registers. Return both."""
        first = self.wide("sine and cosine", sine, angle)
        second = self._results.get(("cosine", angle, 0, 0))
        if second is None:
            second = self._results["cosine", angle, 0, 0] = TracedBig(self, len(self.wide_makers), cosine)
            self.wide_makers.append(len(self.code) - 1)
        return first, second

    def add_input(self, value: BigFloat, column: int) -> TracedBig:
        """Record a number of 3000 bits that comes with a body."""
        return self.wide("given", value, column)

    def test(self, which: str, register: int, sign: int, expected: int) -> bool:
        """Record whether the sign is among the expected ones. Return the present outcome."""
        holds = bool(sign & expected)
        outcome = expected if holds else 15 - expected  # the complement of the four bits
        if (which, register, outcome) not in self._tested:
            self._tested.add((which, register, outcome))
            self.code.append((which, 0, register, outcome, 0))
        return holds

    def write(self, value: Any) -> None:
        """Record the next output: a float, recorded or not."""
        self.written.append(self.plain_of(value).register)

    def write_wide(self, value: Any) -> None:
        """Record the next output among the numbers of 3000 bits."""
        self.code.append(("write wide", self.wide_outputs, self.wide_of(exact(value)).register, 0, 0))
        self.wide_outputs += 1

    def plain_of(self, value: Any) -> TracedFloat:
        """Return a float as one of the tape's own."""
        if isinstance(value, TracedFloat):
            return value
        if isinstance(value, Symbol):
            raise TypeError("a number of many digits where a float is needed")
        value = float(value)
        row, _ = self.numbers.setdefault(_BITS(value), (len(self.numbers), value))
        return self.plain("number", value, row)

    def wide_of(self, value: BigFloat) -> TracedBig:
        """Return a number of 3000 bits as one of the tape's own."""
        if isinstance(value, TracedBig):
            return value
        # Equal intervals share a constant.
        key = value.mantissa, value.exponent, value.off
        row, _ = self.constants.setdefault(key, (len(self.constants), value))
        return self.wide("constant", value, row)
