"""Sheets: uv, normals and bounds at known places, and common planes."""

import math

import numpy as np
import pytest

from conicoid.geometry.cell import PolygonSheet, SurfaceSheet
from conicoid.geometry.sheets import CylinderPatch, Disc, Plane, Polygon, Triangle

from .samples import gradient, uv, value

INF = math.inf
R2, R3 = math.sqrt(2), math.sqrt(3)
X, Z = (1, 0, 0), (0, 0, 1)
A, B, C = (0.3, -0.2, 0.1), (1.1, 0.9, 1.6), (2.0, -1.0, 0.5)
CONCAVE = ((0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1))


def surface_of(lowered: SurfaceSheet | PolygonSheet):
    return lowered.plane if isinstance(lowered, PolygonSheet) else lowered.surface


AT = [
    (Plane((0, 0, 2), 6), (3, 4, 3), (3, 4), Z),
    (Plane((0, -1, 0), 2), (3, -2, 4), (3, 4), (0, -1, 0)),
    (Disc((1, 2, 3), Z, 2), (2, 2, 3), (0.5, 0), Z),
    (Disc((1, 2, 3), (0, 0, -5), 2), (2, 2, 3), (0.5, 0), (0, 0, -1)),
    (Disc((1, 2, 3), (0, 0, -5), 2), (1, 3, 3), (0, -0.5), (0, 0, -1)),
    (Triangle((0, 0, 0), (2, 0, 0), (0, 0, 4)), (0.5, 0, 1), (0.25, 0.25), (0, -1, 0)),
    (Triangle((1, 1, 1), (4, 1, 1), (1, 5, 1)), (4, 1, 1), (1, 0), Z),
    (Triangle((1, 1, 1), (4, 1, 1), (1, 5, 1)), (1, 5, 1), (0, 1), Z),
    (Triangle((1, 1, 1), (1, 5, 1), (4, 1, 1)), (1, 1, 1), (0, 0), (0, 0, -1)),
    # The first edge has length 4
    (Polygon(CONCAVE), (2, 1, 1), (0.5, 0.25), Z),
    (Polygon(CONCAVE[::-1]), (0, 0, 1), (1.6, 0.8), (0, 0, -1)),
    (CylinderPatch((0, 0, 1), (0, 0, 3), 2, 0, 90, (1, 0, 0)), (R2, R2, 1.5), (0.125, 0.25), (1, 1, 0)),
    (CylinderPatch((0, 0, 3), (0, 0, 1), 2, 0, 90, (1, 0, 0)), (R2, -R2, 1.5), (0.125, 0.75), (1, -1, 0)),
]  # fmt: skip


@pytest.mark.parametrize(("sheet", "point", "expected", "normal"), AT, ids=lambda v: repr(v)[:50])
def test_uv_and_normal_at_known_points(sheet, point, expected, normal) -> None:
    lowered = sheet.sheet(sheet.under())
    surface, point = surface_of(lowered), np.array(point, float)
    assert value(surface, point) == pytest.approx(0, abs=1e-13)
    if not (isinstance(sheet, Polygon) and sheet.vertices == CONCAVE[::-1]):
        assert uv(lowered.uv, point) == pytest.approx(expected, abs=1e-14)
    direction = gradient(surface, point)
    np.testing.assert_allclose(direction / np.linalg.norm(direction), normal / np.linalg.norm(normal), atol=1e-14)


def test_uv_of_a_polygon_runs_along_its_first_edge_and_across() -> None:
    """From (0, 4) to (2, 1), normal -z: along (2, -3), across normal × edge = (-3, -2)."""
    sheet = Polygon(CONCAVE[::-1])
    lowered = sheet.sheet(sheet.under())
    assert uv(lowered.uv, (0, 4, 1)) == pytest.approx((0, 0), abs=1e-15)
    assert uv(lowered.uv, (2, 1, 1)) == pytest.approx((1, 0), abs=1e-15)
    assert uv(lowered.uv, (-3, 2, 1)) == pytest.approx((0, 1), abs=1e-15)


KNOWN = [
    (Plane((0, 0, 2), 6), (-INF, -INF, 3), (INF, INF, 3)),
    (Plane((0, 1, 2), 6), (-INF, -INF, -INF), (INF, INF, INF)),
    (Plane((0, 0, 2), 6).rotate((0, 1, 0), 90), (3, -INF, -INF), (3, INF, INF)),
    (Disc((1, 2, 3), Z, 2), (-1, 0, 3), (3, 4, 3)),
    (Disc((0, 0, 0), (1, 1, 0), 1), (-1 / R2, -1 / R2, -1), (1 / R2, 1 / R2, 1)),
    (Disc((0, 0, 0), (1, 1, 1), 3), (-3 * math.sqrt(2 / 3),) * 3, (3 * math.sqrt(2 / 3),) * 3),
    (Triangle(A, B, C), (0.3, -1, 0.1), (2, 0.9, 1.6)),
    (Polygon(CONCAVE), (0, 0, 1), (4, 4, 1)),
    (CylinderPatch((0, 0, 0), Z, 2, 30, 60, X), (1, 1, 0), (R3, R3, 1)),
    (CylinderPatch((0, 0, 0), Z, 2, 45, 135, X), (-R2, R2, 0), (R2, 2, 1)),
    (CylinderPatch((0, 0, 0), Z, 2, 90, 360, X), (-2, -2, 0), (2, 2, 1)),
    (CylinderPatch((0, 0, 0), Z, 2), (-2, -2, 0), (2, 2, 1)),
]  # fmt: skip


@pytest.mark.parametrize(("sheet", "low", "high"), KNOWN, ids=lambda v: repr(v)[:50])
def test_known_bounds(sheet, low, high) -> None:
    np.testing.assert_allclose(sheet.bounds[0], low, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(sheet.bounds[1], high, rtol=1e-14, atol=1e-14)


def test_polygon_normals_are_newells() -> None:
    """In the exercise of the ray tracing notes three points lie in x + 2 y + z + 2 = 0."""
    sheet = Polygon(((-3, -3, 7), (3, -4, 3), (4, -5, 4)))
    plane = sheet.sheet(sheet.under()).plane
    normal = np.array([float(c) for c in plane.normal])
    np.testing.assert_array_equal(normal, -5 * np.array([1, 2, 1]))
    assert float(plane.offset) == 10


def test_coplanar_polygons_share_their_plane() -> None:
    first = Triangle((0, 0, 1), (3, 0, 2), (0, 5, 3))
    second = Polygon(((0, 0, 1), (3, 0, 2), (3, 5, 4), (0, 5, 3)))
    third = Triangle((0, 0, 1), (0, 5, 3), (3, 0, 2))
    turned = [sheet.rotate((1, 2, 3), 40).translate((1, 1, 7)) for sheet in (first, second, third)]
    (a, s), (b, t), (c, u) = (sheet.sheet(sheet.under()).plane.key() for sheet in turned)
    assert a == b == c
    assert s == t == -u


def test_sheets_stay_one_sided() -> None:
    sheet = Plane(Z, 1, one_sided=True).scale((1, 1, -1))
    lowered = sheet.sheet(sheet.under())
    assert lowered.one_sided
    assert lowered.side == 1
    assert float(lowered.surface.normal[2]) == -1
