"""One assembly as OpenMC geometry, as MCNP deck and as GDML file, the latter two written by hand: the same spans."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.io.export.openmc_regions import EmptinessTest, ExportSurfaceTable, RegionWriter

from ...samples import in_turn
from ..gdml.files import placed, text_of, volume
from ..mcnp.decks import chosen, loaded
from ..mcnp.test_same_as_openmc import DECK, GUIDES, PINS, PITCH, XML
from .comparison import written_and_read


def rows() -> list[str]:
    return [" ".join("2" if (i, j) in GUIDES else "1" for i in range(PINS)) for j in range(PINS)]


def gdml() -> str:
    """Pins of a pellet in a cladding, guide tubes of water in a wall, each in a box of water; lengths as in the deck."""
    tube = '<tube name="{}" rmin="{}" rmax="{}" z="20" deltaphi="360" aunit="deg" lunit="mm"/>'
    sizes = {"pellet": (0, 0.4096), "cladding": (0.4096, 0.475), "inside": (0, 0.561), "wall": (0.561, 0.602)}
    solids = "".join(tube.format(name, *radii) for name, radii in sizes.items())
    solids += f'<box name="element" x="{PITCH}" y="{PITCH}" z="20"/><box name="w" x="9" y="9" z="30"/>'

    def place(name: str, at: str = "") -> str:
        return placed(name, at, f'name="{name}"')

    structure = "".join(volume(name, name) for name in sizes)
    structure += volume("pin", "element", place("pellet") + place("cladding"), "air")
    structure += volume("guide", "element", place("inside") + place("wall"), "air")
    places = ""
    for j, i in itertools.product(range(PINS), range(PINS)):
        at = f'<position x="{(i - 2) * 126 / 100}" y="{(j - 2) * 126 / 100}" z="0"/>'
        places += place("guide" if (i, j) in GUIDES else "pin", at)
    return text_of(solids, structure + volume("world", "w", places, "air"))


CELLS = {"pellet": 1, "cladding": 2, "pin": 3, "inside": 4, "wall": 5, "guide": 6}
"""What is the cell of each volume, in the other two."""


def spans_of(scene: co.Scene, rays: co.Rays) -> np.ndarray[Any, Any]:
    """Ray, t_enter, t_exit and number of the cell of each span in the assembly, in that order."""
    spans = scene.spans(rays)
    kinds = np.array([_cell(body.name or "") for body in scene.bodies])[spans.body]
    ray = np.repeat(np.arange(len(rays)), np.diff(spans.offsets))
    rows = np.stack([ray, spans.t_enter, spans.t_exit, kinds])[:, kinds > 0]
    return rows[:, np.lexsort(rows[::-1])]


def _cell(name: str) -> int:
    found = re.match(r"cell (\d+)", name)
    if found:
        return int(found[1])
    return CELLS.get(re.sub("[#[].*", "", name.split("/")[-1]), 0)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, co.Scene]:
    folder = tmp_path_factory.mktemp("assembly")
    deck = loaded(folder, DECK.format(rows="\n".join("     " + row for row in rows())))
    (folder / "geometry.xml").write_text(XML.format(rows=" ".join(reversed(rows()))), encoding="utf-8")
    (folder / "pins.gdml").write_text(gdml(), encoding="utf-8")
    return {"MCNP": deck, "OpenMC": co.load(folder / "geometry.xml"), "GDML": co.load(folder / "pins.gdml")}


@pytest.fixture(scope="module")
def rays() -> co.Rays:
    points, ends = chosen(3, 3000, 4.0), chosen(4, 3000, 4.0)
    return co.Rays(points, ends - points)


def test_the_same_spans(scenes: dict[str, co.Scene], rays: co.Rays) -> None:
    found = {name: spans_of(scene, rays) for name, scene in scenes.items()}
    assert found["OpenMC"].shape[1] > 10_000
    np.testing.assert_array_equal(found["MCNP"], found["OpenMC"])
    np.testing.assert_array_equal(found["GDML"], found["OpenMC"])


@pytest.mark.parametrize(("suffix", "name"), in_turn([".gdml", ".xml"], ["MCNP", "OpenMC", "GDML"]))
def test_written_in_another_format(
    scenes: dict[str, co.Scene], rays: co.Rays, name: str, suffix: str, tmp_path: Path
) -> None:
    """Ends of spans are the same bits in whatever format they were said last."""
    back = written_and_read(scenes[name], tmp_path / f"out{suffix}")
    a, b = scenes[name].spans(rays), back.spans(rays)
    np.testing.assert_array_equal(a.offsets, b.offsets)
    np.testing.assert_array_equal(a.t_enter, b.t_enter)
    np.testing.assert_array_equal(a.t_exit, b.t_exit)


def test_regions_that_are_translated_are_as_empty_as_each_by_itself():
    """Pairs of cells of a lattice, near and far, with surfaces that are disjoint, nested or the same."""
    table = ExportSurfaceTable()
    regions, tests = RegionWriter(table), EmptinessTest(table)
    solids = [
        solid.translate((1.25 * x, 0.1 * y, 0))
        for x, y in itertools.product(range(3), range(3))
        for solid in (
            co.Cylinder((0, 0, -1), (0, 0, 1), 0.4),
            co.Cylinder((0, 0, -1), (0, 0, 1), 0.6) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5),
            co.Box((-0.625, -0.625, -1), (0.625, 0.625, 1)) - co.Sphere(0.6),
            co.HalfSpace((1, 1, 0), 0.3) & co.Sphere(0.5),
        )
    ]
    found = {
        (i, j): tests.are_disjoint(regions.of(solids[i]), regions.of(solids[j]))
        for i, j in itertools.combinations(range(len(solids)), 2)
    }
    assert {True, False} == set(found.values())
    for (i, j), disjoint in found.items():
        assert disjoint == EmptinessTest(table).are_disjoint(regions.of(solids[i]), regions.of(solids[j]))
    assert len(tests._known) < len(found) / 2
