"""A process whose memory is limited ends with a line, not with a signal or in the middle of somebody else's code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..command_line import written
from ..machine_code import needs_machine_code
from .tiny import COMPILED, LOADED, apart, used

pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux")


def with_room_for(mebibytes: int) -> object:
    """The kernel, or the error, with so much address space left."""
    import resource

    now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + (mebibytes << 20),) * 2)
    try:
        return used()
    except MemoryError as error:
        return str(error)


@pytest.mark.parametrize("complete", [False, True], ids=["to compile", "to load"])
@pytest.mark.parametrize("room", [4, 64, 200])
def test_little_room_is_an_error_of_one_line(tmp_path, room, complete):
    if complete:
        apart(tmp_path / "kernels")
    outcome = apart(tmp_path / "kernels", with_room_for, room)
    assert outcome.quiet, outcome
    assert ("to load the kernel doubled" if complete else "to compile the kernel doubled") in outcome.value
    assert "\n" not in outcome.value


def test_enough_room(tmp_path):
    assert apart(tmp_path / "kernels", with_room_for, 1000).value == COMPILED
    # What the thread that loads it reserves for itself, comes on top of the 256 MiB
    assert apart(tmp_path / "kernels", with_room_for, 500).value == LOADED


def rendered(folder: Path, mebibytes: int, jit: str) -> subprocess.CompletedProcess[str]:
    """The command, with so much address space for the whole of it."""
    render = f"{sys.executable} -m conicoid render {written(folder)} -o {folder / 'p.png'} --width 8 --height 8"
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "CONICOID_THREADS": "1", "CONICOID_JIT": jit}
    command = ["sh", "-c", f"ulimit -v {mebibytes << 10}; exec {render}"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize("jit", ["own", pytest.param("", marks=needs_machine_code)])
@pytest.mark.parametrize(
    "mebibytes",
    [150, 330, 430, *(pytest.param(m, marks=pytest.mark.deep) for m in range(140, 801, 20))],
)
def test_a_command_with_little_memory_says_so(tmp_path, mebibytes, jit):
    run = rendered(tmp_path, mebibytes, jit)
    if run.returncode != 0:
        assert run.returncode == 1, run.stderr
        assert run.stderr.startswith("error: not enough memory")
        assert run.stderr.count("\n") == 1
    least = 440 if jit else 200  # where it worked when nothing was asked for beforehand
    assert run.returncode == 1 or mebibytes >= least
