"""The pictures of a scene: `Scene.render`, with layers, groups of lights and previews."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any

from .._util.hints import check_choice
from .._util.validation import check_callback, check_flag
from ..io.images.image import Image
from ..render.exposure import compute_layers, render
from ..render.film.film import image_error
from ..render.film.layers import SUM_LAYERS, check_layers
from ..render.job import FilmResult, RenderJob, make_job


def render_image(
    scene: Any, options: tuple[Any, ...], *, layers: Any, groups: Any, drawn: Mapping[str, Any], progress: Any,
    preview: Any, executor: Any, resume: Any,
) -> Image:  # fmt: skip
    """Return the picture of a scene; `options` are the arguments of `make_job` after the scene."""
    flags = {name: check_flag("render", name, on) for name, on in drawn.items()}
    names, job = check_layers(layers), make_job(scene, *options)
    check_callback("render", "progress", progress)
    show = _preview_function(preview)
    fixed, shown_scene = options[6] is not None, scene
    with_sums = any(name in names for name in SUM_LAYERS)
    if job.shutter is not None:  # layers and labels show the scene in the middle of the interval
        shown_scene = scene.at((job.shutter[0] + job.shutter[1]) / 2)
    group_scenes = _groups(scene, groups)
    exposed = _expose_film(scene, job, fixed, with_sums, progress, show, executor, resume)
    layer_arrays = compute_layers(shown_scene, job, names, exposed)
    for name, part in group_scenes.items():
        # Each group is a picture of its own, with as many samples
        layer_arrays[f"light.{name}"] = _expose_film(part, job, fixed, False, None, None, executor, None).film
    image = Image._of_light(exposed.film, layer_arrays)
    image.noise = None if exposed.sums is None else image_error(exposed.sums)
    if not any(flags.values()):
        return image
    from ..render.overlay import draw_overlay

    return Image._of_light(draw_overlay(image.pixels, shown_scene, job.view, **flags), image.layers)


def _expose_film(
    scene: Any, job: RenderJob, fixed: bool, with_sums: bool, progress: Any, show: Any, executor: Any, resume: Any
) -> FilmResult:
    """Return the film of a job, computed by threads of this process or by an executor, with or without a shutter."""
    if executor is not None or resume is not None:
        from ..parallel.pictures import render_tiles

        return render_tiles(scene, job, with_sums, executor, resume, progress, show, fixed)
    if job.shutter is not None:
        from ..render.motion_blur import render_motion_blur

        return render_motion_blur(scene, job, fixed, progress, show)
    return render(scene, job, with_sums, progress, show)


def _groups(scene: Any, groups: Any) -> dict[str, Any]:
    """Return, for each group of lights, the scene with these lights alone."""
    if groups is None:
        return {}
    from ..render.light_groups import scenes_by_group

    return scenes_by_group(scene, groups)


def _preview_function(preview: Any) -> Callable[[Any, Any], None] | None:
    """Return the function that a job calls with its film as the picture improves, or None without a preview."""
    if preview is None or preview is False:
        return None
    if preview is True:
        preview = notebook_preview()
    elif isinstance(preview, str):
        from ..io.images.codecs import terminal_preview

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
