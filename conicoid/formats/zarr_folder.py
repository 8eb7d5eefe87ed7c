"""Rays in zarr's folders of chunks, read piece by piece, and results as such. Extra `zarr`; https://zarr.dev"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.validate import listed
from .errors import printable
from .flat_rows import WIDTHS, Read, broadcast_rows, leading_shape, rows_of

if TYPE_CHECKING:
    from .stored import Stored

_BLOCK = 16 << 20
"""Bytes of a chunk, about."""


def zarr_module() -> Any:
    try:
        import zarr
    except ImportError:
        raise ImportError(".zarr folders need zarr: pip install 'conicoid[zarr]'") from None
    return zarr


class ZarrSource:
    """An array (..., 6), or a group of the arrays `origins` and `directions`, and perhaps `t_min` and `t_max`."""

    home = None

    def __init__(self, path: Path) -> None:
        zarr = zarr_module()
        if not path.is_dir():
            raise FileNotFoundError(2, "no such folder", str(path))
        try:
            found: Any = zarr.open(str(path), mode="r")
        except Exception as error:  # zarr raises what its stores and codecs raise
            raise ValueError(f"is not a folder of zarr ({(str(error).splitlines() or [''])[0][:120]})") from None
        self._reads: dict[str, Read] = {}
        if hasattr(found, "shape"):
            self._open_table(found)
        else:
            self._open_group(found)
        self.ends = tuple(name for name in ("t_min", "t_max") if name in self._reads)

    def _open_table(self, table: Any) -> None:
        if table.ndim < 2 or table.shape[-1] != 6 or table.dtype.kind not in "fiu":
            raise ValueError(f"rays must be numbers of shape (..., 6), got {table.dtype} {table.shape}")
        self.shape: tuple[int, ...] | None = tuple(table.shape[:-1])
        read = rows_of(table, self.shape)
        self._reads["table"] = read

    def _open_group(self, group: Any) -> None:
        arrays = dict(group.arrays())
        others = [printable(name) for name in arrays if name not in WIDTHS]
        if others:
            raise ValueError(f"arrays of rays are {', '.join(WIDTHS)}; it also holds {listed(others, 5)}")
        for name, array in arrays.items():
            if array.dtype.kind not in "fiu":
                raise ValueError(f"{name} must hold numbers, got {array.dtype}")
        self.shape = leading_shape({name: tuple(array.shape) for name, array in arrays.items()})
        for name, array in arrays.items():
            whole = tuple(array.shape) == (*self.shape, *WIDTHS[name]) and self.shape != ()
            self._reads[name] = (
                rows_of(array, self.shape) if whole else broadcast_rows(np.asarray(array[...], float), self.shape)
            )

    def rows(self, most: int, skip: int) -> Iterator[Any]:
        from .ray_stream import Rows

        count = int(np.prod(self.shape or ()))
        for begin in range(skip, count, most):
            some = {name: read(begin, min(count, begin + most)) for name, read in self._reads.items()}
            table = some.pop("table", None)
            yield Rows(table[:, :3], table[:, 3:]) if table is not None else Rows(**some)


def write_zarr(path: str | os.PathLike[str], arrays: Mapping[str, Stored], more: Mapping[str, Any]) -> None:
    """A new group of arrays, chunked along their first axis. The folder appears whole or not at all; raises OSError."""
    zarr, final = zarr_module(), Path(path)
    if os.path.lexists(final):
        raise FileExistsError(17, "is there already", str(final))
    partial = final.with_name(f".{final.stem[:40]}-{secrets.token_hex(4)}.zarr")
    try:
        group = zarr.open_group(str(partial), mode="w")
        for name, array in arrays.items():
            _write_array(group, name, array)
        for name, values in more.items():
            group.create_array(name, data=np.atleast_1d(values))
        os.rename(partial, final)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _write_array(group: Any, name: str, array: Stored) -> None:
    shape = array.shape
    stacked = len(array.columns) > 1
    rows = shape[1:] if stacked else shape
    each = max(1, array.dtype.itemsize * int(np.prod(rows[1:])))
    step = max(1, min(rows[0], _BLOCK // each))
    chunks = (1, step, *rows[1:]) if stacked else (step, *rows[1:])
    made = group.create_array(name, shape=shape, dtype=array.dtype, chunks=tuple(max(1, n) for n in chunks))
    for k, column in enumerate(array.columns):
        values = column.reshape(rows)
        for begin in range(0, rows[0], step):
            if stacked:
                made[k, begin : begin + step] = values[begin : begin + step]
            else:
                made[begin : begin + step] = values[begin : begin + step]
