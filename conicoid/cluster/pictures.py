"""Pictures in tiles: on workers, and gone on with where a driver was stopped."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.threads import run_on
from ..integrators import INTEGRATORS
from ..integrators.samples import Settings
from ..render import tiles
from ..render.camera import AnyCamera
from ..render.picture import light_of, turns_of
from ..render.tiles import SIDE, Film
from .checkpoint import Checkpoint
from .course import Course, Piece, closing
from .pace import Pace
from .queries import workers_of
from .recipe import Recipe, recipe_of
from .task import prepared_first

if TYPE_CHECKING:
    from ..engine.tables import Geometry
    from ..engine.threads import Progress
    from ..scene import Scene

_MOST = 1 << 12  # tiles of a task: 50 MB
_OF_DASK = 1 << 9  # less than Dask warns of


@dataclass(frozen=True)
class Job:
    """All that a picture depends on but the scene."""

    width: int
    height: int
    samples: int
    integrator: str
    seed: int
    depth: int
    view: AnyCamera


@prepared_first
def tiles_part(scene: Scene, job: Job, begin: int, end: int) -> Any:
    """The pixels of tiles `begin` to `end`, each tile's rows one after the other: (pixels, 3)."""
    turns = turns_of(job.integrator, job.depth)
    settings = Settings(job.samples, job.seed, turns, _look(scene, job))
    fill, lens = tiles.tile_kernel(job.integrator), job.view.lens
    film = np.zeros((job.height, job.width, 3), np.float32)  # of which only what is filled takes memory

    def work(geometry: Geometry, first: int, last: int) -> None:
        fill(geometry, lens, film, settings, begin + first, begin + last)

    run_on(scene.geometry, work, end - begin, 1, (end - begin) * SIDE * SIDE * job.samples)
    return np.concatenate([film[square].reshape(-1, 3) for square in squares(begin, end, job.width)])


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
        column, row = tiles.tile_corner(tile, width)
        yield slice(row, row + SIDE), slice(column, column + SIDE)


def put(film: Film, begin: int, end: int, pixels: Any) -> None:
    """Tiles, as `tiles_part` brings them, onto the film."""
    at = 0
    for square in squares(begin, end, film.shape[1]):
        part = film[square]
        count = part.shape[0] * part.shape[1]
        part[:] = pixels[at : at + count].reshape(part.shape)
        at += count


def rendered(
    scene: Scene, job: Job, executor: Any, resume: str | os.PathLike[str] | None, progress: Progress | None
) -> Film:
    """The film of a picture, its tiles made on workers, or here for None.

    resume: a file of the tiles that are done. Those in it are taken, and new ones added as they come back.
    """
    workers = workers_of("render", executor, progress)
    film = np.zeros((job.height, job.width, 3), np.float32)
    total = tiles.tile_total(job.width, job.height)
    recipes = recipe_of(scene), Recipe(job)
    if resume is None:
        gaps, kept = [(0, total)], None
    else:
        kept = Checkpoint(resume, b"".join(recipe.key for recipe in recipes))
        gaps = _gaps(kept, film, total)
    pace = Pace(workers.chunk, 1, _OF_DASK if workers.is_dask else _MOST, workers.count)
    pieces = (Piece(a, b, (a, b)) for gap in gaps for a, b in pace.pieces(*gap))
    missing = sum(b - a for a, b in gaps)
    course = Course("render", workers, tiles_part, recipes)
    try:
        with closing(course.results(pieces, pace.saw, total, total - missing)) as results:
            for piece, pixels in results:
                put(film, piece.begin, piece.end, pixels)
                if kept is not None:
                    kept.add(piece.begin, piece.end, np.ascontiguousarray(pixels, "<f4").tobytes())
    finally:
        if kept is not None:
            kept.close()
    return film


def _gaps(kept: Checkpoint, film: Film, total: int) -> list[tuple[int, int]]:
    """What is not in a checkpoint; the rest is put onto the film."""
    done = np.zeros(total + 1, np.bool_)
    done[-1] = True
    for begin, end, data in kept.records():
        put(film, begin, end, np.frombuffer(data, "<f4").reshape(-1, 3))
        done[begin:end] = True
    steps = np.diff(np.concatenate([[True], done]).astype(np.int8))
    begins, ends = np.flatnonzero(steps < 0).tolist(), np.flatnonzero(steps > 0).tolist()
    return list(zip(begins, ends, strict=True))
