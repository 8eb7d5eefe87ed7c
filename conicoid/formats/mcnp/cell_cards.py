"""MCNP's cell cards: number, material, density, region and what else is said of a cell."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

from ...shapes.suggestion import did_you_mean
from ..nodes import shortened
from .cards import Card
from .numbers import integer, number

_WORD = re.compile(r"\*?[a-z]+[0-9]*(?::[^\s()=]+)?|[():#]|[^\s():#=]+")
_NAME = re.compile(r"\*?[a-z]+[0-9]*(?::.+)?")
GEOMETRY = ("u", "fill", "lat", "trcl", "imp", "mat", "rho")
OTHERS = (
    "vol", "pwt", "ext", "fcl", "wwn", "dxc", "nonu", "pd", "tmp", "cosy", "bflcl", "elpt", "unc",
)  # fmt: skip
"""About particles and tallies: not read."""


@dataclass(frozen=True)
class CellCard:
    """A cell as its card says it; `given` has the words after each name, such as "fill" or "imp:n"."""

    number: int
    card: Card
    material: int
    density: Fraction | None
    region: list[str]
    given: dict[str, list[str]] = field(default_factory=dict)

    def words(self, name: str) -> tuple[list[str], bool] | None:
        """The words of a name, and whether it was written with a star (in degrees)."""
        for star in ("", "*"):
            if star + name in self.given:
                return self.given[star + name], bool(star)
        return None


def read_cell_card(card: Card, earlier: Mapping[int, CellCard]) -> CellCard:
    """Raises ValueError."""
    words = _WORD.findall(card.text)
    if not words:
        raise ValueError("a cell begins with its number")
    found = integer("the number of a cell", words[0])
    if found < 1:
        raise ValueError(f"the number of a cell must be > 0, got {found}")
    if words[1:2] == ["like"]:
        return _like(found, card, words[2:], earlier)
    if len(words) < 2:
        raise ValueError("a cell needs a material (0 for void)")
    material, at, density = integer("the material", words[1]), 2, None
    if material < 0:
        raise ValueError(f"the material must be >= 0, got {material}")
    if material:
        if len(words) < 3:
            raise ValueError("a cell with a material needs its density")
        density, at = number(words[2]), 3
        if not density:
            raise ValueError("the density must not be 0")
    end = next((i for i in range(at, len(words)) if _NAME.fullmatch(words[i])), len(words))
    return CellCard(found, card, material, density, words[at:end], _given(words[end:]))


def _like(found: int, card: Card, words: list[str], earlier: Mapping[int, CellCard]) -> CellCard:
    """LIKE n BUT"""
    if not words:
        raise ValueError("like: 'LIKE n BUT ...' needs the number of a cell")
    other = integer("the cell after LIKE", words[0])
    if other not in earlier:
        raise ValueError(f"like: cell {other} is not defined before")
    model, given = earlier[other], _given(words[2:] if words[1:2] == ["but"] else words[1:])
    for name in ("fill", "trcl"):  # with or without a star: one takes the place of the other
        if name in given or "*" + name in given:
            model = replace(model, given={k: v for k, v in model.given.items() if k.removeprefix("*") != name})
    material, density = model.material, model.density
    if "mat" in given:
        material = integer("mat", _one("mat", given["mat"]))
    if "rho" in given:
        density = number(_one("rho", given["rho"]))
    if material and not density:
        raise ValueError("a cell with a material needs its density (rho)")
    return CellCard(found, card, material, density if material else None, model.region, {**model.given, **given})


def _one(name: str, words: list[str]) -> str:
    if len(words) != 1:
        raise ValueError(f"{name} must be one number, got {len(words)}")
    return words[0]


def _given(words: list[str]) -> dict[str, list[str]]:
    """Names with the words up to the next one. Shortcuts without a number (r, i, j, m) are words."""
    found: dict[str, list[str]] = {}
    last: list[str] | None = None
    for word in words:
        if not _NAME.fullmatch(word) or (word in ("r", "i", "j", "m") and last is not None):
            if last is None:
                raise ValueError(f"{shortened(word, 20)!r} stands where a name is expected")
            last.append(word)
            continue
        plain = re.sub(r"[0-9:].*", "", word.removeprefix("*"))
        if plain not in GEOMETRY + OTHERS:
            raise ValueError(
                f"{shortened(word, 20)!r} is nothing that a cell has{did_you_mean(plain, GEOMETRY + OTHERS)}"
            )
        if word in found:
            raise ValueError(f"{shortened(word, 20)!r} is given twice")
        last = found[word] = []
    return found
