"""Frames in a folder, each named by all that its picture is made from, so that what is there can be taken."""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..cluster.course import Course, Piece, closing
from ..cluster.recipe import Recipe, recipe_of
from ..cluster.task import prepared_first
from ..formats.atomic import replacing
from ..render.picture import light_of, look_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ..cluster.workers import Workers
    from ..render.camera import AnyCamera
    from ..scene import Scene

_OF_THE_TREE = {"node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items"}


class Frames:
    """The frames of one scene and one set of options, in a folder that need not be there yet."""

    def __init__(self, scene: Scene, folder: Path, options: dict[str, Any]) -> None:
        from ..compiler.sources import source_hash

        self.scene, self.folder, self.options = scene, folder, options
        lowered = scene.lowered
        tables = {k: v for k, v in lowered.tables._asdict().items() if k not in _OF_THE_TREE}
        names = [body.name for body in scene.bodies] if options["labels"] else []
        parts = (source_hash(), sorted(options.items()), names, tables, lowered.rest, lowered.boxes, lowered.body_item)
        self._key = digest_of(*parts, *scene.extent)

    def path(self, camera: AnyCamera) -> Path:
        """Where the picture by a camera is, or is to be."""
        light = light_of(self.scene, camera, self.options["integrator"])
        light = look_of(self.scene, camera) if light is None else light
        key = digest_of(self._key, type(camera).__name__, camera, light)
        return self.folder / f"{key.hex()}.png"

    def is_there(self, path: Path) -> bool:
        """Whether a frame is whole, and of the right size."""
        from PIL import Image

        try:
            with Image.open(path) as file:
                file.verify()  # the checksums: the pixels of a file that is cut short may all be there
            with Image.open(path) as file:
                file.load()
                return file.format == "PNG" and file.size == (self.options["width"], self.options["height"])
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
            return False

    def render(self, path: Path, camera: AnyCamera, progress: Any) -> None:
        """Make a frame."""
        self._keep(path, self.scene.render(camera=camera, progress=progress, **self.options)._repr_png_())

    def render_on(self, workers: Workers, missing: Sequence[tuple[Path, Any]], told: Callable[[int], Any]) -> None:
        """Make several on workers, a frame a task; each is kept as it comes back, and told(done) is called.

        missing: the files, and what each frame is of: its camera (its time, where the scene moves).
        """
        pieces = (Piece(k, k + 1, (each,)) for k, (_, each) in enumerate(missing))
        with closing(self._course(workers).results(pieces, lambda *_: None, len(missing))) as results:
            for piece, content in results:
                self._keep(missing[piece.begin][0], content)
                told(piece.end)

    def _course(self, workers: Workers) -> Course:
        """Tasks that make a frame each."""
        return Course("turntable", workers, frame, (recipe_of(self.scene), Recipe(self.options)))

    def _keep(self, path: Path, content: bytes) -> None:
        self.folder.mkdir(exist_ok=True)
        with replacing(path) as part:
            part.write_bytes(content)


@prepared_first
def frame(scene: Scene, options: dict[str, Any], camera: AnyCamera) -> bytes:
    """A frame as the bytes of its file."""
    return scene.render(camera=camera, **options)._repr_png_()


def digest_of(*parts: Any) -> bytes:
    """One digest of all parts."""
    digest = blake2b(digest_size=16)
    for part in parts:
        _add(digest, part)
    return digest.digest()


def _add(digest: Any, part: Any) -> None:
    """Arrays by their bytes, tables field by field, the rest as Python shows it; each with what sets it off."""
    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype} {part.shape};".encode())
        digest.update(np.ascontiguousarray(part).view(np.uint8).data if part.size else b"")
    elif hasattr(part, "__dataclass_fields__"):
        _add(digest, [(name, getattr(part, name)) for name in part.__dataclass_fields__])
    elif isinstance(part, (tuple, list, dict)):
        items = list(part.items()) if isinstance(part, dict) else part
        digest.update(f"{type(part).__name__} {len(items)};".encode())
        for item in items:
            _add(digest, item)
    else:
        text = repr(part).encode()
        digest.update(b"%d;" % len(text) + text)
