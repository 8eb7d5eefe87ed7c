"""Motions: the inverse is that of their steps, and verdicts in floats are those of exact arithmetic."""

import copy
import dataclasses
import math
import pickle
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid._util.validation import LARGEST
from conicoid.geometry.surface import UPRIGHT, QuadricSurface
from conicoid.geometry.transform import IDENTITY_MOTION, AxisFrame, Motion, Reach, Rotate
from conicoid.numerics import bigfloat as ex
from conicoid.prepare.lowering import lower

from ..samples import deep, drawn

FIVE_TIMES = [[3, -4, 0, 1], [4, 3, 0, 0], [0, 0, 5, 2], [0, 0, 0, 1]]


def random_step(motion: Motion, rng: np.random.Generator, decades: float = 1) -> Motion:
    """Return one more step, with sizes over so many decades on both sides of 1."""
    size = float(10.0 ** rng.uniform(-decades, decades))
    kind = rng.integers(7)
    if kind == 0:
        return motion.translate(rng.normal(size=3) * size)
    if kind == 1:
        return motion.rotate(rng.normal(size=3), float(rng.uniform(-400, 400)))
    if kind == 2:
        return motion.rotate(str(rng.choice(["x", "y", "z", "-x", "-z"])), float(rng.choice([30, 90, 17.5, 180])))
    if kind == 3:
        return motion.scale(size * (-1) ** int(rng.integers(2)))
    if kind == 4:
        return motion.scale(rng.choice([1, -2, 0.7], 3) * size)
    if kind == 5:
        return motion.transform([[size * x for x in row] for row in FIVE_TIMES[:3]] + [[0, 0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3] = rng.normal(size=(3, 4)) * size
    return motion.transform(matrix)


def random_motion(rng: np.random.Generator, decades: float = 1) -> Motion:
    motion = IDENTITY_MOTION
    for _ in range(int(rng.integers(1, 6))):
        motion = random_step(motion, rng, decades)
    return motion


def of_product(motion: Motion) -> tuple[ex.Rows, ex.Row]:
    """Return the inverse by the cofactors of the product."""
    rows, shift = motion.affine
    back = ex.inverse(rows)
    x, y, z = ex.apply(back, shift)
    return back, (-x, -y, -z)


@pytest.mark.parametrize("seed", range(40))
def test_the_inverse_of_the_steps_is_that_of_the_product(seed):
    motion = random_motion(np.random.default_rng(seed))
    rows, shift = of_product(motion)
    expected = [[float(x) for x in (*row, t)] for row, t in zip(rows, shift, strict=True)]
    assert motion.inverse_matrix[:3].tolist() == expected


def test_frames_are_undone():
    frame = AxisFrame((1.0, 2.0, -3.0), (1.0, 2.0, 2.5), (0.0, 0.5, 0.0))
    motion = Motion((frame,))
    forth, back = motion.affine, motion.inverse
    assert ex.multiply(forth[0], back[0]) == ex.IDENTITY
    assert ex.plus(ex.apply(forth[0], back[1]), forth[1]) == (ex.ZERO,) * 3
    assert motion.similarity == ex.ONE


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("size", [1.0, -2.5])
@pytest.mark.parametrize("degrees", [0.0, 17.5, 30.0, 90.0, -120.0, 180.0])
def test_turns_about_coordinate_axes_follow_rodrigues(axis, size, degrees):
    direction = [0.0, 0.0, 0.0]
    direction[axis] = size
    rows, _ = Rotate((direction[0], direction[1], direction[2]), degrees).affine()
    s, c = ex.sin_cos_degrees(degrees)
    k = [ex.exact(math.copysign(1, x)) if x else ex.ZERO for x in direction]
    cross = ((ex.ZERO, -k[2], k[1]), (k[2], ex.ZERO, -k[0]), (-k[1], k[0], ex.ZERO))
    for i in range(3):
        for j in range(3):
            terms = [c if i == j else ex.ZERO, (1 - c) * k[i] * k[j], s * cross[i][j]]
            assert rows[i][j] == ex.cancelling_sum(terms)


SIMILAR = [
    (IDENTITY_MOTION, 1),
    (IDENTITY_MOTION.translate((1, 2, 3)).rotate((1, 2, 3), 33), 1),
    (IDENTITY_MOTION.scale(-0.3).rotate("x", 20).scale((2, -2, 2)), ex.exact(0.3) * 2),
    (IDENTITY_MOTION.transform(FIVE_TIMES).scale(0.5), 2.5),
    (IDENTITY_MOTION.transform([[1, 1, 0, 0], [1, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]), None),
    (IDENTITY_MOTION.scale((1, 2, 1)), None),
    (IDENTITY_MOTION.rotate("z", 45).scale((1, 1, 1 + 2**-52)), None),
]


@pytest.mark.parametrize("case", range(len(SIMILAR)))
def test_similarities_know_their_factor(case):
    motion, factor = SIMILAR[case]
    assert motion.similarity == factor
    for further, expected in ((motion.scale(3), factor and factor * 3), (motion.scale((1, 2, 3)), None)):
        assert further.similarity == expected  # a product with a motion of known factor


NOT_SIMILAR = [
    [[1, 2, 2, 0], [2, 1, -2, 0], [2, 2, 1, 0], [0, 0, 0, 1]],  # rows of one length that are not across one another
    [[1, 2, 0, 0], [-2, 1, 0, 0], [0, 0, math.sqrt(5), 0], [0, 0, 0, 1]],  # sqrt(5) was rounded
]


@pytest.mark.parametrize("case", range(len(NOT_SIMILAR)))
def test_near_similarities_are_none(case):
    assert IDENTITY_MOTION.transform(NOT_SIMILAR[case]).similarity is None


def verdict(motion: Motion) -> bool:
    """Return whether a motion stays in the domain, in 3000 bits."""
    try:
        back, _ = of_product(motion)
    except ZeroDivisionError:
        return False
    rows, shift = motion.affine
    return all(abs(float(x)) <= LARGEST for row in (*rows, shift, *back) for x in row)


def checked(motion: Motion) -> bool:
    try:
        motion.check("Sphere")
    except ValueError:
        return False
    return True


def check_verdicts(seeds: Iterable[int]) -> set[bool]:
    verdicts = set()
    for seed in seeds:
        motion = random_motion(np.random.default_rng([seed, 17]), 90)
        expected = verdict(motion)
        assert checked(motion) == expected, motion
        assert checked(Motion(motion.steps)) == expected, motion
        verdicts.add(expected)
    return verdicts


@pytest.mark.parametrize("seeds", [range(60), deep(drawn(range(60, 10_000), 500))])
def test_bounds_decide_as_exact_arithmetic_does(seeds):
    assert check_verdicts(seeds) == {True, False}


EDGES = [
    IDENTITY_MOTION.translate((LARGEST, 0, 0)),
    IDENTITY_MOTION.translate((LARGEST, 0, 0)).translate((LARGEST * 2**-53, 0, 0)),
    IDENTITY_MOTION.translate((LARGEST, 0, 0)).translate((LARGEST, 0, 0)),
    IDENTITY_MOTION.translate((LARGEST, 0, 0)).translate((LARGEST, 0, 0)).translate((-LARGEST, 0, 0)),
    IDENTITY_MOTION.scale(1e-100).scale(1e-100).scale(1e-100).scale(1e-100),
    IDENTITY_MOTION.scale(1e100).scale(1e100).scale(1e-100).scale(1e-100),
    IDENTITY_MOTION.scale(1e-100),
    IDENTITY_MOTION.transform([[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9.000000000000002, 0], [0, 0, 0, 1]]),
    IDENTITY_MOTION.transform([[1e-100, 0, 0, 0], [0, 1e-100, 0, 0], [0, 0, 1e-100, 0], [0, 0, 0, 1]]),
    IDENTITY_MOTION.transform([[1e100, 1e100, 0, 0], [0, 1e-100, 1e-100, 0], [0, 0, 1e-100, 0], [0, 0, 0, 1]]),
]


@pytest.mark.parametrize("case", range(len(EDGES)))
def test_the_edges_of_the_domain_are_exact(case):
    assert checked(EDGES[case]) == verdict(EDGES[case])


def test_long_numbers_beyond_float64_are_infinite():
    third = ex.exact(1e300) / 3
    assert float(third * third) == math.inf
    assert float(-third * third) == -math.inf
    with pytest.raises(ValueError, match="inverse of motion must have entries of magnitude up to 1e[+]100, got inf"):
        co.Sphere().transform([[1e-100, 1e100, 0, 0], [0, 1e-100, 1e100, 0], [0, 0, 1e-100, 0], [0, 0, 0, 1]])


def test_singular_matrices_are_refused_however_nearly_they_are_invertible():
    with pytest.raises(ValueError, match="determinant is 0"):
        IDENTITY_MOTION.transform([[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0], [0, 0, 0, 1]])
    assert IDENTITY_MOTION.transform([[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9.000000000000002, 0], [0, 0, 0, 1]]).steps


@pytest.mark.parametrize("seed", range(40))
def test_no_entry_is_beyond_the_bounds(seed):
    motion = random_motion(np.random.default_rng([seed, 5]), 5)
    reach = Reach(*(bound * (1 + 1e-9) for bound in motion.reach))
    assert np.abs(motion.matrix[:3, :3]).max() <= reach.stretch
    assert np.abs(motion.inverse_matrix[:3, :3]).max() <= reach.back
    assert np.abs(motion.matrix[:3, 3]).max() <= reach.shift


def test_moving_needs_no_exact_arithmetic():
    moved = (
        co.Sphere(2).rotate((1, 2, 3), 40).translate((1, 2, 3)).scale((1, 2, 3)).transform(FIVE_TIMES).rotate("x", 5)
    )
    assert not {"affine", "inverse"} & set(vars(moved.motion))


def test_a_long_chain_keeps_no_earlier_shapes():
    shape = co.Sphere()
    for k in range(50):
        shape = shape.rotate("z", 7.0 + k)
        assert shape.motion.matrix.shape == (4, 4)
    parts = vars(shape.motion).get("_parts", ())
    assert not any(isinstance(part, Motion) and len(part.steps) > 1 for part in parts)


def test_a_moved_shape_does_not_share_cached_results():
    ball = co.Sphere(2)
    assert ball.bounds[1].tolist() == [2, 2, 2]
    moved = ball.translate((1, 0, 0))
    assert moved.bounds[1].tolist() == [3, 2, 2]
    assert moved == dataclasses.replace(ball, motion=moved.motion) == pickle.loads(pickle.dumps(moved))
    assert copy.copy(moved) == moved
    assert moved.radius == 2
    assert moved.cache is not ball.cache


# Balls


def tables(shapes: list[Any]) -> Iterator[bytes]:
    lowered = lower([co.Body(shape) for shape in shapes])
    yield from (np.ascontiguousarray(getattr(lowered.tables, name)).tobytes() for name in lowered.tables._fields)
    yield from (getattr(lowered.rest, field.name).tobytes() for field in dataclasses.fields(lowered.rest))


def moved_balls(seed: int) -> list[Any]:
    """Return balls large and tiny, near and far, moved in several ways, some of which are equal in real numbers."""
    rng, balls = np.random.default_rng([seed, 3]), []
    for _ in range(6):
        motion, radius = random_motion(rng), float(10.0 ** rng.uniform(-12, 2))
        center = tuple(rng.integers(-3, 4, 3).tolist()) if rng.integers(2) else rng.normal(size=3) * 100
        ball = co.Sphere(radius, center)
        balls.append(dataclasses.replace(ball, motion=motion))
        balls.append(dataclasses.replace(ball, motion=motion.rotate("z", 30).rotate((0, 0, 2), -30)))
        balls.append(ball.scale(3).rotate("x", 10))  # three times a float is often halfway between two
        balls.append((ball | co.Box()) & ball.translate((radius, 0, 0)))
        balls[-1] = dataclasses.replace(balls[-1], motion=motion)
    return balls


def check_balls(seeds: Iterable[int], monkeypatch: pytest.MonkeyPatch) -> None:
    found = [list(tables(moved_balls(seed))) for seed in seeds]
    with monkeypatch.context() as patch:
        patch.setattr(QuadricSurface, "_moved_ball", lambda *_: None)  # all by rows and their Gram matrix
        for seed, expected in zip(seeds, found, strict=True):
            assert list(tables(moved_balls(seed))) == expected


@pytest.mark.parametrize("seeds", [range(6), deep(drawn(range(6, 400), 30))])
def test_balls_that_stay_balls_have_the_same_records(seeds, monkeypatch):
    check_balls(seeds, monkeypatch)


def test_a_ball_keeps_upright_rows_under_similarities_alone():
    ball = QuadricSurface((1.0, 1.0, 1.0), constant=4.0, anchor=(1.0, 2.0, 3.0))
    moved = ball.moved(IDENTITY_MOTION.transform(FIVE_TIMES).rotate("x", 90))
    assert moved.rows is UPRIGHT
    assert moved.constant == 100
    # (1, 2, 3) -> (3 - 8 + 1, 4 + 6, 15 + 2) -> (x, -z, y)
    assert moved.anchor == (-4, -17, 10)
    assert ball.moved(IDENTITY_MOTION.scale((1, 2, 1))).rows is not UPRIGHT
