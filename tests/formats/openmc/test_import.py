"""OpenMC geometry as bodies: the command, notes, names and materials."""

import functools
import math
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io import openmc
from conicoid.io.importers import oklch_to_linear, palette_color
from conicoid.io.scene_file import scene_file, yaml_parser

from ...command_line import execute, failure, run
from .models import EXAMPLE_FILES, load_model, model_file

# --- Names, colors, void, notes: the report of an import

ASSEMBLY = EXAMPLE_FILES["assembly"]


@functools.cache
def assembly() -> openmc.ImportResult:
    """Read the assembly."""
    return openmc.read(ASSEMBLY)


def test_the_assembly_has_the_expected_number_of_bodies() -> None:
    """264 rods of fuel, gap, cladding and water; 24 guide tubes of 3 cells; one instrument tube of 4; the gap outside."""
    imported = assembly()
    assert len(imported.bodies) == 264 * 4 + 24 * 3 + 4 + 1
    counts = {entry.material: entry.bodies for entry in imported.legend}
    assert counts == {1: 264, 2: 264, 3: 264 + 24 * 2 + 2 + 1, 4: 25, 5: 1, None: 264}
    assert [entry.name for entry in imported.legend][:3] == ["uranium dioxide", "zirconium alloy, cladding", "water"]


def test_names_give_the_path_and_are_unique() -> None:
    scene = load_model(ASSEMBLY)
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
    scene = load_model(ASSEMBLY)
    spans = scene.spans((-20, 0.1, 50), (1, 0, 0))
    assert spans.t_enter[0] == 9.25
    assert spans.t_exit[-1] == 30.75
    assert (spans.t_enter[1:] == spans.t_exit[:-1]).all()
    assert spans.lengths().sum() == pytest.approx(21.5, abs=1e-12)


def test_void_is_there_and_invisible_or_left_out(tmp_path: Path) -> None:
    with_void, without = load_model(ASSEMBLY), co.load_openmc(ASSEMBLY, void=False)
    assert len(with_void.bodies) - len(without.bodies) == 264
    name = "cell 2 'gap and plenum' @ cell 100, lattice 50 [3, 4]"
    material = with_void[name].material
    assert (material.transparency, material.refractive_index, material.specular) == (1.0, 1.0, 0.0)
    center = (-10.71 + 3.5 * 1.26, -10.71 + 4.5 * 1.26, 370.0)
    assert with_void.bodies[int(with_void.body_at(center))].name == name
    assert without.body_at(center) == -1


def test_the_same_material_has_the_same_colour_everywhere(tmp_path: Path) -> None:
    scene = co.load_openmc(model_file("kinds", tmp_path))
    pin = co.load_openmc(EXAMPLE_FILES["pin"])
    assert scene.bodies[0].material.color == pin.bodies[0].material.color == co.matte(palette_color(1)).color


def test_oklab_of_white_and_of_red_are_the_published_ones() -> None:
    """Björn Ottosson's page has white at (1, 0, 0), and sRGB red at L 0.628, a 0.225, b 0.126."""
    assert oklch_to_linear(1, 0, 0) == pytest.approx((1, 1, 1), abs=1e-6)
    red = (0.6279554, math.hypot(0.2248631, 0.1258463), math.atan2(0.1258463, 0.2248631))
    assert oklch_to_linear(*red) == pytest.approx((1, 0, 0), abs=1e-5)


def test_notes_name_the_findings(tmp_path: Path) -> None:
    assert assembly().notes == (
        "13 cells, 17 surfaces, 5 universes, 1 lattice",
        "1,133 bodies",
        "boundary reflective: surfaces 41, 42, 43, 44",
        "boundary vacuum: surfaces 45, 46",
    )
    notes = openmc.read(model_file("nested", tmp_path)).notes
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


# --- conicoid import

PIN = EXAMPLE_FILES["pin"]


def test_a_geometry_becomes_a_scene_file(tmp_path: Path) -> None:
    output = tmp_path / "pin.yaml"
    result = execute("import", PIN, "-o", output)
    assert co.load(output) == co.load_openmc(PIN)
    assert "4 cells, 7 surfaces, 1 universe, 0 lattices" in result.stdout
    assert "boundary reflective: surfaces 4, 5, 6, 7" in result.stdout
    assert "material 1             1 body    uranium dioxide" in result.stdout
    assert result.stderr.splitlines() == [f"{PIN}: expands into 4 bodies", f"{output}: 4 bodies"]


def test_without_void(tmp_path: Path) -> None:
    run("import", EXAMPLE_FILES["assembly"], "-o", tmp_path / "a.json", "--no-void")
    assert len(co.load(tmp_path / "a.json").bodies) == 1133 - 264


def test_limits_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "expands into 4 bodies" in failure("import", PIN, "-o", tmp_path / "out.yaml", "--max-bodies", 3)
    monkeypatch.setattr(yaml_parser, "MAX_NODES", 100)
    assert "a scene file holds at most 100 values, this scene takes" in failure(
        "import", PIN, "-o", tmp_path / "out.yaml"
    )


def test_outputs_are_checked_first(tmp_path: Path) -> None:
    assert "scenes are saved as .yaml or .json" in run("import", PIN, "-o", tmp_path / "out.png").stderr
    assert run("import", PIN, "-o", tmp_path / "none" / "out.yaml").exit_code == 2


MESHES = """
<geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 9" boundary="vacuum"/>
<surface id="7" name="coil" type="z-torus" coeffs="0 0 0 5 1 1"/><surface id="8" type="x-torus" coeffs="0 0 0 2 1 1"/>
<dagmc_universe id="30" filename="engine.h5m"/>
<cell id="1" material="1" region="-1"/><cell id="2" material="2" region="-7"/>
<cell id="3" fill="20" region="1 7 -2"/>
<cell id="4" universe="20" fill="30" region="-8 1"/><cell id="5" universe="20" fill="40" region="8"/>
<cell id="6" universe="40" material="1" region="2 | -2"/>
<cell id="9" fill="50" region="2"/>
<lattice id="50" dimension="2 1" lower_left="9 -9" pitch="9 18" universes="30 20" outer="60"/>
<cell id="7" universe="60" material="2"/>
</geometry>"""


def test_cells_with_tori_and_meshes_are_left_out_by_name(tmp_path: Path) -> None:
    """These may be the only cells of a universe and of the root, whose fillings do not become roots instead."""
    path = model_folder(tmp_path, model=MESHES)
    scene = co.load(path)
    assert [body.name for body in scene.bodies] == ["cell 1", "cell 7 @ cell 9, lattice 50 outer"]
    notes = (
        "universe 30 is a mesh (dagmc_universe), which is left out",
        "surface 7 'coil' is a torus (z-torus), which is no quadric: cells 2, 3 left out",
        "surface 8 is a torus (x-torus), which is no quadric: cells 4, 5 left out",
    )
    assert scene.notes[3:6] == notes
    with pytest.raises(ValueError, match=r"strict is set:\nuniverse 30 is a mesh"):
        co.load(path, strict=True)
    alone = model_folder(tmp_path, model="<geometry><dagmc_universe id='3'/></geometry>")
    assert co.load(alone).bodies == ()


# --- The report of an import: names that two materials share, unknown words, omitted checks

THREE_CELLS = """<model><materials>{}</materials><geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 2"/>
<surface id="3" type="sphere" coeffs="0 0 0 3" boundary="vacuum"/>
<cell id="1" material="1" region="-1"/><cell id="2" material="2" region="1 -2"/><cell id="3" material="7" region="2 -3"/>
</geometry></model>"""


def model_folder(tmp_path: Path, *materials: str, model: str = THREE_CELLS) -> Path:
    path = tmp_path / "model.xml"
    path.write_text(model.format("".join(materials)), encoding="utf-8")
    return path


def material_xml(number: int, name: str, density: float = 1.0) -> str:
    return f'<material id="{number}" name="{name}"><density units="g/cm3" value="{density}"/></material>'


def test_materials_of_one_name_are_kept_apart(tmp_path: Path) -> None:
    path = model_folder(tmp_path, material_xml(1, "steel", 8), material_xml(2, "water"), material_xml(7, "steel", 7))
    scene, imported = co.load_openmc(path), openmc.read(path)
    assert [m.name for m in scene.materials] == ["steel (material 1)", "water", "steel (material 7)"]
    rays = co.Rays((-9, 0, 0), (1, 0, 0))
    # 2 cm of material 1 in the middle, 1 cm of 2 and 1 cm of 7 on both sides
    assert scene.line_integral({"steel (material 1)": 1}, rays, otherwise=0) == 2
    assert scene.line_integral({"steel (material 7)": 1}, rays, otherwise=0) == 2
    assert scene.line_integral("density", rays) == 2 * 8 + 2 * 1 + 2 * 7
    volume = co.measure(scene)["steel (material 7)"].volume
    assert np.isclose(volume, 4 / 3 * np.pi * (27 - 8), rtol=1e-14)
    with pytest.raises(KeyError, match="names with it in their names: 'steel .material 1.', 'steel .material 7.'"):
        co.measure(scene)["steel"]
    assert [entry.name for entry in imported.legend] == ["steel (material 1)", "water", "steel (material 7)"]
    assert "material 1 'steel': is called 'steel (material 1)', since another has its name" in imported.notes
    assert "material 7 'steel': is called 'steel (material 7)', since another has its name" in imported.notes


@pytest.mark.parametrize(("names", "expected"), [
    (("void", "a", "b"), ["void (material 1)", "a", "b"]),
    (("", "material 1", "b"), ["material 1 (material 1)", "material 1 (material 2)", "b"]),
    (("a", "a", "a (material 2)"), ["a (material 1)", "a (material 2) (material 2)", "a (material 2)"]),
    (("a", "b", "c"), ["a", "b", "c"]),
    (("a", "b", "c", "a"), ["a", "b", "c"]),  # no cell has the last material
])  # fmt: skip
def test_no_two_names_are_alike(names: tuple[str, ...], expected: list[str], tmp_path: Path) -> None:
    scene = co.load_openmc(model_folder(tmp_path, *map(material_xml, (1, 2, 7, 9), names)))
    assert [m.name for m in scene.materials] == expected


def test_misspelt_words_are_reported(tmp_path: Path) -> None:
    model = THREE_CELLS.replace("boundary", "boundry").replace('<cell id="1"', '<cell id="1" temprature="600"')
    model = model.replace("<surface id=\"1\"", "<serface/><surface id=\"1\" ID=\"4\"").replace("region=\"1 -2\"/>", "region=\"1 -2\"><Volume>3</Volume></cell>")  # fmt: skip
    notes = openmc.read(
        model_folder(
            tmp_path,
            material_xml(1, "a").replace("units", 'unit="x" units'),
            material_xml(2, "b"),
            material_xml(7, "c"),
            model=model,
        )
    ).notes
    assert [note for note in notes if "is not read" in note] == [
        "line 2: <geometry>: 'serface' is not read (did you mean 'surface'?)",
        "line 2: <surface>: 'ID' is not read (did you mean 'id'?)",
        "line 3: <surface>: 'boundry' is not read (did you mean 'boundary'?)",
        "line 4: <cell>: 'temprature' is not read (did you mean 'temperature'?)",
        "line 4: <cell>: 'Volume' is not read (did you mean 'volume'?)",
        "line 1: <density>: 'unit' is not read (did you mean 'units'?)",
    ]


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
    properties = (
        co.load_openmc(model_folder(tmp_path, material, material_xml(2, "b"), material_xml(7, "c")))
        .bodies[0]
        .material.properties
    )
    assert {key: properties[key] for key in ("density", "atom_density") if key in properties} == found


def test_sums_of_two_kinds_are_mistakes(tmp_path: Path) -> None:
    shares = '<nuclide name="H1" ao="0.1"/><nuclide name="O16" wo="0.2"/>'
    path = model_folder(
        tmp_path,
        f'<material id="1"><density units="sum"/>{shares}</material>',
        material_xml(2, "b"),
        material_xml(7, "c"),
    )
    with pytest.raises(co.SceneFileError, match="material 1: density: units sum needs either ao or wo of all nuclides"):
        co.load_openmc(path)


@pytest.mark.parametrize(("spoil", "void", "message"), [
    (lambda text: text, True, []),
    (lambda text: text, False, ["undefined regions (points in no cell) cannot be looked for: void is left out"]),
    (lambda text: text.replace('boundary="vacuum"', ""), True,
     ["undefined regions (points in no cell) cannot be looked for: boundary conditions do not enclose the model, "
      "and no universe fills any of its cells"]),
    (lambda text: text.replace('boundary="vacuum"', "").replace('material="7"', 'fill="5"').replace(
        "</geometry>", '<cell id="9" universe="5" material="7"/></geometry>'), True,
     ["undefined regions (points in no cell) can be looked for in filled cells only: boundary conditions do not enclose the model"]),
])  # fmt: skip
def test_an_import_reports_where_undefined_regions_are_not_searched(spoil, void, message, tmp_path: Path) -> None:
    path = model_folder(
        tmp_path, material_xml(1, "a"), material_xml(2, "b"), material_xml(7, "c"), model=spoil(THREE_CELLS)
    )
    assert [note for note in openmc.read(path, void=void).notes if note.startswith("undefined")] == message


# --- Names are those of the file, whatever they hold: no output follows their control characters

HOSTILE = (
    "fuel&#10;#ffffff    material 9             1 bodies  water",
    "a&#13;b",
    "\x9b31mred",
    "\u202egnp.exe",
    "a\u2028b",
    "&#9;",
    "it's",
)
NAMED_MODEL = """<model><materials><material id="1" name="{0}"/><material id="2" name="Zircaloy"/></materials><geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 2"/><surface id="3" name="{0}" type="sphere" coeffs="0 0 0 3"/>
<cell id="1" name="{0}" material="void 1" region="-1"/><cell id="2" name="{0}" material="1" region="1 -2"/>
<cell id="3" material="2" region="2 -3"/><cell id="4" name="{0}" material="2" region="3 -3"/>
</geometry></model>"""


@pytest.mark.parametrize("name", HOSTILE)
def test_names_cannot_forge_printed_lines(name: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(NAMED_MODEL.format(name), encoding="utf-8")
    imported = openmc.read(path)
    for line in (*map(str, imported.legend), *imported.notes, *(body.name or "" for body in imported.bodies)):
        assert line.isprintable()
    output = tmp_path / "scene.yaml"
    result = execute("import", path, "-o", output)
    assert len(result.stdout.splitlines()) == len(imported.notes) + len(imported.legend)
    assert all(line.isprintable() for line in output.read_text(encoding="utf-8").splitlines())
    assert co.load(output).bodies[1].name == imported.bodies[1].name


def named_in_file(path: Path) -> dict[str, object]:
    """Return the entries under `materials` of a scene file, by name."""
    document = yaml_parser.parse_document(path.read_text(encoding="utf-8"))
    root, problems = document.root, document.problems
    assert not problems
    return dict(root.entries["materials"].entries)  # type: ignore[union-attr]


def test_a_scene_file_names_materials_as_the_legend_does(tmp_path: Path) -> None:
    """Void comes first in the file. Material 2 is Zircaloy in both."""
    path, output = tmp_path / "model.xml", tmp_path / "scene.yaml"
    path.write_text(NAMED_MODEL.format("oxide"), encoding="utf-8")
    imported = openmc.read(path)
    scene_file.write_scene(imported, output, imported.material_names)
    assert list(named_in_file(output)) == ["void", "material 1 'oxide'", "material 2 'Zircaloy'"]
    text = output.read_text(encoding="utf-8")
    for body, name in zip(imported.bodies, ("void", "material 1 'oxide'", "material 2 'Zircaloy'"), strict=True):
        entry = text[text.index(str(body.name)) :].split("- name")[0]
        assert name in entry
    assert co.load(output).bodies == imported.bodies


def test_a_saved_scene_calls_materials_as_they_call_themselves(tmp_path: Path) -> None:
    """The file has the model's names.

    Materials without a name get letters, which cannot be mistaken for OpenMC's numbers.
    """
    output = tmp_path / "scene.yaml"
    co.save(co.load_openmc(EXAMPLE_FILES["pin"]), output)
    assert list(named_in_file(output)) == ["uranium dioxide", "helium", "zirconium alloy", "water"]
    many = co.Scene([co.Body(co.Sphere(1, (i, 0, 0)), co.matte((i / 1000, 0, 0))) for i in range(29)])
    co.save(many, output)
    assert list(named_in_file(output))[25:] == ["material Z", "material AA", "material AB", "material AC"]


# --- A material keeps its data of materials.xml, in units that do not differ from material to material

MATERIAL_MODEL = """<model><materials>{}</materials><geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 2"/><surface id="3" type="sphere" coeffs="0 0 0 3"/>
<cell id="1" material="1" region="-1"/><cell id="2" material="void" region="1 -2"/><cell id="3" material="2" region="2 -3"/>
</geometry></model>"""
FUEL = """<material id="1" name="fuel" depletable="true" temperature="600.5">
  <density units="kg/m3" value="10300"/><nuclide name="U235" ao="0.04"/><nuclide name="O16" ao="1.5"/>
  <nuclide ao="0.5" name="O16"/><element><name>Gd</name><wo>1e-3</wo></element>
</material>"""
WATER = """<material id="2"><density units="atom/cm3" value="1e23"/><sab name="c_H_in_H2O"/></material>"""


def model(tmp_path: Path, *materials: str) -> Path:
    path = tmp_path / "model.xml"
    path.write_text(MATERIAL_MODEL.format("".join(materials)), encoding="utf-8")
    return path


def test_attributes_of_the_file_are_kept(tmp_path: Path) -> None:
    scene = co.load_openmc(model(tmp_path, FUEL, WATER))
    fuel, void, water = (body.material for body in scene.bodies)
    assert (fuel.name, void.name, water.name) == ("fuel", "void", "material 2")
    assert fuel.properties == {
        "id": 1, "density": 10.3, "ao": {"U235": 0.04, "O16": 2.0}, "wo": {"Gd": 1e-3}, "temperature": 600.5, "depletable": True,
    }  # fmt: skip
    assert water.properties == {"id": 2, "atom_density": 0.1, "sab": ("c_H_in_H2O",)}
    assert void.properties == {"density": 0, "atom_density": 0}
    assert scene.first_hit((0, 0, 9), (0, 0, -1)).material is water


def test_without_a_list_the_number_is_known(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        MATERIAL_MODEL.replace("<materials>{}</materials>", "").replace("model>", "x>").split("<x>")[1].split("</x>")[0]
    )
    assert [m.name for m in {body.material: 0 for body in co.load_openmc(path).bodies}] == [
        "material 1",
        "void",
        "material 2",
    ]
    assert openmc.read(path).bodies[0].material.properties == {"id": 1}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (FUEL.replace("kg/m3", "lb/gal"), "material 1 'fuel': density: units must be one of g/cm3, .*, got 'lb/gal'"),
        (FUEL.replace("10300", "ten"), "material 1 'fuel': density: value must be a number, got 'ten'"),
        (FUEL.replace(' value="10300"', ""), "material 1 'fuel': density: needs the attribute or element 'value'"),
        (FUEL.replace('ao="1.5"', 'ao="x"'), "material 1 'fuel': nuclide: ao must be a number, got 'x'"),
        (FUEL.replace(' name="U235"', ""), "material 1 'fuel': nuclide: needs the attribute or element 'name'"),
        (FUEL.replace("600.5", "hot"), "material 1 'fuel': temperature must be a number, got 'hot'"),
    ],
)
def test_mistakes_are_reported_with_the_material(wrong: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(co.SceneFileError, match=message):
        co.load_openmc(model(tmp_path, wrong, WATER))
