"""The lane loops are vectors in the machine code, on a machine that has them."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import llvmlite.binding as llvm
import pytest

FEATURES = llvm.get_host_cpu_features()
WIDE = "zmm" if FEATURES.get("avx512f") else "ymm"
PROGRAM = """
import conicoid as co
from conicoid.trace.array_kernels import trace_first
rays = co.Camera((0, 0, 5), (0, 0, 0), up=(0, 1, 0)).rays(16, 16)
co.Scene([co.Sphere()]).first_hit(rays)
print(next(iter(trace_first.inspect_asm().values())))
"""


@pytest.fixture(scope="module")
def functions(tmp_path_factory):
    """The instructions of each function of `trace_first`, by name; compiled anew, and here: kept kernels have no text."""
    if not FEATURES.get("avx2"):
        pytest.skip("this processor has no AVX2")
    environment = {**os.environ, "CONICOID_CACHE_DIR": str(tmp_path_factory.mktemp("kernels"))}
    environment["CONICOID_THREADS"] = "1"  # or another process compiles it
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, env=environment, timeout=300
    )
    found, name = {}, ""
    for line in run.stdout.splitlines():
        label = re.match(r"^(_ZN\S+):", line)
        if label:
            name = label[1]
            found[name] = []
        elif line.startswith("\t") and not line.startswith("\t.") and name:
            found[name].append(line.split("#")[0].strip())
    return found


def arithmetic(functions, *names):
    """(instructions on whole vectors, on single numbers) among the arithmetic of functions with these names in theirs."""
    lines = [line for name, body in functions.items() if any(part in name for part in names) for line in body]
    kind = r"^v(?:fn?m(?:add|sub)\d+|add|sub|mul|sqrt|div|min|max)"
    vectors = sum(1 for line in lines if re.match(kind + "pd", line) and WIDE in line)
    singles = sum(1 for line in lines if re.match(kind + "sd", line))
    return vectors, singles


@pytest.mark.parametrize(("loop", "least"), [("ball_lanes", 80), ("face_lanes", 300), ("trace_packet", 200)])
def test_lane_loops_are_vectors(functions, loop, least):
    """Balls; quadrics and planes of cells; boxes. About two thirds of what stood there when this was written.

    What follows from an origin that all lanes share stands before the loops, in single numbers.
    """
    vectors, singles = arithmetic(functions, loop)
    assert vectors >= least
    assert vectors > 4 * singles


def test_lane_loops_of_boolean_bodies_are_vectors(functions):
    """Mostly comparisons. They have scalar forms too, for arrays that overlap, which the compiler cannot know do not."""
    bodies = [body for name, body in functions.items() if "lane_regions" in name]
    kind = r"^v(?:cmp\w*|add|sub|mul|min|max|blendm|blendv|and|or)pd"
    assert sum(1 for body in bodies for line in body if re.match(kind, line) and WIDE in line) >= 85


def test_there_are_lane_loops(functions):
    """However functions are merged: much of the arithmetic, and roots, are on whole vectors."""
    lines = [line for body in functions.values() for line in body]
    assert sum(1 for line in lines if line.startswith("vsqrtpd") and WIDE in line) >= 3
    assert sum(1 for line in lines if re.match(r"v(fn?m\w+|mul|add|sub)pd", line) and WIDE in line) > 200
