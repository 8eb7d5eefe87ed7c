"""exp, power, acos, atan2 and hypot of the kernels against mpmath and C's special values; bits and quotients against Python's own."""

import itertools
import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from conicoid.kernels.numbers import double_double as bits, elementary as angles, elementary as exponential
from conicoid.kernels.numbers.elementary import hypot
from conicoid.kernels.numbers.vectors import normalize, quotient, unit_vector
from conicoid.kernels.ray import Ray, scale_ray

from ..compiled import compiled
from ..samples import drawn
from . import coefficients
from .emulated import same, without_compiler

# --- exp, power, acos, atan2 and hypot of the kernels against mpmath, against C's special values, and as arithmetic


MP = mpmath.mp.clone()
MP.prec = 240
TINY, HUGE = 2.0**-1074, math.ldexp(1.0 - 2.0**-53, 1024)
SPECIAL = [
    0.0,
    TINY,
    2.0**-1022,
    0.25,
    0.5,
    0.75,
    math.nextafter(1.0, 0.0),
    1.0,
    math.nextafter(1.0, 2.0),
    3.0,
    1e308,
    HUGE,
    math.inf,
]
SPECIAL = [*SPECIAL, *(-x for x in SPECIAL), math.nan]

EXP, POWER = compiled(exponential.exp), compiled(exponential.power)
ACOS, ATAN2, HYPOT = compiled(angles.acos), compiled(angles.atan2), compiled(hypot)

Rows = list[tuple[float, ...]]


def rows(*columns) -> Rows:
    return list(zip(*(np.asarray(column, dtype=np.float64).tolist() for column in columns), strict=True))


def spread(random, low, high, n):
    """Numbers of both signs, evenly over exponents."""
    return random.choice([-1.0, 1.0], n) * 2.0 ** random.uniform(low, high, n)


def exps(random, n) -> Rows:
    halves = (np.arange(-1074, 1023) + 0.5) * math.log(2)  # where k changes
    return rows(
        np.concatenate(
            [
                random.uniform(-745.1, 709.7, n),
                random.uniform(-1, 1, n),
                random.uniform(-745.1, -708, n),
                spread(random, -60, 0, n),
                halves,
                np.nextafter(halves, np.inf),
                np.log(np.arange(1, 1000)),
            ]
        )
    )


def powers(random, n) -> Rows:
    """Of Phong's cosines, of all exponents, next to 1, next to where m changes, and with results that are subnormal."""
    x = 2.0 ** random.uniform(-1074, 1023, n)
    y = random.uniform(-1, 1, n)
    near = 1 + spread(random, -52, -2, n)
    subnormal = random.uniform(0.1, 0.9, n)
    return [
        *rows(random.uniform(0, 1, n), random.uniform(1, 300, n)),
        *rows(random.uniform(0, 1, n), random.integers(1, 1000, n)),
        *rows(x, y),
        *rows(near, random.uniform(-600, 600, n) / np.log(near)),
        *rows(math.sqrt(2) * (1 + spread(random, -52, -20, n)), random.uniform(-100, 100, n)),
        *rows(subnormal, random.uniform(-744, -709, n) / np.log(subnormal)),
        *rows(np.arange(1, 1 + n), np.full(n, 2.0)),
        *rows(np.arange(1, 1 + n), np.full(n, -0.5)),
    ]


def cosines(random, n) -> Rows:
    x = [random.uniform(-1, 1, 2 * n), 1 - 2.0 ** random.uniform(-53, -1, n), 2.0 ** random.uniform(-53, -1, n) - 1]
    return rows(
        np.concatenate([*x, spread(random, -60, 0, n), random.uniform(0.4, 0.6, n), random.uniform(-0.6, -0.4, n)])
    )


def places(random, n) -> Rows:
    """Points about the circle, near the axes, near the diagonals and the slopes where the way of computing changes."""
    edges = random.choice([0.25, 0.75, 1.0, 4.0, 4 / 3], n) * (1 + spread(random, -52, -3, n))
    x = random.uniform(-1, 1, n)
    found = [
        *rows(random.uniform(-1, 1, 2 * n), random.uniform(-1, 1, 2 * n)),
        *rows(random.uniform(-1, 1, n), spread(random, -80, 0, n)),
        *rows(spread(random, -80, 0, n), random.uniform(-1, 1, n)),
        *rows(spread(random, -1074, 1023, n), spread(random, -1074, 1023, n)),
        *rows(edges * x, x),
    ]
    return [(y, x) for y, x in found if x > 0 or abs(y) > abs(x) * 2.0**-1000 or x == 0]


def vectors(random, n) -> Rows:
    x = spread(random, -1074, 1022, n)
    small = [random.integers(-1000, 1000, n) * TINY for _ in range(3)]
    middling = [random.uniform(-1, 1, n) * 2.0**-1021 for _ in range(3)]
    return [
        *rows(x, x * spread(random, -60, 0, n), x * spread(random, -30, 0, n)),
        *rows(*random.uniform(-1, 1, (3, n))),
        *rows(*small),
        *rows(*middling),
        (3.0, 4.0, 0.0),
        (2.0, 3.0, 6.0),
    ]


def length(x, y, z):
    with MP.workprec(4400):  # squares from 2^-2148 to 2^2046, all of their bits
        return MP.sqrt(x * x + y * y + z * z)


CASES: dict[str, tuple[Callable, Callable, Callable, float, Callable]] = {
    "exp": (EXP, MP.exp, exps, 0.55, exponential.exp),
    "power": (POWER, MP.power, powers, 0.57, exponential.power),
    "acos": (ACOS, MP.acos, cosines, 0.58, angles.acos),
    "atan2": (ATAN2, MP.atan2, places, 0.67, angles.atan2),
    "hypot": (HYPOT, length, vectors, 0.501, hypot),
}
"""Compiled, exact, arguments, the bound in its docstring, interpreted."""


def off(found: float, true) -> float:
    """By how many units of the true result's last place."""
    if abs(true) >= MP.mpf(2) ** 1024 - MP.mpf(2) ** 970:
        return 0.0 if found == math.copysign(math.inf, true) else math.inf
    return float(abs(found - true) / math.ulp(float(true)))


def worst(name: str, seed: int, n: int) -> tuple[float, tuple[float, ...]]:
    function, true, arguments, _, _ = CASES[name]
    cases = arguments(np.random.default_rng(seed), n)
    assert len(cases) > 3 * n
    return max((off(function(*case), true(*map(MP.mpf, case))), case) for case in cases)


@pytest.mark.parametrize("name", CASES)
def test_errors_are_below_the_stated_bound(name):
    bound = CASES[name][3]
    error, case = worst(name, 1, 150)
    assert error <= bound, case
    assert f"{bound} units of the last place" in CASES[name][4].__doc__


@pytest.mark.deep
@pytest.mark.parametrize("name", CASES)
def test_errors_of_very_many(name):
    for seed in drawn(range(2, 100), 1, name):
        error, case = worst(name, seed, 20_000)
        assert error <= CASES[name][3], case


@pytest.mark.parametrize("name", CASES)
def test_compiled_code_follows_ieee_arithmetic(name):
    function, _, arguments, _, inner = CASES[name]
    cases = arguments(np.random.default_rng(3), 60)
    cases += itertools.product(SPECIAL, repeat=len(cases[0])) if len(cases[0]) < 3 else []
    found = [function(*case) for case in cases]
    with without_compiler():
        expected = [inner(*case) for case in cases]
    assert [case for case, a, b in zip(cases, found, expected, strict=True) if not same(a, b)] == []


def limit(function: Callable[..., float], *case: float) -> float:
    """Python's, which is C's, but for what Python raises instead."""
    try:
        return function(*case)
    except OverflowError:
        return math.inf
    except ValueError:
        return math.nan


def agree(a: float, b: float) -> bool:
    """The same special value; numbers to a few units, as the C library may round otherwise."""
    if 0 < abs(b) < math.inf:
        return abs(a - b) <= 2 * math.ulp(b)
    return same(a, b)


@pytest.mark.parametrize(
    ("function", "libm", "count"),
    [(EXP, math.exp, 1), (ACOS, math.acos, 1), (ATAN2, math.atan2, 2), (HYPOT, math.hypot, 3)],
    ids=["exp", "acos", "atan2", "hypot"],
)
def test_special_values_are_those_of_c(function, libm, count):
    cases = list(itertools.product(SPECIAL, repeat=count))
    assert [case for case in cases if not agree(function(*case), limit(libm, *case))] == []


def test_special_values_of_power_are_those_of_c():
    """For a base that is not below zero; 0 to a negative power is infinite, where Python raises."""
    for x, y in itertools.product(SPECIAL, repeat=2):
        if x < 0 and y != 0:
            assert math.isnan(POWER(x, y))
        elif x == 0 and y < 0:
            assert POWER(x, y) == math.inf
        else:
            assert agree(POWER(abs(x), y), limit(math.pow, abs(x), y)), (x, y)


def test_exact_values_are_exact():
    assert [POWER(float(x), 3.0) for x in range(200)] == [x**3 for x in range(200)]
    assert [POWER(x * x, 0.5) for x in np.arange(1.0, 200.0)] == list(range(1, 200))
    assert [POWER(2.0, float(k)) for k in range(-1074, 1024)] == [math.ldexp(1.0, k) for k in range(-1074, 1024)]
    assert all(POWER(x, 1.0) == x for x in np.random.default_rng(4).random(1000))
    assert (EXP(0.0), ACOS(1.0), ATAN2(0.0, 1.0), HYPOT(3 * 2.0**900, 4 * 2.0**900, 0.0)) == (
        1.0,
        0.0,
        0.0,
        5 * 2.0**900,
    )


@pytest.mark.parametrize(
    ("function", "places", "sign"),
    [
        (EXP, [k * math.log(2) / 2 for k in (-2149, -2045, -2043, -3, -1, 1, 3, 2045)], 1),
        (ACOS, [-1.0, -0.5, 0.5, 1.0], -1),
        (lambda t: ATAN2(t, 1.0), [2.0**-30, 0.25, 0.75, 1.0, 4 / 3, 4.0], 1),
        (lambda x: POWER(x, 30.5), [0.5, math.sqrt(0.5), 1.0, math.sqrt(2), 2.0], 1),
        (lambda x: HYPOT(x, 0.75, 0.3), [0.5, 1.0, 2.0], 1),
    ],
    ids=["exp", "acos", "atan2", "power", "hypot"],
)
def test_they_never_turn_back_where_their_formulas_change(function, places, sign):
    for place in places:
        around = [place]
        for _ in range(300):
            around = [math.nextafter(around[0], -math.inf), *around, math.nextafter(around[-1], math.inf)]
        values = [sign * function(x) for x in around if abs(x) <= 1 or function is not ACOS]
        assert values == sorted(values), place


@pytest.mark.parametrize("name", coefficients.POLYNOMIALS)
def test_coefficients_are_those_that_are_derived(name):
    found = getattr(exponential, name, None) or getattr(angles, name)
    assert found == coefficients.POLYNOMIALS[name]()


@pytest.mark.parametrize(("found", "true"), [
    (angles.PI, lambda mp: mp.pi), (angles.HALF_PI, lambda mp: mp.pi / 2), (angles.QUARTER_PI, lambda mp: mp.pi / 4),
    (angles.ATAN_HALF, lambda mp: mp.atan(mp.mpf(1) / 2)), (angles.SIXTH, lambda mp: mp.mpf(1) / 6),
    (exponential.THIRD, lambda mp: mp.mpf(1) / 3), (exponential.FIFTH, lambda mp: mp.mpf(1) / 5),
])  # fmt: skip
def test_constants_in_two_floats(found, true):
    assert tuple(found) == coefficients.doubled(true)


def test_the_logarithm_of_two_in_two_floats():
    """Of 42 bits and a float."""
    high, low = exponential.LN2
    assert high == math.floor(high * 2**42) / 2**42
    assert low == coefficients.doubled(lambda mp: mp.ln2 - high)[0]


# --- Exponents and neighbours by bits, against Python's own


ABOVE, BELOW = compiled(bits.next_float_up), compiled(bits.next_float_down)
EXPONENT, POWER_OF_TWO, SCALED = compiled(bits.exponent_of), compiled(bits.power_of_two), compiled(bits.scale_by_power)

RANDOM = np.random.default_rng(20261122)
SOME = [
    *(2.0 ** RANDOM.uniform(-1074, 1024, 500)).tolist(),
    *(2.0**k for k in range(-1074, 1024)),
    1.7976931348623157e308,
]
SOME += [-x for x in SOME]


def test_neighbours():
    for x in (*SOME, 0.0, -0.0):
        assert ABOVE(x) == math.nextafter(x, math.inf)
        assert BELOW(x) == math.nextafter(x, -math.inf)
    assert (ABOVE(math.inf), BELOW(-math.inf)) == (math.inf, -math.inf)
    assert (ABOVE(-math.inf), BELOW(math.inf)) == (-1.7976931348623157e308, 1.7976931348623157e308)
    assert math.isnan(ABOVE(math.nan))


def test_exponents():
    assert [EXPONENT(x) for x in SOME] == [math.frexp(x)[1] - 1 for x in SOME]


def test_powers_of_two():
    assert [POWER_OF_TWO(k) for k in range(-1022, 1024)] == [math.ldexp(1.0, k) for k in range(-1022, 1024)]
    for x in RANDOM.uniform(1, 2, 20).tolist():
        assert [SCALED(x, k) for k in range(-1022, 1024)] == [math.ldexp(x, k) for k in range(-1022, 1024)]


@pytest.mark.parametrize("exponent", [-1074, -1050, -1022, -700, -101, -99, 0, 99, 101, 700, 1023])
def test_the_scale_of_a_ray_is_a_power_of_two_that_brings_it_near_one(exponent):
    x = math.ldexp(1.0, exponent)
    ray_in = Ray(0.0, 0.0, 0.0, x, -0.75 * x, 0.0, 0.0, math.inf, -1)
    ray, scale = compiled(scale_ray)(ray_in)
    assert scale_ray(ray_in) == (ray, scale)  # without a compiler, as where a ray is decided in exact arithmetic
    assert math.frexp(scale)[0] == 0.5
    assert ray.dx == x * scale
    assert (scale == 1.0) == (2.0**-100 < x < 2.0**100)
    assert 2.0**-100 < ray.dx < 2.0**100


# --- Quotients by a shared reciprocal, and unit vectors by it, against Python's own division


QUOTIENT, UNIT, NORMALIZED = compiled(quotient), compiled(unit_vector), compiled(normalize)
DRAWS = np.random.default_rng(1990)
BELOW_TWO = 2.0 - 2.0**-52
"""All bits of its fraction are set: Markstein's theorem on reciprocals excludes it, and the one on quotients does not.
"""


def same_bits(a, b):
    return np.array(a).tobytes() == np.array(b).tobytes()


def test_quotients_are_those_of_division():
    a = DRAWS.uniform(-2, 2, 20_000) * 2.0 ** DRAWS.integers(-400, 400, 20_000)
    b = DRAWS.uniform(1, 2, 20_000) * 2.0 ** DRAWS.integers(-400, 400, 20_000)
    for x, y in zip(a.tolist(), b.tolist(), strict=True):
        assert same_bits(QUOTIENT(x, y, 1.0 / y), x / y), (x, y)


def test_quotients_that_are_hard_to_round():
    """By divisors at either end of a binade, and of numbers just beside a multiple or a half of one."""
    ends = [1.0 + k * 2.0**-52 for k in range(40)] + [BELOW_TWO - k * 2.0**-52 for k in range(40)]
    for b in [*ends, 3.0, 511.0, 512.0, 1080.0, 2.0**31 - 1]:
        for q in DRAWS.uniform(1, 2, 50).tolist() + ends[::8]:
            for a in (q * b, math.nextafter(q * b, 0.0), math.nextafter(q * b, 9e9), (q + 2.0**-53) * b):
                assert same_bits(QUOTIENT(a, b, 1.0 / b), a / b), (a, b)


@pytest.mark.parametrize("b", [2.0**-900, 1.7 * 2.0**-900, 2.0**900, BELOW_TWO * 2.0**1023])
def test_divisors_at_the_ends_of_the_range(b):
    for q in (DRAWS.uniform(1, 2, 200) * 2.0 ** DRAWS.integers(-400, 400, 200)).tolist():
        if 2.0**-900 <= q * b <= 2.0**900:
            assert same_bits(QUOTIENT(q * b, b, 1.0 / b), q * b / b), (q, b)


def test_zeros_keep_their_signs():
    assert [math.copysign(1.0, QUOTIENT(zero, 3.0, 1.0 / 3.0)) for zero in (0.0, -0.0)] == [1.0, -1.0]


def test_unit_vectors_are_those_of_four_divisions():
    vectors = DRAWS.normal(size=(20_000, 3)) * 2.0 ** DRAWS.integers(-250, 250, (20_000, 3))
    vectors[::7, 1], vectors[::11, 2], vectors[::13, 0] = 0.0, -0.0, 0.0
    for vector in [*vectors.tolist(), [0.0, 0.0, 0.0], [-0.0, 0.0, 1e300], [1e-300, 3e-300, 2e-300]]:
        assert same_bits(UNIT(*vector), NORMALIZED(*vector)), vector
