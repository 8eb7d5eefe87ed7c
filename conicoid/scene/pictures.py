"""The pictures of a scene: what `Scene.render` does."""

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
    scene: Any, asked: tuple[Any, ...], *, layers: Any, groups: Any, drawn: Mapping[str, Any], progress: Any,
    preview: Any, executor: Any, resume: Any,
) -> Image:  # fmt: skip
    """The picture of a job: `asked` are the arguments of `job_of` behind the scene."""
    flags = {name: check_flag("render", name, on) for name, on in drawn.items()}
    names, job = check_layers(layers), make_job(scene, *asked)
    check_callback("render", "progress", progress)
    shows = _preview_function(preview)
    fixed, seen = asked[6] is not None, scene
    keeps = any(name in names for name in SUM_LAYERS)
    if job.shutter is not None:
        seen = scene.at((job.shutter[0] + job.shutter[1]) / 2)
    lit_by = _groups(scene, groups)
    exposed = _expose_film(scene, job, fixed, keeps, progress, shows, executor, resume)
    found = compute_layers(seen, job, names, exposed)
    for name, part in lit_by.items():
        found[f"light.{name}"] = _expose_film(part, job, fixed, False, None, None, executor, None).film
    image = Image._of_light(exposed.film, found)
    image.noise = None if exposed.sums is None else image_error(exposed.sums)
    if not any(flags.values()):
        return image
    from ..render.overlay import draw_overlay

    return Image._of_light(draw_overlay(image.pixels, seen, job.view, **flags), image.layers)


def _expose_film(
    scene: Any, job: RenderJob, fixed: bool, keeps: bool, progress: Any, shows: Any, executor: Any, resume: Any
) -> FilmResult:
    """A film: by these threads or an executor, at once or while the shutter is open."""
    if executor is not None or resume is not None:
        from ..parallel.pictures import render_tiles

        return render_tiles(scene, job, keeps, executor, resume, progress, shows, fixed)
    if job.shutter is not None:
        from ..render.motion_blur import render_motion_blur

        return render_motion_blur(scene, job, fixed, progress, shows)
    return render(scene, job, keeps, progress, shows)


def _groups(scene: Any, groups: Any) -> dict[str, Any]:
    """For each group of lights the scene with these alone."""
    if groups is None:
        return {}
    from ..render.light_groups import scenes_by_group

    return scenes_by_group(scene, groups)


def _preview_function(preview: Any) -> Callable[[Any, Any], None] | None:
    """What is called with a film as it becomes better."""
    if preview is None or preview is False:
        return None
    if preview is True:
        preview = notebook_preview()
    elif isinstance(preview, str):
        from ..io.images.codecs import terminal_preview

        check_choice("render", "preview", preview, ("terminal",))
        preview = terminal_preview()
    check_callback("render", "preview", preview, "image")

    def shown(film: Any, sums: Any) -> None:
        image = Image._of_light(film.copy())
        image.noise = image_error(sums)
        preview(image)

    return shown


# A picture in a notebook that becomes better while it is made.


def notebook_preview() -> Callable[[Any], None]:
    """What shows pictures in one place of a notebook's cell, each in place of the one before.

    Raises ImportError where IPython, and so a notebook, is not there.
    """
    try:
        shows: Any = importlib.import_module("IPython.display")
    except ImportError:
        raise ImportError(
            'render: preview=True shows pictures in notebooks; elsewhere it is "terminal" or a function'
        ) from None
    handle: list[Any] = []

    def preview(image: Any) -> None:
        if handle:
            handle[0].update(image)
        else:
            handle.append(shows.display(image, display_id=True))

    return preview
