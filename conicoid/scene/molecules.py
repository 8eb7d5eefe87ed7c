"""Molecules and crystals: atoms as data, which become scenes in several styles."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.records import ignore_fp_errors
from .._util.text import check_choice
from .._util.validation import check_flag, check_nonnegative, check_positive, format_value
from ..geometry.body import Body
from ..geometry.primitives import Sphere
from ..geometry.shape import Union
from ..io.molecules.atoms import SYMBOLS, VAN_DER_WAALS_RADII, Atoms, atomic_number, read_atoms_object
from ..io.molecules.importer import read_atoms
from ..io.molecules.styles import STYLES, MoleculeStyle, StyleName, build_molecule_bodies
from .scene import Scene

_NOTHING: Mapping[str, Any] = {}


class Molecule(Atoms):
    """Atoms of a molecule or a crystal, in Å; `co.molecule` makes one from files and from objects of other libraries.

    A notebook shows it as a scene.

    Attributes
    ----------
    positions : (N, 3)
    numbers : (N,)
        Atomic numbers, 0 for an unknown element.
    bonds : (M, 3)
        Two atoms and the order of their bond.
    given_bonds : (M, 3) or None
        Bonds from the source; None if `bonds` follow from distances.
    cell : (3, 3) or None
        The edges of the unit *cell* of a crystal, the box that repeats, as rows.
    labels
        The name of each atom, such as "CA LEU 12 A".
    remarks
        Remarks about how the atoms were read.
    symbols, formula
        Of the elements.
    """

    @ignore_fp_errors
    def bodies(
        self,
        style: StyleName = "ball and stick",
        *,
        radii: Mapping[str, float] = _NOTHING,
        colors: Mapping[str, Any] = _NOTHING,
        cell: bool = True,
        name: str | None = None,
    ) -> list[Body]:
        """Return bodies for a scene: balls of all atoms in one entry, then sticks in one, then the edges of the cell.

        In a scene that begins with them body k is atom k: `molecule.labels[hits.body]`. The materials have the names of
        the elements.

        Parameters
        ----------
        style : {"space filling", "ball and stick", "licorice"}
            Balls of van der Waals radii (Alvarez 2013); balls of a quarter of these radii, with sticks; or sticks alone
            with round ends. The two halves of a stick meet in its middle; a double bond is two sticks.
        radii : mapping
            From symbols to other radii of balls, in Å.
        colors : mapping
            From symbols to colours or materials, in place of the usual colours (those of Jmol).
        cell : bool
            Show the edges of the unit cell, if there is one.
        name : str, optional
            The name of the molecule, with which the names of its entries begin: "water" makes "water atoms" and "water
            bonds".

        Raises
        ------
        ValueError
            For an unknown style or symbol.
        """
        check_choice("molecule", "style", style, STYLES)
        check_flag("molecule", "cell", cell)
        for field, by_symbol in (("radii", radii), ("colors", colors)):
            for symbol in by_symbol:
                if not isinstance(symbol, str) or symbol not in SYMBOLS:
                    raise ValueError(f"molecule: {field} must be by symbols such as 'C', got {format_value(symbol)}")
        ball_radii = {
            symbol: check_positive("molecule", f"radii[{symbol!r}]", radius) for symbol, radius in radii.items()
        }
        return build_molecule_bodies(
            self, MoleculeStyle(style, ball_radii, dict(colors), "" if name is None else f"{name} "), cell
        )

    def scene(self, style: StyleName = "ball and stick", **options: Any) -> Scene:
        """Return the scene of `bodies(style, ...)`.

        Parameters
        ----------
        style : {"space filling", "ball and stick", "licorice"}
            As for `bodies`.
        **options
            Those of `bodies`: radii, colors, cell, name.
        """
        return Scene(self.bodies(style, **options), unit="angstrom")

    @ignore_fp_errors
    def solvent_accessible(self, probe: float = 1.4) -> Union | Sphere:
        """Return one solid: all points nearer to an atom than its van der Waals radius plus that of a probe.

        Its surface is where the centre of a ball of a solvent can be (Lee and Richards 1971). `co.measure` computes its
        volume and area, rays hit its walls, and `Body(...)` gives it a material. Some thousands of atoms take seconds.

        Parameters
        ----------
        probe : float
            The radius of a molecule of the solvent, in Å; 1.4 is that of water.

        Raises
        ------
        ValueError
            For a molecule without atoms.
        """
        reach = VAN_DER_WAALS_RADII[self.numbers] + check_nonnegative("molecule", "probe", probe)
        if not len(self):
            raise ValueError("molecule: has no atoms, and so no surface")
        balls = [Sphere(r, tuple(p)) for r, p in zip(reach.tolist(), self.positions.tolist(), strict=True)]
        return Union(tuple(balls)) if len(balls) > 1 else balls[0]

    def __repr__(self) -> str:
        return f"Molecule({self.formula:.60}, {len(self):,} atom{'s' if len(self) != 1 else ''})"

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.scene()._repr_mimebundle_(**options)


@ignore_fp_errors
def molecule(
    atoms: Any, elements: npt.ArrayLike | None = None, *, bonds: npt.ArrayLike | None = None, cell: Any = None
) -> Molecule:
    """Return the molecule of a file, of positions and elements, or of an object of another library.

    Parameters
    ----------
    atoms : path, (N, 3) or object
        The path of an XYZ, PDB, mmCIF or CIF file; positions in Å; or an object of ASE, biotite, MDAnalysis, RDKit or
        gemmi, recognised by its attributes.
    elements : (N,), optional
        With positions: symbols such as "C", or atomic numbers.
    bonds : (M, 2) or (M, 3), optional
        Indices of bonded atoms, without or with orders 1, 1.5, 2 or 3. They replace the bonds of `atoms`, or those that
        follow from distances if `atoms` has none.
    cell : (3, 3), optional
        The edges of the unit *cell* of a crystal, the box that repeats, as rows. It replaces the cell of `atoms`.

    Raises
    ------
    TypeError
        For an object without atoms.
    ValueError
        For invalid values, with the field and the atom.
    SceneFileError
        For a mistake in a file, with its line.
    ImportError
        For a CIF file without gemmi.
    """
    if elements is not None:
        if isinstance(elements, str) and atomic_number(elements) is not None:
            # One symbol stands for all atoms
            elements = np.full(len(np.atleast_2d(atoms)), elements)
        source = Atoms(atoms, elements)
    elif isinstance(atoms, Atoms):
        source = atoms
    elif isinstance(atoms, str | os.PathLike):
        source = read_atoms(atoms)
    elif isinstance(atoms, np.ndarray | list | tuple):
        raise TypeError("molecule: positions need elements: co.molecule(positions, ['C', 'O', 'O'])")
    else:
        source = read_atoms_object(atoms)
    return Molecule(
        source.positions,
        source.numbers,
        source.given_bonds if bonds is None else bonds,
        source.cell if cell is None else cell,
        source.labels,
        source.remarks,
    )
