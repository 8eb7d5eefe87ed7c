"""What tables take for one more placement of what they know: counted from their sizes, not measured."""

from __future__ import annotations

from pathlib import Path

import conicoid as co
from benchmarks.comparison.scenes import PINS, core_xml
from conicoid.kernels.bvh.walk import ROWS

REAL, WHOLE = 8, 4
WALL = 4 * REAL + 2 * WHOLE  # anchor and form; kind and row
PART = (4 + 1) * WHOLE  # a cell, and a leaf of a Boolean body
PLANE = 2 * WHOLE  # surface; side and face
BODY = (1 + 4 + 3 + 4) * WHOLE  # a program, and where it is; entry, face, maps
PIN = 3 * WALL + 7 * PART + 10 * PLANE + 3 * BODY
"""A pin: pellet, cladding and water, of seven parts in all, with three curved walls; parts end at ten planes."""
EDGES = 32
"""What belongs to places along an axis, of which there are as many as the square root of the pins."""


def test_a_pin_takes_what_tells_it_from_others(tmp_path: Path) -> None:
    scenes = []
    for across in (2, 4):
        path = tmp_path / f"{across}.xml"
        path.write_text(core_xml(across), encoding="utf-8")
        scenes.append(co.load_openmc(path, void=False))
    few, many = (scene.memory for scene in scenes)
    one, other = (scene._prepared.lowered.tables for scene in scenes)
    pins = (4**2 - 2**2) * PINS**2
    assert (many.tables - few.tables) / pins <= PIN + EDGES
    assert len(one.quadric_forms) == len(other.quadric_forms)
    for shared in ("planes", "leaf_bounds", "face_maps"):
        assert len(getattr(other, shared)) - len(getattr(one, shared)) < pins / 16, shared
    assert len(other.leaf_items) == ROWS * len(other.entry_kind)
