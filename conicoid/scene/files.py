"""Load scenes from scene files and from files of other programs, and save them."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .._util.records import ignore_fp_errors
from .._util.validation import check_callback, check_flag, check_integer, check_path as checked_path
from ..geometry.body import Body
from ..geometry.shape import Shape
from ..io.scene_file import scene_file
from .scene import Scene, as_scene

if TYPE_CHECKING:
    from ..io.importers import ImportResult

_MOST_LOGGED_NOTES = 12
"""The largest number of remarks of one import in the log."""


@ignore_fp_errors
def load(
    path: str | os.PathLike[str],
    *,
    progress: Callable[[int, int], Any] | None = None,
    outside: bool = False,
    **options: Any,
) -> Scene:
    """Return the scene in a file: YAML or JSON (docs/files.md), or a file of another program (docs/importing.md).

    The content of the file decides its format, not its name. Nothing in a file is executed.

    Parameters
    ----------
    path : path
        The file.
    progress : callable, optional
        progress(done, count) is called from time to time, with shares of the work or numbers of bodies.
    outside : bool
        Allow pictures of textures outside of the folder of the file. Otherwise they are an error.
    **options
        For files of other programs, those of `conicoid.io.importers.ImportOptions`: void, max_bodies, strict, only,
        depth, smooth, entities, root, glasses.

    Returns
    -------
    Scene
        `scene.notes` has the remarks of an import. Remarks about differences from the file also go to the log,
        `logging.getLogger("conicoid")`, as warnings.

    Raises
    ------
    SceneFileError
        A ValueError that lists every mistake with its line, the object, the field, what was expected and what was
        found. For a missing file it is a FileNotFoundError as well.
    TypeError
        For `options` with a scene file.
    """
    from .._util.process import pause_gc
    from ..io.importers import ImportOptions, detect_format

    importer = detect_format(checked_path("load", path))
    if importer is None:  # a scene file, which has no options
        if options:
            raise TypeError(f"load: {', '.join(options)} are for files of other programs, which {path} is not")
        return Scene.load(path, progress=progress, outside=outside)
    check_flag("load", "outside", outside)
    with pause_gc():
        return _scene_of(path, importer.read(path, ImportOptions.of(progress=progress, **options)))


def _scene_of(path: str | os.PathLike[str], parts: ImportResult) -> Scene:
    """Return the scene of imported parts, with its notes, and log the remarks."""
    scene = Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain, unit=parts.unit)
    scene._notes = parts.notes  # no argument of `Scene`: scene files do not keep them
    if parts.remarks:
        import logging

        more = (
            []
            if len(parts.remarks) <= _MOST_LOGGED_NOTES
            else [f"... and {len(parts.remarks) - _MOST_LOGGED_NOTES:,} more in scene.notes"]
        )
        message = "\n".join(f"{os.fspath(path)}: {note}" for note in [*parts.remarks[:_MOST_LOGGED_NOTES], *more])
        logging.getLogger("conicoid").warning("%s", message)
    return scene


@ignore_fp_errors
def save(scene: Scene | Shape | Body, path: str | os.PathLike[str]) -> None:
    """Write a scene file that `load` reads as an equal scene: YAML, or JSON if `path` ends with .json.

    More than 100 balls of a `Spheres` go to a .npy file beside it, named by its content and never overwritten. Files
    appear whole or not at all, the scene last.

    Parameters
    ----------
    scene : Scene, Shape or Body
        One shape or body is saved as the scene of it.
    path : path
        The file to write.

    Raises
    ------
    OSError
        If a file cannot be written.
    ValueError
        For parts that a scene file cannot hold.
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
    """Return the scene of an OpenMC geometry, with a body for each place of each cell; docs/openmc.md describes how.

    `conicoid.io.openmc.read` returns the legend as well.

    Parameters
    ----------
    path : path
        A geometry.xml, with its materials.xml beside it, or a model.xml.
    void : bool
        Cells without material become invisible bodies, so that `scene.body_at` finds every cell.
    max_bodies : int, optional
        The largest number of bodies; a model that expands into more is refused before they are made. None allows
        4,000,000, of them 500,000 that are no moved copies of others, as those in lattices are.
    progress : callable, optional
        progress(done, count) is called with numbers of bodies.

    Returns
    -------
    Scene
        `scene.notes` has the remarks of the import. Those about differences from the file, or about what may not be
        meant, also go to the log, `logging.getLogger("conicoid")`, as warnings: Python shows them on stderr.

    Raises
    ------
    SceneFileError
        A ValueError that lists the mistakes with their lines; also for surfaces that are no quadrics (tori, meshes) and
        for more than `max_bodies` bodies.
    """
    from ..io import openmc

    check_flag("load_openmc", "void", void)
    check_callback("load_openmc", "progress", progress)
    max_bodies = None if max_bodies is None else check_integer("load_openmc", "max_bodies", max_bodies, 1)
    parts = openmc.read(checked_path("load_openmc", path), void=void, max_bodies=max_bodies, progress=progress)
    return _scene_of(path, parts)
