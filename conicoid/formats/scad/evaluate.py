"""Calls as solids, each with the colour that it stands in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...shapes.base import Solid
from ...shapes.looks import matte
from ...shapes.region import Difference, Intersection, Union
from . import solids
from .flat import Drawn, circle, combined, polygon
from .syntax import Call, Text
from .values import Arguments

REFUSED = {
    "hull": "the convex hull of its children",
    "minkowski": "the sum of its children", "text": "letters", "import": "a file",
    "surface": "a height field", "projection": "a projection", "offset": "an outline at a distance",
    "resize": "a size that depends on its children",
}  # fmt: skip
"""Modules whose results are no quadric solids of ours, or not yet."""
_GROUPS = ("group", "union", "render", "root")


@dataclass(frozen=True)
class Part:
    """A solid, and its colour in sRGB, None where it has none of its own."""

    solid: Solid
    color: str | None = None


class Evaluation:
    """What the calls of a file are; what cannot be said is left out, and told."""

    def __init__(self, text: Text, smooth: bool) -> None:
        self.text, self.smooth = text, smooth
        self.remarks: list[str] = []
        self.rounded = 0
        """How many circles are round though $fn is above 0."""

    def parts(self, calls: Sequence[Call]) -> list[Part]:
        """The solids of calls that stand beside one another."""
        found: list[Part] = []
        for call in calls:
            if "*" in call.modifier:
                continue
            if "%" in call.modifier:
                self._tell(call, "is in the background (%) and left out")
                continue
            found += self._parts_of(call)
        return found

    def _parts_of(self, call: Call) -> list[Part]:
        given = Arguments(self.text, call)
        if self.smooth and isinstance(given.given("$fn"), float) and given.given("$fn") > 0:
            self.rounded += 1
        if call.name in _GROUPS:
            return self.parts(call.children)
        if call.name == "multmatrix":
            return self._moved(call, given)
        if call.name == "color":
            return self._colored(call, given)
        if call.name in ("difference", "intersection"):
            return self._combined(call)
        if call.name in REFUSED:
            self._tell(call, f"is {REFUSED[call.name]}, and left out")
            return []
        make = self._makers().get(call.name)
        if make is not None:
            return [Part(given.made(lambda: make(given)))]
        if call.name in ("circle", "square", "polygon"):
            self._tell(call, "is flat and encloses nothing; it is left out")
            return []
        raise given.refuse("is no module of a .csg file: `openscad -o model.csg model.scad` writes one")

    def _makers(self) -> dict[str, Callable[[Arguments], Solid]]:
        return {
            "cube": solids.cube,
            "sphere": lambda given: solids.sphere(given, self.smooth),
            "cylinder": lambda given: solids.cylinder(given, self.smooth),
            "polyhedron": solids.polyhedron,
            "linear_extrude": self._extruded,
            "rotate_extrude": self._turned,
        }

    def _tell(self, call: Call, message: str) -> None:
        line, _ = self.text.place(call.position)
        self.remarks.append(f"line {line}: {call.name} {message}")

    def _moved(self, call: Call, given: Arguments) -> list[Part]:
        matrix = given.matrix()
        if abs(np.linalg.det(matrix[:3, :3])) == 0:
            self._tell(call, "flattens what it moves, which is left out")
            return []
        rows, found = matrix.tolist(), []
        for part in self.parts(call.children):
            found.append(Part(given.made(partial(part.solid.transform, rows)), part.color))
        return found

    def _colored(self, call: Call, given: Arguments) -> list[Part]:
        value = given.given("c") or given.given("0")
        if not isinstance(value, list) or len(value) < 3 or not all(isinstance(v, float) for v in value):
            raise given.refuse(f"must have a list of red, green, blue and alpha, got {value!s:.60}")
        if value[0] < 0:  # no colour: those of the children stay
            return self.parts(call.children)
        channels = [min(max(v, 0.0), 1.0) for v in value]
        if len(channels) > 3 and channels[3] < 1:
            self._tell(call, f"has the opacity {channels[3]:g}, which is not read")
        color = "#" + "".join(f"{round(255 * v):02x}" for v in channels[:3])
        return [Part(part.solid, color) for part in self.parts(call.children)]

    def _combined(self, call: Call) -> list[Part]:
        """Each child is one operand, of whatever it holds; the first gives the colour, cuts keep that of the cutter."""
        operands = []
        for child in call.children:
            parts = self.parts([child])
            if parts or "*" not in child.modifier:
                operands.append(parts)
        if not operands or not operands[0] or (call.name == "intersection" and not all(operands)):
            return []
        color = operands[0][0].color
        made = [_united([_painted(part, color) for part in parts]) for parts in operands if parts]
        if len(made) == 1:
            return [Part(made[0], color)]
        return [Part(Difference(tuple(made)) if call.name == "difference" else Intersection(tuple(made)), color)]

    # ---- In the plane ----

    def _extruded(self, given: Arguments) -> Solid:
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

    def _turned(self, given: Arguments) -> Solid:
        angle = given.number("angle", 360.0)
        start = given.number("start", 0.0)
        start, end = (start, start + angle) if angle > 0 else (start + angle, start)
        if abs(angle) >= 360 or angle == 0:
            start, end = 0.0, 360.0
        return self._drawn(given).turned(start, end, given.sides(self.smooth))

    def _drawn(self, given: Arguments) -> Drawn:
        parts = self._flat(given.call.children)
        if not parts:
            raise ValueError("must have something of the plane in it: a circle, a square or a polygon")
        return combined(Union, parts)

    def _flat(self, calls: Sequence[Call]) -> list[Drawn]:
        found: list[Drawn] = []
        for call in calls:
            given = Arguments(self.text, call)
            if "*" in call.modifier or "%" in call.modifier:
                continue
            if call.name in (*_GROUPS, "color"):
                found += self._flat(call.children)
            elif call.name in ("difference", "intersection"):
                operands = [combined(Union, parts) for child in call.children if (parts := self._flat([child]))]
                if operands:
                    found.append(combined(Difference if call.name == "difference" else Intersection, operands))
            elif call.name == "multmatrix":
                matrix = given.matrix()
                matrix[2], matrix[:2, 2] = (0, 0, 1, 0), 0
                found += [part.moved(matrix) for part in self._flat(call.children)]
            else:
                found.append(given.made(partial(self._one_flat, given)))
        return found

    def _one_flat(self, given: Arguments) -> Drawn:
        name = given.call.name
        if name == "circle":
            return circle(given.number("r", given.number("d", 2.0) / 2), given.sides(self.smooth))
        if name == "square":
            size = given.given("size")
            sizes = [size] * 2 if isinstance(size, float) else size if isinstance(size, list) else [1.0] * 2
            if len(sizes) != 2 or not all(isinstance(s, float) and s > 0 for s in sizes):
                raise ValueError(f"size must be two numbers > 0, got {size!s:.40}")
            x, y = (-sizes[0] / 2, -sizes[1] / 2) if given.flag("center") else (0.0, 0.0)
            return polygon([(x, y), (x + sizes[0], y), (x + sizes[0], y + sizes[1]), (x, y + sizes[1])], None)
        if name == "polygon":
            points = given.rows("points", 2)
            paths = given.given("paths")
            return polygon(points, None if paths is None else given.paths("paths", len(points)))
        raise given.refuse(f"is {REFUSED.get(name, 'nothing of the plane')}, which cannot be extruded here")


def _painted(part: Part, around: str | None) -> Solid:
    """A solid with its own colour on its walls, where that is not the colour around it."""
    return part.solid if part.color is None or part.color == around else part.solid.painted(matte(part.color))


def _united(parts: list[Any]) -> Solid:
    return parts[0] if len(parts) == 1 else Union(tuple(parts))
