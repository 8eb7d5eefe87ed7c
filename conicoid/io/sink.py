"""Sinks: writers of named arrays and of tables, .npy, .npz, .csv, .parquet and .zarr; whole or not at all.

`write_arrays` and `write_columns` choose the format by the suffix. Arrays may lie in memory-mapped files: they are
copied in pieces, never held whole. `source.py` reads such files.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from .._util.file_errors import printable
from .._util.safe_files import replace_file
from .source import parquet_module, zarr_module

_COPY_CHUNK = 1 << 20  # items
_PARQUET_GROUP_ROWS = 1 << 20
"""Rows of a row group, which readers load at once."""
_ZARR_BLOCK_BYTES = 16 << 20
"""Approximate bytes of a chunk."""


@dataclass(frozen=True)
class StoredArray:
    """An array in files: its columns one after the other, as rows along a first axis if there are several."""

    columns: tuple[np.ndarray[Any, Any], ...]
    shape: tuple[int, ...]

    @property
    def dtype(self) -> Any:
        """The dtype, which all columns share."""
        return self.columns[0].dtype


Arrays = Mapping[str, Any]
"""Arrays in memory, and `StoredArray`."""


def write_arrays(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Write a .npz file, a new .zarr folder, or a .npy file of the only array. Raise OSError."""
    suffix = Path(path).suffix.lower()
    if suffix == ".zarr":
        _write_zarr(path, arrays)
        return
    with replace_file(path) as partial:
        if suffix == ".npy":
            ((_, array),) = arrays.items()
            with partial.open("wb") as file:
                _write_npy(file, array)
            return
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    _write_npy(member, array)


def _write_npy(file: IO[bytes], array: Any) -> None:
    """Write an array in .npy format, as a file or a member of a .npz file."""
    if not isinstance(array, StoredArray):
        np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)
        return
    kind = np.lib.format.dtype_to_descr(array.dtype)
    np.lib.format.write_array_header_1_0(file, dict(descr=kind, fortran_order=False, shape=array.shape))
    for column in array.columns:
        flat = column.reshape(-1)
        for begin in range(0, len(flat), _COPY_CHUNK):
            file.write(np.ascontiguousarray(flat[begin : begin + _COPY_CHUNK]).tobytes())


def _write_zarr(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Write a group of arrays, chunked along their first axis."""
    with new_zarr_group(path) as group:
        for name, array in arrays.items():
            if isinstance(array, StoredArray):
                _write_zarr_array(group, name, array)
            else:
                group.create_array(name, data=np.atleast_1d(array))


@contextlib.contextmanager
def new_zarr_group(path: str | os.PathLike[str]) -> Iterator[Any]:
    """Yield an empty group; the folder gets its name when the block ends.

    Raise FileExistsError if the name is taken, and FileNotFoundError for a missing parent folder.
    """
    zarr, folder = zarr_module(), Path(path)
    if os.path.lexists(folder):
        raise FileExistsError(17, "already exists", str(folder))
    if not folder.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(folder.parent))
    partial = folder.with_name(f".{folder.stem[:40]}-{secrets.token_hex(4)}.zarr")
    try:
        yield zarr.open_group(str(partial), mode="w")
        os.rename(partial, folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _write_zarr_array(group: Any, name: str, array: StoredArray) -> None:
    """Write one stored array by its chunks, so that memory holds one chunk at a time."""
    shape = array.shape
    stacked = len(array.columns) > 1
    rows = shape[1:] if stacked else shape
    each = max(1, array.dtype.itemsize * int(np.prod(rows[1:])))
    step = max(1, min(rows[0], _ZARR_BLOCK_BYTES // each))
    chunks = (1, step, *rows[1:]) if stacked else (step, *rows[1:])
    stored = group.create_array(name, shape=shape, dtype=array.dtype, chunks=tuple(max(1, n) for n in chunks))
    for k, column in enumerate(array.columns):
        values = column.reshape(rows)
        for begin in range(0, rows[0], step):
            if stacked:
                stored[k, begin : begin + step] = values[begin : begin + step]
            else:
                stored[begin : begin + step] = values[begin : begin + step]


# Tables: columns of one length.


def write_columns(path: str | os.PathLike[str], columns: Arrays) -> None:
    """Write a .parquet or .csv file. Raise OSError."""
    with replace_file(path) as partial:
        if partial.suffix.lower() == ".parquet":
            _write_parquet(partial, columns)
            return
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(csv_lines(columns))


def _write_parquet(path: Path, columns: Arrays) -> None:
    """Write columns of numbers in row groups."""
    module = parquet_module()
    import pyarrow

    kinds = {name: pyarrow.from_numpy_dtype(column.dtype) for name, column in columns.items()}
    count = max((len(column) for column in columns.values()), default=0)
    with module.ParquetWriter(path, pyarrow.schema(list(kinds.items()))) as writer:
        for begin in range(0, count, _PARQUET_GROUP_ROWS):
            some = {name: np.asarray(column[begin : begin + _PARQUET_GROUP_ROWS]) for name, column in columns.items()}
            writer.write_table(pyarrow.table(some))


def csv_lines(columns: Arrays) -> Iterator[str]:
    """Yield the lines of a .csv file, the heading first; booleans become 0 and 1."""
    yield ",".join(columns) + "\n"
    flat = [np.asarray(column).reshape(-1) for column in columns.values()]
    if not flat:
        return
    plain = [column.astype(np.int8) if column.dtype == np.bool_ else column for column in flat]
    # In pieces, as lists of Python numbers take several times the memory of arrays.
    for begin in range(0, len(plain[0]), 65536):
        rows = zip(*(column[begin : begin + 65536].tolist() for column in plain), strict=True)
        yield from (",".join(map(_format_csv_cell, row)) + "\n" for row in rows)


def _format_csv_cell(value: Any) -> str:
    """Return a text, quoted where needed, or the shortest decimal number that reads back exactly."""
    return quote_csv(value) if isinstance(value, str) else repr(value)


def quote_csv(text: str) -> str:
    """Return a text for a .csv file, in quotes if a reader of such files would misread it."""
    line = printable(text)
    plain = not any(letter in line for letter in ',"') and line == line.strip() and not line.startswith("#")
    return line if plain else '"' + line.replace('"', '""') + '"'


def check_output(path: str | os.PathLike[str], suffixes: tuple[str, ...] = (".npz", ".csv")) -> None:
    """Raise ValueError for a path with another suffix; callers check before they compute results."""
    file = Path(path)
    if file.suffix.lower() not in suffixes:
        raise ValueError(f"{file}: results are written as {', '.join(suffixes[:-1])} or {suffixes[-1]}")
