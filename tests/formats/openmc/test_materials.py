"""What materials.xml says of a material is kept with it, in units that do not differ from material to material."""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.io import openmc

from .models import EXAMPLE_FILES

MODEL = """<model><materials>{}</materials><geometry>
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
    path.write_text(MODEL.format("".join(materials)), encoding="utf-8")
    return path


def test_what_the_file_says(tmp_path: Path) -> None:
    scene = co.load_openmc(model(tmp_path, FUEL, WATER))
    fuel, void, water = (body.material for body in scene.bodies)
    assert (fuel.name, void.name, water.name) == ("fuel", "void", "material 2")
    assert fuel.properties == {
        "id": 1, "density": 10.3, "ao": {"U235": 0.04, "O16": 2.0}, "wo": {"Gd": 1e-3}, "temperature": 600.5, "depletable": True,
    }  # fmt: skip
    assert water.properties == {"id": 2, "atom_density": 0.1, "sab": ("c_H_in_H2O",)}
    assert void.properties == {"density": 0, "atom_density": 0}
    assert scene.first_hit((0, 0, 9), (0, 0, -1)).material is water


def test_it_goes_through_a_scene_file(tmp_path: Path) -> None:
    scene = co.load_openmc(model(tmp_path, FUEL, WATER))
    co.save(scene, tmp_path / "a.yaml")
    assert co.load(tmp_path / "a.yaml") == scene
    assert co.load(tmp_path / "a.yaml").bodies[0].material.properties["ao"]["O16"] == 2


def test_without_a_list_the_number_is_known(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        MODEL.replace("<materials>{}</materials>", "").replace("model>", "x>").split("<x>")[1].split("</x>")[0]
    )
    assert [m.name for m in {body.material: 0 for body in co.load_openmc(path).bodies}] == [
        "material 1",
        "void",
        "material 2",
    ]
    assert openmc.read(path).bodies[0].material.properties == {"id": 1}


def test_the_example() -> None:
    densities = [body.material.properties["density"] for body in co.load_openmc(EXAMPLE_FILES["pin"]).bodies]
    assert densities == [10.3, 0.0016, 6.55, 0.74]


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
def test_mistakes_are_told_with_the_material(wrong: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(co.SceneFileError, match=message):
        co.load_openmc(model(tmp_path, wrong, WATER))
