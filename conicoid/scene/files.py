"""Scenes from and to files."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .._util.errstate import ignore_fp_errors
from .._util.validation import check_callback, check_flag, check_integer
from .._util.validation import check_path as checked_path
from ..geometry.body import Body
from ..geometry.shape import Shape
from ..io.scene_file import scene_file
from .scene import Scene, as_scene

if TYPE_CHECKING:
    from ..io.importers import ImportResult

_MOST_LOGGED_NOTES = 12
"""Notes of an import that are shown at once."""


@ignore_fp_errors
def load(
    path: str | os.PathLike[str],
    *,
    progress: Callable[[int, int], Any] | None = None,
    outside: bool = False,
    **options: Any,
) -> Scene:
    """The scene in the file at `path`: YAML or JSON (docs/files.md), or a file of another program (docs/importing.md).

    The format is known by what is in the file. Nothing in a file is executed.

    progress: progress(done, count) is called now and then, with shares of the work, or numbers of bodies.
    outside: may pictures of textures lie outside of the file's folder? Else that is an error.
    options: of files of other programs, those of `conicoid.io.importers.Options`: void, max_bodies, strict, only,
        depth, smooth, entities. `scene.notes` then is what there is to say of the import; what is not as the file says
        also goes to the log, `logging.getLogger("conicoid")`, as warnings.

    Raises `SceneFileError`, a ValueError, that lists every mistake with its line, the object, the field,
    what was expected and what was found; where there is no such file it is a FileNotFoundError as well.
    """
    from .._util.gc_pause import pause_gc
    from ..io.importers import ImportOptions, detect_format

    found = detect_format(checked_path("load", path))
    if found is None:
        if options:
            raise TypeError(f"load: {', '.join(options)} are for files of other programs, which {path} is not")
        return Scene.load(path, progress=progress, outside=outside)
    check_flag("load", "outside", outside)
    with pause_gc():
        return _scene_of(path, found.read(path, ImportOptions.of(progress=progress, **options)))


def _scene_of(path: str | os.PathLike[str], parts: ImportResult) -> Scene:
    """The scene of what was imported, with its notes; its remarks are told."""
    scene = Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)
    scene._notes = parts.notes
    if parts.remarks:
        import logging

        more = (
            []
            if len(parts.remarks) <= _MOST_LOGGED_NOTES
            else [f"... and {len(parts.remarks) - _MOST_LOGGED_NOTES:,} more in scene.notes"]
        )
        told = "\n".join(f"{os.fspath(path)}: {note}" for note in [*parts.remarks[:_MOST_LOGGED_NOTES], *more])
        logging.getLogger("conicoid").warning("%s", told)
    return scene


@ignore_fp_errors
def save(scene: Scene | Shape | Body, path: str | os.PathLike[str]) -> None:
    """Write a scene file that loads as an equal scene: YAML, or JSON if `path` ends with .json.

    scene: one shape or body is saved as a scene of it.

    More than 100 balls of a `Spheres` go to a .npy file beside it, named by its content and never overwritten.
    Files appear whole or not at all, the scene last.
    Raises OSError where they cannot be written, and ValueError for what a file cannot say.
    """
    scene_file.write_scene(as_scene("save", scene), checked_path("save", path))


@ignore_fp_errors
def load_openmc(
    path: str | os.PathLike[str],
    *,
    void: bool = True,
    max_bodies: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Scene:
    """The scene of an OpenMC geometry: a geometry.xml (with the materials.xml beside it) or a model.xml.

    A body for each place of each cell; docs/openmc.md says how.

    path: of the file.
    void: whether cells without material are invisible bodies, so that `scene.body_at` finds every cell.
    max_bodies: what expands into more is refused, before they are made; None for 4,000,000, of which 500,000 are no
        others moved, as those in lattices are.
    progress: progress(done, count) is called with numbers of bodies.

    `scene.notes` is what there is to say of the import. Those of the notes that tell what is not as the file says, or
    may not be meant, also go to the log, `logging.getLogger("conicoid")`, as warnings: Python shows them on stderr.
    `conicoid.io.openmc.read` gives the legend as well.

    Raises `SceneFileError`, a ValueError, that lists the mistakes with their lines; also for what is no quadric (tori,
    meshes) and for more than `max_bodies` bodies, before they are made.
    """
    from ..io import openmc

    check_flag("load_openmc", "void", void)
    check_callback("load_openmc", "progress", progress)
    max_bodies = None if max_bodies is None else check_integer("load_openmc", "max_bodies", max_bodies, 1)
    parts = openmc.read(checked_path("load_openmc", path), void=void, max_bodies=max_bodies, progress=progress)
    return _scene_of(path, parts)
