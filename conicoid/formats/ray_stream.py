"""Files of rays that memory need not hold: read piece by piece, from any of them on."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..engine.answers.rays import Rays, first_wrong
from ..engine.ray import DEAD
from .data_files import csv_pieces
from .npy import NotPlain, read_header
from .npz_stream import NpzSource
from .parquet_file import ParquetSource
from .ray_file import COLUMNS
from .regular import open_regular
from .zarr_folder import ZarrSource

SUFFIXES = (".npy", ".npz", ".csv", ".parquet", ".zarr")


class Rows(NamedTuple):
    """Some rays as a file has them, flat; `lines` are those of a text."""

    origins: Any
    directions: Any
    t_min: Any = None
    t_max: Any = None
    starts: Any = None
    lines: Sequence[int] = ()


class TimedRays(NamedTuple):
    """Rays (n,) with intervals of their own, a number for each; None where the file has none."""

    rays: Rays
    t_min: Any
    t_max: Any


class Source(Protocol):
    """What rays are read from.

    shape: their leading shape; None where the end is not known.
    ends: which of t_min and t_max it has. home: the scene whose surfaces they start on, if any.
    """

    shape: tuple[int, ...] | None
    ends: tuple[str, ...]
    home: bytes | None

    def rows(self, most: int, skip: int) -> Iterator[Rows]: ...


class RayStream:
    """Rays in a .npy (..., 6), .npz, .csv or .parquet file or a .zarr folder.

    Raises ValueError, naming the file, OSError, and ImportError where its reader is not installed.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        suffix = self.path.suffix.lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"{self.path}: rays are read piece by piece from {', '.join(SUFFIXES)}")
        if suffix != ".zarr":
            open_regular(self.path).close()
        kinds: dict[str, Any] = {
            ".npy": _NpySource, ".npz": NpzSource, ".csv": _CsvSource, ".parquet": ParquetSource, ".zarr": ZarrSource,
        }  # fmt: skip
        try:
            self.source: Source = kinds[suffix](self.path)
        except NotPlain as error:
            raise ValueError(f"{self.path}: is not a {suffix} file of numbers ({error})") from None
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from None

    @property
    def shape(self) -> tuple[int, ...] | None:
        """The leading shape; None for a .csv file, whose end is not known."""
        return self.source.shape

    def check_ends(self, t_min: float | None, t_max: float | None) -> None:
        """ValueError where an end is given for all rays that the file has for each."""
        for name, end in (("t_min", t_min), ("t_max", t_max)):
            option = "--" + name.replace("_", "-")
            if end is not None and np.isnan(end):
                raise ValueError(f"{option} must not be NaN")
            if end is not None and name in self.source.ends:
                raise ValueError(f"{self.path}: holds {name} for its rays; {option} {end:g} would be ignored, or they")

    def pieces(self, most: int, skip: int = 0) -> Iterator[TimedRays]:
        """The rays from number `skip` on, at most so many at a time. Raises ValueError, naming a bad ray's place."""
        done = skip
        try:
            for rows in self.source.rows(most, skip):
                yield TimedRays(self._rays(rows, done), self._end("t_min", rows, done), self._end("t_max", rows, done))
                done += len(rows.origins)
        except NotPlain as error:
            raise ValueError(f"{self.path}: {error}") from None

    def _rays(self, rows: Rows, first: int) -> Rays:
        origins, directions = (np.ascontiguousarray(x, dtype=np.float64) for x in (rows.origins, rows.directions))
        alive = np.ones(len(origins), np.bool_) if rows.starts is None else rows.starts != DEAD
        wrong = first_wrong(origins[alive], directions[alive])
        if wrong is not None:
            place = f"{rows.lines[wrong[0]]}" if rows.lines else f"ray {first + np.flatnonzero(alive)[wrong[0]]}"
            raise ValueError(f"{self.path}: {place}: {wrong[1]}")
        if rows.starts is None:
            return Rays(origins, directions)
        return Rays._spawned(origins, directions, rows.starts, self.source.home)

    def _end(self, name: str, rows: Rows, first: int) -> Any:
        found = getattr(rows, name)
        if found is None:
            return None
        wrong = np.flatnonzero(np.isnan(found))
        if len(wrong):
            raise ValueError(f"{self.path}: {name} must not be NaN, got NaN for ray {first + wrong[0]}")
        return np.asarray(found, np.float64)


class _NpySource:
    """A .npy file (..., 6)."""

    ends: tuple[str, ...] = ()
    home = None

    def __init__(self, path: Path) -> None:
        self._path = path
        with open_regular(path) as file:
            header = read_header(file)
            self._start = file.tell()
            size = os.fstat(file.fileno()).st_size - self._start
        if header.kind is None or not header.shape or header.shape[-1] != 6:
            raise ValueError(f"rays must be numbers of shape (..., 6), {', '.join(COLUMNS)}; got {header}")
        if header.fortran and len(header.shape) > 1:
            raise ValueError("its columns come first: np.ascontiguousarray(rays) is read piece by piece")
        if size < header.count * header.kind.itemsize:
            raise ValueError("it ends too early")
        self._kind = header.kind
        self.shape: tuple[int, ...] | None = header.shape[:-1]
        self._count = header.count // 6

    def rows(self, most: int, skip: int) -> Iterator[Rows]:
        each = 6 * self._kind.itemsize
        with open_regular(self._path) as file:
            file.seek(self._start + skip * each)
            for begin in range(skip, self._count, most):
                data = file.read(min(most, self._count - begin) * each)
                table = np.frombuffer(data, self._kind).astype(np.float64).reshape(-1, 6)
                yield Rows(table[:, :3], table[:, 3:])


class _CsvSource:
    """A .csv file of six columns."""

    shape = None
    ends: tuple[str, ...] = ()
    home = None

    def __init__(self, path: Path) -> None:
        self._path = path

    def rows(self, most: int, skip: int) -> Iterator[Rows]:
        for table, lines in csv_pieces(self._path, 6, COLUMNS, most):
            if skip < len(table):
                yield Rows(table[skip:, :3], table[skip:, 3:], lines=lines[skip:])
            skip = max(0, skip - len(table))
