"""Styles of molecules: atoms as bodies (space filling, ball and stick, licorice), and the edges of a unit cell.

The balls of all atoms come first, as one entry, so that body k is atom k. The rods of bonds follow: a bond is two rods
that meet in its middle, each in the colour of its atom; a double bond is two such pairs side by side, a triple bond
three.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.body import Body
from ...geometry.bulk import Capsules, Cylinders, Spheres
from ...materials.material import Material, rename_material
from ...materials.presets import as_material, lacquer
from .atoms import ELEMENT_COLORS, SYMBOLS, VAN_DER_WAALS_RADII, Atoms

StyleName: TypeAlias = Literal["space filling", "ball and stick", "licorice"]
STYLES: tuple[StyleName, ...] = get_args(StyleName)

BALL = 0.25
"""Radius of balls on sticks, as a share of the van der Waals radius."""
STICK = 0.12
LICORICE = 0.2
EDGE = 0.04
"""Radii of sticks, licorice and edges of a cell, in Å."""
_ROD_OFFSET = 1.3
"""Distance of the two rods of a double bond from its middle line, in their radii."""
_THIN = 0.55
"""Radius of the rods of double and triple bonds, as a share of that of a single bond."""


@dataclass(frozen=True)
class MoleculeStyle:
    """The look of a molecule.

    Parameters
    ----------
    style
        The style.
    radii
        Radii of balls by symbol, in Å, in place of the usual ones.
    colors
        Colours or materials by symbol, in place of the usual ones.
    prefix
        Text before the names of entries.

    """

    style: StyleName
    radii: Mapping[str, float]
    colors: Mapping[str, Any]
    prefix: str = ""


def build_molecule_bodies(atoms: Atoms, look: MoleculeStyle, with_cell: bool) -> list[Body]:
    """Return the bodies of atoms: an entry for all balls, one for all rods, one for the cell.

    Parameters
    ----------
    atoms
        The atoms.
    look
        The look of balls and rods.
    with_cell
        Whether to add the edges of the unit cell, if there is one.

    """
    if not len(atoms):
        return []
    kinds, index = np.unique(atoms.numbers, return_inverse=True)
    materials = [element_material(int(number), look.colors) for number in kinds]
    paint: dict[str, Any] = dict(materials=materials)
    bodies = [
        Body(Spheres(atoms.positions, _radii(atoms, look)), **paint, material_index=index, name=f"{look.prefix}atoms")
    ]
    if look.style != "space filling" and len(atoms.bonds):
        ends, radii, owner = build_rods(
            atoms, LICORICE if look.style == "licorice" else STICK, look.style == "licorice"
        )
        sticks = Cylinders(ends[:, 0], ends[:, 1], radii)
        bodies.append(Body(sticks, **paint, material_index=index[owner], name=f"{look.prefix}bonds"))
    if with_cell and atoms.cell is not None:
        bodies.append(Body(cell_edges(atoms.cell), lacquer("#8c8c8c"), name=f"{look.prefix}cell"))
    return bodies


def element_material(number: int, colors: Mapping[str, Any]) -> Material:
    """Return the material of an element, named by its symbol unless `colors` has a named material for it."""
    symbol = SYMBOLS[number]
    color = colors.get(symbol)
    if color is None:
        return lacquer(ELEMENT_COLORS[number], name=symbol, properties=dict(element=symbol, number=number))
    material = as_material("molecule", color)
    return material if material.name else rename_material(material, symbol)


def _radii(atoms: Atoms, look: MoleculeStyle) -> FloatArray:
    """Return the radii of balls (N,)."""
    by_element = np.full(len(SYMBOLS), LICORICE) if look.style == "licorice" else VAN_DER_WAALS_RADII.copy()
    if look.style == "ball and stick":
        by_element *= BALL
    for symbol, radius in look.radii.items():
        by_element[SYMBOLS.index(symbol)] = radius
    return np.asarray(by_element[atoms.numbers])


def build_rods(atoms: Atoms, radius: float, single: bool) -> tuple[FloatArray, FloatArray, Any]:
    """Return the rods of bonds: two half rods for each line of each bond.

    Parameters
    ----------
    atoms
        The atoms.
    radius
        Radius of the rod of a single bond, in Å.
    single
        Whether bonds of any order have one line.

    Returns
    -------
    tuple
        Ends (R, 2, 3), radii (R,), and the atoms (R,) whose colours the rods have.

    """
    bonds = atoms.bonds
    # Aromatic bonds, of order 1.5, are drawn as double ones
    pairs, order = bonds[:, :2].astype(np.int64), np.ones(len(bonds)) if single else np.ceil(bonds[:, 2] - 0.25)
    ends, radii, owners = [], [], []
    for lines in (1, 2, 3):
        these = pairs[order == lines] if lines < 3 else pairs[order >= 3]
        if not len(these):
            continue
        thin = radius if lines == 1 else radius * _THIN
        side = _sideways(atoms, these) if lines > 1 else np.zeros((len(these), 3))
        for k in range(lines):
            shift = side * ((2 * k - lines + 1) * _ROD_OFFSET * thin * (1.0 if lines == 2 else 0.9))
            points = atoms.positions[these] + shift[:, None]
            # Half rods meet in the middle, each in its atom's colour
            middle = points.mean(axis=1)
            ends.append(np.concatenate([np.stack([points[:, i], middle], axis=1) for i in (0, 1)]))
            radii.append(np.full(2 * len(these), thin))
            owners.append(np.concatenate([these[:, 0], these[:, 1]]))
    return np.concatenate(ends), np.concatenate(radii), np.concatenate(owners)


def _sideways(atoms: Atoms, pairs: Any) -> FloatArray:
    """Return unit vectors across bonds (M, 3), in the plane of a third atom bonded to one of the two, if any."""
    near: dict[int, list[int]] = {}
    for i, k in atoms.bonds[:, :2].astype(np.int64).tolist():
        near.setdefault(i, []).append(k)
        near.setdefault(k, []).append(i)
    vectors = np.empty((len(pairs), 3))
    for row, (i, k) in enumerate(pairs.tolist()):
        along = atoms.positions[k] - atoms.positions[i]
        along = along / np.linalg.norm(along)
        thirds = [atoms.positions[n] - atoms.positions[i] for n in (*near[i], *near[k]) if n not in (i, k)]
        across = [third - along * (third @ along) for third in (*thirds, *np.eye(3)[np.argsort(np.abs(along))])]
        # A third atom may lie on the line of the bond; one of the axes never does.
        best = next(vector for vector in across if vector @ vector > 1e-4)
        vectors[row] = best / np.linalg.norm(best)
    return vectors


def cell_edges(cell: FloatArray) -> Capsules:
    """Return the twelve edges of a unit cell with a corner at the origin; `cell` has its edges as rows (3, 3)."""
    a, b, c = cell
    zero = np.zeros(3)
    edges = [(start, start + a) for start in (zero, b, c, b + c)]
    edges += [(start, start + b) for start in (zero, a, c, a + c)]
    edges += [(start, start + c) for start in (zero, a, b, a + b)]
    begin, end = (np.array([edge[k] for edge in edges]) for k in (0, 1))
    return Capsules(begin, end, EDGE)
