"""Attributes and elements that OpenMC does not know, most often misspelt: they are not read, which is told."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import did_you_mean
from ..nodes import shortened
from .xml_tree import Element

_NAMED = ("id", "name")
_LATTICE = (*_NAMED, "pitch", "outer", "universes")
_SHARE = ("name", "ao", "wo")
KNOWN = {
    "geometry": ("surface", "cell", "lattice", "hex_lattice", "dagmc_universe"),
    "surface": (*_NAMED, "type", "coeffs", "boundary", "albedo", "periodic_surface_id"),
    "cell": (
        *_NAMED, "universe", "fill", "material", "region", "rotation", "translation",
        "temperature", "density", "volume",
    ),
    "lattice": (*_LATTICE, "dimension", "lower_left"),
    "hex_lattice": (*_LATTICE, "n_rings", "n_axial", "orientation", "center"),
    "materials": ("material", "cross_sections"),
    "material": (
        *_NAMED, "density", "nuclide", "element", "sab", "macroscopic", "temperature", "volume", "depletable",
        "isotropic", "cfg",
    ),
    "density": ("value", "units"),
    "nuclide": _SHARE,
    "element": _SHARE,
    "sab": ("name", "fraction"),
    "macroscopic": ("name",),
}  # fmt: skip
"""What elements may hold, as attributes or as elements (OpenMC's documentation, "Geometry" and "Materials")."""


@dataclass(frozen=True)
class Unread:
    """A name in elements of a kind, how often it stands there, and where first."""

    kind: str
    name: str
    times: int
    line: int

    def __str__(self) -> str:
        meant = did_you_mean(self.name, KNOWN[self.kind])
        times = f", {self.times:,} times" if self.times > 1 else ""
        return f"line {self.line}: <{self.kind}>: {shortened(self.name)!r} is not read{times}{meant}"


def unread(root: Element) -> Iterator[Unread]:
    """Each name once for a kind of element, in the order of the file."""
    found: dict[tuple[str, str], list[int]] = {}
    pending = [root]
    while pending:
        element = pending.pop()
        known = KNOWN.get(element.tag)
        if known is None:
            continue
        for name, line in (
            *((name, element.line) for name in element.attributes),
            *((child.tag, child.line) for child in element.children),
        ):
            if name not in known:
                count = found.setdefault((element.tag, name), [0, line])
                count[0] += 1
        pending.extend(child for child in reversed(element.children) if child.tag in known)
    return (Unread(kind, name, times, line) for (kind, name), (times, line) in found.items())
