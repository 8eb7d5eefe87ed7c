"""What moves while the shutter is open: the samples of each pixel are shared out over moments of that time.

The time is cut into `times` equal parts; in the middle of each the scene stands where its tracks have it, exactly, and
a block of consecutive samples sees it so. The picture is the mean of these exact pictures. Blocks of Sobol's points are
themselves spread evenly, over the pixel and the lens, so what does not move looks as without a shutter, to the bit with
integrators that are progressive. Only bodies that move are prepared anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .passes import Exposure
from .picture import Exposed, Job

if TYPE_CHECKING:
    from ..engine.threads import Progress
    from .passes import Keep, Preview


def moments(shutter: tuple[float, float], times: int) -> list[float]:
    """The middles of `times` equal parts."""
    opens, closes = shutter
    return [opens + (k + 0.5) / times * (closes - opens) for k in range(times)]


def stills(scene: Any, job: Job, fixed: bool) -> Iterator[tuple[Any, Job]]:
    """The scene at each moment, and the picture up to the end of that moment's samples."""
    assert job.shutter is not None
    for k, time in enumerate(moments(job.shutter, job.times)):
        still = scene.at(time)
        view = job.view if fixed or still.camera is None else still.camera
        yield still, replace(job, samples=(k + 1) * job.samples // job.times, view=view)


def render_open(
    scene: Any, job: Job, fixed: bool, progress: Progress | None = None, preview: Preview | None = None,
    kept: Any = None,
) -> Exposed:  # fmt: skip
    """The picture of a scene that moves while the shutter is open.

    fixed: is the camera that of the job throughout?
    kept: where sums are read from first, `kept.read(sums)`, and written to, `kept.add(sums, tiles)`, or None.
    """
    film, sums = None, None
    for still, part in stills(scene, job, fixed):
        exposure = Exposure(still, part, True, goes_on=True)
        if sums is not None:
            exposure.sums = sums
        elif kept is not None:
            kept.read(exposure.sums)
        film, sums = exposure.film, exposure.sums
        exposure.go_on(_as_part(progress, part.samples, job.samples), preview, kept and _adding(kept, sums))
    assert film is not None
    return Exposed(film, sums)


def _adding(kept: Any, sums: Any) -> Keep:
    return lambda tiles: kept.add(sums, tiles)


def _as_part(progress: Progress | None, samples: int, of: int) -> Progress | None:
    """Progress of a picture of `samples` samples as of one of more."""
    if progress is None:
        return None
    return lambda done, count: progress(done, count // samples * of)
