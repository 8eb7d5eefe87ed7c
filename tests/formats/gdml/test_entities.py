"""Parts of a GDML file in other files, taken in by entities where that is asked for."""

import pytest

import conicoid as co
from conicoid._util.files import SceneFileError

from ...command_line import run
from .files import MATERIALS, text_of, volume

SOLIDS = '<box name="w" x="9" y="9" z="9"/>'


def written(folder, declarations, materials="&parts;"):
    text = text_of(SOLIDS, volume("world", "w"), materials=materials)
    path = folder / "a.gdml"
    path.write_text(text.replace("<gdml", f"<!DOCTYPE gdml [{declarations}]>\n<gdml", 1))
    return path


def test_files_in_the_folder_are_read_if_asked_for(tmp_path):
    (tmp_path / "materials.xml").write_text(MATERIALS.replace("<materials>", "<materials>&more;"))
    (tmp_path / "more.xml").write_text('<?xml version="1.0" encoding="utf-8"?><!-- none -->')
    path = written(tmp_path, '<!ENTITY parts SYSTEM "./materials.xml"><!ENTITY more SYSTEM "more.xml">')
    with pytest.raises(SceneFileError, match=r"declares an entity.*entities=True \(--entities\)"):
        co.load(path)
    scene = co.load(path, entities=True)
    assert scene.bodies[0].material.name == "iron"
    done = run("import", path, "-o", tmp_path / "a.yaml", "--entities")
    assert done.exit_code == 0
    assert len(co.load(tmp_path / "a.yaml")) == 1


@pytest.mark.parametrize(
    ("declarations", "told"),
    [
        ('<!ENTITY parts "&a;&a;"><!ENTITY a "text">', "declares an entity"),
        ('<!ENTITY % p SYSTEM "materials.xml"> %p;', "declares an entity"),
        ('<!ENTITY parts PUBLIC "x" "materials.xml">', "declares an entity"),
        ('<!ENTITY parts SYSTEM "/etc/passwd">', "file must be the name of a file in the same folder"),
        ('<!ENTITY parts SYSTEM "../a/materials.xml">', "file must be the name of a file in the same folder"),
        ('<!ENTITY parts SYSTEM "http://127.0.0.1:9/a.xml">', "file must be the name of a file in the same folder"),
        ('<!ENTITY parts SYSTEM "none.xml">', "none.xml"),
        ('<!ENTITY parts SYSTEM "link.xml">', "is a link"),
        ('<!ENTITY parts SYSTEM "a.gdml">', "is not XML"),
        ('<!ENTITY parts SYSTEM "itself.xml">', "is not XML"),
        ('<!ENTITY parts SYSTEM "broken.xml">', "broken.xml:2:"),
        ('<!ENTITY parts SYSTEM "often.xml"><!ENTITY none SYSTEM "none_in_it.xml">', "more than 200 times"),
        ('<!ENTITY parts SYSTEM "materials.xml" NDATA gif>', "declares an entity"),
    ],
)
def test_other_entities_are_refused(tmp_path, declarations, told):
    (tmp_path / "materials.xml").write_text(MATERIALS)
    (tmp_path / "itself.xml").write_text("<materials>&parts;</materials>")
    (tmp_path / "broken.xml").write_text("<materials>\n</materials")
    (tmp_path / "none_in_it.xml").write_text("")
    (tmp_path / "often.xml").write_text("<materials>" + "&none;" * 300 + "</materials>")
    (tmp_path / "link.xml").symlink_to("/etc/passwd")
    with pytest.raises(SceneFileError) as error:
        co.load(written(tmp_path, declarations), entities=True)
    assert told in str(error.value)
    assert "root:" not in str(error.value)


def test_the_file_of_a_document_type_is_not_read(tmp_path):
    text = text_of(SOLIDS, volume("world", "w"))
    path = tmp_path / "a.gdml"
    path.write_text(text.replace("<gdml", '<!DOCTYPE gdml SYSTEM "none.dtd">\n<gdml', 1))
    assert len(co.load(path, entities=True)) == 1
