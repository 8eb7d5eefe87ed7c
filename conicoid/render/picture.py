"""A scene to a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..integrators import INTEGRATORS
from ..shapes.material import DEFAULT, Material
from ..shapes.repeated_labels import looks_of
from ..shapes.suggestion import close_to
from ..shapes.validate import callback, shown, whole
from .camera import AnyCamera, as_camera, checked_size
from .fit import fitting_lights

if TYPE_CHECKING:
    from ..engine.tables import Geometry
    from ..engine.threads import Progress
    from .tiles import Film


def render(
    scene: Any,
    width: int = 640,
    height: int = 480,
    samples: int = 4,
    integrator: str = "whitted",
    seed: int = 0,
    depth: int = 10,
    progress: Progress | None = None,
    camera: AnyCamera | None = None,
    elsewhere: Any = None,
) -> Film:
    """The scene's picture as (height, width, 3) float32 of linear light.

    samples: rays per pixel; one goes through the pixel's centre, more are stratified over its area.
    integrator: a name in `INTEGRATORS`.
    depth: how often a ray is reflected or refracted at most.
    The same arguments give the same picture to the bit, for any number of threads.
    progress(done, count) is called with numbers of tiles.
    camera: in place of the scene's.
    elsewhere: fills the film in place of this process' threads: elsewhere(checked arguments).
    Raises ValueError for unknown integrators and senseless numbers.
    """
    width, height = checked_size(width, height)
    options = check_options(samples, integrator, seed, depth)
    samples, seed, depth = options["samples"], options["seed"], options["depth"]
    callback("render", "progress", progress)
    view = as_camera("render", camera) or scene.camera or scene.fitting_camera(width / height)
    if elsewhere is not None:
        made: Film = elsewhere(width, height, samples, integrator, seed, depth, view)
        return made

    from ..engine.threads import run_on
    from ..integrators.samples import Settings
    from . import tiles

    lens = view.lens
    film = np.zeros((height, width, 3), dtype=np.float32)
    settings = Settings(samples, seed, turns_of(integrator, depth), light_of(scene, view, integrator))
    fill = tiles.tile_kernel(integrator)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        fill(geometry, lens, film, settings, begin, end)

    run_on(scene.geometry, work, tiles.tile_total(width, height), 1, width * height * samples, progress)
    return film


def turns_of(integrator: str, depth: int) -> int:
    """How often light is followed at most."""
    most = INTEGRATORS[integrator].turns
    return depth if most is None else most


def light_of(scene: Any, camera: AnyCamera, integrator: str) -> Any:
    """What an integrator needs of materials, lights and background."""
    chosen = INTEGRATORS[integrator]
    if chosen.transports:
        return _transport_of(scene, camera)
    return look_of(scene, camera) if chosen.lit else None


def _transport_of(scene: Any, camera: AnyCamera) -> Any:
    """What light transport needs. Where the scene has no lights, lamps and background are; else those that fit."""
    from ..emitters.transport import lower_transport

    def with_lights(lights: Any) -> Any:
        look = look_of(scene, camera, lights)
        return lower_transport(look, scene.bodies, scene.lowered.body_item, scene.background)

    if scene.lights:
        return with_lights(scene.lights)
    alone = with_lights(())
    return alone if alone.shines else with_lights(fitting_lights(camera))


def look_of(scene: Any, camera: AnyCamera, lights: Any = None) -> Any:
    """Materials, lights and background as kernels take them; lights fit the camera where the scene has none."""
    from ..shading.look import lower_look

    found, sheets, place_of = looks_of(scene.bodies, scene.lowered.body_item)
    materials = [DEFAULT if material is None else material for material in found]
    for i, material in enumerate(materials):
        if not isinstance(material, Material):
            raise TypeError(f"render: material of bodies[{i}] must be a Material, got {type(material).__name__}")
    lights = scene.lights or fitting_lights(camera) if lights is None else lights
    return lower_look(materials, sheets, place_of, lights, scene.background, scene.lowered.face_paint)


def check_options(samples: Any, integrator: Any, seed: Any, depth: Any) -> dict[str, Any]:
    """The options of a picture, or an error."""
    if not isinstance(integrator, str) or integrator not in INTEGRATORS:
        close = close_to(integrator, INTEGRATORS) if isinstance(integrator, str) else ""
        meant = f" (did you mean {close!r}?)" if close else ""
        raise ValueError(f"render: integrator must be one of {', '.join(INTEGRATORS)}, got {shown(integrator)}{meant}")
    return dict(
        samples=_whole("samples", samples, 1, 2**20),
        integrator=integrator,
        seed=_whole("seed", seed, 0, 2**63 - 1),
        depth=_whole("depth", depth, 0, 10_000),
    )


def _whole(name: str, value: Any, least: int, most: int) -> int:
    """An option as an integer within limits, or a ValueError."""
    found = whole(value)
    if found is None or not least <= found <= most:
        raise ValueError(f"render: {name} must be a whole number from {least} to {most}, got {shown(value)}")
    return found
