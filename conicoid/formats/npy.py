"""NumPy's .npy files, read without trust: a header that must be plain, then exactly the numbers that it declares.

Unlike NumPy's own reader this one evaluates nothing, warns of nothing, and knows no objects. The format:
https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import IO, Any

import numpy as np

from ..shapes.vector import FloatArray
from .errors import printable
from .regular import check_memory

MAGIC = b"\x93NUMPY"
FLAGS = "|b1"
"""The type of truth values, as files name it."""
LONGEST_HEADER = 10_000
MOST_AXES = 32
PIECE = 1 << 20

_ENTRY = re.compile(
    r"""\s*(['"])(?P<key>\w{1,20})\1\s*:\s*
        (?: (?P<flag>True|False) | (['"])(?P<text>[^'"]{0,100})\4 | \((?P<axes>[\s\d,L]*)\) )
        \s*(?:,|$)""",
    re.VERBOSE,
)
_NUMBERS = re.compile(r"[<>=|]?(?:[iu][1248]|f(?:2|4|8|16))")


class NotPlain(ValueError):
    """Not the file of an array of numbers; the text says why."""


@dataclass(frozen=True)
class Header:
    """What stands in a file: the type as the file names it, the shape, and whether columns come first."""

    type_name: str
    shape: tuple[int, ...]
    fortran: bool
    length: int  # of the header itself, in bytes

    @property
    def kind(self) -> np.dtype[Any] | None:
        """The type, if it is one of integers or floating-point numbers that this machine has."""
        try:
            return np.dtype(self.type_name) if _NUMBERS.fullmatch(self.type_name) else None
        except TypeError:
            return None

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def __str__(self) -> str:
        return f"{printable(self.type_name)} {self.shape}"


def read_header(file: IO[bytes]) -> Header:
    """The header at the start of a file. Raises NotPlain."""
    start = _exactly(file, 8)
    if start[:6] != MAGIC:
        raise NotPlain("it does not begin like one")
    if start[6:] not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise NotPlain(f"it is of version {start[6]}.{start[7]}, known are 1.0, 2.0 and 3.0")
    width = 2 if start[6] == 1 else 4
    length = int.from_bytes(_exactly(file, width), "little")
    if length > LONGEST_HEADER:
        raise NotPlain(f"its header is {length:,} bytes long, at most {LONGEST_HEADER:,} are read")
    text = _exactly(file, length).decode("latin-1").strip()
    return _parsed(text, 8 + width + length)


def _parsed(text: str, length: int) -> Header:
    if not (text.startswith("{") and text.endswith("}")):
        raise NotPlain("its header is not that of an array of numbers")
    inner, position = text[1:-1].strip(), 0
    found: dict[str, re.Match[str]] = {}
    while position < len(inner):
        match = _ENTRY.match(inner, position)
        if match is None or match["key"] in found:
            raise NotPlain("its header is not that of an array of numbers")
        found[match["key"]], position = match, match.end()
    if set(found) != {"descr", "fortran_order", "shape"}:
        raise NotPlain("its header must say descr, fortran_order and shape, and nothing else")
    name, flag, axes = found["descr"]["text"], found["fortran_order"]["flag"], found["shape"]["axes"]
    if name is None or flag is None or axes is None:
        raise NotPlain("its header is not that of an array of numbers")
    if "O" in name:
        raise NotPlain("it holds Python objects, which are never read")
    return Header(name, _shape(axes), flag == "True", length)


def _shape(text: str) -> tuple[int, ...]:
    axes = [axis.strip().removesuffix("L") for axis in text.split(",")]
    axes = axes[:-1] if axes[-1] == "" else axes
    if len(axes) > MOST_AXES or not all(axis.isdecimal() and len(axis) < 19 for axis in axes):
        raise NotPlain(f"its shape ({' '.join(text.split())[:60]}) is not that of an array")
    shape = tuple(map(int, axes))
    if math.prod(max(axis, 1) for axis in shape) >= 1 << 56:
        raise NotPlain(f"its shape {shape} is that of no array")
    return shape


def read_values(file: IO[bytes], header: Header, kind: np.dtype[Any], size: int) -> FloatArray:
    """The numbers that follow a header, as float64, from a file of `size` bytes that must hold nothing else.

    Raises NotPlain, and ValueError for what does not fit into memory or into float64.
    """
    expected = header.length + header.count * kind.itemsize
    if size != expected:
        raise NotPlain(f"its header announces {expected:,} bytes, it has {size:,}")
    check_memory(header.count * 8)
    try:
        values = np.empty(header.count)
    except MemoryError:
        raise ValueError(f"takes {header.count * 8 / 2**30:,.1f} GiB, more memory than there is left") from None
    step = PIECE // kind.itemsize
    for begin in range(0, header.count, step):
        part = values[begin : begin + step]
        raw = np.frombuffer(_exactly(file, len(part) * kind.itemsize), kind)
        with np.errstate(all="ignore"):
            part[:] = raw
            if kind.itemsize > 8 and (np.isinf(part) & ~np.isinf(raw)).any():
                raise ValueError("holds numbers beyond the range of float64")
    file.read(1)  # its end, where an archive compares a checksum
    return values.reshape(header.shape[::-1]).T if header.fortran else values.reshape(header.shape)


def _exactly(file: IO[bytes], count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise NotPlain("it ends too early")
    return data


def pieces(values: FloatArray) -> list[bytes | memoryview]:
    """The bytes of the file of a float64 array, in pieces: version 1.0, little-endian, rows first."""
    table = np.ascontiguousarray(values, dtype="<f8")
    text = repr({"descr": "<f8", "fortran_order": False, "shape": table.shape})
    padding = -(len(MAGIC) + 4 + len(text) + 1) % 64
    header = f"{text}{' ' * padding}\n".encode("latin-1")
    content = table.data.cast("B") if table.size else b""
    return [MAGIC + b"\x01\x00" + len(header).to_bytes(2, "little") + header, content]
