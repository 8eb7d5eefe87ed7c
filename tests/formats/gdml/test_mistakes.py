"""Expressions of GDML, mistakes with their lines, and hostile files."""

import math
from fractions import Fraction

import pytest

import conicoid as co
from conicoid.io.gdml.expressions import UNIT_VALUES, ExpressionError, evaluate

from ...command_line import execute
from .files import HEAD, MATERIALS, placed, scene_of, text_of, volume

WORLD = '<box name="w" x="40" y="40" z="40"/>'


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1), ("0.1+0.2", Fraction(3, 10)), ("2*(3+4)^2", 98), ("-2^2", -4), ("2^3^2", 64), ("2**-1", Fraction(1, 2)),
        ("1e-3*m", 1), ("90*deg*180/pi", 90), ("3 > 2 && 1 <= 1", 1), ("!(1 == 1) || 0", 0), ("--1", 1), ("+1-+1", 0),
        ("max(1, 2)*min(3, 4)", 6), ("sqrt(2.25)", Fraction(3, 2)), ("pow(2, 10)", 1024), ("10/4/5", Fraction(1, 2)),
        (" .5 ", Fraction(1, 2)), ("1.e2", 100), ("g/cm3", Fraction(1, 1000)), ("1 - 2 - 3", -4),
    ],
)  # fmt: skip
def test_values(text, value):
    assert evaluate(text, UNIT_VALUES) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("sin(30*deg)", 0.5),
        ("atan2(1, -1)", 2.356194490192345),
        ("exp(1)", math.e),
        ("log(e^2)", 2.0),
        ("2^0.5", 2**0.5),
    ],
)
def test_functions(text, value):
    assert float(evaluate(text, UNIT_VALUES)) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "ends too early"), ("1+", "ends too early"), ("(1", "lacks a"), ("1 2", "go on with an operator"),
        ("1/0", "divides by zero"), ("0^-1", "divides by zero"), ("__import__('os')", "has \"'os'"), ("system(1)", "functions are"),
        ("sin(1, 2)", "2 numbers in place of 1"), ("(" * 60 + "1" + ")" * 60, "nests deeper"), ("-" * 80 + "1", "nests deeper"),
        ("1+" * 2000 + "1", "longer than"), ("sqrt(-1)", "square root"), ("log(0)", "finite"), ("1e999", "1e300"),
        ("1e999999999", "1e300"), ("(-1)^0.5", "broken power"), ("exp(1e9)", "finite"), ("1;2", "in it"), ("9" * 400, "1e300"),
    ],
)  # fmt: skip
def test_invalid_expressions_are_refused(text, message):
    with pytest.raises(ExpressionError, match=".*" + message.replace("(", r"\(")):
        evaluate(text, UNIT_VALUES)


def test_numbers_do_not_grow_without_end():
    value = evaluate("*".join(["(1/3)^64"] * 40), UNIT_VALUES)
    assert value.denominator.bit_length() < 3000
    assert float(value) == 0 or value > 0


@pytest.mark.parametrize(
    ("solid", "message"),
    [
        ('<box name="s" x="1" y="2"/>', "box 's': z must be given"),
        ('<box name="s" x="1" y="2" z="-3"/>', "z must be > 0, got -3 mm"),
        ('<box name="s" x="1" y="2" z="hight"/>', "z has 'hight', which is not defined (did you mean 'height'?)"),
        ('<box name="s" x="1" y="2" z="1" lunit="parsnip"/>', "lunit has 'parsnip', which is not defined"),
        ('<tube name="s" rmin="3" rmax="2" z="1"/>', "rmin must be < rmax = 2 mm, got 3 mm"),
        ('<tube name="s" rmax="2" z="1" deltaphi="-1"/>', "deltaphi must be > 0"),
        ('<union name="s"><first ref="w"/></union>', "must have a second element"),
        ('<union name="s"><first ref="w"/><second ref="later"/></union>', "there is no solid 'later' before this"),
        ('<union name="s"><first ref="s"/><second ref="w"/></union>', "'s', which is left out"),
        ('<loop for="i" to="3"><box name="s"/></loop>', "for must be a variable that is defined before, got 'i'"),
        ('<polycone name="s"><zplane z="0" rmax="1"/></polycone>', "must have two or more zplane elements"),
        ('<tet name="s" vertex1="p" vertex2="p" vertex3="p" vertex4="p"/>', "there is no position 'p'"),
        (
            '<polyhedra name="s" numsides="1.5"><zplane z="0" rmax="1"/><zplane z="1" rmax="1"/></polyhedra>',
            "numsides must be a whole number",
        ),
        ('<box name="s[0.5]" x="1" y="2" z="1"/>', "index must be whole"),
        ('<reflectedSolid name="s" solid="w" sx="0"/>', "sx, sy and sz must not be 0"),
    ],
)
def test_mistakes_in_solids_are_reported_with_their_line(tmp_path, solid, message):
    define = '<constant name="height" value="3"/>'
    text = text_of(WORLD + "\n" + solid, volume("world", "s" if "name" in solid else "w"), define)
    line = text[: text.index(solid)].count("\n") + 1
    with pytest.raises((co.SceneFileError, ValueError)) as error:
        scene_of(tmp_path, text, strict=True)
    assert message in str(error.value)
    assert f"a.gdml:{line}" in str(error.value)


@pytest.mark.parametrize(
    ("structure", "message"),
    [
        (volume("world", "s"), "there is no solid 's' before this"),
        (volume("world", "w", material="lead"), "there is no material 'lead'"),
        (volume("world", "w", placed("core")), "there is no volume 'core' before this"),
        (volume("world", "w", placed("world")), "is placed in itself"),
        (volume("world", "w", "<physvol/>"), "must have a volumeref or a file"),
        (
            volume("world", "w", '<replicavol number="2"><volumeref ref="world"/></replicavol>'),
            "must have a replicate_along_axis",
        ),
        (
            volume("world", "w", '<divisionvol axis="kUp"><volumeref ref="world"/></divisionvol>'),
            "axis must be one of kXAxis",
        ),
        ('<volume name="world"/>', "must have a solidref"),
        ("", "there is no volume 'world'"),
    ],
)
def test_mistakes_in_the_structure(tmp_path, structure, message):
    with pytest.raises(co.SceneFileError) as error:
        scene_of(tmp_path, text_of(WORLD, structure))
    assert message in str(error.value)
    assert "a.gdml:" in str(error.value)


def bomb(levels):
    parts = [volume("v0", "w")]
    parts += [volume(f"v{k}", "w", placed(f"v{k - 1}") * 10) for k in range(1, levels)]
    return "".join(parts) + volume("world", "w", placed(f"v{levels - 1}"))


HOSTILE = {
    "entity": ('<!DOCTYPE gdml [<!ENTITY a "x">]>\n<gdml>&a;</gdml>', "declares an entity"),
    "external entity": ('<!DOCTYPE gdml [<!ENTITY a SYSTEM "/etc/passwd">]>\n<gdml>&a;</gdml>', "declares an entity"),
    "parameter entity": ('<!DOCTYPE gdml [<!ENTITY % a SYSTEM "x"> %a;]>\n<gdml/>', "declares an entity"),
    "document type": ('<!DOCTYPE gdml SYSTEM "a.dtd">\n<gdml/>', "an external reference"),
    "bodies": (text_of(WORLD, bomb(20)), "expands into"),
    "depth": (
        text_of(WORLD, volume("v0", "w") + "".join(volume(f"v{k}", "w", placed(f"v{k - 1}")) for k in range(1, 300)) + volume("world", "w", placed("v299"))),
        "nest deeper than 100 levels",
    ),
    "booleans": (
        text_of(
            WORLD + '<box name="b0" x="1" y="1" z="1"/>'
            + "".join(f'<union name="b{k}"><first ref="b{k - 1}"/><second ref="b{k - 1}"/></union>' for k in range(1, 60)),
            volume("world", "b59"),
        ),
        "must be of at most 4,000 solids",
    ),
    "loop": (
        text_of(WORLD, '<loop for="i" to="1e12"/>' + volume("world", "w"), '<variable name="i" value="0"/>'),
        "loops turn more than 200,000 times",
    ),
    "elements": ("<gdml>" * 50 + "</gdml>" * 50, "deeper than 32 levels"),
    "no XML": ("<gdml><solids></gdml>", "is not XML"),
    "no world": (HEAD + "</gdml>", "must have a setup element"),
    "replicas": (
        text_of(
            WORLD,
            volume("p", "w") + volume("world", "w", '<replicavol number="1e9"><volumeref ref="p"/></replicavol>'),
        ),
        "must be a whole number from 0 to 1,000,000",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused(tmp_path, name):
    text, message = HOSTILE[name]
    with pytest.raises(co.SceneFileError, match=message):
        scene_of(tmp_path, text)


def test_a_document_type_without_entities_is_harmless(tmp_path):
    text = text_of(WORLD, volume("world", "w")).replace("<gdml", "<!DOCTYPE gdml []>\n<gdml", 1)
    assert len(scene_of(tmp_path, text)) == 1


# --- Parts of a GDML file in other files, which entities include if the user asks for it

SOLIDS = '<box name="w" x="9" y="9" z="9"/>'


def gdml_file(folder, declarations, materials="&parts;"):
    text = text_of(SOLIDS, volume("world", "w"), materials=materials)
    path = folder / "a.gdml"
    path.write_text(text.replace("<gdml", f"<!DOCTYPE gdml [{declarations}]>\n<gdml", 1))
    return path


def test_files_in_the_folder_are_read_on_request(tmp_path):
    (tmp_path / "materials.xml").write_text(MATERIALS.replace("<materials>", "<materials>&more;"))
    (tmp_path / "more.xml").write_text('<?xml version="1.0" encoding="utf-8"?><!-- none -->')
    path = gdml_file(tmp_path, '<!ENTITY parts SYSTEM "./materials.xml"><!ENTITY more SYSTEM "more.xml">')
    with pytest.raises(co.SceneFileError, match=r"declares an entity.*entities=True \(--entities\)"):
        co.load(path)
    scene = co.load(path, entities=True)
    assert scene.bodies[0].material.name == "iron"
    execute("import", path, "-o", tmp_path / "a.yaml", "--entities")
    assert len(co.load(tmp_path / "a.yaml")) == 1


@pytest.mark.parametrize(
    ("declarations", "message"),
    [
        ('<!ENTITY parts "&a;&a;"><!ENTITY a "text">', "declares an entity"),
        ('<!ENTITY % p SYSTEM "materials.xml"> %p;', "declares an entity"),
        ('<!ENTITY parts PUBLIC "x" "materials.xml">', "declares an entity"),
        ('<!ENTITY parts SYSTEM "/etc/passwd">', "file '/etc/passwd' is outside of the folder"),
        ('<!ENTITY parts SYSTEM "../a/materials.xml">', "file '../a/materials.xml' is outside of the folder"),
        ('<!ENTITY parts SYSTEM "http://127.0.0.1:9/a.xml">', "cannot be read"),
        ('<!ENTITY parts SYSTEM "none.xml">', "none.xml"),
        ('<!ENTITY parts SYSTEM "link.xml">', "outside of the folder"),
        ('<!ENTITY parts SYSTEM "a.gdml">', "is not XML"),
        ('<!ENTITY parts SYSTEM "itself.xml">', "is not XML"),
        ('<!ENTITY parts SYSTEM "broken.xml">', "broken.xml:2:"),
        ('<!ENTITY parts SYSTEM "often.xml"><!ENTITY none SYSTEM "none_in_it.xml">', "more than 200 times"),
        ('<!ENTITY parts SYSTEM "materials.xml" NDATA gif>', "declares an entity"),
    ],
)
def test_other_entities_are_refused(tmp_path, declarations, message):
    (tmp_path / "materials.xml").write_text(MATERIALS)
    (tmp_path / "itself.xml").write_text("<materials>&parts;</materials>")
    (tmp_path / "broken.xml").write_text("<materials>\n</materials")
    (tmp_path / "none_in_it.xml").write_text("")
    (tmp_path / "often.xml").write_text("<materials>" + "&none;" * 300 + "</materials>")
    (tmp_path / "link.xml").symlink_to("/etc/passwd")
    with pytest.raises(co.SceneFileError) as error:
        co.load(gdml_file(tmp_path, declarations), entities=True)
    assert message in str(error.value)
    assert "root:" not in str(error.value)


def test_the_file_of_a_document_type_is_not_read(tmp_path):
    text = text_of(SOLIDS, volume("world", "w"))
    path = tmp_path / "a.gdml"
    path.write_text(text.replace("<gdml", '<!DOCTYPE gdml SYSTEM "none.dtd">\n<gdml', 1))
    assert len(co.load(path, entities=True)) == 1
