"""Random bodies: floats over the whole domain, or whole numbers under irrational angles, where walls are shared."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .items import SHEETS, Item, Step, clipped, combined
from .random_shapes import LEAST, MAKERS, MOST, FloatDraw, Random, WholeDraw, direction, floats, pick, random_shape

BLOCKS = ("Sphere", "Ellipsoid", "Box", "Cylinder", "Cone", "Polyhedron", "OneSheetHyperboloid", "EllipticParaboloid")
FLAT = ("Plane", "Disc", "Triangle", "Polygon", "CylinderPatch")
BOOLEANS = ("Union", "Intersection", "Difference", "Complement", "ClippedSheet", "NestedBooleans")
KINDS = (*MAKERS, *BOOLEANS)
SQUARED = (
    "EllipticParaboloid", "HyperbolicParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone",
    "EllipticCylinder", "HyperbolicCylinder", "Quadric", "DoubleCone", *BOOLEANS,
)  # fmt: skip
"""Kinds whose parameters are inverse squares of the size."""


def motion_of_floats(r: Random, size: float) -> tuple[Step, ...]:
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
    return item if stays or r.random() > share else replace(item, steps=motion_of_floats(r, item.size))


# --- Bodies of small whole numbers, under angles with irrational sines, and scenes in which they share walls and
# apexes


ANGLES = (15, 30, 45, 60, 75, 90, 105, 120, 165, 180, -15, -75, 270, 345)
AXES = (
    *((0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (1, -1, 0)),
    *((1, 1, 1), (1, 2, 2), (0, 1, -1), (2, 0, 1), (1, 2, 3)),
)
SOLIDS = tuple(sorted(set(MAKERS) - set(SHEETS) - {"Spheres"}))
PARTS = ("Sphere", "Ellipsoid", "Box", "Box", "Cylinder", "Cylinder", "Cone", "Polyhedron", "HalfSpace", "DoubleCone", "EllipticParaboloid", "OneSheetHyperboloid")  # fmt: skip


def axis(r: Random) -> tuple[float, ...]:
    return tuple(float(c) for c in pick(r, AXES))


def point(r: Random, reach: int = 2) -> tuple[float, ...]:
    return tuple(float(c) for c in r.integers(-reach, reach + 1, 3))


def turn(r: Random) -> Step:
    return ("rotate", axis(r), float(pick(r, ANGLES)))


def shear(r: Random) -> Step:
    rows = np.eye(4)
    i, j = r.choice(3, 2, replace=False)
    rows[i, j] = pick(r, (1.0, -1.0, 0.5, 2.0))
    rows[:3, 3] = r.integers(-1, 2, 3)
    return ("transform", tuple(tuple(row) for row in rows.tolist()))


def stretch(r: Random) -> Step:
    return (
        "scale",
        pick(
            r, ((1.0, -1.0, 1.0), (-1.0, 1.0, 1.0), (2.0, 1.0, 0.5), (1.0, 2.0, 1.0), (1.0, 3.0, -1.0), -1.0, 2.0, 0.5)
        ),
    )


def whole_motion(r: Random) -> tuple[Step, ...]:
    """Return a motion that keeps rational numbers rational."""
    makers: tuple[Callable[[Random], Step], ...] = (
        lambda r: ("translate", point(r)), shear, stretch, lambda r: ("rotate", pick(r, ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))), float(pick(r, (90, 180, -90)))),
    )  # fmt: skip
    return tuple(pick(r, makers)(r) for _ in range(r.integers(0, 3)))


def motion(r: Random) -> tuple[Step, ...]:
    """Return no motion, a rational one, or one with one turn or two."""
    sort = r.random()
    if sort < 0.2:
        return ()
    if sort < 0.4:
        return whole_motion(r)
    steps = [turn(r)] if sort < 0.85 else [turn(r), turn(r)]
    return (*whole_motion(r)[:1], *steps, *whole_motion(r)[:1])


def spelled(r: Random, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Return other steps that are the same in real numbers: turns in parts or the long way round, there and back again."""
    found: list[Step] = []
    for step in steps:
        if step[0] == "rotate":
            _, about, degrees = step
            part = float(pick(r, (7, 30, -45, 1, 100)))
            found += [("rotate", about, part), ("rotate", about, degrees - part)]
        else:
            found.append(step)
    if r.random() < 0.5:
        about, degrees = axis(r), float(r.integers(1, 180))
        found += [("rotate", about, degrees), ("rotate", about, -degrees)]
    return tuple(found)


def plain(r: Random, kind: str) -> Item:
    return random_shape(WholeDraw(r), kind)


def own_axis(item: Item) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return (point, direction) of the axis of revolution of an unmoved shape, if it has one by its numbers."""
    p = item.parameters
    if item.kind in ("Cylinder", "Cone") and p.get("reference") is None:
        return p["start"], tuple(b - a for a, b in zip(p["start"], p["end"], strict=True))
    if item.kind == "Sphere":
        return p["center"], (1.0, 2.0, 3.0)
    round_ = item.kind == "DoubleCone" or (item.kind in ("EllipticParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone", "EllipticCylinder") and p["A"] == p["E"])  # fmt: skip
    if round_:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    if item.kind == "Ellipsoid" and p["radii"][0] == p["radii"][1]:
        return p["center"], (0.0, 0.0, 1.0)
    return None


def turned_in_place(r: Random, item: Item) -> Item:
    """Return the shape turned about its own axis of revolution by any angle, the same in real numbers."""
    found = own_axis(item)
    if found is None or item.steps:
        return item
    center, about = found
    degrees = float(pick(r, (15, 105, 75, 45, 1, 37, 0.5, 1e-3, 33.3)))
    back = tuple(-c for c in center)
    steps: tuple[Step, ...] = (("rotate", about, degrees),)
    if any(center) and not all(a == 0 or b == 0 for a, b in zip(center, back, strict=True)):
        steps = (("translate", back), *steps, ("translate", center))
    return item.moved(*steps, paper=())


def single(r: Random, kind: str) -> Item:
    """Return one shape of a kind, moved."""
    item = plain(r, kind)
    if kind == "Spheres":
        return item
    if r.random() < 0.3:
        item = turned_in_place(r, item)
    steps = motion(r)
    if r.random() < 0.25:
        return item.moved(*spelled(r, steps), paper=steps)
    return item.moved(*steps)


def part(r: Random) -> Item:
    return single(r, str(pick(r, PARTS)))


def shared(r: Random) -> list[Item]:
    """Return some parts that share surfaces, edges or apexes: one shape shifted, turned in place or cut anew."""
    first = plain(r, str(pick(r, PARTS)))
    others = [turned_in_place(r, first)]
    shift = pick(r, ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 0.0)))
    others.append(first.moved(("translate", shift)))
    others.append(
        first.moved(
            pick(r, (("scale", (-1.0, 1.0, 1.0)), ("scale", (1.0, 1.0, -1.0)), ("rotate", (0.0, 0.0, 1.0), 90.0)))
        )
    )
    others.append(plain(r, str(pick(r, PARTS))))
    others.append(plain(r, "HalfSpace"))
    items = [first, *(pick(r, others) for _ in range(r.integers(1, 3)))]
    steps = motion(r)
    if r.random() < 0.5:
        return [item.moved(*spelled(r, steps), paper=steps) for item in items]
    return [item.moved(*steps) for item in items]


def half_spaces(r: Random) -> Item:
    """Return a Boolean of half-spaces through one point."""
    items = []
    for _ in range(r.integers(2, 5)):
        normal = point(r)
        normal = normal if any(normal) else (1.0, 0.0, 0.0)
        items.append(Item("HalfSpace", {"normal": normal, "offset": sum(normal)}))
    return joined(r, items)


def fan(r: Random, count: int) -> list[Item]:
    """Return half-spaces, cones and wedges through one point."""
    apex = point(r, 1)
    items = []
    for _ in range(count):
        sort = r.random()
        normal = point(r)
        while not any(normal):
            normal = point(r)
        if sort < 0.7:
            offset = sum(a * b for a, b in zip(normal, apex, strict=True))
            items.append(Item("HalfSpace", {"normal": normal, "offset": float(offset)}))
        elif sort < 0.85:
            items.append(Item("DoubleCone", {"slope": float(pick(r, (0.5, 1, 2)))}).moved(("translate", apex)))
        else:
            end = tuple(a + n for a, n in zip(apex, normal, strict=True))
            items.append(
                Item("Cone", {"start": apex, "end": end, "start_radius": 0.0, "end_radius": float(pick(r, (1, 2)))})
            )
    return items


def joined(r: Random, items: list[Item], depth: int = 0) -> Item:
    """Return a random Boolean of some items."""
    if len(items) == 1:
        return combined("Complement", items[0]) if r.random() < 0.25 else items[0]
    if depth < 2 and len(items) > 2:
        cut = int(r.integers(1, len(items)))
        items = [joined(r, items[:cut], depth + 1), joined(r, items[cut:], depth + 1)]
    body = combined(pick(r, ("Union", "Intersection", "Difference")), *items)
    return body.moved(turn(r)) if r.random() < 0.1 else body


def boolean(r: Random) -> Item:
    sort = r.random()
    if sort < 0.4:
        return joined(r, shared(r))
    if sort < 0.7:
        return joined(r, fan(r, int(r.integers(2, 5))))
    return joined(r, [part(r) for _ in range(r.integers(2, 4))])


def tree(r: Random, depth: int) -> Item:
    """Return a tree of at most some levels, each part moved by steps of its own. Here and there it has a part twice."""
    if depth == 0 or r.random() < 0.12:
        return plain(r, str(pick(r, PARTS))).moved(*whole_motion(r))
    kind = str(pick(r, ("Union", "Union", "Intersection", "Difference", "Complement")))
    parts = [tree(r, depth - 1) for _ in range(1 if kind == "Complement" else r.integers(2, 4))]
    again = [parts[0].moved(*whole_motion(r))] if len(parts) > 1 and r.random() < 0.2 else []
    return combined(kind, *parts, *again).moved(*whole_motion(r))


def cut_sheet(r: Random) -> Item:
    sheet, keep = plain(r, str(pick(r, FLAT))), str(pick(r, ("inside", "outside")))
    solid = pick(r, (part, boolean))(r)
    steps = motion(r)
    return clipped(sheet.moved(*steps) if r.random() < 0.5 else sheet, solid, keep)


def abutting(r: Random) -> list[Item]:
    """Return boxes that share walls, corners and edges, bodies in them, and a sheet between, all moved alike."""
    x, y = float(r.integers(-2, 1)), float(r.integers(-2, 1))
    low, high = (x, y, -1.0), (x + 1, y + 2, 1.0)
    items = [
        Item("Box", {"low": low, "high": high}),
        Item("Box", {"low": (x + 1, y, -1.0), "high": (x + 3, y + 2, 1.0)}),
        Item("Box", {"low": (x, y, 1.0), "high": (x + 1, y + 1, 2.0)}),
        Item("Cylinder", {"start": (x + 1, y + 1, -1.0), "end": (x + 1, y + 1, 1.0), "radius": 1.0}),
        Item("Plane", {"normal": (1.0, 0.0, 0.0), "offset": x + 1}),
        Item("Polygon", {"vertices": [(x + 1, y, -1.0), (x + 1, y + 2, -1.0), (x + 1, y + 2, 1.0), (x + 1, y, 1.0)]}),
        Item("Sphere", {"center": (x + 1, y + 1, 0.0), "radius": 1.0}),
    ]
    chosen = [items[i] for i in r.permutation(len(items))[: int(r.integers(2, 6))]]
    steps = motion(r)
    return [
        item.moved(*(spelled(r, steps)), paper=steps) if r.random() < 0.3 else item.moved(*steps) for item in chosen
    ]


def mixed(r: Random) -> list[Item]:
    """Return several bodies of any kind, one of them twice, in other words."""
    items = [single(r, str(pick(r, (*SOLIDS, *FLAT)))) for _ in range(r.integers(2, 5))]
    if r.random() < 0.5:
        items.append(boolean(r))
    again = pick(r, items)
    if again.kind != "Spheres" and again.paper is None:
        again = Item(again.kind, again.parameters, spelled(r, again.steps), again.operands, again.steps)
    return [*items, again]


CUBE = tuple(tuple(float(sign * (i == j)) for j in range(3)) for i in range(3) for sign in (-1, 1))


def in_other_words(r: Random) -> list[Item]:
    """Return one solid in several forms, perhaps a neighbour of it, each moved by steps that are equal in real numbers."""
    solids: tuple[tuple[Item, ...], ...] = (
        (
            Item("Sphere", {"radius": 1.0, "center": (0.0, 0.0, 0.0)}),
            Item("Ellipsoid", {"radii": (2.0, 2.0, 2.0), "center": (0.0, 0.0, 0.0)}).moved(("scale", 0.5)),
            Item("Quadric", {"coefficients": {"xx": 3.0, "yy": 3.0, "zz": 3.0, "constant": -3.0}}),
            combined("Complement", Item("Quadric", {"coefficients": {"xx": -1.0, "yy": -1.0, "zz": -1.0, "constant": 1.0}})),
        ),
        (
            Item("Box", {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)}),
            Item("Polyhedron", {"normals": list(CUBE), "offsets": [1.0] * 6}),
            combined("Intersection", *(Item("HalfSpace", {"normal": tuple(2 * c for c in n), "offset": 2.0}) for n in CUBE)),
            Item("Box", {"low": (0.0, 0.0, 0.0), "high": (1.0, 2.0, 0.5)}).moved(("scale", (2.0, 1.0, 4.0)), ("translate", (-1.0, -1.0, -1.0))),
        ),
        (
            Item("Cylinder", {"start": (0.0, 0.0, -1.0), "end": (0.0, 0.0, 1.0), "radius": 1.0}),
            Item("EllipticCylinder", {"A": 1.0, "E": 1.0, "z_range": (-1.0, 1.0)}),
            Item("Cone", {"start": (0.0, 0.0, 1.0), "end": (0.0, 0.0, -1.0), "start_radius": 1.0, "end_radius": 1.0}),
            combined("Intersection",
                Item("Quadric", {"coefficients": {"xx": 2.0, "yy": 2.0, "constant": -2.0}}),
                Item("Box", {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)}),
            ),
        ),
        (
            Item("DoubleCone", {"slope": 2.0, "z_range": (-1.0, 1.0)}),
            Item("EllipticCone", {"A": 1.0, "E": 1.0, "H": 4.0, "z_range": (-1.0, 1.0)}),
            combined("Union",
                Item("Cone", {"start": (0.0, 0.0, 0.0), "end": (0.0, 0.0, 1.0), "start_radius": 0.0, "end_radius": 2.0}),
                Item("Cone", {"start": (0.0, 0.0, -1.0), "end": (0.0, 0.0, 0.0), "start_radius": 2.0, "end_radius": 0.0}),
            ),
        ),
    )  # fmt: skip
    family, steps = pick(r, solids), motion(r)
    items = [pick(r, family) for _ in range(r.integers(2, 4))]
    moved = [item.moved(*spelled(r, steps), paper=steps) if r.random() < 0.6 else item.moved(*steps) for item in items]
    if r.random() < 0.4:
        moved.append(moved[0].moved(("translate", point(r, 1))))
    return moved if r.random() < 0.5 else [joined(r, moved)]


def decimal(r: Random) -> list[Item]:
    """Return shapes moved by decimals, which are no short binary fractions. Products take whole numbers of any length."""
    shift = tuple(float(c) / 10 for c in r.integers(-9, 10, 3))
    steps: tuple[Step, ...] = (
        ("translate", shift),
        pick(r, (("scale", 0.1), ("scale", (0.3, 1.0, -0.7)), ("scale", 3.0))),
    )
    item = plain(r, str(pick(r, (*PARTS, "Disc", "Polygon", "CylinderPatch"))))
    moved = item.moved(*steps, *((turn(r),) if r.random() < 0.5 else ()))
    return [moved, moved.moved(("translate", tuple(-c for c in shift)))]


def neighbours(r: Random) -> list[Item]:
    """Return a few shapes of any kind, the first again, one step further, and one of them twice."""
    items = [single(r, str(pick(r, (*SOLIDS, *FLAT)))) for _ in range(r.integers(2, 5))]
    return [*items, items[0].moved(("translate", (1.0, 0.0, 0.0))), pick(r, items)]


def crowd(r: Random) -> list[Item]:
    """Return forty solids and sheets on a lattice.

    Boxes of the tree end where rays run, and bodies touch and hold one another.
    """
    kinds = ("Sphere", "Ellipsoid", "Box", "Box", "Cylinder", "Cone", "Polyhedron", "Disc", "Triangle", "Polygon")
    return [plain(r, pick(r, kinds)).moved(*whole_motion(r), ("translate", point(r, 9))) for _ in range(40)]


SCENES: dict[str, Callable[[Random], list[Item]]] = {
    **{kind: (lambda r, kind=kind: [single(r, kind)]) for kind in sorted(MAKERS)},
    "Boolean": lambda r: [boolean(r)],
    "Fan": lambda r: [joined(r, fan(r, int(r.integers(2, 5)))) for _ in range(r.integers(1, 3))],
    "Planes": lambda r: [half_spaces(r) for _ in range(r.integers(1, 4))],
    "Complement": lambda r: [combined("Complement", part(r))],
    "Tree": lambda r: [tree(r, int(r.integers(2, 6)))],
    "Shared": lambda r: [joined(r, shared(r))],
    "Siblings": shared,
    "ClippedSheet": lambda r: [cut_sheet(r)],
    "InOtherWords": in_other_words,
    "Decimal": decimal,
    "Abutting": abutting,
    "Mixed": mixed,
    "Neighbours": neighbours,
    "Crowd": crowd,
}  # fmt: skip
