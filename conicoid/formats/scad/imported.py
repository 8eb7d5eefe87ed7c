"""A .csg file as bodies: one for each colour, which do not overlap."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ...shapes.base import Solid
from ...shapes.body import Body
from ...shapes.looks import matte
from ...shapes.region import Difference, Union
from ...shapes.vector import Box
from ..imports.imported import Imported, LegendEntry, counted, first_few
from ..imports.options import Options
from .evaluate import Evaluation, Part
from .syntax import Reader, Text

DEFAULT = "#f9d72c"
"""What has no colour is yellow, as OpenSCAD shows it."""


def imported(path: str | os.PathLike[str], options: Options) -> Imported:
    """The solids of a file."""
    options.refuse_others("an OpenSCAD model", "strict", "smooth")
    text = Text(Path(path))
    reader = Reader(text)
    calls = reader.calls()
    reader.end()
    evaluation = Evaluation(text, options.smooth)
    parts = evaluation.parts([call for call in calls if "!" in call.modifier] or calls)
    bodies = _bodies(parts)
    legend = tuple(LegendEntry(None, "", body.name, 1) for body in bodies)
    remarks = tuple(first_few(evaluation.remarks))
    facts = [f"{counted(len(parts), 'solid')} of {counted(len(bodies), 'colour')}"]
    if evaluation.rounded:
        facts.append(f"{counted(evaluation.rounded, 'circle')} with $fn made round")
    names = {body.material: body.name for body in bodies if body.name}
    return Imported(bodies, legend, (*facts, *remarks), remarks, names)


def _bodies(parts: list[Part]) -> list[Body]:
    """A body for each colour: the union of what has it, without what came before in other colours."""
    colors = list(dict.fromkeys(part.color or DEFAULT for part in parts))
    found: list[Body] = []
    before: list[tuple[Solid, Box]] = []
    for color in colors:
        these = [part.solid for part in parts if (part.color or DEFAULT) == color]
        whole = these[0] if len(these) == 1 else Union(tuple(these))
        around = whole.bounds
        cut = whole.operands[1:] if isinstance(whole, Difference) and whole.motion.is_identity else ()
        near = [solid for solid, box in before if _may_meet(box, around) and solid not in cut]
        found.append(Body(Difference((whole, *near)) if near else whole, matte(color, name=color), color))
        before += [(solid, solid.bounds) for solid in these]
    return found


def _may_meet(one: Box, other: Box) -> bool:
    """Have two boxes a point in common?"""
    (low, high), (its_low, its_high) = one, other
    return bool(np.all(low <= its_high) and np.all(its_low <= high))
