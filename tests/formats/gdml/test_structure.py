"""Places of volumes: rotations by bodies without symmetry, daughters in mothers, repeats, names."""

from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry import polyhedron
from conicoid.io import importers as options
from conicoid.io.gdml import importer
from conicoid.io.gdml.solid_template import GdmlPlacement, PrimitiveTemplate, place_solid
from conicoid.io.xml_tree import read_xml
from conicoid.prepare.csg_plan import placed_primitives

from ...command_line import execute
from .files import HEAD, placed, scene_of, text_of, volume
from .test_solids import COMB

WORLD = '<box name="w" x="40" y="40" z="40"/>'
BAR = '<box name="bar" x="2" y="4" z="8"/>'
DEG = np.pi / 180


def names(scene):
    return [body.name for body in scene.bodies]


def at(scene, *points):
    """Return the names of the bodies at points."""
    found = np.asarray(scene.body_at(np.array(points, float))).tolist()
    return [None if number < 0 else scene.bodies[number].name for number in found]


def has_one_wall_between(scene, start, bodies):
    """Return whether a ray along z is in these bodies, and leaves each by the surface by which it enters the next."""
    through = scene.crossings(start, (0, 0, 1))
    walls = [set(through.surface[through.t == t].tolist()) for t in np.unique(through.t)]
    return scene.spans(start, (0, 0, 1)).name.tolist() == bodies and list(map(len, walls)) == [1] * len(bodies)


SMALL = '<box name="s" x="2" y="2" z="2"/>'
TIP = SMALL + '<union name="tip"><first ref="s"/><second ref="s"/><position x="{}" y="{}" z="0"/></union>'
ARM = TIP.replace("tip", "arm").format(2, 0) + (
    '<subtraction name="d"><first ref="w"/><second ref="arm"/><rotation z="90" unit="deg"/></subtraction>'
)
PAIR = "<assembly name='pair'>" + "".join(placed("bar", f'<position x="{x}"/>') for x in (3, -3)) + "</assembly>"
PAIRS = placed("pair", '<position y="10"/>', 'name="up0x55d0c0ffee"') + placed(
    "pair", '<position y="-10"/>', 'name="down" copynumber="7"'
)
DEFINE = (
    '<variable name="i" value="0"/><constant name="n" value="3"/><matrix name="m" coldim="1" values="1 2 4"/>'
    '<quantity name="d" type="length" value="1" unit="cm"/>'
)
LOOP = '<loop for="i" to="n" from="1">{}</loop>'.format
COPIES = (
    '<paramvol ncopies="2"><volumeref ref="part"/><parameterised_position_size>'
    '<parameters number="1"><position x="-5" y="0" z="0"/><box_dimensions x="2" y="2" z="2"/></parameters>'
    '<parameters number="2"><position x="5" y="0" z="0"/><rotation x="0" y="0" z="90" unit="deg"/>'
    '<box_dimensions x="6" y="2" z="2"/></parameters></parameterised_position_size></paramvol>'
)
REPLICA = (
    '<replicavol number="{}"><volumeref ref="part"/><replicate_along_axis><direction {}="1"/><width value="{}" unit="{}"/>'
    '<offset value="{}" unit="{}"/></replicate_along_axis></replicavol>'
)
WEDGES = (
    '<tube name="m" rmin="2" rmax="8" z="4" deltaphi="2*pi"/>'
    '<tube name="part" rmin="2" rmax="8" z="4" startphi="-30" deltaphi="60" aunit="deg"/>'
)
SHELLS = WEDGES.replace('startphi="-30" deltaphi="60" aunit="deg"', 'deltaphi="2*pi"')
AROUND = (30 + 60 * np.arange(6)) * DEG


def replicas(solids, number, axis, width, unit="mm", offset=0, place=""):
    replica = REPLICA.format(number, axis, width, unit, offset, unit)
    structure = volume("part", "part") + volume("m", "m", replica) + volume("world", "w", placed("m", place))
    return text_of(WORLD + solids, structure)


PLACES = {  # text, and the bodies at points
    # By +90 degrees about z Geant4's placement turns its volume by -90: the tip at +x goes to -y. About x: +y to -z
    **{f"turned about {turn}": (
        text_of(WORLD + TIP.format(*tip), volume("t", "tip") + volume("world", "w", placed("t", f'<rotation {turn}="90" unit="deg"/>'))),
        {there: "world/t", tuple(-x for x in there): "world"},
    ) for turn, tip, there in (("z", (2, 0), (0, -2, 0)), ("x", (0, 2), (0, 0, -2)), ("y", (2, 0), (0, 0, 2)))},
    "a turned operand": (text_of(WORLD + ARM, volume("world", "d")), {(0, 2, 0): None, (0, -2, 0): "world"}),
    "assemblies": (text_of(WORLD + BAR, volume("bar", "bar") + PAIR + volume("world", "w", PAIRS)), {
        (3, 10, 0): "world/up/bar", (-3, 10, 0): "world/up/bar#2", (3, -10, 0): "world/down[7]/bar",
        (-3, -10, 0): "world/down[7]/bar#2", (0, 10, 0): "world"}),
    "loops, matrices and names with brackets": (
        text_of(WORLD + LOOP('<box name="b[i]" x="m[i]" y="1" z="1"/>'),
                LOOP(volume("v[i]", "b[i]")) + volume("world", "w", LOOP(placed("v[i]", '<position x="0" y="d*(i-2)" z="0"/>'))), DEFINE),
        {(1.9, 10, 0): "world/v_3", (0.9, 0, 0): "world/v_2", (1.9, 0, 0): "world", (0.4, -10, 0): "world/v_1"}),
    "parameterised volumes": (
        text_of(WORLD + '<box name="any" x="1" y="1" z="1"/>', volume("part", "any") + volume("world", "w", COPIES)),
        {(-4.1, 0, 0): "world/part[0]", (5, 2.9, 0): "world/part[1]", (6.1, 0, 0): "world"}),
    "a negative copy number": (
        text_of(WORLD + BAR, volume("v", "bar") + volume("world", "w", placed("v", attributes='name="a" copynumber="-1"'))),
        {(0, 0, 0): "world/a[-1]"}),
    "replicas along x": (replicas('<box name="m" x="12" y="4" z="4"/><box name="part" x="3" y="4" z="4"/>', 4, "x", 3),
                         {(-5, 0, 0): "world/m/part[0]", (5, 0, 0): "world/m/part[3]"}),
    "replicas around z": (replicas(WEDGES, 6, "phi", 60, "deg"),
                          {(5 * np.cos(a), 5 * np.sin(a), 0): f"world/m/part[{k}]" for k, a in enumerate(AROUND)}),
    "replicas outward": (replicas(SHELLS, 3, "rho", 2, offset=2),
                         {(3, 0, 0): "world/m/part[0]", (0, 5, 0): "world/m/part[1]", (-7, 0, 0): "world/m/part[2]"}),
}  # fmt: skip


@pytest.mark.parametrize("name", PLACES)
def test_bodies_stand_where_geant4_has_them(name, tmp_path):
    text, places = PLACES[name]
    assert at(scene_of(tmp_path, text), *places) == [*places.values()]


def test_three_angles_and_a_scale(tmp_path):
    # p_mother = Rx(-a) Ry(-b) Rz(-c) S p + t
    a, b, c = 20, 35, 50
    inside = f'<position x="3" y="-2" z="1"/><rotation x="{a}" y="{b}" z="{c}" unit="deg"/><scale x="1" y="1" z="-1"/>'
    solids = WORLD + '<trd name="t" x1="2" x2="9" y1="3" y2="5" z="8"/>'
    scene = scene_of(tmp_path, text_of(solids, volume("t", "t") + volume("world", "w", placed("t", inside))))
    p = np.random.default_rng(3).uniform(-8, 8, (10_000, 3))

    def turn(axis, degrees):
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        m = np.eye(3)
        m[i, i] = m[j, j] = np.cos(degrees * DEG)
        m[j, i] = np.sin(degrees * DEG)
        m[i, j] = -m[j, i]
        return m

    r = turn(0, -a) @ turn(1, -b) @ turn(2, -c)
    q = (p - [3, -2, 1]) @ r * [1, 1, -1]  # the inverse of r by its transpose, rows as points
    t = (q[:, 2] + 4) / 8
    inside_it = (t >= 0) & (t <= 1) & (abs(q[:, 0]) <= 1 + 3.5 * t) & (abs(q[:, 1]) <= 1.5 + t)
    assert inside_it.sum() > 50
    assert np.array_equal(np.asarray(scene.body_at(p)) == names(scene).index("world/t"), inside_it)


@pytest.mark.parametrize(
    "solid",
    [
        '<sphere name="s" rmax="2" starttheta="0" deltatheta="90" deltaphi="360" aunit="deg"/>',
        '<polycone name="s" deltaphi="6.3"><zplane z="0" rmax="1"/><zplane z="1" rmax="2"/><zplane z="3" rmax="1"/></polycone>',
        '<genericPolycone name="s"><rzpoint r="0" z="0"/><rzpoint r="1" z="0"/><rzpoint r="0" z="2"/></genericPolycone>',
        '<cutTube name="s" rmax="1" z="2" lowX="0" lowY="0.1" lowZ="-1" highX="0" highY="0" highZ="1" deltaphi="6.3"/>',
        '<eltube name="s" dx="1" dy="2" dz="1"/>',
        '<elcone name="s" dx="0.2" dy="0.1" zmax="4" zcut="2"/>',
    ],
)  # fmt: skip
def test_copies_of_a_profile_share_their_walls(tmp_path, solid):
    copies = "".join(placed("v", f'<position x="{x}" y="{x / 3}" z="0"/>') for x in (-9, 0, 9))
    scene = scene_of(tmp_path, text_of(WORLD + solid, volume("v", "s") + volume("world", "w", copies)))
    leaves = [leaf for body in scene.bodies for leaf, _ in placed_primitives(body.shape)]
    profiles = [leaf for leaf in leaves if isinstance(leaf, co.Revolution)]
    assert len(profiles) >= 3
    assert len({id(leaf.own_cache) for leaf in profiles}) == 1


def test_motions_are_not_known_by_ids_of_before_a_pickle():
    """A motion may have the id of one that no longer exists, whose entry must not serve it."""
    motions = [co.Box().rotate("x", angle).translate((angle, 0, 0)).motion for angle in (20.0, 50.0)]
    places = [GdmlPlacement(outer=motion) for motion in motions]
    template = PrimitiveTemplate(lambda shift: co.Box())
    shift = Fraction(1, 3), Fraction(0), Fraction(2)

    def found():
        return [place_solid(template, place, shift) for place in places]

    expected, places_by_motion = found(), template.held
    assert len(places_by_motion) == 2
    places_by_motion.update(zip(places_by_motion, list(places_by_motion.values())[::-1], strict=True))
    assert found() == expected


def test_a_daughter_displaces_its_mother(tmp_path):
    structure = (
        volume("core", "core") + volume("bar", "bar", placed("core", '<position x="0.5" y="0" z="0"/>'))
        + volume("world", "w", placed("bar", '<position x="5" y="0" z="0"/>'), "air")
    )  # fmt: skip
    scene = scene_of(tmp_path, text_of(WORLD + BAR + '<orb name="core" r="0.5"/>', structure))
    assert names(scene) == ["world", "world/bar", "world/bar/core"]
    assert at(scene, (5.5, 0, 0), (4.5, 0, 0), (0, 0, 0), (30, 0, 0)) == [
        "world/bar/core", "world/bar", "world", None,
    ]  # fmt: skip
    spans = scene.spans([(-30, 0, 0)], [(1, 0, 0)])
    # The bar is from 4 to 6, the core from 5 to 6
    lengths = np.zeros(3)
    np.add.at(lengths, spans.body, spans.t_exit - spans.t_enter)
    assert lengths.tolist() == [38.0, 1.0, 1.0]
    assert scene.bodies[0].material.transparency == 1  # air


def test_a_solid_is_made_once_for_each_height(tmp_path, noted_calls):
    """As in a detector of wires, five places have one turn, in a mother that loses all five."""
    outlines = noted_calls(co.Revolution, "__post_init__")
    wires = "".join(placed("p", f'<position x="{k}" y="{-k}" z="0"/><rotation x="30" unit="deg"/>') for k in range(5))
    text = text_of(WORLD + '<tube name="p" rmax="0.2" z="6"/>', volume("p", "p") + volume("world", "w", wires))
    world, *rest = (body.shape for body in scene_of(tmp_path, text).bodies)
    assert len(outlines) == 1
    assert [id(shape) for shape in world.operands[1:]] == list(map(id, rest))


def test_an_outline_of_many_corners_is_cut_once_for_all_places(tmp_path, noted_calls):
    """The sides between two sections with an offset stay flat: 67 planes across x, three across y, and two ends."""
    cut = noted_calls(polyhedron, "convex_parts", lambda *arguments: len(arguments[0]))
    combs = "".join(placed("c", f'<position x="0.1" y="{4.1 * k}" z="{k / 3}"/>') for k in range(-2, 3))
    scene_of(tmp_path, text_of(WORLD + COMB, volume("c", "s") + volume("world", "w", combs)))
    assert cut == [72, 72]


def test_solids_of_a_rotated_volume_have_its_motion(tmp_path):
    """The volume and its two daughters stand along the axis of its rotation."""
    cores = placed("core", '<position z="1"/>') + placed("core", '<position z="-1"/>')
    turn = '<position x="5" y="0" z="0"/><rotation z="30" unit="deg"/>'
    structure = volume("core", "core") + volume("bar", "bar", cores) + volume("world", "w", placed("bar", turn))
    text = text_of(WORLD + BAR + '<box name="core" x="1" y="1" z="1"/>', structure)
    _, bar, *rest = (body.shape for body in scene_of(tmp_path, text).bodies)
    assert [shape.motion for shape in (*bar.operands, *rest)] == 5 * [rest[0].motion]
    assert len(rest[0].motion.steps) == 2


def test_flush_daughters_leave_no_gap(tmp_path):
    # 0.1 + 0.2 is not 0.3 in double precision: in fractions the plates touch, and no ray sees the mother between them
    plates = "".join(
        placed("p", f'<position x="0" y="0" z="{k}*0.1-0.45" unit="cm"/>', f'copynumber="{k}"') for k in range(10)
    )
    solids = '<box name="w" x="1" y="1" z="1" lunit="cm"/><box name="p" x="1" y="1" z="0.1" lunit="cm"/>'
    scene = scene_of(tmp_path, text_of(solids, volume("p", "p") + volume("world", "w", plates, "air")))
    spans = scene.spans([(0.1, 0.2, -30)], [(0, 0, 1)])
    assert [scene.bodies[k].name for k in spans.body] == [f"world/p[{k}]" for k in range(10)]
    assert np.array_equal(spans.t_enter[1:], spans.t_exit[:-1])


def test_an_operand_rotated_about_z_ends_at_its_height(tmp_path):
    # Plates from -0.1 to 0.1, from 0.1 to 0.3, which is rotated, and from 0.3 to 0.5
    two = '<union name="two"><first ref="p"/><second ref="p"/><position z="0.2"/><rotation z="30" unit="deg"/></union>'
    third = placed("p", '<position z="0.4"/>')
    structure = volume("p", "p") + volume("two", "two") + volume("world", "w", placed("two") + third)
    scene = scene_of(tmp_path, text_of(f'{WORLD}<box name="p" x="1" y="1" z="0.2"/>{two}', structure))
    assert has_one_wall_between(scene, (0.1, 0.2, -1), ["world", "world/two", "world/p", "world"])


def test_boxes_that_fill_their_mother_leave_none_of_it(tmp_path):
    scene = scene_of(tmp_path, PLACES["replicas along x"][0])
    assert names(scene) == ["world"] + [f"world/m/part[{k}]" for k in range(4)]


def test_replicas_end_where_their_mother_does(tmp_path):
    """A rotation about z keeps the exact values along z."""
    place = '<position x="0.3" y="-0.7" z="10.1"/>'
    scene = scene_of(tmp_path, replicas(WEDGES.replace('z="4"', 'z="7.04"'), 6, "phi", 60, "deg", place=place))
    for k, angle in enumerate(AROUND):
        start = 0.3 + 5 * np.cos(angle), 5 * np.sin(angle) - 0.7, 0
        assert has_one_wall_between(scene, start, ["world", f"world/m/part[{k}]", "world"])


DIVISION = '<divisionvol axis="kPhi" number="{}" width="0" offset="0" unit="rad"><volumeref ref="part"/></divisionvol>'
FULL = 'z="40" deltaphi="360" aunit="deg"'
TUBE, PLANES = (
    'tube name="m" rmin="2" rmax="80" ',
    '<zplane z="-20" rmin="2" rmax="80"/><zplane z="20" rmin="2" rmax="80"/>',
)


def placed_around(count: int, angle: str, unit: str) -> str:
    """Return a placement of each wedge. Geant4 turns it by the inverse of its rotation."""
    turns = (f'<rotation z="-({angle.format(k)})" unit="{unit}"/>' for k in range(count))
    return "".join(placed("part", turn, f'copynumber="{k}"') for k, turn in enumerate(turns))


@pytest.mark.parametrize(
    ("mother", "count", "rule", "frame", "extent"),
    [
        (TUBE + FULL, 7, placed_around(7, "360/7*{}", "deg"), 0, 360),
        (TUBE + FULL, 11, placed_around(11, "0.3 + twopi/11*{}", "rad"), 0.3 / DEG, 360),
        (TUBE + FULL, 7, placed_around(7, "51.42857142857143*{}", "deg"), 0, 360),
        (TUBE + FULL, 7, REPLICA.format(7, "phi", "360/7", "deg", 0, "deg"), 180 / 7, 360),
        (TUBE + FULL, 11, REPLICA.format(11, "phi", "twopi/11", "rad", "12.3", "deg"), 12.3 + 180 / 11, 360),
        # A width in radians of few digits, less than a seventh of a turn by 1e-12
        (TUBE + FULL, 7, REPLICA.format(7, "phi", "0.897597901025", "rad", 0, "deg"), 180 / 7, 360),
        (TUBE + 'z="40" startphi="0.1" deltaphi="100.2" aunit="deg"', 9, DIVISION.format(9), 0, 100.2),
        ('cone name="m" rmin1="2" rmin2="2" rmax1="80" rmax2="90" ' + FULL, 13, DIVISION.format(13), 0, 360),
        (f'polycone name="m" startphi="0.7" {FULL}>{PLANES}</polycone', 7, DIVISION.format(7), 0, 360),
        (f'polyhedra name="m" numsides="14" startphi="0.7" {FULL}>{PLANES}</polyhedra', 7, DIVISION.format(7), 0, 360),
        (f'polyhedra name="m" numsides="12" {FULL}>{PLANES}</polyhedra', 6, DIVISION.format(6), 0, 360),
    ],
)
def test_wedges_side_by_side_share_walls(tmp_path, mother, count, rule, frame, extent):
    """Where a ray passes from wedge to wedge there is one surface, and no part of their mother between them."""
    part = TUBE.replace('"m"', '"part"') + f'z="40" startphi="-180/{count}" deltaphi="360/{count}" aunit="deg"'
    solids = f'<box name="w" x="400" y="400" z="400"/><{mother}/><{part}/><orb name="ball" r="0.1"/>'
    solids = solids.replace("</polycone/>", "</polycone>").replace("</polyhedra/>", "</polyhedra>")
    ball = placed("ball", '<position x="3*cos(8*deg)" y="3*sin(8*deg)"/>')
    structure = volume("ball", "ball") + volume("part", "part", ball) + volume("m", "m", rule)
    scene = scene_of(tmp_path, text_of(solids, structure + volume("world", "w", placed("m"))))
    generator = np.random.default_rng(5)
    radii, angles = generator.uniform(3, 50, (2, 200)), generator.uniform(1, extent - 1, (2, 200)) * DEG
    starts, ends = np.stack([radii * np.cos(angles), radii * np.sin(angles), 0 * radii + 1], axis=-1)
    through = scene.crossings(starts, ends - starts, t_max=1)
    touched = 0
    for ray in range(200):
        here = through[ray]
        assert not any(scene.bodies[body].name == "world/m" for body in here.body.tolist())
        for t in np.unique(here.t):
            assert len(set(here.surface[here.t == t].tolist())) == 1
            touched += np.sum(here.t == t) == 2
    assert touched > 200
    # The content of a wedge has the rotation of its frame, by a width from each wedge to the next
    azimuths = (frame + 8 + extent / count * np.arange(count)) * DEG
    balls = at(scene, *np.column_stack((3 * np.cos(azimuths), 3 * np.sin(azimuths), 0 * azimuths)))
    assert balls == [f"world/m/part[{k}]/ball" for k in range(count)]


@pytest.mark.parametrize("rotation", ["", 'z="31.1" x="17.3"'])
@pytest.mark.parametrize(
    ("mother", "rule"),
    [
        ('<cone name="m" rmin1="0.7" rmin2="1.3" rmax1="9.1" rmax2="4.3" z="6.1" deltaphi="360"/>', 'kZAxis" number="7'),
        ('<para name="m" x="5.541" y="7.205" z="5.73" alpha="-27.652" theta="7.196" phi="311.821"/>', 'kZAxis" number="7'),
        ('<para name="m" x="5.541" y="7.205" z="5.73" alpha="-27.652" theta="7.196" phi="311.821"/>', 'kYAxis" number="7'),
        ('<polycone name="m" deltaphi="360"><zplane z="0" rmin="0.1" rmax="9.1"/><zplane z="5.1" rmin="0.3" rmax="2"/></polycone>', 'kZAxis" width="0.51'),
    ],
)  # fmt: skip
def test_slices_have_the_leaning_walls_of_their_mother(tmp_path, mother, rule, rotation):
    """Every ray leaves the slices where it enters the body around their mother: no other body is between."""
    division = f'<divisionvol axis="{rule}" unit="mm"><volumeref ref="part"/></divisionvol>'
    solids = WORLD + mother.replace('name="m"', 'name="m" aunit="deg"') + BAR.replace("bar", "any")
    place = placed("m", '<position x="1.729" y="1.971" z="-0.955"/><rotation ' + rotation + ' unit="deg"/>')
    structure = volume("part", "any") + volume("m", "m", division) + volume("world", "w", place)
    scene = scene_of(tmp_path, text_of(solids, structure))
    starts, ends = np.random.default_rng(3).uniform(-9, 9, (2, 200, 3))
    through = scene.crossings(starts, ends - starts)
    assert through.body.size > 600
    for ray in range(200):
        here = through[ray]
        for t in np.unique(here.t):
            assert len(set(here.surface[here.t == t].tolist())) == 1
        assert np.all(np.diff(np.unique(here.t)) > 1e-9)


NESTED = (
    volume("core", "core") + volume("bar", "bar", placed("core"), "air") + volume("world", "w", placed("bar"))
)  # fmt: skip
NESTED_SOLIDS = WORLD + BAR + '<orb name="core" r="0.5"/>'


def test_options(tmp_path):
    text = text_of(NESTED_SOLIDS, NESTED)
    assert names(scene_of(tmp_path, text, depth=0)) == ["world"]
    scene = scene_of(tmp_path, text, depth=1)
    assert at(scene, (0, 0, 0)) == ["world/bar"]
    assert names(scene_of(tmp_path, text, void=False)) == ["world", "world/bar/core"]
    assert at(scene_of(tmp_path, text, void=False), (0.9, 0, 0)) == [None]
    assert names(scene_of(tmp_path, text, only="*/core")) == ["world/bar/core"]
    for call, error, message in (
        (lambda: scene_of(tmp_path, text, only="none"), ValueError, "only 'none' names none of 3 bodies"),
        (
            lambda: scene_of(tmp_path, text, max_bodies=2),
            co.SceneFileError,
            r"expands into 3 bodies; the limit is 2 \(max_bodies\)",
        ),
        (lambda: scene_of(tmp_path, text, smooth=True), ValueError, "smooth means nothing for a GDML file"),
    ):
        with pytest.raises(error, match=message):
            call()


def test_volumes_that_are_no_others_moved_have_a_limit_of_their_own(tmp_path, monkeypatch):
    """One bar with its content stands in ten places, and ten bars stand in one place each."""
    monkeypatch.setattr(options, "DEFAULT_BODY_LIMITS", options.BodyLimits(1000, 5))

    def text(several):
        names = [f"bar{k if several else 0}" for k in range(10)]
        places = "".join(
            f'<physvol><volumeref ref="{name}"/><position x="{3 * k - 15}" unit="mm"/></physvol>'
            for k, name in enumerate(names)
        )
        bars = "".join(volume(name, "bar", placed("core")) for name in dict.fromkeys(names))
        return text_of(NESTED_SOLIDS, volume("core", "core") + bars + volume("world", "w", places))

    assert scene_of(tmp_path, text(False)).body_count == 21
    with pytest.raises(
        co.SceneFileError, match="expands into at least 6 bodies that are no others moved; the limit is 5"
    ):
        scene_of(tmp_path, text(True))
    assert scene_of(tmp_path, text(True), max_bodies=21).body_count == 21


def test_materials(tmp_path):
    scene = scene_of(tmp_path, text_of(NESTED_SOLIDS, NESTED.replace("iron", "G4_Pb", 1)))
    by_name = {body.name: body.material for body in scene.bodies}
    assert by_name["world"].properties["density"] == 7.87
    assert by_name["world/bar"].properties["density"] == 0.0012
    assert by_name["world/bar/core"].name == "G4_Pb"
    assert by_name["world/bar"].transparency == 1
    materials = '<materials><material name="iron"><D value="7870" unit="kg/m3"/></material><material name="air"><D value="1e-3"/></material></materials>'
    scene = scene_of(tmp_path, text_of(NESTED_SOLIDS, NESTED, materials=materials))
    assert scene.bodies[0].material.properties["density"] == pytest.approx(7.87, rel=1e-15)


def test_a_module_of_the_same_folder(tmp_path):
    (tmp_path / "part.gdml").write_text(text_of(BAR, volume("part", "bar") + volume("other", "bar"), world="part"))
    for name, volume_name in (("", "part"), ('volname="other"', "other")):
        inside = f'<physvol><file name="part.gdml" {name}/><position x="5"/></physvol>'
        scene = scene_of(tmp_path, text_of(WORLD, volume("world", "w", inside)))
        assert at(scene, (5, 0, 0)) == [f"world/{volume_name}"]


@pytest.mark.parametrize("name", ["../a.gdml", "/etc/passwd", "..", "", "a.gdml", "none.gdml", "link.gdml"])
def test_other_modules_are_refused(tmp_path, name):
    (tmp_path / "a.gdml").write_text(text_of(BAR, volume("world", "bar")))
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "link.gdml").symlink_to(tmp_path / "a.gdml")
    with pytest.raises(co.SceneFileError, match=r"outside of the folder|refers to itself|cannot be read|is no name"):
        scene_of(tmp_path / "sub", text_of(WORLD, volume("world", "w", f'<physvol><file name="{name}"/></physvol>')))


def test_modules_with_errors_are_read_once(tmp_path, monkeypatch):
    """Each of eight files refers to the next one four times: 4 + 16 + ... + 65,536 readings."""
    read = []
    monkeypatch.setattr(importer, "read_xml", lambda path, **options: (read.append(path), read_xml(path, **options))[1])
    for k in range(9):
        place = "".join(f'<physvol name="p{n}"><file name="m{k + 1}.gdml"/></physvol>' for n in range(4))
        (tmp_path / f"m{k}.gdml").write_text(
            f'<gdml><solids><box name="b" x="1" y="1" z="1"/></solids><structure><volume name="W"><materialref ref="G4_AIR"/>'
            f'<solidref ref="b"/>{place}</volume></structure><setup name="s"><world ref="W"/></setup></gdml>'
        )
    with pytest.raises(co.SceneFileError, match="m1.gdml' has errors, which are listed where it is first read"):
        importer.read_gdml(tmp_path / "m0.gdml")
    assert len(read) == 9


def test_modules_in_folders_below_and_beside(tmp_path):
    """The root is the folder of the file unless a user names another. Files refer to others from their own folder."""
    for folder in ("below", "beside"):
        (tmp_path / folder).mkdir()
    (tmp_path / "beside" / "bar.gdml").write_text(text_of(BAR, volume("part", "bar"), world="part"))
    inside = '<physvol><file name="../beside/bar.gdml"/></physvol>'
    (tmp_path / "below" / "part.gdml").write_text(text_of(WORLD, volume("world", "w", inside)))
    text = text_of(WORLD, volume("world", "w", '<physvol><file name="below/part.gdml"/></physvol>'))
    assert at(scene_of(tmp_path, text), (0, 0, 0)) == ["world/world/part"]
    path = tmp_path / "below" / "part.gdml"
    with pytest.raises(
        co.SceneFileError, match=r"'../beside/bar.gdml' is outside of the folder that may be read \(root="
    ):
        co.load(path)
    assert at(co.load(path, root=tmp_path), (0, 0, 0)) == ["world/part"]
    execute("import", path, "-o", tmp_path / "a.yaml", "--root", tmp_path)
    assert at(co.load(tmp_path / "a.yaml"), (0, 0, 0)) == ["world/part"]


def test_materials_of_all_modules_are_known_to_each(tmp_path):
    """Geant4 has one table of materials: a module uses those before it, and later volumes use those of the module."""
    iron = '<material name="{}" state="solid"><D value="{}"/></material>'.format
    other = f"<materials>{iron('copper', 8.96)}{iron('iron', 1)}</materials>"
    part = text_of(BAR, volume("part", "bar", material="lead") + volume("own", "bar"), world="part", materials=other)
    (tmp_path / "part.gdml").write_text(part)
    inside = '<physvol><file name="part.gdml"/></physvol><physvol><file name="part.gdml" volname="own"/></physvol>'
    inside += '<physvol><volumeref ref="late"/></physvol>'
    late = volume("early", "bar", '<physvol><file name="part.gdml"/></physvol>') + volume(
        "late", "bar", material="copper"
    )
    materials = f"<materials>{iron('iron', 7.87)}{iron('lead', 11.35)}</materials>"
    scene = scene_of(tmp_path, text_of(WORLD + BAR, late + volume("world", "w", inside), materials=materials))
    found = {body.name: (body.material.name, body.material.properties["density"]) for body in scene.bodies}
    assert found == {
        "world": ("iron", 7.87), "world/part": ("lead", 11.35), "world/own": ("iron", 1), "world/late": ("copper", 8.96),
    }  # fmt: skip


def test_a_mistake_in_a_module_is_reported_with_its_file(tmp_path):
    (tmp_path / "part.gdml").write_text(HEAD + "<solids><box name='b' x='nonsense'/></solids></gdml>")
    with pytest.raises(co.SceneFileError, match=r"part\.gdml:3.*'nonsense', which is not defined"):
        scene_of(tmp_path, text_of(WORLD, volume("world", "w", '<physvol><file name="part.gdml"/></physvol>')))


def test_an_empty_number_is_0(tmp_path):
    """Geant4 evaluates an empty number as 0, but the end of a loop must be there."""
    (tmp_path / "a.gdml").write_text(
        '<gdml><materials><material name="a"><D value="1"/></material></materials><solids>'
        '<box name="hall" x="20" y="20" z="20"/><tube name="ring" rmin="" rmax="2" z="4" startphi="" deltaphi="360" '
        'aunit="deg"/></solids><structure><volume name="ring"><materialref ref="a"/><solidref ref="ring"/></volume>'
        '<volume name="hall"><materialref ref="a"/><solidref ref="hall"/><physvol><volumeref ref="ring"/>'
        '<position x="1" y="" z=" "/><rotation x="" y="" z=""/></physvol></volume></structure>'
        '<setup name="Default" version="1"><world ref="hall"/></setup></gdml>'
    )
    low, high = co.load(tmp_path / "a.gdml").bodies[1].shape.bounds
    assert (low.tolist(), high.tolist()) == ([-1, -2, -2], [3, 2, 2])


def test_bounds_of_many_kinds_need_the_boxes_of_few(tmp_path, monkeypatch):
    # Cubes of 520 sizes, each alone, in a row along x; the world's walls are the ends
    count, computed = 520, []
    solids = WORLD + "".join(f'<box name="s{k}" x="0.0{k + 100}" y="0.03" z="0.03"/>' for k in range(count))
    places = "".join(placed(f"v{k}", f'<position x="{(k - 260) / 16}"/>') for k in range(count))
    scene = scene_of(
        tmp_path,
        text_of(solids, "".join(volume(f"v{k}", f"s{k}") for k in range(count)) + volume("world", "w", places)),
    )
    bounds = co.Shape.bounds.fget
    monkeypatch.setattr(co.Shape, "bounds", property(lambda shape: computed.append(shape) or bounds(shape)))
    low, high = scene.bounds
    np.testing.assert_allclose([low, high], [[-20] * 3, [20] * 3], rtol=1e-14)
    assert (low <= -20).all()
    assert (high >= 20).all()
    assert len(computed) <= 6
