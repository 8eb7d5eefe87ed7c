"""Bodies lowered together have the bits of each alone: patterns, numbers, rounding bounds, boxes."""

import math
import random
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.general_quadric import COEFFICIENT_NAMES
from conicoid.prepare.batch_lowering import BatchLowering
from conicoid.prepare.csg_plan import csg_plan
from conicoid.prepare.lower_shape import compute_shape
from conicoid.prepare.tape import recordings

from ...samples import in_turn, many

# --- Bodies lowered together have the bits of each alone: patterns, numbers, rounding bounds, boxes


def number(rng: random.Random) -> float:
    return rng.uniform(-5, 5)


def point(rng: random.Random) -> Any:
    return number(rng), number(rng), number(rng)


def size(rng: random.Random) -> float:
    return abs(number(rng)) + 0.1


def on_grid(rng: random.Random) -> Any:
    return tuple(float(rng.randint(-2, 2)) for _ in range(3))


def _box(rng: random.Random, corner: Any) -> co.Box:
    return co.Box(corner, tuple(x + size(rng) for x in corner))


def _about_origin(rng: random.Random) -> co.Box:
    return co.Box((-size(rng), -0.5, -size(rng)), (size(rng), size(rng), size(rng)))


def _outline(rng: random.Random) -> Any:
    """Return a polygon about the origin, mostly concave."""
    turns = [(math.cos(1.25 * k), math.sin(1.25 * k), size(rng)) for k in range(5)]
    return [(radius * x, radius * y) for x, y, radius in turns]


_CORNERS = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
_QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def _warped_block(rng: random.Random) -> co.Mesh:
    """Return a block whose sides are not flat, of two triangles each. Its faces may be turned inside out."""
    corners = [tuple(x + 0.05 * number(rng) for x in corner) for corner in _CORNERS]
    order = rng.choice((1, -1))
    return co.Mesh(corners, [face[::order] for face in _QUADS])


KINDS = {
    "Sphere": lambda r: co.Sphere(size(r), point(r)),
    "Sphere on a grid": lambda r: co.Sphere(1.0, on_grid(r)),
    "Box": lambda r: _box(r, point(r)),
    "Box on a grid": lambda r: _box(r, on_grid(r)),
    "Cylinder": lambda r: co.Cylinder(point(r), point(r), size(r)),
    "upright Cylinder": lambda r: co.Cylinder((0, 0, 1), (0, 0, 1 + size(r)), size(r)),
    "wedge": lambda r: co.Cylinder(point(r), point(r), size(r), 10.0, 100.0 + number(r), reference=point(r)),
    "Cone": lambda r: co.Cone(point(r), point(r), size(r), size(r)),
    "pointed Cone": lambda r: co.Cone(point(r), point(r), 0.0, size(r)),
    "Ellipsoid": lambda r: co.Ellipsoid((size(r), size(r), size(r)), point(r)),
    "barrel": lambda r: co.Ellipsoid((size(r), size(r), 2.0), z_range=(-1.0, 1.0)),
    "EllipticCone": lambda r: co.EllipticCone(size(r), size(r), size(r), (-size(r), size(r))),
    "OneSheetHyperboloid": lambda r: co.OneSheetHyperboloid(size(r), size(r), size(r), (0.0, size(r))),
    "EllipticParaboloid": lambda r: co.EllipticParaboloid(size(r), size(r)),
    "HyperbolicParaboloid": lambda r: co.HyperbolicParaboloid(size(r), size(r), _about_origin(r)),
    "ParabolicCylinder": lambda r: co.ParabolicCylinder(size(r), _about_origin(r)),
    "Lens": lambda r: co.Lens(7 + number(r) / 3, -7 + number(r) / 3, thickness=1 + size(r) / 9, diameter=2.0),
    "Conic": lambda r: co.Conic(7 + number(r) / 3, number(r) / 3, 2.0),
    "Mirror": lambda r: co.Mirror(-9 + number(r) / 3, number(r) / 3, 2.0, size(r), 0.1),
    "Quadric": lambda r: co.Quadric(coefficients={name: number(r) for name in COEFFICIENT_NAMES}),
    "Quadric by a matrix": lambda r: co.Quadric([[number(r) for _ in range(4)] for _ in range(4)]),
    "Triangle": lambda r: co.Triangle(point(r), point(r), point(r)),
    "Disc": lambda r: co.Disc(point(r), point(r), size(r)),
    "HalfSpace": lambda r: co.HalfSpace(point(r), number(r)),
    "RegularPrism": lambda r: co.RegularPrism(6, size(r), (-size(r), size(r)), number(r)),
    "Wedge": lambda r: co.Wedge(size(r), size(r), size(r), edge_shift=number(r)),
    "part of a Polycone": lambda r: co.Polycone(
        [(-1.0, 0.1, 1 + size(r)), (0.0, 0.3, 1 + size(r)), (size(r), 0.0, size(r))], 10.0, 100 + number(r)
    ),
    "more than half a Revolution": lambda r: co.Revolution(
        [(0.5, 0.0), (0.5 + size(r), 0.1), (0.6, 1 + size(r))], number(r), 250 + number(r)
    ),
    "Extrusion": lambda r: co.Extrusion(_outline(r), (0.0, size(r))),
    "Extrusion to a scale": lambda r: co.Extrusion(_outline(r), (-size(r), 0.5), r.choice((0.0, 0.3, size(r)))),
    "Mesh": _warped_block,
    "Mesh on a grid": lambda r: co.Mesh(_CORNERS, _QUADS).scale(float(r.randint(1, 3))),
}  # fmt: skip
MOTIONS = {
    "still": lambda r: lambda s: s,
    "shifted": lambda r: lambda s: s.translate(point(r)),
    "turned": lambda r: lambda s: s.rotate(point(r), 180 * r.random()).translate(point(r)),
    "turned about an axis": lambda r: lambda s: s.rotate("z", r.choice((30, 45, 90, 17.5))).translate(on_grid(r)),
    "there and back": lambda r: lambda s: s.rotate("x", 30).translate((1, 2, 3)).rotate("x", -30),
    "mirrored": lambda r: lambda s: s.scale((-1.5, 1.5, 1.5)).rotate(point(r), 20),
    "stretched": lambda r: lambda s: s.scale((size(r), -1, 2)).rotate(point(r), 20),
    "sheared": lambda r: lambda s: s.transform(np.eye(4) + np.diag([size(r) / 9, 0.0], k=2)),
}
SOLIDS = {
    "cut": lambda r, a, b, c: a - b - c,
    "joined": lambda r, a, b, c: (a | b) - c,
    "common": lambda r, a, b, c: (a & b) - c,
    "nested": lambda r, a, b, c: (a - b.translate(point(r))).rotate(point(r), 30) | (c - a),
    "painted": lambda r, a, b, c: (a - b.painted("red")).painted("blue") | c.painted("green"),
    "outside": lambda r, a, b, c: ~(a | b) | c,
    "within an outside": lambda r, a, b, c: a & ~b & ~c,
}


def lowered_together(shapes: list[Any], room: int) -> dict[int, tuple[Any, list[float], dict[int, Any]]]:
    """Return (pattern, row, paints) of the bodies that were lowered together, by number."""
    bodies = BatchLowering()
    for number_, shape in enumerate(shapes):
        bodies.add(shape, number_)
    found, left = bodies.lower()
    assert len(left) + sum(len(group.bodies) for group in found) == len(shapes)
    assert len(left) <= room, [shape for shape, _ in left][:3]
    return {
        int(k): (group.pattern, row.tolist(), bodies.paints.get(int(k), {}))
        for group in found
        for k, row in zip(group.bodies, group.rows[:, :], strict=True)
    }


def check(shapes: list[Any], room: int) -> None:
    """Compare bodies with each alone; a fast run compares some of them."""
    found = list(lowered_together(shapes, room).items())
    for number_, (pattern, row, paints) in found[:: many(3, 1)]:
        alone = compute_shape(shapes[number_])
        assert pattern == alone.pattern
        assert [x.hex() for x in row] == [float(x).hex() for x in alone.row], shapes[number_]
        assert paints == alone.paints


MOST = [
    "Sphere", "Box", "Cylinder", "Cone", "Ellipsoid", "Triangle", "Disc", "RegularPrism", "part of a Polycone", "barrel",
    "EllipticCone", "OneSheetHyperboloid", "EllipticParaboloid", "HyperbolicParaboloid", "Conic", "Mirror", "Quadric",
]  # fmt: skip


@pytest.mark.parametrize(("kind", "motion"), in_turn(MOST, ["still", "shifted", "turned", "stretched"]))
def test_most_are_lowered_together(kind, motion):
    """Of plain bodies, only kinds with too few members are lowered one by one."""
    rng = random.Random(f"most {kind} {motion}")
    lowered_together([MOTIONS[motion](rng)(KINDS[kind](rng)) for _ in range(120)], 30)


@pytest.mark.parametrize(
    ("built", "motion"),
    in_turn(SOLIDS, ("still", "turned", "stretched")),
)
def test_booleans(built, motion):
    rng = random.Random(f"{built} {motion}")
    kinds = [rng.choice(("Sphere", "Box", "Cylinder", "Ellipsoid")) for _ in range(3)]
    shapes = [MOTIONS[motion](rng)(SOLIDS[built](rng, *(KINDS[kind](rng) for kind in kinds))) for _ in range(14)]
    check(shapes, len(shapes))


@pytest.mark.parametrize("seed", range(4))
def test_bounds_of_balls_and_boxes_in_common(seed):
    """The balls and boxes may or may not reach their ends. On a grid poles touch faces, and parts may be disjoint."""
    rng = random.Random(seed)
    shapes: list[Any] = []
    for _ in range(40):
        on = seed % 2 == 0
        ball = co.Sphere(rng.choice((1.0, 2.0)) if on else size(rng), on_grid(rng) if on else point(rng))
        other = co.Sphere(2.0, on_grid(rng)) if rng.random() < 0.3 else _box(rng, on_grid(rng) if on else point(rng))
        solid = (ball & other) - co.Cylinder((0, 0, -9), (0, 0, 9), 0.1)
        shapes.append(solid.scale((size(rng), 2, -1)).translate(point(rng)) if seed > 1 else solid.rotate("y", 90))
    check(shapes, len(shapes))


def test_blocks_cut_from_balls_have_the_bounds_of_the_blocks():
    block = co.Sphere(1) & co.Box((-0.7, -0.7, -0.7), (0.7, 0.7, 0.7))
    shapes = [block.scale(0.5 + k).translate((k, 2 * k, 0.1)) for k in range(20)]
    bodies = BatchLowering()
    for number_, shape in enumerate(shapes):
        bodies.add(shape, number_)
    found, left = bodies.lower()
    assert len(left) <= 5  # numbers that are exactly halfway between two floats are left open
    for group in found:
        for number_, row in zip(group.bodies.tolist(), group.rows[:, :], strict=True):
            low, high = shapes[number_].bounds
            assert row[group.pattern.box_at : group.pattern.box_at + 6].tolist() == [*low, *high]
            assert high[0] == pytest.approx(number_ + 0.7 * (0.5 + number_), rel=1e-15)


def test_cylinders_turned_about_themselves_are_lowered_together():
    """The ends stay exact floats, though no entry of the matrix is a float. Half of the axes miss the origin."""
    rng = random.Random(3)
    shapes: list[Any] = []
    for _ in range(40):
        start, axis = [rng.randint(1, 512) / 64 for _ in range(3)], [rng.randint(1, 512) / 64 for _ in range(3)]
        end = [a + b for a, b in zip(start, axis, strict=True)]
        back = [-x for x in start]
        shapes.append(co.Cylinder((0, 0, 0), axis, size(rng)).rotate(axis, 180 * rng.random()).translate(point(rng)))
        shapes.append(co.Cylinder(start, end, 1).translate(back).rotate(axis, 180 * rng.random()).translate(start))
    check(shapes, 0)


def test_some_booleans_are_lowered_together():
    rng = random.Random(8)
    solids = [co.Box((0, 0, 0), (2, 2, size(rng))) - co.Sphere(size(rng)) - KINDS["Cylinder"](rng) for _ in range(100)]
    lowered_together([solid.rotate(point(rng), 20) for solid in solids], 20)


def test_one_body_of_many_primitives_is_composed_of_their_rows():
    """The rows compose the body even where a kind has too few members for a recording: quadrics by named coefficients."""
    rng = random.Random(9)
    quadrics = [co.Quadric(coefficients={"xx": size(rng), "yy": size(rng), "xy": 0.1, "constant": -1.0})] * 3
    parts = [*(KINDS["Cone"](rng) for _ in range(20)), *quadrics]
    parts = [MOTIONS["turned"](rng)(part) for part in parts]
    check([co.Difference((co.Box((-9, -9, -9), (9, 9, 9)), *parts))], 0)


def test_a_plan_has_leaves_from_left_to_right_with_all_that_moves_them():
    a, b, c = co.Sphere(1), co.Box().rotate("x", 5), co.Sphere(2)
    plan = csg_plan(((a - b).translate((1, 0, 0)) | c).scale(2))
    assert [leaf for leaf, _ in plan.leaves] == [a, b, c]
    assert [len(steps) for _, steps in plan.leaves] == [2, 3, 1]


def test_few_of_a_kind_are_not_worth_a_recording(monkeypatch):
    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    bodies = BatchLowering()
    for number_ in range(recordings.FEWEST - 1):
        bodies.add(co.Sphere(1, (number_, 0, 0)), number_)
    found, left = bodies.lower()
    assert not found
    assert len(left) == recordings.FEWEST - 1


@pytest.mark.parametrize("kind", ["Cylinder", "Cone", "Disc"])
def test_one_recording_serves_every_direction_and_growth(kind, monkeypatch, noted_calls):
    """x lies towards the coordinate axis with the least component of the axis, and a cone grows or shrinks.

    Neither is a test of the recording.
    """
    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    programs = noted_calls(recordings.TapeProgram, "of")
    rng = random.Random(f"all directions {kind}")
    check([KINDS[kind](rng) for _ in range(60)], 0)
    assert len(programs) == 1


def test_a_body_that_cannot_be_recorded_leaves_the_others_of_its_kind(monkeypatch):
    """The support of a body needs the digits of a radius of 2, which the first body of the first call has."""
    support = co.Sphere.support

    def by_digits(self, direction):
        return support(self, direction) if not 1.5 < self.radius < 2.5 else math.frexp(self.radius)[0] * 4.0

    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    monkeypatch.setattr(co.Sphere, "support", by_digits)
    for _ in range(2):
        lowered_together([co.Sphere(2.0), *(co.Sphere(3.0, (k, 0, 0)) for k in range(30))], 1)
    shapes = [co.Sphere(2.0, (k, 0, 0)) for k in range(30)]
    assert lowered_together(shapes, 30) == {}
    assert len(lowered_together([*shapes, *(co.Sphere(3.0, (k, 0, 0)) for k in range(30))], 30)) == 30


def test_unrecordable_shapes_are_lowered_alone(monkeypatch):
    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    monkeypatch.setattr(co.Sphere, "support", lambda self, _: math.frexp(self.radius)[0] * 64.0)
    shapes = [co.Sphere(1.0 + k) for k in range(20)]
    assert lowered_together(shapes, 20) == {}
    scene = co.Scene(shapes)
    assert scene.first_hit((0, 0, 29), (0, 0, -1)).t == 9.0


@pytest.mark.parametrize(("built", "motion"), in_turn(SOLIDS, ("still", "shifted", "turned", "stretched")))
def test_booleans_of_polyhedra(built, motion):
    """Polyhedra, bounded or not, are lowered together, and so are the Booleans of them."""
    rng = random.Random(f"{built} {motion} planes")
    shared = co.Polyhedron([(1.0, 0, 0), (0.5, 1.0, 0), (-1.0, -1.0, 0.25)], [1.0, 2.0, 3.0])
    shapes = []
    for _ in range(8):
        own = co.Polyhedron([point(rng) for _ in range(4)], [size(rng) for _ in range(4)])
        parts = [own, KINDS["Sphere"](rng), shared]
        rng.shuffle(parts)
        shapes.append(MOTIONS[motion](rng)(SOLIDS[built](rng, *parts)))
    check([shape for shape in shapes for _ in range(4)], 0)


def test_threads_may_record_at_once(monkeypatch):
    from concurrent.futures import ThreadPoolExecutor

    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    rng = random.Random(2)
    shapes = [KINDS["Cylinder"](rng) for _ in range(60)]

    def rows(_: int) -> list[Any]:
        scene = co.Scene(shapes)
        return [scene._prepared.lowered.tables.whole_quadrics().tobytes(), scene._prepared.lowered.boxes.tobytes()]

    with ThreadPoolExecutor(4) as pool:
        first, *others = pool.map(rows, range(4))
    assert all(other == first for other in others)


def test_a_shape_that_goes_by_the_types_of_its_numbers_is_not_recorded(monkeypatch):
    """The shape branches on the types of its numbers.

    A recorded number would take another branch, so the recording is compared with the body alone.
    """
    tree = co.Sphere.tree

    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    monkeypatch.setattr(
        co.Sphere, "tree", lambda self: tree(self if isinstance(self.radius, float) else co.Sphere(7.0))
    )
    assert lowered_together([co.Sphere(2.0, (k, 0, 0)) for k in range(20)], 20) == {}


# --- Tubes, parts of balls, polycones and flat solids, lowered together: to the bit as each alone


def turn(rng: random.Random) -> tuple[float, float]:
    """Return one angle after another: multiples of 15 such as 30 and 90, other angles, and some of half a turn."""
    first = rng.choice((0.0, 30.0, 90.0, 180 * rng.random()))
    return first, first + rng.choice((90.0, 180.0, 200.0, 1.0 + 350 * rng.random()))


def polar(rng: random.Random) -> tuple[float, float]:
    low = rng.choice((0.0, 30.0, 90 * rng.random()))
    return low, rng.choice((90.5, 150.0, 180.0, 180 - low, 91 + 80 * rng.random()))


def ranges(rng: random.Random) -> tuple[float, float]:
    low = number(rng)
    return low, low + size(rng)


ANGULAR_KINDS = {
    "Tube": lambda r: co.Tube(point(r), point(r), 0.25, 0.5 + size(r)),
    "part of a Tube": lambda r: co.Tube(point(r), point(r), 0.25, 0.5 + size(r), *turn(r), point(r)),
    "part of a Cone": lambda r: co.Cone(point(r), point(r), size(r), size(r), *turn(r), point(r)),
    "part of a pointed Cone": lambda r: co.Cone(point(r), point(r), size(r), 0.0, *turn(r), point(r)),
    "shell": lambda r: co.SphereSection(1 + size(r), size(r) / 6, center=point(r)),
    "polar range": lambda r: co.SphereSection(1 + size(r), 0.5, polar(r), center=point(r)),
    "both ranges": lambda r: co.SphereSection(size(r), 0.0, polar(r), *turn(r)),
    "Polycone": lambda r: co.Polycone([(-1, size(r) / 6, 1 + size(r)), (number(r) / 9, 0, size(r)), (1, 0.5, 2)]),
    "part of a Polycone": lambda r: co.Polycone([(-6, 0, size(r)), (number(r), 0.05, size(r)), (6, 0.05, 2)], *turn(r)),
    "Trapezoid": lambda r: co.Trapezoid((size(r), size(r)), (size(r), size(r)), ranges(r), (number(r), number(r))),
    "pointed Trapezoid": lambda r: co.Trapezoid((size(r), size(r)), (0, 0), ranges(r), (number(r), number(r))),
    "Wedge": lambda r: co.Wedge(size(r), size(r), size(r), size(r), number(r)),
    "RegularPrism": lambda r: co.RegularPrism(6, size(r), ranges(r), rng_angle(r)),
    "prism by its sides": lambda r: co.RegularPrism(5, size(r), ranges(r), rng_angle(r), "sides"),
    "Pyramid": lambda r: co.Pyramid(4, size(r), ranges(r), r.choice((0.0, size(r))), rng_angle(r)),
    "Parallelepiped": lambda r: co.Parallelepiped(point(r), point(r), point(r), point(r)),
}  # fmt: skip


def rng_angle(rng: random.Random) -> float:
    return rng.choice((0.0, 30.0, 45.0, 720 * rng.random() - 360))


@pytest.mark.parametrize(("kind", "motion"), in_turn({**KINDS, **ANGULAR_KINDS}, MOTIONS))
def test_each_body_of_a_batch_equals_the_body_alone(kind, motion):
    rng = random.Random(f"{kind} {motion}")
    check([MOTIONS[motion](rng)({**KINDS, **ANGULAR_KINDS}[kind](rng)) for _ in range(16)], 16)


UPRIGHT = {
    "Wedge": lambda r: co.Wedge(size(r), size(r), size(r)),
    "RegularPrism": lambda r: co.RegularPrism(6, size(r), (0.0, size(r)), 30.0),
    "Quadric of one mixed term": lambda r: co.Quadric(
        coefficients=dict(xx=size(r), yy=2 + size(r), zz=4 + size(r), xy=0.1 * size(r), constant=-1.0)
    ),
    **{kind: ANGULAR_KINDS[kind] for kind in ("Tube", "shell", "polar range", "Polycone")},
}


@pytest.mark.parametrize("kind", UPRIGHT)
def test_their_formulas_are_recorded(kind):
    """Their formulas do not depend on digits of their numbers, so that most of one kind are lowered together."""
    rng = random.Random(f"most {kind}")
    found = lowered_together([UPRIGHT[kind](rng).translate(point(rng)) for _ in range(120)], 120)
    assert len(found) >= 90


@pytest.mark.parametrize("built", SOLIDS)
def test_booleans_of_parts_of_several_cells(built):
    """Numbers that no face has share a row of the map, but not with another primitive."""
    rng = random.Random(built)
    parts = [ANGULAR_KINDS[kind] for kind in ("Tube", "part of a Tube", "polar range")]
    shapes = [MOTIONS["turned"](rng)(SOLIDS[built](rng, *(part(rng) for part in parts))) for _ in range(12)]
    check(shapes, 12)
