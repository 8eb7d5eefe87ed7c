"""Atoms as data: where they are, which elements, what is bonded to what."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...shapes.arrays import real_array
from ...shapes.calm import calm
from ...shapes.fixed import fixed
from ...shapes.validate import DOMAIN, outside_domain, shown
from ...shapes.vector import FloatArray
from .bonds import bonds_by_distance, checked_bonds
from .elements import SYMBOLS, number_of


@fixed
@dataclass(frozen=True, eq=False)
class Atoms:
    """Atoms of a molecule or a crystal, in Å.

    positions: (N, 3). numbers: (N,) atomic numbers, or symbols such as "C"; 0 and "X" are of no known element.
    given_bonds: (M, 2) indices of bonded atoms, or (M, 3) with the order of each bond (1, 1.5, 2 or 3); None where
        nothing is said, and `bonds` go by distance. cell: (3, 3), the edges of a unit cell as rows, or None.
    labels: what each atom is called in its file, such as "CA LEU 12 A"; empty where it is not said.
    remarks: what there is to say of how they were read.

    Raises ValueError that names the field and the atom.
    """

    positions: Any
    numbers: Any
    given_bonds: Any = None
    cell: Any = None
    labels: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @calm
    def __post_init__(self) -> None:
        positions = np.array(real_array("molecule", "atoms", self.positions))
        if positions.size == 0:
            positions = positions.reshape(0, 3)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise ValueError(f"molecule: atoms must have positions of shape (N, 3), got {positions.shape}")
        for wrong, expected in ((~np.isfinite(positions), "finite"), (outside_domain(positions), DOMAIN)):
            bad = np.flatnonzero(wrong.any(axis=1))
            if len(bad):
                raise ValueError(f"molecule: atoms[{bad[0]}] must be {expected}, got {positions[bad[0]].tolist()}")
        numbers = _numbers(self.numbers, len(positions))
        bonds = None if self.given_bonds is None else checked_bonds(self.given_bonds, len(positions))
        cell = None if self.cell is None else np.array(real_array("molecule", "cell", self.cell))
        if cell is not None and (cell.shape != (3, 3) or not np.isfinite(cell).all()):
            raise ValueError(f"molecule: cell must be three finite vectors, (3, 3), got {shown(self.cell)}")
        for name, value in (("positions", positions), ("numbers", numbers), ("given_bonds", bonds), ("cell", cell)):
            if value is not None:
                value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "labels", tuple(self.labels))
        object.__setattr__(self, "remarks", tuple(self.remarks))

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def bonds(self) -> FloatArray:
        """(M, 3): the indices of two bonded atoms, the first the smaller, and the order of their bond.

        Where none are given two atoms are bonded that are no further apart than the sum of their covalent radii and
        0.45 Å, and by 0.4 Å or more (E. C. Meng and R. A. Lewis, J. Comput. Chem. 12 (1991), 891), all of order 1.
        """
        if self.given_bonds is not None:
            found: FloatArray = self.given_bonds
            return found
        pairs = bonds_by_distance(self.positions, self.numbers)
        return np.column_stack([pairs, np.ones(len(pairs))])

    @property
    def symbols(self) -> list[str]:
        """The symbol of each atom's element."""
        return [SYMBOLS[number] for number in self.numbers.tolist()]

    @property
    def formula(self) -> str:
        """How many atoms of each element there are, as Hill writes it: C8H10N4O2."""
        counts = {SYMBOLS[n]: c for n, c in zip(*_counts(self.numbers), strict=True)}
        first = [name for name in ("C", "H") if name in counts and "C" in counts]
        rest = sorted(name for name in counts if name not in first)
        return "".join(f"{name}{counts[name] if counts[name] > 1 else ''}" for name in (*first, *rest))


def _counts(numbers: Any) -> tuple[list[int], list[int]]:
    values, counts = np.unique(numbers, return_counts=True)
    return values.tolist(), counts.tolist()


def _numbers(given: Any, count: int) -> Any:
    """Atomic numbers (N,) of numbers or symbols."""
    values = np.asarray(given)
    if values.shape != (count,):
        raise ValueError(f"molecule: elements must have shape ({count},), as there are positions, got {values.shape}")
    if values.dtype.kind in "USO" and count:
        different, place = np.unique(np.array([str(value) for value in values.tolist()]), return_inverse=True)
        known = [number_of(symbol) for symbol in different.tolist()]
        if None in known:
            wrong = str(different[known.index(None)])
            where = int(np.flatnonzero(place == known.index(None))[0])
            raise ValueError(f"molecule: elements[{where}] must be an element's symbol or number, got {shown(wrong)}")
        return np.array(known, np.int64)[place]
    numbers = np.array(real_array("molecule", "elements", values)).reshape(count)
    bad = np.flatnonzero(~((numbers >= 0) & (numbers < len(SYMBOLS)) & (numbers == np.floor(numbers))))
    if len(bad):
        told = f"an atomic number from 0 to {len(SYMBOLS) - 1}, got {numbers[bad[0]]:g}"
        raise ValueError(f"molecule: elements[{bad[0]}] must be {told}")
    return numbers.astype(np.int64)
