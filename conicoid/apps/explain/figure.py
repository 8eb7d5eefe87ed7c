"""Where a figure is drawn: the plane through the ray and a body's axis, and the window in it."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.validation import check_integer
from ...geometry.quadric_classification import PLANE, SPHERE
from ...kernels.programs import cells_of_leaves, leaves_of_program
from ...queries.extensions import extension
from .conics import ELLIPSE, HYPERBOLA, PARABOLA, Arc, DrawingPlane, branches, restrict_to_plane, wall_arcs
from .polynomial import SurfaceSource, format_float
from .steps import BALL_MISSED, BOX_MISSED, BodyStep, RayRecord

_PARALLEL = 1e-9
_MARGIN = 0.08


def plane_of(found: RayRecord, main: BodyStep | None, shown: Sequence[int]) -> tuple[DrawingPlane, str]:
    """(the plane, a sentence about it)."""
    origin, direction = np.array(found.origin), np.array(found.direction)
    along = direction / np.linalg.norm(direction)
    middle, reach = _middle(found, shown)
    foot = origin + along * float(along @ (middle - origin))
    place, axis, name = _axis(found, main, middle)
    across, about = (
        None,
        f"The plane through the ray and the middle of “{name}”." if main else "A plane through the ray.",
    )
    if axis is not None:
        beside = axis - along * float(along @ axis)
        if float(np.linalg.norm(beside)) > _PARALLEL:
            across = beside / np.linalg.norm(beside)
            normal = np.cross(along, across)
            through = abs(float(normal @ (place - origin))) <= 1e-9 * (reach + float(np.linalg.norm(place - origin)))
            about = f"The plane through the ray {'and' if through else 'that is parallel to'} the axis of “{name}”."
    if across is None:
        beside = place - origin
        beside = beside - along * float(along @ beside)
        size = float(np.linalg.norm(beside))
        if size <= _PARALLEL * (1 + reach):
            beside = np.eye(3)[int(np.argmin(np.abs(along)))]
            beside = beside - along * float(along @ beside)
            size = float(np.linalg.norm(beside))
        across = beside / size
        if axis is not None:
            about = f"The plane through the ray and the axis of “{name}”."
    if across[int(np.argmax(np.abs(across)))] < 0:
        across = -across
    return DrawingPlane(foot, np.array([along, across]), reach), about


def _axis(found: RayRecord, main: BodyStep | None, middle: FloatArray) -> tuple[FloatArray, Any, str]:
    """(a point, a direction or None, the name) of the axis of a body: of its first curved surface that has one."""
    if main is None:
        return middle, None, ""
    scene, center = found.scene.prepared, None
    for number in surfaces_of(scene, main.body):
        told = SurfaceSource.of(scene, number).classification
        if told.center is None or told.kind == PLANE:
            continue
        if told.kind != SPHERE:
            return np.array(told.center), np.array(told.axes[2]), main.name
        center = told.center if center is None else center
    if center is not None:
        return np.array(center), None, main.name
    low, high = _box(found, [main.body])
    bounded = np.isfinite([low, high]).all()
    return ((low + high) / 2 if bounded else middle), None, main.name


def _box(found: RayRecord, shown: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """(low, high) around some bodies, infinite where they are."""
    lowered = found.scene.prepared.lowered
    rows = lowered.boxes[np.array(shown, np.intp)]
    return rows[:, :3].min(axis=0, initial=math.inf), rows[:, 3:].max(axis=0, initial=-math.inf)


def _middle(found: RayRecord, shown: Sequence[int]) -> tuple[FloatArray, float]:
    """(the middle of what is drawn, how far it reaches): of boxes that have an end, and of the crossings."""
    origin, direction = np.array(found.origin), np.array(found.direction)
    points = [origin + one.t * direction for one in found.crossings[:16]]
    met = [step.body for step in found.bodies if step.body in shown and (step.crossings or step.spans)]
    for body in met or shown:
        low, high = _box(found, [body])
        if np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all():
            points += [low, high]
    if not points:
        points = [origin, origin + direction]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    reach = float(np.linalg.norm(high - low)) / 2
    return (low + high) / 2, 1.25 * reach if reach > 0 else 1.0


def window(
    found: RayRecord, plane: DrawingPlane, arcs: Mapping[int, Sequence[Arc]]
) -> tuple[float, float, float, float]:
    """(x0, x1, y0, y1) that holds what is drawn, and the ray's origin unless it is far away."""
    length = float(np.linalg.norm(found.direction))
    origin = float(plane.places(np.array([found.origin]))[0, 0])
    xs, ys = [], [0.0]
    for each in arcs.values():
        for arc in each:
            places = np.clip(arc.branch.points(np.linspace(arc.first, arc.last, 65)), -plane.reach, plane.reach)
            xs += places[:, 0].tolist()
            ys += places[:, 1].tolist()
    xs += [origin + one.t * length for one in found.crossings if abs(origin + one.t * length) <= 2 * plane.reach]
    xs = xs or [origin, origin + length]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    size = max(x1 - x0, y1 - y0, 1e-12 * plane.reach)
    if x0 - size <= origin <= x1 + size:
        x0, x1 = min(x0, origin), max(x1, origin)
    x1 += 0.12 * size
    margin = _MARGIN * max(x1 - x0, y1 - y0)
    x0, x1, y0, y1 = x0 - margin, x1 + margin, y0 - margin, y1 + margin
    low, high = 0.3 * (x1 - x0), 1.1 * (x1 - x0)
    if y1 - y0 < low:
        middle = (y0 + y1) / 2
        y0, y1 = middle - low / 2, middle + low / 2
    if y1 - y0 > high:
        middle, half = (x0 + x1) / 2, (y1 - y0) / 2.2
        x0, x1 = middle - half, middle + half
    return x0, x1, y0, y1


# A drawing as the text of an SVG picture: exact arcs of conics, lines, dots and labels, in itself.

_PIECES = 24
"""Cubic pieces of an arc of a hyperbola, which SVG has no exact command for."""


@dataclass
class SvgDrawing:
    """A window of the plane, x0 <= x <= x1 and y0 <= y <= y1, `width` pixels wide."""

    x0: float
    x1: float
    y0: float
    y1: float
    width: int
    parts: list[str] = field(default_factory=list)

    @property
    def scale(self) -> float:
        """Pixels of a unit."""
        return self.width / (self.x1 - self.x0)

    @property
    def height(self) -> int:
        return round(self.scale * (self.y1 - self.y0))

    def at(self, place: FloatArray) -> tuple[float, float]:
        """A place in pixels, y downwards."""
        x, y = float(place[0]), float(place[1])
        return (x - self.x0) * self.scale, (self.y1 - y) * self.scale

    def _told(self, place: FloatArray) -> str:
        x, y = self.at(place)
        return f"{x:.3f} {y:.3f}"

    def arc(self, arc: Arc, style: str, about: str) -> None:
        """A wall; `about` is shown where the pointer rests on it."""
        self.parts.append(f'<path d="{self.path(arc)}" fill="none" {style}><title>{html.escape(about)}</title></path>')

    def path(self, arc: Arc) -> str:
        """The commands of an arc: A, Q and L are the conics themselves."""
        branch = arc.branch
        ends = branch.points(np.array([arc.first, (arc.first + arc.last) / 2, arc.last]))
        begin, middle, end = (self._told(place) for place in ends)
        if branch.kind == ELLIPSE:
            (ux, uy), (vx, vy) = branch.frame
            turn = -math.degrees(math.atan2(uy, ux))
            sweep = 0 if ux * vy - uy * vx > 0 else 1
            radii = f"{branch.a * self.scale:.3f} {branch.b * self.scale:.3f} {turn:.4f}"
            large = 1 if (arc.last - arc.first) / 2 > math.pi else 0
            return f"M {begin} A {radii} {large} {sweep} {middle} A {radii} {large} {sweep} {end}"
        if branch.kind == PARABOLA:
            s, t = arc.first, arc.last
            own = np.array([(s + t) / 2, branch.a * s * t + branch.b])
            return f"M {begin} Q {self._told(own @ np.array(branch.frame) + np.array(branch.center))} {end}"
        if branch.kind == HYPERBOLA:
            return f"M {begin} {' '.join(self._cubics(arc))}"
        return f"M {begin} L {end}"

    def _cubics(self, arc: Arc) -> list[str]:
        """An arc of a hyperbola in pieces that have its tangents."""
        branch, frame = arc.branch, np.array(arc.branch.frame)
        s = np.linspace(arc.first, arc.last, _PIECES + 1)
        step = (arc.last - arc.first) / _PIECES / 3
        slopes = np.stack([branch.a * np.sinh(s), branch.b * np.cosh(s)], axis=-1) @ frame * step
        places = branch.points(s)
        after, before = places + slopes, places - slopes
        return [
            f"C {self._told(after[k])} {self._told(before[k + 1])} {self._told(places[k + 1])}" for k in range(_PIECES)
        ]

    def line(self, begin: FloatArray, end: FloatArray, style: str) -> None:
        """A straight line."""
        (x, y), (u, v) = self.at(begin), self.at(end)
        self.parts.append(f'<line x1="{x:.2f}" y1="{y:.2f}" x2="{u:.2f}" y2="{v:.2f}" {style}/>')

    def lines(self, pairs: list[tuple[FloatArray, FloatArray]], style: str) -> None:
        """Many straight lines as one path."""
        if pairs:
            path = " ".join(f"M {self._told(begin)} L {self._told(end)}" for begin, end in pairs)
            self.parts.append(f'<path d="{path}" fill="none" {style}/>')

    def dot(self, place: FloatArray, radius: float, style: str) -> None:
        """A disc of some pixels."""
        x, y = self.at(place)
        self.parts.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius}" {style}/>')

    def arrow(self, place: FloatArray, style: str) -> None:
        """The head of an arrow to the right."""
        x, y = self.at(place)
        self.parts.append(
            f'<path d="M {x - 10:.2f} {y - 5:.2f} L {x:.2f} {y:.2f} L {x - 10:.2f} {y + 5:.2f} Z" {style}/>'
        )

    def text(self, x: float, y: float, text: str, style: str = "") -> None:
        """A label at a pixel."""
        halo = 'stroke="#ffffff" stroke-width="3" paint-order="stroke"'
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {halo} {style}>{html.escape(text)}</text>')

    def svg(self, below: int, about: str) -> str:
        """The picture, with some pixels of room below."""
        height = self.height + below
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {height}" width="{self.width}" '
            f'height="{height}" role="img" font-family="system-ui, sans-serif" font-size="13">'
        )
        back = f'<rect width="{self.width}" height="{height}" fill="#ffffff"/>'
        return "\n".join([head, f"<title>{html.escape(about)}</title>", back, *self.parts, "</svg>"])


# The figure of an explanation: the ray in a plane, the exact sections of bodies, the crossings marked with t.

_COLORS = ("#1f5fa8", "#b3541e", "#2f7d4f", "#8a3f8f", "#8a6d1b", "#3a7f8c")
_RAY, _INK, _PALE = "#c4161c", "#333333", "#9a9a9a"
_MOST = 12
"""Bodies that are drawn."""
_GAP, _BELOW = 9.0, 30


@dataclass(frozen=True)
class Figure:
    """A drawing in SVG. A notebook shows it; `save(path)` writes it, `svg` is its text.

    arcs      the walls that are drawn, by the number of the body: exact arcs of conics in the plane
    about     a sentence on what is seen
    """

    svg: str
    arcs: dict[int, tuple[Arc, ...]]
    plane: DrawingPlane
    about: str

    def save(self, path: Any) -> None:
        """Write it as a .svg file at `path`. Raises OSError where that cannot be written."""
        from ..._util.safe_files import write_text
        from ..._util.validation import check_path as checked_path

        write_text(checked_path("save", path), self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Figure({self.about})"


def figure_of(found: RayRecord, body: Any, width: Any) -> Figure:
    """The figure, through the axis of a body: of the one that is hit first, if none is given."""
    width = check_integer("figure", "width", width, 200, 4000)
    shown = _drawn_bodies(found, None if body is None else found[body])
    main = shown[0] if shown else None
    plane, about = plane_of(found, main, [step.body for step in shown])
    arcs = {step.body: tuple(_walls(found, step, plane)) for step in shown}
    drawing = SvgDrawing(*window(found, plane, arcs), width)
    for k, step in enumerate(shown):
        missed = step.outcome in (BOX_MISSED, BALL_MISSED) or not (step.crossings or step.spans)
        _draw_body(drawing, found, step, arcs[step.body], plane, _PALE if missed else _COLORS[k % len(_COLORS)])
    _draw_ray(drawing, found, plane)
    drawing.text(8, drawing.height + 20, about, f'fill="{_INK}"')
    return Figure(drawing.svg(_BELOW, about), arcs, plane, about)


def _drawn_bodies(found: RayRecord, first: BodyStep | None) -> list[BodyStep]:
    """The bodies that are drawn: the one that matters, those met, and a few of the others."""
    rank = {step.body: k for k, step in enumerate(found.bodies)}
    hit = int(found.hit.body)

    def order(step: BodyStep) -> tuple[bool, bool, bool, int]:
        return step is not first, step.body != hit, step.outcome in (BOX_MISSED, BALL_MISSED), rank[step.body]

    return sorted(found.bodies, key=order)[:_MOST]


def _walls(found: RayRecord, step: BodyStep, plane: DrawingPlane) -> list[Arc]:
    """The section of a body: the parts of its surfaces' conics that are its walls."""
    alone = extension("Scene")([found.scene.body(step.body)])
    arcs = []
    for number in surfaces_of(found.scene.prepared, step.body):
        polynomial = SurfaceSource.of(found.scene.prepared, number).polynomial
        conic = restrict_to_plane(polynomial, plane.origin.tolist(), plane.axes.tolist())
        for branch in branches(conic, plane.reach):
            arcs += wall_arcs(alone, number, branch, plane)
    return arcs


def surfaces_of(scene: Any, body: int) -> list[int]:
    """The surfaces that a body is made of."""
    from ...kernels import tables as table

    tables = scene.lowered.tables
    found: set[int] = set()
    kind, index = int(tables.entry_kind[body]), int(tables.entry_index[body])
    if kind == table.BALL:
        found.add(index)
    elif kind == table.CELL:
        found |= _surfaces_of_cell(tables, index)
    elif kind == table.REGION:
        leaves = leaves_of_program(tables, index)
        found = found.union(*(_surfaces_of_cell(tables, int(cells_of_leaves(tables, leaf))) for leaf in leaves))
    else:
        found.add(int((tables.sheet_surface if kind == table.SHEET else tables.polygon_surface)[index]))
    return sorted(found)


def _surfaces_of_cell(tables: Any, cell: int) -> set[int]:
    planes = tables.plane_surface[tables.cell_first[cell] : tables.cell_first[cell + 1]]
    return {*planes.tolist(), *([int(tables.cell_quadric[cell])] if tables.cell_quadric[cell] >= 0 else [])}


def _draw_body(
    drawing: SvgDrawing, found: RayRecord, step: BodyStep, arcs: tuple[Arc, ...], plane: DrawingPlane, color: str
) -> None:
    """The hatched section of a body and its walls."""
    drawing.lines(_hatching(drawing, found, step, plane), f'stroke="{color}" stroke-width="1" stroke-opacity="0.28"')
    for arc in arcs:
        about = f"{step.name}: surface {arc.surface}, {arc.branch.kind}"
        drawing.arc(arc, f'stroke="{color}" stroke-width="2"', about)
    if arcs:
        places = np.concatenate([arc.branch.points(np.linspace(arc.first, arc.last, 65)) for arc in arcs])
        inside = (places[:, 0] > drawing.x0) & (places[:, 0] < drawing.x1) & (places[:, 1] < drawing.y1)
        top = max(places[inside].tolist() or [[drawing.x0, drawing.y0]], key=lambda place: place[1])
        x, y = drawing.at(np.array(top))
        wide = 7.5 * len(step.name)
        x, y = min(max(x - wide / 2, 4), drawing.width - wide), min(max(y - 7, 14), drawing.height - 6)
        drawing.text(x, y, step.name, f'fill="{color}"')


def _hatching(
    drawing: SvgDrawing, found: RayRecord, step: BodyStep, plane: DrawingPlane
) -> list[tuple[FloatArray, FloatArray]]:
    """Slanted lines in the section: the spans of rays in the plane, by the same engine."""
    body = found.scene.body(step.body)
    if body.shape.is_sheet:
        return []
    corner, far = np.array([drawing.x0, drawing.y0]), np.array([drawing.x1, drawing.y1])
    along, across = np.array([1.0, 1.0]) / math.sqrt(2), np.array([-1.0, 1.0]) / math.sqrt(2)
    middle, reach = (corner + far) / 2, float(np.linalg.norm(far - corner)) / 2
    steps = np.arange(-reach, reach, _GAP / drawing.scale)
    starts = middle + steps[:, None] * across - reach * along
    spans = extension("Scene")([body]).spans(plane.points(starts), plane.directions(along), 0.0, 2 * reach)
    rows = np.repeat(np.arange(len(steps)), np.diff(spans.offsets))
    pairs = []
    for k, enter, leave in zip(rows.tolist(), spans.t_enter.tolist(), spans.t_exit.tolist(), strict=True):
        pairs.append((starts[k] + enter * along, starts[k] + leave * along))
    return pairs


def _draw_ray(drawing: SvgDrawing, found: RayRecord, plane: DrawingPlane) -> None:
    """The ray, its origin, and the crossings with their t."""
    direction = np.array(found.direction)
    length = float(np.linalg.norm(direction))
    origin = plane.places(np.array([found.origin]))[0]
    begin = max(float(origin[0]), drawing.x0)
    stop = min(drawing.x1, float(origin[0]) + found.t_max * length)
    drawing.line(np.array([begin, 0.0]), np.array([stop, 0.0]), f'stroke="{_RAY}" stroke-width="1.5"')
    for step in found.bodies:
        for span in step.spans:
            ends = [origin[0] + min(max(t, -1e300), 1e300) * length for t in (span.t_enter, span.t_exit)]
            a, b = (min(max(end, drawing.x0), drawing.x1) for end in ends)
            if a < b:
                drawing.line(np.array([a, 0.0]), np.array([b, 0.0]), f'stroke="{_RAY}" stroke-width="3.5"')
    drawing.arrow(np.array([stop, 0.0]), f'fill="{_RAY}"')
    if drawing.x0 <= origin[0] <= drawing.x1:
        drawing.dot(np.array([origin[0], 0.0]), 4, f'fill="{_INK}"')
        x, y = drawing.at(np.array([origin[0], 0.0]))
        drawing.text(x + 2, y + 18, "o, t = 0", f'fill="{_INK}"')
    _mark_crossings(drawing, found, float(origin[0]), length)


def _mark_crossings(drawing: SvgDrawing, found: RayRecord, origin: float, length: float) -> None:
    """Dots with their t, above and below the ray in turn where they are close."""
    taken = [-math.inf, -math.inf, -math.inf]
    for one in found.crossings:
        place = np.array([origin + one.t * length, 0.0])
        x, y = drawing.at(place)
        if not -1 <= x <= drawing.width + 1:
            continue
        first = one.t == float(found.hit.t)
        drawing.dot(
            place, 5 if first else 3.5, f'fill="{_RAY if first else "#ffffff"}" stroke="{_RAY}" stroke-width="1.5"'
        )
        label = f"t = {format_float(one.t)}" if len(format_float(one.t)) < 8 else f"t ≈ {one.t:.5g}"
        row = next((k for k in range(3) if taken[k] < x - 4), 2)
        taken[row] = x + 7.2 * len(label)
        drawing.text(min(x + 4, drawing.width - 7.2 * len(label)), y - 10 - 15 * row, label, f'fill="{_RAY}"')
