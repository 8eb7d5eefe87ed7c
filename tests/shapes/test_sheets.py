"""Sheets: carried planes, clips, normals that stay on their side, uv and bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conicoid.geometry.cell import PolygonSheet, SurfaceSheet
from conicoid.geometry.shape import PrimitiveSheet
from conicoid.geometry.sheets import CylinderPatch, Disc, Plane, Polygon, Triangle
from conicoid.geometry.transform import Motion

from .evaluate import contains, gradient, uv, value
from .motions import MOTIONS, carried, random_motion

INF = math.inf
R2, R3 = math.sqrt(2), math.sqrt(3)
X, Z = (1, 0, 0), (0, 0, 1)
A, B, C = (0.3, -0.2, 0.1), (1.1, 0.9, 1.6), (2.0, -1.0, 0.5)
CONCAVE = ((0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1))
SHEETS = {
    "plane": Plane((1, 2, -3), 0.5),
    "disc": Disc(A, (1, 1, 0.5), 1.5),
    "triangle": Triangle(A, B, C),
    "polygon": Polygon(CONCAVE),
    "patch": CylinderPatch(A, B, 0.7, 30, 100, C),
    "wide patch": CylinderPatch(A, B, 0.7, 0, 300, C),
    "tube": CylinderPatch(A, B, 0.7),
}
sheets = pytest.mark.parametrize("sheet", SHEETS.values(), ids=SHEETS)


def frame(sheet: PrimitiveSheet) -> Motion:
    return sheet.under()


def surface_of(lowered: SurfaceSheet | PolygonSheet):
    return lowered.plane if isinstance(lowered, PolygonSheet) else lowered.surface


def samples(sheet: PrimitiveSheet, count: int = 300) -> np.ndarray:
    """Points of the sheet in its own frame, from its definition."""
    rng = np.random.default_rng(5)
    if isinstance(sheet, Plane):
        n = np.array(sheet.normal)
        points = rng.normal(size=(count, 3))
        return points - ((points @ n - sheet.offset) / (n @ n))[:, None] * n
    if isinstance(sheet, Disc):
        r, angle = sheet.radius * np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), np.zeros(count)])
    if isinstance(sheet, CylinderPatch):
        angle = np.radians(rng.uniform(sheet.start_angle, sheet.end_angle, count))
        height = rng.uniform(0, sheet.length, count)
        return np.column_stack([sheet.radius * np.cos(angle), sheet.radius * np.sin(angle), height])
    vertices = np.array(sheet.vertices if isinstance(sheet, Polygon) else (sheet.a, sheet.b, sheet.c))[:3]
    return rng.dirichlet((1, 1, 1), count) @ vertices


@sheets
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_the_surface_and_clip_are_carried(sheet, motion) -> None:
    whole = frame(sheet).then(motion)
    lowered, points = sheet.sheet(whole), samples(sheet)
    world = carried(whole, points)
    surface = surface_of(lowered)
    scale = np.linalg.norm(gradient(surface, world), axis=1)
    assert (abs(value(surface, world)) / scale).max() < 1e-13
    if isinstance(lowered, SurfaceSheet) and lowered.clip is not None:
        assert contains(lowered.clip, world).all()
        # Beyond the ends and rims the clip refuses
        beyond = points * (1.3, 1.3, 1) if isinstance(sheet, Disc) else points + np.array((0, 0, sheet.length * 1.01))
        outside = carried(whole, beyond[np.linalg.norm(points[:, :2], axis=1) > 0.8 * sheet.radius])
        assert not contains(lowered.clip, outside).any()
    if isinstance(lowered, PolygonSheet):
        own = np.array(sheet.vertices if isinstance(sheet, Polygon) else (sheet.a, sheet.b, sheet.c))
        corners = np.array([[float(x) for x in corner] for corner in lowered.vertices])
        np.testing.assert_allclose(corners, carried(whole, own), atol=1e-14)


@sheets
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_the_normal_stays_on_its_physical_side(sheet, motion) -> None:
    """A point lifted off the sheet along its normal stays on the normal's side, also in a mirror."""
    whole = frame(sheet).then(motion)
    before, after = surface_of(sheet.sheet(frame(sheet))), surface_of(sheet.sheet(whole))
    start = carried(frame(sheet), samples(sheet, 20))
    normal = gradient(before, start)
    lifted = start + 1e-3 * normal / np.linalg.norm(normal, axis=1)[:, None]
    assert (value(before, lifted) > 0).all()
    assert (value(after, carried(motion, lifted)) > 0).all()


@sheets
def test_uv_goes_with_the_sheet(sheet) -> None:
    own, moved = frame(sheet), random_motion(np.random.default_rng(2))
    first, second = sheet.sheet(own), sheet.sheet(own.then(moved))
    for point in samples(sheet, 20):
        here = carried(own, point)
        assert uv(first.uv, here) == pytest.approx(uv(second.uv, carried(moved, here)), abs=1e-12)


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


@sheets
def test_bounds_hold_the_sheet(sheet) -> None:
    rng = np.random.default_rng(9)
    points = samples(sheet, 3000)
    for motion in (random_motion(rng) for _ in range(5)):
        low, high = sheet.bounds_under(motion)
        world = carried(frame(sheet).then(motion), points)
        slack = 1e-14 * abs(world).max()
        assert (world >= low - slack).all()
        assert (world <= high + slack).all()
        if np.isfinite(low).all() and not isinstance(sheet, Polygon):
            assert (world.min(axis=0) - low).max() < 0.2 * (high - low).max()


def test_polygon_normals_are_newells() -> None:
    """The exercise of the ray tracing notes: its three points lie in x + 2 y + z + 2 = 0."""
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


def test_one_sidedness_is_kept() -> None:
    sheet = Plane(Z, 1, one_sided=True).scale((1, 1, -1))
    lowered = sheet.sheet(sheet.under())
    assert lowered.one_sided
    assert lowered.side == 1
    assert float(lowered.surface.normal[2]) == -1
