"""Tapes played in four floats, and the numbers of motions, beside numbers of 3,000 bits and fractions."""

import math
import random
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from conicoid.geometry.transform import Motion
from conicoid.numerics import bigfloat as number, bigfloat as sines
from conicoid.numerics.bigfloat import BigFloat, exact, fraction, rounded, sqrt
from conicoid.numerics.tracing import Tape
from conicoid.prepare.motion_batch import MotionBatch
from conicoid.prepare.tape.recordings import NO_INPUTS, ProgramResult, TapeProgram, quad_row, schedule_tape
from conicoid.prepare.tape.registers import STATE_OTHER_BRANCH, STATE_UNDECIDED, STATE_VALID

# --- Tapes in four floats, beside numbers of 3,000 bits. Random tapes and hard cases: results are within their bounds,
# and rounded alike.


def sum_of(row: Any) -> Fraction:
    return sum((Fraction(each) for each in row[:-1].tolist()), Fraction(0))


def error_of(row: Any) -> Fraction:
    return Fraction(float(row[-1]))


def play(tape: Tape, inputs: Any) -> ProgramResult:
    return TapeProgram.of(tape).play(np.array(inputs), NO_INPUTS, np.zeros(len(inputs), np.int32))


BITS = 195
"""The bits to which a few operations are certain."""


def some_float(rng: random.Random) -> float:
    """Return a float, often a whole number, so that sums cancel and roots and quotients are whole."""
    return float(rng.randint(-20, 20)) if rng.random() < 0.4 else rng.uniform(-1, 1) * 2.0 ** rng.randint(-60, 60)


def some_steps(rng: random.Random, count: int) -> list[tuple[str, int, int]]:
    return [
        (rng.choice(("add", "subtract", "multiply", "divide", "root", "size", "negate")), rng.randrange(4 + k), rng.randrange(4 + k))
        for k in range(count)
    ]  # fmt: skip


def results_of(steps: list[tuple[str, int, int]], values: list[Any]) -> list[Any]:
    """Return the results of steps as numbers of any kind. A step may use the results of all earlier steps."""
    values = [exact(each) for each in values]
    for operation, a, b in steps:
        first, second = values[a], values[b]
        values.append(
            first + second if operation == "add"
            else first - second if operation == "subtract"
            else first * second if operation == "multiply"
            else first / second if operation == "divide"
            else number.sqrt(abs(first)) if operation == "root"
            else abs(first) if operation == "size"
            else -first
        )  # fmt: skip
    return values[4:]


def check(seed: int, tapes: int, bodies: int = 30) -> tuple[int, int]:
    """Return how many bodies held, and how many stayed undecided."""
    rng, valid, opened = random.Random(seed), 0, 0
    for _ in range(tapes):
        steps, first = some_steps(rng, 10), [some_float(rng) for _ in range(4)]
        tape = Tape()
        try:
            results = results_of(steps, [tape.input(x) for x in first])
        except ZeroDivisionError:
            continue
        for result in results:
            tape.write_wide(result)
            tape.write(number.rounded(result))
        inputs = np.array([first] + [[some_float(rng) for _ in range(4)] for _ in range(bodies)])
        played = play(tape, inputs)
        valid += int((played.state == STATE_VALID).sum())
        opened += int((played.state == STATE_UNDECIDED).sum())
        for row in np.flatnonzero(played.state == STATE_VALID).tolist():
            try:
                truth = results_of(steps, inputs[row].tolist())
            except ZeroDivisionError:  # 3,000 bits do not distinguish (a / b) b from a, nor their difference from zero
                continue
            for k, one in enumerate(truth):
                got = played.fours[row, k]
                assert abs(sum_of(got) - fraction(one)) <= error_of(got) + one.off * Fraction(2) ** one.exponent
                assert played.floats[row, k] == float(one)
    return valid, opened


def test_they_are_within_their_bounds_and_rounded_alike():
    valid, opened = check(5, 40)
    assert valid > BITS // 25 * opened


@pytest.mark.deep
def test_many_are():
    check(6, 400)


@pytest.mark.parametrize("degrees", [0.25, 1e-9, 17.5, 45.0, 89.999, 91.0, -123.456, 359.0, 400.5, -1e7 + 0.125])
def test_sine_and_cosine(degrees):
    tape = Tape()
    for each in sines.sin_cos_degrees(tape.input(degrees)):
        tape.write_wide(each)
        tape.write(number.rounded(each))
    played = play(tape, [[degrees], [degrees + 0.03125]])
    for row, angle in enumerate((degrees, degrees + 0.03125)):
        for k, truth in enumerate(sines.sin_cos_degrees(angle)):
            error = abs(sum_of(played.fours[row, k]) - fraction(truth))
            assert error <= error_of(played.fours[row, k]) < abs(fraction(truth)) / 2**BITS
            assert played.floats[row, k] == float(truth)


def test_sines_and_cosines_beside_every_angle_of_the_table():
    """Angles are multiples of the table's step, halves between two of them, and their neighbours, in all quarters."""
    rng = random.Random(2)
    near = [k * 45.0 / 128.0 for k in range(-1025, 1026)]
    angles = [x for x in (*near, *(math.nextafter(x, rng.choice((-9e9, 9e9))) for x in near)) if x % 30.0]
    angles = rng.sample(angles, 400)
    tape = Tape()
    for each in sines.sin_cos_degrees(tape.input(angles[0])):
        tape.write_wide(each)
    played = play(tape, np.array(angles)[:, None])
    assert (played.state == STATE_VALID).all()
    for row, angle in enumerate(angles):
        for k, truth in enumerate(sines.sin_cos_degrees(angle)):
            error = abs(sum_of(played.fours[row, k]) - fraction(truth))
            assert error <= error_of(played.fours[row, k]) < Fraction(1, 2**BITS)


@pytest.mark.parametrize("turns", range(12))
def test_multiples_of_thirty_degrees_have_recordings_of_their_own(turns):
    tape = Tape()
    for each in sines.sin_cos_degrees(tape.input(30.0 * turns)):
        tape.write(number.rounded(each))
    angles = np.array([[30.0 * turns], [30.0 * turns - 360.0], [30.0 * turns + 30.0], [31.0 * turns + 1.0]])
    played = play(tape, angles)
    assert played.state.tolist() == [STATE_VALID, STATE_VALID, STATE_OTHER_BRANCH, STATE_OTHER_BRANCH]


def test_exact_halves_round_to_even_and_possible_halves_stay_undecided():
    tape = Tape()
    a, b, c = (tape.input(x) for x in (1.0, 2.0**-53, 3.0))
    tape.write(number.rounded(a.exact() + b.exact()))
    exact_ties = play(tape, [[1.0, 2.0**-53, 3.0], [1.0 + 2.0**-52, 2.0**-53, 3.0]])
    assert exact_ties.floats[:, 0].tolist() == [1.0, 1.0 + 2.0**-51]
    third = a.exact() / c.exact()
    tape.write(number.rounded((third + third + third) + b.exact()))
    assert play(tape, [[1.0, 2.0**-53, 3.0]]).state[0] == STATE_UNDECIDED


@pytest.mark.parametrize("start", [1.0, 1.0 + 2.0**-52, -1.0, 2.0 - 2.0**-52, 0.1, -3.7e-5])
def test_beside_a_half_the_rest_decides(start):
    """From a float, half of the gap on either side, and less than a thousandth of a float more or less than that."""
    tape = Tape()
    a, b, c = (tape.input(x) for x in (1.0, 2.0**-53, 2.0**-110))
    tape.write(number.rounded((a.exact() + b.exact()) + c.exact()))
    halves = [(math.nextafter(start, sense * math.inf) - start) / 2 for sense in (1, -1)]
    rows = [(start, half, sense * abs(half) * 2.0**-k) for half in halves for sense in (1, -1) for k in (57, 80, 100)]
    played = play(tape, rows)
    assert (played.state == STATE_VALID).all()
    assert played.floats[:, 0].tolist() == [float(sum(map(Fraction, row))) for row in rows]


def test_bodies_that_fail_a_recorded_test_take_another_branch():
    tape = Tape()
    a, b = tape.input(3.0), tape.input(2.0)
    assert a > b
    assert a - b != 0
    tape.write(a)
    inputs = [[3.0, 2.0], [2.0, 3.0], [2.0, 2.0], [-1.0, -2.0]]
    assert play(tape, inputs).state.tolist() == [STATE_VALID, STATE_OTHER_BRANCH, STATE_OTHER_BRANCH, STATE_VALID]


@pytest.mark.parametrize("look", [float, hash, lambda x: [1, 2][x], lambda x: x.mantissa, lambda x: {x: 1}])
def test_nothing_else_can_look_at_a_recorded_number(look):
    tape = Tape()
    for recorded in (tape.input(2.0), tape.input(2.0).exact()):
        with pytest.raises((TypeError, AttributeError)):
            look(recorded)


def test_differences_and_quotients_that_are_undone_are_exact():
    """(end - start) + start is the end. So a cap stands on the user's point, for any length between."""
    tape = Tape()
    a, b = tape.input(0.1).exact(), tape.input(0.7).exact()
    assert (b - a) + a is b
    assert (a / b) * b is a
    length = number.sqrt(a * a + b * b)
    assert number.is_nothing(length - length)
    assert number.is_nothing(length + -length)


def test_a_tape_with_invalid_operands_leaves_all_undecided():
    import dataclasses

    tape = Tape()
    a = tape.input(1.0)
    tape.write(number.rounded(number.sqrt(a.exact() + 2)))
    recording = TapeProgram.of(tape)
    inputs = np.ones((5, 1))
    assert recording.play(inputs, NO_INPUTS, np.zeros(5, np.int32)).state[0] == STATE_VALID
    for line in range(len(recording.code)):
        for column in range(5):
            for wrong in (-1, 1000):
                code = recording.code.copy()
                code[line, column] = wrong
                spoilt = dataclasses.replace(recording, code=code)
                state = spoilt.play(inputs, NO_INPUTS, np.zeros(5, np.int32)).state[0]
                assert state in (STATE_UNDECIDED, STATE_OTHER_BRANCH, STATE_VALID)
                if column == 0 or (wrong < 0):
                    assert state == STATE_UNDECIDED


@pytest.mark.parametrize(
    "one", [BigFloat(3**400, -700), BigFloat(-(3**400) - 1, 5, 7), exact(0.1), BigFloat(1, 0), number.sqrt(2)]
)
def test_numbers_of_many_bits_are_cut_with_a_bound(one):
    fours = np.array(quad_row(one))
    off = one.off * Fraction(2) ** one.exponent
    assert abs(sum_of(fours) - fraction(one)) + off <= error_of(fours) <= off + abs(fraction(one)) / 2**200


@pytest.mark.parametrize("root", [1, 3, 9, 2**28 - 1, 2**28 + 1, 2**56 - 1, 2**56 + 3, 2**84 + 5])
@pytest.mark.parametrize("shift", [-1, 0, 1])
def test_roots_of_squares_and_of_their_neighbours(root, shift):
    """A square has its root exactly. The root of a number beside it is the true one, whose leading limb may be small."""
    tape = Tape()
    parts = [tape.input(float(part)) for part in _parts(root)]
    whole = exact(parts[0])
    for part in parts[1:]:
        whole = whole + exact(part)
    found = sqrt(whole * whole + shift)
    tape.write(rounded(found))
    tape.write(rounded(found - whole))
    played = play(tape, [_parts(root)])
    true = math.isqrt((root * root + shift) << 1200)
    if played.state[0] == STATE_UNDECIDED:  # the difference may lie below what four floats hold
        assert shift
        assert root > 2**50
        return
    assert played.floats[0, 0] == float(Fraction(true, 1 << 600))
    assert played.floats[0, 1] == (float(Fraction(true - (root << 600), 1 << 600)) if shift else 0.0)


def _parts(whole: int) -> list[float]:
    """Return three floats whose sum is a whole number."""
    parts = []
    for _ in range(3):
        parts.append(float(whole))
        whole -= int(parts[-1])
    return parts


def test_a_tape_is_played_with_its_tests_first():
    """A tape omits unused numbers. The test of one number precedes the numbers that depend on the other."""
    tape = Tape()
    a, b = tape.input(2.0), tape.input(3.0)
    far = exact(b) * exact(b) * exact(b)
    assert a > 1.0
    _ = exact(a) * exact(a)
    tape.write(rounded(far))
    operations = [operation[0] for operation in schedule_tape(tape)]
    assert operations.index("plain sign") < operations.index("widen")
    assert operations.count("multiply") == 2
    played = play(tape, [[2.0, 5.0], [0.5, 5.0]])
    assert played.state.tolist() == [STATE_VALID, STATE_OTHER_BRANCH]
    assert played.floats[0, 0] == 125.0


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("count", [4, 31, 33, 1000])
def test_bodies_that_wait_for_lanes_are_all_played(share, count):
    """Few bodies pass one test and most pass the other. Each has its own result in its own row."""
    tape = Tape()
    a, b = tape.input(1.0), tape.input(2.0)
    assert a > 0.0
    assert b > 0.0
    tape.write(number.rounded(a.exact() / b.exact()))
    rng = np.random.default_rng(count)
    inputs = np.where(rng.random((count, 2)) < (share, 0.9), 1.0, -1.0) * rng.uniform(1, 9, (count, 2))
    played = TapeProgram.of(tape).play(inputs, NO_INPUTS, np.zeros(count, np.int32))
    passed = (inputs > 0).all(axis=1)
    assert (played.state == np.where(passed, STATE_VALID, STATE_OTHER_BRANCH)).all()
    assert (played.floats[passed, 0] == inputs[passed, 0] / inputs[passed, 1]).all()


@pytest.mark.parametrize("size", [2.0**-1000, 2.0**-700, 2.0**-260, 2.0**-100, 2.0**200, 2.0**500, 2.0**900])
def test_numbers_at_the_ends_of_the_floats_are_certain_or_left_open(size):
    """Where products overflow or lose bits below the floats, lanes report that they are not certain."""
    rng = random.Random(str(size))
    tape = Tape()
    a, b, c = (tape.input(x) for x in (1.0, 2.0, 3.0))
    results = [a.exact() * b.exact() * c.exact(), a.exact() / b.exact() + c.exact(), a.exact() * b.exact() - c.exact()]
    for one in results:
        tape.write_wide(one)
        tape.write(number.rounded(one))
    inputs = [[size * rng.uniform(1, 2) for _ in range(3)] for _ in range(40)]
    played = play(tape, inputs)
    for row in np.flatnonzero(played.state == STATE_VALID).tolist():
        x, y, z = map(Fraction, inputs[row])
        for k, truth in enumerate((x * y * z, x / y + z, x * y - z)):
            assert abs(sum_of(played.fours[row, k]) - truth) <= error_of(played.fours[row, k])
            assert played.floats[row, k] == float(truth)
    assert (played.state == STATE_VALID).all() or not 2.0**-260 <= size <= 2.0**200


def test_roots_and_differences_keep_their_digits():
    """Where floats cancel, later ones move up: no bound is wider than the others."""
    rng, tape = random.Random(9), Tape()
    a, b, c = (tape.input(x).exact() for x in (1.0, 2.0, 3.0))
    product = a * b * c
    rest = product - rounded(product).exact()
    for one in (sqrt(a * a + b * b + c * c), rest, rest * rest, (a * b) * c, (a * b - rounded(a * b).exact()) * c):
        tape.write_wide(one)
    inputs = [[rng.uniform(-5, 5) for _ in range(3)] for _ in range(4000)]
    played = play(tape, inputs)
    assert (played.state == STATE_VALID).all()
    size, errors = np.abs(played.fours[..., 0]), played.fours[..., -1]
    assert (errors[:, 0] <= size[:, 0] * 2.0**-BITS).all()
    assert (errors[:, 1:] <= [2.0**-200, 2.0**-240, 2.0**-200, 0.0]).all()
    for (x, y, z), found in zip(inputs, played.fours[:, 3], strict=True):
        assert abs(sum_of(found) - Fraction(x) * Fraction(y) * Fraction(z)) <= error_of(found)


def test_a_ball_holds_all_within_its_radius():
    """Balls in 3,000 bits and in four floats hold their interval for radii of either sign.

    The bound is as tight as its digits.
    """
    rng = np.random.default_rng(7)
    values = rng.normal(size=(60, 2)) * 2.0 ** rng.integers(-200, 60, size=(60, 2))
    tape = Tape()
    tape.write_wide(number.ball(exact(tape.input(1.0)), exact(tape.input(2.0))))
    fours = TapeProgram.of(tape).play(values, NO_INPUTS, np.zeros(60, np.int32)).fours[:, 0]
    np.testing.assert_array_equal(fours[:, 0], values[:, 0])
    assert (fours[:, 4] >= np.abs(values[:, 1])).all()
    np.testing.assert_allclose(fours[:, 4], np.abs(values[:, 1]), rtol=1e-12)
    for middle, radius in values.tolist():
        ball = number.ball(exact(middle), exact(radius))
        off = Fraction(ball.off) * Fraction(2) ** ball.exponent
        reach = abs(fraction(ball) - Fraction(middle)) + abs(Fraction(radius))
        assert reach <= off <= reach * (1 + Fraction(2) ** -20)


# --- The numbers of motions, against fractions, even where terms cancel to less than 2⁻²⁹⁰ of themselves


def minor(m, i, j):
    (a, b), (c, d) = [[m[r][s] for s in range(3) if s != j] for r in range(3) if r != i]
    return a * d - b * c


def numbers_of(rows):
    """Return a matrix without a shift, its shift, its inverse by Cramer's rule, and the shift of the inverse."""
    m = [[Fraction(entry) for entry in row] for row in rows]
    size = sum((-1) ** j * m[0][j] * minor(m, 0, j) for j in range(3))
    inverse = [(-1) ** (i + j) * minor(m, j, i) / size for i, j in product(range(3), range(3))]
    return [*(entry for row in m for entry in row), 0, 0, 0, *inverse, 0, 0, 0]


def flat(k):
    """Return a matrix with two rows at nearly a right angle: 1 + t² - 1."""
    t = 2.0**-145 * (1 + k / 64)
    return [[1.0, t, 1.0], [1.0, t, -1.0], [0.0, 1.0, 0.0]]


def thin(k):
    """Return a matrix with the determinant -t."""
    t = 2.0**-300 * (1 + k / 64)
    return [[1.0, t, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]]


@pytest.mark.parametrize("hard", [flat, thin])
def test_they_are_known_to_195_bits(hard):
    random = np.random.default_rng(0)
    every = [*random.normal(size=(12, 3, 3)).tolist(), *(hard(k) for k in range(6))]
    motions = MotionBatch()
    motion_rows = [
        motions.row(Motion().transform([[*row, 0.0] for row in rows] + [[0, 0, 0, 1.0]]).steps) for rows in every
    ]
    numbers, _, _ = motions.compute()
    for row, rows in zip(numbers[motion_rows], every, strict=True):
        for found, true in zip(row, numbers_of(rows), strict=False):
            assert abs(sum_of(found) - true) <= error_of(found)
            assert error_of(found) <= abs(true) * Fraction(2) ** -195
