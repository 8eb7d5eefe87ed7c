"""Files of rays, and tables of hits, spans, crossings, lengths and line integrals as .npz or .csv files.

`docs/files.md` describes the columns. `RayTable` holds a file of rays that was read whole; `ray_stream.py` reads larger
files in pieces.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.arrays import FloatArray
from .._util.file_errors import printable
from .._util.hints import closest_name
from .._util.safe_files import check_memory, open_regular, replace_file
from .._util.validation import format_list
from .data_files import read_array, read_rows
from .npz import NpyFormatError, NpzArchive
from .scene_file.nodes import shorten

if TYPE_CHECKING:
    from ..queries.scene_protocol import SceneLike


RAY_COLUMNS = ("origin x", "origin y", "origin z", "direction x", "direction y", "direction z")
RAY_ARRAYS = ("origins", "directions", "t_min", "t_max")
START_ARRAYS = ("starts", "starts_home")
HIT_ARRAYS = ("t", "point", "normal", "uv", "body", "face", "surface", "entering")
SPAN_ARRAYS = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped")
CROSSING_ARRAYS = ("t", "point", "normal", "body", "face", "surface", "entering", "before", "after")
"""The fields of hits, spans and crossings in tables of results, without error bounds."""
HIT_ERROR_ARRAYS, SPAN_ERROR_ARRAYS, CROSSING_ERROR_ARRAYS = (
    ("t_error",),
    ("t_enter_error", "t_exit_error"),
    ("t_error",),
)
RAY_BYTES = 400
"""Bytes that a ray and its hit take at most while results are assembled."""
Arrays = Mapping[str, np.ndarray[Any, Any]]


@dataclass(frozen=True)
class RayTable:
    """The rays of a file, of any leading shape, with one interval for all or one for each.

    `origins` and `directions` (..., 3) broadcast together; `t_min` and `t_max` broadcast to the shape of the rays.
    """

    origins: FloatArray
    directions: FloatArray
    t_min: Any = 0.0
    t_max: Any = float("inf")
    source: str = ""
    starts: Any = None
    """The surfaces that rays start on, with the key of their scene, as `Rays.save` writes them."""
    starts_home: Any = None
    ignored: tuple[str, ...] = ()
    """Names of other arrays in a .npz file."""
    lines: Sequence[int] = ()
    """The line number of each ray in a .csv file."""

    def within(self, t_min: float | None, t_max: float | None) -> RayTable:
        """Return the rays with one interval for all; None leaves an end as it is.

        Raise ValueError if the file has the same end for each ray, and for NaN.
        """
        ends: dict[str, Any] = {field: end for field, end in (("t_min", t_min), ("t_max", t_max)) if end is not None}
        for name, end in ends.items():
            if isinstance(getattr(self, name), np.ndarray):
                option = "--" + name.replace("_", "-")
                raise ValueError(
                    f"{self.source}: holds {name} for its rays; {option} {end:g} would be ignored, or they"
                )
            if math.isnan(end):
                raise ValueError(f"--{name.replace('_', '-')} must not be NaN")
        return replace(self, **ends)

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays."""
        return np.broadcast_shapes(self.origins.shape, self.directions.shape)[:-1]


def read_rays(path: str | os.PathLike[str]) -> RayTable:
    """Read rays from a .npy (..., 6), .npz or .csv file. Raise ValueError, with the name of the file, or OSError."""
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in (".npy", ".npz", ".csv"):
        raise ValueError(
            f"{file}: rays are read from .npy, .npz or .csv files, by trace and scene.stream also .parquet and .zarr"
        )
    open_regular(file).close()  # OSError for a missing file, before its content is judged
    try:
        table = _from_npz(file) if suffix == ".npz" else _from_columns(file, suffix)
        _check_shapes(table)
    except ValueError as error:
        raise ValueError(f"{file}: {str(error).removeprefix(file.name).lstrip(': ')}") from None
    return table


def ray_notes(table: RayTable) -> Iterator[str]:
    """Yield notes on a readable file of rays that may not be as its user intends: no rays, or unknown arrays."""
    if not (table.origins.size and table.directions.size):
        yield f"{table.source}: holds no rays"
    if table.ignored:
        names = format_list([printable(name) for name in table.ignored], 5)
        yield f"{table.source}: not read: {names}; arrays of rays are {', '.join(RAY_ARRAYS)}"


def _from_columns(file: Path, suffix: str) -> RayTable:
    if suffix == ".csv":
        rows, lines = read_rows(file, 6, RAY_COLUMNS)
        return RayTable(rows[:, :3], rows[:, 3:], source=str(file), lines=lines)
    header, table = read_array(file)
    if table is None or table.ndim == 0 or table.shape[-1] != 6:
        raise ValueError(f"rays must be numbers of shape (..., 6), {', '.join(RAY_COLUMNS)}; got {header}")
    return RayTable(table[..., :3], table[..., 3:], source=str(file))


def _from_npz(file: Path) -> RayTable:
    with open_regular(file) as opened:
        try:
            archive = NpzArchive(opened, os.fstat(opened.fileno()).st_size)
        except NpyFormatError as error:
            raise ValueError(f"is not a .npz file ({error})") from None
        if not {"origins", "directions"} <= set(archive.members):
            names = shorten(printable(", ".join(archive.members)) or "nothing", 120)
            raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {names}")
        for name in archive.members:
            if name not in (*RAY_ARRAYS, *START_ARRAYS) and (meant := closest_name(name, RAY_ARRAYS)):
                raise ValueError(f"unknown array {shorten(printable(name))!r} (did you mean {meant!r}?)")
        ignored = tuple(name for name in archive.members if name not in (*RAY_ARRAYS, *START_ARRAYS))
        arrays: dict[str, Any] = dict(archive.arrays((*RAY_ARRAYS, *START_ARRAYS)))
    return RayTable(**arrays, source=str(file), ignored=ignored)


def _check_shapes(table: RayTable) -> None:
    """Raise ValueError for arrays that are not of rays, and for so many rays that their hits would not fit into memory.

    Shapes are checked before broadcasting, so that a small file cannot make huge arrays.
    """
    origins, directions = table.origins.shape, table.directions.shape
    for name, shape in (("origins", origins), ("directions", directions)):
        if not shape or shape[-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), got {shape}")
    try:
        rays = np.broadcast_shapes(origins, directions)[:-1]
    except ValueError:
        raise ValueError(f"origins {origins} and directions {directions} do not broadcast together") from None
    count = math.prod(rays)
    try:
        check_memory(count * RAY_BYTES)
    except ValueError as error:
        raise ValueError(f"{count:,} rays with their hits: {error}") from None
    for name, times in (("t_min", table.t_min), ("t_max", table.t_max)):
        shape = np.shape(times)
        try:
            fits = np.broadcast_shapes(rays, shape) == rays
        except ValueError:
            fits = False
        if not fits:
            raise ValueError(f"t_min and t_max must broadcast to the rays' shape {rays}, got {name} of shape {shape}")
        if np.isnan(times).any():
            raise ValueError(f"{name} must not be NaN, got NaN at {int(np.flatnonzero(np.isnan(times))[0])}")


def write_hits(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Write first hits to .npz (arrays of the rays' leading shape) or .csv (a line for each ray)."""
    write_table(path, arrays, hit_columns(arrays))


def hit_columns(arrays: Arrays) -> dict[str, Any]:
    """Return the columns of first hits in a .csv file."""
    return {
        **_point_columns(arrays),
        **{name: arrays["uv"][..., i] for i, name in enumerate(("u", "v"))},
        **{name: arrays[name] for name in ("body", "face", "surface", "entering")},
        **{name: arrays[name] for name in ("t_error",) if name in arrays},
    }


def _point_columns(arrays: Arrays) -> dict[str, Any]:
    return {
        "t": arrays["t"],
        **{name: arrays["point"][..., i] for i, name in enumerate(("x", "y", "z"))},
        **{name: arrays["normal"][..., i] for i, name in enumerate(("normal_x", "normal_y", "normal_z"))},
    }


def write_spans(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Write spans to .npz (offsets and rows) or .csv (a line for each span, beginning with the number of its ray)."""
    write_table(path, arrays, span_columns(arrays))


def span_columns(arrays: Arrays, first: int = 0) -> dict[str, Any]:
    """Return the columns of spans in a .csv file; `first` is the number of the first ray."""
    columns = _ray_column(arrays, first)
    columns |= {name: arrays[name] for name in ("body", "t_enter", "t_exit", "enter_clipped", "exit_clipped")}
    return columns | {name: arrays[name] for name in SPAN_ERROR_ARRAYS if name in arrays}


def crossing_columns(arrays: Arrays, first: int = 0) -> dict[str, Any]:
    """Return the columns of crossings in a .csv file; `first` is the number of the first ray."""
    columns = _ray_column(arrays, first) | _point_columns(arrays)
    columns |= {name: arrays[name] for name in ("body", "face", "surface", "entering", "before", "after")}
    return columns | {name: arrays[name] for name in CROSSING_ERROR_ARRAYS if name in arrays}


def _ray_column(arrays: Arrays, first: int) -> dict[str, Any]:
    """Return the column of ray numbers: row i of the lists belongs to the ray whose offsets enclose i."""
    counts = np.diff(arrays["offsets"])
    return {"ray": np.repeat(np.arange(first, first + len(counts)), counts)}


def write_values(
    path: str | os.PathLike[str], name: str, values: Any, columns: Sequence[str], *, with_names: bool
) -> None:
    """Write numbers for each ray, (...) or (..., columns), to .npz (an array `name`) or .csv (a line for each ray).

    `with_names`: a .npz file also gets an array of texts, `columns`.
    """
    rows = np.asarray(values).reshape(-1, max(1, len(columns)))
    more = {"columns": np.array(columns, dtype=np.str_)} if with_names else {}
    write_table(path, {name: values, **more}, {quote_csv(column): rows[:, k] for k, column in enumerate(columns)})


def quote_csv(text: str) -> str:
    """Return a text for a .csv file, in quotes if a reader of such files would misread it."""
    line = printable(text)
    plain = not any(letter in line for letter in ',"') and line == line.strip() and not line.startswith("#")
    return line if plain else '"' + line.replace('"', '""') + '"'


def is_npz(path: str | os.PathLike[str]) -> bool:
    """Return True for the path of a .npz file."""
    return Path(path).suffix.lower() == ".npz"


def check_output(path: str | os.PathLike[str], suffixes: tuple[str, ...] = (".npz", ".csv")) -> None:
    """Raise ValueError for a path with another suffix; callers check before they compute results."""
    file = Path(path)
    if file.suffix.lower() not in suffixes:
        raise ValueError(f"{file}: results are written as {', '.join(suffixes[:-1])} or {suffixes[-1]}")


def write_table(path: str | os.PathLike[str], arrays: Arrays, columns: Arrays) -> None:
    """Write arrays to .npz, or columns to .csv; the file appears whole or not at all."""
    check_output(path)
    with replace_file(path) as partial:
        if is_npz(partial):
            np.savez(partial, **dict[str, Any](arrays))
            return
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(csv_lines(columns))


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


# Names of the columns of lengths and line integrals.


def length_columns(scene: SceneLike, by: str) -> list[str]:
    """Return a column name for each body or material of a scene: its name, or its number.

    `by` is "body" or "material". A name that occurs twice, or looks like a number's column, gets the number too.
    """
    if by == "body":
        names = [body.name for body in scene[:]]
    else:
        names = ["no material" if material is None else material.name for material in scene.materials]
    counts = Counter(names)
    return [
        f"{by} {number}" if not name
        else f"{by} {number} ({name})" if counts[name] > 1 or name.startswith(f"{by} ") else name
        for number, name in enumerate(names)
    ]  # fmt: skip


def integral_columns(energies: tuple[int, ...]) -> list[str]:
    """Return one column name, or one for each energy.

    `energies` is the part of an array's shape after the shape of the rays: () or (number of energies,).
    """
    return [f"line_integral_{k}" for k in range(energies[0])] if energies else ["line_integral"]
