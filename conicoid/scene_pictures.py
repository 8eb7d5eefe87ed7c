"""The pictures of a scene: what `Scene.render` does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .film.layer_names import OF_SUMS, checked_layers
from .film.passes import error_of_all
from .image import Image
from .render.layers import layers_of
from .render.picture import Exposed, Job, job_of, render
from .shapes.suggestion import one_of
from .shapes.validate import callback, flag


def picture_of(
    scene: Any, asked: tuple[Any, ...], *, layers: Any, groups: Any, drawn: Mapping[str, Any], progress: Any,
    preview: Any, executor: Any, resume: Any,
) -> Image:  # fmt: skip
    """The picture of a job: `asked` are the arguments of `job_of` behind the scene."""
    flags = {name: flag("render", name, on) for name, on in drawn.items()}
    names, job = checked_layers(layers), job_of(scene, *asked)
    callback("render", "progress", progress)
    shows = _shown(preview)
    fixed, seen = asked[6] is not None, scene
    keeps = any(name in names for name in OF_SUMS)
    if job.shutter is not None:
        seen = scene.at((job.shutter[0] + job.shutter[1]) / 2)
    lit_by = _groups(scene, groups)
    exposed = _exposed(scene, job, fixed, keeps, progress, shows, executor, resume)
    found = layers_of(seen, job, names, exposed)
    for name, part in lit_by.items():
        found[f"light.{name}"] = _exposed(part, job, fixed, False, None, None, executor, None).film
    image = Image._of_light(exposed.film, found)
    image.noise = None if exposed.sums is None else error_of_all(exposed.sums)
    if not any(flags.values()):
        return image
    from .overlay import drawn_over

    return drawn_over(image, seen, job.view, **flags)


def _exposed(
    scene: Any, job: Job, fixed: bool, keeps: bool, progress: Any, shows: Any, executor: Any, resume: Any
) -> Exposed:
    """A film: by these threads or an executor, at once or while the shutter is open."""
    if executor is not None or resume is not None:
        from .cluster.pictures import rendered

        return rendered(scene, job, keeps, executor, resume, progress, shows, fixed)
    if job.shutter is not None:
        from .render.shutter import render_open

        return render_open(scene, job, fixed, progress, shows)
    return render(scene, job, keeps, progress, shows)


def _groups(scene: Any, groups: Any) -> dict[str, Any]:
    """For each group of lights the scene with these alone."""
    if groups is None:
        return {}
    from .render.groups import scenes_by_group

    return scenes_by_group(scene, groups)


def _shown(preview: Any) -> Callable[[Any, Any], None] | None:
    """What is called with a film as it becomes better."""
    if preview is None or preview is False:
        return None
    if preview is True:
        from .render.live import in_notebook

        preview = in_notebook()
    elif isinstance(preview, str):
        from .formats.blocks import in_terminal

        one_of("render", "preview", preview, ("terminal",))
        preview = in_terminal()
    callback("render", "preview", preview, "image")

    def shown(film: Any, sums: Any) -> None:
        image = Image._of_light(film.copy())
        image.noise = error_of_all(sums)
        preview(image)

    return shown
