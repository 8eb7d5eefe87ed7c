"""First hits in a .npz file: every field, the rays, and what bodies are called and made of. No scene, and no pickle."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..engine.answers.hits import Hits
from ..engine.answers.rays import Rays
from ..engine.arrays.found import Found
from ..shapes.labels import Labels
from .answer_file import (
    LABELS,
    RAYS,
    arrays_of_labels,
    arrays_of_rays,
    bytes_array,
    check_shapes,
    labels_in,
    naming,
    rays_in,
    read_arrays,
    text_in,
    whole_array,
    write_arrays,
)  # fmt: skip

_FLOATS = {"t": (), "t_error": (), "point_error": (), "point": (3,), "local_point": (3,), "normal": (3,), "uv": (2,)}
_INTS = dict.fromkeys(("body", "face", "surface", "before", "after", "side"), np.int32)
_FLAGS = ("hit", "entering", "doubtful")
_ALL = (*_FLOATS, *_INTS, *_FLAGS, *RAYS, "home", *LABELS)
"""The arrays of such a file. `home` holds the bytes of a scene's key."""


ROWS = tuple(name for name in _ALL if name not in ("home", "starts_home", *LABELS))
"""Those that have an item for each ray."""


def write_hits_file(path: str | os.PathLike[str], hits: Hits) -> None:
    """Write hits, with or without their scene. The file appears whole or not at all; raises OSError."""
    kept = hits.detached()
    write_arrays(path, rows_of(kept) | heads_of(kept.rays, kept._home, kept._labels))


def rows_of(hits: Hits) -> dict[str, Any]:
    """The arrays that have an item for each ray; `starts` is flat, and one item where all have the same."""
    rays = arrays_of_rays(hits.rays)
    arrays: dict[str, Any] = {name: getattr(hits, name) for name in (*_FLOATS, *_INTS, *_FLAGS) if name != "side"}
    arrays["side"] = hits._faces[2].reshape(hits.rays.shape)
    return arrays | {name: rays[name] for name in ROWS if name in rays}


def heads_of(rays: Rays, home: bytes, labels: Labels) -> dict[str, Any]:
    """The other arrays: whose surfaces rays start on, whose are hit, and what bodies are called."""
    return {"starts_home": arrays_of_rays(rays)["starts_home"], "home": bytes_array(home)} | arrays_of_labels(labels)


def read_hits_file(path: str | os.PathLike[str]) -> Hits:
    """Hits without their scene, as `hits.detached()`. Raises ValueError, naming the file, and OSError."""
    with naming(path):
        return _hits(read_arrays(path, _ALL, _ALL, "hits.save", _FLAGS), path)


def _hits(arrays: dict[str, Any], path: str | os.PathLike[str]) -> Hits:
    shape = arrays["t"].shape
    check_shapes(arrays, shape, {**_FLOATS, **dict.fromkeys((*_INTS, *_FLAGS), ()), "origins": (3,)})
    ints = {name: whole_array(name, arrays[name], -1 if name != "side" else -2, 2**31 - 1, np.int32) for name in _INTS}
    flags = {name: whole_array(name, arrays[name], 0, 1, np.bool_).ravel() for name in _FLAGS}
    nothing = np.zeros(arrays["t"].size, np.int32)
    turn = np.where(flags["entering"], 2, 1).astype(np.int8)
    state = {
        "rays": rays_in(arrays),
        "_found": Found(arrays["t"].ravel(), ints["body"].ravel(), nothing, nothing, turn),
        "_doubtful": np.flatnonzero(flags["doubtful"]),
        "_faces": np.stack([ints[name].ravel() for name in ("surface", "face", "side")]),
        "_points": arrays["point"].reshape(-1, 3),
        "_errors": arrays["t_error"].ravel(),
        **{name: arrays[name][()] for name in ("point_error", "local_point", "normal", "uv")},
        **{name: ints[name][()] for name in ("before", "after")},
        "_home": text_in("home", arrays),
        "_labels": labels_in(arrays, ints["body"], path),
    }
    result = object.__new__(Hits)
    result.__setstate__(state)
    return result
