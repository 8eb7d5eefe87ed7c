"""`RenderJob`: the checked options of one picture, and the scene's light and materials as its integrator reads them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.records import FloatArray, dataclass
from .._util.text import check_choice
from .._util.validation import as_integer, check_numbers, check_positive, format_value
from ..geometry.labels import body_material_table
from ..materials.light import AmbientLight
from ..materials.material import DEFAULT_MATERIAL, Material
from .camera import AnyCamera, as_camera, fit_lights
from .film import STEP, check_filter, is_end, select_squares
from .integrators import INTEGRATORS
from .options import MOST_SAMPLES, SAMPLES, Filter, check_size

if TYPE_CHECKING:
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
