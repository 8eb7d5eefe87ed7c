"""The page's pictures against the engine's from the same camera."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.materials.color import srgb_encode
from conicoid.viewer.playground import quadrics_scene

from .browser import NARROW, needs_browser, open_exported

pytestmark = needs_browser
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
GALLERY = (
    "balls_and_barrel", "bored_box", "caffeine", "chess_pawn", "cylinder_patch", "die", "engine",
    "free_cylinder", "gear_plate", "glass_water_mirror", "lenses", *(f"nine_quadrics/{k}" for k in range(9)), "polygons", "reactor_pin",
    "salt",
    "shepp_logan", "sliding_planes", "steinmetz",
)  # fmt: skip
QUICK = {"balls_and_barrel", "bored_box", "gear_plate", "glass_water_mirror", "polygons"}


def gallery_scene(name, monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    before = set(sys.modules)
    module = importlib.import_module(name.partition("/")[0])
    # The sheet of quadrics is nine scenes, by number
    scene = module.scene(*module.PLATES[int(name.partition("/")[2])][2:]) if "/" in name else module.scene()
    for added in set(sys.modules) - before:
        if Path(str(getattr(sys.modules[added], "__file__", ""))).parent == EXAMPLES:
            del sys.modules[added]
    return scene


def assert_agrees(browser, scene, folder):
    with open_exported(browser, scene, folder, NARROW) as page:
        drawn = page.pixels()
        assert page.errors == []
        assert page.ask("conicoid.film.shown.samples") == 1
    height, width = drawn.shape[:2]
    rays = (scene.camera or co.Camera((0, 0, 1), (0, 0, 0))).rays(width, height) if scene.camera else None
    expected = scene.render(width, height, samples=1, depth=10).pixels
    apart = np.abs(srgb_encode(np.clip(drawn[..., :3], 0, 1)) - srgb_encode(np.clip(expected, 0, 1))).max(axis=-1)
    assert (apart <= 3 / 255).mean() >= 0.99
    if rays is not None:
        assert ((drawn[..., 3] > 0.5) == scene.occluded(rays)).mean() >= 0.999
    assert drawn[..., :3].std() > 0.02


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.deep) for name in GALLERY]
)
def test_gallery(browser, name, tmp_path, monkeypatch):
    assert_agrees(browser, gallery_scene(name, monkeypatch), tmp_path)


def test_playground(browser, tmp_path):
    assert_agrees(browser, quadrics_scene(), tmp_path)


def test_silhouettes_against_the_sky(browser, tmp_path):
    """Every kind of entry stands against the sky, and the mask is the engine's."""
    camera = co.Camera((0, -9, 3), (0, 0, 0), field_of_view=30)
    shapes = [
        co.Sphere(1, (-2, 0, 0)),
        co.Spheres([(0, 0, 1), (0.5, 0, 1)], [0.4, 0.3]),
        co.DoubleCone(1, z_range=(-1, 1)).translate((2, 0, 0)),
        (co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(1.2)).scale(0.6),
        co.Disc((0, 0, -1.3), (0, -1, 1), 0.6),
        co.Polygon([(-1, 0, -1), (1, 0, -1), (0, 0, -0.4)]).translate((-1.6, 0, -0.8)),
        co.Cylinder((1, 0, -1.4), (3, 0, -1.2), 0.3, 20, 300, (0, 1, 0)),
    ]
    assert_agrees(browser, co.Scene(shapes, camera=camera, lights=[co.DirectionalLight((0.3, 1, -1), 1.0)]), tmp_path)


@pytest.mark.parametrize("kind", ["ten thousand balls", "a body of five hundred leaves"])
def test_large_scenes_draw(browser, kind, tmp_path):
    rng = np.random.default_rng(0)
    centers = rng.uniform(-1, 1, (10_000, 3))
    if kind == "ten thousand balls":
        bodies = [co.Spheres(centers, np.full(10_000, 0.02))]
    else:
        bodies = [co.Box((-1, -1, -1), (1, 1, 1)) - co.Union(tuple(co.Sphere(0.12, tuple(c)) for c in centers[:500]))]
    camera = co.Camera((0.5, -5, 2), (0, 0, 0), field_of_view=32)
    assert_agrees(browser, co.Scene(bodies, camera=camera, lights=[co.DirectionalLight((0.3, 1, -1), 1.0)]), tmp_path)


def test_walls_that_light_does_not_notice_cost_no_turn(browser, tmp_path):
    """Twelve walls separate two materials that are alike to light, the innermost first, with a box behind.

    The depth is ten.
    """
    clear = [co.Material(transparency=1.0, refractive_index=1.0, name=name) for name in ("one", "other")]
    shells = [co.Body(co.Sphere(1.5 + 0.1 * k), material=clear[k % 2]) for k in range(6)]
    camera = co.Camera((0, -9, 0), (0, 0, 0), field_of_view=30)
    bodies = [*shells, co.Body(co.Box((-0.5, 3, -0.5), (1.5, 4, 1)), material=co.matte("#b02018"))]
    assert_agrees(browser, co.Scene(bodies, camera=camera, lights=[co.AmbientLight(1)]), tmp_path)


def test_coincident_crossings_are_listed_as_the_engine_lists_them(browser, tmp_path):
    """Glass and a block are in one place, and the glass is first in the list. Light meets the block."""
    block = co.Box((-1, -1, -1), (1, 1, 1))
    camera = co.Camera((0.1, -9, 0.2), (0.1, 0, 0.2), field_of_view=30)
    bodies = [co.Body(block, material=co.glass()), co.Body(block, material=co.matte("#b02018"))]
    scene = co.Scene(bodies, camera=camera, lights=[co.AmbientLight(1)])
    with open_exported(browser, scene, tmp_path, NARROW) as page:
        width, height = page.size()
        found = page.ask(
            f"conicoid.picker.at({{ camera: conicoid.state.camera, section: null }}, {width / 2}, {height / 2}, {width}, {height}, 64)"
        )
        expected = scene.crossings(camera.position, np.subtract(camera.look_at, camera.position))
        assert [hit["body"] for hit in found] == expected.body.tolist() == [0, 1, 0, 1]
        red, _, blue = page.pixels()[height // 2, width // 2, :3]
        assert red > 3 * blue


# --- The picture at rest: samples add up to smooth edges and soft shadows


@pytest.mark.deep
def test_at_rest_edges_become_smooth_and_shadows_soft(browser, tmp_path):
    floor = co.Body(co.Disc((0, 0, -1), (0, 0, 1), 6), co.matte("#c03028"))
    scene = co.Scene(
        [co.Sphere(0.7), floor], [co.PointLight((0, 0, 5))], co.Camera((0, -6, 4), (0, 0, -0.5), field_of_view=40)
    )
    with open_exported(browser, scene, tmp_path, NARROW) as page:
        sharp = page.pixels()[..., 0]
        page.ask("(() => { conicoid.film.most = 8; conicoid.film.wake(); })()")
        page.ask("conicoid.film.settled(8)")
        many = "(() => Array.from(conicoid.film.read().values))()"
        smooth = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
        page.page.get_by_label("Softness of shadows").focus()
        page.page.keyboard.press("End")
        page.ask("conicoid.film.settled(8)")
        soft = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
        assert page.ask("conicoid.state.softness") == 0.1
        page.page.keyboard.press("Home")
        page.ask("conicoid.film.settled(8)")
        again = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
    edges = np.abs(np.diff(sharp, axis=1)) > 0.1
    assert np.abs(np.diff(smooth, axis=1))[edges].mean() < 0.8 * np.abs(np.diff(sharp, axis=1))[edges].mean()
    assert (np.abs(soft - smooth) > 0.05).mean() > 0.004  # the half-shadow
    assert np.array_equal(again, smooth)
