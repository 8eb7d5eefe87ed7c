"""Colours as auxiliary information: read where they are understood, told where not, written again."""

from __future__ import annotations

import pytest

import conicoid as co

from .files import text_of, volume

BOX = '<box name="s" x="2" y="2" z="2"/>'


def loaded(folder, value, kind="Color"):
    """A box of a colour, and what is told."""
    hint = f'<auxiliary auxtype="{kind}" auxvalue="{value}"/>'
    path = folder / "a.gdml"
    path.write_text(text_of(BOX, volume("world", "s", hint)), encoding="utf-8")
    return co.load(path)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("#12aB34", "#12ab34"), ("#12ab34ff", "#12ab34"), ("Red", "#ff0000"), ("grey", "#808080"),
        ("(1.0,0.0,0.2)", "#ff0033"), ("1 .4 0", "#ff6600"), ("(0,1,0,1)", "#00ff00"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("kind", ["Color", "color", "Colour"])
def test_colors_are_read_and_written(tmp_path, caplog, value, expected, kind):
    scene = loaded(tmp_path, value, kind)
    assert scene.bodies[0].material.color == expected
    co.save(scene, tmp_path / "a.yaml")
    co.export(scene, tmp_path / "b.gdml")
    assert not caplog.records
    for again in (co.load(tmp_path / "b.gdml"), co.load(tmp_path / "a.yaml")):
        assert again.bodies[0].material == scene.bodies[0].material


@pytest.mark.parametrize(
    "value", ["mauve", "", "#12345", "300", "1 2 3", "nan 0 0", "0.1 0.2", "(0,0,0,0,0)", "1e0 0 0"]
)
def test_what_is_not_understood_is_told(tmp_path, caplog, value):
    material = loaded(tmp_path, value).bodies[0].material
    told = caplog.text
    assert material.color == loaded(tmp_path, "0", "SensDet").bodies[0].material.color
    assert f"has the colour {value!r}, which is not understood" in told


def test_opacity_is_told(tmp_path, caplog):
    assert loaded(tmp_path, "#ff000080").bodies[0].material.color == "#ff0000"
    assert "has a colour of opacity 0.502, which is not read" in caplog.text


def test_one_material_in_several_colors(tmp_path):
    """It is one material in the file that is written, and two in a scene file, where names are of looks."""
    solids, inside = BOX + '<box name="w" x="99" y="99" z="99"/>', ""
    structure = ""
    for k, hint in enumerate(
        ("", '<auxiliary auxtype="Color" auxvalue="red"/>', '<auxiliary auxtype="Color" auxvalue="blue"/>')
    ):
        structure += volume(f"v{k}", "s", hint)
        inside += f'<physvol name="v{k}"><volumeref ref="v{k}"/><position x="{9 * k}" y="0" z="0"/></physvol>'
    (tmp_path / "a.gdml").write_text(text_of(solids, structure + volume("world", "w", inside, "air")), encoding="utf-8")
    scene = co.load(tmp_path / "a.gdml")
    assert len({body.material for body in scene.bodies[1:]}) == 3
    assert len({body.material.name for body in scene.bodies[1:]}) == 1
    co.export(scene, tmp_path / "b.gdml")
    assert (tmp_path / "b.gdml").read_text().count("<material name") == 2
    co.save(scene, tmp_path / "c.yaml")
    for path in ("b.gdml", "c.yaml"):
        assert [body.material for body in co.load(tmp_path / path).bodies] == [body.material for body in scene.bodies]
