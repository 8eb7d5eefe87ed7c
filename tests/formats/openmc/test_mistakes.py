"""What is wrong in a file is said with its line and its name, and nothing else happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import conicoid as co
from conicoid.io import xml_tree, xml_tree as xml_builder
from conicoid.io.openmc.importer import MAX_NESTING

from .broken import CASES, geometry


def refused(path: Path, **options: object) -> co.SceneFileError:
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path, **options)  # type: ignore[arg-type]
    return caught.value


@pytest.mark.parametrize("name", CASES)
def test_mistakes_are_found_where_they_are(name: str, tmp_path: Path) -> None:
    content, line, phrases = CASES[name]
    path = tmp_path / "geometry.xml"
    path.write_text(content, encoding="utf-8")
    error = refused(path)
    for phrase in phrases:
        assert phrase in str(error)
    assert str(error).startswith(f"{path}:{line}:" if line else f"{path}: ")
    assert len(error.problems) == 1


def test_all_mistakes_are_listed_in_the_order_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        geometry(
            "<surface id='8' type='x-torus' coeffs='0 0 0 1 2 3'/>",
            "<surface id='9' type='x-plane' coeffs='a'/>",
            "<cell id='1' region='-1'/>",
            "<cell id='2' material='1' region='(1'/>",
        )
    )
    assert [(problem.line, problem.where) for problem in refused(path).problems] == [
        (3, "surface 8"), (4, "surface 9"), (5, "cell 1"), (6, "cell 2"),
    ]  # fmt: skip


def told(text: str, path: Path) -> list[tuple[int, str]]:
    path.write_text(text, encoding="utf-8")
    return [(problem.line, problem.message) for problem in refused(path).problems]


def test_independent_mistakes_of_all_stages_are_told(tmp_path: Path) -> None:
    """In elements, between them, and in the file as a whole; what follows from another mistake is not."""
    text = geometry(
        "<surface id='8' type='x-torus' coeffs='0 0 0 1 2 3'/>",
        "<cell id='1' material='1' region='-1 8 77'/>",
        "<cell id='2' universe='5' fill='6'/>",
        "<cell id='3' universe='6' fill='5'/>",
        "<lattice id='9' dimension='1 1' lower_left='0 0' pitch='1 1' universes='44'/>",
        "<cell id='4' fill='33'/>",
    )
    assert told(text, tmp_path / "geometry.xml") == [
        (1, "has universes that contain themselves: universe 5 → universe 6 → universe 5"),
        (3, "is a torus (x-torus), which is no quadric: Conicoid cannot express it"),
        (4, "region refers to unknown surface 77"),
        (7, "refers to unknown universe 44"),
        (8, "fill 33 is neither a universe nor a lattice"),
    ]


def test_several_mistakes_in_one_element_are_told(tmp_path: Path) -> None:
    text = geometry(
        "<surface id='8' type='plane' coeffs='0 0 0 1' boundary='sticky'/>",
        "<cell id='1' material='x' universe='y' region='(1' rotation='1 2' fill='2' translation='a b c'/>",
        "<lattice id='9' dimension='2 1' lower_left='0' pitch='1 0' universes='1' outer='z'/>",
        "<hex_lattice id='10' n_rings='1' n_axial='1' center='0 0' pitch='1' orientation='z' universes='1 2'/>",
    )
    lines = [line for line, _ in told(text, tmp_path / "geometry.xml")]
    assert [lines.count(line) for line in (3, 4, 5, 6)] == [2, 6, 4, 4]


def test_mistakes_beside_a_broken_list_of_materials_are_told(tmp_path: Path) -> None:
    (tmp_path / "materials.xml").write_text("<materials>\n<material/>\n<material id='x'/></materials>")
    path = tmp_path / "geometry.xml"
    path.write_text(geometry("<cell id='1' material='3' region='77'/>"))
    assert str(refused(path)).splitlines() == [
        f"{path}: materials.xml:2:1: material: needs the attribute or element 'id'",
        f"{path}: materials.xml:3:1: material: id must be an integer, got 'x'",
        f"{path}:3:1: cell 1: region refers to unknown surface 77",
    ]
    inside = geometry("<cell id='1' material='3' region='77'/>")
    inside = f"<model>{inside}<materials>\n<material/></materials></model>"
    assert [line for line, _ in told(inside, tmp_path / "model.xml")] == [3, 5]


def test_all_that_floats_cannot_hold_is_told(tmp_path: Path) -> None:
    """Each cell once, however often it stands."""
    text = geometry(
        "<surface id='3' type='x-plane' coeffs='1.5e308'/>",
        "<cell id='1' universe='1' material='1' region='3'/>",
        "<cell id='2' universe='1' material='1' region='-3'/>",
        "<cell id='5' fill='1' region='-1'/>",
        "<cell id='6' fill='1' region='1'/>",
    )
    assert [line for line, _ in told(text, tmp_path / "geometry.xml")] == [4, 5]


ALONE = {
    name: (content.split("\n")[2], phrases)
    for name, (content, line, phrases) in CASES.items()
    if line == 3 and name not in ("a number taken twice", "filled with itself")
}


@pytest.mark.parametrize("first", range(0, len(ALONE), 10))
def test_ten_broken_elements_in_one_file_are_all_told(first: int, tmp_path: Path) -> None:
    """Those of the mistakes above that are in one element, each under a number of its own."""
    chosen = list(ALONE.values())[first : first + 10]
    elements = [re.sub(r"id='[459]'", f"id='{100 + i}'", element) for i, (element, _) in enumerate(chosen)]
    found = told(geometry(*elements, "<cell id='1' universe='1' material='1'/>"), tmp_path / "geometry.xml")
    for i, (_, phrases) in enumerate(chosen):
        messages = " ".join(message for line, message in found if line == 3 + i)
        assert phrases[-1].rpartition(": ")[2] in messages
    assert len(found) >= len(chosen)


def test_materials_are_checked_where_there_is_a_list(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(geometry("<cell id='1' material='void 3 4' region='-1'/>"))
    co.load_openmc(path)
    (tmp_path / "materials.xml").write_text("<materials>\n<material id='3'/></materials>")
    assert "cell 1: material 4 is not in the list of materials" in str(refused(path))
    (tmp_path / "materials.xml").write_text("<materials>\n<material id='3'/><material id='3'/></materials>")
    error = refused(path)
    assert str(error).startswith(f"{tmp_path / 'materials.xml'}:2:")
    assert "id 3 is taken by another material" in str(error)


BOMB = """<?xml version="1.0"?>
<!DOCTYPE geometry [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]>
<geometry><cell id="&c;"/></geometry>"""
HOSTILE = {
    "billion laughs": BOMB,
    "a file of this machine": "<!DOCTYPE g [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>\n<geometry><cell id='1' name='&x;'/></geometry>",
    "a file of another": "<!DOCTYPE g SYSTEM 'http://127.0.0.1:9/evil.dtd'>\n<geometry/>",
    "a parameter entity": "<!DOCTYPE g [<!ENTITY % p SYSTEM 'file:///etc/hostname'> %p;]>\n<geometry/>",
    "a harmless document type": "<!DOCTYPE geometry>\n<geometry/>",
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("file", ["geometry.xml", "materials.xml"])
def test_document_types_and_entities_are_refused(name: str, file: str, tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(geometry("<cell id='1' material='1'/>"))
    (tmp_path / file).write_text(HOSTILE[name])
    assert "is refused: it declares a document type (DOCTYPE)" in str(refused(path))


def test_an_undefined_entity_is_no_xml(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text("<geometry>&lt;&x;</geometry>")
    assert "undefined entity" in str(refused(path))


def test_size_depth_and_number_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text("<a>" * 100_000)
    assert f"deeper than {xml_builder.MAX_DEPTH} levels" in str(refused(path))
    monkeypatch.setattr(xml_builder, "MAX_ELEMENTS", 1000)
    path.write_text("<geometry>" + "<cell/>" * 2000 + "</geometry>")
    assert "more than 1,000 elements" in str(refused(path))
    monkeypatch.setattr(xml_tree, "MAX_XML_BYTES", 1 << 20)
    path.write_text("<geometry>" + " " * (1 << 20) + "</geometry>")
    assert "is too large: at most 1 MB are read" in str(refused(path))


def test_only_files_are_read(tmp_path: Path) -> None:
    assert "cannot be read: no such file or directory" in str(refused(tmp_path / "none.xml"))
    assert "cannot be read: is a directory" in str(refused(tmp_path))
    assert "cannot be read: is not a regular file" in str(refused(Path("/dev/zero")))
    assert "cannot be read: a path cannot hold a zero character" in str(refused(Path("a\0b")))


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_bytes(bytes(range(256)) * 10)
    assert "is not XML" in str(refused(path))
    path.write_bytes("<geometry><cell id='1' material='1' name='é'/></geometry>".encode("latin-1"))
    assert "is not XML" in str(refused(path))
    path.write_bytes(
        "<?xml version='1.0' encoding='latin-1'?><geometry><cell id='1' material='1' name='é'/></geometry>".encode(
            "latin-1"
        )
    )
    assert co.load_openmc(path).bodies[0].name == "cell 1 'é'"


def chain(levels: int, copies: int = 1) -> str:
    """Universes in universes; each is filled `copies` times into the one before."""
    lines = []
    for level in range(levels):
        for copy in range(copies):
            lines.append(f"<cell id='{level * copies + copy + 1}' universe='{level}' fill='{level + 1}' region='-2'/>")
    return geometry(*lines, f"<cell id='{levels * copies + 1}' universe='{levels}' material='1'/>")


def test_nesting_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(chain(MAX_NESTING - 1))
    assert len(co.load_openmc(path).bodies) == 1
    path.write_text(chain(MAX_NESTING))
    assert f"nests universes deeper than {MAX_NESTING} levels" in str(refused(path))
    path.write_text(chain(20_000))
    assert "nests universes deeper" in str(refused(path))


def test_what_would_not_fit_is_counted_and_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(chain(60, copies=10))
    error = refused(path)
    assert f"expands into {10**60:,} bodies, at least " in str(error)
    assert "the limit is 4,000,000 (max_bodies)" in str(error)
    path.write_text(chain(3, copies=2))
    assert len(co.load_openmc(path, max_bodies=8).bodies) == 8
    assert "expands into 8 bodies" in str(refused(path, max_bodies=7))


def test_a_repeated_outer_universe_counts_too(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        geometry(
            "<surface id='3' type='sphere' coeffs='0 0 0 1e6'/>",
            "<cell id='1' universe='1' material='1' region='-2'/>",
            "<lattice id='4' dimension='1 1' lower_left='0 0' pitch='1 1' outer='1' universes='1'/>",
            "<cell id='7' fill='4' region='-3'/>",
        )
    )
    assert "bodies, at least" in str(refused(path, max_bodies=500))


def test_numbers_that_leave_the_range_of_floats_on_the_way(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(
        geometry(
            "<surface id='3' type='x-plane' coeffs='1.5e308'/>",
            "<cell id='1' universe='1' material='1' region='3'/>",
            "<cell id='2' fill='1' translation='1.5e308 0 0'/>",
        )
    )
    assert "cell 1 @ cell 2: cannot be expressed in double precision" in str(refused(path))


def test_a_region_of_thousands_of_half_spaces_is_read_quickly(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    holes = [f"<surface id='{10 + i}' type='sphere' coeffs='{i % 100} {i // 100} 0 0.4'/>" for i in range(5_000)]
    region = " ".join(str(10 + i) for i in range(5_000))
    path.write_text(geometry(*holes, f"<cell id='1' material='1' region='{region} -2'/>"))
    (body,) = co.load_openmc(path).bodies
    assert body.shape.bounds[1].tolist() == [1, 1, 1]
