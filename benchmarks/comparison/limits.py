"""The time of a user around the rays, and memory: figures that have a limit of ours instead of a peer.

The ratio is the limit divided by the measurement: one or more is within it.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from conicoid.scene.scene import Scene

from .harness import BenchRow, Measured, Peer, Size
from .scenes import balls, camera_rays

LIMIT = Peer("limit", "at most", lambda: "")

_SCENE = """\
bodies:
  - shape: {Sphere: {radius: 1}}
  - shape: {Difference: [{Box: {low: [1, -1, -1], high: [3, 1, 1]}}, {Sphere: {radius: 1.2, center: [2, 0, 0]}}]}
"""

_RENDER = """\
import sys, time
from conicoid.cli.app import main
sys.argv = ["conicoid", "render", "scene.yaml", "-o", "picture.png", "--width", "64", "--height", "48"]
try:
    main()
finally:
    print(time.process_time())
"""

_IMPORT = "import time; begin = time.perf_counter(); import conicoid; print(time.perf_counter() - begin)"


def _child(program: str, folder: str) -> float:
    """Return the last number that a program prints, run by a new Python in a folder."""
    package = str(Path(__file__).parents[2])
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))}
    command = [sys.executable, "-c", program]
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout.split()[-1])


def check_limit(limit: float, measured: float, unit: str) -> Measured:
    """Compare a figure with its limit."""
    return Measured(measured, limit, limit / measured, unit)


RAY = (0.1, 0.2, -3.0), (0.0, 0.0, 1.0)
SINGLES: dict[str, Callable[[Scene], Any]] = {
    "first_hit": lambda scene: scene.first_hit(*RAY).t,
    "occluded": lambda scene: scene.occluded(*RAY),
    "spans": lambda scene: scene.spans(*RAY).t_enter,
    "contains": lambda scene: scene.contains(RAY[0]),
    "distance": lambda scene: scene.distance(RAY[0]).distance,
}


def microseconds(limit: float, ask: Callable[[Scene], Any], turns: int = 200) -> Callable[[Size], Measured]:
    """Return microseconds of a query on a prepared scene that has answered it before.

    It is the median of so many turns a run.
    """

    def measure(size: Size) -> Measured:
        scene, seconds = Scene(balls(1000).shapes()), []
        ask(scene)
        for _ in range(turns * size.runs):
            begin = time.perf_counter()
            ask(scene)
            seconds.append(time.perf_counter() - begin)
        return check_limit(limit, 1e6 * statistics.median(seconds), "µs")

    return measure


def thousand_rays() -> Callable[[Scene], Any]:
    """First hits of 1,024 neighbours in a picture, from arrays."""
    origins, directions = (part[496:528, 496:528].reshape(-1, 3).astype(float) for part in camera_rays(1024))
    return lambda scene: scene.first_hit(origins, directions).t


def in_new_process(limit: float, program: str) -> Callable[[Size], Measured]:
    """Return the seconds that a program prints, the median of some runs after one that does not count."""

    def measure(size: Size) -> Measured:
        with tempfile.TemporaryDirectory(prefix="conicoid-bench-") as folder:
            Path(folder, "scene.yaml").write_text(_SCENE, encoding="utf-8")
            runs = [_child(program, folder) for _ in range(size.runs + 1)]
        return check_limit(limit, statistics.median(runs[1:]), "s")

    return measure


def bytes_of_a_cell(size: Size) -> Measured:
    """Return the bytes of a ball's tables and its share of the tree, of 24 GiB for ten million balls."""
    memory = Scene(balls(size.balls).shapes()).memory
    return check_limit(np.floor(24 * 2**30 / 1e7), (memory.tables + memory.tree) / memory.primitives, "bytes")


ROWS = (
    *(
        BenchRow(
            "latency" if name == "first_hit" else f"latency-{name}", f"one, {name}", "1,000 balls, prepared", LIMIT,
            1.0, 0.0, microseconds(15.0, ask),
        )
        for name, ask in SINGLES.items()
    ),
    BenchRow(
        "latency-1000", "1,024 neighbours, first_hit", "1,000 balls, prepared", LIMIT, 1.0, 0.0,
        lambda size: microseconds(100.0, thousand_rays())(size),
    ),
    BenchRow("import", "none", "`import conicoid`", LIMIT, 1.0, 0.0, in_new_process(0.5, _IMPORT)),
    BenchRow(
        "command", "picture, 64 × 48", "`conicoid render`, process time", LIMIT, 1.0, 0.0, in_new_process(1.5, _RENDER)
    ),
    BenchRow("memory", "none", "1,000,000 balls, each", LIMIT, 1.0, 0.0, bytes_of_a_cell),
)  # fmt: skip
