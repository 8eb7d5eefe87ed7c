"""Code for the lanes and for the vectors of `engine/culling` can be made for other processors."""

import re

import pytest

from ..samples import deep
from .processors import assembly, before_optimization, functions

PROGRAM = """
import sys
from pathlib import Path
import llvmlite.binding as llvm
from numba import njit
from conicoid.kernels.bvh import culling as simd
from conicoid.kernels.packet.cells import ball_lanes
from conicoid.kernels.ray import Ray
from conicoid.kernels.surface.quadric import SphereRecord

@njit("int64(float64[::1], float64[::1], int64[::1], int32[::1], float64[::1], int64)",
      no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)
def all_of_them(f, rays, lists, counts, near, n):
    simd.put_on_lists(f, 0, n, rays, lists, 0, n, 64, counts)
    simd.load_eight(f, n, near, 0)
    ball_lanes(rays, SphereRecord(f[0], f[1], f[2], f[3]), 0, 0, 0, 0, 64)
    ray = Ray(f[0], f[1], f[2], f[3], f[4], f[5], 0.0, 1.0, n)
    bits = simd.hit_boxes(f, 0, rays, 0, near) | simd.balls_in_beam(f, 0, 8, 8, rays, 0, near)
    bits |= simd.hit_items(f, 0, rays, 0) | simd.group_in_ball(rays, n, f[0], f[1], f[2], f[3])
    simd.keep_items(f, 0, bits, near, n)
    n += simd.put_children(f, 0, counts, 0, n, rays, 0, lists, near, n) + simd.put_balls(f, 0, 8, n, rays, 0, near, n)
    simd.put_numbers(n, bits, lists, 0)
    n += simd.put_groups(f, n, n, rays, 0, lists, n)
    simd.extents(near, 0, n, n + 8)
    bits |= simd.hit_balls(f, 0, 8, 8, ray, f[6], 1.0) | simd.lanes_in_ball(rays, f[0], f[1], f[2], f[3])
    return bits + simd.lowest_bit(bits) + simd.highest_bit(bits)

module = llvm.parse_assembly(next(iter(all_of_them.inspect_llvm().values())))
Path(sys.argv[1]).write_bytes(module.as_bitcode())
"""


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    return before_optimization(PROGRAM, tmp_path_factory.mktemp("code") / "all_of_them.bc")


@pytest.mark.parametrize(("processor", "wide"), [deep(("x86-64-v3", "ymm")), ("x86-64-v4", "zmm")])
def test_the_loop_over_balls_is_vectors(code, processor, wide):
    """All loops over lanes are vectors; test_assembly.py tests the others in the kernel of first hits."""
    lines = [line for body in functions(assembly(code, processor)).values() for line in body]
    vectors, singles = (
        sum(1 for line in lines if re.match(rf"v(?:fn?m(?:add|sub)\d+|add|sub|mul|sqrt|div|min|max){kind}", line)
            and re.search(registers, line))
        for kind, registers in (("pd", wide), ("sd", "xmm"))
    )  # fmt: skip
    assert vectors > 80
    assert vectors > singles


@pytest.mark.parametrize(
    ("processor", "fused"),
    [
        ("generic", r"\bfml[as]\s+v\d+\.2d"),
        deep(("apple-m1", r"\bfml[as]\.2d\s+v\d+")),
        ("x86-64-v3", r"\bvfn?m(add|sub)\d+pd\s.*ymm"),
        deep(("x86-64-v4", r"\bvfn?m(add|sub)\d+pd\s.*zmm")),
    ],
)
def test_other_processors_have_code(code, processor, fused):
    assert len(re.findall(fused, assembly(code, processor, optimized=False))) > 20
