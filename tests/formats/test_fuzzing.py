"""Damaged and random files by the thousand: a clear refusal or a scene, no traceback, within limits of time and memory."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..samples import deeper
from .fuzzing.worker import BYTES, KINDS

ROOT = Path(__file__).resolve().parents[2]
SAMPLE, FULL, BLOCK = 40, 10_000, 100

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")


def run(kinds: list[str], first: int, count: int, folder: Path) -> None:
    """Run cases first, first + 1, ... of each kind, in a process of their own."""
    command = [sys.executable, "-m", "tests.formats.fuzzing.worker", str(first), str(count), str(folder), *kinds]
    ran = subprocess.run(
        command,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=len(kinds) * (60 + count),
        check=False,
        env=os.environ,
    )
    assert ran.returncode == 0, f"the process died: {ran.returncode}\n{ran.stderr[-5000:]}"
    assert ran.stderr == ""
    lines = [json.loads(line) for line in ran.stdout.splitlines()]
    wrong = [f"{case['kind']} {case['seed']}: {case['error']}\n{case['trace']}" for case in lines if "error" in case]
    assert not wrong, f"{len(wrong)} of {count} cases:\n" + "\n".join(wrong[:5])
    assert [line["kind"] for line in lines] == kinds
    for summary in lines:
        assert summary["done"] == count
        assert summary["peak"] < BYTES
        if first < SAMPLE:  # a later block may have none of the few accepted cases of a kind
            assert count / 40 < summary["accepted"] < count, f"{summary['kind']}: one half only is tested"


@pytest.mark.parametrize(("kinds", "first", "count"), [
    (list(KINDS), 0, SAMPLE), *deeper(([kind], first, BLOCK) for kind in KINDS for first in range(SAMPLE, SAMPLE + FULL, BLOCK)),
])  # fmt: skip
def test_damaged_files(kinds, first, count, tmp_path):
    run(kinds, first, count, tmp_path)
