"""The reference itself: numbers, motions, roots and crossings by closed forms; its judge finds all kinds of faults."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co

from .forms import Affine, chain, form, proportional
from .items import Item, clipped, combined
from .judge import Judge
from .numbers import VANISHED, cosine, number, rational, root, rounded, sine
from .quadratics import Table, compare, equal, in_order, roots, whole_ray
from .random_shapes import generator
from .solids import bodies
from .suite import compare as compare_all
from .trace import Trace, body_at

# --- Numbers, motions and roots of the reference, so that they can fail


@pytest.mark.parametrize("degrees", range(-360, 375, 15))
def test_sines_of_multiples_of_fifteen_degrees(degrees):
    s, c = sine(degrees), cosine(degrees)
    assert s.exact
    assert math.isclose(float(s), math.sin(math.radians(degrees)), abs_tol=1e-15)
    assert math.isclose(float(c), math.cos(math.radians(degrees)), abs_tol=1e-15)
    assert s * s + c * c == 1
    assert sine(degrees + 30) == s * cosine(30) + c * sine(30)


def test_sines_of_other_angles_are_rounded():
    s, c = sine(0.7), cosine(0.7)
    assert not s.exact
    assert math.isclose(float(s), math.sin(math.radians(0.7)), rel_tol=1e-15)
    assert 0 <= abs(rational(s) ** 2 + rational(c) ** 2 - 1) < VANISHED
    assert s * s + c * c - 1 == 0


def test_sums_of_square_roots():
    assert root(8) == 2 * root(2)
    assert root(6) * root(10) == 2 * root(15)
    assert root(2.25) == 1.5
    assert (root(2) + root(3)) * (root(3) - root(2)) == 1
    assert (root(2) + root(3) - root(6)).sign == 1  # 3.146 - 2.449
    # 1 / (sqrt 2 + 1)^40 is 5e-16, and the difference of two numbers of 10^15
    tiny = number(1)
    for _ in range(40):
        tiny = tiny * (root(2) - 1)
    assert (tiny.sign, (-tiny).sign) == (1, -1)
    assert math.isclose(float(tiny), (math.sqrt(2) + 1) ** -40, rel_tol=1e-12)


def test_a_rounding_is_nearest():
    third = number(1) / 3
    for value in (third, third * 2.0**-200, third * (1 << 5000), -third):
        off = abs(rounded(value.fraction) - value.fraction) / abs(value.fraction)
        assert 0 <= off * 2**2990 <= 1


def test_motions_that_cancel_do():
    steps = (("rotate", (1, 2, 3), 105), ("scale", (2, 1, -0.5)), ("rotate", (1, 1, 0), 15))
    back = (("rotate", (1, 1, 0), -15), ("scale", (0.5, 1, -2)), ("rotate", (1, 2, 3), -105))
    assert chain((*steps, *back)) == Affine()
    assert chain([("rotate", (0, 0, 1), 15)] * 6).rows == chain([("rotate", (0, 0, 1), 90)]).rows
    rounded_back = chain([("rotate", (1, 2, 3), 40.5), ("rotate", (1, 2, 3), -40.5)])
    assert rounded_back == Affine()
    assert not rounded_back.rows[0][0].exact


def test_motions_compose_first_to_last():
    turn = chain([("translate", (1, 0, 0)), ("rotate", (0, 0, 1), 90), ("scale", (2, 3, 4))])
    assert turn.point((0, 0, 0)) == (0, 3, 0)
    assert turn.point((0, 1, 1)) == (-2, 3, 4)
    assert chain([("rotate", (1, 1, 1), 120)]).point((1, 2, 3)) == (3, 1, 2)
    *rows, last = turn.backwards()
    back = Affine(tuple(row[:3] for row in rows), tuple(row[3] for row in rows))
    assert [x / last[3] for x in back.point(turn.point((5, 6, 7)))] == [5, 6, 7]


def test_multiples_of_a_form_are_one_surface():
    f = {(0, 0): 1, (1, 2): root(2), (3, 3): -3}
    assert proportional(form(f), form({pair: -2 * k for pair, k in f.items()})) == -1
    assert proportional(form(f), form({pair: root(3) * k for pair, k in f.items()})) == 1
    assert proportional(form(f), form({**f, (3, 3): -3 + 2.0**-50})) == 0
    assert proportional(form(f), form({**f, (0, 3): 1})) == 0


def test_rays_are_whole_numbers():
    o, d, w = whole_ray((0.75, -3.0, 2.0**-1000), (1e10, 0, 0.5))
    assert (o, d, w) == ([3 * 2**998, -3 * 2**1000, 1], [10**10 * 2**1000, 0, 2**999], 2**1000)


def test_all_small_quadratics_in_order():
    """Different roots are more than 1e-12 apart here."""
    random = np.random.default_rng(1)
    every = [x for k in range(40) for x in roots(k, tuple(number(int(i)) for i in random.integers(-4, 5, 3)), True)]
    assert len(every) > 40
    for r in every:
        a, b, c = map(float, r.quadratic)
        assert abs((a * r.place + b) * r.place + c) < 1e-12
        assert np.sign(2 * a * r.place + b) == 2 * r.slope - 1
        for s in every:
            off = r.place - s.place
            assert compare(r, s) == (0 if abs(off) < 1e-12 else np.sign(off))
            assert r.surface == s.surface or equal(r, s) == (abs(off) < 1e-12)
    groups = in_order(every[::-1])
    assert [len({round(r.place, 9) for r in group}) for group in groups] == [1] * len(groups)
    assert sorted(r.place for r in every) == [r.place for group in groups for r in group]


# --- Crossings of the reference against closed forms


INF = math.inf
S2, S3 = math.sqrt(2), math.sqrt(3)
UP = ((0, 0, 0), (0, 0, 1))
BOX = Item("Box", {"low": (-1, -1, -1), "high": (1, 1, 1)})
BALL = Item("Sphere", {"radius": 5, "center": (0, 0, 0)})
TUBE = Item("Cylinder", {"start": (0, 0, -1), "end": (0, 0, 1), "radius": 5.0})
RODS = {k: Item("Cylinder", {"start": UP[0], "end": UP[1], "radius": 1, "start_angle": 0, "end_angle": k, "reference": (1, 0, 7)}) for k in (90, 270)}  # fmt: skip
FIRST, SECOND = (Item("Sphere", {"radius": 1, "center": (x, 0, 0)}) for x in (0, 1))
CONE = Item("Cone", {"start": (0, 0, -1), "end": (0, 0, 1), "start_radius": 2, "end_radius": 1})
NAPPES = Item("DoubleCone", {"slope": 1.0})
HOLLOW = Item("Polygon", {"vertices": [(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)]})
LEFT, RIGHT = (Item("Box", {"low": (x, -1, -1), "high": (x + 2, 1, 1)}) for x in (-2, 0))


def trace(items, *rays, start=None):
    origins, directions = (np.array(x, float) for x in zip(*rays, strict=True))
    return Trace(Table(bodies(items)), origins, directions, start)


def crossings_of(item, origin, direction):
    c = trace([item], (origin, direction)).crossings
    return list(zip(c.t.tolist(), c.entering.tolist(), c.face.tolist(), strict=True))


def turned(item, axis, degrees):
    return item.moved(("rotate", axis, degrees))


def quadric(**coefficients):
    return Item("Quadric", {"coefficients": coefficients})


CHORDS = {
    "ball": (BALL, (3, -9, 0), (0, 1, 0), [5, 13], [0, 0]),
    "chord of half a speed": (Item("Sphere", {"radius": 2, "center": (1, 0, 0)}), (-5, 1, 0), (2, 0, 0), [(6 - S3) / 2, (6 + S3) / 2], [0, 0]),
    "ellipsoid": (Item("Ellipsoid", {"radii": (1, 2, 3)}), (0, 1, -5), (0, 0, 1), [5 - 1.5 * S3, 5 + 1.5 * S3], [0, 0]),
    "barrel": (Item("Ellipsoid", {"radii": (1, 2, 3), "center": (0, 0, 1), "z_range": (-1, 2)}), (0, 1, -5), (0, 0, 1), [5, 8], [1, 2]),
    "range that reaches too far": (Item("Ellipsoid", {"radii": (1, 2, 3), "z_range": (-3, 2)}), (0, 0, -5), (0, 0, 1), [2, 7], [0, 2]),
    "box": (BOX, (-3, 0, 0), (2, 0, 0), [1, 2], [0, 1]),
    "diagonal": (BOX, (-3, -3, -3), (1, 1, 1), [2, 4], [0, 1]),
    "turned box": (turned(BOX, (0, 0, 1), 45), (-5, 0, 0), (1, 0, 0), [5 - S2, 5 + S2], [0, 1]),
    "box turned by any angle, along the axis": (turned(BOX, (0, 0, 1), 37), (0, 0, -3), (0, 0, 1), [2, 4], [4, 5]),
    "oblique cylinder": (Item("Cylinder", {"start": (0, 0, 0), "end": (2, 2, 0), "radius": 1}), (1, 1, -3), (0, 0, 1), [2, 4], [0, 0]),
    "along its axis": (Item("Cylinder", {"start": (0, 0, 0), "end": (2, 2, 0), "radius": 1}), (-1, -1, 0), (1, 1, 0), [1, 3], [1, 2]),
    "tube on its side": (turned(TUBE, (1, 1, 1), 120), (0, 3, -9), (0, 0, 1), [5, 13], [0, 0]),
    "pacman": (RODS[270], (-2, -0.125, 0.5), (1, 0, 0), [2 - math.sqrt(63) / 8, 2], [0, 4]),
    "cone": (Item("Cone", {"start": (0, 0, 0), "end": (0, 0, 2), "start_radius": 1, "end_radius": 0.5}), (0.75, 0, -1), (0, 0, 1), [1, 2], [1, 0]),
    "through a rim": (CONE, (2, 3, 3), (-2, -2, -2), [1, 13 / 7], [0, 0]),
    "through a turned rim": (turned(CONE, (0, 0, 1), 105), (2, 3, 3), (-2, -2, -2), [1, 13 / 7], [0, 0]),
    "double cone": (Item("DoubleCone", {"slope": 2, "z_range": (-1, 3)}), (2, 0, -10), (0, 0, 1), [11, 13], [0, 2]),
    "paraboloid": (Item("EllipticParaboloid", {"A": 2.0, "E": 0.5}), (0, -50, 2), (0, 1, 0), [48, 52], [0, 0]),
    "one sheet": (Item("OneSheetHyperboloid", {"A": 1.0, "E": 0.25, "H": 0.75}), (0, -50, 2), (0, 1, 0), [46, 54], [0, 0]),
    "two sheets": (Item("TwoSheetHyperboloid", {"A": 1.0, "E": 0.25, "H": 1.25}), (0, -50, 2), (0, 1, 0), [46, 54], [0, 0]),
    "elliptic cone": (Item("EllipticCone", {"A": 1.0, "E": 0.25, "H": 4.0}), (-50, 0, 2), (1, 0, 0), [46, 54], [0, 0]),
    "elliptic cylinder": (Item("EllipticCylinder", {"A": 4.0, "E": 0.25, "z_range": (-INF, 7)}), (0, -50, 2), (0, 1, 0), [48, 52], [0, 0]),
    "hyperbolic cylinder": (Item("HyperbolicCylinder", {"A": 4, "E": 1}), (-5, 0, 0), (1, 0, 0), [4.5, 5.5], [0, 0]),
    "parabolic cylinder": (Item("ParabolicCylinder", {"G": 2}), (-5, 4, 0), (1, 0, 0), [1, 9], [0, 0]),
    "product": (quadric(xy=1, constant=-1), (-3, -3, 0), (1, 1, 0), [2, 4], [0, 0]),
    "matrix": (Item("Quadric", {"matrix": [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -4]]}), (-9, 0, 0), (1, 0, 0), [8 - math.sqrt(5), 8 + math.sqrt(5)], [0, 0]),
    "union": (combined("Union", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [4, 7], [0, 1]),
    "intersection": (combined("Intersection", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [5, 6], [1, 0]),
    "difference": (combined("Difference", FIRST, SECOND), (-5, 0, 0), (1, 0, 0), [4, 5], [0, 1]),
    "walls in common": (combined("Union", LEFT, RIGHT), (-3, 0, 0), (1, 0, 0), [1, 5], [0, 7]),
    "roots in common": (combined("Union", *(Item("Sphere", {"radius": 1.25, "center": (x, 0, 0)}) for x in (0, 2))), (1, -4, 0), (0, 1, 0), [3.25, 4.75], [0, 0]),
    "within the high face, as if that stood further out": (BOX, (1, 0, -5), (0, 0, 1), [4, 6], [4, 5]),
    "plane": (Item("Plane", {"normal": (0, 0, -2), "offset": -4, "one_sided": True}), (0, 0, 0), (0, 0, 1), [2], [0]),
    "disc": (Item("Disc", {"center": (0, 0, 1), "normal": (0, 0, -1), "radius": 1}), (0.5, 0.5, 0), (0, 0, 1), [1], [0]),
    "triangle": (Item("Triangle", {"a": (0, 0, 0), "b": (4, 0, 0), "c": (0, 4, 0)}), (1, 1, 3), (0, 0, -1), [3], [0]),
    "hollow polygon": (HOLLOW, (2, 1 - 2.0**-51, 3), (0, 0, -1), [3], [0]),
    "clipped sheet": (clipped(Item("Plane", {"normal": (0, 0, -1), "offset": 0}), BALL), (3, -3, -1), (0, 0, 1), [1], [0]),
}  # fmt: skip


@pytest.mark.parametrize("name", CHORDS)
def test_chords(name):
    item, origin, direction, times, faces = CHORDS[name]
    answer = crossings_of(item, origin, direction)
    assert [t for t, _, _ in answer] == pytest.approx(times, rel=1e-15)
    assert [(entering, face) for _, entering, face in answer] == list(zip([True, False], faces, strict=False))


@pytest.mark.parametrize(
    ("item", "origin", "direction"),
    [
        (BALL, (5, -9, 0), (0, 1, 0)),
        (TUBE, (5, 0, -9), (0, 0, 1)),  # along a ruling
        (BOX, (-2, 0, 0), (1, 1, 0)),  # through an edge
        (BOX, (-1, 0, -5), (0, 0, 1)),  # within the low face
        (NAPPES, (0, -3, 0), (0, 1, 0)),  # through the apex, outside
        (NAPPES, (-1, 0, -2), (1, 0, 2)),  # and inside all along
        (RODS[90], (-0.5, -2, 0.5), (0, 1, 0)),
        (combined("Difference", LEFT, LEFT), (-3, 0, 0), (1, 0, 0)),
        (Item("Plane", {"normal": (0, 0, 2), "offset": 4, "one_sided": True}), (0, 0, 0), (0, 0, 1)),
        (Item("Disc", {"center": (0, 0, 1), "normal": (0, 0, 1), "radius": 1}), (0.8, 0.8, 0), (0, 0, 1)),
        (HOLLOW, (2, 2, 3), (0, 0, -1)),
        (clipped(Item("Plane", {"normal": (0, 0, 1), "offset": 0}), BALL, "outside"), (1, 1, -1), (0, 0, 1)),
    ],
)  # fmt: skip
def test_misses_and_touches(item, origin, direction):
    assert crossings_of(item, origin, direction) == []


def test_sheets_give_the_side_that_was_hit():
    sheet = Item("Plane", {"normal": (0, 0, 2), "offset": 4})
    assert crossings_of(sheet, (0, 0, 0), (0, 0, 1)) == [(2, False, 0)]
    assert crossings_of(sheet.moved(("scale", -1)), (0, 0, 0), (0, 0, -1)) == [(2, False, 0)]
    assert crossings_of(sheet.moved(("scale", -1)), (0, 0, -5), (0, 0, 1)) == [(3, True, 0)]
    patch = Item(
        "CylinderPatch",
        {"start": UP[0], "end": UP[1], "radius": 1, "start_angle": 0, "end_angle": 90, "reference": (1, 0, 0)},
    )
    assert crossings_of(patch, (-3, 0.6, 0.5), (1, 0, 0)) == [(pytest.approx(3.8), False, 0)]


def test_faces_of_a_wedge():
    """The rays cross the diagonal of the wedge, from the axis on."""
    wedge = Item(
        "Cylinder",
        {"start": UP[0], "end": UP[1], "radius": 2, "start_angle": 15, "end_angle": 75, "reference": (1, 0, 0)},
    )
    assert crossings_of(wedge, (0, 0, 0.5), (1, 1, 0)) == [(0, True, 3), (pytest.approx(S2), False, 0)]


def test_roots_that_agree_to_many_digits_are_parted():
    """x² + y² + 2^-k z² <= 1 and x² + y² <= 1 along x at z = 1 differ by 2^-(k + 1) of their place."""
    tube, ray = quadric(xx=1, yy=1, constant=-1), ((-5, 0, 1), (1, 0, 0))
    for size, expected in ((2.0**-100, [1, 1, 1, 1]), (2.0**-1000, [1, 1, 1, 1]), (0.0, [1, 1])):
        (groups,) = trace([quadric(xx=1, yy=1, zz=size, constant=-1), tube], ray).groups
        assert [len(group) for group in groups] == expected
        if size:
            assert compare(groups[0][0], groups[1][0]) == -1
            assert [group[0].surface for group in groups] == [1, 0, 0, 1]
    (groups,) = trace([quadric(xx=1, yy=1, zz=1, z=-1, constant=-1), tube], ray).groups  # in common where z = 0 or 1
    assert [len(group) for group in groups] == [2, 2]


def test_rounded_roots_that_agree_are_equal():
    """One angle turns two spheres, and the ray meets their common circle."""
    item = combined("Union", *(Item("Sphere", {"radius": 1.25, "center": (x, 0, 0)}) for x in (0, 2)))
    (groups,) = trace([turned(item, (0, 0, 1), 37.5)], ((0, 0, 0), (0, 0, 1))).groups
    assert [len(group) for group in groups] == [1, 1]
    pair = [turned(BOX, (1, 2, 3), 37.5), turned(turned(BOX, (1, 2, 3), 30), (1, 2, 3), 7.5)]
    table = Table(bodies(pair))
    assert len(table.forms) == 6


def test_a_start_is_taken_out():
    table = Table(bodies([BALL]))
    c = Trace(table, np.array([[3.0, 4.0, 0.0]]), np.array([[-1.0, -1.0, 0.0]]), np.array([0])).crossings.ahead()
    assert c.t.tolist() == pytest.approx([7])
    c = Trace(table, np.array([[3.0, 4.0, 0.0]]), np.array([[-(2.0**-40), 0.0, 1.0]]), np.array([0])).crossings.ahead()
    assert c.t.tolist() == pytest.approx([6 * 2.0**-40])


def test_body_at():
    table = Table(bodies([combined("Difference", BALL, BOX), BOX]))
    points = np.array([[3.0, 4.0, 0.0], [np.nextafter(3, 9), 4.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert body_at(table, points).tolist() == [0, -1, 1, 1]
    assert [body_at(Table(bodies([RODS[270]])), np.array([[x, y, 0.5]]))[0] for x, y in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))] == [0, 0, 0, -1]  # fmt: skip


# --- The judge accepts right answers and finds each kind of wrong one


SMALL_BOX = Item("Box", {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)})
SMALL_BALL = Item("Sphere", {"radius": 1.25, "center": (0.0, 0.0, 0.0)})
CUBE = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
RAYS = (
    np.array([[-5.0, 0, 0], [-5.0, 0.5, 0.3], [0.0, 0, 0], [-5.0, 1.1, 0.1], [0.0, 9.0, 0.0]]),
    np.array([[1.0, 0, 0], [1.3, 0, 0.02], [0.0, 1, 1], [1.0, 0.01, 0.02], [0.0, 1.0, 0.0]]),
)
POINTS = np.array([[1.0, 1, 1], [1.125, 0, 0], [3.0, 0, 0]])
FIELDS = {
    "crossings": "offsets t t_error body face surface entering",
    "first_hit": "t t_error point point_error body face surface entering normal local_point uv doubtful",
    "spans": "offsets body t_enter t_exit t_enter_error t_exit_error enter_clipped exit_clipped",
}


class Altered:
    """A scene with wrong answers of one query."""

    def __init__(self, scene, name, spoil):
        self._scene, self._name, self._spoil = scene, name, spoil

    def __getattr__(self, name):
        query = getattr(self._scene, name)
        if name != self._name:
            return query

        def spoilt(*rays, **limits):
            result = query(*rays, **limits)
            if name in FIELDS:
                fields = {field: np.array(getattr(result, field)) for field in FIELDS[name].split()}
                fields |= {"rays": result.rays} if name == "first_hit" else {}
                result = SimpleNamespace(**fields)
            return self._spoil(result)

        return spoilt


def judged(items, scene=None):
    judge = Judge(co, items)
    judge.scene = scene or judge.scene
    compare_all(generator("judge", 0), judge.rays(*RAYS))
    judge.membership(POINTS)
    return judge.score


def test_right_answers_pass():
    for items, rows in (([SMALL_BOX], 8), ([combined("Union", SMALL_BOX, SMALL_BALL), SMALL_BALL], 20)):
        score = judged(items)
        score.check()
        assert score.rows == rows
    assert score.slackness >= 1


@pytest.mark.parametrize(
    ("items", "other", "complaint"),
    [
        ([SMALL_BALL], [co.Sphere(1.25 + 2.0**-50)], "crossings: t is further off than t_error"),
        ([SMALL_BOX], [co.Polyhedron(CUBE, np.ones(6))], "crossings: face"),
        ([SMALL_BOX], [co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(0.5)], "crossings: number"),
        ([SMALL_BOX, SMALL_BALL], [co.Sphere(1.25), co.Box()], "crossings: body"),
        ([SMALL_BOX], [co.Box((-1, 0.5, -1), (1, 1, 1))], "first_hit: hit or miss"),
        ([SMALL_BOX], [co.Box((-1, -1, -1), (1.125, 1, 1))], "body_at"),
        ([SMALL_BOX], [~co.Box((-1, -1, -1), (1, 1, 1))], "crossings: entering"),
        ([SMALL_BOX, SMALL_BOX.moved(("translate", (0.0, 0.0, 0.0)))], [co.Box(), co.Box().translate((2.0**-50, 0, 0))], "crossings: surface"),
    ],
)  # fmt: skip
def test_another_scene_is_noticed(items, other, complaint):
    assert complaint in judged(items, co.Scene(other)).wrong


def changed(name, change):
    """Change one column where there is a row or a hit."""

    def spoil(result):
        column = getattr(result, name)
        some = np.isfinite(result.t) if hasattr(result, "doubtful") else slice(None)
        column[some] = change(column[some])
        return result

    return spoil


def without_last(result):
    for name, column in vars(result).items():
        setattr(result, name, np.minimum(column, len(result.t) - 1) if name == "offsets" else column[:-1])
    return result


def missed(name, value):
    def spoil(result):
        getattr(result, name)[np.isinf(result.t)] = value
        return result

    return spoil


def ulps(count):
    return lambda t: t + count * np.spacing(t)


SPOILS = {
    "a part in 1e12": ("crossings", changed("t", lambda t: t * (1 + 1e-12)), "crossings: t is further off than t_error"),
    "four units in the last place": ("crossings", changed("t", ulps(4)), "crossings: t is further off than t_error"),
    "far away": ("crossings", changed("t", lambda t: 2 * t), "crossings: t is further off than t_error"),
    "a missing crossing": ("crossings", without_last, "crossings: number"),
    "a small bound": ("crossings", changed("t_error", lambda e: e * 1e-3), "crossings: t is further off than t_error"),
    "a large bound": ("crossings", changed("t_error", lambda e: e + 1), "crossings: t_error is as large as a length"),
    "inside out": ("crossings", changed("entering", np.logical_not), "crossings: entering"),
    "another body": ("crossings", changed("body", lambda b: 1 - b), "crossings: body"),
    "another face": ("crossings", changed("face", lambda f: f + 1), "crossings: face"),
    "one surface": ("crossings", changed("surface", lambda s: 0 * s), "crossings: surface"),
    "NaN": ("crossings", changed("t_error", lambda e: e * np.nan), "crossings: t or t_error is not finite"),
    "no order": ("crossings", changed("t", lambda t: -t), "crossings: order of t"),
    "hits further on": ("first_hit", changed("t", ulps(4)), "first_hit: t is further off than t_error"),
    "hits of another face": ("first_hit", changed("face", lambda f: f + 1), "first_hit: face"),
    "a point beside": ("first_hit", changed("point", lambda p: p + 1e-14), "first_hit: point"),
    "a large error of the point": ("first_hit", changed("point_error", lambda e: e + 1e-9), "first_hit: point_error is large"),
    "a normal beside": ("first_hit", changed("normal", lambda n: n + 1e-13), "first_hit: normal"),
    "an inward normal": ("first_hit", changed("normal", lambda n: -n), "first_hit: normal"),
    "no uv": ("first_hit", changed("uv", lambda x: x * np.nan), "first_hit: uv is not finite"),
    "a miss somewhere": ("first_hit", missed("point", 0.0), "first_hit: point of a miss"),
    "a miss with an error": ("first_hit", missed("t_error", 1.0), "first_hit: t_error of a miss"),
    "no shadow": ("occluded", np.logical_not, "occluded"),
    "longer spans": ("spans", changed("t_exit", ulps(4)), "spans.t_exit: t is further off than t_error"),
    "backward spans": ("spans", changed("t_exit", lambda t: -t - 99), "spans: length"),
    "open spans": ("spans", changed("exit_clipped", np.logical_not), "spans: number"),
    "contains": ("contains", np.logical_not, "contains"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILS)
def test_wrong_answers_are_noticed(name):
    query, spoil, complaint = SPOILS[name]
    items = [combined("Union", SMALL_BOX, SMALL_BALL), SMALL_BALL]
    scene = co.Scene([item.shape(co) for item in items])
    assert complaint in judged(items, Altered(scene, query, spoil)).wrong


def test_intervals_and_routes_are_compared():
    """The answers are right over the whole line, but not between limits or for one ray alone."""
    scene = co.Scene([co.Box()])

    def within(query):
        return lambda *rays, **limits: getattr(scene, query)(
            *rays, **({**limits, "t_max": np.inf} if len(limits) == 2 else limits)
        )

    def alone(*rays, **limits):
        return scene.first_hit(*rays, **limits) if np.ndim(rays[0]) > 1 else scene.first_hit((0, 0, 9), (0, 0, 1))

    for query, complaint in (("crossings", "interval, a crossing is not within"), ("spans", "interval, spans and crossings"), ("occluded", "interval, occluded is not first_hit.t < inf")):  # fmt: skip
        altered = SimpleNamespace(
            **{name: getattr(scene, name) for name in (*FIELDS, "occluded", "body_at", "contains", "_prepared")}
        )
        setattr(altered, query, within(query))
        assert complaint in judged([SMALL_BOX], altered).wrong
    altered = SimpleNamespace(
        **{name: getattr(scene, name) for name in (*FIELDS, "occluded", "body_at", "contains", "_prepared")}
    )
    altered.first_hit = alone
    assert "routes: t alone" in judged([SMALL_BOX], altered).wrong
