"""Materials by number and density, as names and properties: MCNP gives densities by cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from ...shapes.properties import Properties
from ..openmc.material_reading import NamedMaterial
from .data_cards import Shares

BEYOND = 10**12
"""Keys of what has no number of its own."""


@dataclass
class Materials:
    """One for each number and density that cells have; the first of a number has it as its key."""

    shares: Mapping[int, Shares]
    found: dict[int, NamedMaterial] = field(default_factory=dict)
    keys: dict[tuple[int, Fraction], int] = field(default_factory=dict)

    def key(self, number: int, density: Fraction) -> int:
        """Of a material in a cell."""
        known = self.keys.get((number, density))
        if known is not None:
            return known
        key = number if number not in self.found else BEYOND + len(self.keys)
        self.keys[number, density] = key
        said = {"density": float(-density)} if density < 0 else {"atom_density": float(density)}
        shares = {
            kind: {name: float(share) for name, share in parts.items()}
            for kind, parts in self.shares.get(number, {}).items()
            if parts
        }
        self.found[key] = NamedMaterial(number, f"m{number}", Properties({"id": number, **said, **shares}))
        return key

    def named(self) -> dict[int, NamedMaterial]:
        """Materials of several densities are told apart by them."""
        several = {n for n, _ in self.keys if sum(m == n for m, _ in self.keys) > 1}
        result = dict(self.found)
        for (number, density), key in self.keys.items():
            if number in several:
                unit = "g/cm3" if density < 0 else "atoms/b-cm"
                name = f"m{number} at {float(abs(density)):.15g} {unit}"
                result[key] = NamedMaterial(number, name, self.found[key].properties)
        return result
