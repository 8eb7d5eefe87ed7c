"""The elementary functions without a compiler: each operation by Python's floats, fused ones by exact fractions.

What is computed this way depends on nothing but IEEE arithmetic, so compiled code that gives the same bits does not
either.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction

import pytest

from conicoid.engine.numbers import angles, bits, doubled, errorfree, exponential, hypot, polynomial

MODULES = (angles, bits, doubled, errorfree, exponential, hypot, polynomial)


def fma(a: float, b: float, c: float) -> float:
    """a b + c, rounded once; the sign of a zero is that of IEEE."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    return float(exact) if exact else a * b + c


def bits_of(x: float) -> int:
    return struct.unpack("<q", struct.pack("<d", x))[0]


def of_bits(number: int) -> float:
    return struct.unpack("<d", struct.pack("<q", number))[0]


@contextmanager
def interpreted() -> Iterator[None]:
    """Within the block, inner functions that are called from Python work by these."""
    with pytest.MonkeyPatch.context() as patch:
        for module in MODULES:
            for instruction in (fma, bits_of, of_bits):
                patch.setattr(module, instruction.__name__, instruction, raising=False)
        yield


def same(a: float, b: float) -> bool:
    """Equal to the bit; NaN is NaN."""
    return bits_of(a) == bits_of(b) or (math.isnan(a) and math.isnan(b))
