"""Numbers that mpmath works out: sines and cosines of degrees, exact where they are rational."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

from ..forks import nested_lock
from .number import BITS, ONE, ZERO, Number, Symbol, settled

_mp_lock = nested_lock()


@cache
def _mpmath() -> Any:
    """mpmath, imported where it is needed: few scenes have an angle or a matrix that needs it."""
    from mpmath import MPContext

    return MPContext()


@contextmanager
def mpmath_of(bits: int) -> Iterator[Any]:
    """mpmath at a precision, for one thread at a time: the precision, and the constants it keeps, are those of all."""
    with _mp_lock:
        mp = _mpmath()
        mp.prec = bits
        yield mp


def of_mpmath(value: Any, places: int) -> Number:
    """A number of mpmath's whose error is below 2^-places, within `mpmath_of` at least so many bits."""
    mp = _mpmath()
    scaled = int(mp.nint(mp.ldexp(value, places)))
    return settled(Number(scaled, -places, 2))


def sin_cos_degrees(degrees: float) -> tuple[Number, Number]:
    """Sine and cosine of an angle in degrees. Of rational angles they are rational only at multiples of 30 (Niven)."""
    if isinstance(degrees, Symbol):
        return degrees.sine_cosine()
    return _sin_cos_degrees(degrees)


@lru_cache(maxsize=1024)
def _sin_cos_degrees(degrees: float) -> tuple[Number, Number]:
    """`sin_cos_degrees` of a float."""
    angle = Fraction(degrees) % 360
    quarter, rest = divmod(angle, 90)
    half = Number(1, -1)
    if rest == 0:
        s, c = ZERO, ONE
    else:
        with mpmath_of(BITS + 64) as mp:
            radians = mp.pi * rest.numerator / (180 * rest.denominator)
            cosine, sine = mp.cos_sin(radians)
            s, c = _of_sine(sine), _of_sine(cosine)
        s, c = (half if rest == 30 else s), (half if rest == 60 else c)
    for _ in range(int(quarter)):
        s, c = c, -s
    return s, c


def _of_sine(value: Any) -> Number:
    """To 3000 bits of its own, however small: mpmath's sines are right to the last of their bits but a few."""
    return of_mpmath(value, BITS + 32 - int(_mpmath().mag(value)))
