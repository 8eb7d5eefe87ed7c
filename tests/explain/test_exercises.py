"""Explanations of the exercises of the source documents, line by line: their numbers, or hand algebra."""

import math
from fractions import Fraction as F

import pytest

import conicoid as co

from ..seeds.test_shapes import CENTER, CORNERS, CYLINDER, DIRECTION, GENERAL, P1, P2, P3, POINT, RADIUS, start

CLOSE = dict(rel=1e-14, abs=1e-14)


def explanation(shape, origin, direction, **limits: float):
    return co.Scene([shape]).explain([float(x) for x in origin], [float(x) for x in direction], **limits)


def lines(found) -> list[str]:
    """Return the lines of the text, without the sources behind them."""
    return [line.strip().split("   [")[0] for line in found.text.splitlines()]


def has(found, *expected: str) -> None:
    """Assert that the text has these lines, in this order."""
    text, at = lines(found), 0
    for line in expected:
        assert line in text[at:], f"{line!r} is not in\n" + "\n".join(text[at:])
        at += text[at:].index(line) + 1


def sources(found) -> set[str]:
    return {line.split("   [")[1].rstrip("]") for line in found.text.splitlines() if "   [" in line}


UP, LINE = (0, 0, 1), dict(t_min=-math.inf)
PLANE, PIPE = co.Plane((1, 2, 2), 6), co.Quadric(coefficients=dict(xx=1, yy=4, constant=-1))
PINNED = co.Cylinder(P1, P2, 2, reference=P3)
LINES = {  # shape, origin, direction, interval, and lines of the explanation in this order
    # At 4 beside the center B = −5, C = 16 + 25 − 9 = 32, D = 25 − 32 = −7; by the chord 9 − 16
    "a negative discriminant": (co.Sphere(RADIUS, CENTER), (1, 2, -2), UP, {}, [
        "center S = (1, −2, 3), r = 3", "t² + 2 B t + C = 0", "B = (d, o − S) = −5", "C = (o − S)² − r² = 32",
        "D = B² − C = −7 < 0: no real root", "OC² = 41, r² = 9: the origin is outside", "t_ca = (OC, d) = 5",
        "D² = OC² − t_ca² = 16, the squared distance of the line from S", "t_hc² = r² − D² = −7 < 0: no real root"]),
    # x + 2y + 2z = 6 from (1, 1, 8) along −z: v_d = −2, v_0 = 6 − 19 = −13, t = 6.5
    "a plane": (PLANE, (1, 1, 8), (0, 0, -1), {}, [
        "surface 0, plane: x + 2 y + 2 z − 6 = 0", "n = (1, 2, 2), q = 6", "v_d = n·d = −2, v_0 = q − n·o = −13", "t = v_0 / v_d = 6.5"]),
    "a plane behind": (PLANE, (1, 1, 8), UP, {}, [
        "its crossings lie outside the interval of t", "t = v_0 / v_d = −6.5: not within 0 < t < ∞"]),
    "a parallel plane": (co.Plane(UP, 1), (0, 0, 0), (1, 0, 0), {}, ["the ray is parallel to its plane", "v_d = 0: parallel, no crossing"]),
    "a one-sided plane": (co.Plane(UP, 0, one_sided=True), (0, 0, -2), UP, {}, ["it is one-sided and seen from behind"]),
    # x −1 to 3, y 0.5 to 1, z −2 to 2: inside from 0.5 to 1
    "slabs of a box": (co.Box((-1, 2, 1), (3, 3, 3)), (0, 4, 2), (1, -2, 0.5), {}, [
        "x: −1 to 3, origin 0, direction 1: t₁ = −1, t₂ = 3", "t_near = −1, t_far = 3",
        "y: 2 to 3, origin 4, direction −2: t₁ = 1, t₂ = 0.5, swapped", "t_near = 0.5, t_far = 1",
        "z: 1 to 3, origin 2, direction 0.5: t₁ = −2, t₂ = 2", "t_near = 0.5, t_far = 1",
        "all slabs have t_near ≤ t_far: a hit", "its planes leave t from 0.5 to 1"]),
    # Along the axis of x² + y² − z = 0 from (1, 2, 0): a = 0, b = −1, c = 5, t = −c/b = 5
    "a = 0, step 1 of the algorithm": (co.Quadric(coefficients=dict(xx=1, yy=1, z=-1)), (1, 2, 0), UP, {}, [
        "enters body 0 “Quadric 0” at t = 5, face 0, surface 0", "face 0, within surface 0, elliptic paraboloid: x² + y² − z = 0",
        "A = 1, E = 1, I = −0.5", "a t² + b t + c = 0: a = uᵗQu = 0, b = 2 uᵗQp = −1, c = pᵗQp = 5", "a = 0: t = −c / b = 5"]),
    "a = b = 0 inside, which the notes leave out": (PIPE, (0.5, 0, 0), UP, LINE, ["a = b = 0: the ray is inside all along, as c = −0.75"]),
    "a = b = 0 outside": (PIPE, (2, 0, 0), UP, LINE, ["a = b = 0: the ray is outside all along, as c = 3"]),
    # At X = 2 the ray touches, D = 0; at X = 2.5 D = 4 − 6.25
    "discriminant 0 of equation 8": (PINNED, (6, 1, 2), (-1, 0, 0), {}, [
        "nothing is hit: t = ∞", "(8) D = 0 = 0: it only touches", "read as invisible: no crossing"]),
    "negative discriminant of equation 8": (PINNED, (6, 1, 2.5), (-1, 0, 0), {}, ["nothing is hit: t = ∞", "(8) D = −2.25 < 0: no real root"]),
    # KVADR: t² − 3t + 2 = 0, the parabolic cylinder x² <= y along (1, 3, 0) from (0, −2, 0)
    "KVADR": (co.ParabolicCylinder(0.5), (0, -2, 0), (1, 3, 0), {}, [
        "A = 1, G = −0.5", "a t² + b t + c = 0: a = uᵗQu = 1, b = 2 uᵗQp = −3, c = pᵗQp = 2", "b² − 4 a c = 1",
        "t₀ = (−b − √(b² − 4 a c)) / 2a = 1", "t₁ = (−b + √(b² − 4 a c)) / 2a = 2", "inside for t in [1, 2]"]),
    # PICA: along z at x = 6, x² + y² <= 4 z² has a = −4, c = 36, t = ±3. The inside is beyond the roots
    "PICA": (co.DoubleCone(slope=2), (6, 0, 0), UP, LINE, [
        "a t² + b t + c = 0: a = uᵗQu = −4, b = 2 uᵗQp = 0, c = pᵗQp = 36", "its negative side is beyond its roots"]),
    # Up at x = 1/2 the bow tie x² + y² <= z², |z| <= 1 is inside from −1 (cap) to −1/2 and from 1/2 to 1 (cap)
    "a bow tie": (co.DoubleCone(1, z_range=(-1, 1)), (0.5, 0, 0), UP, LINE, [
        "its planes leave t from −1 to 1", "inside, on the whole line: [−1, −0.5], [0.5, 1]"]),
}  # fmt: skip


@pytest.mark.parametrize("name", LINES)
def test_lines_of_an_exercise(name):
    shape, origin, direction, interval, expected = LINES[name]
    has(explanation(shape, origin, direction, **interval), *expected)


# ---- The ray tracing notes: ray and sphere ----

SPHERES = {
    # o − S is N − before·d with |N|² = 5 across d: B = −before, C = 5 + before² − 9, D = 4, t = before ∓ 2
    "3. t0, t1 > 0": (6, (-6, 32, 4, 4, 8), (41, 6, 5, 4), 4, "t₀, t₁ > 0: both lie ahead", "outside", "−"),
    "2. t0 < 0 < t1": (1, (-1, -3, 4, -1, 3), (6, 1, 5, 4), 3, "t₀ < 0 < t₁: the ray starts between its crossings", "inside", "+"),
    "1. t0, t1 < 0": (-3, (3, 5, 4, -5, -1), (14, -3, 5, 4), None, "t₀, t₁ ≤ 0: it lies behind the origin", "outside", ""),
}  # fmt: skip


@pytest.mark.parametrize("case", SPHERES)
def test_sphere_by_both_methods(case):
    before, algebraic, geometric, t, line, where, sign = SPHERES[case]
    found = explanation(co.Sphere(RADIUS, CENTER), start(before), DIRECTION)
    numbers = found.bodies[0].surface.board.numbers
    assert [numbers[k] for k in ("B", "C", "D", "t0", "t1")] == pytest.approx(algebraic, **CLOSE)
    assert [numbers[k] for k in ("OC2", "t_ca", "h2", "t_hc2")] == pytest.approx(geometric, **CLOSE)
    has(found, "t² + 2 B t + C = 0", line)
    assert any(line.endswith(f"r² = 9: the origin is {where}") for line in lines(found))
    if t is None:
        has(found, "t_ca < 0 and the origin is outside: the ray misses")
        assert found.bodies[0].outcome in ("box missed", "ball missed")
        assert found.hit.t == math.inf
    else:
        assert numbers["t"] == pytest.approx(t, **CLOSE)
        assert found.hit.t == pytest.approx(t, **CLOSE)
        assert any(line.startswith(f"t = t_ca {sign} t_hc = ") for line in lines(found))
    names = {'the ray tracing notes, "ray and sphere", the algebraic method'}
    assert names <= sources(found)


# ---- The ray tracing notes: plane, polygon, box ----


def test_polygon_exercise():
    """The plane is x + 2y + z + 2 = 0 (erratum). Without y the edges cross at −1 + 3·6/4 = 3.5 and at 6: outside."""
    found = explanation(co.Polygon(CORNERS), (-2, -7, 4), (0, 1, 0))
    has(found, "nothing is hit: t = ∞", "the ray crosses its plane outside its outline", "surface 0, plane: x + 2 y + z + 2 = 0",
        "the ray crosses the plane at t = 5, at (−2, −2, 4)", "moved to the point: (−1, 3), (5, −1), (6, 0)",
        "edge 1 crosses the u axis at u = 3.5 > 0: counted", "edge 2 crosses the u axis at u = 6 > 0: counted",
        "2 crossings, even: outside")  # fmt: skip
    numbers = found.bodies[0].outline.board.numbers
    assert (numbers["edge 1"], numbers["edge 2"], numbers["crossings"]) == (3.5, 6, 2)
    # P = α A + β B + γ C in (x, z), by Cramer's rule
    (ax, _, az), (bx, _, bz), (cx, _, cz) = CORNERS
    x, _, z = POINT
    whole = F((bx - ax) * (cz - az) - (cx - ax) * (bz - az))
    beta = F((x - ax) * (cz - az) - (cx - ax) * (z - az)) / whole
    gamma = F((bx - ax) * (z - az) - (x - ax) * (bz - az)) / whole
    assert [numbers[k] for k in ("alpha", "beta", "gamma")] == [float(1 - beta - gamma), float(beta), float(gamma)]


def test_a_point_within_the_polygon():
    """The middle of the corners, (4, −12, 14)/3, seen along the normal: α = β = γ = 1/3."""
    found = explanation(co.Polygon(CORNERS), (F(4, 3) + 1, -4 + 2, F(14, 3) + 1), (-1, -2, -1))
    numbers = found.bodies[0].outline.board.numbers
    assert numbers["crossings"] == 1
    assert [numbers[k] for k in ("alpha", "beta", "gamma")] == pytest.approx([1 / 3] * 3, rel=1e-13)
    assert found.hit.t == pytest.approx(1, rel=1e-14)


def test_box_exercise():
    """R₀ = (0, 4, 2), R_d = (0.213, −0.436, 0.873), B from (−1, 2, 1) to (3, 3, 3), in decimals to four digits."""
    found = explanation(co.Box((-1, 2, 1), (3, 3, 3)), (0, 4, 2), (0.213, -0.436, 0.873))
    numbers = found.bodies[0].box.board.numbers
    expected = {"x t1": -4.6948, "x t2": 14.0845, "y t1": 4.5872, "y t2": 2.2936, "z t1": -1.1455, "z t2": 1.1455,
                "t_near": 2.2936, "t_far": 1.1455}  # fmt: skip
    assert numbers == pytest.approx(expected, abs=5e-5)
    text = [line.split(":")[0] for line in lines(found) if line[:2] in ("x:", "y:", "z:")][:3]
    assert text == ["x", "y", "z"]
    # After X it is (−4.69, 14.08), after Y (2.29, 4.59); after Z there is no hit
    running = [line for line in lines(found) if line.startswith("t_near = ")][:3]
    near = [float(line.split("t_near = ")[1].split(",")[0].replace("−", "-")) for line in running]
    far = [float(line.split("t_far = ")[1].replace("−", "-")) for line in running]
    assert near == pytest.approx([-4.6948, 2.2936, 2.2936], abs=5e-5)
    assert far == pytest.approx([14.0845, 4.5872, 1.1455], abs=5e-5)
    has(found, "nothing is hit: t = ∞", "t_near > t_far: no hit")
    assert any("t₁ = 4.58" in line and line.endswith(", swapped") for line in lines(found))


# ---- The ray tracing notes: quadrics ----


def test_general_quadric():
    """x² + y² + z² + xy − 3 along (1, 1, 0): a = A + E + 2B = 3, b = 0, c = −3, b² − 4ac = 36, t = ∓6/6; gradient (3, 3, 0)."""
    found = explanation(co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, constant=-3)), (0, 0, 0), (1, 1, 0))
    gradient = next(line for line in lines(found) if line.startswith("half the gradient (Ax + By + Cz + D, Bx + Ey"))
    x, y, z = gradient.partition(" = (")[2].rstrip(")").split(", ")
    assert (float(x), float(y), float(z)) == pytest.approx((1.5, 1.5, 0), rel=1e-15)
    has(found, "face 0, within surface 0, ellipsoid: x² + y² + z² + xy − 3 = 0", "A = 1, E = 1, H = 1, B = 0.5, J = −3",
        "a t² + b t + c = 0: a = uᵗQu = 3, b = 2 uᵗQp = 0, c = pᵗQp = −3", "b² − 4 a c = 36",
        "t₀ = (−b − √(b² − 4 a c)) / 2a = −1", "t₁ = (−b + √(b² − 4 a c)) / 2a = 1")  # fmt: skip


KINDS = [
    (co.Ellipsoid.from_coefficients(4, 0.25, 1), "ellipsoid", "4 x² + 0.25 y² + z² = 1", (2, 1, 0.5)),  # 1/√E, 1/√H, 1/√A
    (co.EllipticParaboloid(4, 0.25), "elliptic paraboloid", "4 x² + 0.25 y² − z = 0", (0.125, 2)),  # radii 1/2A, 1/2E
    (co.HyperbolicParaboloid(4, 0.25), "hyperbolic paraboloid", "4 x² − 0.25 y² − z = 0", (0.125, 2)),
    (co.OneSheetHyperboloid(4, 0.25, 1), "one-sheet hyperboloid", "4 x² + 0.25 y² − z² = 1", (2, 0.5, 1)),
    (co.TwoSheetHyperboloid(4, 0.25, 1), "two-sheet hyperboloid", "4 x² + 0.25 y² − z² = −1", (2, 0.5, 1)),
    (co.EllipticCone(4, 0.25, 1), "elliptic cone", "4 x² + 0.25 y² − z² = 0", (2, 0.5)),
    (co.EllipticCylinder(4, 0.25), "elliptic cylinder", "4 x² + 0.25 y² = 1", (2, 0.5)),
    (co.HyperbolicCylinder(4, 0.25), "hyperbolic cylinder", "4 x² − 0.25 y² = 1", (0.5, 2)),
    (co.ParabolicCylinder(3), "parabolic cylinder", "x² − 6 y = 0", (3,)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "kind", "equation", "semi_axes"), KINDS, ids=[kind for _, kind, *_ in KINDS])
def test_the_nine_canonical_quadrics(shape, kind, equation, semi_axes):
    """The equations have A = 4, E = 1/4, H = 1 (G = 3), and a = 1/√A and so on, the longest first."""
    surface = co.Scene([shape]).surface(0)
    assert (surface.kind, surface.equation) == (kind, equation)
    assert sorted(surface.classification.semi_axes) == pytest.approx(sorted(semi_axes), rel=1e-15)
    moved = co.Scene([shape.rotate((1, 2, 3), 40).translate((5, -2, 1))]).surface(0)
    assert moved.kind == kind
    assert sorted(moved.classification.semi_axes) == pytest.approx(sorted(semi_axes), rel=1e-14)


# ---- The Clemson notes ----


@pytest.mark.parametrize("case", GENERAL)
def test_the_six_cases_of_caps(case):
    (x, y), (u, v), caps, body, expected = GENERAL[case]
    found = co.Scene([CYLINDER]).explain((x, y, 0), (u, v, 0))
    cell = found.bodies[0].cells[0]
    assert cell.case == int(case[0])
    walls = {face.face: face.entries + face.exits for face in cell.faces}
    assert sorted(walls[0]) == pytest.approx(body, **CLOSE)
    assert sorted(walls[1] + walls[2]) == pytest.approx(caps, **CLOSE)
    words = {1: "c₁ c₂ b₁ b₂: miss", 2: "c₁ b₁ c₂ b₂: hit body, exit cap", 3: "c₁ b₁ b₂ c₂: hit body, exit body",
             4: "b₁ c₁ b₂ c₂: hit cap, exit body", 5: "b₁ c₁ c₂ b₂: hit cap, exit cap", 6: "b₁ b₂ c₁ c₂: miss"}  # fmt: skip
    has(found, f"caps and body in order, case {case[0]}: {words[int(case[0])]}")
    true = [(one.t, one.face) for one in cell.candidates if one.outside_of is None]
    if expected is None:
        assert true == []
    else:
        assert [face for _, face in true] == [face for _, face in expected]
        assert [t for t, _ in true] == pytest.approx([t for t, _ in expected], **CLOSE)


def test_sphere_of_radius_three():
    """The notes' example is diag(1, 1, 1, −1), scaled by 3: diag(1/9, 1/9, 1/9, −1), here times 9."""
    scene = co.Scene([co.Quadric(matrix=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]).scale(3)])
    surface = scene.surface(0)
    assert surface.equation == "x² + y² + z² = 9"
    assert surface.coefficients == {"xx": 1, "yy": 1, "zz": 1, "constant": -9}
    assert (surface.kind, surface.classification.semi_axes) == ("sphere", (3.0,))


# ---- Sasaki 2021 ----


def test_cylinder_by_equations_2_to_12():
    """From (6, 1, 1) along (−1, 0, 0): locally (1, 5, 1) along (0, −1, 0); a = 1, b = −5, c = 1 + 25 − 4 = 22, D = 3,
    t = 5 ∓ √3, (X, Y, Z) = (1, ±√3, 1), θ = ±60°."""
    found = explanation(co.Cylinder(P1, P2, 2, reference=P3), (6, 1, 1), (-1, 0, 0))
    step = next(face.surface for face in found.bodies[0].cells[0].faces if face.face == 0)
    has(found, "p₁ = (1, 0, 0), r = 2", "(2) R_X = (0, 0, 1), R_Y = (1, 0, 0), R_Z = (0, 1, 0)",
        "(5) (X₀, Y₀, Z₀) = (1, 5, 1), (U, V, W) = (0, −1, 0)",
        "(7) (U² + V²) t² + 2 (X₀U + Y₀V) t + X₀² + Y₀² − r² = 0: t² − 10 t + 22 = 0", "(8) D = 3")  # fmt: skip
    numbers, root = step.board.numbers, math.sqrt(3)
    assert (numbers["t-"], numbers["t+"]) == pytest.approx((5 - root, 5 + root), **CLOSE)
    assert (numbers["Z-"], numbers["Z+"]) == (1, 1)
    assert (numbers["angle-"], numbers["angle+"]) == pytest.approx((60, -60), **CLOSE)
    assert found.hit.t == pytest.approx(5 - root, **CLOSE)
    assert "Sasaki 2021 (2) to (10)" in sources(found)


# ---- The graphics textbook ----


def test_allips():
    """x²/4 + y²/9 + z² = 1 along (1, 1, 0) from (−9, −9, 0): (1/4 + 1/9) (t − 9)² = 1: t = 9 ∓ 6/√13."""
    found = explanation(co.Ellipsoid((2, 3, 1)), (-9, -9, 0), (1, 1, 0))
    has(found, "face 0, within surface 0, ellipsoid: 0.25 x² + y²/9 + z² = 1")
    numbers, square = found.bodies[0].cells[0].faces[0].surface.board.numbers, F(13, 36)
    assert numbers["a"] == pytest.approx(float(square), rel=1e-15)
    assert numbers["b"] == pytest.approx(float(-18 * square), rel=1e-15)
    assert numbers["c"] == pytest.approx(float(81 * square - 1), rel=1e-15)
    assert (numbers["t0"], numbers["t1"]) == pytest.approx((9 - 6 / math.sqrt(13), 9 + 6 / math.sqrt(13)), **CLOSE)


def test_false_intersections_of_figure_3_4_8():
    """The ray crosses the wall beyond the end of the cylinder, x = −1 at z = 3, t = 1, and the caps at t = 2 and 4."""
    found = explanation(co.Cylinder((0, 0, 0), (0, 0, 2), 1), (-2, 0, 4), (1, 0, -1))
    cell = found.bodies[0].cells[0]
    assert [(c.t, c.face, c.entering, c.outside_of) for c in cell.candidates] == [
        (1, 0, True, 2), (2, 2, True, None), (3, 0, False, None), (4, 1, False, 0),
    ]  # fmt: skip
    has(found, "1  face 0    enters  false: outside of face 2", "2  face 2    enters  true",
        "3  face 0    leaves  true", "4  face 1    leaves  false: outside of face 0")  # fmt: skip
    assert "the graphics textbook, false intersections; NA8FIR" in sources(found)


@pytest.mark.parametrize("shape", [co.Sphere(2, (0, 0, 1)), co.Ellipsoid((1, 2, 4)), co.EllipticCylinder(1, 0.25)])
def test_tangency_is_invisibility(shape):
    """Along x at y = 2 the discriminant is zero."""
    found = explanation(shape, (-5, 2, 1 if isinstance(shape, co.Sphere) else 0), (1, 0, 0))
    assert found.bodies[0].outcome == "only touched"
    assert not found.hit.hit
    has(found, "the ray only touches it, which counts as a miss", "read as invisible: no crossing")
    assert "the graphics textbook, tangency is invisibility" in sources(found)
    assert found.decision.first in ("certified", "exact")


# ---- Roth's Booleans ----


def test_the_sweep_of_a_difference():
    """A drum from z = 0 to 2 less a ball of radius 1/2 about z = 1, up its axis from z = −5: 5, 5.5, 6.5, 7."""
    found = explanation(co.Cylinder((0, 0, 0), (0, 0, 2), 1) - co.Sphere(0.5, (0, 0, 1)), (0, 0, -5), (0, 0, 1))
    sweep = found.bodies[0].sweep
    assert sweep.expression == "A ∩ ¬B"
    rows = [(row.t, row.letter, row.entering, row.inside, row.count, row.need, row.value) for row in sweep.rows]
    assert rows == [
        (5.0, "A", True, "A", 2, 2, True), (5.5, "B", True, "AB", 1, 2, False),
        (6.5, "B", False, "A", 2, 2, True), (7.0, "A", False, "", 1, 2, False),
    ]  # fmt: skip
    has(found, "the body is A ∩ ¬B", "before all events: outside", "inside for t in [5, 5.5], [6.5, 7]")


def test_coincident_walls_act_together():
    """Two boxes share the wall x = 0. At t = 1 the ray leaves one and enters the other, and stays inside of the union."""
    found = explanation(co.Box((-1, -1, -1), (0, 1, 1)) | co.Box((0, -1, -1), (1, 1, 1)), (-1 - 1, 0, 0), (1, 0, 0))
    rows = [(row.t, row.letter, row.entering, row.value) for row in found.bodies[0].sweep.rows]
    assert rows == [(1, "A", True, True), (2, "A", False, True), (2, "B", True, True), (3, "B", False, False)]
    assert [c.t for c in found.crossings] == [1, 3]


def test_a_negative_square_exchanges_the_roots():
    """Within the asymptotic cone steps 3 and 4 of the notes would report the farther crossing."""
    scene = co.Scene([co.TwoSheetHyperboloid(1, 1, 1)])
    text = str(scene.explain((0, 0, 5), (0, 0, -1)))  # at t = 4 and 6
    assert "t₀ = (−b − √(b² − 4 a c)) / 2a = 6" in text
    assert "a < 0: t₀ > t₁, and the notes, which try t₀ first, would take the farther one" in text
    assert scene.first_hit((0, 0, 5), (0, 0, -1)).t == 4


def test_numbers_beyond_floats_are_infinite():
    """A ray runs nearly along a turned plane. Exactly, they meet at some 1e900, in front or behind."""
    plane = co.HalfSpace((1, -1, 0), 0).rotate((1, 1, 1), 20)
    texts = [str(co.Scene([shape]).explain((1, 0, 0), (1, 1, 1))) for shape in (plane, ~plane)]
    assert all("∞" in text for text in texts)
