"""The walls of every shape by the formulas that docs/shapes.md and the docstrings state, in 50 digits of mpmath.

Nothing here is Conicoid's: a shape is read into plain values, of which some are changed by the names of parameters.
"""

from __future__ import annotations

import dataclasses
import re
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np

mp = mpmath.MPContext()
mp.dps = 50

_GONE = ("motion",)


def read(thing: Any) -> Any:
    """A shape, a step of a motion or a value, as plain values with numbers of mpmath."""
    if isinstance(thing, float):
        return mp.mpf(thing)
    if isinstance(thing, np.ndarray):
        return read(thing.tolist())
    if isinstance(thing, tuple | list):
        return [read(each) for each in thing]
    if isinstance(thing, dict):
        return {name: read(value) for name, value in thing.items()}
    if dataclasses.is_dataclass(thing):
        values = {field.name: read(getattr(thing, field.name)) for field in dataclasses.fields(thing)}
        made = SimpleNamespace(kind=type(thing).__name__, **values)
        if hasattr(made, "motion"):
            made.motion = made.motion.steps
        return made
    return thing


def parts(name: str) -> list[Any]:
    """The way to a number: "motion[0].offset[1]" is motion, 0, offset, 1."""
    return [int(part) if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", name)]


def holder(shape: Any, name: str) -> tuple[Any, Any]:
    """What holds a number, and under which key."""
    *way, last = parts(name)
    for part in way:
        if isinstance(shape, SimpleNamespace) and part == "operands" and not hasattr(shape, "operands"):
            shape = [shape.operand]
        else:
            shape = shape[part] if isinstance(shape, list | dict) else getattr(shape, part)
    return shape, last


def get(shape: Any, name: str) -> Any:
    owner, key = holder(shape, name)
    return getattr(owner, key) if isinstance(owner, SimpleNamespace) else owner[key]


def put(shape: Any, name: str, value: Any) -> None:
    owner, key = holder(shape, name)
    if isinstance(owner, SimpleNamespace):
        setattr(owner, key, value)
    else:
        owner[key] = value


# Vectors


def dot(a: Any, b: Any) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), mp.mpf(0))


def minus(a: Any, b: Any) -> Any:
    return [x - y for x, y in zip(a, b, strict=True)]


def cross(a: Any, b: Any) -> Any:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a: Any) -> Any:
    size = mp.sqrt(dot(a, a))
    return [x / size for x in a]


def turns(x: Any, y: Any) -> Any:
    return mp.atan2(y, x) / (2 * mp.pi) % 1


# Motions, backward


def back(steps: list[Any], x: Any) -> Any:
    for step in reversed(steps):
        x = _undone(step, x)
    return x


def _undone(step: Any, x: Any) -> Any:
    if step.kind == "Translate":
        return minus(x, step.offset)
    if step.kind == "Scale":
        return [a / k for a, k in zip(x, step.factors, strict=True)]
    if step.kind == "Rotate":
        k, angle = unit(step.axis), -step.degrees * mp.pi / 180
        s, c = mp.sin(angle), mp.cos(angle)
        along, aside = dot(k, x), cross(k, x)
        return [a * c + b * s + n * along * (1 - c) for a, b, n in zip(x, aside, k, strict=True)]
    if step.kind == "Back":
        return [dot(row[:3], x) + row[3] for row in step.rows]
    rows = step.matrix
    return solved([row[:3] for row in rows[:3]], [a - row[3] for a, row in zip(x, rows, strict=False)])


def solved(rows: Any, right: Any) -> Any:
    """x with rows x = right, by Cramer's rule."""
    a, b, c = rows
    columns = cross(b, c), cross(c, a), cross(a, b)
    size = dot(a, columns[0])
    return [sum(column[i] * value for column, value in zip(columns, right, strict=True)) / size for i in range(3)]


def undone(thing: Any) -> Any:
    """A shape whose motions are worked out backward, each as one affine map, so that points need no more than that."""
    if isinstance(thing, list):
        return [undone(each) for each in thing]
    if not isinstance(thing, SimpleNamespace):
        return thing
    made = SimpleNamespace(**{name: undone(value) for name, value in vars(thing).items() if name != "motion"})
    if hasattr(thing, "motion"):
        corners = [[mp.mpf(int(i == k)) for i in range(3)] for k in range(4)]
        *ends, origin = [back(thing.motion, corner) for corner in corners]
        rows = [[*(end[i] - origin[i] for end in ends), origin[i]] for i in range(3)]
        made.motion = [SimpleNamespace(kind="Back", rows=rows)] if thing.motion else []
    return made


# Frames


def least_of(axis: Any) -> int:
    """Where an axis is least; the first of those that are equal, but for a change that is to be a derivative."""
    return min(range(3), key=lambda i: round(float(abs(axis[i])), 12))


def axes(start: Any, axis: Any, reference: Any) -> Any:
    """x, y, z of the frame: z along the axis, x towards the reference, or the axis least along it."""
    z = unit(axis)
    if reference is None:
        least = least_of(axis)
        towards = [mp.mpf(int(i == least)) for i in range(3)]
    else:
        towards = minus(reference, start)
    x = unit(minus(towards, [dot(towards, z) * c for c in z]))
    return [x, cross(z, x), z]


def framed(start: Any, axis: Any, reference: Any, x: Any) -> Any:
    return [dot(row, minus(x, start)) for row in axes(start, axis, reference)]


# Shapes: (f, uv) at a point in the coordinates of the shape, uv None where that is not compared


def faces_of(shape: Any) -> int:
    """How many numbers of faces a primitive takes."""
    if shape.kind in ("Cylinder",):
        turn = shape.end_angle - shape.start_angle
        return 3 if turn == 360 else 4 if turn == 180 else 5
    counted = {"Box": 6, "Cone": 3}
    if shape.kind in counted:
        return counted[shape.kind]
    if shape.kind == "Polyhedron":
        return len(shape.offsets)
    if hasattr(shape, "z_range"):
        low, high = shape.z_range or (-mp.inf, mp.inf)
        return 3 if mp.isfinite(high) else 2 if mp.isfinite(low) else 1
    return 7 if getattr(shape, "within", None) is not None else 1


def wall(shape: Any, face: int, x: Any) -> tuple[Any, Any]:
    """(f, uv) of a face of a body at a point of the world."""
    if shape.kind == "ClippedSheet":
        return wall(shape.base, face, back(shape.motion, x))
    if hasattr(shape, "operands") or hasattr(shape, "operand"):
        x = back(shape.motion, x)
        for operand in getattr(shape, "operands", None) or [shape.operand]:
            count = all_faces(operand)
            if face < count:
                return wall(operand, face, x)
            face -= count
        raise AssertionError("no such face")
    return KINDS[shape.kind](shape, face, back(shape.motion, x))


def all_faces(shape: Any) -> int:
    operands = getattr(shape, "operands", None) or ([shape.operand] if hasattr(shape, "operand") else None)
    return faces_of(shape) if operands is None else sum(map(all_faces, operands))


def sphere(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    y = minus(x, s.center)
    return dot(y, y) - s.radius**2, (turns(y[0], y[1]), (y[2] / s.radius + 1) / 2)


def revolved(sx: Any, sy: Any, g: Any, extent: Any, z_range: Any, face: int, y: Any) -> tuple[Any, Any]:
    """sx x² + sy y² <= g(z) within a range."""
    if face:
        z = z_range[face - 1]
        sense = -1 if face == 1 else 1
        size = g(z)
        return sense * (y[2] - z), (y[0] * mp.sqrt(sx / size), y[1] * mp.sqrt(sy / size))
    low, high = z_range or (-mp.inf, mp.inf)
    low, high = max(low, extent[0]), min(high, extent[1])
    v = (y[2] - low) / (high - low) if mp.isfinite(high - low) else y[2]
    return sx * y[0] ** 2 + sy * y[1] ** 2 - g(y[2]), (turns(y[0], y[1]), v)


def ellipsoid(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    a, e, h = s.coefficients or [1 / r**2 for r in s.radii]
    top = 1 / mp.sqrt(h)
    return revolved(a, e, lambda z: 1 - h * z * z, (-top, top), s.z_range, face, minus(x, s.center))


def elliptic(name: str) -> Any:
    def found(s: Any, face: int, y: Any) -> tuple[Any, Any]:
        everywhere = (-mp.inf, mp.inf)
        one = mp.mpf(1)
        rules = {
            "DoubleCone": lambda: (one, one, lambda z: (s.slope * z) ** 2, everywhere),
            "EllipticParaboloid": lambda: (s.A, s.E, lambda z: z, (mp.mpf(0), mp.inf)),
            "OneSheetHyperboloid": lambda: (s.A, s.E, lambda z: 1 + s.H * z * z, everywhere),
            "TwoSheetHyperboloid": lambda: (s.A, s.E, lambda z: s.H * z * z - 1, everywhere),
            "EllipticCone": lambda: (s.A, s.E, lambda z: s.H * z * z, everywhere),
            "EllipticCylinder": lambda: (s.A, s.E, lambda z: one + 0 * z, everywhere),
        }
        sx, sy, g, extent = rules[name]()
        return revolved(sx, sy, g, extent, s.z_range, face, y)

    return found


def box(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    axis, up = divmod(face, 2)
    f = y[axis] - s.high[axis] if up else s.low[axis] - y[axis]
    others = [i for i in range(3) if i != axis]
    return f, tuple((y[i] - s.low[i]) / (s.high[i] - s.low[i]) for i in others)


def within(name: str) -> Any:
    def found(s: Any, face: int, y: Any) -> tuple[Any, Any]:
        if face:
            return box(s.within, face - 1, back(s.within.motion, y))
        rules = {
            "HyperbolicParaboloid": lambda: (s.A * y[0] ** 2 - s.E * y[1] ** 2 - y[2], (0, 1)),
            "HyperbolicCylinder": lambda: (s.A * y[0] ** 2 - s.E * y[1] ** 2 - 1, (1, 2)),
            "ParabolicCylinder": lambda: (y[0] ** 2 - 2 * s.G * y[1], (0, 2)),
        }
        f, along = rules[name]()
        if s.within is None:
            return f, tuple(y[i] for i in along)
        own = back(s.within.motion, y)
        low, high = s.within.low, s.within.high
        return f, tuple((own[i] - low[i]) / (high[i] - low[i]) for i in along)

    return found


def cylinder(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    axis = minus(s.end, s.start)
    length = mp.sqrt(dot(axis, axis))
    y = framed(s.start, axis, s.reference, x)
    if face == 0:
        return y[0] ** 2 + y[1] ** 2 - s.radius**2, (turns(y[0], y[1]), y[2] / length)
    if face < 3:
        return (y[2] - length if face == 2 else -y[2]), (y[0] / s.radius, y[1] / s.radius)
    angle = (s.start_angle if face == 3 else s.end_angle) * mp.pi / 180
    c, sine = mp.cos(angle), mp.sin(angle)
    return sine * y[0] - c * y[1], ((c * y[0] + sine * y[1]) / s.radius, y[2] / length)


def cone(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    axis = minus(s.end, s.start)
    length = mp.sqrt(dot(axis, axis))
    y = framed(s.start, axis, None, x)
    if face == 0:
        radius = s.start_radius + (s.end_radius - s.start_radius) * y[2] / length
        return y[0] ** 2 + y[1] ** 2 - radius**2, (turns(y[0], y[1]), y[2] / length)
    radius = s.start_radius if face == 1 else s.end_radius
    return (y[2] - length if face == 2 else -y[2]), (y[0] / radius, y[1] / radius)


def quadric(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    q = [[mp.mpf(0)] * 4 for _ in range(4)]
    if s.matrix is not None:
        q = [[(s.matrix[i][j] + s.matrix[j][i]) / 2 for j in range(4)] for i in range(4)]
    else:
        places = dict(xx=(0, 0), yy=(1, 1), zz=(2, 2), xy=(0, 1), yz=(1, 2), xz=(0, 2), x=(0, 3), y=(1, 3), z=(2, 3))
        for name, value in s.coefficients.items():
            i, j = places.get(name, (3, 3))
            q[i][j] += value / 2
            q[j][i] += value / 2
    p = [*x, mp.mpf(1)]
    second, first = [row[:3] for row in q[:3]], [row[3] for row in q[:3]]
    if not any(c for row in second for c in row):
        return plane_uv(first, -q[3][3] / 2, x)
    uv = None
    if abs(dot(second[0], cross(second[1], second[2]))) > mp.mpf(10) ** -6:
        center = solved(second, [-c for c in first])
        uv = (turns(x[0] - center[0], x[1] - center[1]), x[2] - center[2])
    return dot(p, [dot(row, p) for row in q]), uv


def plane_uv(normal: Any, offset: Any, x: Any) -> tuple[Any, Any]:
    n = unit(normal)
    foot = [c * offset / dot(normal, normal) for c in normal]
    least = least_of(n)
    towards = [mp.mpf(int(i == least)) for i in range(3)]
    u = unit(minus(towards, [dot(towards, n) * c for c in n]))
    away = minus(x, foot)
    return dot(normal, x) - offset, (dot(u, away), dot(cross(n, u), away))


def plane(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    return plane_uv(s.normal, s.offset, x)


def polyhedron(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    return dot(s.normals[face], x) - s.offsets[face], None


def disc(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    y = framed(s.center, s.normal, None, x)
    return y[2], (y[0] / s.radius, y[1] / s.radius)


def triangle(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    u, v, w = minus(s.b, s.a), minus(s.c, s.a), minus(x, s.a)
    n = cross(u, v)
    return dot(n, w), (dot(cross(w, v), n) / dot(n, n), dot(cross(u, w), n) / dot(n, n))


def polygon(s: Any, _: int, x: Any) -> tuple[Any, Any]:
    points = s.vertices
    pairs = list(zip(points, [*points[1:], points[0]], strict=True))
    n = [sum(cross(a, b)[i] for a, b in pairs) for i in range(3)]
    middle = [sum(point[i] for point in points) / len(points) for i in range(3)]
    edge = minus(points[1], points[0])
    across, away, square = cross(unit(n), edge), minus(x, points[0]), dot(edge, edge)
    return dot(n, minus(x, middle)), (dot(edge, away) / square, dot(across, away) / square)


# Conics of optics, about the vertex


def sag(radius: Any, conic: Any, r: Any) -> Any:
    """c r² / (1 + sqrt(1 - (1 + k) c² r²)); beyond the equator something real, which nobody asks for."""
    if not mp.isfinite(radius):
        return mp.mpf(0)
    return r * r / (radius * (1 + mp.sqrt(abs(1 - (1 + conic) * r * r / radius**2))))


def bent(radius: Any, conic: Any, semi: Any, edge: Any, y: Any) -> tuple[Any, Any]:
    """The curved part out to `semi`, or the plane where it is flat."""
    if not mp.isfinite(radius):
        return y[2], (y[0] / edge, y[1] / edge)
    f = y[0] ** 2 + y[1] ** 2 + (1 + conic) * y[2] ** 2 - 2 * radius * y[2]
    return f, (turns(y[0], y[1]), y[2] / sag(radius, conic, semi))


def conic(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    r = s.aperture / 2
    if face == 0:
        return bent(s.radius_of_curvature, s.conic_constant, r, r, y)
    return y[2] - sag(s.radius_of_curvature, s.conic_constant, r), (y[0] / r, y[1] / r)


def around(radius: Any, ends: Any, y: Any) -> tuple[Any, Any]:
    """A cylinder between two heights."""
    low, high = sorted(ends)
    return y[0] ** 2 + y[1] ** 2 - radius**2, (turns(y[0], y[1]), (y[2] - low) / (high - low) if low < high else y[2])


def lens(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    edge = s.diameter / 2
    semis = [(aperture or s.diameter) / 2 for aperture in (s.front_aperture, s.back_aperture)]
    walls = (s.front_radius, s.front_conic, semis[0]), (s.back_radius, s.back_conic, semis[1])
    heights = mp.mpf(0), s.thickness
    if face < 2:
        return bent(*walls[face], edge, [y[0], y[1], y[2] - heights[face]])
    rims = [height + sag(*one) for height, one in zip(heights, walls, strict=True)]
    if face > 2:
        return y[2] - rims[face - 3], (y[0] / edge, y[1] / edge)
    f, (u, v) = around(edge, rims, y)
    return f, (u, v if rims[0] < rims[1] else y[2])


def mirror(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    r = s.diameter / 2
    if face == 0:
        return bent(s.radius_of_curvature, s.conic_constant, r, r, y)
    if face == 1:
        return y[2] - s.thickness, (y[0] / r, y[1] / r)
    return around(r if face == 2 else s.hole / 2, (sag(s.radius_of_curvature, s.conic_constant, r), s.thickness), y)


# Outlines


def through(corners: Any, x: Any) -> tuple[Any, Any]:
    a, b, c = corners[:3]
    return dot(cross(minus(b, a), minus(c, a)), minus(x, a)), None


def mesh(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    return through([s.vertices[int(k)] for k in s.faces[face]], x)


def extrusion(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    low, high = s.z_range
    if face >= len(s.outline):
        return y[2] - (low if face == len(s.outline) else high), None
    (a, b), (c, d) = s.outline[face], s.outline[(face + 1) % len(s.outline)]
    return through([[a, b, low], [c, d, low], [(a + c) * s.scale_at_top / 2, (b + d) * s.scale_at_top / 2, high]], y)


def revolution(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    if face >= len(s.profile):
        angle = (s.start_angle if face == len(s.profile) else s.end_angle) * mp.pi / 180
        c, sine = mp.cos(angle), mp.sin(angle)
        widest, highest = max(r for r, _ in s.profile), max(abs(z) for _, z in s.profile)
        return sine * y[0] - c * y[1], ((c * y[0] + sine * y[1]) / widest, y[2] / highest)
    (r, z), (end, top) = s.profile[face], s.profile[(face + 1) % len(s.profile)]
    if abs(z - top) < mp.mpf(10) ** -9:
        widest = max(r, end)
        return y[2] - z, (y[0] / widest, y[1] / widest)
    radius = r + (end - r) * (y[2] - z) / (top - z)
    low, high = sorted((z, top))
    return y[0] ** 2 + y[1] ** 2 - radius**2, (turns(y[0], y[1]), (y[2] - low) / (high - low))


KINDS: dict[str, Any] = {
    "Conic": conic, "ConicSheet": conic, "Lens": lens, "Mirror": mirror, "Mesh": mesh, "Extrusion": extrusion,
    "Revolution": revolution,
    "Sphere": sphere, "Ellipsoid": ellipsoid, "Box": box, "Cylinder": cylinder, "CylinderPatch": cylinder, "Cone": cone,
    "Quadric": quadric, "HalfSpace": plane, "Plane": plane, "Polyhedron": polyhedron, "Disc": disc,
    "Triangle": triangle, "Polygon": polygon,
    **{name: elliptic(name) for name in (
        "DoubleCone", "EllipticParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone", "EllipticCylinder",
    )},
    **{name: within(name) for name in ("HyperbolicParaboloid", "HyperbolicCylinder", "ParabolicCylinder")},
}  # fmt: skip


# Hits


def crossing(shape: Any, face: int, o: Any, d: Any, t: Any) -> Any:
    """t of the crossing near a t, by Newton's method with one slope: an error e becomes of the order of e 1e-16."""

    def value(t: Any) -> Any:
        return wall(shape, face, [a + t * b for a, b in zip(o, d, strict=True)])[0]

    step = mp.mpf(10) ** -25
    f = value(t)
    rate = (value(t + step) - f) / step
    for _ in range(9):
        change = f / rate
        t -= change
        if abs(change) < mp.mpf(10) ** -40 * (1 + abs(t)):
            break
        f = value(t)
    else:
        raise AssertionError("no crossing nearby")
    return t


def fields(shape: Any, face: int, o: Any, d: Any, t: Any) -> tuple[Any, Any, Any, Any]:
    """(t, point, unit gradient, uv) of the crossing near a t.

    The gradient by differences forward: what they are off by, half a step times second derivatives, hardly changes.
    """
    shape = undone(shape)
    t = crossing(shape, face, o, d, t)
    x = [a + t * b for a, b in zip(o, d, strict=True)]
    step = mp.mpf(10) ** -16
    f, uv = wall(shape, face, x)
    ahead = (wall(shape, face, [c + step * (i == k) for k, c in enumerate(x)])[0] for i in range(3))
    return t, x, unit([(value - f) / step for value in ahead]), uv
