"""Calls as solids, each with the colour that it stands in."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds
from ...geometry.body import Body
from ...geometry.csg import Difference, Intersection, Union
from ...geometry.shape import Solid
from ...materials.presets import matte
from ..importers import ImportOptions, ImportResult, LegendEntry, format_count, limit_notes
from . import solids
from .solids import PlaneItem, combine_figures, plane_circle, plane_polygon
from .syntax import CallArguments, CsgCall, CsgReader, CsgText

UNSUPPORTED_CALLS = {
    "hull": "the convex hull of its children",
    "minkowski": "the sum of its children", "text": "letters", "import": "a file",
    "surface": "a height field", "projection": "a projection", "offset": "an outline at a distance",
    "resize": "a size that depends on its children",
}  # fmt: skip
"""Modules whose results are no quadric solids of ours, or not yet."""
_GROUP_CALLS = ("group", "union", "render", "root")


@dataclass(frozen=True)
class ColoredSolid:
    """A solid, and its colour in sRGB, None where it has none of its own."""

    solid: Solid
    color: str | None = None


class CsgEvaluation:
    """What the calls of a file are; what cannot be said is left out, and told."""

    def __init__(self, text: CsgText, smooth: bool) -> None:
        self.text, self.smooth = text, smooth
        self.remarks: list[str] = []
        self.rounded = 0
        """How many circles are round though $fn is above 0."""

    def parts(self, calls: Sequence[CsgCall]) -> list[ColoredSolid]:
        """The solids of calls that stand beside one another."""
        found: list[ColoredSolid] = []
        for call in calls:
            if "*" in call.modifier:
                continue
            if "%" in call.modifier:
                self._tell(call, "is in the background (%) and left out")
                continue
            found += self._parts_of(call)
        return found

    def _parts_of(self, call: CsgCall) -> list[ColoredSolid]:
        given = CallArguments(self.text, call)
        if self.smooth and isinstance(given.given("$fn"), float) and given.given("$fn") > 0:
            self.rounded += 1
        if call.name in _GROUP_CALLS:
            return self.parts(call.children)
        if call.name == "multmatrix":
            return self._moved(call, given)
        if call.name == "color":
            return self._colored(call, given)
        if call.name in ("difference", "intersection"):
            return self._combined(call)
        if call.name in UNSUPPORTED_CALLS:
            self._tell(call, f"is {UNSUPPORTED_CALLS[call.name]}, and left out")
            return []
        make = self._makers().get(call.name)
        if make is not None:
            return [ColoredSolid(given.made(lambda: make(given)))]
        if call.name in ("circle", "square", "polygon"):
            self._tell(call, "is flat and encloses nothing; it is left out")
            return []
        raise given.refuse("is no module of a .csg file: `openscad -o model.csg model.scad` writes one")

    def _makers(self) -> dict[str, Callable[[CallArguments], Solid]]:
        return {
            "cube": solids.cube,
            "sphere": lambda given: solids.sphere(given, self.smooth),
            "cylinder": lambda given: solids.cylinder(given, self.smooth),
            "polyhedron": solids.polyhedron,
            "linear_extrude": self._extruded,
            "rotate_extrude": self._turned,
        }

    def _tell(self, call: CsgCall, message: str) -> None:
        line, _ = self.text.place(call.position)
        self.remarks.append(f"line {line}: {call.name} {message}")

    def _moved(self, call: CsgCall, given: CallArguments) -> list[ColoredSolid]:
        matrix = given.matrix()
        if abs(np.linalg.det(matrix[:3, :3])) == 0:
            self._tell(call, "flattens what it moves, which is left out")
            return []
        rows, found = matrix.tolist(), []
        for part in self.parts(call.children):
            found.append(ColoredSolid(given.made(partial(part.solid.transform, rows)), part.color))
        return found

    def _colored(self, call: CsgCall, given: CallArguments) -> list[ColoredSolid]:
        value = given.given("c") or given.given("0")
        if not isinstance(value, list) or len(value) < 3 or not all(isinstance(v, float) for v in value):
            raise given.refuse(f"must have a list of red, green, blue and alpha, got {value!s:.60}")
        if value[0] < 0:  # no colour: those of the children stay
            return self.parts(call.children)
        channels = [min(max(v, 0.0), 1.0) for v in value]
        if len(channels) > 3 and channels[3] < 1:
            self._tell(call, f"has the opacity {channels[3]:g}, which is not read")
        color = "#" + "".join(f"{round(255 * v):02x}" for v in channels[:3])
        return [ColoredSolid(part.solid, color) for part in self.parts(call.children)]

    def _combined(self, call: CsgCall) -> list[ColoredSolid]:
        """Each child is one operand, of whatever it holds; the first gives the colour, cuts keep that of the cutter."""
        operands = []
        for child in call.children:
            parts = self.parts([child])
            if parts or "*" not in child.modifier:
                operands.append(parts)
        if not operands or not operands[0] or (call.name == "intersection" and not all(operands)):
            return []
        color = operands[0][0].color
        made = [_unite_parts([_paint_walls(part, color) for part in parts]) for parts in operands if parts]
        if len(made) == 1:
            return [ColoredSolid(made[0], color)]
        return [
            ColoredSolid(Difference(tuple(made)) if call.name == "difference" else Intersection(tuple(made)), color)
        ]

    # ---- In the plane ----

    def _extruded(self, given: CallArguments) -> Solid:
        drawn = self._drawn(given)
        height = given.number("height", given.number("h", 100.0))
        twist = given.number("twist", 0.0)
        if twist:
            raise ValueError(f"twist must be 0, got {twist:g}: a twisted side is no quadric")
        scale = given.given("scale")
        scales = scale if isinstance(scale, list) else [scale if scale is not None else 1.0] * 2
        if len(scales) != 2 or not all(isinstance(s, float) and s >= 0 for s in scales) or scales[0] != scales[1]:
            raise ValueError(f"scale must be one number >= 0, or two that are equal, got {scale!s:.40}")
        if not height > 0:
            raise ValueError(f"height must be > 0, got {height:g}")
        low = -height / 2 if given.flag("center") else 0.0
        return drawn.extruded(low, low + height, scales[0])

    def _turned(self, given: CallArguments) -> Solid:
        angle = given.number("angle", 360.0)
        start = given.number("start", 0.0)
        start, end = (start, start + angle) if angle > 0 else (start + angle, start)
        if abs(angle) >= 360 or angle == 0:
            start, end = 0.0, 360.0
        return self._drawn(given).turned(start, end, given.sides(self.smooth))

    def _drawn(self, given: CallArguments) -> PlaneItem:
        parts = self._flat(given.call.children)
        if not parts:
            raise ValueError("must have something of the plane in it: a circle, a square or a polygon")
        return combine_figures(Union, parts)

    def _flat(self, calls: Sequence[CsgCall]) -> list[PlaneItem]:
        found: list[PlaneItem] = []
        for call in calls:
            given = CallArguments(self.text, call)
            if "*" in call.modifier or "%" in call.modifier:
                continue
            if call.name in (*_GROUP_CALLS, "color"):
                found += self._flat(call.children)
            elif call.name in ("difference", "intersection"):
                operands = [combine_figures(Union, parts) for child in call.children if (parts := self._flat([child]))]
                if operands:
                    found.append(combine_figures(Difference if call.name == "difference" else Intersection, operands))
            elif call.name == "multmatrix":
                matrix = given.matrix()
                matrix[2], matrix[:2, 2] = (0, 0, 1, 0), 0
                found += [part.moved(matrix) for part in self._flat(call.children)]
            else:
                found.append(given.made(partial(self._one_flat, given)))
        return found

    def _one_flat(self, given: CallArguments) -> PlaneItem:
        name = given.call.name
        if name == "circle":
            return plane_circle(given.number("r", given.number("d", 2.0) / 2), given.sides(self.smooth))
        if name == "square":
            size = given.given("size")
            sizes = [size] * 2 if isinstance(size, float) else size if isinstance(size, list) else [1.0] * 2
            if len(sizes) != 2 or not all(isinstance(s, float) and s > 0 for s in sizes):
                raise ValueError(f"size must be two numbers > 0, got {size!s:.40}")
            x, y = (-sizes[0] / 2, -sizes[1] / 2) if given.flag("center") else (0.0, 0.0)
            return plane_polygon([(x, y), (x + sizes[0], y), (x + sizes[0], y + sizes[1]), (x, y + sizes[1])], None)
        if name == "polygon":
            points = given.rows("points", 2)
            paths = given.given("paths")
            return plane_polygon(points, None if paths is None else given.paths("paths", len(points)))
        raise given.refuse(f"is {UNSUPPORTED_CALLS.get(name, 'nothing of the plane')}, which cannot be extruded here")


def _paint_walls(part: ColoredSolid, around: str | None) -> Solid:
    """A solid with its own colour on its walls, where that is not the colour around it."""
    return part.solid if part.color is None or part.color == around else part.solid.painted(matte(part.color))


def _unite_parts(parts: list[Any]) -> Solid:
    return parts[0] if len(parts) == 1 else Union(tuple(parts))


# A .csg file as bodies: one for each colour, which do not overlap.

DEFAULT_COLOR = "#f9d72c"
"""What has no colour is yellow, as OpenSCAD shows it."""


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """The solids of a file."""
    options.refuse_others("an OpenSCAD model", "strict", "smooth")
    text = CsgText(Path(path))
    reader = CsgReader(text)
    calls = reader.calls()
    reader.end()
    evaluation = CsgEvaluation(text, options.smooth)
    parts = evaluation.parts([call for call in calls if "!" in call.modifier] or calls)
    bodies = _color_bodies(parts)
    legend = tuple(LegendEntry(None, "", body.name, 1) for body in bodies)
    remarks = tuple(limit_notes(evaluation.remarks))
    facts = [f"{format_count(len(parts), 'solid')} of {format_count(len(bodies), 'colour')}"]
    if evaluation.rounded:
        facts.append(f"{format_count(evaluation.rounded, 'circle')} with $fn made round")
    names = {body.material: body.name for body in bodies if body.name}
    return ImportResult(bodies, legend, (*facts, *remarks), remarks, names)


def _color_bodies(parts: list[ColoredSolid]) -> list[Body]:
    """A body for each colour: the union of what has it, without what came before in other colours."""
    colors = list(dict.fromkeys(part.color or DEFAULT_COLOR for part in parts))
    found: list[Body] = []
    before: list[tuple[Solid, BoxEnds]] = []
    for color in colors:
        these = [part.solid for part in parts if (part.color or DEFAULT_COLOR) == color]
        whole = these[0] if len(these) == 1 else Union(tuple(these))
        around = whole.bounds
        cut = whole.operands[1:] if isinstance(whole, Difference) and whole.motion.is_identity else ()
        near = [solid for solid, box in before if _boxes_overlap(box, around) and solid not in cut]
        found.append(Body(Difference((whole, *near)) if near else whole, matte(color, name=color), color))
        before += [(solid, solid.bounds) for solid in these]
    return found


def _boxes_overlap(one: BoxEnds, other: BoxEnds) -> bool:
    """Have two boxes a point in common?"""
    (low, high), (its_low, its_high) = one, other
    return bool(np.all(low <= its_high) and np.all(its_low <= high))
