"""Pictures that continue: to more samples, to less noise, after Ctrl-C and after a kill; always to the same bits."""

import contextlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import conicoid as co
from conicoid.render.film import (
    COUNT,
    LEAST_SAMPLES,
    SQUARES,
    pixel_errors,
    select_squares,
    square_errors,
    square_means,
)

from ..interruptions import Interruption
from ..samples import deeper
from ..thread_counts import on_threads

NAME = "path"


def scene() -> co.Scene:
    return co.Scene(
        [
            co.Body(co.Sphere(1, (0, 0, 1)), co.lacquer("tomato")),
            co.Body(co.Box((-3, -3, -1), (3, 3, 0)), co.matte(co.Checker(scale=0.2, space=True))),
        ],
        camera=co.Camera((4, -6, 3), (0, 0, 0.5), aperture=0.3),
        background="white",
    )


WIDTH, HEIGHT = 70, 50


@pytest.fixture(scope="module")
def whole():
    return scene().render(WIDTH, HEIGHT, 40, NAME)


def test_samples_are_continued(whole, tmp_path):
    for samples in (3, 11, 40):
        image = scene().render(WIDTH, HEIGHT, samples, NAME, resume=tmp_path / "file", layers="samples")
        assert (image.layers["samples"] == samples).all()
    assert (image.pixels == whole.pixels).all()
    again = scene().render(WIDTH, HEIGHT, 40, NAME, resume=tmp_path / "file", progress=Interruption())  # it is complete
    assert (again.pixels == whole.pixels).all()
    fewer = scene().render(WIDTH, HEIGHT, 8, NAME, resume=tmp_path / "file")
    assert (fewer.pixels == whole.pixels).all()  # existing samples are not discarded
    with pytest.raises(ValueError, match="holds parts of other work"):
        scene().render(WIDTH, HEIGHT, 40, NAME, seed=1, resume=tmp_path / "file")


def test_workers_continue_too(whole, tmp_path):
    from conicoid.parallel.workers import inline_workers

    scene().render(WIDTH, HEIGHT, 11, NAME, resume=tmp_path / "file")
    workers = inline_workers()
    workers.chunk = 1
    far = scene().render(WIDTH, HEIGHT, 40, NAME, resume=tmp_path / "file", executor=workers, layers="error")
    assert (far.pixels == whole.pixels).all()
    assert (far.layers["error"] == scene().render(WIDTH, HEIGHT, 40, NAME, layers="error").layers["error"]).all()


@pytest.mark.parametrize("at", [1, 7, 20])
def test_ctrl_c_loses_no_whole_sample(whole, tmp_path, at):
    stop = Interruption(at)
    with contextlib.suppress(KeyboardInterrupt):
        scene().render(WIDTH, HEIGHT, 40, NAME, resume=tmp_path / "file", progress=stop)
    assert len(stop.calls) <= at
    image = scene().render(WIDTH, HEIGHT, 40, NAME, resume=tmp_path / "file")
    assert (image.pixels == whole.pixels).all()


def test_a_cut_file_continues(whole, tmp_path):
    file = tmp_path / "file"
    scene().render(WIDTH, HEIGHT, 24, NAME, resume=file)
    data = file.read_bytes()
    for size in (0, 10, 40, len(data) // 2, len(data) - 1):
        file.write_bytes(data[:size])
        assert (scene().render(WIDTH, HEIGHT, 40, NAME, resume=file).pixels == whole.pixels).all()


def test_a_file_that_grew_is_written_anew(whole, tmp_path, monkeypatch):
    from conicoid.parallel import pictures

    monkeypatch.setattr(pictures, "_LARGE", -4 * WIDTH * HEIGHT * 40)
    for samples in (1, 2, 5, 40):
        image = scene().render(WIDTH, HEIGHT, samples, NAME, resume=tmp_path / "file")
    assert (tmp_path / "file").stat().st_size < 1.1 * WIDTH * HEIGHT * 40 + 1000
    assert (image.pixels == whole.pixels).all()
    monkeypatch.undo()
    assert (scene().render(WIDTH, HEIGHT, 40, NAME, resume=tmp_path / "file").pixels == whole.pixels).all()


# ---- Noise ----


def test_the_error_of_a_pixel_is_the_standard_error():
    rng = np.random.default_rng(8)
    light = rng.random((2000, 9, 1)) * 0.2 + 0.1  # grey: of luminance itself
    sums = np.zeros((1, 9, 5))
    sums[0, :, :3], sums[0, :, SQUARES], sums[0, :, COUNT] = light.sum(axis=0), (light[..., 0] ** 2).sum(axis=0), 2000
    mean, error = light[..., 0].mean(axis=0), light[..., 0].std(axis=0, ddof=1) / np.sqrt(2000)
    assert pixel_errors(sums)[0] == pytest.approx(np.sqrt(mean + error) - np.sqrt(mean), rel=1e-6)
    assert error == pytest.approx(np.full(9, 0.2 / np.sqrt(12 * 2000)), rel=0.1)  # of a uniform distribution


def test_squares_at_the_edges_count_their_pixels():
    values = np.arange(35.0).reshape(5, 7)
    found = square_means(values, 4)
    assert found == pytest.approx(
        np.array([[values[:4, :4].mean(), values[:4, 4:].mean()], [values[4:, :4].mean(), values[4:, 4:].mean()]])
    )


def test_pixels_below_the_noise_limit_are_done():
    sums = np.zeros((8, 16, 5))
    sums[..., COUNT], sums[..., :3], sums[..., SQUARES] = LEAST_SAMPLES, LEAST_SAMPLES * 0.5, LEAST_SAMPLES * 0.25
    sums[:, 8:, SQUARES] += LEAST_SAMPLES * 0.04
    expected = np.sqrt(0.5 + np.sqrt(0.04 / (LEAST_SAMPLES - 1))) - np.sqrt(0.5)
    assert square_errors(sums, 8)[0] == pytest.approx([0, expected], abs=1e-9)
    assert select_squares(sums, 48, expected * 0.9, 8).tolist() == [[0, 1]]
    assert select_squares(sums, 48, expected * 1.1, 8).tolist() == [[0, 0]]
    assert select_squares(sums, 48, None, 8).tolist() == [[1, 1]]
    sums[..., COUNT] = LEAST_SAMPLES + 1  # where no pass ends no pixel is decided
    assert select_squares(sums, 48, 1.0, 8).tolist() == [[1, 1]]


def test_noise_ends_where_it_is_low(tmp_path):
    limit = 0.02
    image = scene().render(WIDTH, HEIGHT, 400, NAME, noise=limit, layers=("samples", "error"))
    samples, error = image.layers["samples"], image.layers["error"]
    assert samples.min() == LEAST_SAMPLES  # the sky and the ball's middle
    assert samples.max() > 2 * LEAST_SAMPLES
    rms = np.sqrt(square_means(error.astype(float) ** 2, 8))
    assert ((rms <= limit * (1 + 1e-6)) | (samples[::8, ::8] == 400)).all()
    converged = scene().render(WIDTH, HEIGHT, 1000, NAME).pixels
    difference = np.sqrt(np.clip(image.pixels, 0, None)) - np.sqrt(np.clip(converged, 0, None))
    assert np.sqrt((difference**2).mean()) < 1.5 * limit
    # the noise limit of the first run changes no bit of the second
    scene().render(WIDTH, HEIGHT, 90, NAME, noise=0.05, resume=tmp_path / "file")
    again = scene().render(WIDTH, HEIGHT, 400, NAME, noise=limit, resume=tmp_path / "file")
    assert (again.pixels == image.pixels).all()
    (other,) = on_threads(lambda: scene().render(WIDTH, HEIGHT, 400, NAME, noise=limit), 3)
    assert (other.pixels == image.pixels).all()


def test_previews_become_the_picture(whole):
    previews = []
    image = scene().render(WIDTH, HEIGHT, 40, NAME, preview=previews.append)
    assert len(previews) > 4
    assert (previews[-1].pixels == image.pixels).all()
    differences = [np.abs(each.pixels - image.pixels).mean() for each in previews]
    assert differences[0] > 3 * differences[-2] > 0


# ---- Death ----

DRIVER = """
import sys
import conicoid as co
from conicoid.render import exposure
from tests.film.test_long_work import scene
exposure.SAVE_INTERVAL = 0.05
image = scene().render(160, 120, int(sys.argv[1]), sys.argv[2], int(sys.argv[3]), resume=sys.argv[4])
image.save(sys.argv[5])
"""


def _until_it_is_there(options, most, folder):
    """Return how often, up to `most` times, the process of a picture was killed at random, and the picture's file.

    asked: samples, integrator and seed. Each process lives until it has kept something, and a little longer.
    """
    file, picture = folder / "file", folder / "picture.exr"
    rng, killed = np.random.default_rng(options[2]), 0
    while not picture.exists():
        driver = subprocess.Popen([sys.executable, "-c", DRIVER, *map(str, options), file, picture])
        if killed == most:
            assert driver.wait() == 0
            continue
        before = file.stat().st_size if file.exists() else 0
        wait = time.monotonic() + 600
        while driver.poll() is None and time.monotonic() < wait:
            if file.exists() and file.stat().st_size > before + 100:
                break
            time.sleep(0.01)
        time.sleep(float(rng.uniform(0, 0.3)))
        if driver.poll() is None:
            driver.send_signal(signal.SIGKILL)
            killed += 1
            driver.wait()
        assert driver.returncode in (0, -signal.SIGKILL), "a process ended by itself, without a picture"
    return killed, picture


def _kill(times, tmp_path, samples, integrator):
    pytest.importorskip("OpenEXR")
    """Pictures one after the other, each compared to its last bit, until so many kills."""
    killed, seed = 0, 0
    while killed < times:
        folder = tmp_path / str(seed)
        folder.mkdir()
        more, picture = _until_it_is_there((samples, integrator, seed), times - killed, folder)
        scene().render(160, 120, samples, integrator, seed).save(folder / "local.exr")
        assert picture.read_bytes() == (folder / "local.exr").read_bytes()
        assert more > 0, "the picture was there before its process could be killed"
        killed, seed = killed + more, seed + 1


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
@pytest.mark.parametrize(
    ("times", "samples", "integrator"), [(1, 64, NAME), *deeper([(20, 400, "path"), (20, 400, "direct")])]
)
def test_a_killed_process_loses_no_stored_light(tmp_path, times, samples, integrator):
    _kill(times, tmp_path, samples, integrator)
