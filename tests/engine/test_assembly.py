"""The lane loops are vectors in the machine code, at every level of a wheel that has vectors, on any processor."""

import re

import pytest

from .processors import FRONT, assembly, before_optimization, functions

pytestmark = pytest.mark.deep  # it compiles the kernel of first hits; test_targets.py tests one of its loops

WIDTHS = {"x86-64-v3": "ymm", "x86-64-v4": "zmm"}
"""Vector registers."""


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    """Return `trace_first` with all that it calls, before LLVM optimises it for a processor."""
    return before_optimization(FRONT, tmp_path_factory.mktemp("code") / "trace_first.bc")


def arithmetic(found: dict[str, list[str]], loop: str, wide: str) -> tuple[int, int]:
    """Return the counts (instructions on whole vectors, on single numbers) of the arithmetic of functions by name."""
    lines = [line for name, body in found.items() if loop in name for line in body]
    kind = r"^v(?:fn?m(?:add|sub)\d+|add|sub|mul|sqrt|div|min|max)"
    vectors = sum(1 for line in lines if re.match(kind + "pd", line) and re.search(wide, line))
    singles = sum(1 for line in lines if re.match(kind + "sd", line))
    return vectors, singles


@pytest.mark.parametrize("processor", WIDTHS)
def test_lane_loops_are_vectors(code, processor):
    """Most arithmetic of the loops is on whole vectors, for balls, quadrics and planes of cells, and boxes.

    The limits are about two thirds of the counts when this test was written. Values of an origin that all lanes share
    stand before the loops, as single numbers. The loops of Boolean bodies are mostly comparisons. They also have scalar
    forms, because the compiler cannot know that arrays do not overlap. However LLVM merges functions, much of the
    arithmetic, and roots, are on whole vectors.
    """
    wide = WIDTHS[processor]
    found = functions(assembly(code, processor))
    for loop, least in (("ball_lanes", 80), ("face_lanes", 300), ("trace_packet", 200)):
        vectors, singles = arithmetic(found, loop, wide)
        assert vectors >= least, loop
        assert vectors > 4 * singles, loop
    bodies = [body for name, body in found.items() if "booleans" in name]
    kind = r"^v(?:cmp\w*|add|sub|mul|min|max|blendm|blendv|and|or)pd"
    assert sum(1 for body in bodies for line in body if re.match(kind, line) and re.search(wide, line)) >= 85
    lines = [line for body in found.values() for line in body if re.search(wide, line)]
    assert sum(1 for line in lines if line.startswith("vsqrtpd")) >= 3
    assert sum(1 for line in lines if re.match(r"v(fn?m\w+|mul|add|sub)pd", line)) > 200


@pytest.mark.parametrize("processor", ["generic", "apple-m1"])
def test_packets_are_vectors_on_arm(code, processor):
    """Vectors have two doubles there.

    Code that is written in vectors is compiled to them; LLVM finds two too few for most loops.
    """
    lines = [
        line for name, body in functions(assembly(code, processor)).items() if "trace_packet" in name for line in body
    ]
    assert sum(1 for line in lines if re.match(r"f\w+(\.2d)?\s+v\d+", line)) > 1000
