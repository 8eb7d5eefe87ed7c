"""Atoms of molecules and crystals: elements, bonds, the class `Atoms`, unit cells, and other libraries' objects.

Sources of the table of elements. Covalent radii in Å: B. Cordero and others, "Covalent radii revisited", Dalton
Transactions (2008), 2832; for C that of sp3, for Mn, Fe and Co that of low spin. Van der Waals radii in Å: S. Alvarez,
"A cartography of the van der Waals territories", Dalton Transactions 42 (2013), 8617. Colours: those of Jmol, which go
back to Corey, Pauling and Koltun.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import DOMAIN, describe_kind, format_value, is_outside_domain, real_array
from ...numerics.portable_math import sin_cos_degrees

# Symbol, covalent radius, van der Waals radius, colour; - where nothing is published.
_ROWS = """
H 0.31 1.20 ffffff; He 0.28 1.43 d9ffff; Li 1.28 2.12 cc80ff; Be 0.96 1.98 c2ff00; B 0.84 1.91 ffb5b5;
C 0.76 1.77 909090; N 0.71 1.66 3050f8; O 0.66 1.50 ff0d0d; F 0.57 1.46 90e050; Ne 0.58 1.58 b3e3f5;
Na 1.66 2.50 ab5cf2; Mg 1.41 2.51 8aff00; Al 1.21 2.25 bfa6a6; Si 1.11 2.19 f0c8a0; P 1.07 1.90 ff8000;
S 1.05 1.89 ffff30; Cl 1.02 1.82 1ff01f; Ar 1.06 1.83 80d1e3; K 2.03 2.73 8f40d4; Ca 1.76 2.62 3dff00;
Sc 1.70 2.58 e6e6e6; Ti 1.60 2.46 bfc2c7; V 1.53 2.42 a6a6ab; Cr 1.39 2.45 8a99c7; Mn 1.39 2.45 9c7ac7;
Fe 1.32 2.44 e06633; Co 1.26 2.40 f090a0; Ni 1.24 2.40 50d050; Cu 1.32 2.38 c88033; Zn 1.22 2.39 7d80b0;
Ga 1.22 2.32 c28f8f; Ge 1.20 2.29 668f8f; As 1.19 1.88 bd80e3; Se 1.20 1.82 ffa100; Br 1.20 1.86 a62929;
Kr 1.16 2.25 5cb8d1; Rb 2.20 3.21 702eb0; Sr 1.95 2.84 00ff00; Y 1.90 2.75 94ffff; Zr 1.75 2.52 94e0e0;
Nb 1.64 2.56 73c2c9; Mo 1.54 2.45 54b5b5; Tc 1.47 2.44 3b9e9e; Ru 1.46 2.46 248f8f; Rh 1.42 2.44 0a7d8c;
Pd 1.39 2.15 006985; Ag 1.45 2.53 c0c0c0; Cd 1.44 2.49 ffd98f; In 1.42 2.43 a67573; Sn 1.39 2.42 668080;
Sb 1.39 2.47 9e63b5; Te 1.38 1.99 d47a00; I 1.39 2.04 940094; Xe 1.40 2.06 429eb0; Cs 2.44 3.48 57178f;
Ba 2.15 3.03 00c900; La 2.07 2.98 70d4ff; Ce 2.04 2.88 ffffc7; Pr 2.03 2.92 d9ffc7; Nd 2.01 2.95 c7ffc7;
Pm 1.99 - a3ffc7; Sm 1.98 2.90 8fffc7; Eu 1.98 2.87 61ffc7; Gd 1.96 2.83 45ffc7; Tb 1.94 2.79 30ffc7;
Dy 1.92 2.87 1fffc7; Ho 1.92 2.81 00ff9c; Er 1.89 2.83 00e675; Tm 1.90 2.79 00d452; Yb 1.87 2.80 00bf38;
Lu 1.87 2.74 00ab24; Hf 1.75 2.63 4dc2ff; Ta 1.70 2.53 4da6ff; W 1.62 2.57 2194d6; Re 1.51 2.49 267dab;
Os 1.44 2.48 266696; Ir 1.41 2.41 175487; Pt 1.36 2.29 d0d0e0; Au 1.36 2.32 ffd123; Hg 1.32 2.45 b8b8d0;
Tl 1.45 2.47 a6544d; Pb 1.46 2.60 575961; Bi 1.48 2.54 9e4fb5; Po 1.40 - ab5c00; At 1.50 - 754f45;
Rn 1.50 - 428296; Fr 2.60 - 420066; Ra 2.21 - 007d00; Ac 2.15 2.80 70abfa; Th 2.06 2.93 00baff;
Pa 2.00 2.88 00a1ff; U 1.96 2.71 008fff; Np 1.90 2.82 0080ff; Pu 1.87 2.81 006bff; Am 1.80 2.83 545cf2;
Cm 1.69 3.05 785ce3; Bk - 3.40 8a4fe3; Cf - 3.05 a136d4; Es - 2.70 b31fd4; Fm - - b31fba; Md - - b30da6;
No - - bd0d87; Lr - - c70066; Rf - - cc0059; Db - - d1004f; Sg - - d90045; Bh - - e00038; Hs - - e6002e;
Mt - - eb0026; Ds - - -; Rg - - -; Cn - - -; Nh - - -; Fl - - -; Mc - - -; Lv - - -; Ts - - -; Og - - -
"""
_TABLE = [row.split() for row in _ROWS.replace("\n", " ").split(";")]

SYMBOLS = ("X", *(row[0] for row in _TABLE))
"""Symbols by atomic number; 0 is an atom of unknown element."""
# Upper case, because files of proteins write CA for calcium and ZN for zinc
_NUMBERS = {symbol.upper(): number for number, symbol in enumerate(SYMBOLS)} | {"D": 1, "T": 1}


def _column(at: int, otherwise: float) -> FloatArray:
    """Return a read-only column of the table by atomic number."""
    values = np.array([otherwise] + [otherwise if row[at] == "-" else float(row[at]) for row in _TABLE])
    values.flags.writeable = False
    return values


COVALENT_RADII = _column(1, 1.5)
"""Covalent radii by atomic number, in Å; 1.5 where nothing is published."""
VAN_DER_WAALS_RADII = _column(2, 2.0)
"""Van der Waals radii by atomic number, in Å; 2 where nothing is published."""
ELEMENT_COLORS = ("#ff1493", *("#ff1493" if row[3] == "-" else f"#{row[3]}" for row in _TABLE))
"""Colours by atomic number (#rrggbb); pink for elements without a usual colour."""


def atomic_number(symbol: str) -> int | None:
    """Return the atomic number of a symbol; None if it is unknown.

    Case does not matter; isotopes and charges are ignored ("FE2+", "13C"). D and T are hydrogen, X is 0.
    """
    return _NUMBERS.get(symbol.strip().lstrip("0123456789").rstrip("0123456789+-").upper())


# Bonds: by distance, found through a grid, or as the user gives them

BOND_TOLERANCE = 0.45
"""Largest excess in Å of a bond over the sum of the covalent radii of its atoms (Meng and Lewis 1991)."""
MIN_BOND_LENGTH = 0.4
"""Least length of a bond in Å; atoms that are nearer are one atom in two alternate positions."""
_AT_ONCE = 1 << 22
"""Pairs of atoms that are compared at once, to bound memory."""
_LONGEST_GRID = 1 << 20
"""Most squares of the grid along an axis, so that keys fit into 64 bits."""
_MOST_BONDS, _MOST_NEIGHBOURS = 16, 1000
"""Most bonds, and most pairs that may be bonds, for each atom in the mean: metals have 7 bonds, and some 200 pairs."""

Indices = npt.NDArray[np.int64]


def bonds_by_distance(positions: FloatArray, numbers: Indices) -> Indices:
    """Return the bonded pairs of atoms (M, 2), the smaller index first, in lexicographic order.

    Parameters
    ----------
    positions
        (N, 3) in Å.
    numbers
        (N,) atomic numbers.

    """
    if len(positions) < 2:
        return np.zeros((0, 2), np.int64)
    radii = COVALENT_RADII[numbers]
    # The longest bond that any two of these atoms may have
    reach = 2 * float(radii.max()) + BOND_TOLERANCE
    blocks: list[Indices] = []
    for first, second in _near_pairs(positions, reach):
        blocks.append(_select_bonded(positions, radii, first, second))
        if sum(map(len, blocks)) > _MOST_BONDS * len(positions):
            raise ValueError(f"molecule: atoms lie closer than any do: they have more than {_MOST_BONDS} bonds each")
    pairs = np.sort(np.concatenate([*blocks, np.zeros((0, 2), np.int64)]), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _select_bonded(positions: FloatArray, radii: FloatArray, first: Indices, second: Indices) -> Indices:
    """Return the pairs (M, 2) whose distance is that of a bond."""
    square = ((positions[first] - positions[second]) ** 2).sum(axis=1)
    most = radii[first] + radii[second] + BOND_TOLERANCE
    bonded = (square <= most * most) & (square >= MIN_BOND_LENGTH * MIN_BOND_LENGTH)
    return np.column_stack([first[bonded], second[bonded]])


def _near_pairs(positions: FloatArray, reach: float) -> Iterator[tuple[Indices, Indices]]:
    """Yield pairs of atoms in neighbouring cubes of a grid, each pair once; they include all pairs within `reach`.

    Cubes of a row along z have consecutive keys, so that the neighbours of a cube are five ranges of sorted atoms.
    """
    low = positions.min(axis=0)
    size = max(reach, float((positions.max(axis=0) - low).max()) / _LONGEST_GRID)
    # From 1: neighbours of the cubes at the border have keys of their own, which no atom has
    square = np.floor((positions - low) / size).astype(np.int64) + 1
    _, rows, columns = (square.max(axis=0) + 2).tolist()
    key = (square[:, 0] * rows + square[:, 1]) * columns + square[:, 2]
    order = np.argsort(key, kind="stable")
    key = key[order]
    own = np.arange(len(key))
    ranges = [(own + 1, np.searchsorted(key, key + 1, "right"))]
    # Half of the neighbours, so that each pair comes once
    for shift in (columns, (rows - 1) * columns, rows * columns, (rows + 1) * columns):
        ranges.append((np.searchsorted(key, key + shift - 1), np.searchsorted(key, key + shift + 1, "right")))
    if sum(int(np.maximum(end - begin, 0).sum()) for begin, end in ranges) > _MOST_NEIGHBOURS * len(key) + _AT_ONCE:
        raise ValueError(f"molecule: atoms lie closer than any do: more than {_MOST_NEIGHBOURS} near each")
    for begin, end in ranges:
        counts = np.maximum(end - begin, 0)
        for part in _atom_slices(counts):
            many = counts[part]
            first = np.repeat(own[part], many)
            within = np.arange(len(first)) - np.repeat(np.cumsum(many) - many, many)
            yield order[first], order[np.repeat(begin[part], many) + within]


def _atom_slices(counts: Indices) -> Iterator[slice]:
    """Yield slices of atoms whose pairs are at most `_AT_ONCE` together, but at least one atom each."""
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        before = int(ends[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, before + _AT_ONCE, "right")))
        yield slice(begin, end)
        begin = end


def check_bonds(pairs: Any, count: int) -> FloatArray:
    """Return bonds as floats (M, 3): indices of two atoms, the smaller first, and the order of the bond.

    Parameters
    ----------
    pairs
        (M, 2) indices, or (M, 3) with orders.
    count
        Number of atoms.

    Raises
    ------
    ValueError
        A bond is not of two different atoms, or its order is not in (0, 4].

    """
    bonds = np.array(real_array("molecule", "bonds", pairs))
    bonds = bonds.reshape(0, 3) if bonds.size == 0 else bonds
    if bonds.ndim != 2 or bonds.shape[1] not in (2, 3):
        raise ValueError(f"molecule: bonds must have shape (M, 2), or (M, 3) with orders, got {bonds.shape}")
    if bonds.shape[1] == 2:
        bonds = np.column_stack([bonds, np.ones(len(bonds))])
    ends = bonds[:, :2]
    wrong = ~((ends >= 0) & (ends < count) & (ends == np.floor(ends))).all(axis=1) | (ends[:, 0] == ends[:, 1])
    for bad, expected in (
        (wrong, f"two different atoms from 0 to {count - 1}"),
        (~((bonds[:, 2] > 0) & (bonds[:, 2] <= 4)), "of an order > 0 and <= 4"),
    ):
        rows = np.flatnonzero(bad)
        if len(rows):
            raise ValueError(f"molecule: bonds[{rows[0]}] must be {expected}, got {bonds[rows[0]].tolist()}")
    bonds[:, :2].sort(axis=1)
    return bonds


# Atoms as data


@dataclass(frozen=True, eq=False)
class Atoms:
    """Atoms of a molecule or a crystal, in Å.

    Parameters
    ----------
    positions
        (N, 3).
    numbers
        (N,) atomic numbers, or symbols such as "C"; 0 and "X" are atoms of unknown element.
    given_bonds
        (M, 2) indices of bonded atoms, or (M, 3) with the order of each bond (1, 1.5, 2 or 3); None finds `bonds` by
        distance.
    cell
        (3, 3), the edges of a unit cell as rows, or None.
    labels
        The name of each atom in its file, such as "CA LEU 12 A"; empty if there are none.
    remarks
        Notes about how the atoms were read.

    Raises
    ------
    ValueError
        A value is wrong; the message names the field and the atom.

    """

    positions: Any
    numbers: Any
    given_bonds: Any = None
    cell: Any = None
    labels: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @ignore_fp_errors
    def __post_init__(self) -> None:
        # A copy, which is then read-only: the caller's array stays the caller's
        positions = np.array(real_array("molecule", "atoms", self.positions))
        if positions.size == 0:
            positions = positions.reshape(0, 3)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise ValueError(f"molecule: atoms must have positions of shape (N, 3), got {positions.shape}")
        for wrong, expected in ((~np.isfinite(positions), "finite"), (is_outside_domain(positions), DOMAIN)):
            bad = np.flatnonzero(wrong.any(axis=1))
            if len(bad):
                raise ValueError(f"molecule: atoms[{bad[0]}] must be {expected}, got {positions[bad[0]].tolist()}")
        numbers = _parse_atomic_numbers(self.numbers, len(positions))
        bonds = None if self.given_bonds is None else check_bonds(self.given_bonds, len(positions))
        cell = None if self.cell is None else np.array(real_array("molecule", "cell", self.cell))
        if cell is not None and (cell.shape != (3, 3) or not np.isfinite(cell).all()):
            raise ValueError(f"molecule: cell must be three finite vectors, (3, 3), got {format_value(self.cell)}")
        for name, value in (("positions", positions), ("numbers", numbers), ("given_bonds", bonds), ("cell", cell)):
            if value is not None:
                value.flags.writeable = False
            object.__setattr__(self, name, value)
        vars(self).update(labels=tuple(self.labels), remarks=tuple(self.remarks))

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def bonds(self) -> FloatArray:
        """Bonds (M, 3): the indices of two atoms, the smaller first, and the order of their bond.

        Without `given_bonds`, two atoms are bonded if their distance is 0.4 Å or more and at most the sum of their
        covalent radii plus 0.45 Å (E. C. Meng and R. A. Lewis, J. Comput. Chem. 12 (1991), 891); all are of order 1.
        """
        if self.given_bonds is not None:
            return self.given_bonds
        pairs = bonds_by_distance(self.positions, self.numbers)
        return np.column_stack([pairs, np.ones(len(pairs))])

    @property
    def symbols(self) -> list[str]:
        """The symbol of each atom's element."""
        return [SYMBOLS[number] for number in self.numbers.tolist()]

    @property
    def formula(self) -> str:
        """The molecular formula in Hill's order, such as C8H10N4O2."""
        counts = {SYMBOLS[n]: c for n, c in zip(*_count_elements(self.numbers), strict=True)}
        first = [name for name in ("C", "H") if name in counts and "C" in counts]
        rest = sorted(name for name in counts if name not in first)
        return "".join(f"{name}{counts[name] if counts[name] > 1 else ''}" for name in (*first, *rest))


def _count_elements(numbers: Any) -> tuple[list[int], list[int]]:
    values, counts = np.unique(numbers, return_counts=True)
    return values.tolist(), counts.tolist()


def _parse_atomic_numbers(elements: Any, count: int) -> Any:
    """Return atomic numbers (N,) from numbers or symbols. Raise ValueError that names the atom."""
    values = np.asarray(elements)
    if values.shape != (count,):
        raise ValueError(f"molecule: elements must have shape ({count},), as there are positions, got {values.shape}")
    if values.dtype.kind in "USO" and count:
        # Each different symbol is looked up once: there may be millions of atoms.
        different, place = np.unique(np.array([str(value) for value in values.tolist()]), return_inverse=True)
        number_of = [atomic_number(symbol) for symbol in different.tolist()]
        if None in number_of:
            wrong = str(different[number_of.index(None)])
            where = int(np.flatnonzero(place == number_of.index(None))[0])
            raise ValueError(
                f"molecule: elements[{where}] must be an element's symbol or number, got {format_value(wrong)}"
            )
        return np.array(number_of, np.int64)[place]
    numbers = np.array(real_array("molecule", "elements", values)).reshape(count)
    bad = np.flatnonzero(~((numbers >= 0) & (numbers < len(SYMBOLS)) & (numbers == np.floor(numbers))))
    if len(bad):
        expected = f"an atomic number from 0 to {len(SYMBOLS) - 1}, got {numbers[bad[0]]:g}"
        raise ValueError(f"molecule: elements[{bad[0]}] must be {expected}")
    return numbers.astype(np.int64)


# Unit cells of crystals from lengths and angles


def cell_vectors(a: float, b: float, c: float, alpha: float, beta: float, gamma: float) -> FloatArray | None:
    """Return the edges of a cell as rows (3, 3), the first along x, the second in the plane of x and y.

    Source: IUCr, International Tables for Crystallography B, 3.3.1.

    Parameters
    ----------
    a, b, c
        Lengths of the edges in Å.
    alpha, beta, gamma
        Angles in degrees: alpha between b and c, beta between a and c, gamma between a and b.

    Returns
    -------
    array or None
        None if the numbers make no cell.

    """
    if not all(math.isfinite(v) and v > 0 for v in (a, b, c)) or not all(0 < v < 180 for v in (alpha, beta, gamma)):
        return None
    cosines = [sin_cos_degrees(angle)[1] for angle in (alpha, beta, gamma)]
    sine = sin_cos_degrees(gamma)[0]
    across = (cosines[0] - cosines[1] * cosines[2]) / sine
    rest = 1 - cosines[1] ** 2 - across**2
    if not rest > 0:  # the three angles do not fit together
        return None
    return np.array(
        [(a, 0, 0), (b * cosines[2], b * sine, 0), (c * cosines[1], c * across, c * math.sqrt(rest))], np.float64
    )


# Other libraries' objects, recognised by their attributes and not by their class, so that no library is imported:
# ASE (`get_positions`), biotite (`coord`), MDAnalysis (`atoms.positions`), RDKit (`GetConformer`), gemmi (`cell`, and
# models or sites). Other objects need `positions` and one of `numbers`, `elements` and `symbols`.


def read_atoms_object(source: Any) -> Atoms:
    """Return the atoms of an object of ASE, biotite, MDAnalysis, RDKit, gemmi, or with `positions` and elements.

    Raise TypeError for other objects, and ValueError for wrong values.
    """
    if hasattr(source, "GetConformer") and hasattr(source, "GetAtoms"):
        return _from_rdkit(source)
    if hasattr(source, "get_positions") and hasattr(source, "get_atomic_numbers"):
        return _from_ase(source)
    if hasattr(source, "coord") and hasattr(source, "element"):
        return _from_biotite(source)
    if hasattr(source, "atoms") and hasattr(source.atoms, "positions"):
        return _from_mdanalysis(source)
    if hasattr(source, "get_all_unit_cell_sites") or (hasattr(source, "cell") and hasattr(source, "spacegroup_hm")):
        return read_gemmi_atoms(source)
    if hasattr(source, "positions"):
        for name in ("numbers", "elements", "symbols"):
            if getattr(source, name, None) is not None:
                return Atoms(source.positions, np.asarray(getattr(source, name)))
    expected = "a file's path, positions with elements, or an object of ASE, biotite, MDAnalysis, RDKit or gemmi"
    raise TypeError(f"molecule: atoms must be {expected}, got {describe_kind(source)}")


def _from_ase(source: Any) -> Atoms:
    # ASE has a cell of zeros for molecules
    cell = np.asarray(source.cell) if np.any(source.pbc) and abs(np.linalg.det(np.asarray(source.cell))) > 0 else None
    return Atoms(source.get_positions(), source.get_atomic_numbers(), cell=cell)


def _from_biotite(source: Any) -> Atoms:
    coord = np.asarray(source.coord)
    remarks: tuple[str, ...] = ()
    if coord.ndim == 3:
        # A stack of models, as of an NMR structure: all of them in one picture would overlap
        coord, remarks = coord[0], ("the first of several models is read",) if len(coord) > 1 else ()
    box = getattr(source, "box", None)
    box = box[0] if box is not None and np.ndim(box) == 3 else box
    bonds = None
    if getattr(source, "bonds", None) is not None:
        bonds = np.asarray(source.bonds.as_array(), np.float64)
        # biotite's bond types: any, single, double, triple, quadruple, then aromatic single, double, triple, and other
        bonds[:, 2] = np.array([1, 1, 2, 3, 4, 1.5, 1.5, 3, 1, 1.5])[np.minimum(bonds[:, 2].astype(int), 9)]
    labels: tuple[str, ...] = ()
    if hasattr(source, "atom_name") and hasattr(source, "res_name"):
        columns = (source.atom_name, source.res_name, source.res_id, source.chain_id)
        labels = tuple(f"{a} {r} {n} {c}".strip() for a, r, n, c in zip(*columns, strict=True))
    return Atoms(coord, np.asarray(source.element), bonds, box, labels, remarks)


def _from_mdanalysis(source: Any) -> Atoms:
    group = source.atoms
    for name in ("elements", "types", "names"):
        elements = getattr(group, name, None)
        if elements is not None:
            break
    else:
        raise ValueError("molecule: atoms must have elements: universe.guess_TopologyAttrs(to_guess=['elements'])")
    bonds = None
    if getattr(group, "bonds", None) is not None and len(group.bonds):
        place = {index: k for k, index in enumerate(np.asarray(group.indices).tolist())}
        # Indices within the whole universe; a group may have only some of its atoms
        pairs = np.asarray(group.bonds.indices).tolist()
        bonds = [(place[a], place[b]) for a, b in pairs if a in place and b in place]
    size = getattr(group, "dimensions", None)
    return Atoms(
        group.positions, np.asarray(elements), bonds, None if size is None else cell_vectors(*map(float, size))
    )


def _from_rdkit(source: Any) -> Atoms:
    numbers = [atom.GetAtomicNum() for atom in source.GetAtoms()]
    bonds = [(b.GetBeginAtomIdx(), b.GetEndAtomIdx(), b.GetBondTypeAsDouble() or 1.0) for b in source.GetBonds()]
    try:
        positions = source.GetConformer().GetPositions()
    except ValueError:
        expected = "must have a conformer: rdkit.Chem.AllChem.EmbedMolecule(molecule) makes one"
        raise ValueError(f"molecule: atoms {expected}") from None
    return Atoms(positions, np.array(numbers, np.int64), bonds)


def share_remarks(shares: Any) -> list[str]:
    """Return a remark on atoms that are in some copies of a molecule only, and have no alternate place."""
    count = int(((shares > 0) & (shares < 1)).sum())
    return [f"{format_count(count, 'atom')} of an occupancy below 1 shown as a whole"] if count else []


def read_gemmi_atoms(structure: Any) -> Atoms:
    """Return the atoms of a gemmi Structure or SmallStructure.

    Of a Structure the first model and the first of alternate positions are read; of a SmallStructure all sites of the
    unit cell, of its disorder groups the first, and those that no other excludes.
    """
    parameters = structure.cell.parameters
    # Lengths 1 1 1 stand for no cell.
    cell = None if parameters[:3] == (1.0, 1.0, 1.0) else cell_vectors(*parameters)
    # A small structure lists the asymmetric unit only; symmetry makes the others
    if hasattr(structure, "get_all_unit_cell_sites"):
        group = next((site.disorder_group for site in structure.sites if site.disorder_group > 0), 0)
        # Groups below 0 exclude only their own images by symmetry
        others = [site for site in structure.sites if site.disorder_group > 0 and site.disorder_group != group]
        unknown = [site for site in structure.sites if not site.element.atomic_number]
        left_out = (unknown, "without an element"), (others, f"of other disorder groups than {group}")
        notes = [f"{format_count(len(some), 'site')} {text} left out" for some, text in left_out if some]

        def is_shown(site: Any) -> bool:
            return site.element.atomic_number > 0 and (site.disorder_group <= 0 or site.disorder_group == group)

        notes += share_remarks(np.array([site.occ for site in structure.sites if is_shown(site)]))
        sites = [site for site in structure.get_all_unit_cell_sites() if is_shown(site)]
        within = np.array([site.fract.tolist() for site in sites]).reshape(-1, 3)
        within -= np.floor(within + 1e-9)  # symmetry may put sites beside the cell: move them into it
        places = within @ np.array(structure.cell.orth.mat.tolist()).T
        numbers = np.array([site.element.atomic_number for site in sites], np.int64)
        return Atoms(places, numbers, cell=cell, labels=tuple(site.label for site in sites), remarks=tuple(notes))
    remarks = ("the first of several models is read",) if len(structure) > 1 else ()
    rows, skipped = [], 0
    for chain in structure[0] if len(structure) else ():
        for residue in chain:
            keys = set()
            for atom in residue:
                # Crystallographers list an atom that is in two places twice; both would be bonded to each other
                if atom.altloc != "\0" and atom.name in keys:
                    skipped += 1
                    continue
                keys.add(atom.name)
                label = f"{atom.name} {residue.name} {residue.seqid} {chain.name}"
                rows.append((atom.pos.x, atom.pos.y, atom.pos.z, atom.element.atomic_number, label))
    if skipped:
        remarks = (*remarks, f"{skipped:,} alternate places of atoms are left out")
    places = np.array([row[:3] for row in rows]).reshape(-1, 3)
    numbers = np.array([row[3] for row in rows], np.int64)
    return Atoms(places, numbers, None, cell, tuple(row[4] for row in rows), remarks)
