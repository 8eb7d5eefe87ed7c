"""Files of rays that need not fit into memory: .npy, .npz, .csv, .parquet and .zarr, read in pieces from any ray on.

`RayStream` reads any of them; each format has a source class with the interface of `RaySource`. Writers of results as
.parquet and .zarr stand beside the sources.
"""

from __future__ import annotations

import math
import os
import secrets
import shutil
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from .._util.file_errors import printable
from .._util.safe_files import open_regular, replace_file
from .._util.validation import format_list
from ..kernels.ray import DEAD
from ..queries.rays import Rays, find_invalid_ray
from .data_files import check_heading, match_columns, read_csv_chunks
from .npz import ZIP_ERRORS, NpyFormatError, NpyHeader, NpzArchive, failure_reason, read_npy_header
from .ray_file import RAY_COLUMNS

if TYPE_CHECKING:
    from .npz import StoredArray


# Arrays that broadcast to the shape of the rays, read as flat rows.

ORIGINS, DIRECTIONS = "origins", "directions"
ARRAY_WIDTHS: dict[str, tuple[int, ...]] = {ORIGINS: (3,), DIRECTIONS: (3,), "t_min": (), "t_max": ()}
"""The arrays of rays, and the axes after their leading shape."""
ReadRows = Callable[[int, int], Any]
"""(begin, end) -> the flat rows from `begin` to `end` as an array."""


def leading_shape(shapes: dict[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Return the shape of the rays whose arrays have these shapes. Raise ValueError if they do not fit together."""
    for name in (ORIGINS, DIRECTIONS):
        if name not in shapes:
            found = ", ".join(shapes) or "nothing"
            raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {found[:120]}")
        if not shapes[name] or shapes[name][-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), got {shapes[name]}")
    try:
        rays: tuple[int, ...] = np.broadcast_shapes(shapes[ORIGINS], shapes[DIRECTIONS])[:-1]
    except ValueError:
        raise ValueError(
            f"origins {shapes[ORIGINS]} and directions {shapes[DIRECTIONS]} do not broadcast together"
        ) from None
    for name in ("t_min", "t_max"):
        if name in shapes and not _fits_rays(shapes[name], rays):
            raise ValueError(
                f"t_min and t_max must broadcast to the rays' shape {rays}, got {name} of shape {shapes[name]}"
            )
    return rays


def _fits_rays(shape: tuple[int, ...], rays: tuple[int, ...]) -> bool:
    try:
        return bool(np.broadcast_shapes(shape, rays) == rays)
    except ValueError:
        return False


def flat_reader(array: Any, shape: tuple[int, ...]) -> ReadRows:
    """Return a reader of flat rows for an array with the leading shape of the rays, which is sliced along axis 0."""
    each = math.prod(shape[1:])

    def read(begin: int, end: int) -> Any:
        first = begin // each
        some = np.asarray(array[first : -(-end // each)], np.float64)
        return some.reshape(-1, *some.shape[len(shape) :])[begin - first * each : end - first * each]

    return read


def broadcast_reader(array: Any, shape: tuple[int, ...]) -> ReadRows:
    """Return a reader of flat rows for an array in memory that broadcasts to the leading shape of the rays."""
    last = array.shape[-1:] if array.ndim and array.shape[-1:] == (3,) else ()
    whole = np.broadcast_to(array, (*shape, *last))

    def read(begin: int, end: int) -> Any:
        return whole[np.unravel_index(np.arange(begin, end), shape)]

    return read


# .npz files. They are trusted no more than files that are read whole.

_SKIP_CHUNK = 4 << 20
_STARTS, _HOME = "starts", "starts_home"


class NpzSource:
    """The arrays `origins` and `directions`, optional `t_min` and `t_max`, and the starts that `Rays.save` adds.

    Arrays with a row for each ray are streamed; arrays that broadcast, and arrays in Fortran order, are read whole.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with open_regular(path) as file:
            archive = NpzArchive(file, os.fstat(file.fileno()).st_size)
            known = (*ARRAY_WIDTHS, _STARTS)
            members = {name: archive.members[name] for name in known if name in archive.members}
            headers = {name: _member_header(archive.zip, info) for name, info in members.items()}
            shapes = {name: header.shape for name, header in headers.items() if name != _STARTS}
            if not {"origins", "directions"} <= set(shapes):
                names = printable(", ".join(archive.members))[:120] or "nothing"
                raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {names}")
            rays = leading_shape(shapes)
            count = int(np.prod(rays))
            self.shape: tuple[int, ...] | None = rays
            self._count = count
            whole = {name: (*rays, *last) for name, last in ARRAY_WIDTHS.items()} | {_STARTS: (count,)}
            self._streamed = {
                name: (info, headers[name]) for name, info in members.items()
                if headers[name].shape == whole[name] and not (headers[name].fortran and len(whole[name]) > 1)
            }  # fmt: skip
            small = archive.arrays([name for name in members if name not in self._streamed], ())
            home = archive.arrays([_HOME]).get(_HOME)
            self.home = None if home is None else home.astype(np.uint8).tobytes() or None
            starts = small.pop(_STARTS, None)
            if starts is not None and starts.shape != (1,):
                raise ValueError(f"starts must have shape (1,) or ({count},), got {starts.shape}")
            self._start = starts
            self._small = {name: broadcast_reader(array, rays) for name, array in small.items()}
        self.ends = tuple(name for name in ("t_min", "t_max") if name in members)

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time."""
        with open_regular(self._path) as file, zipfile.ZipFile(file) as archive:
            try:
                opened = {name: _NpzMember(archive, *member, skip) for name, member in self._streamed.items()}
                for begin in range(skip, self._count, most):
                    end = min(self._count, begin + most)
                    some = {name: member.next(end - begin) for name, member in opened.items()}
                    some |= {name: read(begin, end) for name, read in self._small.items()}
                    starts = some.get(_STARTS, self._start)
                    if starts is not None:
                        starts = np.broadcast_to(starts, (end - begin,)) if len(starts) == 1 else starts
                        some[_STARTS] = np.ascontiguousarray(starts.astype(np.int32))
                    yield RayRows(**some)
            except (NpyFormatError, ValueError):
                raise
            except ZIP_ERRORS as error:
                raise NpyFormatError(failure_reason(error)) from None


class _NpzMember:
    """An array of an archive, read forward from row `skip` on."""

    def __init__(self, archive: zipfile.ZipFile, info: zipfile.ZipInfo, header: NpyHeader, skip: int) -> None:
        self._file: IO[bytes] = archive.open(info)
        read_npy_header(self._file)
        assert header.kind is not None
        self._kind = header.kind
        self._last = header.shape[-1:] if info.filename.removesuffix(".npy") in ("origins", "directions") else ()
        self._each = self._kind.itemsize * int(np.prod(self._last))
        left = skip * self._each
        while left:  # compressed members cannot seek: read and drop, in bounded memory
            left -= len(_read_member_exactly(self._file, min(left, _SKIP_CHUNK)))

    def next(self, count: int) -> Any:
        """Return the next `count` rows as float64. Raise NpyFormatError if the member ends before."""
        data = _read_member_exactly(self._file, count * self._each)
        return np.frombuffer(data, self._kind).astype(np.float64).reshape(-1, *self._last)


def _member_header(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NpyHeader:
    """Return the header of a member. Raise ValueError unless it holds exactly the numbers that it declares."""
    name = info.filename.removesuffix(".npy")
    try:
        if info.flag_bits & 0x1:
            raise NpyFormatError("it is encrypted")
        with archive.open(info) as file:
            header = read_npy_header(file)
    except NpyFormatError as error:
        raise ValueError(f"{name} is not an array of numbers ({error})") from None
    except ZIP_ERRORS as error:
        raise NpyFormatError(failure_reason(error)) from None
    if header.kind is None:
        raise ValueError(f"{name} must hold numbers, got {header}")
    if info.file_size != header.length + header.count * header.kind.itemsize:
        raise ValueError(f"{name} is not an array of numbers (it has {info.file_size:,} bytes)")
    return header


def _read_member_exactly(file: IO[bytes], count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise NpyFormatError("it ends too early")
    return data


# Parquet files of rays and of results. They need the extra `parquet`: Apache Arrow's reader.

_PARQUET_COLUMNS = ("origin x", "origin y", "origin z", "direction x", "direction y", "direction z")
_PARQUET_GROUP_ROWS = 1 << 20
"""Rows of a row group, which readers load at once."""


def parquet_module() -> Any:
    """Return `pyarrow.parquet`. Raise ImportError with the way to install it."""
    try:
        import pyarrow.parquet
    except ImportError:
        raise ImportError(".parquet files need pyarrow: pip install 'conicoid[parquet]'") from None
    return pyarrow.parquet


class ParquetSource:
    """Six columns, named ox, oy, oz, dx, dy, dz or in this order, and optional columns t_min and t_max."""

    home = None

    def __init__(self, path: Path) -> None:
        module = parquet_module()
        try:
            self._file: Any = module.ParquetFile(path)
        except OSError:
            raise
        except Exception as error:  # Arrow raises classes of its own
            raise ValueError(f"is not a Parquet file ({(str(error).splitlines() or [''])[0][:120]})") from None
        schema = self._file.schema_arrow
        names = [str(name) for name in schema.names]
        self.ends: tuple[str, ...] = tuple(name for name in ("t_min", "t_max") if name in names)
        others = [name for name in names if name not in ARRAY_WIDTHS]
        found = match_columns(others, _PARQUET_COLUMNS)
        if found is None:
            if len(others) != 6:
                described = printable(", ".join(names))[:120] or "none"
                raise ValueError(f"must have the columns ox, oy, oz, dx, dy, dz (and t_min, t_max), got {described}")
            check_heading(path.name, ",".join(others), _PARQUET_COLUMNS)
            found = others
        self._names = [*found, *self.ends]
        for name in self._names:
            kind = str(schema.field(name).type)
            if kind not in _PARQUET_NUMBERS:
                raise ValueError(f"column {printable(name)[:60]!r} must hold numbers, got {kind[:40]}")
        self.shape: tuple[int, ...] | None = (int(self._file.metadata.num_rows),)

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time; row groups before that ray are not read."""
        groups: list[int] = []
        first = 0  # rows of the groups that are left out
        for group in range(self._file.num_row_groups):
            count = self._file.metadata.row_group(group).num_rows
            if first + count > skip or groups:
                groups.append(group)
            else:
                first += count
        skip -= first
        for batch in self._file.iter_batches(batch_size=most, row_groups=groups, columns=self._names):
            some = batch.slice(min(skip, batch.num_rows))
            skip -= batch.num_rows - some.num_rows
            if not some.num_rows:
                continue
            columns = {name: self._numbers(name, some.column(name)) for name in self._names}
            table = np.column_stack([columns[name] for name in self._names[:6]])
            yield RayRows(table[:, :3], table[:, 3:], columns.get("t_min"), columns.get("t_max"))

    def _numbers(self, name: str, column: Any) -> Any:
        """Return a column as float64. Raise ValueError for empty places."""
        if column.null_count:
            raise ValueError(f"column {printable(name)[:60]!r} has {column.null_count} empty places")
        return column.to_numpy(zero_copy_only=False).astype(np.float64)


_PARQUET_NUMBERS = {"double", "float", "halffloat", *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64))}


def write_parquet(path: str | os.PathLike[str], columns: Mapping[str, Any]) -> None:
    """Write columns of numbers as a table; the file appears whole or not at all. Raise OSError."""
    module = parquet_module()
    import pyarrow

    kinds = {name: pyarrow.from_numpy_dtype(column.dtype) for name, column in columns.items()}
    count = max((len(column) for column in columns.values()), default=0)
    with replace_file(path) as partial, module.ParquetWriter(partial, pyarrow.schema(list(kinds.items()))) as writer:
        for begin in range(0, count, _PARQUET_GROUP_ROWS):
            some = {name: np.asarray(column[begin : begin + _PARQUET_GROUP_ROWS]) for name, column in columns.items()}
            writer.write_table(pyarrow.table(some))


# Zarr folders (chunked arrays, https://zarr.dev) of rays and of results. They need the extra `zarr`.

_ZARR_BLOCK_BYTES = 16 << 20
"""Approximate bytes of a chunk."""


def zarr_module() -> Any:
    """Return `zarr`. Raise ImportError with the way to install it."""
    try:
        import zarr
    except ImportError:
        raise ImportError(".zarr folders need zarr: pip install 'conicoid[zarr]'") from None
    return zarr


class ZarrSource:
    """An array (..., 6), or a group of the arrays `origins` and `directions` and optional `t_min` and `t_max`."""

    home = None

    def __init__(self, path: Path) -> None:
        zarr = zarr_module()
        if not path.is_dir():
            raise FileNotFoundError(2, "no such folder", str(path))
        try:
            found: Any = zarr.open(str(path), mode="r")
        except Exception as error:  # zarr raises what its stores and codecs raise
            raise ValueError(f"is not a folder of zarr ({(str(error).splitlines() or [''])[0][:120]})") from None
        self._reads: dict[str, ReadRows] = {}
        if hasattr(found, "shape"):
            self._open_table(found)
        else:
            self._open_group(found)
        self.ends = tuple(name for name in ("t_min", "t_max") if name in self._reads)

    def _open_table(self, table: Any) -> None:
        """Read from one array (..., 6)."""
        if table.ndim < 2 or table.shape[-1] != 6 or table.dtype.kind not in "fiu":
            raise ValueError(f"rays must be numbers of shape (..., 6), got {table.dtype} {table.shape}")
        self.shape: tuple[int, ...] | None = tuple(table.shape[:-1])
        read = flat_reader(table, self.shape)
        self._reads["table"] = read

    def _open_group(self, group: Any) -> None:
        """Read from a group of arrays; those that broadcast are loaded."""
        arrays = dict(group.arrays())
        others = [printable(name) for name in arrays if name not in ARRAY_WIDTHS]
        if others:
            raise ValueError(f"arrays of rays are {', '.join(ARRAY_WIDTHS)}; it also holds {format_list(others, 5)}")
        for name, array in arrays.items():
            if array.dtype.kind not in "fiu":
                raise ValueError(f"{name} must hold numbers, got {array.dtype}")
        self.shape = leading_shape({name: tuple(array.shape) for name, array in arrays.items()})
        for name, array in arrays.items():
            whole = tuple(array.shape) == (*self.shape, *ARRAY_WIDTHS[name]) and self.shape != ()
            self._reads[name] = (
                flat_reader(array, self.shape) if whole else broadcast_reader(np.asarray(array[...], float), self.shape)
            )

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time."""
        count = int(np.prod(self.shape or ()))
        for begin in range(skip, count, most):
            some = {name: read(begin, min(count, begin + most)) for name, read in self._reads.items()}
            table = some.pop("table", None)
            yield RayRows(table[:, :3], table[:, 3:]) if table is not None else RayRows(**some)


def write_zarr(path: str | os.PathLike[str], arrays: Mapping[str, StoredArray], more: Mapping[str, Any]) -> None:
    """Write a new group of arrays, chunked along their first axis; the folder appears whole or not at all.

    `more` holds small arrays in memory. Raise FileExistsError if the folder exists, and OSError.
    """
    zarr, final = zarr_module(), Path(path)
    if os.path.lexists(final):
        raise FileExistsError(17, "is there already", str(final))
    partial = final.with_name(f".{final.stem[:40]}-{secrets.token_hex(4)}.zarr")
    try:
        group = zarr.open_group(str(partial), mode="w")
        for name, array in arrays.items():
            _write_zarr_array(group, name, array)
        for name, values in more.items():
            group.create_array(name, data=np.atleast_1d(values))
        os.rename(partial, final)
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


# Streams of any format.

RAY_SUFFIXES = (".npy", ".npz", ".csv", ".parquet", ".zarr")


class RayRows(NamedTuple):
    """Some rays of a file, flat: (n, 3), (n, 3), and (n,) or None; `lines` are line numbers in a text."""

    origins: Any
    directions: Any
    t_min: Any = None
    t_max: Any = None
    starts: Any = None
    lines: Sequence[int] = ()


class TimedRays(NamedTuple):
    """Rays (n,) with the ends of their intervals (n,), or None where the file has none."""

    rays: Rays
    t_min: Any
    t_max: Any


class RaySource(Protocol):
    """A file of rays.

    Attributes
    ----------
    shape
        The leading shape of the rays; None if their number is not known before the end.
    ends
        Those of "t_min" and "t_max" that the file has.
    home
        The key of the scene on whose surfaces the rays start, if any.
    """

    shape: tuple[int, ...] | None
    ends: tuple[str, ...]
    home: bytes | None

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time."""
        ...


class RayStream:
    """Rays in a .npy (..., 6), .npz, .csv or .parquet file or a .zarr folder.

    Raise ValueError, with the name of the file, OSError, and ImportError if the reader of the format is not installed.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        suffix = self.path.suffix.lower()
        if suffix not in RAY_SUFFIXES:
            raise ValueError(f"{self.path}: rays are read piece by piece from {', '.join(RAY_SUFFIXES)}")
        if suffix != ".zarr":
            open_regular(self.path).close()
        kinds: dict[str, Any] = {
            ".npy": _NpySource, ".npz": NpzSource, ".csv": _CsvSource, ".parquet": ParquetSource, ".zarr": ZarrSource,
        }  # fmt: skip
        try:
            self.source: RaySource = kinds[suffix](self.path)
        except NpyFormatError as error:
            raise ValueError(f"{self.path}: is not a {suffix} file of numbers ({error})") from None
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from None

    @property
    def shape(self) -> tuple[int, ...] | None:
        """The leading shape; None for a .csv file, whose number of rays is not known before its end."""
        return self.source.shape

    def check_ends(self, t_min: float | None, t_max: float | None) -> None:
        """Raise ValueError if the caller passes an end that the file has for each ray, and for NaN."""
        for name, end in (("t_min", t_min), ("t_max", t_max)):
            option = "--" + name.replace("_", "-")
            if end is not None and np.isnan(end):
                raise ValueError(f"{option} must not be NaN")
            if end is not None and name in self.source.ends:
                raise ValueError(f"{self.path}: holds {name} for its rays; {option} {end:g} would be ignored, or they")

    def pieces(self, most: int, skip: int = 0) -> Iterator[TimedRays]:
        """Yield the rays from number `skip` on, at most `most` at a time.

        Raise ValueError, with the number or line of the ray, for an invalid one.
        """
        done = skip
        try:
            for rows in self.source.rows(most, skip):
                yield TimedRays(self._rays(rows, done), self._end("t_min", rows, done), self._end("t_max", rows, done))
                done += len(rows.origins)
        except NpyFormatError as error:
            raise ValueError(f"{self.path}: {error}") from None

    def _rays(self, rows: RayRows, first: int) -> Rays:
        """Return the rays of some rows; `first` is the number of the first. Dead rays need not be valid."""
        origins, directions = (np.ascontiguousarray(x, dtype=np.float64) for x in (rows.origins, rows.directions))
        alive = np.ones(len(origins), np.bool_) if rows.starts is None else rows.starts != DEAD
        wrong = find_invalid_ray(origins[alive], directions[alive])
        if wrong is not None:
            place = f"{rows.lines[wrong[0]]}" if rows.lines else f"ray {first + np.flatnonzero(alive)[wrong[0]]}"
            raise ValueError(f"{self.path}: {place}: {wrong[1]}")
        if rows.starts is None:
            return Rays(origins, directions)
        return Rays._spawned(origins, directions, rows.starts, self.source.home)

    def _end(self, name: str, rows: RayRows, first: int) -> Any:
        """Return `t_min` or `t_max` of some rows, None if they have none. Raise ValueError for NaN."""
        values = getattr(rows, name)
        if values is None:
            return None
        wrong = np.flatnonzero(np.isnan(values))
        if len(wrong):
            raise ValueError(f"{self.path}: {name} must not be NaN, got NaN for ray {first + wrong[0]}")
        return np.asarray(values, np.float64)


class _NpySource:
    """A .npy file (..., 6)."""

    ends: tuple[str, ...] = ()
    home = None

    def __init__(self, path: Path) -> None:
        self._path = path
        with open_regular(path) as file:
            header = read_npy_header(file)
            self._start = file.tell()
            size = os.fstat(file.fileno()).st_size - self._start
        if header.kind is None or not header.shape or header.shape[-1] != 6:
            raise ValueError(f"rays must be numbers of shape (..., 6), {', '.join(RAY_COLUMNS)}; got {header}")
        if header.fortran and len(header.shape) > 1:
            raise ValueError("its columns come first: np.ascontiguousarray(rays) is read piece by piece")
        if size < header.count * header.kind.itemsize:
            raise ValueError("it ends too early")
        self._kind = header.kind
        self.shape: tuple[int, ...] | None = header.shape[:-1]
        self._count = header.count // 6

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time."""
        each = 6 * self._kind.itemsize
        with open_regular(self._path) as file:
            file.seek(self._start + skip * each)
            for begin in range(skip, self._count, most):
                data = file.read(min(most, self._count - begin) * each)
                table = np.frombuffer(data, self._kind).astype(np.float64).reshape(-1, 6)
                yield RayRows(table[:, :3], table[:, 3:])


class _CsvSource:
    """A .csv file of six columns."""

    shape = None
    ends: tuple[str, ...] = ()
    home = None

    def __init__(self, path: Path) -> None:
        self._path = path

    def rows(self, most: int, skip: int) -> Iterator[RayRows]:
        """Yield the rows from ray `skip` on, at most `most` at a time; lines before them are read and dropped."""
        for table, lines in read_csv_chunks(self._path, 6, RAY_COLUMNS, most):
            if skip < len(table):
                yield RayRows(table[skip:, :3], table[skip:, 3:], lines=lines[skip:])
            skip = max(0, skip - len(table))
