"""The walls of every shape by the formulas that docs/shapes.md and the docstrings state, in 50 digits of mpmath."""

from __future__ import annotations

from typing import Any

from .plain import back, cross, dot, framed, least_of, minus, mp, solved, turns, undone, unit
from .turned import conic, extrusion, lens, mesh, mirror, revolution

# Shapes: (f, uv) at a point in the coordinates of the shape, uv None where that is not compared


def faces_of(shape: Any) -> int:
    """How many numbers of faces a primitive takes."""
    if shape.kind in ("Cylinder", "Cone"):
        turn = shape.end_angle - shape.start_angle
        return 3 if turn == 360 else 4 if turn == 180 else 5
    counted = {"Box": 6}
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
    return wedge_wall(s, face, y, s.radius, length)


def wedge_wall(s: Any, face: int, y: Any, radius: Any, length: Any) -> tuple[Any, Any]:
    angle = (s.start_angle if face == 3 else s.end_angle) * mp.pi / 180
    c, sine = mp.cos(angle), mp.sin(angle)
    return sine * y[0] - c * y[1], ((c * y[0] + sine * y[1]) / radius, y[2] / length)


def cone(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    axis = minus(s.end, s.start)
    length = mp.sqrt(dot(axis, axis))
    y = framed(s.start, axis, s.reference, x)
    if face > 2:
        return wedge_wall(s, face, y, max(s.start_radius, s.end_radius), length)
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
