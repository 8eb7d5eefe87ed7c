"""Pictures in tiles on workers, and checkpoint files from which a stopped picture goes on."""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from .._util.files import replace_file, resolve_output
from .._util.validation import check_path as checked_path
from ..kernels.threads import Progress
from ..queries.device import Device
from ..queries.device_choice import device_of
from ..queries.scene_protocol import SceneLike
from ..render.exposure import (
    Exposure,
    FilmResult,
    Preview,
    RenderJob,
    empty_sums,
    lower_scene_light,
    render_motion_blur,
    stills,
)
from ..render.film import COUNT, SUMS, mean_pixels
from ..render.integrators import INTEGRATORS
from ..render.tiles import SIDE, SQUARE, tile_corner, tile_total, tiles_of_squares
from .queries import workers_of
from .shared_state import SharedObject, shared_scene, source_version
from .workers import ChunkSize, ScheduledTask, prepare_first, run_tasks

_MAGIC = b"conicoid parts 2\n"
_HEAD = struct.Struct("<QQQI")
"""begin, end, bytes of the part, checksum of these three and of the part."""


class Checkpoint:
    """A file of finished parts of some work, each with a checksum.

    A part that was incomplete when its process died is not read. The file begins with a hash of everything that the
    work depends on, so that parts of other work are never read. Raise ValueError if the file holds other work or
    something else.
    """

    def __init__(self, path: str | os.PathLike[str], key: bytes) -> None:
        self.path = Path(checked_path("render", path, "resume"))
        self.head = _MAGIC + blake2b(key + source_version().encode(), digest_size=16).digest()
        resolve_output(self.path)  # refuses a pipe, which `open` would wait for
        with open(self.path, "ab"):  # create the file if it is missing, keep it otherwise
            pass
        self.file = open(self.path, "r+b")  # noqa: SIM115 - open during the work
        try:
            self._check()
        except BaseException:
            self.file.close()
            raise

    def _check(self) -> None:
        """Check the head, or write it into a new file."""
        head = self.file.read(len(self.head))
        if head != self.head[: len(head)]:
            whose = "other work, or of another version" if head[: len(_MAGIC)] == _MAGIC else "something else"
            raise ValueError(f"{self.path}: holds parts of {whose}; give another name, or remove it")
        if len(head) < len(self.head):
            self.file.seek(0)
            self.file.write(self.head)
            self.file.flush()

    def records(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield the complete parts (begin, end, bytes) in the file, and truncate it after them."""
        at = len(self.head)
        while True:
            self.file.seek(at)
            head = self.file.read(_HEAD.size)
            if len(head) < _HEAD.size:
                break
            begin, end, count, checksum = _HEAD.unpack(head)
            # A length beyond the file is damage: do not allocate it.
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
        """Replace the content of the file by these parts. The old content stays until all are on the disk."""
        self.file.close()
        try:
            with replace_file(self.path) as part:
                other = object.__new__(Checkpoint)
                other.path, other.file = self.path, open(part, "r+b")  # noqa: SIM115 - closed below
                try:
                    other.file.write(self.head)
                    for record in records:
                        other.add(*record)
                finally:
                    other.close()
        finally:
            self.file = open(self.path, "r+b")  # noqa: SIM115 - open during the work
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
        """Append a part. Raise OSError with the file's name if there is no room; earlier parts stay valid."""
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


# Pictures in tiles: on workers, and from a checkpoint.

_LARGE = 1 << 26  # bytes
_MOST = 1 << 12  # tiles of a task: 50 MB
_OF_DASK = 1 << 9  # tiles of a task for Dask: few enough for no warning


@prepare_first
def tiles_part(scene: SceneLike, job: RenderJob, keeps: bool, begin: int, end: int, before: Any) -> Any:
    """Render tiles `begin` to `end`. Return their pixels, each tile's rows one after the other: (pixels, 3).

    With `keeps`, return their sums instead, (pixels, SUMS). `before` are the earlier sums of these tiles, or None.
    """
    keeps = keeps or job.keeps_sums
    gpu = device_of("render", None)  # as CONICOID_DEVICE of the worker says
    exposure = Exposure(scene, job, keeps, begin, end, _look(scene, job), job.shutter is not None, gpu)
    if before is not None:
        put_tiles(exposure.sums, begin, end, before)
    exposure.go_on()
    return tiles_of(exposure.sums if keeps else exposure.film, begin, end)


def _look(scene: SceneLike, job: RenderJob) -> Any:
    """Return materials, lights and background in the form of kernels; the scene caches those of its last camera."""
    key = job.view, INTEGRATORS[job.integrator].module
    cached = vars(scene).get("_look")
    if cached is None or cached[0] != key:
        cached = vars(scene)["_look"] = key, lower_scene_light(scene, job.view, job.integrator)
    return cached[1]


def tile_slices(begin: int, end: int, width: int) -> Iterator[tuple[slice, slice]]:
    """Yield rows and columns of each tile of a film of this width."""
    for tile in range(begin, end):
        column, row = tile_corner(tile, width)
        yield slice(row, row + SIDE), slice(column, column + SIDE)


def put_tiles(film: Any, begin: int, end: int, pixels: Any) -> None:
    """Put tiles in the form of `tiles_part` onto the film, or among the sums."""
    at = 0
    for square in tile_slices(begin, end, film.shape[1]):
        part = film[square]
        count = part.shape[0] * part.shape[1]
        part[:] = pixels[at : at + count].reshape(part.shape)
        at += count


def render_tiles(
    scene: SceneLike, job: RenderJob, keeps: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None, fixed: bool = False, gpu: Device | None = None,
) -> FilmResult:  # fmt: skip
    """Render a picture in tiles on workers, or from a checkpoint.

    keeps: return the sums of its samples as well.
    resume: a file of the sums of tiles. Its tiles are used, and new ones are added as they come.
    fixed: with a shutter, the camera of the job is that of all moments.
    gpu: in place of the threads of this process, where there is no executor.
    """
    if executor is not None and preview is not None:
        raise TypeError("render: preview goes with pictures of this process, not with an executor")
    if job.shutter is not None:
        return _render_shutter(scene, job, fixed, executor, resume, progress, preview, gpu)
    recipes = shared_scene(scene), SharedObject(job)
    if resume is None:
        if not (keeps or job.keeps_sums):
            film = np.zeros((job.height, job.width, 3), np.float32)
            _render_on_workers(job, executor, recipes, progress, film, None)
            return FilmResult(film, None)
        sums = empty_sums(job)
        _render_on_workers(job, executor, recipes, progress, sums, None)
        return FilmResult(mean_pixels(sums), sums)
    checkpoint = TileCheckpoint(resume, recipes[0].key + SharedObject(_job_identity(job)).key, job)
    try:
        if executor is None:
            return _render_in_process(scene, job, progress, preview, checkpoint, gpu)
        sums = empty_sums(job)
        checkpoint.read(sums)
        _render_on_workers(job, executor, recipes, progress, sums, checkpoint)
        return FilmResult(mean_pixels(sums), sums)
    finally:
        checkpoint.close()


def _job_identity(job: RenderJob) -> RenderJob:
    """Return the part of the job that its samples depend on: a progressive picture may get more, or less noise."""
    if job.shutter is not None:  # its samples are distributed over moments
        return job if job.noise is None else replace(job, noise=1.0)
    return replace(job, samples=1, noise=None) if job.is_progressive else job


def _render_shutter(
    scene: SceneLike, job: RenderJob, fixed: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None, gpu: Device | None,
) -> FilmResult:  # fmt: skip
    """Render a picture with a shutter: one moment after the other, with common sums."""
    key = shared_scene(scene).key + SharedObject((_job_identity(job), fixed)).key
    checkpoint = None if resume is None else TileCheckpoint(resume, key, job)
    try:
        if executor is None:
            return render_motion_blur(scene, job, fixed, progress, preview, checkpoint, gpu)
        sums = empty_sums(job)
        if checkpoint is not None:
            checkpoint.read(sums)
        # Samples of a moment follow those of the moment before it.
        first_tile = 0
        for moment, part in stills(scene, job, fixed, sums):
            moment_progress = progress and _of_moment(progress, first_tile, part.samples, job.samples)
            _render_on_workers(
                part, executor, (shared_scene(moment), SharedObject(part)), moment_progress, sums, checkpoint
            )
            first_tile = part.samples
        return FilmResult(mean_pixels(sums), sums)
    finally:
        if checkpoint is not None:
            checkpoint.close()


def _of_moment(progress: Progress, begun: int, end: int, of: int) -> Progress:
    """Return the progress function of the samples from `begun` to `end`, as a share of all samples."""
    return lambda done, count: progress(begun * count + done * (end - begun), of * count)


def _render_in_process(
    scene: SceneLike, job: RenderJob, progress: Progress | None, preview: Preview | None, checkpoint: TileCheckpoint,
    gpu: Device | None,
) -> FilmResult:  # fmt: skip
    """Render in this process, which passes over all tiles several times."""
    exposure = Exposure(scene, job, True, device=gpu)
    checkpoint.read(exposure.sums)
    exposure.go_on(progress, preview, lambda tiles: checkpoint.add(exposure.sums, tiles))
    return FilmResult(exposure.film, exposure.sums)


def _render_on_workers(
    job: RenderJob,
    executor: Any,
    recipes: tuple[SharedObject, SharedObject],
    progress: Progress | None,
    film: Any,
    checkpoint: TileCheckpoint | None,
) -> None:
    """Render on workers, each tile from its first sample to its last, onto the film; of sums, only missing samples.

    checkpoint: receives sums as they come, or None.
    """
    workers = workers_of("render", executor, progress)
    total = tile_total(job.width, job.height)
    keeps = film.shape[2] == SUMS
    # Sums may come from a checkpoint: only tiles that still need samples are sent.
    gaps = _gaps(film, total, job) if keeps else [(0, total)]
    pace = ChunkSize(workers.chunk, 1, _OF_DASK if workers.is_dask else _MOST, workers.count)
    pieces = (
        ScheduledTask(a, b, (a, b, _previous_sums(film, a, b) if keeps else None))
        for gap in gaps
        for a, b in pace.pieces(*gap)
    )
    missing = sum(b - a for a, b in gaps)
    shared = *recipes, SharedObject(keeps)
    with run_tasks("render", workers, tiles_part, shared, pieces, pace.saw, total, total - missing) as results:
        for piece, pixels in results:
            put_tiles(film, piece.begin, piece.end, pixels)
            if checkpoint is not None:
                checkpoint.add(film, [(piece.begin, piece.end)])


def _previous_sums(sums: Any, begin: int, end: int) -> Any:
    """Return the sums of tiles that have samples already, or None."""
    tiles = tiles_of(sums, begin, end)
    return tiles if tiles[:, COUNT].any() else None


def tiles_of(sums: Any, begin: int, end: int) -> Any:
    """Return tiles of a film or of sums, each tile's rows one after the other."""
    return np.concatenate(
        [sums[square].reshape(-1, sums.shape[2]) for square in tile_slices(begin, end, sums.shape[1])]
    )


def _gaps(sums: Any, total: int, job: RenderJob) -> list[tuple[int, int]]:
    """Return ranges of tiles with pixels that still need samples."""
    row, column = np.nonzero(job.sample_mask(sums, job.samples, SQUARE))
    present = np.ones(total + 1, np.bool_)
    present[tiles_of_squares(row, column, job.width)] = False
    steps = np.diff(np.concatenate([[True], present]).astype(np.int8))
    begins, ends = np.flatnonzero(steps < 0).tolist(), np.flatnonzero(steps > 0).tolist()
    return list(zip(begins, ends, strict=True))


class TileCheckpoint:
    """The sums of a picture's tiles in a file. Later parts replace earlier ones."""

    def __init__(self, path: str | os.PathLike[str], key: bytes, job: RenderJob) -> None:
        self._file = Checkpoint(path, key)
        self._whole = job.width * job.height * SUMS * 8

    def read(self, sums: Any) -> None:
        """Put the sums of the file among `sums`."""
        for begin, end, data in self._file.records():
            put_tiles(sums, begin, end, np.frombuffer(data, "<f8").reshape(-1, SUMS))

    def add(self, sums: Any, tiles: list[tuple[int, int]]) -> None:
        """Append tiles; rewrite a file that is several times as large as necessary."""
        parts = ((begin, end, _bytes_of(sums, begin, end)) for begin, end in tiles)
        # Each pass appends all tiles again, so the file grows until it is rewritten.
        if self._file.size > _LARGE + 4 * self._whole:
            total = tile_total(sums.shape[1], sums.shape[0])
            ranges = ((k, min(k + 64, total)) for k in range(0, total, 64))
            self._file.rewrite((begin, end, _bytes_of(sums, begin, end)) for begin, end in ranges)
            return
        for part in parts:
            self._file.add(*part)
        self._file.sync()

    def close(self) -> None:
        """Close the file, which stays."""
        self._file.close()


def _bytes_of(sums: Any, begin: int, end: int) -> bytes:
    """Return the sums of tiles as bytes."""
    return np.ascontiguousarray(tiles_of(sums, begin, end), "<f8").tobytes()
