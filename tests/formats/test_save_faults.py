"""Faults while a scene is saved, and full disks: every earlier scene still loads as it was."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid._util.files import replace_file, write_text
from conicoid.io import image_codecs as exr
from conicoid.parallel.result_writer import ResultParts

# --- Whatever happens while a scene is saved, every earlier scene still loads as it was


CALLS = {"open", "write", "writelines", "fsync", "replace", "rename", "close", "flush", "truncate"}
"""All functions that reach a disk."""


def balls(seed: int, count: int = 150) -> co.Scene:
    random = np.random.default_rng(seed)
    return co.Scene([co.Spheres(random.normal(size=(count, 3)), random.uniform(0.1, 1, count)), co.Sphere(seed + 1)])


OLD, BESIDE, NEW = balls(0), balls(1), balls(2)


def folder_of_scenes(folder: Path) -> Path:
    """Prepare a folder with two scenes of one stem, both with files of balls, for a third one."""
    folder.mkdir()
    co.save(OLD, folder / "st.yaml")
    co.save(BESIDE, folder / "st.json")
    return folder / "st.yaml"


def check(folder: Path, *, saved: bool | None) -> None:
    """Check that nothing is lost, and that the saved scene is complete or absent."""
    assert co.load(folder / "st.json") == BESIDE
    assert co.load(folder / "st.yaml") in ([NEW] if saved else [OLD] if saved is False else [OLD, NEW])


def test_saving_again_leaves_the_balls_of_copies(tmp_path):
    path = folder_of_scenes(tmp_path / "a")
    (path.parent / "copy.yaml").write_bytes(path.read_bytes())
    co.save(NEW, path)
    check(path.parent, saved=True)
    assert co.load(path.parent / "copy.yaml") == OLD
    before = {file: file.stat().st_mtime_ns for file in path.parent.glob("*.npy")}
    co.save(NEW, path)
    assert {file: file.stat().st_mtime_ns for file in path.parent.glob("*.npy")} == before, "nothing to write again"


def test_a_file_of_balls_is_named_by_its_content(tmp_path):
    path = folder_of_scenes(tmp_path / "a")
    for file in path.parent.glob("*.npy"):
        assert file.name == f"st-spheres-{hashlib.sha256(file.read_bytes()).hexdigest()[:32]}.npy"
        found = np.load(file, allow_pickle=False)
        assert found.shape == (150, 4)
        assert found.dtype == np.dtype("<f8")


def test_a_file_edited_by_others_is_not_overwritten(tmp_path):
    path = folder_of_scenes(tmp_path / "a")
    co.save(NEW, tmp_path / "a" / "st.yaml")
    names = {hashlib.sha256(file.read_bytes()).hexdigest(): file for file in path.parent.glob("*.npy")}
    (file,) = (file for file in names.values() if file.name in path.read_text())
    file.write_bytes(b"mine")
    co.save(NEW, path)
    assert co.load(path) == NEW
    assert file.read_bytes() == b"mine"


def test_the_same_balls_are_kept_once(tmp_path):
    spheres = OLD.bodies[0].shape
    co.save(co.Scene([spheres, spheres.translate((1, 0, 0))]), tmp_path / "twice.yaml")
    assert len(list(tmp_path.glob("*.npy"))) == 1
    assert co.load(tmp_path / "twice.yaml") == co.Scene([spheres, spheres.translate((1, 0, 0))])


@pytest.mark.parametrize(
    "stem", ["a\\b", "C:x", "x" * 240, "ü" * 110, "a b", "..", ".hidden", "a:b*c?", "-", os.fsdecode(b"\xff\xfe")]
)
def test_any_name_that_a_disk_takes(stem, tmp_path):
    co.save(OLD, tmp_path / f"{stem}.yaml")
    assert co.load(tmp_path / f"{stem}.yaml") == OLD


def test_a_name_that_no_disk_takes(tmp_path):
    """UTF-8 cannot encode half a surrogate pair."""
    scene, path = co.Scene([co.Sphere()]), str(tmp_path / "\ud800")
    hits = scene.first_hit((0, 0, 5), (0, 0, -1))
    for use in (
        lambda: co.load(f"{path}.yaml"), lambda: co.load(f"{path}.gdml"), lambda: co.Hits.load(f"{path}.npz"),
        lambda: co.save(scene, f"{path}.yaml"), lambda: co.save(scene, f"{path}/a.yaml"), lambda: hits.save(f"{path}.npz"),
        lambda: scene.render(2, 2).save(f"{path}.png"), lambda: scene.slice("z", pixels=4).save(f"{path}.svg"),
    ):  # fmt: skip
        with pytest.raises((OSError, ValueError), match="is no name that a file can have"):
            use()


def test_through_a_link(tmp_path):
    path = folder_of_scenes(tmp_path / "a")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "link.yaml").symlink_to(path)
    assert co.load(tmp_path / "b" / "link.yaml") == OLD
    co.save(NEW, tmp_path / "b" / "link.yaml")
    check(path.parent, saved=True)
    assert co.load(tmp_path / "b" / "link.yaml") == NEW
    (tmp_path / "round.yaml").symlink_to(tmp_path / "round.yaml")
    with pytest.raises(OSError, match="round"):
        co.save(NEW, tmp_path / "round.yaml")


class At:
    """Do something at the n-th call that touches a disk, by watching calls to built-in functions."""

    def __init__(self, number: int, act: Callable[[], None]) -> None:
        self.left, self.act, self.reached = number, act, False

    def __enter__(self) -> At:
        sys.setprofile(self.event)
        return self

    def __exit__(self, *_: object) -> None:
        sys.setprofile(None)

    def event(self, frame, kind: str, function) -> None:
        if kind == "c_call" and getattr(function, "__name__", "") in CALLS:
            self.left -= 1
            if self.left < 0 and not self.reached:
                self.reached = True
                self.act()


def full() -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def calls_to_break() -> Iterator[int]:
    """Return 0, 1, 2, ... for as long as there is such a call."""
    yield from range(200)
    raise AssertionError("saving a scene takes no such number of calls")


def test_a_full_disk_at_every_step(tmp_path):
    steps = 0
    for number in calls_to_break():
        path = folder_of_scenes(tmp_path / f"{number}")
        try:
            with At(number, full) as at:
                co.save(NEW, path)
        except OSError as error:
            assert error.errno == errno.ENOSPC
            assert error.filename is not None
            assert not [file for file in path.parent.iterdir() if file.name.startswith(".")], (
                "a half-written file is left"
            )
        check(path.parent, saved=None)
        steps += at.reached
        if not at.reached:
            check(path.parent, saved=True)
            break
    assert steps >= 8, "two files, each opened, written, brought to the disk and renamed"


def in_child(act: Callable[[], None]) -> int:
    """Return the status of a process that does it."""
    child = os.fork()
    if child == 0:
        try:
            act()
        except OSError:
            os._exit(3)
        except BaseException:
            os._exit(4)
        os._exit(0)
    return os.waitpid(child, 0)[1]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are ended by a signal")
def test_killed_at_every_step(tmp_path):
    steps = 0
    for number in calls_to_break():
        path = folder_of_scenes(tmp_path / f"{number}")

        def act(number: int = number, path: Path = path) -> None:
            with At(number, lambda: os.kill(os.getpid(), signal.SIGKILL)):
                co.save(NEW, path)

        status = in_child(act)
        check(path.parent, saved=None if status else True)
        if status == 0:
            break
        assert status == signal.SIGKILL
        co.save(NEW, path)
        assert not list(path.parent.glob(".*")), "the next save removes what a killed one left"
        steps += 1
    assert steps >= 8


@pytest.mark.skipif(os.name != "posix", reason="there are no locks")
def test_saves_at_a_time_leave_each_other_their_files(tmp_path):
    """A name of a partial file is free again only after a kill, and a name that a stranger planted never is."""
    path, others = tmp_path / "a.txt", []
    with contextlib.ExitStack() as stack:
        for number in range(6):
            others.append(stack.enter_context(replace_file(path)))
            others[-1].write_text(f"{number}")
        assert len(set(others)) == 6
        assert [other.read_text() for other in others] == list("012345")
    assert path.read_text() == "0", "the first one ends last"
    assert list(tmp_path.iterdir()) == [path]
    (tmp_path / "mine").write_text("mine")
    others[0].symlink_to(tmp_path / "mine")
    write_text(path, "new")
    assert ((tmp_path / "mine").read_text(), path.read_text()) == ("mine", "new")
    assert others[0].is_symlink()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits are those of a process")
def test_no_room_for_files_of_any_length(tmp_path):
    """The operating system itself refuses to write on, within the balls, and at the last byte of the scene."""
    path = folder_of_scenes(tmp_path / "a")
    sizes = sorted({file.stat().st_size for file in path.parent.iterdir()})
    for number, limit in enumerate([0, 1, 100, 130, sizes[0] - 1, sizes[0], sizes[-1] - 1, sizes[-1]]):
        path = folder_of_scenes(tmp_path / f"{number}")

        def act(limit: int = limit, path: Path = path) -> None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            co.save(NEW, path)

        status = in_child(act)
        assert os.waitstatus_to_exitcode(status) == (0 if limit == sizes[-1] else 3)
        check(path.parent, saved=limit == sizes[-1])
        assert not [file for file in path.parent.iterdir() if file.name.startswith(".")]


def trace(folder: Path, suffix: str, *options: str) -> None:
    from conicoid.cli.app import app

    files = [f"{folder}/scene.yaml", f"{folder}/rays.npy", f"--output={folder}/hits{suffix}"]
    app(["trace", *files, "--chunk=16", *options], standalone_mode=False)


def remove(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def contents(path: Path):
    if path.suffix == ".zarr":
        return {f"{file.relative_to(path)}": file.read_bytes() for file in path.rglob("*") if file.is_file()}
    return dict(np.load(path)) if path.suffix == ".npz" else path.read_bytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are ended by a signal")
@pytest.mark.parametrize("suffix", [".npz", ".csv", ".parquet", ".zarr"])
def test_results_are_resumed_after_a_kill_at_any_step(suffix, tmp_path):
    """The kill comes in the first part, between parts, or between the last names.

    `trace --resume` ends with the same bytes.
    """
    for module in {".parquet": ["pyarrow.parquet"], ".zarr": ["zarr"]}.get(suffix, []):
        pytest.importorskip(module)
    co.save(BESIDE, tmp_path / "scene.yaml")
    np.save(tmp_path / "rays.npy", np.random.default_rng(3).normal(size=(40, 6)))
    output, count = tmp_path / f"hits{suffix}", 1 << 30
    trace(tmp_path, suffix)
    remove(output)
    with At(count, full) as at:
        trace(tmp_path, suffix)
    count -= at.left
    whole, killed, files = contents(output), 0, sorted(tmp_path.iterdir())
    for number in sorted({*range(0, count, count // (2 if suffix == ".zarr" else 8)), *range(count - 8, count)}):
        remove(output)

        def act(number: int = number) -> None:
            with At(number, lambda: os.kill(os.getpid(), signal.SIGKILL)):
                trace(tmp_path, suffix)

        if status := in_child(act):
            assert status == signal.SIGKILL
            if output.exists() and not (tmp_path / f"{output.name}.parts").exists():  # the output is complete
                remove(output)
            trace(tmp_path, suffix, "--resume")
            killed += 1
        np.testing.assert_equal(contents(output), whole, err_msg=f"killed at step {number}")
        assert sorted(tmp_path.iterdir()) == files, f"killed at step {number}"
    assert killed >= 8


def test_parts_without_a_column_are_refused(tmp_path):
    parts = ResultParts(tmp_path / "hits.csv", "key", False)
    parts.add({"lines": b"abc"}, 1, 1)
    assert ResultParts(tmp_path / "hits.csv", "key", True).rays == 1
    parts.file("lines").write_bytes(b"")
    with pytest.raises(ValueError, match="is damaged; remove it"):
        ResultParts(tmp_path / "hits.csv", "key", True)


# --- Results on a full disk: one line that names the file, no partial file, and the old file as it was


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
def test_errors_are_one_line(tmp_path):
    paths = [tmp_path / str(number) / name for number, name in enumerate(WRITERS)]
    for path in paths:
        path.parent.mkdir()
        path.write_bytes(b"old")
    # Without bytecode (-B): CPython would write a truncated file for a module, and keep it
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
def test_errors_of_libraries_become_os_errors(text, reason, tmp_path, monkeypatch):
    def fail(self: object, path: str) -> None:
        raise RuntimeError(text)

    monkeypatch.setattr(OpenEXR.File, "write", fail)
    with pytest.raises(OSError, match=reason) as caught:
        exr.write_exr(tmp_path / "x.exr", np.zeros((2, 2)))
    assert caught.value.filename == str(tmp_path / "x.exr")
    assert not list(tmp_path.iterdir())


def test_files_are_written_where_room_is_left(tmp_path):
    co.Image(np.zeros((2, 2))).save(tmp_path / "x.exr")
    assert (tmp_path / "x.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"  # the format's magic number
