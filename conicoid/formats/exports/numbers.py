"""Numbers as decimals that readers turn into the same float64; and what is no float64, to forty digits."""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction

from ...shapes import exact as ex

DIGITS = 40
"""Of numbers that are no float64: more than readers keep, so that these round them as they would the exact ones."""
_LONGEST, _LONGEST_QUOTIENT = 60, 400
_CONTEXT = Context(prec=DIGITS)


def decimal(value: float) -> Fraction:
    """The shortest decimal that is read as a float64: 1/10 for 0.1. Sums of such are what people mean by them."""
    return Fraction(repr(value + 0.0))


def word(value: float | Fraction) -> str:
    """A number as text."""
    if isinstance(value, Fraction):
        near = float(value)
        if decimal(near) != value:
            return _many_digits(value)
        value = near
    text = repr(value + 0.0)
    return text[:-2] if text.endswith(".0") else text


def words(values: object) -> str:
    """Several numbers, with blanks between them."""
    return " ".join(word(value) for value in values)  # type: ignore[attr-defined]


def _many_digits(value: Fraction) -> str:
    """All digits where they end soon, else forty."""
    denominator = value.denominator
    twos = (denominator & -denominator).bit_length() - 1
    fives, rest = 0, denominator >> twos
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    places = max(twos, fives)
    if rest == 1 and places <= _LONGEST:
        digits = abs(value.numerator) * 10**places // denominator
        if len(str(digits)) <= _LONGEST:
            return str(Decimal(digits if value >= 0 else -digits).scaleb(-places, Context(prec=2 * _LONGEST)))
    return str(_CONTEXT.divide(Decimal(value.numerator), Decimal(value.denominator)))


def short(value: ex.Writable) -> tuple[Fraction, bool]:
    """A number of many bits as a fraction that `word` says, and whether it is a float64: the decimal of that then."""
    if isinstance(value, (int, float)):
        return decimal(float(value)), True
    near = ex.rounded(value)
    if ex.cancelling_sum((ex.exact(value), -ex.exact(near))):
        return ex.fraction(value), False
    return decimal(near), True


def expression(value: Fraction) -> str:
    """A number for readers that know fractions: as it is where its digits end soon, else a quotient."""
    text = word(value)
    quotient = f"{value.numerator}/{value.denominator}"
    return text if Fraction(text) == value or len(quotient) > _LONGEST_QUOTIENT else quotient
