"""The numbers of bodies worked out alone, but for their boxes: those of primitives that several bodies share, once.

Cells of one universe meet at its surfaces, so that each surface bounds several bodies, and bodies that are one another
moved have some in common.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ...shapes.base import Shape, Solid
from ...shapes.cells import Cell
from ...shapes.motion import STILL, Motion
from ...shapes.steps import Step
from ..tables import Floats
from .assembly import Assembly
from .parts import numbers_of_surfaces, own_frame
from .plan import primitives
from .said import said
from .trees import Faces, world_tree

_Lists: TypeAlias = tuple[list[float], list[float]]


class Alone:
    """Works out bodies one by one, and remembers their primitives."""

    def __init__(self) -> None:
        self._known: dict[Hashable, _Lists] = {}

    def numbers(self, shape: Shape) -> Floats:
        """The row of a solid's numbers but for its boxes: its surfaces, the uv of its faces, the way to its frame."""
        surfaces: list[float] = []
        uv: list[float] = []
        for leaf, steps in primitives(shape):
            own = self._of(leaf, steps)
            surfaces += own[0]
            uv += own[1]
        return np.array([*surfaces, *uv, *(number for line in own_frame(shape).inverse_rows for number in line)])

    def _of(self, leaf: Shape, steps: tuple[Step, ...]) -> _Lists:
        """(numbers of surfaces, of uv) of a primitive that steps move, by what was said of both to the last bit."""
        told = [said(leaf), *map(said, steps)]
        if None in told:
            return _worked_out(leaf, steps)
        key = tuple((each.form, np.array(each.numbers).tobytes()) for each in told if each is not None)
        if key not in self._known:
            self._known[key] = _worked_out(leaf, steps)
        return self._known[key]


def _worked_out(leaf: Shape, steps: tuple[Step, ...]) -> _Lists:
    """`Alone._of`, computed."""
    assert isinstance(leaf, Solid)
    assembly, faces = Assembly(), Faces()
    tree = world_tree(replace(leaf, motion=Motion(steps)), STILL, faces)
    if isinstance(tree, Cell):
        assembly.cell(tree)
    else:
        assembly.program(tree, {})
    return numbers_of_surfaces(assembly), [number for _, numbers in faces.rows for number in numbers]
