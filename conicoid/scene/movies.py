"""Frames in a folder, each named by all that its picture is made from, so that what is there can be taken."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterator
from fractions import Fraction
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .._util.arrays import dot_rows, unit_rows
from .._util.errstate import ignore_fp_errors
from .._util.safe_files import replace_file, resolve_output
from .._util.validation import as_integer, check_callback, check_flag, check_number, check_positive, format_value
from .._util.validation import check_path as checked_path
from ..geometry.tracks import last_time
from ..io.images.movie import check_movie, write_movie
from ..numerics.portable_math import sin_cos_degrees
from ..parallel.scheduler import ScheduledTask, Scheduler, cancel_on_exit, prepare_first
from ..parallel.shared_state import SharedObject, shared_scene
from ..parallel.workers import Workers, as_workers
from ..render.auto_camera import fit_camera, snap_to_domain
from ..render.camera import AnyCamera, as_camera
from ..render.camera_kinds import check_size
from ..render.job import check_options, lower_scene_light, lower_scene_shading
from .scene import Scene, as_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ..geometry.body import Body
    from ..geometry.shape import Shape
    from ..parallel.workers import Workers
    from ..render.camera import AnyCamera
    from .scene import Scene


_OF_THE_TREE = {"node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items"}


class Frames:
    """The frames of one scene and one set of options, in a folder that need not be there yet."""

    def __init__(self, scene: Scene, folder: Path, options: dict[str, Any]) -> None:
        from .._jit.sources import source_hash

        self.scene, self.folder, self.options = scene, folder, options
        lowered = scene.lowered
        tables = {k: v for k, v in lowered.tables._asdict().items() if k not in _OF_THE_TREE}
        names = [body.name for body in scene.bodies] if options["labels"] else []
        parts = (source_hash(), sorted(options.items()), names, tables, lowered.rest, lowered.boxes, lowered.body_item)
        self._key = digest_of(*parts, *scene.extent)

    def path(self, camera: AnyCamera) -> Path:
        """Where the picture by a camera is, or is to be."""
        light = lower_scene_light(self.scene, camera, self.options["integrator"])
        light = lower_scene_shading(self.scene, camera) if light is None else light
        key = digest_of(self._key, type(camera).__name__, camera, light)
        return self.folder / f"{key.hex()}.png"

    def is_there(self, path: Path) -> bool:
        """Whether a frame is whole, and of the right size."""
        from PIL import Image

        try:
            with Image.open(path) as file:
                file.verify()  # the checksums: the pixels of a file that is cut short may all be there
            with Image.open(path) as file:
                file.load()
                return file.format == "PNG" and file.size == (self.options["width"], self.options["height"])
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
            return False

    def render(self, path: Path, camera: AnyCamera, progress: Any) -> None:
        """Make a frame."""
        self._keep(path, self.scene.render(camera=camera, progress=progress, **self.options)._repr_png_())

    def render_on(self, workers: Workers, missing: Sequence[tuple[Path, Any]], told: Callable[[int], Any]) -> None:
        """Make several on workers, a frame a task; each is kept as it comes back, and told(done) is called.

        missing: the files, and what each frame is of: its camera (its time, where the scene moves).
        """
        pieces = (ScheduledTask(k, k + 1, (each,)) for k, (_, each) in enumerate(missing))
        with cancel_on_exit(self._course(workers).results(pieces, lambda *_: None, len(missing))) as results:
            for piece, content in results:
                self._keep(missing[piece.begin][0], content)
                told(piece.end)

    def _course(self, workers: Workers) -> Scheduler:
        """Tasks that make a frame each."""
        return Scheduler("turntable", workers, render_frame, (shared_scene(self.scene), SharedObject(self.options)))

    def _keep(self, path: Path, content: bytes) -> None:
        self.folder.mkdir(exist_ok=True)
        with replace_file(path) as part:
            part.write_bytes(content)


@prepare_first
def render_frame(scene: Scene, options: dict[str, Any], camera: AnyCamera) -> bytes:
    """A frame as the bytes of its file."""
    return scene.render(camera=camera, **options)._repr_png_()


def digest_of(*parts: Any) -> bytes:
    """One digest of all parts."""
    digest = blake2b(digest_size=16)
    for part in parts:
        _add(digest, part)
    return digest.digest()


def _add(digest: Any, part: Any) -> None:
    """Arrays by their bytes, tables field by field, the rest as Python shows it; each with what sets it off."""
    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype} {part.shape};".encode())
        digest.update(np.ascontiguousarray(part).view(np.uint8).data if part.size else b"")
    elif hasattr(part, "__dataclass_fields__"):
        _add(digest, [(name, getattr(part, name)) for name in part.__dataclass_fields__])
    elif isinstance(part, (tuple, list, dict)):
        items = list(part.items()) if isinstance(part, dict) else part
        digest.update(f"{type(part).__name__} {len(items)};".encode())
        for item in items:
            _add(digest, item)
    else:
        text = repr(part).encode()
        digest.update(b"%d;" % len(text) + text)


# The frames of a turntable, and the file that they become.

_MOST_TURNTABLE_FRAMES = 100_000


@ignore_fp_errors
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
    width, height = check_size(width, height, "turntable")
    count = as_integer(frames)
    if count is None or not 1 <= count <= _MOST_TURNTABLE_FRAMES:
        raise ValueError(
            f"turntable: frames must be a whole number from 1 to {_MOST_TURNTABLE_FRAMES}, got {format_value(frames)}"
        )
    frames = count
    seconds = check_positive("turntable", "seconds", seconds)
    options = check_options(samples, integrator, seed, depth)
    options |= {
        name: check_flag("turntable", name, on) for name, on in dict(axes=axes, labels=labels, normals=normals).items()
    }
    keep = check_flag("turntable", "keep", keep)
    check_callback("turntable", "progress", progress)
    as_camera("turntable", camera)
    workers = None if executor is None else as_workers("turntable", executor)
    place = (
        target.with_name(f"{target.stem}-frames")
        if folder is None
        else Path(checked_path("turntable", folder, "folder"))
    )
    check_movie(target, width, height, int(frames), seconds)
    resolve_output(target)
    made = Frames(scene, place, dict(width=width, height=height, **options))
    views = list(_views(scene, camera, frames, width / height))
    files = [made.path(view) for view in views]
    if workers is None:
        rendered = _render_missing(made, list(zip(files, views, strict=True)), progress)
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


def _render_missing(
    made: Frames, wanted: list[tuple[Path, AnyCamera]], progress: Callable[[int, int], Any] | None
) -> int:
    """Render here what is not there; returns how many these were."""
    rendered, frames = 0, len(wanted)
    for i, (file, view) in enumerate(wanted):
        if not made.is_there(file):
            made.render(file, view, progress and _turntable_progress(progress, i, frames))
            rendered += 1
        if progress is not None:
            progress(i + 1, frames)
    return rendered


def _views(scene: Scene, camera: AnyCamera | None, frames: int, aspect: float) -> Iterator[AnyCamera]:
    first = camera or scene.camera or fit_camera(*scene.extent, aspect, frames)
    axis = unit_rows(np.array(first.up))[0]
    away = np.subtract(first.position, first.look_at)
    along = dot_rows(away, axis) * axis
    across, aside = away - along, np.cross(axis, away)
    for i in range(frames):
        s, c = sin_cos_degrees(Fraction(-360 * i, frames))
        turned = along + c * across + s * aside
        yield (
            dataclasses.replace(cast(Any, first), position=snap_to_domain(np.add(first.look_at, turned)))
            if i
            else first
        )


def _turntable_progress(progress: Callable[[int, int], Any], frame: int, frames: int) -> Callable[[int, int], None]:
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


# The film of a scene that moves by keyframes.

_MOST_FILM_FRAMES = 100_000


class FilmFrames(Frames):
    """The frames of a scene that moves, each named also by its time, the tracks and how long the shutter is open."""

    def __init__(
        self, scene: Scene, folder: Path, options: dict[str, Any], camera: AnyCamera | None, aperture: float,
        times: int | None,
    ) -> None:  # fmt: skip
        super().__init__(scene, folder, options)
        self.camera, self.aperture, self.times = camera, aperture, times
        view = camera or scene.camera or scene.fitting_camera(options["width"] / options["height"])
        light = lower_scene_light(scene, view, options["integrator"]) or lower_scene_shading(scene, view)
        self._film = digest_of(self._key, type(view).__name__, view, light, scene.animation, aperture, times)

    def path_at(self, time: float) -> Path:
        """Where the frame of a time is, or is to be."""
        return self.folder / f"{digest_of(self._film, time).hex()}.png"

    def render_at(self, path: Path, time: float, progress: Any) -> None:
        """Make the frame of a time."""
        self._keep(path, render_moment(self.scene, self._how, time, progress))

    def _course(self, workers: Workers) -> Scheduler:
        return Scheduler("animate", workers, render_moment, (SharedObject(self.scene), SharedObject(self._how)))

    @property
    def _how(self) -> dict[str, Any]:
        """All that makes a frame but the scene and the time."""
        return dict(camera=self.camera, aperture=self.aperture, times=self.times, options=self.options)


@prepare_first
def render_moment(scene: Scene, how: dict[str, Any], time: float, progress: Any = None) -> bytes:
    """The frame of a time as the bytes of its file: with the shutter open from then on, or as the scene stands then."""
    given = dict(camera=how["camera"], progress=progress, **how["options"])
    if how["aperture"] == 0:
        return scene.at(time).render(**given)._repr_png_()
    return scene.render(shutter=(time, time + how["aperture"]), times=how["times"], **given)._repr_png_()


@ignore_fp_errors
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
    width, height = check_size(width, height)
    start, length, count = _extent(scene, frames, seconds, start)
    open_for = check_number("animate", "shutter", shutter)
    if not 0 <= open_for <= 1:
        raise ValueError(f"animate: shutter must be in [0, 1], a share of a frame's time, got {open_for:g}")
    options = check_options(samples, integrator, seed, depth) | {
        name: check_flag("animate", name, on) for name, on in dict(axes=axes, labels=labels, normals=normals).items()
    }
    check_callback("animate", "progress", progress)
    view = as_camera("animate", camera)
    workers = None if executor is None else as_workers("animate", executor)
    check_movie(target, width, height, count, length)
    resolve_output(target)
    beside = target.with_name(f"{target.stem}-frames")
    place = beside if folder is None else Path(checked_path("animate", folder, "folder"))
    step = length / count
    made = FilmFrames(scene, place, dict(width=width, height=height, **options), view, open_for * step, _moments(times))
    moments = [start + k * step for k in range(count)]
    files = (
        _render_moments(made, moments, progress)
        if workers is None
        else _render_moments_on(made, moments, workers, progress)
    )
    write_movie(target, [file for file, _ in files], length)
    if not check_flag("animate", "keep", keep):
        remove_frames([file for file, _ in files], place)
    return sum(new for _, new in files)


def frame_count(scene: Scene, frames: Any, seconds: Any, start: Any) -> int:
    """How many frames a film has."""
    return _extent(scene, frames, seconds, start)[2]


def _extent(scene: Scene, frames: Any, seconds: Any, start: Any) -> tuple[float, float, int]:
    """When a film begins, how long it is, and its number of frames."""
    if not scene.animation:
        raise ValueError("animate: the scene has no animation; a co.turntable goes around what stands still")
    begin, end = check_number("animate", "start", start), last_time(scene.animation)
    if seconds is None and not end > begin:
        raise ValueError(f"animate: seconds must be given where the last key, {end:g}, is not after start, {begin:g}")
    length = check_positive("animate", "seconds", end - begin if seconds is None else seconds)
    return begin, length, _count(frames, length)


def _count(frames: Any, length: float) -> int:
    if frames is None:
        return max(1, round(24 * length))
    count = as_integer(frames)
    if count is None or not 1 <= count <= _MOST_FILM_FRAMES:
        raise ValueError(
            f"animate: frames must be a whole number from 1 to {_MOST_FILM_FRAMES}, got {format_value(frames)}"
        )
    return count


def _moments(times: Any) -> int | None:
    """In how many moments of a frame what moves is seen."""
    if times is None:
        return None
    count = as_integer(times)
    if count is None or not 1 <= count <= _MOST_FILM_FRAMES:
        raise ValueError(
            f"animate: times must be a whole number from 1 to {_MOST_FILM_FRAMES}, got {format_value(times)}"
        )
    return count


def _render_moments(made: FilmFrames, times: list[float], progress: Any) -> list[tuple[Path, bool]]:
    """The files of all frames, and which of them are new."""
    files = []
    for k, time in enumerate(times):
        file = made.path_at(time)
        missing = not made.is_there(file)
        if missing:
            made.render_at(file, time, progress and _film_progress(progress, k, len(times)))
        files.append((file, missing))
        if progress is not None:
            progress(k + 1, len(times))
    return files


def _render_moments_on(
    made: FilmFrames, times: list[float], workers: Workers, progress: Any
) -> list[tuple[Path, bool]]:
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


def _film_progress(progress: Callable[[int, int], Any], frame: int, frames: int) -> Callable[[int, int], None]:
    return lambda done, count: progress(frame * count + done, frames * count)
