"""Films: tone curves, filters, denoising, layers, and the options of commands."""

import importlib.util
import io
import math
import sys

import mpmath
import numpy as np
import PIL.Image
import pytest

import conicoid as co
from conicoid.numerics.portable_math import portable_cos, portable_exp, portable_exp2, portable_interp, portable_log2
from conicoid.parallel.workers import inline_workers
from conicoid.render.color_mapping import apply_tone
from conicoid.render.film import RADII
from conicoid.render.options import FILTERS, LAYERS

from ..command_line import execute, failure, run
from ..thread_counts import on_threads

# --- Films: tone curves, filters, functions by sums and products alone, denoising


# --- Tone curves and exposure: formulas evaluated here one number at a time; files of displayed values

LIGHT = [0.0, 1e-4, 0.01, 0.18, 0.5, 1.0, 3.9, 12.3]


def hable(x):
    return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3


@pytest.mark.parametrize("light", LIGHT)
def test_filmic_is_hables(light):
    found = apply_tone(np.full((1, 1, 3), light), 0, "filmic")
    assert found == pytest.approx(np.full((1, 1, 3), min(1, hable(2 * light) / hable(11.2))), abs=1e-14)


def agx(rgb):
    """Return Wrensch's minimal AgX, step by step. Its result is encoded for the display."""
    r, g, b = rgb
    mixed = (
        0.842479062253094 * r + 0.0784335999999992 * g + 0.0792237451477643 * b,
        0.0423282422610123 * r + 0.878468636469772 * g + 0.0791661274605434 * b,
        0.0423756549057051 * r + 0.0784336 * g + 0.879142973793104 * b,
    )
    y = []
    for value in mixed:
        x = (math.log2(max(value, 1e-30)) + 12.47393) / (4.026069 + 12.47393)
        x = min(1, max(0, x))
        y.append(15.5 * x**6 - 40.14 * x**5 + 31.96 * x**4 - 6.868 * x**3 + 0.4298 * x**2 + 0.1191 * x - 0.00232)
    back = (
        1.19687900512017 * y[0] - 0.0980208811401368 * y[1] - 0.0990297440797205 * y[2],
        -0.0528968517574562 * y[0] + 1.15190312990417 * y[1] - 0.0989611768448433 * y[2],
        -0.0529716355144438 * y[0] - 0.0980434501171241 * y[1] + 1.15107367264116 * y[2],
    )
    return [min(1, max(0, value)) for value in back]


@pytest.mark.parametrize("rgb", [(v, v, v) for v in LIGHT] + [(1, 0.1, 0), (0.02, 0.3, 9), (0.18, 0.02, 0.5)])
def test_agx_is_wrenschs(rgb):
    image = co.Image(np.full((1, 1, 3), rgb, np.float32)).developed(tone="agx")
    assert np.abs(np.asarray(image)[0, 0] - 255 * np.array(agx(rgb))).max() <= 0.5 + 1e-4


@pytest.mark.parametrize("stops", [-2, 0, 1, 2.5])
def test_a_stop_is_twice_as_bright(stops):
    light = np.array([[[0.02, 0.1, 0.05]]], np.float32)
    assert apply_tone(light, stops, "srgb") == pytest.approx(light * 2.0**stops, rel=1e-7)
    again = co.Image(light * np.float32(2.0**stops))
    assert np.abs(np.asarray(co.Image(light).developed(stops)).astype(int) - np.asarray(again)).max() <= 1


def test_saved_pictures_equal_the_screen_and_keep_light(tmp_path):
    pytest.importorskip("OpenEXR")
    image = co.Image(np.random.default_rng(4).random((5, 6, 3)).astype(np.float32) * 3)
    shown = image.developed(-0.5, "filmic")
    assert (shown.pixels == image.pixels).all()
    assert (np.asarray(shown) != np.asarray(image)).any()
    for suffix in ("png", "webp"):
        shown.save(tmp_path / f"a.{suffix}")
        assert (np.asarray(PIL.Image.open(tmp_path / f"a.{suffix}")) == np.asarray(shown)).all()
    shown.save(tmp_path / "a.exr")
    assert (co.materials.ImageTexture(tmp_path / "a.exr").pixels.array == image.pixels).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda image: image.developed(tone="aces"), "developed: tone must be one of srgb, filmic, agx"),
        (lambda image: image.developed(math.inf), "developed: exposure must be finite"),
        (lambda image: image.developed(99), "developed: exposure must be from -64 to 64 stops"),
        (lambda image: co.Image(np.zeros((2, 2))).developed(1), "not a number per pixel"),
        (lambda image: image.save("a.png", bits=12), r"Image: bits of .png must be 16 or 8|must be 8 or 16"),
        (lambda image: image.save("a.webp", bits=16), r"Image: bits of .webp must be 8"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(ValueError, match=message):
        call(co.Image(np.zeros((2, 2, 3))))


def test_png_of_16_bits(tmp_path):
    """FFmpeg reads the file in full, and Pillow keeps the upper byte of each number."""
    import av

    pixels = np.random.default_rng(5).random((37, 23, 3)).astype(np.float32)
    co.Image(pixels).save(tmp_path / "deep.png", bits=16)
    encoded = np.where(pixels <= 0.0031308, 12.92 * pixels, 1.055 * pixels.astype(float) ** (1 / 2.4) - 0.055)
    with av.open(str(tmp_path / "deep.png")) as file:
        (frame,) = file.decode(video=0)
        assert frame.format.name == "rgb48be"
        found = frame.to_ndarray(format="rgb48le")
    assert np.abs(found.astype(float) - 65535 * encoded).max() <= 0.5 + 1e-3
    with PIL.Image.open(tmp_path / "deep.png") as file:
        assert file.size == (23, 37)
        upper = np.asarray(file.convert("RGB")).astype(int)
    assert np.abs(upper - found / 257).max() <= 1


# --- Reconstruction filters: samples have the distribution of the filters, and pictures are the same for any tiles and
# threads


def curve(name, x):
    """Return the filters by their formulas."""
    r = RADII[name]
    t, far = 2 * np.pi * (x + r) / (2 * r), abs(x)
    return {
        "box": lambda: np.ones_like(x),
        "tent": lambda: 1 - far,
        "gaussian": lambda: np.exp(-2 * x**2) - np.exp(-4.5),
        "mitchell": lambda: np.where(
            far < 1, 7 * far**3 - 12 * x**2 + 16 / 3, -7 / 3 * far**3 + 12 * x**2 - 20 * far + 32 / 3
        ) / 6,
        "blackman-harris": lambda: 0.35875 - 0.48829 * np.cos(t) + 0.14128 * np.cos(2 * t) - 0.01168 * np.cos(3 * t),
    }[name]()  # fmt: skip


@pytest.mark.parametrize("name", FILTERS)
def test_flat_light_stays_flat_and_an_edge_is_the_integral_of_the_filter(name):
    wall = co.Body(co.Polygon([(0, 4, -50), (50, 4, -50), (50, 4, 50), (0, 4, 50)]), "white")
    camera = co.OrthographicCamera((0, 0, 0), (0, 1, 0), height=16)  # a pixel is one unit
    scene = co.Scene([wall], camera=camera, background="black", lights=[co.AmbientLight(1)])
    rows = scene.render(16, 16, 4096, filter=name).pixels[8, :, 0]
    x = np.arange(16) + 0.5 - 8  # of the pixels' middles
    fine = np.linspace(-RADII[name], RADII[name], 4001)
    middles, step = (fine[1:] + fine[:-1]) / 2, fine[1] - fine[0]
    f = curve(name, middles)
    expected = [f[middles > -place].sum() * step for place in x] / (f.sum() * step)
    assert np.abs(rows - expected).max() < (0.04 if name == "mitchell" else 0.01)


@pytest.mark.parametrize("name", FILTERS)
def test_the_same_picture_for_any_threads(name):
    scene = co.Scene([co.Sphere(), co.Body(co.Sphere(0.5, (1, -1, 0)), co.glass())])
    pictures = on_threads(lambda: scene.render(50, 40, 3, filter=name).pixels, 1, 2, 7)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()
    assert (scene.render(50, 40, 3, filter=name, executor=inline_workers()).pixels == pictures[0]).all()


# --- Functions by sums and products alone, against mpmath at 30 digits


def exactly(function, x):
    with mpmath.workdps(30):
        return np.array([float(function(mpmath.mpf(float(value)))) for value in x])


@pytest.mark.parametrize(
    ("found", "function", "x"),
    [
        (portable_exp, mpmath.exp, np.linspace(-20, 3, 301)),
        (portable_log2, lambda v: mpmath.log(v, 2), np.concatenate([np.geomspace(1e-30, 1e30, 301), [0.7, 1.5]])),
        (portable_cos, mpmath.cos, np.linspace(0, 2 * math.pi, 301)),
    ],
)
def test_near_to_exact(found, function, x):
    assert found(x) == pytest.approx(exactly(function, x), rel=1e-12, abs=1e-13)


def test_powers_of_two():
    assert [portable_exp2(k) for k in (-64, -1, 0, 1, 10)] == [2.0**k for k in (-64, -1, 0, 1, 10)]
    assert portable_exp2(-2.5) == pytest.approx(2**-2.5, rel=1e-13)


def test_between_values():
    places, values = np.array([0.0, 1.0, 1.0, 3.0]), np.array([2.0, 4.0, 5.0, -1.0])
    x = np.array([-1.0, 0.0, 0.25, 1.5, 3.0, 9.0])
    assert portable_interp(x, places, values) == pytest.approx(np.interp(x, places, values), abs=1e-15)


# --- Denoising: pictures come nearer to those without noise


def picture():
    """Return light of two colors, exact and with noise."""
    exact = np.zeros((64, 64, 3), np.float32)
    exact[:, :32], exact[:, 32:] = (0.6, 0.2, 0.1), (0.1, 0.3, 0.5)
    noise = np.random.default_rng(6).normal(0, 0.15, exact.shape).astype(np.float32)
    return exact, np.maximum(exact * (1 + noise), 0)


@pytest.mark.skipif(importlib.util.find_spec("pyoidn") is None, reason="pyoidn is an extra")
def test_noise_is_taken_out_and_edges_stay():
    exact, noisy = picture()
    normal = np.broadcast_to(np.float32((0, 0, 1)), exact.shape).copy()
    for layers in ({}, {"albedo": exact.copy()}, {"albedo": exact.copy(), "normal": normal}):
        image = co.Image._of_light(noisy.copy(), layers).developed(1, "agx")
        found = image.denoised()
        assert np.abs(found.pixels - exact).mean() < 0.25 * np.abs(noisy - exact).mean()
        assert (found.exposure, found.tone) == (1, "agx")
        step = found.pixels[:, 32, 0] - found.pixels[:, 31, 0]
        assert step.mean() < (-0.4 if layers else -0.3)  # of -0.5
    assert (image.pixels == noisy).all()


def test_without_the_library_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(ImportError, match=r"pip install 'conicoid\[denoise\]'"):
        co.Image._of_light(picture()[1]).denoised()
    with pytest.raises(ValueError, match="not a number per pixel"):
        co.Image(np.zeros((2, 2))).denoised()


# --- Layers of a picture, and the commands' options of film


# --- Layers: values at the pixels' centers, and files of them

OpenEXR = pytest.importorskip("OpenEXR")

SCENE = co.Scene(
    [co.Body(co.Sphere(1, (0, 0, 1)), "tomato"), co.Body(co.Box((-2, -2, -1), (2, 2, 0)), co.matte("teal"))],
    camera=co.Camera((4, -6, 3), (0, 0, 0.5)),
)


def test_layers_are_the_hits_of_the_pixels():
    image = SCENE.render(48, 36, 2, layers=True)
    assert tuple(image.layers) == tuple(LAYERS)
    hits = SCENE.first_hit(SCENE.camera.rays(48, 36))
    assert (image.layers["body"] == np.asarray(hits.body)).all()
    assert (image.layers["depth"] == np.asarray(hits.t, np.float32)).all()
    position, normal = np.asarray(hits.point, np.float32), np.nan_to_num(np.asarray(hits.normal)).astype(np.float32)
    assert np.array_equal(image.layers["position"], position, equal_nan=True)
    assert (image.layers["normal"] == normal).all()
    assert (image.layers["samples"] == 2).all()
    assert (image.pixels == SCENE.render(48, 36, 2).pixels).all()
    teal = np.array([0, 0x80, 0x80]) / 255
    middle = image.layers["albedo"][30, 24]  # on the box
    assert middle == pytest.approx(((teal + 0.055) / 1.055) ** 2.4 * (teal > 0), abs=1e-6)


def test_the_error_is_that_of_the_samples():
    image = SCENE.render(24, 18, 8, layers=("error", "samples"))
    error = image.layers["error"]
    assert error.shape == (18, 24)
    assert (error >= 0).all()
    flat = SCENE.first_hit(SCENE.camera.rays(24, 18)).body
    inner = np.asarray(flat)[1:-1, 1:-1]
    same = np.ones_like(inner, bool)
    for dy in (0, 1, 2):
        for dx in (0, 1, 2):
            same &= np.asarray(flat)[dy : dy + 16, dx : dx + 22] == inner
    on_box = same & (inner == 1)
    edges = ~same
    assert error[1:-1, 1:-1][edges].mean() > 5 * error[1:-1, 1:-1][on_box].mean()


def test_all_layers_are_in_the_exr(tmp_path):
    image = SCENE.render(20, 16, 2, layers=True)
    for bits, kind in ((None, np.float32), (16, np.float16)):
        image.save(tmp_path / "layers.exr", bits=bits)
        channels = OpenEXR.File(str(tmp_path / "layers.exr"), separate_channels=True).channels()
        names = {"R", "G", "B", "depth.V", "body.V", "samples.V", "error.V"}
        names |= {f"albedo.{c}" for c in "RGB"} | {f"{name}.{c}" for name in ("normal", "position") for c in "XYZ"}
        assert set(channels) == names
        for k, letter in enumerate("RGB"):
            assert (channels[letter].pixels == image.pixels[..., k].astype(kind)).all()
            assert channels[letter].pixels.dtype == kind
            assert (channels[f"albedo.{letter}"].pixels == image.layers["albedo"][..., k].astype(kind)).all()
        for k, letter in enumerate("XYZ"):
            found, expected = channels[f"position.{letter}"].pixels, image.layers["position"][..., k].astype(kind)
            assert np.array_equal(found, expected, equal_nan=True)
        assert channels["body.V"].pixels.dtype == np.uint32
        assert (channels["body.V"].pixels.astype(np.int32) == image.layers["body"]).all()
        assert (channels["samples.V"].pixels == 2).all()
        assert (channels["depth.V"].pixels == image.layers["depth"].astype(kind)).all()


def test_names_of_layers():
    assert list(SCENE.render(4, 3, 1, layers=["depth", "albedo"]).layers) == ["albedo", "depth"]
    assert SCENE.render(4, 3, 1).layers == {}


# --- `conicoid render` with the options of films: the same as Python's calls

FILE = """
camera: {position: [4, -6, 3], look_at: [0, 0, 0.5], aperture: 0.2}
bodies:
  - shape: {Sphere: {radius: 1, center: [0, 0, 1]}}
    material: {matte: {color: {Gradient: {a: red, b: blue, along: z}}}}
  - shape: {Box: {low: [-2, -2, -1], high: [2, 2, 0]}}
    material: {matte: {color: {Brick: {size: [0.5, 0.2], joint: 0.02}}}}
"""
SMALL = ("--width", "24", "--height", "16", "--samples", "2")


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.yaml").write_text(FILE)
    return tmp_path / "scene.yaml"


def test_a_picture_with_all_of_it(scene, tmp_path):
    output = tmp_path / "out.exr"
    execute("render", scene, "-o", output, *SMALL, "--filter", "tent", "--layers", "all", "--bits", "16")
    image = co.load(scene).render(24, 16, 2, filter="tent", layers=True)
    channels = OpenEXR.File(str(output), separate_channels=True).channels()
    assert (channels["G"].pixels == image.pixels[..., 1].astype(np.float16)).all()
    assert (channels["body.V"].pixels.astype(np.int32) == image.layers["body"]).all()
    execute("render", scene, "-o", output, *SMALL, "--layers", "depth, error")
    names = set(OpenEXR.File(str(output), separate_channels=True).channels())
    assert names == {"R", "G", "B", "depth.V", "error.V"}


def test_exposure_and_tone(scene, tmp_path):
    output = tmp_path / "out.png"
    assert run("render", scene, "-o", output, *SMALL, "--exposure", "-1", "--tone", "agx").exit_code == 0
    shown = co.load(scene).render(24, 16, 2).developed(-1, "agx")
    assert (np.asarray(PIL.Image.open(output)) == np.asarray(shown)).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "a.png", "--layers", "depth"], "--layers goes with an .exr"),
        (["-o", "a.exr", "--tone", "agx"], "--tone goes with a displayed picture"),
        (["-o", "a.webp", "--bits", "16"], "--bits goes with a .png or an .exr"),
        (["-o", "a.png", "--bits", "12"], "--bits must be 16, or 8, got 12"),
        (["-o", "a.png", "--filter", "cubic"], "filter must be one of box"),
        (["-o", "a.png", "--tone", "aces"], "tone must be one of srgb"),
        (["-o", "a.exr", "--layers", "deep"], "layers must be of albedo"),
        (["-o", "a.png", "--noise", "0.01"], "noise goes with integrators"),
        (["-o", "a.png", "--section", "z=0", "--filter", "tent"], "--filter goes with a view"),
    ],
)
def test_ineffective_options_are_refused(scene, options, message):
    options[1] = str(scene.parent / options[1])
    assert message in failure("render", scene, *options, *(SMALL if "--section" not in options else ()))


def test_a_preview_is_written_again_and_again(scene, tmp_path, monkeypatch):
    """The last preview is the picture."""
    written = []
    save = co.Image.save
    monkeypatch.setattr(
        co.Image, "save", lambda image, path, **rest: (written.append(str(path)), save(image, path, **rest))
    )
    options = ("--integrator", "path", "--width", "16", "--height", "12", "--samples", "8")
    execute("render", scene, "-o", tmp_path / "a.png", *options, "--preview", tmp_path / "p.png")
    assert written.count(str(tmp_path / "p.png")) == 4
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "p.png").read_bytes()
    message = failure("render", scene, "-o", tmp_path / "a.png", "--preview", tmp_path / "p.png")
    assert "--preview goes with --integrator" in message


def test_a_preview_in_the_terminal(scene, tmp_path, monkeypatch):
    """The preview stands above the line of progress.

    The test makes the stream a terminal, and lets the line appear at once.
    """
    from rich.console import Console

    from conicoid.cli import terminal

    shown = io.StringIO()
    console = Console(
        file=shown, force_terminal=True, color_system="truecolor", width=40, height=12, legacy_windows=False
    )
    monkeypatch.setattr(terminal, "console", lambda: console)
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    options = ("--integrator", "path", "--width", "64", "--height", "48", "--samples", "64", "--preview", "-")
    execute("render", scene, "-o", tmp_path / "a.png", *options)
    assert "\N{UPPER HALF BLOCK}" in shown.getvalue()
    assert not (tmp_path / "-").exists()


def test_pictures_outside_of_the_folder_need_an_option(tmp_path):
    (tmp_path / "scenes").mkdir()
    PIL.Image.new("RGB", (2, 2), "red").save(tmp_path / "red.png")
    text = "bodies: [{shape: {Sphere: {radius: 1}}, material: {matte: {color: {ImageTexture: {image: ../red.png}}}}}]"
    (tmp_path / "scenes" / "scene.yaml").write_text(text)
    command = ("render", tmp_path / "scenes" / "scene.yaml", "-o", tmp_path / "a.png", *SMALL)
    assert "outside" in failure(*command)
    assert run(*command, "--outside").exit_code == 0
