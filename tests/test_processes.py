"""Scenes go to other processes by every start method, and their answers come back."""

import multiprocessing
import os
import subprocess
import sys

import pytest

from .children import ROOT
from .samples import marked

ALL = ("fork", "spawn", "forkserver")
HERE = [method for method in ALL if method in multiprocessing.get_all_start_methods()]

START = """
import multiprocessing, sys
from concurrent.futures import ProcessPoolExecutor
import numpy as np
import conicoid as co

scene = co.Scene([co.Body(co.Sphere(1), co.matte("red"), "ball"), co.Box((-4, -4, -3), (4, 4, -2))])
down = (0.0, 0.0, -1.0)
rays = co.Rays([(0, 0, 5), (3, 0, 5), (9, 0, 5)], down)
context = multiprocessing.get_context(sys.argv[1])
"""

EXECUTOR = """
here = scene.first_hit(rays)
with ProcessPoolExecutor(1, mp_context=context) as pool:
    asked = [pool.submit(getattr(scene, query), rays) for query in ("first_hit", "spans", "crossings", "occluded")]
    hits, spans, crossings, occluded = (one.result() for one in asked)
    again = pool.submit(scene.first_hit, here.spawn(down)).result()
    image = pool.submit(scene.render, 8, 6, 1).result()
print(hits.t.tolist(), hits.name.tolist(), hits.normal[0].tolist(), hits.t_error[2])
print(spans.lengths().tolist(), crossings.t.tolist(), occluded.tolist())
print(scene.first_hit(hits.spawn(down)).t.tolist(), again.t.tolist(), image.pixels.shape)
"""

POOL = """
with context.Pool(1) as pool:
    for hits in pool.map(scene.first_hit, [rays[:1], rays[1:]]):
        print(hits.t.tolist(), hits.name.tolist())
"""

JOBLIB = """
import joblib
for hits in joblib.Parallel(2)(joblib.delayed(scene.first_hit)(part) for part in (rays[:1], rays[1:])):
    print(hits.t.tolist(), hits.name.tolist())
assert joblib.hash(scene) == joblib.hash(co.Scene(scene.bodies))
"""


def lines_of(program: str, method: str) -> list[str]:
    process = subprocess.run(
        [sys.executable, "-c", START + program, method],
        capture_output=True, text=True, timeout=300, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert process.returncode == 0, process.stderr
    return process.stdout.splitlines()


@pytest.mark.parametrize("method", marked((method, method == "spawn") for method in HERE))
def test_answers_come_back(method):
    """The routes are an executor, a pool, and joblib."""
    joblib = JOBLIB if method == "spawn" else ""
    pool = ["[4.0] ['ball']", "[7.0, inf] [None, None]"]
    assert lines_of(EXECUTOR + POOL + joblib, method) == [
        "[4.0, 7.0, inf] ['ball', None, None] [0.0, 0.0, 1.0] 0.0",
        "[[2.0, 1.0], [0.0, 1.0], [0.0, 0.0]] [4.0, 6.0, 7.0, 8.0, 7.0, 8.0] [True, True, False]",
        "[2.0, 1.0, inf] [2.0, 1.0, inf] (6, 8, 3)",
        *pool * (2 if joblib else 1),
    ]
