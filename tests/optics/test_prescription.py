"""Systems of lenses: prescriptions, published numbers, examples."""

import functools
import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

from .matrices import first_order
from .published import LENSES

# --- Rows become a scene; beams, spots and fans against closed forms

INF = math.inf
SINGLET = [(50, 6, 1.5168, 20), (-50, 45, 1, 20)]


def test_rows_may_be_written_in_three_ways():
    one = co.optics.prescription(SINGLET, 10)
    two = co.optics.prescription(
        [dict(radius=50, thickness=6, medium=1.5168, diameter=20), co.optics.Row(-50, 45, diameter=20)], 10
    )
    assert one.bodies == two.bodies
    assert one.vertices == (0.0, 6.0)
    assert one.image == 51
    lens = one.bodies[0]
    assert lens.shape == co.Lens(50, -50, 6, 20)
    assert (lens.name, lens.material.refractive_index) == ("lens 1", 1.5168)


def test_the_default_image_is_at_the_paraxial_focus():
    system = co.optics.prescription([(50, 6, 1.5168, 20), (-50, None)], 10)
    assert system.image == pytest.approx(first_order(SINGLET)["rear_focus"], rel=1e-14)
    near = co.optics.prescription([(50, 6, 1.5168, 20), (-50, None)], 10, object_distance=100)
    f, points = first_order(SINGLET)["efl"], first_order(SINGLET)
    distance = 100 + points["front_principal"]
    assert near.image == pytest.approx(points["rear_principal"] + 1 / (1 / f - 1 / distance), rel=1e-12)
    assert co.optics.spot(near, 0, count=4).radius < 3


def test_a_glass_by_index_and_abbe_number():
    """n_F - n_C = (n - 1) / V."""
    system = co.optics.prescription([(50, 6, (1.5168, 64.17), 20), (-50, None)], 10, wavelengths=(0.5875618, 0.4861327))
    glass = system.media[1]
    assert glass.index(0.5875618) == pytest.approx(1.5168, rel=1e-15)
    assert glass.index(0.4861327) - glass.index(0.6562725) == pytest.approx(0.5168 / 64.17, rel=1e-12)
    blue = first_order([(50, 6, glass.index(0.4861327)), (-50, 0, 1)])["efl"]
    assert co.optics.focal_length(system, 0.4861327) == pytest.approx(blue, rel=2e-9)
    assert co.optics.focal_length(system.scene, 0.4861327) == pytest.approx(blue, rel=1e-7)


def test_a_function_of_the_wavelength():
    system = co.optics.prescription([(50, 6, lambda wave: 1.5 + 0.004 / wave**2, 20), (-50, None)], 10)
    assert system.bodies[0].material.refractive_index == pytest.approx(1.5 + 0.004 / 0.5875618**2, rel=1e-15)
    assert co.optics.focal_length(system, 0.4) == pytest.approx(
        first_order([(50, 6, 1.525), (-50, 0, 1)])["efl"], rel=2e-9
    )


def test_light_may_come_back_through_a_lens():
    """A concave mirror sends light back through a cemented lens: thicknesses are below 0."""
    rows = [
        dict(radius=-400, thickness=-150, medium="mirror", diameter=60),
        dict(radius=-120, thickness=-5, medium=1.6, diameter=30),
        dict(radius=90, thickness=-3, medium=1.5, diameter=30),
        dict(radius=-70, thickness=-30, diameter=30),
    ]
    system = co.optics.prescription(rows, 40)
    plain = [(row["radius"], row["thickness"], row.get("medium", 1)) for row in rows]
    expected = first_order(plain)
    points = co.optics.cardinal_points(system)
    assert points.focal_length == pytest.approx(expected["efl"], rel=2e-9)
    assert points.rear_focus == pytest.approx(expected["rear_focus"], rel=2e-9)
    assert [body.name for body in system.bodies] == ["mirror 1", "lens 1", "lens 2"]
    walls = system.scene.crossings((1, 0, -250), (0, 0, 1), t_max=200)
    assert walls.t[1] == walls.t[2]
    assert walls.surface[1] == walls.surface[2]


@pytest.mark.parametrize("field", [0, 1.5])
def test_a_paraboloid_has_no_spherical_aberration(field):
    """On the axis all rays meet in the focus. Off it the chief ray of a stop at the mirror goes to f tan(field)."""
    f = 200.0
    system = co.optics.prescription(
        [dict(radius=-2 * f, thickness=-f, medium="mirror", conic=-1, diameter=80 + 4 * field, stop=True)], 80
    )
    spot = co.optics.spot(system, field, count=8)
    if field == 0:
        assert spot.radius < 1e-12
    chief = spot.points[0]
    assert chief == pytest.approx([0, f * math.tan(math.radians(field))], abs=1e-12)
    assert spot.vignetted == 0


def test_a_classical_cassegrain_is_sharp():
    """A paraboloid and a hyperboloid of k = -((m + 1) / (m - 1))² have both foci in place; m is the magnification."""
    f, m, back = 500.0, 4.0, 100.0
    p = (f + back) / (m + 1)  # from the secondary to the focus of the primary; m p behind it lies the image
    rows = [
        dict(radius=-2 * f, thickness=-(f - p), medium="mirror", conic=-1, diameter=200, hole=60, stop=True),
        dict(
            radius=-2 * m * p / (m - 1),
            thickness=m * p,
            medium="mirror",
            conic=-(((m + 1) / (m - 1)) ** 2),
            diameter=70,
        ),
    ]
    system = co.optics.prescription(rows, 190)
    spot = co.optics.spot(system, 0, count=10)
    assert spot.radius < 1e-10
    assert 0.05 < spot.vignetted < 0.2  # the middle falls on the secondary's back
    assert co.optics.focal_length(system) == pytest.approx(m * f, rel=2e-9)
    assert system.image == pytest.approx(back, rel=1e-12)


def test_the_errors_of_a_spherical_mirror():
    """A ray at the height h meets the axis at R - R / (2 cos a) from the vertex, sin a = h / R, under the angle 2 a."""
    r = 100.0
    system = co.optics.prescription([dict(radius=-r, thickness=-r / 2, medium="mirror", diameter=60, stop=True)], 60)
    fan = co.optics.ray_fan(system, 0, count=31)
    h = 30 * fan.pupil
    a = np.arcsin(h / r)
    # From there they go on to the plane z = -R / 2, beyond it as seen from the mirror, and so to the other side.
    assert fan.error[:, 1] == pytest.approx(-np.tan(2 * a) * (r / (2 * np.cos(a)) - r / 2), abs=1e-8)
    assert co.optics.ray_fan(system, 0, axis="x", count=31).error[:, 0] == pytest.approx(fan.error[:, 1], abs=1e-13)


def test_edges_and_stops_take_light():
    """The beam is twice as wide as the opening: a quarter of it passes."""
    rows = [dict(thickness=20, diameter=8, stop=True), (80, 3, 1.5, 30), (-80, 70, 1, 30)]
    system = co.optics.prescription(rows, 16)
    assert [body.name for body in system.bodies] == ["stop", "lens 1"]
    spot = co.optics.spot(system, 0, count=200)
    assert 1 - spot.vignetted == pytest.approx(0.25, abs=0.002)
    narrow = co.optics.prescription([(80, 3, 1.5, 8), (-80, 70, 1, 8)], 16)
    assert 1 - co.optics.spot(narrow, 0, count=200).vignetted == pytest.approx(0.25, abs=0.002)
    assert co.optics.prescription(rows).aperture == pytest.approx(8, rel=1e-15)


def test_the_optical_path_to_an_image_is_one():
    """From infinity to the focus of a plano-hyperbolic lens (k = -n²) all paths are equal, by Fermat's principle."""
    n, f = 1.5, 60.0
    rows = [(INF, 5, n, 30), dict(radius=-(n - 1) * f, thickness=f, conic=-(n**2), diameter=30)]
    system = co.optics.prescription(rows, 26)
    found = co.optics.trace(
        system, co.optics.beam(system, 0, pupil=np.column_stack([np.linspace(-1, 1, 21), np.zeros(21)]))
    )
    end = found.at(system.image)
    assert found.arrived.all()
    assert np.abs(end[:, :2]).max() < 1e-12
    paths = found.optical_path + np.linalg.norm(end - found.points[-1], axis=1)
    assert np.ptp(paths) < 1e-12


def test_a_ball_in_the_way_of_followed_rays():
    """With n = 2 a ball lens focuses rays near the axis on its back."""
    ball = co.Scene([co.Body(co.Sphere(10), co.glass(2.0))])
    points = co.optics.cardinal_points(ball)
    assert points.focal_length == pytest.approx(10, rel=1e-8)
    assert points.rear_focus == pytest.approx(10, rel=1e-8)
    afocal = co.Scene([co.Body(co.Box((-5, -5, 0), (5, 5, 3)), co.glass(1.5))])
    assert co.optics.focal_length(afocal) == INF


def test_light_paths_are_absorbed_reflected_and_transmitted():
    scene = co.Scene(
        [
            co.Body(co.Disc((0, 0, 5), (0, 0, 1), 1), "black"),
            co.Body(co.Disc((5, 0, 5), (1, 0, -1), 1), co.mirror()),
            co.Body(co.Disc((9, 0, 5), (0, 0, 1), 1), co.glass()),
        ]
    )
    found = co.optics.follow(scene, co.Rays([(0, 0, 0), (5, 0, 0), (9.5, 0, 0), (-9, 0, 0)], (0, 0, 1)))
    assert found.arrived.tolist() == [False, True, True, True]
    assert found.rays.directions[1] == pytest.approx([1, 0, 0], abs=1e-15)
    assert found.rays.directions[2].tolist() == [0, 0, 1]
    assert found.rays.origins[3].tolist() == [-9, 0, 0]


def test_a_prescription_is_a_value():
    """Prescriptions are equal by their contents, can be pickled, and their scenes saved."""
    import pickle

    systems = [
        co.optics.prescription([(50, 6, (1.5168, 64.17), 20), (-50, 45, 1, 20)], 10, fields=(0, 5)) for _ in range(2)
    ]
    assert systems[0] == systems[1] == pickle.loads(pickle.dumps(systems[0]))
    assert systems[0] != co.optics.prescription(SINGLET, 10)
    none = co.optics.follow(co.Scene([co.Sphere(1)]), co.Rays([(0, 0, -5), (9, 0, 0)], (0, 0, 1)))
    assert none.arrived.tolist() == [False, True]  # a body without a material is opaque


def test_no_module_hides_a_function():
    """An imported module becomes an attribute of its package, and must not have a public name."""
    import pkgutil

    import conicoid.apps.optics

    assert not {module.name for module in pkgutil.iter_modules(conicoid.apps.optics.__path__)} & set(
        conicoid.apps.optics.__all__
    )


def test_a_missing_optiland_is_named():
    try:
        import optiland.nonsequential  # noqa: F401
    except ImportError:
        with pytest.raises(ImportError, match=r"needs Optiland 0.6 or newer: pip install 'conicoid\[optiland\]'"):
            co.optics.OptilandBackend(seed=1)
    else:
        assert co.optics.OptilandBackend(seed=1).seed == 1


REFUSED = [
    (lambda: co.optics.prescription([]), ValueError, r"prescription: rows must hold at least one surface"),
    (lambda: co.optics.prescription("x"), TypeError, r"prescription: rows must be a list of rows, got str"),
    (lambda: co.optics.prescription([3]), TypeError, r"rows\[0\] must be a Row, a mapping .* got 3"),
    (lambda: co.optics.prescription([(0, 1)]), ValueError, r"rows\[0\]: Row: radius must not be 0"),
    (lambda: co.optics.prescription([dict(radios=3)]), ValueError, r"rows\[0\]: a key must be one of .* \(did you mean 'radius'\?\)"),
    (lambda: co.optics.prescription([(9, 1, 1.5), (9, 1, 1.5)], 1), ValueError, r"rows\[1\]: the last medium must be air, got index 1.5"),
    (lambda: co.optics.prescription([(9, 0, 1.5), (9, 1)], 1), ValueError, r"rows\[0\]: thickness must not be 0 in index 1.5"),
    (lambda: co.optics.prescription([(9, 1, 1.5), (9, 1)]), ValueError, r"aperture must be given where rows have no stop of known diameter"),
    (lambda: co.optics.prescription([(9, None, 1.5), (9, 1)], 1), ValueError, r"rows\[0\]: thickness may be None in the last row alone"),
    (lambda: co.optics.prescription([(9, 1, "unobtainium"), (9, 1)], 1), ValueError, r"rows\[0\]: Row: medium must be a glass .* got 'unobtainium'"),
    (lambda: co.optics.prescription([(9, 1, 1.5), (-9, -1, "mirror")], 1), ValueError, r"rows\[1\]: a mirror in glass"),
    (lambda: co.optics.prescription([(9, 1, 1.5, 12), (-9, 1)], 1), ValueError, r"rows\[0\] and rows\[1\]: Lens: thickness"),
    (lambda: co.optics.prescription([(9, 5, 1.5), (-9, 1)], 1, wavelengths=587.6), ValueError, r"wavelength must be in μm"),
    (lambda: co.optics.prescription([(9, 5, 1.5), (-9, 1)], 1, fields=(0, 91)), ValueError, r"fields must be below 90 degrees"),
    (lambda: co.optics.spot(co.Scene([])), TypeError, r"spot: system must be a Prescription, got Scene"),
    (lambda: co.optics.focal_length(3), TypeError, r"cardinal_points: system must be a Prescription or a Scene, got int"),
    (lambda: co.optics.focal_length(co.Scene([co.Body(co.Sphere(), "red")])), ValueError, r"rays near the z axis do not get through"),
    (lambda: co.optics.trace(3, 4), TypeError, r"trace: system must be a Prescription and rays be Rays, got int and int"),
    (lambda: co.optics.follow(co.Sphere(), 4), TypeError, r"follow: scene must be a Scene and rays be Rays, got Sphere and int"),
    (lambda: co.optics.ray_fan(co.optics.prescription(SINGLET, 5), axis="z"), ValueError, r"ray_fan: axis must be one of x, y, got 'z'"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_invalid_prescriptions_are_refused(case):
    make, error, message = REFUSED[case]
    with pytest.raises(error, match=message):
        make()


# --- Published prescriptions: their scenes have the focal lengths that were printed, by real rays and by matrices


@functools.cache
def system_of(name):
    lens = LENSES[name]
    rows = [
        dict(radius=row[0], thickness=row[1], medium=row[2], conic=(*row, 0.0)[3], stop=i == lens.stop)
        for i, row in enumerate(lens.rows)
    ]
    return co.optics.prescription(rows, lens.aperture)


def last_digit(text):
    """Return half a unit of the last digit of a printed number."""
    digits, _, power = text.partition("E")
    decimals = len(digits.partition(".")[2])
    return 0.5 * 10.0 ** (int(power or 0) - decimals)


def slack(lens, quantity):
    """Return the change of the quantity by rounded indices: to first order, all of them in the worst direction."""
    found = 0.0
    for i, row in enumerate(lens.rows):
        if lens.rounded and row[2] not in (1, "mirror"):
            moved = [*lens.rows[:i], (*row[:2], row[2] + lens.rounded, *row[3:]), *lens.rows[i + 1 :]]
            found += abs(first_order(moved)[quantity] - first_order(lens.rows)[quantity])
    return found


@pytest.mark.parametrize("name", LENSES)
def test_focal_lengths_are_those_printed(name):
    lens = LENSES[name]
    points = co.optics.cardinal_points(system_of(name))
    found = {"efl": points.focal_length, "bfl": points.back_focal_length, "ffl": points.front_focal_length}
    for quantity, text in lens.printed.items():
        assert abs(found[quantity] - float(text)) <= last_digit(text) + slack(lens, quantity), (
            quantity,
            found[quantity],
            text,
        )


@pytest.mark.parametrize("name", LENSES)
def test_real_rays_agree_with_matrices(name):
    lens = LENSES[name]
    expected, points = first_order(lens.rows), co.optics.cardinal_points(system_of(name))
    size = abs(expected["efl"])
    assert points.focal_length == pytest.approx(expected["efl"], rel=2e-9)
    for quantity in ("front_focus", "rear_focus", "front_principal", "rear_principal"):
        assert getattr(points, quantity) == pytest.approx(expected[quantity], rel=2e-9, abs=2e-9 * size), quantity
    assert co.optics.focal_length(system_of(name)) == points.focal_length


LENSES_OF_GLASS = [name for name, lens in LENSES.items() if all(row[2] != "mirror" for row in lens.rows)]


@pytest.mark.parametrize("name", LENSES_OF_GLASS)
def test_the_scene_alone_gives_the_same_rays(name):
    """The scene holds bodies and refractive indices of materials, without the prescription.

    The stop has no index and is left out.
    """
    system = system_of(name)
    glass = co.Scene([body for body in system.bodies if body.name != "stop"])
    points = co.optics.cardinal_points(glass)
    assert points.focal_length == pytest.approx(first_order(LENSES[name].rows)["efl"], rel=1e-7)


@pytest.mark.parametrize("name", ["double Gauss f/2", "Heliar", "telephoto"])
def test_cemented_walls_are_one_surface(name):
    lens = LENSES[name]
    system = system_of(name)
    assert co.check(co.Scene([body for body in system.bodies if body.name != "stop"]), rays=20_000) == []
    walls = system.scene.crossings((0.3, 0.2, -50), (0, 0, 1))
    cemented = [i for i in range(1, len(lens.rows)) if lens.rows[i - 1][2] != 1 and lens.rows[i][2] != 1]
    shared = np.flatnonzero(np.diff(walls.t) == 0)
    assert len(shared) == len(cemented) > 0
    assert (walls.surface[shared] == walls.surface[shared + 1]).all()


def test_at_least_ten_are_compared_with_a_printed_focal_length():
    assert sum("efl" in lens.printed for lens in LENSES.values()) >= 10


# --- The prism of the examples: its picture, small, and its least deviation by light

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def prism(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    yield importlib.import_module("prism")
    sys.modules.pop("prism", None)


def test_the_picture_has_all_colours(prism):
    pixels = prism.picture(None, 0.25).pixels
    assert np.isfinite(pixels).all()
    bright = pixels[pixels.max(axis=2) > 0.3]
    for channel in range(3):  # each channel is the brightest somewhere by far
        others = np.delete(bright, channel, axis=1).max(axis=1)
        assert (bright[:, channel] > 1.5 * others).any()


def test_the_beam_is_turned_by_the_least_deviation(prism):
    rays, _ = prism.beam(0.53)
    paths = co.optics.trace_paths(prism.prism(), rays[:, 0], depth=2, wavelength=0.53)
    out = paths.escaped & (paths.level == 2) & ~paths.mirrored
    out &= ~paths.mirrored[paths.parent]
    turned = np.degrees(np.arccos(paths.direction[out] @ rays.directions[0, 0]))
    assert turned == pytest.approx(np.full(prism.ACROSS, prism.least_deviation(0.53)), abs=1e-10)


@pytest.mark.parametrize("diameter", [None, 20])  # the stand-in for a lost ray would hit a wall of 20
def test_rays_that_are_lost_on_the_way_stay_lost_without_obstructions(diameter):
    system = co.optics.prescription([(50, 6, 1.5, diameter), (-50, 40, None, diameter)], 10)
    rays = co.Rays([(0, 1, -10), (0, 500, -10), (0, 80, -10), (0, -1, -10)], [(0, 0, 1)] * 4)
    found = co.optics.trace(system, rays, obstructions=False)
    assert found.arrived.tolist() == [True, False, False, True]
    assert np.isnan(found.points[1:, 1:3]).all()
    alone = co.optics.trace(system, co.Rays([(0, 1, -10)], [(0, 0, 1)]), obstructions=False)
    assert (found.points[:, 0] == alone.points[:, 0]).all()
