"""Machine code for named processors, whatever this one is: a kernel as Numba hands it to LLVM, and LLVM's own back ends.

Each works in a process of its own: where LLVM has no code for something it ends the process.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conicoid._jit import vector_width as vectors

LINUX, MAC = "unknown-linux-gnu", "apple-macosx"
TRIPLES = {
    "x86-64-v3": f"x86_64-{LINUX}",
    "haswell": f"x86_64-{LINUX}",
    "znver3": f"x86_64-{LINUX}",
    "x86-64-v4": f"x86_64-{LINUX}",
    "skylake-avx512": f"x86_64-{LINUX}",
    "cascadelake": f"x86_64-{LINUX}",
    "icelake-server": f"x86_64-{LINUX}",
    "rocketlake": f"x86_64-{LINUX}",
    "sapphirerapids": f"x86_64-{LINUX}",
    "graniterapids": f"x86_64-{LINUX}",
    "znver4": f"x86_64-{LINUX}",
    "znver5": f"x86_64-{LINUX}",
    "neoverse-n1": f"aarch64-{LINUX}",
    "neoverse-v2": f"aarch64-{LINUX}",
    "apple-m1": f"arm64-{MAC}",
}
"""Of each processor; the names are LLVM's."""

FRONT = """
import contextlib, sys
from pathlib import Path
from numba.core.caching import NullCache
import conicoid as co
from conicoid._jit import compiler as jit_functions
from conicoid.kernels.entry.first_hits import trace_first

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

class Nothing(NullCache):
    @contextlib.contextmanager
    def until_saved(self):
        jit_functions._KernelLibrary.finalize = keep
        yield

trace_first._cache = Nothing()
with contextlib.suppress(Enough):
    co.Scene([co.Sphere()]).first_hit(co.Camera((0, 0, 5), (0, 0, 0), up=(0, 1, 0)).rays(16, 16))
"""

BACK = """
import sys
from pathlib import Path
import llvmlite.binding as llvm

source, triple, processor, width, optimized = sys.argv[1:]
llvm.initialize_all_targets()
llvm.initialize_all_asmprinters()
machine = llvm.Target.from_triple(triple).create_target_machine(cpu=processor, opt=3)
module = llvm.parse_bitcode(Path(source).read_bytes())
words = '"prefer-vector-width"="{}"'.format
module = llvm.parse_assembly(str(module).replace(words(512), words(width)) if int(width) else str(module))
module.triple, module.data_layout = triple, str(machine.target_data)
for speed, vectors in ((0, False), (3, True)) if optimized == "optimized" else ():  # as Numba does it
    options = llvm.create_pipeline_tuning_options(speed_level=speed)
    options.loop_vectorization = options.slp_vectorization = vectors
    builder = llvm.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    if not vectors:
        passes.add_loop_rotate_pass()
        passes.add_instruction_combine_pass()
        passes.add_jump_threading_pass()
    passes.run(module, builder)
print(machine.emit_assembly(module))
"""


def _run(program: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", program, *map(str, arguments)]
    environment = os.environ | {
        "CONICOID_THREADS": "1",
        "CONICOID_VECTOR_BITS": "512",
        "CONICOID_JIT": "own",
    }  # or another process compiles it
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)


def before_optimization(program: str, path: Path) -> Path:
    """What a program writes to the file that it is told: LLVM's code of a kernel, with all that it calls."""
    run = _run(program, path)
    assert run.returncode == 0, run.stderr[-2000:]
    return path


def width(processor: str) -> int:
    """The width of vectors that we choose for a processor, of which nothing but the name is known."""
    return vectors._bits(TRIPLES[processor], processor, "", 0)


def assembly(code: Path, processor: str, optimized: bool = True) -> str:
    """The instructions of LLVM's code on a processor, in vectors of the width that is chosen for it."""
    how = "optimized" if optimized else "as it is"
    run = _run(BACK, code, TRIPLES[processor], processor, width(processor), how)
    if "Unable to find target" in run.stderr or "No available targets" in run.stderr:
        pytest.skip(f"this LLVM makes no code for {TRIPLES[processor]}")
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout


def functions(text: str) -> dict[str, list[str]]:
    """The instructions of each function, by its name."""
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
