"""Exact measures, against formulas and against rays: closed forms, flat faces."""

import itertools
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import conicoid as co
from conicoid.apps.measures import measure as measure_module
from conicoid.apps.measures.hull import fitted_box, leaning_box
from conicoid.io.openscad.solids import sided_ball
from conicoid.scene.warmup import CutCylinders

from ..reference.routes import in_doubt
from ..samples import in_turn, sampled
from .solids import L_OUTLINE, OCTAHEDRON, SHEAR, askew

# --- Closed forms against rays and against formulas, under motions; refusals; how an answer prints

PI = math.pi

PRIMITIVES = {
    "sphere": co.Sphere(1.5, (1, 2, 3)),
    "ellipsoid": co.Ellipsoid((1, 2, 3), (0, 1, 0)),
    "barrel": co.Ellipsoid((1, 1.5, 2), (0.5, 0, 1), (-1.2, 0.3)),
    "box": co.Box((0, 1, 2), (1, 3, 5)),
    "cylinder": co.Cylinder((0, 0, 0), (1, 2, 2), 0.5),
    "wedge": co.Cylinder((0, 0, 0), (1, 2, 2), 0.5, 30, 100, (1, 0, 0)),
    "open pie": co.Cylinder((0, 0, 0), (0, 0, 2), 0.5, -40, 230, (1, 0, 0)),
    "cone": co.Cone((0, 0, 0), (1, 2, 2), 1, 0),
    "frustum": co.Cone((0, 0, 0), (1, 2, 2), 0.25, 1),
    "bow tie": co.DoubleCone(2, (-1, 0.5)),
    "dish": co.EllipticParaboloid(1, 3, (0.5, 2)),
    "cup": co.EllipticParaboloid(1, 3, (-math.inf, 2)),
    "cooling tower": co.OneSheetHyperboloid(1, 2, 3, (-0.2, 1)),
    "two bowls": co.TwoSheetHyperboloid(1, 2, 3, (-1, 2)),
    "elliptic cone": co.EllipticCone(1, 2, 3, (-1, 0.5)),
    "elliptic cylinder": co.EllipticCylinder(1, 4, (-1, 2)),
}
MOTIONS = {
    "still": lambda shape: shape,
    "askew": askew,
    "mirrored": lambda shape: shape.scale((-1, 1, 1)).scale(2),
    "sheared": lambda shape: shape.transform(SHEAR),
}


@pytest.mark.parametrize(("name", "motion"), in_turn(PRIMITIVES, MOTIONS))
def test_closed_forms_agree_with_rays(name: str, motion: str):
    shape = MOTIONS[motion](PRIMITIVES[name])
    closed, sampled = co.measure(shape, rays=600), co.measure(shape | shape, rays=8000)
    assert closed.volume_error == 0
    assert not closed.centroid_error.any()
    assert not closed.inertia_error.any()
    assert closed.volume == pytest.approx(sampled.volume, abs=5 * sampled.volume_error)
    assert closed.area == pytest.approx(sampled.area, abs=5 * math.hypot(sampled.area_error, closed.area_error))
    assert (np.abs(closed.centroid - sampled.centroid) <= 5 * sampled.centroid_error).all()
    assert (np.abs(closed.inertia - sampled.inertia) <= 5 * sampled.inertia_error).all()


def test_areas_have_closed_forms_under_similarities():
    for shape in PRIMITIVES.values():
        for motion in ("still", "askew", "mirrored"):
            found = co.measure(MOTIONS[motion](shape))
            assert (found.area_error, found.rays) == (0, 0)
    assert co.measure(co.Box().transform(SHEAR)).rays == 0
    assert co.measure(PRIMITIVES["barrel"].scale((1, 2, 3)), rays=600).area_error > 0


ROUND = {
    "paraboloid": (co.EllipticParaboloid(1, 1, (-math.inf, 2)), PI / 6 * 26 + 2 * PI),
    "ball": (co.Ellipsoid((2, 2, 2), (1, 2, 3), (-1, 0.5)), 2 * PI * 2 * 1.5 + PI * (3 + 3.75)),
    "bow tie": (co.DoubleCone(2, (-1, 0.5)), PI * math.sqrt(5) * (2 + 0.5) + PI * (4 + 1)),
    # r = cosh v, z = sinh v: the area is 2 π ∫ √(1 + 2 z²) dz = 2 π [z √(1 + 2 z²) / 2 + asinh(√2 z) / √8]
    "hyperboloid": (
        co.OneSheetHyperboloid(1, 1, 1, (-1, 1)),
        2 * PI * (math.sqrt(3) + math.asinh(math.sqrt(2)) / math.sqrt(2)) + 2 * PI * 2,
    ),
}


@pytest.mark.parametrize("name", ROUND)
def test_areas_of_quadrics_of_revolution(name: str):
    shape, area = ROUND[name]
    assert co.measure(shape).area == pytest.approx(area, rel=4e-16)


@pytest.mark.parametrize("radii", [(1, 2, 3), (1, 1, 1e-3), (1, 1, 500), (1, 40, 1), (1e-60, 2e-60, 4e-60)])
def test_an_ellipsoid(radii: tuple[float, float, float]):
    """The area is 4 π R_G(a² b², a² c², b² c²), Carlson's symmetric integral (DLMF 19.33.1)."""
    a, b, c = radii
    area = 4 * PI * float(mpmath.elliprg((mpmath.mpf(a) * b) ** 2, (mpmath.mpf(a) * c) ** 2, (mpmath.mpf(b) * c) ** 2))
    for shape in (co.Ellipsoid(radii), co.Ellipsoid((b, c, a)), co.Sphere(0.5).scale((2 * a, 2 * b, 2 * c))):
        found = co.measure(shape)
        assert (found.rays, found.area) == (0, pytest.approx(area, rel=4e-15))
        assert found.volume == pytest.approx(4 / 3 * PI * a * b * c, rel=1e-14)
    inertia = 4 / 15 * PI * a * b * c * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.diag(co.measure(co.Ellipsoid(radii)).inertia) == pytest.approx(
        inertia, rel=1e-13, abs=1e-15 * max(inertia)
    )


@pytest.mark.parametrize("b", [0.5, 1e-3])
def test_an_elliptic_cylinder(b):
    """The perimeter of an ellipse is 4 a E(1 - b² / a²)."""
    around = float(4 * mpmath.ellipe(1 - mpmath.mpf(b) ** 2))
    found = co.measure(co.EllipticCylinder(1, 1 / b**2, (-1, 2)))
    assert (found.rays, found.area) == (0, pytest.approx(3 * around + 2 * PI * b, rel=4e-15))
    assert found.centroid.tolist() == [0, 0, 0.5]


@pytest.mark.parametrize(
    "shape",
    [
        co.Cylinder((0, 0, -1), (0, 0, 1), 1.5), co.Tube((0, 0, -1), (0, 0, 1), 0.3, 0.7), co.Ellipsoid((1, 2, 3)),
        co.RegularPrism(6, 1.1, (-0.7, 0.7)), co.Cone((0, 0, -1), (0, 0, 1), 0.7, 0.7),
    ],
    ids=lambda shape: type(shape).__name__,
)  # fmt: skip
def test_the_centroid_of_a_symmetric_solid_is_its_middle(shape: co.Shape):
    assert co.measure(shape).centroid.tolist() == [0, 0, 0]


@pytest.mark.parametrize("size", [1e-90, 1e80])
def test_solids_of_revolution_of_any_size(size: float):
    """Fifth powers of these sizes are 0 or infinite in float64."""
    for inner in (0.0, size / 2):
        start, end = (0, 0, 0), (0, 0, 3 * size)
        measures = co.measure(co.Tube(start, end, inner, size) if inner else co.Cylinder(start, end, size))
        assert measures.volume / (size * size * size) == pytest.approx(3 * PI * (0.75 if inner else 1.0))
        assert measures.centroid / size == pytest.approx([0.0, 0.0, 1.5])


def test_a_single_part_of_a_combination_keeps_its_closed_form():
    box = co.Box().translate((1, 0, 0))
    for shape in (co.Union((box,)), co.Intersection((co.Union((box,)),)), box.painted(co.mirror())):
        found = co.measure(shape.rotate((0, 0, 1), 90))
        assert (found.volume, found.rays) == (8, 0)
        assert found.centroid == pytest.approx((0, 1, 0))


def test_sheets():
    assert co.measure(co.Disc((1, 2, 3), (1, 1, 1), 2)).area == pytest.approx(4 * PI)
    assert co.measure(co.Disc((0, 0, 0), (0, 0, 1), 1).scale((2, 3, 5))).area == pytest.approx(6 * PI)
    assert co.measure(co.Triangle((0, 0, 0), (2, 0, 0), (0, 3, 0)).rotate((1, 2, 3), 20)).area == pytest.approx(3)
    patch = co.measure(co.CylinderPatch((0, 0, 0), (0, 0, 2), 1.5, 0, 90, (1, 0, 0)))
    assert (patch.area, patch.area_error, patch.volume) == (pytest.approx(1.5 * PI), 0, 0)


@pytest.mark.parametrize(
    "shape",
    [
        co.Sphere() - co.Sphere(),
        co.Sphere() & co.Sphere(1, (5, 0, 0)),
        co.TwoSheetHyperboloid(1, 1, 1) & co.Box((-9, -9, -0.5), (9, 9, 0.5)),
        co.Polyhedron([(1, 0, 0), (-1, 0, 0)], [0, -1]),
        co.Box() & co.Cylinder((5, 0, 0), (5, 0, 1), 1),
        (co.EllipticCylinder(1, 1) & co.HalfSpace((0, 0, 1), 0)) & co.HalfSpace((0, 0, -1), -1) & co.Box(),
        co.Sphere(1) - co.Box((-2, -2, -2), (2, 2, 2)),
        co.Spheres([], 1),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_empty_solids_measure_nothing(shape: co.Shape):
    found = co.measure(shape, rays=6000)
    assert found.volume == found.area == found.volume_error == found.area_error == 0
    assert not found.inertia.any()
    assert np.isnan(found.centroid).all()


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        *(
            (lambda rays=rays: co.measure(co.Sphere(), rays=rays), ValueError, "measure: rays must be an integer >= 60")
            for rays in (0, 59, 1e6 + 0.5, True, "many")
        ),
        (
            lambda: co.measure(co.Sphere(), rays=10**12 + 1),
            ValueError,
            "rays must be an integer <= 1,000,000,000,000, got 1000000000001",
        ),
        (lambda: co.measure(co.Sphere(), seed=-1), ValueError, "measure: seed must be an integer >= 0, got -1"),
        (lambda: co.measure([co.Sphere()]), TypeError, "measure: shape must be a shape, a Body or a Scene, got list"),
        (
            lambda: co.measure(co.EllipticCylinder(1, 1)),
            ValueError,
            r"measure: EllipticCylinder must be bounded, .* infinite along z",
        ),
        (lambda: co.measure(~co.Sphere()), ValueError, "infinite along x, y, z"),
        (lambda: co.measure(co.Plane((0, 0, 1), 0)), ValueError, "infinite along x, y"),
    ],
)
def test_refusals(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_answers():
    shape = co.Sphere() - co.Box((0, 0, 0), (2, 2, 2))
    calls: list[tuple[int, int]] = []
    found = co.measure(
        co.Body(shape, name="seven eighths"), rays=30_000, progress=lambda done, total: calls.append((done, total))
    )
    assert "volume" in str(found)
    assert "±" in str(found)
    assert calls[-1] == (30_000, 30_000)
    assert all(a[0] <= b[0] for a, b in itertools.pairwise(calls))
    assert not found.centroid.flags.writeable
    with pytest.raises(AttributeError):
        found.volume = 1.0
    assert replace(found, volume=2.0).volume == 2


# --- Solids with flat faces have closed forms: against formulas, fractions, and counts of unit cubes


def closed_form(shape: co.Solid) -> co.measures.Measures:
    """Return measures, which must come from no ray."""
    found = co.measure(shape)
    assert (found.rays, found.volume_error, found.area_error) == (0, 0, 0)
    return found


@pytest.mark.parametrize("sides", [7, 40])
def test_a_ball_of_so_many_sides(sides: int):
    """The ball is a stack of frustums of regular polygons: h (A + B + sqrt(A B)) / 3 each, with trapezoids as sides."""
    count = (sides + 1) // 2
    rings = [math.radians(180 * (k + 0.5) / count) for k in range(count)]
    areas = [sides / 2 * math.sin(math.tau / sides) * (3 * math.sin(a)) ** 2 for a in rings]
    edges = [2 * math.sin(math.pi / sides) * 3 * math.sin(a) for a in rings]
    flat = 3 * math.cos(math.pi / sides)
    volume, area = 0.0, areas[0] + areas[-1]
    for k in range(count - 1):
        rise = 3 * (math.cos(rings[k]) - math.cos(rings[k + 1]))
        volume += rise * (areas[k] + areas[k + 1] + math.sqrt(areas[k] * areas[k + 1])) / 3
        slant = math.hypot(rise, flat * (math.sin(rings[k + 1]) - math.sin(rings[k])))
        area += sides * (edges[k] + edges[k + 1]) / 2 * slant
    found = closed_form(sided_ball(3.0, sides).translate((1e3, 0, 0)))
    assert found.volume == pytest.approx(volume, rel=1e-12)
    assert found.area == pytest.approx(area, rel=1e-12)
    assert found.centroid == pytest.approx((1e3, 0, 0), abs=1e-12)


def test_random_tetrahedra_as_meshes():
    """The volume is a sixth of a determinant, in fractions, the centroid a mean, and areas follow Heron's formula."""
    rng = np.random.default_rng(4)
    for _ in range(12):
        corners = rng.integers(-9, 9, (4, 3)).tolist()
        a, b, c = ([Fraction(p - q) for p, q in zip(corner, corners[0], strict=True)] for corner in corners[1:])
        six = abs(
            a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        if not six:
            continue
        found = closed_form(co.Mesh(corners, ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))))
        assert found.volume == pytest.approx(float(six / 6), rel=1e-12)
        assert found.centroid == pytest.approx(np.mean(corners, axis=0), abs=1e-12)
        area = 0.0
        for three in itertools.combinations(corners, 3):
            p, q, r = (math.dist(one, other) for one, other in itertools.combinations(three, 2))
            area += math.sqrt(max((p + q + r) * (-p + q + r) * (p - q + r) * (p + q - r), 0.0)) / 4
        assert found.area == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("shape", [OCTAHEDRON, co.Extrusion(L_OUTLINE, (0, 1), 0.5)], ids=["polyhedron", "extrusion"])
def test_motions(shape: co.Solid):
    own, turned, sheared = closed_form(shape), closed_form(askew(shape)), closed_form(shape.transform(SHEAR))
    factor = turned.volume / own.volume
    assert turned.area == pytest.approx(own.area * factor ** (2 / 3), rel=1e-12)
    assert sheared.volume == pytest.approx(own.volume * abs(np.linalg.det(np.array(SHEAR)[:3, :3])), rel=1e-13)
    sampled = co.measure(shape.transform(SHEAR) | shape.transform(SHEAR), rays=20_000)
    assert sheared.area == pytest.approx(sampled.area, abs=5 * sampled.area_error)
    assert (np.abs(sheared.inertia - sampled.inertia) <= 5 * sampled.inertia_error).all()


def test_faces_back_to_back_bound_nothing():
    """Two cubes of one mesh that share a wall have the area of a box of 1 × 1 × 2."""
    corners, faces = [], []
    for z in (0, 1):
        first = len(corners)
        corners += [(x, y, z + up) for up in (0, 1) for y in (0, 1) for x in (0, 1)]
        cube = (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
        faces += [tuple(first + k for k in face) for face in cube]
    found = co.measure(co.Mesh(corners, faces), rays=2000)
    assert (found.volume, found.volume_error) == (pytest.approx(2, rel=1e-14), 0)
    assert found.area == pytest.approx(10, abs=5 * found.area_error + 1e-9)


# Booleans of boxes


def sponge(level: int, cut: bool = False) -> co.Solid:
    """Return Menger's sponge as the union of its cubes, or as a cube less square bars."""
    if cut:
        bars = []
        for size in (3**k for k in range(level)):
            for i, j in itertools.product(range(3**level // (3 * size)), repeat=2):
                a, b = size * (3 * i + 1), size * (3 * j + 1)
                for axis in range(3):
                    low, high = [a, b], [a + size, b + size]
                    low.insert(axis, 0)
                    high.insert(axis, 3**level)
                    bars.append(co.Box(low, high))
        return co.Difference((co.Box((0, 0, 0), (3**level,) * 3), *bars))
    places = [(0, 0, 0)]
    for _ in range(level):
        steps = [d for d in itertools.product(range(3), repeat=3) if sum(k == 1 for k in d) < 2]
        places = [tuple(3 * x + y for x, y in zip(p, d, strict=True)) for p in places for d in steps]
    return co.Union(tuple(co.Box(p, tuple(x + 1 for x in p)) for p in places))


@pytest.mark.parametrize("cut", [False, True])
def test_mengers_sponge(cut: bool):
    """20 of 27 cubes are left at each level; the area is 2 (20 / 9)^n + 4 (8 / 9)^n of the first cube's side squared."""
    for level in (1, 2):
        found = closed_form(sponge(level, cut).rotate((1, 2, 3), 33).translate((10, 20, 30)))
        assert found.volume == pytest.approx(20**level, rel=1e-13)
        assert found.area == pytest.approx(9**level * (2 * (20 / 9) ** level + 4 * (8 / 9) ** level), rel=1e-12)


def test_random_booleans_of_boxes():
    """Counts of unit cubes, and of the squares between those inside and outside."""
    rng = np.random.default_rng(6)
    at = np.stack(np.meshgrid(*[np.arange(-1, 9) + 0.5] * 3, indexing="ij"), axis=-1)

    def box():
        low = rng.integers(0, 6, 3)
        high = low + rng.integers(1, 3, 3)
        return co.Box(low.tolist(), high.tolist()), ((at > low) & (at < high)).all(axis=-1)

    for _ in range(8):
        (a, p), (b, q), (c, r), (d, s) = (box() for _ in range(4))
        whole = ((a | b | c) - d) | (d & ~a & b)
        inside = ((p | q | r) & ~s) | (s & ~p & q)
        found = closed_form(whole.scale((2, 1, 3)))
        x, y, z = (2 * (np.arange(-1, 9) + 0.5), np.arange(-1, 9) + 0.5, 3 * (np.arange(-1, 9) + 0.5))
        walls = [np.abs(np.diff(inside.astype(int), axis=axis)).sum() for axis in range(3)]
        assert found.volume == pytest.approx(6 * inside.sum(), rel=1e-13)
        assert found.area == pytest.approx(3 * walls[0] + 6 * walls[1] + 2 * walls[2], rel=1e-13)
        i, j, k = np.nonzero(inside)
        assert found.centroid == pytest.approx((x[i].mean(), y[j].mean(), z[k].mean()), rel=1e-13)
        square = np.array([((x[i] - x[i].mean()) ** 2 + 4 / 12).sum(), ((y[j] - y[j].mean()) ** 2 + 1 / 12).sum()])
        assert found.inertia[2, 2] == pytest.approx(6 * square.sum(), rel=1e-12)
        mixed = ((x[i] - x[i].mean()) * (y[j] - y[j].mean())).sum()
        assert found.inertia[0, 1] == pytest.approx(-6 * mixed, rel=1e-9, abs=1e-9)


def test_tilted_boxes_are_left_to_other_rules():
    tilted = co.Box((0, 0, 0), (1, 1, 1)) | co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 1, 0), 30)
    assert co.measure(tilted, rays=600).rays > 0


@pytest.mark.parametrize(
    ("solid", "volume", "area"),
    [
        (co.Box((0, 0, 0), (1, 1, 1)) - co.Box((0, 0, 5e-13), (1, 1, 1)), 5e-13, 2.0),
        (co.Box((0, 0, 1000), (1, 1, 1000 + 1e-9)) | co.Box((0, 0, 1000), (1, 0.5, 1000 + 1e-9)), 1e-9, 2.0),
    ],
)
def test_thin_boxes_are_not_lost(solid, volume, area):
    """Their walls are apart by more than rounding, however little that is beside their place."""
    found = co.measure(solid)
    assert found.volume == pytest.approx(volume, rel=1e-3, abs=5 * found.volume_error)
    assert found.area == pytest.approx(area, rel=1e-3, abs=5 * found.area_error)


CUBE = (0, 0, 0), (3, 3, 3)
"""A cube of 27, with boxes added, or taken away by faces that look inward."""


@pytest.mark.parametrize(
    "boxes",
    sampled(
        [
            [(((1, 1, 0), (2, 2, 2)), -1)],
            [(((1, 1, 0), (2, 2, 3)), -1)],
            [(((1, 1, 1), (2, 2, 2)), -1)],
            [(((0, 0, 0), (2, 2, 2)), -1)],
            [(((0, 1, 0), (2, 2, 2)), -1)],
            [(((0, 0, 0), (1, 1, 3)), -1), (((1, 1, 0), (2, 2, 3)), -1)],
            [(((3, 1, 1), (4, 2, 2)), 1), (((1, 1, 3), (2, 2, 4)), 1)],
            [(((3, 0, 0), (4, 3, 3)), 1)],
        ],
        2,
    ),
)
def test_holes_and_blocks_that_share_a_wall(boxes):
    """Of two faces in one plane one may be larger: a hole that is flush with a wall, a block on it."""
    corners, faces = [], []
    for (low, high), sense in [(CUBE, 1), *boxes]:
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        faces += [tuple(len(corners) + k for k in quad[::sense]) for quad in quads]
        corners += [tuple((low, high)[k >> axis & 1][axis] for axis in range(3)) for k in range(8)]
    mesh = co.Mesh(corners, faces)
    points = np.random.default_rng(5).uniform(-0.5, 4.5, (4000, 3))
    count = sum(sense * ((points > low) & (points < high)).all(axis=1) for (low, high), sense in [(CUBE, 1), *boxes])
    assert np.array_equal(co.Scene([mesh]).contains(points), count > 0)
    volume = 27 + sum(sense * np.prod(np.subtract(high, low)) for (low, high), sense in boxes)
    assert co.measure(mesh).volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize(("radius", "boxes"), [(2.0, 1), (1e30, 2)])
def test_a_shape_is_boxed_once_for_each_unit(radius, boxes, noted_calls):
    """A molecule of 27,000 balls took a third of the time of its measure for a second box of each."""
    boxed = noted_calls(measure_module, "fitted_box")
    assert co.measure(co.Sphere(radius)).volume == pytest.approx(4 / 3 * math.pi * radius**3, rel=1e-14)
    assert len(boxed) == boxes


def test_only_the_smallest_turned_box_is_bounded_exactly(noted_calls):
    """A bar of 10 × 1 × 1, turned by 30°, holds cubes under other turns.

    Exact bounds of eight boxes took 0.4 s a body of a tokamak, half of its measure.
    """
    bar = co.Box((-5, -0.5, -0.5), (5, 0.5, 0.5)).rotate("z", 30)
    shape = co.Union([co.Box((-0.2,) * 3, (0.2,) * 3).rotate("z", angle) for angle in (10, 20, 40, 50, 60, 70)] + [bar])
    moved = noted_calls(co.Union, "bounds_under", lambda self, outer: outer)
    box = fitted_box(shape)
    assert sorted(box.half) == pytest.approx([0.5, 0.5, 5], rel=1e-12)
    assert sum(not motion.is_identity for motion in moved) == 1


@pytest.mark.parametrize("length", [1, 30])
def test_rays_of_a_turned_part_are_seldom_in_doubt(length: float):
    """A block has crossed bores, by turned normals that are rounded. All rays along its walls were in doubt."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    half, center = np.array([1.5, 1.0, 2.0 * length]), np.array([3.0, -2.0, 7.0])
    normals = np.concatenate([turn, -turn])
    block = co.Polyhedron(normals, normals @ center + np.tile(half, 2))
    bores = [co.Cylinder(center - 99 * turn[k], center + 99 * turn[k], radius) for k, radius in ((0, 0.4), (2, 0.6))]
    shape, random = block - bores[0] - bores[1], np.random.default_rng(4)
    tight = fitted_box(shape)
    box = leaning_box(tight)
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * half @ turn + center
    assert (np.abs((corners - box.center) @ box.axes) <= box.half * (1 + 1e-12)).all()
    assert np.prod(box.half) < 3 * np.prod(tight.half)
    for axis in box.axes.T:
        origins = box.center + random.uniform(-1, 1, (2000, 3)) * box.half @ box.axes.T - 99 * axis
        assert in_doubt(co.Scene([shape]), co.Rays(origins, axis)).mean() < 0.01


def test_copies_of_a_lattice_are_measured_once(noted_calls):
    """128 cylinders less a ball: the first is measured, and one that has been moved; with rays each has its own."""
    scene = co.Scene(CutCylinders()).moved(5, (0.0, 0.0, 0.5))
    single = noted_calls(measure_module, "_measure_bodies")
    done: list[tuple[int, int]] = []
    found = co.measure(scene, progress=lambda *counts: done.append(counts))
    assert len(single) == 2
    assert done == [(1, 128), (2, 128), (128, 128)]
    volume = math.pi / 4 - 4 / 3 * math.pi * 0.2**3 / 2  # half of the ball is outside
    assert found.volume == pytest.approx(np.full(128, volume), rel=1e-14)
    for number, body in enumerate(scene):
        place = np.array(body.shape.bounds).mean(axis=0)
        assert found[number].centroid[:2] == pytest.approx(place[:2], abs=1e-13)
        assert found[number].centroid[2] == pytest.approx(co.measure(body).centroid[2], abs=1e-14)
    co.measure(scene, 600)
    assert len(single) == 2 + 128


@pytest.mark.parametrize("seed", range(3))
def test_faces_that_are_all_but_flat_have_closed_forms(seed: int):
    """A cube of 2 with the middle of each side moved in or out by up to 1e-9: parts of it are slivers."""
    rng = np.random.default_rng(seed)
    corners = [tuple(map(float, c)) for c in itertools.product((-1, 1), repeat=3)]
    points, faces = list(corners), []
    for axis, sense in itertools.product(range(3), (-1, 1)):
        middle = np.zeros(3)
        middle[axis] = sense * (1 + rng.uniform(-1e-9, 1e-9))
        side = [k for k, corner in enumerate(corners) if corner[axis] == sense]
        others = np.delete(np.array(corners)[side], axis, axis=1)
        ring = [side[k] for k in np.argsort(np.arctan2(others[:, 1], others[:, 0]))]
        ring = ring if sense * (-1) ** axis > 0 else ring[::-1]
        faces += [(len(points), ring[k], ring[(k + 1) % 4]) for k in range(4)]
        points.append(tuple(middle.tolist()))
    found = co.measure(co.Mesh(points, faces))
    assert found.rays == 0
    # Each pyramid over a side has the volume 4 h / 3
    heights = [Fraction(abs(value)) for point in points[8:] for value in point if value]
    assert found.volume == pytest.approx(float(4 * sum(heights) / 3), rel=1e-15)
    assert found.area == pytest.approx(24, rel=1e-14)
