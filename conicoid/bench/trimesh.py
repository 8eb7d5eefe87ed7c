"""trimesh with Embree: nearest hits on boxes as meshes of twelve triangles, single precision."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from .peer import Absent, Peer, distribution, module
from .scenes import Boxes, Floats, Singles


def _version() -> str:
    version = distribution("trimesh")
    distribution("embreex")
    if not module("trimesh.ray", "trimesh").has_embree:
        raise Absent("trimesh finds no Embree: pip install embreex")
    return f"trimesh {version}"


PEER = Peer("trimesh", "Embree, float32, triangles", _version)


class TrimeshScene:
    """Boxes as one mesh, and rays (M, 3)."""

    def __init__(self, boxes: Boxes, origins: Singles, directions: Singles) -> None:
        library: Any = module("trimesh", "trimesh")
        block = library.creation.box(extents=(2, 2, 2))
        points = np.einsum("nij,nvj->nvi", boxes.turns, block.vertices[None] * boxes.halves[:, None])
        points += boxes.centers[:, None]
        faces = block.faces[None] + len(block.vertices) * np.arange(len(boxes.centers))[:, None, None]
        self.mesh = library.Trimesh(points.reshape(-1, 3), faces.reshape(-1, 3), process=False)
        self.origins, self.directions = origins.astype(float), directions.astype(float)
        self.seconds()

    def seconds(self) -> float:
        begin = time.perf_counter()
        self.mesh.ray.intersects_first(self.origins, self.directions)
        return time.perf_counter() - begin

    def distances(self) -> Floats:
        """t (M,), inf for a miss."""
        _, ray, points = self.mesh.ray.intersects_id(
            self.origins, self.directions, multiple_hits=False, return_locations=True
        )
        t = np.full(len(self.origins), np.inf)
        t[ray] = np.linalg.norm(points - self.origins[ray], axis=1)
        return t
