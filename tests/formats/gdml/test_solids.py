"""Each solid of GDML against its formula, as Geant4's book of applications gives it, at random points."""

import itertools

import numpy as np
import pytest

from ...samples import in_turn
from .files import solid_scene

# --- Each solid against its formula, as Geant4's book of applications gives it, at random points

DEG = np.pi / 180


def rotated(p, degrees, axis):
    """Return points turned counter-clockwise about an axis."""
    c, s = np.cos(degrees * DEG), np.sin(degrees * DEG)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    q = p.copy()
    q[:, i], q[:, j] = c * p[:, i] - s * p[:, j], s * p[:, i] + c * p[:, j]
    return q


def radius(p):
    return np.hypot(p[:, 0], p[:, 1])


def in_phi(p, start, delta):
    return (np.arctan2(p[:, 1], p[:, 0]) / DEG - start) % 360 <= delta


def in_box(p, x, y, z):
    return (abs(p) <= np.array([x, y, z]) / 2).all(axis=1)


def in_stack(p, planes, r=None):
    """Return which points are between planes (z, rmin, rmax), in either order; `r` replaces distances from the axis."""
    z, r, found = p[:, 2], radius(p) if r is None else r, np.zeros(len(p), bool)
    for (z0, a, b), (z1, c, d) in itertools.pairwise(planes):
        if z0 != z1:
            t = (z - z0) / (z1 - z0)
            found |= (t >= 0) & (t <= 1) & (r >= a + (c - a) * t) & (r <= b + (d - b) * t)
    return found


def in_cone(p, a, b, c, d, h):
    """Return which points are between (rmin, rmax) = (a, b) at -h and (c, d) at h."""
    return in_stack(p, [(-h, a, b), (h, c, d)])


def in_sphere(p):
    r = np.linalg.norm(p, axis=1)
    theta = np.arccos(p[:, 2] / r) / DEG
    return (r >= 3) & (r <= 8) & in_phi(p, 20, 200) & (theta >= 30) & (theta <= 120)


def in_trd(p, x1, x2, y1, y2, h):
    t = (p[:, 2] + h) / (2 * h)
    x, y = (x1 + (x2 - x1) * t) / 2, (y1 + (y2 - y1) * t) / 2
    return (t >= 0) & (t <= 1) & (abs(p[:, 0]) <= x) & (abs(p[:, 1]) <= y)


def in_para(p):
    z = p[:, 2]
    x0, y0 = z * np.tan(20 * DEG) * np.cos(30 * DEG), z * np.tan(20 * DEG) * np.sin(30 * DEG)
    y = p[:, 1] - y0
    x = p[:, 0] - x0 - y * np.tan(15 * DEG)
    return (abs(z) <= 6) & (abs(y) <= 4) & (abs(x) <= 3)


def in_trap(p):
    """Return which points are in the mother of all trapezoids.

    Its half lengths are 6; 4, 2, 3, tan 0.1; 5, 2.5, 3.75 (x in proportion keeps sides flat).
    """
    z = p[:, 2]
    t = (z + 6) / 12
    y0 = z * np.tan(10 * DEG) * np.sin(40 * DEG)
    x0 = z * np.tan(10 * DEG) * np.cos(40 * DEG)
    half_y, below, above = 4 + t, 2 + t / 2, 3 + 0.75 * t
    y = p[:, 1] - y0
    x = p[:, 0] - x0 - y * np.tan(10 * DEG)
    half_x = (below + above) / 2 + (above - below) / 2 * y / half_y
    return (abs(z) <= 6) & (abs(y) <= half_y) & (abs(x) <= half_x)


def across_sides(p, count, start, delta):
    """Return distances to the sides of a polyhedra, each along the middle of its sector; infinite beyond the last."""
    step = delta / count
    angle = (np.arctan2(p[:, 1], p[:, 0]) / DEG - start) % 360
    middle = start + (np.floor(angle / step) + 0.5) * step
    across = p[:, 0] * np.cos(middle * DEG) + p[:, 1] * np.sin(middle * DEG)
    return np.where(angle <= delta, across, np.inf)


def in_polyhedra(p, count, start, delta, planes, share=1.0):
    """Return which points are between `planes` (z, rmin, rmax), with radii to the sides, or times `share`."""
    return in_stack(p, planes, across_sides(p, count, start, delta) / share)


def in_tet(p, corners):
    m = np.linalg.inv(np.array(corners[1:], float) - corners[0])
    t = (p - corners[0]) @ m
    return (t >= 0).all(axis=1) & (t.sum(axis=1) <= 1)


def in_cut_tube(p):
    x, y, z = p.T
    return (
        (radius(p) >= 2) & (radius(p) <= 5) & in_phi(p, 10, 250)
        & (0.3 * x - 0.9 * (z + 4) <= 0) & (-0.2 * x + 0.1 * y + 0.9 * (z - 4) <= 0)
    )  # fmt: skip


def in_polygon(x, y, corners):
    """Return which points have an odd number of edges to the right."""
    found = np.zeros(len(x), bool)
    for (a, b), (c, d) in zip(corners, [*corners[1:], corners[0]], strict=True):
        if b != d:
            found ^= ((b > y) != (d > y)) & (x < a + (c - a) * (y - b) / (d - b))
    return found


def in_xtru(p, corners, sections):
    """Return which points are between `sections` (z, x offset, y offset, scale), which change evenly from one to the next."""
    found = np.zeros(len(p), bool)
    for low, high in itertools.pairwise(sections):
        t = (p[:, 2] - low[0]) / (high[0] - low[0])
        x, y, scale = (a + (b - a) * t for a, b in zip(low[1:], high[1:], strict=True))
        found |= (t >= 0) & (t <= 1) & in_polygon((p[:, 0] - x) / scale, (p[:, 1] - y) / scale, corners)
    return found


def xtru(corners, sections):
    return (
        '<xtru name="s">'
        + "".join(f'<twoDimVertex x="{x}" y="{y}"/>' for x, y in corners)
        + "".join(
            f'<section zOrder="{k}" zPosition="{z}" xOffset="{x}" yOffset="{y}" scalingFactor="{scale}"/>'
            for k, (z, x, y, scale) in enumerate(sections)
        )
        + "</xtru>"
    )


# 33 teeth from y = 1 to 3, each 0.2 wide, on a bar from y = 0; an offset moves them along y from z = 2 to 6
TOOTH = ((0, 30), (2, 30), (2, 10), (4, 10))
TEETH = [(-6.6, 0), *(((k + a) / 10, y / 10) for k in range(-66, 66, 4) for a, y in TOOTH), (6.6, 0)]
PUSH = [(-4, 0, 0, 1), (2, 0, 0, 1), (6, 0, 0.7, 1)]
COMB = xtru(TEETH, PUSH)


def hyperbolic(p):
    z, r2 = p[:, 2], p[:, 0] ** 2 + p[:, 1] ** 2
    return (abs(z) <= 6) & (r2 <= 16 + (np.tan(40 * DEG) * z) ** 2) & (r2 >= 4 + (np.tan(20 * DEG) * z) ** 2)


def planes(rows):
    return "".join(f'<zplane z="{z}" rmin="{a}" rmax="{b}"/>' for z, a, b in rows)


def points(rows):
    return "".join(f'<rzpoint r="{r}" z="{z}"/>' for r, z in rows)


STEPS = [(-7, 1, 4), (-2, 2, 6), (3, 2, 3), (6, 0, 8)]
TOUCHING = [(-6, 0, 5), (-2, 0, 5), (-2, 2, 8), (2, 4, 4), (6, 1, 7)]
GENERIC = [(2, -6), (7, -3), (4, 0), (7, 5), (2, 5)]
CORNERS = [(0, 0, 0), (6, 1, 0), (1, 7, -2), (-2, 1, 8)]
DEFINE = "".join(f'<position name="p{k}" x="{x}" y="{y}" z="{z}" unit="mm"/>' for k, (x, y, z) in enumerate(CORNERS))
L = [(0, 0), (6, 0), (6, 2), (2, 2), (2, 5), (0, 5)]
SHRINK = [(-5, 0, 0, 1), (3, 2, -1, 0.5), (5, 2, -1, 0.5)]
FACETS = "".join(
    f'<triangular vertex1="p{a}" vertex2="p{b}" vertex3="p{c}" type="ABSOLUTE"/>'
    for a, b, c in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
)
PENTAGRAM = [(5, 0), (-4, 3), (2, -5), (2, 5), (-4, -3)]
BOW = [(2, -4), (8, 4), (8, -4), (2, 4)]
ARB8 = " ".join(
    f'v{k}x="{x}" v{k}y="{y}"'
    for k, (x, y) in enumerate([(-3, -3), (-3, 3), (3, 3), (3, -3), (-2, -2), (-2, 2), (2, 2), (2, -2)], 1)
)
SOLIDS = {
    "box": ('<box name="s" x="1" y="0.8" z="0.6" lunit="cm"/>', lambda p: in_box(p, 10, 8, 6)),
    "tube": (
        '<tube name="s" rmin="2" rmax="7" z="9" startphi="30" deltaphi="280" aunit="deg"/>',
        lambda p: in_cone(p, 2, 7, 2, 7, 4.5) & in_phi(p, 30, 280),
    ),
    "one height by two expressions": (
        '<polycone name="s" deltaphi="360" aunit="deg">'
        '<zplane rmax="2" z="0"/><zplane rmax="6" z="0.1+0.2"/><zplane rmax="8" z="0.30000000000000001"/>'
        '<zplane rmin="1" rmax="8" z="0.3"/><zplane rmin="1" rmax="8" z="6"/></polycone>',
        lambda p: in_cone(p - [0, 0, 0.15], 0, 2, 0, 6, 0.15) | in_cone(p - [0, 0, 3.15], 1, 8, 1, 8, 2.85),
    ),
    "radians": (
        '<tube name="s" rmax="7" z="9" startphi="-pi/2" deltaphi="pi"/>',
        lambda p: in_cone(p, 0, 7, 0, 7, 4.5) & (p[:, 0] >= 0),
    ),
    "cutTube": (
        '<cutTube name="s" rmin="2" rmax="5" z="8" startphi="10" deltaphi="250" aunit="deg" lowX="0.3" lowY="0" lowZ="-0.9"'
        ' highX="-0.2" highY="0.1" highZ="0.9"/>',
        in_cut_tube,
    ),
    "cone": (
        '<cone name="s" rmin1="1" rmax1="4" rmin2="3" rmax2="8" z="12" startphi="90" deltaphi="90" aunit="deg"/>',
        lambda p: in_cone(p, 1, 4, 3, 8, 6) & in_phi(p, 90, 90),
    ),
    "sphere": (
        '<sphere name="s" rmin="3" rmax="8" startphi="20" deltaphi="200" starttheta="30" deltatheta="90" aunit="deg"/>',
        in_sphere,
    ),
    "lower half": (
        '<sphere name="s" rmin="0" rmax="8" startphi="0" deltaphi="360" starttheta="90" deltatheta="90" aunit="deg"/>',
        lambda p: (np.linalg.norm(p, axis=1) <= 8) & (p[:, 2] <= 0),
    ),
    "orb": ('<orb name="s" r="7.5"/>', lambda p: np.linalg.norm(p, axis=1) <= 7.5),
    "ellipsoid": (
        '<ellipsoid name="s" ax="4" by="6" cz="9" zcut1="-3" zcut2="7"/>',
        lambda p: (((p / [4, 6, 9]) ** 2).sum(axis=1) <= 1) & (p[:, 2] >= -3) & (p[:, 2] <= 7),
    ),
    "eltube": (
        '<eltube name="s" dx="3" dy="7" dz="5"/>',
        lambda p: ((p[:, 0] / 3) ** 2 + (p[:, 1] / 7) ** 2 <= 1) & (abs(p[:, 2]) <= 5),
    ),
    "elcone": (
        '<elcone name="s" dx="0.5" dy="0.75" zmax="10" zcut="4"/>',
        lambda p: (
            ((p[:, 0] / 0.5) ** 2 + (p[:, 1] / 0.75) ** 2 <= (10 - p[:, 2]) ** 2) & (abs(p[:, 2]) <= 4)
        ),
    ),
    "paraboloid": (
        '<paraboloid name="s" rlo="2" rhi="8" dz="6"/>',
        lambda p: (radius(p) ** 2 <= 4 + 60 * (p[:, 2] + 6) / 12) & (abs(p[:, 2]) <= 6),
    ),
    "hype": ('<hype name="s" rmin="2" rmax="4" inst="20" outst="40" z="12" aunit="deg"/>', hyperbolic),
    "trd": ('<trd name="s" x1="4" x2="12" y1="10" y2="5" z="14"/>', lambda p: in_trd(p, 4, 12, 10, 5, 7)),
    "point": ('<trd name="s" x1="12" x2="0" y1="10" y2="0" z="14"/>', lambda p: in_trd(p, 12, 0, 10, 0, 7)),
    "trap": (
        '<trap name="s" z="12" theta="10" phi="40" y1="8" x1="4" x2="6" alpha1="10" y2="10" x3="5" x4="7.5" alpha2="10"'
        ' aunit="deg"/>',
        in_trap,
    ),
    "para": ('<para name="s" x="6" y="8" z="12" alpha="15" theta="20" phi="30" aunit="deg"/>', in_para),
    "tet": ('<tet name="s" vertex1="p0" vertex2="p1" vertex3="p2" vertex4="p3"/>', lambda p: in_tet(p, CORNERS)),
    "tessellated": (f'<tessellated name="s">{FACETS}</tessellated>', lambda p: in_tet(p, CORNERS)),
    "arb8": (f'<arb8 name="s" {ARB8} dz="5"/>', lambda p: in_trd(p, 6, 4, 6, 4, 5)),
    "polycone": (
        f'<polycone name="s" startphi="0" deltaphi="360" aunit="deg">{planes(STEPS)}</polycone>',
        lambda p: in_stack(p, STEPS),
    ),
    "reversed polycone": (
        f'<polycone name="s" startphi="10" deltaphi="200" aunit="deg">{planes(STEPS[::-1])}</polycone>',
        lambda p: in_stack(p, STEPS) & in_phi(p, 10, 200),
    ),
    "touching polycone": (f'<polycone name="s">{planes(TOUCHING)}</polycone>', lambda p: in_stack(p, TOUCHING)),
    "genericPolycone": (
        f'<genericPolycone name="s" startphi="0" deltaphi="360" aunit="deg">{points(GENERIC)}</genericPolycone>',
        lambda p: in_stack(p, [(-6, 2, 2), (-3, 2, 7), (0, 2, 4), (5, 2, 7)]),
    ),
    "polyhedra": (
        f'<polyhedra name="s" startphi="20" deltaphi="360" numsides="5" aunit="deg">{planes(STEPS)}</polyhedra>',
        lambda p: in_polyhedra(p, 5, 20, 360, STEPS),
    ),
    "polyhedra of a wedge": (
        f'<polyhedra name="s" startphi="20" deltaphi="250" numsides="4" aunit="deg">{planes(STEPS)}</polyhedra>',
        lambda p: in_polyhedra(p, 4, 20, 250, STEPS),
    ),
    "one side": (
        f'<polyhedra name="s" startphi="20" deltaphi="40" numsides="1" aunit="deg">{planes(STEPS)}</polyhedra>',
        lambda p: in_polyhedra(p, 1, 20, 40, STEPS),
    ),
    "genericPolyhedra": (
        f'<genericPolyhedra name="s" startphi="0" deltaphi="360" numsides="6" aunit="deg">{points(GENERIC)}</genericPolyhedra>',
        lambda p: in_polyhedra(p, 6, 0, 360, [(-6, 2, 2), (-3, 2, 7), (0, 2, 4), (5, 2, 7)], np.cos(30 * DEG)),
    ),
    "xtru": (xtru(L, SHRINK), lambda p: in_xtru(p, L, SHRINK)),
    "xtru of many corners": (COMB, lambda p: in_xtru(p, TEETH, PUSH)),
    "subtraction": (
        '<box name="a" x="12" y="10" z="8"/><box name="b" x="4" y="2" z="20"/><subtraction name="s"><first ref="a"/>'
        '<second ref="b"/><position x="2" y="1" z="0"/><rotation x="0" y="0" z="30" unit="deg"/></subtraction>',
        lambda p: in_box(p, 12, 10, 8) & ~in_box(rotated(p - [2, 1, 0], -30, 2), 4, 2, 20),
    ),
    "union": (
        '<box name="a" x="12" y="2" z="4"/><box name="b" x="3" y="9" z="1"/><union name="s"><first ref="a"/>'
        '<second ref="b"/><position x="1" y="-2" z="3"/><rotation x="20" y="30" z="40" unit="deg"/>'
        '<firstposition x="-3" y="1" z="0"/><firstrotation x="90" y="50" z="0" unit="deg"/></union>',
        lambda p: in_box(rotated(rotated(p - [-3, 1, 0], -50, 1), -90, 0), 12, 2, 4)
        | in_box(rotated(rotated(rotated(p - [1, -2, 3], -40, 2), -30, 1), -20, 0), 3, 9, 1),
    ),
    "intersection": (
        '<box name="a" x="12" y="6" z="9"/><orb name="b" r="6"/><intersection name="s"><first ref="a"/><second ref="b"/>'
        '<position x="0" y="0" z="3"/></intersection>',
        lambda p: in_box(p, 12, 6, 9) & (np.linalg.norm(p - [0, 0, 3], axis=1) <= 6),
    ),
    "multiUnion": (
        '<box name="a" x="5" y="4" z="3"/><multiUnion name="s"><multiUnionNode name="1"><solid ref="a"/></multiUnionNode>'
        '<multiUnionNode name="2"><solid ref="a"/><position x="5" y="0" z="0"/></multiUnionNode>'
        '<multiUnionNode name="3"><solid ref="a"/><position x="0" y="5" z="0"/><rotation x="25" y="10" z="5" unit="deg"/>'
        "</multiUnionNode></multiUnion>",
        lambda p: in_box(p, 5, 4, 3) | in_box(p - [5, 0, 0], 5, 4, 3)
        | in_box(rotated(rotated(rotated(p - [0, 5, 0], -5, 2), -10, 1), -25, 0), 5, 4, 3),
    ),
    "scaledSolid": (
        '<orb name="a" r="3"/><scaledSolid name="s"><solidref ref="a"/><scale name="k" x="2" y="1" z="0.5"/></scaledSolid>',
        lambda p: np.linalg.norm(p / [2, 1, 0.5], axis=1) <= 3,
    ),
    "reflectedSolid": (
        '<trd name="a" x1="4" x2="12" y1="10" y2="5" z="14"/>'
        '<reflectedSolid name="s" solid="a" sx="1" sy="1" sz="-1" dx="1" dy="0" dz="0" rx="0" ry="0" rz="90" aunit="deg"/>',
        lambda p: in_trd(rotated(p - [1, 0, 0], -90, 2) * [1, 1, -1], 4, 12, 10, 5, 7),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_equals_its_formula(tmp_path, name):
    text, inside = SOLIDS[name]
    scene = solid_scene(tmp_path, text, "s", DEFINE)
    assert not [note for note in scene.notes if "left out" in note]
    p = np.random.default_rng(5).uniform(-10, 10, (10_000, 3))
    expected = inside(p)
    assert 50 < expected.sum() < 9_900
    found = np.asarray(scene.body_at(p)) == 0
    assert np.array_equal(found, expected)


def test_normals_of_flat_solids_are_whole_numbers_if_these_are_short(tmp_path):
    """The side of a trd rises by 4 along 14. Its normal (7, 0, -2) and its offset 7 · 4 at z = 0 are floats."""
    shape = solid_scene(tmp_path, '<trd name="s" x1="4" x2="12" y1="10" y2="10" z="14"/>', "s").bodies[0].shape
    sides = {(7, 0, -2): 28, (-7, 0, -2): 28, (0, 1, 0): 5, (0, -1, 0): 5, (0, 0, 1): 7, (0, 0, -1): 7}
    assert dict(zip(map(tuple, shape.normals), shape.offsets, strict=True)) == sides


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_sides_are_flat_to_a_hundred_thousandth_of_their_size(share, tmp_path):
    """The corner (1, 1, 1) of a cube is moved by e in x: x = 1 + e (1 + y) (1 + z) / 4 on the ruled side.

    The flat side has its normal along the vector area and the mean height: x = 1 + e (1 + y + z) / 4, which leaves all
    corners by e / 4. The size of the side is 2.
    """
    e = share * 8e-5
    low, high = [(-1, -1), (-1, 1), (1, 1), (1, -1)], [(-1, -1), (-1, 1), (1 + e, 1), (1, -1)]
    scene = solid_scene(tmp_path, f'<arb8 name="s" {corners(low, high)} dz="1"/>', "s")
    y, z = np.random.default_rng(1).uniform(-0.99, 0.99, (2, 50))
    found = scene.first_hit(np.column_stack([np.full(50, 5.0), y, z]), (-1, 0, 0))
    above = 1 + y + z if share < 1 else (1 + y) * (1 + z)
    np.testing.assert_allclose(5 - found.t, 1 + e * above / 4, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("delta", "count"), [("6.283185307", 2), ("6.28318530", 4)])
def test_two_pi_of_ten_digits_is_a_full_turn(tmp_path, delta, count):
    """Geant4's tubes are full from 2 pi - 5e-10 on. A slit of 7e-9 has two walls that a ray across y = 0 meets."""
    scene = solid_scene(tmp_path, f'<tube name="s" rmax="7" z="9" startphi="0" deltaphi="{delta}"/>', "s")
    assert len(scene.crossings([(5, -20, 1)], [(0, 1, 0)]).t) == count


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            xtru([(x, x * x * (-1) ** x) for x in range(500)], [(0, 0, 0, 1), (1, 0, 0, 1)]),
            "xtru 's': it has 500 faces, more than the 400 of a concave solid",
        ),
        (
            '<torus name="s" rmin="0" rmax="1" rtor="5" startphi="0" deltaphi="360"/>',
            "torus 's': is no quadric; left out",
        ),
        ('<twistedbox name="s" x="1" y="1" z="1" PhiTwist="1"/>', "twistedbox 's': is no quadric; left out"),
        (
            '<tessellated name="s"><triangular vertex1="p0" vertex2="p1" vertex3="p2"/></tessellated>',
            "no closed surface",
        ),
        (
            xtru(PENTAGRAM, [(0, 0, 0, 1), (1, 0, 0, 0.5)]),
            "outline must not cross or touch itself",
        ),
        (
            f'<genericPolyhedra name="s" startphi="0" deltaphi="6" numsides="9">{points(BOW)}</genericPolyhedra>',
            "no simple outline: edges cross",
        ),
    ],
)
def test_impossible_solids_are_left_out_and_reported(tmp_path, text, message):
    from .files import placed, scene_of, text_of, volume

    structure = volume("v", "s") + volume("world", "w", placed("v"))
    scene = scene_of(tmp_path, text_of(text + '<box name="w" x="9" y="9" z="9"/>', structure, DEFINE))
    assert [body.name for body in scene.bodies] == ["world"]
    assert any(note.startswith("a.gdml:") and message in note for note in scene.notes)
    with pytest.raises(ValueError, match="strict is set"):
        scene_of(tmp_path, text_of(text, structure.replace('"w"', '"s"'), DEFINE), strict=True)


# --- Solids with twisted sides, against sections at each height

BOTTOM = [(-4, -5), (-6, 4), (3, 6), (5, -3)]
TOP = [(-2, -6), (-5, 2), (2, 4), (6, -1)]


def corners(low, high):
    return " ".join(f'v{k}x="{x}" v{k}y="{y}"' for k, (x, y) in enumerate([*low, *high], 1))


def within_sections(p, low, high, half):
    """Corners move evenly from low to high. At its height a point is on one side of every edge (clockwise corners)."""
    share = ((p[:, 2] + half) / (2 * half))[:, None]
    at = [(1 - share) * a + share * b for a, b in zip(np.array(low, float), np.array(high, float), strict=True)]
    found = abs(p[:, 2]) <= half
    for a, b in zip(at, [*at[1:], at[0]], strict=True):
        d, q = b - a, p[:, :2] - a
        found &= d[:, 0] * q[:, 1] - d[:, 1] * q[:, 0] <= 0
    return found


def twisted_tube(p, twist, inner, outer, low, high, width):
    """In a section the sides are at ± width / 2 from atan(k z). Radii at z = 0 grow by sqrt(1 + k² z²)."""
    z = p[:, 2]
    k = np.tan(twist / 2 * DEG) / max(abs(low), abs(high))
    grown = np.sqrt(1 + (k * z) ** 2)
    turned = np.arctan(k * z) / DEG
    inside = (z >= low) & (z <= high) & (radius(p) >= inner * grown) & (radius(p) <= outer * grown)
    return inside & (in_phi(p, turned - width / 2, width) if width < 360 else True)


C30 = np.cos(30 * DEG)
TWISTED = {
    "arb8": (f'<arb8 name="s" {corners(BOTTOM, TOP)} dz="7"/>', lambda p: within_sections(p, BOTTOM, TOP, 7)),
    "counter-clockwise": (
        f'<arb8 name="s" {corners(BOTTOM[::-1], TOP[::-1])} dz="7"/>',
        lambda p: within_sections(p, BOTTOM, TOP, 7),
    ),
    "from an edge": (
        f'<arb8 name="s" {corners([(-4, -5), (-4, -5), (3, 6), (3, 6)], TOP)} dz="7"/>',
        lambda p: within_sections(p, [(-4, -5), (-4, -5), (3, 6), (3, 6)], TOP, 7),
    ),
    "trap": (
        '<trap name="s" z="14" y1="8" x1="4" x2="10" alpha1="0" y2="10" x3="9" x4="5" alpha2="20" aunit="deg"/>',
        lambda p: within_sections(
            p, [(-2, -4), (-5, 4), (5, 4), (2, -4)],
            [(x + y * np.tan(20 * DEG), y) for x, y in [(-4.5, -5), (-2.5, 5), (2.5, 5), (4.5, -5)]], 7,
        ),
    ),
    "twistedtubs": (
        '<twistedtubs name="s" twistedangle="60" endinnerrad="3" endouterrad="8" zlen="14" phi="70" aunit="deg"/>',
        lambda p: twisted_tube(p, 60, 3 * C30, 8 * C30, -7, 7, 70),
    ),
    "the other way": (
        '<twistedtubs name="s" twistedangle="-60" endinnerrad="3" endouterrad="8" zlen="14" phi="250" aunit="deg"/>',
        lambda p: twisted_tube(p, -60, 3 * C30, 8 * C30, -7, 7, 250),
    ),
    "segments": (
        '<twistedtubs name="s" twistedangle="60" endinnerrad="3" endouterrad="8" zlen="14" nseg="3" totphi="360"'
        ' aunit="deg"/>',
        lambda p: twisted_tube(p, 60, 3 * C30, 8 * C30, -7, 7, 120),
    ),
    "by middle radii": (
        '<twistedtubs name="s" twistedangle="100" midinnerrad="2" midouterrad="5" negativeEndz="-3" positiveEndz="8"'
        ' phi="360" aunit="deg"/>',
        lambda p: twisted_tube(p, 100, 2, 5, -3, 8, 360),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TWISTED)
def test_a_twisted_solid_has_its_sections(tmp_path, name):
    text, inside = TWISTED[name]
    scene = solid_scene(tmp_path, text, "s")
    assert not [note for note in scene.notes if "left out" in note]
    p = np.random.default_rng(6).uniform(-9, 9, (20_000, 3))
    expected = inside(p)
    assert 500 < expected.sum() < 15_000
    assert np.array_equal(np.asarray(scene.body_at(p)) == 0, expected)
    low, high = scene.bodies[0].shape.bounds
    assert (low >= -10).all()
    assert (high <= 10).all()
    assert (low <= p[expected].min(axis=0)).all()
    assert (high >= p[expected].max(axis=0)).all()


def test_a_section_that_bends_inward_is_left_out(tmp_path):
    # Halfway the corner (2, 2) of a square is at (0, 0) - (1, 1) / 2, behind the line through its neighbours.
    low, high = [(-2, -2), (-2, 2), (2, 2), (2, -2)], [(-2, -2), (-2, 2), (-3, -3), (2, -2)]
    scene = solid_scene(tmp_path, f'<arb8 name="a" {corners(low, high)} dz="7"/><box name="s" x="1" y="1" z="1"/>', "s")
    assert any("between its ends is not convex" in note for note in scene.notes)


# --- Random solids in random Booleans, at random points, points near walls, and hits


def random_planes(g):
    """Return two to five planes, some at one height, some without a bore, from above as often as from below."""
    heights = np.cumsum([-6, 2, *g.choice([0, 1, 3], g.integers(0, 4))])
    outer = g.uniform(2, 8, len(heights))
    rows = np.stack([heights, outer * g.choice([0, 0.5, 0.9], len(heights)), outer], axis=1).tolist()
    return rows[:: g.choice([1, -1])]


def random_outline(g, middle):
    """Return a star about (middle, 0), of either sense."""
    count = g.integers(5, 9)
    angles = (np.arange(count) + g.uniform(-0.2, 0.2, count)) * 2 * np.pi / count
    reach = g.uniform(1, 5, count)
    return np.stack([middle + reach * np.cos(angles), reach * np.sin(angles)], axis=1).tolist()[:: g.choice([1, -1])]


def random_quad(g):
    """Return corners of an ellipse, clockwise."""
    angles = -np.arange(4) * 90 + g.uniform(-15, 15, 4)
    return np.stack([g.uniform(4, 6) * np.cos(angles * DEG), g.uniform(4, 6) * np.sin(angles * DEG)], axis=1).tolist()


def random_solid(g, kind):
    """Return the text of a solid named "s", and its formula."""
    start, delta, count = g.choice([0, 90, -200.5]), g.choice([360, 270, 100]), g.integers(3, 8)
    turn = f'name="s" startphi="{start}" deltaphi="{delta}" aunit="deg"'
    rows, outline, share = random_planes(g), random_outline(g, 6), np.cos(delta / count / 2 * DEG)
    match kind:
        case "polycone":
            return f"<polycone {turn}>{planes(rows)}</polycone>", lambda p: in_stack(p, rows) & in_phi(p, start, delta)
        case "polyhedra":
            text = f'<polyhedra {turn} numsides="{count}">{planes(rows)}</polyhedra>'
            return text, lambda p: in_polyhedra(p, count, start, delta, rows)
        case "genericPolycone":
            text = f"<genericPolycone {turn}>{points(outline)}</genericPolycone>"
            return text, lambda p: in_polygon(radius(p), p[:, 2], outline) & in_phi(p, start, delta)
        case "genericPolyhedra":
            text = f'<genericPolyhedra {turn} numsides="{count}">{points(outline)}</genericPolyhedra>'
            return text, lambda p: in_polygon(across_sides(p, count, start, delta) / share, p[:, 2], outline)
        case "xtru":
            star, heights = random_outline(g, 0), np.cumsum(g.uniform(1, 4, 3)) - 6
            sections = [(z, *g.uniform(-2, 2, 2), g.choice([1, 0.4])) for z in heights]
            return xtru(star, sections), lambda p: in_xtru(p, star, sections)
        case "arb8":
            low, high = random_quad(g), random_quad(g)
            return f'<arb8 name="s" {corners(low, high)} dz="5"/>', lambda p: within_sections(p, low, high, 5)


KINDS = ("polycone", "polyhedra", "genericPolycone", "genericPolyhedra", "xtru", "arb8")
BOOLEANS = {"union": np.logical_or, "intersection": np.logical_and, "subtraction": np.greater}


@pytest.mark.parametrize(("kind", "seed"), in_turn(KINDS, range(6)))
def test_random_solids_equal_their_formulas(tmp_path, kind, seed):
    g = np.random.default_rng([seed, KINDS.index(kind)])
    (first, one), (second, other) = random_solid(g, kind), random_solid(g, g.choice(KINDS))
    shift, angles, scale = g.uniform(-3, 3, 3), g.uniform(-180, 180, 3), g.choice([-1, 1, 0.5], 3)

    def operands(p):
        q = p / scale
        r = q - shift
        for axis in (2, 1, 0):
            r = rotated(r, -angles[axis], axis)
        return one(q), other(r)

    p = g.uniform(-12, 12, (4_000, 3)) * scale
    boolean = next(name for name in g.permutation(list(BOOLEANS)) if BOOLEANS[name](*operands(p)).any())

    def inside(p):
        return BOOLEANS[boolean](*operands(p))

    a, b = (text.replace('name="s"', f'name="{name}"') for text, name in ((first, "a"), (second, "b")))
    x, y, z = (
        " ".join(f'{axis}="{value}"' for axis, value in zip("xyz", row, strict=True)) for row in (shift, angles, scale)
    )
    text = (
        f'{a}{b}<{boolean} name="c"><first ref="a"/>'
        f'<second ref="b"/><position {x}/><rotation {y} unit="deg"/></{boolean}>'
        f'<scaledSolid name="s"><solidref ref="c"/><scale name="k" {z}/></scaledSolid>'
    )
    scene = solid_scene(tmp_path, text, "s")
    points_inside = p[inside(p)]
    low, high = points_inside[g.integers(len(points_inside), size=500)], p[~inside(p)][:500]
    step = high - low
    for _ in range(50):
        middle = (low + high) / 2
        within = inside(middle)[:, None]
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    p = np.concatenate([p, low - 1e-8 * step, high + 1e-8 * step])
    assert np.array_equal(np.asarray(scene.body_at(p)) == 0, inside(p))
    # Rays to walls of the formula: the solid has a wall where they arrive
    hits = scene.first_hit(p[:500] * 3, low - p[:500] * 3)
    assert hits.hit.sum() > 400
    point, normal = hits.point[hits.hit], hits.normal[hits.hit]
    assert np.array_equal(inside(point - 1e-9 * normal), ~inside(point + 1e-9 * normal))
