"""A process with limited memory ends with a line, not with a signal or in the middle of other code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..children import child
from ..command_line import scene_file
from ..machine_code import needs_compiler, needs_machine_code
from ..samples import deep, drawn

pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux")

COMPILING = """
import resource, sys
from pathlib import Path
from conicoid._jit.compiler import compile_function
doubled = compile_function(lambda x: 2.0 * x, entry=True)
now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (now + (int(sys.argv[1]) << 20),) * 2)
try:
    print(doubled(21.0))
except MemoryError as error:
    print(error)
"""


@needs_compiler
@pytest.mark.parametrize("room", [4, 200, 1000])
def test_little_room_to_compile_is_an_error_of_one_line(room):
    with child(COMPILING, room) as running:
        code, out, errors = running.end(60)
    assert (code, errors) == (0, "")
    assert out.count("\n") == 1
    if room == 1000:
        assert out == "42.0\n"
    else:
        assert out.startswith("to compile the kernel <lambda> takes up to 512 MiB of memory")


def run_render(folder: Path, mebibytes: int, jit: str) -> subprocess.CompletedProcess[str]:
    """Run the command with a limit of address space for all of it."""
    render = f"{sys.executable} -m conicoid render {scene_file(folder)} -o {folder / 'p.png'} --width 8 --height 8"
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "CONICOID_THREADS": "1", "CONICOID_JIT": jit}
    command = ["sh", "-c", f"ulimit -v {mebibytes << 10}; exec {render}"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize(
    "jit", [pytest.param("own", marks=[needs_compiler, pytest.mark.deep]), pytest.param("", marks=needs_machine_code)]
)
@pytest.mark.parametrize(
    "mebibytes",
    [150, 330, 430, *map(deep, drawn(range(140, 801, 20), 6))],
)
def test_a_command_reports_little_memory(tmp_path, mebibytes, jit):
    run = run_render(tmp_path, mebibytes, jit)
    if run.returncode != 0:
        assert run.returncode == 1, run.stderr
        assert run.stderr.startswith("error: not enough memory")
        assert run.stderr.count("\n") == 1
    least = 440 if jit else 200  # it worked there without allocations beforehand
    assert run.returncode == 1 or mebibytes >= least
