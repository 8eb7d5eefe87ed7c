"""Names are what the file says, whatever they hold: nothing that is printed or written obeys them."""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.io import openmc
from conicoid.io.scene_file import scene_file, yaml_parser

from ...command_line import run
from .models import EXAMPLE_FILES

HOSTILE = (
    "fuel&#10;#ffffff    material 9             1 bodies  water",
    "a&#13;b",
    "\x9b31mred",
    "\u202egnp.exe",
    "a\u2028b",
    "&#9;",
    "it's",
)
MODEL = """<model><materials><material id="1" name="{0}"/><material id="2" name="Zircaloy"/></materials><geometry>
<surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 2"/><surface id="3" name="{0}" type="sphere" coeffs="0 0 0 3"/>
<cell id="1" name="{0}" material="void 1" region="-1"/><cell id="2" name="{0}" material="1" region="1 -2"/>
<cell id="3" material="2" region="2 -3"/><cell id="4" name="{0}" material="2" region="3 -3"/>
</geometry></model>"""


@pytest.mark.parametrize("name", HOSTILE)
def test_names_cannot_forge_what_is_printed(name: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(MODEL.format(name), encoding="utf-8")
    imported = openmc.read(path)
    for line in (*map(str, imported.legend), *imported.notes, *(body.name or "" for body in imported.bodies)):
        assert line.isprintable()
    output = tmp_path / "scene.yaml"
    result = run("import", path, "-o", output)
    assert result.exit_code == 0
    assert len(result.stdout.splitlines()) == len(imported.notes) + len(imported.legend)
    assert all(line.isprintable() for line in output.read_text(encoding="utf-8").splitlines())
    assert co.load(output).bodies[1].name == imported.bodies[1].name


def test_a_mistake_does_not_obey_its_name(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(MODEL.format(HOSTILE[0]).replace('coeffs="0 0 0 3"', 'coeffs="0 0 0 -3"'), encoding="utf-8")
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path)
    assert len(str(caught.value).splitlines()) == len(caught.value.problems) == 1


def named_in_file(path: Path) -> dict[str, object]:
    """What stands under `materials`, by the name there."""
    root, problems = yaml_parser.parse_yaml(path.read_text(encoding="utf-8"))
    assert root is not None
    assert not problems
    return dict(root.entries["materials"].entries)  # type: ignore[union-attr]


def test_a_scene_file_names_materials_as_the_legend_does(tmp_path: Path) -> None:
    """Void comes first in the file; material 2 is Zircaloy in both."""
    path, output = tmp_path / "model.xml", tmp_path / "scene.yaml"
    path.write_text(MODEL.format("oxide"), encoding="utf-8")
    imported = openmc.read(path)
    scene_file.write_scene(imported, output, imported.material_names)
    assert list(named_in_file(output)) == ["void", "material 1 'oxide'", "material 2 'Zircaloy'"]
    text = output.read_text(encoding="utf-8")
    for body, name in zip(imported.bodies, ("void", "material 1 'oxide'", "material 2 'Zircaloy'"), strict=True):
        entry = text[text.index(str(body.name)) :].split("- name")[0]
        assert name in entry
    assert co.load(output).bodies == imported.bodies


def test_a_saved_scene_calls_materials_as_they_call_themselves(tmp_path: Path) -> None:
    """The model's names; materials without a name get letters, which cannot be taken for OpenMC's numbers."""
    output = tmp_path / "scene.yaml"
    co.save(co.load_openmc(EXAMPLE_FILES["pin"]), output)
    assert list(named_in_file(output)) == ["uranium dioxide", "helium", "zirconium alloy", "water"]
    many = co.Scene([co.Body(co.Sphere(1, (i, 0, 0)), co.matte((i / 1000, 0, 0))) for i in range(29)])
    co.save(many, output)
    assert list(named_in_file(output))[25:] == ["material Z", "material AA", "material AB", "material AC"]


def test_materials_of_one_colour_are_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conicoid.io.openmc.expansion.palette_color", lambda number: "#808080")
    path = tmp_path / "model.xml"
    path.write_text(MODEL.format("oxide"), encoding="utf-8")
    imported = openmc.read(path)
    assert sorted(imported.material_names.values()) == ["material 1 'oxide'", "material 2 'Zircaloy'", "void"]
    assert [body.material.name for body in imported.bodies] == ["void", "oxide", "Zircaloy"]
