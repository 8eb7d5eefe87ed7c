"""Solids of flat faces, extruded outlines and solids of revolution: by point tests of their outlines, Pappus and Gauss."""

import itertools
import math
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry import convex_decomposition, facets, sheets
from conicoid.geometry.sheets import check_simple

from ..samples import sampled


def star(count, seed, middle=0.0):
    """Return a concave polygon that is star-shaped about its middle."""
    rng = np.random.default_rng(seed)
    angles, radii = np.sort(rng.uniform(0, 2 * math.pi, count)), rng.uniform(0.3, 1.5, count)
    return [(float(x) + middle, float(y)) for x, y in zip(radii * np.cos(angles), radii * np.sin(angles), strict=True)]


def inside(polygon, x, y):
    """Return, by even-odd, which points of arrays are inside."""
    found = np.zeros(np.shape(x), bool)
    for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        if y1 != y2:
            found ^= ((y1 > y) != (y2 > y)) & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
    return found


def area(polygon):
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True))) / 2


FLANGE = [(1, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1.5, 1), (1.5, 3), (1, 3)]
PROFILES = [[(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 3)], FLANGE, star(5, 1, 1.6), star(20, 2, 1.6)]


@pytest.mark.parametrize("count", [3, 5, 9, 24])
@pytest.mark.parametrize("scale", [1.0, 0.0, 0.5])
def test_extrusions_contain_the_points_of_their_outline(count, scale):
    outline = star(count, count)
    shape = co.Extrusion(outline, (-1, 2), scale)
    points = np.random.default_rng(1).uniform(-1.6, 2.2, (4000, 3))
    grown = 1 + (scale - 1) * (points[:, 2] + 1) / 3
    within = (points[:, 2] > -1) & (points[:, 2] < 2)
    expected = inside(outline, points[:, 0] / grown, points[:, 1] / grown) & within
    assert np.array_equal(co.Scene([shape]).contains(points), expected)


def test_faces_of_an_extrusion_are_its_edges():
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    for points in (outline, outline[::-1]):
        scene = co.Scene([co.Extrusion(points, (0, 1))])
        hits = scene.first_hit(
            [(1.5, 5, 0.5), (5, 0.5, 0.5), (0.5, 0.5, 5), (0.5, 0.5, -5)],
            [(0, -1, 0), (-1, 0, 0), (0, 0, -1), (0, 0, 1)],
        )
        assert hits.t.tolist() == [4, 3, 4, 5]
        edges = [{points[k], points[(k + 1) % 6]} for k in range(6)]
        sides = [edges.index({(2, 1), (1, 1)}), edges.index({(2, 0), (2, 1)})]
        assert hits.face.tolist() == [*sides, 7, 6]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("angles", [(0, 360), (20, 90), (30, 300), (10, 190)])
def test_revolutions_contain_the_points_of_their_profile(profile, angles):
    shape = co.Revolution(profile, *angles)
    points = np.random.default_rng(1).uniform(-3.2, 3.2, (4000, 3))
    turned = (np.degrees(np.arctan2(points[:, 1], points[:, 0])) - angles[0]) % 360
    expected = inside(profile, np.hypot(points[:, 0], points[:, 1]), points[:, 2]) & (turned < angles[1] - angles[0])
    assert np.array_equal(co.Scene([shape]).contains(points), expected)


def test_the_volume_of_a_revolution_is_pappus():
    """The volume is the area times the way of its centroid: of the flange, 6 · ... as three rectangles."""
    rectangles = [(1, 1.5, 3), (1.5, 2, 1), (2, 3, 3)]  # inner, outer, height
    expected = sum(math.pi * (b * b - a * a) * h for a, b, h in rectangles)
    found = co.measure(co.Revolution(FLANGE), rays=40_000)
    assert abs(found.volume - expected) <= 5 * found.volume_error + 1e-12


def test_faces_of_a_revolution_are_its_edges():
    scene = co.Scene([co.Revolution(FLANGE, 0, 270)])
    rays = (
        [(1.75, 0.1, 9), (9, 0.1, 2), (1.25, 0.1, 9), (1.2, 9, 2), (-9, -2.5, 1.5)],
        [(0, 0, -1), (-1, 0, 0), (0, 0, -1), (0, -1, 0), (1, 0, 0)],
    )
    hits = scene.first_hit(*rays)
    assert hits.face.tolist() == [4, 1, 6, 1, 1]
    assert hits.t[[0, 2]].tolist() == [8, 6]
    assert scene.first_hit((1.25, -9, 1), (0, 1, 0)).face == 8  # the walls at 0 and at 270 degrees
    assert scene.first_hit((9, -1.25, 1), (-1, 0, 0)).face == 9


def ring(count=8):
    """Return a ring of square section. No plane sees all of its faces."""
    vertices, faces = [], []
    for i in range(count):
        angle = 2 * math.pi * i / count
        vertices += [(r * math.cos(angle), r * math.sin(angle), z) for r, z in ((1, 0), (2, 0), (2, 1), (1, 1))]
        there = (i + 1) % count
        faces += [(4 * i + k, 4 * there + k, 4 * there + (k + 1) % 4, 4 * i + (k + 1) % 4) for k in range(4)]
    return vertices, faces


def test_a_ring_of_faces():
    vertices, faces = ring()
    for ways in (faces, [face[::-1] for face in faces]):
        shape = co.Mesh(vertices, ways)
        assert co.measure(shape).volume == pytest.approx(8 * 0.5 * math.sin(math.pi / 4) * 3, rel=1e-12)
        scene = co.Scene([shape])
        points = np.random.default_rng(2).uniform(-2.2, 2.2, (4000, 3))
        corners = [(math.cos(math.pi / 4 * k), math.sin(math.pi / 4 * k)) for k in range(8)]
        outer, inner = ([(r * x, r * y) for x, y in corners] for r in (2, 1))
        flat = inside(outer, *points[:, :2].T) & ~inside(inner, *points[:, :2].T)
        assert np.array_equal(scene.contains(points), flat & (points[:, 2] > 0) & (points[:, 2] < 1))
        assert len(scene.spans((-9, 0.1, 0.5), (1, 0, 0)).t_enter) == 2


def test_a_cube_of_triangles_is_a_box():
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [part for a, b, c, d in quads for part in ((a, b, c), (a, c, d))]
    rng = np.random.default_rng(3)
    rays = rng.uniform(-2, 2, (500, 3)), rng.normal(size=(500, 3))
    box = co.Scene([co.Box((0, 0, 0), (1, 1, 1))]).first_hit(*rays)
    for faces in (quads, triangles):
        hits = co.Scene([co.Mesh(corners, faces)]).first_hit(*rays)
        assert np.array_equal(hits.t, box.t)
        assert set(hits.face[hits.hit].tolist()) <= set(range(0, len(faces), len(faces) // 6))


def test_a_face_out_of_plane_is_cut_into_triangles():
    """One corner of a cube is out of plane: each of its three faces there becomes two triangles."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    corners[7] = (1.25, 1.5, 1.125)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [part for a, b, c, d in quads for part in ((a, b, c), (a, c, d))]
    gauss = sum(np.linalg.det([corners[k] for k in part]) for part in triangles) / 6
    found = co.measure(co.Mesh(corners, quads), rays=100_000)
    assert found.volume_error < 1e-3
    assert abs(found.volume - abs(gauss)) <= 5 * found.volume_error + 1e-12


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: co.Mesh([(0, 0, 0)] * 4, [(0, 1, 2)] * 4), "Mesh: "),
        (lambda: co.Mesh(ring()[0], ring()[1][1:]), "Mesh: faces must close, with each edge in two faces of opposite sense: vertices"),
        (lambda: co.Mesh(ring()[0], [(0, 1, 99)] * 4), r"Mesh: faces\[0\] must be three or more numbers of vertices from 0 to 31"),
        (lambda: co.Extrusion([(0, 0), (1, 1), (1, 0), (0, 1)]), "Extrusion: outline must "),
        (lambda: co.Extrusion([(0, 0), (2, 2), (2, 0), (0, 1)]), "Extrusion: outline must not cross or touch itself, edges 0 and 2 do"),
        (lambda: co.Extrusion([(0, 0), (1, 0), (2, 0)]), "Extrusion: outline must enclose an area"),
        (lambda: co.Extrusion([(0, 0), (1, 0), (0, 1)], (0, math.inf)), "Extrusion: z_range must be two finite numbers"),
        (lambda: co.Extrusion([(0, 0), (1, 0), (0, 1)], scale_at_top=-1), "Extrusion: scale_at_top must be >= 0, got -1"),
        (lambda: co.Revolution([(-1, 0), (1, 0), (0, 1)]), r"Revolution: profile\[0\] must have r >= 0, got \(-1, 0\)"),
        (lambda: co.Revolution([(1, 0), (2, 0), (2, 1)], 0, 400), r"Revolution: end_angle - start_angle must be in \(0, 360\]"),
    ],
)  # fmt: skip
def test_impossible_meshes_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def touches(a, b, c, d, neighbours):
    """Return whether two edges have a common point, or neighbours (b = c) one beside their corner, by Cramer's rule."""
    a, b, c, d = (tuple(map(Fraction, point)) for point in (a, b, c, d))
    r, s, q = ((end[0] - begin[0], end[1] - begin[1]) for begin, end in ((a, b), (c, d), (a, c)))
    across, t, u = (one[0] * other[1] - one[1] * other[0] for one, other in ((r, s), (q, s), (q, r)))
    if neighbours:
        return not across and r[0] * s[0] + r[1] * s[1] < 0
    if across:
        return 0 <= t / across <= 1 and 0 <= u / across <= 1
    along = sorted(r[0] * (x - a[0]) + r[1] * (y - a[1]) for x, y in (c, d))
    return not u and along[0] <= r[0] ** 2 + r[1] ** 2 and along[1] >= 0


@pytest.mark.parametrize("size", [1.0, 1e-160, 1e150])
def test_outlines_touch_themselves_exactly(size):
    """Corners lie on a small grid, some a unit in the last place beside it. Thousands of edges nearly touch."""
    rng = np.random.default_rng(8)
    for count in [4] * 300 + [6] * 200:
        grid = rng.integers(1, 5, (count, 2)) * np.where(rng.random((count, 2)) < 0.3, 1 + 2.0**-52, 1.0)
        outline = [(float(x), float(y)) for x, y in grid * size / 3]
        edges = list(zip(outline, outline[1:] + outline[:1], strict=True))
        if len(set(outline)) < count:
            continue
        pairs = [(i, j) for i in range(count) for j in range(count) if i < j or (i, j) == (count - 1, 0)]
        bad = any(touches(*edges[i], *edges[j], (j - i) % count == 1) for i, j in pairs if (i, j) != (0, count - 1))
        try:
            check_simple("X", "outline", outline)
        except ValueError:
            assert bad, outline
        else:
            assert not bad, outline


def test_a_plain_profile_takes_no_fractions(monkeypatch):
    """A detector has an outline for each of its wires."""
    monkeypatch.setattr(sheets, "Fraction", None)
    co.Revolution([(1, -0.7), (2.1, -0.7), (2.1, 3), (1, 3)])


BLOCK = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
OCTAHEDRON = [(k, 2 + j, 4 + i)[:: 1 if (i + j + k) % 2 == 0 else -1] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def convex_piece(rng):
    """Return the corners and faces of a block, an octahedron or a tetrahedron at whole numbers."""
    low, kind = rng.integers(-3, 3, 3), rng.integers(3)
    if kind == 0:
        high = low + rng.integers(1, 4, 3)
        return [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], BLOCK
    if kind == 1:
        return [
            tuple(low + side * rng.integers(1, 3) * axis) for axis in np.eye(3, dtype=int) for side in (1, -1)
        ], OCTAHEDRON
    while True:
        corners = rng.integers(-3, 4, (4, 3))
        volume = round(np.linalg.det(corners[1:] - corners[0]))
        if volume:
            return [*map(tuple, corners)], [face[:: 1 if volume > 0 else -1] for face in TETRAHEDRON]


def half_spaces(corners, faces):
    """Return (normals, offsets) of a convex piece in whole numbers, inside n·x <= d."""
    points = np.array(corners)
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals, (normals * a).sum(axis=1)


def chord(normals, offsets, origin, direction):
    """Return where a line enters and leaves a convex piece, in fractions, or None if it misses."""
    low, high = Fraction(-1000), Fraction(1000)
    for normal, offset in zip(normals.tolist(), offsets.tolist(), strict=True):
        slope = sum(n * u for n, u in zip(normal, direction, strict=True))
        assert slope
        t = (offset - sum(n * o for n, o in zip(normal, origin, strict=True))) / slope
        low, high = (low, min(high, t)) if slope > 0 else (max(low, t), high)
    return (low, high) if low < high else None


def joined_spans(chords):
    """Return (enter, leave) wherever the sum of senses is above 0."""
    ends = Counter()
    for sense, low, high in chords:
        ends[low] += sense
        ends[high] -= sense
    spans, count = [], 0
    for t in sorted(t for t, step in ends.items() if step):
        was, count = count > 0, count + ends[t]
        if was != (count > 0):
            spans.append(t)
    return list(zip(spans[::2], spans[1::2], strict=True))


@pytest.mark.parametrize("seed", sampled(range(300), 26))
def test_a_mesh_is_where_its_pieces_wind_more_than_zero_times(seed, monkeypatch):
    """Convex pieces overlap, touch, lie in one another, are inside out, or are there twice.

    The oracle knows no faces: the winding number is the sum of the senses of the pieces that contain a point.
    """
    rng = np.random.default_rng(seed)
    pieces = []
    for _ in range(rng.integers(2, 6)):
        corners, faces = pieces[-1][1:] if pieces and rng.random() < 0.25 else convex_piece(rng)
        pieces.append((int(rng.choice([1, 1, -1])), corners, faces))
    vertices, faces, volume = [], [], Fraction(0)
    for sense, corners, own in pieces:
        if rng.random() < 0.5:
            own = [(face[0], b, c) for face in own for b, c in itertools.pairwise(face[1:])]
        faces += [tuple(len(vertices) + k for k in face[::sense]) for face in own]
        vertices += [tuple(map(float, corner)) for corner in corners]
        three = [
            np.array([corners[face[0]], corners[b], corners[c]])
            for face in own
            for b, c in itertools.pairwise(face[1:])
        ]
        volume += sense * sum(round(np.linalg.det(each)) for each in three)
    if not volume:
        with pytest.raises(ValueError, match="must enclose a volume"):
            co.Mesh(vertices, faces)
        return
    turned = 1 if volume > 0 else -1
    mesh = co.Mesh(vertices, faces)
    if seed % 4 == 0:  # fractions alone give the same parts
        monkeypatch.setattr(facets, "_TURNS", [])
        assert str(co.Mesh(vertices, faces).tree()) == str(mesh.tree())
    scene = co.Scene([mesh])
    spaces = [(turned * sense, *half_spaces(corners, own)) for sense, corners, own in pieces]

    points = rng.uniform(-4, 6, (2000, 3))
    winding = sum(sense * (points @ normals.T < offsets).all(axis=1) for sense, normals, offsets in spaces)
    assert np.array_equal(scene.contains(points), winding > 0)

    origins, directions = rng.uniform(-9, 9, (60, 3)), rng.normal(size=(60, 3))
    hits, found = scene.first_hit(origins, directions), scene.spans(origins, directions)
    shadows = scene.occluded(origins, directions)
    planes = {number: half_spaces(vertices, [faces[number]]) for number, _ in mesh.planes()}
    for k, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        ray = [*map(Fraction, origin)], [*map(Fraction, direction)]
        chords = [(sense, *at) for sense, *piece in spaces if (at := chord(*piece, *ray)) is not None]
        expected = [(low, high) for low, high in joined_spans(chords) if high > 0]
        own = found[k]
        assert own.t_enter.tolist() == pytest.approx([float(max(low, 0)) for low, _ in expected], rel=1e-9, abs=1e-12)
        assert own.t_exit.tolist() == pytest.approx([float(high) for _, high in expected], rel=1e-9)
        walls = [float(t) for span in expected for t in span if t > 0]
        assert bool(hits.hit[k]) == bool(shadows[k]) == bool(walls)
        if walls:
            single = scene.first_hit(origin, direction)
            assert hits.t[k] == single.t == pytest.approx(walls[0], rel=1e-9)
            normal, offset = planes[int(hits.face[k])]
            assert normal @ hits.point[k] == pytest.approx(offset, abs=1e-9)


def skyline(rng):
    """Return the corners and faces of a prism of columns of whole size, and its cubes, up to 9 along each axis."""
    lows, highs = rng.integers(0, 4, 5), rng.integers(5, 9, 5)
    bottom, top = rng.integers(0, 4), rng.integers(5, 9)
    cells = np.zeros((9, 9, 9), int)
    for k, (low, high) in enumerate(zip(lows, highs, strict=True)):
        cells[k + 2, low:high, bottom:top] = 1
    steps = [[(k + 2 + end, heights[k]) for k in range(5) for end in (0, 1)] for heights in (lows, highs)]
    outline = list(dict.fromkeys(steps[0] + steps[1][::-1]))
    count = len(outline)
    corners = [(x, y, z) for z in (bottom, top) for x, y in outline]
    sides = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    faces = [*sides, tuple(range(count))[::-1], tuple(range(count, 2 * count))]
    turn = [int(axis) for axis in np.roll(range(3), rng.integers(3))]
    return [tuple(float(corner[axis]) for axis in turn) for corner in corners], faces, cells.transpose(turn)


@pytest.mark.parametrize("seed", sampled(range(200), 50))
def test_prisms_that_overlap_fill_the_cubes_of_a_grid(seed):
    """There are concave faces in common planes, and one prism is a hole: points inside, volumes and areas."""
    rng = np.random.default_rng(seed)
    vertices, faces, cells = [], [], np.zeros((9, 9, 9), int)
    for sense in (1, 1, -1):
        corners, own, cubes = skyline(rng)
        faces += [tuple(len(vertices) + k for k in face[::sense]) for face in own]
        vertices += corners
        cells += sense * cubes
    cells *= np.sign(cells.sum())  # the sense of faces that enclose a volume above 0 counts
    mesh, full = co.Mesh(vertices, faces), np.pad(cells > 0, 1)
    middles = np.indices(full.shape).reshape(3, -1).T - 0.5
    assert np.array_equal(co.Scene([mesh]).contains(middles), full.ravel())
    found = co.measure(mesh, rays=2000)
    assert found.volume == pytest.approx(full.sum(), rel=1e-12)
    assert found.centroid == pytest.approx(np.argwhere(full).mean(axis=0) - 0.5, abs=1e-9)
    area = sum(np.diff(full.astype(int), axis=axis).astype(bool).sum() for axis in range(3))
    assert found.area == pytest.approx(area, abs=5 * found.area_error + 1e-9)


def test_a_piece_within_another_one_adds_no_part():
    rng = np.random.default_rng(1)
    cube = [(x, y, z) for x in (-9.0, 9.0) for y in (-9.0, 9.0) for z in (-9.0, 9.0)]
    vertices, faces = cube, [*BLOCK]
    for _ in range(3):
        corners, own = convex_piece(rng)
        faces += [tuple(len(vertices) + k for k in face) for face in own]
        vertices = [*vertices, *(tuple(map(float, corner)) for corner in corners)]
    assert co.Mesh(vertices, faces).tree() == co.Mesh(cube, BLOCK).tree()


def test_a_hole_that_sticks_out_has_a_closed_form():
    """A block of 4 by 4 by 4, and a block inside out that takes 1 by 1 by 2 of it and winds -1 times around the rest."""
    vertices, faces = [], []
    for sense, low, high in ((1, (2, 3, 0), (6, 7, 4)), (-1, (3, 0, 0), (4, 4, 2))):
        faces += [tuple(len(vertices) + k for k in face[::sense]) for face in BLOCK]
        vertices += [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    found = co.measure(co.Mesh(vertices, faces), rays=2000)
    assert (found.volume, found.volume_error) == (pytest.approx(62, rel=1e-12), 0)


@pytest.mark.parametrize("seed", range(4))
def test_floats_find_the_faces_that_fractions_find(seed):
    rng = np.random.default_rng(seed)
    for _ in range(20):
        # Random normals, and those of a prism; offsets on a coarse grid, where planes meet in lines and corners
        normals = np.round(rng.normal(size=(rng.integers(4, 18), 3)) * 2, rng.integers(0, 3))
        normals[:, 2] *= seed % 2
        normals = normals[normals.any(axis=1)] / np.abs(normals[normals.any(axis=1)]).max(axis=1, keepdims=True)
        rows = np.column_stack([normals, np.round(rng.uniform(0, 1, len(normals)), rng.integers(1, 4))])
        cube = np.column_stack([np.concatenate([np.eye(3), -np.eye(3)]), np.ones(6)])
        planes = [
            facets.FlatPlane(tuple(map(Fraction, row[:3])), Fraction(row[3]), tuple(row))
            for row in np.concatenate([rows, cube]).tolist()
        ]
        sides = [(k, 1) for k in range(len(planes))]
        found = convex_decomposition._sure_faces(rows)
        exact = [bool(convex_decomposition.exact_face(planes, sides, k)) for k in range(len(rows))]
        assert all(not sure or (sure > 0) == face for sure, face in zip(found, exact, strict=True))
        assert (found != 0).mean() > 0.5
