"""Pictures in tiles: on workers, and gone on with where a driver was stopped."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..film.sums import COUNT, SUMS, pixels_of
from ..integrators import INTEGRATORS
from ..render.passes import Exposure
from ..render.picture import Exposed, Job, light_of
from ..render.shutter import render_open, stills
from ..render.tiles import SIDE, tile_corner, tile_total
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
        return _on_workers(scene, job, keeps, executor, recipes, progress, None)
    kept = Kept(resume, recipes[0].key + Recipe(_what(job)).key, job)
    try:
        if executor is None:
            return _here(scene, job, progress, preview, kept)
        return _on_workers(scene, job, keeps, executor, recipes, progress, kept)
    finally:
        kept.close()


def _what(job: Job) -> Job:
    """The job as far as its samples depend on it: of a progressive picture there may be more, or less noise."""
    return replace(job, samples=1, noise=None) if job.is_progressive and job.shutter is None else job


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
        held, exposed = kept or Held(), None
        for k, (still, part) in enumerate(stills(scene, job, fixed)):
            told = progress and _of_moments(progress, k, job.times)
            exposed = _on_workers(still, part, True, executor, (recipe_of(still), Recipe(part)), told, held)
        assert exposed is not None
        return exposed
    finally:
        if kept is not None:
            kept.close()


def _of_moments(progress: Progress, moment: int, times: int) -> Progress:
    return lambda done, count: progress(moment * count + done, times * count)


def _here(scene: Scene, job: Job, progress: Progress | None, preview: Preview | None, kept: Kept) -> Exposed:
    """By the threads of this process, which go over all tiles again and again."""
    exposure = Exposure(scene, job, True)
    kept.read(exposure.sums)
    exposure.go_on(progress, preview, lambda tiles: kept.add(exposure.sums, tiles))
    return Exposed(exposure.film, exposure.sums)


def _on_workers(
    scene: Scene, job: Job, keeps: bool, executor: Any, recipes: tuple[Recipe, Recipe], progress: Progress | None,
    kept: Kept | Held | None,
) -> Exposed:  # fmt: skip
    """By workers, each tile from its first sample to its last."""
    workers = workers_of("render", executor, progress)
    total = tile_total(job.width, job.height)
    keeps = keeps or kept is not None
    film = np.zeros((job.height, job.width, SUMS) if keeps else (job.height, job.width, 3), "f8" if keeps else "f4")
    if kept is not None:
        kept.read(film)
    gaps = [(0, total)] if kept is None else _gaps(film, total, job)
    pace = Pace(workers.chunk, 1, _OF_DASK if workers.is_dask else _MOST, workers.count)
    pieces = (Piece(a, b, (a, b, _before(kept, film, a, b))) for gap in gaps for a, b in pace.pieces(*gap))
    missing = sum(b - a for a, b in gaps)
    course = Course("render", workers, tiles_part, (*recipes, Recipe(keeps)))
    with closing(course.results(pieces, pace.saw, total, total - missing)) as results:
        for piece, pixels in results:
            put(film, piece.begin, piece.end, pixels)
            if kept is not None:
                kept.add(film, [(piece.begin, piece.end)])
    return Exposed(pixels_of(film), film) if keeps else Exposed(film, None)


def _before(kept: Kept | Held | None, sums: Any, begin: int, end: int) -> Any:
    """The sums of tiles that have samples already."""
    if kept is None:
        return None
    found = tiles_of(sums, begin, end)
    return found if found[:, COUNT].any() else None


def tiles_of(sums: Any, begin: int, end: int) -> Any:
    """Tiles of a film or of sums, each tile's rows one after the other."""
    return np.concatenate([sums[square].reshape(-1, sums.shape[2]) for square in squares(begin, end, sums.shape[1])])


def _gaps(sums: Any, total: int, job: Job) -> list[tuple[int, int]]:
    """The tiles that do not have all samples yet."""
    done = np.ones(total + 1, np.bool_)
    done[:total] = [(sums[square][..., COUNT] >= job.samples).all() for square in squares(0, total, job.width)]
    steps = np.diff(np.concatenate([[True], done]).astype(np.int8))
    begins, ends = np.flatnonzero(steps < 0).tolist(), np.flatnonzero(steps > 0).tolist()
    return list(zip(begins, ends, strict=True))


class Held:
    """The same sums from one moment to the next, where no file keeps them."""

    def __init__(self) -> None:
        self._sums: Any = None

    def read(self, sums: Any) -> None:
        """Fill in what there is."""
        if self._sums is not None:
            sums[:] = self._sums

    def add(self, sums: Any, tiles: list[tuple[int, int]]) -> None:
        """Hold them."""
        del tiles
        self._sums = sums


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
