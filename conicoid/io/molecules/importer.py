"""Import of molecules: readers of CIF, mmCIF, PDB and XYZ files, and bodies in a default style.

CIF and mmCIF files need gemmi, an extra: `pip install "conicoid[molecules]"`. Of an mmCIF the first model and the first
of alternate positions are read, as gemmi has them; of a CIF all sites of a unit cell, by the symmetry that it states.
"""

from __future__ import annotations

import codecs
import io
import math
import os
import re
from array import array
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from ..._util.files import Problem, SceneFileError, open_regular
from ..._util.lazy_names import import_extra
from ..._util.text import format_count
from ..importers import DETECTION_BYTES, ImportOptions, ImportResult, LegendEntry, is_cif, is_pdb, is_xyz
from .atoms import (
    ELEMENT_COLORS,
    SYMBOLS,
    Atoms,
    atomic_number,
    bonds_by_distance,
    cell_vectors,
    read_gemmi_atoms,
    share_remarks,
)
from .styles import MoleculeStyle, build_molecule_bodies

MAX_CIF_BYTES, MAX_LINE_LENGTH = 1 << 30, 1 << 20
"""Most bytes of a CIF or mmCIF, and most letters of a line of other files."""
_LINES_AT_ONCE = 1 << 16
_COMPONENT_PLACES = (("model_Cartn_", ""), ("pdbx_model_Cartn_", "_ideal"), ("", ""))
"""Before and after the axis in the names of places: of a model, ideal ones, and those of restraints' dictionaries."""
_CIF_FRACTIONS = tuple(f"_atom_site_fract_{axis}" for axis in "xyz")
_CIF_EDGES = tuple(f"_cell_length_{edge}" for edge in "abc")
_CIF_GROUPS = tuple(f"_space_group_name_{name}" for name in ("H-M_ref", "H-M_full", "Schoenflies"))
"""Names of a space group that gemmi does not read."""
_CIF_PLACES = (
    "_atom_site.Cartn_x",
    "_atom_site_fract_x",
    "_atom_site.fract_x",
    *(f"_chem_comp_atom.{a}x{b}" for a, b in _COMPONENT_PLACES),
)
"""Names of places by which a data block has atoms."""


def _read_lines(path: Path, encoding: str) -> Iterator[str]:
    """Yield the lines of a file of any length. Raise SceneFileError for a line that no such file has."""
    stream = open_regular(path)
    if stream.peek(3).startswith(codecs.BOM_UTF8):
        stream.read(3)
    with io.TextIOWrapper(stream, encoding, "replace") as file:
        for number, line in enumerate(iter(partial(file.readline, MAX_LINE_LENGTH + 1), ""), start=1):
            if len(line) > MAX_LINE_LENGTH:
                problem = Problem(number, 1, "molecule", f"is longer than {MAX_LINE_LENGTH:,} letters")
                raise SceneFileError(path, [problem])
            yield line


def read_cif(path: Path) -> Atoms:
    """Return the atoms of a CIF or mmCIF. Raise ImportError without gemmi, SceneFileError with gemmi's message."""
    gemmi = import_extra("gemmi", f"{path}: a CIF or mmCIF is read by gemmi", "molecules")
    if path.stat().st_size > MAX_CIF_BYTES:  # gemmi would read all of it before it looked at any
        raise SceneFileError(path, [Problem(0, 0, "molecule", f"is larger than {MAX_CIF_BYTES >> 20:,} MiB")])
    try:
        blocks = list(gemmi.cif.read(str(path)))
        # Dictionaries of restraints begin with a block that lists the others
        block = next((one for one in blocks if any(map(one.find_values, _CIF_PLACES))), blocks[0])
        remarks = (f"{format_count(len(blocks) - 1, 'other data block')} not read",) if len(blocks) > 1 else ()
        # Structures describe the components of their residues too, as a rule without places
        if block.find_values("_atom_site.Cartn_x"):
            atoms = _macromolecule(block, gemmi.cif.as_string)
        elif block.find_values("_chem_comp_atom.atom_id"):
            atoms = _component(block, gemmi.cif.as_string)
        else:
            dotted = block.find_values("_atom_site.fract_x")
            atoms = _crystal(_rename_items(block, gemmi.cif) if dotted else block, gemmi)
        return replace(atoms, remarks=(*remarks, *atoms.remarks))
    except (ValueError, RuntimeError) as error:
        raise SceneFileError(path, [_cif_problem(path, str(error))]) from None


def _rename_items(block: Any, cif: Any) -> Any:
    """Return a block of a crystal by version 3 of the core dictionary with the names before: _cell_length_a."""
    result = cif.Document().add_new_block(block.name)
    for item in block:
        if item.pair is not None:
            name, value = item.pair
            result.set_pair(name.replace(".", "_"), value)
        elif item.loop is not None:
            names, values = list(item.loop.tags), list(item.loop.values)
            loop = result.init_loop("", [name.replace(".", "_") for name in names])
            loop.set_all_values([values[k :: len(names)] for k in range(len(names))])
    return result


def _crystal(block: Any, gemmi: Any) -> Atoms:
    """Return all sites of a crystal's unit cell, by the symmetry that a block states."""
    structure = gemmi.make_small_structure_from_block(block)
    if block.find_values("_atom_site_label"):
        for names in (_CIF_FRACTIONS, _CIF_EDGES):
            if not all(map(block.find_values, names)):
                raise ValueError(f"sites must have places as fractions of a cell: {', '.join(names)} must be there")
    remarks = []
    if structure.spacegroup is None and not structure.cell.images:
        values = [gemmi.cif.as_string(block.find_value(name) or "?") for name in _CIF_GROUPS]
        structure.spacegroup_hm = structure.spacegroup_hm or values[0]
        structure.determine_and_set_spacegroup("S.H2N")  # a number alone names a group in its usual setting
        stated = structure.spacegroup_hm, structure.spacegroup_hall, structure.spacegroup_number, structure.symops
        if structure.spacegroup is None and any((*stated, *values)):
            remarks.append("the symmetry that the file states is unknown: only the sites that it lists are shown")
    atoms = read_gemmi_atoms(structure)
    return replace(atoms, remarks=(*remarks, *atoms.remarks))


def _component(block: Any, as_string: Any) -> Atoms:
    """Return the atoms of a definition of a chemical component: at places of a model, or else at ideal ones."""
    for prefix, suffix in _COMPONENT_PLACES:
        columns = [list(block.find_values(f"_chem_comp_atom.{prefix}{axis}{suffix}")) for axis in "xyz"]
        if all(columns) and not any(text in (".", "?") for column in columns for text in column):
            places = np.column_stack([_cif_floats(np.array(column), "_chem_comp_atom") for column in columns])
            labels = tuple(as_string(text) for text in block.find_values("_chem_comp_atom.atom_id"))
            return Atoms(places, list(block.find_values("_chem_comp_atom.type_symbol")), labels=labels)
    raise ValueError("_chem_comp_atom must have places of all atoms, of a model or ideal ones")


def _macromolecule(block: Any, as_string: Any) -> Atoms:
    """Return the atoms of an mmCIF's table, read by columns: a million atoms take seconds."""

    def column(*names: str) -> Any:
        """Return the first column that exists, without quotes; None if none does."""
        for name in names:
            values = list(block.find_values(f"_atom_site.{name}"))
            if values:
                return np.array([as_string(v) if v[0] in "'\";" else v for v in values])
        return None

    places = np.column_stack([_cif_floats(column(f"Cartn_{axis}"), f"_atom_site.Cartn_{axis}") for axis in "xyz"])
    names = [
        column("auth_atom_id", "label_atom_id"), column("auth_comp_id", "label_comp_id"),
        column("auth_seq_id", "label_seq_id"), column("auth_asym_id", "label_asym_id"),
    ]  # fmt: skip
    symbols, model, other = column("type_symbol"), column("pdbx_PDB_model_num"), column("label_alt_id")
    if symbols is None:
        raise ValueError("_atom_site.type_symbol, the element of each atom, must be there")
    selected, remarks = np.ones(len(places), bool), []
    if model is not None and (model != model[0]).any():
        selected &= model == model[0]
        remarks.append("the first of several models is read")
    insertion = column("pdbx_PDB_ins_code")
    sites = [part for part in (*names[2:], insertion) if part is not None]
    if other is not None and not np.isin(other, (".", "?")).all():
        parts = [part for part in (*names[:2], *sites) if part is not None]
        whole = [" ".join(row) for row in zip(*parts, strict=True)]
        _, first = np.unique(np.array(whole), return_index=True)
        alternate = ~np.isin(other, (".", "?"))
        alternate[first] = False
        if names[1] is not None and sites:
            other_residue = ~_has_first_name([" ".join(row) for row in zip(*sites, strict=True)], names[1])
            alternate |= other_residue & ~np.isin(other, (".", "?"))
        remarks.append(f"{int((alternate & selected).sum()):,} alternate places of atoms are left out")
        selected &= ~alternate
    shares = column("occupancy")
    if shares is not None and not np.isin(shares, (".", "?")).any():
        alone = selected if other is None else selected & np.isin(other, (".", "?"))
        remarks += share_remarks(_cif_floats(shares, "_atom_site.occupancy")[alone])
    labels: Any = names[0][selected] if names[0] is not None else np.zeros(0, "U1")
    if names[2] is not None and insertion is not None:
        names[2] = np.char.add(names[2], np.where(np.isin(insertion, (".", "?")), "", insertion))
    for part in names[1:]:
        if part is not None and len(labels):
            labels = np.char.add(np.char.add(labels, " "), part[selected])
    cell = _cif_cell(block)
    return Atoms(places[selected], symbols[selected], cell=cell, labels=tuple(labels.tolist()), remarks=tuple(remarks))


def _has_first_name(sites: Any, names: Any) -> Any:
    """Return a mask (N,) of the atoms whose residue has the name of the first one at its place in the chain."""
    _, first, place = np.unique(np.asarray(sites), return_index=True, return_inverse=True)
    return names == names[first][place]


def _cif_floats(values: Any, name: str) -> Any:
    try:
        return values.astype(np.float64)
    except (AttributeError, ValueError):
        raise ValueError(f"{name} must be numbers") from None


def _cif_cell(block: Any) -> Any:
    """Return the unit cell (3, 3); None if there is none, and for lengths 1 1 1, which stand for none."""
    names = ("length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma")
    texts = [(block.find_value(f"_cell.{name}") or "?").partition("(")[0] for name in names]
    try:
        numbers = [float(text) for text in texts]
    except ValueError:
        return None
    return None if numbers[:3] == [1.0, 1.0, 1.0] else cell_vectors(*numbers)


def _cif_problem(path: Path, message: str) -> Problem:
    """Return gemmi's message as a problem at its line.

    Messages have the form `name:line:column: message`, or `name:line:column(offset): message`.
    """
    match = re.search(r":(\d+):(\d+)(?:\(\d+\))?: *(.*)", message, re.S)
    if match:
        return Problem(int(match[1]), int(match[2]), "molecule", match[3].strip()[:200])
    return Problem(0, 0, "molecule", message.replace(str(path), "").strip(": ")[:200])


# PDB files, by columns (wwPDB, "Atomic Coordinate Entry Format", version 3.3): atoms, unit cell, CONECT.
#
# Of several models the first is read, of alternate positions of an atom the one that is listed first. The element
# stands in columns 77 and 78; if these are blank, it follows from the atom's name in columns 13 to 16, in which symbols
# of one letter begin in column 14. Names of four letters, such as HG21, begin in column 13 too: those of residues of
# proteins and nucleic acids are known to have no metals, and any hydrogen's name of four letters is one of hydrogen's.

_PDB_WIDTH = 80


def read_pdb(path: Path) -> Atoms:
    """Return the atoms of the first model of a PDB. Raise SceneFileError with the line of an error."""
    records, numbers, cells, conect = bytearray(), array("q"), [], []
    has_ended = is_longer = False
    for number, line in enumerate(_read_lines(path, "latin-1"), start=1):  # a byte for each letter
        kind, text = line[:6], line[:_PDB_WIDTH].rstrip("\n").encode("latin-1")
        if kind in ("ATOM  ", "HETATM"):
            is_longer |= has_ended
            if not has_ended:
                records += text.ljust(_PDB_WIDTH)
                numbers.append(number)
        elif kind == "CRYST1":
            cells.append((number, text))
        elif kind == "CONECT":
            conect.append(text)
        has_ended |= kind.rstrip() in ("ENDMDL", "END") or (kind == "MODEL " and bool(records))
    remarks = ["the first of several models is read"] if is_longer else []
    rows = np.frombuffer(records.replace(b"\0", b" "), np.uint8).reshape(-1, _PDB_WIDTH)
    first = _first_places(rows)
    if not first.all():
        remarks.append(f"{int((~first).sum()):,} alternate places of atoms are left out")
    rows, line_of = rows[first], np.array(numbers)[first]
    positions = np.column_stack([_pdb_floats(path, rows, line_of, begin) for begin in (30, 38, 46)])
    elements = _pdb_elements(path, rows, line_of)
    shares = [_pdb_number(text) for text in _pdb_texts(rows, 54, 60)[rows[:, 16] == ord(" ")].tolist()]
    remarks += share_remarks(np.array(shares))
    bonds = _read_conect(conect, rows, positions, elements)
    return Atoms(positions, elements, bonds, _pdb_cell(path, cells), _pdb_labels(rows), tuple(remarks))


def _pdb_texts(rows: Any, begin: int, end: int) -> Any:
    """Return the texts (N,) of columns, counted from 0, without blanks around them."""
    return np.char.strip(np.ascontiguousarray(rows[:, begin:end]).view(f"S{end - begin}").reshape(-1))


def _first_places(rows: Any) -> Any:
    """Return a mask (N,) of atoms that are no alternate position of one before.

    These have no letter for alternate positions (column 17), or they are the first of their name and residue.
    """
    letters = rows[:, 16]
    if (letters == ord(" ")).all():
        return np.ones(len(rows), bool)
    whole = np.ascontiguousarray(np.delete(rows[:, 12:27], 4, axis=1)).view("S14").reshape(-1)
    _, first = np.unique(whole, return_index=True)
    mask = letters == ord(" ")
    mask[first] = True
    residues = np.ascontiguousarray(rows[:, 17:20]).view("S3").reshape(-1)
    sites = np.ascontiguousarray(rows[:, 21:27]).view("S6").reshape(-1)
    return mask & ((letters == ord(" ")) | _has_first_name(sites, residues))


def _pdb_floats(path: Path, rows: Any, line_of: Any, begin: int) -> Any:
    """Return the numbers (N,) in eight columns from `begin`, counted from 0."""
    texts = _pdb_texts(rows, begin, begin + 8)
    try:
        plain = not (rows[:, begin : begin + 8] == ord("_")).any()  # a number in Python may be 1_000
        values = texts.astype(np.float64) if plain else None
    except ValueError:
        values = None
    if values is None:  # one by one, to find the first that is no number
        values = np.array([_pdb_number(text) for text in texts.tolist()])
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        text = texts[bad[0]].decode("utf-8", "replace")
        where = f"columns {begin + 1} to {begin + 8}"
        raise _pdb_error(path, int(line_of[bad[0]]), f"{where} must be a finite number, got {text!r}")
    return values


def _pdb_number(text: bytes) -> float:
    """Return a number; NaN for other texts."""
    try:
        return math.nan if b"_" in text else float(text)
    except ValueError:
        return math.nan


def _pdb_elements(path: Path, rows: Any, line_of: Any) -> Any:
    """Return the atomic numbers (N,)."""
    symbols, names = _pdb_texts(rows, 76, 78), np.ascontiguousarray(rows[:, 12:16]).view("S4").reshape(-1)
    # Each different pair of symbol and name is looked up once.
    residues = _pdb_texts(rows, 17, 20)
    keys = np.char.add(np.char.add(np.char.add(symbols, b"|"), np.char.add(residues, b"|")), names)
    keys, place = np.unique(keys, return_inverse=True)
    elements = np.zeros(len(keys), np.int64)
    for k, key in enumerate(keys.tolist()):
        symbol, residue, name = key.decode("ascii", "replace").split("|", 2)
        # Files from before 1996 count their lines in columns 77 to 80
        number = (
            atomic_number(symbol) if symbol and not symbol.isdigit() else _element_of_atom_name(name.ljust(4), residue)
        )
        if number is None:
            line = int(line_of[np.flatnonzero(place == k)[0]])
            raise _pdb_error(path, line, f"columns 77 and 78 must be an element's symbol, got {symbol!r}")
        elements[k] = number
    return elements[place]


_RESIDUES = frozenset(
    "ALA ARG ASN ASP ASX CYS CYX GLN GLU GLX GLY HIS HID HIE HIP ILE LEU LYS MET MSE PHE PRO PYL SEC SER THR TRP TYR "
    "VAL ACE NH2 NME A C G U I DA DC DG DT DI DU T ADE CYT GUA THY URA +A +C +G +U +T HOH WAT DOD SOL TIP "
    "HSD HSE HSP ASH GLH LYN CYM ARN HYP NLE ORN NMA FOR PCA SEP TPO PTR CSO MLY GOL EDO PEG NAG BMA MAN "
    "AMP ADP ATP ANP GMP GDP GTP CTP UTP NAD NAI NAP NDP FMN FAD COA ACO SAM SAH".split()
)
"""Names of residues whose atoms are of C, H, D, N, O, P and S, but for `_HEAVY`."""
_HEAVY = {"MSE": "SE", "SEC": "SE", "HEM": "FE", "HEC": "FE", "HEA": "FE"}
"""Residue -> the one element of it with two letters."""
_RARE = ("HE", "HF", "HO", "NE", "CF", "CM", "NO", "NP", "PA", "PM", "PO")
"""Elements that molecules do not have, but for ions in residues of their names: others are names of H, C, N and P."""


def _element_of_atom_name(name: str, residue: str) -> int:
    """Return the atomic number that an atom's name begins with; 0 if it names no element."""
    first, letters = name[:2].strip(" 0123456789'\"*"), name.strip(" 0123456789'\"*")
    if (heavy := _HEAVY.get(residue)) and letters.startswith(heavy):
        return atomic_number(heavy) or 0
    if (residue in _RESIDUES or heavy) and letters[:1] in tuple("CHDNOPS"):
        return atomic_number(letters[:1]) or 0
    if letters.startswith(_RARE) and not residue.startswith(letters[:2]):
        return atomic_number(letters[:1]) or 0
    # Four letters leave no column for a blank: with a digit or a prime they are hydrogen's, HF11 as well as HO5'
    if len(name.strip()) == 4 and name[0] == "H" and not name.isalpha():
        return 1
    return atomic_number(first) or atomic_number(name.strip(" 0123456789'\"*")[:1]) or 0


def _pdb_labels(rows: Any) -> tuple[str, ...]:
    """Return labels such as "CA LEU 12 A": atom, residue, number of the residue, and chain."""
    parts = [_pdb_texts(rows, *columns) for columns in ((12, 16), (17, 20), (22, 27), (21, 22))]
    joined = parts[0]
    for part in parts[1:]:
        joined = np.char.add(np.char.add(joined, b" "), part)
    return tuple(text.decode("ascii", "replace").strip() for text in joined.tolist())


def _read_conect(lines: list[bytes], rows: Any, positions: Any, elements: Any) -> Any:
    """Return the bonds (a, b, order) of CONECT records and those by distance; None if there are no records.

    A bond that the records repeat is double or triple.
    """
    records: dict[tuple[int, int], int] = {}
    if not lines:
        return None
    # Reversed, so that of equal serial numbers the first atom counts.
    serial = {text: k for k, text in reversed(list(enumerate(_pdb_texts(rows, 6, 11).tolist())))}
    for line in lines:
        first = serial.get(line[6:11].strip())
        for begin in range(11, 31, 5):
            other = serial.get(line[begin : begin + 5].strip())
            if first is not None and other is not None and first != other:
                records[first, other] = records.get((first, other), 0) + 1
    # Records list a bond from both atoms; some files from one of them, or with its order on one side only
    orders: dict[tuple[int, int], int] = {}
    for pair, order in records.items():
        bond = min(pair), max(pair)
        orders[bond] = max(orders.get(bond, 0), order)
    for first, other in bonds_by_distance(positions, elements).tolist():
        orders.setdefault((first, other), 1)
    return [(first, other, min(order, 3)) for (first, other), order in sorted(orders.items())]


def _pdb_cell(path: Path, records: list[tuple[int, bytes]]) -> Any:
    """Return the unit cell (3, 3) of the first CRYST1; None without one, and for lengths 1 1 1 or 0 0 0."""
    for number, line in records[:1]:
        places = ((6, 15), (15, 24), (24, 33), (33, 40), (40, 47), (47, 54))
        numbers = [_pdb_number(line[begin:end]) for begin, end in places]
        if numbers[:3] in ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]):
            return None
        cell = cell_vectors(*numbers)
        if cell is None:
            raise _pdb_error(path, number, "CRYST1 must hold three lengths and three angles of a cell")
        return cell
    return None


def _pdb_error(path: Path, line: int, message: str) -> SceneFileError:
    return SceneFileError(path, [Problem(line, 1, "molecule", message)])


# XYZ files: the number of atoms, a comment, and a line for each atom: symbol (or number), x, y, z in Å.
#
# The comment of an extended file may hold `Lattice="ax ay az bx by bz cx cy cz"`, and the columns of the lines as
# `Properties=species:S:1:pos:R:3`: name, type and count of each. Of several frames the first is read.

_XYZ_PROPERTIES = re.compile(r"\bproperties\s*+=\s*+(\"[^\"]*+\"|\S++)", re.I)
_XYZ_LATTICE = re.compile(r"\blattice\s*=\s*(?:\"([^\"]*+)\"|'([^']*)'|\{([^{}]*+)\})", re.I)


def read_xyz(path: Path) -> Atoms:
    """Return the atoms of the first frame of an XYZ. Raise SceneFileError with the line of an error."""
    lines = _read_lines(path, "utf-8")
    first, comment = next(lines, ""), next(lines, "")
    if re.fullmatch(r"\s*+\d{1,9}\s*+", first) is None:
        raise _xyz_error(path, 1, "the number of atoms must stand here, alone")
    count, positions, numbers = int(first), [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    symbol, place = _xyz_columns(path, comment)
    width = max(symbol, place + 2) + 1
    for begin in range(0, count, _LINES_AT_ONCE):
        some = list(islice(lines, min(count - begin, _LINES_AT_ONCE)))
        end = begin + len(some)
        if end < min(count, begin + _LINES_AT_ONCE):
            raise _xyz_error(path, end + 3, f"must be atom {end + 1} of {count}, and is the end of the file")
        rows = [line.split(None, width)[:width] for line in some]
        short = next((k for k, row in enumerate(rows) if len(row) < width), None)
        if short is not None:
            message = f"must be a symbol and three numbers, got {some[short].strip()!r:.80}"
            raise _xyz_error(path, begin + short + 3, message)
        positions.append(_xyz_positions(path, rows, place, begin + 3))
        numbers.append(_xyz_elements(path, [row[symbol] for row in rows], begin + 3))
    remarks = ("the first of several frames is read",) if any(line.strip() for line in lines) else ()
    cell = _xyz_cell(path, comment)
    return Atoms(np.concatenate(positions), np.concatenate(numbers), cell=cell, remarks=remarks)


def _xyz_columns(path: Path, comment: str) -> tuple[int, int]:
    """Return the columns of the symbol and of x: 0 and 1, or those that an extended file's comment states."""
    match = _XYZ_PROPERTIES.search(comment)
    if match is None:
        return 0, 1
    words, columns, at = match[1].strip('"').split(":"), dict[str, int](), 0
    for name, _, count in zip(words[::3], words[1::3], words[2::3], strict=False):
        columns.setdefault(name.lower(), at)
        at += int(count) if re.fullmatch("[0-9]{1,4}", count) else 1
    symbol = columns.get("species", columns.get("z"))
    if symbol is None or "pos" not in columns:
        raise _xyz_error(path, 2, f"Properties must have species (or Z) and pos, got {match[1]!r:.80}")
    return symbol, columns["pos"]


def _xyz_positions(path: Path, rows: list[list[str]], place: int, line: int) -> Any:
    """Return the positions (N, 3), whose x stands in the column `place`."""
    columns = [[row[k] for row in rows] for k in range(place, place + 3)]
    try:
        positions = np.stack([np.array(column, np.float64) for column in columns], axis=1)
    except ValueError:
        positions = None
    plain = not any("_" in text for column in columns for text in column)
    if plain and positions is not None and np.isfinite(positions).all():
        return positions
    for k, row in enumerate(rows):  # one by one, to report the line
        for text in row[place : place + 3]:
            if not _is_number(text):
                raise _xyz_error(path, line + k, f"x, y and z must be finite numbers, got {text!r:.40}")
    return positions


def _is_number(text: str) -> bool:
    try:
        return "_" not in text and math.isfinite(float(text))
    except ValueError:
        return False


def _xyz_elements(path: Path, texts: list[str], line: int) -> Any:
    """Return the atomic numbers (N,)."""
    number_of = {text: atomic_number(text) for text in set(texts)}
    for text in number_of:
        if number_of[text] is None and text.isdecimal() and int(text[:4]) < len(SYMBOLS):
            number_of[text] = int(text)
    wrong = next((k for k, text in enumerate(texts) if number_of[text] is None), None)
    if wrong is not None:
        raise _xyz_error(path, line + wrong, f"must begin with an element's symbol or number, got {texts[wrong]!r:.40}")
    return np.array([number_of[text] for text in texts], np.int64)


def _xyz_cell(path: Path, comment: str) -> Any:
    """Return the unit cell (3, 3) in a comment; None if it has none."""
    match = _XYZ_LATTICE.search(comment)
    if match is None:
        return None
    words = (match[1] or match[2] or match[3] or "").split()
    if len(words) != 9 or not all(_is_number(word) for word in words):
        raise _xyz_error(path, 2, f"Lattice must be nine finite numbers, got {' '.join(words)!r:.80}")
    return np.array([float(word) for word in words]).reshape(3, 3)


def _xyz_error(path: Path, line: int, message: str) -> SceneFileError:
    return SceneFileError(path, [Problem(line, 1, "molecule", message)])


# Files of molecules, recognised by their content

_READERS: tuple[tuple[Callable[[str, str], bool], Callable[[Path], Atoms]], ...] = (
    (is_cif, read_cif), (is_pdb, read_pdb), (is_xyz, read_xyz),
)  # fmt: skip


def read_atoms(path: str | os.PathLike[str]) -> Atoms:
    """Return the atoms in a file.

    Parameters
    ----------
    path
        An XYZ, PDB, mmCIF or CIF file.

    Raises
    ------
    SceneFileError
        The file has an error; the message has its line.
    OSError
        The file cannot be read.
    ValueError
        The file is of another kind.
    ImportError
        The file needs gemmi, which is not installed.

    """
    with open_regular(path) as file:
        head = file.read(DETECTION_BYTES).decode("utf-8-sig", "replace")
    for recognises, read in _READERS:
        if recognises(head, Path(path).suffix.lower()):
            return read(Path(path))
    raise ValueError(f"{os.fspath(path)}: is no XYZ, PDB, mmCIF or CIF file")


# Import by the options of all formats

MANY_ATOMS = 20_000
"""Above this number atoms are shown as balls only, as bonds could not be distinguished."""


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import a molecule as balls and sticks, or as balls of van der Waals radii above `MANY_ATOMS` atoms.

    The unit cell of a crystal is shown too.

    Parameters
    ----------
    path
        The file.
    options
        Options of the import; `strict` applies.

    Raises
    ------
    ValueError
        An option does not apply, or there are more bodies than `max_bodies`; also SceneFileError.
    ImportError, OSError
        See `read_atoms`.

    """
    options.refuse_others("a molecule", "strict")
    atoms = read_atoms(path)
    look = MoleculeStyle("ball and stick" if len(atoms) <= MANY_ATOMS else "space filling", {}, {})
    bodies = build_molecule_bodies(atoms, look, True)
    count = len(atoms) + (0 if look.style == "space filling" else 2 * len(atoms.bonds))
    if options.max_bodies is not None and count > options.max_bodies:
        raise ValueError(
            f"{os.fspath(path)}: {format_count(count, 'body')}, more than max_bodies = {options.max_bodies:,}"
        )
    legend = []
    for number, count in zip(*np.unique(atoms.numbers, return_counts=True), strict=True):
        legend.append(LegendEntry(None, SYMBOLS[number], ELEMENT_COLORS[number], int(count)))
    remarks = atoms.remarks if len(atoms) else (*atoms.remarks, "the file holds no atoms")
    facts = (f"{format_count(len(atoms), 'atom')}: {atoms.formula:.200}", f"shown in the style {look.style!r}")
    names = {material: material.name for body in bodies for material in (body.materials or ()) if material.name}
    return ImportResult(bodies, tuple(legend), (*facts, *remarks), remarks, names, unit="angstrom")
