"""Cells of bodies: groups of their planes against half-spaces in fractions, and balls around them against formulas."""

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.io.openscad.solids import sided_ball
from conicoid.kernels import tables as table
from conicoid.kernels.body.cell import FIRST_CUTS, FIRST_GROUPS, MANY_PLANES
from conicoid.kernels.bvh.walk import ROUND, ROWS
from conicoid.kernels.tables import length

from ..samples import deep, many


def rough(count: int, seed: int) -> co.Polyhedron:
    """Return a polyhedron of planes whose numbers have few digits, so that many of them meet in points."""
    rng = np.random.default_rng(seed)
    normals = rng.integers(-9, 10, (count, 3)).astype(float)
    normals[:6] = [*np.eye(3), *-np.eye(3)]
    normals = normals[normals.any(axis=1)]
    offsets = np.ceil(4 * np.linalg.norm(normals, axis=1)) + rng.integers(0, 2, len(normals))
    return co.Polyhedron(normals.tolist(), offsets.tolist())


def prism(count: int) -> co.Polyhedron:
    """Return a prism along z: planes in one direction of all, and far ends."""
    angles = 2 * np.pi * np.arange(count) / count
    sides = np.round(np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1), 9)
    return co.Polyhedron([*sides.tolist(), (0, 0, 1), (0, 0, -1)], [1.0] * count + [9.0, 9.0])


SOLIDS = {
    "few": rough(MANY_PLANES + 6, 0),
    "rough": rough(300, 1),
    "ball": sided_ball(10.0, 40),
    "prism": prism(700),
    "far": rough(90, 2).translate((1000, -200, 3)),
    "three directions": co.Polyhedron(
        [(1, 0, 0), (-1, 0.5, 0), (0, -1, 0.2)] * 20, [1.0 + 0.25 * (k // 3) for k in range(60)]
    ),
    "half": co.Polyhedron([(1, 0.01 * k - 0.5, 0.3) for k in range(100)], [3.0] * 100),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_groups_hold_each_plane_once_and_bound_its_values(name: str) -> None:
    tables = co.Scene([SOLIDS[name]])._prepared.lowered.tables
    sizes, count = tables.group_planes[:, -1].tolist(), int(tables.cell_first[1])
    assert tables.cell_groups.tolist() == [0, len(sizes)]
    planes = tables.planes[tables.surface_row[tables.plane_surface]]
    sense = np.where(tables.plane_face > 0, 1.0, -1.0)
    scale = sense / np.linalg.norm(planes[:, :3], axis=1)
    points = np.random.default_rng(0).uniform(-12, 12, (60, 3)) + planes[:, 4:].mean(axis=0)
    values = np.einsum("pk,npk->np", planes[:, :3], points[:, None] - planes[:, 4:]) + planes[:, 3]
    seen: list[int] = []
    for group in range(FIRST_GROUPS, len(sizes)):
        leaves = [k for k in range(group, group + sizes[group]) if sizes[k] == 1]
        members = tables.group_planes[leaves, :4]
        members = members[members >= 0]
        seen += members.tolist() if sizes[group] == 1 else []
        assert len(members)
        assert set(tables.group_planes[group, :4].tolist()) <= {-1, *members.tolist()}
        middle, width, anchor, most = np.split(tables.group_bounds[group], [3, 6, 9])
        away = points - anchor
        assert (away @ middle + abs(away) @ width + most >= (values * scale)[:, members].max(axis=1)).all()
    assert sorted(seen) == list(range(count))
    first = tables.group_planes[:FIRST_GROUPS, :4].ravel().tolist()
    assert len(set(first)) == FIRST_CUTS


def span(solid: co.Polyhedron, origin: list[Fraction], direction: list[Fraction]) -> tuple[Fraction, Fraction] | None:
    """Return the span of a ray from t = 0 in the half-spaces of a solid, exactly; None if it is empty or a point."""
    low, high = Fraction(0), Fraction(10**9)
    for normal, offset in zip(solid.normals, solid.offsets, strict=True):
        rate = sum(Fraction(n) * d for n, d in zip(normal, direction, strict=True))
        height = sum(Fraction(n) * o for n, o in zip(normal, origin, strict=True)) - Fraction(offset)
        if rate == 0:
            if height >= 0:  # no ray of these tests runs within a face
                assert height > 0
                return None
        elif rate < 0:
            low = max(low, -height / rate)
        else:
            high = min(high, -height / rate)
    return (low, high) if low < high else None


@pytest.mark.parametrize("name", ["few", "rough", "ball", "prism"])
def test_rays_at_corners_edges_and_along_faces_have_the_spans_of_exact_half_spaces(name: str) -> None:
    solid, rng = SOLIDS[name], np.random.default_rng(4)
    corners, along = many(16, 60), many(8, 10)
    count = corners + along + many(6, 20)
    aims = rng.integers(-5, 6, (count, 3)).astype(float)
    normals, offsets = np.array(solid.normals), np.array(solid.offsets)
    for k in range(corners):  # points where three planes meet, as floats have them
        chosen = np.argsort(-(normals @ rng.normal(size=3)) / np.linalg.norm(normals, axis=1))[:3]
        if abs(np.linalg.det(normals[chosen])) > 1e-9:
            aims[k] = np.linalg.solve(normals[chosen], offsets[chosen])
    origins = aims + 40 * np.round(rng.normal(size=(count, 3)))
    origins[corners:][:along] = aims[corners:][:along] + [0, 0, 40]  # along the sides of the prism
    directions = aims - origins
    within = (directions @ normals.T == 0) & (origins @ normals.T == offsets)
    some = directions.any(axis=1) & ~within.any(axis=1)
    origins, directions = origins[some], directions[some]
    scene, hits = co.Scene([solid]), 0
    first = scene.first_hit(origins, directions).t
    for t, origin, direction in zip(first.tolist(), origins.tolist(), directions.tolist(), strict=True):
        exact = span(solid, list(map(Fraction, origin)), list(map(Fraction, direction)))
        found = scene.spans(origin, direction)
        assert len(found.t_enter) == (exact is not None)
        assert (t < math.inf) == (exact is not None)
        if exact is not None:
            hits += 1
            ends = (found.t_enter[0], found.t_exit[0], t)
            assert all(math.isclose(a, b, rel_tol=1e-13) for a, b in zip(ends, (*exact, exact[0]), strict=True))
    assert hits > many(3, 15)


def test_rays_in_packets_and_single_ones_agree_at_a_ball_of_many_faces() -> None:
    scene, side = co.Scene([SOLIDS["ball"]]), 48
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, side), np.linspace(-0.5, 0.5, side))
    directions = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    origins = np.tile([0.1, 0.2, -25.0], (len(directions), 1))
    together = scene.first_hit(origins, directions)
    order = np.random.default_rng(0).permutation(len(directions))
    apart = scene.first_hit(origins[order], directions[order])
    assert np.array_equal(apart.t, together.t[order])
    assert np.array_equal(apart.face, together.face[order])
    assert 0.2 < np.isfinite(together.t).mean() < 0.9


def test_edits_keep_the_groups_of_cells_that_stay_and_make_those_of_new_ones() -> None:
    ball, box = SOLIDS["ball"].translate((30, 0, 0)), co.Box((-2, -2, -2), (2, 2, 2))
    bodies = [
        ("rough", SOLIDS["rough"]),
        ("box", box),
        ("ball", ball),
        ("cut", SOLIDS["few"].translate((0.37, 0.41, 0.23)) - co.Sphere(3)),
    ]
    before = co.Scene([co.Body(shape, name=name) for name, shape in bodies])
    before.prepare()
    scene = before.moved("ball", (1, 2, 3))
    edits = (
        scene,
        scene.replace("box", SOLIDS["prism"]),
        scene.without("rough"),
        scene.without(["rough", "ball", "cut"]),
    )
    for edited in edits:
        fresh = co.Scene(edited.bodies)
        for name in ("cell_groups", "group_planes", "group_bounds"):
            one, other = (getattr(each._prepared.lowered.tables, name) for each in (edited, fresh))
            assert np.array_equal(one, other)


@pytest.mark.parametrize("sides", [32, 64, deep(400)])
def test_rays_along_planes_that_exact_methods_decide(sides: int) -> None:
    """Rays go along the axis of a prism and 1.24 from it, beside it within its box.

    A tangent of a ball makes them doubtful.
    """
    for x, y in ((0.875, 0.875), (-0.875, 0.875), (0.875, -0.875), (-0.875, -0.875)):
        ball = co.Sphere(1.0, (math.copysign(1.875, x), y, -3.0))
        scene = co.Scene([co.RegularPrism(sides, 1.0, (-1.0, 1.0)), ball])
        hit = scene.first_hit((x, y, 5.0), (0, 0, -1))
        assert not hit.hit
        assert hit.doubtful
        assert len(scene.spans((x, y, 5.0), (0, 0, -1)).body) == 0


@pytest.mark.parametrize("name", SOLIDS)
def test_doubt_is_the_same_on_all_routes(name: str) -> None:
    """Rays go along planes, through edges, and from walls on: in packets, streams, lists and alone."""
    rng = np.random.default_rng(3)
    scene = co.Scene([SOLIDS[name]])
    low, high = (np.clip(end, -1e4, 1e4) for end in scene.bounds)
    directions = rng.integers(-2, 3, (640, 3)) / 2.0
    directions[~directions.any(axis=1)] = 1.0
    points = np.round(rng.uniform(low, high, (640, 3)) * 2.0) / 2.0
    rays = co.Rays(points - 8.0 * directions, directions)
    hits = scene.first_hit(rays)
    spawned = hits.spawn(rng.permutation(directions))[hits.hit]
    doubtful = 0
    for some in (rays, spawned) if spawned.size > 40 else (rays,):
        one = scene.first_hit(some).doubtful
        order = rng.permutation(np.resize(np.arange(some.size), 9000))
        assert np.array_equal(scene.first_hit(some[order]).doubtful, one[order])
        assert np.array_equal(scene.first_hit(some[order[:50]]).doubtful, one[order[:50]])
        assert [bool(scene.first_hit(some[int(i)]).doubtful) for i in order[:200]] == one[order[:200]].tolist()
        doubtful += int(one.sum())
    assert name in ("ball", "half", "three directions") or doubtful > 10


# --- Balls around cells hold them, and are as tight as a formula says


# Shape, and the radius of the least ball around it whose center is halfway along its axis
CASES = [
    (co.Cylinder((0, 0, -1), (0, 0, 1), 0.5), math.hypot(0.5, 1.0)),
    (co.Ellipsoid((1, 2, 3)), 3.0),
    (co.Ellipsoid((2, 2, 2), z_range=(-1.0, 1.0)), 2.0),
    (co.Ellipsoid((2, 2, 2), z_range=(1.0, 2.0)), 2.0),  # the least ball around a ball is itself
    (co.Ellipsoid((2, 2, 3), z_range=(1.5, 3.0)), math.hypot(math.sqrt(3.0), 0.75)),
    # x² + y² = z² between 1 and 2: the upper rim
    (co.EllipticCone(1, 1, 1, z_range=(1.0, 2.0)), math.hypot(2.0, 0.5)),
    # x² + y² = 1 + z²
    (co.OneSheetHyperboloid(1, 1, 1, z_range=(-1.0, 1.0)), math.sqrt(3.0)),
    (co.EllipticCylinder(0.25, 1.0, z_range=(-1.0, 2.0)), math.hypot(2.0, 1.5)),
    # x² + y² = z: the rim
    (co.EllipticParaboloid(1, 1, z_range=(0.0, 2.0)), math.hypot(math.sqrt(2.0), 1.0)),
]


def ball_of(shape):
    """Return (center, radius, whether it is better than the box) of the only entry of a scene."""
    geometry = co.Scene([shape])._prepared.geometry
    assert length(geometry, table.LEAF_ITEMS) == ROWS
    items = geometry.floats[geometry.places[table.LEAF_ITEMS] :][:ROWS]
    return items[:3], items[3], items[4] % 1 == ROUND


def points_of(shape, count=4000):
    """Return points on a shape, by rays towards its middle."""
    rng = np.random.default_rng(0)
    low, high = (np.array(corner) for corner in shape.bounds)
    directions = rng.normal(size=(count, 3))
    far = np.linalg.norm(high - low)
    origins = (low + high) / 2 + far * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    targets = rng.uniform(low, high, (count, 3))
    points = co.Scene([shape]).first_hit(origins, targets - origins).point
    return points[np.isfinite(points[:, 0])]


@pytest.mark.parametrize(("shape", "radius"), CASES)
@pytest.mark.parametrize("turned", [False, True])
def test_a_ball_around_a_cell_holds_it_and_is_tight(shape, radius, turned):
    if turned:
        shape = shape.scale(0.1).rotate((1, 2, 3), 40).translate((5, -70, 11))
        radius *= 0.1
    center, found, preferred = ball_of(shape)
    low, high = (np.array(corner) for corner in shape.bounds)
    assert abs(found - radius) <= 1e-5 * radius
    points = points_of(shape)
    assert len(points) > 1000
    assert np.linalg.norm(points - center, axis=1).max() <= found * (1 + 1e-12)
    half = (high - low) / 2
    area = 2 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0])
    assert preferred == (math.pi * found**2 <= area)


@pytest.mark.parametrize(
    "shape",
    [
        co.Box((-1, -2, -3), (1, 2, 3)).rotate((1, 1, 0), 30),
        # Stretched across its axis and turned: the planes are not at right angles to it
        co.Cylinder((0, 0, -1), (0, 0, 1), 0.5).rotate((1, 0, 0), 40).scale((1, 3, 0.5)),
        co.HyperbolicParaboloid(1, 1, within=co.Box((-1, -1, -1), (1, 1, 1))),
    ],
)
def test_others_have_the_ball_around_their_box(shape):
    center, found, _ = ball_of(shape)
    low, high = (np.array(corner) for corner in shape.bounds)
    assert abs(found - 0.5 * np.linalg.norm(high - low)) <= 1e-9 * found
    assert np.allclose(center, (low + high) / 2, rtol=0, atol=1e-9)


@pytest.mark.parametrize("size", [1e-95, 1e-30, 1e30, 1e95])
@pytest.mark.parametrize(("shape", "radius"), CASES)
def test_balls_hold_cells_of_any_size(shape, radius, size):
    center, found, _ = ball_of(shape.scale(size))
    low, high = (np.array(corner) for corner in shape.bounds)
    assert radius * (1 - 1e-12) <= found / size <= 0.5 * np.linalg.norm(high - low) * (1 + 1e-9)
    assert np.linalg.norm(points_of(shape) - center / size, axis=1).max() <= found / size * (1 + 1e-12)
