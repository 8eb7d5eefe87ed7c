"""Scenes of a user: a shape by name, parameters, operands and motion steps, which both sides take."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from .forms import chain

Step = tuple[Any, ...]
SHEETS = ("Plane", "Disc", "Triangle", "Polygon", "CylinderPatch", "ClippedSheet")
SIGN = {"Union": "|", "Intersection": "&", "Difference": "-"}
OPERATION = {"|": operator.or_, "&": operator.and_, "-": operator.sub}


@dataclass(frozen=True)
class Item:
    """A shape with `steps` in the user's order.

    `paper`, where it is not None, are other steps that are equal to them in real numbers. `center` and `size` are,
    before the motion, a point in the midst of it and its largest extent, or its scale.
    """

    kind: str
    parameters: dict[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    operands: tuple[Item, ...] = ()
    paper: tuple[Step, ...] | None = None
    center: tuple[float, ...] = (0.0, 0.0, 0.0)
    size: float = 8.0
    bounded: bool = True

    @property
    def exact_steps(self) -> tuple[Step, ...]:
        return self.steps if self.paper is None else self.paper

    @property
    def is_sheet(self) -> bool:
        return self.kind in SHEETS

    @cached_property
    def world_center(self) -> np.ndarray:
        return np.array([float(x) for x in chain(self.exact_steps).point(self.center)])

    @cached_property
    def world_size(self) -> float:
        rows = np.array([[float(x) for x in r] for r in chain(self.exact_steps).rows])
        return self.size * float(np.linalg.norm(rows, 2))

    def moved(self, *steps: Step, paper: tuple[Step, ...] | None = None) -> Item:
        """Return it moved by some more steps, which equal `paper` in real numbers."""
        known = None
        if self.paper is not None or paper is not None:
            known = (*self.exact_steps, *(steps if paper is None else paper))
        return replace(self, steps=(*self.steps, *steps), paper=known)

    def numbers(self) -> Iterator[float]:
        """Return every finite number of the user's."""
        yield from _flat([*self.parameters.values(), *(step[1:] for step in self.steps)])
        for operand in self.operands:
            yield from operand.numbers()

    def shape(self, library: Any) -> Any:
        """Return the library's shape, by its public interface."""
        made = self._combined(library) if self.operands else self._plain(library)
        for verb, *arguments in self.steps:
            made = getattr(made, verb)(*arguments)
        return made

    def _plain(self, library: Any) -> Any:
        parameters = dict(self.parameters)
        if parameters.get("within") is not None:
            parameters["within"] = library.Box(*parameters["within"])
        return getattr(library, self.kind)(**parameters)

    @property
    def _sign(self) -> str:
        return SIGN.get(self.kind) or ("-" if self.parameters["keep"] == "outside" else "&")

    def _combined(self, library: Any) -> Any:
        first, *others = (operand.shape(library) for operand in self.operands)
        if self.kind == "Complement":
            return ~first
        for other in others:
            first = OPERATION[self._sign](first, other)
        return first

    def __repr__(self) -> str:
        """Print it as a user would type it, but for spheres in bulk within Booleans, which no generator makes."""
        if self.kind == "Complement":
            text = f"(~{self.operands[0]!r})"
        elif self.operands:
            text = "(" + f" {self._sign} ".join(map(repr, self.operands)) + ")"
        else:
            values = (
                f"{k}={f'co.Box{v!r}' if k == 'within' and v is not None else repr(v)}"
                for k, v in self.parameters.items()
            )
            text = f"co.{self.kind}({', '.join(values)})"
        return text + "".join(f".{verb}({', '.join(map(repr, arguments))})" for verb, *arguments in self.steps)


def _flat(value: Any) -> Iterator[float]:
    if isinstance(value, (dict, list, tuple)):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _flat(item)
    elif isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value):
        yield float(value)


def combined(kind: str, *items: Item, **more: Any) -> Item:
    return Item(kind, operands=items, **more)


def clipped(sheet: Item, solid: Item, keep: str = "inside", **more: Any) -> Item:
    return Item("ClippedSheet", {"keep": keep}, operands=(sheet, solid), **more)
