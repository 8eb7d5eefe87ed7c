"""What is wrong in a file is said with its line and its name, and nothing else happens."""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.formats.openmc import xml_tree
from conicoid.formats.openmc.reading import MAX_NESTING

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
    assert f"deeper than {xml_tree.MAX_DEPTH} levels" in str(refused(path))
    monkeypatch.setattr(xml_tree, "MAX_ELEMENTS", 1000)
    path.write_text("<geometry>" + "<cell/>" * 2000 + "</geometry>")
    assert "more than 1,000 elements" in str(refused(path))
    monkeypatch.setattr(xml_tree, "MAX_BYTES", 1 << 20)
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
    assert f"expands into {10**60:,} bodies, about " in str(error)
    assert "the limit is 50,000 (max_bodies)" in str(error)
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
    assert "bodies, about" in str(refused(path, max_bodies=500))


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
