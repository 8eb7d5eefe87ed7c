"""Movies: GIF and WebP by Pillow, MP4 (H.264) by PyAV, an extra. Files appear whole or not at all."""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..._util.safe_files import replace_file

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
