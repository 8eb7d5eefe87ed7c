"""Numbers with error bounds: against Arb's intervals of twice the digits, and the rules for undecided intervals."""

import itertools
import math
import random
import sys
import threading
from fractions import Fraction

import flint
import pytest

from conicoid.geometry.general_quadric import Symmetric, eigen_decomposition
from conicoid.numerics import bigfloat as ex, bigfloat as sines
from conicoid.numerics.bigfloat import (
    BITS,
    BigFloat,
    cut,
    exact,
    fraction,
    settled,
    simplest_ratio,
    sin_cos_degrees,
    sqrt,
)

ANGLES = [15, 16, 22.5, 45, 60, 75, 105, 120, 285, 0.1, 1e-3, 1e-80, 359.9, -7.25, 1e6 + 0.3]
ANGLES += [5e-324, -1e-200, 44.99999999999999, 45.00000000000001, 90 - 2.0**-46, 180 + 2.0**-45, 1e300]


@pytest.fixture(autouse=True)
def digits():
    before, flint.ctx.prec = flint.ctx.prec, 2 * BITS
    yield
    flint.ctx.prec = before


def ball(x: Fraction) -> flint.arb:
    return flint.arb(flint.fmpz(x.numerator)) / flint.arb(flint.fmpz(x.denominator))


def interval(n: BigFloat) -> flint.arb:
    return ball(Fraction(n.mantissa) * Fraction(2) ** n.exponent)


def radius(n: BigFloat) -> flint.arb:
    return ball(Fraction(n.off) * Fraction(2) ** n.exponent)


def holds(n: BigFloat, true: flint.arb) -> bool:
    return not abs(interval(n) - true) > radius(n)


def sharp(n: BigFloat, places: int = BITS - 64) -> bool:
    """Return whether the error is below 2^-places of the number."""
    return abs(n.mantissa) >> places >= n.off


def sine(degrees: float) -> flint.arb:
    return flint.arb.sin_pi(ball(Fraction(degrees) / 180))


@pytest.mark.parametrize("degrees", ANGLES)
def test_sines_and_cosines(degrees):
    s, c = sin_cos_degrees(degrees)
    assert holds(s, sine(degrees))
    assert holds(c, flint.arb.cos_pi(ball(Fraction(degrees) / 180)))
    assert sharp(s)
    assert sharp(c)


@pytest.mark.parametrize("places", [64, 384, 3200, 9000])
def test_sines_to_any_number_of_places(places):
    flint.ctx.prec = places + 128
    assert abs(ball(Fraction(sines.pi_fixed_point(places), 1 << places)) - flint.arb.pi()) * 2**places < 1.01
    for angle in (Fraction(45), Fraction(45, 64), Fraction(1, 3), Fraction(1, 10**9)):
        s, c = sines.sin_cos_fixed_point(angle, places)
        true_s, true_c = flint.arb.sin_pi(ball(angle / 180)), flint.arb.cos_pi(ball(angle / 180))
        assert abs(ball(Fraction(c, 1 << places)) - true_c) * 2**places < 3
        assert abs(ball(Fraction(s, 1 << places)) ** 2 - true_s**2) * 2**places < 3


def test_sines_that_are_rational_are_exact():
    found = {d: sin_cos_degrees(d) for d in range(-360, 361, 30)}
    assert [(float(s), s.off) for s, _ in (found[d] for d in (0, 30, 90, 150, 210, 270))] == [
        (0, 0), (0.5, 0), (1, 0), (0.5, 0), (-0.5, 0), (-1, 0),
    ]  # fmt: skip
    assert all((s.off == 0) == (d % 180 in (0, 30, 90, 150)) for d, (s, _) in found.items())


@pytest.mark.parametrize("seed", range(20))
def test_random_expressions_lie_within_their_bounds(seed):
    """Sums, products, quotients and roots of sines and floats of any size; some cancel to nearly nothing."""
    rng = random.Random(seed)
    pool: list[tuple[BigFloat, flint.arb]] = [(sin_cos_degrees(d)[0], sine(d)) for d in rng.sample(ANGLES, 4)]
    for value in (rng.uniform(-9, 9), rng.random() * 1e-90, 3.0, 1e60):
        pool.append((exact(value), ball(Fraction(value))))
    for _ in range(60):
        (a, x), (b, y) = rng.choice(pool), rng.choice(pool)
        kind = rng.randrange(6)
        if kind == 0:
            new = a + b, x + y
        elif kind == 1:
            new = a - b, x - y
        elif kind == 2:
            new = a * b, x * y
        elif kind == 3 and b:
            new = a / b, x / y
        elif kind == 4:
            new = sqrt(abs(a)), abs(x).sqrt()
        else:
            near = a * (1 + exact(2.0 ** -rng.randrange(900)))
            new = near - a, x * (1 + ball(fraction(near / a) - 1)) - x if a else x - x
            if a:
                continue
        assert holds(*new)
        if 1e-200 < abs(float(new[0])) < 1e200:
            pool.append(new)


def test_floats_sums_and_products_are_exact():
    a, b = exact(0.1), exact(1e-90)
    assert (a * b + a).off == 0
    assert fraction(a * b + a) == Fraction(0.1) * Fraction(1e-90) + Fraction(0.1)
    assert (exact(6.0) / 3.0).off == 0
    assert sqrt(exact(2.25)) == 1.5
    assert exact(Fraction(3, 8)).off == 0
    assert exact(Fraction(1, 3)).off > 0


def test_possible_zeros_and_short_numbers_are_settled():
    s, c = sin_cos_degrees(16)
    assert settled(s * s + c * c) == 1
    assert ex.dot((s, c), (c, -s)) == 0
    assert settled(sqrt(2) * sqrt(2) - 2) == 0
    assert settled(sqrt(3)).off > 0
    # A hair from a short number, and known to be
    hair = exact(2.0**-1000)
    assert fraction(settled(1 + hair * hair)) == 1 + Fraction(2) ** -2000
    assert fraction(settled(sqrt(1 + hair) - 1)) != 0


def test_a_wide_interval_decides_nothing():
    vague = BigFloat(1 << 400, -400, 1)
    assert settled(vague) is vague
    assert simplest_ratio(vague, 1024) is None


@pytest.mark.parametrize("ratio", [Fraction(1, 3), Fraction(-22, 7), Fraction(3**200, 7**180), Fraction(5, 3) / 2**700])
def test_fractions_are_recognised(ratio):
    root = sqrt(7)
    blurred = exact(ratio) * root * root / 7
    assert blurred.off > 0
    assert simplest_ratio(blurred, 1024) == ratio


@pytest.mark.parametrize(
    "value", [sqrt(2), sin_cos_degrees(20)[0], sqrt(3) / 7, exact(Fraction(3**900, 7**800)) * sqrt(5) / sqrt(5)]
)
def test_inexact_numbers_are_no_fractions(value):
    assert simplest_ratio(value, 1024) is None


@pytest.mark.parametrize(("first", "second"), list(itertools.combinations((15, 33.25, 75, 105, 170.125), 2)))
def test_turns_compose_exactly(first, second):
    (s1, c1), (s2, c2) = sin_cos_degrees(first), sin_cos_degrees(second)
    s, c = sin_cos_degrees(first + second)
    assert not ex.dot((s1, c1), (c2, s2)) - s
    assert not ex.dot((c1, -s1), (c2, s2)) - c


def test_floats_are_the_nearest():
    for value in (Fraction(1, 3), Fraction(10) ** 40 / 7, Fraction(1, 7 * 10**300)):
        assert float(exact(value)) == float(value)
    assert float(exact(2.0**1000) * exact(2.0**1000)) == math.inf
    assert fraction(cut(exact(0b10111), 3)) == 0b11000


def test_possible_zeros_do_not_divide():
    with pytest.raises(ZeroDivisionError):
        exact(1.0) / (sqrt(2) * sqrt(2) - 2)
    with pytest.raises(ValueError, match="negative"):
        sqrt(exact(-1.0))


@pytest.mark.parametrize(
    "value",
    [0, 1, -1, 2.5, -0.375, 5e-324, 1e300, (1 << 100) + 1, 2**61 - 1, -(2**61) + 1, 3**3000, Fraction(-7, 1 << 99)],
)
def test_equal_numbers_have_one_hash(value):
    assert exact(value) == value
    assert hash(exact(value)) == hash(value)
    assert exact(value) not in (math.inf, -math.inf, math.nan, Fraction(value) + 1)


def stretched(k: int) -> Symmetric:
    """Return a form whose eigenvalues take more bits with larger k."""
    rows = ((2, 1, Fraction(k, 7), 0), (1, 3 * 10 ** (10 * k), 1, 0), (Fraction(k, 7), 1, 5, 0), (0, 0, 0, -1))
    return tuple(tuple(map(Fraction, row)) for row in rows)


def test_threads_do_not_share_a_precision():
    """Each thread's intervals meet those of one thread, though other threads compute with fewer and with more bits."""
    alone = {k: eigen_decomposition(stretched(k))[0] for k in (1, 2, 7, 8)}
    wrong: list[int] = []

    def work(k: int) -> None:
        for turn in range(1, 13):
            wrong.extend(k for a, b in zip(eigen_decomposition(stretched(k))[0], alone[k], strict=True) if a - b)
            s, c = sines._sin_cos_degrees.__wrapped__(turn / 7)
            wrong.extend([k] if s * s + c * c - 1 else [])

    switches = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=work, args=(k,)) for k in alone]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(switches)
    assert not wrong


@pytest.mark.parametrize("zero", [exact(0), exact(0.0)])
def test_zero_divided_by_an_inexact_number_is_zero(zero):
    root = sqrt(2)
    assert zero / root == 0
    assert not (zero / root).off
