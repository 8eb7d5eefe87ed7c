"""Molecules: bonds, styles, published numbers, and files with their mistakes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co
from conicoid.io.importers import BodyLimits, detect_format
from conicoid.io.molecules.atoms import COVALENT_RADII, SYMBOLS, VAN_DER_WAALS_RADII, atomic_number

from ...command_line import execute

# --- Molecules: bonds against all pairs, published numbers, styles by rays and measures

WATER = ([(0, 0, 0.1173), (0, 0.7572, -0.4692), (0, -0.7572, -0.4692)], ["O", "H", "H"])


def test_tables_hold_the_published_numbers():
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
    """The rods of ethene's double bond lie in the plane of the hydrogens."""
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
    ("call", "kind", "message"),
    [
        (lambda: co.molecule([(0, 0, 0)]), TypeError, "positions need elements: co.molecule"),
        (
            lambda: co.molecule([(0, 0)], ["C"]),
            ValueError,
            r"atoms must have positions of shape \(N, 3\), got \(1, 2\)",
        ),
        (
            lambda: co.molecule([(0, 0, 0)], ["C", "C"]),
            ValueError,
            r"elements must have shape \(1,\), as there are positions, got \(2,\)",
        ),
        (
            lambda: co.molecule([(0, 0, 0)], ["Qq"]),
            ValueError,
            r"elements\[0\] must be an element's symbol or number, got 'Qq'",
        ),
        (
            lambda: co.molecule([(0, 0, 0)], [200]),
            ValueError,
            r"elements\[0\] must be an atomic number from 0 to 118, got 200",
        ),
        (lambda: co.molecule([(0, 0, math.nan)], ["C"]), ValueError, r"atoms\[0\] must be finite"),
        (
            lambda: co.molecule(3),
            TypeError,
            "atoms must be a file's path, positions with elements, or an object of ASE",
        ),
        (
            lambda: co.molecule(*WATER, bonds=[(0, 3)]),
            ValueError,
            r"bonds\[0\] must be two different atoms from 0 to 2, got \[0.0, 3.0, 1.0\]",
        ),
        (lambda: co.molecule(*WATER, bonds=[(1, 1)]), ValueError, r"bonds\[0\] must be two different atoms"),
        (lambda: co.molecule(*WATER, bonds=[(0, 1, 9)]), ValueError, r"bonds\[0\] must be of an order > 0 and <= 4"),
        (lambda: co.molecule(*WATER, bonds=[1, 2]), ValueError, r"bonds must have shape \(M, 2\), or \(M, 3\)"),
        (lambda: co.molecule(*WATER, cell=[1, 2, 3]), ValueError, r"cell must be three finite vectors, \(3, 3\)"),
        (
            lambda: co.molecule(*WATER).scene("balls"),
            ValueError,
            "style must be one of space filling, ball and stick, licorice, got 'balls'",
        ),
        (
            lambda: co.molecule(*WATER).scene(radii=dict(oxygen=1)),
            ValueError,
            "radii must be by symbols such as 'C', got 'oxygen'",
        ),
        (lambda: co.molecule(*WATER).scene(radii=dict(O=-1)), ValueError, r"radii\['O'\] must be > 0"),
    ],
)
def test_files_that_are_no_molecules_are_refused(call, kind, message):
    with pytest.raises(kind, match=message):
        call()


def _pdb(*atoms, tail=""):
    """Return lines of PDB from (name in four columns, letter of an alternate place, residue, number, occupancy)."""
    return "".join(
        f"ATOM  {i:5d} {name}{letter}{residue:>3} A{number:4d}    {3.0 * i:8.3f}{0:8.3f}{0:8.3f}{share:6.2f}{0:6.2f}"
        f"{tail}\n"
        for i, (name, letter, residue, number, share) in enumerate(atoms, 1)
    )


def test_elements_by_names_of_atoms(tmp_path):
    """The component dictionary of the wwPDB has these names. Columns 77 and 78 are blank."""
    names = {
        ("HG21", "VAL"): "H", ("HO5'", "DA"): "H", ("NE2 ", "GLN"): "N", (" CA ", "ALA"): "C", ("CA  ", "CA"): "Ca",
        ("HG  ", "CYS"): "H", ("HG  ", "HG"): "Hg", ("CD1 ", "LEU"): "C", ("NB  ", "HEM"): "N", ("FE  ", "HEM"): "Fe",
        ("CE  ", "MET"): "C", ("SE  ", "MSE"): "Se", ("1HB ", "ALA"): "H", ("HF11", "LIG"): "H", ("CL  ", "CL"): "Cl",
        ("OP1 ", "G"): "O", ("SG  ", "CYS"): "S", ("NA  ", "NA"): "Na", (" D  ", "ALA"): "D",
        ("HE1 ", "HSD"): "H", ("NE2 ", "HSE"): "N", ("CD2 ", "HSP"): "C", ("CE  ", "LYN"): "C", ("HO2 ", "GOL"): "H",
        ("HO  ", "HO"): "Ho", ("NE  ", "LIG"): "N", ("CO  ", "B12"): "Co", ("PB  ", "ATP"): "P", ("PA  ", "NAD"): "P",
        ("PB  ", "PB"): "Pb", ("CM1 ", "LIG"): "C", ("NO1 ", "LIG"): "N", ("PA1 ", "LIG"): "P",
    }  # fmt: skip
    path = tmp_path / "a.pdb"
    path.write_text(_pdb(*((name, " ", residue, k, 1) for k, (name, residue) in enumerate(names, 1))))
    assert co.molecule(path).symbols == [{"D": "H"}.get(symbol, symbol) for symbol in names.values()]
    # From before 1996: the name of the entry, and a count of lines
    path.write_text(_pdb(("HG21", " ", "VAL", 1, 1), ("CA  ", " ", "CA", 2, 1), tail="      1ABC1234"))
    assert co.molecule(path).symbols == ["H", "Ca"]


@pytest.mark.parametrize(
    ("stated", "count"),
    [
        ("_symmetry_Int_Tables_number 225", 8),  # Fm-3m by its number alone
        ("_symmetry_space_group_name_H-M 'F m -3 m strange'", 2),
        ("_symmetry_equiv_pos_as_xyz 'x,y'", 2),
        ("_space_group_name_H-M_alt ?\n_space_group_name_H-M_ref 'F m -3 m'", 8),
        ("_space_group_name_Schoenflies O_h^5", 2),
    ],
)
def test_an_unknown_symmetry_of_a_crystal_is_reported(stated, count, tmp_path):
    pytest.importorskip("gemmi")
    text = SALT.replace("_symmetry_space_group_name_H-M 'F m -3 m'", stated)
    found = co.molecule(text_file(tmp_path, text, "a.cif"))
    note = "the symmetry that the file states is unknown: only the sites that it lists are shown"
    assert (len(found), found.remarks) == (count, () if count == 8 else (note,))


@pytest.mark.parametrize(("old", "new"), [("_fract_", "_Cartn_"), ("_cell_length_", "_cell_formula_")])
def test_a_crystal_without_its_numbers(old, new, tmp_path):
    """Places in Å of a crystal's CIF came out as 0, and fractions without a cell as Å."""
    pytest.importorskip("gemmi")
    with pytest.raises(co.SceneFileError, match="sites must have places as fractions of a cell: _.*must be there"):
        co.molecule(text_file(tmp_path, SALT.replace(old, new), "a.cif"))


def test_no_atoms():
    none = co.molecule(np.zeros((0, 3)), [])
    assert len(none) == 0
    assert len(none.scene()) == 0
    with pytest.raises(ValueError, match="has no atoms"):
        none.solvent_accessible()


# ---- Objects of other libraries, by their attributes: tests try the real ones where they are installed ----


def test_objects_of_other_libraries_are_read_by_their_attributes():
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


# --- Files of molecules: the rules of their documentation, and mistakes with their lines

XYZ = """3
water, from its angle and bond
O 0.0 0.0 0.1173
H 0.0 0.7572 -0.4692 extra columns 3
1 0.0 -0.7572 -0.4692
"""
# The columns are those of the format's documentation (wwPDB 3.3): an amino acid with an alternate place, and a water
PDB = """HEADER    TEST
CRYST1   10.000   20.000   30.000  90.00 100.00  90.00 P 1
ATOM      1  N   GLY A  12      11.104   6.134  -6.504  1.00  0.00           N
ATOM      2  CA AGLY A  12      11.639   6.071  -5.147  0.60  0.00           C
ATOM      3  CA BGLY A  12      11.700   6.100  -5.100  0.40  0.00           C
ATOM      4  C   GLY A  12      13.150   6.100  -5.100  1.00  0.00           C
HETATM    5 CA    CA A 101      20.000   6.000  -5.000  1.00  0.00
HETATM    6  O   HOH A 201       1.000   2.000   3.000  1.00  0.00           O
CONECT    5    6
CONECT    5    6
END
"""
CIF = """data_test
_cell.length_a 10
_cell.length_b 20(3)
_cell.length_c 30
_cell.angle_alpha 90
_cell.angle_beta 90
_cell.angle_gamma 90
loop_
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.auth_asym_id
_atom_site.auth_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.pdbx_PDB_model_num
C "C5'" . DA A 1 1.0 2.0 3.0 1
O O1 A DA A 1 2.0 2.0 3.0 1
O O1 B DA A 1 2.1 2.0 3.0 1
C "C5'" . DA A 1 9.0 2.0 3.0 2
"""
SALT = """data_NaCl
_cell_length_a 5.64
_cell_length_b 5.64
_cell_length_c 5.64
_cell_angle_alpha 90
_cell_angle_beta 90
_cell_angle_gamma 90
_symmetry_space_group_name_H-M 'F m -3 m'
loop_
_atom_site_label
_atom_site_type_symbol
_atom_site_fract_x
_atom_site_fract_y
_atom_site_fract_z
Na1 Na 0 0 0
Cl1 Cl 0.5 0.5 0.5
"""


def text_file(folder, text, name="a.txt"):
    path = folder / name
    path.write_text(text)
    return path


def _rows(category, *names):
    """Return the head of a loop of CIF."""
    return "loop_\n" + "".join(f"{category}.{name}\n" for name in names)


SITES = ("type_symbol", "Cartn_x", "Cartn_y", "Cartn_z")
CODED = "type_symbol label_atom_id label_alt_id label_comp_id label_asym_id auth_seq_id pdbx_PDB_ins_code Cartn_x Cartn_y Cartn_z".split()
COMPONENT = "atom_id type_symbol model_Cartn_x model_Cartn_y model_Cartn_z pdbx_model_Cartn_x_ideal pdbx_model_Cartn_y_ideal pdbx_model_Cartn_z_ideal".split()
ZINC = {"atom_id": "ZN", "type_symbol": "ZN", "{}Cartn_x": 1, "{}Cartn_y": 2, "{}Cartn_z": 3}
LINES = PDB.splitlines(keepends=True)
OBLIQUE = [(10, 0, 0), (0, 20, 0), (30 * math.cos(math.radians(100)), 0, 30 * math.sin(math.radians(100)))]
LATTICE = XYZ.replace("water, from its angle and bond", 'Lattice="9 0 0 0 8 0 1 0 7" Properties=species:S:1:pos:R:3')
DISORDERED = SALT.replace("F m -3 m", "P 1").rstrip("\n").rpartition("_atom_site_fract_z")[0] + (
    "_atom_site_fract_z\n_atom_site_disorder_group\n_atom_site_occupancy\n"
    "C1 C 0 0 0 . 1\nO1 O .12 0 0 2 .6\nO1 O .09 .06 0 1 .4\nN1 N .5 .5 .5 -1 .5\nQ1 Q .1 .2 .3 . 1\n"
)
FIRST = dict(symbols=["N"], remarks=("the first of several models is read",))
HOLDS = {
    "XYZ": (XYZ, dict(symbols=["O", "H", "H"], positions=WATER[0], bonds=[(0, 1, 1), (0, 2, 1)], cell=None)),
    "XYZ with a cell and frames": (LATTICE + LATTICE, dict(
        cell=[[9, 0, 0], [0, 8, 0], [1, 0, 7]], remarks=("the first of several frames is read",))),
    "PDB": (PDB, dict(
        symbols=["N", "C", "C", "Ca", "O"], labels=("N GLY 12 A", "CA GLY 12 A", "C GLY 12 A", "CA CA 101 A", "O HOH 201 A"),
        positions=[(11.104, 6.134, -6.504), (11.639, 6.071, -5.147), (13.15, 6.1, -5.1), (20, 6, -5), (1, 2, 3)],
        bonds=[[0, 1, 1], [1, 2, 1], [3, 4, 2]], cell=OBLIQUE, remarks=("1 alternate places of atoms are left out",))),
    # From the second atom alone, to one that is too far for a bond by distance
    "PDB of a far bond": (PDB.replace("CONECT    5    6", "CONECT    6    4"), dict(bonds=[[0, 1, 1], [1, 2, 1], [2, 4, 2]])),
    "PDB of models": ([*LINES[:2], "MODEL        1\n", LINES[2], "ENDMDL\n", "MODEL        2\n", LINES[5], "ENDMDL\n"], FIRST),
    "PDB of models without an end": ([*LINES[:2], "MODEL        1\n", LINES[2], "MODEL        2\n", LINES[5]], FIRST),
    "PDB of frames": ([LINES[2], "END\n", LINES[5], "END\n"], FIRST),  # as programs for moving molecules write them
    # Of two residues at one place the first is read; a warning names an atom that only half of the copies have
    "PDB of places that exclude one another": (
        "CRYST1    0.000    0.000    0.000  90.00  90.00  90.00 P 1           1\n"
        + _pdb((" CB ", "A", "SER", 1, 0.6), (" CB ", "B", "THR", 1, 0.4), (" OG ", "A", "SER", 1, 0.6),
               (" OG1", "B", "THR", 1, 0.4), (" N  ", " ", "ALA", 2, 0.5), (" CA ", " ", "ALA", 2, 1)),
        dict(symbols=["C", "O", "N", "C"], cell=None, remarks=(
            "2 alternate places of atoms are left out", "1 atom of an occupancy below 1 shown as a whole"))),
    "CIF": (CIF, dict(symbols=["C", "O"], labels=("C5' DA 1 A", "O1 DA 1 A"), cell=np.diag([10, 20, 30]), remarks=(
        "the first of several models is read", "1 alternate places of atoms are left out"))),
    # Residues 100 and 100A are two: the first place of the second is no alternate place of the first
    "CIF of insertion codes": (
        "data_x\n" + _rows("_atom_site", *CODED)
        + "".join(f"O OG {letter} SER A 100 {code} {x} 0 0\n" for letter, code, x in ("A?0", "B?1", "AA5", "BA6")),
        dict(positions=[(0, 0, 0), (5, 0, 0)], labels=("OG SER 100 A", "OG SER 100A A"),
             remarks=("2 alternate places of atoms are left out",))),
    # A disorder group of 1 or 2 excludes the other, and one below 0 its own images
    "CIF of sites that exclude one another": (DISORDERED, dict(
        symbols=["C", "O", "N"], positions=[(0, 0, 0), (0.12 * 5.64, 0, 0), (2.82, 2.82, 2.82)], remarks=(
            "1 site without an element left out", "1 site of other disorder groups than 2 left out",
            "2 atoms of an occupancy below 1 shown as a whole"))),
    "CIF of a component": ("data_ALA\n" + _rows("_chem_comp_atom", *COMPONENT) + "N N 1 2 3 4 5 6\nCA C 2 2 3 5 5 6\n",
                           dict(positions=[[1, 2, 3], [2, 2, 3]])),
    "CIF of ideal places": ("data_ALA\n" + _rows("_chem_comp_atom", *COMPONENT) + "N N ? ? ? 4 5 6\nCA C ? ? ? 5 5 6\n",
                            dict(positions=[[4, 5, 6], [5, 5, 6]])),
    # Structures list the atoms of their residues too; dictionaries of restraints begin with a list of components
    "CIF of residues": ("data_ALA\n" + _rows("_chem_comp_atom", *COMPONENT[:2]) + "N N\n" + _rows("_atom_site", *SITES) + "C 7 8 9\n",
                        dict(positions=[[7, 8, 9]])),
    "CIF of restraints": (
        "data_comp_list\n_chem_comp.id ALA\ndata_ALA\n" + _rows("_chem_comp_atom", *COMPONENT[:2], "x", "y", "z") + "N N 1 1 2\n",
        dict(positions=[[1, 1, 2]], remarks=("1 other data block not read",))),
    # A category of one row has no loop: https://www.iucr.org/resources/cif/spec/version1.1/cifsyntax, paragraph 4
    **{f"CIF of one row of {category}": (
        "data_ZN\n" + "".join(f"{category}.{name.format(prefix)} {value}\n" for name, value in ZINC.items()),
        dict(symbols=["Zn"], positions=[[1, 2, 3]])) for category, prefix in (("_chem_comp_atom", "model_"), ("_atom_site", ""))},
}  # fmt: skip
"""By name, the text of a file, and what the molecule has of it."""


@pytest.mark.parametrize("name", HOLDS)
def test_files_hold_their_atoms(name, tmp_path):
    text, expected = HOLDS[name]
    if name.startswith("CIF"):
        pytest.importorskip("gemmi")
    found = co.molecule(text_file(tmp_path, "".join(text), "a.txt" if text is CIF else f"a.{name[:3].lower()}"))
    for field, value in expected.items():
        if field in ("positions", "bonds", "cell") and value is not None:
            np.testing.assert_allclose(getattr(found, field), value, rtol=0, atol=1e-14)
        else:
            assert getattr(found, field) == value


def test_a_file_without_atoms(tmp_path):
    pytest.importorskip("gemmi")
    assert "the file holds no atoms" in co.load(text_file(tmp_path, "data_none\n_cell.length_a 5\n", "a.cif")).notes


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        ("species:S:1:forces:R:3:pos:R:3", "{0} 9 9 9 {1} {2} {3}"),
        ("id:I:1:pos:R:3:Species:S:1:energy:R:1", "7 {1} {2} {3} {0} 4"),
        ('"id:I:1:Z:I:1:pos:R:3"', "7 8 {1} {2} {3}"),
    ],
)
def test_extended_xyz_describes_its_columns(columns, line, tmp_path):
    """libAtoms, https://github.com/libAtoms/extxyz, describes the format: name, type and number of columns."""
    text = f"2\nProperties={columns}\n{line.format('O', 1, 2, 3)}\n{line.format('O', 4, 5, 6)}\n"
    found = co.molecule(text_file(tmp_path, text, "a.xyz"))
    assert (found.symbols, found.positions.tolist()) == (["O", "O"], [[1, 2, 3], [4, 5, 6]])
    with pytest.raises(co.SceneFileError, match=r"a.xyz:2:1: .*Properties must have species \(or Z\) and pos, got"):
        co.molecule(text_file(tmp_path, text.lower().replace("pos:", "place:"), "a.xyz"))
    with pytest.raises(co.SceneFileError, match="must be a symbol and three numbers, got 'O 1'"):
        co.molecule(text_file(tmp_path, f"1\nProperties={columns}\nO 1\n", "a.xyz"))


@pytest.mark.parametrize("text", ["XYZ", "PDB"])
def test_a_byte_order_mark_takes_no_atom(text, tmp_path):
    text = {"XYZ": XYZ, "PDB": "".join(line for line in PDB.splitlines(True) if line.startswith(("ATOM", "HET")))}[text]
    plain, marked = text_file(tmp_path, text), tmp_path / "b.txt"
    marked.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert co.molecule(marked).symbols == co.molecule(plain).symbols


@pytest.mark.parametrize("dot", ["_", "."])
def test_a_crystal_has_all_sites_of_its_cell(dot, tmp_path):
    """Version 3 of the core dictionary names its items with a dot."""
    pytest.importorskip("gemmi")
    text = SALT.replace("_atom_site_", f"_atom_site{dot}").replace("_cell_", f"_cell{dot}")
    name = f"_space_group{dot}name_H-M_alt"
    found = co.molecule(text_file(tmp_path, text.replace("_symmetry_space_group_name_H-M", name)))
    assert found.formula == "Cl4Na4"
    assert np.allclose(np.sort(found.positions[:, 0]), [0, 0, 0, 0, 2.82, 2.82, 2.82, 2.82])


@pytest.mark.parametrize("serial", ["    1", "A0000", "a0000", "*****"])
def test_files_of_many_atoms_are_known(serial, tmp_path):
    """Hybrid-36 numbers an atom after 99,999 with letters, and other programs write stars."""
    found = detect_format(text_file(tmp_path, f"ATOM  {serial}  CA  ALA A   1       1.000   2.000   3.000\n", "a"))
    assert found.name.startswith("molecules")


@pytest.mark.parametrize(("text", "kind"), [(XYZ, 3), (PDB, 5)])
def test_files_are_scenes_like_others(text, kind, tmp_path):
    path = text_file(tmp_path, text, "a.yaml")
    found = detect_format(path)
    assert found.name.startswith("molecules")
    scene = co.load(path)
    assert scene.notes[0].startswith(f"{kind} atoms: ")
    assert len(scene) > kind
    result = execute("import", path, "-o", tmp_path / "out.yaml")
    assert "#ff0d0d" in result.stdout
    again = co.load(tmp_path / "out.yaml")
    rays = (0.1, 0.2, 50), (0.01, 0, -1)
    assert again.first_hit(*rays).t == scene.first_hit(*rays).t
    assert len(again) == len(scene)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (XYZ.replace("3\n", "4\n", 1), ":6:1: molecule: must be atom 4 of 4, and is the end of the file"),
        (XYZ.replace("0.7572 -0.4692 extra", "0.75x -0.4692"), ":4:1: molecule: x, y and z must be finite numbers, got '0.75x'"),
        (XYZ.replace("0.7572 -0.4692 extra", "0_7572 -0.4692"), ":4:1: molecule: x, y and z must be finite numbers, got '0_7572'"),
        (XYZ.replace("H 0.0", "Hx 0.0"), ":4:1: molecule: must begin with an element's symbol or number, got 'Hx'"),
        (XYZ.replace("1 0.0 -0.7572 -0.4692", "H 0.0"), ":5:1: molecule: must be a symbol and three numbers, got 'H 0.0'"),
        (XYZ.replace("water,", 'Lattice="1 2"'), ":2:1: molecule: Lattice must be nine finite numbers, got '1 2'"),
        (PDB.replace("   6.134", "   6_134"), ":3:1: molecule: columns 39 to 46 must be a finite number, got '6_134'"),
        (PDB.replace("   6.134", "   6.1x4"), ":3:1: molecule: columns 39 to 46 must be a finite number, got '6.1x4'"),
        (PDB.replace("           N\n", "          Qq\n"), ":3:1: molecule: columns 77 and 78 must be an element's symbol, got 'Qq'"),
        (PDB.replace("  90.00 100.00", "  90.00 200.00"), ":2:1: molecule: CRYST1 must hold three lengths and three angles"),
    ],
)  # fmt: skip
def test_mistakes_have_lines(text, message, tmp_path):
    path = text_file(tmp_path, text)
    with pytest.raises(co.SceneFileError) as error:
        co.molecule(path)
    assert str(error.value).startswith(f"{path}{message}")


def test_files_of_other_kinds(tmp_path):
    with pytest.raises(ValueError, match="is no XYZ, PDB, mmCIF or CIF file"):
        co.molecule(text_file(tmp_path, "conicoid: 1"))
    with pytest.raises(FileNotFoundError):
        co.molecule(tmp_path / "none.xyz")


def test_a_limit_counts_if_it_is_that_of_other_formats(tmp_path, monkeypatch):
    monkeypatch.setattr("conicoid.io.importers.DEFAULT_BODY_LIMITS", BodyLimits(3, 3))
    path = tmp_path / "a.xyz"
    path.write_text("5\n\n" + "".join(f"He {9 * k} 0 0\n" for k in range(5)))
    assert co.load(path).body_count == 5
    with pytest.raises(ValueError, match="5 bodies, more than max_bodies = 3"):
        co.load(path, max_bodies=3)
