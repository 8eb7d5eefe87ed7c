"""Inner functions from Numba's own `njit`, and how often they are compiled."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest
from numba.core.registry import cpu_target

from conicoid._jit import dispatch
from conicoid._jit import vector_width as vectors
from conicoid._jit.decorators import helper, inline, kernel
from conicoid._jit.numba_cache import KernelCache
from conicoid._util.environment import read_jit_mode, read_vector_bits


@inline
def half(x: float) -> float:
    return 0.5 * x


@helper
def half_of_element(values: np.ndarray, k: int) -> float:
    return half(values[k])


@helper
def sum_of_halves(values: np.ndarray) -> float:
    return half_of_element(values, 0) + half_of_element(values, np.int32(1)) + half_of_element(values, len(values) - 1)


def test_njit_finds_what_an_inner_function_calls():
    @numba.njit
    def outer(values):
        return sum_of_halves(values) + half_of_element(values, 0)

    assert outer(np.array([2.0, 4.0, 6.0])) == 7.0


def test_a_kernel_is_linked_with_all_that_it_calls():
    outer = kernel()(lambda values: sum_of_halves(values))
    assert outer(np.array([2.0, 4.0, 8.0])) == 7.0


def test_constants_and_widths_do_not_multiply_a_function():
    sum_of_halves.compile((numba.float64[::1],))
    assert len(half_of_element.overloads) == 1


@pytest.mark.parametrize(
    ("wish", "version", "plain"),
    [
        ("", "0.65.0", False),
        ("", "0.64.1", True),
        ("", "{}.{}.9".format(*dispatch.TESTED[1]), False),
        ("", f"0.{dispatch.TESTED[1][1] + 1}.0rc1", True),
        ("", "1.0", True),
        ("", "nightly", True),
        ("own", "1.0", False),
        ("plain", "0.65.0", True),
    ],
)
def test_our_own_way_is_for_versions_of_numba_that_it_was_tested_with(wish, version, plain):
    assert dispatch._is_plain(wish, version) is plain


def test_the_installed_numba_is_one_of_these():
    assert not dispatch._is_plain("", numba.__version__)


def test_there_are_two_ways_only(monkeypatch):
    monkeypatch.setenv("CONICOID_JIT", "fast")
    with pytest.raises(ValueError, match="CONICOID_JIT must be 'plain' or 'own', got 'fast'"):
        read_jit_mode()


def test_a_width_of_vectors_is_one_of_two(monkeypatch):
    monkeypatch.setenv("CONICOID_VECTOR_BITS", "1024")
    with pytest.raises(ValueError, match="CONICOID_VECTOR_BITS must be 256 or 512, got '1024'"):
        read_vector_bits()


LINUX = "x86_64-unknown-linux-gnu"


@pytest.mark.parametrize(
    ("triple", "processor", "features", "wish", "bits"),
    [
        (LINUX, "znver4", "", 0, 512),
        (LINUX, "icelake-server", "+avx512f,+avx512vl", 0, 512),
        (LINUX, "skylake-avx512", "+avx512f,+avx512vl", 0, 256),
        (LINUX, "haswell", "+avx,+avx2", 0, 256),
        (LINUX, "rocketlake", "+avx512f,-avx512fp16", 0, 256),
        (LINUX, "rocketlake", "+avx512f,+avx512fp16", 0, 512),  # a virtual machine that tells another model's number
        (LINUX, "generic", "+avx512f,+sse4a", 0, 512),  # AMD's next
        (LINUX, "znver5", "", 256, 256),
        (LINUX, "skylake-avx512", "", 512, 512),
        ("arm64-apple-darwin25.0.0", "apple-m1", "", 0, 0),
        ("arm64-apple-darwin25.0.0", "apple-m1", "", 512, 512),
    ],
)
def test_the_width_of_vectors(triple, processor, features, wish, bits):
    assert vectors._bits(triple, processor, features, wish) == bits


def test_kernels_of_another_width_are_other_files(monkeypatch):
    """Of the cache; LLVM's name and features of the processor are the same."""
    signature, code = (numba.float64[::1],), cpu_target.target_context.codegen()
    names = set()
    for wish in (256, 512):
        monkeypatch.setattr(vectors, "_wish", wish)
        names.add(KernelCache(half.py_func)._file(signature, code))
    assert len(names) == 2


@pytest.mark.parametrize("wish", [256, 512])
def test_a_kernel_prefers_what_is_wished(wish, monkeypatch):
    monkeypatch.setattr(vectors, "_wish", wish)
    outer = kernel()(lambda values: abs(values[0]))
    outer(np.array([-2.0]))
    written = "".join(outer.inspect_llvm().values())
    assert f'"prefer-vector-width"="{wish}"' in written
    assert f'"prefer-vector-width"="{768 - wish}"' not in written


SAMPLE = """
import hashlib
import sys
import numpy as np
import conicoid as co

scene = co.Scene([co.Sphere(1), co.Box((2, 0, 0), (3, 1, 1)) - co.Sphere(0.5, (2, 0, 0)),
                  co.Cone((0, 0, 3), (0, 0, 5), 1, 0.5).rotate((1, 2, 3), 15), co.Disc((0, 0, 7), (0, 1, 1), 2)])
random = np.random.default_rng(0)
rays = [(random.integers(-8, 8, (3000, 3)), np.where(d == 0, 1e-3, d)) for d in random.integers(-3, 4, (1, 3000, 3))]
for origins, directions in rays + [([3.0, 4.0, 5.0], [-3.0, -4.0, -4.9])]:
    hits, spans, crossings = (getattr(scene, query)(origins, directions) for query in ("first_hit", "spans", "crossings"))
    for value in (hits.t, hits.t_error, hits.point, hits.normal, hits.uv, hits.doubtful, spans.t_enter, crossings.t, crossings.face):
        print(hashlib.sha256(np.ascontiguousarray(value)).hexdigest())
print("conicoid._jit.compiler" in sys.modules)
"""


def said(program: str, way: str, folder: object, bits: str = "") -> list[str]:
    environment = {
        **os.environ, "CONICOID_JIT": way, "CONICOID_CACHE_DIR": str(folder), "CONICOID_VECTOR_BITS": bits,
    }  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_plain_njit(tmp_path):
    program = "import sys, conicoid as co; print(len(co.Rays([(0, 0, 5)], (0, 0, -1)).origins)); print('conicoid._jit.compiler' in sys.modules)"
    assert said(program, "plain", tmp_path) == ["1", "False"]
    assert not list(tmp_path.iterdir())


@pytest.mark.deep
def test_plain_njit_gives_the_same_bits(tmp_path):
    own, plain = (said(SAMPLE, way, tmp_path) for way in ("own", "plain"))
    assert (own.pop(), plain.pop()) == ("True", "False")
    assert own == plain


@pytest.mark.deep
def test_both_widths_of_vectors_give_the_same_bits(tmp_path):
    assert said(SAMPLE, "own", tmp_path, "256") == said(SAMPLE, "own", tmp_path, "512")
