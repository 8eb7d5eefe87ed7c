"""Atoms as bodies: balls of van der Waals' radii, balls and sticks, licorice; and the edges of a unit cell.

The balls of all atoms come first, as one entry, so that body k is atom k. A bond is two rods that meet in its middle,
each in the colour of its atom, and follow the balls; double bonds are two such pairs side by side, triple ones three.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from ..._util.arrays import FloatArray
from ...geometry.body import Body
from ...geometry.bulk import Spheres
from ...geometry.bulk_shapes import Capsules, Cylinders
from ...materials.material import Material, rename_material
from ...materials.presets import as_material, lacquer
from .atoms import ELEMENT_COLORS, SYMBOLS, VAN_DER_WAALS_RADII, Atoms

StyleName: TypeAlias = Literal["space filling", "ball and stick", "licorice"]
STYLES: tuple[StyleName, ...] = get_args(StyleName)

BALL = 0.25
"""Of balls on sticks: their radius as a share of van der Waals'."""
STICK = 0.12
LICORICE = 0.2
EDGE = 0.04
"""Radii of sticks, licorice and edges of a cell, in Å."""
_APART = 1.3
"""How far rods of one bond lie from its middle, in their radii, and how thick they are as a share of a single one."""
_THIN = 0.55


@dataclass(frozen=True)
class MoleculeStyle:
    """How a molecule is shown: its style, and what is not as usual.

    radii: of balls by symbol, in Å. colors: by symbol: colours or materials. prefix: of names.
    """

    style: StyleName
    radii: Mapping[str, float]
    colors: Mapping[str, Any]
    prefix: str = ""


def build_molecule_bodies(atoms: Atoms, look: MoleculeStyle, with_cell: bool) -> list[Body]:
    """The bodies of atoms: an entry for all balls, one for all rods, one for the cell."""
    if not len(atoms):
        return []
    kinds, index = np.unique(atoms.numbers, return_inverse=True)
    materials = [element_material(int(number), look.colors) for number in kinds]
    paint: dict[str, Any] = dict(materials=materials)
    found = [
        Body(Spheres(atoms.positions, _radii(atoms, look)), **paint, material_index=index, name=f"{look.prefix}atoms")
    ]
    if look.style != "space filling" and len(atoms.bonds):
        ends, radii, owner = build_rods(
            atoms, LICORICE if look.style == "licorice" else STICK, look.style == "licorice"
        )
        sticks = Cylinders(ends[:, 0], ends[:, 1], radii)
        found.append(Body(sticks, **paint, material_index=index[owner], name=f"{look.prefix}bonds"))
    if with_cell and atoms.cell is not None:
        found.append(Body(cell_edges(atoms.cell), lacquer("#8c8c8c"), name=f"{look.prefix}cell"))
    return found


def element_material(number: int, colors: Mapping[str, Any]) -> Material:
    """The material of an element: its name is the symbol."""
    symbol = SYMBOLS[number]
    given = colors.get(symbol)
    if given is None:
        return lacquer(ELEMENT_COLORS[number], name=symbol, properties=dict(element=symbol, number=number))
    made = as_material("molecule", given)
    return made if made.name else rename_material(made, symbol)


def _radii(atoms: Atoms, look: MoleculeStyle) -> FloatArray:
    """(N,) radii of balls."""
    usual = np.full(len(SYMBOLS), LICORICE) if look.style == "licorice" else VAN_DER_WAALS_RADII.copy()
    if look.style == "ball and stick":
        usual *= BALL
    for symbol, radius in look.radii.items():
        usual[SYMBOLS.index(symbol)] = radius
    return np.asarray(usual[atoms.numbers])


def build_rods(atoms: Atoms, radius: float, single: bool) -> tuple[FloatArray, FloatArray, Any]:
    """(ends (R, 2, 3), radii (R,), whose colour each has (R,)): two halves for each line of each bond.

    single: one line for a bond of any order.
    """
    bonds = atoms.bonds
    pairs, order = bonds[:, :2].astype(np.int64), np.ones(len(bonds)) if single else np.ceil(bonds[:, 2] - 0.25)
    ends, radii, owners = [], [], []
    for lines in (1, 2, 3):
        these = pairs[order == lines] if lines < 3 else pairs[order >= 3]
        if not len(these):
            continue
        thin = radius if lines == 1 else radius * _THIN
        side = _sideways(atoms, these) if lines > 1 else np.zeros((len(these), 3))
        for k in range(lines):
            shift = side * ((2 * k - lines + 1) * _APART * thin * (1.0 if lines == 2 else 0.9))
            points = atoms.positions[these] + shift[:, None]
            middle = points.mean(axis=1)
            ends.append(np.concatenate([np.stack([points[:, i], middle], axis=1) for i in (0, 1)]))
            radii.append(np.full(2 * len(these), thin))
            owners.append(np.concatenate([these[:, 0], these[:, 1]]))
    return np.concatenate(ends), np.concatenate(radii), np.concatenate(owners)


def _sideways(atoms: Atoms, pairs: Any) -> FloatArray:
    """(M, 3) unit vectors across bonds, in the plane of a third atom that is bonded to one of the two, if one is."""
    near: dict[int, list[int]] = {}
    for i, k in atoms.bonds[:, :2].astype(np.int64).tolist():
        near.setdefault(i, []).append(k)
        near.setdefault(k, []).append(i)
    found = np.empty((len(pairs), 3))
    for row, (i, k) in enumerate(pairs.tolist()):
        along = atoms.positions[k] - atoms.positions[i]
        along = along / np.linalg.norm(along)
        thirds = [atoms.positions[n] - atoms.positions[i] for n in (*near[i], *near[k]) if n not in (i, k)]
        across = [third - along * (third @ along) for third in (*thirds, *np.eye(3)[np.argsort(np.abs(along))])]
        best = next(vector for vector in across if vector @ vector > 1e-4)
        found[row] = best / np.linalg.norm(best)
    return found


def cell_edges(cell: FloatArray) -> Capsules:
    """The twelve edges of a unit cell from the origin."""
    a, b, c = cell
    zero = np.zeros(3)
    edges = [(start, start + a) for start in (zero, b, c, b + c)]
    edges += [(start, start + b) for start in (zero, a, c, a + c)]
    edges += [(start, start + c) for start in (zero, a, b, a + b)]
    begin, end = (np.array([edge[k] for edge in edges]) for k in (0, 1))
    return Capsules(begin, end, EDGE)
