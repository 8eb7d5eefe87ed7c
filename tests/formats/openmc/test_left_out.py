"""What has no volume is left out, and each kind of it is told."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from conicoid.io import openmc

from .broken import geometry
from .models import EXAMPLE_FILES, NAMES, put, written

CLADDING = re.compile(r'(<cell id="3" name="cladding".*region=")[^"]*')
ENDS = {
    "a smaller cylinder": ("z-cylinder", "0 0 0.3"),
    "the same cylinder": ("z-cylinder", "0 0 0.418"),
    "a plane below": ("z-plane", "-30"),
    "a slanted plane beyond": ("plane", "1 1 0 -30"),
    "a ball within": ("sphere", "0 0 0 0.2"),
    "a cylinder far away": ("x-cylinder", "30 0 0.1"),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if "cylinder" in name else [pytest.mark.deep]) for name in ENDS]
)
def test_an_empty_cell_at_264_places_is_noted(name: str, tmp_path: Path) -> None:
    """The cladding of the assembly's 264 rods, outside of cylinder 2 and inside of something that is all within it."""
    kind, numbers = ENDS[name]
    text = EXAMPLE_FILES["assembly"].read_text(encoding="utf-8")
    text = CLADDING.sub(r"\g<1>2 -3 -15", text)
    text = text.replace("</geometry>", f'<surface id="15" type="{kind}" coeffs="{numbers}"/></geometry>')
    imported = openmc.read(put(text, tmp_path))
    assert len(imported.bodies) == 1133 - 264
    assert "869 bodies; 264 places without volume left out" in imported.notes
    assert "cell 3 'cladding': has no volume in any of its 264 places, left out there" in imported.notes
    assert 2 not in [entry.material for entry in imported.legend]


@pytest.mark.parametrize("twice", ["1 -1", "-2 2", "3 -3", "4 -4", "5 -5", "4 -6", "-4 -7"])
def test_both_sides_of_a_surface_are_nothing(twice: str, tmp_path: Path) -> None:
    """Of each kind of surface; of the same plane written with other numbers; and of parallel planes."""
    surfaces = (
        '<surface id="3" type="z-cone" coeffs="0 0 0 1"/>', '<surface id="4" type="plane" coeffs="1 -2 0.5 3"/>',
        '<surface id="5" type="quadric" coeffs="1 2 3 1 0 0 0 0 0 -1"/>', '<surface id="6" type="plane" coeffs="0.2 -0.4 0.1 0.6"/>',
        '<surface id="7" type="plane" coeffs="-2 4 -1 -6.5"/>',
    )  # fmt: skip
    text = geometry(
        *surfaces, f'<cell id="1" material="1" region="{twice}"/>', '<cell id="2" material="2" region="-2"/>'
    )
    imported = openmc.read(put(text, tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 2"]
    assert "cell 1: has no volume in its only place, left out there" in imported.notes


def test_slanted_planes_that_leave_a_slab_stay(tmp_path: Path) -> None:
    """4: x + y > 1; 6: -2 x - 2 y > -3, that is x + y < 1.5; 7: x + y < 0.9."""
    surfaces = [
        f'<surface id="{i}" type="plane" coeffs="{c}"/>'
        for i, c in ((4, "1 1 0 1"), (6, "-2 -2 0 -3"), (7, "1 1 0 0.9"))
    ]
    cells = (
        '<cell id="1" material="1" region="-2 4 6"/>',
        '<cell id="2" material="1" region="-2 4 -7"/>',
        '<cell id="3" material="1" region="-2 -7 6"/>',
    )
    imported = openmc.read(put(geometry(*surfaces, *cells), tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 1", "cell 3"]


def check_cells_made_empty(name: str, folder: Path, step: int) -> None:
    """Cells in turn are cut down to nothing: no body of one is left, and a note says so."""
    text = written(name, folder).read_text(encoding="utf-8")
    cells = re.findall(r'<cell id="(\d+)"[^>]*region="', text)
    surface = re.findall(r'<surface id="(\d+)"', text)[0]
    path = folder / "model.xml"
    for number in cells[::step]:
        spoilt = re.sub(rf'(<cell id="{number}"[^>]*region=")([^"]*)', rf"\g<1>(\g<2>) {surface} -{surface}", text)
        path.write_text(spoilt, encoding="utf-8")
        imported = openmc.read(path)
        assert not [body for body in imported.bodies if (body.name or "").split()[1] == number]
        assert any(
            re.match(rf"cell {number}\b.*: has no volume in (its only|any of its)", note) for note in imported.notes
        )


@pytest.mark.parametrize("name", ["kinds", "nested", "pin"])
def test_a_cell_that_is_made_empty_is_told(name: str, tmp_path: Path) -> None:
    check_cells_made_empty(name, tmp_path, 3)


@pytest.mark.deep
@pytest.mark.parametrize("name", NAMES)
def test_every_cell_that_is_made_empty_is_told(name: str, tmp_path: Path) -> None:
    check_cells_made_empty(name, tmp_path, 1)


def test_elements_beyond_the_cell_around_are_told(tmp_path: Path) -> None:
    """A ball of radius 1 about the corner of a lattice of 3 x 3 elements of size 1: it meets only that element."""
    text = geometry(
        '<cell id="1" universe="1" material="1"/>',
        f'<lattice id="4" name="grid" dimension="3 3" lower_left="0 0" pitch="1 1" universes="{"1 " * 9}"/>',
        '<cell id="2" fill="4" region="-2"/>',
    )
    imported = openmc.read(put(text, tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 1 @ cell 2, lattice 4 [0, 0]"]
    assert "in 8 of 9 elements of lattice 4 'grid' nothing lies in the cell around it, left out" in imported.notes


def test_notes_of_a_kind_are_not_endless(tmp_path: Path) -> None:
    cells = [f'<cell id="{i}" material="1 2" region="2 -2"/>' for i in range(1, 101)]
    notes = openmc.read(put(geometry(*cells), tmp_path)).notes
    assert "0 bodies; 100 places without volume left out" in notes
    shown = sum(note.startswith("cell") and "has no volume" in note for note in notes)
    assert 10 <= shown <= 20  # a screen
    assert notes.count(f"... and {100 - shown} more like this") == 2
    assert len(notes) < 50
