"""Conics, lenses and mirrors against the sag formula itself, in Python's floats."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.conic import ConicWall, _wall_supports, conic_reaches

CONSTANTS = [-4.0, -1.5, -1.0, -0.6, 0.0, 1.5]


def sag(r, radius, conic):
    """z = c r² / (1 + sqrt(1 - (1 + k) c² r²))"""
    if math.isinf(radius):
        return np.zeros_like(r)
    c = 1 / radius
    return c * r**2 / (1 + np.sqrt(1 - (1 + conic) * c**2 * r**2))


def points(seed, semi, low, high, count=4000):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-semi, semi, (count, 2)), rng.uniform(low, high, count)])


def apart(heights, *walls, by=1e-9):
    """Points that lie clear of all walls."""
    return np.all([np.abs(heights - wall) > by for wall in walls], axis=0)


@pytest.mark.parametrize("conic", CONSTANTS)
@pytest.mark.parametrize("radius", [2.0, -2.0])
def test_a_sheet_is_met_where_the_sag_says_and_nowhere_else(radius, conic):
    """Along z through a disc wider than the aperture: one crossing within it, none beyond, no other half."""
    sheet = co.ConicSheet(radius, conic, 2.4, hole=0.5)
    rng = np.random.default_rng(5)
    xy = rng.uniform(-1.6, 1.6, (2000, 2))
    r = np.hypot(*xy.T)
    xy, r = xy[np.abs(r - 1.2) > 1e-9], r[np.abs(r - 1.2) > 1e-9]
    found = co.Scene([sheet]).crossings(np.column_stack([xy, np.full(len(xy), -99)]), (0, 0, 1), t_min=-math.inf)
    on = (r < 1.2) & (r > 0.25)
    assert np.array_equal(np.diff(found.offsets), on.astype(int))
    assert found.t - 99 == pytest.approx(sag(r[on], radius, conic), abs=2e-14)
    assert found.entering.all()  # the normal looks towards -z


@pytest.mark.parametrize("conic", CONSTANTS)
@pytest.mark.parametrize("radius", [1.5, -1.5])
def test_a_conic_holds_what_lies_between_the_sag_and_the_rim(radius, conic):
    solid = co.Scene([co.Conic(radius, conic, 1.8)])
    xyz = points(1, 1.0, -6, 6)
    r = np.hypot(xyz[:, 0], xyz[:, 1])
    within = r < 0.9
    end = sag(np.array(0.9), radius, conic)
    wall = sag(np.where(within, r, 0.0), radius, conic)
    expected = within & (np.minimum(wall, end) <= xyz[:, 2]) & (xyz[:, 2] <= np.maximum(wall, end))
    assert np.array_equal(solid.contains(xyz), expected)
    assert co.Conic(radius, conic, 1.8).sheet() == co.ConicSheet(radius, conic, 1.8)


LENSES = {
    "biconvex": (20, -30, 4, 12, 0, 0), "biconcave": (-20, 30, 1, 12, 0, 0), "meniscus": (15, 25, 3, 12, 0, 0),
    "plano-convex": (math.inf, -12, 4, 12, 0, 0), "plano-concave": (math.inf, 12, 1, 12, 0, 0), "plate": (math.inf, math.inf, 2, 12, 0, 0),
    "thick rod": (7, -7, 60, 12, 0, 0), "thick concave": (-7, 7, 60, 12, 0, 0), "ball": (6, -6, 12, 12, 0, 0),
    "hyperbolic": (8, -8, 60, 12, -3, -2), "hyperbolic hollow": (-8, 8, 60, 12, -3, -2), "parabolic": (9, -11, 6, 12, -1, -1),
    "oblate": (12, -12, 5, 12, 1.5, 2), "mixed meniscus": (-9, -10, 3, 12, -5, 0.5), "long prolate": (6.2, 6.4, 3, 12, -0.7, -0.8),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "aperture"),
    [(name, aperture) for name in LENSES for aperture in (None, 9.0) if name != "ball" or not aperture],
)
def test_a_lens_is_what_lies_between_its_faces(name, aperture):
    front, back, thickness, diameter, k1, k2 = LENSES[name]
    lens = co.Lens(front, back, thickness, diameter, k1, k2, aperture, aperture)
    xyz = points(2, 6.5, -12, thickness + 12)
    r = np.hypot(xyz[:, 0], xyz[:, 1])
    at = np.minimum(np.minimum(r, 6), (aperture or diameter) / 2)
    low, high = sag(at, front, k1), thickness + sag(at, back, k2)
    clear = apart(xyz[:, 2], low, high)
    expected = (r <= 6) & (low <= xyz[:, 2]) & (xyz[:, 2] <= high)
    assert expected.any()
    assert np.array_equal(co.Scene([lens]).contains(xyz)[clear], expected[clear])
    box = np.array([[-6, -6, low[r <= 6].min()], [6, 6, high[r <= 6].max()]])
    ends = np.array(lens.bounds)
    assert (ends[0] <= box[0] + 1e-12).all()
    assert (ends[1] >= box[1] - 1e-12).all()
    middle = np.linspace(0, (aperture or diameter) / 2, 4001)
    assert ends[0][2] == pytest.approx(sag(middle, front, k1).min(), abs=1e-12)
    assert ends[1][2] == pytest.approx(thickness + sag(middle, back, k2).max(), abs=1e-12)


@pytest.mark.parametrize("thickness", [3.0, -3.0])
@pytest.mark.parametrize(("radius", "conic"), [(-9, -1), (-12, -2.5), (9, 0), (math.inf, 0), (11, 0.5)])
def test_a_mirror_lies_between_the_conic_and_its_back(radius, conic, thickness):
    mirror = co.Scene([co.Mirror(radius, conic, 10, thickness, hole=2)])
    xyz = points(3, 5.5, -6, 6)
    r = np.hypot(xyz[:, 0], xyz[:, 1])
    wall = sag(np.minimum(r, 5), radius, conic)
    expected = (r > 1) & (r < 5) & (np.minimum(wall, thickness) < xyz[:, 2]) & (xyz[:, 2] < np.maximum(wall, thickness))
    clear = apart(xyz[:, 2], wall, thickness)
    assert np.array_equal(mirror.contains(xyz)[clear], expected[clear])


def test_faces_are_those_that_the_docs_number():
    lens = co.Scene([co.Lens(-20, 30, 1, 12, front_aperture=8, back_aperture=10)])
    origins = [(1, 0, -9), (1, 0, 9), (9, 0, 0.5), (5, 0, -9), (5.5, 0, 9)]
    directions = [(0, 0, 1), (0, 0, -1), (-1, 0, 0), (0, 0, 1), (0, 0, -1)]
    assert lens.first_hit(origins, directions).face.tolist() == [0, 1, 2, 3, 4]
    mirror = co.Scene([co.Mirror(-20, -1, 12, 2, hole=4)])
    assert mirror.first_hit(
        [*origins[1:3], (3, 0, -9), (0, 0, 1)], [*directions[1:3], (0, 0, 1), (1, 0, 0)]
    ).face.tolist() == [-1, 2, 0, 3]


def test_elements_of_a_group_share_their_walls():
    """Every ray through a triplet crosses four surfaces: six walls, of which two and two are one, to the last bit."""
    group = co.LensGroup((40.1, -30.3, math.inf, -60.7), (5.1, 1.3, 2.7), 20, (1.6, 1.7, 1.5), (0, -1.3, 0, 0.4))
    rng = np.random.default_rng(7)
    origins = np.column_stack([rng.uniform(-5, 5, (500, 2)), np.full(500, -30.0)])
    tilted = np.column_stack([rng.uniform(-0.05, 0.05, (500, 2)), np.ones(500)])
    scene = co.Scene([body.rotate((1, 2, 3), 40).translate((0.1, 0.2, 0.3)) for body in group])
    turned = co.Scene([*group])
    for one, start, way in ((turned, origins, tilted), (scene, *_carried(origins, tilted))):
        found = one.crossings(start, way, t_min=-math.inf)
        assert (np.diff(found.offsets) == 6).all()
        t, surface = found.t.reshape(-1, 6), found.surface.reshape(-1, 6)
        assert (t[:, 1] == t[:, 2]).all()
        assert (t[:, 3] == t[:, 4]).all()
        assert (surface[:, 1] == surface[:, 2]).all()
        assert (surface[:, 3] == surface[:, 4]).all()
    assert co.check(turned) == []


def _carried(origins, directions):
    """Rays moved as the group is."""
    axis, angle = np.array([1, 2, 3]) / math.sqrt(14), math.radians(40)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return origins @ turn.T + (0.1, 0.2, 0.3), directions @ turn.T


REFUSED = [
    (lambda: co.Conic(0), r"Conic: radius_of_curvature must not be 0"),
    (lambda: co.Conic(math.inf), r"Conic: radius_of_curvature must be finite"),
    (lambda: co.Conic(1, 0, 2.1), r"Conic: aperture must not be over .* is 2 wide, got 2.1"),
    (lambda: co.Conic(1, 3, 1.01), r"Conic: aperture must not be over .* is 1 wide"),
    (lambda: co.ConicSheet(1, 0, 1, 1), r"ConicSheet: hole must be below aperture = 1, got 1"),
    (lambda: co.Lens(10, -10, 1, 10), r"Lens: thickness, .* must leave glass everywhere: at 5 from the axis .* crossed by 1.67949"),
    (lambda: co.Lens(10, 10, 1, 21), r"Lens: diameter must not be over what front_radius and front_conic give"),
    (lambda: co.Lens(10, 10, 1, 5, back_aperture=6), r"Lens: back_aperture must not be over diameter = 5, got 6"),
    (lambda: co.Mirror(10, 0, 10, 1), r"Mirror: thickness must not be 0, and lie beyond the rim, .* z = 1.33975, got 1"),
    (lambda: co.Mirror(10, 0, 1, 0), r"Mirror: thickness must not be 0"),
    (lambda: co.Stop(3, 3), r"Stop: aperture must be below diameter = 3, got 3"),
    (lambda: co.Prism(180, 1, 1), r"Prism: apex_angle must be between 0 and 180 degrees, got 180"),
    (lambda: co.LensGroup((1, 2), (1, 2), 1, (1.5, 1.6)), r"LensGroup: radii must be 3 entries to go with thicknesses, got 2"),
    (lambda: co.LensGroup((10, -10, 10), (1, 2), 10, (1.5, 1.6)), r"LensGroup: .* element 0: Lens: thickness"),
    (lambda: co.Doublet((10, -10, 10, 5), (1, 2, 3), 10, (1.5, 1.6, 2)), r"Doublet: thicknesses must be 2 numbers"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_is_no_lens_is_refused(case):
    make, told = REFUSED[case]
    with pytest.raises(ValueError, match=told):
        make()


def test_the_glass_may_be_thinnest_between_axis_and_edge():
    """Two faces of one curvature at the vertex, the front's conic falling back: they touch in the middle first."""
    front, back, k1, k2 = 10.0, 10.4, -8.0, 0.5
    r = np.linspace(0, 6, 100001)
    gap = sag(r, back, k2) - sag(r, front, k1)
    least = float(-gap.min())
    assert least > 0 < gap[-1] - gap.min()
    assert 0 < gap.argmin() < 100000
    co.Lens(front, back, least * 1.0001, 12, k1, k2)
    with pytest.raises(ValueError, match="must leave glass everywhere"):
        co.Lens(front, back, least * 0.9999, 12, k1, k2)


def test_supports_in_floats_are_above_the_exact_ones_and_near_them() -> None:
    """Walls of any size and conic, in directions of any slope, beside the maximum over rim, hole and cap in 300 bits."""
    rng, walls = np.random.default_rng(11), []
    while len(walls) < 80:
        radius = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 6))
        conic = float(rng.choice([0, -1, rng.uniform(-3, 3), -(10 ** rng.uniform(0, 3))]))
        semi = float(abs(radius) * 10 ** rng.uniform(-5, 1.5))
        if conic_reaches(radius, conic, semi):
            wall = ConicWall(radius, conic, float(rng.choice([0, 1, 1e4])), semi, semi * float(rng.choice([1, 1.5])))
            walls.append((wall, bool(rng.random() < 0.7), float(semi * rng.choice([0, 0.3]))))
    ways = rng.normal(size=(len(walls), 2, 3)) * (1, 1, 100)
    found = _wall_supports(walls, ways)
    with mpmath.workprec(300):
        for (wall, hollow, hole), own, reaches in zip(walls, ways.tolist(), found.tolist(), strict=True):
            r, steep, vertex = mpmath.mpf(wall.radius), 1 + mpmath.mpf(wall.conic), mpmath.mpf(wall.vertex)
            for (x, y, z), reach in zip(own, reaches, strict=True):
                across, slope = mpmath.hypot(x, y), -mpmath.hypot(x, y) / z
                at = [(wall.semi, wall.edge), *([(hole, hole)] if hole or hollow else [])]
                if hollow and slope * r > 0 and 1 + steep * slope**2 > 0:
                    # z' = slope there
                    distance = abs(slope * r) / mpmath.sqrt(1 + steep * slope**2)
                    at += [(distance, distance)] if hole <= distance <= wall.semi else []
                sags = [
                    q * q / (r * (1 + mpmath.sqrt(1 - steep * q * q / r**2))) for q in (mpmath.mpf(q) for q, _ in at)
                ]
                true = max(z * (vertex + sag) + across * edge for sag, (_, edge) in zip(sags, at, strict=True))
                size = abs(z) * (abs(vertex) + abs(sags[0])) + across * wall.edge
                assert math.isnan(reach) or true <= reach <= true + 1e-9 * size
