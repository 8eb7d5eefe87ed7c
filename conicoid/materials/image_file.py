"""Image files for textures and environments: decode them to sRGB bytes or linear light, or raise a clear error."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import warnings
import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.lazy_names import import_extra
from .._util.validation import format_value, real_array

if TYPE_CHECKING:
    from pathlib import Path
from .color import BYTE, srgb_decode

MOST_TEXELS = 1 << 27
"""The most pixels of a texture."""
_FREE_TEXELS, _TEXELS_PER_BYTE = 1 << 24, 64
"""Pixels that a file of any size may have, and for each of its bytes: compressed zeros would take all memory.

A smooth .jpg has some 50 pixels for each byte."""
_CHANNELS = 4  # that a file of so many pixels may have in all its parts
_MOST_BYTES, _MOST_READS = 1 << 29, 1 << 20
"""Most bytes of a file, which decoders may copy, and of calls that read it: Pillow skips bytes of no meaning singly."""
_PIECE = 1 << 18
"""Bytes of a file that are unpacked at a time."""
_FEW = 8
"""The most different whole numbers that an array of linear light may plausibly hold."""
_PHOTOS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
SUFFIXES = (*_PHOTOS, ".exr")
"""Suffixes of the files that can be read."""


class Pixels:
    """Pixels (height, width, 3): bytes of sRGB, or float32 of linear light. Their content is compared by a digest."""

    def __init__(self, array: Any) -> None:
        from hashlib import blake2b

        self.array = array
        # Frozen: the digest depends on it.
        self.array.setflags(write=False)
        head = f"{array.dtype} {array.shape};".encode()
        self.digest = blake2b(head + array.tobytes(), digest_size=8).hexdigest()

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore_pixels, (self.array,)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height)"""
        return self.array.shape[1], self.array.shape[0]

    def linear(self, is_data: bool) -> Any:
        """Return linear light (height, width, 3) float32. With `is_data`, bytes are no colours but shares of 255."""
        if self.array.dtype != np.uint8:
            return self.array
        # 256 values only: decode a table, not each pixel.
        table = np.arange(256) / 255 if is_data else srgb_decode(np.arange(256) / 255)
        return table.astype(np.float32)[self.array]


def image_array(owner: str, field: str, image: Any) -> Any:
    """Return the numbers of an array, or of an `Image`: uint8 (bytes of sRGB), or floats (linear light).

    Raise ValueError for whole numbers of other types that can only be bytes: as light they would be hundreds of times
    white.
    """
    numbers = image if isinstance(image, list | tuple) else getattr(image, "pixels", image)
    array = np.asarray(numbers) if hasattr(numbers, "dtype") else np.zeros(0)
    if array.dtype == np.uint8:
        return array
    floats = real_array(owner, field, numbers, "an array of numbers (height, width, 3)")
    bright = float(floats.max()) if floats.size and np.isfinite(floats).all() else 0.0
    if array.dtype.kind in "iu" and bright > 1:
        raise ValueError(
            f"{owner}: {field} of integers up to {bright:g} must be of uint8, sRGB bytes (array.astype('uint8')); "
            f"got {array.dtype}"
        )
    is_whole = 1 < bright <= BYTE and floats.min() >= 0 and (floats == np.round(floats)).all()
    if is_whole and len(np.unique(floats)) > _FEW:
        raise ValueError(
            f"{owner}: {field} of whole numbers up to {bright:g} must be of uint8, sRGB bytes "
            f"(array.astype('uint8')), or linear light, where 1 is white; got {array.dtype}"
        )
    return floats


def _restore_pixels(array: Any) -> Pixels:
    """Unpickle from a copy of the array."""
    return Pixels(np.array(array))


def read_pixels(file: str | os.PathLike[str]) -> Pixels:
    """Return the pixels of a file. Raise ValueError if it is missing, no picture, damaged, or too large.

    Raise ImportError for an .exr without OpenEXR.
    """
    from pathlib import Path  # few scenes have pictures on their bodies

    path = Path(file)
    try:
        is_there = path.is_file()
    except (OSError, ValueError):  # the name is impossible on this system
        is_there = False
    if not is_there:
        raise ValueError(f"is not an existing file: {format_value(str(path))}")
    # The suffix decides the decoder, not the content.
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"must be a picture ({', '.join(SUFFIXES)}), got {path.name!r}")
    if path.stat().st_size > _MOST_BYTES:
        raise ValueError(f"{path.name!r} is larger than {_MOST_BYTES >> 20:,} MiB")
    return Pixels(_read_exr(path) if suffix == ".exr" else _read_photo(path, _PHOTOS[suffix]))


@contextlib.contextmanager
def _decoding(path: Path, kind: str) -> Iterator[None]:
    """Turn errors of decoders into a ValueError with the name of the file."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0][:200]
        raise ValueError(f"{path.name!r} cannot be read as {kind}: {reason}") from None


class _CountedReads(io.BufferedReader):
    """A file that can be read so many times only."""

    _count = 0

    def read(self, size: int | None = -1, /) -> bytes:
        self._count += 1
        if self._count > _MOST_READS:
            raise ValueError(f"takes more than {_MOST_READS:,} steps")
        return super().read(size)


def _read_photo(path: Path, kind: str) -> Any:
    """Decode a .png, .jpg or .webp."""
    from PIL import Image

    from .._util.files import open_regular  # a start without textures needs no files

    # `_check_size` has its own limit, so the warning of Pillow is turned off.
    with warnings.catch_warnings(), _decoding(path, kind):
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        with (
            open_regular(path) as stream,
            _CountedReads(stream.raw) as reads,
            Image.open(reads, formats=[kind]) as file,
        ):
            _check_size(path, *file.size)
            if kind == "PNG":
                _check_rows(path)
            if file.mode in ("I;16", "I;16B", "I"):
                return _grey16(file)
            return np.array(file.convert("RGB"))


def _grey16(file: Any) -> Any:
    """Return grey of 16 bits as linear light."""
    table = srgb_decode(np.arange(65536) / 65535).astype(np.float32)
    return np.repeat(table[np.asarray(file).astype(np.uint16, copy=False)][..., None], 3, axis=2)


_PNG_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_PNG_PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and steps, of the passes of an interlaced file (PNG specification, 8.1)."""


def _check_rows(path: Path) -> None:
    """Raise OSError for a PNG that ends before its last row: Pillow takes the memory of all, and leaves them black."""
    from .._util.files import open_regular  # a start without textures needs no files

    decoder, missing = zlib.decompressobj(), 1
    with open_regular(path) as file:
        file.seek(8)
        while missing > 0 and len(head := file.read(8)) == 8:
            length, kind = struct.unpack(">I4s", head)
            if kind == b"IHDR":
                width, height, bits, color, *_, interlaced = struct.unpack(">IIBBBBB", file.read(length)[:13])
                passes = _PNG_PASSES if interlaced else ((0, 0, 1, 1),)
                sizes = [(-(-(width - x) // dx), -(-(height - y) // dy)) for x, y, dx, dy in passes]
                missing = sum(h * (1 + -(-w * bits * _PNG_CHANNELS[color] // 8)) for w, h in sizes if w > 0 and h > 0)
                length = 0
            while kind == b"IDAT" and missing > 0 and (part := file.read(min(length, _PIECE))):
                length -= len(part)
                while part and missing > 0:
                    missing -= len(decoder.decompress(part, _PIECE))
                    part = decoder.unconsumed_tail
            file.seek(length + 4, os.SEEK_CUR)
    if missing > 0:
        raise OSError("rows are missing")


def import_openexr() -> Any:
    """Return `OpenEXR`. Raise ImportError with the way to install it."""
    return import_extra("OpenEXR", ".exr files need OpenEXR", "exr")


def _read_exr(path: Path) -> Any:
    """Decode an .exr: channels R, G, B or one of grey."""
    openexr = import_openexr()
    with _decoding(path, "OpenEXR"):
        numbers = 0
        for part in openexr.File(os.fspath(path), header_only=True).parts:
            if part.type() in (openexr.deepscanline, openexr.deeptile):
                raise ValueError("is a deep image, with any number of samples for each pixel")
            low, high = part.header["dataWindow"]
            width, height = (int(end) - int(begin) + 1 for begin, end in zip(low, high, strict=True))
            numbers += width * height * max(1, len(part.header["channels"]))
            _check_size(path, width, height, numbers)  # before all parts and channels are decoded
        channels = openexr.File(os.fspath(path)).channels()
        name = next((name for name in ("RGB", "RGBA", "Y", "R") if name in channels), None)
        if name is None:
            raise ValueError("must have the channels R, G, B or Y")
        pixels = np.asarray(channels[name].pixels, np.float32)
        if not np.isfinite(pixels).all():
            raise ValueError("must hold finite numbers")
    return np.ascontiguousarray(pixels[..., :3] if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=2))


def _check_size(path: Path, width: int, height: int, numbers: int = 0) -> None:
    """Raise ValueError for more than MOST_TEXELS pixels, or far more than the bytes of the file stand for."""
    most = min(MOST_TEXELS, max(_FREE_TEXELS, _TEXELS_PER_BYTE * path.stat().st_size))
    if width * height > most or numbers > _CHANNELS * most:
        size = f"{width} x {height} pixels" if width * height > most else f"{numbers:,} numbers"
        raise ValueError(
            f"has {size}; a texture has at most {MOST_TEXELS:,} pixels, and one of so few bytes {most:,}, "
            f"with {_CHANNELS} numbers each"
        )
