"""Faces of shapes: numbers, uv, normals; and the names of their surfaces."""

import math

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

from .samples import MATRIX, SAMPLES, Sample, faces, gradient, uv, value

# --- Face numbers, uv and outward normals at points, by hand


HERE, Z, X = (0, 0, 0), (0, 0, 1), (1, 0, 0)
R2, R3 = math.sqrt(2), math.sqrt(3)
TUBE = Cylinder(HERE, (0, 0, 2), 1, 30, 240, X)

# shape, point in its own frame, face, uv, direction of the outward normal
AT = [
    (Ellipsoid((1, 2, 3)), (0, 2, 0), 0, (0.25, 0.5), (0, 1, 0)),
    (Ellipsoid((1, 2, 3)), (0, 0, 3), 0, (None, 1), Z),
    (Ellipsoid((1, 2, 3)), (-1, 0, 0), 0, (0.5, 0.5), (-1, 0, 0)),
    (Ellipsoid((1, 2, 3), z_range=(-1.5, 4.5)), (0, 0, 3), 0, (None, 1), Z),
    (Ellipsoid((1, 2, 3), z_range=(-1.5, 1.5)), (0, -2, 0), 0, (0.75, 0.5), (0, -1, 0)),
    # The cut at z = ±1.5 has the half-axes sqrt(3)/2 and sqrt(3)
    (Ellipsoid((1, 2, 3), z_range=(-1.5, 1.5)), (R3 / 4, R3 / 2, 1.5), 2, (0.5, 0.5), Z),
    (Ellipsoid((1, 2, 3), z_range=(-1.5, 1.5)), (0, -R3, -1.5), 1, (0, -1), (0, 0, -1)),
    (Ellipsoid.from_coefficients(4, 1, 1), (0.5, 0, 0), 0, (0, 0.5), X),
    (Box((0, 0, 0), (2, 4, 8)), (0, 1, 2), 0, (0.25, 0.25), (-1, 0, 0)),
    (Box((0, 0, 0), (2, 4, 8)), (2, 1, 2), 1, (0.25, 0.25), X),
    (Box((0, 0, 0), (2, 4, 8)), (1, 0, 2), 2, (0.5, 0.25), (0, -1, 0)),
    (Box((0, 0, 0), (2, 4, 8)), (1, 4, 2), 3, (0.5, 0.25), (0, 1, 0)),
    (Box((0, 0, 0), (2, 4, 8)), (1, 3, 0), 4, (0.5, 0.75), (0, 0, -1)),
    (Box((0, 0, 0), (2, 4, 8)), (1, 3, 8), 5, (0.5, 0.75), Z),
    (TUBE, (0, 1, 0.5), 0, (0.25, 0.25), (0, 1, 0)),
    (TUBE, (0.25, 0.5, 0), 1, (0.25, 0.5), (0, 0, -1)),
    (TUBE, (-0.25, 0.5, 2), 2, (-0.25, 0.5), Z),
    # Half way out on the walls at 30° and 240°
    (TUBE, (R3 / 4, 0.25, 1), 3, (0.5, 0.5), (0.5, -R3 / 2, 0)),
    (TUBE, (-0.25, -R3 / 4, 0.5), 4, (0.5, 0.25), (R3 / 2, -0.5, 0)),
    (Cylinder(HERE, (0, 0, 2), 1, 0, 180, X), (0.5, 0, 1), 3, (0.5, 0.5), (0, -1, 0)),
    (Cylinder(HERE, (0, 0, 2), 1, 0, 180, X), (-0.5, 0, 1), 3, (-0.5, 0.5), (0, -1, 0)),
    (Cone(HERE, (0, 0, 2), 2, 0), (1, 0, 1), 0, (0, 0.5), (1, 0, 1)),
    (Cone(HERE, (0, 0, 2), 2, 0), (1, 1, 0), 1, (0.5, 0.5), (0, 0, -1)),
    (Cone(HERE, (0, 0, 2), 1, 2), (0, 1.5, 1), 0, (0.25, 0.5), (0, 2, -1)),
    (Cone(HERE, (0, 0, 2), 1, 2), (1, 1, 2), 2, (0.5, 0.5), Z),
    (DoubleCone(1, (-1, 3)), (0, -1, 1), 0, (0.75, 0.5), (0, -1, -1)),
    (DoubleCone(1, (-1, 3)), (0.5, 0, -1), 1, (0.5, 0), (0, 0, -1)),
    (DoubleCone(2, (-1, 3)), (0, 3, 3), 2, (0, 0.5), Z),
    (DoubleCone(1), (0, 5, -5), 0, (0.25, -5), (0, 1, 1)),
    (EllipticParaboloid(1, 4), (2, 0, 4), 0, (0, 4), (4, 0, -1)),
    (EllipticParaboloid(1, 4, (-1, 8)), (2, 0, 4), 0, (0, 0.5), (4, 0, -1)),
    (EllipticParaboloid(1, 4, (1, 4)), (1, 0.5, 4), 2, (0.5, 0.5), Z),
    (EllipticParaboloid(1, 4, (1, 4)), (0.5, 0, 1), 1, (0.5, 0), (0, 0, -1)),
    (HyperbolicParaboloid(1, 2), (3, 2, 1), 0, (3, 2), (6, -8, -1)),
    (HyperbolicParaboloid(1, 1, Box((-2, -1, -9), (2, 3, 9))), (1, 1, 0), 0, (0.75, 0.5), (2, -2, -1)),
    (HyperbolicParaboloid(1, 1, Box((-2, -1, -9), (2, 3, 9))), (1, 1, 9), 6, (0.75, 0.5), Z),
    (HyperbolicParaboloid(1, 1, Box((-2, -1, -9), (2, 3, 9))), (-2, 1, 9), 1, (0.5, 1), (-1, 0, 0)),
    (OneSheetHyperboloid(1, 4, 3, (-1, 1)), (0, 0.5, 0), 0, (0.25, 0.5), (0, 1, 0)),
    (OneSheetHyperboloid(1, 4, 3, (-1, 1)), (1, 0.5, 1), 2, (0.5, 0.5), Z),
    (TwoSheetHyperboloid(1, 4, 5, (-1, 1)), (2, 0, 1), 0, (0, 1), (2, 0, -5)),
    (TwoSheetHyperboloid(1, 4, 5, (-1, 1)), (1, 0.5, -1), 1, (0.5, 0.5), (0, 0, -1)),
    (EllipticCone(1, 4, 1, (0, 2)), (0, -0.5, 1), 0, (0.75, 0.5), (0, -2, -1)),
    (EllipticCone(1, 4, 1, (0, 2)), (1, 0.5, 2), 2, (0.5, 0.5), Z),
    (EllipticCylinder(1, 4, (0, 4)), (0, -0.5, 1), 0, (0.75, 0.25), (0, -1, 0)),
    (EllipticCylinder(1, 4, (0, 4)), (0.5, 0.25, 0), 1, (0.5, 0.5), (0, 0, -1)),
    (HyperbolicCylinder(1, 3), (-2, 1, 7), 0, (1, 7), (-2, -3, 0)),
    (HyperbolicCylinder(1, 3, Box((-9, -1, 0), (9, 3, 8))), (2, 1, 2), 0, (0.5, 0.25), (2, -3, 0)),
    (HyperbolicCylinder(1, 3, Box((-9, -1, 0), (9, 3, 8))), (0, 3, 2), 4, (0.5, 0.25), (0, 1, 0)),
    (ParabolicCylinder(2), (2, 1, 7), 0, (2, 7), (2, -2, 0)),
    (ParabolicCylinder(2, Box((-4, 0, 0), (4, 9, 14))), (2, 1, 7), 0, (0.75, 0.5), (2, -2, 0)),
    (HalfSpace((0, 0, 5), 10), (3, 4, 2), 0, (3, 4), Z),
    (HalfSpace((1, 0, 0), 2), (2, 3, 4), 0, (3, 4), X),
    (Polyhedron((Z, (0, 0, -1), X), (1, 1, 3)), (3, 5, 0.5), 2, (5, 0.5), X),
    (Quadric(coefficients=dict(xx=1, yy=1, zz=1, x=-2, z=-4, constant=1)), (1, 2, 2), 0, (0.25, 0), (0, 1, 0)),
    (Quadric(coefficients=dict(xx=-1, yy=-1, zz=-1, constant=4)), (2, 0, 0), 0, (0, 0), (-1, 0, 0)),
    (Quadric(coefficients=dict(z=2, constant=-4)), (3, 4, 2), 0, (3, 4), Z),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "point", "number", "expected", "normal"), AT, ids=lambda v: repr(v)[:40])
def test_face_uv_and_normal(shape, point, number, expected, normal) -> None:
    face = faces(shape.tree())[number]
    assert value(face.surface, np.array(point, float)) == pytest.approx(0, abs=1e-14)
    for found, wanted in zip(uv(face.uv, point), expected, strict=True):
        assert wanted is None or found == pytest.approx(wanted, abs=1e-14)
    outward = face.inside * gradient(face.surface, np.array(point, float))
    np.testing.assert_allclose(outward / np.linalg.norm(outward), normal / np.linalg.norm(normal), atol=1e-14)


def test_numbers_of_faces() -> None:
    def numbers(shape) -> list[int]:
        return sorted(faces(shape.tree()))

    assert numbers(TUBE) == [0, 1, 2, 3, 4]
    assert numbers(Cylinder(HERE, Z, 1, 0, 180, X)) == [0, 1, 2, 3]
    assert numbers(Cylinder(HERE, Z, 1)) == [0, 1, 2]
    assert numbers(Ellipsoid()) == [0]
    assert numbers(Ellipsoid(z_range=(-9, 1))) == [0, 2]
    assert numbers(Ellipsoid(z_range=(-3, 3))) == [0]
    assert numbers(EllipticParaboloid(1, 1, (0, 1))) == [0, 2]
    assert numbers(TwoSheetHyperboloid(1, 1, 1, (0, 2))) == [0, 1, 2]
    assert numbers(DoubleCone(1, (-math.inf, 1))) == [0, 2]
    assert numbers(ParabolicCylinder(1, Box())) == [0, 1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.name)
def test_cells_have_one_quadric_first_and_rising_numbers(sample: Sample) -> None:
    tree = sample.shape.tree()
    numbers = list(faces(tree))
    assert numbers == sorted(numbers)
    for cell in [tree] if hasattr(tree, "faces") else [part for part in tree.parts if hasattr(part, "faces")]:
        quadrics = [i for i, face in enumerate(cell.faces) if hasattr(face.surface, "squares")]
        assert quadrics in ([], [0])


# --- One surface has one name in every form, under every motion


Q = Quadric
P, R = (1, 2, 3), (-2, 0.3, 5)


def keys(shape: PrimitiveSolid) -> dict[int, tuple]:
    """Return face number -> (key, sense) in the world, the sense turned to the face's inside."""
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
