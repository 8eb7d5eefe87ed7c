"""Inner functions from Numba's own `njit`, and how often they are compiled."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from conicoid.compiler import jit
from conicoid.compiler.jit import helper, inline, kernel
from conicoid.environment import jit_wanted


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
    outer = kernel(lambda values: sum_of_halves(values))
    assert outer(np.array([2.0, 4.0, 8.0])) == 7.0


def test_constants_and_widths_do_not_multiply_a_function():
    sum_of_halves.compile((numba.float64[::1],))
    assert len(half_of_element.overloads) == 1


@pytest.mark.parametrize(
    ("wish", "version", "plain"),
    [
        ("", "0.65.0", False),
        ("", "0.64.1", True),
        ("", "{}.{}.9".format(*jit.TESTED[1]), False),
        ("", f"0.{jit.TESTED[1][1] + 1}.0rc1", True),
        ("", "1.0", True),
        ("", "nightly", True),
        ("own", "1.0", False),
        ("plain", "0.65.0", True),
    ],
)
def test_our_own_way_is_for_versions_of_numba_that_it_was_tested_with(wish, version, plain):
    assert jit._is_plain(wish, version) is plain


def test_the_installed_numba_is_one_of_these():
    assert not jit._is_plain("", numba.__version__)


def test_there_are_two_ways_only(monkeypatch):
    monkeypatch.setenv("CONICOID_JIT", "fast")
    with pytest.raises(ValueError, match="CONICOID_JIT must be 'plain' or 'own', got 'fast'"):
        jit_wanted()


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
print("conicoid.compiler.functions" in sys.modules)
"""


def said(program: str, way: str, folder: object) -> list[str]:
    environment = {**os.environ, "CONICOID_JIT": way, "CONICOID_CACHE_DIR": str(folder)}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_plain_njit(tmp_path):
    program = "import sys, conicoid as co; print(len(co.Rays([(0, 0, 5)], (0, 0, -1)).origins)); print('conicoid.compiler.functions' in sys.modules)"
    assert said(program, "plain", tmp_path) == ["1", "False"]
    assert not list(tmp_path.iterdir())


@pytest.mark.deep
def test_plain_njit_gives_the_same_bits(tmp_path):
    own, plain = (said(SAMPLE, way, tmp_path) for way in ("own", "plain"))
    assert (own.pop(), plain.pop()) == ("True", "False")
    assert own == plain
