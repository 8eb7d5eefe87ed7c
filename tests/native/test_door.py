"""No mistake in Python reaches machine code: every kernel by its door, with wrong arguments of every kind."""

import ast
import os
import subprocess
import sys

import pytest

from ..children import ROOT
from ..machine_code import needs_machine_code

pytestmark = needs_machine_code


@pytest.mark.parametrize(
    ("count", "seed"), [(2000, 0), *(pytest.param(5000, seed, marks=pytest.mark.deep) for seed in range(1, 5))]
)
def test_wrong_arguments_are_errors_and_never_more(count, seed):
    command = [sys.executable, "-m", "tests.native.fuzz", str(count), str(seed)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=os.environ, timeout=3000)
    assert run.returncode == 0, run.stderr[-2000:]
    outcomes = ast.literal_eval(run.stdout)
    assert sum(outcomes.values()) == count
    assert outcomes["TypeError"] > 0.3 * count
    assert outcomes["ValueError"] > 0.1 * count
    assert outcomes["went through"] < 0.3 * count
