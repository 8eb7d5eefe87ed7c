"""Type hints accept correct programs: pyright, as in editors, agrees with mypy (`make check`) about a user's program."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.deep
def test_pyright_finds_the_error_of_the_last_line_and_no_other(tmp_path):
    """Pyright's stricter rules are for users who choose them; errors are for all."""
    lines = Path(__file__).with_name("typing_program.py").read_text(encoding="utf-8").splitlines()
    program = tmp_path / "program.py"
    program.write_text("\n".join([*lines[:-1], lines[-1].partition("  #")[0]]), encoding="utf-8")
    ran = subprocess.run(
        [sys.executable, "-m", "basedpyright", "--outputjson", "--level", "error", "--pythonpath", sys.executable,
         str(program)],
        capture_output=True, text=True, check=False, timeout=300, cwd=Path(__file__).parent,
    )  # fmt: skip
    found = json.loads(ran.stdout)["generalDiagnostics"]
    assert [item["range"]["start"]["line"] + 1 for item in found] == [len(lines)], ran.stdout + ran.stderr
    assert "rendered" in found[0]["message"]
