"""OpenMC's surfaces and regions, and regions without an end."""

import itertools
import math
import xml.etree.ElementTree as ElementTree
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, strategies as st

import conicoid as co
from conicoid.io.openmc.placement import Extent, UniversePlacement, rotation_by_angles
from conicoid.io.openmc.region_expression import (
    MAX_PARENTHESES,
    HalfSpaceNode,
    IntersectionNode,
    Region,
    list_half_spaces,
    parse_region,
)
from conicoid.io.openmc.surfaces import FlatSurface, GeneralSurface, Surface, read_surface
from conicoid.io.xml_tree import XmlElement

from ...engine.nodes import Nodes
from .evaluator import Evaluator, evaluate_region, same_place
from .models import endless, geometry_file, load_model, model_file

# --- Surfaces: each kind as OpenMC's documentation defines it, moved exactly, and as the very solid that was written

KINDS = {
    "x-plane": "0.7", "y-plane": "-0.3", "z-plane": "1e-3", "plane": "1 -2 0.5 1.25",
    "x-cylinder": "0.1 -0.2 0.4095", "y-cylinder": "0.3 0.7 1.1", "z-cylinder": "-1.26 0.63 0.475",
    "sphere": "0.1 0.2 0.3 1.7",
    "x-cone": "-1 0.3 0.2 0.3", "y-cone": "0.4 1 -0.2 0.45", "z-cone": "0.1 -0.6 0.5 0.7",
    "quadric": "1 1.5 -0.5 0.4 -0.3 0.2 0.1 -0.2 0.3 -1.7",
}  # fmt: skip


def surface(kind: str, coefficients: str) -> Surface:
    return read_surface(XmlElement("surface", 1, 1, {"id": "1", "type": kind, "coeffs": coefficients})).surface


def solid(item: Surface, positive: bool = False) -> co.Solid:
    if isinstance(item, FlatSurface):
        return item.solid(positive)
    return ~item.solid() if positive else item.solid()


def evaluator(kind: str, coefficients: str) -> Evaluator:
    found = Evaluator.__new__(Evaluator)
    found.surfaces = {1: (kind, [float(word) for word in coefficients.split()])}
    return found


@pytest.mark.parametrize(("kind", "coefficients"), KINDS.items())
@pytest.mark.parametrize("angles", [(0, 0, 0), (90, 0, 0), (0, -90, 90), (180, 90, 270)])
def test_sides_are_those_of_the_equation_wherever_it_stands(
    kind: str, coefficients: str, angles: tuple[int, ...]
) -> None:
    a, b, c = (Fraction(angle) for angle in angles)
    place = UniversePlacement(shift=(Fraction("0.1"), Fraction("-0.7"), Fraction("1.3")))
    place = place.inner((Fraction(1), Fraction("0.3"), Fraction("-0.2")), rotation_by_angles((a, b, c)))
    own = np.random.default_rng(1).uniform(-3, 3, (2000, 3))
    matrix = np.array([[float(v) for v in row] for row in place.turn.rows])
    points = own @ matrix.T + [float(v) for v in place.shift]
    values = evaluator(kind, coefficients).value_of(1, own)
    clear = np.abs(values) > 1e-9
    moved = surface(kind, coefficients).placed(place)
    for positive in (False, True):
        inside = co.Scene([solid(moved, positive)]).contains(points)
        assert (inside == (values > 0 if positive else values < 0))[clear].all()


@pytest.mark.parametrize(("kind", "coefficients"), KINDS.items())
def test_bounds_of_a_box_hold_for_its_points(kind: str, coefficients: str) -> None:
    item, values = surface(kind, coefficients), evaluator(kind, coefficients)
    random = np.random.default_rng(2)
    decided = 0
    for _ in range(300):
        middle, half = random.uniform(-3, 3, 3), random.uniform(0.01, 1, 3) * random.choice([0.2, 1, 3])
        low, high = ([Fraction(v) for v in middle + sign * half] for sign in (-1, 1))
        points = random.uniform(middle - half, middle + half, (200, 3))
        found = values.value_of(1, points)
        side = item.side_of(Extent((low[0], low[1], low[2]), (high[0], high[1], high[2])))
        decided += side != 0
        assert side == 0 or (side * found >= -1e-12).all()
        for positive in (False, True):
            box = item.extent(positive)
            inside = points[found > 1e-12] if positive else points[found < -1e-12]
            for i in range(3):
                low_end, high_end = box.low[i], box.high[i]
                assert low_end is None or (inside[:, i] >= float(low_end) - 1e-12).all()
                assert high_end is None or (inside[:, i] <= float(high_end) + 1e-12).all()
    assert decided > 50 or kind.endswith("cone") or kind == "quadric"


def test_written_surfaces_equal_those_of_the_scene() -> None:
    """The fields of the shapes have the user's numbers to the last bit; those of a plane are integers."""
    assert surface("plane", "1 -2 0.5 1.3").solid() == co.HalfSpace((2, -4, 1), 2.6)
    assert surface("plane", "0.123456789012345678 -2 0.5 1.3").solid() == co.HalfSpace(
        (0.123456789012345678, -2, 0.5), 1.3
    )
    assert surface("x-plane", "-10.71").solid(positive=True) == co.HalfSpace((-1, 0, 0), 10.71)
    assert surface("sphere", "0.1 0.2 0.3 1.7").solid() == co.Sphere(1.7, (0.1, 0.2, 0.3))
    upright = co.EllipticCylinder(1, 1).scale((0.4095, 0.4095, 1))
    assert surface("z-cylinder", "0.1 0.2 0.4095").solid() == upright.translate((0.1, 0.2, 0))
    assert surface("z-cylinder", "0 0 0.4095").solid() == upright
    assert surface("x-cylinder", "0.1 0.2 0.4095").solid() == upright.rotate((0, 1, 0), 90).translate((0, 0.1, 0.2))
    assert surface("y-cone", "1 2 3 0.7").solid() == co.EllipticCone(1, 1, 0.7).rotate((1, 0, 0), 90).translate(
        (1, 2, 3)
    )
    quadric = surface("quadric", "1 2 3 4 5 6 7 8 9 -10").solid()
    terms = dict(xx=1, yy=2, zz=3, xy=4, yz=5, xz=6, x=7, y=8, z=9, constant=-10)
    assert quadric == co.Quadric(coefficients=terms)


def test_a_quadric_without_squares_is_its_plane() -> None:
    assert surface("quadric", "0 0 0 0 0 0 0 1 0 -2").solid() == co.HalfSpace((0, 1, 0), 2)
    assert surface("quadric", "0 0 0 0 0 0 0 -0.3 0 0.21").solid() == co.HalfSpace((0, -1, 0), -0.7)
    assert surface("plane", "0.3 0 0 0.21").solid() == surface("x-plane", "0.7").solid()


@pytest.mark.parametrize("factor", ["3", "0.7", "1e-3", "123.45", "1e12"])
def test_multiples_of_a_plane_are_one(factor: str) -> None:
    """Decimals have no exact products with most factors in floats. Planes of the opposite sign face the other way."""
    numbers = [Fraction(number) for number in ("0.1", "-0.25", "0.3", "0.7")]
    one, other = (FlatSurface((a, b, c), d) for a, b, c, d in (numbers, [Fraction(factor) * n for n in numbers]))
    assert one.solid() == other.solid() == co.HalfSpace((2, -5, 6), 14)
    assert FlatSurface((-numbers[0], -numbers[1], -numbers[2]), -numbers[3]).solid() == one.solid(True)


@pytest.mark.parametrize(
    ("kind", "numbers", "quadric"),
    [
        ("z-cylinder", "0.1 0.2 0.41", "1 1 0 0 0 0 -0.2 -0.4 0 -0.1181"),
        ("z-cylinder", "0.3 0.1 0.001", "10 10 0 0 0 0 -6 -2 0 0.99999"),
        ("x-cylinder", "-0.63 1.26 0.4095", "0 1 1 0 0 0 0 1.26 -2.52 1.81680975"),
        ("y-cylinder", "0 0 0.7", "3 0 3 0 0 0 0 0 0 -1.47"),
        ("sphere", "0.1 0.2 -0.3 1.1", "1 1 1 0 0 0 -0.2 -0.4 0.6 -1.07"),
        ("z-cone", "0.1 0.2 -0.3 0.07", "3 3 -0.21 0 0 0 -0.6 -1.2 -0.126 0.1311"),
        ("x-cone", "0.7 0 0 1.1", "-0.11 0.1 0.1 0 0 0 0.154 0 0 -0.0539"),
    ],
)
def test_a_round_quadric_is_that_cylinder_sphere_or_cone(kind: str, numbers: str, quadric: str) -> None:
    """In exact decimals they are one wall, not two that differ by rounding. With the opposite sign it is the outside."""
    assert surface("quadric", quadric) == surface(kind, numbers)
    opposite = surface("quadric", " ".join(str(-Decimal(number)) for number in quadric.split()))
    assert opposite.solid() == ~surface(kind, numbers).solid()


@pytest.mark.parametrize("factor", ["3", "0.7", "1e-3", "-1", "-0.3"])
@pytest.mark.parametrize(
    "quadric", ["0.1 0.2 0.3 0 0 0 -0.1 0 0 -0.7", "1 1 0 0 0 0 -0.2 -0.4 0 -0.1182", "0 0 0 1 0 0 0 0 0.3 0"]
)
def test_multiples_of_a_quadric_are_one(factor: str, quadric: str) -> None:
    """Decimals have no exact products with most factors in floats. Quadrics of the opposite sign face the other way."""
    times = " ".join(str(Decimal(factor) * Decimal(number)) for number in quadric.split())
    one, other = (surface("quadric", numbers).solid().coefficients for numbers in (quadric, times))
    assert {name: math.copysign(value, float(factor) * value) for name, value in one.items()} == other


@pytest.mark.parametrize(
    "quadric",
    [
        "1 1 0 0 0 0 -0.2 -0.4 0 -0.1182",  # its radius is irrational
        "-1 -1 0 0 0 0 0 0 0 1", "1 1 0 0 0 0 0 0 1 -1", "1 1 0 0.1 0 0 0 0 0 -1", "1 2 0 0 0 0 0 0 0 -1",
        "1 1 -1 0 0 0 0 0 0 -1", "1 0 0 0 0 0 0 0 0 -1", "1 1 1 0 0 0 0 0 0 1", "1 1 0 0 0 0 0 0 0 0",
    ],
)  # fmt: skip
def test_other_quadrics_stay_quadrics(quadric: str) -> None:
    assert isinstance(surface("quadric", quadric), GeneralSurface)


def test_sums_are_exact_in_decimals() -> None:
    """-10.71 + 17 · 1.26 = 10.71 holds neither for the nearest floats nor for their sums."""
    place = UniversePlacement(shift=(Fraction("-10.71"), Fraction(0), Fraction(0)))
    for _ in range(17):
        place = place.inner((Fraction("1.26"), Fraction(0), Fraction(0)))
    assert surface("x-plane", "0").placed(place).solid() == co.HalfSpace((1, 0, 0), 10.71)
    assert sum([1.26] * 17, -10.71) != 10.71


def test_the_cylinder_is_the_one_that_a_user_would_write() -> None:
    """The importer's cylinder and co.Cylinder's have one entry of the surface table."""
    mine = surface("z-cylinder", "0.63 -1.26 0.4095").solid()
    scene = co.Scene([mine, co.Cylinder((0.63, -1.26, -1), (0.63, -1.26, 1), 0.4095)])
    hits = [scene.crossings((0.7, 5, 0.1), (0, -1, 0))]
    surfaces = hits[0].surface
    assert len(surfaces) == 4
    assert len(set(surfaces.tolist())) == 1


@pytest.mark.parametrize("ring", ["z-cylinder' coeffs='0 0 0", "sphere' coeffs='0 0 0 0"])
def test_the_innermost_ring_may_have_radius_0(ring: str, tmp_path) -> None:
    """Programs divide a pin into rings from radius 0 on. The first cell has no volume, and the second is whole."""
    text = (
        endless(2, 0.3)
        .replace('region="-1"', 'region="-1 7"')
        .replace(
            "</geometry>",
            f"""
      <surface id="7" type='{ring}'/><cell id="8" universe="1" material="1" region="-7"/></geometry>""",
        )
    )
    path = geometry_file(text, tmp_path)
    scene, points = co.load_openmc(path), np.random.default_rng(4).uniform((0, 0, -1), (2, 2, 1), (300, 3))
    assert scene.body_count == 2 * 4
    names = [scene.bodies[number].name for number in scene.body_at(points)]
    assert all(map(same_place, Evaluator(path).find(points), names))


def test_elements_and_attributes_are_the_same(tmp_path) -> None:
    path = model_file("kinds", tmp_path)
    root = ElementTree.parse(path).getroot()
    for element in root:
        for name in list(element.attrib):
            child = ElementTree.SubElement(element, name)
            child.text = f"  {element.attrib.pop(name)} \n"
    other = tmp_path / "elements.xml"
    ElementTree.ElementTree(root).write(other)
    assert co.load_openmc(other) == co.load_openmc(path)


# --- The grammar of regions, against Python's own operators of the same precedence, and its mistakes

SURFACES = (1, 2, 3)


def value(region: Region, negative: dict[int, bool]) -> bool:
    if isinstance(region, HalfSpaceNode):
        return negative[region.surface] != region.positive
    return (all if isinstance(region, IntersectionNode) else any)(value(part, negative) for part in region.parts)


def table(text: str) -> list[bool]:
    """Return the value of a region for every combination of sides."""
    region = parse_region(text)
    return [
        value(region, dict(zip(SURFACES, sides, strict=True))) for sides in itertools.product([True, False], repeat=3)
    ]


def expected(text: str) -> list[bool]:
    rows = []
    for sides in itertools.product([True, False], repeat=3):
        # -2 and -1 are ~1 and ~0: truth in the lowest bit
        bits = {surface: int(side) for surface, side in zip(SURFACES, sides, strict=True)}
        rows.append(bool(evaluate_region(text, bits.__getitem__) & 1))
    return rows


SAME = {
    "1": "+1",
    "1 2": "1 & 2",
    "1 2 | 3": "(1 2) | 3",
    "1 | 2 3": "1 | (2 3)",
    "1 | 2 & 3": "1 | (2 & 3)",
    "~1 2": "(~1) 2",
    "~1 | 2": "(~1) | 2",
    "~(1 2)": "-1 | -2",
    "~(1 | -2)": "-1 2",
    "~~1": "1",
    "~(~1 ~(2 | -3))": "1 | 2 | -3",
    "1-2": "1 & -2",
    "1(2|3)": "1 & (2 | 3)",
    "(1)(2)": "1 2",
    "\t(1\n|2) -3 ": "(1 | 2) & -3",
    "-1|~2": "-1 | -2",
    "((((1))))": "1",
}


@pytest.mark.parametrize(("left", "right"), SAME.items())
def test_these_mean_the_same(left: str, right: str) -> None:
    assert table(left) == table(right) == expected(left) == expected(right)


texts = st.recursive(
    st.sampled_from(["1", "-1", "+2", "-2", "3", "-3"]),
    lambda inner: st.one_of(
        st.builds("({})".format, inner),
        st.builds("~({})".format, inner),
        st.builds("{} {}".format, inner, inner),
        st.builds("{} & {}".format, inner, inner),
        st.builds("{}|{}".format, inner, inner),
    ),
    max_leaves=20,
)


@given(texts)
def test_regions_follow_the_precedence_of_operators(text: str) -> None:
    assert table(text) == expected(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 |", "a surface, '~' or '(' must stand here (after '1 |')"),
        ("| 1", "a surface, '~' or '(' must stand here (after '|')"),
        ("1 & & 2", "a surface, '~' or '(' must stand here (after '1 & &')"),
        ("~", "a surface, '~' or '(' must stand here (after '~')"),
        ("()", "a surface, '~' or '(' must stand here (after '()')"),
        ("(1 2", "a ')' is missing (after '(1 2')"),
        ("1 2)", "a ')' without its '(' (after '1 2)')"),
        ("1 + 2", "'+ 2' is no half-space, '~', '&', '|' or parenthesis (after '1')"),
        ("1.5", "'.5' is no half-space"),
        ("a", "'a' is no half-space, '~', '&', '|' or parenthesis (at the beginning)"),
        ("1 # 2", "'# 2' is no half-space"),
        ("9" * 40, "is no half-space"),
    ],
)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(ValueError, match="region: ") as caught:
        parse_region(text)
    assert message in str(caught.value)


def test_depth_is_limited_and_length_is_not() -> None:
    deep = "(" * (MAX_PARENTHESES + 1) + "1" + ")" * (MAX_PARENTHESES + 1)
    with pytest.raises(ValueError, match=f"deeper than {MAX_PARENTHESES} levels"):
        parse_region(deep)
    with pytest.raises(ValueError, match="deeper than"):
        parse_region("(" * 100_000)
    assert parse_region("~" * 100_001 + "1") == HalfSpaceNode(1, False)
    assert len(list(list_half_spaces(parse_region("1 -2 | " * 50_000 + "3")))) == 100_001


# --- A lattice in two dimensions, its cells without ends along z: located and met by few nodes, however many pins

RADIUS = 0.4
SIDES = 8, 32


@pytest.fixture(scope="module")
def lattices(tmp_path_factory: pytest.TempPathFactory) -> dict[int, co.Scene]:
    folder = tmp_path_factory.mktemp("lattices")
    return {side: load_model(geometry_file(endless(side, RADIUS), folder)) for side in SIDES}


def test_points_are_located_by_few_nodes(lattices: dict[int, co.Scene]) -> None:
    """Sixteen times as many pins need hardly more nodes for a point, at any height. No body is outside the trees."""
    random = np.random.default_rng(3)
    mean = {}
    for side, scene in lattices.items():
        assert len(scene.bodies) == 2 * side**2
        points = random.uniform((0, 0, -1e6), (side, side, 1e6), (400, 3))
        element = np.floor(points[:, :2])
        pin = ((points[:, :2] - element - 0.5) ** 2).sum(axis=1) < RADIUS**2
        located = scene.body_at(points)
        names = np.array([body.name for body in scene.bodies])
        expected = [
            f"cell {1 if inner else 2} @ cell 3, lattice 9 [{x:.0f}, {y:.0f}]"
            for inner, (x, y) in zip(pin, element, strict=True)
        ]
        assert names[located].tolist() == expected
        nodes = Nodes(scene)
        nodes.check()
        assert nodes.beside() == []
        mean[side] = np.mean([nodes.visits(point) for point in points])
    assert mean[32] < mean[8] + 3
    assert mean[32] < 8


def test_a_ray_crosses_every_expected_wall(lattices: dict[int, co.Scene]) -> None:
    """Along x through the middles of pins the ray crosses water, pin, water in each element, without a gap."""
    for side, scene in lattices.items():
        spans = scene.spans((-1.0, 2.5, 123456.0), (1, 0, 0))
        ends = np.append(spans.t_enter, spans.t_exit[-1])
        walls = [k + 1 + at for k in range(side) for at in (0, 0.5 - RADIUS, 0.5 + RADIUS)] + [side + 1]
        assert (spans.t_enter[1:] == spans.t_exit[:-1]).all()
        assert np.allclose(ends, walls, rtol=1e-12, atol=0)
        assert scene.first_hit((-1.0, 2.5, -7e5), (1, 0, 0)).t == 1.0
        assert scene.first_hit((0.5, 0.5, 0.0), (0, 0, 1)).t == math.inf
