"""Arrays in files beside a scene: .npy and .csv, data only, inside the scene's own folder."""

from __future__ import annotations

from array import array
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .atomic import replacing

MAX_BYTES = 4 << 30


def beside(folder: Path, name: str) -> Path:
    """The file `name` below `folder`; ValueError for an absolute path, a way out of it, or no file."""
    if PurePosixPath(name).is_absolute() or PureWindowsPath(name).drive or "\\" in name or "\0" in name:
        raise ValueError(f"must be a relative path with forward slashes, got {name!r}")
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"must stay inside the scene's folder, got {name!r}")
    if not path.is_file():
        raise ValueError(f"is not an existing file: {name!r} beside the scene")
    return path


def read_table(path: Path, columns: int, header: tuple[str, ...]) -> FloatArray:
    """(N, columns) float64 from a .npy or .csv file; ValueError says what is wrong, with the row.

    A .csv file has `columns` numbers in each line, with a header line or without; empty lines and
    lines that begin with # do not count. `header` names the columns in messages.
    """
    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"{path.name} is larger than {MAX_BYTES >> 30} GiB")
    suffix = path.suffix.lower()
    if suffix not in (".npy", ".csv"):
        raise ValueError(f"{path.name} must be a .npy or .csv file")
    table = load_array(path) if suffix == ".npy" else _read_csv(path, columns, header)
    if table.ndim != 2 or table.shape[1] != columns or table.dtype.kind not in "fiu":
        names = ", ".join(header)
        raise ValueError(
            f"{path.name} must hold numbers of shape (N, {columns}): {names}; got {table.dtype} {table.shape}"
        )
    return np.ascontiguousarray(table, dtype=np.float64)


def load_array(path: Path) -> np.ndarray[Any, Any]:
    """The array of a .npy file, memory-mapped, never unpickled; ValueError if it is none."""
    try:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, EOFError, TypeError, SyntaxError, OverflowError, MemoryError) as error:
        raise ValueError(f"{path.name} is not a .npy file of numbers ({str(error).splitlines()[0][:120]})") from None


def _read_csv(path: Path, columns: int, header: tuple[str, ...]) -> FloatArray:
    values = array("d")
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, line in enumerate(file, start=1):
                words = line.replace(",", " ").split()
                if not words or words[0].startswith("#"):
                    continue
                row = [_number(word) for word in words]
                if not values and all(value is None for value in row):
                    continue  # the header
                if len(row) != columns or None in row:
                    expected = f"{columns} numbers ({', '.join(header)})"
                    raise ValueError(f"{path.name}:{number}: must be {expected}, got {line.strip()[:60]!r}")
                values.extend(value for value in row if value is not None)
    except UnicodeDecodeError:
        raise ValueError(f"{path.name} is not a text in UTF-8") from None
    return np.array(values, dtype=np.float64).reshape(-1, columns)


def _number(word: str) -> float | None:
    try:
        return None if "_" in word else float(word)
    except ValueError:
        return None


def save_array(path: Path, values: FloatArray) -> None:
    """Write a .npy file, whole or not at all."""
    with replacing(path) as partial, partial.open("wb") as file:
        np.save(file, values, allow_pickle=False)
