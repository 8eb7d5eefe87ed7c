"""Turntables and films: pictures of many frames, written as a .gif, .webp or .mp4.

Frames are .png files in a folder. The name of each is a digest of everything that its picture depends on, so that a
later run takes the frames that are there. `turntable` goes around a scene, `animate` follows the tracks of a scene.
"""

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

from .._util.arrays import dot_rows, ignore_fp_errors, unit_rows
from .._util.files import open_regular, replace_file, resolve_output
from .._util.validation import (
    as_integer,
    check_callback,
    check_flag,
    check_number,
    check_path as checked_path,
    check_positive,
    format_value,
)
from ..geometry.tracks import last_time
from ..io.image_codecs import check_movie, write_movie
from ..numerics.portable_math import sin_cos_degrees
from ..parallel.shared_state import SharedObject, shared_scene
from ..parallel.workers import ScheduledTask, Workers, as_workers, prepare_first, run_tasks
from ..render.camera import AnyCamera, as_camera, fit_camera, snap_to_domain
from ..render.exposure import check_options, lower_scene_light, lower_scene_shading
from ..render.options import check_size
from .scene import Scene, as_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..geometry.body import Body
    from ..geometry.shape import Shape


_TREE_TABLES = {"node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items",
                "cell_groups", "group_bounds", "group_planes"}  # fmt: skip
"""Tables of the trees of boxes and planes, which the names of frames leave out."""


Progress = Callable[[int, int], Any]


class Frames:
    """The frames of one scene and one set of options, in a folder that is created with the first frame."""

    def __init__(self, scene: Scene, folder: Path, options: dict[str, Any]) -> None:
        from .._jit.sources import digest_of_files

        self.scene, self.folder, self.options = scene, folder, options
        scene._close_gaps()
        lowered = scene._prepared.lowered
        tables = {k: v for k, v in lowered.tables._asdict().items() if k not in _TREE_TABLES}
        # Names show in pictures with labels only; a change of code makes other frames
        names = [body.name for body in scene.bodies] if options["labels"] else []
        parts = (sorted(options.items()), names, tables, lowered.rest, lowered.boxes, lowered.body_item)
        self._key = digest_of(digest_of_files(), *parts, *scene.extent)

    def path(self, camera: Any) -> Path:
        """Return where the picture by a camera is, or will be."""
        light = lower_scene_light(self.scene, camera, self.options["integrator"])
        light = lower_scene_shading(self.scene, camera) if light is None else light
        key = digest_of(self._key, type(camera).__name__, camera, light)
        return self.folder / f"{key.hex()}.png"

    def is_whole(self, path: Path) -> bool:
        """Return whether a frame is whole and of the right size."""
        from PIL import Image

        size = self.options["width"], self.options["height"]
        try:
            with open_regular(path) as raw, Image.open(raw, formats=["PNG"]) as file:
                if file.size != size:  # before memory is taken for its pixels
                    return False
                file.verify()  # the checksums: a truncated file may still hold all pixels
            with open_regular(path) as raw, Image.open(raw, formats=["PNG"]) as file:  # nothing loads after `verify`
                file.load()
                return True
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
            return False

    def render(self, path: Path, camera: Any, progress: Progress | None) -> None:
        """Compute a frame and write its file."""
        self._write(path, self.scene.render(camera=camera, progress=progress, **self.options)._repr_png_())

    def render_missing(self, subjects: Sequence[Any], progress: Progress | None) -> tuple[list[Path], int]:
        """Compute the frames that are not there, in this process.

        Parameters
        ----------
        subjects : sequence
            What each frame shows: its camera, or its time in a film.
        progress : callable, optional
            progress(done, count) is called for each tile, and for each frame.

        Returns
        -------
        files : list of Path
            The file of each frame; equal frames share one.
        rendered : int
            The number of frames that were computed.
        """
        files, rendered, count = [self.path(each) for each in subjects], 0, len(subjects)
        for k, (file, subject) in enumerate(zip(files, subjects, strict=True)):
            if not self.is_whole(file):
                self.render(file, subject, progress and _tile_progress(progress, k, count))
                rendered += 1
            if progress is not None:
                progress(k + 1, count)
        return files, rendered

    def render_missing_on(
        self, workers: Workers, subjects: Sequence[Any], progress: Progress | None
    ) -> tuple[list[Path], int]:
        """Do the same on workers, a frame in each task, and write each frame when it comes back."""
        files = [self.path(each) for each in subjects]
        # A dictionary, so that equal frames are rendered once
        missing = {file: each for file, each in zip(files, subjects, strict=True) if not self.is_whole(file)}
        names, there = list(missing), len(files) - len(missing)
        pieces = (ScheduledTask(k, k + 1, (each,)) for k, each in enumerate(missing.values()))
        with run_tasks(*self._work(workers), pieces, total=len(names)) as results:
            for piece, content in results:
                self._write(names[piece.begin], content)
                if progress is not None:
                    progress(there + piece.end, len(files))
        return files, len(names)

    def _work(self, workers: Workers) -> tuple[str, Workers, Callable[..., bytes], tuple[SharedObject, SharedObject]]:
        """Return the first arguments of `run_tasks` for tasks that each compute a frame."""
        return "turntable", workers, render_frame, (shared_scene(self.scene), SharedObject(self.options))

    def _write(self, path: Path, content: bytes) -> None:
        """Write a frame, whole or not at all."""
        self.folder.mkdir(exist_ok=True)
        with replace_file(path) as part:
            part.write_bytes(content)


@prepare_first
def render_frame(scene: Scene, options: dict[str, Any], camera: AnyCamera) -> bytes:
    """Return a frame as the bytes of its file."""
    return scene.render(camera=camera, **options)._repr_png_()


def digest_of(*parts: Any) -> bytes:
    """Return one digest of all parts."""
    digest = blake2b(digest_size=16)
    for part in parts:
        _add(digest, part)
    return digest.digest()


def _add(digest: Any, part: Any) -> None:
    """Add arrays by their bytes, tables field by field, the rest by their repr.

    A length or shape goes before each, so that different parts cannot run together into equal bytes.
    """
    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype} {part.shape};".encode())
        digest.update(np.ascontiguousarray(part).view(np.uint8).data if part.size else b"")  # without a copy
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


def _tile_progress(progress: Progress, frame: int, frames: int) -> Progress:
    """Return a function that reports the tiles of one frame as a part of those of all frames."""
    return lambda done, count: progress(frame * count + done, frames * count)


class _MovieJob:
    """The arguments that `turntable` and `animate` share, checked; errors begin with the name of the function."""

    def __init__(
        self, name: str, path: Any, width: Any, height: Any, options: dict[str, Any], flags: dict[str, Any],
        folder: Any, keep: Any, progress: Progress | None, executor: Any,
    ) -> None:  # fmt: skip
        self.target = Path(checked_path(name, path))
        width, height = check_size(width, height, name)
        on = {key: check_flag(name, key, value) for key, value in flags.items()}
        self.options = dict(width=width, height=height, **check_options(**options), **on)
        self.keep, self.progress = check_flag(name, "keep", keep), progress
        check_callback(name, "progress", progress)
        self.workers = None if executor is None else as_workers(name, executor)
        default_folder = self.target.with_name(f"{self.target.stem}-frames")
        self.folder = default_folder if folder is None else Path(checked_path(name, folder, "folder"))

    @property
    def aspect(self) -> float:
        """The width of a frame divided by its height."""
        return float(self.options["width"] / self.options["height"])

    def check_movie(self, frames: int, seconds: float) -> None:
        """Raise for a movie that cannot be written, before its first frame is computed."""
        check_movie(self.target, self.options["width"], self.options["height"], frames, seconds)
        resolve_output(self.target)

    def run(self, frames: Frames, subjects: list[Any], seconds: float) -> int:
        """Compute the missing frames and write the movie; return the number of frames that were computed."""
        if self.workers is None:
            files, rendered = frames.render_missing(subjects, self.progress)
        else:
            files, rendered = frames.render_missing_on(self.workers, subjects, self.progress)
        write_movie(self.target, files, seconds)
        if not self.keep:
            remove_frames(files, self.folder)
        return rendered


def remove_frames(files: list[Path], folder: Path) -> None:
    """Remove frames, and their folder if it is empty then."""
    for file in set(files):  # equal frames share a file
        file.unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()  # fails if other files are in it


_MOST_FRAMES = 100_000


def _check_count(name: str, field: str, value: Any) -> int:
    """Return a number of frames or moments; raise ValueError for anything else."""
    count = as_integer(value)
    if count is None or not 1 <= count <= _MOST_FRAMES:
        raise ValueError(f"{name}: {field} must be a whole number from 1 to {_MOST_FRAMES}, got {format_value(value)}")
    return count


# --- Turntables


@ignore_fp_errors
def turntable(
    scene: Scene | Shape | Body, path: str | os.PathLike[str], *, frames: int = 48, seconds: float = 4.0,
    width: int = 480, height: int = 360, samples: int = 4, integrator: str = "whitted", seed: int = 0, depth: int = 10,
    camera: AnyCamera | None = None, axes: bool = False, labels: bool = False, normals: bool = False,
    folder: str | os.PathLike[str] | None = None, keep: bool = True,
    progress: Callable[[int, int], Any] | None = None, executor: Any = None,
) -> int:  # fmt: skip
    """Turn a scene about once, and write the film as a .gif, .webp or .mp4.

    The camera goes around the point that it looks at, about its `up`: the scene seems to turn counterclockwise. Lights
    of the scene turn with it; default lights stand still.

    The frames are .png files, each named by everything that it depends on. Frames that are there are not rendered
    again: an interrupted turntable continues, and a changed scene gets other frames.

    Parameters
    ----------
    scene : Scene, Shape or Body
        The scene.
    path : path
        The file to write, .gif, .webp or .mp4.
    frames : int
        The number of pictures of the whole turn.
    seconds : float
        The time of the turn.
    width, height, samples, integrator, seed, depth, axes, labels, normals
        As for `Scene.render`.
    camera : AnyCamera, optional
        Default: the camera of the scene, or one that fits.
    folder : path, optional
        The folder of the frames. Default: `spin-frames` beside spin.gif.
    keep : bool
        Keep the frames at the end.
    progress : callable, optional
        progress(done, count) is called from time to time.
    executor : optional
        Computes the frames, a task each, as for `scene.first_hit`. A worker that dies costs only its own frame.

    Returns
    -------
    int
        The number of frames that were rendered.

    Raises
    ------
    ValueError
        For a film that cannot be written, before the first frame.
    ImportError
        For a .mp4 without its encoder (`pip install 'conicoid[video]'`), before the first frame.
    """
    scene = as_scene("turntable", scene)
    options = dict(samples=samples, integrator=integrator, seed=seed, depth=depth)
    flags = dict(axes=axes, labels=labels, normals=normals)
    job = _MovieJob("turntable", path, width, height, options, flags, folder, keep, progress, executor)
    frames = _check_count("turntable", "frames", frames)
    seconds = check_positive("turntable", "seconds", seconds)
    as_camera("turntable", camera)
    job.check_movie(frames, seconds)
    return job.run(Frames(scene, job.folder, job.options), list(_views(scene, camera, frames, job.aspect)), seconds)


def _views(scene: Scene, camera: AnyCamera | None, frames: int, aspect: float) -> Iterator[AnyCamera]:
    """Yield the camera of each frame: the position turned about the axis `up` through the point that it looks at."""
    first = camera or scene.camera or fit_camera(*scene.extent, aspect, frames)
    axis = unit_rows(np.array(first.up))[0]
    offset = np.subtract(first.position, first.look_at)
    axial = dot_rows(offset, axis) * axis
    radial, tangential = offset - axial, np.cross(axis, offset)
    for i in range(frames):
        # The camera turns clockwise, so the scene seems to turn counterclockwise
        s, c = sin_cos_degrees(Fraction(-360 * i, frames))
        turned = axial + c * radial + s * tangential
        yield (
            dataclasses.replace(cast(Any, first), position=snap_to_domain(np.add(first.look_at, turned)))
            if i
            else first
        )


# --- Films of scenes that move by keyframes


class FilmFrames(Frames):
    """The frames of an animated scene; the name of each depends on its time, the tracks and the shutter as well."""

    def __init__(
        self, scene: Scene, folder: Path, options: dict[str, Any], camera: AnyCamera | None, aperture: float,
        times: int | None,
    ) -> None:  # fmt: skip
        super().__init__(scene, folder, options)
        self.camera, self.aperture, self.times = camera, aperture, times
        view = camera or scene.camera or scene.fitting_camera(options["width"] / options["height"])
        light = lower_scene_light(scene, view, options["integrator"]) or lower_scene_shading(scene, view)
        self._film = digest_of(self._key, type(view).__name__, view, light, scene.animation, aperture, times)

    def path(self, time: Any) -> Path:
        """Return where the frame of a time is, or will be."""
        return self.folder / f"{digest_of(self._film, time).hex()}.png"

    def render(self, path: Path, time: Any, progress: Progress | None) -> None:
        """Compute the frame of a time and write its file."""
        self._write(path, render_moment(self.scene, self._frame_options, time, progress))

    def _work(self, workers: Workers) -> tuple[str, Workers, Callable[..., bytes], tuple[SharedObject, SharedObject]]:
        return "animate", workers, render_moment, (SharedObject(self.scene), SharedObject(self._frame_options))

    @property
    def _frame_options(self) -> dict[str, Any]:
        """Everything that a frame depends on, apart from the scene and the time."""
        return dict(camera=self.camera, aperture=self.aperture, times=self.times, options=self.options)


@prepare_first
def render_moment(scene: Scene, how: dict[str, Any], time: float, progress: Any = None) -> bytes:
    """Return the frame of a time as the bytes of its file.

    The shutter opens at that time. For an aperture of 0 the picture shows that instant.
    """
    arguments = dict(camera=how["camera"], progress=progress, **how["options"])
    if how["aperture"] == 0:
        return scene.at(time).render(**arguments)._repr_png_()
    return scene.render(shutter=(time, time + how["aperture"]), times=how["times"], **arguments)._repr_png_()


@ignore_fp_errors
def animate(
    scene: Scene, path: str | os.PathLike[str], *, frames: int | None = None, seconds: float | None = None,
    start: float = 0.0, shutter: float = 0.5, times: int | None = None, width: int = 480, height: int = 360,
    samples: int = 16, integrator: str = "whitted", seed: int = 0, depth: int = 10, camera: AnyCamera | None = None,
    axes: bool = False, labels: bool = False, normals: bool = False, folder: str | os.PathLike[str] | None = None,
    keep: bool = True, progress: Callable[[int, int], Any] | None = None, executor: Any = None,
) -> int:  # fmt: skip
    """Make a film of a scene with an animation, as a .gif, .webp or .mp4.

    A body that moves is prepared anew for each moment; everything else is shared. The frames are .png files, each named
    by everything that it depends on. Frames that are there are not rendered again.

    Parameters
    ----------
    scene : Scene
        With tracks, `scene.animation`.
    path : path
        The file to write, .gif, .webp or .mp4.
    frames : int, optional
        The number of pictures. Default: 24 a second.
    seconds : float, optional
        The length of the film. Default: to the last key.
    start : float
        The time of the first frame, in seconds of the animation.
    shutter : float
        The share of the time of a frame during which the shutter is open, from 0, an instant, to 1.
    times : int, optional
        The number of moments of that interval, as for `Scene.render`.
    width, height, samples, integrator, seed, depth, axes, labels, normals
        As for `Scene.render`.
    camera : AnyCamera, optional
        A camera that stands still, in place of the camera of the scene.
    folder : path, optional
        The folder of the frames. Default: `film-frames` beside film.gif.
    keep : bool
        Keep the frames at the end.
    progress : callable, optional
        progress(done, count) is called from time to time.
    executor : optional
        Computes the frames, a task each, as for `scene.first_hit`.

    Returns
    -------
    int
        The number of frames that were rendered.

    Raises
    ------
    ValueError
        For a scene without an animation, and a film that cannot be written, before the first frame.
    """
    scene = as_scene("animate", scene)
    options = dict(samples=samples, integrator=integrator, seed=seed, depth=depth)
    flags = dict(axes=axes, labels=labels, normals=normals)
    job = _MovieJob("animate", path, width, height, options, flags, folder, keep, progress, executor)
    start, length, count = _extent(scene, frames, seconds, start)
    open_share = check_number("animate", "shutter", shutter)
    if not 0 <= open_share <= 1:
        raise ValueError(f"animate: shutter must be in [0, 1], a share of the time of a frame, got {open_share:g}")
    view = as_camera("animate", camera)
    job.check_movie(count, length)
    step = length / count
    moments = None if times is None else _check_count("animate", "times", times)
    store = FilmFrames(scene, job.folder, job.options, view, open_share * step, moments)
    return job.run(store, [start + k * step for k in range(count)], length)


def frame_count(scene: Scene, frames: Any, seconds: Any, start: Any) -> int:
    """Return the number of frames of a film; the arguments are those of `animate`."""
    return _extent(scene, frames, seconds, start)[2]


def _extent(scene: Scene, frames: Any, seconds: Any, start: Any) -> tuple[float, float, int]:
    """Return the start of a film, its length in seconds, and its number of frames."""
    if not scene.animation:
        raise ValueError("animate: the scene has no animation; co.turntable goes around a scene at rest")
    begin, end = check_number("animate", "start", start), last_time(scene.animation)
    if seconds is None and not end > begin:
        raise ValueError(f"animate: seconds must be given if the last key, {end:g}, is not after start, {begin:g}")
    length = check_positive("animate", "seconds", end - begin if seconds is None else seconds)
    # The default is 24 frames a second
    count = max(1, round(24 * length)) if frames is None else _check_count("animate", "frames", frames)
    return begin, length, count
