"""The systems that are measured, each in its own words for the same bodies and rays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import numpy as np

from ...scene import Scene
from .. import embree, mitsuba, raysect, trimesh
from ..peer import Peer, module
from ..scenes import Balls
from . import mitsuba_bodies
from .bodies import Ball, Block, Body, Turned
from .families import SHAPES, Trial
from .frames import along_axis
from .tally import Answer


@dataclass(frozen=True)
class System:
    """Bits of the floats that it takes and answers with, the shapes it has, and how it traces trials."""

    peer: Peer
    inputs: int
    answers: int
    shapes: tuple[str, ...]
    trace: Callable[[Sequence[Trial]], list[Answer]]


def with_conicoid(trials: Sequence[Trial]) -> list[Answer]:
    def answer(trial: Trial) -> Answer:
        hits = Scene([trial.body.shape()]).first_hit(trial.origins, trial.directions)
        return Answer(hits.t, getattr(hits, "t_error", None))

    return [answer(trial) for trial in trials]


def with_embree(trials: Sequence[Trial]) -> list[Answer]:
    def answer(trial: Trial) -> Answer:
        assert isinstance(trial.body, Ball)
        ball = Balls(np.array([trial.body.center], np.float32), np.array([trial.body.radius], np.float32))
        rays = (np.ascontiguousarray(x, np.float32) for x in (trial.origins, trial.directions))
        with embree.EmbreeScene(ball) as scene:
            return Answer(scene.first_hits(*rays)[1])

    return [answer(trial) for trial in trials]


def with_raysect(trials: Sequence[Trial]) -> list[Answer]:
    core: Any = module("raysect.core", "raysect")

    def answer(trial: Trial) -> Answer:
        world = core.World()
        _raysect_body(trial.body, world)
        rows = zip(trial.origins.tolist(), trial.directions.tolist(), strict=True)
        found = (world.hit(core.Ray(core.Point3D(*o), core.Vector3D(*d))) for o, d in rows)
        return Answer(np.array([np.inf if hit is None else hit.ray_distance for hit in found]))

    return [answer(trial) for trial in trials]


def _raysect_body(body: Body, world: Any) -> Any:
    core: Any = module("raysect.core", "raysect")
    primitive: Any = module("raysect.primitive", "raysect")
    if isinstance(body, Ball):
        return primitive.Sphere(body.radius, parent=world, transform=core.translate(*body.center))
    if isinstance(body, Block):
        return primitive.Box(core.Point3D(*body.low), core.Point3D(*body.high), parent=world)
    assert isinstance(body, Turned)
    frame, height = along_axis(body.start, body.end)
    kind = primitive.Cone if body.end_radius == 0 else primitive.Cylinder
    return kind(body.start_radius, height, parent=world, transform=core.AffineMatrix3D(frame.tolist()))


def with_trimesh(trials: Sequence[Trial]) -> list[Answer]:
    """Its answer is a point; t comes from the coordinate in which the direction is longest."""
    library: Any = module("trimesh", "trimesh")
    cube = library.creation.box(extents=(2, 2, 2))

    def answer(trial: Trial) -> Answer:
        assert isinstance(trial.body, Block)
        corners = np.where(cube.vertices < 0, trial.body.low, trial.body.high)
        mesh = library.Trimesh(corners, cube.faces, process=False)
        points, ray, _ = mesh.ray.intersects_location(trial.origins, trial.directions, multiple_hits=False)
        t = np.full(len(trial.origins), np.inf)
        along = np.argmax(np.abs(trial.directions[ray]), axis=1)
        row = np.arange(len(ray))
        t[ray] = (points[row, along] - trial.origins[ray, along]) / trial.directions[ray, along]
        return Answer(t)

    return [answer(trial) for trial in trials]


ALL = tuple(SHAPES)
CONICOID = Peer("Conicoid", "float64", lambda: f"Conicoid {metadata.version('conicoid')}")

SYSTEMS = (
    System(CONICOID, 53, 53, ALL, with_conicoid),
    System(raysect.PEER, 53, 53, ("sphere", "box", "cylinder", "cone"), with_raysect),
    System(mitsuba.PEER, 24, 24, ("sphere", "box", "cylinder"), mitsuba_bodies.trace),
    System(embree.PEER, 24, 24, ("sphere",), with_embree),
    System(
        trimesh.PEER, 24, 53, ("box",), with_trimesh
    ),  # Embree finds the triangle, trimesh meets its plane in float64
)
