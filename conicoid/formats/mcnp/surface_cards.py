"""MCNP's surface cards, and surfaces as regions of numbered sheets: macrobodies have several."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ..openmc.region import Both, Half, Region
from ..openmc.surface_kinds import NamedSurface
from ..openmc.surfaces import Surface
from .cards import Card
from .forms import Form, form
from .materials import BEYOND
from .numbers import integer, numbers
from .regions import joined, renumbered
from .transformations import Change, moved

_NUMBER = re.compile(r"([*+]?)([0-9]{1,9})")
_BOUNDARIES = {"": "transmission", "*": "reflective", "+": "white"}


@dataclass(frozen=True)
class SurfaceCard:
    """A surface as its card says it."""

    number: int
    boundary: str
    change: int | None  # of a TR card
    partner: int | None  # periodic with another surface
    form: Form


def read_surface_card(card: Card) -> SurfaceCard:
    """Raises ValueError."""
    words = card.text.split()
    found = _NUMBER.fullmatch(words[0])
    if found is None or not int(found[2]):
        raise ValueError(f"a surface begins with its number, got {words[0][:20]!r}")
    change = partner = None
    rest = words[1:]
    if rest and re.fullmatch(r"[-+]?[0-9]+", rest[0]):
        other = integer("a transformation", rest.pop(0))
        change, partner = (other, None) if other > 0 else (None, -other or None)
    if not rest:
        raise ValueError("a surface needs a kind, such as px")
    boundary = "periodic" if partner else _BOUNDARIES[found[1]]
    return SurfaceCard(int(found[2]), boundary, change, partner, form(rest[0], numbers(rest[1:])))


@dataclass
class Sheets:
    """The single surfaces of all cards, each with a key: the card's number where it has one sheet, else a new one."""

    found: dict[int, NamedSurface] = field(default_factory=dict)
    facets: dict[int, list[Region]] = field(default_factory=dict)  # by the number of a card: the negative sides
    copies: dict[tuple[int, Change], int] = field(default_factory=dict)
    with_facets: set[int] = field(default_factory=set)

    def add(self, card: SurfaceCard, change: Change | None) -> None:
        """The sheets of a card, moved."""
        regions: list[Region] = []
        for surface in card.form.surfaces:
            own = surface if change is None else moved(surface, change)
            key = card.number if len(card.form.surfaces) == 1 else BEYOND + len(self.found)
            regions.append(Half(self._kept(key, card.number, own, card.boundary), False))
        self.facets[card.number] = regions
        if card.form.has_facets:
            self.with_facets.add(card.number)

    def _kept(self, key: int, number: int, surface: Surface, boundary: str) -> int:
        self.found[key] = NamedSurface(number, "", surface, boundary)
        return key

    def side(self, number: int, facet: int | None) -> Region:
        """The negative side of a surface or of a facet. Raises ValueError."""
        regions = self.facets[number]
        if facet is None:
            return joined(Both, regions)
        if number not in self.with_facets:
            raise ValueError(f"region: surface {number} has no facets, {number}.{facet} is asked for")
        if not 1 <= facet <= len(regions):
            raise ValueError(f"region: surface {number} has facets 1 to {len(regions)}, {number}.{facet} is asked for")
        return regions[facet - 1]

    def moved(self, region: Region, change: Change) -> Region:
        """A region elsewhere."""
        return renumbered(region, lambda key: self._copy(key, change))

    def _copy(self, key: int, change: Change) -> int:
        if (key, change) not in self.copies:
            old = self.found[key]
            copy = self._kept(BEYOND + len(self.found), old.id, moved(old.surface, change), old.boundary)
            self.copies[key, change] = copy
        return self.copies[key, change]
