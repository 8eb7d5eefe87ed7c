"""Files of other programs that use every part of a format that an export can write."""

from pathlib import Path

import numpy as np

import conicoid as co

from ..gdml.files import placed, text_of, volume

_ALL = 'deltaphi="360" aunit="deg" lunit="mm"'
GDML_SOLIDS = {
    "box": '<box name="{}" x="3.1" y="4.7" z="5.3" lunit="cm"/>',
    "tube": f'<tube name="{{}}" rmin="3" rmax="11" z="33" {_ALL}/>',
    "wedge": '<tube name="{}" rmin="3" rmax="11" z="33" startphi="20" deltaphi="123" aunit="deg" lunit="mm"/>',
    "wide": '<tube name="{}" rmin="0" rmax="11.7" z="33" startphi="-20" deltaphi="300.1" aunit="deg" lunit="mm"/>',
    "cutTube": '<cutTube name="{}" rmin="2" rmax="8" z="30" startphi="0" deltaphi="360" lowX="0.1" lowY="0.2" lowZ="-0.9"'
    ' highX="0.3" highY="0" highZ="0.8" aunit="deg" lunit="mm"/>',
    "cone": f'<cone name="{{}}" rmin1="1" rmax1="7" rmin2="2" rmax2="3" z="20" {_ALL}/>',
    "tip": f'<cone name="{{}}" rmin1="0" rmax1="7" rmin2="0" rmax2="0" z="20" {_ALL}/>',
    "sphere": '<sphere name="{}" rmin="3" rmax="9" startphi="10" deltaphi="100" starttheta="20" deltatheta="80"'
    ' aunit="deg" lunit="mm"/>',
    "shell": '<sphere name="{}" rmin="3.3" rmax="9.1" deltaphi="360" deltatheta="180" aunit="deg" lunit="mm"/>',
    "orb": '<orb name="{}" r="9.7" lunit="mm"/>',
    "ellipsoid": '<ellipsoid name="{}" ax="5" by="7" cz="11" zcut1="-8" zcut2="6" lunit="mm"/>',
    "whole ellipsoid": '<ellipsoid name="{}" ax="5.1" by="7.3" cz="11.9" zcut1="0" zcut2="0" lunit="mm"/>',
    "eltube": '<eltube name="{}" dx="5" dy="7.3" dz="9" lunit="mm"/>',
    "elcone": '<elcone name="{}" dx="0.5" dy="0.7" zmax="20" zcut="9" lunit="mm"/>',
    "paraboloid": '<paraboloid name="{}" rlo="3" rhi="8" dz="10" lunit="mm"/>',
    "hype": '<hype name="{}" rmin="2" rmax="5" inst="10" outst="25" z="30" aunit="deg" lunit="mm"/>',
    "trd": '<trd name="{}" x1="10" x2="15" y1="7" y2="21" z="13" lunit="mm"/>',
    "trap": '<trap name="{}" z="16" theta="10" phi="0" y1="11" x1="12" x2="14" alpha1="5" y2="11" x3="12" x4="14"'
    ' alpha2="5" aunit="deg" lunit="mm"/>',
    "para": '<para name="{}" x="6" y="7" z="8" alpha="10" theta="15" phi="20" aunit="deg" lunit="mm"/>',
    "arb8": '<arb8 name="{}" v1x="-5" v1y="-5" v2x="5" v2y="-5" v3x="5" v3y="5" v4x="-5" v4y="5" v5x="-3" v5y="-3" v6x="3"'
    ' v6y="-3" v7x="3" v7y="3" v8x="-3" v8y="3" dz="7" lunit="mm"/>',
    "polycone": f'<polycone name="{{}}" startphi="0" {_ALL}><zplane z="-10" rmin="1" rmax="7"/>'
    '<zplane z="3" rmin="2" rmax="9"/><zplane z="8" rmin="2" rmax="4"/></polycone>',
    "polyhedra": f'<polyhedra name="{{}}" startphi="10" numsides="6" {_ALL}><zplane z="-10" rmin="1" rmax="7"/>'
    '<zplane z="3" rmin="2" rmax="9"/></polyhedra>',
    "prism": f'<polyhedra name="{{}}" startphi="0" numsides="8" {_ALL}><zplane z="-10" rmin="0" rmax="7"/>'
    '<zplane z="12" rmin="0" rmax="7"/></polyhedra>',
    "xtru": '<xtru name="{}" lunit="mm"><twoDimVertex x="0" y="0"/><twoDimVertex x="11" y="0"/><twoDimVertex x="4" y="4"/>'
    '<twoDimVertex x="0" y="12"/><section zOrder="0" zPosition="-6" xOffset="0" yOffset="0" scalingFactor="1"/>'
    '<section zOrder="1" zPosition="7" xOffset="0" yOffset="0" scalingFactor="1"/></xtru>',
    "scaled xtru": '<xtru name="{}" lunit="mm"><twoDimVertex x="0" y="0"/><twoDimVertex x="11" y="0"/>'
    '<twoDimVertex x="4" y="4"/><twoDimVertex x="0" y="12"/>'
    '<section zOrder="0" zPosition="-6" xOffset="0" yOffset="0" scalingFactor="1"/>'
    '<section zOrder="1" zPosition="7" xOffset="1" yOffset="-2" scalingFactor="0.5"/></xtru>',
}
"""One solid of each element, without its name."""
BOOLEANS = """
<box name="block" x="20" y="20" z="20"/> <tube name="bore" rmin="0" rmax="6" z="50" deltaphi="360" aunit="deg"/>
<subtraction name="bored"><first ref="block"/><second ref="bore"/><position x="7" y="5" z="0"/>
  <rotation x="10" y="20" z="-35" unit="deg"/></subtraction>
<union name="both"><first ref="bored"/><second ref="block"/><position x="-17" y="5" z="1.3"/>
  <rotation z="90" unit="deg"/><firstposition x="1.1" y="0" z="0"/><firstrotation x="30" unit="deg"/></union>
<intersection name="common"><first ref="both"/><second ref="bored"/><position x="0.3" y="0.4" z="0.5"/></intersection>
<multiUnion name="many"><multiUnionNode name="a"><solid ref="bore"/><position x="10" y="0" z="0"/></multiUnionNode>
  <multiUnionNode name="b"><solid ref="block"/><rotation y="45" unit="deg"/></multiUnionNode></multiUnion>
<scaledSolid name="long"><solidref ref="bored"/><scale x="1" y="1.5" z="0.7"/></scaledSolid>
<reflectedSolid name="mirrored" solid="both" sx="1" sy="1" sz="-1" rx="0" ry="0" rz="0.3" dx="1" dy="2" dz="3"/>
"""
TURNS = ("", '<rotation x="10" y="20" z="-35" unit="deg"/>', '<rotation z="90" unit="deg"/>')


def detector(solids: dict[str, str], more: str = "", others: tuple[str, ...] = ()) -> str:
    """Return solids at places of their own, a third of them turned, and two copies of a nest of three."""
    names = [f"s{k}" for k in range(len(solids))]
    text = "".join(each.format(name) for name, each in zip(names, solids.values(), strict=True)) + more
    names += others
    text += '<box name="w" x="600" y="600" z="600"/><box name="nest" x="80" y="80" z="80"/>'
    text += '<orb name="ball" r="9.7"/><box name="cube" x="8" y="8" z="8"/>'
    volumes = "".join(volume(f"V{name}", name, material=("iron", "air")[k % 2]) for k, name in enumerate(names))
    volumes += volume("Vcube", "cube")
    volumes += volume("Vball", "ball", placed("Vcube", '<position x="1.5" y="0.25" z="-0.75"/>' + TURNS[1]), "air")
    inner = placed("Vball", f'<position x="1.7" y="2.3" z="0.1"/>{TURNS[1]}', 'name="in" copynumber="3"')
    inner += placed("Vball", '<position x="-21.7" y="2.3" z="0.1"/>', 'name="in" copynumber="4"')
    volumes += volume("Vnest", "nest", inner)
    places = "".join(
        placed(
            f"V{name}", f'<position x="{-220 + 70 * (k % 7)}.3" y="{-220 + 70 * (k // 7)}" z="0.{k}"/>{TURNS[k % 3]}'
        )
        for k, name in enumerate(names)
    )
    for z, turn in ((-200, TURNS[1]), (200, TURNS[2])):
        places += placed("Vnest", f'<position x="0" y="0.7" z="{z}"/>{turn}', f'name="nest{z}"')
    return text_of(text, volumes + volume("W", "w", places, "air"), world="W")


SCAD = """
color([0.2, 0.4, 0.6, 1]) {
 multmatrix([[0.8, -0.6, 0, 1.5], [0.6, 0.8, 0, 0.25], [0, 0, 1, -0.3], [0, 0, 0, 1]]) {
  difference() {
   cube(size = [2.1, 1.7, 1.3], center = true);
   cylinder($fn = 0, $fa = 12, $fs = 2, h = 3.3, r1 = 0.4, r2 = 0.4, center = true);
   multmatrix([[1, 0, 0, 0.7], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) sphere($fn = 0, $fa = 12, $fs = 2, r = 0.35);
  }
 }
 multmatrix([[1, 0, 0, -3], [0, 1.5, 0, 0], [0, 0, 0.7, 0.1], [0, 0, 0, 1]]) sphere($fn = 0, $fa = 12, $fs = 2, r = 0.9);
}
color([1, 0, 0, 1]) union() {
 cylinder($fn = 0, $fa = 12, $fs = 2, h = 1.7, r1 = 0.9, r2 = 0.2, center = false);
 multmatrix([[1, 0, 0, 3.3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
  rotate_extrude(angle = 270, start = 30, $fn = 0, $fa = 12, $fs = 2) polygon(points = [[0.2, 0], [0.7, 0.1], [0.5, 0.9]]);
 multmatrix([[1, 0, 0, 0], [0, 1, 0, 3.1], [0, 0, 1, 0], [0, 0, 0, 1]])
  linear_extrude(height = 1.1, center = true, scale = 0.5, $fn = 0, $fa = 12, $fs = 2)
   polygon(points = [[0, 0], [1.1, 0], [0.3, 0.9], [0.1, 0.3]]);
 multmatrix([[1, 0, 0, 0], [0, 1, 0, -3.1], [0, 0, 1, 0], [0, 0, 0, 1]]) sphere($fn = 7, $fa = 12, $fs = 2, r = 0.8);
 multmatrix([[1, 0, 0, 0], [0, 1, 0, -5.1], [0, 0, 1, 0], [0, 0, 0, 1]])
  polyhedron(points = [[0, 0, 0], [1.1, 0, 0], [0, 1.3, 0], [0, 0, 0.7]], faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]);
 multmatrix([[1, 0, 0, 0], [0, 1, 0, -7.1], [0, 0, 1, 0], [0, 0, 0, 1]])
  cylinder($fn = 6, $fa = 12, $fs = 2, h = 1.7, r1 = 0.4, r2 = 0.9, center = false);
}
color([0, 1, 0, 1]) multmatrix([[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1]]) intersection() {
 cube(size = [1.3, 1.3, 1.3], center = false);
 color([1, 1, 0, 1]) sphere($fn = 0, $fa = 12, $fs = 2, r = 1.2);
}
"""


# --- Comparisons of scenes that must answer alike, to the last bit


def written_and_read(scene: co.Scene, path: Path, **options) -> co.Scene:
    """Write a scene and return the scene of the file.

    Lengths keep their numbers, because units have tests of their own.
    """
    co.export(scene.replace(unit=None), path, **options)
    return co.load(path)


def rays_through(scene: co.Scene, count: int = 1500) -> co.Rays:
    """Return rays from around a scene to points in it.

    A tenth of them go along the axes, so that they run in flat faces too.
    """
    rng = np.random.default_rng(7)
    low, high = scene.extent
    size = (high - low).max()
    origins = rng.uniform(low - 0.1 * size, high + 0.1 * size, (count, 3))
    ends = rng.uniform(low, high, (count, 3))
    directions = ends - origins
    straight = count // 10
    directions[:straight] = np.eye(3)[rng.integers(0, 3, straight)]
    return co.Rays(origins, directions)


def assert_same_answers(one: co.Scene, other: co.Scene, count: int = 1500) -> None:
    """Assert equal spans, first hits and points, bit by bit, and that at least one ray hits."""
    rays = rays_through(one, count)
    a, b = one.spans(rays), other.spans(rays)
    assert len(a.t_enter) > 0
    for name in ("offsets", "body", "t_enter", "t_exit"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    mine, its = one.first_hit(rays), other.first_hit(rays)
    for name in ("body", "t", "normal", "entering"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(its, name), err_msg=name)
    points = rays.origins + rays.directions
    np.testing.assert_array_equal(one.body_at(points), other.body_at(points))


def assert_close_answers(one: co.Scene, other: co.Scene, tolerance: float = 1e-9) -> None:
    """Assert equal bodies along rays, with lengths within a tolerance: the file has rounded numbers."""
    rays = rays_through(one, 400)
    a, b = (scene.spans(rays).lengths() for scene in (one, other))
    size = float((one.extent[1] - one.extent[0]).max())
    np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * size)
