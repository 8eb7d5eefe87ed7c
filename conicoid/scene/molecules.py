"""Molecules and crystals: atoms as data, which become scenes in several styles."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import with_attribute_hints
from .._util.hints import check_choice, with_method_hints
from .._util.validation import check_flag, check_nonnegative, check_positive, format_value
from ..geometry.body import Body
from ..geometry.primitives import Sphere
from ..geometry.shape import Union
from ..io.molecules.atoms import SYMBOLS, VAN_DER_WAALS_RADII, Atoms, atomic_number, read_atoms_object
from ..io.molecules.importer import read_atoms
from ..io.molecules.styles import STYLES, MoleculeStyle, StyleName, build_molecule_bodies
from .scene import Scene

_NOTHING: Mapping[str, Any] = {}


@with_attribute_hints
@with_method_hints
class Molecule(Atoms):
    """Atoms of a molecule or a crystal, in Å; `co.molecule` makes one of files and of other libraries' objects.

    positions: (N, 3). numbers: (N,) atomic numbers, 0 for no known element. bonds: (M, 3), two atoms and the order of
    their bond. cell: (3, 3), the edges of a crystal's unit *cell* as rows, the box that repeats, or None.
    given_bonds: those that are given, None where `bonds` go by distance.
    labels: what each atom is called, such as "CA LEU 12 A". remarks: what there is to say of how they were read.
    symbols, formula: of the elements.

    In a notebook it shows itself.
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
        """Bodies for a scene: the balls of all atoms in one entry, then sticks in one, then the edges of the cell.

        In a scene that begins with them body k is atom k: `molecule.labels[hits.body]`. The materials are called as the
        elements.

        style: "space filling", balls of van der Waals' radii (Alvarez 2013); "ball and stick", balls of a quarter of
            that; "licorice", sticks alone with round ends. Two halves of a stick meet in its middle; double bonds are
            two sticks.
        radii: other radii of balls, in Å, by symbol.
        colors: by symbol, colours or materials in place of the usual colours (those of Jmol).
        cell: are the edges of the unit cell shown, where there is one?
        name: of the molecule, which its entries begin with: "water" makes "water atoms" and "water bonds".

        Raises ValueError for a style or a symbol that there is not.
        """
        check_choice("molecule", "style", style, STYLES)
        check_flag("molecule", "cell", cell)
        for field, given in (("radii", radii), ("colors", colors)):
            for symbol in given:
                if not isinstance(symbol, str) or symbol not in SYMBOLS:
                    raise ValueError(f"molecule: {field} must be by symbols such as 'C', got {format_value(symbol)}")
        checked = {symbol: check_positive("molecule", f"radii[{symbol!r}]", radius) for symbol, radius in radii.items()}
        return build_molecule_bodies(
            self, MoleculeStyle(style, checked, dict(colors), "" if name is None else f"{name} "), cell
        )

    def scene(self, style: StyleName = "ball and stick", **options: Any) -> Scene:
        """`bodies(style, ...)` as a scene.

        style: "space filling", "ball and stick" or "licorice".
        options: those of `bodies`: radii, colors, cell, name.
        """
        return Scene(self.bodies(style, **options))

    @ignore_fp_errors
    def solvent_accessible(self, probe: float = 1.4) -> Union | Sphere:
        """One solid: all that is nearer to an atom than its radius of van der Waals and a probe's.

        Its surface is where the middle of a ball of a solvent can be (Lee and Richards 1971). `co.measure` has its
        volume and area, rays its walls, and `Body(...)` gives it a material. Some thousands of atoms take seconds.

        probe: the radius of a molecule of the solvent, in Å; 1.4 is water's.

        Raises ValueError where there are no atoms.
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
def molecule(atoms: Any, elements: Any = None, *, bonds: Any = None, cell: Any = None) -> Molecule:
    """A molecule, of a file, of positions and elements, or of another library's object.

    atoms: the path of an XYZ, PDB, mmCIF or CIF file; positions (N, 3) in Å; or an object of ASE, biotite, MDAnalysis,
        RDKit or gemmi, which are known by what they have.
    elements: with positions, (N,) symbols such as "C", or atomic numbers.
    bonds: (M, 2) indices of bonded atoms, or (M, 3) with orders 1, 1.5, 2 or 3, in place of what the atoms say
        themselves or, where they say nothing, of those by distance.
    cell: (3, 3), the edges of a crystal's unit *cell* as rows, the box that repeats, in place of what atoms say.

    Raises TypeError for what has no atoms, ValueError that names the field and the atom, SceneFileError with the line
    of a file, ImportError where a CIF is to be read without gemmi.
    """
    if elements is not None:
        if isinstance(elements, str) and atomic_number(elements) is not None:
            elements = np.full(len(np.atleast_2d(atoms)), elements)
        found = Atoms(atoms, elements)
    elif isinstance(atoms, Atoms):
        found = atoms
    elif isinstance(atoms, str | os.PathLike):
        found = read_atoms(atoms)
    elif isinstance(atoms, np.ndarray | list | tuple):
        raise TypeError("molecule: positions need elements: co.molecule(positions, ['C', 'O', 'O'])")
    else:
        found = read_atoms_object(atoms)
    return Molecule(
        found.positions,
        found.numbers,
        found.given_bonds if bonds is None else bonds,
        found.cell if cell is None else cell,
        found.labels,
        found.remarks,
    )
