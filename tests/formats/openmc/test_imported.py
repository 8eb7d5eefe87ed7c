"""Names, colours, void, notes: what an import says about itself."""

from __future__ import annotations

import functools
import importlib
import itertools
import math
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io import openmc
from conicoid.io.importers import oklch_to_linear, palette_color
from conicoid.materials.color import linear_rgb

from .models import EXAMPLE_FILES, EXAMPLES, loaded, written

ASSEMBLY = EXAMPLE_FILES["assembly"]


@functools.cache
def assembly() -> openmc.ImportResult:
    """What is read of the assembly."""
    return openmc.read(ASSEMBLY)


def test_the_assembly_has_the_bodies_that_arithmetic_says() -> None:
    """264 rods of fuel, gap, cladding and water; 24 guide tubes of 3 cells; one instrument tube of 4; the gap outside."""
    imported = assembly()
    assert len(imported.bodies) == 264 * 4 + 24 * 3 + 4 + 1
    counts = {entry.material: entry.bodies for entry in imported.legend}
    assert counts == {1: 264, 2: 264, 3: 264 + 24 * 2 + 2 + 1, 4: 25, 5: 1, None: 264}
    assert [entry.name for entry in imported.legend][:3] == ["uranium dioxide", "zirconium alloy, cladding", "water"]


def test_names_say_the_way_and_are_unique() -> None:
    scene = loaded(ASSEMBLY)
    names = [body.name for body in scene.bodies]
    assert len(set(names)) == len(names)
    corner = "cell 1 'fuel' @ cell 100, lattice 50 [0, 0]"
    low, high = scene[corner].shape.bounds
    assert low == pytest.approx([-10.08 - 0.4096, -10.08 - 0.4096, 0], abs=1e-12)
    assert high == pytest.approx([-10.08 + 0.4096, -10.08 + 0.4096, 365.76], abs=1e-12)
    assert scene.body_at((-10.08, -10.08, 100)) == names.index(corner)
    assert "cell 31 'water gap' @ cell 100, lattice 50 outer" in names


def test_walls_that_coincide_on_paper_are_one_surface() -> None:
    """A ray across the assembly enters each cell where it leaves the one before, to the bit."""
    scene = loaded(ASSEMBLY)
    spans = scene.spans((-20, 0.1, 50), (1, 0, 0))
    assert spans.t_enter[0] == 9.25
    assert spans.t_exit[-1] == 30.75
    assert (spans.t_enter[1:] == spans.t_exit[:-1]).all()
    assert spans.lengths().sum() == pytest.approx(21.5, abs=1e-12)


def test_void_is_there_and_invisible_or_left_out(tmp_path: Path) -> None:
    with_void, without = loaded(ASSEMBLY), co.load_openmc(ASSEMBLY, void=False)
    assert len(with_void.bodies) - len(without.bodies) == 264
    name = "cell 2 'gap and plenum' @ cell 100, lattice 50 [3, 4]"
    material = with_void[name].material
    assert (material.transparency, material.refractive_index, material.specular) == (1.0, 1.0, 0.0)
    center = (-10.71 + 3.5 * 1.26, -10.71 + 4.5 * 1.26, 370.0)
    assert with_void.bodies[int(with_void.body_at(center))].name == name
    assert without.body_at(center) == -1


def test_the_same_material_has_the_same_colour_everywhere(tmp_path: Path) -> None:
    scene = co.load_openmc(written("kinds", tmp_path))
    pin = co.load_openmc(EXAMPLE_FILES["pin"])
    assert scene.bodies[0].material.color == pin.bodies[0].material.color == co.matte(palette_color(1)).color


def test_colours_are_far_apart() -> None:
    """By their distance in OKLab, of which 0.02 is about the least that is noticed side by side."""
    places = np.array([oklab(palette_color(number)) for number in range(1, 25)])
    distances = [float(np.linalg.norm(a - b)) for a, b in itertools.combinations(places, 2)]
    assert min(distances) > 0.04
    neighbours = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert neighbours.min() > 0.15
    for number in (*range(1, 300), 10**9, 10**17):
        assert len(palette_color(number)) == 7


def oklab(color: str) -> tuple[float, float, float]:
    """The inverse of the palette's OKLCH colours, by Newton's method on its definition."""
    target = np.array(linear_rgb(color))
    point = np.array([0.6, 0.0, 0.0])

    def rgb(p: np.ndarray) -> np.ndarray:
        return np.array(oklch_to_linear(p[0], math.hypot(p[1], p[2]), math.atan2(p[2], p[1])))

    for _ in range(60):
        slopes = np.column_stack([(rgb(point + 1e-6 * e) - rgb(point - 1e-6 * e)) / 2e-6 for e in np.eye(3)])
        point = point - np.linalg.solve(slopes, rgb(point) - target)
    assert rgb(point) == pytest.approx(target, abs=1e-9)
    return float(point[0]), float(point[1]), float(point[2])


def test_oklab_of_white_and_of_red_are_the_published_ones() -> None:
    """Björn Ottosson's page: white is (1, 0, 0); sRGB red is L 0.628, a 0.225, b 0.126."""
    assert oklch_to_linear(1, 0, 0) == pytest.approx((1, 1, 1), abs=1e-6)
    red = (0.6279554, math.hypot(0.2248631, 0.1258463), math.atan2(0.1258463, 0.2248631))
    assert oklch_to_linear(*red) == pytest.approx((1, 0, 0), abs=1e-5)


def test_notes_say_what_was_found(tmp_path: Path) -> None:
    assert assembly().notes == (
        "13 cells, 17 surfaces, 5 universes, 1 lattice",
        "1,133 bodies",
        "boundary reflective: surfaces 41, 42, 43, 44",
        "boundary vacuum: surfaces 45, 46",
    )
    notes = openmc.read(written("nested", tmp_path)).notes
    assert "lattice 6: the cell around it may reach beyond it, and there is no outer universe" in notes
    assert not any(note.startswith("lattice 5") for note in notes)
    assert "no list of materials: they are known by number only" in notes


def test_notes_on_materials_for_each_place_and_on_crooked_rotations(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        "<geometry><cell id='1' universe='1' material='4 void 2'/>"
        "<cell id='2' fill='1' rotation='1 0 0 0 0.7 -0.7 0 0.7 0.7'/></geometry>"
    )
    imported = openmc.read(path)
    assert "cell 1: has a material for each place (4, void, 2); the first is taken for all" in imported.notes
    assert "cell 2: its rotation matrix is 0.02 away from a rotation; it is applied as it is" in imported.notes
    assert [entry.material for entry in imported.legend] == [4]
    scene = co.load_openmc(path)
    assert scene.contains([(1e9, -3, 0), (0, 0, 0)]).all()


def test_progress_begins_with_the_number() -> None:
    calls: list[tuple[int, int]] = []
    openmc.read(ASSEMBLY, progress=lambda done, most: calls.append((done, most)))
    assert calls[0] == (0, 1133)
    assert [done // 256 for done, _ in calls[1:]] == [1, 2, 3, 4]


def test_the_legend_reads_well() -> None:
    lines = [str(entry) for entry in assembly().legend]
    assert lines[0] == f"{palette_color(1)}    material 1           264 bodies  uranium dioxide"
    assert lines[-1] == "invisible  void                 264 bodies"


def test_it_renders(tmp_path: Path) -> None:
    """The pin cell has no end along z; a camera that fits is found all the same."""
    image = co.load_openmc(EXAMPLE_FILES["pin"]).render(32, 24, 1)
    assert np.isfinite(image.pixels).all()
    assert image.pixels.std() > 0.01


@pytest.mark.deep
def test_the_example_cuts_the_assembly_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """In front the slanted plane cuts fuel; at the back one looks through the open plenum down to its top."""
    monkeypatch.syspath_prepend(str(EXAMPLES.parent))
    reactor_pin = importlib.import_module("reactor_pin")
    scene = reactor_pin.scene()
    x, rows = 1.26, (-10.08, 10.08)
    hits = scene.first_hit([(x, y, 90) for y in rows], (0, 0, -1))
    assert [scene.bodies[body].name.split(" @ ")[0] for body in hits.body.tolist()] == ["cell 1 'fuel'"] * 2
    assert hits.point[:, 2] == pytest.approx([16 - 0.45 * x + 0.9 * rows[0], 365.76 - 352], abs=1e-12)
