"""The frames of a turntable, and the file that they become."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..cluster.workers import as_workers
from ..formats.atomic import checked_place
from ..formats.movie import check_movie, write_movie
from ..render.camera import AnyCamera, as_camera, checked_size
from ..render.fit import fitting_camera, placed
from ..render.picture import check_options
from ..scene import Scene, as_scene
from ..shapes.calm import calm
from ..shapes.rounded import sin_cos_degrees
from ..shapes.row_vectors import dot_rows, unit_rows
from ..shapes.validate import callback, flag, positive, shown, whole
from ..shapes.validate import path as checked_path
from .frames import Frames

if TYPE_CHECKING:
    from ..shapes.base import Shape
    from ..shapes.body import Body

_MOST = 100_000


@calm
def turntable(
    scene: Scene | Shape | Body,
    path: str | os.PathLike[str],
    *,
    frames: int = 48,
    seconds: float = 4.0,
    width: int = 480,
    height: int = 360,
    samples: int = 4,
    integrator: str = "whitted",
    seed: int = 0,
    depth: int = 10,
    camera: AnyCamera | None = None,
    axes: bool = False,
    labels: bool = False,
    normals: bool = False,
    folder: str | os.PathLike[str] | None = None,
    keep: bool = True,
    progress: Callable[[int, int], Any] | None = None,
    executor: Any = None,
) -> int:
    """A `scene` turned about once in `seconds`, a .gif, .webp or .mp4 at `path`; returns how many frames were rendered.

    The camera (that given, the scene's, or one that fits) goes around the point it looks at, about its `up`; the
    scene seems to turn counterclockwise. Lights of the scene's own turn with it, others stand still.
    `width`, `height`, `samples`, `integrator`, `seed`, `depth`, `axes`, `labels` and `normals` are those of `render`.

    Frames are .png files in `folder` (by default `spin-frames` beside spin.gif), named by all that they are made
    from. Those that are there already are taken: a turntable that was interrupted goes on, a changed scene has
    others. `keep=False` removes them in the end. `progress(done, count)` is called now and then.
    `executor` is where frames are made, a task each, as for `scene.first_hit`: a worker that dies costs its own frame.
    Raises ValueError for what cannot be written and ImportError where a .mp4 lacks its encoder
    (extra `video`: `pip install ".[video]"` in the repository), both before the first frame.
    """
    scene, target = as_scene("turntable", scene), Path(checked_path("turntable", path))
    width, height = checked_size(width, height, "turntable")
    count = whole(frames)
    if count is None or not 1 <= count <= _MOST:
        raise ValueError(f"turntable: frames must be a whole number from 1 to {_MOST}, got {shown(frames)}")
    frames = count
    seconds = positive("turntable", "seconds", seconds)
    options = check_options(samples, integrator, seed, depth)
    options |= {
        name: flag("turntable", name, on) for name, on in dict(axes=axes, labels=labels, normals=normals).items()
    }
    keep = flag("turntable", "keep", keep)
    callback("turntable", "progress", progress)
    as_camera("turntable", camera)
    workers = None if executor is None else as_workers("turntable", executor)
    place = (
        target.with_name(f"{target.stem}-frames")
        if folder is None
        else Path(checked_path("turntable", folder, "folder"))
    )
    check_movie(target, width, height, int(frames), seconds)
    checked_place(target)
    made = Frames(scene, place, dict(width=width, height=height, **options))
    views = list(_views(scene, camera, frames, width / height))
    files = [made.path(view) for view in views]
    if workers is None:
        rendered = _rendered(made, list(zip(files, views, strict=True)), progress)
    else:
        missing = {file: view for file, view in zip(files, views, strict=True) if not made.is_there(file)}
        there, rendered = frames - len(missing), len(missing)

        def told(done: int) -> None:
            if progress is not None:
                progress(there + done, frames)

        made.render_on(workers, list(missing.items()), told)
    write_movie(target, files, seconds)
    if not keep:
        remove_frames(files, place)
    return rendered


def _rendered(made: Frames, wanted: list[tuple[Path, AnyCamera]], progress: Callable[[int, int], Any] | None) -> int:
    """Render here what is not there; returns how many these were."""
    rendered, frames = 0, len(wanted)
    for i, (file, view) in enumerate(wanted):
        if not made.is_there(file):
            made.render(file, view, progress and _share(progress, i, frames))
            rendered += 1
        if progress is not None:
            progress(i + 1, frames)
    return rendered


def _views(scene: Scene, camera: AnyCamera | None, frames: int, aspect: float) -> Iterator[AnyCamera]:
    first = camera or scene.camera or fitting_camera(*scene.extent, aspect, frames)
    axis = unit_rows(np.array(first.up))[0]
    away = np.subtract(first.position, first.look_at)
    along = dot_rows(away, axis) * axis
    across, aside = away - along, np.cross(axis, away)
    for i in range(frames):
        s, c = sin_cos_degrees(Fraction(-360 * i, frames))
        turned = along + c * across + s * aside
        yield dataclasses.replace(cast(Any, first), position=placed(np.add(first.look_at, turned))) if i else first


def _share(progress: Callable[[int, int], Any], frame: int, frames: int) -> Callable[[int, int], None]:
    """Progress of one frame as that of all, in their tiles."""

    def told(done: int, count: int) -> None:
        progress(frame * count + done, frames * count)

    return told


def remove_frames(files: list[Path], folder: Path) -> None:
    """Frames that are no longer wanted, and their folder if nothing else is in it."""
    for file in set(files):
        file.unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()
