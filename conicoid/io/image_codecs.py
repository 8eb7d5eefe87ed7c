"""Codecs of images and movies: OpenEXR, sRGB bytes, PNG, JPEG and WebP, half blocks in a terminal; GIF, WebP, MP4.

Pixels are linear light, 1 being white, of shape (height, width, 3) with rows from top to bottom.
"""

from __future__ import annotations

import contextlib
import errno
import io
import itertools
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.files import replace_file
from ..kernels.tables import Floats
from ..materials.color import srgb_encode
from ..materials.image_file import import_openexr

if TYPE_CHECKING:
    from rich.text import Text


# OpenEXR: linear light of any range, as floats of 32 or 16 bits, with further layers as channels.

_LAYER_CHANNELS = {"normal": "XYZ", "position": "XYZ"}
"""Channel letters of the layers that hold vectors; layers of colours use RGB."""


def write_exr(
    path: str | os.PathLike[str],
    values: npt.ArrayLike,
    layers: Mapping[str, npt.ArrayLike] | None = None,
    half: bool = False,
) -> None:
    """Write an OpenEXR file; it appears whole or not at all.

    Parameters
    ----------
    path
        The file to write.
    values
        (height, width, 3), written as channels R, G and B, or (height, width), written as channel Y.
    layers
        Further arrays with as many pixels, written as channels such as albedo.R, normal.X, depth.V and body.V.
        Integers become unsigned integers of 32 bits, so that -1 becomes the largest number.
    half
        Write floats of 16 bits. Light above 65504, the largest of them, becomes 65504; a layer with such numbers has
        32 bits.

    Raises
    ------
    ImportError
        If the extra `exr` is not installed.
    OSError
        If the file cannot be written.
    """
    openexr = import_openexr()
    kind = np.float16 if half else np.float32
    data = np.asarray(values)
    if half:
        most = float(np.finfo(np.float16).max)
        data = np.where(np.isfinite(data), np.clip(data, -most, most), data)
    data = _exr_float(data, kind)
    channels = {"RGB" if data.ndim == 3 else "Y": data}
    for name, layer in (layers or {}).items():
        whole = np.asarray(layer).dtype.kind in "iu"
        array = np.asarray(layer).astype(np.uint32) if whole else _exr_float(layer, _layer_kind(layer, half))
        if array.ndim == 2:
            channels[f"{name}.V"] = np.ascontiguousarray(array)
            continue
        for k, letter in enumerate(_LAYER_CHANNELS.get(name, "RGB")):
            channels[f"{name}.{letter}"] = np.ascontiguousarray(array[..., k])
    header = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    with replace_file(path) as part:
        try:
            openexr.File(header, channels).write(str(part))
        except RuntimeError as error:
            raise _exr_os_error(str(error)) from None


def _layer_kind(layer: Any, half: bool) -> Any:
    """Return the type of a layer's channels: a depth or a place that 16 bits cannot hold is not cut."""
    values = np.asarray(layer)
    fits = half and not (np.isfinite(values) & (abs(values) > np.finfo(np.float16).max)).any()
    return np.float16 if fits else np.float32


def _exr_float(values: Any, kind: Any) -> Any:
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(np.asarray(values).astype(kind))


def _exr_os_error(text: str) -> OSError:
    """Convert the message of the OpenEXR library, which hides errno, to the OSError that Python would raise."""
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO):
        if os.strerror(code) in text:
            return OSError(code, os.strerror(code))
    return OSError(errno.EIO, f"cannot be written: {text.splitlines()[0] if text else 'OpenEXR does not say why'}")


# Linear light as bytes of sRGB.
#
# A byte is `srgb_encode` of a value, rounded. The formula takes two roots for each number; but it increases, so the
# byte equals the number of thresholds that the value has reached. The first eight bits of the value's fraction leave at
# most two bytes possible, and one comparison decides between them.

_BUCKET_SHIFT = 44  # bits after the first eight of the fraction of a float64
_FIRST_BUCKET = (1023 - 13) << 8  # exponent and first fraction bits of 2^-13; smaller values are black
_SRGB_CHUNK = 1 << 14  # numbers at a time, so that they stay in the cache


def srgb_bytes(pixels: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return linear pixels of any shape as sRGB bytes (uint8): values are clipped to [0, 1], NaN becomes black."""
    linear = np.ascontiguousarray(pixels)
    values, codes = linear.reshape(-1), np.empty(linear.size, np.uint8)
    below, next_above = _srgb_table()
    for begin in range(0, len(values), _SRGB_CHUNK):
        part = values[begin : begin + _SRGB_CHUNK].astype(np.float64)
        with np.errstate(invalid="ignore"):
            np.copyto(part, 0.0, where=~(part > 0.0))  # NaN too
        np.minimum(part, 1.0, out=part)
        # The bits of floats >= 0, read as integers, have the order of the floats: shifted, they number the buckets.
        first = below[np.maximum((part.view(np.int64) >> _BUCKET_SHIFT) - _FIRST_BUCKET, 0)]
        np.add(first, part >= next_above[first], out=codes[begin : begin + _SRGB_CHUNK])
    return codes.reshape(linear.shape)


def srgb_words(pixels: npt.ArrayLike) -> npt.NDArray[np.uint16]:
    """Return linear pixels as uint16 of sRGB, 65,535 being white, clipped as in `srgb_bytes`.

    They are computed by the formula: a table of so many thresholds takes as long.
    """
    cut = np.clip(np.nan_to_num(np.asarray(pixels, dtype=np.float64), nan=0.0, posinf=1.0), 0.0, 1.0)
    return np.rint(65535 * srgb_encode(cut)).astype(np.uint16)


def _srgb_codes(values: Floats) -> npt.NDArray[np.uint8]:
    """Return the sRGB bytes of linear values in [0, 1] by the formula."""
    return np.rint(255 * srgb_encode(values)).astype(np.uint8)


@lru_cache(maxsize=1)
def _srgb_table() -> tuple[Any, Floats]:
    """Return the byte of the least number of each bucket, and for each byte the least number of the next byte.

    A bucket holds the numbers that share their exponent and the first eight bits of their fraction. The thresholds are
    found by bisection of the bits of floats.
    """
    beginnings = np.arange(_FIRST_BUCKET, (1023 << 52 >> _BUCKET_SHIFT) + 1)
    # The bits of 0 and of 1. Bits of floats >= 0 have the order of the floats.
    low, high = np.zeros(255, np.int64), np.full(255, 1023 << 52, np.int64)
    byte_numbers = np.arange(1, 256)
    while (high - low > 1).any():
        middle = (low + high) >> 1
        reached = _srgb_codes(middle.view(np.float64)) >= byte_numbers
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return _srgb_codes((beginnings << _BUCKET_SHIFT).view(np.float64)), np.append(high.view(np.float64), np.inf)


# PNG: 8 or 16 bits of sRGB for each channel.
#
# For whoever renders: Pillow takes twice the time for files as large (12 ms instead of 6 for 600 x 440 pixels), 23 ms
# more for its import, and has no colour images of 16 bits for each channel.

_PERCEPTUAL = b"\x00"  # rendering intent in the sRGB chunk
_LEVEL = 3  # zlib level of 8-bit files: half the time of level 6, and images of smooth bodies are no larger
_DEEP_LEVEL = 6
_MOST = 1 << 30  # bytes of a chunk, which must be fewer than 2^31
_RGB, _UP = 2, 2  # colour type, and the filter "Up" of a row


def png_bytes(pixels: npt.ArrayLike) -> bytes:
    """Return a PNG file of linear pixels (height, width, 3); values are clipped to [0, 1], NaN becomes black."""
    return _png_file(srgb_bytes(pixels), 8, _LEVEL)


def _png_file(codes: npt.NDArray[Any], bits: int, level: int) -> bytes:
    """Return a PNG file of codes (height, width, 3), by the PNG specification, third edition, 2025.

    Each row holds its differences from the row above (filter 2, "Up"), modulo 256 in each byte. A filter for each row,
    as Pillow chooses it, would make files no smaller.
    """
    height, width, _ = codes.shape
    rows = codes.view(np.uint8).reshape(height, -1)
    lines = np.empty((height, 1 + rows.shape[1]), np.uint8)
    lines[:, 0] = _UP
    lines[:1, 1:] = rows[:1]  # the row above the first counts as zeros
    np.subtract(rows[1:], rows[:-1], out=lines[1:, 1:])
    header = struct.pack(">IIBBBBB", width, height, bits, _RGB, 0, 0, 0)
    data = zlib.compress(lines.data, level)
    pieces = [(b"IDAT", data[begin : begin + _MOST]) for begin in range(0, len(data), _MOST)]
    parts = ((b"IHDR", header), (b"sRGB", _PERCEPTUAL), *pieces, (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in parts
    )


def write_png(path: str | os.PathLike[str], pixels: npt.ArrayLike, bits: int = 8) -> None:
    """Write linear pixels (height, width, 3) with 8 or 16 bits per channel; the file appears whole or not at all."""
    with replace_file(path) as part:
        part.write_bytes(
            png_bytes(pixels) if bits == 8 else _png_file(srgb_words(pixels).astype(">u2"), 16, _DEEP_LEVEL)
        )


# Images for mail and web pages: JPEG, slightly lossy, and WebP, lossless. Both hold 8 bits of sRGB per channel.

PHOTO_OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    ".jpg": ("JPEG", dict(quality=92, subsampling=0)),
    ".jpeg": ("JPEG", dict(quality=92, subsampling=0)),
    ".webp": ("WEBP", dict(lossless=True)),
}
"""Suffix -> Pillow's format and its options."""


def write_photo(path: str | os.PathLike[str], pixels: npt.ArrayLike, suffix: str) -> None:
    """Write linear pixels (height, width, 3) as JPEG or WebP; the file appears whole or not at all.

    `suffix` is a key of `PHOTO_OPTIONS`. Raise ValueError if an image has more pixels a side than the format allows.
    """
    from PIL import Image

    kind, options = PHOTO_OPTIONS[suffix]
    stream = io.BytesIO()
    try:
        Image.fromarray(srgb_bytes(pixels), "RGB").save(stream, kind, **options)
    except (KeyError, OSError, ValueError) as error:
        raise ValueError(f"Image: {os.fspath(path)} cannot be written as {kind}: {error}") from None
    with replace_file(path) as part:
        part.write_bytes(stream.getvalue())


# Images in a terminal: each character shows two pixels, one above the other, as an upper half block on a background.

UPPER_HALF = "▀"


def downsample(pixels: FloatArray, columns: int, rows: int) -> FloatArray:
    """Return an image (height, width, 3) shrunk to fit into `columns` x `rows` pixels, by means of light.

    The sides keep their ratio, and images are never enlarged.
    """
    height, width = pixels.shape[:2]
    share = min(1.0, columns / width, rows / height)
    high, wide = max(1, int(height * share)), max(1, int(width * share))
    y, x = (np.arange(n) * size // n for n, size in ((high, height), (wide, width)))
    # Light adds up, codes of sRGB do not
    total = np.add.reduceat(np.add.reduceat(np.asarray(pixels, float), y, axis=0), x, axis=1)
    sizes = np.diff(np.append(y, height))[:, None] * np.diff(np.append(x, width))
    return np.asarray(total / sizes[..., None])


def render_half_blocks(pixels: FloatArray, columns: int, rows: int) -> Text:
    """Return an image (height, width, 3) of linear light as text of at most `columns` x `rows` characters."""
    from rich.text import Text

    shown = np.asarray(srgb_bytes(downsample(pixels, columns, 2 * rows).astype(np.float32)))
    text = Text(end="", no_wrap=True)
    for top in range(0, len(shown), 2):
        if top:
            text.append("\n")
        for column in range(shown.shape[1]):
            text.append(UPPER_HALF, _half_block_style(shown[top : top + 2, column]))
    return text


def _half_block_style(pair: npt.NDArray[np.uint8]) -> str:
    """Return the rich style of one character: the colours of its two pixels, or of one in an odd last row."""
    over, under = ("#" + bytes(pixel.tolist()).hex() for pixel in (pair[0], pair[-1]))
    return f"{over} on {under}" if len(pair) == 2 else over


def terminal_preview() -> Callable[[Any], None]:
    """Return a function that draws an Image in the terminal at stderr, each over the one before.

    The function does nothing if stderr is not a terminal.
    """
    from rich.console import Console
    from rich.control import Control
    from rich.segment import ControlType

    console, above = Console(stderr=True), [0]

    def preview(image: Any) -> None:
        if not console.is_terminal:
            return
        # Two lines are left for the cursor and for the next output of the program
        drawn = render_half_blocks(image._display_light, console.width, max(1, console.height - 2))
        if above[0]:
            console.control(Control((ControlType.CURSOR_UP, above[0])))
        console.print(drawn, end="\n")
        above[0] = drawn.plain.count("\n") + 1

    return preview


# Movies: GIF and WebP by Pillow, MP4 (H.264) by PyAV, an extra. Files appear whole or not at all.

MOVIE_SUFFIXES = (".gif", ".webp", ".mp4")
"""Suffixes of the files of movies."""
_FASTEST = 50  # frames a second of a GIF: browsers show faster ones slowly
_LONGEST = {".gif": 655, ".webp": 16777, ".mp4": 1000}
"""Most seconds of a frame: 16 bits of hundredths, 24 bits of milliseconds, and the least frame rate that we write."""
_LONGEST_SIDE = {".gif": 65535, ".webp": 16383, ".mp4": 16384}
"""Most pixels of a side."""
_SAMPLED = 12  # frames that the colours of a GIF are chosen from
_BT709 = 1  # the code of BT.709 for matrix, primaries and transfer curve alike

MovieProgress = Callable[[int, int], Any]


def check_movie(path: str | os.PathLike[str], width: int, height: int, frames: int, seconds: float) -> None:
    """Raise ValueError for a movie that could not be written; callers check before they render frames.

    `width` and `height` are in pixels, `seconds` is the time of all frames. Raise ImportError for a .mp4 if PyAV is
    not installed.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MOVIE_SUFFIXES:
        raise ValueError(f"turntable: movies are saved as {', '.join(MOVIE_SUFFIXES)}, got {os.fspath(path)[:200]!r}")
    if max(width, height) > _LONGEST_SIDE[suffix]:
        raise ValueError(
            f"turntable: a {suffix} has at most {_LONGEST_SIDE[suffix]} pixels a side, got {width} x {height}"
        )
    if suffix == ".gif" and frames > _FASTEST * seconds:
        raise ValueError(
            f"turntable: a .gif shows at most {_FASTEST} frames a second, got {frames} in {seconds:g} seconds"
        )
    if seconds > _LONGEST[suffix] * frames:
        raise ValueError(
            f"turntable: a {suffix} shows a frame for at most {_LONGEST[suffix]} seconds, "
            f"got {frames} frames in {seconds:g} seconds"
        )
    if suffix == ".mp4":
        if width % 2 or height % 2:
            raise ValueError(f"turntable: width and height of a .mp4 must be even, got {width} x {height}")
        _av()


def write_movie(
    path: str | os.PathLike[str], frames: Sequence[Path], seconds: float, progress: MovieProgress | None = None
) -> None:
    """Write a movie of `seconds` from image files of one size. GIF and WebP repeat for ever.

    `progress(done, count)` is called after each frame. The suffix of `path` chooses the format.
    """
    write = {".gif": _write_gif, ".webp": _write_webp, ".mp4": _write_mp4}[Path(path).suffix.lower()]
    with replace_file(path) as partial:
        write(partial, frames, seconds, progress or (lambda done, count: None))


def _write_gif(path: Path, frames: Sequence[Path], seconds: float, progress: MovieProgress) -> None:
    """Write a GIF with one palette for all frames, so that parts that stand still do not flicker."""
    from PIL import Image

    # Of frames all through the film, as colours at its end may be new
    some = [_open_frame(frames[i]) for i in range(0, len(frames), -(-len(frames) // _SAMPLED))]
    strip = Image.new("RGB", (some[0].width, sum(frame.height for frame in some)))
    for k, frame in enumerate(some):
        strip.paste(frame, (0, k * frame.height))
    palette = strip.quantize(256)
    pictures = (frame.quantize(palette=palette) for frame in _report_frames(frames, progress))
    next(pictures).save(
        path, save_all=True, append_images=pictures, loop=0, duration=_durations(len(frames), seconds, 10)
    )


def _write_webp(path: Path, frames: Sequence[Path], seconds: float, progress: MovieProgress) -> None:
    pictures = _report_frames(frames, progress)
    durations = _durations(len(frames), seconds, 1)
    next(pictures).save(path, save_all=True, append_images=pictures, loop=0, duration=durations, lossless=True)


def _write_mp4(path: Path, frames: Sequence[Path], seconds: float, progress: MovieProgress) -> None:
    """Write H.264 in BT.709, the colour matrix that players assume."""
    av = _av()
    rate = (Fraction(len(frames)) / Fraction(seconds)).limit_denominator(1000)
    with av.open(str(path), "w", options={"movflags": "faststart"}) as movie:
        stream = movie.add_stream("libx264", rate=rate, options={"crf": "17", "preset": "slow"})
        stream.width, stream.height = _open_frame(frames[0]).size
        # The one layout of pixels that all players decode
        stream.pix_fmt, context = "yuv420p", stream.codec_context
        context.colorspace = context.color_primaries = context.color_trc = context.color_range = _BT709
        for picture in _report_frames(frames, progress):
            frame = av.VideoFrame.from_image(picture).reformat(format="yuv420p", dst_colorspace="ITU709")
            movie.mux(stream.encode(frame))
        movie.mux(stream.encode())


def _report_frames(frames: Sequence[Path], progress: MovieProgress) -> Iterator[Any]:
    """Yield the frames, and report progress after each."""
    for done, frame in enumerate(frames, 1):
        yield _open_frame(frame)
        progress(done, len(frames))


def _open_frame(frame: Path) -> Any:
    from PIL import Image

    with Image.open(frame) as file:
        return file.convert("RGB")


def _durations(count: int, seconds: float, unit: int) -> list[int]:
    """Return the milliseconds of each frame: multiples of `unit` that add up to the time of all, up to rounding.

    Ends are rounded, not durations, so that errors do not add up.
    """
    ends = [round(i * seconds * 1000 / (count * unit)) * unit for i in range(count + 1)]
    return [max(unit, end - begin) for begin, end in itertools.pairwise(ends)]


def _av() -> Any:
    with contextlib.suppress(ImportError):
        import av

        return av
    raise ImportError("a .mp4 is written by PyAV: pip install 'conicoid[video]'; .gif and .webp need nothing more")
