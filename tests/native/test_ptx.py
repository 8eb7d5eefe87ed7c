"""The code for GPUs: the contents of its PTX."""

import re
import shutil
import subprocess

import pytest

from conicoid.kernels.device import EACH, SHARED, ScratchSize, size_name
from conicoid.kernels.tables import BALL, CELL
from native import ptx

from ..emulation import ptx_of
from ..samples import marked

MOST_USED = ["any_hits_few", "list_rows_few"]
"""Kernels of most scenes. A fast test takes the first, because each takes seconds of a compiler."""
SMALL = [name for name in ptx.PARTS["queries"] if name.endswith(f"_{EACH}")]


@pytest.mark.parametrize("name", marked((name, name in (MOST_USED[0], *SMALL[::5])) for name in ptx.PARTS["queries"]))
def test_ptx_rounds_as_the_cpu_does(name):
    """The code has some of the instructions that `ptx.ptx` checks."""
    text = ptx_of(name)
    assert f".entry {name}(" in text
    assert ".target sm_75" in text
    assert f".maxnreg {ptx.REGISTERS.get(name.rpartition('_')[2], ptx.MOST_REGISTERS)}" in text
    assert len(re.findall(r"\bmul\.rn\.f64\b", text)) > 50 or name.endswith(f"_{EACH}")
    assert "_ZN" not in text


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("mul.f64 %rd1, %rd2, %rd3;", "rounds by mul.f64"),
        ("add.rm.f32 %r1, %r2, %r3;", "rounds by add.rm.f32"),
        ("cvt.ftz.f64.f32 %rd1, %r2;", "has .ftz"),
        ("@%p1 ex2.approx.f32 %r1, %r2;", "rounds by ex2.approx.f32; has .approx"),
        ("fma.rn.f64 %rd1, %rd2, %rd3, %rd4;", "fuses what the code does not"),
        ("call.uni (retval0), malloc, (param0);", "calls malloc"),
        ('.b8 name[3] = "/home";', "names a place"),
    ],
)
def test_ptx_that_rounds_otherwise_is_refused(line, wrong):
    assert "; ".join(ptx.wrong_with_ptx(f"\t{line}\n", 0)) == wrong


@pytest.mark.skipif(shutil.which("ptxas") is None, reason="NVIDIA's assembler is not here")
@pytest.mark.parametrize("name", marked((name, name == MOST_USED[0]) for name in MOST_USED))
def test_registers_and_spills_are_within_bounds(tmp_path, name):
    """The loop over nodes spills few registers, and no array needs much local memory."""
    source = tmp_path / "kernel.ptx"
    source.write_text(ptx_of(name))
    command = ["ptxas", "-v", "-arch=sm_75", "-o", str(tmp_path / "kernel.cubin"), str(source)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    entry = printed[printed.index(f"for {name}") :]
    frame, stores, loads = map(
        int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+)", entry).groups()
    )
    assert int(re.search(r"Used (\d+) registers", printed)[1]) <= ptx.MOST_REGISTERS
    assert frame < 8192
    assert max(stores, loads) < 512


def test_a_scene_has_the_smallest_sufficient_size():
    for needed, name in (
        (ScratchSize(1, 1, 40, BALL), "balls"), (ScratchSize(1, 1, 40, CELL), "cells"), (ScratchSize(1, 1, 40), "few"),
        (ScratchSize(8, 3, 40), "few"), (ScratchSize(3, 9, 40), "many"), (ScratchSize(65, 9, 40), SHARED),
        (ScratchSize(1, 1, 97, BALL), SHARED),
    ):  # fmt: skip
        assert size_name("first_hits", needed) == name
    assert size_name("first_bodies", ScratchSize(1, 1, 40, BALL)) == "few"
