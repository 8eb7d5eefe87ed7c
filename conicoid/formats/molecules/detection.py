"""What files of molecules are known by, before anything that reads them is loaded."""

from __future__ import annotations

import re

_DATA = re.compile(r"\A(\s*(#[^\n]*)?\n)*\s*data_\S*", re.I)
_RECORDS = re.compile(r"^(ATOM  |HETATM)[ \d]{5}.{19}[ \d.+-]{24}", re.M)
_FIRST = re.compile(r"\A\s*\d+[ \t]*\r?\n[^\n]*(\n\s*([A-Za-z]{1,3}|\d{1,3})(\s+[-+.\d][^\s]*){3})")


def is_cif(head: str, suffix: str) -> bool:
    """Is a text a CIF or mmCIF, by its first block?"""
    return _DATA.match(head.removeprefix("\ufeff")) is not None


def is_pdb(head: str, suffix: str) -> bool:
    """Is a text a PDB: has it a line of an atom, or the first lines of a long header?"""
    return _RECORDS.search(head) is not None or (
        head.startswith("HEADER    ") and re.search(r"^(TITLE|COMPND|REMARK)", head, re.M) is not None
    )


def is_xyz(head: str, suffix: str) -> bool:
    """Is a text an XYZ, by its first three lines?"""
    return suffix == ".xyz" or _FIRST.match(head) is not None


def is_molecule(head: str, suffix: str) -> bool:
    """Is a text one of these, by its beginning?"""
    return any(recognises(head, suffix) for recognises in (is_cif, is_pdb, is_xyz))
