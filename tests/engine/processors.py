"""Machine code for the levels of wheels, whatever this processor is: a kernel before and after LLVM's optimisation.

Each runs in a process of its own, because LLVM ends the process where it has no code for an operation.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from native.targets import TARGETS

LEVELS = {
    level.processor: (target.name, level.name)
    for target in map(TARGETS.__getitem__, ("linux-x86_64", "linux-aarch64", "macos-arm64"))
    for level in target.levels
}
"""The target and level of each processor; the names are LLVM's."""

FRONT = """
import contextlib, sys
from pathlib import Path
import conicoid as co
from conicoid._jit import compiler as jit_functions
from conicoid.kernels.first_hits import trace_first

class Enough(Exception):
    pass

def keep(program):
    whole = program._final_module
    for library in jit_functions._reachable_libraries(program._linking_libraries):
        part = jit_functions._own_module(library)
        defined = [function.name for function in part.functions if not function.is_declaration]
        if "NRT_decref" not in defined:  # Numba's counts of references have been made for this processor
            whole.link_in(part, preserve=True)
    Path(sys.argv[1]).write_bytes(whole.as_bitcode())
    raise Enough

def compile_to_keep(signature, compile=trace_first._compile):
    jit_functions._KernelLibrary.finalize = keep
    return compile(signature)

trace_first._compile = compile_to_keep
with contextlib.suppress(Enough):
    co.Scene([co.Sphere()]).first_hit(co.Camera((0, 0, 5), (0, 0, 0), up=(0, 1, 0)).rays(16, 16))
"""

BACK = """
import sys
from pathlib import Path
import llvmlite.binding as llvm
from native import objects
from native.targets import TARGETS

source, target, level, optimized = sys.argv[1:]
target = TARGETS[target]
machine = objects.machine_for(target.triple, target.only(level).levels[0])
module = llvm.parse_bitcode(Path(source).read_bytes())
module.triple, module.data_layout = target.triple, str(machine.target_data)
if optimized == "optimized":
    objects.simplify(module, machine)
    objects.optimize(module, machine)
print(machine.emit_assembly(module))
"""


def _run(program: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", program, *map(str, arguments)]
    environment = os.environ | {
        "CONICOID_THREADS": "1",
        "CONICOID_JIT": "own",
    }  # or another process compiles it
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=3000)


def before_optimization(program: str, path: Path) -> Path:
    """Return the output file of a program: LLVM's code of a kernel, with all that it calls."""
    run = _run(program, path)
    assert run.returncode == 0, run.stderr[-2000:]
    return path


def assembly(code: Path, processor: str, optimized: bool = True) -> str:
    """Return the instructions of LLVM's code on a processor, as in a wheel."""
    run = _run(BACK, code, *LEVELS[processor], "optimized" if optimized else "as it is")
    if "Unable to find target" in run.stderr or "No available targets" in run.stderr:
        pytest.skip(f"this LLVM makes no code for {processor}")
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout


def functions(text: str) -> dict[str, list[str]]:
    """Return the instructions of each function, by name."""
    found: dict[str, list[str]] = {}
    name = ""
    for line in text.splitlines():
        label = re.match(r"^\"?(_?_ZN[^\":]+)\"?:", line)
        if label:
            name = label[1]
            found[name] = []
        elif line.startswith("\t") and not line.startswith("\t.") and name:
            found[name].append(line.split("#")[0].strip())
    return found
