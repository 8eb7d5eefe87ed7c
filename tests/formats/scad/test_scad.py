"""OpenSCAD's .csg: each module against its formula by points, colours, and mistakes with their places."""

import itertools
import math

import numpy as np
import pytest

import conicoid as co
from conicoid.io.importers import detect_format

ROUND = "$fn = 0, $fa = 12, $fs = 2"


def csg_file(folder, text, name="a.txt"):
    path = folder / name
    path.write_text(text)
    return path


def load_text(folder, text, **options):
    return co.load(csg_file(folder, text), **options)


def points(count=4000, size=3.0):
    return np.random.default_rng(1).uniform(-size, size, (count, 3))


def polygon(x, y, corners):
    """Return which points are in a convex polygon, corners counter-clockwise."""
    found = np.ones(np.shape(x), bool)
    for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1], strict=True):
        found &= (c - a) * (y - b) - (d - b) * (x - a) >= 0
    return found


def ring(radius, sides):
    return [
        (radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides)) for k in range(sides)
    ]


def cone(x, y, z, low, high, first, second):
    radius = first + (second - first) * (z - low) / (high - low)
    return (np.hypot(x, y) <= radius) & (z >= low) & (z <= high)


def frustum(x, y, z, low, high, first, second, sides):
    scale = first + (second - first) * (z - low) / (high - low)
    safe = np.where(scale > 0, scale, 1)
    return polygon(x / safe, y / safe, ring(1, sides)) & (z >= low) & (z <= high) & (scale > 0)


def between(v, low, high):
    return (v >= low) & (v <= high)


SQUARE = "square(size = [1, 2], center = false);"
CASES = {
    "cube(size = [1, 2, 3], center = false);": lambda x, y, z: between(x, 0, 1) & between(y, 0, 2) & between(z, 0, 3),
    "cube(size = 2, center = true);": lambda x, y, z: (abs(x) <= 1) & (abs(y) <= 1) & (abs(z) <= 1),
    "cube([1, 2, 3]);": lambda x, y, z: between(x, 0, 1) & between(y, 0, 2) & between(z, 0, 3),
    "cube(size = 2, true);": lambda x, y, z: (abs(x) <= 1) & (abs(y) <= 1) & (abs(z) <= 1),
    "sphere(2);": lambda x, y, z: x * x + y * y + z * z <= 4,
    "cylinder(2, 2);": lambda x, y, z: cone(x, y, z, 0, 2, 2, 1),
    "cylinder(h = 3, d1 = 4, d2 = 2, center = true);": lambda x, y, z: cone(x, y, z, -1.5, 1.5, 2, 1),
    "linear_extrude(2) square([1, 2], true);": lambda x, y, z: (abs(x) <= 0.5) & (abs(y) <= 1) & between(z, 0, 2),
    f"sphere({ROUND}, r = 2);": lambda x, y, z: x * x + y * y + z * z <= 4,
    f"cylinder({ROUND}, h = 3, r1 = 2, r2 = 1, center = true);": lambda x, y, z: cone(x, y, z, -1.5, 1.5, 2, 1),
    f"cylinder({ROUND}, h = 2, r1 = 0, r2 = 2, center = false);": lambda x, y, z: cone(x, y, z, 0, 2, 0, 2),
    "cylinder($fn = 5, h = 2, r1 = 2, r2 = 2, center = false);": lambda x, y, z: frustum(x, y, z, 0, 2, 2, 2, 5),
    "cylinder($fn = 6, h = 2, r1 = 1, r2 = 2.5, center = true);": lambda x, y, z: frustum(x, y, z, -1, 1, 1, 2.5, 6),
    "cylinder($fn = 4, h = 2, r1 = 2, r2 = 0, center = false);": lambda x, y, z: frustum(x, y, z, 0, 2, 2, 0, 4),
    "multmatrix([[0, -2, 0, 1], [1, 0, 0, 0], [0, 0, 1, -1], [0, 0, 0, 1]]) { cube(size = 1); }":
        lambda x, y, z: between(y, 0, 1) & between((1 - x) / 2, 0, 1) & between(z + 1, 0, 1),
    f"difference() {{ cube(size = 4, center = true); sphere({ROUND}, r = 2); cylinder({ROUND}, h = 9, r1 = 1, r2 = 1, center = true); }}":
        lambda x, y, z: (np.maximum(np.maximum(abs(x), abs(y)), abs(z)) <= 2) & (x * x + y * y + z * z > 4) & (np.hypot(x, y) > 1),
    f"intersection() {{ group() {{ cube(size = 2); sphere({ROUND}, r = 1); }} cube(size = 3, center = true); }}":
        lambda x, y, z: ((between(x, 0, 2) & between(y, 0, 2) & between(z, 0, 2)) | (x * x + y * y + z * z <= 1)) & (np.maximum(np.maximum(abs(x), abs(y)), abs(z)) <= 1.5),
    f"linear_extrude(height = 2, center = true, scale = [1, 1]) {{ {SQUARE} }}":
        lambda x, y, z: between(x, 0, 1) & between(y, 0, 2) & (abs(z) <= 1),
    f"linear_extrude(height = 2, scale = [0.5, 0.5]) {{ multmatrix([[1, 0, 0, 1], [0, 1, 0, 0.5], [0, 0, 1, 0], [0, 0, 0, 1]]) {SQUARE} }}":
        lambda x, y, z: between(x / (1 - z / 4), 1, 2) & between(y / (1 - z / 4), 0.5, 2.5) & between(z, 0, 2),
    f"linear_extrude(height = 2, scale = 0.5) {{ multmatrix([[1, 0, 0, 1.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) circle({ROUND}, r = 1); }}":
        lambda x, y, z: (np.hypot(x / (1 - z / 4) - 1.5, y / (1 - z / 4)) <= 1) & between(z, 0, 2),
    f"linear_extrude(height = 1) {{ difference() {{ circle({ROUND}, r = 2); {SQUARE} }} }}":
        lambda x, y, z: (np.hypot(x, y) <= 2) & ~(between(x, 0, 1) & between(y, 0, 2)) & between(z, 0, 1),
    "linear_extrude(height = 1) { polygon(points = [[0, 0], [2, 0], [0, 2], [0.5, 0.5], [1, 0.5], [0.5, 1]], paths = [[0, 1, 2], [3, 4, 5]]); }":
        lambda x, y, z: polygon(x, y, [(0, 0), (2, 0), (0, 2)]) & ~polygon(x, y, [(0.5, 0.5), (1, 0.5), (0.5, 1)]) & between(z, 0, 1),
    "rotate_extrude(angle = 360) { multmatrix([[1, 0, 0, 1], [0, 1, 0, -1], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [1, 2]); } }":
        lambda x, y, z: between(np.hypot(x, y), 1, 2) & (abs(z) <= 1),
    "rotate_extrude(angle = 90) { polygon(points = [[1, 0], [2, 0], [1, 2]]); }":
        lambda x, y, z: polygon(np.hypot(x, y), z, [(1, 0), (2, 0), (1, 2)]) & (x >= 0) & (y >= 0),
    f"rotate_extrude() {{ intersection() {{ circle({ROUND}, r = 2); polygon(points = [[0, -3], [3, -3], [3, 3], [0, 3]]); }} }}":
        lambda x, y, z: x * x + y * y + z * z <= 4,
    "polyhedron(points = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], convexity = 1);":
        lambda x, y, z: (x >= 0) & (y >= 0) & (z >= 0) & (x + y + z <= 2),
}  # fmt: skip


@pytest.mark.parametrize("text", CASES)
def test_modules_are_their_formulas(text, tmp_path):
    scene = load_text(tmp_path, text)
    assert len(scene) == 1
    at = points()
    assert np.array_equal(scene.contains(at), CASES[text](*at.T))


def test_a_ball_of_so_many_sides(tmp_path):
    """OpenSCAD's ball has rings at polar angles 180 (k + 1/2) / n for n = $fn / 2, and corners at 360 k / $fn."""
    scene = load_text(tmp_path, "sphere($fn = 8, r = 2);")
    levels = [(2 * math.sin(math.pi * (k + 0.5) / 4), 2 * math.cos(math.pi * (k + 0.5) / 4)) for k in range(4)]
    at = points()
    expected = np.zeros(len(at), bool)
    for (r1, z1), (r0, z0) in itertools.pairwise(levels):
        expected |= frustum(*at.T, z0, z1, r0, r1, 8)
    assert np.array_equal(scene.contains(at), expected)
    smooth = load_text(tmp_path, "sphere($fn = 8, r = 2);", smooth=True)
    assert np.array_equal(smooth.contains(at), (at**2).sum(axis=1) <= 4)
    assert "1 circle with $fn made round" in smooth.notes


def test_a_turned_polygon_of_so_many_sides(tmp_path):
    scene = load_text(tmp_path, "rotate_extrude($fn = 6) { polygon(points = [[1, 0], [2, 0], [2, 1], [1, 2]]); }")
    at = points()
    x, y, z = at.T
    outer = frustum(x, y, z, 0, 1, 2, 2, 6) | frustum(x, y, z, 1, 2, 2, 1, 6)
    assert np.array_equal(scene.contains(at), outer & ~frustum(x, y, z, 0, 2, 1, 1, 6))


@pytest.mark.parametrize(
    ("arguments", "left", "azimuth"),
    [
        ("$fn = 5", False, 180), ("angle = 360, $fn = 5", False, 180), ("angle = 360, start = 0, $fn = 5", False, 0),
        ("angle = 360, start = 30, $fn = 5", False, 30), ("angle = 360, start = 30, $fn = 5", True, 210),
    ],
)  # fmt: skip
def test_the_azimuth_of_the_first_corner(arguments, left, azimuth, tmp_path):
    """OpenSCAD's rotatePolygon: v[0] (cos a, sin a) from `start` on, which is 180 for a full turn."""
    rows = [[-1 if left else 1, 0], [-2 if left else 2, 0], [-2 if left else 2, 1]]
    scene = load_text(tmp_path, f"rotate_extrude({arguments}) {{ polygon(points = {rows}); }}")
    at = points()
    x, y, z = at.T
    c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))
    x, y = c * x + s * y, c * y - s * x
    expected = frustum(x, y, z, 0, 1, 2, 2, 5) & ~frustum(x, y, z, 0, 1, 1, 2, 5)
    assert np.array_equal(scene.contains(at), expected)


def test_a_polygon_on_the_left_turns_from_there(tmp_path):
    scene = load_text(tmp_path, "rotate_extrude(angle = 90) { polygon(points = [[-1, 0], [-2, 0], [-1, 2]]); }")
    at = points()
    x, y, z = at.T
    expected = polygon(np.hypot(x, y), z, [(1, 0), (2, 0), (1, 2)]) & (x <= 0) & (y <= 0)
    assert np.array_equal(scene.contains(at), expected)


def test_colours_become_bodies_that_do_not_overlap(tmp_path):
    text = """
color([1, 0, 0, 1]) { cube(size = 2, center = true); }
color([0, 0, 1, 1]) { multmatrix([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = 2, center = true); } }
color([1, 0, 0, 1]) { multmatrix([[1, 0, 0, 9], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = 2, center = true); } }
multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 0.5); }
"""
    scene = load_text(tmp_path, text)
    assert [body.name for body in scene.bodies] == ["#ff0000", "#0000ff", "#f9d72c"]
    spans = scene.spans((-9, 0.1, 0.1), (1, 0, 0))
    assert spans.body.tolist() == [0, 1, 2, 0]
    assert spans.t_enter[[0, 1, 3]].tolist() == [8, 10, 17]
    assert len(co.check(scene)) == 0


def test_cuts_have_the_colour_of_the_cutter(tmp_path):
    scene = load_text(
        tmp_path,
        "difference() { cube(size = 2, center = true); color([0, 1, 0, 1]) { cube(size = [1, 1, 9], center = true); } }",
    )
    cut, outside = (
        scene.render(1, 1, samples=1, camera=co.Camera((x, 0, 0), (1, 0, 0)), integrator="albedo") for x in (0, 9)
    )
    assert cut.values[0, 0].tolist() == [0, 1, 0]
    assert outside.values[0, 0, 0] > 0.9


def test_omissions_are_reported_with_their_line(tmp_path):
    scene = load_text(
        tmp_path, "cube(size = 1);\nhull() { sphere(r = 1); }\n%sphere(r = 2);\n*sphere(r = 3);\ncircle(r = 1);\n"
    )
    assert len(scene) == 1
    notes = [note for note in scene.notes if note.startswith("line")]
    assert notes == [
        "line 2: hull is the convex hull of its children, and left out",
        "line 3: sphere is in the background (%) and left out",
        "line 5: circle is flat and encloses nothing; it is left out",
    ]
    with pytest.raises(ValueError, match="strict is set:\nline 2: hull"):
        load_text(tmp_path, "cube(size = 1);\nhull() { sphere(r = 1); }", strict=True)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("cube(size = [0, 1, 1]);", "cube has the size [0.0, 1.0, 1.0]; it is left out"),
        ("cube(sise = 3); cube();", "cube has no parameter 'sise', which is not read"),
        ("linear_extrude(height = 1, v = [1, 0, 1]) { square(size = 1); }", "linear_extrude is extruded along [1.0, 0.0, 1.0], which is not read; it is left out"),
        ("sphere(r = -1);", "sphere has the radius -1; it is left out"),
        ("cylinder(h = 0, r1 = 1, r2 = 1);", "cylinder has the height 0; it is left out"),
        ("cylinder(h = 1, r1 = 0, r2 = 0);", "cylinder has the radii 0 and 0; it is left out"),
        ("linear_extrude(height = 0) { square(size = 1); }", "linear_extrude has the height 0; it is left out"),
        ("linear_extrude(height = 1, twist = 20) { square(size = 1); }", "linear_extrude has the twist 20, and a twisted side is no quadric; it is left out"),
        ("linear_extrude(height = 1, scale = [1, 2]) { square(size = 1); }", "linear_extrude has two scales, 1 and 2, between which no side is a plane; it is left out"),
        ("rotate_extrude() { multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) circle(r = 1); }", "rotate_extrude is a torus, or a sphere cut by sides or angles, which no quadric bounds; it is left out"),
        ("polyhedron(points = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 1]]);", "polyhedron is no closed solid (Mesh: faces must close, with each edge in two faces of opposite sense: vertices 0 and 1 are no such edge); it is left out"),
        ("roof(method = \"voronoi\") { square(size = 1); }", "roof is a roof, and left out"),
        ("linear_extrude(height = 1) { circle(r = 0); square(size = 1); }", "circle has the radius 0; it is left out"),
        ("linear_extrude(height = 1) { square(size = [0, 1]); square(size = 1); }", "square has the size [0.0, 1.0]; it is left out"),
        ("linear_extrude(height = 1) { polygon(points = [[0, 0], [1, 0]]); square(size = 1); }", "polygon has no area; it is left out"),
        ("linear_extrude(height = 1) { polygon(points = [], paths = undef); square(size = 1); }", "polygon has no area; it is left out"),
        ("linear_extrude(height = 1) { text(text = \"A\"); square(size = 1); }", "text is letters, and left out"),
        ("linear_extrude(height = 1) { offset(r = 1) { square(size = 3); } square(size = 1); }", "offset is an outline at a distance, and left out"),
        ("linear_extrude(height = 1) { group() { hull() { circle(r = 9); } } square(size = 1); }", "hull is the convex hull of its children, and left out"),
        ("linear_extrude(height = 1) { import(file = \"a.svg\"); square(size = 1); }", "import is a file, and left out"),
        ("linear_extrude(height = 1) { fill() { circle(r = 9); } square(size = 1); }", "fill is an outline without its holes, and left out"),
        ("linear_extrude(height = 1) { cube(size = 9); square(size = 1); }", "cube is no figure of the plane; it is left out"),
        ("linear_extrude(height = 1) { linear_extrude(height = 9) { circle(r = 9); } square(size = 1); }", "linear_extrude is no figure of the plane; it is left out"),
        ("cube(size = [inf, inf, inf]);", "cube has the size [inf, inf, inf]; it is left out"),
        ("cube(size = [nan, 1, 1]);", "cube has the size [nan, 1.0, 1.0]; it is left out"),
        ("sphere(r = nan);", "sphere has the r nan; it is left out"),
        ("cylinder(h = inf, r1 = 1, r2 = 1);", "cylinder has the h inf; it is left out"),
        ("linear_extrude(height = inf) { square(size = 1); }", "linear_extrude has the height inf; it is left out"),
        ("linear_extrude(height = 1, scale = -1) { square(size = 1); }", "linear_extrude has the scale -1.0; it is left out"),
        ("linear_extrude(height = 1) { circle(r = inf); square(size = [inf, 1]); square(size = 1); }", "circle has the r inf; it is left out"),
        ("linear_extrude(height = 1) { polygon(points = [[0, 0], [1, inf], [1, 0]]); square(size = 1); }", "polygon has the point (1.0, inf); it is left out"),
        ("polyhedron(points = [[0, 0, nan], [2, 0, 0], [0, 2, 0], [0, 0, 2]], faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]);", "polyhedron has the point (0.0, 0.0, nan); it is left out"),
        ("polyhedron(points = undef, triangles = undef, convexity = 1);", "polyhedron has no points; it is left out"),
        ("polyhedron(points = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], faces = undef);", "polyhedron has no faces; it is left out"),
        ("linear_extrude(height = 1) { polygon(points = undef, paths = undef); square(size = 1); }", "polygon has no points; it is left out"),
        ("multmatrix([[1, 0, 0, 0], [0, inf, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 9); }", "multmatrix flattens what it moves, or makes it infinite; it is left out"),
        ("linear_extrude(height = 1) { multmatrix([[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle(r = 9); } square(size = 1); }", "multmatrix flattens what it moves, or makes it infinite; it is left out"),
        ("rotate_extrude(angle = 0) { square(size = 3); }", "rotate_extrude has the angle 0; it is left out"),
        ("rotate_extrude(angle = 90, $fn = 8) { square(size = 3); }", "rotate_extrude has $fn and an angle, which are not read: smooth makes it round; it is left out"),
        ("rotate_extrude() { square(size = 3, center = true); }", "rotate_extrude has a polygon on both sides of the y axis; it is left out"),
        ("rotate_extrude() { text(text = \"A\"); }", "rotate_extrude holds no circle, square or polygon; it is left out"),
        ("linear_extrude(height = 1) { difference() { text(text = \"A\"); square(size = 3); } square(size = 1); }", "text is letters, and left out"),
        ("linear_extrude(height = 1) { intersection() { square(size = 3); text(text = \"A\"); } square(size = 1); }", "text is letters, and left out"),
    ],
)  # fmt: skip
def test_empty_solids_are_left_out(text, note, tmp_path):
    # The unit cube remains without the refused parts, and nothing else
    scene = load_text(tmp_path, f"cube(size = 1);\n{text}")
    assert f"line 2: {note}" in scene.notes
    assert scene.first_hit([(0.5, 0.5, 5), (2, 0.5, 5), (-0.5, 0.5, 5)], (0, 0, -1)).t.tolist() == [4, np.inf, np.inf]


@pytest.mark.parametrize(("first", "last"), [(2, 2), (2, 1), (1, 2.5), (0, 3), (3, 0)])
@pytest.mark.parametrize("sides", [3, 6, 100])
def test_a_sided_cylinder_is_one_convex_polyhedron(sides, first, last, tmp_path):
    """Cutting prisms of a hundred sides from meshes took a tenth of a second each."""
    scene = load_text(tmp_path, f"cylinder($fn = {sides}, h = 3, r1 = {first}, r2 = {last}, center = true);")
    assert isinstance(scene.bodies[0].shape, co.Polyhedron)
    points = np.random.default_rng(sides).uniform(-3, 3, (2000, 3))
    # Within a sector the side is as far from the axis as the middle of its edge
    aside = np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi / sides) - np.pi / sides
    reach = (first + (last - first) * (points[:, 2] / 3 + 0.5)) * np.cos(np.pi / sides)
    inside = (abs(points[:, 2]) < 1.5) & (np.hypot(points[:, 0], points[:, 1]) * np.cos(aside) < reach)
    assert np.array_equal(scene.body_at(points) == 0, inside)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("cube(size = 1)", ":1:15: text: must be the name of a module, got the end of the file"),
        ("x = 3;", ":1:1: x: is a program; `openscad -o model.csg model.scad` runs it"),
        ("union() { for(a=[0:45:180]) cube(a); }", ":1:11: for: is a program; `openscad -o model.csg model.scad` runs it"),
        ("module bar(n) { cube(n); }", ":1:1: module: is a program; `openscad -o model.csg model.scad` runs it"),
        ("group() {\n cub(size = 1);\n}", ":2:2: cub: is no module of a .csg file"),
        ("cube(size = [1, 2]);", ":1:1: cube: size must be three numbers, got [1.0, 2.0]"),
        ("multmatrix([[1]]) { cube(size = 1); }", ":1:1: multmatrix: m must be four rows of four numbers"),
        ("linear_extrude(height = 1, scale = [1, 2, 3]) { square(size = 1); }", ":1:1: linear_extrude: scale must be one or two"),
        ("linear_extrude(height = 1) { cub(size = 1); }", ":1:30: cub: is nothing of the plane, which cannot be extruded"),
        ("cube(size = foo);", ":1:13: text: must be a number, a text, true, false, undef or a list, got 'foo'"),
        ("cube(\n  size = [1, 2, 3", ":2:18: text: must be ',', got the end of the file"),
    ],
)  # fmt: skip
def test_mistakes_have_places(text, message, tmp_path):
    path = csg_file(tmp_path, text, "a.csg")
    with pytest.raises(co.SceneFileError) as error:
        co.load(path)
    assert str(error.value).startswith(f"{path}{message}"), str(error.value)


def test_files_nested_without_end_are_refused(tmp_path):
    with pytest.raises(co.SceneFileError, match="is nested more than 200 deep"):
        load_text(tmp_path, "group() {" * 100_000)
    with pytest.raises(co.SceneFileError, match="must be"):
        load_text(tmp_path, "cube(size = " + "[" * 100_000)
    with pytest.raises(co.SceneFileError):
        load_text(tmp_path, "group() " * 100_000 + ";")


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("intersection() { cube(size = 2); %sphere(r = 1); }", "cube(size = 2);"),
        ("intersection() { cube(size = 2); *sphere(r = 1); }", "cube(size = 2);"),
        ("difference() { %cube(size = 2); cube(size = 3); sphere(r = 1); }", "difference() { cube(size = 3); sphere(r = 1); }"),
        (
            "linear_extrude(height = 1) { intersection() { square(size = 2); %circle(r = 1); } }",
            "linear_extrude(height = 1) { square(size = 2); }",
        ),
        ("cube(size = 9); group() { *group() { !cube(size = 4); } !cube(size = 2); !cube(size = 3); }", "cube(size = 2);"),
    ],
)  # fmt: skip
def test_modifiers_within_calls(text, same, tmp_path):
    """OpenSCAD's GeometryEvaluator passes over background children, and its root is the first "!" in the tree."""
    assert load_text(tmp_path, text).bodies == load_text(tmp_path, same).bodies


@pytest.mark.parametrize("head", ["", "\ufeff", "// a comment\n", "/* two\nlines */ ", "%"])
def test_files_are_known_by_their_first_call(head, tmp_path):
    found = detect_format(
        csg_file(
            tmp_path, head + "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = 1); }"
        )
    )
    assert found.name == "OpenSCAD's .csg"
