"""Path tracing, and the points of light transport."""

import math

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.render import sampling as sobol

from ..compiled import compiled
from ..samples import deep
from ..thread_counts import on_threads

# --- Light transport against closed forms: the light of points, balls, discs and squares, furnaces, walls without leaks


WHITE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)
ASIDE = co.OrthographicCamera((0, -1e-3, 1e-4), (0, 0, 0), up=(0, 0, 1), height=1e-9)
"""A view of the origin, under a body right over it."""


def floor(material=None):
    return co.Body(co.Box((-50, -50, -1), (50, 50, 0)), material or co.matte(WHITE))


def color(items, lights=(), background=BLACK, camera=ASIDE, samples=256, **options):
    """Return the color of one pixel, which sees one point."""
    scene = co.Scene(items, lights=list(lights), camera=camera, background=background)
    return scene.render(1, 1, samples, **{"integrator": "path", **options}).pixels[0, 0]


# Lights without extent: their pictures are Whitted's, but for a light's highlights


@pytest.mark.parametrize(
    "light",
    [
        co.PointLight((4, 0, 3), 50, falloff="inverse_square"),
        co.PointLight((4, 0, 3), 2),
        co.DirectionalLight((1, 0, -1), (0.5, 1, 2)),
        co.SpotLight((0, 3, 4), (0, -3, -4), angle=20, intensity=3),
    ],
)
def test_lights_without_extent_are_as_bright_as_in_whitteds_pictures(light):
    items = [floor(co.matte((0.2, 0.4, 0.8)))]
    assert color(items, [light], samples=1) == pytest.approx(
        color(items, [light], samples=1, integrator="whitted"), rel=1e-6
    )


def test_several_lights_add_up():
    lights = [co.PointLight((k, 1, 3), 1 + k) for k in range(20)]
    few, many = color([floor()], lights[:5], samples=1 << 12), color([floor()], lights, samples=1 << 14)
    for radiance, count in ((few, 5), (many, 20)):
        expected = sum((1 + k) * 3 / math.sqrt(k * k + 1 + 9) for k in range(count))
        assert radiance == pytest.approx([expected] * 3, rel=0.01)


# Lamps: radiance L and a form factor F give L F


@pytest.mark.parametrize("distance", [1.001, 2, 30])
def test_a_ball_overhead(distance):
    """F = R² / d² (a ball that is all above the horizon)."""
    radiance = color([floor(), co.Body(co.Sphere(1, (0, 0, distance)), co.glow(3))])
    assert radiance == pytest.approx([3 / distance**2] * 3, rel=1e-3)


@pytest.mark.parametrize(("radius", "height"), [(1, 1), (2, 1), (0.1, 3)])
def test_a_disc_overhead(radius, height):
    """F = R² / (R² + h²)."""
    radiance = color([floor(), co.Body(co.Disc((0, 0, height), (0, 0, 1), radius), co.glow((2, 1, 0)))])
    assert radiance == pytest.approx(np.array((2, 1, 0)) * radius**2 / (radius**2 + height**2), rel=2e-3)


SQUARE = [(-1.5, -1.5, 1), (1.5, -1.5, 1), (1.5, 1.5, 1), (-1.5, 1.5, 1)]
CORNER = 1.5 / math.sqrt(1 + 1.5**2)
OVERHEAD = 4 / math.pi * CORNER * math.atan(CORNER)


@pytest.mark.parametrize(
    "lamp",
    [
        co.Polygon(SQUARE),
        co.Polygon([(1.5 * x, 1.5 * y, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]).translate((0, 0, 1)),
        co.Polygon([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]).rotate("x", 90).scale(1.5).translate((0, 0, 1)),
        co.Box((-1.5, -1.5, 1), (1.5, 1.5, 2)),
    ],
    ids=["polygon", "moved", "turned and scaled", "a box, which paths find alone"],
)
def test_a_square_overhead(lamp):
    """Four corners of F = (X / √(1 + X²)) atan(X / √(1 + X²)) / π each, X = 1.5 the half side over the height."""
    assert color([floor(), co.Body(lamp, co.glow(1))], samples=4096) == pytest.approx([OVERHEAD] * 3, rel=5e-3)


def test_two_triangles_are_a_square():
    a, b, c, d = SQUARE
    lamps = [co.Body(co.Triangle(a, b, c), co.glow(1)), co.Body(co.Triangle(a, c, d), co.glow(1))]
    assert color([floor(), *lamps], samples=4096) == pytest.approx([OVERHEAD] * 3, rel=5e-3)


@pytest.mark.parametrize(
    "lamp",
    [
        co.Cylinder((-1, 0.3, 1.5), (1, 0.2, 1.2), 0.4),
        co.Polygon([(-1, -1, 1), (1, -1, 1), (1, 1, 1.0), (0, 1, 1), (0, 0, 1), (-1, 0, 1)]),
        co.Sphere(0.5, (0.3, 0.4, 0.9)).rotate("z", 30),
        co.Disc((0.5, 0, 1), (1, 0, 2), 0.7),
    ],
    ids=lambda lamp: type(lamp).__name__,
)
def test_lamps_that_are_drawn_are_as_bright_as_those_that_paths_find(lamp):
    """A cut lamp is not a shape to draw points from; here the cut removes nothing."""
    box = co.Box((-9, -9, -9), (9, 9, 9))
    drawn, found = (color([floor(), co.Body(shape, co.glow(1))], samples=1 << 15) for shape in (lamp, lamp & box))
    assert drawn == pytest.approx(found, rel=5e-3)


@pytest.mark.parametrize("lamp", [co.Sphere(3), co.Cylinder((0, 0, -3), (0, 0, 3), 2), co.Box((-2,) * 3, (2,) * 3)])
def test_within_a_lamp_all_is_as_bright_as_its_colour(lamp):
    inside = co.OrthographicCamera((0, 0, 1.5), (0, 0, 0), up=(0, 1, 0), height=1e-6)
    ball = co.Body(co.Sphere(1), co.matte((0.5, 0.5, 0.5)))
    radiance = color([co.Body(lamp, co.glow(1)), ball], camera=inside, depth=1, samples=4096)
    assert radiance == pytest.approx([0.5] * 3, rel=2e-3)


def test_a_lamp_flush_with_a_ceiling_gives_light_where_it_is_listed_first():
    """Of coincident surfaces the first in the list is visible, and it alone gives light."""
    lamp, ceiling = (
        co.Body(co.Disc((0, 0, 1), (0, 0, 1), 1), co.glow(1)),
        co.Body(co.Box((-3, -3, 1), (3, 3, 2)), BLACK),
    )
    assert color([lamp, ceiling, floor(co.matte(WHITE))], depth=1) == pytest.approx([0.5] * 3, rel=5e-3)
    assert color([ceiling, lamp, floor(co.matte(WHITE))], depth=1) == pytest.approx([0.0] * 3, abs=1e-12)


# Surroundings


def test_a_white_ball_in_a_white_furnace_is_white():
    view = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=2.2)
    scene = co.Scene([co.Body(co.Sphere(1), co.matte(WHITE))], background=WHITE, camera=view)
    assert (scene.render(24, 24, 4, "path").pixels == 1).all()


def test_ambient_light_comes_from_where_nothing_is():
    ball = co.Body(co.Sphere(1, (0, 0, -1)), co.matte((0.5, 0.5, 0.5)))
    assert color([ball], [co.AmbientLight(0.6)], samples=64) == pytest.approx([0.3] * 3, rel=1e-6)


def image(height=8, width=16, seed=0):
    return np.random.default_rng(seed).random((height, width, 3)) ** 4


def bilinear(pixels, d):
    """Return the radiance of an image along directions, by a second implementation."""
    height, width, _ = pixels.shape
    row = np.arccos(d[:, 2]) / np.pi * height - 0.5
    column = np.arctan2(d[:, 1], d[:, 0]) / (2 * np.pi) % 1 * width - 0.5
    above, left = np.floor(row).astype(int), np.floor(column).astype(int)
    s, t = (row - above)[:, None], (column - left)[:, None]

    def at(i, j):
        return pixels[np.clip(i, 0, height - 1), j % width]

    upper = (1 - t) * at(above, left) + t * at(above, left + 1)
    return (1 - s) * upper + s * ((1 - t) * at(above + 1, left) + t * at(above + 1, left + 1))


def test_surroundings_of_an_image():
    """A floor has ∫ L cos / π, here by the midpoint rule."""
    pixels = image()
    u, v = (np.stack(np.meshgrid(*[np.arange(600)] * 2)).reshape(2, -1) + 0.5) / 600
    z, turn = np.sqrt(u), 2 * np.pi * v
    r = np.sqrt(1 - u)
    expected = bilinear(pixels, np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)).mean(axis=0)
    radiance = color([floor()], background=co.Environment(pixels, intensity=2), samples=1 << 14, depth=1)
    assert radiance == pytest.approx(2 * expected, rel=5e-3)


def test_a_bright_spot_of_an_image_is_aimed_at():
    pixels = np.zeros((64, 128, 3))
    pixels[10, 100] = 1e4
    few = [color([floor()], background=co.Environment(pixels), samples=64, seed=k)[0] for k in range(20)]
    assert np.std(few) < 0.2 * np.mean(few)


def test_a_panorama_shows_its_surroundings():
    """Balls at the six ends of the axes are where they were, as looks along the axes show."""
    ends = np.concatenate([np.eye(3), -np.eye(3)])
    balls = [co.Body(co.Sphere(0.5, 3 * end), co.glow(0.1 + np.abs(end))) for end in ends[:4]]
    panorama = co.Scene(balls, [co.AmbientLight(0)], background=BLACK).render(
        128, 64, 4, "path", camera=co.EquirectangularCamera((0, 0, 0), (-1, 0, 0))
    )
    seen = co.Scene([co.Sphere(1, (50, 60, 70))], background=co.Environment(panorama))
    for end, expected in zip(ends, [*(0.1 + np.eye(3)), (1.1, 0.1, 0.1), BLACK, BLACK], strict=True):
        camera = co.OrthographicCamera((0, 0, 0), end, up=end[[1, 2, 0]], height=1e-9)
        found = seen.render(1, 1, 1, "path", camera=camera).values[0, 0]
        assert found == pytest.approx(np.array(expected), rel=1e-5), end


# Walls and media


def test_walls_that_abut_leak_nothing():
    """A black room of six boxes, face to face, stands in a bright sky. No path leaves it."""
    walls = [
        co.Box((-2, -2, -2), (2, 2, -1)), co.Box((-2, -2, 1), (2, 2, 2)), co.Box((-2, -2, -1), (-1, 2, 1)),
        co.Box((1, -2, -1), (2, 2, 1)), co.Box((-1, -2, -1), (1, -1, 1)), co.Box((-1, 1, -1), (1, 2, 1)),
    ]  # fmt: skip
    room = [co.Body(wall.rotate((1, 2, 3), 25), co.matte((0.9, 0.9, 0.9))) for wall in walls]
    within = co.Camera((0, 0, 0), (1, 0.3, 0.2), field_of_view=120)
    scene = co.Scene(room, background=WHITE, camera=within, lights=[co.DirectionalLight((0.3, 0.2, -1), 5)])
    assert (scene.render(32, 32, 8, "path", depth=12).pixels == 0).all()


@pytest.mark.parametrize(
    ("look", "core", "samples", "depth", "rel"),
    [
        *((co.glass(index), co.glass(1.3, roughness=0.0), 64, 200, 1e-5) for index in (1.0, 1.5)),
        *((co.fog((1, 0.9, 0.8), anisotropy=share), None, 256, 500, 0.01) for share in (0.0, 0.7, -0.5)),
        # Dispersing glass has the mean color of glass that does not disperse
        (co.glass(1.5, dispersion=0.01), None, 1024, 50, 0.02),
    ],
)
def test_a_ball_without_absorption_is_invisible_in_a_furnace(look, core, samples, depth, rel):
    bodies = (
        [co.Body(co.Sphere(1), look)] if core is None else [co.Body(co.Sphere(0.5), core), co.Body(co.Sphere(1), look)]
    )
    view = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=1.5 if core is None else 1.8)
    pixels = co.Scene(bodies, background=WHITE, camera=view).render(8, 8, samples, "path", depth=depth).pixels
    mean = pixels.mean(axis=(0, 1)) if core is None else pixels
    assert mean == pytest.approx(np.ones_like(mean), rel=rel)


def test_absorption_by_beers_law():
    """The slab has index 1 and is 2 thick along the axis: exp(-2 σ) of the background."""
    slab = co.Body(co.Box((-5, -5, -2), (5, 5, 0)), co.Material(transparency=1, absorption=(0.1, 0.5, 2)))
    down = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=1e-6)
    radiance = color([slab], background=WHITE, camera=down, samples=4)
    assert radiance == pytest.approx(np.exp(-2 * np.array((0.1, 0.5, 2))), rel=1e-6)


def test_light_scattered_once():
    """A chord of length 2 R of a ball of fog scatters parallel light from across it once.

    It sends σ ∫ exp(-σ s) p exp(-σ l(s)) ds E, with l the way in from the side, p = 1 / (4π), E = π I; here for thin
    fog.
    """
    sigma = 0.5
    s = (np.arange(20000) + 0.5) / 10000
    across = np.sqrt(1 - (s - 1) ** 2)
    expected = np.mean(sigma * np.exp(-sigma * (s + across))) * 2 / (4 * np.pi) * np.pi
    down = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=1e-6)
    ball = co.Body(co.Sphere(1), co.fog(sigma))
    radiance = color([ball], [co.DirectionalLight((1, 0, 0))], camera=down, samples=1 << 14, depth=1)
    assert radiance == pytest.approx([expected] * 3, rel=0.01)


def test_a_pane_transmits_as_much_light_of_a_lamp_as_it_shows():
    """A thin pane transmits 1 - 2 F / (1 + F), F = 0.04 at normal incidence, nearly so for a lamp far above."""
    lamp, pane = (
        co.Body(co.Disc((0, 0, 20), (0, 0, 1), 0.5), co.glow(1000)),
        co.Body(co.Plane((0, 0, 1), 5), co.glass(1.5)),
    )
    clear, behind = color([lamp, floor()], depth=1), color([lamp, pane, floor()], depth=1)
    assert behind / clear == pytest.approx([1 - 2 * 0.04 / 1.04] * 3, rel=2e-3)


# Depth


def test_depth_counts_scatterings():
    """A closed room of albedo 1/2 glows with 1: 1 + 1/2 + 1/4 + ..."""
    room = co.Body(co.Sphere(3), co.glow(1, (0.5, 0.5, 0.5)))
    inside = co.OrthographicCamera((0, 0, 1.5), (0, 0, 0), up=(0, 1, 0), height=1e-6)
    for depth in (0, 1, 2, 5):
        radiance = color([room], camera=inside, depth=depth, samples=2048)
        assert radiance == pytest.approx([2 - 0.5**depth] * 3, rel=0.01)


def test_direct_light_is_a_path_of_one_scattering():
    items = [floor(), co.Body(co.Sphere(1, (0, 0, 2)), co.glow(1, (0.5, 0.5, 0.5)))]
    assert (color(items, integrator="direct") == color(items, depth=1)).all()


# The same bits

STILL_LIFE = co.Scene(
    [
        floor(co.matte((0.6, 0.5, 0.4), roughness=0.5)), co.Body(co.Sphere(1, (0, 0, 1)), co.glass(1.5, roughness=0.2)),
        co.Body(co.Sphere(1, (2.2, 0, 1)), co.materials.gold(0.2)), co.Body(co.Sphere(1, (-2.2, 0, 1)), co.plastic("navy")),
        co.Body(co.Disc((0, 0, 5), (0, 0, 1), 1), co.glow(9)), co.Body(co.Sphere(0.5, (1, -2, 0.5)), co.fog(3)),
        co.Body(co.Sphere(0.4, (-1, -2, 0.4)), co.glass(1.6, dispersion=0.02)),
    ],
    camera=co.Camera((0, -8, 3), (0, 0, 1)), lights=[co.PointLight((3, -4, 5), 0.3)], background=co.Sky(),
)  # fmt: skip


@pytest.mark.parametrize("integrator", ["path", "direct", "occlusion"])
def test_any_number_of_threads_makes_the_same_picture(integrator):
    pictures = on_threads(lambda: STILL_LIFE.render(70, 50, 2, integrator).pixels, 1, 2, 7)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()
    assert np.isfinite(pictures[0]).all()


# --- The points of light transport: nets in each pair of dimensions, the same at any time, independent of one another


@numba.njit
def _points(seed, pixel, count, pair):
    found = np.empty((count, 2))
    for k in range(count):
        found[k] = sobol.sobol_pair(seed, pixel, k, pair)
    return found


@pytest.mark.parametrize("pair", [0, 1, 7])
@pytest.mark.parametrize("pixel", [0, 12345])
@pytest.mark.parametrize("power", [1, 4, 7, deep(10)])
def test_every_box_of_a_power_of_two_has_one_point(pair, pixel, power):
    """A (0, m, 2)-net is also one in its first 2^m points, so that a picture may go on."""
    points = _points(3, pixel, 2**power, pair)
    assert ((points >= 0) & (points < 1)).all()
    for across in range(power + 1):
        boxes = np.floor(points * (2**across, 2 ** (power - across))).astype(int)
        assert len({tuple(box) for box in boxes}) == 2**power


def test_single_dimensions_are_those_of_pairs():
    one = compiled(sobol.sobol)
    for k in range(20):
        assert [one(5, 6, k, 8), one(5, 6, k, 9)] == list(_points(5, 6, 20, 4)[k])


@pytest.mark.parametrize("other", [dict(seed=1), dict(pixel=8), dict(pair=3)])
def test_seeds_pixels_and_pairs_have_points_of_their_own(other):
    first = dict(seed=0, pixel=7, count=64, pair=2)
    assert (_points(*first.values()) != _points(*(first | other).values())).all()


def test_pairs_and_pixels_are_independent_on_the_whole():
    """Moments of 16 points in each of 4000 pixels, in two pairs, are within 5 standard errors of independent ones."""
    a, b = (np.concatenate([_points(0, pixel, 16, pair) for pixel in range(4000)]) for pair in (4, 5))
    four = np.concatenate([a, b], axis=1)
    assert np.abs(four.mean(axis=0) - 0.5).max() < 5 / np.sqrt(12 * len(four))
    correlation = np.corrcoef(four.T) - np.eye(4)
    assert np.abs(correlation).max() < 5 / np.sqrt(len(four))
