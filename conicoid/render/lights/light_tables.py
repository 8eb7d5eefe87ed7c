"""The tables of light in a scene: materials, lights and background, lamps as sources, and those of each integrator.

Point, spot and parallel lights are records; the first functions compute their light at a point.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline, record_shapes
from ..._util.arrays import matmul_rows
from ...geometry.body import Body
from ...geometry.bulk import Bulk, Spheres
from ...geometry.primitives import Cylinder, Sphere
from ...geometry.sheets import Disc, Polygon, Triangle
from ...kernels.numbers.elementary import acos
from ...kernels.numbers.vectors import dot
from ...kernels.tables import Floats, Ints
from ...materials.color import amount_rgb
from ...materials.light import (
    AmbientLight,
    Background,
    DirectionalLight,
    Environment as Image,
    Light,
    PointLight,
    SpotLight,
)
from ...materials.material import Material
from ...numerics.portable_math import hypot
from ..bsdf.albedo_tables import AlbedoTables
from ..bsdf.material_table import MaterialTable
from ..bsdf.registry import lower_albedos, lower_materials
from .environment import Colors, EnvironmentTable, lower_background, lower_environment, mean_radiance

LIGHT_RECORD = np.dtype(
    [
        ("parallel", "i8"),
        ("position", "f8", (3,)),
        ("axis", "f8", (3,)),
        ("intensity", "f8", (3,)),
        ("fades", "i8"),
        ("outer", "f8"),
        ("inner", "f8"),
    ],
    align=True,
)


def lower_lights(lights: Iterable[Light]) -> tuple[npt.NDArray[np.void], tuple[float, float, float]]:
    """Return (records of the lights that have a direction, the rgb sum of the ambient ones)."""
    items = list(lights)
    ambient = np.zeros(3)
    for light in items:
        if isinstance(light, AmbientLight):
            ambient += amount_rgb(light.intensity)
    directed = [light for light in items if not isinstance(light, AmbientLight)]
    records = np.zeros(len(directed), dtype=LIGHT_RECORD)
    for record, light in zip(records, directed, strict=True):
        _fill(record, light)
    return records, (float(ambient[0]), float(ambient[1]), float(ambient[2]))


def _fill(record: Any, light: DirectionalLight | PointLight | SpotLight) -> None:
    """Fill the record of a light; a light without a cone has angles of inf."""
    record["intensity"] = amount_rgb(light.intensity)
    record["outer"] = record["inner"] = math.inf
    if isinstance(light, DirectionalLight):
        record["parallel"], record["axis"] = 1, _unit(light.direction)
        return
    record["position"], record["fades"] = light.position, light.falloff == "inverse_square"
    if isinstance(light, SpotLight):
        record["axis"] = _unit(light.direction)
        record["outer"] = math.radians(light.angle)
        record["inner"] = math.radians(light.angle - light.soft_edge)


def _unit(direction: tuple[float, float, float]) -> tuple[float, ...]:
    """Return a direction at unit length; scaled first, so that no square overflows."""
    scaled = [component / max(map(abs, direction)) for component in direction]
    length = hypot(*scaled)
    return tuple(component / length for component in scaled)


@inline
def light_direction(light: Any, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return (lx, ly, lz, end): the ray from a point along l reaches the light at the parameter `end`."""
    if light.parallel == 1:
        return -light.axis[0], -light.axis[1], -light.axis[2], math.inf
    return light.position[0] - x, light.position[1] - y, light.position[2] - z, 1.0


@inline
def light_share(light: Any, lx: float, ly: float, lz: float, distance: float) -> float:
    """Return the share of the intensity that arrives along unit -l from a distance: by falloff and the spot's cone."""
    result = 1.0
    if light.fades == 1:
        result = 1.0 / (distance * distance)
    if light.outer < math.inf:
        cosine = -dot(lx, ly, lz, light.axis[0], light.axis[1], light.axis[2])
        angle = acos(min(1.0, max(-1.0, cosine)))
        if angle > light.outer:
            result = 0.0
        elif angle > light.inner:
            s = (light.outer - angle) / (light.outer - light.inner)
            result *= s * s * (3.0 - 2.0 * s)
    return result


# --- Tables of a scene


@record_shapes(lights="*")
class ShadingTables(NamedTuple):
    """Materials, lights, the ambient light and the background."""

    materials: MaterialTable
    lights: Annotated[npt.NDArray[np.void], LIGHT_RECORD]
    ambient: tuple[float, float, float]
    background: Colors


def lower_shading_tables(
    materials: Sequence[Material], sheets: Sequence[bool], item_of: Ints,
    lights: Iterable[Light], background: Background | None, paints: Mapping[int, Material],
) -> ShadingTables:  # fmt: skip
    """Return the shading tables of a scene.

    Parameters
    ----------
    materials, sheets
        The material of each entry, and whether the entry is a sheet.
    item_of
        The entry of each numbered body.
    lights, background
        Those of the scene; a background of None is the default one.
    paints
        The material of each face that has its own, by the row of the face.

    """
    records, ambient = lower_lights(lights)
    return ShadingTables(
        lower_materials(materials, sheets, item_of, paints), records, ambient, lower_background(background)
    )


# Polygons cut into triangles, by their ears (Meisters 1975)


def triangulate(loop: npt.NDArray[np.float64]) -> npt.NDArray[np.int64] | None:
    """Return the corners of triangles (n - 2, 3) by number, of a loop (n, 3); None if it crosses or touches itself."""
    points = _flat(loop)
    left, found = list(range(len(points))), []
    while len(left) > 3:
        # Every simple polygon has two ears (Meisters): without one the loop crosses itself
        ear = next((k for k in range(len(left)) if _is_ear(points, left, k)), None)
        if ear is None:
            return None
        found.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    found.append((left[0], left[1], left[2]))
    cut = np.array(found)
    areas = _area(points[cut[:, 0]], points[cut[:, 1]], points[cut[:, 2]])
    whole = abs(_loop_area(points))
    return cut if (areas >= 0).all() and abs(areas.sum() - whole) <= 1e-9 * whole else None


def _flat(loop: npt.NDArray[np.float64]) -> Any:
    """Return the loop (n, 2) in its plane, counter-clockwise."""
    spokes = loop - loop[0]
    normal = np.cross(spokes[1:-1], spokes[2:]).sum(axis=0)
    # Seen along the axis on which its area is largest
    axis = int(np.abs(normal).argmax())
    points = loop[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return points if normal[axis] > 0 else points * (1, -1)


def _area(a: Any, b: Any, c: Any) -> Any:
    """Return twice the signed areas of triangles, over 0 for those that turn left."""
    p, q = b - a, c - a
    return p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]


def _loop_area(points: Any) -> float:
    """Return twice the signed area of a loop."""
    following = np.roll(points, -1, axis=0)
    return float((points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]).sum())


def _is_ear(points: Any, left: list[int], k: int) -> bool:
    """Return whether the loop bulges at a corner, with no other corner within the triangle there."""
    a, b, c = (points[left[j % len(left)]] for j in (k - 1, k, k + 1))
    if _area(a, b, c) < 0:
        return False
    corners = {k % len(left), (k - 1) % len(left), (k + 1) % len(left)}
    others = points[[left[j] for j in range(len(left)) if j not in corners]]
    # A corner on a straight edge is cut off as a triangle without area
    if _area(a, b, c) == 0:
        return True
    inside = (_area(a, b, others) >= 0) & (_area(b, c, others) >= 0) & (_area(c, a, others) >= 0)
    return not bool(inside.any())


# The table of sources, from a scene's bodies, lights and background

DELTA_LIGHT, BALL, DISC, CYLINDER, POLYGON, SURROUNDINGS = 0, 1, 2, 3, 4, 5
"""Kinds of source. DELTA_LIGHT is a point, spot or parallel light; the shapes are lamps."""

SOURCE_RECORD = np.dtype(
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
"""index: of a light, or of the first triangle, of `count`. center: of a ball, a disc, a start cap, or of a polygon.
across, beside: unit vectors across the axis `along`. reach: the radius of a ball about the middle that holds the
source. until: the share of the power of all sources up to this one."""

TRIANGLE_STRIDE = 10  # numbers of a triangle: a corner, two edges, and the share of the area up to it
MOST_BALLS = 4096
"""Only paths find the light of longer lists of balls that glow."""


@record_shapes(records="*", source_of="*", triangles="*")
class LightSources(NamedTuple):
    """The sources that integrators sample light from."""

    records: Annotated[npt.NDArray[np.void], SOURCE_RECORD]
    source_of: Ints
    """The number of the source of each body, or -1; empty if no body is a source."""
    triangles: Floats


def lower_sources(bodies: Sequence[Body], item_of: Ints, look: ShadingTables, surroundings: float) -> LightSources:
    """Return the sources of a scene; surroundings: the mean radiance of an image around it, 0 without one."""
    found, triangles = _lamps(bodies, item_of, look)
    for k, light in enumerate(look.lights):
        record = _blank(DELTA_LIGHT, -1)
        record["index"] = k
        # A rough power is enough: it decides how often a source is sampled, not how bright it is
        record["power"] = math.pi * float(np.mean(light["intensity"])) * (4 * math.pi if light["fades"] else 1.0)
        found.append(record)
    if surroundings > 0:
        record = _blank(SURROUNDINGS, -1)
        record["power"] = math.pi * surroundings
        found.append(record)
    return _sources(found, triangles, len(item_of))


def _lamps(
    bodies: Sequence[Body], item_of: Ints, look: ShadingTables
) -> tuple[list[Any], list[npt.NDArray[np.float64]]]:
    """Return the records and triangles of the lamps."""
    found: list[Any] = []
    triangles: list[npt.NDArray[np.float64]] = []
    if _is_listed(bodies) and (look.materials.rows["emission"] > 0).any():
        firsts = np.searchsorted(item_of, np.arange(len(bodies) + 1))
        for entry in _glowing(bodies, firsts):
            found += _of_body(bodies[entry], int(firsts[entry]), triangles)
    return found, triangles


def _sources(found: list[Any], triangles: list[npt.NDArray[np.float64]], bodies: int) -> LightSources:
    """Return the tables of sources from their records; the lamps come first."""
    lamps = [int(record["body"]) for record in found if record["body"] >= 0]
    source_of = np.zeros(0, np.int32)
    if lamps:
        source_of = np.full(bodies, -1, np.int32)
        source_of[lamps] = np.arange(len(lamps), dtype=np.int32)
    records = np.array([record[()] for record in found], SOURCE_RECORD) if found else np.zeros(0, SOURCE_RECORD)
    total = records["power"].sum()
    records["until"] = np.cumsum(records["power"]) / total if total > 0 else np.arange(1, len(records) + 1)
    return LightSources(records, source_of, np.concatenate(triangles).ravel() if triangles else np.zeros(0))


def _is_listed(bodies: Any) -> bool:
    """Return whether bodies are a list of entries. Repeated bodies are not, and only paths find their light."""
    return isinstance(bodies, list | tuple)


def _glowing(bodies: Sequence[Body], firsts: Any) -> Iterable[int]:
    """Yield the entries that are opaque, glow on all faces, and are not painted."""
    for entry, body in enumerate(bodies):
        material = body.material
        if material is None or body.materials is not None or firsts[entry + 1] == firsts[entry]:
            continue
        if max(amount_rgb(material.emission)) > 0 and max(amount_rgb(material.transparency)) == 0:
            yield entry


def _blank(kind: int, body: int) -> Any:
    """Return a record of zeros but for its kind and body."""
    record = np.zeros((), SOURCE_RECORD)
    record["kind"], record["body"] = kind, body
    return record


def _of_body(body: Body, first: int, triangles: list[npt.NDArray[np.float64]]) -> list[Any]:
    """Return the sources of an entry: none if its shape is none of those that are sampled."""
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
    """Return the source of a shape, or None if the shape is not sampled."""
    if type(shape) in (Polygon, Triangle):
        return _polygon(shape, body, triangles)
    # A stretched ball is an ellipsoid, whose solid angle has no simple formula; paths find its light
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
    """Return the source of a polygon, cut into triangles; None for one that crosses itself."""
    loop = np.array(shape.vertices if isinstance(shape, Polygon) else (shape.a, shape.b, shape.c), float)
    cut = triangulate(loop)
    if cut is None:
        return None
    matrix = shape.under().matrix
    corners = matmul_rows(loop, matrix[:3, :3].T) + matrix[:3, 3]
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


# The tables of each integrator


class WhittedLight(NamedTuple):
    """The tables of Whitted's method, which sends rays to lamps from every point."""

    look: ShadingTables
    lamps: LightSources


def lower_lamplight(look: ShadingTables, bodies: Sequence[Body], item_of: Ints) -> WhittedLight:
    """Return Whitted's tables; item_of: the entry of each body."""
    return WhittedLight(look, _sources(*_lamps(bodies, item_of, look), len(item_of)))


class PathLight(NamedTuple):
    """The tables of light transport."""

    look: ShadingTables
    albedos: AlbedoTables
    sources: LightSources
    surroundings: EnvironmentTable
    shines: bool
    """Whether paths may find light by chance: a body glows, or the surroundings are not black."""


def lower_transport(
    look: ShadingTables, bodies: Sequence[Body], item_of: Ints, background: Background | None
) -> PathLight:
    """Return the tables of light transport; item_of: the entry of each body."""
    pixels = background.radiance if isinstance(background, Image) else None
    mean = 0.0 if pixels is None else mean_radiance(pixels)
    sources = lower_sources(bodies, item_of, look, mean)
    around_all = np.array([*look.background, look.ambient])
    shines = bool((look.materials.rows["emission"] > 0).any() or (around_all > 0).any() or mean > 0)
    return PathLight(look, lower_albedos(look.materials), sources, lower_environment(pixels), shines)
