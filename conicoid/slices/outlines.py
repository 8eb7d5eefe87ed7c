"""The walls of bodies in a slice: each curve cut to where it really bounds a body."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.certified.forms import form
from ..engine.queries.points import bodies_at
from ..shapes.vector import FloatArray
from .bodies import Bodies, boxes_overlap
from .conic import Conic, Unclear, conic_of
from .curve import Curve, gradient, value
from .outline import Outline
from .records import Records
from .window import Window

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..engine.prepared import Prepared
    from ..engine.threads import Progress

Floats6 = tuple[float, float, float, float, float, float]


class _Wall:
    """A curve with the surfaces that it is in, and the entries that these bound."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve
        self.surfaces: set[int] = set()
        self.owners: list[int] = []
        self.box = np.zeros(4)


class Cutter:
    """Finds the outlines of a scene in a window."""

    def __init__(self, scene: Prepared, window: Window) -> None:
        self.scene, self.window, self.bodies = scene, window, Bodies(scene)
        self.entries = self.bodies.cut_by(window)
        self._exact, self._records = window.exact(), Records(scene, window)
        users: dict[int, list[int]] = defaultdict(list)
        for entry in self.entries:
            for surface in sorted(self.bodies.faces(entry).surfaces):
                users[surface].append(entry)
        self.floats: dict[int, Floats6] = {}
        self.walls = self._walls(users)
        self.boxes = np.array([wall.box for wall in self.walls]).reshape(-1, 4)

    def _walls(self, users: dict[int, list[int]]) -> list[_Wall]:
        """Every curve once, however many surfaces it is in, as far as it may lie in the boxes of bodies."""
        boxes = {entry: self.bodies.place_box(entry, self.window) for entry in self.entries}
        found: dict[Any, _Wall] = {}
        for surface in sorted(users):
            conic, curves = self._cut(surface)
            self.floats[surface] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0) if conic.is_everywhere else conic.floats
            for curve in curves:
                wall = found.setdefault(curve.key, _Wall(curve))
                wall.surfaces.add(surface)
                wall.owners += [entry for entry in users[surface] if entry not in wall.owners]
        for wall in found.values():
            around = np.array([boxes[entry] for entry in wall.owners])
            own = wall.curve.box()
            wall.box[:2] = np.maximum(around[:, :2].min(axis=0), own[:2])
            wall.box[2:] = np.minimum(around[:, 2:].max(axis=0), own[2:])
        return [wall for wall in found.values() if (wall.box[:2] <= wall.box[2:]).all()]

    def _cut(self, surface: int) -> tuple[Conic, list[Curve]]:
        """A surface in the plane: by its record where that says enough, else as it was written."""
        try:
            conic = self._records.conic(surface)
            return conic, [] if conic.is_everywhere else conic.curves()
        except Unclear:
            conic = conic_of(form(self.scene, surface), self.window, self._exact)
            return conic, [] if conic.is_everywhere else conic.curves()

    def outlines(self, progress: Progress | None = None) -> list[Outline]:
        """All of them, in the order of the surfaces."""
        found: list[Outline] = []
        origin = np.array(self.window.origin)
        for k, wall in enumerate(self.walls):
            found += self._of_wall(wall)
            if progress is not None:
                progress(k + 1, len(self.walls))
        for one in found:
            one._origin = origin
        return found

    def _breaks(self, wall: _Wall) -> tuple[FloatArray, FloatArray]:
        """(parameters, points) in order, where a curve meets others or leaves the window."""
        across, up = self.window.size
        edges = [
            (0.0, 0.0, 0.0, 0.5 * x, 0.5 * y, -0.5 * size)
            for x, y, size in ((1, 0, across), (-1, 0, across), (0, 1, up), (0, -1, up))
        ]
        near = np.flatnonzero(boxes_overlap(wall.box, self.boxes)).tolist()
        others = [self.walls[k].curve.conic for k in near if self.walls[k] is not wall]
        parts = [wall.curve.crossings(np.array([*edges, *others]))]
        cuts = [self.bodies.edges_cut(entry, self.window) for entry in self._sheets_in(wall)]
        parts += [(wall.curve.parameter(places), places) for places in cuts if places is not None]
        t = np.concatenate([part[0] for part in parts])
        points = np.concatenate([part[1] for part in parts])
        order = np.argsort(t, kind="stable")
        return t[order], points[order]

    def _of_wall(self, wall: _Wall) -> list[Outline]:
        """The pieces of a curve that bound a body."""
        curve = wall.curve
        t, points = self._breaks(wall)
        if curve.closed:
            if not len(t):
                t, points = np.zeros(1), curve.points([0.0])
            t, points = np.append(t, t[0] + 2 * math.pi), np.concatenate([points, points[:1]])
        if len(t) < 2:
            return []
        middle = (t[1:] + t[:-1]) / 2
        places = curve.points(middle)
        half = np.array(self.window.size) / 2
        kept = (t[1:] > t[:-1]) & (np.abs(places) <= half).all(axis=1) & np.isfinite(places).all(axis=1)
        which = np.flatnonzero(kept)
        if not len(which):
            return []
        pieces = self._sides(wall, middle[which], places[which])
        return _joined(curve, sorted(wall.surfaces), t, points, which.tolist(), pieces)

    def _sides(self, wall: _Wall, t: FloatArray, places: FloatArray) -> list[Any]:
        """Of each piece by its middle: (bodies to the left, to the right, those it bounds), None if it bounds none."""
        curve, count = wall.curve, len(t)
        ahead = curve.velocity(t)
        left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        known: dict[int, Any] = {}

        def sign_of(surface: int) -> Any:
            if surface not in known:
                known[surface] = np.sign(value(self.floats[surface], places))
            return known[surface]

        def beside(turn: float) -> Callable[[int], Any]:
            def signs(surface: int) -> Any:
                if surface in wall.surfaces:
                    return turn * np.sign((gradient(self.floats[surface], places) * left).sum(axis=1))
                return sign_of(surface)

            return signs

        others = bodies_at(self.scene, self.window.in_space(places))
        numbers = {self.bodies.number(entry) for entry in wall.owners}
        around = [[int(body) for body in others[i] if int(body) not in numbers] for i in range(count)]
        found: list[Any] = []
        held = [self._held(wall, beside(turn), count) for turn in (1.0, -1.0)]
        sheets = self._sheets(wall, t, sign_of)
        for i in range(count):
            one, other = (sorted([*around[i], *(body for body, mask in side if mask[i])]) for side in held)
            bounded = sorted({*one} ^ {*other} | {body for body, mask in sheets if mask[i]})
            found.append((tuple(one), tuple(other), tuple(bounded)) if bounded else None)
        return found

    def _held(self, wall: _Wall, signs: Callable[[int], Any], count: int) -> list[tuple[int, Any]]:
        """(body, at which places it is there) of solids."""
        solid = [entry for entry in wall.owners if not self.bodies.is_sheet(entry)]
        return [(self.bodies.number(entry), self.bodies.holds(entry, signs, count)) for entry in solid]

    def _sheets_in(self, wall: _Wall) -> list[int]:
        """The sheets that a curve lies in."""
        return [
            entry
            for entry in wall.owners
            if self.bodies.is_sheet(entry) and self.bodies.faces(entry).cells[0][0][0] in wall.surfaces
        ]

    def _sheets(self, wall: _Wall, t: FloatArray, sign_of: Callable[[int], Any]) -> list[tuple[int, Any]]:
        """(body, at which places it is there) of sheets that the curve lies in; polygons by even and odd."""

        def signs(surface: int) -> Any:
            return np.zeros(len(t)) if surface in wall.surfaces else sign_of(surface)

        found = []
        for entry in self._sheets_in(wall):
            held, edges = self.bodies.holds(entry, signs, len(t)), self.bodies.edges_cut(entry, self.window)
            if edges is not None:
                held &= (wall.curve.parameter(edges)[None] < t[:, None]).sum(axis=1) % 2 == 1
            found.append((self.bodies.number(entry), held))
        return found


def _joined(
    curve: Curve, surfaces: list[int], t: FloatArray, points: FloatArray, which: list[int], pieces: list[Any]
) -> list[Outline]:
    """Outlines of pieces; neighbours with the same bodies on both sides are one."""
    runs: list[list[Any]] = []
    for k, sides in zip(which, pieces, strict=True):
        if sides is None:
            continue
        if runs and t[runs[-1][1]] == t[k] and runs[-1][2] == sides:
            runs[-1][1] = k + 1
        else:
            runs.append([k, k + 1, sides])
    last = len(t) - 1
    if curve.closed and len(runs) > 1 and runs[0][0] == 0 and runs[-1][1] == last and runs[0][2] == runs[-1][2]:
        runs[0][0] = runs.pop()[0]
    found = []
    for first, end, sides in runs:
        begin, stop = float(t[first]), float(t[end])
        stop += 2 * math.pi if stop <= begin else 0.0
        ends = points[first], points[end]
        found.append(Outline(curve, begin, stop, ends, tuple(surfaces), *sides))
    return found
