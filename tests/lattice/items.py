"""What a user writes: a shape by name, parameters, operands and motion steps; from it come both sides, the library's and the exact."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

Step = tuple[Any, ...]
SHEETS = ("Plane", "Disc", "Triangle", "Polygon", "CylinderPatch", "ClippedSheet")
COMBINED = {"Union": "|", "Intersection": "&", "Difference": "-"}


@dataclass(frozen=True)
class Item:
    """`steps` as the user writes them. `paper`, where it is not None: other steps that are equal to them on paper."""

    kind: str
    parameters: dict[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    operands: tuple[Item, ...] = ()
    paper: tuple[Step, ...] | None = None

    @property
    def exact_steps(self) -> tuple[Step, ...]:
        return self.steps if self.paper is None else self.paper

    @property
    def is_sheet(self) -> bool:
        return self.kind in SHEETS

    def moved(self, *steps: Step, paper: tuple[Step, ...] | None = None) -> Item:
        """Moved by some steps more, which are `paper` on paper."""
        known = (
            None if self.paper is None and paper is None else (*self.exact_steps, *(steps if paper is None else paper))
        )
        return replace(self, steps=(*self.steps, *steps), paper=known)

    def shape(self, library: Any) -> Any:
        """The library's shape, by its public interface."""
        made = self._combined(library) if self.operands else self._plain(library)
        for verb, *arguments in self.steps:
            made = getattr(made, verb)(*arguments)
        return made

    def _plain(self, library: Any) -> Any:
        parameters = dict(self.parameters)
        if parameters.get("within") is not None:
            parameters["within"] = library.Box(*parameters["within"])
        return getattr(library, self.kind)(**parameters)

    def _combined(self, library: Any) -> Any:
        first, *others = (operand.shape(library) for operand in self.operands)
        if self.kind == "Complement":
            return ~first
        if self.kind == "ClippedSheet":
            return first - others[0] if self.parameters.get("keep") == "outside" else first & others[0]
        for other in others:
            first = (
                first | other
                if self.kind == "Union"
                else first & other
                if self.kind == "Intersection"
                else first - other
            )
        return first

    def __repr__(self) -> str:
        """As a user would type it, but for spheres in bulk within Booleans, which there are none of."""
        if self.kind == "Complement":
            text = f"(~{self.operands[0]!r})"
        elif self.operands:
            sign = COMBINED.get(self.kind) or ("-" if self.parameters.get("keep") == "outside" else "&")
            text = "(" + f" {sign} ".join(map(repr, self.operands)) + ")"
        else:
            text = f"co.{self.kind}({', '.join(f'{k}={_text(k, v)}' for k, v in self.parameters.items())})"
        return text + "".join(f".{verb}({', '.join(map(repr, arguments))})" for verb, *arguments in self.steps)


def _text(name: str, value: Any) -> str:
    return f"co.Box{value!r}" if name == "within" and value is not None else repr(value)


def union(*items: Item) -> Item:
    return Item("Union", operands=items)


def intersection(*items: Item) -> Item:
    return Item("Intersection", operands=items)


def difference(*items: Item) -> Item:
    return Item("Difference", operands=items)


def complement(item: Item) -> Item:
    return Item("Complement", operands=(item,))


def clipped(sheet: Item, solid: Item, keep: str = "inside") -> Item:
    return Item("ClippedSheet", {"keep": keep}, operands=(sheet, solid))
