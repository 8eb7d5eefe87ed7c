"""Files of named arrays of numbers: sources read .npy, .npz, .csv, .parquet and .zarr in bounded pieces; sinks write.

`open_source` opens any of them. A source knows the type and shape of each array before it reads a number. Its rows
come in pieces of any size from any row on, and an array is read whole only if memory holds it. Sinks, below, write such
files.
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import zipfile
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from .._util.arrays import FloatArray
from .._util.files import create_partial, open_regular, printable, refuse_devices, release_partial, replace_file
from .._util.lazy_names import import_extra
from .._util.records import dataclass
from .npz import (
    MAX_DATA_BYTES,
    ArrayHeader,
    ArrayRows,
    NpyFormatError,
    NpzArchive,
    check_heading,
    match_columns,
    read_csv_chunks,
    read_npy_header,
)

TABLE = ""
"""The name of the only array of a .npy file, of a .zarr folder that is an array, and of the columns of a table."""
LINE = "line"
"""The name of the line numbers that come with the rows of a .csv file."""
SOURCE_SUFFIXES = (".npy", ".npz", ".csv", ".parquet", ".zarr")
Rows = dict[str, Any]


class Source(Protocol):
    """Named arrays of numbers in a file.

    Attributes
    ----------
    headers
        The type and shape of each known array. A first axis of -1 has a length that only the end of the file tells.
    others
        The names of the other arrays of the file, which are never read.
    """

    headers: dict[str, ArrayHeader]
    other_columns: tuple[str, ...]

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield the rows of some arrays from row `skip` on, `most` at a time or all at once for None, as float64.

        The first `axes` axes of all these arrays have the same lengths, and count as one here. With axes = 0 an array
        is one row: it is read whole, and one that is too large for memory raises ValueError.
        """


def open_source(path: Path, names: Collection[str], columns: Sequence[str], whole: bool) -> Source:
    """Open a file by its suffix.

    Parameters
    ----------
    path
        Any other file than a regular one, or a folder for .zarr, raises OSError.
    names
        The arrays that the caller knows.
    columns
        The columns of a table, for comparison with its headings.
    whole
        Whether all arrays will be read into memory: more of them than memory holds raises ValueError.
    """
    kinds: dict[str, Any] = {
        ".npy": NpySource, ".npz": partial(NpzSource, whole=whole), ".csv": CsvSource, ".parquet": ParquetSource,
        ".zarr": ZarrSource,
    }  # fmt: skip
    suffix = path.suffix.lower()
    if suffix != ".zarr":
        # A pipe or device would block or never end, so that anything but a plain file is refused first
        open_regular(path).close()
    source: Source = kinds[suffix](path, names, columns)
    if whole:
        if suffix == ".csv" and path.stat().st_size > MAX_DATA_BYTES:
            raise ValueError(f"is larger than {MAX_DATA_BYTES >> 30} GiB")
        for header in source.headers.values():
            header.check_memory()
    return source


class NpySource:
    """A .npy file: one array."""

    other_columns: tuple[str, ...] = ()

    def __init__(self, path: Path, names: Collection[str], columns: Sequence[str]) -> None:
        self._path = path
        with open_regular(path) as file, self._errors():
            # The size of the file must agree before a number is read, as a head may announce more than the disk holds
            header = read_npy_header(file)
            if header.kind is not None:
                header.check_size(os.fstat(file.fileno()).st_size)
        self.headers = {TABLE: header}

    @staticmethod
    @contextlib.contextmanager
    def _errors() -> Iterator[None]:
        """State in errors that the file is none of numbers."""
        try:
            yield
        except NpyFormatError as error:
            raise ValueError(f"is not a .npy file of numbers ({error})") from None

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield rows of the array."""
        with open_regular(self._path) as file:
            if not axes:
                self.headers[TABLE].check_memory()
            rows = ArrayRows(file, self.headers[TABLE], axes, skip)
            for begin, end in row_ranges(rows.count, most, skip):
                with self._errors():
                    piece = {TABLE: rows.next(end - begin)}
                yield piece


class NpzSource:
    """A .npz file: it is trusted no more in pieces than whole."""

    def __init__(self, path: Path, names: Collection[str], columns: Sequence[str], whole: bool = False) -> None:
        self._path = path
        with open_regular(path) as file:
            archive = NpzArchive(file)
            self.other_columns = tuple(name for name in archive.members if name not in names)
            self.headers = {}
            for name in archive.members:
                if name in names:
                    with archive.naming(name):
                        self.headers[name] = archive.open(name, whole)[1]

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield rows of some arrays, which are read side by side."""
        with open_regular(self._path) as file:
            archive, rows = NpzArchive(file), {}
            for name in names:
                with archive.naming(name):
                    rows[name] = ArrayRows(*archive.open(name, not axes), axes, skip)
            for begin, end in row_ranges(next(iter(rows.values())).count, most, skip):
                piece = {}
                for name, array in rows.items():
                    with archive.naming(name):
                        piece[name] = array.next(end - begin)
                yield piece
            for name, array in rows.items():
                with archive.naming(name):
                    array.finish()


def row_ranges(count: int, most: int | None, skip: int) -> Iterator[tuple[int, int]]:
    """Yield (begin, end) of pieces of `most` rows from row `skip` on, or of all rows at once for None."""
    if most is None:
        yield skip, count
        return
    for begin in range(skip, count, most):
        yield begin, min(count, begin + most)


class CsvSource:
    """A .csv file: a table of given columns, whose number of rows is known at its end."""

    other_columns: tuple[str, ...] = ()

    def __init__(self, path: Path, names: Collection[str], columns: Sequence[str]) -> None:
        self._path, self._columns = path, tuple(columns)
        self.headers = {TABLE: ArrayHeader("<f8", (-1, len(columns)))}

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield rows of the table with their line numbers; lines before them are read and dropped."""
        for table, lines in read_csv_chunks(self._path, len(self._columns), self._columns, most):
            # For None also an empty table, since the caller waits for one piece
            if skip < len(table) or most is None:
                yield {TABLE: table[skip:], LINE: lines[skip:]}
            skip = max(0, skip - len(table))


# Parquet files. They need the extra `parquet`: Apache Arrow's reader.

_PARQUET_NUMBERS = {"double", "float", "halffloat", *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64))}


def parquet_module() -> Any:
    """Return `pyarrow.parquet`. Raise ImportError with the way to install it."""
    return import_extra("pyarrow.parquet", ".parquet files need pyarrow", "parquet")


class ParquetSource:
    """A .parquet file: a table of given columns, by their names or in this order, and columns that the caller knows."""

    other_columns: tuple[str, ...] = ()

    def __init__(self, path: Path, names: Collection[str], columns: Sequence[str]) -> None:
        module = parquet_module()
        try:
            self._file: Any = module.ParquetFile(path)
        except OSError:
            raise
        except Exception as error:  # Arrow raises classes of its own
            raise ValueError(f"is not a Parquet file ({_first_line(error)})") from None
        schema = self._file.schema_arrow
        found = list(map(str, schema.names))
        ray_columns = [name for name in found if name in names]
        self._table = self._find_columns(path.name, [name for name in found if name not in names], columns)
        for name in (*self._table, *ray_columns):
            kind = str(schema.field(name).type)
            if kind not in _PARQUET_NUMBERS:
                raise ValueError(f"column {printable(name)[:60]!r} must hold numbers, got {kind[:40]}")
        count = int(self._file.metadata.num_rows)
        self.headers = {TABLE: ArrayHeader("<f8", (count, len(columns)))}
        self.headers |= {name: ArrayHeader("<f8", (count,)) for name in ray_columns}

    @staticmethod
    def _find_columns(place: str, names: list[str], columns: Sequence[str]) -> list[str]:
        """Return the names of the columns of the table. Raise ValueError for others."""
        found = match_columns(names, tuple(columns))
        if found is not None:
            return found
        if len(names) != len(columns):
            described = printable(", ".join(names))[:120] or "none"
            raise ValueError(f"must have the columns ox, oy, oz, dx, dy, dz (and t_min, t_max), got {described}")
        check_heading(place, ",".join(names), tuple(columns))
        return names

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield rows; row groups before row `skip` are not read."""
        fields = [*self._table, *(name for name in names if name != TABLE)]
        groups: list[int] = []
        for group in range(self._file.num_row_groups):
            count = self._file.metadata.row_group(group).num_rows
            if groups or skip < count:
                groups.append(group)
            else:
                skip -= count
        whole = most is None
        batches = [self._file.read(fields)] if whole else self._file.iter_batches(most, groups, fields)
        for batch in batches:
            some = batch.slice(min(skip, batch.num_rows))
            skip -= batch.num_rows - some.num_rows
            if some.num_rows or whole:
                columns = {name: self._numbers(name, some.column(name)) for name in fields}
                table = np.column_stack([columns[name] for name in self._table])
                yield {name: table if name == TABLE else columns[name] for name in names}

    def _numbers(self, name: str, column: Any) -> Any:
        """Return a column as float64. Raise ValueError for empty places."""
        if column.null_count:
            raise ValueError(f"column {printable(name)[:60]!r} has {column.null_count} empty places")
        return np.asarray(column.to_numpy(zero_copy_only=False)).astype(np.float64)


# Zarr folders (chunked arrays, https://zarr.dev). They need the extra `zarr`.


def zarr_module() -> Any:
    """Return `zarr`. Raise ImportError with the way to install it."""
    return import_extra("zarr", ".zarr folders need zarr", "zarr")


class ZarrSource:
    """A .zarr folder: an array, or a group of arrays."""

    def __init__(self, path: Path, names: Collection[str], columns: Sequence[str]) -> None:
        zarr = zarr_module()
        if not path.is_dir():
            raise FileNotFoundError(2, "no such folder", str(path))
        refuse_devices(path)
        try:
            found: Any = zarr.open(str(path), mode="r")
            arrays: dict[str, Any] = {TABLE: found} if hasattr(found, "shape") else dict(found.arrays())
        except Exception as error:  # zarr raises what its stores and codecs raise
            raise ValueError(f"is not a folder of zarr ({_first_line(error)})") from None
        self.other_columns = tuple(name for name in arrays if name not in (TABLE, *names))
        self._arrays = {name: array for name, array in arrays.items() if name not in self.other_columns}
        self.headers = {
            name: ArrayHeader(np.dtype(array.dtype).str, tuple(array.shape)) for name, array in self._arrays.items()
        }

    def rows(self, names: Collection[str], axes: int, most: int | None, skip: int) -> Iterator[Rows]:
        """Yield rows; of an array with several such axes, whole items of the first axis are read."""
        count = math.prod(self.headers[next(iter(names))].shape[:axes])
        for begin, end in row_ranges(count, most, skip):
            yield {name: self._flat(name, self.headers[name].shape[:axes], begin, end) for name in names}

    def _flat(self, name: str, shape: tuple[int, ...], begin: int, end: int) -> FloatArray:
        """Return flat rows of an array with these first axes."""
        if not shape:
            self.headers[name].check_memory()
        each = max(1, math.prod(shape[1:]))
        first, array = begin // each, self._arrays[name]
        try:
            # Whole items of the first axis, as chunks hold them; the rest is cut off below
            some = np.asarray(array[first : -(-end // each)] if shape else array[...], np.float64)
        except Exception as error:  # a damaged chunk raises what its codec raises
            raise ValueError(f"array {name} has a chunk that cannot be read ({_first_line(error)})") from None
        return some.reshape(-1, *some.shape[len(shape) :])[begin - first * each : end - first * each]


def _first_line(error: Exception) -> str:
    """Return the beginning of an error's message."""
    return (str(error).splitlines() or [""])[0][:120]


def as_integers(name: str, array: Any, least: int, most: int, kind: Any) -> Any:
    """Return the floats of a file as integers of dtype `kind`. Raise ValueError for others than `least` to `most`."""
    if not ((array == np.floor(array)) & (array >= least) & (array <= most)).all():
        raise ValueError(f"{name} must hold integers from {least} to {most}")
    return array.astype(kind)


# Sinks: writers of named arrays and of tables, .npy, .npz, .csv, .parquet and .zarr; whole or not at all.
#
# `write_arrays` and `write_columns` choose the format by the suffix. Arrays may lie in memory-mapped files: they are
# copied in pieces, never held whole. Sources, above, read them.

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


def write_arrays(path: str | os.PathLike[str], arrays: Arrays, about: Callable[[int], None] | None = None) -> None:
    """Write a .npz file, a new .zarr folder, or a .npy file of the only array. Raise OSError.

    about: gets the number that the file system has for the folder, before that has its name.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".zarr":
        _write_zarr(path, arrays, about)
        return
    with replace_file(path) as partial:
        if suffix == ".npy":
            ((_, array),) = arrays.items()
            with partial.open("wb") as file:
                _write_npy(file, array)
            return
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, array in arrays.items():
                # The size is not known when a member begins, and 4 GiB are soon reached
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


def _write_zarr(path: str | os.PathLike[str], arrays: Arrays, about: Callable[[int], None] | None) -> None:
    """Write a group of arrays, chunked along their first axis."""
    with new_zarr_group(path) as group:
        if about is not None:
            about(os.stat(group.store.root).st_ino)
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
    # Beside the final place, since a rename across file systems would be a copy
    partial, lock = create_partial(folder, ".zarr", folder=True)
    try:
        yield zarr.open_group(str(partial), mode="w-")  # "w" would replace the folder, and so its lock
        os.rename(partial, folder)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    finally:
        release_partial(lock)


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
