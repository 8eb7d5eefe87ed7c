"""Files of rays, .npy, .npz, .csv, .parquet and .zarr: whole, or in pieces where memory does not hold them.

`docs/reference/files.md` describes the arrays and columns. `array_file.py` reads the numbers; here they become rays.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._util.files import check_memory, printable
from .._util.text import closest_name
from .._util.validation import format_list
from ..kernels.ray import DEAD
from ..queries.rays import Rays, find_invalid_ray
from .array_file import LINE, SOURCE_SUFFIXES, TABLE, Rows, as_integers, open_source, row_ranges

RAY_COLUMNS = ("origin x", "origin y", "origin z", "direction x", "direction y", "direction z")
_ORIGINS, _DIRECTIONS, _STARTS, _HOME = "origins", "directions", "starts", "starts_home"
_LIMITS = ("t_min", "t_max")
_LAST_AXES: dict[str, tuple[int, ...]] = {TABLE: (6,), _ORIGINS: (3,), _DIRECTIONS: (3,), "t_min": (), "t_max": ()}
"""The axes of arrays after those of the rays."""
_USER_ARRAYS = (_ORIGINS, _DIRECTIONS, *_LIMITS)
_KNOWN_ARRAYS = (*_USER_ARRAYS, _STARTS, _HOME)
"""`Rays.save` adds the surfaces that rays start on, and the key of their scene."""
_RAY_BYTES = 400
"""Bytes that a ray and its hit take at most while results are assembled."""


class TimedRays(NamedTuple):
    """Rays with the ends of their intervals, of the same shape, or None where the file has none."""

    rays: Rays
    t_min: Any
    t_max: Any

    def limits(self, t_min: Any, t_max: Any) -> dict[str, Any]:
        """Return the ends as arguments of queries; those of the caller stand for missing ones, and None for none."""
        ends = (other if own is None else own for own, other in ((self.t_min, t_min), (self.t_max, t_max)))
        return {name: end for name, end in zip(_LIMITS, ends, strict=True) if end is not None}


class RayFile:
    """A file of rays.

    `shape` is the leading shape of the rays, None for a .csv file, whose number of rays is known at its end. `home` is
    the key of the scene on whose surfaces the rays start, if any. With `whole`, rays that do not fit into memory with
    their hits are refused before any is read.

    Raise ValueError, with the name of the file, OSError, and ImportError if the reader of the format is not installed.
    """

    def __init__(self, path: str | os.PathLike[str], whole: bool = False) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() not in SOURCE_SUFFIXES:
            suffixes = f"{', '.join(SOURCE_SUFFIXES[:-1])} or {SOURCE_SUFFIXES[-1]}"
            raise ValueError(f"{self.path}: rays are read from {suffixes} files")
        with self._errors():
            self._source = open_source(self.path, _KNOWN_ARRAYS, RAY_COLUMNS, whole)
            self._headers = {name: header for name, header in self._source.headers.items() if name != _HOME}
            self._leading = self._find_shape()
            self._count = math.prod(self._leading)
            self._check_limits()
            if whole:
                _check_memory(self._count)
            self.home = self._read_home()
            full = {name: (*self._leading, *last) for name, last in _LAST_AXES.items()} | {_STARTS: (self._count,)}
            # Only arrays of full shape have rows to read; others broadcast, and are small
            self._streamed = [name for name, each in self._headers.items() if each.by_rows and each.shape == full[name]]
            self._small = {
                name: self._whole(name) if name == _STARTS else np.broadcast_to(self._whole(name), full[name])
                for name in self._headers if name not in self._streamed
            }  # fmt: skip

    @property
    def shape(self) -> tuple[int, ...] | None:
        """The leading shape of the rays, None if it is known only at the end of the file."""
        return self._leading if self._count >= 0 else None

    @contextlib.contextmanager
    def _errors(self) -> Iterator[None]:
        """Begin errors with the path."""
        try:
            yield
        except ValueError as error:
            raise ValueError(f"{self.path}: {str(error).removeprefix(self.path.name).lstrip(': ')}") from None

    def _find_shape(self) -> tuple[int, ...]:
        """Return the leading shape of the rays. Raise ValueError for other arrays than those of rays."""
        headers, table = self._headers, self._headers.get(TABLE)
        if table is not None:
            if table.kind is None or table.shape[-1:] != (6,):
                raise ValueError(f"rays must be numbers of shape (..., 6), {', '.join(RAY_COLUMNS)}; got {table}")
            return table.shape[:-1]
        if not {_ORIGINS, _DIRECTIONS} <= set(headers):
            names = printable(", ".join((*headers, *self._source.other_columns)))[:120] or "nothing"
            raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {names}")
        for name in self._source.other_columns:
            if meant := closest_name(name, _USER_ARRAYS):
                raise ValueError(f"unknown array {printable(name)[:60]!r} (did you mean {meant!r}?)")
        for name, header in headers.items():
            if header.kind is None:
                raise ValueError(f"{name} must hold numbers, got {header}")
        origins, directions = headers[_ORIGINS].shape, headers[_DIRECTIONS].shape
        for name, shape in ((_ORIGINS, origins), (_DIRECTIONS, directions)):
            if shape[-1:] != (3,):
                raise ValueError(f"{name} must have shape (..., 3), got {shape}")
        try:
            # By their shapes alone, so that a small file cannot make huge arrays
            return np.broadcast_shapes(origins, directions)[:-1]
        except ValueError:
            raise ValueError(f"origins {origins} and directions {directions} do not broadcast together") from None

    def _check_limits(self) -> None:
        """Raise ValueError for intervals and starts of other shapes than that of the rays."""
        rays = self._leading
        for name in _LIMITS:
            shape = self._headers[name].shape if name in self._headers else ()
            try:
                fits = rays == (-1,) or np.broadcast_shapes(rays, shape) == rays
            except ValueError:
                fits = False
            if not fits:
                raise ValueError(
                    f"t_min and t_max must broadcast to the rays' shape {rays}, got {name} of shape {shape}"
                )
        starts = self._headers[_STARTS].shape if _STARTS in self._headers else (1,)
        if starts not in ((1,), (self._count,)):
            raise ValueError(f"starts must have shape (1,) or ({self._count},), got {starts}")

    def _whole(self, name: str) -> Any:
        """Return a whole array."""
        (piece,) = self._source.rows((name,), 0, None, 0)
        return piece[name][0]

    def _read_home(self) -> bytes | None:
        """Return the key of the scene of the starts."""
        if _HOME not in self._source.headers:
            return None
        key: bytes = as_integers(_HOME, self._whole(_HOME), 0, 255, np.uint8).tobytes()
        return key or None

    @property
    def limits(self) -> tuple[str, ...]:
        """Those of "t_min" and "t_max" that the file has."""
        return tuple(name for name in _LIMITS if name in self._headers)

    def check_limits(self, t_min: float | None, t_max: float | None) -> None:
        """Raise ValueError if the caller passes an end that the file has for each ray, and for NaN."""
        for name, end in zip(_LIMITS, (t_min, t_max), strict=True):
            if end is not None and np.isnan(end):
                raise ValueError(f"{name} must not be NaN")
            if end is not None and name in self._headers:
                raise ValueError(
                    f"{self.path}: holds {name} of each ray, so one {name} for all, {end:g}, cannot be given"
                )

    def notes(self) -> Iterator[str]:
        """Yield notes on a readable file that may not be as its user intends: no rays, or unknown arrays."""
        with self._errors():
            if self._count <= 0 and not any(True for _ in self._pieces(1, 0)):
                yield f"{self.path}: holds no rays"
        if self._source.other_columns:
            names = format_list([printable(name) for name in self._source.other_columns], 5)
            yield f"{self.path}: not read: {names}; arrays of rays are {', '.join(_USER_ARRAYS)}"

    def read(self) -> TimedRays:
        """Return all rays in their leading shape. Raise ValueError as `pieces`."""
        (flat,) = self.pieces(None)
        shape = flat.rays.shape if self.shape is None else self.shape
        with self._errors():
            _check_memory(flat.rays.size)
        origins, directions = (lines.reshape(*shape, 3) for lines in (flat.rays.origins, flat.rays.directions))
        ends = (None if end is None else end.reshape(shape) for end in flat[1:])
        return TimedRays(Rays._spawned(origins, directions, flat.rays._starts, flat.rays._home), *ends)

    def pieces(self, most: int | None, skip: int = 0) -> Iterator[TimedRays]:
        """Yield the flat rays from number `skip` on, at most `most` at a time; None stands for all at once.

        Raise ValueError, with the number or line of the ray, for an invalid one.
        """
        with self._errors():
            for begin, rows in self._pieces(most, skip):
                ends = (self._limit(name, rows, begin) for name in _LIMITS)
                yield TimedRays(self._rays(rows, begin), *ends)

    def _pieces(self, most: int | None, skip: int) -> Iterator[tuple[int, Rows]]:
        """Yield the number of the first ray and the arrays of each piece."""
        if not self._streamed:
            for begin, end in row_ranges(self._count, most, skip):
                yield begin, self._small_rows(begin, end)
            return
        for rows in self._source.rows(self._streamed, len(self._leading), most, skip):
            end = skip + len(rows[self._streamed[0]])
            yield skip, rows | self._small_rows(skip, end)
            skip = end

    def _small_rows(self, begin: int, end: int) -> Rows:
        """Return rows of the arrays in memory, which stand for all rays."""
        small = {name: array for name, array in self._small.items() if name != _STARTS}
        places = np.unravel_index(np.arange(begin, end), self._leading) if small else ()
        rows = {name: array[places] for name, array in small.items()}
        if _STARTS in self._small:
            rows[_STARTS] = np.broadcast_to(self._small[_STARTS], (end - begin,))
        return rows

    def _rays(self, rows: Rows, first: int) -> Rays:
        """Return the rays of some rows; `first` is the number of the first. Dead rays need not be valid."""
        both = np.split(rows[TABLE], 2, axis=1) if TABLE in rows else (rows[_ORIGINS], rows[_DIRECTIONS])
        origins, directions = map(np.ascontiguousarray, both)
        starts = as_integers(_STARTS, rows.get(_STARTS, np.array([-1.0])), -(2**31), 2**31 - 1, np.int32).reshape(-1)
        # Rays from misses have no point, and NaN is right there
        alive = np.flatnonzero(np.broadcast_to(starts != DEAD, len(origins)))
        every = len(alive) == len(origins)
        wrong = find_invalid_ray(*((origins, directions) if every else (origins[alive], directions[alive])))
        if wrong is not None:
            place = alive[wrong[0]]
            raise ValueError(f"{rows[LINE][place] if LINE in rows else f'ray {first + place}'}: {wrong[1]}")
        return Rays._spawned(origins, directions, starts, self.home)

    def _limit(self, name: str, rows: Rows, first: int) -> Any:
        """Return `t_min` or `t_max` of some rows, None if they have none. Raise ValueError for NaN."""
        values = rows.get(name)
        if values is not None and np.isnan(values).any():
            raise ValueError(f"{name} must not be NaN, got NaN for ray {first + np.flatnonzero(np.isnan(values))[0]}")
        return values


def _check_memory(count: int) -> None:
    """Raise ValueError for so many rays that their hits would not fit into memory."""
    try:
        check_memory(count * _RAY_BYTES)
    except ValueError as error:
        raise ValueError(f"{count:,} rays with their hits: {error}") from None
