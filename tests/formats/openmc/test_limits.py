"""What would not fit is counted, never written out, and refused at once: with the number, the bytes, the line and what to do."""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

import conicoid as co
from benchmarks.comparison.scenes import write_core
from conicoid.io import importers as options
from conicoid.io.openmc import geometry as limits
from conicoid.io.openmc.importer import read_openmc_geometry

from ...children import ROOT
from .broken import geometry
from .models import put

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
    path = put(text, tmp_path)
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
    path = put(big(1000, 700), tmp_path)
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
    """Of a lattice that nothing cuts there are as many as elements, and one that is worked out."""
    monkeypatch.setattr(options, "DEFAULT_BODY_LIMITS", options.BodyLimits(1000, 10))
    lattice = f'<{LATTICE} dimension="20 20" pitch="1 1" universes="{"1 " * 400}"/>'
    path = put(geometry(PIN, lattice, '<cell id="2" fill="4"/>'), tmp_path)
    assert len(co.load_openmc(path).bodies) == 400
    with pytest.raises(co.SceneFileError, match=r"expands into 400 bodies, .* the limit is 399 \(max_bodies\)"):
        co.load_openmc(path, max_bodies=399)
    surfaces = [f"<surface id='{10 + i}' type='sphere' coeffs='{i} 0 0 0.4'/>" for i in range(11)]
    cells = [f"<cell id='{10 + i}' material='1' region='-{10 + i}'/>" for i in range(11)]
    path = put(geometry(*surfaces, *cells), tmp_path)
    with pytest.raises(co.SceneFileError, match="has at least 11 bodies that are no others moved, 44 kB in memory"):
        co.load_openmc(path)
    assert len(co.load_openmc(path, max_bodies=11).bodies) == 11


def test_a_core_of_400000_pins_is_no_more_than_is_allowed(tmp_path: Path) -> None:
    write_core(tmp_path / "geometry.xml", 38)
    assert 417_316 < read_openmc_geometry(tmp_path / "geometry.xml").body_count < options.DEFAULT_BODY_LIMITS.bodies


def test_what_no_scene_file_holds_is_refused_before_its_bodies_are_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cylinder of a lattice's element is two primitives, each with its motion: four parts at least."""
    write_core(tmp_path / "geometry.xml", 15)
    scene = co.load_openmc(tmp_path / "geometry.xml")
    made, kind = [], type(scene.bodies)
    work = kind.shape_at
    monkeypatch.setattr(kind, "shape_at", lambda *of: made.append(of[1]) or work(*of))
    with pytest.raises(
        ValueError, match=r"scene.yaml: a scene file may have 1,000,000 parts .* has about [12],\d{3},\d{3}"
    ):
        scene.save(tmp_path / "scene.yaml")
    assert len(made) < 100 < scene.body_count / 1000


@pytest.mark.deep
def test_thirty_million_elements_are_refused_in_one_gibibyte(tmp_path: Path) -> None:
    path = put(big(5000, 6000), tmp_path)
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(path)], cwd=ROOT, capture_output=True, text=True, timeout=600, check=True
    )
    assert "expands into 30,006,000 bodies, at least 18 GB in memory" in done.stdout


def test_many_lattices_of_which_one_is_used(tmp_path: Path) -> None:
    """The others are not written out."""
    lattices = [
        f'<{LATTICE.replace("4", str(i))} dimension="50 50" pitch="1 1" universes="{"1 " * 2500}"/>'
        for i in range(10, 60)
    ]
    geometry_read = read_openmc_geometry(put(geometry(PIN, *lattices, '<cell id="2" fill="10"/>'), tmp_path))
    assert geometry_read.body_count == 2500
    assert not any("universes" in vars(lattice) for lattice in geometry_read.lattices.values())


def test_half_spaces_at_many_places_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell between a hundred balls, at forty places: each ball is looked at in each place."""
    monkeypatch.setattr(limits, "FEWEST_STEPS", 0)
    monkeypatch.setattr(limits, "STEPS_FOR_A_BODY", 90)
    balls = [f"<surface id='{10 + i}' type='sphere' coeffs='{i % 10} {i // 10} 0 0.4'/>" for i in range(100)]
    region = " ".join(str(10 + i) for i in range(100))
    path = put(
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
    path = put(geometry(f"<{tag} id='7' {attributes}/>"), tmp_path)
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
    """Also where several add up, one within another."""
    inner = '<cell id="7" universe="8" fill="1" translation="1e308 1e308 0"/>'
    for text in (
        geometry(PIN, f'<cell id="2" fill="1" {MOTIONS[name]}/>'),
        geometry(PIN, inner, f'<cell id="2" fill="8" {MOTIONS[name]}/>'),
    ):
        with pytest.raises(co.SceneFileError) as caught:
            co.load_openmc(put(text, tmp_path))
        assert all(problem.line in (3, 4, 5) for problem in caught.value.problems)
        assert "double precision" in str(caught.value)
