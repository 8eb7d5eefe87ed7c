"""Raysect: nearest hits on spheres, double precision, one Python call for each ray, one core."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from .peer import Peer, distribution, module
from .scenes import Balls, Floats, Singles


def _version() -> str:
    version = distribution("raysect")
    module("raysect.core", "raysect")
    return f"Raysect {version}"


PEER = Peer("Raysect", "float64, one core", _version)


class RaysectScene:
    """Balls and rays (M, 3) as Raysect's objects; making the rays is not timed."""

    def __init__(self, balls: Balls, origins: Singles, directions: Singles) -> None:
        core: Any = module("raysect.core", "raysect")
        primitive: Any = module("raysect.primitive", "raysect")
        self.world = core.World()
        for center, radius in zip(balls.centers.tolist(), balls.radii.tolist(), strict=True):
            primitive.Sphere(radius, parent=self.world, transform=core.translate(*center))
        self.rays = [
            core.Ray(core.Point3D(*o), core.Vector3D(*d))
            for o, d in zip(origins.tolist(), directions.tolist(), strict=True)
        ]
        self.world.hit(self.rays[0])

    def first_hits(self) -> tuple[float, Floats]:
        """(seconds, t (M,), inf for a miss)."""
        hit, inf = self.world.hit, np.inf
        begin = time.perf_counter()
        t = [found.ray_distance if (found := hit(ray)) is not None else inf for ray in self.rays]
        return time.perf_counter() - begin, np.array(t)
