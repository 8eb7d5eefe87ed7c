"""Files of rays, and files of what rays found: see docs/files.md for the columns."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .atomic import replacing
from .data_files import load_array, read_table

COLUMNS = ("origin x", "origin y", "origin z", "direction x", "direction y", "direction z")
MAX_BYTES = 64 << 30
Arrays = Mapping[str, np.ndarray[Any, Any]]


@dataclass(frozen=True)
class RayTable:
    """Rays of any leading shape, with one interval for all or one for each."""

    origins: FloatArray
    directions: FloatArray
    t_min: Any = 0.0
    t_max: Any = float("inf")


def read_rays(path: str | os.PathLike[str]) -> RayTable:
    """Rays from a .npy (..., 6), .npz or .csv file. Raises ValueError, naming the file, and OSError."""
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in (".npy", ".npz", ".csv"):
        raise ValueError(f"{file}: rays are read from .npy, .npz or .csv files")
    if file.is_dir():
        raise IsADirectoryError(21, "is a directory", str(file))
    with file.open("rb"):
        pass  # so that a missing file is an OSError in all cases
    try:
        return _from_npz(file) if suffix == ".npz" else _from_columns(file, suffix)
    except ValueError as error:
        raise ValueError(f"{file}: {str(error).removeprefix(file.name).lstrip(': ')}") from None


def _from_columns(file: Path, suffix: str) -> RayTable:
    table = load_array(file) if suffix == ".npy" else read_table(file, 6, COLUMNS)
    if table.ndim == 0 or table.shape[-1] != 6 or table.dtype.kind not in "fiu":
        raise ValueError(
            f"rays must be numbers of shape (..., 6), {', '.join(COLUMNS)}; got {table.dtype} {table.shape}"
        )
    return RayTable(np.array(table[..., :3], np.float64), np.array(table[..., 3:], np.float64))


def _from_npz(file: Path) -> RayTable:
    known = ("origins", "directions", "t_min", "t_max")
    try:
        with zipfile.ZipFile(file) as archive:
            if sum(item.file_size for item in archive.infolist()) > MAX_BYTES:
                raise ValueError(f"holds more than {MAX_BYTES >> 30} GiB")
        with np.load(file, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files if name in known}
            names = ", ".join(arrays.files) or "nothing"
    except (zipfile.BadZipFile, EOFError, KeyError, OSError, NotImplementedError) as error:
        raise ValueError(f"is not a .npz file ({str(error)[:120]})") from None
    if "origins" not in found or "directions" not in found:
        raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {names}")
    for name, array in found.items():
        if array.dtype.kind not in "fiu":
            raise ValueError(f"{name} must hold numbers, got {array.dtype}")
    return RayTable(**{name: np.asarray(array, np.float64) for name, array in found.items()})


def write_hits(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """First hits to .npz (arrays of the rays' leading shape) or .csv (a line for each ray)."""
    columns = {
        "t": arrays["t"],
        **{name: arrays["point"][..., i] for i, name in enumerate(("x", "y", "z"))},
        **{name: arrays["normal"][..., i] for i, name in enumerate(("normal_x", "normal_y", "normal_z"))},
        **{name: arrays["uv"][..., i] for i, name in enumerate(("u", "v"))},
        **{name: arrays[name] for name in ("body", "face", "surface", "entering")},
    }
    _write(path, arrays, columns)


def write_spans(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Spans to .npz (offsets and rows) or .csv (a line for each span, beginning with its ray's number)."""
    counts = np.diff(arrays["offsets"])
    columns = {"ray": np.repeat(np.arange(len(counts)), counts)}
    columns |= {name: arrays[name] for name in ("body", "t_enter", "t_exit", "enter_clipped", "exit_clipped")}
    _write(path, arrays, columns)


def check_output(path: str | os.PathLike[str]) -> None:
    """ValueError now, rather than after the work, where the results could not be written."""
    file = Path(path)
    if file.suffix.lower() not in (".npz", ".csv"):
        raise ValueError(f"{file}: results are written as .npz or .csv")


def _write(path: str | os.PathLike[str], arrays: Arrays, columns: Arrays) -> None:
    check_output(path)
    with replacing(path) as partial:
        if partial.suffix.lower() == ".npz":
            np.savez(partial, **dict[str, Any](arrays))
            return
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(_lines(columns))


def _lines(columns: Arrays) -> Iterator[str]:
    yield ",".join(columns) + "\n"
    flat = [np.asarray(column).reshape(-1) for column in columns.values()]
    plain = [column.astype(np.int8) if column.dtype == np.bool_ else column for column in flat]
    for begin in range(0, len(plain[0]), 65536):
        rows = zip(*(column[begin : begin + 65536].tolist() for column in plain), strict=True)
        yield from (",".join(map(repr, row)) + "\n" for row in rows)
