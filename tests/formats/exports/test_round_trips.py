"""Import, export, import: the same answers to the bit, for all that each format has."""

from __future__ import annotations

import copy
import logging
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io.export import csg_pieces as lowered

from ...samples import deep, sampled
from ..openmc.models import EXAMPLE_FILES, KINDS, TURNS
from . import models
from .comparison import assert_close_answers, assert_same_answers, written_and_read

OPENMC = {"kinds": KINDS, "turns": TURNS}


def loaded(folder: Path, text: str, name: str) -> co.Scene:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return co.load(path)


def same(one: co.Scene, other: co.Scene) -> None:
    """Bodies as well as answers."""
    assert [body.name for body in one.bodies] == [body.name for body in other.bodies]
    assert [body.material for body in one.bodies] == [body.material for body in other.bodies]
    assert_same_answers(one, other)


@pytest.mark.parametrize("name", sampled(models.GDML_SOLIDS, 4))
def test_solids_of_gdml(name: str, tmp_path: Path) -> None:
    """As it stands, turned by odd angles, and turned by a quarter."""
    thrice = {f"{name} {k}": models.GDML_SOLIDS[name] for k in range(3)}
    scene = loaded(tmp_path, models.detector(thrice), "in.gdml")
    assert len(scene) == 1 + 3 + 2 * 5
    same(scene, written_and_read(scene, tmp_path / "out.gdml"))


def test_booleans_of_gdml(tmp_path: Path) -> None:
    others = ("bored", "both", "common", "many", "long", "mirrored")
    scene = loaded(tmp_path, models.detector({}, models.BOOLEANS, others), "in.gdml")
    assert len(scene) == 1 + len(others) + 2 * 5
    same(scene, written_and_read(scene, tmp_path / "out.gdml"))


def test_a_second_export_is_the_same_text(tmp_path: Path) -> None:
    """So nothing grows from trip to trip."""
    for text, name in ((models.detector(models.GDML_SOLIDS), "a.gdml"), (models.SCAD, "a.csg"), (KINDS, "a.xml")):
        scene, texts = loaded(tmp_path, text, name), []
        for k in range(3):
            path = tmp_path / f"{k}{Path(name).suffix}"
            scene = written_and_read(scene, path)
            texts.append(path.read_text())
        assert texts[1] == texts[2]


def test_openscad(tmp_path: Path) -> None:
    scene = loaded(tmp_path, models.SCAD, "in.csg")
    assert len(scene) == 3
    same(scene, written_and_read(scene, tmp_path / "out.scad", strict=True))


@pytest.mark.parametrize("name", ["kinds", deep("turns")])
def test_openmc(name: str, tmp_path: Path) -> None:
    scene = loaded(tmp_path, OPENMC[name], "in.xml")
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
    assert scene.domain is not None
    assert np.array_equal(scene.domain.bounds, back.domain.bounds)
    if name == "pin":
        assert_same_answers(scene, back)


TAPERED = """<xtru name="{}" lunit="mm"><twoDimVertex x="0" y="0"/><twoDimVertex x="10" y="0"/><twoDimVertex x="0" y="20"/>
<section zOrder="0" zPosition="0" xOffset="0" yOffset="0" scalingFactor="1"/>
<section zOrder="1" zPosition="20" xOffset="0" yOffset="0" scalingFactor="0.5"/></xtru>"""
STEPPED = """<polyhedra name="{}" startphi="7" deltaphi="200" numsides="3" aunit="deg" lunit="mm">
<zplane z="-5" rmin="0" rmax="4.1"/><zplane z="0" rmin="0" rmax="7.3"/><zplane z="6" rmin="0" rmax="3.7"/></polyhedra>"""


def test_tapered_outlines_of_gdml(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """As in Geant4's example of scaled volumes; a convex one is planes from the beginning."""
    scene = loaded(tmp_path, models.detector({f"tapered {k}": TAPERED for k in range(3)}), "in.gdml")
    same(scene, written_and_read(scene, tmp_path / "out.gdml"))
    assert "compute planes from corners" not in caplog.text


def test_polyhedra_of_several_sections(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Sides are floats of sines, which readers get from the same element only."""
    scene = loaded(tmp_path, models.detector({f"stepped {k}": STEPPED for k in range(3)}), "in.gdml")
    same(scene, written_and_read(scene, tmp_path / "out.gdml", strict=True))


COMPUTED = """<define><constant name="r" value="1+2*3"/><quantity name="ell" value="30.5" unit="mm"/></define>"""


def test_elements_are_written_with_the_values_of_their_expressions(tmp_path: Path) -> None:
    """A third is no decimal: it is written as a quotient. Units of the file become their values in mm."""
    solid = '<paraboloid name="{}" rlo="r/3" rhi="r" dz="10/r" lunit="ell"/>'
    text = models.detector({"bowl": solid}).replace("<materials>", f"{COMPUTED}<materials>", 1)
    scene = loaded(tmp_path, text, "in.gdml")
    back = written_and_read(scene, tmp_path / "out.gdml", strict=True)
    assert ' rlo="7/3" rhi="7" dz="10/7" lunit="30.5"/>' in (tmp_path / "out.gdml").read_text()
    same(scene, back)


def test_moved_and_copied_solids_keep_their_element(tmp_path: Path) -> None:
    scene = loaded(tmp_path, models.detector({"prism": models.GDML_SOLIDS["prism"]}), "in.gdml")
    prism = scene["W/Vs0"].shape.rotate("x", 30).translate((1, 2, 3))
    co.export(co.Scene([pickle.loads(pickle.dumps(prism))]), tmp_path / "out.gdml", strict=True)
    assert "<polyhedra" in (tmp_path / "out.gdml").read_text()
    scene = loaded(tmp_path, models.detector({"tube": models.GDML_SOLIDS["cutTube"]}), "tube.gdml")  # a Boolean
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene), copy.copy(scene)):
        co.export(same, tmp_path / "tube_out.gdml", strict=True)
        assert "<cutTube" in (tmp_path / "tube_out.gdml").read_text()
    ball = loaded(tmp_path, "sphere($fn = 7, $fa = 12, $fs = 2, r = 0.8);", "in.csg")
    co.export(ball, tmp_path / "out.scad", strict=True)
    assert "sphere($fn = 7, $fa = 3, $fs = 0.01, r = 0.8);" in (tmp_path / "out.scad").read_text()


def test_planes_that_readers_get_from_corners_are_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Sides of a prism that are floats of sines; those of a tessellated solid come from corners."""
    turns = [2 * math.pi * k / 7 for k in range(7)]
    normals = [(math.cos(t), math.sin(t), 0.0) for t in turns] + [(0, 0, -1), (0, 0, 1)]
    scene = co.Scene([co.Polyhedron(normals, [1.3] * 9)])
    again = written_and_read(scene, tmp_path / "out.gdml")
    assert "the last digits may differ" in caplog.text
    assert_close_answers(scene, again, 1e-12)


def test_many_bodies_that_are_one_moved_take_the_time_of_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is known again, and cut out of planes, once for all."""
    calls = []
    worked_out = lowered._polyhedron_faces
    monkeypatch.setattr(lowered, "_polyhedron_faces", lambda *given: calls.append(1) or worked_out(*given))
    one = co.Polyhedron(((1, 2, 0), (-1, 2, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)), (1, 1, 1, 1.5, 1.25))
    scene = co.Scene([one.rotate((0, 0, 1), 7.0 * k).translate((9.0 * k, 0, 0)) for k in range(20)])
    co.export(scene, tmp_path / "out.gdml")
    assert len(calls) <= 1


def test_another_order_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A hole of the first body is the third, which a volume's daughter comes before the second."""
    hole = co.Box((-1, -1, -1), (1, 1, 1))
    whole = co.Difference((co.Box((-5, -5, -5), (5, 5, 5)), hole))
    bodies = [co.Body(whole, name="a"), co.Body(co.Sphere(1, (9, 0, 0)), name="b"), co.Body(hole, name="c")]
    again = written_and_read(co.Scene(bodies), tmp_path / "out.gdml")
    assert sorted(body.name.removeprefix("a/") for body in again.bodies) == ["a", "b", "c"]
    assert "bodies come back in another order" in caplog.text
    caplog.clear()
    written_and_read(co.Scene([bodies[0], bodies[2], bodies[1]]), tmp_path / "out.gdml")
    assert "another order" not in caplog.text
