"""Senseless parameters are refused; arrays of callers; quick checks of plain vectors and triangles."""

import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import conicoid as co
from conicoid._util import validation as validate
from conicoid._util.records import is_member_sorted, unique_first_with_inverse, unique_sorted, unique_with_inverse
from conicoid._util.validation import is_masked
from conicoid.geometry.primitives import Box, Sphere
from conicoid.geometry.quadrics import Ellipsoid
from conicoid.geometry.registry import REGISTRY

# --- Errors about senseless parameters name the shape, the field, the expected and the found value


NAN, INF = math.nan, math.inf
HERE, Z = (0, 0, 0), (0, 0, 1)
SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))

REFUSED = [
    ("Ellipsoid", dict(radii=(1, 0, 2)), r"radii\[1\] must be > 0, got 0.0"),
    ("Ellipsoid", dict(radii=(1, 2)), r"radii must be 3 numbers, got 2"),
    ("Ellipsoid", dict(radii=(1, NAN, 1)), r"radii\[1\] must be finite, got nan"),
    ("Ellipsoid", dict(center=(0, INF, 0)), r"center\[1\] must be finite, got inf"),
    ("Ellipsoid", dict(z_range=(1, 1)), r"z_range must have low < high, got \(1.0, 1.0\)"),
    ("Ellipsoid", dict(z_range=(2, -2)), r"z_range must have low < high, got \(2.0, -2.0\)"),
    ("Ellipsoid", dict(z_range=(0, NAN)), r"z_range\[1\] must be a number, got nan"),
    ("Ellipsoid", dict(z_range=3), r"z_range must be \(low, high\), got 3"),
    ("Ellipsoid", dict(coefficients=(1, -2, 1)), r"E must be > 0, got -2.0"),
    ("Ellipsoid", dict(radii=(1, 1, 1), coefficients=(1, 2, 1)), r"radii must be left out where coefficients"),
    ("Box", dict(low=(0, 0, 0), high=(1, 0, 1)), r"high\[1\] must be > low\[1\] = 0.0, got 0.0"),
    ("Box", dict(high=(1, 1, INF)), r"high\[2\] must be finite, got inf"),
    ("Box", dict(low="abc"), r"low must be 3 numbers, got 'abc'"),
    ("Cylinder", dict(start=HERE, end=HERE, radius=1), r"end must differ from start, got \(0.0, 0.0, 0.0\)"),
    ("Cylinder", dict(start=HERE, end=Z, radius=0), r"radius must be > 0, got 0.0"),
    ("Cylinder", dict(start=HERE, end=Z, radius=-1), r"radius must be > 0, got -1.0"),
    ("Cylinder", dict(start=HERE, end=Z, radius=1, end_angle=90), r"reference must be given with angles"),
    (
        "Cylinder",
        dict(start=HERE, end=Z, radius=1, start_angle=90, end_angle=90, reference=(1, 0, 0)),
        r"in \(0, 360\]",
    ),
    ("Cylinder", dict(start=HERE, end=Z, radius=1, end_angle=361, reference=(1, 0, 0)), r"in \(0, 360\], got 361.0"),
    ("Cylinder", dict(start=HERE, end=Z, radius=1, reference=(0, 0, 5)), r"reference must lie off the axis"),
    (
        "Cylinder",
        dict(start=(-1e308, 0, 0), end=(1e308, 0, 0), radius=1),
        r"start\[0\] must be 0 or of magnitude 1e-100",
    ),
    ("Cone", dict(start=HERE, end=Z, start_radius=0, end_radius=0), r"must not both be 0"),
    ("Cone", dict(start=HERE, end=Z, start_radius=-1, end_radius=0), r"start_radius must be >= 0, got -1.0"),
    ("Cone", dict(start=Z, end=Z, start_radius=1, end_radius=0), r"end must differ from start"),
    ("DoubleCone", dict(slope=0), r"slope must be > 0, got 0.0"),
    ("DoubleCone", dict(slope=True), r"slope must be a number, got True"),
    ("EllipticParaboloid", dict(A=1, E=0), r"E must be > 0, got 0.0"),
    ("EllipticParaboloid", dict(A=NAN, E=1), r"A must be finite, got nan"),
    ("HyperbolicParaboloid", dict(A=-1, E=1), r"A must be > 0, got -1.0"),
    ("HyperbolicParaboloid", dict(A=1, E=1, within=(0, 1)), r"within must be a Box or None, got tuple"),
    ("HyperbolicParaboloid", dict(A=1, E=1, within=Sphere()), r"within must be a Box or None, got Sphere"),
    ("OneSheetHyperboloid", dict(A=1, E=1, H=0), r"H must be > 0, got 0.0"),
    ("TwoSheetHyperboloid", dict(A=1, E=1, H=1, z_range=(INF, INF)), r"z_range must have low < high"),
    ("EllipticCone", dict(A=1, E=1, H=-1), r"H must be > 0, got -1.0"),
    ("EllipticCylinder", dict(A=0, E=1), r"A must be > 0, got 0.0"),
    ("HyperbolicCylinder", dict(A=1, E=INF), r"E must be finite, got inf"),
    ("HyperbolicCylinder", dict(A=1, E=1, within="box"), r"within must be a Box or None, got str"),
    ("ParabolicCylinder", dict(G=0), r"G must be > 0, got 0.0"),
    ("ParabolicCylinder", dict(G=1, within=5), r"within must be a Box or None, got int"),
    ("Quadric", dict(), r"exactly one of matrix and coefficients must be given, got neither"),
    ("Quadric", dict(matrix=[[0] * 4] * 4, coefficients={"x": 1}), r"exactly one of .* got both"),
    ("Quadric", dict(matrix=[[0] * 4] * 4), r"matrix must hold more than a constant, got 0.0 alone"),
    ("Quadric", dict(matrix=[[0, 1, 0, 0], [-1, 0, 0, 0], [0] * 4, [0, 0, 0, 3]]), r"got 3.0 alone"),
    ("Quadric", dict(matrix=[[1, 0], [0, 1]]), r"matrix must be a 4 x 4 matrix, got 2 rows"),
    ("Quadric", dict(matrix=[[1, 0, 0, NAN]] * 4), r"matrix\[0\]\[3\] must be finite, got nan"),
    ("Quadric", dict(coefficients={"constant": -2}), r"coefficients must hold more than a constant, got -2.0 alone"),
    ("Quadric", dict(coefficients={"yx": 1}), r"coefficients must be named xx, yy, .*, got 'yx'"),
    ("Quadric", dict(coefficients={"xx": "a"}), r"coefficients.xx must be a number, got 'a'"),
    ("Quadric", dict(coefficients=[1, 2]), r"coefficients must be a mapping"),
    ("HalfSpace", dict(normal=HERE, offset=1), r"normal must not be zero, got \(0.0, 0.0, 0.0\)"),
    ("HalfSpace", dict(normal=Z, offset=NAN), r"offset must be finite, got nan"),
    ("HalfSpace", dict(normal=Z, offset=INF), r"offset must be finite, got inf"),
    ("Polyhedron", dict(normals=[], offsets=[]), r"normals must have at least 1 points, got 0"),
    ("Polyhedron", dict(normals=[Z, HERE], offsets=[1, 1]), r"normals\[1\] must not be zero"),
    ("Polyhedron", dict(normals=[Z, Z], offsets=[1]), r"offsets must be 2 numbers, got 1"),
    ("Plane", dict(normal=HERE, offset=0), r"normal must not be zero"),
    ("Plane", dict(normal=Z, offset=0, one_sided=1), r"one_sided must be true or false, got 1"),
    ("Disc", dict(center=HERE, normal=HERE, radius=1), r"normal must not be zero"),
    ("Disc", dict(center=HERE, normal=Z, radius=0), r"radius must be > 0, got 0.0"),
    ("Triangle", dict(a=HERE, b=Z, c=(0, 0, 2)), r"a, b, c must not lie on a line"),
    ("Triangle", dict(a=HERE, b=HERE, c=Z), r"a, b, c must not lie on a line"),
    ("Triangle", dict(a=HERE, b=Z, c=(0, NAN, 0)), r"c\[1\] must be finite, got nan"),
    ("Polygon", dict(vertices=SQUARE[:2]), r"vertices must have at least 3 points, got 2"),
    ("Polygon", dict(vertices=[HERE, Z, (0, 0, 3)]), r"vertices must enclose an area"),
    ("Polygon", dict(vertices=[*SQUARE[:3], (0, 1, 1e-13)]), r"vertices must lie in a plane .* at 2.5e-14 from"),
    ("CylinderPatch", dict(start=HERE, end=Z, radius=0), r"radius must be > 0, got 0.0"),
    ("CylinderPatch", dict(start=HERE, end=HERE, radius=1), r"end must differ from start"),
    ("CylinderPatch", dict(start=HERE, end=Z, radius=1, end_angle=90), r"reference must be given with angles"),
]


@pytest.mark.parametrize(("name", "fields", "message"), REFUSED, ids=[f"{n}-{f}"[:60] for n, f, _ in REFUSED])
def test_refused(name: str, fields: dict, message: str) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: .*{message}"):
        REGISTRY[name](**fields)


def test_singular_motions_are_refused() -> None:
    for move in (
        lambda s: s.scale(0),
        lambda s: s.scale((1, 0, 1)),
        lambda s: s.transform([[1, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
        lambda s: s.transform([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]),
        lambda s: s.rotate((0, 0, 0), 30),
    ):
        with pytest.raises(ValueError, match="must"):
            move(Box())


def test_ends_of_ranges_may_be_infinite() -> None:
    assert REGISTRY["DoubleCone"](z_range=(-INF, 1)).z_range == (-INF, 1)
    assert REGISTRY["EllipticCylinder"](1, 1, (0, INF)).z_range == (0, INF)


def test_polygons_may_be_flat_to_rounding() -> None:
    """The corners of a square in a skew plane are rounded off it by an ulp or so."""
    third = 1 / 3
    corners = [
        (1 + third, 0.1, -third),
        (0.1, 1 + third, -third),
        (-1, third, 1.1 - third),
        (0.7, -0.9 + third, 0.2 - third + 0.1),
    ]
    on_plane = [(x, y, 1.1 - x - y) for x, y, _ in corners]
    assert len(REGISTRY["Polygon"](on_plane).vertices) == 4
    far = [(x + 1e6, y, 1.1 - (x + 1e6) - y) for x, y, _ in corners]
    assert len(REGISTRY["Polygon"](far).vertices) == 4


def test_fields_become_plain_floats_and_tuples() -> None:
    import numpy as np

    shape = REGISTRY["Ellipsoid"](np.array([1, 2, 3]), np.zeros(3, np.float32), np.array([-1, 1]))
    assert shape == REGISTRY["Ellipsoid"]((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), (-1.0, 1.0))
    assert all(type(x) is float for x in (*shape.radii, *shape.center, *shape.z_range))
    assert hash(shape) == hash(REGISTRY["Ellipsoid"](z_range=(-1, 1)))


_near_one = st.builds(
    lambda sign, ulps: sign * (1.0 + ulps * 2.0**-52), st.sampled_from((-1.0, 1.0)), st.integers(-2, 3)
)


@given(
    st.one_of(st.just(1.0), st.floats(1e-3, 1e3)),
    st.tuples(*[st.one_of(_near_one, st.sampled_from([0.0, -math.inf, math.inf]), st.floats(-2, 2))] * 2),
    st.booleans(),
)
def test_cut_ellipsoids_keep_some_of_the_solid(size: float, ends: tuple[float, float], by_coefficients: bool) -> None:
    """The open interval of the ends meets ]-c, c[: with c² = 1 / H of an ellipsoid by coefficients, in fractions."""
    low, high = sorted(end * size if abs(end) > 1e-90 else 0.0 for end in ends)
    if not low < high or low == math.inf or high == -math.inf:
        return
    size_fields = {"coefficients": (1.0, 1.0, size)} if by_coefficients else {"radii": (1.0, 2.0, size)}
    square = 1 / Fraction(size) if by_coefficients else Fraction(size) ** 2
    below = low < 0 or Fraction(low) ** 2 < square
    above = high > 0 or Fraction(high) ** 2 < square
    if below and above:
        assert Ellipsoid(z_range=(low, high), **size_fields).z_range == (low, high)
    else:
        with pytest.raises(ValueError, match="z_range must leave a part of the solid"):
            Ellipsoid(z_range=(low, high), **size_fields)


# --- Arrays of callers: masked entries are found everywhere, and never read as NaN


MASKED = np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0])
WHOLE = np.ma.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("values", "found"),
    [
        (MASKED, True), (WHOLE, False), ([MASKED], True), ([[1, 2, 3], MASKED], True), ((WHOLE, [1, 2, 3]), False),
        ([[1.0, 2.0, np.ma.masked]], True), ([WHOLE, [1, np.ma.masked]], True), ([[[[MASKED]]]], True),
        ([np.zeros(3)], False), ("text", False), (["text", b"bytes"], False), (range(3), False), ([], False), (3, False),
        (None, False),
    ],
)  # fmt: skip
def test_masked_entries(values, found):
    assert is_masked(values) == found


@pytest.mark.parametrize("origins", [[(0, 0, 1), (0, 0, np.ma.masked)], [np.zeros(3), MASKED]])
def test_they_are_refused_in_lists(origins):
    with pytest.raises(ValueError, match="Rays: origins must be an array of numbers .* without masked entries"):
        co.Rays(origins, (0, 0, 1))


# --- Quick checks of plain vectors and triangles give the results of closer ones


ODD: list[Any] = [
    0.0, -0.0, 1.0, -2.5, 3, True, None, "1", float("nan"), float("inf"), -float("inf"), 1e100, -1e100, 1e-100, -1e-100,
    1.0000000000000002e100, 9.999999999999999e-101, 5e-324, 1e200, np.float64(2), np.float32(2), np.int64(4), 10**400,
    Fraction(1, 2), 1j,
]  # fmt: skip


def outcome(value: Any, nonzero: bool) -> tuple[str, Any]:
    try:
        found = validate.check_vector("Sphere", "center", value, nonzero=nonzero)
    except ValueError as error:
        return "refused", str(error)
    assert all(type(x) is float for x in found)
    return "taken", list(map(str, found))


def check_alike(value: Any) -> None:
    for nonzero in (False, True):
        found = outcome(value, nonzero)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(validate, "_plain_vector", lambda _: None)
            assert outcome(value, nonzero) == found


def test_vectors_of_odd_numbers():
    for x, y in itertools.product(ODD, ODD):
        for sequence in (list, tuple):
            check_alike(sequence((x, y, 1.5)))
            check_alike(sequence((1.5, x, y)))
    assert outcome((0.0, -0.0, 0.0), True)[0] == "refused"


def test_vectors_of_odd_kinds():
    row = np.array([1.0, 2.0, 3.0])
    kinds = [
        row, row.astype(np.float32), row.astype(int), row.astype(bool), row[:2], row[None], np.array(1.0), row.astype(complex), row * np.nan,
        np.ma.masked_array(row, [0, 1, 0]), row.astype(object), np.array(["1", "2", "3"]), "123", b"123", {1.0, 2.0, 3.0},
        {1.0: 1, 2.0: 2, 3.0: 3}, [], (1.0, 2.0), (1.0, 2.0, 3.0, 4.0), iter([1.0, 2.0, 3.0]), 5, None, row[::-1], row.astype(">f8"),
    ]  # fmt: skip
    for value in kinds:
        if not hasattr(value, "__next__"):
            check_alike(value)
    assert outcome(row, True) == ("taken", ["1.0", "2.0", "3.0"])


def on_a_line(a: Any, b: Any, c: Any) -> bool:
    """Return, in rational arithmetic, whether points are on a line."""
    p, q = ([Fraction(y) - Fraction(x) for x, y in zip(a, end, strict=True)] for end in (b, c))
    return all(p[i] * q[j] == p[j] * q[i] for i, j in ((0, 1), (0, 2), (1, 2)))


def triangles(seed: int) -> list[Any]:
    """Return corners on a line, beside it by an ulp or a little more, of all sizes, and far away."""
    rng = np.random.default_rng(seed)
    a, step = rng.integers(-9, 10, 3) * 10.0 ** rng.integers(-3, 4), rng.normal(size=3) * 10.0 ** rng.uniform(-40, 40)
    b, c = a + step, a + step * rng.integers(-3, 4)
    bent = c * (1 + rng.integers(-1, 2, 3) * 2.0**-52)
    far = a + step * (1 + rng.normal(size=3) * 2.0 ** rng.integers(-60, 0))
    return [(a, b, corner) for corner in (a, b, c, bent, far)]


def test_flat_triangles_are_refused_and_no_others():
    taken = 0
    for corners in itertools.chain.from_iterable(map(triangles, range(200))):
        plain = [tuple(corner.tolist()) for corner in corners]
        if on_a_line(*plain):
            with pytest.raises(ValueError, match="Triangle: a, b, c must not lie on a line"):
                co.Triangle(*plain)
        else:
            taken += co.Triangle(*plain).a == plain[0]
    assert 100 < taken < 900


def test_a_color_is_computed_once_and_refused_each_time():
    assert co.Body(co.Sphere(), "red").material is co.Body(co.Box(), "red").material
    for _ in range(2):
        with pytest.raises(ValueError, match="Body: material must be three linear numbers"):
            co.Body(co.Sphere(), "rad")


# --- Different numbers, against NumPy's `unique`


RANDOM = np.random.default_rng(7)
ARRAYS = [
    np.zeros(0, np.int64), np.array([5]), np.full(9, -2), RANDOM.integers(-4, 5, 1000), RANDOM.integers(0, 10**6, 500),
    RANDOM.integers(0, 50, 300).astype(np.int32), RANDOM.integers(-9, 9, 400) / 4.0, np.array([0.0, -0.0, np.inf, -np.inf, 0.0]),
]  # fmt: skip


@pytest.mark.parametrize("numbers", ARRAYS)
def test_they_are_those_of_numpy(numbers: np.ndarray) -> None:
    values, first, place = np.unique(numbers, return_index=True, return_inverse=True)
    assert np.array_equal(unique_sorted(numbers), values)
    assert np.array_equal(unique_sorted(numbers[:3], numbers, numbers[-2:]), values)
    found, places = unique_with_inverse(numbers)
    assert np.array_equal(found, values)
    assert np.array_equal(places, place)
    assert all(np.array_equal(*pair) for pair in zip(unique_first_with_inverse(numbers), (first, place), strict=True))
    assert np.array_equal(is_member_sorted(numbers, values[::2]), np.isin(numbers, values[::2]))
