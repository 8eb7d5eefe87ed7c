"""The figure of an explanation: the ray in a plane, the exact sections of bodies, the crossings marked with t."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.programs import cells_of_leaves, leaves_of_program
from ..shapes.validate import integer
from ..shapes.vector import FloatArray
from .arcs import Arc, Plane, walls
from .conics import branches, restricted
from .numbers import told
from .polynomial import Source
from .steps import BALL, BOX, BodyStep
from .svg import Drawing
from .windows import plane_of, window

if TYPE_CHECKING:
    from .explanation import Explanation

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
    plane: Plane
    about: str

    def save(self, path: Any) -> None:
        """Write it as a .svg file at `path`. Raises OSError where that cannot be written."""
        from ..formats.atomic import write_text
        from ..shapes.validate import path as checked_path

        write_text(checked_path("save", path), self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Figure({self.about})"


def figure_of(found: Explanation, body: Any, width: Any) -> Figure:
    """The figure, through the axis of a body: of the one that is hit first, if none is given."""
    width = integer("figure", "width", width, 200, 4000)
    shown = _shown(found, None if body is None else found[body])
    main = shown[0] if shown else None
    plane, about = plane_of(found, main, [step.body for step in shown])
    arcs = {step.body: tuple(_walls(found, step, plane)) for step in shown}
    drawing = Drawing(*window(found, plane, arcs), width)
    for k, step in enumerate(shown):
        missed = step.outcome in (BOX, BALL) or not (step.crossings or step.spans)
        _draw_body(drawing, found, step, arcs[step.body], plane, _PALE if missed else _COLORS[k % len(_COLORS)])
    _draw_ray(drawing, found, plane)
    drawing.text(8, drawing.height + 20, about, f'fill="{_INK}"')
    return Figure(drawing.svg(_BELOW, about), arcs, plane, about)


def _shown(found: Explanation, first: BodyStep | None) -> list[BodyStep]:
    """The bodies that are drawn: the one that matters, those met, and a few of the others."""
    rank = {step.body: k for k, step in enumerate(found.bodies)}
    hit = int(found.hit.body)

    def order(step: BodyStep) -> tuple[bool, bool, bool, int]:
        return step is not first, step.body != hit, step.outcome in (BOX, BALL), rank[step.body]

    return sorted(found.bodies, key=order)[:_MOST]


def _walls(found: Explanation, step: BodyStep, plane: Plane) -> list[Arc]:
    """The section of a body: the parts of its surfaces' conics that are its walls."""
    from ..scene import Scene

    alone = Scene([found.scene.body(step.body)])
    arcs = []
    for number in surfaces_of(found.scene.prepared, step.body):
        polynomial = Source.of(found.scene.prepared, number).polynomial
        conic = restricted(polynomial, plane.origin.tolist(), plane.axes.tolist())
        for branch in branches(conic, plane.reach):
            arcs += walls(alone, number, branch, plane)
    return arcs


def surfaces_of(scene: Any, body: int) -> list[int]:
    """The surfaces that a body is made of."""
    from ..engine import tables as table

    tables = scene.lowered.tables
    found: set[int] = set()
    kind, index = int(tables.entry_kind[body]), int(tables.entry_index[body])
    if kind == table.BALL:
        found.add(index)
    elif kind == table.CELL:
        found |= _of_cell(tables, index)
    elif kind == table.REGION:
        leaves = leaves_of_program(tables, index)
        found = found.union(*(_of_cell(tables, int(cells_of_leaves(tables, leaf))) for leaf in leaves))
    else:
        found.add(int((tables.sheet_surface if kind == table.SHEET else tables.polygon_surface)[index]))
    return sorted(found)


def _of_cell(tables: Any, cell: int) -> set[int]:
    planes = tables.plane_surface[tables.cell_first[cell] : tables.cell_first[cell + 1]]
    return {*planes.tolist(), *([int(tables.cell_quadric[cell])] if tables.cell_quadric[cell] >= 0 else [])}


def _draw_body(
    drawing: Drawing, found: Explanation, step: BodyStep, arcs: tuple[Arc, ...], plane: Plane, color: str
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
    drawing: Drawing, found: Explanation, step: BodyStep, plane: Plane
) -> list[tuple[FloatArray, FloatArray]]:
    """Slanted lines in the section: the spans of rays in the plane, by the same engine."""
    from ..scene import Scene

    body = found.scene.body(step.body)
    if body.shape.is_sheet:
        return []
    corner, far = np.array([drawing.x0, drawing.y0]), np.array([drawing.x1, drawing.y1])
    along, across = np.array([1.0, 1.0]) / math.sqrt(2), np.array([-1.0, 1.0]) / math.sqrt(2)
    middle, reach = (corner + far) / 2, float(np.linalg.norm(far - corner)) / 2
    steps = np.arange(-reach, reach, _GAP / drawing.scale)
    starts = middle + steps[:, None] * across - reach * along
    spans = Scene([body]).spans(plane.points(starts), plane.directions(along), 0.0, 2 * reach)
    rows = np.repeat(np.arange(len(steps)), np.diff(spans.offsets))
    pairs = []
    for k, enter, leave in zip(rows.tolist(), spans.t_enter.tolist(), spans.t_exit.tolist(), strict=True):
        pairs.append((starts[k] + enter * along, starts[k] + leave * along))
    return pairs


def _draw_ray(drawing: Drawing, found: Explanation, plane: Plane) -> None:
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


def _mark_crossings(drawing: Drawing, found: Explanation, origin: float, length: float) -> None:
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
        label = f"t = {told(one.t)}" if len(told(one.t)) < 8 else f"t ≈ {one.t:.5g}"
        row = next((k for k in range(3) if taken[k] < x - 4), 2)
        taken[row] = x + 7.2 * len(label)
        drawing.text(min(x + 4, drawing.width - 7.2 * len(label)), y - 10 - 15 * row, label, f'fill="{_RAY}"')
