"""Pictures: reproducible to the bit, true to the geometry; samples in a pixel; light by groups."""

import io

import numpy as np
import pytest

import conicoid as co
from conicoid.render import sampling as sampler
from conicoid.render.integrators import INTEGRATORS
from conicoid.render.tiles import SIDE

from ..compiled import compiled
from ..thread_counts import on_threads

# --- Pictures: reproducible to the bit, true to the geometry, with errors that list the choices


SCENE = co.Scene(
    [
        co.Body(co.Sphere(1, (0, 0, 1)), co.glass()),
        co.Body(co.Cylinder((1, 1, 0), (2, 1.5, 1), 0.5), co.lacquer("crimson")),
        co.Body(co.Box((-4, -4, -0.2), (4, 4, 0)), co.matte(co.Checker(scale=0.5, space=True))),
    ],
)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_same_picture_for_any_number_of_threads(integrator):
    pictures = on_threads(lambda: SCENE.render(50, 37, 3, integrator=integrator).pixels, 1, 2, 5)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()


def test_seeds_move_the_samples():
    one, two = (SCENE.render(50, 37, 3, seed=seed).pixels for seed in (1, 2))
    assert (one == SCENE.render(50, 37, 3, seed=1).pixels).all()
    assert (one != two).any()
    assert np.abs(one.mean() - two.mean()) < 0.01


def test_one_sample_goes_through_the_pixel_centre():
    camera = co.Camera((4, -6, 4), (0, 0, 0.5))
    scene = co.Scene(SCENE.bodies, camera=camera)
    pixels = scene.render(40, 30, 1, integrator="normals").pixels
    normal = np.asarray(scene.first_hit(camera.rays(40, 30)).normal)
    expected = np.where(np.isnan(normal), 0, 0.5 + 0.5 * normal)
    assert np.abs(pixels - expected).max() < 1e-6


def test_a_camera_and_lights_come_by_themselves():
    pixels = SCENE.render(60, 40, 1).pixels
    assert pixels.dtype == np.float32
    assert pixels.shape == (40, 60, 3)
    assert np.ptp(pixels) > 0.5
    assert co.Scene([]).render(8, 8).pixels.min() > 0.5


def test_progress_ends_with_the_count():
    calls = []
    SCENE.render(50, 37, 1, progress=lambda done, count: calls.append((done, count)))
    tiles = -(-50 // SIDE) * -(-37 // SIDE)
    assert calls[-1] == (tiles, tiles)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            dict(integrator="photons"),
            ValueError,
            f"render: integrator must be one of {', '.join(INTEGRATORS)}, got 'photons'",
        ),
        (dict(width=0), ValueError, "render: width must be a whole number of pixels >= 1, got 0"),
        (dict(samples=0), ValueError, "render: samples must be a whole number from 1 to 1048576, got 0"),
        (dict(samples=2.5), ValueError, "render: samples must be a whole number"),
        (dict(seed=-1), ValueError, "render: seed must be a whole number"),
        (dict(depth=-1), ValueError, "render: depth must be a whole number"),
        (
            dict(filter="gausian"),
            ValueError,
            r"render: filter must be one of box, .*, got 'gausian' \(did you mean 'gaussian'",
        ),
        (dict(layers="dept"), ValueError, r"render: layers must be of albedo, .*, got 'dept' \(did you mean 'depth'"),
        (dict(layers=3), TypeError, "render: layers must be names of layers, or True for all, got 3"),
        (
            dict(noise=0.01),
            ValueError,
            r"render: noise goes with integrators whose samples can be continued .*, not whitted",
        ),
        (dict(noise=0, integrator="path"), ValueError, "render: noise must be > 0"),
        (
            dict(preview="window", integrator="path"),
            ValueError,
            "render: preview must be one of terminal, got 'window'",
        ),
        (dict(times=3), ValueError, "times goes with shutter"),
        (dict(shutter=(1, 0)), ValueError, "shutter must close after it opens"),
        (dict(groups=["key"]), TypeError, "groups must be a mapping"),
        (dict(groups={"a": ["kee"]}), ValueError, r"groups\['a'\] must name bodies that glow.*got 'kee'.*key"),
        (dict(groups={"a": [co.AmbientLight(3)]}), ValueError, "must name bodies that glow, lights of the scene"),
        (dict(groups={"": ["key"]}), ValueError, "groups must have names"),
        *(
            ({name: "yes"}, ValueError, f"render: {name} must be true or false, got 'yes'")
            for name in ("axes", "labels", "normals")
        ),
    ],
)
def test_bad_arguments_are_named(arguments, error, message):
    with pytest.raises(error, match=message):
        LIT.render(**{"width": 8, "height": 8, **arguments})


def test_many_bodies_of_one_entry_share_a_material():
    centers = np.array([(x, 0.0, 0.0) for x in (-2, 0, 2)])
    camera = co.OrthographicCamera((0, -5, 0), (0, 0, 0), height=2)
    balls = co.Body(co.Spheres(centers, np.full(3, 0.5)), co.matte((1, 0, 0)))
    pixels = (
        co.Scene([balls], lights=[co.AmbientLight(1)], camera=camera, background=(0, 0, 1)).render(60, 20, 1).pixels
    )
    assert (pixels[10, [10, 30, 50]] == (1, 0, 0)).all()
    assert (pixels[10, [0, 20, 40]] == (0, 0, 1)).all()


# --- Samples in a pixel: stratified, reproducible, different from pixel to pixel


sample_in_pixel = compiled(sampler.sample_in_pixel)


def samples(count: int, pixel: int = 7, seed: int = 0) -> np.ndarray:
    return np.array([sample_in_pixel(seed, pixel, i, count) for i in range(count)])


@pytest.mark.parametrize("count", [2, 3, 4, 5, 7, 9, 16, 25, 64])
def test_each_column_has_one_sample(count):
    for pixel in range(20):
        points = samples(count, pixel)
        assert ((points >= 0) & (points < 1)).all()
        assert (np.floor(points[:, 0] * count) == np.arange(count)).all()


@pytest.mark.parametrize("power", [1, 2, 3, 4, 6])
def test_every_box_of_a_power_of_two_has_one_sample(power):
    count = 2**power
    for pixel in range(20):
        points = samples(count, pixel)
        for columns in (2**k for k in range(power + 1)):
            cells = np.floor(points * (columns, count // columns)).astype(int)
            assert len({tuple(cell) for cell in cells}) == count


def test_samples_depend_on_seed_and_pixel_only():
    assert (samples(9) == samples(9)).all()
    assert (samples(9) != samples(9, pixel=8)).all()
    assert (samples(9) != samples(9, seed=1)).all()


# --- Light by groups adds up to all light; previews have an estimate of their noise


WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
SUN = co.DirectionalLight((1, 0, -2), (0.4, 0.3, 0.1))
KEY = co.Body(co.Disc((0, -1, 3), (0, 0, 1), 0.5), co.glow((6, 3, 1)), "key")
FILL = co.Body(co.Sphere(0.4, (2, 0, 2)), co.glow((0, 1, 4)), "fill")
LIT = co.Scene(
    [co.Body(co.Plane((0, 0, 1), 0), co.matte(WHITE)), co.Body(co.Sphere(0.7, (0, 0, 0.7)), "white"), KEY, FILL],
    [SUN, co.AmbientLight(0.05)], co.Camera((0, -6, 3), (0, 0, 0.5)), (0.05, 0.06, 0.1),
)  # fmt: skip
GROUPS = {"key": ["key"], "rest": ["fill", SUN, co.AmbientLight(0.05)], "sky": "background"}


@pytest.mark.parametrize(("integrator", "samples", "off"), [("path", 256, 0.02), ("whitted", 32, 0.02)])
def test_groups_add_up(integrator, samples, off):
    image = LIT.render(32, 24, samples, integrator, groups=GROUPS)
    parts = {name: image.layers[f"light.{name}"] for name in GROUPS}
    total = sum(parts.values())
    assert total.mean(axis=(0, 1)) == pytest.approx(image.pixels.mean(axis=(0, 1)), rel=off)
    assert parts["key"][..., 2].mean() < parts["key"][..., 0].mean()
    assert min(parts["key"].max(), parts["rest"].max()) > 0


def test_a_group_is_the_picture_with_its_lights_alone():
    dark = LIT.replace("fill", material=co.glow(0)).replace(lights=co.AmbientLight(0), background=BLACK)
    image = LIT.render(16, 12, 8, "path", groups={"key": "key"})
    assert (image.layers["light.key"] == dark.render(16, 12, 8, "path").pixels).all()
    assert (image.pixels == LIT.render(16, 12, 8, "path").pixels).all()


def test_groups_are_layers_of_an_exr(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    image = LIT.render(8, 6, 2, "direct", groups={"key": ["key"]}, layers="depth")
    image.save(tmp_path / "out.exr")
    channels = openexr.File(str(tmp_path / "out.exr"), separate_channels=True).channels()
    assert {"light.key.R", "light.key.G", "light.key.B", "depth.V", "R"} <= set(channels)
    assert (channels["light.key.G"].pixels == image.layers["light.key"][..., 1]).all()


def test_previews_report_their_noise():
    previews = []
    image = LIT.render(16, 12, 32, "path", preview=previews.append, layers="error")
    noises = [one.noise for one in previews]
    assert len(noises) >= 5
    assert noises[0] == np.inf
    assert (np.diff(noises[1:]) < 0).all()
    assert noises[-1] == pytest.approx(np.sqrt((image.layers["error"].astype(float) ** 2).mean()), rel=1e-6)
    assert (previews[-1].pixels == image.pixels).all()


def test_previews_in_a_notebook(monkeypatch):
    """There is one display, which previews update."""
    display = pytest.importorskip("IPython.display")
    calls = []

    class Handle:
        def update(self, image):
            calls.append(image)

    monkeypatch.setattr(display, "display", lambda image, display_id: calls.append(image) or Handle())
    image = LIT.render(8, 6, 8, "path", preview=True)
    assert len(calls) == 4
    assert (calls[-1].pixels == image.pixels).all()


def test_previews_in_a_terminal(monkeypatch):
    """The upper pixel of a half block is the color of the character, and the lower one its background."""
    from rich.console import Console

    from conicoid.io.image_codecs import downsample, render_half_blocks

    pixels = np.zeros((3, 2, 3), np.float32)
    pixels[0, 0], pixels[1, 0], pixels[2, 1] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    text = render_half_blocks(pixels, 10, 10)
    assert text.plain == "\u2580\u2580\n\u2580\u2580"
    assert [str(span.style) for span in text.spans] == [
        "#ff0000 on #00ff00", "#000000 on #000000", "#000000", "#0000ff",
    ]  # fmt: skip
    assert downsample(np.arange(24.0).reshape(4, 2, 3), 1, 2).tolist() == [[[4.5, 5.5, 6.5]], [[16.5, 17.5, 18.5]]]
    shown = io.StringIO()
    console = Console(
        file=shown, force_terminal=True, color_system="truecolor", width=20, height=9, legacy_windows=False
    )
    monkeypatch.setattr("rich.console.Console", lambda **_: console)
    LIT.render(16, 12, 8, "path", preview="terminal")
    assert shown.getvalue().count("\x1b[6A") == 3, "four pictures of six rows, each but the first over the one before"
