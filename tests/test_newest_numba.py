"""The script that tries the newest Numba: what it says, with and without a network."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
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


@pytest.mark.parametrize(
    ("version", "works", "said"),
    [
        ("0.68.1", True, ["0.68.1 works", "nothing to raise"]),
        (
            "0.69.0rc1",
            True,
            ["Raise the second of TESTED in conicoid/_jit/compiler.py from (0, 68) to (0, 69)", "extra"],
        ),
        ("1.0.0", True, ["from (0, 68) to (1, 0)"]),
        ("0.69.0", False, ["0.69.0 fails", "Leave TESTED in conicoid/_jit/compiler.py at (0, 68)"]),
        ("0.68.2", False, ["mend the compiler, or lower it"]),
    ],
)
def test_what_is_to_be_written(script, version, works, said):
    text = "\n".join(script.verdict(version, (0, 68), works))
    assert all(each in text for each in said), text


def test_it_reads_what_is_tested(script):
    assert script.last_tested() == compiler.TESTED[1]


def test_the_tests_that_it_runs_are_there(script):
    for path in (*script.TESTS, script.COMPILER, script.REQUIREMENTS):
        assert (script.ROOT / path).exists()
    path, _, name = script.ASKS_FOR_A_TESTED_ONE.partition("::")
    assert f"def {name}(" in (script.ROOT / path).read_text(encoding="utf-8")


def test_the_compiler_is_not_held_back(script):
    lock = "llvmlite==0.50.0\nmpmath==1.4.1\nnumba==0.68.1\nnumpy==2.4.6\nnumpydoc==1.9\n"
    assert script.constraints(lock) == "mpmath==1.4.1\nnumpydoc==1.9\n"


@pytest.mark.deep  # it makes an environment
def test_without_a_network(tmp_path):
    """The index is a folder that is not there: one message, and nothing left behind."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PIP_")}
    environment |= {"PIP_CONFIG_FILE": os.devnull, "PIP_NO_INDEX": "1", "TMPDIR": str(tmp_path), "TEMP": str(tmp_path)}
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(
        "Not tried: pip could not install --upgrade pip hatchling (is there a network?):\nERROR: "
    )
    assert len(done.stderr.splitlines()) < 6
    assert not list(tmp_path.iterdir())
