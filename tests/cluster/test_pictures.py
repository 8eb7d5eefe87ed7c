"""Pictures in tiles on workers, and those that go on where a driver was stopped."""

from __future__ import annotations

import errno
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import conicoid as co
from conicoid.parallel.pictures import Checkpoint
from conicoid.parallel.workers import inline_workers

from . import subject


def test_tiles_of_workers_to_the_bit():
    scene = subject.scene()
    local = scene.render(100, 70, samples=2, axes=True)
    told = []
    with co.parallel.Processes(1) as pool:
        for chunk in (1, 5, None):
            how = co.parallel.Workers(pool, chunk=chunk)
            far = scene.render(100, 70, samples=2, axes=True, executor=how, progress=lambda *step: told.append(step))
            assert np.array_equal(far.pixels, local.pixels)
    assert told[-1] == (4 * 3, 4 * 3)  # tiles of 32 pixels


def test_a_picture_goes_on(tmp_path):
    scene, file = subject.scene(), tmp_path / "tiles"
    local = scene.render(100, 70, samples=1)
    stopped = []

    def stop(done, count):
        stopped.append(done)
        if done == 5:
            raise KeyboardInterrupt

    workers = inline_workers()
    workers.chunk = 1
    with pytest.raises(KeyboardInterrupt):
        scene.render(100, 70, samples=1, resume=file, executor=workers, progress=stop)
    with open(file, "ab") as cut:
        cut.write(b"what was being written when the power went")
    told = []
    image = scene.render(100, 70, samples=1, resume=file, executor=workers, progress=lambda *step: told.append(step))
    assert np.array_equal(image.pixels, local.pixels)
    assert told[0][0] == 5  # tiles 0 to 3 were kept, and one is new
    again = []
    image = scene.render(100, 70, samples=1, resume=file, progress=lambda *step: again.append(step))
    assert np.array_equal(image.pixels, local.pixels)
    assert again == []  # all of them were there
    with pytest.raises(ValueError, match="holds parts of other work"):
        scene.render(100, 70, samples=2, resume=file)


def test_other_files_are_not_touched(tmp_path):
    file = tmp_path / "letter.txt"
    file.write_text("Dear reader, this is no checkpoint.")
    with pytest.raises(ValueError, match="holds parts of something else"):
        subject.scene().render(40, 40, resume=file)
    assert file.read_text() == "Dear reader, this is no checkpoint."


def test_damaged_parts_are_done_again(tmp_path):
    file = tmp_path / "parts"
    kept = Checkpoint(file, b"key")
    for k in range(3):
        kept.add(k, k + 1, bytes([k]) * 10)
    kept.close()
    data = bytearray(file.read_bytes())
    data[-15] ^= 1  # in the last part
    file.write_bytes(data)
    again = Checkpoint(file, b"key")
    assert list(again.records()) == [(0, 1, b"\0" * 10), (1, 2, b"\1" * 10)]
    again.add(2, 3, b"new")
    again.close()
    last = Checkpoint(file, b"key")
    assert list(last.records())[2] == (2, 3, b"new")
    last.close()


@pytest.mark.skipif(sys.platform != "linux", reason="/dev/full is Linux's")
def test_a_full_disk_is_named():
    kept = object.__new__(Checkpoint)
    kept.path, kept.file = "/dev/full", open("/dev/full", "wb")  # noqa: SIM115
    with pytest.raises(OSError, match="No space left") as caught:
        kept.add(0, 1, b"data")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, "/dev/full")
    with pytest.raises(OSError, match="No space left"):
        kept.close()


DRIVER = """
import sys
import conicoid as co
from tests.cluster import subject
with co.parallel.Processes(2) as pool:
    image = subject.scene().render(640, 480, samples=4, resume=sys.argv[1],
                                   executor=co.parallel.Workers(pool, chunk=2))
image.save(sys.argv[2])
"""


@pytest.mark.deep
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_a_driver_killed_twenty_times(tmp_path):
    pytest.importorskip("OpenEXR")
    tiles, picture = tmp_path / "tiles", tmp_path / "picture.exr"
    rng, killed, sizes = np.random.default_rng(20), 0, [0]
    while killed < 20:
        driver = subprocess.Popen([sys.executable, "-c", DRIVER, tiles, picture])
        wanted = sizes[-1] + int(rng.integers(1, 100_000))
        while driver.poll() is None and not (tiles.exists() and tiles.stat().st_size > wanted):
            time.sleep(0.005)
        if driver.poll() is not None:
            assert driver.returncode == 0
            tiles.unlink()  # it was done: from the start again
            sizes.append(0)
            continue
        driver.send_signal(signal.SIGKILL)
        driver.wait()
        killed += 1
        sizes.append(tiles.stat().st_size)
    subprocess.run([sys.executable, "-c", DRIVER, tiles, picture], check=True)
    subject.scene().render(640, 480, samples=4).save(tmp_path / "local.exr")
    assert picture.read_bytes() == (tmp_path / "local.exr").read_bytes()
