"""Scenes from and to scene files."""

from __future__ import annotations

import os

from .formats import scene_file
from .scene import Scene


def load(path: str | os.PathLike[str]) -> Scene:
    """The scene in a YAML or JSON file (docs/files.md). Nothing in a file is executed.

    Raises `SceneFileError`, a ValueError, that lists every mistake with its line, the object, the field,
    what was expected and what was found.
    """
    parts = scene_file.read(path)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background)


def save(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write a scene file that loads as an equal scene: YAML, or JSON if `path` ends with .json.

    More than 100 balls of a `Spheres` go to a .npy file beside it. Files appear whole or not at all.
    Raises OSError where they cannot be written, and ValueError for what a file cannot say.
    """
    scene_file.write(scene, path)
