"""NumPy's .npy and .npz files: readers for untrusted files; and arrays in .npy and .csv files beside a scene.

A .npy file must have a plain header and then exactly the numbers that it declares. Unlike NumPy's reader this one
evaluates nothing, warns of nothing and knows no objects. Of a .npz file only requested arrays are read, and never more
than they declare. Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

import contextlib
import io
import itertools
import math
import os
import re
import struct
import sys
import zipfile
import zlib
from array import array
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import IO, Any, BinaryIO

import numpy as np

from .._util.arrays import FloatArray
from .._util.files import check_memory, open_regular, printable, replace_file
from .._util.records import dataclass
from .scene_file.nodes import is_beyond_float64

# .npy files.

MAGIC = b"\x93NUMPY"
BOOL_DTYPE = "|b1"
"""The name of the boolean type in files."""
MAX_HEADER_BYTES = 10_000
MAX_AXES = 32
NPY_CHUNK = 1 << 20

# One entry of the header's dict literal. The header is matched, never evaluated.
_HEADER_ENTRY = re.compile(
    r"""\s*(['"])(?P<key>\w{1,20})\1\s*:\s*
        (?: (?P<flag>True|False) | (['"])(?P<text>[^'"]{0,100})\4 | \((?P<axes>[\s\d,L]*)\) )
        \s*(?:,|$)""",
    re.VERBOSE,
)
_NUMBER_DTYPE = re.compile(r"[<>=|]?(?:[iu][1248]|f(?:2|4|8|16))")


class NpyFormatError(ValueError):
    """Raised for a file that is not an array of numbers; the message gives the reason."""


class RefusedArrayError(ValueError):
    """Raised for an array of a sound file that is refused; the message gives the reason."""


@dataclass(frozen=True)
class ArrayHeader:
    """The header of an array in a file: the name of its type, its shape, and Fortran's order."""

    type_name: str
    shape: tuple[int, ...]
    fortran: bool = False
    length: int = 0  # bytes of the header of a .npy file, magic and lengths included

    @property
    def kind(self) -> np.dtype[Any] | None:
        """The dtype, or None if it is not a type of integers or floating-point numbers of this machine."""
        try:
            return np.dtype(self.type_name) if _NUMBER_DTYPE.fullmatch(self.type_name) else None
        except TypeError:
            return None

    @property
    def count(self) -> int:
        """The number of items."""
        return math.prod(self.shape)

    @property
    def by_rows(self) -> bool:
        """Whether the items of a row lie together, so that rows can be read one after the other."""
        return not self.fortran or len(self.shape) < 2

    def check_memory(self) -> None:
        """Raise RefusedArrayError for more numbers than memory holds as float64."""
        try:
            check_memory(self.count * 8)
        except ValueError as error:
            raise RefusedArrayError(str(error)) from None

    def check_size(self, size: int) -> None:
        """Raise NpyFormatError unless a .npy file of `size` bytes holds the header, the numbers, and nothing else."""
        expected = self.length + self.count * np.dtype(self.type_name).itemsize
        if size != expected:
            raise NpyFormatError(f"its header announces {expected:,} bytes, it has {size:,}")

    def __str__(self) -> str:
        return f"{printable(self.type_name)} {self.shape}"


def read_npy_header(file: IO[bytes]) -> ArrayHeader:
    """Read the header at the start of a .npy file. Raise NpyFormatError if it is not plain."""
    start = _read_exactly(file, 8)
    if start[:6] != MAGIC:
        raise NpyFormatError("it does not begin like one")
    if start[6:] not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise NpyFormatError(f"it is of version {start[6]}.{start[7]}, known are 1.0, 2.0 and 3.0")
    width = 2 if start[6] == 1 else 4
    length = int.from_bytes(_read_exactly(file, width), "little")
    # Before it is read: a header may claim 4 GiB
    if length > MAX_HEADER_BYTES:
        raise NpyFormatError(f"its header is {length:,} bytes long, at most {MAX_HEADER_BYTES:,} are read")
    text = _read_exactly(file, length).decode("latin-1").strip()
    return _parse_header(text, 8 + width + length)


def _parse_header(text: str, length: int) -> ArrayHeader:
    if not (text.startswith("{") and text.endswith("}")):
        raise NpyFormatError("its header is not that of an array of numbers")
    inner, position = text[1:-1].strip(), 0
    entries: dict[str, re.Match[str]] = {}
    while position < len(inner):
        match = _HEADER_ENTRY.match(inner, position)
        # A key that comes twice could show one value to the check, and another to a reader
        if match is None or match["key"] in entries:
            raise NpyFormatError("its header is not that of an array of numbers")
        entries[match["key"]], position = match, match.end()
    if set(entries) != {"descr", "fortran_order", "shape"}:
        raise NpyFormatError("its header must say descr, fortran_order and shape, and nothing else")
    name, flag, axes = entries["descr"]["text"], entries["fortran_order"]["flag"], entries["shape"]["axes"]
    if name is None or flag is None or axes is None:
        raise NpyFormatError("its header is not that of an array of numbers")
    # Objects are pickles, which execute code
    if "O" in name:
        raise NpyFormatError("it holds Python objects, which are never read")
    return ArrayHeader(name, _parse_shape(axes), flag == "True", length)


def _parse_shape(text: str) -> tuple[int, ...]:
    axes = [axis.strip().removesuffix("L") for axis in text.split(",")]
    axes = axes[:-1] if axes[-1] == "" else axes
    # 18 digits fit into 64 bits; int() of thousands of digits would take long
    if len(axes) > MAX_AXES or not all(axis.isdecimal() and len(axis) < 19 for axis in axes):
        raise NpyFormatError(f"its shape ({' '.join(text.split())[:60]}) is not that of an array")
    shape = tuple(map(int, axes))
    # Zero axes count as 1, so that no axis of an empty array is too long for NumPy either.
    if math.prod(max(axis, 1) for axis in shape) >= 1 << 56:
        raise NpyFormatError(f"its shape {shape} is that of no array")
    return shape


def read_npy_values(file: IO[bytes], header: ArrayHeader) -> FloatArray:
    """Return all numbers of a .npy file as float64. Raise the errors of `read_numbers`."""
    header.check_memory()
    array = ArrayRows(file, header, 0, 0)
    values = array.next(1)[0]
    array.finish()
    return np.asarray(values, order="C")  # kernels read by rows, and a file may hold columns


def read_numbers(file: IO[bytes], header: ArrayHeader, count: int) -> FloatArray:
    """Read the next `count` numbers of an array as float64. Neither a buffer nor a read is larger than `NPY_CHUNK`.

    Raise NpyFormatError if the file ends too early, and RefusedArrayError for numbers that do not fit into memory or
    into float64.
    """
    kind = np.dtype(header.type_name)
    try:
        # Memory is taken by the header's word, which `check_memory` and the size of the file have confirmed
        values = np.empty(count)
    except MemoryError:
        raise RefusedArrayError(f"takes {count * 8 / 2**30:,.1f} GiB, more memory than there is left") from None
    # In pieces, so that the file's own type never doubles the memory
    step = NPY_CHUNK // kind.itemsize
    for begin in range(0, count, step):
        part = values[begin : begin + step]
        raw = np.frombuffer(_read_exactly(file, len(part) * kind.itemsize), kind)
        with np.errstate(all="ignore"):
            part[:] = raw
            # Only long doubles have a larger range than float64.
            if kind.itemsize > 8 and (np.isinf(part) & ~np.isinf(raw)).any():
                raise RefusedArrayError("holds numbers beyond the range of float64")
    return values


class ArrayRows:
    """An array of an open file, read forwards from row `skip` on.

    Its first `axes` axes count as one. Without any the array is one row, which may be in Fortran's order.
    """

    def __init__(self, file: IO[bytes], header: ArrayHeader, axes: int, skip: int) -> None:
        self._file, self._header, self._last = file, header, header.shape[axes:]
        self._each = math.prod(self._last)
        self.count = math.prod(header.shape[:axes])
        # A compressed member is read and dropped up to there, in bounded pieces
        file.seek(header.length + skip * self._each * np.dtype(header.type_name).itemsize)

    def next(self, count: int) -> FloatArray:
        """Return the next `count` rows. Raise the errors of `read_numbers`."""
        values = read_numbers(self._file, self._header, count * self._each)
        if self._header.by_rows:
            return values.reshape(count, *self._last)
        # Fortran's order is C's order of the axes reversed
        return values.reshape(self._last[::-1]).T[None]

    def finish(self) -> None:
        """Read the end of the file, where an archive compares the checksum."""
        # zipfile compares the checksum only when it reads beyond the last byte
        self._file.read(1)


def _read_exactly(file: IO[bytes], count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise NpyFormatError("it ends too early")
    return data


def npy_chunks(values: FloatArray) -> list[bytes | memoryview]:
    """Return the bytes of a .npy file of an array as float64, in pieces: version 1.0, little-endian, C order."""
    table = np.ascontiguousarray(values, dtype="<f8")
    text = repr({"descr": "<f8", "fortran_order": False, "shape": table.shape})
    padding = -(len(MAGIC) + 4 + len(text) + 1) % 64  # the format aligns the numbers to 64 bytes
    header = f"{text}{' ' * padding}\n".encode("latin-1")
    content = table.data.cast("B") if table.size else b""
    return [MAGIC + b"\x01\x00" + len(header).to_bytes(2, "little") + header, content]


# .npz files, read without trust.

FREE_BYTES, MAX_COMPRESSION = 256 << 20, 50
"""Compressed arrays of a file may unpack to `FREE_BYTES` and `MAX_COMPRESSION` times the size of the file."""
_MAX_READ = 4 << 20
"""Most bytes of one read of an archive; an archive with a longer directory is refused."""
ZIP_ERRORS = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error, EOFError, OSError, LookupError,
    NotImplementedError, RuntimeError, ArithmeticError, AttributeError, TypeError, ValueError, MemoryError,
)  # fmt: skip
"""Errors that the standard library's reader raises for damaged archives."""


class _BoundedFile:
    """A file that limits the size of one read, so that `zipfile` cannot load a huge directory into memory."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.most = file, _MAX_READ

    def read(self, count: int = -1) -> bytes:
        # One byte more than allowed, which tells a longer read from one that just fits
        data = self.file.read(self.most + 1 if count < 0 else min(count, self.most + 1))
        if len(data) > self.most:
            raise zipfile.BadZipFile("its directory is too long")
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self.file.seek(offset, whence)

    def tell(self) -> int:
        return self.file.tell()

    def seekable(self) -> bool:
        return True


class NpzArchive:
    """A .npz file: its directory, and the arrays on request. Raise ValueError if it is none."""

    def __init__(self, file: BinaryIO) -> None:
        self.size = os.fstat(file.fileno()).st_size
        self.budget = FREE_BYTES + MAX_COMPRESSION * self.size  # bytes that compressed arrays may still take
        bounded = _BoundedFile(file)
        try:
            self.zip = zipfile.ZipFile(bounded)
        except ZIP_ERRORS as error:
            raise ValueError(f"is not a .npz file ({failure_reason(error)})") from None
        bounded.most = sys.maxsize  # members are read in pieces, and skipped in larger ones
        self.members: dict[str, zipfile.ZipInfo] = {}
        for info in self.zip.infolist():
            # Two members of one name would let check and reading see different arrays
            name = info.filename.removesuffix(".npy")
            if name in self.members:
                raise ValueError(f"is not a .npz file (it holds {printable(name[:60])!r} twice)")
            self.members[name] = info

    def arrays(self, names: Collection[str], flags: Collection[str] = ()) -> dict[str, FloatArray]:
        """Return those of the arrays `names` that the file has, as float64.

        Arrays in `flags` may also be booleans, which NumPy writes as bytes 0 or 1. Raise ValueError, with the name of
        the array, if one is not of numbers or too large.
        """
        arrays = {}
        for name in names:
            if name in self.members:
                with self.naming(name):
                    arrays[name] = read_npy_values(*self.open(name, True, name in flags))
        return arrays

    @contextlib.contextmanager
    def naming(self, name: str) -> Iterator[None]:
        """Turn every error of an array into a ValueError with its name."""
        try:
            yield
        except RefusedArrayError as error:
            raise ValueError(f"{name} {error}") from None
        except NpyFormatError as error:
            raise ValueError(f"{name} is not an array of numbers ({error})") from None
        except ZIP_ERRORS as error:
            raise ValueError(f"{name} is not an array of numbers ({failure_reason(error)})") from None

    def open(self, name: str, whole: bool, is_flag: bool = False) -> tuple[IO[bytes], ArrayHeader]:
        """Return an array and its header, before any number is read.

        whole: all of it will be in memory at once; raise an error if that is too much. The errors lack its name.
        """
        info = self.members[name]
        # Bit 0: encrypted
        if info.flag_bits & 0x1:
            raise NpyFormatError("it is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NpyFormatError("it is compressed in a way that NumPy does not write")
        file = self.zip.open(info)
        header = read_npy_header(file)
        if is_flag and header.type_name == BOOL_DTYPE:
            header = replace(header, type_name="|u1")
        if header.kind is None:
            raise RefusedArrayError(f"must hold numbers, got {header}")
        if whole:
            self._charge(info, header)
            header.check_memory()
        header.check_size(info.file_size)
        return file, header

    def _charge(self, info: zipfile.ZipInfo, header: ArrayHeader) -> None:
        """Raise RefusedArrayError if the compressed arrays of a file become too large for a file of its size."""
        if info.compress_type != zipfile.ZIP_STORED:
            # For all arrays together: many small bombs are one large one
            self.budget -= header.count * 8
        if self.budget < 0:
            most = (FREE_BYTES + MAX_COMPRESSION * self.size) / 2**30
            size = header.count * 8 / 2**30
            raise RefusedArrayError(f"unpacks to {size:,.1f} GiB, a file of this size may hold at most {most:,.2f} GiB")


def failure_reason(error: BaseException) -> str:
    """Return the first line of an error's message, printable and short, or the name of its class."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for it"
    return printable((str(error).splitlines() or [type(error).__name__])[0][:120])


# Arrays in .npy and .csv files beside a scene: data only, inside the folder of the scene.
#
# Readers check paths, sizes and headings, and name file and line in errors; .npy files are written under names that
# carry their digest.

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
