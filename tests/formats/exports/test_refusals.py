"""What a format cannot say is refused by name, all of it in one message; what it says less of is told."""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.io.export.exporters import EXPORT_FORMATS, find_export_format

from ...command_line import run
from .comparison import assert_close_answers, assert_same_answers, written_and_read

SUFFIXES = (".gdml", ".scad", ".xml")
SADDLE = co.HyperbolicParaboloid(1, 1, within=co.Box())


@pytest.mark.parametrize("suffix", SUFFIXES)
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
        (".gdml", co.Sphere(1) & co.Sphere(1, (5, 0, 0)), "thing: there is nothing in it"),
    ],
)  # fmt: skip
def test_solids_that_cannot_be_said(suffix: str, shape: co.Union, message: str | None, tmp_path: Path) -> None:
    path = tmp_path / f"out{suffix}"
    scene = co.Scene([co.Body(shape, name="thing"), co.Body(co.Sphere(0.5, (9, 0, 0)), name="ball")])
    if message is None:
        co.export(scene, path)
        return
    with pytest.raises(ValueError, match="1 body cannot be written as ") as error:
        co.export(scene, path)
    assert message in str(error.value)
    assert "ball" not in str(error.value)
    assert not path.exists()


def test_the_saddle_is_a_quadric_in_openmc(tmp_path: Path) -> None:
    assert_same_answers(co.Scene([SADDLE]), written_and_read(co.Scene([SADDLE]), tmp_path / "out.xml"))


def test_what_is_narrowed_is_told(tmp_path: Path) -> None:
    turned = co.Body(co.Cylinder((0, 0, 0), (1, 2, 3), 1), "red", "rod")
    scene = co.Scene([turned], lights=[co.AmbientLight(1)], camera=co.Camera((9, 0, 0), (0, 0, 0)))
    told = {suffix: "\n".join(co.export(scene, tmp_path / f"out{suffix}")) for suffix in SUFFIXES}
    for suffix, word in ((".gdml", "numbers"), (".scad", "numbers"), (".xml", "surfaces")):
        assert f"{word} are rounded to float64: rod" in told[suffix]
        assert "not written: lights, camera" in told[suffix]
        assert_close_answers(scene, co.load(tmp_path / f"out{suffix}"))
        with pytest.raises(ValueError, match="would not hold all of the scene, and strict is set:\nnot written"):
            co.export(scene, tmp_path / f"strict{suffix}", strict=True)
        assert not (tmp_path / f"strict{suffix}").exists()


def test_cells_of_openmc_do_not_overlap(tmp_path: Path) -> None:
    """What two bodies share belongs to the one that is listed first, as `body_at` says."""
    scene = co.Scene([co.Body(co.Sphere(1), name="a"), co.Body(co.Sphere(1, (1, 0, 0)), name="b")])
    notes = co.export(scene, tmp_path / "out.xml")
    assert any("cut by bodies before them, as cells must not overlap: b" in note for note in notes)
    back = co.load(tmp_path / "out.xml")
    points = [(0, 0, 0), (0.5, 0, 0), (0.9, 0, 0), (1.5, 0, 0), (2.5, 0, 0)]
    assert back.body_at(points).tolist() == scene.body_at(points).tolist() == [0, 0, 0, 1, -1]
    assert back.spans((-5, 0, 0), (1, 0, 0)).t_enter.tolist() == [4, 6]


def test_many_bodies_in_one_entry(tmp_path: Path) -> None:
    balls = co.Spheres([(0, 0, 0), (5, 0, 0)], [1, 2])
    scene = co.Scene([co.Body(balls, name="pebbles", materials=["red", "blue"])])
    for suffix in SUFFIXES:
        back = written_and_read(scene, tmp_path / f"out{suffix}")
        assert len(back) == 2
        assert back.first_hit((5, 0, 9), (0, 0, -1)).t == 7
    assert [body.name for body in co.load(tmp_path / "out.gdml").bodies] == ["pebbles[0]", "pebbles[1]"]


def test_names_with_what_xml_and_gdml_mean_otherwise(tmp_path: Path) -> None:
    names = ['a<b>&"c"\'', "x\ny", "ring[i]", "core/fuel[3]", "core/fuel[4]"]
    bodies = [co.Body(co.Sphere(1, (3 * k, 0, 0)), name=name) for k, name in enumerate(names)]
    for suffix in SUFFIXES:
        co.export(co.Scene(bodies), tmp_path / f"out{suffix}")
    back = [body.name for body in co.load(tmp_path / "out.gdml").bodies]
    assert back == ['a<b>&"c"\'', "x\\ny", "ring(i)", "core/fuel[3]", "core/fuel[4]"]


def test_formats_are_known_by_suffix(tmp_path: Path) -> None:
    assert [find_export_format(f"a{suffix.upper()}") for suffix in SUFFIXES] == [
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


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_command(scene_file: Path, suffix: str) -> None:
    output = scene_file.with_name(f"out{suffix}")
    for order in ((scene_file, output), ("-o", output, scene_file), (scene_file, "--output", output)):
        done = run("export", *map(str, order))
        assert done.exit_code == 0, done.stderr
        assert f"{output}: " in done.stderr
        assert_same_answers(co.load(scene_file), co.load(output))
        output.unlink()


def test_mistakes_of_the_command(scene_file: Path, tmp_path: Path) -> None:
    for arguments, message in (
        ((scene_file, tmp_path / "x.step"), "pages are saved as .html, models as .gdml, .scad, .csg, .xml"),
        ((scene_file, tmp_path / "none" / "x.gdml"), "no such folder"),
        ((scene_file, tmp_path / "x.html", "--strict"), "--strict goes with models"),
        ((tmp_path / "none.yaml", tmp_path / "x.gdml"), "no such file"),
        (("-", tmp_path / "x.gdml"), "scenes are read from files"),
    ):
        done = run("export", *map(str, arguments))
        assert done.exit_code == 2
        assert message in done.stderr.lower() or message in done.stderr
        assert "Traceback" not in done.output
    co.export(co.Sphere(), tmp_path / "in.gdml")
    before = (tmp_path / "in.gdml").read_bytes()
    assert run("export", str(tmp_path / "in.gdml"), str(tmp_path / "in.gdml")).exit_code == 2
    assert (tmp_path / "in.gdml").read_bytes() == before


def test_the_command_names_what_it_refuses(tmp_path: Path) -> None:
    co.save(co.Scene([co.Body(co.Plane((0, 0, 1), 0), name="floor"), co.Sphere()]), tmp_path / "scene.yaml")
    done = run("export", str(tmp_path / "scene.yaml"), str(tmp_path / "x.gdml"))
    assert done.exit_code == 2
    assert "1 body cannot be written as GDML:\nfloor: Plane is a sheet" in done.stderr
    assert not (tmp_path / "x.gdml").exists()
