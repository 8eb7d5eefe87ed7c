"""Dual numbers: evaluating a shape's own formulas with them gives the derivatives of its walls.

A `Dual` is a `BigFloat` of 3000 bits with its derivatives, as floats, by the parameters that it depends on (forward
mode: Wengert, A simple automatic derivative evaluation program, CACM 7, 1964). Comparisons use the value alone. A zero
with a derivative is true, so that a formula does not skip a term that is zero now but changes.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any, NoReturn

from ...numerics import bigfloat
from ...numerics.bigfloat import BigFloat, Symbol, exact

Slopes = dict[int, float]
"""Number of a parameter -> derivative by it. Missing derivatives are zero."""

_RADIAN = math.pi / 180


class Dual(BigFloat, Symbol):
    """A number with its derivatives by parameters."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: BigFloat, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    @property
    def _unseen(self) -> NoReturn:
        """Refuse access to the digits: they have no derivative."""
        raise TypeError("a number with derivatives does not expose its digits")

    # The fields of `BigFloat`. A formula that read them would lose the derivatives.
    mantissa = exponent = off = _unseen

    def __add__(self, other: Any) -> Any:
        return _sum(self, other, 1.0)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return _sum(self, other, -1.0)

    def __rsub__(self, other: Any) -> Any:
        return _sum(-self, other, 1.0)

    def __neg__(self) -> Dual:
        return Dual(-self.value, {key: -slope for key, slope in self.slopes.items()})

    def __abs__(self) -> Dual:
        return -self if self.value < 0 else self

    def __mul__(self, other: Any) -> Any:
        if not is_finite(other):  # an infinite float has no derivative, and its product has none
            return float(self.value) * other
        value = value_of(other)
        return _depends_on(self.value * value, (self, float(value)), (other, float(self.value)))

    __rmul__ = __mul__

    def __pow__(self, power: int) -> Any:
        if power != 2:
            raise TypeError("only squares have derivatives here")
        return self * self

    def __truediv__(self, other: Any) -> Any:
        return _quotient(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _quotient(other, self)

    def __bool__(self) -> bool:
        return bool(self.value) or any(self.slopes.values())

    def __eq__(self, other: object) -> bool:
        if isinstance(other, float) and not math.isfinite(other):
            return False
        # The difference is false only if its value and all its derivatives are zero.
        return not (self - other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __lt__(self, other: Any) -> bool:
        return _compare_values(operator.lt, self, other)

    def __le__(self, other: Any) -> bool:
        return _compare_values(operator.le, self, other)

    def __gt__(self, other: Any) -> bool:
        return _compare_values(operator.gt, self, other)

    def __ge__(self, other: Any) -> bool:
        return _compare_values(operator.ge, self, other)

    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> NoReturn:
        raise TypeError("a number with derivatives does not convert to float: use ex.rounded")

    def __repr__(self) -> str:
        return f"Slope({float(self.value)!r}, {self.slopes})"

    def exact(self) -> Dual:
        return self

    def settled(self) -> Dual:
        """Return the number with its value settled (`bigfloat.settled`) and the same derivatives."""
        return Dual(bigfloat.settled(self.value), self.slopes)

    def rounded(self) -> Dual:
        """Return the number itself: the step of rounding has no derivative."""
        return self

    def root(self) -> Any:
        """Return the square root. At zero its derivatives are NaN where those of the number are not 0."""
        value = bigfloat.sqrt(self.value)
        return _depends_on(value, (self, 0.5 / float(value))) if value else Dual(value, _unknown(self.slopes))

    def larger(self, other: Any, first: bool = True) -> Any:
        """Return the larger of two numbers.

        If the values are equal, the derivative by each parameter that moves them apart is NaN: either may become the
        larger.
        """
        if self.value != value_of(other):
            return max(self, other)
        keys = self.slopes.keys() | slopes_of(other).keys()
        differing = [key for key in keys if self.slopes.get(key, 0.0) != slopes_of(other).get(key, 0.0)]
        return Dual(self.value, {**self.slopes, **dict.fromkeys(differing, math.nan)})

    def sine_cosine(self) -> tuple[Any, Any]:
        """Return (sine, cosine) of the number as an angle in degrees."""
        s, c = bigfloat.sin_cos_degrees(float(self.value))
        return _depends_on(s, (self, _RADIAN * float(c))), _depends_on(c, (self, -_RADIAN * float(s)))


def value_of(x: Any) -> BigFloat:
    """Return the value of a number without its derivatives."""
    return x.value if isinstance(x, Dual) else exact(x)


def slopes_of(x: Any) -> Slopes:
    """Return the derivatives of a number; none for a plain one."""
    return x.slopes if isinstance(x, Dual) else {}


def is_finite(x: Any) -> bool:
    """Return whether x is anything but a float that is not finite."""
    return not isinstance(x, float) or math.isfinite(x)


def _depends_on(value: BigFloat, *parts: tuple[Any, float]) -> Dual:
    """Return a number whose derivatives follow by the chain rule from (number, partial derivative) pairs."""
    slopes: Slopes = {}
    for part, factor in parts:
        for key, slope in slopes_of(part).items():
            slopes[key] = slopes.get(key, 0.0) + factor * slope
    return Dual(value, slopes)


def _sum(a: Dual, b: Any, sign: float) -> Any:
    if not is_finite(b):
        return sign * b
    value = value_of(b)
    return _depends_on(a.value + (value if sign > 0 else -value), (a, 1.0), (b, sign))


def _quotient(a: Any, b: Any) -> Any:
    if not is_finite(b):
        return 0.0
    # d(a / b) = da / b - (a / b) db / b.
    above, below = value_of(a), value_of(b)
    value = above / below
    inverse = 1.0 / float(below)
    return _depends_on(value, (a, inverse), (b, -float(value) * inverse))


def _compare_values(how: Callable[[Any, Any], bool], a: Dual, b: Any) -> bool:
    """Compare by the values; an infinite float lies beyond all of them."""
    # Any finite value compares with an infinite float like 0.
    return how(0.0, b) if not is_finite(b) else how(a.value, value_of(b))


def _unknown(slopes: Slopes) -> Slopes:
    """Return NaN for each derivative that is not zero: no derivative exists."""
    return dict.fromkeys((key for key, slope in slopes.items() if slope), math.nan)
