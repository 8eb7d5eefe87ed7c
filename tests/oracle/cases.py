"""A shape by name, parameters and motion steps, from which both sides are built: the library's and the oracle's."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .formula import Not, carried, unnumbered
from .frames import Affine, chain
from .sheets import SHEETS, clipped, sheet_carried
from .solids import COMBINED, SOLIDS


@dataclass(frozen=True)
class Case:
    """A shape by name, parameters and motion steps.

    `center` and `size` are, before the motion, a point in the midst of it and its largest extent;
    for an unbounded shape `size` is its scale and `bounded` is False.
    """

    kind: str
    parameters: dict[str, Any]
    center: tuple[float, ...]
    size: float
    bounded: bool = True
    steps: tuple[tuple[Any, ...], ...] = ()
    operands: tuple[Case, ...] = field(default=())

    @property
    def motion(self) -> Affine:
        return chain(self.steps)

    @property
    def world_center(self) -> np.ndarray:
        return np.array([float(x) for x in self.motion.point(self.center)])

    @property
    def world_size(self) -> float:
        rows = np.array([[float(x) for x in row] for row in self.motion.rows])
        return self.size * float(np.linalg.norm(rows, 2))

    @property
    def is_sheet(self) -> bool:
        return self.kind in SHEETS or self.kind == "ClippedSheet"

    def reference(self) -> Any:
        """The oracle's formula or sheet."""
        if self.kind == "ClippedSheet":
            base, solid = (operand.reference() for operand in self.operands)
            sheet = clipped(base, Not(solid) if self.parameters["keep"] == "outside" else solid)
            return sheet_carried(sheet, self.motion.inverse()) if self.steps else sheet
        if self.operands:
            formula = COMBINED[self.kind](*(unnumbered(operand.reference()) for operand in self.operands))
        elif self.is_sheet:
            sheet = SHEETS[self.kind](**self.parameters)
            return sheet_carried(sheet, self.motion.inverse()) if self.steps else sheet
        else:
            formula = SOLIDS[self.kind](**self.parameters)
        return carried(formula, self.motion.inverse()) if self.steps else formula

    def shape(self, library: Any) -> Any:
        """The library's shape, through the public interface."""
        if self.operands:
            shape = _combine(
                self.kind,
                [operand.shape(library) for operand in self.operands],
                self.parameters.get("keep") == "outside",
            )
        else:
            parameters = dict(self.parameters)
            if parameters.get("within") is not None:
                parameters["within"] = library.Box(*parameters["within"])
            shape = getattr(library, self.kind)(**parameters)
        for verb, *arguments in self.steps:
            shape = getattr(shape, verb)(*arguments)
        return shape


def _combine(kind: str, shapes: list[Any], outside: bool = False) -> Any:
    result = shapes[0]
    if kind == "ClippedSheet":
        return result - shapes[1] if outside else result & shapes[1]
    if kind == "Complement":
        return ~result
    for shape in shapes[1:]:
        result = result | shape if kind == "Union" else result & shape if kind == "Intersection" else result - shape
    return result
