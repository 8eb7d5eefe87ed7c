"""Pictures in files, for textures: what is in them as linear light, or a message that says what is wrong."""

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
_FEW = 8
"""Different whole numbers that light may have by intention."""
_PHOTOS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
SUFFIXES = (*_PHOTOS, ".exr")


class Pixels:
    """A picture (height, width, 3): bytes of sRGB, or float32 of linear light. Compared by its content."""

    def __init__(self, array: Any) -> None:
        from hashlib import blake2b

        self.array = array
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
        """float32 of linear light, (height, width, 3); bytes that are data, and no colours, as shares of 255."""
        if self.array.dtype != np.uint8:
            return self.array
        table = np.arange(256) / 255 if is_data else srgb_decode(np.arange(256) / 255)
        return table.astype(np.float32)[self.array]


def image_array(owner: str, field: str, image: Any) -> Any:
    """The numbers of an array, or of an `Image`: uint8, which are bytes of sRGB, or floats of linear light.

    Whole numbers of other types that can only be bytes are a ValueError: as light they were hundreds of times white.
    """
    given = image if isinstance(image, list | tuple) else getattr(image, "pixels", image)
    array = np.asarray(given) if hasattr(given, "dtype") else np.zeros(0)
    if array.dtype == np.uint8:
        return array
    floats = real_array(owner, field, given, "an array of numbers (height, width, 3)")
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
            f"(array.astype('uint8')), or linear light of which 1 is white; got {array.dtype}"
        )
    return floats


def _restore_pixels(array: Any) -> Pixels:
    return Pixels(np.array(array))


def read_pixels(file: str | os.PathLike[str]) -> Pixels:
    """The picture in a file. Raises ValueError for a file that is missing, no picture, damaged, or too large."""
    from pathlib import Path  # few scenes have pictures on their bodies

    path = Path(file)
    try:
        is_there = path.is_file()
    except (OSError, ValueError):  # no name that the system could have
        is_there = False
    if not is_there:
        raise ValueError(f"is not an existing file: {format_value(str(path))}")
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"must be a picture ({', '.join(SUFFIXES)}), got {path.name!r}")
    return Pixels(_read_exr(path) if suffix == ".exr" else _read_photo(path, _PHOTOS[suffix]))


def _read_photo(path: Path, kind: str) -> Any:
    from PIL import Image

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
    """Grey of 16 bits, as linear light."""
    grey = srgb_decode(np.array(file, np.float64) / 65535).astype(np.float32)
    return np.repeat(grey[..., None], 3, axis=2)


def _read_exr(path: Path) -> Any:
    import OpenEXR

    try:
        channels = OpenEXR.File(os.fspath(path)).channels()
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
    if width * height > MOST_TEXELS:
        raise ValueError(f"{path.name!r} has {width} x {height} pixels, a texture at most {MOST_TEXELS:,}")
