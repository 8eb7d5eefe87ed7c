"""One surface has one name, however it is written and whatever moved it there."""

from __future__ import annotations

import numpy as np
import pytest

from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.polyhedron import Polyhedron
from conicoid.geometry.primitives import Box, Cone, Cylinder, HalfSpace, Sphere
from conicoid.geometry.quadrics import (
    DoubleCone,
    Ellipsoid,
    EllipticCone,
    EllipticCylinder,
    EllipticParaboloid,
    HyperbolicCylinder,
    HyperbolicParaboloid,
    OneSheetHyperboloid,
    ParabolicCylinder,
    TwoSheetHyperboloid,
)
from conicoid.geometry.shape import PrimitiveSolid

from .catalogue import MATRIX, SAMPLES, Sample
from .evaluate import faces

Q = Quadric
P, R = (1, 2, 3), (-2, 0.3, 5)


def keys(shape: PrimitiveSolid) -> dict[int, tuple]:
    """Face number -> (key, sense) in the world, the sense turned to the face's inside."""
    motion, found = shape.under(), {}
    for number, face in faces(shape.tree()).items():
        key, sense = face.surface.moved(motion).key()
        found[number] = (key, sense * face.inside)
    return found


def surface(shape: PrimitiveSolid, number: int = 0) -> tuple:
    return keys(shape)[number]


SAME = [
    (Sphere(1), Ellipsoid((1, 1, 1))),
    (Sphere(1), Q(matrix=np.diag([1, 1, 1, -1]))),
    (Sphere(1), Q(matrix=np.diag([3, 3, 3, -3]))),
    (Sphere(0.7, P), Ellipsoid((0.7, 0.7, 0.7), P)),
    (Sphere(3), Sphere(1).scale(3)),
    (Sphere(3), Ellipsoid((1, 2, 3)).scale((3, 1.5, 1))),
    (Sphere(2, P), Sphere(2).translate(P)),
    (Sphere(2, P), Sphere(2).rotate((1, 1, 0), 33).translate(P)),
    (Sphere(1), Sphere(1).scale((1, -1, 1))),
    (Ellipsoid((1, 2, 4)), Ellipsoid.from_coefficients(1, 0.25, 0.0625)),
    (Ellipsoid((1, 2, 4)), Sphere(1).scale((1, 2, 4))),
    (Ellipsoid((1, 2, 3)), Q(coefficients=dict(xx=36, yy=9, zz=4, constant=-36))),
    (Cylinder((0, 0, 0), (0, 0, 1), 2), Cylinder((0, 0, 1), (0, 0, 5), 2)),
    (Cylinder((0, 0, 0), P, 0.3), Cylinder(P, (2, 4, 6), 0.3)),
    (Cylinder((0, 0, 0), P, 0.3), Cylinder(P, (0, 0, 0), 0.3)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2), Cone((0, 0, 0), (0, 0, 1), 2, 2)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2), EllipticCylinder(0.25, 0.25, (0, 1))),
    (Cylinder((0, 0, 0), (0, 0, 1), 2), Q(coefficients=dict(xx=1, yy=1, constant=-4))),
    # A cone split in two frusta, written from either end
    (Cone((0, 0, 0), (0, 0, 2), 3, 1), Cone((0, 0, 2), (0, 0, 3), 1, 0)),
    (Cone((0, 0, 0), (0, 0, 2), 3, 1), Cone((0, 0, 2), (0, 0, 0), 1, 3)),
    (Cone((0, 0, 0), P, 3, 1), Cone(P, (0, 0, 0), 1, 3)),
    (Cone((0, 0, 0), (0, 0, 1), 0, 2), DoubleCone(2)),
    (DoubleCone(2), EllipticCone(1, 1, 4)),
    (DoubleCone(2, (-1, 1)), Q(coefficients=dict(xx=1, yy=1, zz=-4))),
    (EllipticParaboloid(1, 4), Q(coefficients=dict(xx=1, yy=4, z=-1))),
    (HyperbolicParaboloid(1, 4), Q(coefficients=dict(xx=1, yy=-4, z=-1))),
    (OneSheetHyperboloid(1, 2, 3), Q(coefficients=dict(xx=1, yy=2, zz=-3, constant=-1))),
    (TwoSheetHyperboloid(1, 2, 3), Q(coefficients=dict(xx=1, yy=2, zz=-3, constant=1))),
    (HyperbolicCylinder(1, 4), Q(coefficients=dict(xx=1, yy=-4, constant=-1))),
    (ParabolicCylinder(3), Q(coefficients=dict(xx=1, y=-6))),
    (HalfSpace((0, 0, 1), 2), HalfSpace((0, 0, 3), 6)),
    (HalfSpace((1, 2, 2), 3), Q(coefficients=dict(x=1, y=2, z=2, constant=-3))),
    (HalfSpace((1, 2, 2), 3), Polyhedron(((2, 4, 4),), (6,))),
    (HalfSpace((0, 0, 1), 2), HalfSpace((0, 0, 1), 0).translate((5, 7, 2))),
    # Only the symmetric part counts; x y once is half on either side of the diagonal
    (Q(coefficients=dict(xx=1, xy=1, constant=-1)), Q(matrix=[[1, 1, 0, 0], [0] * 4, [0] * 4, [0, 0, 0, -1]])),
    (Q(coefficients=dict(xx=1, xy=1, constant=-1)), Q(matrix=[[1, 0.5, 0, 0], [0.5, 0, 0, 0], [0] * 4, [0, 0, 0, -1]])),
    (Q(matrix=MATRIX), Q(matrix=np.array(MATRIX) * 4)),
    (Q(coefficients=dict(xy=1, z=-1)), HyperbolicParaboloid(0.5, 0.5).rotate((0, 0, 1), 45)),
]  # fmt: skip


@pytest.mark.parametrize(("first", "second"), SAME, ids=lambda shape: repr(shape)[:50])
def test_the_same_surface_has_the_same_name_and_sense(first, second) -> None:
    assert surface(first) == surface(second)


DIFFERENT = [
    (Sphere(1), Sphere(1 + 2**-52)),
    (Sphere(1), Sphere(1, (1e-100, 0, 0))),
    (HalfSpace((0, 0, 1), 1), HalfSpace((0, 0, 1), 1 + 2**-52)),
    (Cylinder((0, 0, 0), P, 0.3), Cylinder((0, 0, 0), (1, 2, 3 + 2**-50), 0.3)),
    (Cone((0, 0, 0), (0, 0, 1), 1, 1 + 2**-52), Cone((0, 0, 0), (0, 0, 1), 1, 1)),
]


@pytest.mark.parametrize(("first", "second"), DIFFERENT, ids=lambda shape: repr(shape)[:50])
def test_surfaces_that_differ_by_an_ulp_differ(first, second) -> None:
    assert surface(first)[0] != surface(second)[0]


def test_a_box_shares_its_planes_with_half_spaces_and_boxes() -> None:
    box, other = keys(Box((0, 0, 0), (1, 2, 3))), keys(Box((1, 0, 0), (4, 5, 6)))
    assert box[1] == surface(HalfSpace((2, 0, 0), 2))
    assert box[0] == surface(HalfSpace((-1, 0, 0), 0))
    assert box[1][0] == other[0][0]
    assert box[1][1] == -other[0][1]
    assert box[2] == other[2]


def test_the_other_side_of_a_quadric_has_the_opposite_sense() -> None:
    for values in (dict(xx=1, yy=1, zz=1, constant=-1), dict(xx=1, xy=3, zz=2, y=1), dict(x=1, z=2, constant=5)):
        name, sense = surface(Q(coefficients=values))
        other, opposite = surface(Q(coefficients={key: -value for key, value in values.items()}))
        assert name == other
        assert sense == -opposite


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.name)
def test_motions_that_are_equal_on_paper_give_equal_names(sample: Sample) -> None:
    shape = sample.shape
    plain = keys(shape)
    for motion in (
        lambda s: s.translate(P).translate((-1, -2, -3)),
        lambda s: s.rotate(P, 123).rotate(P, -123),
        lambda s: s.rotate(R, 120).rotate(R, 240),
        lambda s: s.scale(-4).scale(-0.25),
        lambda s: s.scale((2, -1, 8)).scale((0.5, -1, 0.125)),
        lambda s: s.translate(R).rotate((0, 0, 1), 90).rotate((0, 0, 1), 270).translate((2, -0.3, -5)),
    ):
        assert keys(motion(shape)) == plain
    third = shape.rotate((0, 1, 0), 30).rotate((0, 1, 0), 30).rotate((0, 1, 0), 30)
    assert keys(third) == keys(shape.rotate((0, 1, 0), 90))
    assert keys(third) == keys(shape.transform([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]))
