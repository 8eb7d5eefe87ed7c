"""An environment's picture in a scene file: by the name of its file, or by its numbers."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import conicoid as co
from tests.children import ROOT
from tests.command_line import run

PIXELS = np.random.default_rng(3).random((4, 8, 3)).astype(np.float32)
SCENE = "background: {Environment: {pixels: sky.exr, intensity: 2}}\nbodies: [{shape: Sphere}]\n"


@pytest.fixture
def folder(tmp_path):
    pytest.importorskip("OpenEXR")
    co.Image(PIXELS).save(tmp_path / "sky.exr")
    (tmp_path / "scene.yaml").write_text(SCENE.replace("Sphere", "{Sphere: {}}"))
    return tmp_path


def test_a_scene_file_names_a_picture(folder):
    found = co.load(folder / "scene.yaml").background
    assert found == co.Environment(PIXELS, intensity=2) == co.Environment(folder / "sky.exr", intensity=2)
    assert found == co.Environment.of_file(folder / "sky.exr", 2)


def test_what_is_saved_names_it_too(folder):
    scene = co.load(folder / "scene.yaml")
    co.save(scene, folder / "again.yaml")
    assert "pixels: sky.exr" in (folder / "again.yaml").read_text()
    assert co.load(folder / "again.yaml") == scene


def test_a_small_one_of_numbers_stands_in_the_file(folder):
    scene = co.Scene([co.Sphere()], background=co.Environment(PIXELS.astype(float) / 3))
    co.save(scene, folder / "numbers.yaml")
    assert co.load(folder / "numbers.yaml") == scene


def test_a_large_one_is_to_be_put_into_a_file(folder):
    """Its numbers were written, more than a scene file may have, and `load` refused what `save` had written."""
    large = np.full((500, 1000, 3), 0.5)
    with pytest.raises(
        ValueError, match=r"^Environment: pixels must be in a file .*co.Image\(pixels\).save\('sky.exr'\)"
    ):
        co.save(co.Scene([], background=co.Environment(large)), folder / "large.yaml")
    (folder / "below").mkdir()
    co.Image(large).save(folder / "large.exr")
    scene = co.Scene([], background=co.Environment(folder / "large.exr"))
    with pytest.raises(ValueError, match=r"^Environment: pixels must be in a file .*: copy '.*large.exr' there$"):
        co.save(scene, folder / "below" / "scene.yaml")
    co.save(scene, folder / "scene.yaml")
    assert co.load(folder / "scene.yaml") == scene


@pytest.mark.parametrize(("name", "told"), [
    ("no.exr", "Environment: pixels: is not an existing file: 'no.exr' beside the scene"),
    ("../sky.exr", "Environment: pixels: must stay inside the scene's folder"),
    ("sky.txt", "Environment: pixels: .*file must be a picture"),
])  # fmt: skip
def test_mistakes_are_told_with_their_place(folder, name, told):
    (folder / "sky.txt").write_text("blue")
    inner = folder / "inner"
    inner.mkdir()
    target = inner if name.startswith("..") else folder
    (target / "bad.yaml").write_text(SCENE.replace("sky.exr", name).replace("Sphere", "{Sphere: {}}"))
    with pytest.raises(co.SceneFileError, match=told) as caught:
        co.load(target / "bad.yaml")
    assert ":1:" in str(caught.value)


def test_without_openexr_the_way_to_install_it_is_in_the_message(folder, monkeypatch):
    image, plate = co.Image(PIXELS), co.Scene([co.Sphere()]).slice("z", 0, pixels=8)
    monkeypatch.setitem(sys.modules, "OpenEXR", None)  # Python then finds none
    for work in (
        lambda: co.load(folder / "scene.yaml"), lambda: co.Environment(folder / "sky.exr"),
        lambda: image.save(folder / "new.exr"), lambda: plate.save(folder / "new.exr"),
    ):  # fmt: skip
        with pytest.raises(ImportError, match=r"^\.exr files need OpenEXR: pip install 'conicoid\[exr\]'$"):
            work()
    for command in ("render", "slice"):
        result = run(command, ROOT / "examples" / "scenes" / "barrel.yaml", "-o", folder / "new.exr")
        assert (result.exit_code, "pip install 'conicoid[exr]'" in result.stderr) == (1, True)
    assert not (folder / "new.exr").exists()
