"""Scenes from and to files."""

from __future__ import annotations

import os
from collections.abc import Callable

from .formats import scene_file
from .scene import Scene
from .shapes.calm import calm


@calm
def load(path: str | os.PathLike[str]) -> Scene:
    """The scene in a YAML or JSON file (docs/files.md). Nothing in a file is executed.

    Raises `SceneFileError`, a ValueError, that lists every mistake with its line, the object, the field,
    what was expected and what was found.
    """
    parts = scene_file.read(path)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background)


@calm
def save(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write a scene file that loads as an equal scene: YAML, or JSON if `path` ends with .json.

    More than 100 balls of a `Spheres` go to a .npy file beside it, named by its content and never overwritten.
    Files appear whole or not at all, the scene last.
    Raises OSError where they cannot be written, and ValueError for what a file cannot say.
    """
    scene_file.write(scene, path)


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

    parts = openmc.read(path, void=void, max_bodies=max_bodies, progress=progress)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background)
