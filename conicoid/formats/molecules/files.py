"""Files of molecules: XYZ, PDB, mmCIF and CIF, known by their content."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ..imports.formats import HEAD
from .atoms import Atoms
from .cif import read_cif
from .detection import is_cif, is_pdb, is_xyz
from .pdb import read_pdb
from .xyz import read_xyz

_READERS: tuple[tuple[Callable[[str, str], bool], Callable[[Path], Atoms]], ...] = (
    (is_cif, read_cif), (is_pdb, read_pdb), (is_xyz, read_xyz),
)  # fmt: skip


def read_atoms(path: str | os.PathLike[str]) -> Atoms:
    """The atoms in a file. Raises SceneFileError with lines, OSError, and ValueError for a file of another kind."""
    with open(path, "rb") as file:
        head = file.read(HEAD).decode("utf-8", "replace")
    for recognises, read in _READERS:
        if recognises(head, Path(path).suffix.lower()):
            return read(Path(path))
    raise ValueError(f"{os.fspath(path)}: is no XYZ, PDB, mmCIF or CIF file")
