"""The class of a quadric: all affine classes, under rational congruences, with known centers, axes and semi-axes."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import conicoid as co
from conicoid.geometry.general_quadric import KINDS
from conicoid.numerics import rational

from ..samples import deep, sampled

# The 17 affine classes of real quadrics (real points or none), and the plane: coefficients, kind, inside
CLASSES = [
    (dict(xx=1, yy=2, zz=3, constant=-1), "ellipsoid", "within"),
    (dict(xx=1, yy=2, zz=3, constant=1), "empty", "nothing"),
    (dict(xx=1, yy=2, zz=3), "point", "the point alone"),
    (dict(xx=1, yy=2, zz=-3, constant=-1), "one-sheet hyperboloid", "around the last axis"),
    (dict(xx=1, yy=2, zz=-3, constant=1), "two-sheet hyperboloid", "within the two sheets"),
    (dict(xx=1, yy=2, zz=-3), "elliptic cone", "within the nappes"),
    (dict(xx=1, yy=2, z=-2), "elliptic paraboloid", "within the bowl"),
    (dict(xx=1, yy=-2, z=-2), "hyperbolic paraboloid", "where the last axis points"),
    (dict(xx=1, yy=2, constant=-1), "elliptic cylinder", "within"),
    (dict(xx=1, yy=2, constant=1), "empty", "nothing"),
    (dict(xx=1, yy=-2, constant=-1), "hyperbolic cylinder", "between the branches"),
    (dict(xx=1, yy=2), "line", "the line alone"),
    (dict(xx=1, yy=-2), "crossing planes", "the two wedges about the first axis"),
    (dict(xx=1, y=-2), "parabolic cylinder", "within"),
    (dict(xx=1, constant=-1), "parallel planes", "between the planes"),
    (dict(xx=1, constant=1), "empty", "nothing"),
    (dict(xx=1), "double plane", "the plane alone"),
    (dict(x=1, constant=-1), "plane", "where the last axis points"),
]
OPPOSITE = {
    "within": "outside",
    "nothing": "all of space",
    "the point alone": "all of space",
    "the line alone": "all of space",
    "the plane alone": "all of space",
    "around the last axis": "away from the last axis",
    "within the two sheets": "between the two sheets",
    "within the nappes": "outside the nappes",
    "within the bowl": "outside the bowl",
    "between the branches": "within the branches",
    "between the planes": "beyond the planes",
    "where the last axis points": "where the last axis points",
    "the two wedges about the first axis": "the two wedges about the first axis",
}
PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "x": (0, 3), "y": (1, 3), "z": (2, 3), "constant": (3, 3)}
whole = st.integers(-6, 6)


def matrix(values: dict[str, int], factor: int = 1) -> list[list[Fraction]]:
    rows = [[Fraction(0)] * 4 for _ in range(4)]
    for name, value in values.items():
        i, j = PLACES[name]
        rows[i][j] += Fraction(value * factor, 2)
        rows[j][i] += Fraction(value * factor, 2)
    return rows


def congruent(q: list[list[Fraction]], affine: list[list[int]]) -> list[list[float]]:
    """Return PᵀQP for an affine P, a matrix of small numbers that are exact in floats."""
    p = [[Fraction(c) for c in row] for row in [*affine, [0, 0, 0, 1]]]
    image = [[sum(p[k][i] * q[k][m] * p[m][j] for k in range(4) for m in range(4)) for j in range(4)] for i in range(4)]
    assert all(Fraction(float(c)) == c for row in image for c in row)
    return [[float(c) for c in row] for row in image]


@pytest.mark.parametrize(("values", "kind", "inside"), CLASSES, ids=lambda item: str(item) if item else "")
@pytest.mark.parametrize("count", [3, deep(100)])
def test_the_class_survives_congruences(values, kind, inside, count):
    """No invertible affine map changes the class (Sylvester's law of inertia). A negative factor changes the side."""

    @settings(max_examples=count, deadline=None)
    @given(st.lists(st.lists(whole, min_size=4, max_size=4), min_size=3, max_size=3), st.integers(1, 9))
    def run(affine, factor):
        check_congruence(values, kind, inside, affine, factor)

    run()


def check_congruence(values, kind, inside, affine, factor):
    linear = np.array(affine, dtype=float)[:, :3]
    if abs(round(float(np.linalg.det(linear)))) == 0:
        affine = [[1, 2, 0, 1], [0, 1, 3, -2], [0, 0, 2, 5]]
    found = co.Quadric(matrix=congruent(matrix(values, 2 * factor), affine)).classification
    assert found.kind in (("sphere", "ellipsoid") if kind == "ellipsoid" else (kind,))
    assert found.inside == inside
    turned = co.Quadric(matrix=congruent(matrix(values, -2 * factor), affine)).classification
    assert turned.kind == found.kind
    assert turned.inside == OPPOSITE[inside]
    assert found.degenerate == (kind in KINDS[KINDS.index("crossing planes") :])


# Three vectors of length 7, each across the others
TURN = [[2, 3, 6], [3, -6, 2], [6, 2, -3]]


def turned(squares: tuple[int, ...], center: tuple[int, ...], constant: int) -> list[list[float]]:
    """Return Σ squares[k] (rows[k]·(x - center))² + constant with rows TURN; unit axes are TURN / 7."""
    rows = np.array(TURN)
    a = sum(s * np.outer(row, row) for s, row in zip(squares, rows, strict=True))
    b = -a @ np.array(center)
    c = np.array(center) @ a @ np.array(center) + constant
    return np.block([[a, b[:, None]], [b[None, :], np.array([[c]])]]).astype(float).tolist()


@pytest.mark.parametrize(
    ("squares", "constant", "kind", "order", "semi_axes"),
    [
        # semi-axis = sqrt(|constant| / (49 square))
        ((1, 4, 9), -1764, "ellipsoid", (0, 1, 2), (6, 3, 2)),
        ((9, 1, 4), -1764, "ellipsoid", (1, 2, 0), (6, 3, 2)),
        ((-1, 4, 9), -1764, "one-sheet hyperboloid", (1, 2, 0), (3, 2, 6)),
        ((4, 9, -1), 1764, "two-sheet hyperboloid", (0, 1, 2), (3, 2, 6)),
        ((1, -9, 4), 0, "elliptic cone", (0, 2, 1), (3, 1.5)),
        ((0, 9, 4), -1764, "elliptic cylinder", (2, 1, 0), (3, 2)),
        ((9, 0, -4), -1764, "hyperbolic cylinder", (0, 2, 1), (2, 3)),
        ((9, 0, -4), 1764, "hyperbolic cylinder", (2, 0, 1), (3, 2)),
        ((0, 0, 9), -1764, "parallel planes", (2,), (2,)),
        ((0, -9, 4), 0, "crossing planes", (1, 2, 0), (1.5,)),
    ],
)
def test_center_axes_and_semi_axes_are_those_it_was_made_of(squares, constant, kind, order, semi_axes):
    center = (3, -5, 2)
    found = co.Quadric(matrix=turned(squares, center, constant)).classification
    assert found.kind == kind
    assert found.semi_axes == semi_axes
    unit = np.array(TURN) / 7
    for axis, k in zip(found.axes, order, strict=False):
        assert abs(np.dot(axis, unit[k])) == pytest.approx(1, abs=1e-15)
    flat = unit[[k for k in range(3) if squares[k] == 0]]  # nearest to the origin: without what lies along flat axes
    expected = np.array(center) - flat.T @ (flat @ np.array(center))
    np.testing.assert_allclose(found.center, expected, rtol=0, atol=1e-15)
    assert np.linalg.det(found.axes) == pytest.approx(1, abs=1e-14)


def test_paraboloids_have_a_vertex_and_radii_of_curvature():
    """y₁²/p₁ + y₂²/p₂ = 2 y₃: near the vertex the section along y₁ is a circle of radius p₁."""
    # 3 (x - 1)² + (y + 2)² = 6 (z - 5): p = 1 and 3
    found = co.Quadric(coefficients=dict(xx=3, yy=1, x=-6, y=4, z=-6, constant=37)).classification
    assert (found.kind, found.center, found.semi_axes) == ("elliptic paraboloid", (1, -2, 5), (3, 1))
    assert found.axes == ((0, 1, 0), (-1, 0, 0), (0, 0, 1))
    assert found.inside == "within the bowl"
    # x² = 4 (z - 1), nearest to the origin on the line of vertices y = anything
    found = co.Quadric(coefficients=dict(xx=-1, z=4, constant=-4)).classification
    assert (found.kind, found.center, found.semi_axes) == ("parabolic cylinder", (0, 0, 1), (2,))
    assert found.axes == ((1, 0, 0), (0, 0, 1), (0, -1, 0))
    assert found.inside == "outside"
    # x y = z is a saddle that rises along x = y
    found = co.Quadric(coefficients=dict(xy=1, z=-1)).classification
    assert (found.kind, found.semi_axes, found.axes[2]) == ("hyperbolic paraboloid", (1, 1), (0, 0, 1))
    assert found.axes[0] == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0))


def test_a_plane_has_its_normal_towards_the_inside():
    found = co.Quadric(coefficients=dict(x=2, y=-2, z=1, constant=-18)).classification
    assert found.kind == "plane"
    assert found.center == (4, -4, 2)
    assert found.axes[2] == pytest.approx((-2 / 3, 2 / 3, -1 / 3))


@pytest.mark.parametrize(("constant", "kind"), [(14.0, "elliptic cone"), (13.999999999999998, "one-sheet hyperboloid"),
                                                (14.000000000000002, "two-sheet hyperboloid")])  # fmt: skip
def test_the_last_bit_separates_a_cone_from_hyperboloids(constant, kind):
    # (x - 1)² + (y - 2)² - 9 (z - 1)² about its apex has the constant 1 + 4 - 9 = -4; shifted here to 14 - 18
    values = dict(xx=1, yy=1, zz=-9, x=-2, y=-4, z=18)
    found = co.Quadric(coefficients=values | dict(constant=constant - 18)).classification
    assert found.kind == kind
    assert found.revolution


def test_round_ones_are_recognised():
    ball = co.Quadric(coefficients=dict(xx=4, yy=4, zz=4, x=-8, constant=-5)).classification
    assert (ball.kind, ball.center, ball.semi_axes, ball.revolution) == ("sphere", (1, 0, 0), (1.5,), True)
    nearly = co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1e-100, constant=-1)).classification
    assert nearly.kind == "ellipsoid"
    assert not nearly.revolution
    disc = co.Quadric(coefficients=dict(xx=9, yy=1, zz=1, constant=-9)).classification
    assert disc.revolution
    assert disc.axes[2] == (1, 0, 0)
    assert disc.semi_axes == (3, 3, 1)


MOVES = {
    "turned": lambda s: s.rotate((1, 2, -1), 25).translate((3, -2, 1)),
    "stretched": lambda s: s.scale((1, -2, 0.5)).rotate((1, 0, 3), 100),
    "sheared": lambda s: s.transform([[1, 0.5, 0, 1], [0, 1, 0.3, 2], [0, 0, 1, 3], [0, 0, 0, 1]]),
    "far": lambda s: s.translate((1e5, 2e5, -1e5)),
}


@pytest.mark.parametrize(
    ("values", "kind", "inside", "move"),
    sampled([(*each, move) for each in CLASSES for move in MOVES], 5),
    ids=lambda item: str(item) if item else "",
)
def test_moved_ones_are_described_in_the_world(values, kind, inside, move):
    """Kind and side stay.

    The center is at the image under the motion's matrix, and ends of real semi-axes on the surface.
    """
    still, moved = co.Quadric(coefficients=values), MOVES[move](co.Quadric(coefficients=values))
    found = moved.classification
    assert (found.kind, found.inside) == (kind, inside)
    if kind == "empty":
        return
    back, at = moved.motion.inverse_matrix, np.array(found.center)
    size = 1 + np.abs(moved.motion.matrix).max()

    def value(point: np.ndarray) -> float:
        own = np.array([*(back[:3, :3] @ point + back[:3, 3]), 1.0])
        return float(own @ np.array([[float(c) for c in row] for row in still.symmetric]) @ own)

    axes = np.array(found.axes)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    on = {
        "ellipsoid": (0, 1, 2), "one-sheet hyperboloid": (0, 1), "two-sheet hyperboloid": (2,),
        "elliptic cylinder": (0, 1), "hyperbolic cylinder": (0,), "parallel planes": (0,),
    }.get(kind)  # fmt: skip
    tips = [at + sign * found.semi_axes[k] * axes[k] for k in on or () for sign in (1, -1)]
    if kind == "elliptic cone":
        tips = [at + axes[2] + found.semi_axes[k] * axes[k] for k in (0, 1)]
    if kind == "crossing planes":
        tips = [at + axes[0] + found.semi_axes[0] * axes[1], at + 2 * axes[2]]
    if kind in ("elliptic paraboloid", "hyperbolic paraboloid", "parabolic cylinder"):
        opening = axes[1 if kind == "parabolic cylinder" else 2]
        tips = [at + axes[0] + opening / (2 * found.semi_axes[0])]
    for point in [*tips, *([] if on else [at])]:
        assert abs(value(point)) < 1e-12 * size**2


@settings(max_examples=40, deadline=None)
@given(st.lists(whole, min_size=10, max_size=10))
def test_inertia_is_that_of_the_eigenvalues(entries):
    q = np.zeros((4, 4))
    q[np.triu_indices(4)] = entries
    q = q + q.T
    values = np.linalg.eigvalsh(q)
    if (np.abs(values) < 1e-6).any():
        rank = np.linalg.matrix_rank(q, tol=1e-6)
        assert sum(rational.inertia([[Fraction(c) for c in row] for row in q.tolist()])) == rank
    else:
        expected = (int((values > 0).sum()), int((values < 0).sum()))
        assert rational.inertia([[Fraction(c) for c in row] for row in q.tolist()]) == expected


def test_the_description_is_one_line():
    text = str(co.Quadric(coefficients=dict(xx=1, yy=0.25, zz=-1, constant=-1)).classification)
    assert text == (
        "one-sheet hyperboloid; center (0, 0, 0); semi-axes 2, 1, 1; axes (0, 1, 0) (-1, 0, 0) (0, 0, 1); "
        "inside: around the last axis"
    )
