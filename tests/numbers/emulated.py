"""The elementary functions without a compiler: each operation by Python's floats, fused ones by exact fractions.

Results depend on nothing but IEEE arithmetic, so compiled code that gives the same bits does not either.
"""

import math
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction

import pytest

from conicoid.kernels.numbers import (
    double_double as bits,
    double_double as doubled,
    double_double as errorfree,
    elementary as angles,
    elementary as exponential,
    elementary as hypot,
    elementary as polynomial,
)

MODULES = (angles, bits, doubled, errorfree, exponential, hypot, polynomial)


def fma(a: float, b: float, c: float) -> float:
    """a b + c, rounded once; the sign of a zero is that of IEEE."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    return float(exact) if exact else a * b + c


def float_bits(x: float) -> int:
    return struct.unpack("<q", struct.pack("<d", x))[0]


def float_from_bits(number: int) -> float:
    return struct.unpack("<d", struct.pack("<q", number))[0]


@contextmanager
def without_compiler() -> Iterator[None]:
    """Within the block, inner functions that are called from Python work by these."""
    with pytest.MonkeyPatch.context() as patch:
        for module in MODULES:
            for instruction in (fma, float_bits, float_from_bits):
                patch.setattr(module, instruction.__name__, instruction, raising=False)
        yield


def same(a: float, b: float) -> bool:
    """Equal to the bit; NaN is NaN."""
    return float_bits(a) == float_bits(b) or (math.isnan(a) and math.isnan(b))
