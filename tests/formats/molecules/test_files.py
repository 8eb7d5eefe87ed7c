"""Files of molecules: what their documentation says, and mistakes with their lines."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.io.importers import BodyLimits, detect_format

from ...command_line import run

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


def written(folder, text, name="a.txt"):
    path = folder / name
    path.write_text(text)
    return path


def test_xyz(tmp_path):
    found = co.molecule(written(tmp_path, XYZ))
    assert found.symbols == ["O", "H", "H"]
    assert found.positions[1].tolist() == [0.0, 0.7572, -0.4692]
    assert len(found.bonds) == 2
    assert found.cell is None


def test_extended_xyz_has_a_cell_and_frames(tmp_path):
    frame = XYZ.replace("water, from its angle and bond", 'Lattice="9 0 0 0 8 0 1 0 7" Properties=species:S:1:pos:R:3')
    found = co.molecule(written(tmp_path, frame + frame))
    assert found.cell.tolist() == [[9, 0, 0], [0, 8, 0], [1, 0, 7]]
    assert found.remarks == ("the first of several frames is read",)


def test_pdb(tmp_path):
    found = co.molecule(written(tmp_path, PDB))
    assert found.symbols == ["N", "C", "C", "Ca", "O"]
    assert found.labels == ("N GLY 12 A", "CA GLY 12 A", "C GLY 12 A", "CA CA 101 A", "O HOH 201 A")
    assert found.positions[1].tolist() == [11.639, 6.071, -5.147]
    assert found.remarks == ("1 alternate places of atoms are left out",)
    assert found.bonds.tolist() == [[0, 1, 1], [1, 2, 1], [3, 4, 2]]
    expected = [(10, 0, 0), (0, 20, 0), (30 * math.cos(math.radians(100)), 0, 30 * math.sin(math.radians(100)))]
    assert np.allclose(found.cell, expected, rtol=0, atol=1e-14)


def test_the_first_model_of_a_pdb(tmp_path):
    lines = PDB.splitlines(keepends=True)
    models = [*lines[:2], "MODEL        1\n", lines[2], "ENDMDL\n", "MODEL        2\n", lines[5], "ENDMDL\n"]
    found = co.molecule(written(tmp_path, "".join(models)))
    assert found.symbols == ["N"]
    assert found.remarks == ("the first of several models is read",)


def test_mmcif(tmp_path):
    pytest.importorskip("gemmi")
    found = co.molecule(written(tmp_path, CIF))
    assert found.symbols == ["C", "O"]
    assert found.labels == ("C5' DA 1 A", "O1 DA 1 A")
    assert found.cell.tolist() == [[10, 0, 0], [0, 20, 0], [0, 0, 30]]
    assert len(found.remarks) == 2


def test_a_crystal_has_all_sites_of_its_cell(tmp_path):
    pytest.importorskip("gemmi")
    found = co.molecule(written(tmp_path, SALT))
    assert found.formula == "Cl4Na4"
    assert np.allclose(np.sort(found.positions[:, 0]), [0, 0, 0, 0, 2.82, 2.82, 2.82, 2.82])


@pytest.mark.parametrize(("text", "kind"), [(XYZ, 3), (PDB, 5)])
def test_files_are_scenes_like_others(text, kind, tmp_path):
    path = written(tmp_path, text, "a.yaml")
    found = detect_format(path)
    assert found is not None
    assert found.name.startswith("molecules")
    scene = co.load(path)
    assert scene.notes[0].startswith(f"{kind} atoms: ")
    assert len(scene) > kind
    done = run("import", path, "-o", tmp_path / "out.yaml")
    assert done.exit_code == 0, done.stderr
    assert "#ff0d0d" in done.stdout
    again = co.load(tmp_path / "out.yaml")
    rays = (0.1, 0.2, 50), (0.01, 0, -1)
    assert again.first_hit(*rays).t == scene.first_hit(*rays).t
    assert len(again) == len(scene)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (XYZ.replace("3\n", "4\n", 1), ":6:1: molecule: must be atom 4 of 4, and is the end of the file"),
        (XYZ.replace("0.7572 -0.4692 extra", "0.75x -0.4692"), ":4:1: molecule: x, y and z must be finite numbers, got '0.75x'"),
        (XYZ.replace("H 0.0", "Hx 0.0"), ":4:1: molecule: must begin with an element's symbol or number, got 'Hx'"),
        (XYZ.replace("1 0.0 -0.7572 -0.4692", "H 0.0"), ":5:1: molecule: must be a symbol and three numbers, got 'H 0.0'"),
        (XYZ.replace("water,", 'Lattice="1 2"'), ":2:1: molecule: Lattice must be nine finite numbers, got '1 2'"),
        (PDB.replace("   6.134", "   6.1x4"), ":3:1: molecule: columns 39 to 46 must be a finite number, got '6.1x4'"),
        (PDB.replace("           N\n", "          Qq\n"), ":3:1: molecule: columns 77 and 78 must be an element's symbol, got 'Qq'"),
        (PDB.replace("  90.00 100.00", "  90.00 200.00"), ":2:1: molecule: CRYST1 must hold three lengths and three angles"),
    ],
)  # fmt: skip
def test_mistakes_have_lines(text, message, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(co.SceneFileError) as error:
        co.molecule(path)
    assert str(error.value).startswith(f"{path}{message}")


def test_files_of_other_kinds(tmp_path):
    with pytest.raises(ValueError, match="is no XYZ, PDB, mmCIF or CIF file"):
        co.molecule(written(tmp_path, "conicoid: 1"))
    with pytest.raises(FileNotFoundError):
        co.molecule(tmp_path / "none.xyz")


def test_a_limit_counts_if_it_is_that_of_other_formats(tmp_path, monkeypatch):
    monkeypatch.setattr("conicoid.io.importers.DEFAULT_BODY_LIMITS", BodyLimits(3, 3))
    path = tmp_path / "a.xyz"
    path.write_text("5\n\n" + "".join(f"He {9 * k} 0 0\n" for k in range(5)))
    assert co.load(path).body_count == 5
    with pytest.raises(ValueError, match="5 bodies, more than max_bodies = 3"):
        co.load(path, max_bodies=3)
