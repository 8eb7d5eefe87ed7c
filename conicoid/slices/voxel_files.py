"""Voxels as files: NumPy's .npz, zarr's folders, VTK's image data by pyevtk, NRRD by pynrrd."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formats.atomic import replacing
from ..shapes.validate import shown

if TYPE_CHECKING:
    from .voxels import Voxels


def write_voxels(path: str | os.PathLike[str], voxels: Voxels) -> None:
    """Write voxels, by the suffix."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in _WRITERS:
        raise ValueError(f"Voxels: voxels are saved as {', '.join(_WRITERS)}, got {shown(os.fspath(path))}")
    _WRITERS[suffix](path, voxels)


def arrays_of(voxels: Voxels) -> dict[str, Any]:
    """What is in the voxels, by name."""
    found = dict(body=voxels.body, material=voxels.material, fractions=voxels.fractions, bounds=voxels.bounds)
    return {name: array for name, array in found.items() if array is not None}


def by_name(voxels: Voxels) -> dict[str, Any]:
    """Arrays (nx, ny, nz) with a name for each; names that are the same, or not of letters, get their number."""
    if voxels.fractions is None or voxels.bounds is None:
        return arrays_of(voxels)
    found: dict[str, Any] = {}
    for k, name in enumerate(voxels.names):
        plain = "".join(letter if letter.isalnum() else "_" for letter in name if letter.isascii())
        plain = plain if plain and plain not in found else f"{plain}_{k}"
        found[plain], found[f"{plain}_bound"] = voxels.fractions[k], voxels.bounds[k]
    return found


def _write_npz(path: Any, voxels: Voxels) -> None:
    arrays: dict[str, Any] = dict(low=voxels.low, high=voxels.high, names=np.array(voxels.names, str))
    arrays |= arrays_of(voxels)
    with replacing(path) as file, file.open("wb") as stream:
        np.savez_compressed(stream, **arrays)


def _write_zarr(path: Any, voxels: Voxels) -> None:
    """A group of arrays in blocks; low, high and names are its attributes. The folder appears whole or not at all."""
    from ..formats.zarr_folder import zarr_module

    zarr = zarr_module()
    folder = Path(path)
    if folder.exists():
        raise FileExistsError(17, "is there already", str(path))
    partial = folder.with_name(f".{folder.stem[:40]}-{secrets.token_hex(4)}.zarr")
    try:
        group = zarr.open_group(str(partial), mode="w")
        group.attrs.update(low=voxels.low.tolist(), high=voxels.high.tolist(), names=list(voxels.names))
        for name, array in arrays_of(voxels).items():
            group.create_array(name, data=array)
        os.rename(partial, folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _write_vti(path: Any, voxels: Voxels) -> None:
    """Image data with the arrays as data of cells. pyevtk writes the file, which it gives the suffix."""
    try:
        from pyevtk.hl import imageToVTK
    except ImportError:
        raise ImportError(".vti files need pyevtk: pip install 'conicoid[vtk]'") from None
    cells = {name: np.asfortranarray(array) for name, array in by_name(voxels).items()}
    low, step = (tuple(map(float, part)) for part in (voxels.low, voxels.spacing))
    with replacing(path) as file:
        imageToVTK(os.fspath(file.with_suffix("")), origin=low, spacing=step, cellData=cells)


def _write_nrrd(path: Any, voxels: Voxels) -> None:
    """One array: of ids, or of fractions with the names along its first axis."""
    try:
        import nrrd
    except ImportError:
        raise ImportError(".nrrd files need pynrrd: pip install 'conicoid[nrrd]'") from None
    whole = voxels.body if voxels.fractions is None else voxels.fractions
    center, step = voxels.low + voxels.spacing / 2, np.diag(voxels.spacing)
    header: dict[str, Any] = {"space dimension": 3, "space origin": center}
    if voxels.fractions is None:
        header |= {"space directions": step, "kinds": ["domain"] * 3}
    else:
        header |= {
            "space directions": np.concatenate([np.full((1, 3), np.nan), step]),
            "kinds": ["list", "domain", "domain", "domain"], "names": " ".join(voxels.names),
        }  # fmt: skip
    with replacing(path) as file:
        nrrd.write(os.fspath(file), np.asarray(whole), header)


_WRITERS: dict[str, Callable[[Any, Voxels], None]] = {
    ".npz": _write_npz, ".zarr": _write_zarr, ".vti": _write_vti, ".nrrd": _write_nrrd,
}  # fmt: skip
