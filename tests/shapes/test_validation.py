"""Senseless parameters are refused with the shape, the field, what was expected and the value found."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, strategies as st

from conicoid.geometry.primitives import Box, Sphere
from conicoid.geometry.quadrics import Ellipsoid
from conicoid.geometry.registry import REGISTRY

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
    """A square in a skew plane: its corners round off the plane by an ulp or so."""
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
    made = {"coefficients": (1.0, 1.0, size)} if by_coefficients else {"radii": (1.0, 2.0, size)}
    square = 1 / Fraction(size) if by_coefficients else Fraction(size) ** 2
    below = low < 0 or Fraction(low) ** 2 < square
    above = high > 0 or Fraction(high) ** 2 < square
    if below and above:
        assert Ellipsoid(z_range=(low, high), **made).z_range == (low, high)
    else:
        with pytest.raises(ValueError, match="z_range must leave a part of the solid"):
            Ellipsoid(z_range=(low, high), **made)
