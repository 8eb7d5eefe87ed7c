"""Crossings of the reference against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .items import Item, clipped, combined
from .quadratics import Table, compare
from .solids import bodies
from .trace import Trace, body_at

INF = math.inf
S2, S3 = math.sqrt(2), math.sqrt(3)
UP = ((0, 0, 0), (0, 0, 1))
BOX = Item("Box", {"low": (-1, -1, -1), "high": (1, 1, 1)})
BALL = Item("Sphere", {"radius": 5, "center": (0, 0, 0)})
TUBE = Item("Cylinder", {"start": (0, 0, -1), "end": (0, 0, 1), "radius": 5.0})
RODS = {k: Item("Cylinder", {"start": UP[0], "end": UP[1], "radius": 1, "start_angle": 0, "end_angle": k, "reference": (1, 0, 7)}) for k in (90, 270)}  # fmt: skip
FIRST, SECOND = (Item("Sphere", {"radius": 1, "center": (x, 0, 0)}) for x in (0, 1))
CONE = Item("Cone", {"start": (0, 0, -1), "end": (0, 0, 1), "start_radius": 2, "end_radius": 1})
NAPPES = Item("DoubleCone", {"slope": 1.0})
HOLLOW = Item("Polygon", {"vertices": [(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)]})
LEFT, RIGHT = (Item("Box", {"low": (x, -1, -1), "high": (x + 2, 1, 1)}) for x in (-2, 0))


def trace(items, *rays, start=None):
    origins, directions = (np.array(x, float) for x in zip(*rays, strict=True))
    return Trace(Table(bodies(items)), origins, directions, start)


def found(item, origin, direction):
    c = trace([item], (origin, direction)).crossings
    return list(zip(c.t.tolist(), c.entering.tolist(), c.face.tolist(), strict=True))


def turned(item, axis, degrees):
    return item.moved(("rotate", axis, degrees))


def quadric(**coefficients):
    return Item("Quadric", {"coefficients": coefficients})


CHORDS = {
    "ball": (BALL, (3, -9, 0), (0, 1, 0), [5, 13], [0, 0]),
    "chord of half a speed": (Item("Sphere", {"radius": 2, "center": (1, 0, 0)}), (-5, 1, 0), (2, 0, 0), [(6 - S3) / 2, (6 + S3) / 2], [0, 0]),
    "ellipsoid": (Item("Ellipsoid", {"radii": (1, 2, 3)}), (0, 1, -5), (0, 0, 1), [5 - 1.5 * S3, 5 + 1.5 * S3], [0, 0]),
    "barrel": (Item("Ellipsoid", {"radii": (1, 2, 3), "center": (0, 0, 1), "z_range": (-1, 2)}), (0, 1, -5), (0, 0, 1), [5, 8], [1, 2]),
    "range that reaches too far": (Item("Ellipsoid", {"radii": (1, 2, 3), "z_range": (-3, 2)}), (0, 0, -5), (0, 0, 1), [2, 7], [0, 2]),
    "box": (BOX, (-3, 0, 0), (2, 0, 0), [1, 2], [0, 1]),
    "diagonal": (BOX, (-3, -3, -3), (1, 1, 1), [2, 4], [0, 1]),
    "turned box": (turned(BOX, (0, 0, 1), 45), (-5, 0, 0), (1, 0, 0), [5 - S2, 5 + S2], [0, 1]),
    "box turned by any angle, along the axis": (turned(BOX, (0, 0, 1), 37), (0, 0, -3), (0, 0, 1), [2, 4], [4, 5]),
    "oblique cylinder": (Item("Cylinder", {"start": (0, 0, 0), "end": (2, 2, 0), "radius": 1}), (1, 1, -3), (0, 0, 1), [2, 4], [0, 0]),
    "along its axis": (Item("Cylinder", {"start": (0, 0, 0), "end": (2, 2, 0), "radius": 1}), (-1, -1, 0), (1, 1, 0), [1, 3], [1, 2]),
    "tube on its side": (turned(TUBE, (1, 1, 1), 120), (0, 3, -9), (0, 0, 1), [5, 13], [0, 0]),
    "pacman": (RODS[270], (-2, -0.125, 0.5), (1, 0, 0), [2 - math.sqrt(63) / 8, 2], [0, 4]),
    "cone": (Item("Cone", {"start": (0, 0, 0), "end": (0, 0, 2), "start_radius": 1, "end_radius": 0.5}), (0.75, 0, -1), (0, 0, 1), [1, 2], [1, 0]),
    "through a rim": (CONE, (2, 3, 3), (-2, -2, -2), [1, 13 / 7], [0, 0]),
    "through a turned rim": (turned(CONE, (0, 0, 1), 105), (2, 3, 3), (-2, -2, -2), [1, 13 / 7], [0, 0]),
    "double cone": (Item("DoubleCone", {"slope": 2, "z_range": (-1, 3)}), (2, 0, -10), (0, 0, 1), [11, 13], [0, 2]),
    "paraboloid": (Item("EllipticParaboloid", {"A": 2.0, "E": 0.5}), (0, -50, 2), (0, 1, 0), [48, 52], [0, 0]),
    "one sheet": (Item("OneSheetHyperboloid", {"A": 1.0, "E": 0.25, "H": 0.75}), (0, -50, 2), (0, 1, 0), [46, 54], [0, 0]),
    "two sheets": (Item("TwoSheetHyperboloid", {"A": 1.0, "E": 0.25, "H": 1.25}), (0, -50, 2), (0, 1, 0), [46, 54], [0, 0]),
    "elliptic cone": (Item("EllipticCone", {"A": 1.0, "E": 0.25, "H": 4.0}), (-50, 0, 2), (1, 0, 0), [46, 54], [0, 0]),
    "elliptic cylinder": (Item("EllipticCylinder", {"A": 4.0, "E": 0.25, "z_range": (-INF, 7)}), (0, -50, 2), (0, 1, 0), [48, 52], [0, 0]),
    "hyperbolic cylinder": (Item("HyperbolicCylinder", {"A": 4, "E": 1}), (-5, 0, 0), (1, 0, 0), [4.5, 5.5], [0, 0]),
    "parabolic cylinder": (Item("ParabolicCylinder", {"G": 2}), (-5, 4, 0), (1, 0, 0), [1, 9], [0, 0]),
    "product": (quadric(xy=1, constant=-1), (-3, -3, 0), (1, 1, 0), [2, 4], [0, 0]),
    "matrix": (Item("Quadric", {"matrix": [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -4]]}), (-9, 0, 0), (1, 0, 0), [8 - math.sqrt(5), 8 + math.sqrt(5)], [0, 0]),
    "union": (combined("Union", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [4, 7], [0, 1]),
    "intersection": (combined("Intersection", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [5, 6], [1, 0]),
    "difference": (combined("Difference", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [4, 5], [0, 1]),
    "walls in common": (combined("Union", LEFT, RIGHT), (-3, 0, 0), (1, 0, 0), [1, 5], [0, 7]),
    "roots in common": (combined("Union", *(Item("Sphere", {"radius": 1.25, "center": (x, 0, 0)}) for x in (0, 2))), (1, -4, 0), (0, 1, 0), [3.25, 4.75], [0, 0]),
    "within the high face, as if that stood further out": (BOX, (1, 0, -5), (0, 0, 1), [4, 6], [4, 5]),
    "plane": (Item("Plane", {"normal": (0, 0, -2), "offset": -4, "one_sided": True}), (0, 0, 0), (0, 0, 1), [2], [0]),
    "disc": (Item("Disc", {"center": (0, 0, 1), "normal": (0, 0, -1), "radius": 1}), (0.5, 0.5, 0), (0, 0, 1), [1], [0]),
    "triangle": (Item("Triangle", {"a": (0, 0, 0), "b": (4, 0, 0), "c": (0, 4, 0)}), (1, 1, 3), (0, 0, -1), [3], [0]),
    "hollow polygon": (HOLLOW, (2, 1 - 2.0**-51, 3), (0, 0, -1), [3], [0]),
    "clipped sheet": (clipped(Item("Plane", {"normal": (0, 0, -1), "offset": 0}), BALL), (3, -3, -1), (0, 0, 1), [1], [0]),
}  # fmt: skip


@pytest.mark.parametrize("name", CHORDS)
def test_chords(name):
    item, origin, direction, times, faces = CHORDS[name]
    answer = found(item, origin, direction)
    assert [t for t, _, _ in answer] == pytest.approx(times, rel=1e-15)
    assert [(entering, face) for _, entering, face in answer] == list(zip([True, False], faces, strict=False))


@pytest.mark.parametrize(
    ("item", "origin", "direction"),
    [
        (BALL, (5, -9, 0), (0, 1, 0)),
        (TUBE, (5, 0, -9), (0, 0, 1)),  # along a ruling
        (BOX, (-2, 0, 0), (1, 1, 0)),  # through an edge
        (BOX, (-1, 0, -5), (0, 0, 1)),  # within the low face
        (NAPPES, (0, -3, 0), (0, 1, 0)),  # through the apex, outside
        (NAPPES, (-1, 0, -2), (1, 0, 2)),  # and inside all along
        (RODS[90], (-0.5, -2, 0.5), (0, 1, 0)),
        (combined("Difference", LEFT, LEFT), (-3, 0, 0), (1, 0, 0)),
        (Item("Plane", {"normal": (0, 0, 2), "offset": 4, "one_sided": True}), (0, 0, 0), (0, 0, 1)),
        (Item("Disc", {"center": (0, 0, 1), "normal": (0, 0, 1), "radius": 1}), (0.8, 0.8, 0), (0, 0, 1)),
        (HOLLOW, (2, 2, 3), (0, 0, -1)),
        (clipped(Item("Plane", {"normal": (0, 0, 1), "offset": 0}), BALL, "outside"), (1, 1, -1), (0, 0, 1)),
    ],
)  # fmt: skip
def test_misses_and_touches(item, origin, direction):
    assert found(item, origin, direction) == []


def test_sheets_say_which_side_is_met():
    sheet = Item("Plane", {"normal": (0, 0, 2), "offset": 4})
    assert found(sheet, (0, 0, 0), (0, 0, 1)) == [(2, False, 0)]
    assert found(sheet.moved(("scale", -1)), (0, 0, 0), (0, 0, -1)) == [(2, False, 0)]
    assert found(sheet.moved(("scale", -1)), (0, 0, -5), (0, 0, 1)) == [(3, True, 0)]
    patch = Item(
        "CylinderPatch",
        {"start": UP[0], "end": UP[1], "radius": 1, "start_angle": 0, "end_angle": 90, "reference": (1, 0, 0)},
    )
    assert found(patch, (-3, 0.6, 0.5), (1, 0, 0)) == [(pytest.approx(3.8), False, 0)]


def test_faces_of_a_wedge():
    """The diagonal of the wedge, from the axis on."""
    wedge = Item(
        "Cylinder",
        {"start": UP[0], "end": UP[1], "radius": 2, "start_angle": 15, "end_angle": 75, "reference": (1, 0, 0)},
    )
    assert found(wedge, (0, 0, 0.5), (1, 1, 0)) == [(0, True, 3), (pytest.approx(S2), False, 0)]


def test_roots_that_agree_to_many_digits_are_parted():
    """x² + y² + 2^-k z² <= 1 and x² + y² <= 1 along x, at z = 1: they differ by 2^-(k + 1) of their place."""
    tube, ray = quadric(xx=1, yy=1, constant=-1), ((-5, 0, 1), (1, 0, 0))
    for size, expected in ((2.0**-100, [1, 1, 1, 1]), (2.0**-1000, [1, 1, 1, 1]), (0.0, [1, 1])):
        (groups,) = trace([quadric(xx=1, yy=1, zz=size, constant=-1), tube], ray).groups
        assert [len(group) for group in groups] == expected
        if size:
            assert compare(groups[0][0], groups[1][0]) == -1
            assert [group[0].surface for group in groups] == [1, 0, 0, 1]
    (groups,) = trace([quadric(xx=1, yy=1, zz=1, z=-1, constant=-1), tube], ray).groups  # in common where z = 0 or 1
    assert [len(group) for group in groups] == [2, 2]


def test_rounded_roots_that_agree_are_equal():
    """Two spheres turned by one angle, whose circle in common the ray meets."""
    item = combined("Union", *(Item("Sphere", {"radius": 1.25, "center": (x, 0, 0)}) for x in (0, 2)))
    (groups,) = trace([turned(item, (0, 0, 1), 37.5)], ((0, 0, 0), (0, 0, 1))).groups
    assert [len(group) for group in groups] == [1, 1]
    pair = [turned(BOX, (1, 2, 3), 37.5), turned(turned(BOX, (1, 2, 3), 30), (1, 2, 3), 7.5)]
    table = Table(bodies(pair))
    assert len(table.forms) == 6


def test_a_start_is_taken_out():
    table = Table(bodies([BALL]))
    c = Trace(table, np.array([[3.0, 4.0, 0.0]]), np.array([[-1.0, -1.0, 0.0]]), np.array([0])).crossings.ahead()
    assert c.t.tolist() == pytest.approx([7])
    c = Trace(table, np.array([[3.0, 4.0, 0.0]]), np.array([[-(2.0**-40), 0.0, 1.0]]), np.array([0])).crossings.ahead()
    assert c.t.tolist() == pytest.approx([6 * 2.0**-40])


def test_body_at():
    table = Table(bodies([combined("Difference", BALL, BOX), BOX]))
    points = np.array([[3.0, 4.0, 0.0], [np.nextafter(3, 9), 4.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert body_at(table, points).tolist() == [0, -1, 1, 1]
    assert [body_at(Table(bodies([RODS[270]])), np.array([[x, y, 0.5]]))[0] for x, y in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))] == [0, 0, 0, -1]  # fmt: skip
