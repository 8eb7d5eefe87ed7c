"""The pictures of a scene: `Scene.render`, with layers, groups of lights and previews."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from .._util.text import check_choice, describe_names
from .._util.validation import check_callback, check_flag, describe_kind, format_value
from ..geometry.body import Body
from ..io.image import Image
from ..materials.color import amount_rgb
from ..materials.light import AmbientLight, as_lights
from ..materials.material import Material
from ..queries.device_choice import device_of
from ..render.exposure import FilmResult, RenderJob, compute_layers, make_job, render, render_motion_blur
from ..render.film import SUM_LAYERS, check_layers, image_error

if TYPE_CHECKING:
    from ..queries.device import Device

_FEW = 1000  # rays of a picture that is rendered here sooner than a card begins


def render_image(
    scene: Any, options: tuple[Any, ...], *, layers: Any, groups: Any, drawn: Mapping[str, Any], progress: Any,
    preview: Any, executor: Any, resume: Any, device: str | None,
) -> Image:  # fmt: skip
    """Return the picture of a scene; `options` are the arguments of `make_job` after the scene."""
    flags = {name: check_flag("render", name, on) for name, on in drawn.items()}
    names, job = check_layers(layers), make_job(scene, *options)
    check_callback("render", "progress", progress)
    show = _preview_function(preview)
    gpu = None if executor is not None else device_of("render", device, job.width * job.height * job.samples <= _FEW)
    fixed, shown_scene = options[6] is not None, scene
    with_sums = any(name in names for name in SUM_LAYERS)
    if job.shutter is not None:  # layers and labels show the scene in the middle of the interval
        shown_scene = scene.at((job.shutter[0] + job.shutter[1]) / 2)
    group_scenes = {} if groups is None else scenes_by_group(scene, groups)
    exposed = _expose_film(scene, job, fixed, with_sums, progress, show, executor, resume, gpu)
    layer_arrays = compute_layers(shown_scene, job, names, exposed, gpu)
    for name, part in group_scenes.items():
        # Each group is a picture of its own, with as many samples
        layer_arrays[f"light.{name}"] = _expose_film(part, job, fixed, False, None, None, executor, None, gpu).film
    image = Image._of_light(exposed.film, layer_arrays)
    image.noise = None if exposed.sums is None else image_error(exposed.sums)
    if not any(flags.values()):
        return image
    from ..render.overlay import draw_overlay

    return Image._of_light(draw_overlay(image.pixels, shown_scene, job.view, **flags), image.layers)


def _expose_film(
    scene: Any, job: RenderJob, fixed: bool, with_sums: bool, progress: Any, show: Any, executor: Any, resume: Any,
    gpu: Device | None,
) -> FilmResult:  # fmt: skip
    """Return the film of a job, by threads of this process, an executor or a GPU, with or without a shutter."""
    if executor is not None or resume is not None:
        from ..parallel.pictures import render_tiles

        return render_tiles(scene, job, with_sums, executor, resume, progress, show, fixed, gpu)
    if job.shutter is not None:
        return render_motion_blur(scene, job, fixed, progress, show, device=gpu)
    return render(scene, job, with_sums, progress, show, gpu)


def _preview_function(preview: Any) -> Callable[[Any, Any], None] | None:
    """Return the function that a job calls with its film as the picture improves, or None without a preview."""
    if preview is None or preview is False:
        return None
    if preview is True:
        preview = notebook_preview()
    elif isinstance(preview, str):
        from ..io.image_codecs import terminal_preview

        check_choice("render", "preview", preview, ("terminal",))
        preview = terminal_preview()
    check_callback("render", "preview", preview, "image")

    def show(film: Any, sums: Any) -> None:
        image = Image._of_light(film.copy())  # the job goes on to change its film
        image.noise = image_error(sums)
        preview(image)

    return show


def notebook_preview() -> Callable[[Any], None]:
    """Return a function that shows pictures in one place of a notebook cell, each in place of the one before.

    Raises ImportError without IPython, and so without a notebook.
    """
    try:
        display: Any = importlib.import_module("IPython.display")
    except ImportError:
        raise ImportError(
            'render: preview=True shows pictures in notebooks; other programs take "terminal" or a function'
        ) from None
    handle: list[Any] = []

    def preview(image: Any) -> None:
        if handle:
            handle[0].update(image)
        else:
            handle.append(display.display(image, display_id=True))

    return preview


# Groups of lights: for each a scene in which these alone give light
#
# Light adds up, so the pictures of all groups, each with noise of its own, add up to the picture.

BACKGROUND = "background"
_BLACK = (0.0, 0.0, 0.0)


def scenes_by_group(scene: Any, groups: Any) -> dict[str, Any]:
    """Return, for the name of each group, the scene with its lights alone.

    groups: name -> members: names of bodies that glow, lights of the scene, and "background".
    """
    if not isinstance(groups, Mapping):
        raise TypeError(f"render: groups must be a mapping from names to lists of lights, got {describe_kind(groups)}")
    return {_check_group_name(name): _scene_of_group(scene, name, members) for name, members in groups.items()}


def _check_group_name(name: Any) -> str:
    if not isinstance(name, str) or not name or not name.isprintable():
        raise ValueError(f"render: groups must have names that are texts, got {format_value(name)}")
    return name


def _scene_of_group(scene: Any, group: str, members: Any) -> Any:
    """The scene with some of its lights."""
    items = [members] if isinstance(members, str) or not isinstance(members, list | tuple | set) else list(members)
    lamps = {body.name for body in scene.bodies if body.name is not None and _glows(body)}
    lights, bodies, sky = [], set(), False
    for item in items:
        if isinstance(item, str) and item in lamps:
            bodies.add(item)
        elif isinstance(item, str) and item == BACKGROUND:
            sky = True
        elif not isinstance(item, str) and item in scene.lights:
            lights.append(item)
        else:
            names = describe_names(item, "bodies that glow", sorted(lamps))
            expected = f'bodies that glow, lights of the scene or "{BACKGROUND}"'
            raise ValueError(
                f"render: groups[{format_value(group)}] must name {expected}, got {format_value(item)}; {names}"
            )
    made = scene
    for number, body in enumerate(scene.bodies):
        if _glows(body) and body.name not in bodies:
            made = made._with_entry(number, body, _without_emission(body))
    background = scene.background if sky else _BLACK
    return made.replace(lights=as_lights(lights) or [AmbientLight(0.0)], background=background)


def _materials(body: Body) -> tuple[Any, ...]:
    return tuple(body.materials) if body.materials is not None else (body.material,)


def _glows(body: Body) -> bool:
    """Does a body, or one of many in an entry, give light by itself?"""
    found = (each for each in _materials(body) if isinstance(each, Material))
    return any(max(amount_rgb(each.emission)) > 0 for each in found)


def _without_emission(body: Body) -> Body:
    """The same without light of its own."""
    dark = [dataclasses.replace(each, emission=0.0) if isinstance(each, Material) else each
            for each in _materials(body)]  # fmt: skip
    if body.materials is not None:
        return dataclasses.replace(body, materials=tuple(dark))
    return dataclasses.replace(body, material=dark[0])
