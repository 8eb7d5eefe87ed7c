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
from pathlib import Path
import numpy as np
import OpenEXR
import conicoid as co
from conicoid.io.array_file import write_arrays, write_columns
from conicoid.cli.terminal import user_mistakes

SPANS = dict(body=np.zeros(5000, int))
SPANS |= {name: np.ones(5000) for name in ("t_enter", "t_exit", "enter_clipped", "exit_clipped")}
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
for folder in sorted(Path(sys.argv[1]).iterdir()):
    (path,) = folder.iterdir()
    print("#", path.name, file=sys.stderr)
    try:
        with user_mistakes():
            exec(sys.argv[2 + int(folder.name)])
    except SystemExit as end:
        assert end.code
        continue
    print("written", file=sys.stderr)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="a disk is made small by a limit of the process")
def test_one_line_and_nothing_else(tmp_path):
    paths = [tmp_path / str(number) / name for number, name in enumerate(WRITERS)]
    for path in paths:
        path.parent.mkdir()
        path.write_bytes(b"old")
    # Without bytecode (-B): CPython would cut what it writes of a module short, and keep it
    command = [sys.executable, "-B", "-c", CODE, str(tmp_path), *WRITERS.values()]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=300)
    messages = dict(part.split("\n", 1) for part in ran.stderr.split("# ")[1:])
    for path in paths:
        (line,) = messages[path.name].splitlines()
        assert line.startswith(f"error: {path.parent}")
        assert line.endswith(": file too large")
        assert path.read_bytes() == b"old"
        assert list(path.parent.iterdir()) == [path]


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
