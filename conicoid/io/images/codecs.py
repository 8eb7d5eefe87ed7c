"""OpenEXR pictures: linear light, whatever its range, in floats of 32 or 16 bits, and layers of what else is known."""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.safe_files import replace_file
from ...kernels.tables import Floats
from ...materials.color import srgb_encode

if TYPE_CHECKING:
    from rich.text import Text


_LAYER_CHANNELS = {"normal": "XYZ", "position": "XYZ"}
"""What the channels of a layer are called that has no colours."""


def write_exr(
    path: str | os.PathLike[str], values: Any, layers: Mapping[str, Any] | None = None, half: bool = False
) -> None:
    """Write (height, width, 3) as channels R, G, B, or (height, width) as the channel Y.

    layers: arrays of as many pixels, as channels such as albedo.R, normal.X, depth.V and body.V. Integers become
        unsigned ones of 32 bits, in which -1 is the largest number.
    half: floats of 16 bits; what is too large for them becomes infinite.
    """
    import OpenEXR

    kind = np.float16 if half else np.float32
    data = _exr_float(values, kind)
    channels = {"RGB" if data.ndim == 3 else "Y": data}
    for name, layer in (layers or {}).items():
        whole = np.asarray(layer).dtype.kind in "iu"
        array = np.asarray(layer).astype(np.uint32) if whole else _exr_float(layer, kind)
        if array.ndim == 2:
            channels[f"{name}.V"] = np.ascontiguousarray(array)
            continue
        for k, letter in enumerate(_LAYER_CHANNELS.get(name, "RGB")):
            channels[f"{name}.{letter}"] = np.ascontiguousarray(array[..., k])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with replace_file(path) as part:
        try:
            OpenEXR.File(header, channels).write(str(part))
        except RuntimeError as error:
            raise _exr_os_error(str(error)) from None


def _exr_float(values: Any, kind: Any) -> Any:
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(np.asarray(values).astype(kind))


def _exr_os_error(text: str) -> OSError:
    """What the library says in its own words, as Python would say it."""
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO):
        if os.strerror(code) in text:
            return OSError(code, os.strerror(code))
    return OSError(errno.EIO, f"cannot be written: {text.splitlines()[0] if text else 'OpenEXR does not say why'}")


# Linear light as bytes of sRGB, as pictures hold them.
#
# A byte is what `srgb_encode` gives, rounded. That takes two roots for each number; but it only rises, so the byte is
# the
# number of thresholds that a value has reached: of the two that the first eight bits of its fraction leave open, one
# comparison decides.

_BUCKET_SHIFT = 44  # what follows the first eight bits of the fraction of a float64
_FIRST_BUCKET = (1023 - 13) << 8  # the beginning of 2^-13; what is less is black
_SRGB_CHUNK = 1 << 14  # numbers: they stay in the cache


def srgb_bytes(pixels: Any) -> Any:
    """Linear pixels as uint8 of sRGB: cut to [0, 1], NaN is black."""
    given = np.ascontiguousarray(pixels)
    values, codes = given.reshape(-1), np.empty(given.size, np.uint8)
    below, next_above = _srgb_table()
    for begin in range(0, len(values), _SRGB_CHUNK):
        part = values[begin : begin + _SRGB_CHUNK].astype(np.float64)
        with np.errstate(invalid="ignore"):
            np.copyto(part, 0.0, where=~(part > 0.0))
        np.minimum(part, 1.0, out=part)
        first = below[np.maximum((part.view(np.int64) >> _BUCKET_SHIFT) - _FIRST_BUCKET, 0)]
        np.add(first, part >= next_above[first], out=codes[begin : begin + _SRGB_CHUNK])
    return codes.reshape(given.shape)


def srgb_words(pixels: Any) -> Any:
    """The same as uint16, 65,535 being white: by the formula, as a table of so many thresholds takes as long."""
    cut = np.clip(np.nan_to_num(np.asarray(pixels, dtype=np.float64), nan=0.0, posinf=1.0), 0.0, 1.0)
    return np.rint(65535 * srgb_encode(cut)).astype(np.uint16)


def _srgb_codes(values: Floats) -> Any:
    """Bytes of linear values in [0, 1], by the formula."""
    return np.rint(255 * srgb_encode(values)).astype(np.uint8)


@lru_cache(maxsize=1)
def _srgb_table() -> tuple[Any, Floats]:
    """The byte of the least number with each beginning, and the least number of the byte that follows each."""
    beginnings = np.arange(_FIRST_BUCKET, (1023 << 52 >> _BUCKET_SHIFT) + 1)
    low, high = np.zeros(255, np.int64), np.full(255, 1023 << 52, np.int64)  # bits of 0 and of 1, in the same order
    wanted = np.arange(1, 256)
    while (high - low > 1).any():
        middle = (low + high) >> 1
        reached = _srgb_codes(middle.view(np.float64)) >= wanted
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return _srgb_codes((beginnings << _BUCKET_SHIFT).view(np.float64)), np.append(high.view(np.float64), np.inf)


# Pictures for mail and pages: JPEG, which loses a little, and WebP, which loses nothing. Both in 8 bits of sRGB.

PHOTO_OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    ".jpg": ("JPEG", dict(quality=92, subsampling=0)),
    ".jpeg": ("JPEG", dict(quality=92, subsampling=0)),
    ".webp": ("WEBP", dict(lossless=True)),
}
"""Suffix -> Pillow's format and its options."""


def write_photo(path: str | os.PathLike[str], pixels: Any, suffix: str) -> None:
    """Write linear (height, width, 3) pixels. Raises ValueError for more pixels a side than the format has."""
    from PIL import Image

    kind, options = PHOTO_OPTIONS[suffix]
    stream = io.BytesIO()
    try:
        Image.fromarray(srgb_bytes(pixels), "RGB").save(stream, kind, **options)
    except (KeyError, OSError, ValueError) as error:
        raise ValueError(f"Image: {os.fspath(path)} cannot be written as {kind}: {error}") from None
    with replace_file(path) as part:
        part.write_bytes(stream.getvalue())


# A picture in a terminal: each character shows two pixels, one over the other, as half a block on a background.

UPPER_HALF = "▀"


def downsample(pixels: FloatArray, columns: int, rows: int) -> FloatArray:
    """(height, width, 3): the means of light over as few equal parts as fit into columns x rows; never enlarged."""
    height, width = pixels.shape[:2]
    share = min(1.0, columns / width, rows / height)
    high, wide = max(1, int(height * share)), max(1, int(width * share))
    y, x = (np.arange(n) * size // n for n, size in ((high, height), (wide, width)))
    total = np.add.reduceat(np.add.reduceat(np.asarray(pixels, float), y, axis=0), x, axis=1)
    sizes = np.diff(np.append(y, height))[:, None] * np.diff(np.append(x, width))
    return np.asarray(total / sizes[..., None])


def render_half_blocks(pixels: Any, columns: int, rows: int) -> Text:
    """A picture (height, width, 3) of linear light in at most so many columns and rows of characters."""
    from rich.text import Text

    shown = np.asarray(srgb_bytes(downsample(pixels, columns, 2 * rows).astype(np.float32)))
    text = Text(end="", no_wrap=True)
    for top in range(0, len(shown), 2):
        if top:
            text.append("\n")
        for column in range(shown.shape[1]):
            text.append(UPPER_HALF, _half_block_style(shown[top : top + 2, column]))
    return text


def _half_block_style(pair: Any) -> str:
    """The colours of one character."""
    over, under = ("#" + bytes(pixel.tolist()).hex() for pixel in (pair[0], pair[-1]))
    return f"{over} on {under}" if len(pair) == 2 else over


def terminal_preview() -> Callable[[Any], None]:
    """What draws pictures in the terminal that stderr is, each over the one before; nothing where it is none."""
    from rich.console import Console
    from rich.control import Control
    from rich.segment import ControlType

    console, above = Console(stderr=True), [0]

    def preview(image: Any) -> None:
        if not console.is_terminal:
            return
        drawn = render_half_blocks(image._shown, console.width, max(1, console.height - 2))
        if above[0]:
            console.control(Control((ControlType.CURSOR_UP, above[0])))
        console.print(drawn, end="\n")
        above[0] = drawn.plain.count("\n") + 1

    return preview
