"""Atoms of other libraries' objects, known by what they have and not by their class: none of them is imported.

ASE (`get_positions`), biotite (`coord`), MDAnalysis (`atoms.positions`), RDKit (`GetConformer`), gemmi (`cell`, and
models or sites). Others have `positions` and `numbers`, `elements` or `symbols`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...shapes.validate import what
from .atoms import Atoms
from .cells import cell_of


def atoms_of_object(given: Any) -> Atoms:
    """The atoms of an object. Raises TypeError for what has none."""
    if hasattr(given, "GetConformer") and hasattr(given, "GetAtoms"):
        return _of_rdkit(given)
    if hasattr(given, "get_positions") and hasattr(given, "get_atomic_numbers"):
        return _of_ase(given)
    if hasattr(given, "coord") and hasattr(given, "element"):
        return _of_biotite(given)
    if hasattr(given, "atoms") and hasattr(given.atoms, "positions"):
        return _of_mdanalysis(given)
    if hasattr(given, "get_all_unit_cell_sites") or (hasattr(given, "cell") and hasattr(given, "spacegroup_hm")):
        return atoms_of_gemmi(given)
    if hasattr(given, "positions"):
        for name in ("numbers", "elements", "symbols"):
            if getattr(given, name, None) is not None:
                return Atoms(given.positions, np.asarray(getattr(given, name)))
    told = "a file's path, positions with elements, or an object of ASE, biotite, MDAnalysis, RDKit or gemmi"
    raise TypeError(f"molecule: atoms must be {told}, got {what(given)}")


def _of_ase(given: Any) -> Atoms:
    cell = np.asarray(given.cell) if np.any(given.pbc) and abs(np.linalg.det(np.asarray(given.cell))) > 0 else None
    return Atoms(given.get_positions(), given.get_atomic_numbers(), cell=cell)


def _of_biotite(given: Any) -> Atoms:
    coord = np.asarray(given.coord)
    remarks: tuple[str, ...] = ()
    if coord.ndim == 3:
        coord, remarks = coord[0], ("the first of several models is read",) if len(coord) > 1 else ()
    box = getattr(given, "box", None)
    box = box[0] if box is not None and np.ndim(box) == 3 else box
    bonds = None
    if getattr(given, "bonds", None) is not None:
        bonds = np.asarray(given.bonds.as_array(), np.float64)
        # kinds: any, single, double, triple, quadruple, then aromatic of single, double, triple, and of neither
        bonds[:, 2] = np.array([1, 1, 2, 3, 4, 1.5, 1.5, 3, 1, 1.5])[np.minimum(bonds[:, 2].astype(int), 9)]
    labels: tuple[str, ...] = ()
    if hasattr(given, "atom_name") and hasattr(given, "res_name"):
        columns = (given.atom_name, given.res_name, given.res_id, given.chain_id)
        labels = tuple(f"{a} {r} {n} {c}".strip() for a, r, n, c in zip(*columns, strict=True))
    return Atoms(coord, np.asarray(given.element), bonds, box, labels, remarks)


def _of_mdanalysis(given: Any) -> Atoms:
    group = given.atoms
    for name in ("elements", "types", "names"):
        elements = getattr(group, name, None)
        if elements is not None:
            break
    else:
        raise ValueError("molecule: atoms must have elements: universe.guess_TopologyAttrs(to_guess=['elements'])")
    bonds = None
    if getattr(group, "bonds", None) is not None and len(group.bonds):
        place = {index: k for k, index in enumerate(np.asarray(group.indices).tolist())}
        pairs = np.asarray(group.bonds.indices).tolist()
        bonds = [(place[a], place[b]) for a, b in pairs if a in place and b in place]
    size = getattr(group, "dimensions", None)
    return Atoms(group.positions, np.asarray(elements), bonds, None if size is None else cell_of(*map(float, size)))


def _of_rdkit(given: Any) -> Atoms:
    numbers = [atom.GetAtomicNum() for atom in given.GetAtoms()]
    bonds = [(b.GetBeginAtomIdx(), b.GetEndAtomIdx(), b.GetBondTypeAsDouble() or 1.0) for b in given.GetBonds()]
    try:
        positions = given.GetConformer().GetPositions()
    except ValueError:
        told = "must have a conformer: rdkit.Chem.AllChem.EmbedMolecule(molecule) makes one"
        raise ValueError(f"molecule: atoms {told}") from None
    return Atoms(positions, np.array(numbers, np.int64), bonds)


def atoms_of_gemmi(given: Any) -> Atoms:
    """The atoms of a gemmi Structure, of its first model and first alternate places, or of a SmallStructure's cell."""
    parameters = given.cell.parameters
    cell = None if parameters[:3] == (1.0, 1.0, 1.0) else cell_of(*parameters)
    if hasattr(given, "get_all_unit_cell_sites"):
        sites = [site for site in given.get_all_unit_cell_sites() if site.element.atomic_number > 0]
        within = np.array([site.fract.tolist() for site in sites]).reshape(-1, 3)
        within -= np.floor(within + 1e-9)  # sites that symmetry puts beside the cell are those within it
        places = within @ np.array(given.cell.orth.mat.tolist()).T
        numbers = np.array([site.element.atomic_number for site in sites], np.int64)
        return Atoms(places, numbers, cell=cell, labels=tuple(site.label for site in sites))
    remarks = ("the first of several models is read",) if len(given) > 1 else ()
    rows, left = [], 0
    for chain in given[0] if len(given) else ():
        for residue in chain:
            seen = set()
            for atom in residue:
                if atom.altloc != "\0" and atom.name in seen:
                    left += 1
                    continue
                seen.add(atom.name)
                label = f"{atom.name} {residue.name} {residue.seqid} {chain.name}"
                rows.append((atom.pos.x, atom.pos.y, atom.pos.z, atom.element.atomic_number, label))
    if left:
        remarks = (*remarks, f"{left:,} alternate places of atoms are left out")
    places = np.array([row[:3] for row in rows]).reshape(-1, 3)
    numbers = np.array([row[3] for row in rows], np.int64)
    return Atoms(places, numbers, None, cell, tuple(row[4] for row in rows), remarks)
