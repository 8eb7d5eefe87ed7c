"""Voids around parts from CAD: what is outside of flat pieces, or in a bore of them, becomes one polyhedron less."""

from __future__ import annotations

import numpy as np

import conicoid as co

DECK = """a bored wedge in a box
1 1 -2.0 (-1 -2 3 4 -5 7) imp:n=1
2 0 (8 -9 10 -11 12 -13) (1 : 2 : -3 : -4 : 5 : -7) imp:n=1
3 0 (-8 : 9 : -10 : 11 : -12 : 13) imp:n=0

1 p 1 1 0 2
2 p 1 -1 0 2
3 px -1
4 pz -1
5 pz 1.5
7 c/z 0.2 0.1 0.4
8 px -4
9 px 4
10 py -5
11 py 5
12 pz -3
13 pz 3

m1 26056 1.0
"""


def test_a_void_around_a_bored_part_is_a_box_without_a_polyhedron_and_a_bore(tmp_path) -> None:
    (tmp_path / "wedge.mcnp").write_text(DECK)
    scene = co.load(tmp_path / "wedge.mcnp")
    points = np.random.default_rng(0).uniform((-4, -5, -3), (4, 5, 3), (20_000, 3))
    x, y, z = points.T
    wedge = (x + y < 2) & (x - y < 2) & (x > -1) & (z > -1) & (z < 1.5)
    solid = wedge & ((x - 0.2) ** 2 + (y - 0.1) ** 2 > 0.16)
    assert solid.sum() > 500
    assert (wedge & ~solid).sum() > 50
    assert np.array_equal(scene.body_at(points), np.where(solid, 0, 1))
    tables = scene._prepared.lowered.tables
    assert np.diff(tables.cell_first).max() == 6
    assert np.diff(tables.program_leaf).tolist() == [2, 3]  # the wedge and its bore; the box, the wedge and the bore
