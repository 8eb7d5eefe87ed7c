"""Import of OpenSCAD's evaluated models (.csg): calls become solids with colours, and solids become bodies.

`CsgEvaluation` evaluates calls and remarks on those that it leaves out; `import_file` makes one body for each colour.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds
from ..._util.records import dataclass
from ..._util.text import format_count
from ...geometry.body import Body
from ...geometry.shape import Difference, Intersection, Solid, Union
from ...materials.presets import matte
from ..importers import ImportOptions, ImportResult, LegendEntry, OmittedPart, limit_notes
from ..scene_file.nodes import shorten
from . import solids
from .solids import PlaneItem, combine_figures, plane_circle, plane_polygon
from .syntax import CallArguments, CsgCall, CsgReader, CsgText

UNSUPPORTED_CALLS = {
    "hull": "the convex hull of its children",
    "minkowski": "the sum of its children", "text": "letters", "import": "a file",
    "surface": "a height field", "projection": "a projection", "offset": "an outline at a distance",
    "resize": "a size that depends on its children", "roof": "a roof", "fill": "an outline without its holes",
}  # fmt: skip
"""Modules that are not supported, as their results are no quadrics or are not computed here."""
_GROUP_CALLS = ("group", "union", "render", "root")


@dataclass(frozen=True)
class ColoredSolid:
    """A solid with its colour (#rrggbb in sRGB), or None if it has no colour of its own."""

    solid: Solid
    color: str | None = None


class CsgEvaluation:
    """Evaluator of the calls of a file; it leaves out calls that it cannot express, with a remark."""

    def __init__(self, text: CsgText, smooth: bool) -> None:
        self.text, self.smooth = text, smooth
        self.remarks: list[str] = []
        self.rounded = 0
        """Number of circles that are round although $fn is above 0."""

    def parts(self, calls: Sequence[CsgCall]) -> list[ColoredSolid]:
        """Return the solids of calls that stand side by side. Raise SceneFileError for an invalid call."""
        solids_of_calls: list[ColoredSolid] = []
        for call in calls:
            if "*" in call.modifier:
                continue
            if "%" in call.modifier:
                self._remark(call, "is in the background (%) and left out")
                continue
            solids_of_calls += self._parts_of(call)
        return solids_of_calls

    def _parts_of(self, call: CsgCall) -> list[ColoredSolid]:
        """Return the solids of one call."""
        arguments = self._arguments(call)
        if self.smooth and isinstance(arguments.value("$fn"), float) and arguments.value("$fn") > 0:
            self.rounded += 1
        if call.name in _GROUP_CALLS:
            return self.parts(call.children)
        if call.name == "multmatrix":
            return self._moved(call, arguments)
        if call.name == "color":
            return self._colored(call, arguments)
        if call.name in ("difference", "intersection"):
            return self._combined(call)
        if call.name in UNSUPPORTED_CALLS:
            self._remark(call, f"is {UNSUPPORTED_CALLS[call.name]}, and left out")
            return []
        build = self._builders().get(call.name)
        if build is not None:
            try:
                return [ColoredSolid(arguments.build(lambda: build(arguments)))]
            except OmittedPart as error:
                self._remark(call, f"{error}; it is left out")
                return []
        if call.name in ("circle", "square", "polygon"):
            self._remark(call, "is flat and encloses nothing; it is left out")
            return []
        raise arguments.refuse("is no module of a .csg file: `openscad -o model.csg model.scad` writes one")

    def _builders(self) -> dict[str, Callable[[CallArguments], Solid]]:
        """Return the builders of solids by the names of modules."""
        return {
            "cube": solids.cube,
            "sphere": lambda arguments: solids.sphere(arguments, self.smooth),
            "cylinder": lambda arguments: solids.cylinder(arguments, self.smooth),
            "polyhedron": solids.polyhedron,
            "linear_extrude": self._extruded,
            "rotate_extrude": self._revolved,
        }

    def _arguments(self, call: CsgCall) -> CallArguments:
        arguments = CallArguments(self.text, call)
        for name in arguments.unknown():
            self._remark(call, f"has no parameter {shorten(name)!r}, which is not read")
        return arguments

    def _remark(self, call: CsgCall, message: str) -> None:
        line, _ = self.text.place(call.position)
        self.remarks.append(f"line {line}: {call.name} {message}")

    def _moved(self, call: CsgCall, arguments: CallArguments) -> list[ColoredSolid]:
        """Return the children of a multmatrix, moved."""
        matrix = arguments.matrix()
        if self._loses_all(call, matrix):
            return []
        rows, moved = matrix.tolist(), []
        for part in self.parts(call.children):
            moved.append(ColoredSolid(arguments.build(partial(part.solid.transform, rows)), part.color))
        return moved

    def _loses_all(self, call: CsgCall, matrix: np.ndarray[Any, Any]) -> bool:
        """Return whether a motion leaves nothing of its children, and remark it: a scaling by 0 or infinity."""
        loses_all = not np.isfinite(matrix).all() or bool(np.linalg.det(matrix[:3, :3]) == 0)
        if loses_all:
            self._remark(call, "flattens what it moves, or makes it infinite; it is left out")
        return loses_all

    def _colored(self, call: CsgCall, arguments: CallArguments) -> list[ColoredSolid]:
        """Return the children of a color, in this colour."""
        value = arguments.value("c")
        if not isinstance(value, list) or len(value) < 3 or not all(isinstance(v, float) for v in value):
            raise arguments.refuse(f"must have a list of red, green, blue and alpha, got {value!s:.60}")
        if value[0] < 0:  # a negative channel means no colour: the children keep theirs
            return self.parts(call.children)
        channels = [min(max(v, 0.0), 1.0) for v in value]
        if len(channels) > 3 and channels[3] < 1:
            self._remark(call, f"has the opacity {channels[3]:g}, which is not read")
        color = "#" + "".join(f"{round(255 * v):02x}" for v in channels[:3])
        return [ColoredSolid(part.solid, color) for part in self.parts(call.children)]

    def _combined(self, call: CsgCall) -> list[ColoredSolid]:
        """Return the difference or intersection of the children, each child being one operand.

        The result has the colour of the first operand; walls that another operand cuts have the colour of the cutter.
        """
        operands = []
        for child in call.children:
            parts = self.parts([child])
            # An empty child is an operand too: the intersection with it is empty, and so is a difference from it
            if _counts(child):
                operands.append(parts)
        if not operands or not operands[0] or (call.name == "intersection" and not all(operands)):
            return []
        color = operands[0][0].color
        united = [_unite_parts([_paint_walls(part, color) for part in parts]) for parts in operands if parts]
        if len(united) == 1:
            return [ColoredSolid(united[0], color)]
        return [
            ColoredSolid(Difference(tuple(united)) if call.name == "difference" else Intersection(tuple(united)), color)
        ]

    # Figures in the plane

    def _extruded(self, arguments: CallArguments) -> Solid:
        """Return the solid of a linear_extrude."""
        drawn = self._drawn(arguments)
        height = arguments.number("height", arguments.number("h", 100.0))
        twist = arguments.number("twist", 0.0)
        if twist:
            raise OmittedPart(f"has the twist {twist:g}, and a twisted side is no quadric")
        scale = arguments.value("scale")
        # Two different factors make sides that are no planes
        scales = scale if isinstance(scale, list) else [scale if scale is not None else 1.0] * 2
        if len(scales) != 2 or not all(isinstance(s, float) for s in scales):
            raise ValueError(f"scale must be one or two numbers, got {scale!s:.40}")
        if not all(0 <= s < math.inf for s in scales):
            raise OmittedPart(f"has the scale {scale!s:.40}")
        if scales[0] != scales[1]:
            raise OmittedPart(f"has two scales, {scales[0]:g} and {scales[1]:g}, between which no side is a plane")
        if not height > 0:
            raise OmittedPart(f"has the height {height:g}")
        along = arguments.value("v")
        if along is not None and not (isinstance(along, list) and along[:2] == [0, 0] and len(along) == 3):
            raise OmittedPart(f"is extruded along {along!s:.40}, which is not read")
        low = -height / 2 if arguments.flag("center") else 0.0
        return drawn.extruded(low, low + height, scales[0])

    def _revolved(self, arguments: CallArguments) -> Solid:
        """Return the solid of a rotate_extrude."""
        angle = arguments.number("angle", 360.0)
        if angle == 0:
            raise OmittedPart("has the angle 0")
        is_full = abs(angle) >= 360
        # A full turn begins on the -x axis where a file does not say otherwise, as in OpenSCAD 2021.01
        start = arguments.number("start", 180.0 if is_full else 0.0)
        start, end = (start, start + 360) if is_full else (start + min(angle, 0), start + max(angle, 0))
        return self._drawn(arguments).turned(start, end, arguments.sides(self.smooth))

    def _drawn(self, arguments: CallArguments) -> PlaneItem:
        """Return the union of the figures in a call. Raise OmittedPart if it has none."""
        parts = self._flat(arguments.call.children)
        if not parts:
            raise OmittedPart("holds no circle, square or polygon")
        return combine_figures(Union, parts)

    def _flat(self, calls: Sequence[CsgCall]) -> list[PlaneItem]:
        """Return the figures of calls in the plane."""
        figures: list[PlaneItem] = []
        for call in calls:
            arguments = self._arguments(call)
            if not _counts(call):
                continue
            if call.name in (*_GROUP_CALLS, "color"):
                figures += self._flat(call.children)
            elif call.name in ("difference", "intersection"):
                # As in space, an empty child is an operand
                parts = [self._flat([child]) for child in call.children if _counts(child)]
                if parts and parts[0] and (call.name == "difference" or all(parts)):
                    kind = Difference if call.name == "difference" else Intersection
                    figures.append(combine_figures(kind, [combine_figures(Union, part) for part in parts if part]))
            elif call.name == "multmatrix":
                matrix = arguments.matrix()
                matrix[2], matrix[:2, 2] = (0, 0, 1, 0), 0  # the part of the motion within the plane
                if not self._loses_all(call, matrix):
                    figures += [part.moved(matrix) for part in self._flat(call.children)]
            elif call.name in UNSUPPORTED_CALLS:
                self._remark(call, f"is {UNSUPPORTED_CALLS[call.name]}, and left out")
            else:
                try:
                    figures.append(arguments.build(partial(self._one_flat, arguments)))
                except OmittedPart as error:
                    self._remark(call, f"{error}; it is left out")
        return figures

    def _one_flat(self, arguments: CallArguments) -> PlaneItem:
        """Return a circle, square or polygon."""
        name = arguments.call.name
        if name == "circle":
            return plane_circle(arguments.radius("", 1.0), arguments.sides(self.smooth))
        if name == "square":
            size = arguments.value("size")
            sizes = [size] * 2 if isinstance(size, float) else size if isinstance(size, list) else [1.0] * 2
            if len(sizes) != 2 or not all(isinstance(s, float) for s in sizes):
                raise ValueError(f"size must be two numbers, got {size!s:.40}")
            if not all(0 < s < math.inf for s in sizes):
                raise OmittedPart(f"has the size {size!s:.40}")
            x, y = (-sizes[0] / 2, -sizes[1] / 2) if arguments.flag("center") else (0.0, 0.0)
            return plane_polygon([(x, y), (x + sizes[0], y), (x + sizes[0], y + sizes[1]), (x, y + sizes[1])], None)
        if name == "polygon":
            points = arguments.rows("points", 2)
            paths = arguments.value("paths")
            return plane_polygon(points, None if paths is None else arguments.paths("paths", len(points)))
        if name in self._builders():  # OpenSCAD warns that it mixes figures and solids, and goes on
            raise OmittedPart("is no figure of the plane")
        raise arguments.refuse("is nothing of the plane, which cannot be extruded here")


def _counts(call: CsgCall) -> bool:
    """Return whether a call is part of the model, neither disabled nor in the background."""
    return not {"*", "%"} & set(call.modifier)


def _root_call(calls: Sequence[CsgCall]) -> CsgCall | None:
    """Return the first call with the modifier "!", at any depth, or None."""
    for call in calls:
        if "*" in call.modifier:
            continue
        root = call if "!" in call.modifier else _root_call(call.children)
        if root is not None:
            return root
    return None


def _paint_walls(part: ColoredSolid, outer_color: str | None) -> Solid:
    """Return a solid with its colour on its walls if that differs from the colour around it."""
    return part.solid if part.color is None or part.color == outer_color else part.solid.painted(matte(part.color))


def _unite_parts(parts: list[Any]) -> Solid:
    return parts[0] if len(parts) == 1 else Union(tuple(parts))


# Import: one body for each colour; bodies do not overlap.

DEFAULT_COLOR = "#f9d72c"
"""The yellow in which OpenSCAD shows solids without a colour."""


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import a .csg file: one body for each colour.

    Parameters
    ----------
    path
        The file.
    options
        Options of the import; `strict` and `smooth` apply.

    Raises
    ------
    SceneFileError
        The file has errors.
    ValueError
        An option does not apply to OpenSCAD.

    """
    options.refuse_others("an OpenSCAD model", "strict", "smooth")
    text = CsgText(Path(path))
    reader = CsgReader(text)
    calls = reader.calls()
    reader.end()
    evaluation = CsgEvaluation(text, options.smooth)
    root = _root_call(calls)
    parts = evaluation.parts(calls if root is None else [root])
    bodies = _color_bodies(parts)
    legend = tuple(LegendEntry(None, "", body.name, 1) for body in bodies)
    remarks = tuple(limit_notes(evaluation.remarks))
    facts = [f"{format_count(len(parts), 'solid')} of {format_count(len(bodies), 'colour')}"]
    if evaluation.rounded:
        facts.append(f"{format_count(evaluation.rounded, 'circle')} with $fn made round")
    names = {body.material: body.name for body in bodies if body.name}
    return ImportResult(bodies, legend, (*facts, *remarks), remarks, names, unit="mm")


def _color_bodies(parts: list[ColoredSolid]) -> list[Body]:
    """Return a body for each colour: the union of its solids, less the solids of the colours before it."""
    colors = list(dict.fromkeys(part.color or DEFAULT_COLOR for part in parts))
    bodies: list[Body] = []
    before: list[tuple[Solid, BoxEnds]] = []
    for color in colors:
        # Overlapping solids of two colours: the first listed has the common part, as the first listed body has in a
        # scene
        these = [part.solid for part in parts if (part.color or DEFAULT_COLOR) == color]
        whole = these[0] if len(these) == 1 else Union(tuple(these))
        whole_box = whole.bounds
        # A solid that the file subtracts already need not be subtracted again.
        cut = whole.operands[1:] if isinstance(whole, Difference) and whole.motion.is_identity else ()
        near = [solid for solid, box in before if _boxes_overlap(box, whole_box) and solid not in cut]
        bodies.append(Body(Difference((whole, *near)) if near else whole, matte(color, name=color), color))
        before += [(solid, solid.bounds) for solid in these]
    return bodies


def _boxes_overlap(one: BoxEnds, other: BoxEnds) -> bool:
    """Return True if two boxes have a point in common."""
    (low, high), (other_low, other_high) = one, other
    return bool(np.all(low <= other_high) and np.all(other_low <= high))
