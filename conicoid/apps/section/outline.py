"""Outlines of a slice: the curves in which a plane cuts the walls of bodies, as exact pieces of conics.

`OutlineCutter` intersects every surface near the window with its plane, breaks each curve where it crosses others, and
keeps the pieces that bound a body. `WindowBodies` reads the bodies from the tables of the scene.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ..._util.validation import as_integer, format_value
from ...kernels.faces import cell_faces, plane_faces, sides_of
from ...kernels.programs import cells_of_leaves, gates_of_program, leaves_of_program, row_of_leaf
from ...kernels.tables import BALL, CELL, POLYGON, REGION, SHEET
from ...kernels.threads import Progress
from ...prepare.prepared_scene import PreparedScene, exact_form
from ...queries.points import bodies_at
from .conic import PlaneConic, RecordConics, UnclearConicError, as_six, cut_conic, snap_conic
from .curve import Curve, Ellipse, Graph, Pair, crossings, form_gradient, form_value
from .window import Window

_DEEPEST = 12
"""Most halvings of the Béziers of a curve."""
_BEND = 1e-9
"""Sine of the angle between tangents below which a piece of a parabola is drawn as straight."""


class Outline:
    """A piece of the curve in which a plane cuts a wall, made by `Slice.outlines`.

    It is the part of its `curve` from the parameter `begin` to `stop`, with `ends` where the wall meets others. Places
    are in lengths along u and v, like `Slice.extent`.

    Attributes
    ----------
    kind : str
        "line", "ellipse", "parabola" or "hyperbola".
    surfaces : tuple of int
        The surfaces that it lies in, numbered like `hits.surface`; several where walls coincide.
    left, right : tuple of int
        The bodies on both sides, seen from start to end, in listing order.
    bodies : tuple of int
        The bodies whose boundary it is.
    start, end : float64 (2,)
        Its ends, where the wall meets others; equal for a whole ellipse.
    center, radii, angle
        For an ellipse: its centre, its half-axes, and the direction of the first one in degrees. None for other kinds.
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
        """The place where it begins, (2,)."""
        return self._ends[0] + self._origin

    @property
    def end(self) -> FloatArray:
        """The place where it ends, (2,)."""
        return self._ends[1] + self._origin

    @property
    def is_closed(self) -> bool:
        """Whether it is a whole ellipse."""
        return self._curve.closed and self._stop - self._begin > 2 * math.pi * (1 - 1e-15)

    @property
    def center(self) -> FloatArray | None:
        """The centre of an ellipse, (2,); None for other kinds."""
        whole = self._ellipse
        return None if whole is None else np.array(whole[0]) + self._origin

    @property
    def radii(self) -> tuple[float, float] | None:
        """The half-axes of an ellipse; None for other kinds."""
        whole = self._ellipse
        return None if whole is None else whole[2]

    @property
    def angle(self) -> float | None:
        """The direction of the first half-axis of an ellipse, in degrees from u; None for other kinds."""
        whole = self._ellipse
        return None if whole is None else math.degrees(math.atan2(whole[1][1], whole[1][0]))

    @property
    def _ellipse(self) -> tuple[Pair, Pair, Pair] | None:
        """The centre, the direction of the first half-axis and both half-axes of an ellipse; None for other kinds."""
        curve = self._curve
        if isinstance(curve, Ellipse):
            return curve.center, curve.axis, curve.radii
        return curve.whole if isinstance(curve, Graph) else None

    def points(self, count: int = 33) -> FloatArray:
        """Return places along the outline, from end to end, each on the wall to rounding.

        Parameters
        ----------
        count : int
            At least 2.

        Returns
        -------
        float64 (count, 2)

        Raises
        ------
        ValueError
            For another count.
        """
        number = as_integer(count)
        if number is None or number < 2:
            raise ValueError(f"Outline: count must be a whole number of at least 2, got {format_value(count)}")
        return self._about(np.linspace(self._begin, self._stop, number)) + self._origin

    def _about(self, t: Any) -> FloatArray:
        """Return the places of parameters, about the middle of the window. The ends are the computed crossings."""
        places = self._curve.points(t)
        places[t == self._begin], places[t == self._stop] = self._ends
        return places

    def distance(self, places: npt.ArrayLike) -> Any:
        """Return the distances of places from the whole curve, to first order, which serves for places near it.

        Parameters
        ----------
        places : array_like (..., 2)
            In the coordinates of `Slice.extent`.

        Returns
        -------
        float64 (...)
        """
        about = np.asarray(places, float) - self._origin
        # The first-order distance is |f| / |∇f|.
        slope = np.linalg.norm(2 * form_gradient(self._curve.conic, about), axis=-1)
        return np.abs(form_value(self._curve.conic, about)) / slope

    def _cubics(self, off: float) -> FloatArray:
        """Return cubic Béziers (pieces, 4, 2) about the middle of the window, at most `off` from the curve.

        Lines and parabolas are cubics themselves. Pieces of other curves are tested at places along them, and halved
        until all fit.
        """
        # Pieces of an eighth of a turn, or of one unit of a hyperbola's parameter, to begin with.
        turn = math.pi / 4 if self.kind == "ellipse" else 1.0
        pieces = 1 if self.kind in ("line", "parabola") else max(1, math.ceil((self._stop - self._begin) / turn))
        for _ in range(_DEEPEST):
            cubics = self._tangent_cubics(pieces)
            if self.kind in ("line", "parabola") or self._off(cubics) <= off:
                break
            pieces *= 2
        return cubics

    def _tangent_cubics(self, pieces: int) -> FloatArray:
        """Return Béziers that are tangent to the curve at their ends, and meet it in the middle.

        For an ellipse their handles are k = 4/3 tan(h/4) times the velocity by the angle; h is the angle of a piece.
        """
        t = np.linspace(self._begin, self._stop, pieces + 1)
        places, slopes = self._about(t), self._curve.velocity(t)
        k = self._curve.handle((self._stop - self._begin) / pieces)
        first, last = places[:-1] + k * slopes[:-1], places[1:] - k * slopes[1:]
        if self.kind in ("line", "parabola"):
            # A parabola is a quadratic Bézier exactly; its control point is where the tangents cross.
            way = places[1:] - places[:-1]
            control, turn = places[:-1] + way / 2, _cross(slopes[:-1], slopes[1:])
            bends = np.abs(turn) > _BEND * np.linalg.norm(slopes[:-1], axis=1) * np.linalg.norm(slopes[1:], axis=1)
            share = _cross(way, slopes[1:])[bends] / turn[bends]
            control[bends] = places[:-1][bends] + share[:, None] * slopes[:-1][bends]
            first, last = (places[:-1] + 2 * control) / 3, (places[1:] + 2 * control) / 3
        return np.stack([places[:-1], first, last, places[1:]], axis=1)

    def _off(self, cubics: FloatArray) -> float:
        """Return the largest distance of Béziers from the curve, at places along them."""
        t = np.linspace(0, 1, 17)[1:-1]
        basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        places = np.einsum("kt,nkx->ntx", basis, cubics)
        return float(self.distance(places + self._origin).max())

    def __repr__(self) -> str:
        (a, b), (c, d) = self.start.tolist(), self.end.tolist()
        way = "whole" if self.is_closed else f"({a:.6g}, {b:.6g}) to ({c:.6g}, {d:.6g})"
        return f"Outline({self.kind}, {way}, left={self.left}, right={self.right})"


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the cross products of vectors (n, 2)."""
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


# --- The bodies of a prepared scene: which of them a window may cut, and which hold a place

Signs = Callable[[int], Any]
"""Surface -> its sign, -1, 0 or 1, at each of some places."""
Mask = npt.NDArray[np.bool_]
_CLOSE = 1e-13
"""Value of a surface's conic, in units of its largest coefficient, that may be rounding."""
_INSIDE = 0.4834
"""The share of a piece at which it is tested."""
_WIDER = 1e-9
"""Relative margin of boxes."""


@dataclass(frozen=True)
class WindowFaces:
    """The surfaces of an entry: for each of its cells, (surface, side that is inside) of its walls."""

    cells: tuple[tuple[tuple[int, int], ...], ...]

    @property
    def surfaces(self) -> set[int]:
        """The surfaces of all cells."""
        return {surface for cell in self.cells for surface, _ in cell}


class WindowBodies:
    """Reads the entries of a scene for a window."""

    def __init__(self, scene: PreparedScene) -> None:
        self.scene, self.tables = scene, scene.lowered.tables
        self._faces: dict[int, WindowFaces] = {}

    def cut_by(self, window: Window) -> list[int]:
        """Return the solids and sheets whose boxes the window may cross."""
        tables, boxes = self.tables, self.scene.lowered.boxes
        corners = np.stack([window.corner + s * window.u + t * window.v for s in (0, 1) for t in (0, 1)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        # First the box of the window, then its plane; both with a margin for rounding.
        slack = _WIDER * (np.abs(corners).max() + np.abs(high - low).max())
        meets = ((boxes[:, :3] <= high + slack) & (boxes[:, 3:] >= low - slack)).all(axis=1)
        across, up = window.size
        normal = np.cross(window.u / across, window.v / up)
        # Unbounded boxes give NaN here, which counts as cut by the plane.
        with np.errstate(invalid="ignore"):
            middle, half = (boxes[:, 3:] + boxes[:, :3]) / 2, (boxes[:, 3:] - boxes[:, :3]) / 2
            distance = np.abs((middle - window.corner) @ normal) - half @ np.abs(normal)
        meets &= ~(distance > slack)
        return np.flatnonzero(meets & np.isin(tables.entry_kind, (BALL, CELL, REGION, SHEET, POLYGON))).tolist()

    def place_box(self, entry: int, window: Window) -> tuple[float, float, float, float]:
        """Return (left, bottom, right, top) around an entry in the window, about its middle. It may be too large."""
        box = self.scene.lowered.boxes[entry]
        across, up = window.size
        half = np.array([across, up]) / 2
        # An unbounded entry may reach the whole window.
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

    def is_sheet(self, entry: int) -> bool:
        """Return whether an entry is a sheet."""
        return int(self.tables.entry_kind[entry]) in (SHEET, POLYGON)

    def faces(self, entry: int) -> WindowFaces:
        """Return the faces of an entry. A sheet's own surface comes first, as a cell of one face."""
        cached = self._faces.get(entry)
        if cached is None:
            cached = self._faces[entry] = WindowFaces(tuple(self._cells(entry)))
        return cached

    def _cells(self, entry: int) -> list[tuple[tuple[int, int], ...]]:
        """Return (surface, side) of the walls of each cell of an entry."""
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
        """Return (the program that clips a sheet, or -1; its surface)."""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) == POLYGON:
            return int(tables.polygon_program[index]), int(tables.polygon_surface[index])
        return int(tables.sheet_program[index]), int(tables.sheet_surface[index])

    def edges_cut(self, entry: int, window: Window) -> FloatArray | None:
        """Return the places (n, 2) where the edges of a polygon cross the window's plane; None for other entries."""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) != POLYGON:
            return None
        first, last = tables.polygon_first[index : index + 2].tolist()
        corners = tables.vertices[first:last]
        after = np.roll(corners, -1, axis=0)
        normal = np.cross(window.u, window.v)
        above, next_above = (corners - window.corner) @ normal, (after - window.corner) @ normal
        # A corner in the plane counts as above it, for both of its edges.
        cut = (above < 0) != (next_above < 0)
        share = (above[cut] / (above[cut] - next_above[cut]))[:, None]
        points = corners[cut] + share * (after[cut] - corners[cut]) - window.corner
        across, up = window.size
        return np.stack([points @ window.u / across - across / 2, points @ window.v / up - up / 2], axis=1)

    def _leaves(self, program: int) -> list[tuple[tuple[int, int], ...]]:
        """Return the cells of the leaves of a program, in order."""
        return [self._cell(int(cells_of_leaves(self.tables, leaf))) for leaf in leaves_of_program(self.tables, program)]

    def _cell(self, cell: int) -> tuple[tuple[int, int], ...]:
        """Return (surface, side) of the walls of a cell: its planes, then its quadric."""
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
        """Return whether `count` places are in an entry, by the signs of its surfaces; for a sheet, in its clip."""
        tables, cells = self.tables, self.faces(entry).cells
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind in (BALL, CELL):
            return _in_cell(cells[0], signs, count)
        if kind in (SHEET, POLYGON):
            program = self._sheet(entry)[0]
            return np.ones(count, bool) if program < 0 else self._program(program, cells[1:], signs, count)
        return self._program(index, cells, signs, count)

    def _program(self, program: int, cells: Any, signs: Signs, count: int) -> Mask:
        """Evaluate a Boolean program by counting the true inputs of its gates (kernels/programs.py)."""
        tables = self.tables
        # A gate starts with its count for all leaves outside. Each leaf that is inside changes the count of its gate by
        # one, and so does each gate whose truth changes with its parent. Parents come before their inputs in the table,
        # so gates are visited in reverse.
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
        return (truths[0] >= int(tables.gate_need[begin])) != bool(tables.gate_negated[begin])


def _in_cell(faces: tuple[tuple[int, int], ...], signs: Signs, count: int) -> Mask:
    """Return whether places are in a cell or on its walls."""
    inside = np.ones(count, bool)
    for surface, side in faces:
        inside &= signs(surface) * side <= 0
    return inside


def boxes_overlap(one: FloatArray, others: FloatArray) -> Mask:
    """Return bool (n,): which boxes (n, 4) overlap one box."""
    return (others[:, 0] <= one[2]) & (others[:, 2] >= one[0]) & (others[:, 1] <= one[3]) & (others[:, 3] >= one[1])


# --- Cutting curves to the pieces that bound a body

Floats6 = tuple[float, float, float, float, float, float]


class _Wall:
    """A curve, the surfaces that it lies in, the entries that these bound, and its box in the window."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve
        self.surfaces: set[int] = set()
        self.owners: list[int] = []
        self.box = np.zeros(4)


class _Pieces(NamedTuple):
    """The breaks of a curve, in order, and its pieces in the window: the place of the first break, and the middle."""

    t: FloatArray
    points: FloatArray
    which: npt.NDArray[np.intp]
    middle: FloatArray
    places: FloatArray


_WALLS = 256
"""Walls whose crossings are refined together, and whose neighbours are found by one query."""


class OutlineCutter:
    """Computes the outlines of a scene in a window.

    With `single_body`, outlines are those of that body alone, in a plane whose numbers are rounded: conics that
    are almost lines are lines. Their places are about the middle of the window.
    """

    def __init__(self, scene: PreparedScene, window: Window, single_body: int | None = None) -> None:
        self.scene, self.window, self.bodies, self.single_body = scene, window, WindowBodies(scene), single_body
        self.entries = [entry for entry in self.bodies.cut_by(window) if single_body is None or entry == single_body]
        self._exact, self._records = window.exact(), RecordConics(scene, window)
        # Surface -> the entries that it bounds.
        users: dict[int, list[int]] = defaultdict(list)
        for entry in self.entries:
            for surface in sorted(self.bodies.faces(entry).surfaces):
                users[surface].append(entry)
        self.floats: dict[int, Floats6] = {}
        self._conic = lru_cache(maxsize=1 << 12)(lambda surface: self._cut(surface)[0])
        self.walls = self._walls(users)
        self.boxes = np.array([wall.box for wall in self.walls]).reshape(-1, 4)

    def _walls(self, users: dict[int, list[int]]) -> list[_Wall]:
        """Return every curve once, however many surfaces it lies in, if it may reach the boxes of their bodies."""
        boxes = {entry: self.bodies.place_box(entry, self.window) for entry in self.entries}
        walls: dict[Any, _Wall] = {}
        for surface in sorted(users):
            conic, curves = self._cut(surface)
            # A surface that holds the whole plane has no sign in it. One that only touches the plane has one sign, also
            # where it touches.
            touches = 0.0 if conic.is_everywhere else conic.constant_sign
            self.floats[surface] = conic.floats if curves else (0.0, 0.0, 0.0, 0.0, 0.0, touches)
            for curve in curves:
                # Coincident curves have one key, so several surfaces share one wall.
                wall = walls.setdefault(curve.key, _Wall(curve))
                wall.surfaces.add(surface)
                wall.owners += [entry for entry in users[surface] if entry not in wall.owners]
        for wall in walls.values():
            owner_boxes = np.array([boxes[entry] for entry in wall.owners])
            own = wall.curve.box()
            # The curve matters only where both its own box and a box of its bodies are.
            wall.box[:2] = np.maximum(owner_boxes[:, :2].min(axis=0), own[:2])
            wall.box[2:] = np.minimum(owner_boxes[:, 2:].max(axis=0), own[2:])
        return [wall for wall in walls.values() if (wall.box[:2] <= wall.box[2:]).all()]

    def _cut(self, surface: int) -> tuple[PlaneConic, list[Curve]]:
        """Return the conic of a surface and its curves, from its record if that suffices, else from its exact form."""
        try:
            return self._curves(self._records.conic(surface))
        except UnclearConicError:
            return self._curves(cut_conic(exact_form(self.scene, surface), self.window, self._exact))

    def _curves(self, conic: PlaneConic) -> tuple[PlaneConic, list[Curve]]:
        """Return a conic, snapped if the plane is rounded, and its curves."""
        if conic.is_everywhere:
            return conic, []
        conic = conic if self.single_body is None else snap_conic(conic)
        return conic, conic.curves()

    def outlines(self, progress: Progress | None = None) -> list[Outline]:
        """Return all outlines, in the order of the surfaces."""
        outlines: list[Outline] = []
        origin = np.array(self.window.origin if self.single_body is None else (0.0, 0.0))
        for begin in range(0, len(self.walls), _WALLS):
            walls = self.walls[begin : begin + _WALLS]
            places = crossings([wall.curve for wall in walls], [self._conics_near(wall) for wall in walls])
            cuts = [(wall, self._pieces(wall, own)) for wall, own in zip(walls, places, strict=True)]
            for k, (wall, pieces, others) in enumerate(self._with_neighbours(cuts)):
                outlines += self._of_wall(wall, pieces, others)
                if progress is not None:
                    progress(begin + k + 1, len(self.walls))
        for one in outlines:
            one._origin = origin
        return outlines

    def _conics_near(self, wall: _Wall) -> FloatArray:
        """Return the conics (n, 6) that may cross a curve: the window's edges, which are lines, and other walls."""
        across, up = self.window.size
        edges = [
            (0.0, 0.0, 0.0, 0.5 * x, 0.5 * y, -0.5 * size)
            for x, y, size in ((1, 0, across), (-1, 0, across), (0, 1, up), (0, -1, up))
        ]
        # Only curves whose boxes overlap can cross.
        near = np.flatnonzero(boxes_overlap(wall.box, self.boxes)).tolist()
        return np.array([*edges, *(self.walls[k].curve.conic for k in near if self.walls[k] is not wall)])

    def _breaks(self, wall: _Wall, crossings: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (parameters, points), in order, where a curve meets others or leaves the window."""
        corners = np.array(wall.curve.corners)
        parts = [(wall.curve.parameter(crossings), crossings), (corners, wall.curve.points(corners))]
        cuts = [self.bodies.edges_cut(entry, self.window) for entry in self._sheets_in(wall)]
        parts += [(wall.curve.parameter(places), places) for places in cuts if places is not None]
        t = np.concatenate([part[0] for part in parts])
        points = np.concatenate([part[1] for part in parts])
        order = np.argsort(t, kind="stable")
        return t[order], points[order]

    def _pieces(self, wall: _Wall, crossings: FloatArray) -> _Pieces:
        """Return the pieces of a curve between its breaks, as far as they are in the window."""
        curve = wall.curve
        t, points = self._breaks(wall, crossings)
        if curve.closed:  # the first break is the last one too, a turn later
            if not len(t):
                t, points = np.zeros(1), curve.points([0.0])
            t, points = np.append(t, t[0] + 2 * math.pi), np.concatenate([points, points[:1]])
        # Not halfway, where other walls may touch a symmetric piece
        middle = t[:-1] + _INSIDE * (t[1:] - t[:-1])
        places = curve.points(middle) if len(middle) else np.zeros((0, 2))
        half = np.array(self.window.size) / 2
        # Between two breaks no side changes, so the middle stands for the whole piece.
        in_window = (t[1:] > t[:-1]) & (np.abs(places) <= half).all(axis=1) & np.isfinite(places).all(axis=1)
        which = np.flatnonzero(in_window)
        return _Pieces(t, points, which, middle[which], places[which])

    def _with_neighbours(self, cuts: list[tuple[_Wall, _Pieces]]) -> Iterator[tuple[_Wall, _Pieces, list[list[int]]]]:
        """Yield walls and their pieces with the bodies at the middle of each piece that the wall does not bound."""
        places, first = np.concatenate([pieces.places for _, pieces in cuts]), 0
        # One query for many walls. Bodies that a wall does not bound hold both sides or none.
        bodies = None if self.single_body is not None else bodies_at(self.scene, self.window.in_space(places))
        for wall, pieces in cuts:
            others: list[list[int]] = [[] for _ in pieces.which]
            if bodies is not None:
                at = (bodies[first + i] for i in range(len(others)))
                others = [[int(body) for body in each if int(body) not in wall.owners] for each in at]
            first += len(others)
            yield wall, pieces, others

    def _of_wall(self, wall: _Wall, pieces: _Pieces, neighbours: list[list[int]]) -> list[Outline]:
        """Return the pieces of a curve that bound a body."""
        if not len(pieces.which):
            return []
        sides = self._sides(wall, pieces.middle, pieces.places, neighbours)
        surfaces = sorted(wall.surfaces)
        return _join_pieces(wall.curve, surfaces, pieces.t, pieces.points, pieces.which.tolist(), sides)

    def _sides(self, wall: _Wall, t: FloatArray, places: FloatArray, neighbours: list[list[int]]) -> list[Any]:
        """Return (bodies on the left, on the right, bounded bodies) for each piece; None for one that bounds none.

        Each piece is tested at its middle; `neighbours` are the other bodies there.
        """
        curve, count = wall.curve, len(t)
        ahead = curve.velocity(t)
        left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        cached: dict[int, Any] = {}

        def sign_of(surface: int) -> Any:
            if surface not in cached:
                values = form_value(self.floats[surface], places)
                near = np.abs(values) < _CLOSE
                if near.any():
                    values = np.where(near, form_value(self._beside(surface, min(wall.surfaces)), places), values)
                cached[surface] = np.sign(values)
            return cached[surface]

        # On one side of the curve its own surfaces have the sign of their slope across it; on the other, the opposite.
        def signs_of_side(turn: float) -> Callable[[int], Any]:
            def signs(surface: int) -> Any:
                if surface in wall.surfaces:
                    return turn * np.sign((form_gradient(self.floats[surface], places) * left).sum(axis=1))
                return sign_of(surface)

            return signs

        sides_of_pieces: list[Any] = []
        side_masks = [self._bodies_at_wall(wall, signs_of_side(turn), count) for turn in (1.0, -1.0)]
        sheets = self._sheets(wall, t, sign_of)
        for i in range(count):
            one, other = (sorted([*neighbours[i], *(body for body, mask in side if mask[i])]) for side in side_masks)
            # A solid is bounded where it is on one side only; a sheet has no inside.
            bounded = sorted({*one} ^ {*other} | {body for body, mask in sheets if mask[i]})
            sides_of_pieces.append((tuple(one), tuple(other), tuple(bounded)) if bounded else None)
        return sides_of_pieces

    def _beside(self, surface: int, wall: int) -> Floats6:
        """Return a conic that has the sign of a surface along a wall, also where both coincide but for rounding."""
        one, other = self._conic(surface), self._conic(wall)
        k = max(range(6), key=lambda i: abs(other.exact[i]))
        lead = other.exact[k]
        # The wall's own conic is zero there, so any multiple of it may be taken off: exactly, as floats may be equal
        rest = [
            (a * lead - b * one.exact[k]) * (1 if lead > 0 else -1) for a, b in zip(one.exact, other.exact, strict=True)
        ]
        return replace(one, exact=as_six(rest)).floats if any(rest) else self.floats[surface]

    def _bodies_at_wall(self, wall: _Wall, signs: Callable[[int], Any], count: int) -> list[tuple[int, Any]]:
        """Return (body, mask of the places that it holds) of the wall's solids."""
        solid = [entry for entry in wall.owners if not self.bodies.is_sheet(entry)]
        return [(entry, self.bodies.holds(entry, signs, count)) for entry in solid]

    def _sheets_in(self, wall: _Wall) -> list[int]:
        """Return the sheets that a curve lies in."""
        return [
            entry
            for entry in wall.owners
            if self.bodies.is_sheet(entry) and self.bodies.faces(entry).cells[0][0][0] in wall.surfaces
        ]

    def _sheets(self, wall: _Wall, t: FloatArray, sign_of: Callable[[int], Any]) -> list[tuple[int, Any]]:
        """Return (body, mask of its places) of the sheets that the curve lies in; polygons by the even-odd rule."""

        def signs(surface: int) -> Any:
            # On its own surfaces a place has the sign 0, which counts as inside.
            return np.zeros(len(t)) if surface in wall.surfaces else sign_of(surface)

        masks = []
        for entry in self._sheets_in(wall):
            mask, edges = self.bodies.holds(entry, signs, len(t)), self.bodies.edges_cut(entry, self.window)
            if edges is not None:
                # A place is inside a polygon if an odd number of edges come before it along the line.
                mask &= (wall.curve.parameter(edges)[None] < t[:, None]).sum(axis=1) % 2 == 1
            masks.append((entry, mask))
        return masks


def _join_pieces(
    curve: Curve, surfaces: list[int], t: FloatArray, points: FloatArray, which: list[int], pieces: list[Any]
) -> list[Outline]:
    """Return the outlines of pieces; neighbours with the same bodies on both sides become one."""
    runs: list[list[Any]] = []
    for k, sides in zip(which, pieces, strict=True):
        if sides is None:
            continue
        if runs and t[runs[-1][1]] == t[k] and runs[-1][2] == sides:
            runs[-1][1] = k + 1
        else:
            runs.append([k, k + 1, sides])
    last = len(t) - 1
    # A piece of a closed curve may continue across its first break.
    if curve.closed and len(runs) > 1 and runs[0][0] == 0 and runs[-1][1] == last and runs[0][2] == runs[-1][2]:
        runs[0][0] = runs.pop()[0]
    outlines = []
    for first, end, sides in runs:
        begin, stop = float(t[first]), float(t[end])
        stop += 2 * math.pi if stop <= begin else 0.0
        ends = points[first], points[end]
        outlines.append(Outline(curve, begin, stop, ends, tuple(surfaces), *sides))
    return outlines
