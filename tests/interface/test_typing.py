"""Type hints take what runs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("typing_program.py")
CACHE = Path(__file__).parents[2] / ".mypy_cache" / "a_users_program"
"""What mypy knows of the package from the run before; it looks at what changed since."""


def test_a_users_program_has_one_error_its_last_line():
    """The line that is wrong on purpose shows that hints are found at all."""
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={CACHE}", "--no-error-summary",
         "--follow-imports=silent", str(PROGRAM)],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    last = len(PROGRAM.read_text(encoding="utf-8").splitlines())
    found = [line.split(":", 1)[1] for line in ran.stdout.splitlines() if ": error:" in line]
    assert len(found) == 1, ran.stdout + ran.stderr
    assert found[0].startswith(f"{last}: error: "), found
    assert "rendered" in found[0]


@pytest.mark.deep
def test_pyright_says_the_same():
    """As editors have it. Its own stricter rules are for those who choose them; errors are everybody's."""
    ran = subprocess.run(
        [sys.executable, "-m", "basedpyright", "--outputjson", "--level", "error", "--pythonpath", sys.executable,
         str(PROGRAM)],
        capture_output=True, text=True, check=False, timeout=300, cwd=PROGRAM.parent,
    )  # fmt: skip
    last = len(PROGRAM.read_text(encoding="utf-8").splitlines())
    found = json.loads(ran.stdout)["generalDiagnostics"]
    assert [item["range"]["start"]["line"] + 1 for item in found] == [last], ran.stdout + ran.stderr
    assert "rendered" in found[0]["message"]
