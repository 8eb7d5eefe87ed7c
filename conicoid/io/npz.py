"""NumPy's .npy and .npz files: readers for untrusted files, and writers for arrays that lie in files.

A .npy file must have a plain header and then exactly the numbers that it declares. Unlike NumPy's reader this one
evaluates nothing, warns of nothing and knows no objects. Of a .npz file only requested arrays are read, and never more
than they declare. Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import IO, Any, BinaryIO

import numpy as np

from .._util.arrays import FloatArray
from .._util.file_errors import printable
from .._util.safe_files import check_memory, replace_file

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


@dataclass(frozen=True)
class NpyHeader:
    """The header of a .npy file: the name of the type, the shape, and whether the order is Fortran's."""

    type_name: str
    shape: tuple[int, ...]
    fortran: bool
    length: int  # bytes of the header itself, magic and lengths included

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

    def __str__(self) -> str:
        return f"{printable(self.type_name)} {self.shape}"


def read_npy_header(file: IO[bytes]) -> NpyHeader:
    """Read the header at the start of a .npy file. Raise NpyFormatError if it is not plain."""
    start = _read_exactly(file, 8)
    if start[:6] != MAGIC:
        raise NpyFormatError("it does not begin like one")
    if start[6:] not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise NpyFormatError(f"it is of version {start[6]}.{start[7]}, known are 1.0, 2.0 and 3.0")
    width = 2 if start[6] == 1 else 4
    length = int.from_bytes(_read_exactly(file, width), "little")
    if length > MAX_HEADER_BYTES:
        raise NpyFormatError(f"its header is {length:,} bytes long, at most {MAX_HEADER_BYTES:,} are read")
    text = _read_exactly(file, length).decode("latin-1").strip()
    return _parse_header(text, 8 + width + length)


def _parse_header(text: str, length: int) -> NpyHeader:
    if not (text.startswith("{") and text.endswith("}")):
        raise NpyFormatError("its header is not that of an array of numbers")
    inner, position = text[1:-1].strip(), 0
    entries: dict[str, re.Match[str]] = {}
    while position < len(inner):
        match = _HEADER_ENTRY.match(inner, position)
        if match is None or match["key"] in entries:
            raise NpyFormatError("its header is not that of an array of numbers")
        entries[match["key"]], position = match, match.end()
    if set(entries) != {"descr", "fortran_order", "shape"}:
        raise NpyFormatError("its header must say descr, fortran_order and shape, and nothing else")
    name, flag, axes = entries["descr"]["text"], entries["fortran_order"]["flag"], entries["shape"]["axes"]
    if name is None or flag is None or axes is None:
        raise NpyFormatError("its header is not that of an array of numbers")
    if "O" in name:
        raise NpyFormatError("it holds Python objects, which are never read")
    return NpyHeader(name, _parse_shape(axes), flag == "True", length)


def _parse_shape(text: str) -> tuple[int, ...]:
    axes = [axis.strip().removesuffix("L") for axis in text.split(",")]
    axes = axes[:-1] if axes[-1] == "" else axes
    if len(axes) > MAX_AXES or not all(axis.isdecimal() and len(axis) < 19 for axis in axes):
        raise NpyFormatError(f"its shape ({' '.join(text.split())[:60]}) is not that of an array")
    shape = tuple(map(int, axes))
    # Zero axes count as 1, so that no axis of an empty array is too long for NumPy either.
    if math.prod(max(axis, 1) for axis in shape) >= 1 << 56:
        raise NpyFormatError(f"its shape {shape} is that of no array")
    return shape


def read_npy_values(file: IO[bytes], header: NpyHeader, kind: np.dtype[Any], size: int) -> FloatArray:
    """Read the numbers after a header as float64, from a file of `size` bytes that must hold nothing else.

    Raise NpyFormatError if the size is another, and ValueError for numbers that do not fit into memory or into float64.
    """
    expected = header.length + header.count * kind.itemsize
    if size != expected:
        raise NpyFormatError(f"its header announces {expected:,} bytes, it has {size:,}")
    check_memory(header.count * 8)
    try:
        values = np.empty(header.count)
    except MemoryError:
        raise ValueError(f"takes {header.count * 8 / 2**30:,.1f} GiB, more memory than there is left") from None
    step = NPY_CHUNK // kind.itemsize
    for begin in range(0, header.count, step):
        part = values[begin : begin + step]
        raw = np.frombuffer(_read_exactly(file, len(part) * kind.itemsize), kind)
        with np.errstate(all="ignore"):
            part[:] = raw
            # Only long doubles have a larger range than float64.
            if kind.itemsize > 8 and (np.isinf(part) & ~np.isinf(raw)).any():
                raise ValueError("holds numbers beyond the range of float64")
    file.read(1)  # the end of the file, where an archive compares the checksum
    return values.reshape(header.shape[::-1]).T if header.fortran else values.reshape(header.shape)


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
        self.file = file

    def read(self, count: int = -1) -> bytes:
        data = self.file.read(_MAX_READ + 1 if count < 0 else min(count, _MAX_READ + 1))
        if len(data) > _MAX_READ:
            raise zipfile.BadZipFile("its directory is too long")
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self.file.seek(offset, whence)

    def tell(self) -> int:
        return self.file.tell()

    def seekable(self) -> bool:
        return True


class NpzArchive:
    """A .npz file of `size` bytes: its directory, and the arrays on request. Raise NpyFormatError if it is none."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self.size = size
        self.left = FREE_BYTES + MAX_COMPRESSION * size  # bytes that compressed arrays may still take
        try:
            self.zip = zipfile.ZipFile(_BoundedFile(file))
        except ZIP_ERRORS as error:
            raise NpyFormatError(failure_reason(error)) from None
        self.members: dict[str, zipfile.ZipInfo] = {}
        for info in self.zip.infolist():
            name = info.filename.removesuffix(".npy")
            if name in self.members:
                raise NpyFormatError(f"it holds {printable(name[:60])!r} twice")
            self.members[name] = info

    def arrays(self, wanted: Collection[str], flags: Collection[str] = ()) -> dict[str, FloatArray]:
        """Return those of the `wanted` arrays that the file has, as float64.

        Arrays in `flags` may also be booleans, which NumPy writes as bytes 0 or 1. Raise ValueError, with the name of
        the array, if one is not of numbers or too large.
        """
        arrays = {}
        for name in wanted:
            if name in self.members:
                try:
                    arrays[name] = self._array(self.members[name], name in flags)
                except NpyFormatError as error:
                    raise ValueError(f"{name} is not an array of numbers ({error})") from None
                except ValueError as error:
                    raise ValueError(f"{name} {error}") from None
        return arrays

    def _array(self, info: zipfile.ZipInfo, is_flag: bool) -> FloatArray:
        if info.flag_bits & 0x1:
            raise NpyFormatError("it is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NpyFormatError("it is compressed in a way that NumPy does not write")
        try:
            with self.zip.open(info) as file:
                return self._values(info, file, is_flag)
        except (NpyFormatError, _RefusedArray):
            raise
        except ZIP_ERRORS as error:
            raise NpyFormatError(failure_reason(error)) from None

    def _values(self, info: zipfile.ZipInfo, file: IO[bytes], is_flag: bool) -> FloatArray:
        header = read_npy_header(file)
        kind = np.dtype(np.uint8) if is_flag and header.type_name == BOOL_DTYPE else header.kind
        if kind is None:
            raise _RefusedArray(f"must hold numbers, got {header}")
        self._charge(info, header)
        try:
            return read_npy_values(file, header, kind, info.file_size)
        except NpyFormatError:
            raise
        except ValueError as error:
            raise _RefusedArray(str(error)) from None

    def _charge(self, info: zipfile.ZipInfo, header: NpyHeader) -> None:
        """Raise _RefusedArray if the compressed arrays of a file become too large for a file of its size."""
        if info.compress_type != zipfile.ZIP_STORED:
            self.left -= header.count * 8
        if self.left < 0:
            most = (FREE_BYTES + MAX_COMPRESSION * self.size) / 2**30
            size = header.count * 8 / 2**30
            raise _RefusedArray(f"unpacks to {size:,.1f} GiB, a file of this size may hold at most {most:,.2f} GiB")


class _RefusedArray(ValueError):
    """Raised for an array of a sound file that is refused; the message gives the reason."""


def failure_reason(error: BaseException) -> str:
    """Return the first line of an error's message, printable and short, or the name of its class."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for it"
    return printable((str(error).splitlines() or [type(error).__name__])[0][:120])


# Writers of arrays that lie in memory-mapped files: they are copied in pieces, never held whole.

_COPY_CHUNK = 1 << 20  # items


@dataclass(frozen=True)
class StoredArray:
    """An array in files: its columns one after the other, as rows along a first axis if there are several."""

    columns: tuple[np.ndarray[Any, Any], ...]
    shape: tuple[int, ...]

    @property
    def dtype(self) -> Any:
        """The dtype, which all columns share."""
        return self.columns[0].dtype


def write_npz(path: str | os.PathLike[str], arrays: Mapping[str, StoredArray], more: Mapping[str, Any]) -> None:
    """Write a .npz file of stored arrays and of `more` in memory; it appears whole or not at all. Raise OSError."""
    with (
        replace_file(path) as partial,
        zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED, allowZip64=True) as archive,
    ):
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write_stored_array(member, array)
        for name, values in more.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.asanyarray(values), allow_pickle=False)


def write_npy(path: str | os.PathLike[str], array: StoredArray) -> None:
    """Write a .npy file of a stored array; it appears whole or not at all. Raise OSError."""
    with replace_file(path) as partial, partial.open("wb") as file:
        _write_stored_array(file, array)


def _write_stored_array(file: IO[bytes], array: StoredArray) -> None:
    """Write an array in .npy format, for a file or a member of a .npz file."""
    kind = np.lib.format.dtype_to_descr(array.dtype)
    np.lib.format.write_array_header_1_0(file, dict(descr=kind, fortran_order=False, shape=array.shape))
    for column in array.columns:
        flat = column.reshape(-1)
        for begin in range(0, len(flat), _COPY_CHUNK):
            file.write(np.ascontiguousarray(flat[begin : begin + _COPY_CHUNK]).tobytes())
