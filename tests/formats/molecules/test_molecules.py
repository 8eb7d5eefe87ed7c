"""Molecules: bonds against all pairs, published numbers, styles by what rays and measures find."""

from __future__ import annotations

import math
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co
from conicoid.io.molecules.atoms import COVALENT_RADII, SYMBOLS, VAN_DER_WAALS_RADII, atomic_number

WATER = ([(0, 0, 0.1173), (0, 0.7572, -0.4692), (0, -0.7572, -0.4692)], ["O", "H", "H"])


def test_tables_hold_what_was_published():
    """Some of Cordero 2008, table 2, and of Alvarez 2013, table 1."""
    for symbol, bond, contact in (("H", 0.31, 1.20), ("C", 0.76, 1.77), ("S", 1.05, 1.89), ("U", 1.96, 2.71)):
        assert (COVALENT_RADII[SYMBOLS.index(symbol)], VAN_DER_WAALS_RADII[SYMBOLS.index(symbol)]) == (bond, contact)
    assert len(SYMBOLS) == 119
    assert SYMBOLS[118] == "Og"
    assert [atomic_number(text) for text in ("FE2+", "13C", "d", " Na ", "Qq")] == [26, 6, 1, 11, None]


@pytest.mark.parametrize("count", [0, 1, 2, 700])
def test_bonds_are_those_of_all_pairs(count):
    rng = np.random.default_rng(count)
    places = rng.uniform(0, 12, (count, 3)) * (1, 1, 3)
    numbers = rng.choice([1, 6, 7, 8, 16, 55], count)
    far = np.linalg.norm(places[:, None] - places, axis=2)
    near = (far <= COVALENT_RADII[numbers][:, None] + COVALENT_RADII[numbers] + 0.45) & (far >= 0.4)
    expected = np.argwhere(np.triu(near, 1))
    assert np.array_equal(co.molecule(places, numbers).bonds[:, :2], expected)


def test_atoms_that_are_far_apart_have_a_grid_all_the_same():
    places = [(0, 0, 0), (1, 0, 0), (1e9, 1e9, -1e9), (1e9 + 1, 1e9, -1e9)]
    assert co.molecule(places, "C").bonds[:, :2].tolist() == [[0, 1], [2, 3]]


def test_body_k_is_atom_k():
    water = co.molecule(*WATER)
    scene = water.scene("space filling")
    assert water.formula == "H2O"
    assert repr(water) == "Molecule(H2O, 3 atoms)"
    hits = scene.first_hit([(0, 0, 9), (0, 9, -0.4692), (0, -9, -0.4692)], [(0, 0, -1), (0, -1, 0), (0, 1, 0)])
    assert hits.body.tolist() == [0, 1, 2]
    assert [material.name for material in hits.material] == ["O", "H", "H"]
    assert hits.material[0].properties["number"] == 8
    assert hits.t.tolist() == pytest.approx([9 - 0.1173 - 1.5, 9 - 0.7572 - 1.2, 9 - 0.7572 - 1.2], rel=4e-16)


def test_sticks_meet_in_the_middle_of_a_bond_in_the_colours_of_their_atoms():
    scene = co.molecule([(0, 0, 0), (1.2, 0, 0)], ["C", "O"]).scene("licorice")
    hits = scene.first_hit([(0.5, 9, 0), (0.7, 9, 0)], (0, -1, 0))
    assert [material.name for material in hits.material] == ["C", "O"]
    assert hits.t.tolist() == pytest.approx([8.8, 8.8], rel=4e-16)
    assert scene.contains((0.6, 0, 0.19))


@pytest.mark.parametrize(("order", "rods", "middle"), [(1, 1, True), (2, 2, False), (1.5, 2, False), (3, 3, True)])
def test_bonds_of_higher_order_are_several_rods(order, rods, middle):
    """Ethene's plane: the rods of a double bond lie in the plane of the hydrogens."""
    places = [(-0.67, 0, 0), (0.67, 0, 0), (-1.24, 0.93, 0), (1.24, 0.93, 0)]
    ethene = co.molecule(places, ["C", "C", "H", "H"], bonds=[(0, 1, order), (0, 2, 1), (1, 3, 1)])
    scene = ethene.scene("ball and stick")
    assert len(scene) == 4 + 2 * (rods + 2)
    spans = scene.spans((0.1, -3, 0), (0, 1, 0))  # across the bond, in the plane
    assert len(spans.t_enter) == rods
    assert scene.contains((0.1, 0, 0)) == middle
    assert len(scene.spans((0.1, 0, -3), (0, 0, 1)).t_enter) == middle


def test_a_solvent_sees_the_union_of_two_balls():
    """Two balls of radius R at a distance d: 2 · 2πR (R + d/2) of area, 2 π/3 (R + d/2)² (2R - d/2) of volume."""
    d, reach = 3.0, 1.77 + 1.4
    solid = co.molecule([(0, 0, 0), (d, 0, 0)], "C").solvent_accessible()
    found = co.measure(solid)
    height = reach + d / 2
    assert found.volume_error < 5e-3 * found.volume
    assert abs(found.volume - 2 * math.pi / 3 * height**2 * (3 * reach - height)) <= 5 * found.volume_error + 1e-12


def test_a_cell_is_shown_by_its_twelve_edges():
    salt = co.molecule([(0, 0, 0), (2.82, 0, 0)], ["Na", "Cl"], bonds=[], cell=np.eye(3) * 5.64)
    assert len(salt.scene()) == 2 + 12
    assert len(salt.scene(cell=False)) == 2
    corners = np.argwhere(np.ones((2, 2, 2))) * 5.64
    scene = co.Scene(salt.bodies()[-1:])
    assert scene.contains(corners).all()
    assert scene.contains([(2.8, 0, 0), (5.64, 3, 5.64)]).all()
    assert not scene.contains((2.8, 2.8, 0))


def test_colours_and_radii_of_ones_own():
    steel = co.metal("gray", name="steel")
    scene = co.molecule(*WATER).scene("space filling", radii=dict(O=2), colors=dict(O="red", H=steel))
    assert scene.first_hit((0, 0, 9), (0, 0, -1)).t == pytest.approx(9 - 0.1173 - 2, rel=4e-16)
    assert scene.body(0).material.name == "O"
    assert scene.body(1).material == steel


@pytest.mark.parametrize(
    ("arguments", "kind", "message"),
    [
        (([(0, 0, 0)],), TypeError, "positions need elements: co.molecule"),
        (([(0, 0)], ["C"]), ValueError, r"atoms must have positions of shape \(N, 3\), got \(1, 2\)"),
        (([(0, 0, 0)], ["C", "C"]), ValueError, r"elements must have shape \(1,\), as there are positions, got \(2,\)"),
        (([(0, 0, 0)], ["Qq"]), ValueError, r"elements\[0\] must be an element's symbol or number, got 'Qq'"),
        (([(0, 0, 0)], [200]), ValueError, r"elements\[0\] must be an atomic number from 0 to 118, got 200"),
        (([(0, 0, math.nan)], ["C"]), ValueError, r"atoms\[0\] must be finite"),
        ((3,), TypeError, "atoms must be a file's path, positions with elements, or an object of ASE"),
    ],
)
def test_what_is_no_molecule(arguments, kind, message):
    with pytest.raises(kind, match=message):
        co.molecule(*arguments)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(bonds=[(0, 3)]), r"bonds\[0\] must be two different atoms from 0 to 2, got \[0.0, 3.0, 1.0\]"),
        (dict(bonds=[(1, 1)]), r"bonds\[0\] must be two different atoms"),
        (dict(bonds=[(0, 1, 9)]), r"bonds\[0\] must be of an order > 0 and <= 4"),
        (dict(bonds=[1, 2]), r"bonds must have shape \(M, 2\), or \(M, 3\)"),
        (dict(cell=[1, 2, 3]), r"cell must be three finite vectors, \(3, 3\)"),
    ],
)
def test_bonds_and_cells_that_cannot_be(options, message):
    with pytest.raises(ValueError, match=message):
        co.molecule(*WATER, **options)


def test_styles_that_there_are_not():
    water = co.molecule(*WATER)
    with pytest.raises(ValueError, match="style must be one of space filling, ball and stick, licorice, got 'balls'"):
        water.scene("balls")
    with pytest.raises(ValueError, match="radii must be by symbols such as 'C', got 'oxygen'"):
        water.scene(radii=dict(oxygen=1))
    with pytest.raises(ValueError, match=r"radii\['O'\] must be > 0"):
        water.scene(radii=dict(O=-1))


def test_a_molecule_travels():
    water = pickle.loads(pickle.dumps(co.molecule(*WATER)))
    assert water.symbols == ["O", "H", "H"]
    assert len(water.bonds) == 2
    assert co.molecule(water).formula == "H2O"


def test_no_atoms():
    none = co.molecule(np.zeros((0, 3)), [])
    assert len(none) == 0
    assert len(none.scene()) == 0
    with pytest.raises(ValueError, match="has no atoms"):
        none.solvent_accessible()


# ---- Other libraries' objects, by what these have: the real ones are tried where they are installed ----


def test_objects_of_other_libraries_by_what_they_have():
    places, numbers = np.array(WATER[0]), np.array([8, 1, 1])
    ase = SimpleNamespace(
        get_positions=lambda: places, get_atomic_numbers=lambda: numbers, cell=np.eye(3) * 9, pbc=[True] * 3
    )
    assert co.molecule(ase).cell.tolist() == (np.eye(3) * 9).tolist()
    bonds = SimpleNamespace(as_array=lambda: np.array([[0, 1, 1], [0, 2, 2]]))
    biotite = SimpleNamespace(coord=places, element=np.array(WATER[1]), bonds=bonds, box=None)
    assert co.molecule(biotite).bonds.tolist() == [[0, 1, 1], [0, 2, 2]]
    group = SimpleNamespace(positions=places, elements=np.array(WATER[1]), dimensions=[9, 9, 9, 90, 90, 90])
    assert co.molecule(SimpleNamespace(atoms=group)).cell[2].tolist() == [0, 0, 9]
    plain = SimpleNamespace(positions=places, symbols=WATER[1])
    assert co.molecule(plain).formula == "H2O"
    atoms = [SimpleNamespace(GetAtomicNum=lambda n=n: n) for n in (8, 1, 1)]
    bond = SimpleNamespace(GetBeginAtomIdx=lambda: 0, GetEndAtomIdx=lambda: 1, GetBondTypeAsDouble=lambda: 2.0)
    rdkit = SimpleNamespace(
        GetAtoms=lambda: atoms,
        GetBonds=lambda: [bond],
        GetConformer=lambda: SimpleNamespace(GetPositions=lambda: places),
    )
    assert co.molecule(rdkit).bonds.tolist() == [[0, 1, 2]]


def test_an_object_of_ase():
    ase = pytest.importorskip("ase.build")
    assert co.molecule(ase.molecule("C2H6")).formula == "C2H6"
    salt = co.molecule(ase.bulk("NaCl", "rocksalt", a=5.64, cubic=True))
    assert salt.formula == "Cl4Na4"
    assert np.allclose(salt.cell, np.eye(3) * 5.64)


def test_a_structure_of_gemmi():
    gemmi = pytest.importorskip("gemmi")
    model, chain, residue, structure = gemmi.Model(1), gemmi.Chain("A"), gemmi.Residue(), gemmi.Structure()
    residue.name, residue.seqid = "HOH", gemmi.SeqId(1, " ")
    for place, symbol in zip(*WATER, strict=True):
        atom = gemmi.Atom()
        atom.name, atom.element, atom.pos = symbol, gemmi.Element(symbol), gemmi.Position(*place)
        residue.add_atom(atom)
    chain.add_residue(residue), model.add_chain(chain), structure.add_model(model)
    found = co.molecule(structure)
    assert found.formula == "H2O"
    assert found.labels[0] == "O HOH 1 A"
