"""Whole files against an evaluator that shares no code."""

from __future__ import annotations

import numpy as np
import pytest

from .evaluator import Evaluator
from .files import placed, scene_of, text_of, volume

SOLIDS = """
<box name="w" x="200" y="200" z="200"/>
<tube name="t" rmin="2" rmax="9" z="20" startphi="15" deltaphi="300" aunit="deg"/>
<trap name="p" z="24" theta="10" phi="40" y1="16" x1="8" x2="12" alpha1="10" y2="20" x3="10" x4="15" alpha2="10" aunit="deg"/>
<trd name="d" x1="6" x2="20" y1="10" y2="5" z="30"/>
<cone name="c" rmin1="1" rmax1="4" rmin2="3" rmax2="8" z="12"/>
<union name="u"><first ref="d"/><second ref="t"/><position x="3" y="-2" z="5"/><rotation x="20" y="30" z="40" unit="deg"/></union>
<subtraction name="s"><first ref="u"/><second ref="c"/><rotation x="-70" y="10" z="5" unit="deg"/></subtraction>
<box name="b" x="60" y="60" z="60"/>
"""


@pytest.mark.parametrize("seed", range(3))
def test_the_deepest_volume(tmp_path, seed):
    chance = np.random.default_rng(seed)

    def motion(reach):
        x, y, z = chance.uniform(-reach, reach, 3)
        a, b, c = chance.uniform(-180, 180, 3)
        return f'<position x="{x}" y="{y}" z="{z}"/><rotation x="{a}" y="{b}" z="{c}" unit="deg"/>'

    structure = volume("vc", "c") + volume("vs", "s") + volume("vp", "p", placed("vc", '<position x="1" y="0" z="2"/>'))
    structure += volume("vb", "b", placed("vs", motion(5)))
    inside = "".join(
        placed(name, f'<position x="{x}" y="{y}" z="{z}"/>' + motion(1).partition("/>")[2])
        for name, x, y, z in [
            ("vb", -40, -40, 0),
            ("vb", 40, 40, 0),
            ("vp", 50, -50, 0),
            ("vp", -50, 50, 30),
            ("vs", 0, 0, 75),
        ]
    )
    text = text_of(SOLIDS, structure + volume("world", "w", inside))
    scene = scene_of(tmp_path, text)
    p = chance.uniform(-100, 100, (100_000, 3))
    p[50_000:] = (
        chance.uniform(-30, 30, (50_000, 3))
        + np.array([(-40, -40, 0), (40, 40, 0), (50, -50, 0), (0, 0, 75)])[chance.integers(0, 4, 50_000)]
    )
    names = np.array([body.name.rpartition("/")[2].partition("#")[0] for body in scene.bodies] + [""], object)
    found, expected = names[np.asarray(scene.body_at(p))], Evaluator(tmp_path / "a.gdml").deepest(p)
    assert set(expected) == {"", "world", "vb", "vs", "vp", "vc"} - ({""} if (abs(p) <= 100).all() else set())
    assert (found != expected).sum() == 0
