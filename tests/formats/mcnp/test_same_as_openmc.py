"""The same assembly as MCNP deck and as OpenMC geometry: the same spans, to the bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import conicoid as co

from .decks import chosen, loaded

PITCH, PINS = 1.26, 5
GUIDES = {(1, 1), (3, 1), (2, 2), (1, 3), (3, 3)}

DECK = """\
Five by five pins
1 1 -10.4  -1 u=1 imp:n=1
2 2 -6.55  1 -2 u=1 imp:n=1
3 3 -0.7   2 u=1 imp:n=1
4 3 -0.7   -3 u=2 imp:n=1
5 2 -6.55  3 -4 u=2 imp:n=1
6 3 -0.7   4 u=2 imp:n=1
10 0 -10 u=5 lat=1 imp:n=1 fill=-2:2 -2:2 0:0
{rows}
20 0 -20 fill=5 imp:n=1
99 0 20 imp:n=0

1 cz 0.4096
2 cz 0.475
3 cz 0.561
4 cz 0.602
10 rpp -0.63 0.63 -0.63 0.63 -10 10
20 rpp -3.15 3.15 -3.15 3.15 -10 10

m1 92235 1
m2 40000 1
m3 1001 2 8016 1
"""

XML = """\
<geometry>
  <surface id="1" type="z-cylinder" coeffs="0 0 0.4096"/>
  <surface id="2" type="z-cylinder" coeffs="0 0 0.475"/>
  <surface id="3" type="z-cylinder" coeffs="0 0 0.561"/>
  <surface id="4" type="z-cylinder" coeffs="0 0 0.602"/>
  <surface id="5" type="x-plane" coeffs="-3.15"/> <surface id="6" type="x-plane" coeffs="3.15"/>
  <surface id="7" type="y-plane" coeffs="-3.15"/> <surface id="8" type="y-plane" coeffs="3.15"/>
  <surface id="9" type="z-plane" coeffs="-10"/> <surface id="10" type="z-plane" coeffs="10"/>
  <cell id="1" universe="1" material="1" region="-1"/>
  <cell id="2" universe="1" material="2" region="1 -2"/>
  <cell id="3" universe="1" material="3" region="2"/>
  <cell id="4" universe="2" material="3" region="-3"/>
  <cell id="5" universe="2" material="2" region="3 -4"/>
  <cell id="6" universe="2" material="3" region="4"/>
  <lattice id="5" dimension="5 5" lower_left="-3.15 -3.15" pitch="1.26 1.26" universes="{rows}"/>
  <cell id="20" fill="5" region="5 -6 7 -8 9 -10"/>
</geometry>
"""


def test_the_same_spans(tmp_path: Path) -> None:
    rows = [" ".join("2" if (i, j) in GUIDES else "1" for i in range(PINS)) for j in range(PINS)]
    deck = loaded(tmp_path, DECK.format(rows="\n".join("     " + row for row in rows)))
    path = tmp_path / "geometry.xml"
    path.write_text(XML.format(rows=" ".join(reversed(rows))), encoding="utf-8")
    model = co.load(path)
    assert len(deck.bodies) == len(model.bodies) == 75
    points, ends = chosen(3, 3000, 4.0), chosen(4, 3000, 4.0)
    mine, other = (scene.spans(points, ends - points) for scene in (deck, model))
    assert len(mine.t_enter) > 10_000
    np.testing.assert_array_equal(mine.t_enter, other.t_enter)
    np.testing.assert_array_equal(mine.t_exit, other.t_exit)
    cells = [
        [body.name.split(" @ ")[0] for body in (scene.bodies[int(n)] for n in spans.body[:2000])]
        for scene, spans in ((deck, mine), (model, other))
    ]
    assert cells[0] == cells[1]
