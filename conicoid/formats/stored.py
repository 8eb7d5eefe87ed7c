"""Arrays whose numbers lie in files, written into files of arrays without being held."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import IO, Any

import numpy as np

from .atomic import replacing

_PIECE = 1 << 20  # items


@dataclass(frozen=True)
class Stored:
    """An array: the numbers of its columns one after the other, as rows of a first axis where they are several."""

    columns: tuple[np.ndarray[Any, Any], ...]
    shape: tuple[int, ...]

    @property
    def dtype(self) -> Any:
        return self.columns[0].dtype


def write_npz(path: str | os.PathLike[str], arrays: Mapping[str, Stored], more: Mapping[str, Any]) -> None:
    """A .npz file of stored arrays and of some in memory. It appears whole or not at all; raises OSError."""
    with (
        replacing(path) as partial,
        zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED, allowZip64=True) as archive,
    ):
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write(member, array)
        for name, values in more.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.asanyarray(values), allow_pickle=False)


def write_npy(path: str | os.PathLike[str], array: Stored) -> None:
    """A .npy file of a stored array. It appears whole or not at all; raises OSError."""
    with replacing(path) as partial, partial.open("wb") as file:
        _write(file, array)


def _write(file: IO[bytes], array: Stored) -> None:
    """An array as .npy files and members of .npz files have it."""
    kind = np.lib.format.dtype_to_descr(array.dtype)
    np.lib.format.write_array_header_1_0(file, dict(descr=kind, fortran_order=False, shape=array.shape))
    for column in array.columns:
        flat = column.reshape(-1)
        for begin in range(0, len(flat), _PIECE):
            file.write(np.ascontiguousarray(flat[begin : begin + _PIECE]).tobytes())
