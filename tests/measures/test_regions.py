"""Measures by regions and by samples."""

import importlib
import math

import numpy as np
import pytest

import conicoid as co

from ..samples import deeper, marked, sampled
from ..thread_counts import on_threads
from .solids import BARE, KNOWN, Known, askew

# --- Closed forms of combinations against formulas and against rays: prisms, solids of revolution, cells of models

PI = math.pi
CLOSED = (
    "lens of two spheres", "spherical cap", "napkin ring", "sphere with a blind bore", "wedge of a cylinder", "half a ball", "box with a hole",
    "thin plate with a hole, tilted", "thin shell", "capsule", "cube of eight",
)  # fmt: skip


@pytest.mark.parametrize(
    "known", [*BARE, *(known for known in KNOWN if known.name in CLOSED)], ids=lambda known: known.name
)
def test_against_formulas(known: Known):
    found = co.measure(known.shape)
    assert (found.rays, found.volume_error, found.area_error) == (0, 0, 0)
    assert_known(known, found, 1e-12)


def cells(tmp_path, surfaces: str, *regions: str) -> list[co.Body]:
    """Return the bodies of an OpenMC model of cells with these regions."""
    path = tmp_path / "geometry.xml"
    rows = "".join(f'<cell id="{k + 1}" material="1" region="{region}"/>' for k, region in enumerate(regions))
    path.write_text(f"<geometry>{surfaces}{rows}</geometry>")
    return list(co.load_openmc(path).bodies)


def surface(number: int, kind: str, *numbers: float) -> str:
    return f'<surface id="{number}" type="{kind}" coeffs="{" ".join(map(repr, numbers))}"/>'


ENDS = surface(1, "z-plane", -3.0) + surface(2, "z-plane", 4.0)
PIN = ENDS + surface(3, "z-cylinder", 0.1, 0.2, 0.4) + surface(4, "z-cylinder", 0.1, 0.2, 0.5)
SIDES = "".join(
    surface(5 + k, kind, at)
    for k, (kind, at) in enumerate([("x-plane", -1.0), ("x-plane", 1.0), ("y-plane", -1.0), ("y-plane", 1.0)])
)


CELLS = [  # of a capped cylinder, an annulus, a square with a round hole, and half of the cylinder; 7 high
    ("1 -2 -3", PI * 0.16 * 7, 2 * PI * 0.4 * 7 + 2 * PI * 0.16, (0.1, 0.2, 0.5)),
    ("1 -2 3 -4", PI * 0.09 * 7, 2 * PI * 0.9 * 7 + 2 * PI * 0.09, (0.1, 0.2, 0.5)),
    ("1 -2 5 -6 7 -8 4", (4 - PI * 0.25) * 7, 2 * (4 - PI * 0.25) + (8 + 2 * PI * 0.5) * 7, None),
    ("1 -2 -3 9", PI * 0.08 * 7, PI * 0.16 + (PI * 0.4 + 0.8) * 7, (0.1 + 4 * 0.4 / (3 * PI), 0.2, 0.5)),
]  # fmt: skip


@pytest.mark.parametrize(("region", "volume", "area", "centroid"), CELLS)
def test_the_cells_of_a_pin(region, volume, area, centroid, tmp_path):
    (cell,) = cells(tmp_path, PIN + SIDES + surface(9, "x-plane", 0.1), region)
    found = co.measure(cell)
    assert found.rays == 0
    assert_known(Known(region, cell.shape, volume, area, centroid), found, 1e-13)


def test_a_hexagonal_can(tmp_path):
    planes = "".join(surface(10 + k, "plane", math.cos(k * PI / 3), math.sin(k * PI / 3), 0.0, 2.0) for k in range(6))
    (can,) = cells(tmp_path, ENDS + planes, "1 -2 " + " ".join(f"-{10 + k}" for k in range(6)))
    found = co.measure(can)
    assert found.volume == pytest.approx(2 * math.sqrt(3) * 4 * 7, rel=1e-13)  # 2 √3 times the inradius squared
    assert found.area == pytest.approx(2 * 2 * math.sqrt(3) * 4 + 6 * 4 / math.sqrt(3) * 7, rel=1e-13)
    assert found.rays == 0


@pytest.fixture
def few_rays(monkeypatch):
    """Limit the number of rays to the time of a test, where the measure chooses it."""
    monkeypatch.setattr(importlib.import_module("conicoid.apps.measures.measure"), "RAYS", 60_000)


@pytest.mark.usefixtures("few_rays")
def test_spheres_cones_and_the_regions_between_them(tmp_path):
    spheres = "".join(surface(k, "sphere", 1.0, 2.0, 3.0, float(k)) for k in (1, 2))
    cone = surface(3, "z-cone", 0.0, 0.0, 0.0, 0.25) + surface(4, "z-plane", 1.0) + surface(5, "z-plane", 3.0)
    quadric = surface(6, "quadric", 1.0, 1.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -4.0)
    ball, shell, frustum, bitten = cells(tmp_path, spheres + cone + quadric, "-1", "1 -2", "-3 4 -5", "-6 4 | -6 -4 3")
    assert co.measure(ball).volume == pytest.approx(4 / 3 * PI)
    found = co.measure(shell)
    assert (found.volume, found.area) == (pytest.approx(4 / 3 * PI * 7), pytest.approx(4 * PI * 5))
    assert found.inertia == pytest.approx(np.eye(3) * 8 * PI / 15 * 31)  # 2/5 m r² of each
    found = co.measure(frustum)
    assert found.volume == pytest.approx(PI * 0.25 * (27 - 1) / 3)
    assert found.area == pytest.approx(PI * (0.25 + 2.25) + PI * 2.0 * math.hypot(1, 2))
    # The ellipsoid of semi-axes 2, 2, 1 without what lies in the cone below z = 1, by 200 thousand slices
    z = (np.arange(200_000) + 0.5) / 100_000 - 1
    ring = np.clip(4 - 4 * z**2 - z**2 / 4, 0, None)
    found = co.measure(bitten)
    assert found.volume == pytest.approx(PI * ring.sum() / 100_000, rel=1e-6)
    assert found.volume_error == 0


@pytest.mark.parametrize("count", [2, pytest.param(15, marks=pytest.mark.deep)])
def test_random_combinations_agree_with_rays_and_move_with_their_parts(count):
    random = np.random.default_rng(11)
    seen = 0
    for _ in range(count):
        x, y, r, low = *random.uniform(-0.6, 0.6, 2), *random.uniform(0.3, 1, 2)
        parts = [
            co.Cylinder((x, y, -low), (x, y, 1), r), co.Cylinder((0, 0, -1), (0, 0, low), 0.8),
            co.Box((-0.7, -0.5, -0.9), (0.5, 0.6, low)), co.HalfSpace((1, 2, 0), 0.3), co.Sphere(0.9), co.Cone((0, 0, -1), (0, 0, 1), r, 0.1),
        ]  # fmt: skip
        one, two, three = (parts[k] for k in random.choice(4 if random.random() < 0.7 else 6, 3, replace=False))
        shape = ((one | two) - three) & co.Box((-2, -2, -2), (2, 2, 2))
        found = co.measure(shape)
        if found.rays:
            continue
        seen += 1
        rays = co.measure(shape, rays=30_000)
        assert found.volume == pytest.approx(rays.volume, abs=5 * rays.volume_error + 1e-12)
        assert found.area == pytest.approx(rays.area, abs=5 * rays.area_error + 1e-12)
        if found.volume > 0:
            assert (np.abs(found.centroid - rays.centroid) <= 5 * rays.centroid_error + 1e-12).all()
            assert (np.abs(found.inertia - rays.inertia) <= 5 * rays.inertia_error + 1e-12).all()
        moved = co.measure(askew(shape))
        turn = np.array(co.Box().rotate((1, 2, 3), 37).motion.matrix)[:3, :3]
        assert (moved.volume, moved.area) == (
            pytest.approx(found.volume, rel=1e-12),
            pytest.approx(found.area, rel=1e-12),
        )
        assert moved.inertia == pytest.approx(turn @ found.inertia @ turn.T, abs=1e-12)
        assert moved.centroid == pytest.approx(turn @ found.centroid + (3, 4, 5), abs=1e-12)
    assert seen >= count // 4


@pytest.mark.usefixtures("few_rays")
def test_walls_that_are_all_but_the_same_are_left_to_rays():
    """The tube is as thick as a few roundings, which decide which wall is outside. So no form is valid."""
    outer = co.Cylinder((0.1, 0, 0), (0.1, 0, 1), 0.3)
    tube = (outer - co.Cylinder((0.1, 0, -1), (0.1, 0, 2), 0.3 - 1e-15)) | co.Box((5, 0, 0), (6, 1, 1))
    found = co.measure(tube, seed=3)
    assert found.rays > 0
    assert found.volume == pytest.approx(1, abs=5 * found.volume_error + 1e-12)


def test_the_requested_number_of_rays_is_used():
    shape = co.Box() - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)
    assert co.measure(shape).rays == 0
    assert 3000 < co.measure(shape, rays=6000).rays < 9000
    assert co.measure(shape, rays=6000).volume_error > 0


def test_a_scene_body_by_body_and_by_material():
    steel, water = co.matte(name="steel", properties={"density": 8}), co.matte(name="water")
    scene = co.Scene(
        [
            co.Body(co.Box((0, 0, 0), (1, 2, 3)), steel, "block"), co.Body(co.Spheres([(9, 0, 0), (-9, 0, 0)], [1, 2]), water),
            co.Body(co.Box((2, 0, 0), (3, 2, 3)), steel), co.Disc((0, 0, 9), (0, 0, 1), 2), co.Plane((0, 0, 1), -9),
        ]
    )  # fmt: skip
    calls: list[tuple[int, int]] = []
    found = co.measure(scene, progress=lambda done, count: calls.append((done, count)))
    assert isinstance(found, co.measures.SceneMeasures)
    assert len(found) == scene.body_count == 6
    assert found.volume == pytest.approx([6, 4 / 3 * PI, 32 / 3 * PI, 6, 0, 0])
    assert found.volume_error.tolist() == [0] * 6
    assert found[0].area == found[3].area == 22
    assert found[4].area == pytest.approx(4 * PI)
    assert math.isnan(found[5].area)
    assert found.materials == (steel, water, None)
    assert [m.volume for m in found.by_material] == pytest.approx([12, 12 * PI, 0])
    assert found["steel"].volume == 12
    assert found["steel"].centroid == pytest.approx((1.5, 1, 1.5))
    # Two boxes of mass 6, their centers 1 away from the common one along x
    assert found["steel"].inertia == pytest.approx(
        np.diag([6 / 12 * 13 * 2, 6 / 12 * 10 * 2 + 12, 6 / 12 * 5 * 2 + 12])
    )
    assert found["water"].centroid == pytest.approx((9 * (4 / 3 - 32 / 3) / 12, 0, 0))
    assert calls[-1] == (6, 6)
    assert "material 'steel'" in str(found)
    assert "body 0 'block'" in str(found)
    with pytest.raises(KeyError, match="no material and no body is called 'steal'; names: 'steel', 'water'"):
        found["steal"]


def test_a_scene_with_rays_and_without_end():
    lens = co.Sphere() & co.Cylinder((0.3, 0, -2), (0.4, 0, 2), 0.5)
    found = co.measure(
        co.Scene([lens, co.Body(lens.translate((5, 0, 0)), "red"), co.Body(~co.Sphere(9), "red")]), rays=20_000
    )
    assert 0 < found[0].volume_error < 0.01 * found[0].volume
    assert found[0].volume == pytest.approx(found[1].volume, abs=5 * found[0].volume_error)
    assert math.isnan(found[2].volume)
    assert math.isnan(found.by_material[1].volume)
    assert found.by_material[0].volume == found[0].volume
    assert len(co.measure(co.Scene([]))) == 0


def test_volumes_of_an_imported_assembly_add_up(tmp_path):
    """2 x 2 pins stand in a box. Fuel, cladding and water fill it, and each has the volume of its formula."""
    path = tmp_path / "geometry.xml"
    path.write_text(
        f"<geometry>{PIN}{SIDES}"
        '<cell id="1" universe="1" material="1" region="-3"/><cell id="2" universe="1" material="2" region="3 -4"/>'
        '<cell id="3" universe="1" material="3" region="4"/>'
        '<lattice id="5" dimension="2 2" lower_left="-1 -1" pitch="1 1" universes="1 1 1 1"/>'
        '<cell id="4" fill="5" region="1 -2 5 -6 7 -8"/></geometry>'
    )
    found = co.measure(co.load_openmc(path))
    assert sum(body.rays for body in found) == 0
    assert found.volume.sum() == pytest.approx(4 * 7, rel=1e-13)
    # The circle of radius 0.4 about (0.1, 0.2) stays within its element [-0.5, 0.5]², that of 0.5 does not
    assert found["material 1"].volume == pytest.approx(4 * PI * 0.16 * 7 - 4 * 7 * segment(0.4, 0.3), rel=1e-12)
    cut = segment(0.5, 0.3) + segment(0.5, 0.4) - corner(0.5, 0.3, 0.4)
    both = PI * 0.25 - cut
    assert (found["material 1"].volume + found["material 2"].volume) / 28 == pytest.approx(both, rel=1e-12)


def segment(radius: float, height: float) -> float:
    """Return the area of a disc beyond a chord at a distance from its center."""
    return radius**2 * math.acos(height / radius) - height * math.sqrt(radius**2 - height**2)


def corner(radius: float, x: float, y: float) -> float:
    """Return the area of a disc with coordinates above x and y from its center, by a million strips."""
    if x * x + y * y >= radius**2:
        return 0.0
    end = math.sqrt(radius**2 - y**2)
    at = x + (np.arange(10**6) + 0.5) * (end - x) / 10**6
    return float((np.sqrt(radius**2 - at**2) - y).sum() * (end - x) / 10**6)


# --- Rays against formulas: values within their errors, and errors that are small and honest

SIGMAS = 4


def assert_known(known: Known, found: co.measures.Measures, slack: float = 0.0) -> None:
    """Assert that each measure is within its error, and within a share of itself."""
    inertia = np.diag(known.inertia) if known.inertia else None
    for name, value in (
        ("volume", known.volume),
        ("area", known.area),
        ("centroid", known.centroid),
        ("inertia", inertia),
    ):
        if value is not None:
            off, size = np.abs(getattr(found, name) - np.array(value)), np.abs(value).max()
            assert (off <= SIGMAS * getattr(found, f"{name}_error") + slack * max(1.0, size)).all(), name


@pytest.mark.parametrize(
    ("known", "rays", "share"),
    [
        *marked(((known, 60_000, 1e-2), k % 3 == 0) for k, known in enumerate(KNOWN)),
        *deeper((known, 1_000_000, 1e-3) for known in KNOWN),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_samples_against_formulas(known: Known, rays: int, share: float):
    found = co.measure(known.shape, rays=rays, seed=1)
    assert found.rays <= rays + 10_000
    assert 0 < found.volume_error < share * known.volume
    assert share == 1e-2 or found.area_error < share * found.area
    assert_known(known, found)


@pytest.mark.parametrize(
    "name", sampled(["thin shell", "lens of two spheres", "two thin rods askew", "half a ball", "box with a hole"], 5)
)
def test_errors_are_honest(name: str):
    """Over many seeds the deviations have the size of the errors: χ² of 60 is within 4.5 sigma of 60."""
    known = next(known for known in KNOWN if known.name == name)
    found = [co.measure(known.shape, rays=3_000, seed=seed) for seed in range(60)]
    rows = [
        [((m.volume - known.volume) / m.volume_error) for m in found],
        [((m.area - known.area) / m.area_error) for m in found],
    ]
    rows += [[((m.centroid - known.centroid) / m.centroid_error)[k] for m in found] for k in range(3) if known.centroid]
    for deviations in np.array(rows):
        assert abs((deviations**2).sum() - 60) < 4.5 * math.sqrt(2 * 60)


@pytest.mark.parametrize(("shape", "area"), [(co.Sphere(1.5), 9 * math.pi), (co.Box((0, 0, 0), (1, 2, 3)), 22.0)])
def test_crofton_by_counting(shape: co.Shape, area: float):
    """For a ball of radius R the area by isotropic lines, 2 π R² E[crossings], agrees with that of three families."""
    n, radius = 100_000, 2.5
    random = np.random.default_rng(3)
    low, high = shape.bounds
    direction = random.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    u = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction), axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    angle, distance = random.uniform(0, 2 * math.pi, (n, 1)), radius * np.sqrt(random.random((n, 1)))
    origin = (low + high) / 2 + distance * (np.cos(angle) * u + np.sin(angle) * np.cross(direction, u))
    counts = np.diff(co.Scene([shape]).crossings(origin, direction, t_min=-math.inf).offsets)
    factor = 2 * math.pi * radius**2
    error = factor * counts.std() / math.sqrt(n)
    assert factor * counts.mean() == pytest.approx(area, abs=SIGMAS * error)
    found = co.measure(shape & shape, rays=20_000)
    assert found.area == pytest.approx(area, abs=SIGMAS * found.area_error)


def test_sheets_have_an_area_only():
    sheet = co.Plane((1, 2, 2), 1) & co.Sphere(1.5)
    found = co.measure(sheet, rays=20_000)
    assert found.area == pytest.approx(math.pi * (1.5**2 - 1 / 9), abs=SIGMAS * found.area_error)
    assert found.volume == found.volume_error == 0
    polygon = co.Polygon([(0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1)])
    found = co.measure(polygon, rays=20_000)
    assert found.area == pytest.approx(4 * 4 - 4 * 3 / 2, abs=SIGMAS * found.area_error)
    assert np.isnan(found.centroid).all()


def test_the_same_seed_gives_the_same_numbers_on_any_number_of_threads():
    shape = co.Sphere(1) - co.Cylinder((0, 0, -2), (1, 0, 2), 0.5)
    runs = on_threads(lambda: co.measure(shape, rays=30_000, seed=5), 1, 3, None)
    for run in runs[1:]:
        assert (run.volume, run.area, run.volume_error) == (runs[0].volume, runs[0].area, runs[0].volume_error)
        assert np.array_equal(run.inertia, runs[0].inertia)
    assert co.measure(shape, rays=30_000, seed=6).volume != runs[0].volume


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale(scale: float):
    shape = co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2))
    one, other = co.measure(shape, rays=10_000), co.measure(shape.scale(scale), rays=10_000)
    assert other.volume == pytest.approx(one.volume * scale**3, abs=6 * one.volume_error * scale**3)
    assert other.area == pytest.approx(one.area * scale**2, abs=6 * one.area_error * scale**2)
    assert np.allclose(other.inertia_error, one.inertia_error * scale**5, rtol=0.3, atol=0)


def test_many_parts_and_great_depth():
    random = np.random.default_rng(4)
    centers = [(x, y, z) for x in range(7) for y in range(7) for z in range(7)]
    radii = random.uniform(0.2, 0.45, len(centers))
    found = co.measure(co.Spheres(centers, radii), rays=60_000)
    assert found.volume == pytest.approx(4 / 3 * math.pi * (radii**3).sum(), abs=SIGMAS * found.volume_error)
    assert found.volume_error < 0.01 * found.volume
    shape: co.Solid = co.Box((0, 0, 0), (40, 1, 1))
    for k in range(40):
        shape = (shape - co.Box((k + 0.25, 0, 0), (k + 0.75, 1, 1))) | co.Sphere(0.125, (k + 0.5, 0.5, 0.5))
    found = co.measure(shape, rays=20_000)
    assert found.volume == pytest.approx(20 + 40 * 4 / 3 * math.pi / 512, abs=SIGMAS * found.volume_error)


def test_copies_share_their_closed_form(noted_calls):
    """A thousand pipes of a detector took as long as a thousand different ones. Shear leaves a union of boxes one."""
    module = importlib.import_module("conicoid.apps.measures.measure")
    calls = noted_calls(module, "closed_region")
    pipe = co.Cylinder((0, 0, 0), (0, 0, 2), 1) - co.Cylinder((0, 0, -1), (0, 0, 3), 0.8)
    places = [(4.0 * k, -k, 0.1 * k) for k in range(5)]
    scene = co.Scene(
        [pipe.rotate("x", 90 * k).rotate((1, 2, 3), 7 * k).scale(1 + k).translate(at) for k, at in enumerate(places)]
    )
    for k, found in enumerate(co.measure(scene)):
        size, turn = 1 + k, np.array(co.Box().rotate("x", 90 * k).rotate((1, 2, 3), 7 * k).motion.matrix)[:3, :3]
        assert (found.rays, found.volume) == (0, pytest.approx(2 * PI * 0.36 * size**3, rel=1e-14))
        assert found.area == pytest.approx((4 * PI * 1.8 + 2 * PI * 0.36) * size**2, rel=1e-14)
        assert found.centroid == pytest.approx(turn @ [0, 0, size] + places[k], rel=1e-13)
        along, across = 0.36 * PI * (1 + 0.64), 0.36 * PI * (1 + 0.64) / 2 + 0.72 * PI * 4 / 12
        assert found.inertia == pytest.approx(
            turn @ np.diag([across, across, along]) @ turn.T * size**5, abs=1e-12 * size**5
        )
    assert len(calls) == 1
    boxes = co.Box((0, 0, 0), (1, 1, 1)) | co.Box((0.5, 0, 0), (2, 1, 1))
    assert co.measure(boxes).volume == 2
    sheared = co.measure(boxes.transform([[1, 0.4, 0, 1], [0, 1, 0.2, 0], [0, 0, 3, 0], [0, 0, 0, 1]]))
    assert (sheared.rays, sheared.volume) == (0, pytest.approx(6, rel=1e-14))


def test_errors_of_equal_bodies_are_independent():
    """Two pipes of radius 1 that cross have 16 / 3 in common. Their errors add up by squares only if their rays differ."""
    cross = co.Cylinder((-2, 0, 0), (2, 0, 0), 1) & co.Cylinder((0, -2, 0), (0, 2, 0), 1)
    scene = co.Scene([cross.translate((3 * k, 0, 0)) for k in range(30)])
    shares = []
    for seed in range(4):
        found = co.measure(scene, rays=3000, seed=seed).by_material[0]
        assert found.volume_error > 0
        shares.append((found.volume - 30 * 16 / 3) / found.volume_error)
    assert np.mean(np.square(shares)) < 4
