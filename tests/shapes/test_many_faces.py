"""Polyhedra of many faces: bounds and rays against exact half-spaces, and rows against those of single faces."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.bounds.linear_program import integer_row, integer_support
from conicoid.geometry.polyhedron import MANY_FACES
from conicoid.io.openscad.solids import sided_ball
from conicoid.prepare import primitive_batch
from conicoid.prepare.lower_shape import compute_shape
from conicoid.prepare.motion_batch import MotionChains
from conicoid.prepare.primitive_batch import PrimitiveBatch

from ..samples import sampled
from .test_linear_program import corners

BALL = sided_ball(10.0, 16)


_TURNS = 2 * np.pi * np.arange(40) / 40
PRISM = co.Polyhedron(np.stack([np.cos(_TURNS), np.sin(_TURNS), 0 * _TURNS], axis=1).tolist(), [1.0] * 40)
"""It is unbounded along z, so that no end fixes the anchors of its faces."""


def rough(seed: int, count: int = 60) -> co.Polyhedron:
    """Return a polyhedron of random planes. Their numbers have few digits, so that many planes meet in a point."""
    rng = np.random.default_rng(seed)
    normals = rng.integers(-3, 4, (count, 3)).astype(float)
    normals = normals[normals.any(axis=1)]
    return co.Polyhedron(normals.tolist(), rng.integers(2, 9, len(normals)).astype(float).tolist())


SHAPES = {
    "ball": BALL,
    "moved": BALL.translate((1.1, 2, 3)),
    "turned": BALL.rotate((1, 2, 3), 25),
    "sheared": BALL.transform([[1, 0.4, 0, 1], [-0.3, 1, 0.2, 0], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]),
    "rough": rough(1),
    "rough, turned": rough(2).rotate((1, 0, 1), 90),
    "prism, moved": PRISM.translate((0.1, 0.2, 0.3)),
    "unbounded": co.Polyhedron([(1, 0.25 * k, 0.5) for k in range(MANY_FACES)], [3.0] * MANY_FACES),
}


def copies(solid: co.Solid) -> list[co.Solid]:
    """Return a solid that stands twice at one place, as GDML's daughters in their mothers do, and at others."""
    once = [solid, solid.translate((3, 0, 0)), solid.translate((0, 2, 1)), solid.rotate("z", 20), solid.rotate("z", 30)]
    return [*once, *once[:4]]


BATCHES = {name: [shape] for name, shape in SHAPES.items()} | {
    "extrusions": copies(co.Extrusion([(0, 0), (6, 0), (6, 2), (2, 2), (2, 5), (0, 5)])),
    "meshes": copies(
        co.Mesh([(0, 0, 0), (6, 1, 0), (1, 7, -2), (-2, 1, 8)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    ),
}


@pytest.mark.parametrize("name", BATCHES)
def test_faces_together_give_the_numbers_of_each(name: str):
    shapes, batch, found = BATCHES[name], PrimitiveBatch(), {}
    places = np.arange(7, 7 + len(shapes), dtype=np.int32)
    assert not len(batch.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), places))
    groups, left = batch.lower()
    for form, own, rows in groups:
        found |= {place: (form, rows[k : k + 1, : form.pattern.width][0]) for k, place in enumerate(own.tolist())}
    assert (left, sorted(found)) == ([], places.tolist())
    for (_, (form, row)), shape in zip(sorted(found.items()), shapes, strict=True):
        single = compute_shape(shape)
        assert (form.tree, form.pattern) == (single.tree, single.pattern)
        assert np.array_equal(row, single.row)


def test_a_flat_solid_that_stands_twice_at_one_place_is_lowered_once(noted_calls):
    counts = noted_calls(PrimitiveBatch, "_first_columns", lambda self, key, of, *rest: len(of))
    twice = BATCHES["extrusions"]
    for shapes in (twice[:5], twice):
        batch = PrimitiveBatch()
        batch.add(
            shapes, MotionChains([shape.motion.steps for shape in shapes]), np.arange(len(shapes), dtype=np.int32)
        )
        batch.lower()
    assert counts[: len(counts) // 2] == counts[len(counts) // 2 :]


@pytest.mark.parametrize(("axis", "degrees"), [("x", 90), ("x", 30), ((1, 2, 3), 25)])
def test_faces_of_a_turned_solid_are_recorded(axis, degrees, noted_calls):
    """Sources of OpenSCAD turn cylinders of a hundred sides. A face takes 10 µs from a recording, and 15 ms alone."""
    computed = noted_calls(primitive_batch, "compute_shape")
    quadrangles = [co.Extrusion([(0, 0), (1 + 0.1 * k, 0), (1, 1), (0, 0.7)]) for k in range(8)]
    for solids in ([PRISM], quadrangles):
        shapes = [solid.translate((0.1, 0.2, 0.3)).rotate(axis, degrees) for solid in solids]
        batch, places = PrimitiveBatch(), np.arange(len(shapes), dtype=np.int32)
        batch.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), places)
        batch.lower()
        assert len(computed) < 10  # most faces come from a recording
        computed.clear()


def test_a_prism_without_ends_equals_its_half_spaces():
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (5000, 3))
    x, y, _ = (points - (0.1, 0.2, 0.3)).T
    reach = (np.cos(_TURNS)[:, None] * x + np.sin(_TURNS)[:, None] * y).max(axis=0)
    found, sure = co.Scene([SHAPES["prism, moved"]]).contains(points), np.abs(reach - 1) > 1e-12
    assert np.array_equal(found[sure], reach[sure] < 1)
    assert 1000 < found.sum() < 4000


@pytest.mark.parametrize("name", ["ball", "rough", "unbounded"])
def test_bounds_are_those_of_all_half_spaces(name: str):
    shape = SHAPES[name]
    rows = [integer_row((*map(Fraction, n), Fraction(d))) for n, d in zip(shape.normals, shape.offsets, strict=True)]
    for axis in range(3):
        for sign, end in ((1, shape.bounds[1][axis]), (-1, -shape.bounds[0][axis])):
            direction = [Fraction(sign * (k == axis)) for k in range(3)]
            exact = integer_support(rows, direction)
            assert end >= exact
            assert end == math.inf or math.nextafter(end, -math.inf) < exact


@pytest.mark.parametrize("sides", [3, 4, 5, 8, 31])
def test_a_sided_ball_reaches_to_its_corners(sides: int):
    count = (sides + 1) // 2
    ball = sided_ball(2.0, sides)
    rings = [math.radians(180 * (k + 0.5) / count) for k in range(count)]
    corners = [
        (2 * math.sin(a) * math.cos(b), 2 * math.sin(a) * math.sin(b), 2 * math.cos(a))
        for a in rings for b in (math.tau * k / sides for k in range(sides))
    ]  # fmt: skip
    assert ball.bounds[0] == pytest.approx(np.min(corners, axis=0), abs=1e-14)
    assert ball.bounds[1] == pytest.approx(np.max(corners, axis=0), abs=1e-14)


# Polyhedra of few faces, many at once


def few(kind: str, rng: np.random.Generator) -> co.Polyhedron:
    """Return a bounded polyhedron: of any planes, of planes with few digits, or one that is empty or unbounded."""
    block = [*np.eye(3), *-np.eye(3)]
    if kind == "digits":
        normals = rng.integers(-2, 3, (6, 3)).astype(float)
        normals[~normals.any(axis=1)] = 1.0
        return co.Polyhedron([*block, *normals], [2.0] * 6 + rng.integers(1, 5, 6).astype(float).tolist())
    if kind == "pyramid":  # four planes in the tip, and some twice
        normals = [(1, 0, 1), (-1, 0, 1), (0, 1, 1), (0, -1, 1), (0, 0, -1), (0, 0, -1), (1, 1, 2), (2, 0, 2)]
        height = float(rng.uniform(0.1, 3))
        return co.Polyhedron(normals, [height] * 4 + [0.5, 0.5, 2 * height, 2 * height])
    if kind == "open":  # slabs, corners, and prisms without ends
        normals = [(1, 0, 0), (-2, 0, 0), rng.normal(size=3), (0.5, 1, 0), (-1, -1, 0), (0, 0, 1)]
        return co.Polyhedron([normals[k] for k in rng.permutation(6)[:4]], rng.uniform(0.5, 1.5, 4).tolist())
    offsets = rng.uniform(0.5, 1.5, 10)
    if kind == "odd":
        offsets[0], block = rng.choice([-3.0, 1.0]), block if rng.random() < 0.5 else [*block[:5], (1.0, 1.0, 1.0)]
    return co.Polyhedron([*block, *rng.normal(size=(4, 3))], offsets.tolist())


MOTIONS = {
    "still": lambda shape, rng: shape,
    "moved": lambda shape, rng: shape.translate(rng.uniform(-5, 5, 3)),
    "moved twice": lambda shape, rng: shape.translate(rng.uniform(-5, 5, 3)).translate((0.1, 0.2, 0.3)),
    "scaled": lambda shape, rng: shape.scale(rng.uniform(-2, 2, 3)).translate(rng.uniform(-5, 5, 3)),
    "upright": lambda shape, rng: shape.rotate("z", 90.0 * rng.integers(4)).translate((1, 2, float(rng.uniform()))),
    "turned": lambda shape, rng: shape.rotate(rng.normal(size=3), 37.5).translate(rng.uniform(-5, 5, 3)),
    "sheared": lambda shape, rng: shape.transform([*rng.uniform(-1, 1, (3, 4)), (0, 0, 0, 1)]),
}


@pytest.mark.parametrize(
    ("kind", "motion"), sampled(itertools.product(["any", "digits", "pyramid", "odd", "open"], MOTIONS), 3)
)
def test_polyhedra_together_have_the_numbers_and_the_boxes_of_each(kind: str, motion: str):
    rng = np.random.default_rng(5)
    shapes = [MOTIONS[motion](few(kind, rng), rng) for _ in range(8)]
    batch = PrimitiveBatch()
    batch.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), np.arange(8, dtype=np.int32))
    found, left = batch.lower()
    assert not left
    rows: dict[int, np.ndarray] = {}
    for form, places, table in found:
        rows |= {place: table[k, : form.pattern.width] for k, place in enumerate(places.tolist())}
    for place, shape in enumerate(shapes):
        again = co.Polyhedron(shape.normals, shape.offsets)._with_motion(
            shape.motion
        )  # without the results of the batch
        single = compute_shape(again)
        assert np.array_equal(rows[place], single.row)
        box = rows[place][single.pattern.bounds_at + 6 * len(single.pattern.leaves) :][:6]
        if kind in ("odd", "open") or motion not in ("still", "moved", "scaled", "sheared"):
            continue
        matrix = [[Fraction(x) for x in row] for row in np.eye(4)]
        for step in shape.motion.steps:  # floats, so that fractions carry the corners exactly
            own = getattr(step, "matrix", None)
            own = np.diag([*getattr(step, "factors", (1.0,) * 3), 1.0]) if own is None else np.array(own)
            own[:3, 3] += getattr(step, "offset", (0.0,) * 3)
            fractions = [[Fraction(x) for x in row] for row in own.tolist()]
            matrix = [
                [sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*matrix, strict=True)]
                for row in fractions
            ]
        moved = [
            [sum(m * x for m, x in zip(row, (*point, 1), strict=True)) for row in matrix[:3]]
            for point in corners(list(zip(shape.normals, shape.offsets, strict=True)))
        ]
        for axis, ends in enumerate(zip(*moved, strict=True)):
            assert box[axis] <= min(ends) <= box[axis] + 1e-12
            assert box[3 + axis] - 1e-12 <= max(ends) <= box[3 + axis]
