"""First hits in a .npz file: every field, the rays, and what bodies are called and made of. No scene, and no pickle."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np

from ..engine.answers.hits import Hits
from ..engine.answers.rays import Rays
from ..engine.arrays.found import Found
from ..engine.ray import DEAD
from ..shapes.body import Body
from ..shapes.disc import Disc
from ..shapes.labels import Labels
from ..shapes.sphere import Sphere
from .atomic import replacing
from .errors import SceneFileError
from .npy import NotPlain
from .npz import Archive
from .regular import open_regular
from .scene_file import Parts, parsed, scene_data
from .yaml_writer import json_text

_FLOATS = {"t": (), "t_error": (), "point_error": (), "point": (3,), "local_point": (3,), "normal": (3,), "uv": (2,)}
_INTS = {"body": np.int32, "face": np.int32, "surface": np.int32, "side": np.int32}
_FLAGS = ("hit", "entering", "doubtful")
_RAYS = ("origins", "directions", "starts", "starts_home")
_ABOUT = ("home", "first_bodies", "labels")
_ALL = (*_FLOATS, *_INTS, *_FLAGS, *_RAYS, *_ABOUT)
"""The arrays of such a file. Those of bytes hold a scene's key, and a scene file: a ball for a solid, else a disc."""


def write_hits_file(path: str | os.PathLike[str], hits: Hits) -> None:
    """Write hits, with or without their scene. The file appears whole or not at all; raises OSError."""
    kept = hits.detached()
    rays, labels = kept.rays, kept._labels
    arrays: dict[str, Any] = {name: getattr(kept, name) for name in (*_FLOATS, *_INTS) if name != "side"}
    arrays |= {name: np.asarray(getattr(kept, name), np.uint8) for name in _FLAGS}
    arrays["side"] = kept._faces[2].reshape(rays.shape)
    arrays |= {"origins": rays.origins, "directions": rays.directions, "starts": rays._starts}
    arrays |= {"starts_home": _bytes(rays._home or b""), "home": _bytes(kept._home), "first_bodies": labels.firsts}
    entries = zip(labels.solid, labels.materials, labels.names, strict=True)
    bodies = tuple(
        Body(Sphere() if solid else Disc((0, 0, 0), (0, 0, 1), 1), material, name) for solid, material, name in entries
    )
    arrays["labels"] = _bytes(json_text(scene_data(Parts(bodies), None)).encode())
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)


def read_hits_file(path: str | os.PathLike[str]) -> Hits:
    """Hits without their scene, as `hits.detached()`. Raises ValueError, naming the file, and OSError."""
    try:
        return _hits(_arrays(path), path)
    except SceneFileError as error:
        raise ValueError(f"{os.fspath(path)}: labels are damaged: {error.problems[0].message}") from None
    except (ValueError, IndexError, OverflowError) as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from None


def _arrays(path: str | os.PathLike[str]) -> dict[str, Any]:
    with open_regular(path) as file:
        try:
            archive = Archive(file, os.fstat(file.fileno()).st_size)
        except NotPlain as error:
            raise ValueError(f"is not a .npz file ({error})") from None
        missing = [name for name in _ALL if name not in archive.members]
        if missing:
            raise ValueError(f"is not a file of hits.save: it lacks {', '.join(missing[:5])}")
        return archive.arrays(_ALL)


def _hits(arrays: dict[str, Any], path: str | os.PathLike[str]) -> Hits:
    shape = arrays["t"].shape
    for name, last in {**_FLOATS, **dict.fromkeys((*_INTS, *_FLAGS), ()), "origins": (3,), "directions": (3,)}.items():
        if arrays[name].shape != (*shape, *last):
            raise ValueError(f"{name} must have shape {(*shape, *last)}, got {arrays[name].shape}")
    count = arrays["t"].size
    ints = {name: _whole(name, arrays[name], -1 if name != "side" else -2, 2**31 - 1, np.int32) for name in _INTS}
    flags = {name: _whole(name, arrays[name], 0, 1, np.bool_).ravel() for name in _FLAGS}
    starts = _whole("starts", arrays["starts"], -(2**31), 2**31 - 1, np.int32)
    if starts.shape not in ((1,), (count,)):
        raise ValueError(f"starts must have shape (1,) or ({count},), got {starts.shape}")
    alive = np.broadcast_to(starts, (count,)).reshape(shape) != DEAD
    Rays(arrays["origins"][alive], arrays["directions"][alive])  # refuses what cannot be traced
    home = _text("starts_home", arrays) or None
    rays = Rays._spawned(arrays["origins"], arrays["directions"], starts, home)
    nothing = np.zeros(count, np.int32)
    turn = np.where(flags["entering"], 2, 1).astype(np.int8)
    result = object.__new__(Hits)
    state = {
        "rays": rays,
        "_found": Found(arrays["t"].ravel(), ints["body"].ravel(), nothing, nothing, turn),
        "_doubtful": np.flatnonzero(flags["doubtful"]),
        "_faces": np.stack([ints[name].ravel() for name in ("surface", "face", "side")]),
        "_points": arrays["point"].reshape(-1, 3),
        "_errors": arrays["t_error"].ravel(),
        **{name: arrays[name][()] for name in ("point_error", "local_point", "normal", "uv")},
        "_home": _text("home", arrays),
        "_labels": _labels(arrays, ints["body"], path),
    }
    result.__setstate__(state)
    return result


def _labels(arrays: dict[str, Any], bodies: Any, path: str | os.PathLike[str]) -> Labels:
    entries = parsed(_text("labels", arrays).decode(), path).bodies
    firsts = _whole("first_bodies", arrays["first_bodies"], 0, 2**53, np.int64)
    if firsts.shape != (len(entries),) or (np.diff(firsts) <= 0).any():
        raise ValueError(f"first_bodies must be {len(entries)} rising numbers, got {firsts.shape}")
    if (bodies >= 0).any() and not (len(firsts) and firsts[0] <= bodies[bodies >= 0].min()):
        raise ValueError("first_bodies must not be above the numbers in body")
    return dataclasses.replace(Labels.of(entries), firsts=firsts)


def _whole(name: str, array: Any, least: int, most: int, kind: Any) -> Any:
    if not ((array == np.floor(array)) & (array >= least) & (array <= most)).all():
        raise ValueError(f"{name} must hold integers from {least} to {most}")
    return array.astype(kind)


def _bytes(content: bytes) -> Any:
    return np.frombuffer(content, np.uint8)


def _text(name: str, arrays: dict[str, Any]) -> bytes:
    content: bytes = _whole(name, arrays[name], 0, 255, np.uint8).tobytes()
    return content
