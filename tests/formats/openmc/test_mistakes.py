"""OpenMC: mistakes with their lines, and limits of the expansion of a file."""

import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

import conicoid as co
from benchmarks.comparison.scenes import write_core
from conicoid.io import importers as options, xml_tree, xml_tree as xml_builder
from conicoid.io.openmc import geometry as limits
from conicoid.io.openmc.importer import MAX_NESTING, read_openmc_geometry

from ...children import ROOT
from .models import CASES, geometry, geometry_file

# --- Mistakes in a file are errors with line and name, and nothing else happens


def import_error(path: Path, **options: object) -> co.SceneFileError:
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path, **options)  # type: ignore[arg-type]
    return caught.value


@pytest.mark.parametrize("name", CASES)
def test_mistakes_are_found_where_they_are(name: str, tmp_path: Path) -> None:
    content, line, phrases = CASES[name]
    path = geometry_file(content, tmp_path)
    error = import_error(path)
    for phrase in phrases:
        assert phrase in str(error)
    assert str(error).startswith(f"{path}:{line}:" if line else f"{path}: ")
    assert len(error.problems) == 1


def test_all_mistakes_are_listed_in_the_order_of_the_file(tmp_path: Path) -> None:
    path = geometry_file(
        geometry(
            "<surface id='8' type='x-toru' coeffs='0 0 0 1 2 3'/>",
            "<surface id='9' type='x-plane' coeffs='a'/>",
            "<cell id='1' region='-1'/>",
            "<cell id='2' material='1' region='(1'/>",
        ),
        tmp_path,
    )
    assert [(problem.line, problem.where) for problem in import_error(path).problems] == [
        (3, "surface 8"), (4, "surface 9"), (5, "cell 1"), (6, "cell 2"),
    ]  # fmt: skip


def problems_of(text: str, path: Path) -> list[tuple[int, str]]:
    path.write_text(text, encoding="utf-8")
    return [(problem.line, problem.message) for problem in import_error(path).problems]


def test_independent_mistakes_of_all_stages_are_reported(tmp_path: Path) -> None:
    """Mistakes are in elements, between them, and in the file as a whole.

    Consequences of another mistake are not reported.
    """
    text = geometry(
        "<surface id='8' type='x-torus' coeffs='0 0 0 1 2 3' boundary='sticky'/>",
        "<cell id='1' material='1' region='-1 8 77'/>",
        "<cell id='2' universe='5' fill='6'/>",
        "<cell id='3' universe='6' fill='5'/>",
        "<lattice id='9' dimension='1 1' lower_left='0 0' pitch='1 1' universes='44'/>",
        "<cell id='4' fill='33'/>",
    )
    assert problems_of(text, tmp_path / "geometry.xml") == [
        (1, "has universes that contain themselves: universe 5 → universe 6 → universe 5"),
        (3, "boundary must be one of periodic, reflective, transmission, vacuum, white, got 'sticky'"),
        (4, "region refers to unknown surface 77"),
        (7, "refers to unknown universe 44"),
        (8, "fill 33 is neither a universe nor a lattice"),
    ]


def test_several_mistakes_in_one_element_are_reported(tmp_path: Path) -> None:
    text = geometry(
        "<surface id='8' type='plane' coeffs='0 0 0 1' boundary='sticky'/>",
        "<cell id='1' material='x' universe='y' region='(1' rotation='1 2' fill='2' translation='a b c'/>",
        "<lattice id='9' dimension='2 1' lower_left='0' pitch='1 0' universes='1' outer='z'/>",
        "<hex_lattice id='10' n_rings='1' n_axial='1' center='0 0' pitch='1' orientation='z' universes='1 2'/>",
    )
    lines = [line for line, _ in problems_of(text, tmp_path / "geometry.xml")]
    assert [lines.count(line) for line in (3, 4, 5, 6)] == [2, 6, 4, 4]


def test_mistakes_beside_a_broken_list_of_materials_are_reported(tmp_path: Path) -> None:
    (tmp_path / "materials.xml").write_text("<materials>\n<material/>\n<material id='x'/></materials>")
    path = geometry_file(geometry("<cell id='1' material='3' region='77'/>"), tmp_path)
    assert str(import_error(path)).splitlines() == [
        f"{path}: materials.xml:2:1: material: needs the attribute or element 'id'",
        f"{path}: materials.xml:3:1: material: id must be an integer, got 'x'",
        f"{path}:3:1: cell 1: region refers to unknown surface 77",
    ]
    inside = geometry("<cell id='1' material='3' region='77'/>")
    inside = f"<model>{inside}<materials>\n<material/></materials></model>"
    assert [line for line, _ in problems_of(inside, tmp_path / "model.xml")] == [3, 5]


def test_numbers_beyond_floats_are_reported(tmp_path: Path) -> None:
    """Each cell is reported once, however many places it has."""
    text = geometry(
        "<surface id='3' type='x-plane' coeffs='1.5e308'/>",
        "<cell id='1' universe='1' material='1' region='3'/>",
        "<cell id='2' universe='1' material='1' region='-3'/>",
        "<cell id='5' fill='1' region='-1'/>",
        "<cell id='6' fill='1' region='1'/>",
    )
    assert [line for line, _ in problems_of(text, tmp_path / "geometry.xml")] == [4, 5]


def test_materials_are_checked_against_their_list(tmp_path: Path) -> None:
    path = geometry_file(geometry("<cell id='1' material='void 3 4' region='-1'/>"), tmp_path)
    co.load_openmc(path)
    (tmp_path / "materials.xml").write_text("<materials>\n<material id='3'/></materials>")
    assert "cell 1: material 4 is not in the list of materials" in str(import_error(path))
    (tmp_path / "materials.xml").write_text("<materials>\n<material id='3'/><material id='3'/></materials>")
    error = import_error(path)
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
    path = geometry_file(geometry("<cell id='1' material='1'/>"), tmp_path)
    (tmp_path / file).write_text(HOSTILE[name])
    assert "is refused: it declares a document type (DOCTYPE)" in str(import_error(path))


def test_size_depth_and_number_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = geometry_file("<a>" * 100_000, tmp_path)
    assert f"deeper than {xml_builder.MAX_DEPTH} levels" in str(import_error(path))
    monkeypatch.setattr(xml_builder, "MAX_ELEMENTS", 1000)
    path.write_text("<geometry>" + "<cell/>" * 2000 + "</geometry>")
    assert "more than 1,000 elements" in str(import_error(path))
    monkeypatch.setattr(xml_tree, "MAX_XML_BYTES", 1 << 20)
    path.write_text("<geometry>" + " " * (1 << 20) + "</geometry>")
    assert "is too large: at most 1 MB are read" in str(import_error(path))


@pytest.mark.parametrize(("path", "reason"), [
    ("{}/none.xml", "no such file or directory"), ("{}", "is a directory"), ("/dev/zero", "is not a regular file"),
    ("a\0b", "a path cannot hold a zero character"),
])  # fmt: skip
def test_only_files_are_read(path: str, reason: str, tmp_path: Path) -> None:
    assert f"cannot be read: {reason}" in str(import_error(Path(path.format(tmp_path))))


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_bytes(bytes(range(256)) * 10)
    assert "is not XML" in str(import_error(path))
    path.write_bytes("<geometry><cell id='1' material='1' name='é'/></geometry>".encode("latin-1"))
    assert "is not XML" in str(import_error(path))
    path.write_bytes(
        "<?xml version='1.0' encoding='latin-1'?><geometry><cell id='1' material='1' name='é'/></geometry>".encode(
            "latin-1"
        )
    )
    assert co.load_openmc(path).bodies[0].name == "cell 1 'é'"


def chain(levels: int, copies: int = 1) -> str:
    """Return universes in universes. Each fills `copies` cells of the one before."""
    lines = []
    for level in range(levels):
        for copy in range(copies):
            lines.append(f"<cell id='{level * copies + copy + 1}' universe='{level}' fill='{level + 1}' region='-2'/>")
    return geometry(*lines, f"<cell id='{levels * copies + 1}' universe='{levels}' material='1'/>")


WHOLE = {  # a file, options, and a part of the message
    "an undefined entity": ("<geometry>&lt;&x;</geometry>", {}, "undefined entity"),
    "a level too many": (chain(MAX_NESTING), {}, f"nests universes deeper than {MAX_NESTING} levels"),
    "far too many levels": (chain(20_000), {}, "nests universes deeper"),
    "ten copies in sixty levels": (chain(60, copies=10), {}, f"expands into {10**60:,} bodies, at least "),
    "the limit": (chain(60, copies=10), {}, "the limit is 4,000,000 (max_bodies)"),
    "a body too many": (chain(3, copies=2), {"max_bodies": 7}, "expands into 8 bodies"),
    "an outer universe, repeated": (
        geometry(
            "<surface id='3' type='sphere' coeffs='0 0 0 1e6'/>", "<cell id='1' universe='1' material='1' region='-2'/>",
            "<lattice id='4' dimension='1 1' lower_left='0 0' pitch='1 1' outer='1' universes='1'/>", "<cell id='7' fill='4' region='-3'/>",
        ), {"max_bodies": 500}, "bodies, at least",
    ),
    "numbers that leave the range of floats on the way": (
        geometry(
            "<surface id='3' type='x-plane' coeffs='1.5e308'/>", "<cell id='1' universe='1' material='1' region='3'/>",
            "<cell id='2' fill='1' translation='1.5e308 0 0'/>",
        ), {}, "cell 1 @ cell 2: cannot be expressed in double precision",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WHOLE)
def test_impossible_geometries_are_refused(name: str, tmp_path: Path) -> None:
    text, options_, phrase = WHOLE[name]
    path = geometry_file(text, tmp_path)
    assert phrase in str(import_error(path, **options_))


@pytest.mark.parametrize(("text", "count"), [(chain(MAX_NESTING - 1), 1), (chain(3, copies=2), 8)])
def test_as_many_levels_and_bodies_as_may_be(text: str, count: int, tmp_path: Path) -> None:
    path = geometry_file(text, tmp_path)
    assert len(co.load_openmc(path, max_bodies=count).bodies) == count


def test_a_region_of_thousands_of_half_spaces_is_read_quickly(tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    holes = [f"<surface id='{10 + i}' type='sphere' coeffs='{i % 100} {i // 100} 0 0.4'/>" for i in range(5_000)]
    region = " ".join(str(10 + i) for i in range(5_000))
    path.write_text(geometry(*holes, f"<cell id='1' material='1' region='{region} -2'/>"))
    (body,) = co.load_openmc(path).bodies
    assert body.shape.bounds[1].tolist() == [1, 1, 1]


# --- Expansions that would not fit are counted, never written out, and refused at once: the message has the number, the
# bytes, the line and the remedy

LIMITED = """
import resource, sys
from pathlib import Path
import conicoid as co
from conicoid.io import openmc
most = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() + 2**30
resource.setrlimit(resource.RLIMIT_AS, (most, most))
try:
    openmc.read(sys.argv[1])
except co.SceneFileError as error:
    print(error)
"""
PIN = '<cell id="1" universe="1" material="1" region="-2"/>'
LATTICE = 'lattice id="4" lower_left="0 0"'
WITHIN = '<surface id="3" type="sphere" coeffs="0 0 0 100"/>', PIN
SMALL = {
    "more elements than universes": (
        geometry(PIN, f'<{LATTICE} dimension="100000000 2" pitch="1 1" universes="1 1"/>', '<cell id="2" fill="4"/>'),
        4, ("a lattice of 100000000 x 2 needs 200000000, got 2",),
    ),
    "more rings than universes": (
        geometry(PIN, '<hex_lattice id="4" n_rings="100000000" n_axial="3" center="0 0 0" pitch="1 1" universes="1"/>', '<cell id="2" fill="4"/>'),
        4, ("needs 89999999100000003, got 1",),
    ),
    # A square of 2e10 elements across; a number that floats cannot hold; hexagons; no height at all in one direction
    "tiny elements around a lattice": (
        geometry(*WITHIN, f'<{LATTICE} dimension="1 1" pitch="1e-8 1e-8" outer="1" universes="1"/>', '<cell id="2" fill="4" region="-3"/>'),
        6, ("up to 399,999,999,999,999,999,999 bodies, at least 2.4e+14 GB", "cell 2, in which the outer universe 1 of lattice 4 is repeated", "raise it"),
    ),
    "no float holds their number": (
        geometry(*WITHIN, f'<{LATTICE} dimension="1 1" pitch="1e-300 1e-300" outer="1" universes="1"/>', '<cell id="2" fill="4" region="-3"/>'),
        6, ("up to about 1e604 bodies, more than any memory holds",),
    ),
    "tiny hexagons around a lattice": (
        geometry(*WITHIN, '<hex_lattice id="4" n_rings="1" center="0 0" pitch="1e-8" outer="1" universes="1"/>', '<cell id="2" fill="4" region="-3"/>'),
        6, ("GB in memory, most of them through cell 2",),
    ),
    "low levels around hexagons": (
        geometry(*WITHIN, '<hex_lattice id="4" n_rings="1" n_axial="1" center="0 0 0" pitch="10 1e-9" outer="1" universes="1"/>', '<cell id="2" fill="4" region="-3"/>'),
        6, ("GB in memory, most of them through cell 2",),
    ),
    "universes in universes": (
        geometry(*(f'<cell id="{10 * i + j}" universe="{i}" fill="{i + 1}"/>' for i in range(98) for j in range(10)), '<cell id="2000" universe="98" material="1"/>'),
        913, (f"about 1e{98} bodies, more than any memory holds, most of them through cell 910, which is filled with 1,000,000 bodies",),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SMALL)
def test_a_small_file_takes_little_memory(name: str, tmp_path: Path) -> None:
    text, line, phrases = SMALL[name]
    path = geometry_file(text, tmp_path)
    tracemalloc.start()
    try:
        with pytest.raises(co.SceneFileError) as caught:
            co.load_openmc(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    (problem,) = caught.value.problems
    assert problem.line == line
    assert all(phrase in str(caught.value) for phrase in phrases), str(caught.value)
    assert peak < 10e6


def big(columns: int, rows: int) -> str:
    row = "1 " * (columns - 1) + "2\n"
    return geometry(
        PIN,
        '<cell id="3" universe="2" material="2"/><cell id="5" universe="2" material="void" region="2"/>',
        f'<{LATTICE} name="core" dimension="{columns} {rows}" pitch="1 1"><universes>',
        f"{row * rows}</universes></lattice>",
        '<cell id="2" fill="4"/>',
    )


def test_a_lattice_is_counted_and_not_written_out(tmp_path: Path) -> None:
    """In each row of a thousand: 999 elements with one cell, and one with two."""
    path = geometry_file(big(1000, 700), tmp_path)
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path, max_bodies=500_000)
    (problem,) = caught.value.problems
    assert (problem.line, problem.where) == (5, "geometry")
    assert problem.message == (
        "expands into 700,700 bodies, at least 420 MB in memory, most of them through lattice 4 'core' of 700,000 elements; "
        "the limit is 500,000 (max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    lattice = read_openmc_geometry(path).lattices[4]
    assert lattice.tally == {1: 999 * 700, 2: 700}
    assert "universes" not in vars(lattice)


def test_bodies_that_are_no_others_moved_have_a_limit_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lattice that nothing cuts has as many bodies as elements, and one of them is computed."""
    monkeypatch.setattr(options, "DEFAULT_BODY_LIMITS", options.BodyLimits(1000, 10))
    lattice = f'<{LATTICE} dimension="20 20" pitch="1 1" universes="{"1 " * 400}"/>'
    path = geometry_file(geometry(PIN, lattice, '<cell id="2" fill="4"/>'), tmp_path)
    assert len(co.load_openmc(path).bodies) == 400
    with pytest.raises(co.SceneFileError, match=r"expands into 400 bodies, .* the limit is 399 \(max_bodies\)"):
        co.load_openmc(path, max_bodies=399)
    surfaces = [f"<surface id='{10 + i}' type='sphere' coeffs='{i} 0 0 0.4'/>" for i in range(11)]
    cells = [f"<cell id='{10 + i}' material='1' region='-{10 + i}'/>" for i in range(11)]
    path = geometry_file(geometry(*surfaces, *cells), tmp_path)
    with pytest.raises(co.SceneFileError, match="has at least 11 bodies that are no others moved, 44 kB in memory"):
        co.load_openmc(path)
    assert len(co.load_openmc(path, max_bodies=11).bodies) == 11


def test_a_core_of_400000_pins_is_no_more_than_is_allowed(tmp_path: Path) -> None:
    write_core(tmp_path / "geometry.xml", 38)
    assert 417_316 < read_openmc_geometry(tmp_path / "geometry.xml").body_count < options.DEFAULT_BODY_LIMITS.bodies


def test_bodies_beyond_scene_files_are_refused_before_they_are_made(tmp_path: Path, noted_calls) -> None:
    """A cylinder in a lattice is two primitives, each with its motion: four parts at least."""
    write_core(tmp_path / "geometry.xml", 15)
    scene = co.load_openmc(tmp_path / "geometry.xml")
    kind = type(scene.bodies)
    lists = noted_calls(kind, "shape_at")
    with pytest.raises(
        ValueError, match=r"scene.yaml: a scene file may have 1,000,000 parts .* has about [12],\d{3},\d{3}"
    ):
        scene.save(tmp_path / "scene.yaml")
    assert len(lists) < 100 < scene.body_count / 1000


@pytest.mark.deep
def test_thirty_million_elements_are_refused_in_one_gibibyte(tmp_path: Path) -> None:
    path = geometry_file(big(5000, 6000), tmp_path)
    process = subprocess.run(
        [sys.executable, "-c", LIMITED, str(path)], cwd=ROOT, capture_output=True, text=True, timeout=600, check=True
    )
    assert "expands into 30,006,000 bodies, at least 18 GB in memory" in process.stdout


def test_one_of_many_lattices_is_used(tmp_path: Path) -> None:
    """The other lattices are not expanded."""
    lattices = [
        f'<{LATTICE.replace("4", str(i))} dimension="50 50" pitch="1 1" universes="{"1 " * 2500}"/>'
        for i in range(10, 60)
    ]
    geometry_read = read_openmc_geometry(geometry_file(geometry(PIN, *lattices, '<cell id="2" fill="10"/>'), tmp_path))
    assert geometry_read.body_count == 2500
    assert not any("universes" in vars(lattice) for lattice in geometry_read.lattices.values())


def test_half_spaces_at_many_places_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell between a hundred balls has forty places. Each ball is compared in each place."""
    monkeypatch.setattr(limits, "FEWEST_STEPS", 0)
    monkeypatch.setattr(limits, "STEPS_FOR_A_BODY", 90)
    balls = [f"<surface id='{10 + i}' type='sphere' coeffs='{i % 10} {i // 10} 0 0.4'/>" for i in range(100)]
    region = " ".join(str(10 + i) for i in range(100))
    path = geometry_file(
        geometry(
            *balls,
            f"<cell id='1' universe='1' material='1' region='{region}'/>",
            *(f"<cell id='{2 + i}' fill='1' translation='0 0 {100 * i}'/>" for i in range(40)),
        ),
        tmp_path,
    )
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path, max_bodies=40)
    (problem,) = caught.value.problems
    assert (problem.line, problem.where) == (103, "cell 1")
    assert (
        "at so many places, that to compare them takes over 3,600 steps: raise the limit (max_bodies)"
        in problem.message
    )
    monkeypatch.undo()
    assert len(co.load_openmc(path, max_bodies=40).bodies) == 40


@pytest.mark.parametrize(
    ("tag", "attributes", "phrase"),
    [
        ("cell", f"material='{'1 ' * 1_000_001}'", "material has more than 1,000,000 words"),
        ("cell", f"material='1' region='{'1 ' * 200_001}'", "at most 200,000 stand in one region"),
        ("surface", f"type='plane' coeffs='{'1 ' * 300_000}'", "coeffs must be 4 numbers, got 300000"),
        ("lattice", f"dimension='{'1 ' * 1_000_001}'", "dimension has more than 1,000,000 words"),
    ],
)
def test_long_values_are_refused_by_their_length(tag: str, attributes: str, phrase: str, tmp_path: Path) -> None:
    path = geometry_file(geometry(f"<{tag} id='7' {attributes}/>"), tmp_path)
    with pytest.raises(co.SceneFileError) as caught:
        co.load_openmc(path)
    assert caught.value.problems[0].line == 3
    assert phrase in str(caught.value)
    assert len(str(caught.value)) < 1000


MOTIONS = {
    "far": 'translation="1e101 0 0"', "farther": 'translation="1.7e308 1.7e308 0"', "far and turned": 'translation="0 1e300 0" rotation="1 2 3"',
    "angle": 'rotation="1e200 1 0"', "small angle": 'rotation="1e-200 1 0"', "large matrix": 'rotation="1e308 0 0 0 1e308 0 0 0 1e308"',
    "small matrix": 'rotation="1e-300 0 0 0 1e-300 0 0 0 1e-300"',
    "steep matrix": 'rotation="1e-160 1e160 0 1 0 1e160 0 1 1e-160"', "far matrix": 'translation="1e308 0 0" rotation="2 0 0 0 2 0 0 0 2"',
}  # fmt: skip


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_out_of_range_are_refused_with_their_line(name: str, tmp_path: Path) -> None:
    """Several motions may add up, one within another."""
    inner = '<cell id="7" universe="8" fill="1" translation="1e308 1e308 0"/>'
    for text in (
        geometry(PIN, f'<cell id="2" fill="1" {MOTIONS[name]}/>'),
        geometry(PIN, inner, f'<cell id="2" fill="8" {MOTIONS[name]}/>'),
    ):
        with pytest.raises(co.SceneFileError) as caught:
            co.load_openmc(geometry_file(text, tmp_path))
        assert all(problem.line in (3, 4, 5) for problem in caught.value.problems)
        assert "double precision" in str(caught.value)
