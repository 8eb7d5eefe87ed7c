"""NumPy's .npy and .npz files: readers for untrusted files.

A .npy file must have a plain header and then exactly the numbers that it declares. Unlike NumPy's reader this one
evaluates nothing, warns of nothing and knows no objects. Of a .npz file only requested arrays are read, and never more
than they declare. Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import struct
import sys
import zipfile
import zlib
from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import IO, Any, BinaryIO

import numpy as np

from .._util.arrays import FloatArray
from .._util.dataclass import dataclass
from .._util.files import check_memory, printable

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
