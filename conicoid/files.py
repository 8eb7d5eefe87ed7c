"""Scenes from and to files."""

from __future__ import annotations

import os
from collections.abc import Callable

from .formats import scene_file
from .scene import Scene, as_scene
from .shapes.base import Shape
from .shapes.body import Body
from .shapes.calm import calm
from .shapes.validate import callback, flag, integer
from .shapes.validate import path as checked_path


@calm
def load(path: str | os.PathLike[str]) -> Scene:
    """The scene in a YAML or JSON file (docs/files.md). Nothing in a file is executed.

    Raises `SceneFileError`, a ValueError, that lists every mistake with its line, the object, the field,
    what was expected and what was found.
    """
    parts = scene_file.read(checked_path("load", path))
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)


@calm
def save(scene: Scene | Shape | Body, path: str | os.PathLike[str]) -> None:
    """Write a scene file that loads as an equal scene: YAML, or JSON if `path` ends with .json.

    One shape or body is saved as a scene of it.

    More than 100 balls of a `Spheres` go to a .npy file beside it, named by its content and never overwritten.
    Files appear whole or not at all, the scene last.
    Raises OSError where they cannot be written, and ValueError for what a file cannot say.
    """
    scene_file.write(as_scene("save", scene), checked_path("save", path))


@calm
def load_openmc(
    path: str | os.PathLike[str],
    *,
    void: bool = True,
    max_bodies: int = 50_000,
    progress: Callable[[int, int], None] | None = None,
) -> Scene:
    """The scene of an OpenMC geometry: a geometry.xml (with the materials.xml beside it) or a model.xml.

    A body for each place of each cell; docs/openmc.md says how. With `void`, cells without material are invisible
    bodies, so that `scene.body_at` finds every cell. `conicoid.formats.openmc.read` gives the legend as well.
    Raises `SceneFileError`, a ValueError, that lists the mistakes with their lines; also for what is no quadric (tori,
    meshes) and for more than `max_bodies` bodies, before they are made.
    """
    from .formats import openmc

    flag("load_openmc", "void", void)
    callback("load_openmc", "progress", progress)
    max_bodies = integer("load_openmc", "max_bodies", max_bodies, 1)
    parts = openmc.read(checked_path("load_openmc", path), void=void, max_bodies=max_bodies, progress=progress)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)
