"""Lenses, mirrors, prisms and corner cubes: by the sag formula, and by the paths of light."""

import math
from dataclasses import dataclass

import mpmath
import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.cell import Cell, Face
from conicoid.geometry.conic import ConicWall, _wall_supports, conic_reaches
from conicoid.geometry.shape import REGISTERED, PrimitiveSolid
from conicoid.geometry.surface import PlaneSurface

# --- Conics, lenses and mirrors against the sag formula itself, in Python's floats


CONSTANTS = [-4.0, -1.5, -1.0, -0.6, 0.0, 1.5]


def sag(r, radius, conic):
    """Return z = c r² / (1 + sqrt(1 - (1 + k) c² r²))."""
    if math.isinf(radius):
        return np.zeros_like(r)
    c = 1 / radius
    return c * r**2 / (1 + np.sqrt(1 - (1 + conic) * c**2 * r**2))


def points(seed, semi, low, high, count=4000):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-semi, semi, (count, 2)), rng.uniform(low, high, count)])


def points_off_walls(heights, *walls, by=1e-9):
    """Return points clear of all walls."""
    return np.all([np.abs(heights - wall) > by for wall in walls], axis=0)


@pytest.mark.parametrize("conic", CONSTANTS)
@pytest.mark.parametrize("radius", [2.0, -2.0])
def test_a_sheet_is_hit_at_its_sag_alone(radius, conic):
    """Rays go along z through a disc wider than the aperture: one crossing within it, none beyond, no other half."""
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
def test_a_conic_lies_between_the_sag_and_the_rim(radius, conic):
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
def test_a_lens_lies_between_its_faces(name, aperture):
    front, back, thickness, diameter, k1, k2 = LENSES[name]
    lens = co.Lens(front, back, thickness, diameter, k1, k2, aperture, aperture)
    xyz = points(2, 6.5, -12, thickness + 12)
    r = np.hypot(xyz[:, 0], xyz[:, 1])
    at = np.minimum(np.minimum(r, 6), (aperture or diameter) / 2)
    low, high = sag(at, front, k1), thickness + sag(at, back, k2)
    clear = points_off_walls(xyz[:, 2], low, high)
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
    clear = points_off_walls(xyz[:, 2], wall, thickness)
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
    """Every ray through a triplet crosses four surfaces: two pairs of its six walls are one, to the last bit."""
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
    """Return rays with the motion of the group."""
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
def test_invalid_lenses_are_refused(case):
    make, message = REFUSED[case]
    with pytest.raises(ValueError, match=message):
        make()


def test_the_glass_may_be_thinnest_between_axis_and_edge():
    """Two faces have one curvature at the vertex, and the front's conic falls back. They touch in the middle first."""
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
    """Supports are at least the maximum over rim, hole and cap in 300 bits, for walls and slopes of any size.

    Along an axis they are the least floats that are not below it.
    """
    rng, walls = np.random.default_rng(11), []
    while len(walls) < 80:
        radius = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 6))
        conic = float(rng.choice([0, -1, rng.uniform(-3, 3), -(10 ** rng.uniform(0, 3))]))
        semi = float(abs(radius) * 10 ** rng.uniform(-5, 1.5))
        if conic_reaches(radius, conic, semi):
            wall = ConicWall(radius, conic, float(rng.choice([0, 1, 1e4])), semi, semi * float(rng.choice([1, 1.5])))
            walls.append((wall, bool(rng.random() < 0.7), float(semi * rng.choice([0, 0.3]))))
    axes = np.concatenate([np.eye(3), -2 * np.eye(3)])
    ways = np.concatenate(
        [rng.normal(size=(len(walls), 2, 3)) * (1, 1, 100), np.tile(axes, (len(walls), 1, 1))], axis=1
    )
    found = _wall_supports(walls, ways)
    with mpmath.workprec(300):
        for (wall, hollow, hole), own, reaches in zip(walls, ways.tolist(), found.tolist(), strict=True):
            r, steep, vertex = mpmath.mpf(wall.radius), 1 + mpmath.mpf(wall.conic), mpmath.mpf(wall.vertex)
            for (x, y, z), reach in zip(own, reaches, strict=True):
                across, slope = mpmath.hypot(x, y), -mpmath.hypot(x, y) / z if z else mpmath.inf
                at = [(wall.semi, wall.edge), *([(hole, hole)] if hole or hollow else [])]
                if hollow and z and slope * r > 0 and 1 + steep * slope**2 > 0:
                    # z' = slope there
                    distance = abs(slope * r) / mpmath.sqrt(1 + steep * slope**2)
                    at += [(distance, distance)] if hole <= distance <= wall.semi else []
                sags = [
                    q * q / (r * (1 + mpmath.sqrt(1 - steep * q * q / r**2))) for q in (mpmath.mpf(q) for q, _ in at)
                ]
                true = max(z * (vertex + sag) + across * edge for sag, (_, edge) in zip(sags, at, strict=True))
                size = abs(z) * (abs(vertex) + abs(sags[0])) + across * wall.edge
                if np.count_nonzero((x, y, z)) > 1:
                    assert math.isnan(reach) or true <= reach <= true + 1e-9 * size
                else:
                    assert math.isnan(reach) or math.nextafter(reach, -math.inf) < true <= reach + 2.0**-90 * abs(true)


# --- Prisms and corner cubes by the paths of light, and walls of solids as open sheets


def bent_rays(scene, rays, steps):
    """Return rays after refractions (a pair of indices) or reflections (None), one after the other."""
    for step in steps:
        hits = scene.first_hit(rays)
        assert hits.hit.all()
        if step is None:
            rays = hits.spawn(co.reflect(rays.directions, hits.normal))
        else:
            ways, total = co.refract(rays.directions, hits.normal, step[0] / step[1])
            assert not total.any()
            rays = hits.spawn(ways)
    return rays


@pytest.mark.parametrize(("apex", "index"), [(60, 1.5168), (30, 1.7), (90, 1.3)])
def test_the_least_deviation_of_a_prism(apex, index):
    """n = sin((a + d) / 2) / sin(a / 2): the ray inside is parallel to the base."""
    half = math.radians(apex / 2)
    d = 2 * math.asin(index * math.sin(half)) - 2 * half
    way = np.array([0, math.sin(d / 2), math.cos(d / 2)])
    scene = co.Scene([co.Prism(apex, 10, 8)])
    out = bent_rays(scene, co.Rays([np.array([1, 0.5, 0]) - 30 * way], [way]), [(1, index), (index, 1)])
    assert out.directions[0] / np.linalg.norm(out.directions[0]) == pytest.approx([0, -way[1], way[2]], abs=1e-14)


def test_the_angle_at_the_apex_and_the_sizes():
    prism = co.Prism(50, 10, 8)
    half = math.radians(25)
    low, high = prism.bounds
    assert high == pytest.approx([4, 5 * math.cos(half), 10 * math.sin(half)], rel=1e-15)
    assert low == pytest.approx(-high, rel=1e-15)
    found = co.Scene([prism]).first_hit([(0, 0, -20), (0, 0, 20), (0, -20, 0), (-20, 0, 0), (20, 0, 0)], [(0, 0, 1), (0, 0, -1), (0, 1, 0), (1, 0, 0), (-1, 0, 0)])  # fmt: skip
    assert found.face.tolist() == [0, 1, 2, 3, 4]
    assert math.degrees(math.acos(-found.normal[0] @ found.normal[1])) == pytest.approx(50, rel=1e-14)


@pytest.mark.parametrize("tilt", [0, 3, -5])
def test_a_penta_prism_turns_by_a_right_angle_however_it_stands(tilt):
    index, t = 1.5168, math.radians(tilt)
    way = np.array([0, math.sin(t), math.cos(t)])
    rng = np.random.default_rng(1)
    on_face = np.column_stack([rng.uniform(-2, 2, 100), rng.uniform(1, 4, 100), np.zeros(100)])
    rays = co.Rays(on_face - 9 * way, np.tile(way, (100, 1)))
    out = bent_rays(co.Scene([co.PentaPrism(5, 6)]), rays, [(1, index), None, None, (index, 1)])
    ways = out.directions / np.linalg.norm(out.directions, axis=1)[:, None]
    assert np.abs(ways @ way).max() < 1e-14
    assert ways == pytest.approx(np.tile([0, -way[2], way[1]], (100, 1)), abs=1e-14)


def test_a_full_beam_passes_the_penta_prism():
    rng = np.random.default_rng(2)
    rays = co.Rays(np.column_stack([rng.uniform(-3, 3, 500), rng.uniform(0, 5, 500), np.full(500, -4.0)]), (0, 0, 1))
    scene = co.Scene([co.PentaPrism(5, 6.5)])
    faces = []
    for step in ([(1, 1.5)], [None], [None]):
        faces.append(scene.first_hit(rays).face)
        rays = bent_rays(scene, rays, step)
    assert [set(face.tolist()) for face in (*faces, scene.first_hit(rays).face)] == [{0}, {2}, {3}, {1}]


def test_a_corner_cube_sends_light_back():
    rng = np.random.default_rng(3)
    ways = rng.uniform(-0.2, 0.2, (400, 3)) + (0, 0, 1)
    rays = co.Rays(rng.uniform(-0.5, 0.5, (400, 3)) * (1, 1, 0) - 5 * ways, ways)
    out = bent_rays(co.Scene([co.CornerCube(3)]), rays, [(1, 1.5), None, None, None, (1.5, 1)])
    back = out.directions / np.linalg.norm(out.directions, axis=1)[:, None]
    assert back == pytest.approx(-ways / np.linalg.norm(ways, axis=1)[:, None], abs=2e-15)
    assert np.array(co.CornerCube(3).bounds) == pytest.approx(
        np.array([[-math.sqrt(18), -math.sqrt(13.5), 0], [math.sqrt(4.5), math.sqrt(13.5), 3]])
    )


def test_a_stop_is_a_ring():
    r = np.linspace(0.013, 3, 300)
    hits = co.Scene([co.Stop(2, 4)]).first_hit(np.column_stack([r, np.zeros(300), np.full(300, -1)]), (0, 0, 1))
    assert np.array_equal(hits.hit, (r > 1) & (r < 2))
    assert (hits.normal[hits.hit] == (0, 0, -1)).all()


SOLIDS = {
    "box": co.Box((-1, -2, 0), (1, 0.5, 1.5)),
    "wedge": co.Cylinder((0, 0, 0), (1, 1, 1), 1, 20, 310, (2, 0, 0)),
    "lens": co.Lens(-2, 1.5, 0.4, 2, front_aperture=1.5, back_aperture=1.8),
    "long lens": co.Lens(1, -1, 4, 1.5, -3, 0),
    "mirror": co.Mirror(-2, -1, 3, 0.5, 0.75),
    "bowls": co.TwoSheetHyperboloid(1, 1, 1, (-2, 3)),
    "moved cone": co.Cone((0, 0, 0), (0, 0, 2), 1, 0.5).rotate("x", 30).scale((1, 2, 0.5)),
    "polar angles": co.SphereSection(1.5, 0.5, (100, 160), 20, 310),
    "beyond a cone": co.SphereSection(1.5, 0.5, (35, 80)),
    "one cone": co.SphereSection(1.5, polar_range=(40, 140)),
    "rings": co.Revolution([(0.5, 0), (2, 0), (1, 1), (1.5, 2), (0.75, 2.5), (0.5, 1)], 30, 200),
    "sections": co.Polycone([(0, 0.5, 1), (1, 0.5, 2), (1, 0.75, 1.5), (2, 0.75, 0.75)], -30, 240),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_the_walls_of_a_solid_are_its_surface(name):
    """The walls together have the crossings of the solid, at the same t, on the same side."""
    solid = SOLIDS[name]
    whole = co.Scene([solid])
    low, high = whole.bounds
    rng = np.random.default_rng(4)
    start, to = (rng.uniform(low - 1, high + 1, (1500, 3)) for _ in range(2))
    found = whole.crossings(start, to - start, t_min=-math.inf)
    faces = sorted(set(found.face.tolist()))
    open_ = co.Scene([co.Wall(solid, face) for face in faces]).crossings(start, to - start, t_min=-math.inf)
    assert len(faces) > 1
    assert np.array_equal(found.offsets, open_.offsets)
    assert np.array_equal(found.t, open_.t)
    assert np.array_equal(found.face, np.array(faces)[open_.body])
    assert np.array_equal(found.entering, open_.entering)


def test_a_wall_cut_by_solids_is_a_thin_mirror():
    """An off-axis piece of a paraboloid z = (x² + y²) / 4 f sends light along -z to its focus, (0, 0, f)."""
    f = 50.0
    dish = co.Wall(co.EllipticParaboloid(1 / (4 * f), 1 / (4 * f)), 0) & co.Cylinder((40, 0, -1), (40, 0, 99), 12.5)
    rng = np.random.default_rng(6)
    rays = co.Rays(
        np.column_stack([rng.uniform(28, 52, 300), rng.uniform(-12, 12, 300), np.full(300, 90.0)]), (0, 0, -1)
    )
    hits = co.Scene([dish]).first_hit(rays)
    assert np.array_equal(hits.hit, np.hypot(rays.origins[:, 0] - 40, rays.origins[:, 1]) < 12.5)
    out = hits[hits.hit].spawn(co.reflect(rays.directions[hits.hit], hits.normal[hits.hit]))
    t = (f - out.origins[:, 2]) / out.directions[:, 2]
    assert np.abs((out.origins + t[:, None] * out.directions)[:, :2]).max() < 1e-12


def test_a_face_on_several_surfaces_is_no_wall():
    """A user's own shape may give its faces one number."""

    @dataclass(frozen=True)
    class Slab(PrimitiveSolid):
        def tree(self):
            return Cell(tuple(Face(PlaneSurface((0.0, 0.0, sense), 1.0), 0) for sense in (-1.0, 1.0)))

        def support(self, direction):
            return 99.0 * sum(map(abs, direction))

    REGISTERED.pop("Slab")
    with pytest.raises(ValueError, match=r"Wall: face 0 of Slab is on more than one surface"):
        co.Wall(Slab(), 0)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: co.Wall(co.Box(), 6), ValueError, r"Wall: face must be one of Box's, 0, 1, 2, 3, 4, 5, got 6"),
        (
            lambda: co.Wall(co.Box() | co.Sphere(), 0),
            TypeError,
            r"Wall: solid must be a primitive, got Union; Wall\(part, face\) & others",
        ),
        (lambda: co.Wall(co.Disc((0, 0, 0), (0, 0, 1), 1), 0), TypeError, r"Wall: solid must be a solid, got Disc"),
    ],
)
def test_missing_walls_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
