"""Projections, scans of other programs, and the Shepp-Logan head against its closed form."""

import math
import re
import sys

import mpmath
import numpy as np
import pytest

import conicoid as co

from ..children import child
from ..interruptions import Interruption
from ..samples import deep, sampled

# --- The X-ray projection of the Shepp-Logan head against its closed form in extended precision
# A parallel beam through ellipsoids of densities ρ that add up: the pixel is Σ ρ · chord, and the
# chord of |R (x - c) / radii| = 1 is 2 √(b² - a c) |d| / a with the quadratic of the ray in the ball's frame.


# density; semi-axes a, b, c; centre; Euler angles φ, θ, ψ (z-x-z), in degrees. Shepp and Logan 1974, after
# Kak and Slaney 1988 in three dimensions, with the contrast of Toft 1996.
HEAD = np.array([
    [1.0, 0.69, 0.92, 0.81, 0, 0, 0, 0, 0, 0],
    [-0.8, 0.6624, 0.874, 0.78, 0, -0.0184, 0, 0, 0, 0],
    [-0.2, 0.11, 0.31, 0.22, 0.22, 0, 0, -18, 0, 10],
    [-0.2, 0.16, 0.41, 0.28, -0.22, 0, 0, 18, 0, 10],
    [0.1, 0.21, 0.25, 0.41, 0, 0.35, -0.15, 0, 0, 0],
    [0.1, 0.046, 0.046, 0.05, 0, 0.1, 0.25, 0, 0, 0],
    [0.1, 0.046, 0.046, 0.05, 0, -0.1, 0.25, 0, 0, 0],
    [0.1, 0.046, 0.023, 0.05, -0.08, -0.605, 0, 0, 0, 0],
    [0.1, 0.023, 0.023, 0.02, 0, -0.606, 0, 0, 0, 0],
    [0.1, 0.023, 0.046, 0.02, 0.06, -0.605, 0, 0, 0, 0],
])  # fmt: skip
# A point in the ellipsoid's own frame is Rz(ψ) Rx(θ) Rz(φ) (x - centre), Rz(φ) = [[cos, sin, 0], [-sin, cos, 0], [0, 0,
# 1]].

VIEWS = {
    "from the side": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "from above": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "oblique": ((0.6, 0.64, 0.48), (-0.8, 0.48, 0.36), (0.0, -0.6, 0.8)),
}
"""Direction of the beam, and the axes of the picture: an orthonormal triple in 3-4-5 fractions."""


def head():
    shapes = []
    for _, a, b, c, *rest in HEAD.tolist():
        center, (phi, theta, psi) = rest[:3], rest[3:]
        shape = co.Ellipsoid((a, b, c)).rotate((0, 0, 1), psi).rotate((1, 0, 0), theta).rotate((0, 0, 1), phi)
        shapes.append(shape.translate(center))
    return co.Scene(shapes)


def beam(view, pixels):
    """Return origins 3 units out, at the middles of pixels over [-1, 1]²."""
    d, u, v = (np.array(x) for x in VIEWS[view])
    s = (2 * np.arange(pixels) + 1) / pixels - 1
    return -3 * d + s[None, :, None] * u + s[:, None, None] * v, d


def turned(phi, theta, psi):
    """Return Rz(ψ) Rx(θ) Rz(φ) by mpmath, to 40 digits."""
    with mpmath.workdps(40):

        def rotation(degrees, i, j):
            r, angle = mpmath.eye(3), mpmath.mpf(degrees) * mpmath.pi / 180
            r[i, i] = r[j, j] = mpmath.cos(angle)
            r[i, j], r[j, i] = mpmath.sin(angle), -mpmath.sin(angle)
            return r

        return rotation(psi, 0, 1) * rotation(theta, 1, 2) * rotation(phi, 0, 1)


def extended(matrix):
    return np.array([[np.longdouble(mpmath.nstr(matrix[i, j], 30)) for j in range(3)] for i in range(3)])


def closed_form(origins, direction):
    """Return Σ ρ chord in 80-bit floats."""
    assert np.finfo(np.longdouble).eps < 2e-19
    o, d = origins.astype(np.longdouble), np.asarray(direction, dtype=np.longdouble)
    total = np.zeros(o.shape[:-1], dtype=np.longdouble)
    for row in HEAD:
        rho, radii, center = np.longdouble(row[0]), row[1:4].astype(np.longdouble), row[4:7].astype(np.longdouble)
        r = extended(turned(*row[7:]))
        p, e = (o - center) @ r.T / radii, r @ d / radii
        a, b = e @ e, p @ e
        p = p - (b / a)[..., None] * e  # foot of the perpendicular: b becomes 0
        discriminant = 1 - np.sum(p * p, axis=-1)
        chord = 2 * np.sqrt(np.where(discriminant > 0, discriminant, 0) / a) * np.sqrt(d @ d)
        total += rho * chord
    return total


def exact_pixel(origin, direction):
    """Return the same pixel by mpmath, to 40 digits."""
    with mpmath.workdps(40):
        total = mpmath.mpf(0)
        for row in HEAD.tolist():
            r = turned(*row[7:])
            p = r * mpmath.matrix([mpmath.mpf(float(o)) - mpmath.mpf(c) for o, c in zip(origin, row[4:7], strict=True)])
            e = r * mpmath.matrix([mpmath.mpf(float(x)) for x in direction])
            p, e = ([x / mpmath.mpf(k) for x, k in zip(v, row[1:4], strict=True)] for v in (p, e))
            a, b, c = (sum(x * y for x, y in zip(*pair, strict=True)) for pair in ((e, e), (p, e), (p, p)))
            if b * b > a * (c - 1):
                total += mpmath.mpf(row[0]) * 2 * mpmath.sqrt(b * b - a * (c - 1)) / a
        return total * mpmath.sqrt(sum(mpmath.mpf(float(x)) ** 2 for x in direction))


def check(view, pixels):
    origins, direction = beam(view, pixels)
    picture = head().spans(origins, direction).line_integral(HEAD[:, 0])
    expected = closed_form(origins, direction)
    assert picture.shape == (pixels, pixels)
    assert picture.max() > 0.3
    off = np.abs(picture.astype(np.longdouble) - expected)
    assert off.max() <= 1e-12, f"{float(off.max())} off at pixel {np.unravel_index(off.argmax(), off.shape)}"
    return picture


@pytest.mark.parametrize("pixels", [128, deep(512)])
@pytest.mark.parametrize("view", VIEWS)
def test_projection(view, pixels):
    picture = check(view, pixels)
    origins, direction = beam(view, pixels)
    for row, column in ((64, 64), (20, 64), (64, 100), (90, 30), (40, 70), (1, 1)):
        exact = exact_pixel(origins[row, column], direction)
        assert abs(mpmath.mpf(float(picture[row, column])) - exact) <= 1e-12


def test_middle_pixel_by_hand():
    """Down the z axis through (0, 0) the ray crosses the skull and the brain: 2·0.81·1 - 0.8·2·0.78·√(1 - (0.0184/0.874)²).

    It misses the fifth figure, whose √(1 - (0.35/0.25)²) at y = 0 is not real, and all others.
    """
    value = head().spans((0, 0, 3), (0, 0, -1)).line_integral(HEAD[:, 0])
    expected = 2 * 0.81 - 0.8 * 2 * 0.78 * np.sqrt(1 - (0.0184 / 0.874) ** 2)
    assert value == pytest.approx(expected, abs=1e-14)


# --- Projections, and scans of other programs


# --- Sinograms: the Shepp-Logan head against its closed form, and the same bits on all routes

SCANS = {
    "parallel": co.ct.parallel(np.arange(0, 180, 20.0), 24, spacing=0.09, offset=0.01),
    "fanflat": co.ct.fanflat(np.arange(0, 360, 45.0), 24, 3, 2, spacing=0.16, radius=5),
    "parallel3d": co.ct.parallel3d([0, 30, 91.5], 6, 8, spacing=(0.25, 0.3)),
    "cone": co.ct.cone(np.arange(0, 360, 60.0), 6, 8, 3, 2, spacing=(0.4, 0.5), offset=(0.1, 0)),
    "helical": co.ct.helical(np.arange(-360, 360, 60.0), 4, 8, 3, 2, pitch=0.5, spacing=(0.4, 0.3), radius=5),
    "rtk": co.ct.rtk([0, 77], 6, 6, 3, 5, spacing=(0.5, 0.5), out_of_plane_angle=3, in_plane_angle=5),
}


def exact(scan):
    """Return sums of densities times chords along the rays of a scan, in 80-bit floats."""
    rays = co.Rays.from_scan(scan).to_rays()
    lines = zip(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3), strict=True)
    return np.array([closed_form(o[None], d)[0] for o, d in lines]).reshape(scan.shape)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="the closed form needs floats of 80 bits")
@pytest.mark.parametrize("name", sampled(SCANS, 3))
def test_the_head_against_its_closed_form(name):
    found = co.ct.project(head(), SCANS[name], HEAD[:, 0])
    assert found.max() > 0.2
    assert np.abs(found - exact(SCANS[name])).max() < 1e-12


def test_energies_files_and_lazy_arrays(tmp_path):
    scan, values = SCANS["cone"], HEAD[:, :2]
    local = co.ct.project(head(), scan, values)
    assert local.shape == (*scan.shape, 2)
    assert np.array_equal(local[..., 0], co.ct.project(head(), scan, HEAD[:, 0]))
    calls = []
    with co.parallel.Processes(1) as pool:
        executor = co.parallel.Workers(pool, chunk=77)
        sinogram = co.ct.project(head(), scan, values, executor=executor, out=tmp_path / "sinogram.npy",
                             progress=lambda *step: calls.append(step))  # fmt: skip
    assert np.array_equal(sinogram, local)
    assert np.array_equal(np.load(tmp_path / "sinogram.npy"), local)
    assert calls[-1] == (local.size // 2, local.size // 2)
    da = pytest.importorskip("dask.array")
    lazy = co.ct.project(head(), scan, values, chunks=4)
    assert isinstance(lazy, da.Array)
    assert lazy.chunks[0] == (4, 2)
    assert np.array_equal(lazy.compute(scheduler="synchronous"), local)


def test_a_failure_leaves_no_file(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        co.ct.project(head(), SCANS["cone"], HEAD[:, 0], out=tmp_path / "sinogram.npy", progress=Interruption())
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ValueError, match=r"project: out must end with .npy"):
        co.ct.project(head(), SCANS["cone"], HEAD[:, 0], out=tmp_path / "sinogram.tif")
    with pytest.raises(TypeError, match=r"project: geometry must be one of co.ct, got str"):
        co.ct.project(head(), "cone", HEAD[:, 0])


def test_rays_end_at_the_detector():
    # A ball behind the detector does not count, and one around the source counts from there
    wall = co.Scene([co.Sphere(1, (0, 9, 0)), co.Sphere(1, (0, -5, 0))])
    scan = co.ct.fanflat([0], 1, 5, 3)
    assert co.ct.project(wall, scan, [1, 1]).tolist() == [[1.0]]


TENTH = "co.ct.cone(np.arange(0, 360, 5.0), 1200, 1200, 3, 2, spacing=(0.004, 0.004))"
"""A tenth of the views of a scan of 720."""
PROJECT = f"""
import resource, sys
import numpy as np
import conicoid as co
from tests.ct.test_project import HEAD, head
with co.parallel.Processes(2) as pool:
    co.ct.project(head(), {TENTH}, HEAD[:, 0], executor=pool, out=sys.argv[1])
own = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(own + 2 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


@pytest.mark.deep
@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_a_hundred_million_rays_in_two_gigabytes(tmp_path):
    """The test runs in a process of its own, because the peak of this one is that of all tests before.

    `ru_maxrss` counts a parent's memory.
    """
    with child(PROJECT, tmp_path / "sinogram.npy") as running:
        code, most, errors = running.end(1200)
    assert code == 0, errors
    assert int(most) * 1024 < 2 << 30
    scan, found = eval(TENTH), np.load(tmp_path / "sinogram.npy", mmap_mode="r")
    some = found[::24, 100::500, 100::300]
    views, rows, columns = (
        x.ravel()
        for x in np.meshgrid(np.arange(0, 72, 24), np.arange(100, 1200, 500), np.arange(100, 1200, 300), indexing="ij")
    )
    places, sources = scan.pixels(views, rows, columns), scan.vectors[views, :3]
    expected = [closed_form(o[None], p - o)[0] for o, p in zip(sources, places, strict=True)]
    assert np.abs(some.ravel() - np.array(expected)).max() < 1e-12


# --- Scans against the definitions of ASTRA and RTK: rays derived by hand, and matrices as their documents print them

HALF = math.sqrt(0.5)


def ray(scan, *index):
    rays = co.Rays.from_scan(scan).to_rays()[index]
    return rays.origins, rays.directions


# ASTRA at 0°: the source at (0, -far, 0), the detector at (0, near, 0), columns along x and rows along z. The last row is
# at z = +0.5, the first column at x = -1.5 · 2. At 90°, whose sine is 1, the source is at (far, 0, 0), columns along y, and
# the offset shifts the detector along its axes. One turn of a helix is 360°: at -90° it is a quarter of the pitch below the
# middle.
@pytest.mark.parametrize(
    ("scan", "shape", "index", "start", "end"),
    [
        (co.ct.cone([0], 3, 4, 10, 5, spacing=(2, 0.5)), (1, 3, 4), (0, 2, 0), [0, -10, 0], [-3, 5, 0.5]),
        (
            co.ct.cone([90], 1, 2, 10, 5, spacing=(2, 1), offset=(0.25, 3)),
            (1, 1, 2),
            (0, 0, 1),
            [10, 0, 0],
            [-5, 1 + 0.25, 3],
        ),
        (co.ct.helical([-90, 0, 720], 1, 1, 10, 5, pitch=8), (3, 1, 1), (0, 0, 0), [-10, 0, -2], [5, 0, -2]),
        (co.ct.helical([-90, 0, 720], 1, 1, 10, 5, pitch=8), (3, 1, 1), (2, 0, 0), [0, -10, 16], [0, 5, 16]),
    ],
)
def test_rays_of_cones_and_helices(scan, shape, index, start, end):
    origin, direction = ray(scan, *index)
    assert origin.tolist() == start
    assert (origin + direction).tolist() == end
    assert scan.shape == shape


def test_parallel_rays():
    # At 45° the direction is (sin, -cos), columns along (cos, sin); the middle of two is half a step from each
    scan = co.ct.parallel([45], 2, spacing=4)
    origin, direction = ray(scan, 0, 1)
    assert np.allclose(direction, (HALF, -HALF, 0), rtol=1e-15)
    assert np.allclose(origin, (2 * HALF, 2 * HALF, 0), rtol=1e-15)
    deep = co.ct.parallel3d([90], 2, 1, spacing=(1, 6), offset=(0.5, 1))
    origin, direction = ray(deep, 0, 1, 0)
    assert direction.tolist() == [1, 0, 0]
    assert origin.tolist() == [0, 0.5, 1 + 3]


def test_a_detector_about_the_source_has_equal_angles():
    scan = co.ct.fanflat([0], 7, 4, 2, spacing=0.3, radius=6)
    places = scan.pixels(np.zeros(7, int), 0, np.arange(7)) - (0, -4, 0)
    assert np.allclose(np.linalg.norm(places, axis=1), 6, rtol=1e-15)
    angles = np.arctan2(places[:, 0], places[:, 1])
    assert np.allclose(angles, (np.arange(7) - 3) * 0.3 / 6, rtol=1e-14, atol=1e-16)


def test_a_shifted_curved_detector_keeps_its_cylinder():
    scan = co.ct.cone([30], 2, 5, 4, 2, spacing=(0.3, 1), offset=(0.7, 0), radius=6)
    places = scan.pixels(np.zeros(5, int), 1, np.arange(5)) - scan.vectors[0, :3]
    assert np.allclose(np.linalg.norm(places[:, :2], axis=1), 6, rtol=1e-14)
    assert np.allclose(places[:, 2], 0.5)


def astra(kind, **entries):
    names = dict(
        angles="ProjectionAngles", width="DetectorWidth", count="DetectorCount", rows="DetectorRowCount",
        columns="DetectorColCount", x="DetectorSpacingX", y="DetectorSpacingY", far="DistanceOriginSource",
        near="DistanceOriginDetector", vectors="Vectors",
    )  # fmt: skip
    return co.ct.from_astra({"type": kind} | {names[name]: value for name, value in entries.items()})


def test_dictionaries_of_astra():
    quarter = np.array([np.pi / 2])
    pairs = [
        (astra("parallel", angles=quarter, width=2.0, count=5), co.ct.parallel([90], 5, spacing=2)),
        (astra("fanflat", angles=quarter, width=2.0, count=5, far=9, near=3), co.ct.fanflat([90], 5, 9, 3, spacing=2)),
        (
            astra("parallel3d", angles=quarter, x=2.0, y=3.0, rows=4, columns=5),
            co.ct.parallel3d([90], 4, 5, spacing=(2, 3)),
        ),
        (
            astra("cone", angles=quarter, x=2.0, y=3.0, rows=4, columns=5, far=9, near=3),
            co.ct.cone([90], 4, 5, 9, 3, spacing=(2, 3)),
        ),
    ]
    for scan, ours in pairs:
        assert scan.shape == ours.shape
        assert np.allclose(scan.vectors, ours.vectors, atol=1e-14)
        assert (scan.is_parallel, scan.is_plane) == (ours.is_parallel, ours.is_plane)
    twelve = np.array([[0, -9, 0, 0, 3, 0, 2, 0, 0, 0, 0, 3.0]])
    vec = astra("cone_vec", vectors=twelve, rows=4, columns=5)
    assert np.array_equal(vec.vectors, co.ct.cone([0], 4, 5, 9, 3, spacing=(2, 3)).vectors)
    six = astra("fanflat_vec", vectors=np.array([[0, -9, 0, 3, 2, 0.0]]), count=5)
    assert np.array_equal(six.vectors, co.ct.fanflat([0], 5, 9, 3, spacing=2).vectors)


MATRICES = [
    # RTK's documentation prints these: gantry angle, projection offsets, and the matrix of each (sid 1000, sdd 1536)
    (271.847274780273, (-117.056503295898, -1.01195001602173), [
        [-166.5093078829, 0, -1531.42837748039, -117056.503295898],
        [-1.01142410874151, -1536, 0.0326206557691505, -1011.95001602173],
        [-0.999480303105996, 0, 0.0322354417240802, -1000],
    ]),
    (271.852905273438, (-117.056831359863, -1.01187002658844), [
        [-166.660129424325, 0, -1531.41199650136, -117056.831359863],
        [-1.01134095059569, -1536, 0.0327174625589984, -1011.87002658844],
        [-0.999477130482326, 0, 0.0323336411615466, -1000],
    ]),
]  # fmt: skip


@pytest.mark.parametrize(("angle", "offset", "matrix"), MATRICES)
def test_matrices_of_rtk(angle, offset, matrix):
    # Every point of the ray to a pixel projects to the place of the pixel, offset aside
    scan = co.ct.rtk([angle], 5, 7, 1000, 1536, spacing=(30, 20), projection_offset=offset)
    rays = co.Rays.from_scan(scan).to_rays()
    for t in (0.3, 0.9):
        points = (rays.origins + t * rays.directions).reshape(-1, 3)
        u, v, w = np.array(matrix) @ np.column_stack([points, np.ones(len(points))]).T
        rows, columns = np.mgrid[:5, :7].reshape(2, -1)
        assert np.allclose(u / w, (columns - 3) * 30, atol=1e-6)
        assert np.allclose(v / w, (rows - 2) * 20, atol=1e-6)


def rtk_matrix(angle, out, inside, sid, sdd, source, shift):
    """As RTK's documentation composes it."""

    def turn(degrees, i, j):
        matrix, a = np.eye(4), math.radians(-degrees)
        matrix[i, i] = matrix[j, j] = math.cos(a)
        matrix[i, j], matrix[j, i] = -math.sin(a), math.sin(a)
        return matrix

    rotation = turn(inside, 0, 1) @ turn(out, 1, 2) @ turn(angle, 2, 0)
    offset = np.eye(4)
    offset[0, 3], offset[1, 3] = -source[0], -source[1]
    depth = np.diag([-sdd, -sdd, 1.0])
    depth = np.column_stack([depth, [0, 0, -sid]])
    last = np.array([[1, 0, source[0] - shift[0]], [0, 1, source[1] - shift[1]], [0, 0, 1]])
    return last @ depth @ offset @ rotation


def test_nine_parameters_of_rtk():
    parameters = dict(out_of_plane_angle=4, in_plane_angle=-7, source_offset=(0.3, -0.2), projection_offset=(0.5, 1.5))
    scan = co.ct.rtk([33, 250], 4, 3, 100, 150, spacing=(2, 3), **parameters)
    rays = co.Rays.from_scan(scan).to_rays()
    rows, columns = np.mgrid[:4, :3].reshape(2, -1)
    for k, angle in enumerate((33, 250)):
        matrix = rtk_matrix(angle, 4, -7, 100, 150, (0.3, -0.2), (0.5, 1.5))
        points = (rays.origins[k] + 0.6 * rays.directions[k]).reshape(-1, 3)
        u, v, w = matrix @ np.column_stack([points, np.ones(len(points))]).T
        assert np.allclose(u / w, (columns - 1) * 2, atol=1e-11)
        assert np.allclose(v / w, (rows - 1.5) * 3, atol=1e-11)


def test_parallel_rays_and_cylinders_of_rtk():
    # Without angles the rotated axes are those of the world. The source is up z, so that rays go down
    scan = co.ct.rtk([0], 1, 2, 100, 0, spacing=(2, 1), projection_offset=(0.5, 0))
    origin, direction = ray(scan, 0, 0, 1)
    assert direction.tolist() == [0, 0, -1]
    assert origin.tolist() == [1.5, 0, -100]
    bent = co.ct.rtk([0], 1, 3, 100, 150, spacing=(30, 1), radius=150)  # about the source
    places = bent.pixels(np.zeros(3, int), 0, np.arange(3)) - (0, 0, 100)
    assert np.allclose(np.linalg.norm(places, axis=1), 150, rtol=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: co.ct.cone([0], 0, 3, 1, 1), "ScanGeometry: rows must be an integer >= 1, got 0"),
        (lambda: co.ct.cone([0], 3, 3, -1, 1), "cone: source_origin must be > 0, got -1"),
        (lambda: co.ct.parallel([math.nan], 3), "parallel: angles must be finite numbers of shape (views,)"),
        (lambda: co.ct.from_astra({"type": "cone"}), "from_astra: cone must have DetectorRowCount, DetectorColCount"),
        (lambda: co.ct.from_astra({"type": "spiral"}), "from_astra: type must be one of parallel, fanflat"),
        (lambda: co.ct.rtk([0, 1], 3, 3, [1, 2, 3], 4), "rtk: source_to_isocenter must be a number, or for each of 2"),
        (
            lambda: co.ct.ScanGeometry(np.zeros((1, 12)), 3, 3, True),
            "ScanGeometry: u and v of a view must not be parallel",
        ),
    ],
)
def test_invalid_scans_are_refused(make, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        make()
