"""Motion blur: the samples of each pixel are spread over moments of the time while the shutter is open.

That time is cut into `times` equal parts. At the middle of each the scene stands where its tracks have it, exactly, and
a block of consecutive samples sees it so. The picture is the mean of these exact pictures. Blocks of Sobol's points are
themselves spread evenly, over the pixel and the lens. So a scene at rest looks as without a shutter, to the bit with
progressive integrators. Only bodies that move are prepared anew.

If noise ends the work, all moments are seen in a round of some samples before it is judged, and in the next again.
Moments differ, and their differences count as noise, so the reported noise is not too small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.arrays import FloatArray
from . import exposure
from .exposure import Exposure
from .film.film import SUMS, mean_pixels
from .job import FilmResult, RenderJob
from .tiles import SQUARE

if TYPE_CHECKING:
    from ..kernels.threads import Progress
    from .exposure import Preview, TileSink


def moments(shutter: tuple[float, float], times: int) -> list[float]:
    """The middles of `times` equal parts."""
    opens, closes = shutter
    return [opens + (k + 0.5) / times * (closes - opens) for k in range(times)]


def empty_sums(job: RenderJob) -> FloatArray:
    """The sums of a picture that has no samples yet."""
    return np.zeros((job.height, job.width, SUMS))


def stills(scene: Any, job: RenderJob, fixed: bool, sums: FloatArray) -> Iterator[tuple[Any, RenderJob]]:
    """Yield the scene at each moment in which some pixels get samples, and the picture up to the end of that moment.

    sums: those of all samples so far, up to date whenever the next moment is requested.
    """
    assert job.shutter is not None
    for begin in range(0, job.samples, job.round):
        count = min(job.round, job.samples - begin)
        if not job.wanted(sums, begin + count, SQUARE).any():
            continue
        for k, time in enumerate(moments(job.shutter, job.times)):
            end = begin + (k + 1) * count // job.times
            if not job.wanted(sums, end, SQUARE).any():
                continue
            still = scene.at(time)
            view = job.view if fixed or still.camera is None else still.camera
            yield still, replace(job, samples=end, view=view)


def render_motion_blur(
    scene: Any, job: RenderJob, fixed: bool, progress: Progress | None = None, preview: Preview | None = None,
    kept: Any = None,
) -> FilmResult:  # fmt: skip
    """The picture of a scene that moves while the shutter is open.

    fixed: is the camera that of the job throughout?
    kept: where sums are read from first, `kept.read(sums)`, and written to, `kept.add(sums, tiles)`, or None.
    """
    sums = empty_sums(job)
    if kept is None:
        _expose(scene, job, fixed, sums, progress, preview, None)
        return FilmResult(mean_pixels(sums), sums)
    kept.read(sums)
    new = _NewTiles(kept, sums)
    try:
        _expose(scene, job, fixed, sums, progress, preview, new.add)
    finally:
        new.write()
    return FilmResult(mean_pixels(sums), sums)


def _expose(
    scene: Any, job: RenderJob, fixed: bool, sums: FloatArray, progress: Progress | None, preview: Preview | None,
    keep: TileSink | None,
) -> None:  # fmt: skip
    for still, part in stills(scene, job, fixed, sums):
        exposure = Exposure(still, part, True, goes_on=True)
        exposure.sums = sums
        exposure.go_on(_as_part(progress, part.samples, job.samples), preview, keep)


class _NewTiles:
    """Tiles with new samples, which are written every few seconds: moments may be much shorter."""

    def __init__(self, kept: Any, sums: FloatArray) -> None:
        self._kept, self._sums, self._tiles, self._written = kept, sums, set[int](), monotonic()

    def add(self, tiles: list[tuple[int, int]]) -> None:
        """Remember tiles, and write all if it is time."""
        for begin, end in tiles:
            self._tiles.update(range(begin, end))
        if monotonic() - self._written >= exposure.SAVE_INTERVAL:
            self.write()

    def write(self) -> None:
        """Write those that are not yet."""
        if self._tiles:
            self._kept.add(self._sums, exposure.tile_ranges(sorted(self._tiles)))
        self._tiles.clear()
        self._written = monotonic()


def _as_part(progress: Progress | None, samples: int, of: int) -> Progress | None:
    """Progress of a picture of `samples` samples as of one of more."""
    if progress is None:
        return None
    return lambda done, count: progress(done, count // samples * of)
