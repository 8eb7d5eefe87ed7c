"""A picture that comes into being: its options (`RenderJob`), then passes over its tiles until enough noise is gone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.records import dataclass
from .._util.text import check_choice
from .._util.validation import as_integer, check_numbers, check_positive, format_value
from ..geometry.labels import body_material_table
from ..kernels.tables import Longs
from ..kernels.threads import KernelRange, Progress, chunk_size, has_ended, marked_items, run_on
from ..materials.light import AmbientLight
from ..materials.material import DEFAULT_MATERIAL, Material
from . import tiles
from .camera import AnyCamera, as_camera, fit_lights
from .camera_rays import lower_view
from .film import COUNT, STEP, SUMS, check_filter, is_end, mean_pixels, next_end, pixel_errors, select_squares
from .integrators import INTEGRATORS
from .integrators.samples import Settings
from .options import MOST_SAMPLES, SAMPLES, Filter, check_size
from .tiles import SIDE, SQUARE, Film

if TYPE_CHECKING:
    from ..queries.device import Device
    from .tiles import Film


@dataclass(frozen=True)
class RenderJob:
    """All that a picture depends on but the scene, checked."""

    width: int
    height: int
    samples: int
    integrator: str
    seed: int
    depth: int
    view: AnyCamera
    filter: Filter = "box"
    noise: float | None = None
    shutter: tuple[float, float] | None = None
    times: int = 1
    """Moments of the shutter's time at which moving bodies are seen."""

    @property
    def round(self) -> int:
        """In so many samples all moments of the shutter's time are seen once: all, or where noise may end them some."""
        return self.samples if self.noise is None else -(-STEP // self.times) * self.times

    def sample_mask(self, sums: FloatArray, last: int, side: int) -> npt.NDArray[np.int8]:
        """(rows, columns): 1 for each square, `side` pixels a side, that is to get samples in a pass up to `last`."""
        is_judged = is_end if self.shutter is None else lambda count: count % self.round == 0
        return select_squares(sums, last, self.noise, side, is_judged)

    @property
    def is_progressive(self) -> bool:
        """May samples be added to it?"""
        return INTEGRATORS[self.integrator].progressive

    @property
    def keeps_sums(self) -> bool:
        """Whether the picture needs sums of samples by itself."""
        return self.is_progressive or self.noise is not None


class FilmResult(NamedTuple):
    """A film, and the sums of its samples where they were kept (`film.sums`)."""

    film: Film
    sums: FloatArray | None


def make_job(
    scene: Any, width: Any, height: Any, samples: Any, integrator: Any, seed: Any, depth: Any, camera: Any,
    form: Any = "box", noise: Any = None, shutter: Any = None, times: Any = None,
) -> RenderJob:  # fmt: skip
    """Return the job of a picture. Raise ValueError for unknown integrators and invalid numbers."""
    width, height = check_size(width, height, "render")
    limit = check_positive("render", "noise", noise) if noise is not None else None
    if samples is None:
        samples = SAMPLES if limit is None else MOST_SAMPLES
    options = check_options(samples, integrator, seed, depth)
    if limit is not None and not INTEGRATORS[integrator].progressive:
        able = ", ".join(name for name, one in INTEGRATORS.items() if one.progressive) or "none so far"
        raise ValueError(
            f"render: noise goes with integrators whose samples can be continued ({able}), not {integrator}"
        )
    kind = check_filter("render", form)
    view = as_camera("render", camera) or scene.camera or scene.fitting_camera(width / height)
    during = None if shutter is None else _shutter(shutter)
    if times is not None and shutter is None:
        raise ValueError("render: times goes with shutter; without one all is seen at one time")
    most = (
        1
        if shutter is None
        else min(options["samples"], MOST_TIMES if times is None else _check_option("times", times, 1, 2**20))
    )
    return RenderJob(width, height, **options, view=view, filter=kind, noise=limit, shutter=during, times=most)


MOST_TIMES = 64
"""Default number of moments of a shutter's time."""


def _shutter(value: Any) -> tuple[float, float]:
    """When a shutter opens and closes."""
    opens, closes = check_numbers("render", "shutter", value, 2)
    if not opens <= closes:
        raise ValueError(f"render: shutter must close after it opens, got {opens:g} to {closes:g}")
    return opens, closes


def most_turns(integrator: str, depth: int) -> int:
    """How often light is followed at most."""
    most = INTEGRATORS[integrator].turns
    return depth if most is None else most


def lower_scene_light(scene: Any, camera: AnyCamera, integrator: str) -> Any:
    """The materials, lights and background in the form of an integrator."""
    kind = INTEGRATORS[integrator]
    if kind.transports:
        return _lower_transport(scene, camera)
    return _lower_whitted(scene, camera) if kind.lit else None


def _lower_whitted(scene: Any, camera: AnyCamera) -> Any:
    """Return the tables of Whitted's pictures; lamps without lights get the ambient one of those that fit."""
    from .lights.light_tables import lower_lamplight

    made = lower_lamplight(lower_scene_shading(scene, camera), scene.bodies, scene._prepared.lowered.body_item)
    if scene.lights or len(made.lamps.records) == 0:
        return made
    ambient = [light for light in fit_lights(camera) if isinstance(light, AmbientLight)]
    return made._replace(look=lower_scene_shading(scene, camera, ambient))


def _lower_transport(scene: Any, camera: AnyCamera) -> Any:
    """Return the tables of light transport; without lights, of lamps and background, or else of lights that fit."""
    from .lights.light_tables import lower_transport

    def with_lights(lights: Any) -> Any:
        look = lower_scene_shading(scene, camera, lights)
        return lower_transport(look, scene.bodies, scene._prepared.lowered.body_item, scene.background)

    if scene.lights:
        return with_lights(scene.lights)
    alone = with_lights(())
    return alone if alone.shines else with_lights(fit_lights(camera))


def lower_scene_shading(scene: Any, camera: AnyCamera, lights: Any = None) -> Any:
    """Materials, lights and background as kernels take them; lights fit the camera where the scene has none."""
    from .lights.light_tables import lower_shading_tables

    found, sheets, place_of = body_material_table(scene.bodies, scene._prepared.lowered.body_item)
    materials = [DEFAULT_MATERIAL if material is None else material for material in found]
    for i, material in enumerate(materials):
        if not isinstance(material, Material):
            raise TypeError(f"render: material of bodies[{i}] must be a Material, got {type(material).__name__}")
    lights = scene.lights or fit_lights(camera) if lights is None else lights
    paint = scene._prepared.lowered.face_paint
    return lower_shading_tables(materials, sheets, place_of, lights, scene.background, paint)


def scale_to_pixels(look: Any, job: RenderJob) -> Any:
    """A look, or the tables of light transport, for pixels of a picture's size."""
    return look._replace(look=_with_pixels(look.look, job))


def _with_pixels(look: Any, job: RenderJob) -> Any:
    at, along = job.view.pixel(job.width, job.height)
    return look._replace(materials=look.materials._replace(pixel=np.array([at, along])))


def check_options(samples: Any, integrator: Any, seed: Any, depth: Any) -> dict[str, Any]:
    """The options of a picture, or an error."""
    return dict(
        samples=_check_option("samples", samples, 1, 2**20),
        integrator=check_choice("render", "integrator", integrator, INTEGRATORS),
        seed=_check_option("seed", seed, 0, 2**63 - 1),
        depth=_check_option("depth", depth, 0, 10_000),
    )


def _check_option(name: str, value: Any, least: int, most: int) -> int:
    """An option as an integer within limits, or a ValueError."""
    found = as_integer(value)
    if found is None or not least <= found <= most:
        raise ValueError(f"render: {name} must be a whole number from {least} to {most}, got {format_value(value)}")
    return found


# A picture that comes into being: passes over its tiles until it has all its samples, or noise enough is gone.
#
# Motion blur exposes scenes at moments of the time while the shutter is open, and adds their samples.

Preview: TypeAlias = Callable[[Film, FloatArray], Any]
TileSink: TypeAlias = Callable[[list[tuple[int, int]]], Any]
_TILES = 16
"""Most tiles of one sample that a call fills: its overhead is as long as half a tile of a simple picture.

Of many samples each is handed over as it is done.
"""
_PATIENCE = 60.0  # seconds for threads to end


class Exposure:
    """A film, with the sums of its samples if they are kept; work is on tiles `begin` to `end`.

    Invariant: the sums of a square are those of whole samples, whenever no thread works on it.
    """

    def __init__(
        self, scene: Any, job: RenderJob, keeps: bool, begin: int = 0, end: int | None = None, look: Any = None,
        goes_on: bool = False, device: Device | None = None,
    ) -> None:  # fmt: skip
        """goes_on: may samples be added also where the integrator is not progressive? device: a card that adds them."""
        self.scene, self.job, self.keeps = scene, job, keeps
        self.begin = begin
        self.end = tiles.tile_total(job.width, job.height) if end is None else end
        self.film = np.zeros((job.height, job.width, 3), np.float32)  # only filled parts take memory
        self.sums = np.zeros((job.height if keeps else 0, job.width, SUMS))
        look = lower_scene_light(scene, job.view, job.integrator) if look is None else look
        turns = most_turns(job.integrator, job.depth)
        self._settings = Settings(job.samples, job.seed, turns, look and scale_to_pixels(look, job), int(goes_on))
        self._view = lower_view(job.view, job.filter)
        self._card = None
        if device is not None:
            from .device_pictures import DevicePictures

            self._card = DevicePictures(device, scene._prepared, job.integrator, self._view, self._settings)
        self._changed: set[int] = set()
        """Tiles in which this pass adds samples, and which are not yet handed over."""
        self._marks = np.zeros(self.end - self.begin, np.int8)
        """1 for each tile that is done in this pass."""
        self._unreported: set[int] = set()
        """Tiles of the passes before that are not yet handed over."""
        self._saved = monotonic()

    def go_on(
        self, progress: Progress | None = None, preview: Preview | None = None, keep: TileSink | None = None
    ) -> None:
        """Compute the missing samples.

        keep([(begin, end), ...]) is called from time to time with tiles whose sums are new, also if the work is
        interrupted. Between two calls lies the work of some seconds.
        """
        if self.keeps:
            self.film[:] = mean_pixels(self.sums)
        begun = self._begun() if self.keeps else 0
        for last, squares in self._passes(preview is not None or keep is not None):
            self._run(last, squares, begun, progress, keep)
            begun = last
            if keep is not None and monotonic() - self._saved > SAVE_INTERVAL / 4:
                self._hand_over(keep, True)
            if preview is not None:
                preview(self.film, self.sums)
        if keep is not None:
            self._hand_over(keep, True)

    def _passes(self, is_watched: bool) -> Iterator[tuple[int, Any]]:
        """(samples at its end, the squares that are wanted) of each pass: short ones first, where somebody looks."""
        job = self.job
        if not self.keeps:
            yield job.samples, np.zeros(0, np.int8)
            return
        at = self._begun()
        while at < job.samples:
            after = next_end(at) if is_watched or job.noise is not None else at + STEP
            at = min(job.samples, after) if job.is_progressive else job.samples
            squares = self._sample_mask(at)
            if squares.any():
                yield at, squares

    def _begun(self) -> int:
        """The fewest samples that a square has which is to get more."""
        count = self.sums[::SQUARE, ::SQUARE, COUNT].ravel()
        return int(count[self._sample_mask(self.job.samples) != 0].min(initial=self.job.samples))

    def _sample_mask(self, last: int) -> Any:
        """Return a mask (squares,): the squares that get samples in a pass that ends with `last`."""
        across = -(-self.job.width // SIDE)
        top, bottom = self.begin // across, -(-self.end // across)
        rows, columns = -(-self.job.height // SQUARE), -(-self.job.width // SQUARE)
        found = np.zeros((rows, columns), np.int8)
        part = self.job.sample_mask(self.sums[top * SIDE : bottom * SIDE], last, SQUARE)
        places: Longs = np.indices(part.shape)
        first = top * SIDE // SQUARE
        tile = tiles.tiles_of_squares(first + places[0], places[1], self.job.width)
        found[first : first + len(part)] = part & (self.begin <= tile) & (tile < self.end)
        return found.ravel()

    def _run(self, last: int, squares: Any, begun: int, progress: Progress | None, keep: TileSink | None) -> None:
        """One pass."""
        fill, across = tiles.tile_kernel(self.job.integrator), -(-self.job.width // SQUARE)
        row, column = np.divmod(np.flatnonzero(squares), across)
        self._changed = set(tiles.tiles_of_squares(row, column, self.job.width).tolist())
        self._marks[:] = 0
        before, after = (self._view, self.film, self.sums, squares, self._settings, last), ()
        work = KernelRange(fill, before, after, self.begin)

        def report(done: int, count: int) -> None:
            if keep is not None:
                self._hand_over(keep, False)
            if progress is not None and self.keeps:
                progress(begun * count + done * (last - begun), count * self.job.samples)
            elif progress is not None:
                progress(done, count)

        def mark(tiles: Longs, left: int) -> None:
            """Note tiles that the card has done, and report how many it has left."""
            self._marks[tiles - self.begin] = 1
            report(count - left, count)

        count = self.end - self.begin
        rays = min(count * SIDE * SIDE, self.job.width * self.job.height) * (last - begun)
        try:
            watched = report if progress is not None or keep is not None else None
            most = max(1, _TILES // max(1, last - begun))
            chunk, tables = chunk_size(count, most), (self.film, self.sums, squares, last, begun)
            if self._card is None or not self._card.fill(*tables, self.begin, self.end, mark):
                run_on(self.scene._prepared.geometry, work, count, chunk, rays, watched, self._marks)
        except BaseException:
            if has_ended(_PATIENCE) and keep is not None:
                self._hand_over(keep, True)  # also tiles with unfinished squares
            raise
        self._unreported |= self._changed
        self._changed = set()

    def _hand_over(self, keep: TileSink, is_end: bool) -> None:
        """Hand over new tiles, from time to time; in the middle of a pass those that no thread will write to."""
        if not is_end and monotonic() - self._saved < SAVE_INTERVAL:
            return
        if is_end:
            new = self._changed | self._unreported
        else:
            new = self._changed.intersection((self.begin + marked_items(self._marks)).tolist())
        self._saved = monotonic()
        if new:
            keep(tile_ranges(sorted(new)))
        self._changed -= new
        self._unreported -= new


def tile_ranges(numbers: list[int]) -> list[tuple[int, int]]:
    """Return rising numbers as ranges (begin, end) of consecutive ones."""
    steps = np.flatnonzero(np.diff(numbers) != 1) + 1
    return [(int(part[0]), int(part[-1]) + 1) for part in np.split(np.array(numbers), steps)]


SAVE_INTERVAL = 10.0
"""Seconds after which finished tiles are handed over."""


def render(
    scene: Any, job: RenderJob, keeps: bool = False, progress: Progress | None = None, preview: Preview | None = None,
    device: Device | None = None,
) -> FilmResult:  # fmt: skip
    """Render a picture of a scene with the threads of this process: (height, width, 3) float32 of linear light.

    The same job gives the same picture to the bit, for any number of threads.

    Parameters
    ----------
    scene : Scene
        With the bodies, lights and background.
    job : RenderJob
        The camera, the integrator and all options.
    keeps : bool
        Return the sums of the samples as well.
    progress : callable, optional
        progress(done, count) is called with numbers of tiles.
    preview : callable, optional
        preview(film, sums) is called after each pass of a progressive picture.
    device : Device, optional
        A card that renders the picture, to the same bits. Where its memory is too small threads do.
    """
    exposure = Exposure(scene, job, keeps or job.keeps_sums, device=device)
    exposure.go_on(progress, preview)
    return FilmResult(exposure.film, exposure.sums if exposure.keeps else None)


# --- Layers: data of each pixel besides its light, such as the body, its distance, and error bounds


def compute_layers(
    scene: Any, job: RenderJob, names: tuple[str, ...], exposed: FilmResult, device: Device | None = None
) -> dict[str, Any]:
    """Name -> array, of the layers of a picture."""
    found: dict[str, Any] = {}
    if "albedo" in names:
        colors = replace(job, integrator="albedo", noise=None, samples=min(job.samples, 64))
        found["albedo"] = render(scene, colors, device=device).film
    if exposed.sums is not None:
        found["samples"] = exposed.sums[..., COUNT].astype(np.int32)
        found["error"] = pixel_errors(exposed.sums).astype(np.float32)
    if {"normal", "depth", "position", "body"} & set(names):
        hits = scene.first_hit(job.view.rays(job.width, job.height))
        found["normal"] = np.nan_to_num(np.asarray(hits.normal)).astype(np.float32)
        found["depth"] = np.asarray(hits.t).astype(np.float32)
        found["position"] = np.asarray(hits.point).astype(np.float32)
        found["body"] = hits.body
    return {name: found[name] for name in names}


# --- Motion blur
#
# The time while the shutter is open is cut into `times` equal parts. At the middle of each the scene stands where its
# tracks have it, exactly, and a block of consecutive samples sees it so. The picture is the mean of these exact
# pictures. Blocks of Sobol's points are themselves spread evenly, over the pixel and the lens. So a scene at rest looks
# as without a shutter, to the bit with progressive integrators. Only bodies that move are prepared anew.
#
# If noise ends the work, all moments are seen in a round of some samples before it is judged, and in the next again.
# Moments differ, and their differences count as noise, so the reported noise is not too small.


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
        if not job.sample_mask(sums, begin + count, SQUARE).any():
            continue
        for k, time in enumerate(moments(job.shutter, job.times)):
            end = begin + (k + 1) * count // job.times
            if not job.sample_mask(sums, end, SQUARE).any():
                continue
            moment = scene.at(time)
            view = job.view if fixed or moment.camera is None else moment.camera
            yield moment, replace(job, samples=end, view=view)


def render_motion_blur(
    scene: Any, job: RenderJob, fixed: bool, progress: Progress | None = None, preview: Preview | None = None,
    kept: Any = None, device: Device | None = None,
) -> FilmResult:  # fmt: skip
    """The picture of a scene that moves while the shutter is open.

    fixed: is the camera that of the job throughout?
    kept: where sums are read from first, `kept.read(sums)`, and written to, `kept.add(sums, tiles)`, or None.
    """
    sums = empty_sums(job)
    if kept is None:
        _expose(scene, job, fixed, sums, progress, preview, None, device)
        return FilmResult(mean_pixels(sums), sums)
    kept.read(sums)
    new = _NewTiles(kept, sums)
    try:
        _expose(scene, job, fixed, sums, progress, preview, new.add, device)
    finally:
        new.write()
    return FilmResult(mean_pixels(sums), sums)


def _expose(
    scene: Any, job: RenderJob, fixed: bool, sums: FloatArray, progress: Progress | None, preview: Preview | None,
    keep: TileSink | None, device: Device | None,
) -> None:  # fmt: skip
    for moment, part in stills(scene, job, fixed, sums):
        exposure = Exposure(moment, part, True, goes_on=True, device=device)
        exposure.sums = sums
        exposure.go_on(_as_part(progress, part.samples, job.samples), preview, keep)


class _NewTiles:
    """Tiles with new samples, which are written every few seconds: moments may be much shorter."""

    def __init__(self, kept: Any, sums: FloatArray) -> None:
        self._sink, self._sums, self._tiles, self._written = kept, sums, set[int](), monotonic()

    def add(self, tiles: list[tuple[int, int]]) -> None:
        """Remember tiles, and write all if it is time."""
        for begin, end in tiles:
            self._tiles.update(range(begin, end))
        if monotonic() - self._written >= SAVE_INTERVAL:
            self.write()

    def write(self) -> None:
        """Write those that are not yet."""
        if self._tiles:
            self._sink.add(self._sums, tile_ranges(sorted(self._tiles)))
        self._tiles.clear()
        self._written = monotonic()


def _as_part(progress: Progress | None, samples: int, of: int) -> Progress | None:
    """Return a callback for a part of `samples` samples of a picture, which reports it as a share of `of` samples."""
    if progress is None:
        return None
    return lambda done, count: progress(done, count // samples * of)
