"""The script that tries the newest Numba: its report, with and without a network."""

import importlib.util
from pathlib import Path

import pytest

from conicoid._jit import compiler

SCRIPT = Path(__file__).resolve().parents[1] / ".ci/newest_numba.py"


@pytest.fixture(scope="module")
def script():
    description = importlib.util.spec_from_file_location("newest_numba", SCRIPT)
    module = importlib.util.module_from_spec(description)
    description.loader.exec_module(module)
    return module


def test_the_tested_versions_are_read(script):
    assert script.last_tested() == compiler.TESTED[1]


def test_the_tests_that_it_runs_are_there(script):
    for path in (*script.TESTS, script.COMPILER, script.REQUIREMENTS):
        assert (script.ROOT / path).exists()
    path, _, name = script.ASKS_FOR_A_TESTED_ONE.partition("::")
    assert f"def {name}(" in (script.ROOT / path).read_text(encoding="utf-8")


def test_the_compiler_is_not_held_back(script):
    lock = "llvmlite==0.50.0\nmpmath==1.4.1\nnumba==0.68.1\nnumpy==2.4.6\nnumpydoc==1.9\n"
    assert script.constraints(lock) == "mpmath==1.4.1\nnumpydoc==1.9\n"
