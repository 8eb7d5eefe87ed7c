"""Find the cell at a point by MCNP's rules, in floats: regions, universes, lattices and transformations.

A model has everything twice: `text` is the deck, and the other fields are for this evaluator, written by hand.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .senses import Mask, Points, Sense

Change = tuple[Any, Any]
"""Origin and rows: x' = rows (x - origin)."""


@dataclass
class Lattice:
    """The steps from an element to the next, and the content of each: a universe, or None for the cell's own material."""

    ways: Any
    entries: dict[tuple[int, int, int], Any]


@dataclass
class CellModel:
    """A card, with its region, universe and filling for the evaluator."""

    text: str
    region: str
    u: int = 0
    fill: int | None = None
    into: Change | None = None
    moved: Change | None = None
    lattice: Lattice | None = None
    is_outside: bool = False

    @property
    def number(self) -> int:
        return int(self.text.split()[0])


@dataclass
class Model:
    """A deck and its meaning."""

    cells: list[CellModel]
    surfaces: dict[int, tuple[str, Sense]]
    data: str = ""
    moves: dict[int, Change] = field(default_factory=dict)  # of surfaces

    @property
    def text(self) -> str:
        cells = "\n".join(cell.text for cell in self.cells)
        surfaces = "\n".join(f"{number} {card}" for number, (card, _) in self.surfaces.items())
        return f"title\n{cells}\n\n{surfaces}\n\n{self.data}\n"

    def names(self, points: Points) -> list[str | None]:
        found: Any = np.full(len(points), None, object)
        self._find(0, points, np.arange(len(points)), (), found)
        return list(found)

    def _find(self, universe: int, points: Points, at: Any, path: tuple[str, ...], found: Any) -> None:
        for cell in self.cells:
            if cell.u != universe or cell.is_outside:
                continue
            if cell.lattice is not None:
                self._elements(cell, cell.lattice, points, at, path, found)
                continue
            inside = self.within(cell, points)
            if cell.fill is None:
                self._name(cell, at[inside], path, found)
            else:
                inner = carried(points[inside], cell.into or cell.moved)
                self._find(cell.fill, inner, at[inside], (*path, f"cell {cell.number}"), found)

    def _elements(self, cell: CellModel, lattice: Lattice, points: Points, at: Any, path: Any, found: Any) -> None:
        points = carried(points, cell.moved)
        for index, entry in lattice.entries.items():
            own = points - sum(
                (i * np.array(way, float) for i, way in zip(index, lattice.ways, strict=False)), np.zeros(3)
            )
            inside = self._region(cell.region, own)
            step = (*path, f"cell {cell.number}", f"lattice [{', '.join(map(str, index))}]")
            if entry is None:
                self._name(cell, at[inside], step, found)
                continue
            universe, change = entry if isinstance(entry, tuple) else (entry, None)
            self._find(universe, carried(own[inside], change), at[inside], step, found)

    def _name(self, cell: CellModel, at: Any, path: tuple[str, ...], found: Any) -> None:
        found[at] = f"cell {cell.number}" + (f" @ {', '.join(path)}" if path else "")

    def within(self, cell: CellModel, points: Points) -> Mask:
        """Return which points are in a cell's region."""
        return self._region(cell.region, carried(points, cell.moved))

    def _region(self, text: str, points: Points) -> Mask:
        """Evaluate the region by Python's operators, which bind as MCNP's do."""
        by_number = {cell.number: cell for cell in self.cells}
        functions: dict[str, Callable[..., Mask]] = {
            "S": lambda n: carried_sense(self.surfaces[n][1], self.moves.get(n), points),
            "C": lambda n: self.within(by_number[n], points),
        }
        words = re.findall(r"#\d+|[-+]?\d+|[#:()]", text)
        code = ""
        for before, word in zip(["", *words], words, strict=False):
            if before not in ("", ":", "(", "#") and word not in (":", ")"):
                code += " & "
            if word == ":":
                code += " | "
            elif word in ("(", ")"):
                code += word
            elif word == "#":
                code += "~"
            elif word[0] == "#":
                code += f"~C({word[1:]})"
            else:
                code += f"{'~' if word[0] == '-' else ''}S({word.lstrip('+-')})"
        return np.asarray(eval(code, functions))


def carried(points: Points, change: Change | None) -> Points:
    """Return main coordinates as auxiliary ones."""
    if change is None:
        return points
    origin, rows = change
    return (points - np.array(origin, float)) @ np.array(rows, float).T


def carried_sense(sense: Sense, change: Change | None, points: Points) -> Mask:
    return sense(carried(points, change))
