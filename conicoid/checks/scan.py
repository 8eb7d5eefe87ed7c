"""What rays see: stretches common to two bodies, and slivers between two surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.arrays.owners import owners
from ..shapes.vector import FloatArray

if TYPE_CHECKING:
    from ..scene import Scene

CHUNK = 1 << 14
THIN = 1e-9
"""Anything thinner than this part of a body's size is a sliver."""

_PARALLEL = 0.99
"""|cosine| of the angle between the walls of a sliver; at an edge, walls meet at a larger angle."""


@dataclass
class Sighting:
    """Bodies and surfaces seen together: how often, and the ray on which the stretch was longest, or thickest."""

    length: float
    origin: FloatArray
    direction: FloatArray
    what: str = ""
    times: int = 0


@dataclass
class Scan:
    """Collects what rays through a scene see. `overlaps` by pair of bodies, `slivers` by bodies and surfaces."""

    scene: Scene
    sizes: FloatArray
    seen: Any  # (bodies,) bool: some ray meets it
    overlaps: dict[tuple[int, int], Sighting] = field(default_factory=dict)
    slivers: dict[tuple[int, int, int, int], Sighting] = field(default_factory=dict)
    rays: int = 0

    def follow(self, origins: FloatArray, directions: FloatArray) -> None:
        """Send rays of unit direction."""
        for begin in range(0, len(origins), CHUNK):
            o, d = origins[begin : begin + CHUNK], directions[begin : begin + CHUNK]
            self._spans(o, d)
            self._crossings(o, d)
            self.rays += len(o)

    def _spans(self, origins: FloatArray, directions: FloatArray) -> None:
        spans = self.scene.spans(origins, directions)
        self.seen[spans.body] = True
        ray = owners(spans.offsets)
        # Rays along an axis may run within a sliver from end to end
        askew = np.count_nonzero(directions, axis=1) > 1
        first = np.flatnonzero(askew[ray])
        # In order of t_enter, those that overlap a span follow it without a gap
        for apart in range(1, len(ray)):
            first = first[first + apart < len(ray)]
            other = first + apart
            first = first[(ray[first] == ray[other]) & (spans.t_enter[other] < spans.t_exit[first])]
            if not len(first):
                return
            other = first + apart
            length = np.minimum(spans.t_exit[first], spans.t_exit[other]) - spans.t_enter[other]
            bodies = np.sort(np.column_stack([spans.body[first], spans.body[other]]), axis=1)
            there = length > 0
            for key, length_, k, times in _longest(bodies[there], length[there], ray[first][there]):
                _note(self.overlaps, (key[0], key[1]), Sighting(length_, origins[k], directions[k], "overlap", times))

    def _crossings(self, origins: FloatArray, directions: FloatArray) -> None:
        found = self.scene.crossings(origins, directions)
        self.seen[found.body] = True
        ray = owners(found.offsets)
        one, other = np.arange(len(ray) - 1), np.arange(1, len(ray))
        apart = found.t[other] - found.t[one]
        thin = THIN * np.minimum(self.sizes[found.body[one]], self.sizes[found.body[other]])
        thin = (ray[one] == ray[other]) & (apart > 0) & (apart < thin) & (found.surface[one] != found.surface[other])
        one, other, apart = one[thin], other[thin], apart[thin]
        normals = [
            self._normals(found, k, origins[ray[k]] + found.t[k, None] * directions[ray[k]]) for k in (one, other)
        ]
        thin = np.abs((normals[0] * normals[1]).sum(axis=1)) > _PARALLEL
        apart = apart * np.abs((normals[0] * directions[ray[one]]).sum(axis=1))
        one, other, apart = one[thin], other[thin], apart[thin]
        keys = np.column_stack([found.body[one], found.body[other], found.surface[one], found.surface[other]])
        turned = (keys[:, 2] > keys[:, 3])[:, None]
        keys = np.where(turned, keys[:, (1, 0, 3, 2)], keys)
        for key, length, k, times in _longest(keys, apart, np.arange(len(apart))):
            what = _between(
                found.body[one[k]] == found.body[other[k]], found.entering[one[k]], found.entering[other[k]]
            )
            at = ray[one[k]]
            _note(
                self.slivers,
                (key[0], key[1], key[2], key[3]),
                Sighting(length, origins[at], directions[at], what, times),
            )

    def _normals(self, found: Any, rows: Any, points: FloatArray) -> FloatArray:
        from ..engine.answers.fields import normals_of

        normals = np.empty_like(points)
        faces = np.stack([found.surface[rows], found.face[rows], np.ones_like(found.face[rows])])
        normals_of(self.scene.geometry, faces, points, 0, len(points), normals)
        return normals


def _between(same_body: bool, first_enters: bool, second_enters: bool) -> str:
    """What lies between two walls next to each other on a ray."""
    if same_body:
        return "film" if first_enters else "gap"
    if first_enters == second_enters:
        return "step"
    return "overlap" if first_enters else "gap"


def _longest(keys: Any, lengths: FloatArray, places: Any) -> Iterator[tuple[Any, float, int, int]]:
    """(key, longest, its place, how many) for every different row of keys."""
    if not len(keys):
        return
    order = np.lexsort((-lengths, *keys.T[::-1]))
    keys = keys[order]
    heads = np.flatnonzero(np.concatenate([[True], (keys[1:] != keys[:-1]).any(axis=1)]))
    counts = np.diff([*heads, len(keys)])
    for head, count in zip(heads.tolist(), counts.tolist(), strict=True):
        yield tuple(keys[head].tolist()), float(lengths[order[head]]), int(places[order[head]]), count


def _note(table: dict[Any, Sighting], key: Any, sighting: Sighting) -> None:
    known = table.get(key)
    if known is None:
        table[key] = sighting
        return
    sighting.times += known.times
    if known.length >= sighting.length:
        known.times = sighting.times
    else:
        table[key] = sighting
