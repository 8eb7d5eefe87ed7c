"""Bounds of solids that cut one another: closed forms, and random cuts against points that are inside."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.polyhedron import Polyhedron
from conicoid.geometry.primitives import Box, Cone, Cylinder, HalfSpace, Sphere
from conicoid.geometry.quadrics import (
    DoubleCone,
    Ellipsoid,
    EllipticCylinder,
    EllipticParaboloid,
    HyperbolicCylinder,
    HyperbolicParaboloid,
    OneSheetHyperboloid,
    ParabolicCylinder,
    TwoSheetHyperboloid,
)
from conicoid.geometry.shape import Solid, region_bounds
from conicoid.geometry.transform import IDENTITY_MOTION
from conicoid.prepare.csg_plan import placed_primitives

from ..reference.forms import PAIRS, chain
from ..reference.items import Item, combined
from ..reference.numbers import number
from ..reference.quadratics import Table
from ..reference.random_shapes import Random, generator, pick
from ..reference.solids import bodies
from ..reference.trace import body_at, truth
from ..reference.whole_items import SOLIDS, motion, plain, whole_motion
from ..samples import in_turn
from .evaluate import contains
from .motions import climb, random_motion

# --- Bounds of solids that cut one another: closed forms, and random cuts against points that are inside


INF = math.inf
R2, R3, H3 = math.sqrt(2), math.sqrt(3), math.sqrt(3) / 2
C30, S30 = H3, 0.5


def below(z: float) -> HalfSpace:
    return HalfSpace((0, 0, 1), z)


def above(z: float) -> HalfSpace:
    return HalfSpace((0, 0, -1), -z)


def intersection(*parts: Solid) -> Solid:
    result = parts[0]
    for part in parts[1:]:
        result = result & part
    return result


CUBE = intersection(*(HalfSpace(tuple(s * (i == k) for k in range(3)), 1) for i in range(3) for s in (1, -1)))
PRISM = intersection(
    above(0), below(2), *(HalfSpace((math.cos(math.pi * k / 3), math.sin(math.pi * k / 3), 0), 1) for k in range(6))
)
SADDLE = HyperbolicParaboloid(1, 1)

KNOWN = {
    # Half-spaces alone
    "prism": (PRISM, (-1, -2 / R3, 0), (1, 2 / R3, 2)),
    "turned cube": (CUBE.rotate((0, 0, 1), 30), (-C30 - S30, -C30 - S30, -1), (C30 + S30, C30 + S30, 1)),
    "complement of their union": (~(~HalfSpace((1, 1, 0), 1) | HalfSpace((1, 0, 0), 0) | HalfSpace((0, 1, 0), 0)
                                    | below(-1) | above(2)), (0, 0, -1), (1, 1, 2)),
    "corner cut off": (Box((0, 0, 0), (1, 1, 1)) & HalfSpace((1, 1, 1), 0.5), (0, 0, 0), (0.5, 0.5, 0.5)),
    "wedge of two planes": (HalfSpace((1, 1, 0), 1) & HalfSpace((-1, 1, 0), 1), (-INF, -INF, -INF), (INF, 1, INF)),
    "two polyhedra": (Polyhedron(((1, 1, 0), (-1, -1, 0)), (1, 1)) & Polyhedron(((1, -1, 0), (-1, 1, 0)), (1, 1)),
                      (-1, -1, -INF), (1, 1, INF)),
    # A ball
    "cap": (Sphere() & above(0.5), (-H3, -H3, 0.5), (H3, H3, 1)),
    "ball without its cap": (Sphere() - below(0.5), (-H3, -H3, 0.5), (H3, H3, 1)),
    "ball with a flat": (Sphere() - above(0.5), (-1, -1, -1), (1, 1, 0.5)),
    "far cap": (Sphere(1, (1e6, 0, 0)) & above(0.5), (1e6 - H3, -H3, 0.5), (1e6 + H3, H3, 1)),
    "oblique half": (Sphere() & HalfSpace((1, 0, 1), 0), (-1, -1, -1), (1 / R2, 1, 1 / R2)),
    "oblique halves": (Sphere() & HalfSpace((1, 0, 1), 0) & HalfSpace((-1, 0, 1), 0), (-1 / R2, -1, -1), (1 / R2, 1, 0)),
    "needle eye": (Sphere() & HalfSpace((1, 0, 0), 0) & HalfSpace((-1, 0, 0), 0), (0, -1, -1), (0, 1, 1)),
    "lens": (Sphere() & Sphere(1, (1, 0, 0)), (0, -1, -1), (1, 1, 1)),
    "thin lens": (Sphere() & Sphere(1, (1.6, 0, 0)), (0.6, -0.8, -0.8), (1, 0.8, 0.8)),
    "ball beyond a plane": (Sphere() & above(1.5), (INF,) * 3, (-INF,) * 3),
    "ball outside of a corner": (Sphere() & intersection(*(HalfSpace(tuple(-1.0 * (i == k) for k in range(3)), -0.6)
                                                            for i in range(3))), (INF,) * 3, (-INF,) * 3),
    # x² + y² <= 1 and x + z <= 0 ...: the ellipse of the cut
    "slanted cylinder": (EllipticCylinder(1, 1) & HalfSpace((-1, 0, 1), 0) & HalfSpace((-1, 0, -1), 0),
                         (0, -1, -1), (1, 1, 1)),
    "quadric outside": (~Quadric(coefficients=dict(xx=-1, yy=-1, zz=1, constant=-1)) & above(0) & below(2),
                        (-R3, -R3, 1), (R3, R3, 2)),
    # The other quadrics between planes
    "paraboloid": (EllipticParaboloid(1, 2) & below(1.5), (-math.sqrt(1.5), -H3, 0), (math.sqrt(1.5), H3, 1.5)),
    # x² <= z <= x + 2 for -1 <= x <= 2; y² <= x + 2 - x² is largest at x = 1/2
    "slanted paraboloid": (EllipticParaboloid(1, 1) & HalfSpace((-1, 0, 1), 2), (-1, -1.5, 0), (2, 1.5, 4)),
    "quarter paraboloid": (EllipticParaboloid(1, 1) & HalfSpace((-1, 0, 0), 0), (0, -INF, 0), (INF, INF, INF)),
    "tower": (OneSheetHyperboloid(1, 4, 1) & above(-1) & below(R3), (-2, -1, -1), (2, 1, R3)),
    "bow tie": (DoubleCone(2) & above(-1) & below(3), (-6, -6, -1), (6, 6, 3)),
    "one nappe": (DoubleCone(2) & above(0), (-INF, -INF, 0), (INF, INF, INF)),
    # x² <= z², 2 z <= x + 3: the ellipse from x = -1, z = 1 to x = z = 3; its half-axis across is sqrt(3)
    "slanted cone": (DoubleCone(1) & above(0) & HalfSpace((-1, 0, 2), 3), (-1, -R3, 0), (3, R3, 3)),
    "bowls": (TwoSheetHyperboloid(1, 1, 4) & above(-2) & below(1),
              (-math.sqrt(15), -math.sqrt(15), -2), (math.sqrt(15), math.sqrt(15), 1)),
    "no bowl": (TwoSheetHyperboloid(1, 1, 4) & above(-0.4) & below(0.4), (INF,) * 3, (-INF,) * 3),
    # x² <= z + y² <= 1 + 4 and z >= -4
    "saddle": (SADDLE & below(1) & HalfSpace((0, 1, 0), 2) & HalfSpace((0, -1, 0), 2),
               (-math.sqrt(5), -2, -4), (math.sqrt(5), 2, 1)),
    "open saddle": (SADDLE & below(1), (-INF, -INF, -INF), (INF, INF, 1)),
    "half cylinder": (EllipticCylinder(1, 1) & HalfSpace((1, 0, 0), -0.5), (-1, -H3, -INF), (-0.5, H3, INF)),
    "half cylinder with an end": (EllipticCylinder(1, 1) & HalfSpace((1, 0, 0), -0.5) & above(3),
                                  (-1, -H3, 3), (-0.5, H3, INF)),
    "waist": (HyperbolicCylinder(1, 1) & HalfSpace((0, 1, 0), 1) & HalfSpace((0, -1, 0), 2),
              (-math.sqrt(5), -2, -INF), (math.sqrt(5), 1, INF)),
    "trough": (ParabolicCylinder(2) & HalfSpace((0, 1, 0), 4), (-4, 0, -INF), (4, 4, INF)),
    # Complements, differences and unions
    "POV-Ray 128": (EllipticParaboloid(1, 1) & Cylinder((0, 0, -1), (0, 0, 2), 5), (-R2, -R2, 0), (R2, R2, 2)),
    "POV-Ray 128, narrow": (EllipticParaboloid(1, 1) & Cylinder((0, 0, -1), (0, 0, 4), 1), (-1, -1, 0), (1, 1, 4)),
    "POV-Ray 315": (Sphere() - EllipticCylinder(4, 4), (-1, -1, -1), (1, 1, 1)),
    "De Morgan": (~(~Sphere() | below(0.5)), (-H3, -H3, 0.5), (H3, H3, 1)),
    "union cut": ((Sphere() | Sphere(1, (3, 0, 0))) & above(0.5), (-H3, -H3, 0.5), (3 + H3, H3, 1)),
    "cut union": ((Sphere() | Sphere(1, (3, 0, 0)) | Box((9, 9, -9), (10, 10, -8))) - below(0.5),
                  (-H3, -H3, 0.5), (3 + H3, H3, 1)),
    "nested": ((Sphere() & (above(0.5) | above(0.8))) - (HalfSpace((1, 0, 0), 0) & above(-2)), (0, -1, 0.5), (1, 1, 1)),
    "cone in a ball": (DoubleCone(0.5) & Sphere(), (-0.5, -0.5, -1), (0.5, 0.5, 1)),
    "box without a box": (Box() - Box((0, -2, -2), (2, 2, 2)), (-1, -1, -1), (1, 1, 1)),
    "wedge over a half turn": (Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 270, (1, 0, 0)) & HalfSpace((-1, 0, 0), -1),
                               (1, -R3, 0), (2, R3, 1)),
    "cut cone": (Cone((0, 0, 0), (0, 0, 4), 2, 0) & above(1), (-1.5, -1.5, 1), (1.5, 1.5, 4)),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_bounds_are_the_known_ones(name: str) -> None:
    shape, low, high = KNOWN[name]
    for found, expected, sign in zip(shape.bounds, (low, high), (-1, 1), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-12)
        # Never on the inner side, but for the rounding of the expected value itself
        ends = [(f, e) for f, e in zip(found, expected, strict=True) if math.isfinite(e)]
        assert all(sign * (f - e) >= -1e-15 * (1 + abs(e)) for f, e in ends)


@pytest.mark.parametrize("scale", [1e-90, 1e-9, 1e9, 1e90])
def test_bounds_scale_with_the_solid(scale: float) -> None:
    cap = Sphere(scale) & HalfSpace((0, 0, -1), -scale / 2)
    cup = EllipticParaboloid(1 / scale, 2 / scale) & HalfSpace((0, 0, 1), 1.5 * scale)
    for shape, name in ((cap, "cap"), (cup, "paraboloid")):
        for found, expected in zip(shape.bounds, KNOWN[name][1:], strict=True):
            np.testing.assert_allclose(found / scale, expected, rtol=1e-11, atol=1e-12)


CONVEX = [
    Sphere(1.2),
    Ellipsoid((1, 2, 0.5)),
    EllipticParaboloid(1, 3),
    EllipticCylinder(1, 4),
    ParabolicCylinder(0.5),
]
OTHERS = [
    OneSheetHyperboloid(1, 2, 3),
    TwoSheetHyperboloid(1, 2, 3),
    DoubleCone(0.7),
    SADDLE,
    HyperbolicCylinder(1, 4),
    Quadric(coefficients=dict(xx=1, yy=-1, xy=0.5, z=1, x=0.3, constant=0.1)),
]


@pytest.mark.parametrize(
    ("quadric", "seed"),
    in_turn(CONVEX + OTHERS, range(3)),
    ids=lambda value: value if isinstance(value, int) else type(value).__name__,
)
def test_random_cuts_hold_the_solid_and_touch_it(quadric, seed: int) -> None:
    """Points that climb along each axis stay within the bounds; on convex solids they reach them."""
    rng = np.random.default_rng([seed, 7])
    normals = rng.normal(size=(rng.integers(1, 7), 3))
    offsets = rng.uniform(0.2, 1.5, len(normals))
    planes = [HalfSpace(tuple(n), d) for n, d in zip(normals.tolist(), offsets.tolist(), strict=True)]
    motion = random_motion(rng)
    low, high = intersection(quadric, *planes).bounds_under(motion)
    parts = [quadric.tree(), *(plane.tree() for plane in planes)]

    def inside(points):
        return np.all([contains(part, points, IDENTITY_MOTION) for part in parts], axis=0)

    points = rng.normal(size=(20000, 3)) * 10 ** rng.uniform(-1, 1, (20000, 1))
    points = points[inside(points)]
    assert len(points) > 100
    for axis in range(3):
        for sign, end in ((1, high[axis]), (-1, -low[axis])):
            direction, shift = sign * motion.matrix[axis, :3], sign * motion.matrix[axis, 3]
            reached = climb(inside, direction, points, rng, 250 if math.isfinite(end) else 60) @ direction + shift
            assert reached <= end + 1e-13 * (abs(reached) + 1)
            if quadric in CONVEX and math.isfinite(end):
                assert end - reached <= 1e-6 * (1 + abs(end))
            if quadric in CONVEX and math.isinf(end):
                assert reached > 30


def test_thousands_of_holes_and_deep_trees_stay_quick() -> None:
    """A limit on what is asked, not a timing: both would take minutes if every candidate were tried."""
    started = time.process_time()
    plate = Box((0, 0, 0), (100, 100, 1))
    for k in range(2000):
        plate = plate - Cylinder((k % 50, k // 50, -1), (k % 50, k // 50, 2), 0.3)
    assert [end.tolist() for end in plate.bounds] == [[0, 0, 0], [100, 100, 1]]
    body: Solid = Sphere()
    for k in range(300):
        body = Sphere(1 + k / 300) - (body & HalfSpace((1, k, 0), k))
    low, high = body.bounds
    assert (low >= -2).all()
    assert (high <= 2).all()
    facets = [HalfSpace((math.cos(k), math.sin(k), math.cos(7 * k)), 1.5) for k in range(60)]
    low, high = intersection(Sphere(), *facets).bounds
    assert (low >= -1).all()
    assert (high <= 1).all()
    assert time.process_time() - started < 30


# --- Boxes around what balls and boxes have in common: against the closed form of a lens, and alike alone and together


@pytest.mark.parametrize("reach", [0.25, 1.0, 1.5])
def test_a_turned_lens(reach: float) -> None:
    """A ball of radius 2 about the origin, and one of radius 3 beside it along x, turned about z and x.

    The second ends at x = reach; the box of both cuts the first there: across x it reaches sqrt(4 - reach²), where the
    second ball is wide enough.
    """
    lens = (co.Sphere(2) & co.Sphere(3, (reach - 3, 0, 0))).rotate("x", 40)
    low, high = lens.bounds
    assert (low[0], high[0]) == pytest.approx((-2, reach), abs=1e-11)
    assert high[0] >= reach
    second = math.sqrt(9 - max(0.0, -2 - (reach - 3)) ** 2)
    assert high[1] == pytest.approx(min(2.0, second), rel=1e-11)


# --- Bounds of pairs of quadrics under motions: they exist, and hold points that are inside for certain


FAST, DEEP = 30, 120


def test_a_residue_is_no_height() -> None:
    # Above the bowl z >= 0, on paper and in floats
    low, high = (co.EllipticParaboloid(2, 0.5) & co.DoubleCone(1.5)).scale((1, 2, 0.5)).bounds
    assert low.tolist() == [-math.inf, -math.inf, 0]
    assert (high == math.inf).all()
    bow = co.HyperbolicParaboloid(2, 0.5) & co.DoubleCone(0.5, (0, 2))
    low, high = bow.rotate((1, 2, 3), 15).bounds
    # The apex, where all of it ends
    assert low[2] == 0
    assert np.isfinite([low, high]).all()
    # The same without a turn: z <= 2 and x² + y² <= z² / 4
    np.testing.assert_allclose(bow.bounds, [(-1, -1, 0), (1, 1, 2)], rtol=1e-9)


@pytest.mark.parametrize("residue", [5e-324, 1e-300, 1e-100, 1e-17])
def test_a_plane_beside_the_vertex_costs_no_digits(residue: float) -> None:
    """As a box's side may stand there; the bowl x² + y² <= z, z <= 4 is 2 wide."""
    from conicoid.geometry.bounds.quadric_extent import cut_quadric_bounds
    from conicoid.geometry.surface import PlaneSurface, QuadricSurface

    bowl = QuadricSurface((1.0, 1.0, 0.0), (0.0, 0.0, -0.5), 0.0)
    for end in (residue, -residue):
        planes = [PlaneSurface((0.0, 0.0, -1.0), end), PlaneSurface((0.0, 0.0, 1.0), 4.0)]
        low, high = cut_quadric_bounds(bowl, planes)
        np.testing.assert_allclose([*low, *high], [-2, -2, 0, 2, 2, 4], rtol=1e-12, atol=1e-12)


def exact_bounds(solid: Any) -> Any:
    """The box that `geometry.bounds` finds, in numbers of 3000 bits."""
    return solid.bounds


def prepared_bounds(solid: Any) -> Any:
    """The box that `prepare.csg_plan` finds, in floats."""
    box = co.Scene([solid])._prepared.lowered.boxes[0]
    return box[:3], box[3:]


def random_pair(r: Random) -> Item:
    """Two shapes, the second moved against the first, and the part of the one that is in the other, or is not."""
    parts = [plain(r, str(pick(r, SOLIDS))) for _ in range(2)]
    return combined(
        str(pick(r, ("Intersection", "Intersection", "Difference"))), parts[0], parts[1].moved(*whole_motion(r))
    )


def check_pairs(seed: int, count: int, bounds: Callable[[Any], Any] = exact_bounds) -> int:
    """How many points were held against bounds."""
    checked = 0
    for k in range(count):
        r = generator(f"pairs {seed}", k)
        pair = random_pair(r)
        moved = pair.moved(*motion(r))
        low, high = bounds(moved.shape(co))
        assert not np.isnan([low, high]).any(), moved
        there = chain(moved.exact_steps)
        for point in extreme_points(pair, there, r):
            for x, least, most in zip(there.point(point), low.tolist(), high.tolist(), strict=True):
                assert least == -math.inf or (x - number(least)).sign >= 0, (moved, point)
                assert most == math.inf or (number(most) - x).sign >= 0, (moved, point)
            checked += 1
    return checked


def extreme_points(pair: Item, there: Any, r: Random) -> list[list[float]]:
    """Points that are inside in exact arithmetic, far out along the world's axes."""
    table = Table(bodies([pair]))

    def seems(points: np.ndarray) -> np.ndarray:
        """Inside in floats."""
        whole = np.concatenate([points, np.ones((len(points), 1))], axis=1).T
        products = np.array([whole[i] * whole[j] for i, j in PAIRS])
        return truth(
            table.bodies[0].formula,
            lambda forms: np.all([np.array([*map(float, form.k)]) @ products <= 0 for form in forms], axis=0),
        )

    grid = r.integers(-8, 9, (300, 3)) / 4
    points = np.concatenate([np.zeros((1, 3)), grid, r.normal(size=(500, 3)) * 10 ** r.uniform(-1, 1, (500, 1))])
    points = points[seems(points)]
    found = points[:3].tolist()
    for row in there.rows if len(points) > 3 else ():
        for direction in np.array([*map(float, row)]) * [[1], [-1]]:
            found.append(climb(seems, direction, points, r, 12, 20).tolist())
    inside = body_at(table, np.array(found)) if found else ()
    return [point for point, body in zip(found, inside, strict=True) if body == 0]


def test_bounds_hold_what_is_inside() -> None:
    assert check_pairs(0, FAST) > FAST


@pytest.mark.deep
@pytest.mark.parametrize("bounds", [exact_bounds, prepared_bounds])
@pytest.mark.parametrize("seed", range(1, 11))
def test_bounds_hold_what_is_inside_of_many(seed: int, bounds: Callable[[Any], Any]) -> None:
    assert check_pairs(seed, DEEP, bounds) > DEEP


def test_prepared_bounds_hold_what_is_inside() -> None:
    assert check_pairs(11, FAST, prepared_bounds) > FAST


def test_prepared_bounds_are_as_tight_as_exact_ones() -> None:
    drawn = [generator("pairs 12", k) for k in range(FAST)]
    solids = [random_pair(r).moved(*motion(r)).shape(co) for r in drawn]
    boxes = co.Scene(solids)._prepared.lowered.boxes
    finite = np.isfinite(boxes).all(axis=1)
    assert finite.sum() > FAST // 2
    for k, solid in enumerate(solids):
        exact, box = np.concatenate(solid.bounds), boxes[k]
        if finite[k]:
            # Infinite exact ends would be as if the box were tighter
            wider, size = np.maximum(exact[:3] - box[:3], box[3:] - exact[3:]), (exact[3:] - exact[:3]).max()
            assert (wider <= 1e-6 * size).all(), k
        # In a scene of many as alone, to the bit
        np.testing.assert_array_equal(box, np.concatenate(prepared_bounds(solid)))


def test_prepared_bounds_of_a_body_as_thin_as_the_rounding_of_its_place():
    """Sixteen steps of a float thick, far from the origin; the point is inside by exact fractions."""
    center = 1024.0
    thick = 8 * math.ulp(center)
    flat, round_, plane = (
        co.Ellipsoid((1, 1, thick), (0, 0, center)), co.Ellipsoid((1.5, 0.5, 2.0), (0, 0.6, center)),
        co.HalfSpace((-20 * thick, 0, 1), center),
    )  # fmt: skip
    for parts in itertools.permutations((flat, round_, plane)):
        low, high = prepared_bounds(co.Intersection(parts))
        assert (low <= (0.9, 0.25, center)).all()
        assert (high >= (0.9, 0.25, center)).all()


def test_known_boxes_serve_parts_with_a_motion_of_their_own():
    """Bounds of a placed part cost a millisecond; its recording has given them. Boxes that are not its own show it."""
    body = (co.Sphere(1).rotate("x", 30).translate((9, 0, 0)) | co.Box()).translate((0, 0, 5))
    known = {
        (id(leaf), steps): (np.full(3, 2.0 * k), np.full(3, 2.0 * k + 1))
        for k, (leaf, steps) in enumerate(placed_primitives(body))
    }
    low, high = region_bounds(body, IDENTITY_MOTION, known)
    assert (low.tolist(), high.tolist()) == ([0.0] * 3, [3.0] * 3)
