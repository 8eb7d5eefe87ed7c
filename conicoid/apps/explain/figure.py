"""The figure of an explanation: the plane through the ray and a body's axis, exact sections of bodies, and crossings.

Order of the file: the plane and its window, a drawing as text of SVG, the figure.
"""

from __future__ import annotations

import html
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ..._util.validation import check_integer, check_path as checked_path
from ...geometry.general_quadric import PLANE, SPHERE
from ...prepare.prepared_scene import PreparedScene
from ..section.drawing import svg_path
from ..section.outline import Outline, OutlineCutter, WindowBodies
from ..section.window import Window
from .polynomial import SurfaceSource, format_float
from .steps import BALL_MISSED, BOX_MISSED, BodyStep, RayRecord

# The plane of the drawing and its window.

_PARALLEL = 1e-9
"""A part of an axis across the ray that is not longer than this has no direction."""
_MARGIN = 0.08
"""Margin of the window, as a share of its larger side."""


_LEAST = 1e-100
"""Smaller components of rays are set to 0, as rays refuse them."""


@dataclass(frozen=True)
class DrawingPlane:
    """The plane origin + x axes[0] + y axes[1], with orthonormal axes; the drawing shows `reach` about the origin."""

    origin: FloatArray
    axes: FloatArray
    reach: float

    @property
    def window(self) -> Window:
        """The square of two reaches in each direction about the origin, in which bodies are cut."""
        u, v = 4 * self.reach * self.axes
        return Window(self.origin - u / 2 - v / 2, u, v, 1, 1)

    def points(self, places: FloatArray) -> FloatArray:
        """Return places (n, 2) of the plane as points (n, 3) of the world."""
        return _flush_tiny(places @ self.axes + self.origin)

    def directions(self, places: FloatArray) -> FloatArray:
        """Return vectors (n, 2) of the plane as vectors (n, 3) of the world."""
        return _flush_tiny(places @ self.axes)

    def places(self, points: Any) -> FloatArray:
        """Return points (n, 3) of the world projected onto the plane, (n, 2)."""
        return np.asarray((np.asarray(points) - self.origin) @ self.axes.T)


def _flush_tiny(values: FloatArray) -> FloatArray:
    """Set components that are too small for a ray to 0."""
    return np.where(np.abs(values) < _LEAST, 0.0, values)


def plane_of(found: RayRecord, main: BodyStep | None, shown: Sequence[int]) -> tuple[DrawingPlane, str]:
    """Return the plane of the drawing, and a sentence about it; `shown` are the numbers of the bodies in it.

    It holds the ray, and the axis of the main body or a direction parallel to that, or else the body's middle.
    """
    origin, direction = np.array(found.origin), np.array(found.direction)
    along = direction / np.linalg.norm(direction)
    middle, reach = _middle(found, shown)
    # The point of the ray's line that is nearest to the middle is the origin of the plane
    foot = origin + along * float(along @ (middle - origin))
    place, axis, name = _axis(found, main, middle)
    across, about = (
        None,
        f"The plane through the ray and the middle of “{name}”." if main else "A plane through the ray.",
    )
    if axis is not None:
        # The ray and the part of the axis across it span the plane
        sideways = axis - along * float(along @ axis)
        if float(np.linalg.norm(sideways)) > _PARALLEL:
            across = sideways / np.linalg.norm(sideways)
            normal = np.cross(along, across)
            # The plane holds the axis only if the axis meets the ray's line; else it is parallel to it
            through = abs(float(normal @ (place - origin))) <= 1e-9 * (reach + float(np.linalg.norm(place - origin)))
            about = f"The plane through the ray {'and' if through else 'that is parallel to'} the axis of “{name}”."
    # No axis, or one along the ray: the ray and the middle of the body span the plane
    if across is None:
        sideways = place - origin
        sideways = sideways - along * float(along @ sideways)
        size = float(np.linalg.norm(sideways))
        # The middle is on the ray: any direction across will do
        if size <= _PARALLEL * (1 + reach):
            sideways = np.eye(3)[int(np.argmin(np.abs(along)))]
            sideways = sideways - along * float(along @ sideways)
            size = float(np.linalg.norm(sideways))
        across = sideways / size
        if axis is not None:
            about = f"The plane through the ray and the axis of “{name}”."
    # A fixed sense, whatever the sense of the axis
    if across[int(np.argmax(np.abs(across)))] < 0:
        across = -across
    return DrawingPlane(foot, np.array([along, across]), reach), about


def _axis(found: RayRecord, main: BodyStep | None, middle: FloatArray) -> tuple[FloatArray, Any, str]:
    """Return (a point, a direction or None, the body's name) of the axis of a body's first curved surface with one."""
    if main is None:
        return middle, None, ""
    scene, center = found.scene._prepared, None
    for number in surfaces_of(scene, main.body):
        classification = SurfaceSource.of(scene, number).classification
        if classification.center is None or classification.kind == PLANE:
            continue
        # The first axis counts; without one, the center of the first sphere
        if classification.kind != SPHERE:
            return np.array(classification.center), np.array(classification.axes[2]), main.title
        center = classification.center if center is None else center
    if center is not None:
        return np.array(center), None, main.title
    low, high = _box(found, [main.body])
    bounded = np.isfinite([low, high]).all()
    return ((low + high) / 2 if bounded else middle), None, main.title


def _box(found: RayRecord, shown: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Return a box (low, high) around some bodies, infinite where they are."""
    lowered = found.scene._prepared.lowered
    rows = lowered.boxes[np.array(shown, np.intp)]
    return rows[:, :3].min(axis=0, initial=math.inf), rows[:, 3:].max(axis=0, initial=-math.inf)


def _middle(found: RayRecord, shown: Sequence[int]) -> tuple[FloatArray, float]:
    """Return the middle and the reach of the drawing, from the first crossings and the finite boxes of bodies.

    The bodies are those shown that the ray crosses, or all that are shown if it crosses none.
    """
    origin, direction = np.array(found.origin), np.array(found.direction)
    points = [origin + one.t * direction for one in found.crossings[:16]]
    crossed = [step.body for step in found.bodies if step.body in shown and (step.crossings or step.spans)]
    for body in crossed or shown:
        low, high = _box(found, [body])
        if np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all():
            points += [low, high]
    if not points:
        points = [origin, origin + direction]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    reach = float(np.linalg.norm(high - low)) / 2
    return (low + high) / 2, 1.25 * reach if reach > 0 else 1.0


def window(
    found: RayRecord, plane: DrawingPlane, arcs: Mapping[int, Sequence[Outline]]
) -> tuple[float, float, float, float]:
    """Return (x0, x1, y0, y1) around the arcs and the crossings, and the ray's origin unless that is far away."""
    length = float(np.linalg.norm(found.direction))
    origin = float(plane.places(np.array([found.origin]))[0, 0])
    xs, ys = [], [0.0]
    for each in arcs.values():
        for arc in each:
            places = np.clip(arc.points(65), -plane.reach, plane.reach)
            xs += places[:, 0].tolist()
            ys += places[:, 1].tolist()
    xs += [origin + one.t * length for one in found.crossings if abs(origin + one.t * length) <= 2 * plane.reach]
    xs = xs or [origin, origin + length]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    size = max(x1 - x0, y1 - y0, 1e-12 * plane.reach)
    # The origin is shown if it is at most the window's size away
    if x0 - size <= origin <= x1 + size:
        x0, x1 = min(x0, origin), max(x1, origin)
    # Room for the head of the arrow
    x1 += 0.12 * size
    margin = _MARGIN * max(x1 - x0, y1 - y0)
    x0, x1, y0, y1 = x0 - margin, x1 + margin, y0 - margin, y1 + margin
    # The height is between 0.3 and 1.1 of the width
    low, high = 0.3 * (x1 - x0), 1.1 * (x1 - x0)
    if y1 - y0 < low:
        middle = (y0 + y1) / 2
        y0, y1 = middle - low / 2, middle + low / 2
    if y1 - y0 > high:
        middle, half = (x0 + x1) / 2, (y1 - y0) / 2.2
        x0, x1 = middle - half, middle + half
    return x0, x1, y0, y1


# A drawing as the text of a self-contained SVG picture: exact arcs of conics, lines, dots and labels.

_OFF = 1e-3
"""Pixels by which the Béziers of a hyperbola may miss it: SVG has no exact command for it."""


def _short(number: float) -> str:
    """Return a number of pixels with three decimals."""
    return f"{number:.3f}"


@dataclass
class SvgDrawing:
    """A drawing of the window x0 <= x <= x1 and y0 <= y <= y1 of the plane, `width` pixels wide."""

    x0: float
    x1: float
    y0: float
    y1: float
    width: int
    parts: list[str] = field(default_factory=list)

    @property
    def scale(self) -> tuple[float, float]:
        """Pixels of a unit of the plane, to the right and up."""
        scale = self.width / (self.x1 - self.x0)
        return scale, scale

    @property
    def height(self) -> int:
        """Pixels of the window's height."""
        return round(self.scale[1] * (self.y1 - self.y0))

    def at(self, place: Any) -> tuple[float, float]:
        """Return a place in pixels, y downwards."""
        x, y = self.places(place).tolist()
        return x, y

    def places(self, about: Any) -> FloatArray:
        """Return places (..., 2) of the plane in pixels."""
        return np.asarray((np.asarray(about) - (self.x0, self.y1)) * (self.scale[0], -self.scale[1]))

    def outline(self, outline: Outline, style: str, about: str) -> None:
        """Draw a wall; `about` is shown where the pointer rests on it."""
        path = svg_path(self, outline, _OFF, _short)
        self.parts.append(f'<path d="{path}" fill="none" {style}><title>{html.escape(about)}</title></path>')

    def line(self, begin: FloatArray, end: FloatArray, style: str) -> None:
        """Draw a straight line."""
        (x, y), (u, v) = self.at(begin), self.at(end)
        self.parts.append(f'<line x1="{x:.2f}" y1="{y:.2f}" x2="{u:.2f}" y2="{v:.2f}" {style}/>')

    def lines(self, pairs: FloatArray, style: str) -> None:
        """Draw many straight lines, pairs of places (n, 2, 2), as one path."""
        if len(pairs):
            rows = self.places(pairs).reshape(-1, 4).tolist()
            path = " ".join(f"M {x:.3f} {y:.3f} L {u:.3f} {v:.3f}" for x, y, u, v in rows)
            self.parts.append(f'<path d="{path}" fill="none" {style}/>')

    def dot(self, place: FloatArray, radius: float, style: str) -> None:
        """Draw a disc with a radius in pixels."""
        x, y = self.at(place)
        self.parts.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius}" {style}/>')

    def arrow(self, place: FloatArray, style: str) -> None:
        """Draw the head of an arrow to the right."""
        x, y = self.at(place)
        self.parts.append(
            f'<path d="M {x - 10:.2f} {y - 5:.2f} L {x:.2f} {y:.2f} L {x - 10:.2f} {y + 5:.2f} Z" {style}/>'
        )

    def text(self, x: float, y: float, text: str, style: str = "") -> None:
        """Draw a label at a pixel."""
        halo = 'stroke="#ffffff" stroke-width="3" paint-order="stroke"'
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {halo} {style}>{html.escape(text)}</text>')

    def svg(self, below: int, about: str) -> str:
        """Return the picture as text, with some pixels of room below; `about` is its title."""
        height = self.height + below
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {height}" width="{self.width}" '
            f'height="{height}" role="img" font-family="system-ui, sans-serif" font-size="13">'
        )
        back = f'<rect width="{self.width}" height="{height}" fill="#ffffff"/>'
        return "\n".join([head, f"<title>{html.escape(about)}</title>", back, *self.parts, "</svg>"])


# The figure: the ray in the plane, the exact sections of bodies, the crossings marked with t.

_COLORS = ("#1f5fa8", "#b3541e", "#2f7d4f", "#8a3f8f", "#8a6d1b", "#3a7f8c")
_RAY, _INK, _PALE = "#c4161c", "#333333", "#9a9a9a"
_MOST = 12
"""Bodies that are drawn."""
_GAP, _CAPTION_HEIGHT = 9.0, 30
"""Pixels between lines of hatching, and below the picture for the sentence."""


@dataclass(frozen=True)
class Figure:
    """A drawing in SVG, which a notebook shows.

    Attributes
    ----------
    svg : str
        The picture as text.
    arcs : dict of int to tuple of Outline
        The walls that are drawn, by the number of the body: exact pieces of conics, in coordinates of the plane.
    plane : DrawingPlane
        The plane of the drawing.
    about : str
        A sentence about the plane.
    """

    svg: str
    arcs: dict[int, tuple[Outline, ...]]
    plane: DrawingPlane
    about: str

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the drawing to an SVG file.

        Parameters
        ----------
        path : str or os.PathLike

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        from ..._util.files import write_text

        write_text(checked_path("save", path), self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Figure({self.about})"


def figure_of(found: RayRecord, body: Any, width: Any) -> Figure:
    """Return the figure through the axis of a body, by default of the one that is hit first."""
    width = check_integer("figure", "width", width, 200, 4000)
    shown = _drawn_bodies(found, None if body is None else found[body])
    main = shown[0] if shown else None
    plane, about = plane_of(found, main, [step.body for step in shown])
    arcs = {step.body: _walls(found, step, plane) for step in shown}
    drawing = SvgDrawing(*window(found, plane, arcs), width)
    inside, hatching = _hatching(drawing, found, plane)
    for k, step in enumerate(shown):
        missed = step.outcome in (BOX_MISSED, BALL_MISSED) or not (step.crossings or step.spans)
        color = _PALE if missed else _COLORS[k % len(_COLORS)]
        drawing.lines(hatching[inside == step.body], f'stroke="{color}" stroke-width="1" stroke-opacity="0.28"')
        _draw_body(drawing, step, arcs[step.body], color)
    _draw_ray(drawing, found, plane)
    drawing.text(8, drawing.height + 20, about, f'fill="{_INK}"')
    return Figure(drawing.svg(_CAPTION_HEIGHT, about), arcs, plane, about)


def _drawn_bodies(found: RayRecord, first: BodyStep | None) -> list[BodyStep]:
    """Return the bodies that are drawn: the given one, the one hit first, those that the tree reaches, a few others."""
    rank = {step.body: k for k, step in enumerate(found.bodies)}
    hit = int(found.hit.body)

    def order(step: BodyStep) -> tuple[bool, bool, bool, int]:
        return step is not first, step.body != hit, step.outcome in (BOX_MISSED, BALL_MISSED), rank[step.body]

    return sorted(found.bodies, key=order)[:_MOST]


def _walls(found: RayRecord, step: BodyStep, plane: DrawingPlane) -> tuple[Outline, ...]:
    """Return the section of a body: the pieces of conics that are its walls."""
    return tuple(OutlineCutter(found.scene._prepared, plane.window, step.body).outlines())


def surfaces_of(scene: PreparedScene, body: int) -> list[int]:
    """Return the numbers of the surfaces that a body is made of, in rising order; of a sheet its own surface."""
    bodies = WindowBodies(scene)
    cells = bodies.faces(body).cells
    return sorted({surface for cell in (cells[:1] if bodies.is_sheet(body) else cells) for surface, _ in cell})


def _draw_body(drawing: SvgDrawing, step: BodyStep, arcs: tuple[Outline, ...], color: str) -> None:
    """Draw the walls of a body and its name."""
    for arc in arcs:
        about = f"{step.title}: surface {', '.join(map(str, arc.surfaces))}, {arc.kind}"
        drawing.outline(arc, f'stroke="{color}" stroke-width="2"', about)
    if arcs:
        places = np.concatenate([arc.points(65) for arc in arcs])
        inside = (places[:, 0] > drawing.x0) & (places[:, 0] < drawing.x1) & (places[:, 1] < drawing.y1)
        top = max(places[inside].tolist() or [[drawing.x0, drawing.y0]], key=lambda place: place[1])
        x, y = drawing.at(np.array(top))
        wide = 7.5 * len(step.title)
        x, y = min(max(x - wide / 2, 4), drawing.width - wide), min(max(y - 7, 14), drawing.height - 6)
        drawing.text(x, y, step.title, f'fill="{color}"')


def _hatching(drawing: SvgDrawing, found: RayRecord, plane: DrawingPlane) -> tuple[Any, FloatArray]:
    """Return slanted lines inside solids, spans of rays in the plane: bodies (n,) and pairs of places (n, 2, 2)."""
    # Parallel lines at 45 degrees through the window's middle
    corner, far = np.array([drawing.x0, drawing.y0]), np.array([drawing.x1, drawing.y1])
    along, across = np.array([1.0, 1.0]) / math.sqrt(2), np.array([-1.0, 1.0]) / math.sqrt(2)
    middle, reach = (corner + far) / 2, float(np.linalg.norm(far - corner)) / 2
    steps = np.arange(-reach, reach, _GAP / drawing.scale[0])
    starts = middle + steps[:, None] * across - reach * along
    spans = found.scene.spans(plane.points(starts), plane.directions(along), 0.0, 2 * reach)
    first = np.repeat(starts, np.diff(spans.offsets), axis=0)
    ends = (first + t[:, None] * along for t in (spans.t_enter, spans.t_exit))
    return spans.body, np.stack([*ends], axis=1)


def _draw_ray(drawing: SvgDrawing, found: RayRecord, plane: DrawingPlane) -> None:
    """Draw the ray, its spans, its origin, and the crossings with their t."""
    direction = np.array(found.direction)
    length = float(np.linalg.norm(direction))
    origin = plane.places(np.array([found.origin]))[0]
    begin = max(float(origin[0]), drawing.x0)
    stop = min(drawing.x1, float(origin[0]) + found.t_max * length)
    drawing.line(np.array([begin, 0.0]), np.array([stop, 0.0]), f'stroke="{_RAY}" stroke-width="1.5"')
    for step in found.bodies:
        for span in step.spans:
            # Ends at infinity are clipped to the window like others
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
    """Mark crossings by dots and their t, in up to three rows above the ray where labels would overlap."""
    ends = [-math.inf, -math.inf, -math.inf]
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
        # The lowest row that is free at this place, or the highest
        row = next((k for k in range(3) if ends[k] < x - 4), 2)
        ends[row] = x + 7.2 * len(label)
        drawing.text(min(x + 4, drawing.width - 7.2 * len(label)), y - 10 - 15 * row, label, f'fill="{_RAY}"')
