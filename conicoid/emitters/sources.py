"""The table of sources, from a scene's bodies, lights and background."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..compiler.shapes import shaped
from ..engine.tables import Floats, Ints
from ..shading.look import Look
from ..shapes.body import Body
from ..shapes.bulk import Bulk
from ..shapes.color import amount_rgb
from ..shapes.cylinder import Cylinder
from ..shapes.disc import Disc
from ..shapes.polygon import Polygon
from ..shapes.rounded import hypot
from ..shapes.row_vectors import product
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres
from ..shapes.triangle import Triangle
from .ears import triangles_of

LIGHT, BALL, DISC, CYLINDER, POLYGON, SURROUNDINGS = 0, 1, 2, 3, 4, 5
"""Kinds of source; a light is a `PointLight` and its like."""

RECORD = np.dtype(
    [
        ("kind", "i8"),
        ("body", "i8"),
        ("index", "i8"),
        ("count", "i8"),
        ("center", "f8", (3,)),
        ("across", "f8", (3,)),
        ("beside", "f8", (3,)),
        ("along", "f8", (3,)),
        ("radius", "f8"),
        ("length", "f8"),
        ("reach", "f8"),
        ("area", "f8"),
        ("radiance", "f8", (3,)),
        ("power", "f8"),
        ("until", "f8"),
    ],
    align=True,
)
"""index: of a light, or the first triangle, of `count`. center: of a ball, a disc, a start cap, or of a polygon.
across, beside: unit vectors across the axis `along`. reach: a ball about the middle that holds it. until: the share of
the power of all sources up to this one."""

TRIANGLE = 10  # a corner, two edges, and the share of the area up to it
MOST_BALLS = 4096
"""A longer list of balls that glow is found by paths alone."""


@shaped(records="*", source_of="*", triangles="*")
class Sources(NamedTuple):
    """All that light is asked from."""

    records: Annotated[npt.NDArray[np.void], RECORD]
    source_of: Ints
    """The source that each body is, or -1; empty where no body is one."""
    triangles: Floats


def lower_sources(bodies: Sequence[Body], item_of: Ints, look: Look, surroundings: float) -> Sources:
    """The sources of a scene; surroundings: mean radiance of an image around it, 0 for none that is asked."""
    found, triangles = _lamps(bodies, item_of, look)
    for k, light in enumerate(look.lights):
        record = _blank(LIGHT, -1)
        record["index"] = k
        record["power"] = math.pi * float(np.mean(light["intensity"])) * (4 * math.pi if light["fades"] else 1.0)
        found.append(record)
    if surroundings > 0:
        record = _blank(SURROUNDINGS, -1)
        record["power"] = math.pi * surroundings
        found.append(record)
    return _sources(found, triangles, len(item_of))


def lower_lamps(bodies: Sequence[Body], item_of: Ints, look: Look) -> Sources:
    """The lamps of a scene alone."""
    return _sources(*_lamps(bodies, item_of, look), len(item_of))


def _lamps(bodies: Sequence[Body], item_of: Ints, look: Look) -> tuple[list[Any], list[npt.NDArray[np.float64]]]:
    """Records and triangles of what glows and is drawn from."""
    found: list[Any] = []
    triangles: list[npt.NDArray[np.float64]] = []
    if _is_listed(bodies) and (look.materials.rows["emission"] > 0).any():
        firsts = np.searchsorted(item_of, np.arange(len(bodies) + 1))
        for entry in _glowing(bodies, firsts):
            found += _of_body(bodies[entry], int(firsts[entry]), triangles)
    return found, triangles


def _sources(found: list[Any], triangles: list[npt.NDArray[np.float64]], bodies: int) -> Sources:
    """The tables of sources, of which the lamps come first."""
    lamps = [int(record["body"]) for record in found if record["body"] >= 0]
    source_of = np.zeros(0, np.int32)
    if lamps:
        source_of = np.full(bodies, -1, np.int32)
        source_of[lamps] = np.arange(len(lamps), dtype=np.int32)
    records = np.array([record[()] for record in found], RECORD) if found else np.zeros(0, RECORD)
    total = records["power"].sum()
    records["until"] = np.cumsum(records["power"]) / total if total > 0 else np.arange(1, len(records) + 1)
    return Sources(records, source_of, np.concatenate(triangles).ravel() if triangles else np.zeros(0))


def _is_listed(bodies: Any) -> bool:
    """Are bodies a list of entries? What repeats is not, and glows for paths alone."""
    return isinstance(bodies, list | tuple)


def _glowing(bodies: Sequence[Body], firsts: Any) -> Iterable[int]:
    """Entries that are opaque, shine with all of their faces, and are not painted."""
    for entry, body in enumerate(bodies):
        material = body.material
        if material is None or body.materials is not None or firsts[entry + 1] == firsts[entry]:
            continue
        if max(amount_rgb(material.emission)) > 0 and max(amount_rgb(material.transparency)) == 0:
            yield entry


def _blank(kind: int, body: int) -> Any:
    record = np.zeros((), RECORD)
    record["kind"], record["body"] = kind, body
    return record


def _of_body(body: Body, first: int, triangles: list[npt.NDArray[np.float64]]) -> list[Any]:
    """The sources that an entry is: none where it is no shape that is drawn from."""
    shape, radiance = body.shape, amount_rgb(body.material.emission)
    if isinstance(shape, Bulk):
        if not isinstance(shape, Spheres) or len(shape) > MOST_BALLS:
            return []
        made = [(_of_shape(shape.single(k), first + k, triangles)) for k in range(len(shape))]
    else:
        made = [_of_shape(shape, first, triangles)]
    records = [record for record in made if record is not None]
    for record in records:
        record["radiance"] = radiance
        record["power"] = math.pi * float(np.mean(radiance)) * float(record["area"])
    return records


def _of_shape(shape: Any, body: int, triangles: list[npt.NDArray[np.float64]]) -> Any:
    """The source that a shape is, or None."""
    if type(shape) in (Polygon, Triangle):
        return _polygon(shape, body, triangles)
    if type(shape) not in (Sphere, Disc, Cylinder) or shape.motion.similarity is None:
        return None
    matrix, factor = shape.under().matrix, abs(float(shape.motion.similarity))
    center, axes = matrix[:3, 3], matrix[:3, :3] / factor
    if isinstance(shape, Cylinder) and shape.end_angle - shape.start_angle < 360:
        return None
    kind = BALL if isinstance(shape, Sphere) else DISC if isinstance(shape, Disc) else CYLINDER
    record = _blank(kind, body)
    radius = factor * float(shape.radius)
    record["center"], record["radius"] = center, radius
    record["across"], record["beside"], record["along"] = axes[:, 0], axes[:, 1], axes[:, 2]
    if isinstance(shape, Sphere):
        record["area"], record["reach"] = 4 * math.pi * radius**2, radius
    elif isinstance(shape, Disc):
        record["area"], record["reach"] = math.pi * radius**2, radius
    else:
        length = factor * shape.length
        record["length"], record["reach"] = length, hypot(radius, length / 2)
        record["area"] = 2 * math.pi * radius * (radius + length)
    return record


def _polygon(shape: Polygon | Triangle, body: int, triangles: list[npt.NDArray[np.float64]]) -> Any:
    """A polygon, cut into triangles; None for one that crosses itself."""
    loop = np.array(shape.vertices if isinstance(shape, Polygon) else (shape.a, shape.b, shape.c), float)
    cut = triangles_of(loop)
    if cut is None:
        return None
    matrix = shape.under().matrix
    corners = product(loop, matrix[:3, :3].T) + matrix[:3, 3]
    a, b, c = (corners[cut[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.sqrt((normals**2).sum(axis=1)) / 2
    rows = np.concatenate([a, b - a, c - a, (np.cumsum(areas) / areas.sum())[:, None]], axis=1)
    record = _blank(POLYGON, body)
    record["index"], record["count"] = sum(len(each) for each in triangles), len(rows)
    triangles.append(rows)
    record["area"], record["center"] = areas.sum(), corners.mean(axis=0)
    record["along"] = normals.sum(axis=0) / (2 * areas.sum())
    record["reach"] = np.sqrt(((corners - record["center"]) ** 2).sum(axis=1)).max()
    return record
