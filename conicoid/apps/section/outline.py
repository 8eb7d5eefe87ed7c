"""A piece of a wall in a slice: a line, or a part of an ellipse, a parabola or a hyperbola."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray
from ..._util.hints import with_method_hints
from ..._util.validation import as_integer, format_value
from ...kernels.faces import cell_faces, plane_faces, sides_of
from ...kernels.programs import cells_of_leaves, gates_of_program, leaves_of_program, row_of_leaf
from ...kernels.tables import BALL, CELL, POLYGON, REGION, SHEET
from ...queries.exact.surface_forms import exact_form
from ...queries.points import bodies_at
from .conic import PlaneConic, RecordConics, UnclearConicError, cut_conic
from .curve import Curve, Ellipse, form_gradient, form_value
from .window import Window

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...kernels.threads import Progress
    from ...prepare.prepared_scene import PreparedScene


_DEEPEST = 12


@with_method_hints
class Outline:
    """A piece of the curve in which a plane cuts a wall. Places are in lengths along u and v, as `Slice.extent`.

    kind       "line", "ellipse", "parabola" or "hyperbola"
    surfaces   the surfaces it lies in, as `hits.surface` has them: several where walls coincide
    left, right   bodies on both sides of it, looking from start to end, the first listed first
    bodies     those whose boundary it is
    start, end   its ends, where the wall meets others: equal for a whole ellipse
    curve, begin, stop, ends   what it is made from, by `Slice.outlines`
    center, radii, angle   of an ellipse: its half-axes, and the direction of the first in degrees; None for others
    """

    def __init__(
        self, curve: Curve, begin: float, stop: float, ends: tuple[FloatArray, FloatArray], surfaces: tuple[int, ...],
        left: tuple[int, ...], right: tuple[int, ...], bodies: tuple[int, ...],
    ) -> None:  # fmt: skip
        self._curve, self._begin, self._stop, self._ends = curve, begin, stop, ends
        self._origin = np.zeros(2)
        self.kind, self.surfaces = curve.kind, surfaces
        self.left, self.right, self.bodies = left, right, bodies

    @property
    def start(self) -> FloatArray:
        """Where it begins, (2,)."""
        place: FloatArray = self._ends[0] + self._origin
        return place

    @property
    def end(self) -> FloatArray:
        """Where it ends, (2,)."""
        place: FloatArray = self._ends[1] + self._origin
        return place

    @property
    def is_closed(self) -> bool:
        """Is it a whole ellipse?"""
        return self._curve.closed and self._stop - self._begin > 2 * math.pi * (1 - 1e-15)

    @property
    def center(self) -> FloatArray | None:
        """Of an ellipse, (2,)."""
        return np.array(self._curve.center) + self._origin if isinstance(self._curve, Ellipse) else None

    @property
    def radii(self) -> tuple[float, float] | None:
        """Half-axes of an ellipse."""
        return self._curve.radii if isinstance(self._curve, Ellipse) else None

    @property
    def angle(self) -> float | None:
        """Direction of the first half-axis of an ellipse, in degrees from that of u."""
        if not isinstance(self._curve, Ellipse):
            return None
        return math.degrees(math.atan2(self._curve.axis[1], self._curve.axis[0]))

    def points(self, count: int = 33) -> FloatArray:
        """Places (count, 2) along it, from end to end, each on the wall to rounding.

        count: at least 2.
        """
        number = as_integer(count)
        if number is None or number < 2:
            raise ValueError(f"Outline: count must be a whole number from 2 on, got {format_value(count)}")
        places: FloatArray = self._about(np.linspace(self._begin, self._stop, number)) + self._origin
        return places

    def _about(self, t: Any) -> FloatArray:
        """Places about the middle of the window; the ends are where they were found to be."""
        places = self._curve.points(t)
        places[t == self._begin], places[t == self._stop] = self._ends
        return places

    def distance(self, places: Any) -> Any:
        """How far places (..., 2) are from the whole curve, to first order: for tests of places that are near to it.

        places: numbers as `extent` has them.
        """
        about = np.asarray(places, float) - self._origin
        slope = np.linalg.norm(2 * form_gradient(self._curve.conic, about), axis=-1)
        return np.abs(form_value(self._curve.conic, about)) / slope

    def _cubics(self, off: float) -> FloatArray:
        """(pieces, 4, 2): cubic Béziers about the middle of the window, at most `off` from the curve.

        Lines and parabolas are cubics. Of the others each piece is tested at sixteen places, and halved until it fits.
        """
        turn = math.pi / 4 if self.kind == "ellipse" else 1.0
        pieces = 1 if self.kind in ("line", "parabola") else max(1, math.ceil((self._stop - self._begin) / turn))
        for _ in range(_DEEPEST):
            cubics = self._with(pieces)
            if self.kind in ("line", "parabola") or self._off(cubics) <= off:
                break
            pieces *= 2
        return cubics

    def _with(self, pieces: int) -> FloatArray:
        """Béziers that touch the curve at their ends, its middle too: k = 4/3 tan(h/4) of the slope by the angle."""
        t = np.linspace(self._begin, self._stop, pieces + 1)
        places, slopes, h = self._about(t), self._curve.velocity(t), (self._stop - self._begin) / pieces
        k = {"ellipse": 4 / 3 * math.tan(h / 4), "hyperbola": 4 / 3 * math.tanh(h / 4)}.get(self.kind, h / 3)
        first, last = places[:-1] + k * slopes[:-1], places[1:] - k * slopes[1:]
        if self.kind == "line":
            first, last = (2 * places[:-1] + places[1:]) / 3, (places[:-1] + 2 * places[1:]) / 3
        cubics: FloatArray = np.stack([places[:-1], first, last, places[1:]], axis=1)
        return cubics

    def _off(self, cubics: FloatArray) -> float:
        """By how much Béziers leave the curve, at places along them."""
        t = np.linspace(0, 1, 17)[1:-1]
        basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        places = np.einsum("kt,nkx->ntx", basis, cubics)
        return float(self.distance(places + self._origin).max())

    def __repr__(self) -> str:
        (a, b), (c, d) = self.start.tolist(), self.end.tolist()
        way = "whole" if self.is_closed else f"({a:.6g}, {b:.6g}) to ({c:.6g}, {d:.6g})"
        return f"Outline({self.kind}, {way}, left={self.left}, right={self.right})"


# What bodies are made of, as the tables of a prepared scene say it: which a window may cut, and what holds a place.

Signs = Callable[[int], Any]
"""The sign of a surface, -1, 0 or 1, at each of some places."""
Mask = npt.NDArray[np.bool_]
_WIDER = 1e-9


@dataclass(frozen=True)
class WindowFaces:
    """The surfaces of an entry, and for each of its cells those that bound it, with the side that is inside."""

    cells: tuple[tuple[tuple[int, int], ...], ...]

    @property
    def surfaces(self) -> set[int]:
        """All of them."""
        return {surface for cell in self.cells for surface, _ in cell}


class WindowBodies:
    """The entries of a scene."""

    def __init__(self, scene: PreparedScene) -> None:
        self.scene, self.tables = scene, scene.lowered.tables
        self._faces: dict[int, WindowFaces] = {}

    def cut_by(self, window: Window) -> list[int]:
        """The solid entries, and sheets, whose boxes the window may meet."""
        tables, boxes = self.tables, self.scene.lowered.boxes
        corners = np.stack([window.corner + s * window.u + t * window.v for s in (0, 1) for t in (0, 1)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        slack = _WIDER * (np.abs(corners).max() + np.abs(high - low).max())
        meets = ((boxes[:, :3] <= high + slack) & (boxes[:, 3:] >= low - slack)).all(axis=1)
        normal = np.cross(window.u, window.v)
        normal = normal / np.linalg.norm(normal)
        with np.errstate(invalid="ignore"):
            middle, half = (boxes[:, 3:] + boxes[:, :3]) / 2, (boxes[:, 3:] - boxes[:, :3]) / 2
            away = np.abs((middle - window.corner) @ normal) - half @ np.abs(normal)
        meets &= ~(away > slack)
        return np.flatnonzero(meets & np.isin(tables.entry_kind, (BALL, CELL, REGION, SHEET, POLYGON))).tolist()

    def place_box(self, entry: int, window: Window) -> tuple[float, float, float, float]:
        """(left, bottom, right, top) of the box of an entry in the window, about its middle; it may be larger."""
        box = self.scene.lowered.boxes[entry]
        across, up = window.size
        half = np.array([across, up]) / 2
        if not np.isfinite(box).all():
            return -half[0], -half[1], half[0], half[1]
        middle, reach = (box[3:] + box[:3]) / 2, (box[3:] - box[:3]) / 2
        sides = np.stack([window.u / across, window.v / up])
        place = sides @ (middle - window.corner) - half
        size = np.abs(sides) @ reach
        size = size + _WIDER * (size + np.abs(place) + half)
        left, bottom = np.maximum(place - size, -half).tolist()
        right, top = np.minimum(place + size, half).tolist()
        return left, bottom, right, top

    def number(self, entry: int) -> int:
        """Its body."""
        return entry

    def is_sheet(self, entry: int) -> bool:
        return int(self.tables.entry_kind[entry]) in (SHEET, POLYGON)

    def faces(self, entry: int) -> WindowFaces:
        """What bounds an entry; of a sheet its own surface comes first, as a cell of one."""
        known = self._faces.get(entry)
        if known is None:
            known = self._faces[entry] = WindowFaces(tuple(self._cells(entry)))
        return known

    def _cells(self, entry: int) -> list[tuple[tuple[int, int], ...]]:
        tables = self.tables
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind == BALL:
            return [((index, 1),)]
        if kind == CELL:
            return [self._cell(index)]
        if kind in (SHEET, POLYGON):
            program, surface = self._sheet(entry)
            own = ((surface, 1),)
            return [own, *(self._leaves(program) if program >= 0 else [])]
        return self._leaves(index)

    def _sheet(self, entry: int) -> tuple[int, int]:
        """(what clips a sheet or -1, its surface)"""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) == POLYGON:
            return int(tables.polygon_program[index]), int(tables.polygon_surface[index])
        return int(tables.sheet_program[index]), int(tables.sheet_surface[index])

    def edges_cut(self, entry: int, window: Window) -> FloatArray | None:
        """Places (n, 2) where the edges of a polygon go through the plane of a window; None for what is none."""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) != POLYGON:
            return None
        first, last = tables.polygon_first[index : index + 2].tolist()
        corners = tables.vertices[first:last]
        after = np.roll(corners, -1, axis=0)
        normal = np.cross(window.u, window.v)
        above, next_above = (corners - window.corner) @ normal, (after - window.corner) @ normal
        cut = (above < 0) != (next_above < 0)
        share = (above[cut] / (above[cut] - next_above[cut]))[:, None]
        points = corners[cut] + share * (after[cut] - corners[cut]) - window.corner
        across, up = window.size
        return np.stack([points @ window.u / across - across / 2, points @ window.v / up - up / 2], axis=1)

    def _leaves(self, program: int) -> list[tuple[tuple[int, int], ...]]:
        return [self._cell(int(cells_of_leaves(self.tables, leaf))) for leaf in leaves_of_program(self.tables, program)]

    def _cell(self, cell: int) -> tuple[tuple[int, int], ...]:
        tables = self.tables
        first, last = tables.cell_first[cell : cell + 2].tolist()
        planes = zip(
            tables.plane_surface[first:last].tolist(),
            sides_of(plane_faces(tables, slice(first, last))).tolist(),
            strict=True,
        )
        quadric = int(tables.cell_quadric[cell])
        return (*planes, *([(quadric, int(sides_of(cell_faces(tables, cell))))] if quadric >= 0 else []))

    def holds(self, entry: int, signs: Signs, count: int) -> Mask:
        """Is each of `count` places in an entry, by the signs of its surfaces there? Of a sheet: in what clips it."""
        tables, cells = self.tables, self.faces(entry).cells
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind in (BALL, CELL):
            return _in_cell(cells[0], signs, count)
        if kind in (SHEET, POLYGON):
            program = self._sheet(entry)[0]
            return np.ones(count, bool) if program < 0 else self._program(program, cells[1:], signs, count)
        return self._program(index, cells, signs, count)

    def _program(self, program: int, cells: Any, signs: Signs, count: int) -> Mask:
        """A Boolean program, by counting the true inputs of its gates (kernels/programs.py)."""
        tables = self.tables
        gates = gates_of_program(tables, program)
        begin, first = gates[0], int(row_of_leaf(tables, program, tables.program_leaf[program]))
        truths = np.repeat(tables.gate_start[begin : gates.stop].astype(np.int64)[:, None], count, axis=1)
        for k, cell in enumerate(cells):
            change = -1 if tables.leaf_negated[first + k] else 1
            truths[tables.leaf_gate[first + k] - begin] += change * _in_cell(cell, signs, count)
        for gate in reversed(gates[1:]):
            need, start = int(tables.gate_need[gate]), int(tables.gate_start[gate])
            falls = (start >= need) != bool(tables.gate_negated[gate])
            changed = (truths[gate - begin] >= need) != (start >= need)
            truths[tables.gate_parent[gate] - begin] += (-1 if falls else 1) * changed
        found: Mask = (truths[0] >= int(tables.gate_need[begin])) != bool(tables.gate_negated[begin])
        return found


def _in_cell(faces: tuple[tuple[int, int], ...], signs: Signs, count: int) -> Mask:
    inside = np.ones(count, bool)
    for surface, side in faces:
        inside &= signs(surface) * side <= 0
    return inside


def boxes_overlap(one: FloatArray, others: FloatArray) -> Mask:
    """Which of some boxes (n, 4) share a place with one."""
    found: Mask = (
        (others[:, 0] <= one[2]) & (others[:, 2] >= one[0]) & (others[:, 1] <= one[3]) & (others[:, 3] >= one[1])
    )
    return found


# The walls of bodies in a slice: each curve cut to where it really bounds a body.

Floats6 = tuple[float, float, float, float, float, float]


class _Wall:
    """A curve with the surfaces that it is in, and the entries that these bound."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve
        self.surfaces: set[int] = set()
        self.owners: list[int] = []
        self.box = np.zeros(4)


class OutlineCutter:
    """Finds the outlines of a scene in a window."""

    def __init__(self, scene: PreparedScene, window: Window) -> None:
        self.scene, self.window, self.bodies = scene, window, WindowBodies(scene)
        self.entries = self.bodies.cut_by(window)
        self._exact, self._records = window.exact(), RecordConics(scene, window)
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

    def _cut(self, surface: int) -> tuple[PlaneConic, list[Curve]]:
        """A surface in the plane: by its record where that says enough, else as it was written."""
        try:
            conic = self._records.conic(surface)
            return conic, [] if conic.is_everywhere else conic.curves()
        except UnclearConicError:
            conic = cut_conic(exact_form(self.scene, surface), self.window, self._exact)
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
        return _join_pieces(curve, sorted(wall.surfaces), t, points, which.tolist(), pieces)

    def _sides(self, wall: _Wall, t: FloatArray, places: FloatArray) -> list[Any]:
        """Of each piece by its middle: (bodies to the left, to the right, those it bounds), None if it bounds none."""
        curve, count = wall.curve, len(t)
        ahead = curve.velocity(t)
        left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        known: dict[int, Any] = {}

        def sign_of(surface: int) -> Any:
            if surface not in known:
                known[surface] = np.sign(form_value(self.floats[surface], places))
            return known[surface]

        def beside(turn: float) -> Callable[[int], Any]:
            def signs(surface: int) -> Any:
                if surface in wall.surfaces:
                    return turn * np.sign((form_gradient(self.floats[surface], places) * left).sum(axis=1))
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


def _join_pieces(
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
