"""Results on a disk that is full: one line that names the file, nothing half-written, the old file as it was."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io import image_codecs as exr

from ..samples import sampled

OpenEXR = pytest.importorskip("OpenEXR")

ROOT = Path(__file__).resolve().parents[2]
WRITERS = {
    "picture.png": "co.Image(np.random.default_rng(0).random((200, 200, 3))).save(path)",
    "picture.exr": "co.Image(np.random.default_rng(0).random((200, 200, 3))).save(path)",
    "numbers.exr": "co.Image(np.random.default_rng(0).random((200, 200))).save(path)",
    "scene.yaml": "co.save(co.Scene([co.Sphere(k + 1.5) for k in range(3000)]), path)",
    "balls.yaml": "co.save(co.Scene([co.Spheres(np.ones((3000, 3)), 1.0)]), path)",
    "spans.npz": "write_arrays(path, SPANS)",
    "spans.csv": "write_columns(path, SPANS)",
    "parts.csv": "co.Scene([co.Sphere(1)]).stream(np.ones((5000, 6)), out=path)",
    "parts.npz": "co.Scene([co.Sphere(1)]).stream(np.ones((5000, 6)), out=path)",
}
CODE = """
import resource, signal, sys
import numpy as np
import conicoid as co
from conicoid.io.array_file import write_arrays, write_columns
from conicoid.cli.terminal import user_mistakes

SPANS = dict(body=np.zeros(5000, int))
SPANS |= {name: np.ones(5000) for name in ("t_enter", "t_exit", "enter_clipped", "exit_clipped")}
import OpenEXR
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
path = sys.argv[1]
with user_mistakes():
    %s
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="a disk is made small by a limit of the process")
@pytest.mark.parametrize("name", sampled(WRITERS, 2))
def test_one_line_and_nothing_else(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(b"old")
    command = [sys.executable, "-c", CODE % WRITERS[name], str(path), "5000"]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
    assert ran.returncode != 0
    (line,) = ran.stderr.splitlines()
    assert line.startswith(f"error: {tmp_path}"), line
    assert line.endswith(": file too large"), line
    assert path.read_bytes() == b"old"
    assert [file for file in tmp_path.iterdir() if file != path] == []


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('Failed to write pixel data to image file "x". No space left on device.', "No space left on device"),
        ("something of its own\nand more", "cannot be written: something of its own"),
    ],
)
def test_whatever_the_library_says_is_an_os_error(text, reason, tmp_path, monkeypatch):
    def fail(self: object, path: str) -> None:
        raise RuntimeError(text)

    monkeypatch.setattr(OpenEXR.File, "write", fail)
    with pytest.raises(OSError, match=reason) as caught:
        exr.write_exr(tmp_path / "x.exr", np.zeros((2, 2)))
    assert caught.value.filename == str(tmp_path / "x.exr")
    assert not list(tmp_path.iterdir())


def test_where_there_is_room_it_is_written(tmp_path):
    co.Image(np.zeros((2, 2))).save(tmp_path / "x.exr")
    assert (tmp_path / "x.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"  # the format's magic number
