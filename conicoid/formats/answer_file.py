"""What the .npz files of rays and answers have in common: rays, and what bodies are called and made of. No pickles."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from ..engine.answers.rays import Rays
from ..engine.ray import DEAD
from ..shapes.body import Body
from ..shapes.disc import Disc
from ..shapes.labels import Labels
from ..shapes.sphere import Sphere
from ..shapes.validate import listed, shown
from .atomic import replacing
from .errors import SceneFileError, printable
from .npy import NotPlain
from .npz import Archive
from .ray_file import read_rays
from .regular import open_regular
from .scene_file import Parts, parsed, scene_data
from .yaml_writer import json_text

RAYS = ("origins", "directions", "starts", "starts_home")
LABELS = ("first_bodies", "labels")
"""`labels` holds the bytes of a scene file: a ball stands for a solid, else a disc."""
Arrays = dict[str, Any]


def write_arrays(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """A .npz file, whole or not at all. Raises OSError."""
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)


def read_arrays(
    path: str | os.PathLike[str], wanted: Collection[str], needed: Collection[str], what: str,
    flags: Collection[str] = (),
) -> Arrays:  # fmt: skip
    """The wanted arrays, of which some must be there; flags may be truth values. ValueError: not a file of `what`."""
    with open_regular(path) as file:
        try:
            archive = Archive(file, os.fstat(file.fileno()).st_size)
        except NotPlain as error:
            raise ValueError(f"is not a .npz file ({error})") from None
        missing = [name for name in needed if name not in archive.members]
        if missing:
            there = [printable(name) for name in archive.members]
            lacks = f"it lacks {', '.join(missing[:5])} and holds {listed(there, 5)}"
            raise ValueError(f"is not a file of {what}: {lacks}{_reader_of(archive.members, what)}")
        others = [printable(name) for name in archive.members if name not in wanted]
        if others:
            told = f"it also holds {listed(others, 5)}{_reader_of(archive.members, what)}"
            raise ValueError(f"is not a file of {what}: {told}")
        return dict(archive.arrays(wanted, flags))


_MARKS = {"crossings": ("offsets", "point"), "spans": ("offsets", "ends"), "hits": ("t", "local_point")}


def _reader_of(members: Collection[str], what: str) -> str:
    """What reads a file that holds such arrays, if it is known and not `what`, for a message."""
    for kind, marks in _MARKS.items():
        if set(marks) <= set(members):
            return f"; co.{kind.capitalize()}.load reads it" if what != f"{kind}.save" else ""
    if {"origins", "directions"} <= set(members):
        intervals = "; rays have no intervals: numpy.load reads them, and first_hit(rays, t_min=...) takes them"
        return intervals if what == "rays.save" else "; co.Rays.load reads it"
    return "; numpy.load reads any .npz file"


@contextlib.contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """What is wrong in a file, as a ValueError that names it."""
    try:
        yield
    except SceneFileError as error:
        raise ValueError(f"{os.fspath(path)}: labels are damaged: {error.problems[0].message}") from None
    except (ValueError, IndexError, OverflowError) as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from None


def write_rays_file(path: str | os.PathLike[str], rays: Rays) -> None:
    """Write rays with the surfaces that they start on."""
    write_arrays(path, arrays_of_rays(rays))


def read_rays_file(path: str | os.PathLike[str]) -> Rays:
    """Rays with the surfaces that they start on, if the file knows them. Raises ValueError, naming it, and OSError."""
    suffix = os.path.splitext(path)[1].lower()
    if suffix in (".npy", ".csv"):
        table = read_rays(path)
        with naming(path):
            return Rays(table.origins, table.directions)
    if suffix != ".npz":
        raise ValueError(f"load: path of rays must end with .npz, .npy or .csv, got {shown(os.fspath(path))}")
    with naming(path):
        arrays = read_arrays(path, RAYS, RAYS[:2], "rays.save")
        if "starts" in arrays:
            return rays_in(arrays)
        return Rays(arrays["origins"], arrays["directions"])


def arrays_of_rays(rays: Rays) -> Arrays:
    home = bytes_array(rays._home or b"")
    return {"origins": rays.origins, "directions": rays.directions, "starts": rays._starts, "starts_home": home}


def rays_in(arrays: Arrays) -> Rays:
    """Those of a file's arrays; ValueError for what cannot be traced."""
    origins, directions = arrays["origins"], arrays["directions"]
    for name, array in (("origins", origins), ("directions", directions)):
        if array.ndim == 0 or array.shape != origins.shape or array.shape[-1] != 3:
            raise ValueError(f"{name} must have shape {(*origins.shape[:-1], 3)}, got {array.shape}")
    shape, count = origins.shape[:-1], origins.size // 3
    starts = whole_array("starts", arrays["starts"], -(2**31), 2**31 - 1, np.int32)
    if starts.shape not in ((1,), (count,)):
        raise ValueError(f"starts must have shape (1,) or ({count},), got {starts.shape}")
    alive = np.broadcast_to(starts, (count,)).reshape(shape) != DEAD
    Rays(origins[alive], directions[alive])  # refuses what cannot be traced
    home = text_in("starts_home", arrays) if "starts_home" in arrays else b""
    return Rays._spawned(origins, directions, starts, home or None)


def arrays_of_labels(labels: Labels) -> Arrays:
    entries = zip(labels.solid, labels.materials, labels.names, strict=True)
    return {"first_bodies": labels.firsts, "labels": bodies_array(entries)}


def bodies_array(entries: Any) -> Any:
    """(is it solid, material, name) of some entries, as the bytes of a scene file."""
    bodies = tuple(
        Body(Sphere() if solid else Disc((0, 0, 0), (0, 0, 1), 1), material, name) for solid, material, name in entries
    )
    return bytes_array(json_text(scene_data(Parts(bodies), None)).encode())


def bodies_in(name: str, arrays: Arrays, path: str | os.PathLike[str]) -> Sequence[Body]:
    """What `bodies_array` has written."""
    return parsed(text_in(name, arrays).decode(), path).bodies


def labels_in(arrays: Arrays, bodies: Any, path: str | os.PathLike[str]) -> Labels:
    """The labels of a file, which cover the numbers of `bodies`."""
    entries = bodies_in("labels", arrays, path)
    firsts = whole_array("first_bodies", arrays["first_bodies"], 0, 2**53, np.int64)
    if firsts.shape != (len(entries),) or (np.diff(firsts) <= 0).any():
        raise ValueError(f"first_bodies must be {len(entries)} rising numbers, got {firsts.shape}")
    if (bodies >= 0).any() and not (len(firsts) and firsts[0] <= bodies[bodies >= 0].min()):
        raise ValueError("first_bodies must not be above the numbers in body")
    return dataclasses.replace(Labels.of(entries), firsts=firsts)


def check_shapes(arrays: Arrays, shape: tuple[int, ...], lasts: dict[str, tuple[int, ...]]) -> None:
    """ValueError for arrays of another shape than the common one and what follows it."""
    for name, last in lasts.items():
        if arrays[name].shape != (*shape, *last):
            raise ValueError(f"{name} must have shape {(*shape, *last)}, got {arrays[name].shape}")


def whole_array(name: str, array: Any, least: int, most: int, kind: Any) -> Any:
    """Numbers of a file as integers of a kind; ValueError for others."""
    if not ((array == np.floor(array)) & (array >= least) & (array <= most)).all():
        raise ValueError(f"{name} must hold integers from {least} to {most}")
    return array.astype(kind)


def bytes_array(content: bytes) -> Any:
    return np.frombuffer(content, np.uint8)


def text_in(name: str, arrays: Arrays) -> bytes:
    content: bytes = whole_array(name, arrays[name], 0, 255, np.uint8).tobytes()
    return content
