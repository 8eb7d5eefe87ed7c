"""Kernels that Numba compiles: how often it compiles each, the versions of Numba, the note on a terminal, and the bits."""

import io
import json
import re
import sys
import tomllib

import numba
import numpy as np
import pytest

from conicoid._jit import compiler
from conicoid._jit.decorators import DECLARED, helper, inline, kernel

from .children import ROOT
from .machine_code import needs_machine_code
from .native.test_digest import DIGESTS, digests
from .samples import deep


@inline
def half(x: float) -> float:
    return 0.5 * x


@helper
def half_of_element(values: np.ndarray, k: int) -> float:
    return half(values[k])


@helper
def sum_of_halves(values: np.ndarray) -> float:
    return half_of_element(values, 0) + half_of_element(values, np.int32(1)) + half_of_element(values, len(values) - 1)


def test_njit_finds_the_callees_of_an_inner_function():
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
    ("wish", "version", "refused"),
    [
        ("", "0.65.0", False),
        ("", "0.64.1", True),
        ("", "{}.{}.9".format(*compiler.TESTED[1]), False),
        ("", f"0.{compiler.TESTED[1][1] + 1}.0rc1", True),
        ("", "1.0", True),
        ("", "nightly", True),
        ("own", "1.0", False),
    ],
)
def test_only_tested_versions_of_numba_compile_unless_the_user_insists(wish, version, refused):
    if refused:
        with pytest.raises(
            ImportError, match=rf"Conicoid compiles with Numba 0\.65 to .*, found {version}: pip install"
        ):
            compiler.require_tested_version(version, wish)
    else:
        compiler.require_tested_version(version, wish)


def test_the_installed_numba_is_a_tested_one():
    compiler.require_tested_version(numba.__version__, "")


def test_the_extra_installs_tested_versions_alone():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    (first, last) = compiler.TESTED
    assert extras["jit"] == [f"numba>={first[0]}.{first[1]},<{last[0]}.{last[1] + 1}"]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def note(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> str:
    """Return the text that a compilation writes to a stream in place of stderr."""
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(compiler._Note, "SECONDS", 0.001)

    def halves(values: np.ndarray) -> float:
        return half_of_element(values, 0) + half(values[1])

    assert compiler.compile_function(halves, entry=True)(np.array([2.0, 4.0])) == 3.0
    return stream.getvalue()


def test_a_terminal_shows_the_kernel_being_compiled(monkeypatch):
    first, *others, last, end = note(monkeypatch, Terminal()).split("\r")[1:]
    assert first == "compiling halves in this process: 0 functions, 0 s"
    assert others
    assert all(
        re.fullmatch(r"compiling halves in this process: \d+ functions, \d+ s", each.rstrip()) for each in others
    )
    assert (last.strip(), end) == ("", "")
    assert len(last) >= len(first)


def test_no_line_is_shown_without_a_terminal(monkeypatch):
    assert note(monkeypatch, io.StringIO()) == ""


CHECKS = "first_invalid", "hit_points"
HIT_FIELDS = "faces_of", "normals_of", "uvs_of", "errors_of_t"
TRACERS = "trace_first", "trace_rows"


@needs_machine_code
@pytest.mark.parametrize("names", [CHECKS, deep((HIT_FIELDS,)), deep((TRACERS,))], ids=" ".join)
def test_compiled_kernels_give_the_bits_of_machine_code(names, monkeypatch):
    """Every kind of answer has its digest where this process compiles some kernels."""
    digests()  # imports the modules with kernels
    modules = [module for name, module in sys.modules.items() if name.startswith("conicoid.")]
    kernels = {name: compiler.compile_function(DECLARED[name][0], entry=True) for name in names}
    for name, module in [(name, module) for name in names for module in modules if name in vars(module)]:
        monkeypatch.setattr(module, name, kernels[name])
    assert digests() == json.loads(DIGESTS.read_text(encoding="utf-8"))
    assert all(each.overloads for each in kernels.values())
