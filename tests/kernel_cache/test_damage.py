"""Files of compiled kernels that are not what was written: each is noticed, dropped and made anew, without a word."""

from __future__ import annotations

import itertools
import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from ..command_line import written
from .tiny import COMPILED, LOADED, apart, kept, posix_only, used

Damage = Callable[[bytes, random.Random], bytes]


def flipped(data: bytes, rng: random.Random) -> bytes:
    k = rng.randrange(len(data))
    return data[:k] + bytes([data[k] ^ 1 << rng.randrange(8)]) + data[k + 1 :]


def garbled(data: bytes, rng: random.Random) -> bytes:
    begin = rng.randrange(len(data))
    end = min(len(data), begin + rng.randrange(1, 2000))
    noise = rng.randbytes(end - begin)
    return data[:begin] + noise + data[end:] if noise != data[begin:end] else b""


DAMAGES: dict[str, Damage] = {
    "a bit": flipped,
    "some bytes": garbled,
    "truncated": lambda data, rng: data[: rng.randrange(len(data))],
    "emptied": lambda data, rng: b"",
    "longer": lambda data, rng: data + rng.randbytes(rng.randrange(1, 100)),
    "noise": lambda data, rng: rng.randbytes(rng.randrange(1, 5000)),
    "zeros": lambda data, rng: bytes(len(data)),
    "zeros at the end": lambda data, rng: data[: len(data) // 2] + bytes(len(data) - len(data) // 2),
    "twice": lambda data, rng: data + data,
    "a pickle": lambda data, rng: pickle.dumps("0.0"),
    "without the checksum": lambda data, rng: data[50:],
    "another's": lambda data, rng: data.replace(b"doubled", b"tripled"),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with a kernel in it, which is found there."""
    folder = tmp_path_factory.mktemp("kernels")
    for expected in (COMPILED, LOADED):
        outcome = apart(folder)
        assert outcome.quiet, outcome
        assert outcome.value == expected
    return folder


def check(folder: Path, damage: Damage, rng: random.Random) -> None:
    path = kept(folder)
    data = path.read_bytes()
    path.write_bytes(damage(data, rng))
    assert path.read_bytes() != data
    for expected in (COMPILED, LOADED):
        outcome = apart(folder)
        assert outcome.quiet, outcome
        assert outcome.value == expected


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_kernel_is_compiled_again(whole, name):
    check(whole, DAMAGES[name], random.Random(name))


@pytest.mark.deep
def test_200_damaged_kernels(whole):
    rng = random.Random(20261122)
    for _ in range(200):
        check(whole, rng.choice(list(DAMAGES.values())), rng)


def test_a_file_under_another_name_is_not_taken_for_that_one(whole):
    path = kept(whole)
    data = path.read_bytes()
    other = path.with_name(f"{path.name[:-10]}{'0' * 6}.nbc")
    path.rename(other)
    assert apart(whole).value == COMPILED
    path.write_bytes(data)
    assert apart(whole).value == LOADED
    path.write_bytes(path.read_bytes())
    other.replace(path)
    assert apart(whole).value == LOADED  # the same bytes under the name they were written for


@posix_only
@pytest.mark.parametrize("kind", ["pipe", "link", "dangling", "folder"])
def test_what_is_no_file_is_not_read(tmp_path, kind):
    folder = tmp_path / "kernels"
    apart(folder)
    path = kept(folder)
    data = path.read_bytes()
    path.unlink()
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        if kind == "link":
            (tmp_path / "elsewhere").write_bytes(data)
        path.symlink_to(tmp_path / "elsewhere")
    outcome = apart(folder)
    assert outcome.value == COMPILED
    if kind == "folder":  # it cannot be replaced
        assert outcome.one_line
    else:
        assert outcome.quiet
        assert apart(folder).value == LOADED


def limited(size: int, action: signal.Handlers) -> object:
    """With files of so many bytes at most; one more is an error, or the end of the process."""
    import resource

    signal.signal(signal.SIGXFSZ, action)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return used()


def left(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in (".nbc", ".tmp")]


@posix_only
@pytest.mark.parametrize("size", [0, 60, 3000])
def test_no_space_left_in_the_middle_of_writing(tmp_path, size):
    folder = tmp_path / "kernels"
    outcome = apart(folder, limited, size, signal.SIG_IGN)
    assert outcome.value == COMPILED
    assert outcome.one_line
    assert not left(folder)
    assert apart(folder).value == COMPILED
    assert apart(folder).value == LOADED


@posix_only
@pytest.mark.parametrize("size", [60, 3000])
def test_killed_in_the_middle_of_writing(tmp_path, size):
    folder = tmp_path / "kernels"
    apart(folder, limited, size, signal.SIG_DFL)
    outcome = apart(folder, limited, size, signal.SIG_DFL)
    assert outcome.code == -signal.SIGXFSZ
    assert not list(folder.rglob("*.nbc"))
    assert apart(folder).value == COMPILED
    assert apart(folder).value == LOADED


@posix_only
@pytest.mark.deep
def test_killed_or_out_of_space_anywhere(tmp_path):
    folder = tmp_path / "kernels"
    ends = set()
    for size in [*range(0, 200, 10), *range(200, 12_000, 400)]:
        for action in (signal.SIG_DFL, signal.SIG_IGN):
            outcome = apart(folder, limited, size, action)
            assert outcome.code == -signal.SIGXFSZ or outcome.quiet or outcome.one_line, outcome
            assert outcome.value in (None, COMPILED, LOADED)
            ends.add((outcome.code, outcome.value == LOADED))
    assert ends == {(-signal.SIGXFSZ, False), (0, False), (0, True)}


@pytest.fixture
def small_disk(tmp_path):
    """A disk of four pages."""
    disk = tmp_path / "disk"
    disk.mkdir(mode=0o700)
    command = ["mount", "-t", "tmpfs", "-o", "size=16k,mode=700", "tmpfs", str(disk)]
    if shutil.which("mount") is None or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("needs the right to mount a small disk")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.deep
@pytest.mark.parametrize("taken", [0, 1, 2, 3, 4])
def test_a_full_disk(small_disk, taken):
    """Of four pages the mark takes one, and the kernel two."""
    (small_disk / "taken").write_bytes(bytes(4096 * taken))
    outcome = apart(small_disk / "kernels")
    assert outcome.value == COMPILED
    assert outcome.one_line if taken > 1 else outcome.quiet, outcome
    (small_disk / "taken").unlink()
    expected = COMPILED if taken > 1 else LOADED
    assert apart(small_disk / "kernels").value == expected
    assert apart(small_disk / "kernels").value == LOADED


def unloadable() -> object:
    """A file that is whole and ours, but of no use: as if the compiler had changed under the same version."""
    from conicoid._jit import disk_cache as files

    path = kept(Path(os.environ["CONICOID_CACHE_DIR"]))
    assert files.write_kernel(path.name, pickle.dumps(("no", "kernel")))
    return used()


def test_a_whole_file_that_cannot_be_loaded_is_compiled_again(tmp_path):
    apart(tmp_path / "kernels")
    outcome = apart(tmp_path / "kernels", unloadable)
    assert outcome.quiet, outcome
    assert outcome.value == COMPILED
    assert apart(tmp_path / "kernels").value == LOADED


@pytest.mark.deep
def test_a_picture_with_all_kernels_damaged(tmp_path):
    """The whole engine: said to be compiled, compiled, and then there; the same picture each time."""
    folder, rng = tmp_path / "kernels", random.Random(20261123)
    render = [sys.executable, "-m", "conicoid", "render", str(written(tmp_path)), "--width", "8", "--height", "8", "-o"]
    pictures, said = [], []
    for turn in range(3):
        if turn == 1:
            files = sorted(folder.rglob("*.nbc"))
            for path, damage in zip(files, itertools.cycle(DAMAGES.values()), strict=False):
                path.write_bytes(damage(path.read_bytes(), rng))
        picture = tmp_path / f"{turn}.png"
        environment = os.environ | {"CONICOID_CACHE_DIR": str(folder)}
        run = subprocess.run([*render, str(picture)], env=environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        said.append([line for line in run.stderr.splitlines() if not line.startswith(str(picture))])
        pictures.append(picture.read_bytes())
    assert len(files) > 5
    assert pictures[0] == pictures[1] == pictures[2]
    assert [len(lines) for lines in said] == [1, 1, 0], said
    assert all("compiling kernels" in line for lines in said for line in lines)
