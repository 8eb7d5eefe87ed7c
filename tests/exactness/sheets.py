"""The sheets: a surface, the closed formula or the loop that bounds it, and the side of its normal."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flint import fmpq

from .forms import Affine, Form, carried, plane
from .rational import ZERO, cross, dot, exactly, minus, vector
from .solids import Axis, Formula, cell, cylinder_side, diagonal, mapped, walls

Point = tuple[fmpq, ...]


@dataclass(frozen=True)
class ExactSheet:
    """`surface` within `clip` and within the closed polygon `loop` (even-odd)."""

    surface: Form
    clip: Formula | None = None
    loop: tuple[Point, ...] = ()
    one_sided: bool = False

    def moved(self, motion: Affine) -> ExactSheet:
        """The gradient stays on its physical side, mirror or not."""
        back = motion.inverse()
        return replace(
            self,
            surface=carried(self.surface, back),
            clip=None if self.clip is None else mapped(self.clip, lambda f: carried(f, back)),
            loop=tuple(motion.point(p) for p in self.loop),
        )

    def clipped(self, solid: Formula) -> ExactSheet:
        return replace(self, clip=solid if self.clip is None else ("all", (self.clip, solid)))


def disc(center: Any, normal: Any, radius: Any) -> ExactSheet:
    ball = cell(diagonal((1, 1, 1), -(exactly(radius) ** 2), center=center))
    return ExactSheet(plane(normal, dot(vector(normal), vector(center))), ball)


def polygon(vertices: Any) -> ExactSheet:
    """The plane is Newell's, through the mean of the vertices."""
    points = [vector(v) for v in vertices]
    spokes = [minus(p, points[0]) for p in points]
    normal: Sequence[fmpq] = (ZERO,) * 3
    for p, q in itertools.pairwise(spokes):
        normal = [a + b for a, b in zip(normal, cross(p, q), strict=True)]
    middle = [sum((p[i] for p in points), ZERO) / len(points) for i in range(3)]
    return ExactSheet(plane(normal, dot(normal, middle)), loop=tuple(points))


def cylinder_patch(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> ExactSheet:
    axis = Axis(start, end, reference)
    sides, convex = walls(axis, start_angle, end_angle)
    clip: Formula = cell(*axis.caps(), *(sides if convex else ()))
    if not convex:
        clip = ("all", (clip, ("any", tuple(cell(side) for side in sides))))
    return ExactSheet(cylinder_side(axis, radius), clip)


SHEETS: dict[str, Callable[..., ExactSheet]] = {
    "Plane": lambda normal, offset, one_sided=False: ExactSheet(plane(normal, offset), one_sided=one_sided),
    "Disc": disc,
    "Triangle": lambda a, b, c: polygon((a, b, c)),
    "Polygon": polygon,
    "CylinderPatch": cylinder_patch,
}
