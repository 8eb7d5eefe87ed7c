"""What an import says of itself: names that two materials share, words it does not know, what is not looked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io import openmc

from .models import EXAMPLE_FILES

MODEL = """<model><materials>{}</materials><geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 2"/>
<surface id="3" type="sphere" coeffs="0 0 0 3" boundary="vacuum"/>
<cell id="1" material="1" region="-1"/><cell id="2" material="2" region="1 -2"/><cell id="3" material="7" region="2 -3"/>
</geometry></model>"""


def put(tmp_path: Path, *materials: str, model: str = MODEL) -> Path:
    path = tmp_path / "model.xml"
    path.write_text(model.format("".join(materials)), encoding="utf-8")
    return path


def named(number: int, name: str, density: float = 1.0) -> str:
    return f'<material id="{number}" name="{name}"><density units="g/cm3" value="{density}"/></material>'


def test_materials_of_one_name_are_kept_apart(tmp_path: Path) -> None:
    path = put(tmp_path, named(1, "steel", 8), named(2, "water"), named(7, "steel", 7))
    scene, imported = co.load_openmc(path), openmc.read(path)
    assert [m.name for m in scene.materials] == ["steel (material 1)", "water", "steel (material 7)"]
    rays = co.Rays((-9, 0, 0), (1, 0, 0))
    # 2 cm of material 1 in the middle, 1 cm of 2 and 1 cm of 7 on both sides
    assert scene.line_integral({"steel (material 1)": 1}, rays, otherwise=0) == 2
    assert scene.line_integral({"steel (material 7)": 1}, rays, otherwise=0) == 2
    assert scene.line_integral("density", rays) == 2 * 8 + 2 * 1 + 2 * 7
    volume = co.measure(scene)["steel (material 7)"].volume
    assert np.isclose(volume, 4 / 3 * np.pi * (27 - 8), rtol=1e-14)
    with pytest.raises(KeyError, match="materials with it in their names: 'steel .material 1.', 'steel .material 7.'"):
        co.measure(scene)["steel"]
    assert [entry.name for entry in imported.legend] == ["steel (material 1)", "water", "steel (material 7)"]
    assert "material 1 'steel': is called 'steel (material 1)', since another has its name" in imported.notes
    assert "material 7 'steel': is called 'steel (material 7)', since another has its name" in imported.notes


@pytest.mark.parametrize(("names", "expected"), [
    (("void", "a", "b"), ["void (material 1)", "a", "b"]),
    (("", "material 1", "b"), ["material 1 (material 1)", "material 1 (material 2)", "b"]),
    (("a", "a", "a (material 2)"), ["a (material 1)", "a (material 2) (material 2)", "a (material 2)"]),
    (("a", "b", "c"), ["a", "b", "c"]),
])  # fmt: skip
def test_no_two_names_are_alike(names: tuple[str, ...], expected: list[str], tmp_path: Path) -> None:
    scene = co.load_openmc(put(tmp_path, *map(named, (1, 2, 7), names)))
    assert [m.name for m in scene.materials] == expected


def test_materials_that_no_cell_has_change_no_names(tmp_path: Path) -> None:
    scene = co.load_openmc(put(tmp_path, named(1, "a"), named(2, "b"), named(7, "c"), named(9, "a")))
    assert [m.name for m in scene.materials] == ["a", "b", "c"]


def test_misspelt_words_are_told(tmp_path: Path) -> None:
    model = MODEL.replace("boundary", "boundry").replace('<cell id="1"', '<cell id="1" temprature="600"')
    model = model.replace("<surface id=\"1\"", "<serface/><surface id=\"1\" ID=\"4\"").replace("region=\"1 -2\"/>", "region=\"1 -2\"><Volume>3</Volume></cell>")  # fmt: skip
    notes = openmc.read(
        put(tmp_path, named(1, "a").replace("units", 'unit="x" units'), named(2, "b"), named(7, "c"), model=model)
    ).notes
    assert [note for note in notes if "is not read" in note] == [
        "line 2: <geometry>: 'serface' is not read (did you mean 'surface'?)",
        "line 2: <surface>: 'ID' is not read (did you mean 'id'?)",
        "line 3: <surface>: 'boundry' is not read (did you mean 'boundary'?)",
        "line 4: <cell>: 'temprature' is not read (did you mean 'temperature'?)",
        "line 4: <cell>: 'Volume' is not read (did you mean 'volume'?)",
        "line 1: <density>: 'unit' is not read (did you mean 'units'?)",
    ]


def test_many_unknown_words_are_counted(tmp_path: Path) -> None:
    words = " ".join(f'x{k}="1"' for k in range(1000))
    model = MODEL.replace('<cell id="1"', f'<cell {words} id="1"').replace('<cell id="2"', '<cell x0="1" id="2"')
    notes = openmc.read(put(tmp_path, named(1, "a"), named(2, "b"), named(7, "c"), model=model)).notes
    assert any(note.startswith("line 4: <cell>: 'x0' is not read, 2 times (known: ") for note in notes)
    assert "... and 982 more names that are not read" in notes
    assert len(notes) < 40


@pytest.mark.parametrize("name", EXAMPLE_FILES)
def test_every_word_of_the_examples_is_known(name: str) -> None:
    notes = openmc.read(EXAMPLE_FILES[name]).notes
    assert not [note for note in notes if "is not read" in note]


@pytest.mark.parametrize(("shares", "found"), [
    ('<nuclide name="H1" ao="0.1"/><nuclide name="O16" ao="0.2"/>', {"atom_density": 0.3}),
    ('<nuclide name="H1" wo="1.5"/><element name="O" wo="0.25"/>', {"density": 1.75}),
    ("", {}),
])  # fmt: skip
def test_densities_that_are_sums(shares: str, found: dict[str, float], tmp_path: Path) -> None:
    """OpenMC, "Materials": shares are then densities, in atom/b-cm or g/cm3, and the total is their sum."""
    material = f'<material id="1"><density units="sum"/>{shares}</material>'
    properties = co.load_openmc(put(tmp_path, material, named(2, "b"), named(7, "c"))).bodies[0].material.properties
    assert {key: properties[key] for key in ("density", "atom_density") if key in properties} == found


def test_sums_of_two_kinds_are_mistakes(tmp_path: Path) -> None:
    shares = '<nuclide name="H1" ao="0.1"/><nuclide name="O16" wo="0.2"/>'
    path = put(tmp_path, f'<material id="1"><density units="sum"/>{shares}</material>', named(2, "b"), named(7, "c"))
    with pytest.raises(co.SceneFileError, match="material 1: density: units sum needs either ao or wo of all nuclides"):
        co.load_openmc(path)


@pytest.mark.parametrize(("spoil", "void", "told"), [
    (lambda text: text, True, []),
    (lambda text: text, False, ["undefined regions (points in no cell) cannot be looked for: void is left out"]),
    (lambda text: text.replace('boundary="vacuum"', ""), True,
     ["undefined regions (points in no cell) cannot be looked for: boundary conditions do not enclose the model, "
      "and no universe fills any of its cells"]),
    (lambda text: text.replace('boundary="vacuum"', "").replace('material="7"', 'fill="5"').replace(
        "</geometry>", '<cell id="9" universe="5" material="7"/></geometry>'), True,
     ["undefined regions (points in no cell) can be looked for in filled cells only: boundary conditions do not enclose the model"]),
])  # fmt: skip
def test_an_import_says_where_undefined_regions_are_not_looked_for(spoil, void, told, tmp_path: Path) -> None:
    path = put(tmp_path, named(1, "a"), named(2, "b"), named(7, "c"), model=spoil(MODEL))
    assert [note for note in openmc.read(path, void=void).notes if note.startswith("undefined")] == told
