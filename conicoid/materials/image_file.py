"""Image files for textures and environments: decode them to sRGB bytes or linear light, or raise a clear error."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.validation import format_value, real_array
from .color import BYTE, srgb_decode

if TYPE_CHECKING:
    from pathlib import Path

MOST_TEXELS = 1 << 27
"""The most pixels of a texture."""
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
    return Pixels(_read_exr(path) if suffix == ".exr" else _read_photo(path, _PHOTOS[suffix]))


def _read_photo(path: Path, kind: str) -> Any:
    """Decode a .png, .jpg or .webp."""
    from PIL import Image

    # `_check_size` has its own limit, so the warning of Pillow is turned off.
    before = Image.MAX_IMAGE_PIXELS
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=[kind]) as file:
                _check_size(path, *file.size)
                if file.mode in ("I;16", "I;16B", "I"):
                    return _grey16(file)
                return np.array(file.convert("RGB"))
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"{path.name!r} cannot be read as {kind}: {error}") from None
    finally:
        Image.MAX_IMAGE_PIXELS = before


def _grey16(file: Any) -> Any:
    """Return grey of 16 bits as linear light."""
    grey = srgb_decode(np.array(file, np.float64) / 65535).astype(np.float32)
    return np.repeat(grey[..., None], 3, axis=2)


def import_openexr() -> Any:
    """Return `OpenEXR`. Raise ImportError with the way to install it."""
    try:
        import OpenEXR
    except ImportError:
        raise ImportError(".exr files need OpenEXR: pip install 'conicoid[exr]'") from None
    return OpenEXR


def _read_exr(path: Path) -> Any:
    """Decode an .exr: channels R, G, B or one of grey."""
    openexr = import_openexr()
    try:
        channels = openexr.File(os.fspath(path)).channels()
        name = next(name for name in ("RGB", "RGBA", "Y", "R") if name in channels)
        pixels = np.asarray(channels[name].pixels, np.float32)
    except StopIteration:
        raise ValueError(f"{path.name!r} must have the channels R, G, B or Y") from None
    except Exception as error:
        raise ValueError(f"{path.name!r} cannot be read as OpenEXR: {str(error).splitlines()[0][:200]}") from None
    _check_size(path, pixels.shape[1], pixels.shape[0])
    if not np.isfinite(pixels).all():
        raise ValueError(f"{path.name!r} must hold finite numbers")
    return np.ascontiguousarray(pixels[..., :3] if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=2))


def _check_size(path: Path, width: int, height: int) -> None:
    """Raise ValueError for a picture with more than MOST_TEXELS pixels."""
    if width * height > MOST_TEXELS:
        raise ValueError(f"{path.name!r} has {width} x {height} pixels, a texture at most {MOST_TEXELS:,}")
