"""Bodies in Mitsuba's words, traced by a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..mitsuba import find_llvm
from ..peer import Absent
from .bodies import Ball, Block, Body, Turned
from .families import Trial
from .frames import along_axis
from .tally import Answer


def trace(trials: Sequence[Trial]) -> list[Answer]:
    """Raises Absent where Mitsuba does not run."""
    with tempfile.TemporaryDirectory(prefix="conicoid-bench-") as name:
        folder = Path(name)
        (folder / "scenes.json").write_text(json.dumps([_shapes(trial.body) for trial in trials]))
        counts = [len(trial.origins) for trial in trials]
        origins, directions = (
            np.concatenate(rows).astype(np.float32)
            for rows in ([trial.origins for trial in trials], [trial.directions for trial in trials])
        )
        np.savez(folder / "rays.npz", origins=origins, directions=directions, counts=counts)
        done = subprocess.run(
            [sys.executable, "-m", "conicoid.bench.accuracy.mitsuba_worker", str(folder)],
            env={**os.environ, "DRJIT_LIBLLVM_PATH": str(find_llvm())}, capture_output=True, text=True,
        )  # fmt: skip
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise Absent(f"Mitsuba's process ended ({done.returncode}): {lines[-1] if lines else ''}")
        t = np.load(folder / "t.npy").astype(float)
        return [Answer(part) for part in np.split(t, np.cumsum(counts)[:-1])]


def _shapes(body: Body) -> list[dict[str, Any]]:
    """As dictionaries for `load_dict`, with matrices as lists. Its cylinder is open, so two discs close it."""
    if isinstance(body, Ball):
        return [{"type": "sphere", "center": body.center, "radius": body.radius}]
    if isinstance(body, Block):
        low, high = np.array(body.low), np.array(body.high)
        frame = np.diag([*(high - low) / 2, 1])
        frame[:3, 3] = (low + high) / 2
        return [{"type": "cube", "to_world": frame.tolist()}]
    assert isinstance(body, Turned)
    frame, _ = along_axis(body.start, body.end)
    frame[:3, :2] *= body.start_radius
    discs = []
    for center in (body.start, body.end):
        frame[:3, 3] = center
        discs.append({"type": "disk", "to_world": frame.tolist()})
    return [{"type": "cylinder", "p0": body.start, "p1": body.end, "radius": body.start_radius}, *discs]
