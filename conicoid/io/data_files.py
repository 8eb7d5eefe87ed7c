"""Arrays in .npy and .csv files beside a scene: data only, inside the folder of the scene.

Readers check paths, sizes and headings, and name file and line in errors; .npy files are written under names that carry
their digest.
"""

from __future__ import annotations

import io
import itertools
import os
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath

import numpy as np

from .._util.arrays import FloatArray
from .._util.files import open_regular, replace_file
from .npz import ArrayHeader, NpyFormatError, npy_chunks, read_npy_header, read_npy_values
from .scene_file.nodes import is_beyond_float64

MAX_DATA_BYTES = 4 << 30
MAX_LINE_LENGTH = 10_000


def resolve_data_file(folder: Path, name: str) -> Path:
    """Return the file `name` below `folder`.

    Raise ValueError for an absolute path, a path (or link) that leads out of the folder, or no file.
    """
    # By the rules of both systems, so that a scene is refused or accepted everywhere alike
    if PurePosixPath(name).is_absolute() or PureWindowsPath(name).drive or "\\" in name or "\0" in name:
        raise ValueError(f"must be a relative path with forward slashes, got {name!r}")
    try:
        # Links are followed before the comparison: a link may lead out of the folder
        path = (folder / name).resolve()
    except RuntimeError:  # Python's error for a circle of links
        raise ValueError(f"must not lead in a circle of links, got {name!r}") from None
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"must stay inside the scene's folder, got {name!r}")
    if not path.is_file():
        raise ValueError(f"is not an existing file: {name!r} beside the scene")
    if path.stat().st_size > MAX_DATA_BYTES:
        raise ValueError(f"is larger than {MAX_DATA_BYTES >> 30} GiB: {name!r}")
    return path


def read_rows(path: Path, columns: int, header: tuple[str, ...]) -> tuple[FloatArray, Sequence[int]]:
    """Return (N, columns) float64 from a .npy or .csv file, and for a .csv file the line number of each row.

    A .csv file has `columns` numbers in each line, after one header line or none; empty lines and
    lines that begin with # do not count. `header` names the columns, also in messages. Raise ValueError for a file of
    another kind, shape or size, and for a bad line.
    """
    suffix = path.suffix.lower()
    if suffix not in (".npy", ".csv"):
        raise ValueError(f"{path.name} must be a .npy or .csv file")
    if suffix == ".csv":
        return _read_csv(path, columns, header)
    found, table = read_array(path)
    if table is None or table.ndim != 2 or table.shape[1] != columns:
        names = ", ".join(header)
        raise ValueError(f"{path.name} must hold numbers of shape (N, {columns}): {names}; got {found}")
    return np.ascontiguousarray(table), ()


def read_array(path: Path) -> tuple[ArrayHeader, FloatArray | None]:
    """Return the header of a .npy file and its numbers as float64, or None if its items are not numbers.

    Raise ValueError if it is not a .npy file.
    """
    with open_regular(path) as file:
        try:
            header = read_npy_header(file)
            if header.kind is None:
                return header, None
            header.check_size(os.fstat(file.fileno()).st_size)
            return header, read_npy_values(file, header)
        except NpyFormatError as error:
            raise ValueError(f"{path.name} is not a .npy file of numbers ({error})") from None
        except ValueError as error:
            raise ValueError(f"{path.name} {error}") from None


def _read_csv(path: Path, columns: int, header: tuple[str, ...]) -> tuple[FloatArray, Sequence[int]]:
    (whole,) = read_csv_chunks(path, columns, header, None)
    return whole


def read_csv_chunks(
    path: Path, columns: int, header: tuple[str, ...], most: int | None
) -> Iterator[tuple[FloatArray, Sequence[int]]]:
    """Yield the rows of a .csv file (n, columns) and their line numbers, at most `most` rows at a time.

    For `most` = None yield all rows once, even if there are none. Raise ValueError, with file and line, as `read_rows`.
    """
    # Arrays of machine numbers, not lists: a file of rays may have hundreds of millions
    lines, values, heading, expected = array("q"), array("d"), "", f"{columns} numbers ({', '.join(header)})"
    found_any = False
    try:
        with io.TextIOWrapper(open_regular(path), encoding="utf-8-sig") as file:
            for number, line in enumerate(_lines(path, file), start=1):
                words = line.replace(",", " ").split()
                if not words or words[0].startswith("#"):
                    continue
                row = [_number(word) for word in words]
                # A heading is the first line with content, if none of its words is a number.
                if not found_any and not heading and all(value is None for value in row):
                    heading = line.strip()
                    check_heading(f"{path.name}:{number}", heading, header)
                    continue
                if len(row) != columns or None in row:
                    raise ValueError(f"{path.name}:{number}: must be {expected}, got {line.strip()[:60]!r}")
                found_any = True
                values.extend(value for value in row if value is not None)
                lines.append(number)
                if most is not None and len(lines) == most:
                    yield np.array(values, dtype=np.float64).reshape(-1, columns), lines
                    lines, values = array("q"), array("d")
    except UnicodeDecodeError:
        raise ValueError(f"{path.name} is not a text in UTF-8") from None
    if not found_any and len(_cells(heading)) != columns:
        found = f"only {heading[:60]!r}" if heading else "nothing"
        raise ValueError(f"{path.name} must have {expected} in each line, with commas or spaces between, got {found}")
    if lines or most is None:
        yield np.array(values, dtype=np.float64).reshape(-1, columns), lines


def _cells(heading: str) -> list[str]:
    return heading.split("," if "," in heading else None)


_COSINES = {"direction x": "u", "direction y": "v", "direction z": "w"}


def _aliases(name: str) -> set[str]:
    """Return the names that a column may have: for "origin x" originx, ox and x; for directions also u, v, w."""
    words = name.split()
    return {"".join(words), words[0][0] + "".join(words[1:]), words[-1], _COSINES.get(name, words[-1])}


def match_columns(names: Sequence[str], header: tuple[str, ...]) -> list[str] | None:
    """Return the name that stands for each column of `header`, or None if a column has no name of its own.

    A name such as x, which an origin and a direction share, is not enough.
    """
    plain = {"".join(c for c in name.casefold() if c.isalnum()): name for name in names}
    found = [[plain[own] for own in sorted(_aliases(name) - {name.split()[-1]}) if own in plain] for name in header]
    return [one[0] for one in found] if all(found) else None


_FOREIGN_COLUMNS = {
    "diameter",
    "diam",
    "theta",
    "phi",
    "azimuth",
    "elevation",
    "polar",
    "inclination",
    "distance",
    "range",
}
_END_POINT_SUFFIXES = ("2", "end", "target", "stop", "last", "final")


def _is_foreign_column(plain: str) -> bool:
    """Return True for the name of an angle, a diameter or an end point, which no file of points, balls or rays has."""
    of_end = any(plain == axis + end or plain == end + axis for axis in "xyz" for end in _END_POINT_SUFFIXES)
    return plain in _FOREIGN_COLUMNS or of_end


def check_heading(place: str, heading: str, header: tuple[str, ...]) -> None:
    """Raise ValueError for a header line with the name of a column in another's place, or with a foreign column."""
    # A file with its columns in another order would be read without any sign of it.
    for i, cell in enumerate(_cells(heading)):
        plain = "".join(c for c in cell.casefold() if c.isalnum())
        places = [k for k, name in enumerate(header) if plain in _aliases(name)]
        if places and i not in places:
            raise ValueError(f"{place}: columns must be in the order {', '.join(header)}, got {heading[:60]!r}")
        if not places and _is_foreign_column(plain):
            raise ValueError(
                f"{place}: columns are read as {', '.join(header)}, and {cell.strip()[:40]!r} is none of these"
            )


def _lines(path: Path, file: io.TextIOWrapper) -> Iterator[str]:
    """Yield the lines of a text. Raise ValueError for one that is longer than any line of numbers."""
    number = 0
    while line := file.readline(MAX_LINE_LENGTH + 1):
        number += 1
        if len(line) > MAX_LINE_LENGTH:
            raise ValueError(f"{path.name}:{number}: is longer than {MAX_LINE_LENGTH:,} characters")
        yield line


def _number(word: str) -> float | None:
    """Return a number that float64 holds, written infinities and NaN included; None for anything else."""
    try:
        value = None if "_" in word else float(word)  # float() accepts 1_000
    except ValueError:
        return None
    return None if value is not None and is_beyond_float64(word, value) else value


def save_array(path: Path, values: FloatArray) -> None:
    """Write a .npy file; it appears whole or not at all."""
    with replace_file(path) as partial, partial.open("wb") as file:
        for piece in npy_chunks(values):
            file.write(piece)


def array_file_name(folder: Path, stem: str, values: FloatArray) -> str:
    """Return a name in `folder` for a .npy file that holds exactly these values: it contains their SHA-256.

    If a file of that name holds something else, because somebody wrote into it, the name gets a number.
    """
    digest = content_digest(values)
    for attempt in itertools.count(1):
        name = f"{stem}-{digest[:32]}{f'-{attempt}' if attempt > 1 else ''}.npy"
        # lexists: a broken link is a name that somebody uses, too.
        if not os.path.lexists(folder / name) or _holds(folder / name, digest):
            return name
    raise AssertionError("unreachable")


def save_array_once(path: Path, values: FloatArray) -> None:
    """Write a file with a name from `array_file_name`, unless it exists."""
    if not os.path.lexists(path):
        save_array(path, values)


def content_digest(values: FloatArray) -> str:
    """Return the SHA-256 of the .npy file of an array, in hexadecimal digits."""
    import hashlib

    digest = hashlib.sha256()
    for piece in npy_chunks(values):
        digest.update(piece)
    return digest.hexdigest()


def _holds(path: Path, digest: str) -> bool:
    """Return True if a file, not a link, has the content of this digest: somebody may have written into it."""
    import hashlib

    try:
        if path.is_symlink():
            return False
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == digest
    except OSError:
        return False
