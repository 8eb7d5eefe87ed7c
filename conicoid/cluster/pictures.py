"""Pictures in tiles: on workers, and gone on with where a driver was stopped."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..film.sums import COUNT, SUMS, pixels_of
from ..integrators import INTEGRATORS
from ..render.frame import SQUARE
from ..render.passes import Exposure
from ..render.picture import Exposed, Job, light_of
from ..render.shutter import no_sums, render_open, stills
from ..render.tiles import SIDE, tile_corner, tile_total, tiles_of_squares
from .checkpoint import Checkpoint
from .course import Course, Piece, closing
from .pace import Pace
from .queries import workers_of
from .recipe import Recipe, recipe_of
from .task import prepared_first

if TYPE_CHECKING:
    from ..engine.threads import Progress
    from ..render.passes import Preview
    from ..scene import Scene

_LARGE = 1 << 26  # bytes
_MOST = 1 << 12  # tiles of a task: 50 MB
_OF_DASK = 1 << 9  # less than Dask warns of


@prepared_first
def tiles_part(scene: Scene, job: Job, keeps: bool, begin: int, end: int, before: Any) -> Any:
    """The pixels of tiles `begin` to `end`, each tile's rows one after the other: (pixels, 3).

    keeps: their sums instead, (pixels, SUMS). before: those that there were.
    """
    keeps = keeps or job.keeps_sums
    exposure = Exposure(scene, job, keeps, begin, end, _look(scene, job), job.shutter is not None)
    if before is not None:
        put(exposure.sums, begin, end, before)
    exposure.go_on()
    return tiles_of(exposure.sums if keeps else exposure.film, begin, end)


def _look(scene: Scene, job: Job) -> Any:
    """Materials, lights and background as kernels take them, kept with the scene for the camera of the last picture."""
    asked = job.view, INTEGRATORS[job.integrator].module
    known = vars(scene).get("_look")
    if known is None or known[0] != asked:
        known = vars(scene)["_look"] = asked, light_of(scene, job.view, job.integrator)
    return known[1]


def squares(begin: int, end: int, width: int) -> Iterator[tuple[slice, slice]]:
    """The pixels of each tile of a film so wide."""
    for tile in range(begin, end):
        column, row = tile_corner(tile, width)
        yield slice(row, row + SIDE), slice(column, column + SIDE)


def put(film: Any, begin: int, end: int, pixels: Any) -> None:
    """Tiles, as `tiles_part` brings them, onto the film, or among the sums."""
    at = 0
    for square in squares(begin, end, film.shape[1]):
        part = film[square]
        count = part.shape[0] * part.shape[1]
        part[:] = pixels[at : at + count].reshape(part.shape)
        at += count


def rendered(
    scene: Scene, job: Job, keeps: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None, fixed: bool = False,
) -> Exposed:  # fmt: skip
    """A picture whose tiles are made on workers, or that goes on where it was stopped.

    keeps: are the sums of its samples wanted?
    resume: a file of the sums of tiles. Those in it are taken, and new ones added as they come.
    fixed: with a shutter, is the camera that of the job throughout?
    """
    if executor is not None and preview is not None:
        raise TypeError("render: preview goes with pictures of this process, not with an executor")
    if job.shutter is not None:
        return _open(scene, job, fixed, executor, resume, progress, preview)
    recipes = recipe_of(scene), Recipe(job)
    if resume is None:
        if not (keeps or job.keeps_sums):
            film = np.zeros((job.height, job.width, 3), np.float32)
            _on_workers(scene, job, executor, recipes, progress, film, None)
            return Exposed(film, None)
        sums = no_sums(job)
        _on_workers(scene, job, executor, recipes, progress, sums, None)
        return Exposed(pixels_of(sums), sums)
    kept = Kept(resume, recipes[0].key + Recipe(_what(job)).key, job)
    try:
        if executor is None:
            return _here(scene, job, progress, preview, kept)
        sums = no_sums(job)
        kept.read(sums)
        _on_workers(scene, job, executor, recipes, progress, sums, kept)
        return Exposed(pixels_of(sums), sums)
    finally:
        kept.close()


def _what(job: Job) -> Job:
    """The job as far as its samples depend on it: of a progressive picture there may be more, or less noise."""
    if job.shutter is not None:  # whose samples are shared out among moments
        return job if job.noise is None else replace(job, noise=1.0)
    return replace(job, samples=1, noise=None) if job.is_progressive else job


def _open(
    scene: Scene, job: Job, fixed: bool, executor: Any, resume: str | os.PathLike[str] | None,
    progress: Progress | None, preview: Preview | None,
) -> Exposed:  # fmt: skip
    """A picture with a shutter: one moment after the other, whose samples share the sums."""
    key = recipe_of(scene).key + Recipe((_what(job), fixed)).key
    kept = None if resume is None else Kept(resume, key, job)
    try:
        if executor is None:
            return render_open(scene, job, fixed, progress, preview, kept)
        sums = no_sums(job)
        if kept is not None:
            kept.read(sums)
        begun = 0
        for still, part in stills(scene, job, fixed, sums):
            told = progress and _of_moment(progress, begun, part.samples, job.samples)
            _on_workers(still, part, executor, (recipe_of(still), Recipe(part)), told, sums, kept)
            begun = part.samples
        return Exposed(pixels_of(sums), sums)
    finally:
        if kept is not None:
            kept.close()


def _of_moment(progress: Progress, begun: int, end: int, of: int) -> Progress:
    """Progress of the samples from `begun` to `end` as of all."""
    return lambda done, count: progress(begun * count + done * (end - begun), of * count)


def _here(scene: Scene, job: Job, progress: Progress | None, preview: Preview | None, kept: Kept) -> Exposed:
    """By the threads of this process, which go over all tiles again and again."""
    exposure = Exposure(scene, job, True)
    kept.read(exposure.sums)
    exposure.go_on(progress, preview, lambda tiles: kept.add(exposure.sums, tiles))
    return Exposed(exposure.film, exposure.sums)


def _on_workers(
    scene: Scene, job: Job, executor: Any, recipes: tuple[Recipe, Recipe], progress: Progress | None, film: Any,
    kept: Kept | None,
) -> None:  # fmt: skip
    """By workers, each tile from its first sample to its last, onto the film; if it is of sums, what is missing there.

    kept: where sums are added as they come, or None.
    """
    workers = workers_of("render", executor, progress)
    total = tile_total(job.width, job.height)
    keeps = film.shape[2] == SUMS
    gaps = _gaps(film, total, job) if keeps else [(0, total)]
    pace = Pace(workers.chunk, 1, _OF_DASK if workers.is_dask else _MOST, workers.count)
    pieces = (Piece(a, b, (a, b, _before(film, a, b) if keeps else None)) for gap in gaps for a, b in pace.pieces(*gap))
    missing = sum(b - a for a, b in gaps)
    course = Course("render", workers, tiles_part, (*recipes, Recipe(keeps)))
    with closing(course.results(pieces, pace.saw, total, total - missing)) as results:
        for piece, pixels in results:
            put(film, piece.begin, piece.end, pixels)
            if kept is not None:
                kept.add(film, [(piece.begin, piece.end)])


def _before(sums: Any, begin: int, end: int) -> Any:
    """The sums of tiles that have samples already."""
    found = tiles_of(sums, begin, end)
    return found if found[:, COUNT].any() else None


def tiles_of(sums: Any, begin: int, end: int) -> Any:
    """Tiles of a film or of sums, each tile's rows one after the other."""
    return np.concatenate([sums[square].reshape(-1, sums.shape[2]) for square in squares(begin, end, sums.shape[1])])


def _gaps(sums: Any, total: int, job: Job) -> list[tuple[int, int]]:
    """The tiles in which some pixels are to get samples."""
    row, column = np.nonzero(job.wanted(sums, job.samples, SQUARE))
    done = np.ones(total + 1, np.bool_)
    done[tiles_of_squares(row, column, job.width)] = False
    steps = np.diff(np.concatenate([[True], done]).astype(np.int8))
    begins, ends = np.flatnonzero(steps < 0).tolist(), np.flatnonzero(steps > 0).tolist()
    return list(zip(begins, ends, strict=True))


class Kept:
    """The sums of a picture's tiles in a file. Later parts take the place of earlier ones."""

    def __init__(self, path: str | os.PathLike[str], key: bytes, job: Job) -> None:
        self._file = Checkpoint(path, key)
        self._whole = job.width * job.height * SUMS * 8

    def read(self, sums: Any) -> None:
        """Fill in what there is."""
        for begin, end, data in self._file.records():
            put(sums, begin, end, np.frombuffer(data, "<f8").reshape(-1, SUMS))

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
