"""Decks: surfaces by MCNP's manual, whole decks by an evaluator, by OpenMC, and voids around parts from CAD."""

import numpy as np
import pytest

import conicoid as co

from .models import (
    ABOUT_Z,
    ASYMMETRIC,
    BODIES,
    MODELS,
    SIMPLE,
    TRANSFORMS,
    Sense,
    beyond_any,
    carried,
    chosen,
    cuboid,
    load_deck,
    names_at,
    plane,
    tube,
)

# --- Whole decks: against an evaluator, against OpenMC, and voids around parts from CAD

# --- Whole decks against an evaluator that shares no code, at 10⁴ points each; transformations by an asymmetric body

POINTS = chosen(2, 10_000, 3.0)


@pytest.mark.parametrize("name", MODELS)
def test_every_point_is_in_the_cell_of_mcnp(tmp_path, name: str) -> None:
    model = MODELS[name]
    expected = model.names(POINTS)
    assert len(set(expected)) > 3
    assert names_at(load_deck(tmp_path, model.text), POINTS) == expected


@pytest.mark.parametrize("name", TRANSFORMS)
def test_transformations_of_a_surface_a_cell_and_a_filling(tmp_path, name: str) -> None:
    card, change = TRANSFORMS[name]
    body, sense = ASYMMETRIC[1]
    expected = [None if out else "cell 1" for out in sense(carried(POINTS, change))]
    assert expected.count("cell 1") > 100
    as_surface = f"title\n1 0 -1\n\n{body.replace(' ', ' 1 ', 1)}\n\n{card}\n"
    assert names_at(load_deck(tmp_path, as_surface), POINTS) == expected
    as_cell = f"title\n1 0 -1 trcl=1\n\n{body}\n\n{card}\n"
    assert names_at(load_deck(tmp_path, as_cell), POINTS) == expected
    as_filling = f"title\n1 0 -1 u=1\n2 0 -2 fill=1(1)\n\n{body}\n2 so 9\n\n{card}\n"
    inner = [None if each is None else "cell 1 @ cell 2" for each in expected]
    assert names_at(load_deck(tmp_path, as_filling), POINTS) == inner


def test_a_row_and_a_column_give_a_rotation(tmp_path) -> None:
    """The deck gives five cosines of a turn about (1, 2, 2)/3 by 60 degrees (Rodrigues' formula)."""
    axis = np.array([1, 2, 2]) / 3
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rows = np.eye(3) + np.sin(np.pi / 3) * skew + 0.5 * skew @ skew
    body, sense = ASYMMETRIC[1]
    expected = [None if out else "cell 1" for out in sense(carried(POINTS, ((0, 0, 0), rows)))]
    for row in range(3):
        for column in range(3):
            words = [repr(float(rows[i, j])) if row == i or column == j else "j" for i in range(3) for j in range(3)]
            card = f"tr1 0 0 0 {' '.join(words)}"
            scene = load_deck(tmp_path, f"title\n1 0 -1 trcl=1\n\n{body}\n\n{card}\n")
            assert names_at(scene, POINTS) == expected


HEXAGON = [np.array([np.cos(a), np.sin(a), 0]) for a in np.radians([0, 60, 120])]


@pytest.mark.parametrize(
    ("container", "sense"),
    [
        ("-20 trcl=7", lambda p: cuboid(-1.5, 1.5, -1, 1, -2, 2)(carried(p, ((0, 0, 0), ABOUT_Z)))),
        (
            "-21",
            beyond_any(
                *(plane(sign * v, sign * 1.7 * v) for v in HEXAGON for sign in (1, -1)),
                plane((0, 0, 1), (0, 0, 2)), plane((0, 0, -1), (0, 0, -2)),
            ),
        ),
        (
            "-22",
            beyond_any(
                tube((-1, 0, -1), (1, 2, 1.5), 1.25), plane((1, 2, 1.5), (0, 2, 0.5)), plane((-1, -2, -1.5), (-1, 0, -1))
            ),
        ),
    ],
)  # fmt: skip
def test_slanted_walls_end_a_lattice_without_end(tmp_path, container: str, sense: Sense) -> None:
    """A rod of radius 0.2 in each element, in a box turned by 30 degrees, a hexagonal can and an oblique one."""
    scene = load_deck(
        tmp_path,
        f"""title
1 0 -1 u=1
2 0 1 u=1
3 0 -2 u=2 lat=1 fill=1
4 0 {container} fill=2

1 cz 0.2
2 rpp -0.25 0.25 -0.25 0.25 -9 9
20 rpp -1.5 1.5 -1 1 -2 2
21 rhp 0 0 -2 0 0 4 1.7 0 0
22 rcc -1 0 -1  1 2 1.5  1.25

*tr7 0 0 0 30 60 90 120 30 90 90 90 0
""",
    )
    own = carried(POINTS, ((0, 0, 0), ABOUT_Z)) if "trcl" in container else POINTS
    off = own[:, :2] - np.round(own[:, :2] / 0.5) * 0.5
    rods = np.where((off**2).sum(axis=1) < 0.04, "cell 1", "cell 2")
    expected = [None if out else rod for out, rod in zip(sense(POINTS), rods, strict=True)]
    assert [name and name.split(" @")[0] for name in names_at(scene, POINTS)] == expected


def test_elements_about_another_point_than_their_universes_are_cut(tmp_path) -> None:
    """The elements are 0.87 high and their middles 0.3 below the origins: the box cuts the lowest, though not by half."""
    scene = load_deck(
        tmp_path,
        """title
1 0 -1 u=1
2 0 1 u=1
3 0 -2 3 -4 5 u=2 lat=1 fill=-2:2 -2:2 0:0 1 24r
4 0 -20 fill=2

1 s 0 0.1 0 0.2
2 px 0.6
3 px -0.6
4 py 0.135
5 py -0.735
20 rpp -2 2 -1.5 1.5 -2 2
""",
    )
    own = POINTS[:, :2] - np.stack(
        [np.round(POINTS[:, 0] / 1.2) * 1.2, np.round((POINTS[:, 1] + 0.3) / 0.87) * 0.87], 1
    )
    balls = own[:, 0] ** 2 + (own[:, 1] - 0.1) ** 2 + POINTS[:, 2] ** 2 < 0.04
    out = cuboid(-2, 2, -1.5, 1.5, -2, 2)(POINTS)
    expected = [None if each else "cell 1" if ball else "cell 2" for each, ball in zip(out, balls, strict=True)]
    assert [name and name.split(" @")[0] for name in names_at(scene, POINTS)] == expected


def test_surfaces_of_a_moved_cell_have_numbers(tmp_path) -> None:
    """1000 c + s is surface s as TRCL moves it with cell c."""
    text = "title\n5 0 -1 trcl=(2 0 0)\n6 0 5001 -2\n\n1 so 1\n2 so 4\n"
    scene = load_deck(tmp_path, text)
    assert names_at(scene, [(2, 0, 0), (0, 0, 0)]) == ["cell 5", "cell 6"]


# --- Every kind of surface, macrobody and facet against the formulas of MCNP's manual, at 10⁴ points each

NEAR = chosen(1, 10_000, 3.0)


def check(folder, card: str, region: str, sense: Sense) -> None:
    """Put cell 1 on the positive side of a region and cell 2 on its other side."""
    scene = load_deck(folder, f"title\n1 0 {region}\n2 0 #1\n\n7 {card}\n")
    expected = np.where(sense(NEAR), "cell 1", "cell 2").tolist()
    assert 0 < expected.count("cell 1") < len(NEAR)
    assert names_at(scene, NEAR) == expected


@pytest.mark.parametrize(("card", "sense"), SIMPLE, ids=[card for card, _ in SIMPLE])
def test_surfaces(tmp_path, card: str, sense: Sense) -> None:
    check(tmp_path, card, "7", sense)


@pytest.mark.parametrize(("card", "facets"), BODIES, ids=[card for card, _ in BODIES])
def test_macrobodies_and_facets(tmp_path, card: str, facets: list[Sense]) -> None:
    check(tmp_path, card, "7", beyond_any(*facets))
    for number, sense in enumerate(facets, 1):
        check(tmp_path, card, f"7.{number}", sense)


TORI = """\
A ball, a ring around it and a ball beside it
1 1 -1 -1 imp:n=1
2 2 -2 -7 1 imp:n=1
3 0 1 7 -9 imp:n=1
4 3 -1 -10 trcl=(0 0 0) imp:n=1
5 0 #2 9 10 -11 imp:n=1
6 like 4 but trcl=(0 40 0)
7 0 -8 fill=3 imp:n=1
8 0 4007 -10 u=3 imp:n=1
9 0 11 imp:n=0

1 so 1
7 tz 0 0 0 5 1 1
8 s 40 0 0 2
9 so 10
10 s 20 0 0 2
11 so 100
"""


def test_cells_with_tori_are_left_out_by_name(tmp_path) -> None:
    scene = load_deck(tmp_path, TORI)
    points = [(0.1, 0, 0), (20.1, 0, 0), (20.1, 40, 0), (5, 0, 0), (8, 0, 0), (0, 50, 0), (40, 0, 0)]
    assert names_at(scene, points) == ["cell 1", "cell 4", "cell 6", None, None, None, None]
    message = "surface 7 is a torus (tz), which is no quadric: cells 2, 3, 5, 8 left out"
    assert message in scene.notes
    with pytest.raises(ValueError, match=r"strict is set:\nsurface 7 is a torus"):
        load_deck(tmp_path, TORI, strict=True)


def test_cells_of_a_mesh_are_left_out_by_name(tmp_path) -> None:
    """For cells that take their shape from a mesh, MCNP writes 0 in place of surfaces."""
    scene = load_deck(
        tmp_path, "title\n1 1 -1 0 u=5 imp:n=1\n2 0 -1 fill=5 imp:n=1\n3 1 -1 1 -2 imp:n=1\n\n1 so 1\n2 so 2\n"
    )
    assert names_at(scene, [(0, 0, 0), (1.5, 0, 0)]) == [None, "cell 3"]
    assert "surface 0 stands for a mesh (EMBED): cell 1 left out" in scene.notes


def test_unknown_facets(tmp_path) -> None:
    for card, region in (("rcc 0 0 0 0 0 1 1", "-7.4"), ("so 1", "-7.1"), ("ell 0 0 0 0 0 2 -1", "7.1")):
        with pytest.raises(ValueError, match=r":2:1: cell 1: region: surface 7 has .*facets"):
            load_deck(tmp_path, f"title\n1 0 {region}\n\n7 {card}\n")


# --- Voids around parts from CAD: the outside of flat pieces, or of pieces in a bore, becomes one polyhedron less

BORED = """a bored wedge in a box
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
    (tmp_path / "wedge.mcnp").write_text(BORED)
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


# --- The same assembly as MCNP deck and as OpenMC geometry: the same spans, to the bit

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
