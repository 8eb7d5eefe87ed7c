"""A file of finished parts of some work, each with a checksum: what was being written when a process died is not read.

It begins with a name of the work (a hash of all it depends on), so that parts of another one are never taken for its.
"""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.safe_files import replace_file
from .._util.validation import check_path as checked_path
from ..render.exposure import Exposure
from ..render.film.film import COUNT, SUMS, mean_pixels
from ..render.integrators import INTEGRATORS
from ..render.job import FilmResult, RenderJob, lower_scene_light
from ..render.motion_blur import empty_sums, render_motion_blur, stills
from ..render.tiles import SIDE, SQUARE, tile_corner, tile_total, tiles_of_squares
from .queries import workers_of
from .scheduler import ChunkSize, ScheduledTask, Scheduler, cancel_on_exit, prepare_first
from .shared_state import SharedObject, shared_scene, source_version

if TYPE_CHECKING:
    from ..kernels.threads import Progress
    from ..queries.scene_protocol import SceneLike
    from ..render.exposure import Preview


_MAGIC = b"conicoid parts 2\n"
_HEAD = struct.Struct("<QQQI")
"""begin, end, bytes of the part, checksum of these three and of it"""


class Checkpoint:
    """Parts of the work of a key, at `path`. Raises ValueError where the file is of other work or of something else."""

    def __init__(self, path: str | os.PathLike[str], key: bytes) -> None:
        self.path = Path(checked_path("render", path, "resume"))
        self.head = _MAGIC + blake2b(key + source_version().encode(), digest_size=16).digest()
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


# Pictures in tiles: on workers, and gone on with where a driver was stopped.

_LARGE = 1 << 26  # bytes
_MOST = 1 << 12  # tiles of a task: 50 MB
_OF_DASK = 1 << 9  # less than Dask warns of


@prepare_first
def tiles_part(scene: SceneLike, job: RenderJob, keeps: bool, begin: int, end: int, before: Any) -> Any:
    """The pixels of tiles `begin` to `end`, each tile's rows one after the other: (pixels, 3).

    keeps: their sums instead, (pixels, SUMS). before: those that there were.
    """
    keeps = keeps or job.keeps_sums
    exposure = Exposure(scene, job, keeps, begin, end, _look(scene, job), job.shutter is not None)
    if before is not None:
        put_tiles(exposure.sums, begin, end, before)
    exposure.go_on()
    return tiles_of(exposure.sums if keeps else exposure.film, begin, end)


def _look(scene: SceneLike, job: RenderJob) -> Any:
    """Materials, lights and background as kernels take them, kept with the scene for the camera of the last picture."""
    asked = job.view, INTEGRATORS[job.integrator].module
    known = vars(scene).get("_look")
    if known is None or known[0] != asked:
        known = vars(scene)["_look"] = asked, lower_scene_light(scene, job.view, job.integrator)
    return known[1]


def tile_slices(begin: int, end: int, width: int) -> Iterator[tuple[slice, slice]]:
    """The pixels of each tile of a film so wide."""
    for tile in range(begin, end):
        column, row = tile_corner(tile, width)
        yield slice(row, row + SIDE), slice(column, column + SIDE)


def put_tiles(film: Any, begin: int, end: int, pixels: Any) -> None:
    """Tiles, as `tiles_part` brings them, onto the film, or among the sums."""
    at = 0
    for square in tile_slices(begin, end, film.shape[1]):
        part = film[square]
        count = part.shape[0] * part.shape[1]
        part[:] = pixels[at : at + count].reshape(part.shape)
        at += count


def render_tiles(
    scene: SceneLike, job: RenderJob, keeps: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None, fixed: bool = False,
) -> FilmResult:  # fmt: skip
    """A picture whose tiles are made on workers, or that goes on where it was stopped.

    keeps: are the sums of its samples wanted?
    resume: a file of the sums of tiles. Those in it are taken, and new ones added as they come.
    fixed: with a shutter, is the camera that of the job throughout?
    """
    if executor is not None and preview is not None:
        raise TypeError("render: preview goes with pictures of this process, not with an executor")
    if job.shutter is not None:
        return _open(scene, job, fixed, executor, resume, progress, preview)
    recipes = shared_scene(scene), SharedObject(job)
    if resume is None:
        if not (keeps or job.keeps_sums):
            film = np.zeros((job.height, job.width, 3), np.float32)
            _render_on_workers(scene, job, executor, recipes, progress, film, None)
            return FilmResult(film, None)
        sums = empty_sums(job)
        _render_on_workers(scene, job, executor, recipes, progress, sums, None)
        return FilmResult(mean_pixels(sums), sums)
    kept = TileCheckpoint(resume, recipes[0].key + SharedObject(_job_identity(job)).key, job)
    try:
        if executor is None:
            return _render_here(scene, job, progress, preview, kept)
        sums = empty_sums(job)
        kept.read(sums)
        _render_on_workers(scene, job, executor, recipes, progress, sums, kept)
        return FilmResult(mean_pixels(sums), sums)
    finally:
        kept.close()


def _job_identity(job: RenderJob) -> RenderJob:
    """The job as far as its samples depend on it: of a progressive picture there may be more, or less noise."""
    if job.shutter is not None:  # whose samples are shared out among moments
        return job if job.noise is None else replace(job, noise=1.0)
    return replace(job, samples=1, noise=None) if job.is_progressive else job


def _open(
    scene: SceneLike, job: RenderJob, fixed: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None,
) -> FilmResult:  # fmt: skip
    """A picture with a shutter: one moment after the other, whose samples share the sums."""
    key = shared_scene(scene).key + SharedObject((_job_identity(job), fixed)).key
    kept = None if resume is None else TileCheckpoint(resume, key, job)
    try:
        if executor is None:
            return render_motion_blur(scene, job, fixed, progress, preview, kept)
        sums = empty_sums(job)
        if kept is not None:
            kept.read(sums)
        begun = 0
        for still, part in stills(scene, job, fixed, sums):
            told = progress and _of_moment(progress, begun, part.samples, job.samples)
            _render_on_workers(still, part, executor, (shared_scene(still), SharedObject(part)), told, sums, kept)
            begun = part.samples
        return FilmResult(mean_pixels(sums), sums)
    finally:
        if kept is not None:
            kept.close()


def _of_moment(progress: Progress, begun: int, end: int, of: int) -> Progress:
    """Progress of the samples from `begun` to `end` as of all."""
    return lambda done, count: progress(begun * count + done * (end - begun), of * count)


def _render_here(
    scene: SceneLike, job: RenderJob, progress: Progress | None, preview: Preview | None, kept: TileCheckpoint
) -> FilmResult:
    """By the threads of this process, which go over all tiles again and again."""
    exposure = Exposure(scene, job, True)
    kept.read(exposure.sums)
    exposure.go_on(progress, preview, lambda tiles: kept.add(exposure.sums, tiles))
    return FilmResult(exposure.film, exposure.sums)


def _render_on_workers(
    scene: SceneLike,
    job: RenderJob,
    executor: Any,
    recipes: tuple[SharedObject, SharedObject],
    progress: Progress | None,
    film: Any,
    kept: TileCheckpoint | None,
) -> None:
    """By workers, each tile from its first sample to its last, onto the film; if it is of sums, what is missing there.

    kept: where sums are added as they come, or None.
    """
    workers = workers_of("render", executor, progress)
    total = tile_total(job.width, job.height)
    keeps = film.shape[2] == SUMS
    gaps = _gaps(film, total, job) if keeps else [(0, total)]
    pace = ChunkSize(workers.chunk, 1, _OF_DASK if workers.is_dask else _MOST, workers.count)
    pieces = (
        ScheduledTask(a, b, (a, b, _previous_sums(film, a, b) if keeps else None))
        for gap in gaps
        for a, b in pace.pieces(*gap)
    )
    missing = sum(b - a for a, b in gaps)
    course = Scheduler("render", workers, tiles_part, (*recipes, SharedObject(keeps)))
    with cancel_on_exit(course.results(pieces, pace.saw, total, total - missing)) as results:
        for piece, pixels in results:
            put_tiles(film, piece.begin, piece.end, pixels)
            if kept is not None:
                kept.add(film, [(piece.begin, piece.end)])


def _previous_sums(sums: Any, begin: int, end: int) -> Any:
    """The sums of tiles that have samples already."""
    found = tiles_of(sums, begin, end)
    return found if found[:, COUNT].any() else None


def tiles_of(sums: Any, begin: int, end: int) -> Any:
    """Tiles of a film or of sums, each tile's rows one after the other."""
    return np.concatenate(
        [sums[square].reshape(-1, sums.shape[2]) for square in tile_slices(begin, end, sums.shape[1])]
    )


def _gaps(sums: Any, total: int, job: RenderJob) -> list[tuple[int, int]]:
    """The tiles in which some pixels are to get samples."""
    row, column = np.nonzero(job.wanted(sums, job.samples, SQUARE))
    done = np.ones(total + 1, np.bool_)
    done[tiles_of_squares(row, column, job.width)] = False
    steps = np.diff(np.concatenate([[True], done]).astype(np.int8))
    begins, ends = np.flatnonzero(steps < 0).tolist(), np.flatnonzero(steps > 0).tolist()
    return list(zip(begins, ends, strict=True))


class TileCheckpoint:
    """The sums of a picture's tiles in a file. Later parts take the place of earlier ones."""

    def __init__(self, path: str | os.PathLike[str], key: bytes, job: RenderJob) -> None:
        self._file = Checkpoint(path, key)
        self._whole = job.width * job.height * SUMS * 8

    def read(self, sums: Any) -> None:
        """Fill in what there is."""
        for begin, end, data in self._file.records():
            put_tiles(sums, begin, end, np.frombuffer(data, "<f8").reshape(-1, SUMS))

    def add(self, sums: Any, tiles: list[tuple[int, int]]) -> None:
        """Add tiles; a file that has become several times as large as it need be is written anew."""
        parts = ((begin, end, _bytes_of(sums, begin, end)) for begin, end in tiles)
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
    return np.ascontiguousarray(tiles_of(sums, begin, end), "<f8").tobytes()
