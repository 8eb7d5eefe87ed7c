"""Damaged and random files by the thousand: refused in a clear way or read, never a traceback, never long, never large."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from .fuzzing.worker import BYTES, KINDS

ROOT = Path(__file__).resolve().parents[2]
SAMPLE, FULL, BLOCK = 60, 10_000, 100

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")


def failures(kind: str, first: int, count: int, folder: Path) -> tuple[list[str], dict[str, Any]]:
    """What went wrong in cases first, first + 1, ... and the summary."""
    command = [sys.executable, "-m", "tests.formats.fuzzing.worker", kind, str(first), str(count), str(folder)]
    ran = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=60 + count, check=False, env={**os.environ}
    )
    assert ran.returncode == 0, f"the process died: {ran.returncode}\n{ran.stderr[-5000:]}"
    assert ran.stderr == ""
    *found, summary = map(json.loads, ran.stdout.splitlines())
    return [f"{kind} {case['seed']}: {case['error']}\n{case['trace']}" for case in found], summary


def run(kind: str, first: int, count: int, folder: Path) -> None:
    wrong, summary = failures(kind, first, count, folder)
    assert not wrong, f"{len(wrong)} of {count} cases:\n" + "\n".join(wrong[:5])
    assert summary["done"] == count
    assert summary["peak"] < BYTES
    assert count / 40 < summary["accepted"] < count, "a fuzzer that is always refused, or never, tests one half only"


@pytest.mark.parametrize("kind", KINDS)
def test_a_sample(kind, tmp_path):
    run(kind, 0, SAMPLE, tmp_path)


@pytest.mark.deep
@pytest.mark.parametrize("first", range(SAMPLE, SAMPLE + FULL, BLOCK))
@pytest.mark.parametrize("kind", KINDS)
def test_more(kind, first, tmp_path):
    run(kind, first, BLOCK, tmp_path)
