"""Scenes in the files of other programs: every solid, round trips, refusals, one assembly in three formats."""

import copy
import functools
import itertools
import logging
import pickle
import re
from pathlib import Path
from typing import Any
from xml.parsers import expat

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import conicoid as co
from conicoid.io.export import gdml as gdml_writer
from conicoid.io.export.exporters import EXPORT_FORMATS, ExportBody, ExportOptions, find_export_format
from conicoid.io.export.openmc_regions import EmptinessTest, ExportSurfaceTable, RegionWriter
from conicoid.io.openmc.region import SurfaceSide
from conicoid.io.openmc.region_expression import IntersectionNode, UnionNode
from conicoid.io.openmc.values import read_title

from ...command_line import execute, failure, run
from ...samples import deep, in_turn, sampled
from ..gdml.files import placed, text_of, volume
from ..mcnp.models import chosen, load_deck
from ..mcnp.test_models import DECK, GUIDES, PINS, PITCH, XML
from ..openmc.models import EXAMPLE_FILES, KINDS, TURNS
from ..strategies import SOLIDS, moved, primitive
from . import models
from .models import assert_close_answers, assert_same_answers, written_and_read

# --- Every solid of Conicoid, moved and combined: a format writes it so that it answers as before, or refuses it by
# name

SUFFIXES = [each.suffixes[0] for each in EXPORT_FORMATS]
FEW = hypothesis.settings(
    max_examples=5,
    deadline=None,
    derandomize=True,
    phases=[hypothesis.Phase.generate],
    suppress_health_check=list(hypothesis.HealthCheck),
)
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")
CUT = co.Box((-3, -3, -3), (3, 3, 3))


def check_export(scene: co.Scene, path: Path) -> None:
    """Check that the file answers alike but for the rounding of numbers, or that the refusal names the body."""
    try:
        notes = co.export(scene, path)
    except ValueError as error:
        assert "\nthing: " in str(error) or str(error).endswith("body to write")
        return
    try:
        back = co.load(path)
    except ValueError:  # numbers that are out of bounds in the format's own form
        assert not _is_moderate(scene)
        return
    is_empty = any(note.startswith("with nothing in it") for note in notes)
    if _is_moderate(scene) and not is_empty:
        assert len(back) == 1
        assert_close_answers(scene, back, 1e-7)


def _is_moderate(scene: co.Scene) -> bool:
    """Return whether rounding one number of the shape in OpenSCAD or GDML leaves the others in sight."""
    numbers = [abs(float(word)) for word in _NUMBER.findall(repr(scene.bodies[0].shape))]
    low, high = scene.bounds
    return (
        max(numbers, default=1) < 1e3 and min((n for n in numbers if n), default=1) > 1e-3 and (high - low).min() > 0.01
    )


@pytest.mark.parametrize(("name", "suffix"), in_turn(SOLIDS, SUFFIXES))
@FEW
@hypothesis.given(st.data())
def test_every_kind(name: str, suffix: str, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """The shape stands as it is, cut by a box, and cut from one."""
    shape = data.draw(moved(primitive(name)))
    kind = data.draw(st.sampled_from(["alone", "within", "without"]))
    shape = {"alone": shape, "within": CUT & shape, "without": CUT - shape}[kind]
    check_export(co.Scene([co.Body(shape, name="thing")]), tmp_path_factory.mktemp("x") / f"out{suffix}")


# --- One message names everything that a format cannot write; a warning names what it loses

SOLID_FORMATS = (".gdml", ".scad", ".xml")
SADDLE = co.HyperbolicParaboloid(1, 1, within=co.Box())


@pytest.mark.parametrize("suffix", SOLID_FORMATS)
def test_sheets_are_refused_by_name(suffix: str, tmp_path: Path) -> None:
    bodies = [co.Body(co.Disc((0, 0, k), (0, 0, 1), 1), name=f"pane {k}") for k in range(40)]
    with pytest.raises(ValueError, match="40 bodies cannot be written as ") as error:
        co.export(co.Scene([*bodies, co.Sphere(9)]), tmp_path / f"out{suffix}")
    lines = str(error.value).splitlines()
    assert lines[1] == "pane 0: Disc is a sheet, and such files have solids only"
    assert lines[-1] == "... and 32 more like this"
    assert len(lines) <= 22
    assert max(map(len, lines)) <= 200
    assert not (tmp_path / f"out{suffix}").exists()


@pytest.mark.parametrize(
    ("suffix", "shape", "message"),
    [
        (".gdml", co.HalfSpace((0, 0, 1), 0), "thing: it has no end on some side: intersect it with a Box"),
        (".scad", ~co.Sphere(), "thing: it has no end on some side"),
        (".gdml", SADDLE, "thing: a quadric of it is no ellipsoid, cylinder, cone, paraboloid or hyperboloid"),
        (".scad", co.EllipticParaboloid(1, 1, (0, 2)), "thing: a part of it is a paraboloid or hyperboloid"),
        (".gdml", co.Sphere().transform([[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) - co.Box((0, 0, 0), (9, 9, 9)),
         "thing: a motion of it (Transform) is no chain of turns, shifts and scalings along the axes"),
        (".xml", co.Sphere(1) - co.Sphere(1), None),
        *((suffix, co.Sphere(1) & co.Sphere(1, (5, 0, 0)), None) for suffix in SOLID_FORMATS),
    ],
)  # fmt: skip
def test_inexpressible_solids_are_refused(suffix: str, shape: co.Union, message: str | None, tmp_path: Path) -> None:
    path = tmp_path / f"out{suffix}"
    scene = co.Scene([co.Body(shape, name="thing"), co.Body(co.Sphere(0.5, (9, 0, 0)), name="ball")])
    if message is None:
        assert any("with nothing in it" in note for note in co.export(scene, path))
        assert co.load(path).crossings((9, 0, 5), (0, 0, -1)).t.tolist() == [4.5, 5.5]
        return
    with pytest.raises(ValueError, match="1 body cannot be written as ") as error:
        co.export(scene, path)
    assert message in str(error.value)
    assert "ball" not in str(error.value)
    assert not path.exists()


def test_the_saddle_is_a_quadric_in_openmc(tmp_path: Path) -> None:
    assert_same_answers(co.Scene([SADDLE]), written_and_read(co.Scene([SADDLE]), tmp_path / "out.xml"))


def test_narrowed_bodies_are_reported(tmp_path: Path) -> None:
    turned = co.Body(co.Cylinder((0, 0, 0), (1, 2, 3), 1), "red", "rod")
    scene = co.Scene([turned], lights=[co.AmbientLight(1)], camera=co.Camera((9, 0, 0), (0, 0, 0)))
    notes = {suffix: "\n".join(co.export(scene, tmp_path / f"out{suffix}")) for suffix in SOLID_FORMATS}
    for suffix, word in ((".gdml", "numbers"), (".scad", "numbers"), (".xml", "surfaces")):
        assert f"{word} are rounded to float64: rod" in notes[suffix]
        assert "not written: lights, camera" in notes[suffix]
        assert_close_answers(scene, co.load(tmp_path / f"out{suffix}"))
        with pytest.raises(ValueError, match="would not hold all of the scene, and strict is set:\nnot written"):
            co.export(scene, tmp_path / f"strict{suffix}", strict=True)
        assert not (tmp_path / f"strict{suffix}").exists()


def test_a_file_of_openmc_has_a_cell(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="there is no body to write"):
        co.export(co.Scene([]), tmp_path / "out.xml")
    assert not list(tmp_path.iterdir())


def test_turned_parts_fill_a_cell_of_openmc_if_others_bound_them(tmp_path: Path) -> None:
    """(0.336, 1.256, 0) is 1.3 from the center, at 75 degrees: in the turned box, beside an unturned one and the ball."""
    turned, path = co.Box().rotate("z", 30), tmp_path / "a.xml"
    for solid, fills in ((turned, 0), (turned & co.Sphere(1.2), 1)):
        co.export(co.Scene([solid]), path)
        assert path.read_text().count(' rotation="0 0 30"') == fills
        assert co.load(path).contains([(0.55, 0.55, 0.3), (0.336, 1.256, 0)]).tolist() == [True, fills == 0]


def test_cells_of_openmc_do_not_overlap(tmp_path: Path) -> None:
    """Space that two bodies share belongs to the first in the list, as for `body_at`."""
    scene = co.Scene([co.Body(co.Sphere(1), name="a"), co.Body(co.Sphere(1, (1, 0, 0)), name="b")])
    notes = co.export(scene, tmp_path / "out.xml")
    assert any("cut by bodies before them, as cells must not overlap: b" in note for note in notes)
    back = co.load(tmp_path / "out.xml")
    points = [(0, 0, 0), (0.5, 0, 0), (0.9, 0, 0), (1.5, 0, 0), (2.5, 0, 0)]
    assert back.body_at(points).tolist() == scene.body_at(points).tolist() == [0, 0, 0, 1, -1]
    assert back.spans((-5, 0, 0), (1, 0, 0)).t_enter.tolist() == [4, 6]


def test_one_overlap_of_a_body_is_enough_for_gdml(tmp_path: Path, noted_calls) -> None:
    """10 balls all share the origin. Regions are compared once for each but the first, not for all 45 pairs."""
    count = noted_calls(EmptinessTest, "is_empty")
    scene = co.Scene([co.Sphere(2, (k / 8, 0, 0)) for k in range(10)])
    notes = co.export(scene, tmp_path / "out.gdml")
    assert len(count) <= 9
    assert any(": body 1, body 2, body 3 and 6 more" in note for note in notes if "may share points" in note)


def test_a_ray_shows_which_balls_overlap() -> None:
    """The ray is the part of the line between two centers in both balls, by the quadratic formula.

    Booleans have no ray.
    """
    random = np.random.default_rng(41)
    centers, radii = random.uniform(-3, 3, (24, 3)), random.uniform(0.2, 2, 24)
    balls = [co.Sphere(*ball) for ball in zip(radii, map(tuple, centers), strict=True)]
    solids = [*balls, balls[0] - co.Box()]
    nests = [gdml_writer.VolumeNest(k, ExportBody("", solid, None), solid) for k, solid in enumerate(solids)]
    for first in range(len(balls)):
        shares: dict[int, float] = {}
        for later in range(first + 1, len(balls)):
            both = [first, later]
            start = centers[first] + 2 * min(radii[both]) * gdml_writer._ASIDE
            direction, away = centers[later] - start, start - centers[both]
            middle, square = -(away @ direction), direction @ direction
            roots = np.sqrt(np.maximum(middle**2 - square * ((away**2).sum(axis=1) - radii[both] ** 2), 0.0))
            ends = np.clip([(middle - roots) / square, (middle + roots) / square], 0.0, 1.0)
            shares[later] = min(ends[1]) - max(ends[0])
        clear = gdml_writer._clear_overlaps(nests, [*((first, later) for later in shares), (first, len(balls))])
        assert clear == {later for later, share in shares.items() if share > gdml_writer._CLEAR_SHARE}


def test_many_bodies_in_one_entry(tmp_path: Path) -> None:
    balls = co.Spheres([(0, 0, 0), (5, 0, 0)], [1, 2])
    scene = co.Scene([co.Body(balls, name="pebbles", materials=["red", "blue"])])
    for suffix in SOLID_FORMATS:
        back = written_and_read(scene, tmp_path / f"out{suffix}")
        assert len(back) == 2
        assert back.first_hit((5, 0, 9), (0, 0, -1)).t == 7
    assert [body.name for body in co.load(tmp_path / "out.gdml").bodies] == ["pebbles[0]", "pebbles[1]"]


def test_names_of_many_volumes_are_found_in_few_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The n-th of one name took n steps: each of 13,000 bonds looked at 6,500 names."""
    looked_up = []

    class Names(set):
        def __contains__(self, name):
            looked_up.append(name)
            return super().__contains__(name)

    writer = functools.partial(gdml_writer._StructureWriter, used_names=Names())
    monkeypatch.setattr(gdml_writer, "_StructureWriter", writer)
    balls = co.Spheres([(k, 0, 0) for k in range(40)], 0.1 + 0.01 * np.arange(40))
    co.export(co.Scene([co.Body(balls, name="a")]), tmp_path / "a.gdml")
    assert [body.name for body in co.load(tmp_path / "a.gdml").bodies] == [f"a[{k}]" for k in range(40)]
    assert len(looked_up) <= 3 * 40


def test_names_with_characters_special_to_xml_and_gdml(tmp_path: Path) -> None:
    names = ['a<b>&"c"\'', "x\ny", "ring[i]", "core/fuel[3]", "core/fuel[4]"]
    bodies = [co.Body(co.Sphere(1, (3 * k, 0, 0)), name=name) for k, name in enumerate(names)]
    for suffix in SOLID_FORMATS:
        co.export(co.Scene(bodies), tmp_path / f"out{suffix}")
    back = [body.name for body in co.load(tmp_path / "out.gdml").bodies]
    assert back == ['a<b>&"c"\'', "x\\ny", "ring(i)", "core/fuel[3]", "core/fuel[4]"]


LATTICE = """<geometry><surface id="1" type="sphere" coeffs="0 0 0 9" boundary="vacuum"/>
<surface id="2" type="z-cylinder" coeffs="0 0 .4"/><surface id="3" type="x-plane" coeffs="0"/>
<cell id="1" name="it's \\ fuel&#160;of 8 &#10;rows in a pin of a lattice in a cell that is turned" universe="1" region="-2" material="2"/>
<cell id="2" universe="1" region="2" material="void"/>
<lattice id="5" dimension="2 1" lower_left="-2 -1" pitch="2 2" universes="1 1"/>
<cell id="3" universe="7" fill="5"/><cell id="4" fill="7" rotation="0 0 30" region="-1 3"/>
<cell id="8" name="it's outside&#160;" material="void" region="-1 -3"/></geometry>"""


def test_a_region_in_many_places_is_simplified_once(noted_calls) -> None:
    # (r and b) or (r outside b), r within it again, 16 deep: 2^17 sides as a tree, 33 different ones
    table = ExportSurfaceTable()
    regions, emptiness = RegionWriter(table), EmptinessTest(table)
    region = regions.of(co.Sphere(1))
    for k in range(16):
        ball = regions.of(co.Sphere(1, (0.05 * (k + 1), 0, 0)))
        region = UnionNode(tuple(IntersectionNode((region, side)) for side in (ball, emptiness.complement(ball))))
    tested = noted_calls(SurfaceSide, "of")
    assert not emptiness.is_empty(region)
    # The intersection, and those of at most two branches at three splits: 1 + 2 + 4 + 8
    assert 0 < len(tested) <= 15 * 33


def test_names_of_cells_and_places_come_back(tmp_path: Path) -> None:
    scene = read_text(tmp_path, LATTICE, "in.xml")
    names = [body.name or "" for body in scene.bodies]
    assert names[1].endswith(" @ cell 4, cell 3, lattice 5 [1, 0]")
    assert names[-1] == 'cell 8 "it\'s outside"'
    for k in range(2):
        scene = written_and_read(scene, tmp_path / f"{k}.xml")
        assert sorted(body.name or "" for body in scene.bodies) == sorted(names)
        assert all(scene[name].name == name for name in names)
    assert read_title(f"cell 1 'a'{'+-' * 50_000}'b'") is None  # too deep for Python to evaluate


def test_formats_are_known_by_suffix(tmp_path: Path) -> None:
    assert [find_export_format(f"a{suffix.upper()}") for suffix in SOLID_FORMATS] == [
        EXPORT_FORMATS[0],
        EXPORT_FORMATS[1],
        EXPORT_FORMATS[2],
    ]
    assert find_export_format("a.yaml") is None
    with pytest.raises(
        ValueError, match=r"scenes are exported as a page, .html, or as models: .gdml, .scad, .csg, .xml"
    ):
        co.export(co.Sphere(), tmp_path / "a.step")
    with pytest.raises(ValueError, match="title means nothing for GDML"):
        co.export(co.Sphere(), tmp_path / "a.gdml", title="x")


# ---- The command ----


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    co.save(co.Scene([co.Body(co.Box() - co.Sphere(0.5), "red", "die")]), tmp_path / "scene.yaml")
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize("suffix", SOLID_FORMATS)
def test_the_command(scene_file: Path, suffix: str) -> None:
    output = scene_file.with_name(f"out{suffix}")
    result = execute("export", str(scene_file), str(output))
    assert f"{output}: " in result.stderr
    assert_same_answers(co.load(scene_file), co.load(output))


def test_mistakes_of_the_command(scene_file: Path, tmp_path: Path) -> None:
    for arguments, message in (
        ((scene_file, tmp_path / "x.step"), "pages are saved as .html, models as .gdml, .scad, .csg, .xml"),
        ((scene_file, tmp_path / "none" / "x.gdml"), "no such folder"),
        ((scene_file, tmp_path / "x.html", "--strict"), "--strict goes with models"),
        ((tmp_path / "none.yaml", tmp_path / "x.gdml"), "no such file"),
        (("-", tmp_path / "x.gdml"), "scenes are read from files"),
    ):
        error = failure("export", *map(str, arguments))
        assert message in error.lower() or message in error
    co.export(co.Sphere(), tmp_path / "in.gdml")
    before = (tmp_path / "in.gdml").read_bytes()
    assert run("export", str(tmp_path / "in.gdml"), str(tmp_path / "in.gdml")).exit_code == 2
    assert (tmp_path / "in.gdml").read_bytes() == before


def test_the_command_names_the_refused_body(tmp_path: Path) -> None:
    co.save(co.Scene([co.Body(co.Plane((0, 0, 1), 0), name="floor"), co.Sphere()]), tmp_path / "scene.yaml")
    assert "1 body cannot be written as GDML:\nfloor: Plane is a sheet" in failure(
        "export", str(tmp_path / "scene.yaml"), str(tmp_path / "x.gdml")
    )
    assert not (tmp_path / "x.gdml").exists()


# --- Import, export, import: the same answers to the bit, for every part of each format

OPENMC = {"kinds": KINDS, "turns": TURNS}


def read_text(folder: Path, text: str, name: str) -> co.Scene:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return co.load(path)


def check_bodies(one: co.Scene, other: co.Scene) -> None:
    """Assert equal bodies as well as answers."""
    assert [body.name for body in one.bodies] == [body.name for body in other.bodies]
    assert [body.material for body in one.bodies] == [body.material for body in other.bodies]
    assert_same_answers(one, other)


@pytest.mark.parametrize("name", sampled(models.GDML_SOLIDS, 4))
def test_solids_of_gdml(name: str, tmp_path: Path) -> None:
    """The scene stands as it is, turned by odd angles, and turned by a quarter."""
    thrice = {f"{name} {k}": models.GDML_SOLIDS[name] for k in range(3)}
    scene = read_text(tmp_path, models.detector(thrice), "in.gdml")
    assert len(scene) == 1 + 3 + 2 * 5
    check_bodies(scene, written_and_read(scene, tmp_path / "out.gdml"))


def test_booleans_of_gdml(tmp_path: Path) -> None:
    others = ("bored", "both", "common", "many", "long", "mirrored")
    scene = read_text(tmp_path, models.detector({}, models.BOOLEANS, others), "in.gdml")
    assert len(scene) == 1 + len(others) + 2 * 5
    check_bodies(scene, written_and_read(scene, tmp_path / "out.gdml"))


def test_a_second_export_is_the_same_text(tmp_path: Path) -> None:
    """No text grows from trip to trip."""
    for text, name in ((models.detector(models.GDML_SOLIDS), "a.gdml"), (models.SCAD, "a.csg"), (KINDS, "a.xml")):
        scene, texts = read_text(tmp_path, text, name), []
        for k in range(3):
            path = tmp_path / f"{k}{Path(name).suffix}"
            scene = written_and_read(scene, path)
            texts.append(path.read_text())
        assert texts[1] == texts[2]


def test_openscad(tmp_path: Path) -> None:
    """The last part, a cylinder with sides, is a polyhedron, whose corners are rounded."""
    exact, sides, rest = re.split(r" multmatrix[^\n]*\n(  cylinder[^}]*)", models.SCAD)
    scene = read_text(tmp_path, exact + rest, "in.csg")
    assert len(scene) == 3
    check_bodies(scene, written_and_read(scene, tmp_path / "out.scad", strict=True))
    scene = read_text(tmp_path, sides, "in.csg")
    assert_close_answers(scene, written_and_read(scene, tmp_path / "out.scad"))


@pytest.mark.parametrize("name", ["kinds", deep("turns")])
def test_openmc(name: str, tmp_path: Path) -> None:
    scene = read_text(tmp_path, OPENMC[name], "in.xml")
    back = written_and_read(scene, tmp_path / "out.xml")
    assert [body.material for body in scene.bodies] == [body.material for body in back.bodies]
    assert_same_answers(scene, back)


@pytest.mark.parametrize("name", ["pin", deep("assembly")])
def test_the_examples(name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR, "conicoid"):
        scene = co.load(EXAMPLE_FILES[name])
        back = written_and_read(scene, tmp_path / "out.xml")
    assert [body.shape for body in scene.bodies] == [body.shape for body in back.bodies]
    assert [body.material for body in scene.bodies] == [body.material for body in back.bodies]
    assert np.array_equal(scene.domain.bounds, back.domain.bounds)
    if name == "pin":
        assert_same_answers(scene, back)


TAPERED = """<xtru name="{}" lunit="mm"><twoDimVertex x="0" y="0"/><twoDimVertex x="10" y="0"/><twoDimVertex x="0" y="20"/>
<section zOrder="0" zPosition="0" xOffset="0" yOffset="0" scalingFactor="1"/>
<section zOrder="1" zPosition="20" xOffset="0" yOffset="0" scalingFactor="0.5"/></xtru>"""
STEPPED = """<polyhedra name="{}" startphi="7" deltaphi="200" numsides="3" aunit="deg" lunit="mm">
<zplane z="-5" rmin="0" rmax="4.1"/><zplane z="0" rmin="0" rmax="7.3"/><zplane z="6" rmin="0" rmax="3.7"/></polyhedra>"""


@pytest.mark.parametrize(("solid", "strict"), [(TAPERED, False), (STEPPED, True)])
def test_outlines_and_polyhedra_of_gdml(
    solid: str, strict: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """As in Geant4's example of scaled volumes. A convex outline is planes from the beginning.

    Sides of polyhedra are floats of sines, which readers get from the same element only.
    """
    scene = read_text(tmp_path, models.detector({f"solid {k}": solid for k in range(3)}), "in.gdml")
    check_bodies(scene, written_and_read(scene, tmp_path / "out.gdml", strict=strict))
    assert "compute planes from corners" not in caplog.text


COMPUTED = """<define><constant name="r" value="1+2*3"/><quantity name="ell" value="30.5" unit="mm"/></define>"""


def test_elements_are_written_with_the_values_of_their_expressions(tmp_path: Path) -> None:
    """A third is no decimal, so it is written as a quotient. Units of the file become their values in mm."""
    solid = '<paraboloid name="{}" rlo="r/3" rhi="r" dz="10/r" lunit="ell"/>'
    text = models.detector({"bowl": solid}).replace("<materials>", f"{COMPUTED}<materials>", 1)
    scene = read_text(tmp_path, text, "in.gdml")
    back = written_and_read(scene, tmp_path / "out.gdml", strict=True)
    assert ' rlo="7/3" rhi="7" dz="10/7" lunit="30.5"/>' in (tmp_path / "out.gdml").read_text()
    check_bodies(scene, back)


def test_moved_and_copied_solids_keep_their_element(tmp_path: Path) -> None:
    scene = read_text(tmp_path, models.detector({"prism": models.GDML_SOLIDS["prism"]}), "in.gdml")
    prism = scene["W/Vs0"].shape.rotate("x", 30).translate((1, 2, 3))
    co.export(co.Scene([pickle.loads(pickle.dumps(prism))]), tmp_path / "out.gdml", strict=True)
    assert "<polyhedra" in (tmp_path / "out.gdml").read_text()
    scene = read_text(tmp_path, models.detector({"tube": models.GDML_SOLIDS["cutTube"]}), "tube.gdml")  # a Boolean
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene), copy.copy(scene)):
        co.export(same, tmp_path / "tube_out.gdml", strict=True)
        assert "<cutTube" in (tmp_path / "tube_out.gdml").read_text()
    ball = read_text(tmp_path, "sphere($fn = 7, $fa = 12, $fs = 2, r = 0.8);", "in.csg")
    co.export(ball, tmp_path / "out.scad", strict=True)
    assert "sphere($fn = 7, $fa = 3, $fs = 0.01, r = 0.8);" in (tmp_path / "out.scad").read_text()


@pytest.mark.parametrize("sides", [3, 8, 24, 100])
def test_gdml_has_balls_of_flat_sides_as_polyhedra(tmp_path: Path, sides: int) -> None:
    """Four sides meet in each corner; as rounded corners the solid is concave, and of more than 400 faces it is lost."""
    ball = read_text(tmp_path, f"sphere($fn = {sides}, $fa = 12, $fs = 2, r = 2);", "in.csg")
    again = written_and_read(ball, tmp_path / "out.gdml")
    assert again.notes == ("2 solids, 2 volumes", "1 body")
    assert_close_answers(ball, again, 1e-13)
    # The frustums between rings of corners, as OpenSCAD places them
    count = (sides + 1) // 2
    angles = (np.arange(count) + 0.5) * np.pi / count
    radii, heights = 2 * np.sin(angles), 2 * np.cos(angles)
    volume = sum((a * a + a * b + b * b) * h / 3 for a, b, h in zip(radii, radii[1:], -np.diff(heights), strict=False))
    volume *= sides / 2 * np.sin(2 * np.pi / sides)
    found = co.measure(again)[0]
    assert abs(found.volume - volume) <= 6 * found.volume_error + 1e-12 * volume


def test_a_pile_of_bodies_is_cut_body_by_body_in_openmc(tmp_path: Path) -> None:
    """Cell k has its own side and one of each cell before it: cut cells within cut cells doubled with every body."""
    count = 14
    pile = co.Scene([co.Sphere(4, (k, 0, 0)) for k in range(count)], unit="cm")
    again = written_and_read(pile, tmp_path / "out.xml")
    regions = re.findall('region="([^"]*)"', (tmp_path / "out.xml").read_text())
    assert sum(len(re.findall(r"\d+", region)) for region in regions) <= count * (count + 1) // 2
    points = np.random.default_rng(0).uniform((-4, -4, -4), (count + 3, 4, 4), (4000, 3))
    inside = np.square(points[:, None] - [(k, 0, 0) for k in range(count)]).sum(axis=-1) < 16
    first = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    np.testing.assert_array_equal(again.body_at(points), first)


def test_another_order_is_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The hole of the first body is the third body, and in a volume a daughter comes before the second body."""
    hole = co.Box((-1, -1, -1), (1, 1, 1))
    whole = co.Difference((co.Box((-5, -5, -5), (5, 5, 5)), hole))
    bodies = [co.Body(whole, name="a"), co.Body(co.Sphere(1, (9, 0, 0)), name="b"), co.Body(hole, name="c")]
    again = written_and_read(co.Scene(bodies), tmp_path / "out.gdml")
    assert sorted(body.name.removeprefix("a/") for body in again.bodies) == ["a", "b", "c"]
    assert "bodies come back in another order" in caplog.text
    caplog.clear()
    written_and_read(co.Scene([bodies[0], bodies[2], bodies[1]]), tmp_path / "out.gdml")
    assert "another order" not in caplog.text


# --- One assembly as OpenMC geometry, as MCNP deck and as GDML file, the latter two by hand: the same spans


def rows() -> list[str]:
    return [" ".join("2" if (i, j) in GUIDES else "1" for i in range(PINS)) for j in range(PINS)]


def gdml() -> str:
    """Return pins of a pellet in a cladding, and guide tubes, each in a box of water; lengths as in the deck."""
    tube = '<tube name="{}" rmin="{}" rmax="{}" z="20" deltaphi="360" aunit="deg" lunit="mm"/>'
    sizes = {"pellet": (0, 0.4096), "cladding": (0.4096, 0.475), "inside": (0, 0.561), "wall": (0.561, 0.602)}
    solids = "".join(tube.format(name, *radii) for name, radii in sizes.items())
    solids += f'<box name="element" x="{PITCH}" y="{PITCH}" z="20"/><box name="w" x="9" y="9" z="30"/>'

    def place(name: str, at: str = "") -> str:
        return placed(name, at, f'name="{name}"')

    structure = "".join(volume(name, name) for name in sizes)
    structure += volume("pin", "element", place("pellet") + place("cladding"), "air")
    structure += volume("guide", "element", place("inside") + place("wall"), "air")
    places = ""
    for j, i in itertools.product(range(PINS), range(PINS)):
        at = f'<position x="{(i - 2) * 126 / 100}" y="{(j - 2) * 126 / 100}" z="0"/>'
        places += place("guide" if (i, j) in GUIDES else "pin", at)
    return text_of(solids, structure + volume("world", "w", places, "air"))


CELLS = {"pellet": 1, "cladding": 2, "pin": 3, "inside": 4, "wall": 5, "guide": 6}
"""The cell, in the other two formats, of each volume."""


def spans_of(scene: co.Scene, rays: co.Rays) -> np.ndarray[Any, Any]:
    """Return ray, t_enter, t_exit and number of the cell of each span in the assembly, in that order."""
    spans = scene.spans(rays)
    kinds = np.array([_cell(body.name or "") for body in scene.bodies])[spans.body]
    ray = np.repeat(np.arange(len(rays)), np.diff(spans.offsets))
    rows = np.stack([ray, spans.t_enter, spans.t_exit, kinds])[:, kinds > 0]
    return rows[:, np.lexsort(rows[::-1])]


def _cell(name: str) -> int:
    found = re.match(r"cell (\d+)", name)
    if found:
        return int(found[1])
    return CELLS.get(re.sub("[#[].*", "", name.split("/")[-1]), 0)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, co.Scene]:
    folder = tmp_path_factory.mktemp("assembly")
    deck = load_deck(folder, DECK.format(rows="\n".join("     " + row for row in rows())))
    (folder / "geometry.xml").write_text(XML.format(rows=" ".join(reversed(rows()))), encoding="utf-8")
    (folder / "pins.gdml").write_text(gdml(), encoding="utf-8")
    return {"MCNP": deck, "OpenMC": co.load(folder / "geometry.xml"), "GDML": co.load(folder / "pins.gdml")}


@pytest.fixture(scope="module")
def rays() -> co.Rays:
    points, ends = chosen(3, 3000, 4.0), chosen(4, 3000, 4.0)
    return co.Rays(points, ends - points)


def test_the_same_spans(scenes: dict[str, co.Scene], rays: co.Rays) -> None:
    found = {name: spans_of(scene, rays) for name, scene in scenes.items()}
    assert found["OpenMC"].shape[1] > 10_000
    np.testing.assert_array_equal(found["MCNP"], found["OpenMC"])
    np.testing.assert_array_equal(found["GDML"], found["OpenMC"])


@pytest.mark.parametrize(("suffix", "name"), in_turn([".gdml", ".xml"], ["MCNP", "OpenMC", "GDML"]))
def test_written_in_another_format(
    scenes: dict[str, co.Scene], rays: co.Rays, name: str, suffix: str, tmp_path: Path
) -> None:
    """Ends of spans keep their bits through every format."""
    back = written_and_read(scenes[name], tmp_path / f"out{suffix}")
    a, b = scenes[name].spans(rays), back.spans(rays)
    np.testing.assert_array_equal(a.offsets, b.offsets)
    np.testing.assert_array_equal(a.t_enter, b.t_enter)
    np.testing.assert_array_equal(a.t_exit, b.t_exit)


# --- Units of length

_SIZES_IN_MM = dict(angstrom=1e-7, nm=1e-6, um=1e-3, mm=1, cm=10, m=1000, km=1e6) | {"in": 25.4}
_UNITS_OF_FILES = {"gdml": "mm", "xml": "cm", "scad": "mm"}


@pytest.mark.parametrize(("unit", "suffix"), in_turn([None, *_SIZES_IN_MM], _UNITS_OF_FILES))
def test_lengths_are_converted_to_the_unit_of_the_file(tmp_path, unit, suffix):
    """Rays hit the scene of the file at the distances of the scene, times the size of its unit."""
    solids = [
        co.Sphere(0.41, (0.1, 0.2, 0.3)),
        co.Box((1, 1, 1), (2, 3, 4)).rotate("z", 30).translate((0.5, 0, 0)),
        co.Cone((5, 0, 0), (5, 0, 1), 0.5, 0.2),
        co.Ellipsoid((0.5, 0.6, 0.7)).translate((0, 8, 0)),
        co.Cylinder((-5, 0, 0), (-5, 0, 1), 0.5).rotate((1, 2, 3), 20) - co.Sphere(0.2, (-5, 0, 0.5)),
    ]
    scene = co.Scene([co.Body(solid, co.matte((0.1 * k, 0.5, 0.2))) for k, solid in enumerate(solids, 1)], unit=unit)
    path = tmp_path / f"model.{suffix}"
    result = find_export_format(path).write(scene, path, ExportOptions())
    read, target = co.load(path), _UNITS_OF_FILES[suffix]
    assert read.unit == target
    assert any(note.startswith("the scene states no unit") for note in result.notes) == (unit is None)
    factor = 1 if unit is None else _SIZES_IN_MM[unit] / _SIZES_IN_MM[target]
    origins = np.array([(0.1, 0.2, 9), (1, 1.9, 9), (5.1, 0, 9), (0.1, 8.1, 9), (-4.3, -1.5, 9)])
    down = (0.0, 0.0, -1.0)
    expected, found = scene.first_hit(origins, down).t, read.first_hit(origins * factor, down).t
    assert np.isfinite(expected[:4]).all()
    assert found == pytest.approx(expected * factor, rel=1e-9)


def test_scenes_of_two_units_are_not_mixed():
    inches = co.Scene([co.Body(co.Box((0, 0, 0), (1, 1, 1)), name="box")], lights=[co.AmbientLight()], unit="in")
    metres = co.Scene([co.Body(co.Sphere(1), name="ball")], unit="m")
    for call, error, message in (
        (lambda: inches.added(metres), ValueError, r"a scene in m does not go into one in in: .*shape.scale\(39.37"),
        (lambda: metres.added(inches, before="ball"), ValueError, r"a scene in in does not go into one in m"),
        (lambda: inches + metres, TypeError, r"put together by a.added\(b\)"),
    ):
        with pytest.raises(error, match=message):
            call()
    for other in (metres.replace(unit=None), metres.replace(unit="in")):
        both = inches.added(other)
        assert (both.unit, [body.name for body in both.bodies], both.lights) == ("in", ["box", "ball"], inches.lights)
    with pytest.raises(ValueError, match=r"in mm does not go into one in um: .*shape.scale\(1000\)"):
        metres.replace(unit="um").added(inches.replace(unit="mm"))
    with pytest.raises(ValueError, match="both named 'box'"):
        inches.added(inches)


def test_line_integrals_are_in_the_unit_of_the_scene(tmp_path):
    """One plate of 2 g/cm³ and 3 mm has two units, and density × length differs by these (docs/queries.md)."""
    gdml = """<gdml><materials><material name="m"><D value="2"/></material></materials>
<solids><box name="b" x="9" y="9" z="3" lunit="mm"/></solids><structure><volume name="v"><materialref ref="m"/>
<solidref ref="b"/></volume></structure><setup name="Default" version="1.0"><world ref="v"/></setup></gdml>"""
    (tmp_path / "a.gdml").write_text(gdml)
    (tmp_path / "a.mcnp").write_text("t\n1 1 -2 -1\n\n1 rpp -.45 .45 -.45 .45 -.15 .15\n\nm1 1001 1\n")
    found = {}
    for scene in map(co.load, (tmp_path / "a.gdml", tmp_path / "a.mcnp")):
        found[scene.unit] = float(scene.line_integral("density", co.Rays((0, 0, 50), (0, 0, -1))))
    assert found == {"mm": 6, "cm": pytest.approx(0.6, rel=1e-15)}


def test_a_scene_keeps_its_unit(tmp_path):
    scene = co.Scene([co.Body(co.Sphere(1), name="ball")], unit="in")
    for path in (tmp_path / "scene.yaml", tmp_path / "scene.json"):
        co.save(scene, path)
        assert co.load(path) == scene
        assert co.load(path).unit == "in"
    assert co.load(path) != co.Scene(scene.bodies)
    edits = scene.moved("ball", (1, 0, 0)), scene.added(co.Box()), scene.without("ball"), scene.replace(lights=())
    for scene_with_unit in (*edits, pickle.loads(pickle.dumps(scene)), copy.copy(scene)):
        assert scene_with_unit.unit == "in"
    assert scene.replace(unit=None).unit is None
    with pytest.raises(ValueError, match="Scene: unit must be one of angstrom, nm.* got 'inch'"):
        co.Scene([], unit="inch")
    (tmp_path / "scene.yaml").write_text("unit: feet\nbodies: []\n")
    with pytest.raises(co.SceneFileError, match=r"scene\.yaml:1:7: unit: must be one of angstrom, nm"):
        co.load(tmp_path / "scene.yaml")


@pytest.mark.parametrize(
    ("name", "text", "unit"),
    [
        ("a.mcnp", "a deck\n1 0 -1 imp:n=1\n2 0 1 imp:n=0\n\n1 so 5\n\n", "cm"),
        ("a.scad", "sphere(r = 2, $fn = 9);", "mm"),
        ("a.xyz", "1\n\nC 0 0 0\n", "angstrom"),
    ],
)
def test_importers_state_the_unit(tmp_path, name, text, unit):
    (tmp_path / name).write_text(text)
    assert co.load(tmp_path / name).unit == unit


@pytest.mark.parametrize("name", ["a\x01b", "a\ud800b", "a\x1b[31m", "a\x7f\ufffe", "a\nb", "a\x00b"])
@pytest.mark.parametrize("suffix", [".gdml", ".xml"])
def test_xml_is_valid_for_any_name(name, suffix, tmp_path):
    """Readers of XML refuse control characters, lone surrogates and U+FFFE, which a name may hold."""
    bodies = [
        co.Body(co.Sphere(), co.matte("red", name=name, properties={"state": name, "macroscopic": name}), name),
        co.Body(co.Sphere(0.5).translate((3, 0, 0))),
    ]
    co.export(co.Scene(bodies), tmp_path / f"x{suffix}")
    assert len(co.load(tmp_path / f"x{suffix}").bodies) == 2
    expat.ParserCreate().Parse((tmp_path / f"x{suffix}").read_bytes(), True)
