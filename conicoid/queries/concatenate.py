"""Hits, spans, crossings or distances of several questions as one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..geometry.labels import Labels
from ..kernels.entry.first_hits import HitBuffers
from .distances import Distances, Nearest
from .hits import Hits
from .rays import Rays
from .result import NO_SCENE, check_parts

_HIT_ROWS = ("point_error", "local_point", "normal", "uv", "before", "after")
"""What is worked out, an array shaped like the rays each."""


def concatenate_hits(parts: Any) -> Hits:
    """Hits one after the other along the first axis (see `Hits.concatenate`)."""
    given = check_parts(Hits, parts)
    if not given:
        raise ValueError("Hits: parts must hold at least one Hits, got none")
    try:
        rays = Rays.concatenate(part.rays for part in given)
    except ValueError as error:
        raise ValueError(str(error).replace("Rays:", "Hits:", 1)) from None
    found = HitBuffers(*(np.concatenate(columns) for columns in zip(*(part._found for part in given), strict=True)))
    firsts = np.cumsum([0, *(len(part._found.t) for part in given)])
    doubtful = np.concatenate([first + part._doubtful for first, part in zip(firsts, given, strict=False)])
    scene = given[0]._scene
    if scene is not NO_SCENE and all(part._scene is scene for part in given):
        return Hits(scene, rays, found, doubtful)
    return _concatenate_detached_hits([part.detached() for part in given], rays, found, doubtful)


def concatenate_lists(kind: Any, parts: Any) -> Any:
    """Spans or crossings of one ray after the other (see `ByRay.concatenate`)."""
    name = kind.__name__
    given = check_parts(kind, parts)
    if not given:
        raise ValueError(f"{name}: parts must hold at least one {name}, got none")
    try:
        rays = Rays.concatenate(part._rays for part in given)
    except ValueError as error:
        raise ValueError(str(error).replace("Rays:", f"{name}:", 1)) from None
    is_one = given[0]._scene is not NO_SCENE and all(part._scene is given[0]._scene for part in given)
    rows = given if is_one else [part.detached() for part in given]
    counts = np.concatenate([np.diff(part.offsets) for part in rows])
    state = {"_rays": rays, "offsets": np.concatenate([[0], np.cumsum(counts)]).astype(rows[0].offsets.dtype)}
    columns = kind._columns if is_one else [n for n, v in vars(rows[0]).items() if isinstance(v, np.ndarray)]
    for column in columns:
        if column not in state:
            axis = -1 if column in kind._columns else 0
            state[column] = np.concatenate([getattr(part, column) for part in rows], axis=axis)
    result = object.__new__(kind)
    result.__setstate__({**vars(rows[0]), **state} if not is_one else state | _counts(rows[0]))
    if is_one:
        vars(result)["_scene"] = given[0]._scene
    else:
        vars(result).update(_common_scene_state(rows, name))
    return result


def concatenate_distances(parts: Any) -> Distances:
    """Distances one after the other along the first axis (see `Distances.concatenate`)."""
    given = check_parts(Distances, parts)
    if not given:
        raise ValueError("Distances: parts must hold at least one Distances, got none")
    shapes = [part.points.shape if part.shape else (1, 3) for part in given]
    if len({shape[1:] for shape in shapes}) > 1:
        raise ValueError(f"Distances: parts must have one shape but for the first axis, got {shapes[:4]}")
    points = np.concatenate([part.points.reshape(shape) for part, shape in zip(given, shapes, strict=True)])
    found = Nearest(*(np.concatenate(columns) for columns in zip(*(part._found for part in given), strict=True)))
    scene = given[0]._scene
    if scene is not NO_SCENE and all(part._scene is scene for part in given):
        return Distances(scene, points, found)
    rows = [part.detached() for part in given]
    state: dict[str, Any] = {"points": points, "_found": found, "_home": rows[0]._home}
    state |= _common_scene_state(rows, "Distances")
    state["_faces"] = np.concatenate([part._faces for part in rows], axis=1)
    state["_normals"] = np.concatenate([part._normals for part in rows])
    result = object.__new__(Distances)
    result.__setstate__(state)
    return result


def _counts(part: Any) -> dict[str, Any]:
    return {"_body_count": part._body_count} if hasattr(part, "_body_count") else {}


def _common_scene_state(parts: Sequence[Any], name: str) -> dict[str, Any]:
    """What detached lists know of their scene; a ValueError where it is not the same."""
    for i, part in enumerate(parts):
        if part._home != parts[0]._home or getattr(part, "_distinct", ()) != getattr(parts[0], "_distinct", ()):
            raise ValueError(f"{name}: parts must be of one scene, got parts[0] and parts[{i}] of different ones")
    return {"_labels": _merge_labels([part._labels for part in parts], name)}


def _concatenate_detached_hits(parts: Sequence[Hits], rays: Rays, found: HitBuffers, doubtful: Any) -> Hits:
    for i, part in enumerate(parts):
        if part._home != parts[0]._home:
            raise ValueError(f"Hits: parts must be of one scene, got parts[0] and parts[{i}] of different ones")
    state: dict[str, Any] = {"rays": rays, "_found": found, "_doubtful": doubtful, "_home": parts[0]._home}
    state["_labels"] = _merge_labels([part._labels for part in parts])
    state["_faces"] = np.concatenate([part._faces for part in parts], axis=1)
    state["_points"] = np.concatenate([part._points for part in parts])
    state["_errors"] = np.concatenate([part._errors for part in parts])
    for name in _HIT_ROWS:
        arrays = [np.asarray(getattr(part, name)) for part in parts]
        rows = [array if part.rays.shape else array[None] for part, array in zip(parts, arrays, strict=True)]
        state[name] = np.concatenate(rows)
    result = object.__new__(Hits)
    result.__setstate__(state)
    return result


def _merge_labels(labels: Sequence[Labels], owner: str = "Hits") -> Labels:
    """The entries of all, each once; a ValueError where they call one differently."""
    known: dict[int, tuple[Any, ...]] = {}
    for some in labels:
        for first, *said in zip(some.firsts.tolist(), some.names, some.materials, some.solid, strict=True):
            if known.setdefault(first, tuple(said)) != tuple(said):
                raise ValueError(f"{owner}: parts must be of one scene, got two names or materials of body {first}")
    firsts = sorted(known)
    names, materials, solid = ([known[first][k] for first in firsts] for k in range(3))
    return Labels(np.array(firsts, np.int64), tuple(names), tuple(materials), tuple(solid))
