"""The general quadric: principal axes, anchors, degenerate ones, and the values of its fields."""

import copy
import json
import pickle

import numpy as np
import pytest

from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.surface import UPRIGHT, PlaneSurface
from conicoid.numerics import bigfloat as ex

from .samples import contains, value

NAMES = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")


def polynomial(values: dict[str, float], points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    terms = dict(xx=x * x, yy=y * y, zz=z * z, xy=x * y, yz=y * z, xz=x * z, x=x, y=y, z=z, constant=1.0)
    return sum(values[name] * terms[name] for name in values)


def random_coefficients(seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    values = dict(zip(NAMES, rng.normal(size=10).tolist(), strict=True))
    # Now and then some terms vanish
    return {name: v for name, v in values.items() if seed % 3 == 0 or rng.random() > 0.3} or {"xy": 1.0}


@pytest.mark.parametrize("seed", range(40))
def test_the_principal_form_is_the_polynomial(seed: int) -> None:
    values = random_coefficients(seed)
    points = np.random.default_rng(seed).normal(size=(500, 3)) * 3
    if not any(name in values for name in NAMES[:9]):
        return
    shape = Quadric(coefficients=values)
    expected = polynomial(values, points)
    np.testing.assert_allclose(value(shape.surface, points), expected, atol=1e-11)
    np.testing.assert_array_equal(contains(shape.tree(), points), expected <= 0)


@pytest.mark.parametrize("seed", range(20))
def test_eigenvalues_and_directions(seed: int) -> None:
    """Compare with NumPy's own eigenvalues. Directions are orthonormal and exact to 400 bits."""
    rng = np.random.default_rng(100 + seed)
    a = rng.normal(size=(4, 4))
    surface = Quadric(matrix=a).surface
    symmetric = (a + a.T)[:3, :3] / 2
    np.testing.assert_allclose(sorted(float(s) for s in surface.squares), np.linalg.eigvalsh(symmetric), rtol=1e-12)
    rows = ex.multiply(surface.rows, ex.transpose(surface.rows))
    for i in range(3):
        for j in range(3):
            assert abs(rows[i][j] - int(i == j)) < 2.0**-380
    # The center solves A x = -b, and there no linear term is left
    center = np.linalg.solve(symmetric, -(a + a.T)[:3, 3] / 2)
    if abs(np.linalg.eigvalsh(symmetric)).min() > 1e-2:
        np.testing.assert_allclose([float(c) for c in surface.anchor], center, rtol=1e-10)
        assert not any(surface.linear)


ANCHORED = [  # coefficients, and in the principal form: squares, anchor, linear terms, and the constant on the right
    # -3 y² + 6 y = -3 (y - 1)² + 3
    (dict(xx=0.1, yy=-3, zz=7, y=6, constant=-1), (0.1, -3, 7), (0, 1, 0), (0, 0, 0), -2),
    # A paraboloid about its vertex: (x - 1)² + (y + 2)² = z - 4
    (dict(xx=1, yy=1, x=-2, y=4, z=-1, constant=9), (1, 1, 0), (1, -2, 4), (0, 0, -0.5), 0),
    # x² + y² + ε z² - z: the center at z = 1 / (2 ε) is no place to look from; the vertex is
    *((dict(xx=1, yy=1, zz=weak, z=-1), (1, 1, weak), (0, 0, 0), (0, 0, -0.5), 0) for weak in (1e-9, -1e-9, 1e-15, -1e-15)),
    # x² + y² + (z / 10⁴)² <= 1 moved to z = 3, about its center
    (dict(xx=1, yy=1, zz=1e-8, z=-6e-8, constant=9e-8 - 1), (1, 1, 1e-8), (0, 0, 3), (0, 0, 0), 1),
]  # fmt: skip


@pytest.mark.parametrize(("coefficients", "squares", "anchor", "linear", "constant"), ANCHORED)
def test_upright_quadrics_keep_their_numbers(coefficients, squares, anchor, linear, constant) -> None:
    surface = Quadric(coefficients=coefficients).surface
    assert surface.rows is UPRIGHT
    assert [float(s) for s in surface.squares] == list(squares)
    np.testing.assert_allclose([float(c) for c in surface.anchor], anchor, rtol=1e-15)
    assert [float(b) for b in surface.linear] == list(linear)
    assert float(surface.constant) == pytest.approx(constant, rel=1e-15)


def test_signature_of_canonical_kinds() -> None:
    """The signs are those of the eigenvalues of turned canonical quadrics. Zeros are exact."""
    exact_turn = np.array([[2, -2, 1], [1, 2, 2], [2, 1, -2]])  # columns orthogonal, of length 3
    for diagonal, signs in (
        ((1, 1, 1), (1, 1, 1)),
        ((1, 2, 0), (0, 1, 1)),
        ((1, -4, 0), (-1, 0, 1)),
        ((4, 0, 0), (0, 0, 1)),
    ):
        a = np.zeros((4, 4))
        a[:3, :3] = exact_turn @ np.diag(diagonal) @ exact_turn.T
        a[3, 3] = -1
        surface = Quadric(matrix=a).surface
        assert sorted(np.sign([float(s) for s in surface.squares])) == sorted(signs)
        np.testing.assert_allclose(
            sorted(float(s) for s in surface.squares), sorted(9.0 * np.array(diagonal)), atol=1e-13
        )


def test_small_eigenvalues_beside_large_ones_keep_their_digits() -> None:
    """The small eigenvalue of [[10²⁰, 1], [1, 10⁻²⁰ (1 + 2⁻²⁰)]] is det / trace, far below 53 bits of the large one."""
    small = 1e-20 * (1 + 2.0**-20)
    surface = Quadric(matrix=[[1e20, 1, 0, 0], [1, small, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]).surface
    low, _, high = sorted(surface.squares)
    determinant = ex.exact(1e20) * ex.exact(small) - 1
    assert float(high) == 1e20
    assert float(low) == pytest.approx(float(determinant / (ex.exact(1e20) + ex.exact(small))), rel=1e-15)


def test_exactly_singular_ones_have_exact_zeros() -> None:
    # (x + 2 y + 3 z)² <= 4
    n = np.array([1.0, 2, 3])
    a = np.zeros((4, 4))
    a[:3, :3], a[3, 3] = np.outer(n, n), -4
    surface = Quadric(matrix=a).surface
    assert sum(s == 0 for s in surface.squares) == 2
    assert float(max(surface.squares)) == pytest.approx(14)


def test_without_second_order_terms_it_is_a_half_space() -> None:
    shape = Quadric(coefficients=dict(x=3, y=-4, constant=10))
    assert isinstance(shape.surface, PlaneSurface)
    assert [float(c) for c in shape.surface.normal] == [3, -4, 0]
    assert float(shape.surface.offset) == -10
    # The foot of the perpendicular from the origin
    np.testing.assert_allclose([float(c) for c in shape.surface.anchor], (-1.2, 1.6, 0), rtol=1e-15)
    assert shape.support((-3.0, 4.0, 0.0)) == np.inf
    assert shape.support((6.0, -8.0, 0.0)) == -20


@pytest.mark.parametrize(
    ("values", "inside", "outside"),
    [
        (dict(xx=1, yy=1, zz=1, constant=1), [], [(0, 0, 0), (5, 5, 5)]),
        (dict(xx=-1, constant=-1), [(0, 0, 0), (9, 9, 9)], []),
        (dict(xx=1), [(0, 5, 7)], [(1e-9, 0, 0)]),
        (dict(xx=1, constant=-4), [(2, 5, 7), (-2, 0, 0)], [(2.1, 0, 0)]),
        (dict(xy=1), [(1, -1, 5), (0, 3, 0)], [(1, 1, 0), (-1, -2, 0)]),
        (dict(xx=1, yy=1), [(0, 0, 9)], [(0, 1e-9, 0)]),
        (dict(xx=1, yy=1, zz=1), [(0, 0, 0)], [(0, 0, 1e-9)]),
        (dict(xx=1, yy=1, xy=-2, constant=-0.5), [(3, 3, 1), (3, 2.4, 1)], [(3, 2.2, 1)]),
    ],
)
def test_degenerate_ones_are_legal(values, inside, outside) -> None:
    tree = Quadric(coefficients=values).tree()
    for points, expected in ((inside, True), (outside, False)):
        for point in points:
            assert contains(tree, np.array(point, float)) == expected


def test_coefficients_compare_hash_and_stay() -> None:
    shape = Quadric(coefficients=dict(constant=-1, yy=0, xx=1))
    other = Quadric(coefficients={"xx": 1.0, "constant": -1.0})
    assert shape == other
    assert hash(shape) == hash(other)
    assert shape != Quadric(coefficients=dict(xx=1, constant=-2))
    assert dict(shape.coefficients) == {"xx": 1.0, "constant": -1.0}
    assert json.loads(json.dumps(shape.coefficients)) == {"xx": 1.0, "constant": -1.0}
    with pytest.raises(TypeError, match="cannot be changed"):
        shape.coefficients["xx"] = 2.0
    for same in (
        copy.deepcopy(shape),
        pickle.loads(pickle.dumps(shape)),
        shape.translate((0, 0, 0)).translate((1, 0, 0)),
    ):
        assert same.coefficients == shape.coefficients
        assert hash(same.coefficients) == hash(shape.coefficients)


def test_a_paraboloid_across_an_axis_of_the_world_has_no_end_there():
    """(x + z)² + y² - 2x - 2y - z = 1 with u = x + z, v = y - 1: x is u² - u + v² - 2 and z is 2 + 2u - u² - v²."""
    low, high = Quadric(coefficients=dict(xx=1, yy=1, zz=1, xz=2, x=-2, y=-2, z=-1, constant=-1)).bounds
    assert low.tolist() == [-2.25, -np.inf, -np.inf]
    assert high.tolist() == [np.inf, np.inf, 3.0]


@pytest.mark.parametrize("rank", [1, 2, 3])
@pytest.mark.parametrize("count", [60, pytest.param(600, marks=pytest.mark.deep)])
def test_bounds_hold_quadrics_of_small_integers(rank, count):
    """Their axes are irrational, or along those of the world where matrices have zeros; ends of far ones are none."""
    random = np.random.default_rng(rank)
    points = random.normal(size=(4000, 3)) * 10.0 ** random.uniform(-1, 3, (4000, 1))
    for _ in range(count):
        columns = random.integers(-1, 2, (3, rank))
        matrix = columns @ np.diag(random.integers(1, 4, rank)) @ columns.T
        linear = random.integers(-2, 3, 3) * random.integers(0, 2, 3)
        values = dict(
            zip(
                NAMES,
                (
                    *np.diag(matrix),
                    2 * matrix[0, 1],
                    2 * matrix[1, 2],
                    2 * matrix[0, 2],
                    *linear,
                    random.integers(-3, 1),
                ),
                strict=True,
            )
        )
        if not (matrix.any() or linear.any()):
            continue
        named = {name: float(value) for name, value in values.items()}
        inside = points[polynomial(named, points) <= 0]
        low, high = Quadric(coefficients=named).bounds
        assert ((low <= inside) & (inside <= high)).all(), named
