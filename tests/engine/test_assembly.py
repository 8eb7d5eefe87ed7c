"""The lane loops are vectors in the machine code, at every level of a wheel that has them, whatever this processor is."""

from __future__ import annotations

import re

import pytest

from .processors import FRONT, assembly, before_optimization, functions

pytestmark = pytest.mark.deep  # the kernel of first hits is compiled anew; test_targets.py looks at one of its loops

WIDTHS = {"x86-64-v3": "ymm", "x86-64-v4": "zmm"}
"""The registers of vectors."""


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    """`trace_first` with all that it calls, before LLVM optimises it for a processor."""
    return before_optimization(FRONT, tmp_path_factory.mktemp("code") / "trace_first.bc")


def arithmetic(found: dict[str, list[str]], loop: str, wide: str) -> tuple[int, int]:
    """(instructions on whole vectors, on single numbers) among the arithmetic of functions with this in their names."""
    lines = [line for name, body in found.items() if loop in name for line in body]
    kind = r"^v(?:fn?m(?:add|sub)\d+|add|sub|mul|sqrt|div|min|max)"
    vectors = sum(1 for line in lines if re.match(kind + "pd", line) and re.search(wide, line))
    singles = sum(1 for line in lines if re.match(kind + "sd", line))
    return vectors, singles


@pytest.mark.parametrize("processor", WIDTHS)
def test_lane_loops_are_vectors(code, processor):
    """Balls; quadrics and planes of cells; boxes. About two thirds of what stood there when this was written.

    What follows from an origin that all lanes share stands before the loops, in single numbers. The loops of Boolean
    bodies are mostly comparisons; they have scalar forms too, for arrays that overlap, which the compiler cannot know
    do not. However functions are merged, much of the arithmetic, and roots, are on whole vectors.
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
    """Of two doubles: what is written in vectors is; of loops LLVM thinks that two are hardly worth it."""
    lines = [
        line for name, body in functions(assembly(code, processor)).items() if "trace_packet" in name for line in body
    ]
    assert sum(1 for line in lines if re.match(r"f\w+(\.2d)?\s+v\d+", line)) > 1000
