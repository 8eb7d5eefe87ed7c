"""A file of finished parts of some work, each with a checksum: what was being written when a process died is not read.

It begins with a name of the work (a hash of all it depends on), so that parts of another one are never taken for its.
"""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from hashlib import blake2b
from pathlib import Path

from ..formats.atomic import replacing
from ..shapes.validate import path as checked_path
from .edition import edition

_MAGIC = b"conicoid parts 2\n"
_HEAD = struct.Struct("<QQQI")
"""begin, end, bytes of the part, checksum of these three and of it"""


class Checkpoint:
    """Parts of the work of a key, at `path`. Raises ValueError where the file is of other work or of something else."""

    def __init__(self, path: str | os.PathLike[str], key: bytes) -> None:
        self.path = Path(checked_path("render", path, "resume"))
        self.head = _MAGIC + blake2b(key + edition().encode(), digest_size=16).digest()
        with open(self.path, "ab"):
            pass
        self.file = open(self.path, "r+b")  # noqa: SIM115 - for as long as the work takes
        try:
            self._check()
        except BaseException:
            self.file.close()
            raise

    def _check(self) -> None:
        head = self.file.read(len(self.head))
        if head != self.head[: len(head)]:
            whose = "other work, or of another version" if head[: len(_MAGIC)] == _MAGIC else "something else"
            raise ValueError(f"{self.path}: holds parts of {whose}; give another name, or remove it")
        if len(head) < len(self.head):
            self.file.seek(0)
            self.file.write(self.head)
            self.file.flush()

    def records(self) -> Iterator[tuple[int, int, bytes]]:
        """The whole parts (begin, end, bytes) in the file; what follows them is cut off."""
        at = len(self.head)
        while True:
            self.file.seek(at)
            head = self.file.read(_HEAD.size)
            if len(head) < _HEAD.size:
                break
            begin, end, count, checksum = _HEAD.unpack(head)
            if count > os.fstat(self.file.fileno()).st_size:
                break
            data = self.file.read(count)
            if len(data) < count or zlib.crc32(data, zlib.crc32(head[:24])) != checksum:
                break
            yield begin, end, data
            at += _HEAD.size + count
        self.file.truncate(at)
        self.file.seek(at)

    def rewrite(self, records: Iterable[tuple[int, int, bytes]]) -> None:
        """Leave nothing in the file but these parts. What is in it stays until they are all on the disk."""
        self.file.close()
        try:
            with replacing(self.path) as part:
                other = object.__new__(Checkpoint)
                other.path, other.file = self.path, open(part, "r+b")  # noqa: SIM115 - closed below
                try:
                    other.file.write(self.head)
                    for record in records:
                        other.add(*record)
                finally:
                    other.close()
        finally:
            self.file = open(self.path, "r+b")  # noqa: SIM115 - for as long as the work takes
            self.file.seek(0, os.SEEK_END)

    @property
    def size(self) -> int:
        """Bytes of the file."""
        return os.fstat(self.file.fileno()).st_size

    def sync(self) -> None:
        """Wait until all parts are on the disk."""
        with contextlib.suppress(OSError):
            os.fsync(self.file.fileno())

    def add(self, begin: int, end: int, data: bytes) -> None:
        """Append a part. Raises OSError, naming the file, where there is no room; what is in it stays good."""
        numbers = _HEAD.pack(begin, end, len(data), 0)[:24]
        try:
            self.file.write(numbers + struct.pack("<I", zlib.crc32(data, zlib.crc32(numbers))) + data)
            self.file.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, os.fspath(self.path)) from None

    def close(self) -> None:
        """Close the file, which stays."""
        try:
            self.file.close()
        except OSError as error:
            raise OSError(error.errno, error.strerror, os.fspath(self.path)) from None
