"""How the command ends: without freeing what was made, and without taking anything from whoever goes on or listens."""

from __future__ import annotations

import os
import subprocess
import sys

from .children import ROOT

BY_ANOTHER = """
import runpy, sys
sys.argv = ["conicoid", "--version"]
try:
    runpy.run_module("conicoid", run_name="__main__")
except SystemExit as end:
    print("ended with", end.code)
"""
LATE = """
import atexit, sys
from conicoid.__main__ import run
atexit.register(lambda: print("late"))
sys.argv = ["conicoid", "--version"]
run()
"""
WATCHED = """
import sys
from conicoid.__main__ import run
sys.argv = ["conicoid", "--version"]
if hasattr(sys, "monitoring"):
    sys.monitoring.use_tool_id(sys.monitoring.PROFILER_ID, "watcher")
else:
    sys.setprofile(lambda *event: None)
try:
    run()
finally:
    print("watched to the end")
"""


def printed(*words: str, given: str = "") -> str:
    """What Python prints, of both streams."""
    ran = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, input=given, timeout=120, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    return ran.stdout + ran.stderr


def test_a_program_that_runs_it_goes_on() -> None:
    assert "ended with 0" in printed("-c", BY_ANOTHER)


def test_what_is_printed_at_the_end_is_written() -> None:
    assert printed("-c", LATE).endswith("late\n")


def test_a_watcher_is_left_to_tell() -> None:
    assert "watched to the end" in printed("-c", WATCHED)


def test_a_profile_is_printed() -> None:
    assert "cumtime" in printed("-m", "cProfile", "-m", "conicoid", "--version")


def test_a_prompt_follows() -> None:
    assert "42" in printed("-i", "-m", "conicoid", "--version", given="print(6 * 7)\n")
