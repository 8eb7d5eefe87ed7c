"""What the columns of lengths and line integrals are called in files."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..scene import Scene


def names_of_lengths(scene: Scene, by: str) -> list[str]:
    """Names of bodies or materials, or else their numbers."""
    if by == "body":
        names = [body.name for body in scene[:]]
    else:
        names = ["no material" if material is None else material.name for material in scene.materials]
    counts = Counter(names)
    return [
        f"{by} {number}" if not name
        else f"{by} {number} ({name})" if counts[name] > 1 or name.startswith(f"{by} ") else name
        for number, name in enumerate(names)
    ]  # fmt: skip


def names_of_integrals(energies: tuple[int, ...]) -> list[str]:
    """One name, or one for each energy; energies: what follows the shape of the rays."""
    return [f"line_integral_{k}" for k in range(energies[0])] if energies else ["line_integral"]
