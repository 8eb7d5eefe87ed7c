"""How well rays and points are conditioned: by formulas, and by force."""

import dataclasses
import itertools
import math
import tracemalloc
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import conicoid as co
from conicoid.apps.checks.conditioning import (
    SINGLE_PRECISION_DIGITS,
    Conditioning,
    _part as prepare_part,
    conditioning,
    digits,
)
from conicoid.apps.checks.critical_points import movement
from conicoid.apps.checks.perturbation import MotionFields, OwnForms, number_changes, own_frame

from ..command_line import run
from ..samples import marked
from ..shapes.samples import SAMPLES

# --- Digits that remain, against formulas; which numbers a report names and which it omits


@pytest.mark.parametrize("center", [(1e3, 0, 0), (-3e5, 4e5, 0), (2e9, 3e9, 6e9)])
@pytest.mark.parametrize("radius", [1.0, 0.25])
def test_a_ball_far_away(center, radius):
    """The surface moves by at most u (|c| + r), of its width 2 r."""
    expected = -math.log10(U * (np.linalg.norm(center) + radius) / (2 * radius))
    assert remaining_digits(co.Sphere(radius, center)) == pytest.approx(expected, abs=1e-6)
    assert remaining_digits(co.Spheres([center, (0, 0, 0)], radius)) == pytest.approx(expected, abs=1e-6)
    # Σ |n_k c_k| is |c| along n = c / |c|; the ellipsoid's extent counts as that of its box there, at most √3 times more
    ellipsoid = remaining_digits(co.Ellipsoid((radius,) * 3, center))
    assert expected - 0.1 <= ellipsoid <= expected + math.log10(math.sqrt(3)) + 0.1
    moved = only(co.Sphere(radius).translate(center))
    assert moved.digits == pytest.approx(expected, abs=1e-6)
    assert moved.number == f"move[0].translate[{int(np.abs(center).argmax())}]"


def test_a_cone_by_coefficients_loses_half_at_its_apex():
    # (x - 1)² + (y - 2)² = (z - 3)²: at the apex F = u Σ |terms| = 46 u, and the movement √(F / 3 w²) for widths w; the
    # cone is endless, and the check takes it from -6 to 6: the box reaches to 4, and its edge of 2 is added
    values = dict(xx=1, yy=1, zz=-1, x=-2, y=-4, z=6, constant=-4)
    found = only(co.Quadric(coefficients=values), co.Box((0, 1, 2), (2, 3, 4)))
    assert found.digits == pytest.approx(-math.log10(math.sqrt(46 * U / (3 * 12**2))), abs=0.01)
    np.testing.assert_allclose(found.point, (1, 2, 3), atol=1e-6)
    assert "double point" in found.reason
    assert remaining_digits(co.EllipticCone(1, 1, 1, z_range=(-1, 1)).translate((1, 2, 3))) > 15
    # (x - 1)² = 0, from -3 to 3: F = u (1 + 2 + 1)
    double = only(co.Quadric(coefficients=dict(xx=1, x=-2, constant=1)), co.Box())
    assert double.digits == pytest.approx(-math.log10(math.sqrt(4 * U / 6**2)), abs=0.01)


def test_needles_lose_when_they_are_turned_only():
    # 30° times u at a distance of 1e12 of one end, against a thickness of 1 to √2
    box = co.Box((0, 0, 0), (1, 1, 1e12))
    assert remaining_digits(box) == ALL
    turned = only(box.rotate((1, 0, 0), 30))
    swing = 1e12 * math.radians(30) * U
    assert -math.log10(2 * swing) <= turned.digits <= -math.log10(swing / math.sqrt(2))
    assert turned.number == "move[0].rotate.degrees"
    assert "as long as thick" in turned.reason
    assert remaining_digits(co.Ellipsoid((1, 1, 1e12))) == ALL
    assert remaining_digits(co.Ellipsoid((1, 1, 1e12)).rotate((1, 2, 3), 30)) < 6
    assert remaining_digits(co.Cylinder((0, 0, 0), (1e8, 2e8, 3e8), 1)) < 8.5


def test_nearly_singular_motions():
    # Squeezed to 1e-10 along (1, -1): entries of order 1 change by u, against a half width of about 1e-10 / 2√2
    shear = [[1, 1, 0, 0], [1, 1 + 1e-10, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    for shape in (co.Sphere(), co.Cylinder((0, 0, -1), (0, 0, 1), 1), co.Box()):
        found = only(shape.transform(shear))
        assert 5 < found.digits < 7
        assert "nearly singular, of condition number 4.0e+10" in found.reason
    assert remaining_digits(co.Sphere().scale((1, 1, 1e-12))) == ALL


@pytest.mark.parametrize("altitude", [1e-3, 1e-8, 1e-12])
def test_slivers(altitude):
    # The third corner moves by u (0.5 + 1) or so, against the altitude
    flat = ((0, 0, 1), (1, 0, 1), (0.5, altitude, 1))
    expected = -math.log10(U / altitude)
    for shape in (co.Triangle(*flat), co.Polygon(flat)):
        assert expected - 0.5 <= remaining_digits(shape) <= expected + 0.5
    assert remaining_digits(co.Triangle((0, 0, 1), (1, 0, 1), (0.5, 1, 1))) > 15


def test_an_anchor_far_from_the_origin():
    for shape in (
        co.Disc((1e9, 0, 0), (1, 1, 1), 0.5),
        co.Box((1e9, 0, 0), (1e9 + 1, 1, 1)),
        co.Disc((0, 0, 0), (1, 1, 1), 0.5).translate((1e9, 0, 0)),
    ):
        found = only(shape)
        assert found.digits == pytest.approx(-math.log10(1e9 * U), abs=0.5)
        assert "from the origin" in found.reason
    hole = co.Box() - co.Cylinder((0.5, 0.5, -2), (0.5, 0.5, 2), 1e-10)
    found = only(hole)
    assert found.part == "Cylinder"
    assert 6 < found.digits < 7


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.name)
def test_ordinary_shapes_keep_their_digits(sample):
    assert (
        np.nan_to_num(remaining_digits(sample.shape), nan=ALL) > 7.8
    )  # half of them where surfaces touch or have an apex
    if type(sample.shape) not in (co.Quadric, co.HyperbolicParaboloid, co.ParabolicCylinder, co.HyperbolicCylinder):
        assert remaining_digits(sample.shape) > 12


@settings(max_examples=15, deadline=None)
@given(st.integers(-40, 40), st.sampled_from(["ball", "cylinder", "quadric", "box", "triangle"]))
def test_digits_have_no_unit_of_length(exponent, kind):
    k = 2.0**exponent
    shape = {
        "ball": lambda k: co.Sphere(k, (30 * k, 5 * k, -7 * k)),
        "cylinder": lambda k: co.Cylinder((k, 2 * k, 300 * k), (k, 5 * k, 301 * k), 0.25 * k),
        "quadric": lambda k: co.Quadric(
            coefficients=dict(xx=1, yy=2, zz=3, x=-100 * k, y=50 * k, constant=2000 * k * k)
        ),
        "box": lambda k: co.Box((100 * k, k, k), (101 * k, 2 * k, 2 * k)).rotate((1, 2, 3), 40),
        "triangle": lambda k: co.Triangle((k, k, k), (2 * k, k, 1.5 * k), (k, 30 * k, k)),
    }[kind]
    assert remaining_digits(shape(k)) == pytest.approx(remaining_digits(shape(1.0)), abs=1e-3)


def test_the_worst_part_speaks_for_its_body():
    far = co.Sphere(1).translate((1e10, 0, 0))
    for body in (
        co.Sphere(2, (1e10, 0, 0)) - far,
        co.Box().translate((1e10, 0, 0)) | far,
        ~far,
        co.Disc((0, 0, 0), (0, 0, 1), 1) - far,
    ):
        assert only(body).digits == pytest.approx(remaining_digits(far), abs=1e-3)
    inside = (co.Box() - co.Sphere(0.5)).translate((1e10, 0, 0))
    assert only(inside).number == "move[0].translate[0]"


def test_bodies_without_anything_to_look_at_are_missing():
    nothing = co.Quadric(coefficients=dict(xx=1, constant=1))
    scene = co.Scene([nothing, co.Sphere(), co.Box() & co.Box((3, 3, 3), (4, 4, 4)), co.Spheres(np.zeros((2, 3)), 1)])
    assert [one.body for one in conditioning(scene)] == [1, 3, 4]
    assert np.isnan(digits(scene)).tolist() == [True, False, True, False, False]
    assert conditioning(co.Scene([])) == []
    assert [one.body for one in conditioning(scene, below=5)] == []


def test_endless_bodies_are_measured_by_their_finite_walls():
    assert remaining_digits(co.HalfSpace((1, 2, 3), 5)) > 14
    assert remaining_digits(co.Plane((0, 0, 1), 1e9)) > 14
    tube = co.Quadric(coefficients=dict(xx=1, yy=1, x=-2e5, constant=1e10 - 1))  # (x - 1e5)² + y² <= 1
    assert 4.5 < only(tube, co.Box((1e5, 0, 0), (1e5 + 1, 1, 1))).digits < 6.5  # u D² / 1, some of them


def test_every_number_is_changed_and_nothing_else():
    shape = co.Cylinder((0, 2, 3), (4, 5, 6), 0.5, 0, 90, reference=(1, 0, 0))
    found = list(number_changes(shape))
    assert [change.number for change in found] == (
        ["start[1]", "start[2]", "end[0]", "end[1]", "end[2]", "radius", "end_angle", "reference[0]"]
    )
    radius = next(change for change in found if change.number == "radius")
    assert radius.result == co.Cylinder((0, 2, 3), (4, 5, 6), math.nextafter(0.5, 1), 0, 90, reference=(1, 0, 0))
    assert radius.share * (radius.result.radius - 0.5) == 0.5 * U
    moved = co.Sphere().rotate((0, 0, 2), 30).translate((1, 0, 0)).motion
    assert [change.number for change in number_changes(moved)] == [
        "[0].axis[2]",
        "[0].degrees",
        "[1].offset[0]",
    ]
    quadric = co.Quadric(coefficients=dict(xx=2, z=-1))
    assert [dict(change.result.coefficients) for change in number_changes(quadric)] == [
        dict(xx=math.nextafter(2, 3), z=-1), dict(xx=2, z=math.nextafter(-1, -2)),
    ]  # fmt: skip
    assert [change.number for change in number_changes(co.Ellipsoid.from_coefficients(1, 2, 3))] == [
        f"coefficients[{k}]" for k in range(3)
    ]
    inner = co.HyperbolicCylinder(1, 2, within=co.Box((0, 0, 0), (1, 1, 1)).translate((0, 0, 5)))
    assert "within.motion[0].offset[2]" in [change.number for change in number_changes(inner)]


def test_check_and_the_command_line_name_them(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        "bodies:\n  - {shape: {Sphere: {radius: 1}}}\n"
        "  - {name: far, shape: {Quadric: {coefficients: {xx: 1, yy: 1, zz: 1, x: -2.0e+6, constant: 999999999999}}}}\n"
    )
    (finding,) = co.check(co.load(path), rays=300)
    assert (finding.kind, finding.bodies, finding.origin) == ("lost digits", (1,), None)
    assert 3 < finding.size < 5
    text = run("info", path, "--check", "--rays", "300").stdout
    assert "lost digits: body 1 (far) keeps" in text
    assert (
        "coefficients.constant of its Quadric counts most" in text
        or "coefficients.x of its Quadric counts most" in text
    )
    assert "sphere; center (1000000, 0, 0); radius 1; inside: within" in text


@pytest.mark.parametrize("radius", [1.0, 5.0])
def test_level_edges_of_a_profile_stay_level(radius):
    """One decimal stands at both ends of such an edge. So the end moves by u |z|, of a length of 2 |z|."""
    corners = ((0, -20.7), (radius, -20.7), (radius, 20.7), (0, 20.7))
    tube = co.Revolution(corners)
    assert remaining_digits(tube) > 14.5
    assert remaining_digits(tube.scale((10.1, 14.3, 1))) == pytest.approx(
        remaining_digits(co.Cylinder((0, 0, -20.7), (0, 0, 20.7), 1)), abs=1.2
    )
    # A body that is thin beside its distance from the origin loses these digits: from 1e6 to 1e6 + 1, u (2e6 + 1) of 1
    far = only(co.Revolution(tuple((r, 1e6 + (z > 0)) for r, z in corners)))
    assert far.number in ("profile[0][1]", "profile[2][1]")
    assert far.digits == pytest.approx(-math.log10(U * 1e6), abs=0.31)


LATTICE = """<geometry>
<surface id="1" type="z-cylinder" coeffs="0 0 0.4"/><surface id="2" type="quadric" coeffs="1 2 0 .5 0 0 0 0 0 -.2"/>
<surface id="3" type="x-plane" coeffs="0"/><surface id="4" type="x-plane" coeffs="{wide}"/>
<surface id="5" type="y-plane" coeffs="-3"/><surface id="6" type="y-plane" coeffs="3"/>
<surface id="7" type="z-plane" coeffs="-2"/><surface id="8" type="z-plane" coeffs="2"/>
<cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="2" region="1"/>
<cell id="3" universe="2" material="1" region="-2"/><cell id="4" universe="2" material="2" region="2"/>
<cell id="5" fill="9" region="3 -4 5 -6 7 -8"/>
<lattice id="9" pitch="{pitch} 1" dimension="6 6" lower_left="0 -3" universes="{universes}"/></geometry>"""


@pytest.mark.parametrize("pitch", marked([(1, False), (1e7, True), (1e9, False)]))
def test_instances_are_named_as_if_each_were_tested(pitch, tmp_path, monkeypatch):
    """The corners of the box of all shifts decide for a kind, while `digits` tests every body."""
    path = tmp_path / "lattice.xml"
    path.write_text(LATTICE.format(wide=6 * pitch, pitch=pitch, universes=" ".join("1 2".split() * 18)))
    scene = co.load(path)
    every = digits(scene)
    assert len(every) == 72
    for below in (every.min() - 0.6, every.min() - 0.4, np.median(every), np.nextafter(every.max(), 99)):
        assert [one.body for one in conditioning(scene, below)] == np.flatnonzero(every < below).tolist()
    tested: list[int] = []
    monkeypatch.setattr(
        "conicoid.apps.checks.conditioning._BodyExaminer.worst", lambda self, shape, body: tested.append(body)
    )
    assert conditioning(scene, every.min() - 0.6) == []
    assert len(tested) < 30 or pitch == 1e9  # there rounding may move one wall past another: each is tested


# --- Digits that remain, against brute force in exact arithmetic: every number up or down, and every combination of them


def test_nearly_parallel_planes_move_their_edge():
    """The planes z <= d and -n z + a x <= b meet at x = (b + n d) / a, here 0.5. The body reaches from -1.5 to there."""
    a, n, d, b = 2.0**-30, 1.0, 0.3, -0.3 + 2.0**-31
    normals = [(0, 0, 1), (a, 0, -n), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
    found = only(co.Polyhedron(normals, [d, b, 1.5, 1, 1]))
    numbers = [Fraction(v) for v in (1, a, n, d, b)]  # the first is the 1 in (0, 0, 1)
    edges = []
    for signs in itertools.product((1, -1), repeat=5):
        one, a_, n_, d_, b_ = (v * (1 + s * Fraction(U)) for v, s in zip(numbers, signs, strict=True))
        edges.append((b_ + n_ * d_ / one) / a_)
    moves = float(max(abs(edge - Fraction(b + n * d) / Fraction(a)) for edge in edges)) / 2
    assert moves * 0.9 <= found.movement <= 3 * moves
    assert "surfaces meet there" in found.reason
    assert found.number in ("normals[0][2]", "normals[1][2]", "offsets[0]", "offsets[1]")


# --- The conditioning report of one shape

U = 2.0**-53
ALL = 53 * math.log10(2)


def only(shape: co.Shape, *others: co.Shape) -> Conditioning:
    found = conditioning(co.Scene([shape, *others]))
    assert [one.body for one in found] == list(range(1 + len(others)))
    return found[0]


def remaining_digits(shape: co.Shape) -> float:
    return float(digits(co.Scene([shape]))[0])


def test_a_corner_within_one_rounding_of_another_has_no_column_to_change():
    # Moved by one unit in the last place, the last corner is the first one: the profile has one corner less
    profile = [(2, 0), (3, 1), (2.5, 3), (1, 2), (math.nextafter(2, 0), 0)]
    assert not list(co.check(co.Scene([co.Revolution(profile)]), rays=100))


_CORNER = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
_TETRAHEDRA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.2, 0.2, 0.2)]


def _flat(kind: str, far: float, thin: float) -> co.Shape:
    """Return an L-shaped prism, a frustum of one, or a tetrahedron with a dent, far from the origin and thin."""
    if kind == "mesh":
        faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 4), (2, 3, 4), (3, 1, 4)]
        return co.Mesh([(x + far, y - far, thin * z + 0.3) for x, y, z in _TETRAHEDRA], faces)
    outline = [(far + x, thin * y - far / 3) for x, y in _CORNER]
    return co.Extrusion(outline, (far, far + 1), 0.7 if kind == "frustum" else 1.0)


def _rod(far: float, thin: float) -> co.Shape:
    start = np.random.default_rng(5).uniform(-1, 1, 3) * far
    return co.Cylinder(start, start + np.array([0.3, -0.4, 0.5]) * max(thin, far * 2.0**-50), min(1.0, thin**0.5))


@pytest.mark.parametrize("kind", ["prism", "frustum", "mesh", "rod"])
@pytest.mark.parametrize(("far", "thin"), [(0.5, 1.0), (1e3, 1.0), (1e6, 1e-2), (3e8, 1e-3), (1e11, 1.0)])
def test_bounds_leave_out_no_body_that_has_fewer_digits(kind, far, thin):
    shape = _rod(far, thin) if kind == "rod" else _flat(kind, far, thin)
    scene = co.Scene([shape])
    digits = conditioning(scene)[0].digits
    assert [one.digits for one in conditioning(scene, digits + 1e-6)] == [digits]
    assert not conditioning(scene, digits)


def test_ordinary_bodies_are_tested_without_a_change_of_each_number(monkeypatch):
    def refuse(leaf, sides):
        raise AssertionError(leaf)

    monkeypatch.setattr("conicoid.apps.checks.perturbation._comparable_changes", refuse)
    shapes = [_flat("prism", 1e3, 1.0), _flat("frustum", -20.0, 0.1), _flat("mesh", 1e3, 0.1), _rod(100.0, 0.5)]
    shapes += [
        _leaf(kind, 100.0, 0.5) & co.Sphere(0.7, (100, 0, 0)) - _rod(100.0, 0.5)
        for kind in ("block", "rod", "ellipsoid")
    ]
    assert not conditioning(co.Scene(shapes), SINGLE_PRECISION_DIGITS)


_CUBE = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
_CUBE_CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]


def _triangles(faces):
    return [(face[0], a, b) for face in faces for a, b in itertools.pairwise(face[1:])]


@pytest.mark.parametrize("height", [1.2, 0.8])
def test_a_face_that_is_not_flat_counts_as_its_triangles(height):
    corners = [*_CUBE_CORNERS[:6], (1, 1, height), _CUBE_CORNERS[7]]
    whole, cut = (
        conditioning(co.Scene([co.Mesh(corners, faces)]))[0]
        for faces in (_CUBE, [*_CUBE[:1], *_triangles(_CUBE[1:2]), *_CUBE[2:3], *_triangles(_CUBE[3:5]), *_CUBE[5:]])
    )
    assert (whole.movement, whole.number, whole.point.tolist()) == (cut.movement, cut.number, cut.point.tolist())
    # Parts of the one that is convex have no other corners
    assert height < 1 or any(np.allclose(whole.point, corner, atol=1e-12) for corner in corners)


def test_flat_solids_are_not_cut_anew_for_a_change_of_each_number(monkeypatch):
    notch = [(0, 0), (3, 0), (3, 2), (1.5, 1), (0, 2)]
    low, high = [(*p, -1.0) for p in notch], [(0.8 * x, 0.7 * y, 1.0 + 0.1 * x * y) for x, y in notch]
    sides = [(i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i) for i in range(5)]
    faces = _triangles([(4, 3, 2, 1, 0), (5, 6, 7, 8, 9), *sides])
    for solid in (co.Mesh([*low, *high], faces), co.Extrusion(notch, (-1, 2), 0.7)):
        own = OwnForms(solid)
        for change, _ in own.changes:  # planes are those of a solid that is cut anew
            planes = set(dataclasses.replace(change.result).parts.planes)
            assert planes.issuperset(solid.moved_planes(change.result).values())
        assert len(own.changes) >= 9
        scene = co.Scene([solid])
        with monkeypatch.context() as patch:
            patch.setattr("conicoid.geometry.polyhedron.convex_parts", None)
            assert conditioning(scene)[0].digits > 13


def test_a_tip_of_many_planes_takes_little_memory():
    # 82,160 triples of 80 planes meet at the tip: a million tests, each of three surfaces at most
    turn = 2 * np.pi * np.arange(80) / 80
    sides = np.stack([np.cos(turn), np.sin(turn), np.ones(80)], axis=1)
    tip = co.Polyhedron([*sides, (0, 0, -1)], [*(sides @ (3, 4, 1)), 0])
    scene = co.Scene([tip])
    scene.prepare()
    tracemalloc.start()
    assert not conditioning(scene, SINGLE_PRECISION_DIGITS)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 512 * 2**20


def _leaf(kind: str, far: float, thin: float) -> co.Shape:
    """Return a turned block of planes of any scale, or a rod across it or a quadric, `far` from the origin."""
    random = np.random.default_rng(7)
    turn, at = np.linalg.qr(random.normal(size=(3, 3)))[0], np.array([far, 0, 0])
    if kind == "rod":
        return co.Cylinder(at - turn[0], at + turn[0] * thin, 0.2 * thin)
    if kind in ("ellipsoid", "tip"):  # xᵀ s x - 2 xᵀ s a + aᵀ s a = 1 about the point a, or = 0
        second = turn.T @ np.diag([1.0, thin**-2, thin**-2 if kind == "ellipsoid" else -1.0]) @ turn
        first, rest = -second @ at, at @ second @ at - (kind == "ellipsoid")
        return co.Quadric(matrix=np.block([[second, first[:, None]], [first, rest]]).tolist())
    if kind == "box":
        return co.Box(at - [1.0, thin, thin], at + [1.0, thin, 2 * thin])
    if kind == "half-space":
        return co.HalfSpace(3 * turn[0], 3 * turn[0] @ at)
    normals = np.concatenate([turn, -turn]) * random.uniform(0.1, 10, (6, 1))
    reach = np.tile([1.0, thin, thin], 2) * np.linalg.norm(normals, axis=1)
    return co.Polyhedron(normals.tolist(), normals @ at + reach)


_PLACES = [(0.0, 1.0), (0.5, 1e-3), (1e3, 1.0), (1e6, 1e-2)]
_CASES = [*((kind, *place) for kind in ("block", "box", "half-space", "rod") for place in _PLACES)]
_CASES += [*((kind, *place) for kind in ("ellipsoid", "tip") for place in _PLACES[:3])]  # farther off, none is left


@pytest.mark.parametrize(("kind", "far", "thin"), _CASES)
def test_bounds_of_all_changes_are_not_below_the_sum_of_the_single_ones(kind, far, thin):
    leaf, random = _leaf(kind, far, thin), np.random.default_rng(8)
    frame, (low, high), _ = own_frame(leaf)
    low, high = (-2 * np.ones(3), 2 * np.ones(3)) if kind in ("half-space", "tip") else (low, high)
    for share in (0.0, 0.1, 0.4):
        cut = share * random.uniform(0, 1, (2, 3)) * (high - low)
        extent = tuple((low + cut[0]).tolist()), tuple((high - cut[1]).tolist())
        exact, bound = (
            movement(
                prepare_part(OwnForms(leaf), frame, *extent, share > 0, bounded),
                MotionFields(np.zeros((0, 3, 4)), ()),
                False,
            )
            for bounded in (False, True)
        )
        if exact is None:  # no face is in the part
            assert bound is None
            continue
        assert exact.relative <= bound.relative
        assert kind == "tip" or bound.relative <= 100 * exact.relative  # at a tip nothing moves where all terms are 0
