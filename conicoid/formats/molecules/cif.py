"""Molecules of mmCIF and CIF files, which gemmi reads: an extra, `pip install "conicoid[molecules]"`.

Of an mmCIF the first model and the first of alternate places are taken, as gemmi has them; of a CIF all sites of a unit
cell, by the symmetry that it states.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import Problem, SceneFileError
from .atoms import Atoms
from .cells import cell_of
from .objects import atoms_of_gemmi


def read_cif(path: Path) -> Atoms:
    """The atoms of a file. Raises ImportError without gemmi, SceneFileError with what gemmi says of the file."""
    try:
        import gemmi
    except ImportError:
        told = 'is read by gemmi: pip install "conicoid[molecules]"'
        raise ImportError(f"{path}: a CIF or mmCIF {told}") from None
    try:
        block = gemmi.cif.read(str(path)).sole_block()
        if block.find_loop("_atom_site.Cartn_x"):
            return _macromolecule(block, gemmi.cif.as_string)
        return atoms_of_gemmi(gemmi.make_small_structure_from_block(block))
    except (ValueError, RuntimeError) as error:
        raise SceneFileError(path, [_problem(path, str(error))]) from None


def _macromolecule(block: Any, as_string: Any) -> Atoms:
    """The atoms of an mmCIF's table, by columns: a million take seconds."""

    def column(*names: str) -> Any:
        """The first column that there is, without quotes; None for none."""
        for name in names:
            values = list(block.find_loop(f"_atom_site.{name}"))
            if values:
                return np.array([as_string(v) if v[0] in "'\";" else v for v in values])
        return None

    places = np.column_stack([_floats(column(f"Cartn_{axis}"), f"_atom_site.Cartn_{axis}") for axis in "xyz"])
    names = [
        column("auth_atom_id", "label_atom_id"), column("auth_comp_id", "label_comp_id"),
        column("auth_seq_id", "label_seq_id"), column("auth_asym_id", "label_asym_id"),
    ]  # fmt: skip
    symbols, model, other = column("type_symbol"), column("pdbx_PDB_model_num"), column("label_alt_id")
    if symbols is None:
        raise ValueError("_atom_site.type_symbol, the element of each atom, must be there")
    kept, remarks = np.ones(len(places), bool), []
    if model is not None and (model != model[0]).any():
        kept &= model == model[0]
        remarks.append("the first of several models is read")
    if other is not None and not np.isin(other, (".", "?")).all():
        whole = [" ".join(row) for row in zip(*(part for part in names if part is not None), strict=True)]
        _, first = np.unique(np.array(whole), return_index=True)
        alternate = ~np.isin(other, (".", "?"))
        alternate[first] = False
        remarks.append(f"{int((alternate & kept).sum()):,} alternate places of atoms are left out")
        kept &= ~alternate
    labels: Any = names[0][kept] if names[0] is not None else np.zeros(0, "U1")
    for part in names[1:]:
        if part is not None and len(labels):
            labels = np.char.add(np.char.add(labels, " "), part[kept])
    cell = _cell(block)
    return Atoms(places[kept], symbols[kept], cell=cell, labels=tuple(labels.tolist()), remarks=tuple(remarks))


def _floats(values: Any, name: str) -> Any:
    try:
        return values.astype(np.float64)
    except (AttributeError, ValueError):
        raise ValueError(f"{name} must be numbers") from None


def _cell(block: Any) -> Any:
    """The unit cell; None for none, and for 1 1 1, which stands for none."""
    names = ("length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma")
    texts = [(block.find_value(f"_cell.{name}") or "?").partition("(")[0] for name in names]
    try:
        numbers = [float(text) for text in texts]
    except ValueError:
        return None
    return None if numbers[:3] == [1.0, 1.0, 1.0] else cell_of(*numbers)


def _problem(path: Path, told: str) -> Problem:
    """What gemmi says, at its line: `name:line:column: message`, or `name:line:column(offset): message`."""
    found = re.search(r":(\d+):(\d+)(?:\(\d+\))?: *(.*)", told, re.S)
    if found:
        return Problem(int(found[1]), int(found[2]), "molecule", found[3].strip()[:200])
    return Problem(0, 0, "molecule", told.replace(str(path), "").strip(": ")[:200])
