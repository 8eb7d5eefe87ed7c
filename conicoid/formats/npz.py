"""NumPy's .npz files, read without trust: only the arrays that are asked for, and never more than they declare."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Collection
from typing import IO, BinaryIO

import numpy as np

from ..shapes.vector import FloatArray
from .errors import printable
from .npy import FLAGS, Header, NotPlain, read_header, read_values

FREE_BYTES, TIMES = 256 << 20, 50
"""Compressed arrays may always take so much memory, and so many times the size of their file in addition."""
_LONGEST_READ = 4 << 20
DAMAGE = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error, EOFError, OSError, LookupError,
    NotImplementedError, RuntimeError, ArithmeticError, AttributeError, TypeError, ValueError, MemoryError,
)  # fmt: skip
"""What the standard library's reader raises for archives that are none."""


class _Bounded:
    """A file of which nobody can ask for much at once: an archive's directory is not read into memory unseen."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file

    def read(self, count: int = -1) -> bytes:
        data = self.file.read(_LONGEST_READ + 1 if count < 0 else min(count, _LONGEST_READ + 1))
        if len(data) > _LONGEST_READ:
            raise zipfile.BadZipFile("its directory is too long")
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self.file.seek(offset, whence)

    def tell(self) -> int:
        return self.file.tell()

    def seekable(self) -> bool:
        return True


class Archive:
    """The directory of a .npz file of `size` bytes. Raises NotPlain."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self.size = size
        self.left = FREE_BYTES + TIMES * size
        try:
            self.zip = zipfile.ZipFile(_Bounded(file))
        except DAMAGE as error:
            raise NotPlain(reason_of(error)) from None
        self.members: dict[str, zipfile.ZipInfo] = {}
        for info in self.zip.infolist():
            name = info.filename.removesuffix(".npy")
            if name in self.members:
                raise NotPlain(f"it holds {printable(name[:60])!r} twice")
            self.members[name] = info

    def arrays(self, wanted: Collection[str], flags: Collection[str] = ()) -> dict[str, FloatArray]:
        """Those of the wanted arrays that are there, as float64. Raises ValueError, naming the array.

        flags: those that may also be truth values, as NumPy writes them: bytes, 0 or 1.
        """
        found = {}
        for name in wanted:
            if name in self.members:
                try:
                    found[name] = self._array(self.members[name], name in flags)
                except NotPlain as error:
                    raise ValueError(f"{name} is not an array of numbers ({error})") from None
                except ValueError as error:
                    raise ValueError(f"{name} {error}") from None
        return found

    def _array(self, info: zipfile.ZipInfo, is_flag: bool) -> FloatArray:
        if info.flag_bits & 0x1:
            raise NotPlain("it is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NotPlain("it is compressed in a way that NumPy does not write")
        try:
            with self.zip.open(info) as file:
                return self._values(info, file, is_flag)
        except (NotPlain, _Refused):
            raise
        except DAMAGE as error:
            raise NotPlain(reason_of(error)) from None

    def _values(self, info: zipfile.ZipInfo, file: IO[bytes], is_flag: bool) -> FloatArray:
        header = read_header(file)
        kind = np.dtype(np.uint8) if is_flag and header.type_name == FLAGS else header.kind
        if kind is None:
            raise _Refused(f"must hold numbers, got {header}")
        self._charge(info, header)
        try:
            return read_values(file, header, kind, info.file_size)
        except NotPlain:
            raise
        except ValueError as error:
            raise _Refused(str(error)) from None

    def _charge(self, info: zipfile.ZipInfo, header: Header) -> None:
        """Refuse small files that unpack to what no such file should."""
        if info.compress_type != zipfile.ZIP_STORED:
            self.left -= header.count * 8
        if self.left < 0:
            most = (FREE_BYTES + TIMES * self.size) / 2**30
            size = header.count * 8 / 2**30
            raise _Refused(f"unpacks to {size:,.1f} GiB, a file of this size may hold at most {most:,.2f} GiB")


class _Refused(ValueError):
    """An array that could be read and is not: the text says why."""


def reason_of(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "there is not enough memory for it"
    return printable((str(error).splitlines() or [type(error).__name__])[0][:120])
