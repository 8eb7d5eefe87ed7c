"""Import, export, import: the same answers to the bit, for all that each format has."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

from ..openmc.models import EXAMPLE_FILES, KINDS, TURNS
from . import models
from .comparison import assert_same_answers, written_and_read

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


@pytest.mark.parametrize("name", models.GDML_SOLIDS)
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


@pytest.mark.parametrize("name", OPENMC)
def test_openmc(name: str, tmp_path: Path) -> None:
    scene = loaded(tmp_path, OPENMC[name], "in.xml")
    back = written_and_read(scene, tmp_path / "out.xml")
    assert [body.material for body in scene.bodies] == [body.material for body in back.bodies]
    assert_same_answers(scene, back)


@pytest.mark.parametrize("name", EXAMPLE_FILES)
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
