"""Random solids, sheets and Booleans over the whole documented domain, with random motions."""

from dataclasses import replace

import numpy as np

from .items import Item, Step, clipped, combined
from .random_shapes import LEAST, MAKERS, MOST, FloatDraw, Random, direction, floats, pick, random_shape

BLOCKS = ("Sphere", "Ellipsoid", "Box", "Cylinder", "Cone", "Polyhedron", "OneSheetHyperboloid", "EllipticParaboloid")
FLAT = ("Plane", "Disc", "Triangle", "Polygon", "CylinderPatch")
BOOLEANS = ("Union", "Intersection", "Difference", "Complement", "ClippedSheet", "NestedBooleans")
KINDS = (*MAKERS, *BOOLEANS)
SQUARED = (
    "EllipticParaboloid", "HyperbolicParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone",
    "EllipticCylinder", "HyperbolicCylinder", "Quadric", "DoubleCone", *BOOLEANS,
)  # fmt: skip
"""Kinds whose parameters are inverse squares of the size."""


def motion(r: Random, size: float) -> tuple[Step, ...]:
    """Return one to three steps."""
    steps: list[Step] = []
    for _ in range(r.integers(1, 4)):
        verb = pick(r, ("translate", "rotate", "turn", "scale", "stretch", "transform"))
        if verb == "translate":
            steps.append((verb, floats(direction(r) * size * 10 ** r.uniform(-1, 1.5))))
        elif verb == "rotate":
            steps.append((verb, floats(direction(r)), float(r.uniform(-360, 360))))
        elif verb == "turn":
            steps.append(("rotate", floats(np.eye(3)[r.integers(3)]), float(90 * r.integers(1, 4))))
        elif verb == "scale":
            steps.append((verb, float(r.choice([-1, 1]) * 2 ** r.uniform(-2, 2))))
        elif verb == "stretch":
            steps.append(("scale", floats(r.choice([-1, 1], 3) * 2 ** r.uniform(-1, 1, 3))))
        else:
            matrix = np.eye(4)
            matrix[:3, :3] += r.uniform(-0.4, 0.4, (3, 3))
            matrix[:3, 3] = direction(r) * size
            steps.append((verb, [floats(row) for row in matrix]))
    return tuple(steps)


def still(kind: str, r: Random, size: float) -> Item:
    if kind in MAKERS:
        return random_shape(FloatDraw(r, size), kind)
    if kind == "ClippedSheet":
        sheet = still(pick(r, FLAT), r, size)
        sheet = sheet.moved(("translate", floats(-np.array(sheet.center))))
        return clipped(sheet, block(r, size, 0.1), pick(r, ("inside", "outside")), size=2 * size)
    if kind == "NestedBooleans":
        parts = [still(pick(r, BOOLEANS[:3]), r, size) for _ in range(2)]
        if r.random() < 0.4:
            parts[1] = combined("Complement", parts[1], size=parts[1].size)
        return combined(pick(r, BOOLEANS[:3]), *parts, size=max(part.size for part in parts))
    count = 1 if kind == "Complement" else pick(r, (2, 2, 2, 3))
    blocks = [
        block(r, size, r.uniform(0.2, 0.5) if k and kind == "Difference" else r.uniform(0, 0.25)) for k in range(count)
    ]
    return combined(kind, *blocks, size=max(size, *(part.size for part in blocks)) * 3)


def block(r: Random, size: float, away: float) -> Item:
    """Return a bounded solid near the origin."""
    found = still(pick(r, BLOCKS), r, size)
    while not found.bounded:
        found = still(found.kind, r, size)
    found = found.moved(("translate", floats(-np.array(found.center) + direction(r) * size * away)))
    return found.moved(("rotate", floats(direction(r)), float(r.uniform(0, 360)))) if r.random() < 0.5 else found


def ordinary(kind: str, r: Random) -> Item:
    """Return a shape of scale 1e-6 to 1e6, moved in three cases of five."""
    return _moved(still(kind, r, float(10 ** r.uniform(-6, 6))), r, 0.6)


def extreme(kind: str, r: Random) -> Item:
    """Return sizes from 1e-92 to 1e92, or from 1e-45 to 1e45 where parameters are inverse squares."""
    most = 45.0 if kind in SQUARED else 92.0
    while True:
        found = _moved(still(kind, r, float(10 ** (r.choice([-1, 1]) * r.uniform(most / 2, most)))), r, 0.4)
        if all(x == 0 or LEAST <= abs(x) <= MOST for x in found.numbers()):
            return found


def _moved(item: Item, r: Random, share: float) -> Item:
    """Return the shape moved. Bulk spheres stay, because a motion rounds their centers and radii, and so do far shapes."""
    stays = item.kind == "Spheres" or np.linalg.norm(item.center) > 40 * item.size
    return item if stays or r.random() > share else replace(item, steps=motion(r, item.size))
