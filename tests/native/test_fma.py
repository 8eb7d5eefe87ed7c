"""The fused multiply-add for processors without the instruction, against rational arithmetic."""

import ctypes
import itertools
import math
import random
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import pytest

from ..samples import deep, many

SOURCE = Path(__file__).resolve().parents[2] / "native" / "fma.c"
LEAST, SMALLEST_NORMAL, LARGEST = 2.0**-1074, 2.0**-1022, math.ldexp(2 - 2.0**-52, 1023)
SPECIAL = [
    0.0, LEAST, 3 * LEAST, SMALLEST_NORMAL - LEAST, SMALLEST_NORMAL, 2.0**-537, 2.0**-500, 0.5, 1.0, 1 + 2.0**-52,
    2 - 2.0**-52, 3.0, 2.0**52 + 1, 2.0**53 - 1, 2.0**500, 2.0**1023, LARGEST, math.inf, math.nan,
]  # fmt: skip
SPECIAL += [-x for x in SPECIAL]

Triple = tuple[float, float, float]


@pytest.fixture(scope="module")
def fma(tmp_path_factory) -> Callable[..., float]:
    library = tmp_path_factory.mktemp("fma") / "fma.so"
    compiler = [sys.executable, "-m", "ziglang", "cc", "-O2", "-fPIC", "-shared", "-ffp-contract=off"]
    subprocess.run([*compiler, "-DFMA=double exact_fma", str(SOURCE), "-o", str(library)], check=True)
    found = ctypes.CDLL(str(library)).exact_fma
    found.argtypes, found.restype = [ctypes.c_double] * 3, ctypes.c_double
    return found


def expected(a: float, b: float, c: float) -> float:
    """Return the result by IEEE 754, section 5.4.1 and clause 6, to nearest, ties to even."""
    if math.isnan(a) or math.isnan(b) or math.isnan(c):
        return math.nan
    sign = math.copysign(1, a) * math.copysign(1, b)
    if math.isinf(a) or math.isinf(b):
        if a == 0 or b == 0 or (math.isinf(c) and math.copysign(1, c) != sign):
            return math.nan
        return math.copysign(math.inf, sign)
    if math.isinf(c):
        return c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0:  # a zero sum of two equal signs keeps the sign; otherwise it is +0
        both = (a == 0 or b == 0) and c == 0
        return math.copysign(0.0, c) if both and math.copysign(1, c) == sign else 0.0
    try:
        found = float(exact)
    except OverflowError:
        found = math.inf
    return math.copysign(found, 1 if exact > 0 else -1)


def any_float(chance: random.Random) -> float:
    """Return random bits; every fourth float is small, and every fourth lacks most of its fraction."""
    bits, kind = chance.getrandbits(64), chance.randrange(4)
    if kind == 0:
        bits &= ~(0x7FC << 52)
    if kind == 1:
        bits &= ~((1 << chance.randrange(20, 53)) - 1)
    return struct.unpack("<d", struct.pack("<Q", bits))[0]


def near(chance: random.Random, x: float) -> float:
    """Return a float within some units of the last place of another, or far below or above."""
    if x == 0 or not math.isfinite(x):
        return x
    if chance.random() < 0.5:
        return x + chance.randint(-3, 3) * math.ulp(x)
    return math.copysign(min(abs(x) * 2.0 ** chance.randint(-120, 120), LARGEST), chance.choice((x, -x)))


def cancelling(chance: random.Random) -> Triple:
    """Return a b + c where c is about -a b: nearly all digits cancel."""
    a, b = (math.ldexp(chance.uniform(1, 2), chance.randint(-540, 510)) for _ in range(2))
    return a, b, near(chance, -(a * b))


def halfway(chance: random.Random) -> Triple:
    """Return factors and a power of two c. Their product is at, or next to, the middle between two floats near c."""
    whole = 2 * chance.getrandbits(51) + 1
    e = chance.randint(-1074, 900)
    return (
        0.5 + chance.choice((0.0, 2.0**-53, 2.0**-52)),
        math.ldexp(1, e),
        chance.choice((1, -1)) * math.ldexp(whole, e),
    )


def below(chance: random.Random) -> Triple:
    """Return products and sums among the subnormal numbers."""
    a = math.ldexp(chance.uniform(1, 2), chance.randint(-560, -500))
    b = math.ldexp(chance.uniform(1, 2), chance.randint(-560, -500))
    return a, chance.choice((b, -b)), chance.randint(-(2**12), 2**12) * LEAST


def above(chance: random.Random) -> Triple:
    """Return products at the edge of overflow, which c may bring back."""
    a = math.ldexp(chance.uniform(1, 2), 512)
    return (
        a,
        math.ldexp(chance.uniform(1, 2), chance.choice((510, 511))),
        chance.choice((LARGEST, -LARGEST, near(chance, -LARGEST))),
    )


def hard(count: int, seed: int) -> Iterator[Triple]:
    chance = random.Random(seed)
    for k in range(count):
        kind = (cancelling, halfway, below, above)[k % 8] if k % 8 < 4 else None
        yield kind(chance) if kind else (any_float(chance), any_float(chance), any_float(chance))


def same(x: float, y: float) -> bool:
    return (x == y and math.copysign(1, x) == math.copysign(1, y)) or (math.isnan(x) and math.isnan(y))


def wrong(fma: Callable[..., float], cases: Iterator[Triple]) -> list[str]:
    return [" ".join(map(float.hex, case)) for case in cases if not same(fma(*case), expected(*case))]


def test_special_values(fma):
    assert not wrong(fma, itertools.islice(itertools.product(SPECIAL, repeat=3), 0, None, many(5, 1)))


@pytest.mark.parametrize(("count", "seed"), [(20_000, 1), deep((1_000_000, 2))])
def test_hard_and_random_cases(fma, count, seed):
    assert not wrong(fma, hard(count, seed))
