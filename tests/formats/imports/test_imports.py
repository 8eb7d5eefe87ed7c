"""Properties of all imports: the content decides the format, options are checked, names stay."""

import pytest

import conicoid as co
from conicoid.io.importers import IMPORT_FORMATS, detect_format, find_root_element, matches_name

from ...command_line import execute, failure

PIN = """<geometry>
  <surface id="1" type="z-cylinder" coeffs="0 0 0.4"/>
  <surface id="2" type="z-cylinder" coeffs="0 0 0.5"/>
  <cell id="1" name="fuel" material="1" region="-1"/>
  <cell id="2" name="cladding" material="2" region="1 -2"/>
</geometry>"""


@pytest.fixture
def pin(tmp_path):
    path = tmp_path / "a.yaml"  # its name suggests another format
    path.write_text(PIN)
    return path


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("<geometry/>", "geometry"),
        ("  \n<?xml version='1.0'?>\n<!-- <model> -->\n<geometry a='<b>'>", "geometry"),
        ("<!DOCTYPE gdml [<!ENTITY a SYSTEM 'b'>]>\n<gdml:gdml x='1'>", "gdml"),
        ("<!DOCTYPE gdml SYSTEM 'a.dtd'><gdml>", "gdml"),
        ("conicoid: 1\nbodies: []", None),
        ("<", ""),
    ],
)
def test_the_first_element_of_a_text(text, name):
    assert find_root_element(text) == name


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("<geometry/>", "OpenMC geometries"), ("group() {}", "OpenSCAD's .csg"), ("data_a", "molecules (XYZ, PDB, mmCIF, CIF)"),
        ("1\n\nC 0 0 0", "molecules (XYZ, PDB, mmCIF, CIF)"), ("SURF 0\n", "Zemax lens files"),
    ],
)  # fmt: skip
def test_a_byte_order_mark_hides_no_format(text, name, tmp_path):
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert detect_format(tmp_path / "a").name == name


def test_a_format_is_known_by_its_content(pin):
    found = detect_format(pin)
    assert found.name.startswith("OpenMC")
    assert [body.name for body in co.load(pin).bodies] == ["cell 1 'fuel'", "cell 2 'cladding'"]


def test_scene_files_are_of_no_other_format(tmp_path):
    path = tmp_path / "scene.gdml"
    co.save(co.Sphere(1), path.with_suffix(".yaml"))
    path.write_bytes(path.with_suffix(".yaml").read_bytes())
    assert detect_format(path) is None
    assert len(co.load(path)) == 1
    assert detect_format(tmp_path / "none.xml") is None


@pytest.mark.parametrize("name", [each.name for each in IMPORT_FORMATS])
def test_every_format_refuses_empty_files_clearly(name, tmp_path):
    assert len({each.name for each in IMPORT_FORMATS}) == len(IMPORT_FORMATS)
    path = tmp_path / "empty"
    path.write_bytes(b"")
    assert detect_format(path) is None


def test_only_named_parts_are_imported(pin):
    scene = co.load(pin, only="clad")
    assert [body.name for body in scene.bodies] == ["cell 2 'cladding'"]
    assert scene.notes[-1] == "1 body of 2 named by 'clad'"


def test_names_and_patterns():
    assert matches_name("fuel", "core/fuel[3]")
    assert not matches_name("Fuel", "core/fuel[3]")
    assert matches_name("core/*", "core/fuel[3]")
    assert not matches_name("*fuel", "core/fuel[3]")


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        (dict(depth=1), ValueError, "load: depth means nothing for an OpenMC geometry: there are void, strict, only"),
        (dict(dept=1), ValueError, "option must be one of .*got 'dept' \\(did you mean 'depth'\\?\\)"),
        (dict(only=""), ValueError, "load: only must be a pattern of names or None, got ''"),
        (dict(strict=1), ValueError, "load: strict must be true or false, got 1"),
        (dict(max_bodies=0), ValueError, "load: max_bodies must be an integer >= 1, got 0"),
        (dict(progress=3), TypeError, "load: progress must be a function or None"),
        (dict(only="steel"), ValueError, "load: only 'steel' names none of 2 bodies"),
        (dict(strict=True), ValueError, "strict is set:\nundefined regions"),
    ],
)
def test_options_refuse(pin, options, kind, message):
    with pytest.raises(kind, match=message):
        co.load(pin, **options)


def test_scene_files_take_no_options_of_imports(tmp_path):
    co.save(co.Sphere(1), tmp_path / "scene.yaml")
    with pytest.raises(TypeError, match="load: only are for files of other programs"):
        co.load(tmp_path / "scene.yaml", only="fuel")


def test_the_command_reads_any_format_and_names_those_there_are(pin, tmp_path):
    execute("import", str(pin), "-o", str(tmp_path / "out.yaml"), "--only", "fuel")
    assert len(co.load(tmp_path / "out.yaml")) == 1
    co.save(co.Sphere(1), tmp_path / "scene.yaml")
    assert "is of no known format: OpenMC geometries" in failure(
        "import", str(tmp_path / "scene.yaml"), "-o", str(tmp_path / "other.yaml")
    )
