"""The cards of the data block that say something of the geometry: TR, M, and what may be said of cells there."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction

from ..nodes import shortened
from .cards import Card
from .numbers import entries, number
from .transformations import Change, change_of

_NAME = re.compile(r"(\*?)([a-z]+)([0-9]{0,9})(\*|:\S+)?")
PER_CELL = ("imp", "u", "lat", "fill", "trcl")
Shares = dict[str, dict[str, Fraction]]


@dataclass
class Data:
    """Transformations and materials by number; entries for the cells in their order, by name."""

    changes: dict[int, Change] = field(default_factory=dict)
    materials: dict[int, Shares] = field(default_factory=dict)
    cells: dict[str, tuple[Card, list[Fraction | None]]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def read(self, card: Card) -> None:
        """One card. Raises ValueError."""
        name, *words = card.text.split()
        found = _NAME.fullmatch(name)
        if found is None:
            self.remarks.append(f"line {card.line}: {shortened(name, 20)!r} is not read")
            return
        star, kind, digits, particles = found.groups()
        if particles == "*":
            star, particles = "*", None
        if kind == "tr":
            key = int(digits or 1)
            if key in self.changes:
                raise ValueError(f"tr{key} is given twice")
            self.changes[key] = Change()  # so that nothing is said against those that refer to a broken one
            self.changes[key] = change_of(entries(words), bool(star))
        elif kind == "m" and digits and int(digits):
            if int(digits) in self.materials:
                raise ValueError(f"m{int(digits)} is given twice")
            self.materials[int(digits)] = _shares(words)
        elif kind in PER_CELL and not digits:
            if kind in ("fill", "trcl") and (star or ":" in card.text or "(" in card.text):
                raise ValueError(f"{kind} in the data block is read with one number for each cell only")
            self.cells[kind + (particles or "")] = card, entries(words)
        elif kind == "void":
            self.remarks.append(f"line {card.line}: the card VOID is not obeyed: cells keep their materials")


def _shares(words: list[str]) -> Shares:
    """Atom fractions ("ao"), or, written as negative numbers, weight fractions ("wo")."""
    found: Shares = {"ao": {}, "wo": {}}
    at = 0
    while at < len(words):
        name = words[at]
        if at + 1 >= len(words):
            raise ValueError(f"a fraction is missing after {shortened(name, 20)!r}")
        if re.fullmatch(r"[0-9]+(\.[0-9a-z]+)?", name):
            share = number(words[at + 1])
            shares = found["wo" if share < 0 else "ao"]
            shares[name] = shares.get(name, Fraction(0)) + abs(share)
        elif not re.match(r"[a-z]", name):
            raise ValueError(f"{shortened(name, 20)!r} is no nuclide")
        at += 2
    return found
