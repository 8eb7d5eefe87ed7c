"""Where a peer keeps a body along its own z axis."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from conicoid.scene.scene import Scene

from .. import peers
from ..harness import ROOT, Absent, Peer, module
from ..peers import find_llvm
from ..scenes import BallRows
from .bodies import SHAPES, Body, ExactBall, ExactBlock, ExactRevolution, Floats, Trial, Vector
from .reference import SystemAnswer


def along_axis(start: Vector, end: Vector) -> tuple[Floats, float]:
    """A rotation and shift (4, 4) that takes z to an axis along a coordinate axis and 0 to `start`, and its length.

    Both are exact: the rotation has entries 0, 1 and -1.
    """
    step = np.subtract(end, start)
    k = int(np.argmax(np.abs(step)))
    frame = np.eye(4)
    frame[:3, :3] = np.roll(np.eye(3), k + 1, axis=0)  # a cyclic exchange, which takes z to axis k
    if step[k] < 0:
        frame[:3, [0, 2]] *= -1  # half a turn about y
    frame[:3, 3] = start
    return frame, float(abs(step[k]))


# Bodies in Mitsuba's words, traced by a process of its own.


def trace(trials: Sequence[Trial]) -> list[SystemAnswer]:
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
            [sys.executable, "-m", "benchmarks.comparison.accuracy.mitsuba_worker", str(folder)], cwd=ROOT,
            env={**os.environ, "DRJIT_LIBLLVM_PATH": str(find_llvm())}, capture_output=True, text=True,
        )  # fmt: skip
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise Absent(f"Mitsuba's process ended ({done.returncode}): {lines[-1] if lines else ''}")
        t = np.load(folder / "t.npy").astype(float)
        return [SystemAnswer(part) for part in np.split(t, np.cumsum(counts)[:-1])]


def _shapes(body: Body) -> list[dict[str, Any]]:
    """As dictionaries for `load_dict`, with matrices as lists. Its cylinder is open, so two discs close it."""
    if isinstance(body, ExactBall):
        return [{"type": "sphere", "center": body.center, "radius": body.radius}]
    if isinstance(body, ExactBlock):
        low, high = np.array(body.low), np.array(body.high)
        frame = np.diag([*(high - low) / 2, 1])
        frame[:3, 3] = (low + high) / 2
        return [{"type": "cube", "to_world": frame.tolist()}]
    assert isinstance(body, ExactRevolution)
    frame, _ = along_axis(body.start, body.end)
    frame[:3, :2] *= body.start_radius
    discs = []
    for center in (body.start, body.end):
        frame[:3, 3] = center
        discs.append({"type": "disk", "to_world": frame.tolist()})
    return [{"type": "cylinder", "p0": body.start, "p1": body.end, "radius": body.start_radius}, *discs]


# The systems that are measured, each in its own words for the same bodies and rays.


@dataclass(frozen=True)
class System:
    """Bits of the floats that it takes and answers with, the shapes it has, and how it traces trials."""

    peer: Peer
    inputs: int
    answers: int
    shapes: tuple[str, ...]
    trace: Callable[[Sequence[Trial]], list[SystemAnswer]]


def with_conicoid(trials: Sequence[Trial]) -> list[SystemAnswer]:
    def answer(trial: Trial) -> SystemAnswer:
        hits = Scene([trial.body.shape()]).first_hit(trial.origins, trial.directions)
        return SystemAnswer(hits.t, getattr(hits, "t_error", None))

    return [answer(trial) for trial in trials]


def with_embree(trials: Sequence[Trial]) -> list[SystemAnswer]:
    def answer(trial: Trial) -> SystemAnswer:
        assert isinstance(trial.body, ExactBall)
        ball = BallRows(np.array([trial.body.center], np.float32), np.array([trial.body.radius], np.float32))
        rays = (np.ascontiguousarray(x, np.float32) for x in (trial.origins, trial.directions))
        with peers.EmbreeScene(ball) as scene:
            return SystemAnswer(scene.first_hits(*rays)[1])

    return [answer(trial) for trial in trials]


def with_raysect(trials: Sequence[Trial]) -> list[SystemAnswer]:
    core: Any = module("raysect.core", "raysect")

    def answer(trial: Trial) -> SystemAnswer:
        world = core.World()
        _raysect_body(trial.body, world)
        rows = zip(trial.origins.tolist(), trial.directions.tolist(), strict=True)
        found = (world.hit(core.Ray(core.Point3D(*o), core.Vector3D(*d))) for o, d in rows)
        return SystemAnswer(np.array([np.inf if hit is None else hit.ray_distance for hit in found]))

    return [answer(trial) for trial in trials]


def _raysect_body(body: Body, world: Any) -> Any:
    core: Any = module("raysect.core", "raysect")
    primitive: Any = module("raysect.primitive", "raysect")
    if isinstance(body, ExactBall):
        return primitive.Sphere(body.radius, parent=world, transform=core.translate(*body.center))
    if isinstance(body, ExactBlock):
        return primitive.Box(core.Point3D(*body.low), core.Point3D(*body.high), parent=world)
    assert isinstance(body, ExactRevolution)
    frame, height = along_axis(body.start, body.end)
    kind = primitive.Cone if body.end_radius == 0 else primitive.Cylinder
    return kind(body.start_radius, height, parent=world, transform=core.AffineMatrix3D(frame.tolist()))


def with_trimesh(trials: Sequence[Trial]) -> list[SystemAnswer]:
    """Its answer is a point; t comes from the coordinate in which the direction is longest."""
    library: Any = module("trimesh", "trimesh")
    cube = library.creation.box(extents=(2, 2, 2))

    def answer(trial: Trial) -> SystemAnswer:
        assert isinstance(trial.body, ExactBlock)
        corners = np.where(cube.vertices < 0, trial.body.low, trial.body.high)
        mesh = library.Trimesh(corners, cube.faces, process=False)
        points, ray, _ = mesh.ray.intersects_location(trial.origins, trial.directions, multiple_hits=False)
        t = np.full(len(trial.origins), np.inf)
        along = np.argmax(np.abs(trial.directions[ray]), axis=1)
        row = np.arange(len(ray))
        t[ray] = (points[row, along] - trial.origins[ray, along]) / trial.directions[ray, along]
        return SystemAnswer(t)

    return [answer(trial) for trial in trials]


ALL_SHAPES = tuple(SHAPES)
CONICOID = Peer("Conicoid", "float64", lambda: f"Conicoid {metadata.version('conicoid')}")

SYSTEMS = (
    System(CONICOID, 53, 53, ALL_SHAPES, with_conicoid),
    System(peers.RAYSECT, 53, 53, ("sphere", "box", "cylinder", "cone"), with_raysect),
    System(peers.MITSUBA, 24, 24, ("sphere", "box", "cylinder"), trace),
    System(peers.EMBREE, 24, 24, ("sphere",), with_embree),
    System(
        peers.TRIMESH, 24, 53, ("box",), with_trimesh
    ),  # Embree finds the triangle, trimesh meets its plane in float64
)
