"""The film of a scene that moves by keyframes."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..cluster.course import Course
from ..cluster.recipe import Recipe
from ..cluster.task import prepared_first
from ..cluster.workers import Workers, as_workers
from ..formats.atomic import checked_place
from ..formats.movie import check_movie, write_movie
from ..render.camera import AnyCamera, as_camera, checked_size
from ..render.picture import check_options, light_of, look_of
from ..scene import Scene, as_scene
from ..shapes.animation import end_of
from ..shapes.calm import calm
from ..shapes.validate import callback, flag, number, positive, shown, whole
from ..shapes.validate import path as checked_path
from .frames import Frames, digest_of
from .turntable import remove_frames

_MOST = 100_000


class FilmFrames(Frames):
    """The frames of a scene that moves, each named also by its time, the tracks and how long the shutter is open."""

    def __init__(
        self, scene: Scene, folder: Path, options: dict[str, Any], camera: AnyCamera | None, aperture: float,
        times: int | None,
    ) -> None:  # fmt: skip
        super().__init__(scene, folder, options)
        self.camera, self.aperture, self.times = camera, aperture, times
        view = camera or scene.camera or scene.fitting_camera(options["width"] / options["height"])
        light = light_of(scene, view, options["integrator"]) or look_of(scene, view)
        self._film = digest_of(self._key, type(view).__name__, view, light, scene.animation, aperture, times)

    def path_at(self, time: float) -> Path:
        """Where the frame of a time is, or is to be."""
        return self.folder / f"{digest_of(self._film, time).hex()}.png"

    def render_at(self, path: Path, time: float, progress: Any) -> None:
        """Make the frame of a time."""
        self._keep(path, moment(self.scene, self._how, time, progress))

    def _course(self, workers: Workers) -> Course:
        return Course("animate", workers, moment, (Recipe(self.scene), Recipe(self._how)))

    @property
    def _how(self) -> dict[str, Any]:
        """All that makes a frame but the scene and the time."""
        return dict(camera=self.camera, aperture=self.aperture, times=self.times, options=self.options)


@prepared_first
def moment(scene: Scene, how: dict[str, Any], time: float, progress: Any = None) -> bytes:
    """The frame of a time as the bytes of its file: with the shutter open from then on, or as the scene stands then."""
    given = dict(camera=how["camera"], progress=progress, **how["options"])
    if how["aperture"] == 0:
        return scene.at(time).render(**given)._repr_png_()
    return scene.render(shutter=(time, time + how["aperture"]), times=how["times"], **given)._repr_png_()


@calm
def animate(
    scene: Scene,
    path: str | os.PathLike[str],
    *,
    frames: int | None = None,
    seconds: float | None = None,
    start: float = 0.0,
    shutter: float = 0.5,
    times: int | None = None,
    width: int = 480,
    height: int = 360,
    samples: int = 16,
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
    """A film of a `scene` with an animation, a .gif, .webp or .mp4 at `path`; returns how many frames were rendered.

    It shows `seconds` from `start` on, to the last key if not given, in `frames`, 24 a second if not given. The shutter
    is open for the share `shutter` of a frame's time, 0 for an instant, in as many moments as `times` says
    (see `render`). `camera` stands still in place of the scene's own. `width`, `height`, `samples`, `integrator`,
    `seed`, `depth`, `axes`, `labels` and `normals` are those of `render`. A body that moves costs its own preparation.

    Frames are .png files in `folder` (by default `film-frames` beside film.gif), named by all that they are made from.
    Those that are there already are taken. `keep=False` removes them in the end. `progress(done, count)` is called now
    and then. `executor` is where frames are made, a task each, as for `scene.first_hit`. Raises ValueError for what
    cannot be written, before the first frame.
    """
    scene, target = as_scene("animate", scene), Path(checked_path("animate", path))
    width, height = checked_size(width, height)
    start, length, count = _extent(scene, frames, seconds, start)
    open_for = number("animate", "shutter", shutter)
    if not 0 <= open_for <= 1:
        raise ValueError(f"animate: shutter must be in [0, 1], a share of a frame's time, got {open_for:g}")
    options = check_options(samples, integrator, seed, depth) | {
        name: flag("animate", name, on) for name, on in dict(axes=axes, labels=labels, normals=normals).items()
    }
    callback("animate", "progress", progress)
    view = as_camera("animate", camera)
    workers = None if executor is None else as_workers("animate", executor)
    check_movie(target, width, height, count, length)
    checked_place(target)
    beside = target.with_name(f"{target.stem}-frames")
    place = beside if folder is None else Path(checked_path("animate", folder, "folder"))
    step = length / count
    made = FilmFrames(scene, place, dict(width=width, height=height, **options), view, open_for * step, _moments(times))
    moments = [start + k * step for k in range(count)]
    files = _made(made, moments, progress) if workers is None else _made_on(made, moments, workers, progress)
    write_movie(target, [file for file, _ in files], length)
    if not flag("animate", "keep", keep):
        remove_frames([file for file, _ in files], place)
    return sum(new for _, new in files)


def frame_count(scene: Scene, frames: Any, seconds: Any, start: Any) -> int:
    """How many frames a film has."""
    return _extent(scene, frames, seconds, start)[2]


def _extent(scene: Scene, frames: Any, seconds: Any, start: Any) -> tuple[float, float, int]:
    """When a film begins, how long it is, and its number of frames."""
    if not scene.animation:
        raise ValueError("animate: the scene has no animation; a co.turntable goes around what stands still")
    begin, end = number("animate", "start", start), end_of(scene.animation)
    if seconds is None and not end > begin:
        raise ValueError(f"animate: seconds must be given where the last key, {end:g}, is not after start, {begin:g}")
    length = positive("animate", "seconds", end - begin if seconds is None else seconds)
    return begin, length, _count(frames, length)


def _count(frames: Any, length: float) -> int:
    if frames is None:
        return max(1, round(24 * length))
    count = whole(frames)
    if count is None or not 1 <= count <= _MOST:
        raise ValueError(f"animate: frames must be a whole number from 1 to {_MOST}, got {shown(frames)}")
    return count


def _moments(times: Any) -> int | None:
    """In how many moments of a frame what moves is seen."""
    if times is None:
        return None
    count = whole(times)
    if count is None or not 1 <= count <= _MOST:
        raise ValueError(f"animate: times must be a whole number from 1 to {_MOST}, got {shown(times)}")
    return count


def _made(made: FilmFrames, times: list[float], progress: Any) -> list[tuple[Path, bool]]:
    """The files of all frames, and which of them are new."""
    files = []
    for k, time in enumerate(times):
        file = made.path_at(time)
        missing = not made.is_there(file)
        if missing:
            made.render_at(file, time, progress and _share(progress, k, len(times)))
        files.append((file, missing))
        if progress is not None:
            progress(k + 1, len(times))
    return files


def _made_on(made: FilmFrames, times: list[float], workers: Workers, progress: Any) -> list[tuple[Path, bool]]:
    """The same on workers: a task for each file that is missing."""
    files = [made.path_at(time) for time in times]
    missing = {file: time for file, time in zip(files, times, strict=True) if not made.is_there(file)}
    there = len(files) - len(missing)

    def told(done: int) -> None:
        if progress is not None:
            progress(there + done, len(times))

    made.render_on(workers, list(missing.items()), told)
    new = set(missing)
    found = []
    for file in files:
        found.append((file, file in new))
        new.discard(file)
    return found


def _share(progress: Callable[[int, int], Any], frame: int, frames: int) -> Callable[[int, int], None]:
    return lambda done, count: progress(frame * count + done, frames * count)
