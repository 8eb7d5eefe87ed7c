"""conicoid slice, and the examples that draw slices."""

from __future__ import annotations

import importlib
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ..command_line import refused, run, written

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TEXT = "{http://www.w3.org/2000/svg}text"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return written(tmp_path)


def test_a_slice_as_svg(scene, tmp_path):
    result = run("slice", scene, "-o", tmp_path / "cut.svg", "--at", 0.5, "--pixels", 200)
    assert result.exit_code == 0, result.output
    assert "cut.svg: 200 x " in result.output
    root = ElementTree.parse(tmp_path / "cut.svg").getroot()
    assert [text.text for text in root.iter(TEXT)] == ["ball", "body 1"]
    assert run("slice", scene, "-o", tmp_path / "cut.pdf", "--by", "material").exit_code == 0
    assert (tmp_path / "cut.pdf").read_bytes().startswith(b"%PDF")


def test_an_oblique_slice_as_a_picture(scene, tmp_path):
    plain = tmp_path / "plain.png"
    result = run(
        "slice", scene, "-o", plain, "--origin", "-2,-2,-2", "--u", "4,0,4", "--v", "0,4,0", "--pixels", 141,
        "--no-legend", "--no-outlines",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    pixels = np.asarray(Image.open(plain))
    assert pixels.shape == (100, 141, 3)
    # the ball is a circle of radius 1 of a window that is 5.66 x 4
    seen = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)[1]
    assert np.pi / (4 * np.sqrt(32)) == pytest.approx(min(seen, key=lambda n: abs(n - 1957)) / 14100, abs=0.01)


def test_what_the_command_refuses(scene, tmp_path):
    out = tmp_path / "cut.svg"
    for arguments, told in (
        (("--by", "colour"), "--by must be one of body, material"),
        (("--axis", "w"), "--axis must be one of x, y, z"),
        (("--origin", "0,0,0"), "--origin goes with both --u and --v"),
        (("--origin", "0,0", "--u", "1,0,0", "--v", "0,1,0"), "--origin must be three numbers"),
        (("--u", "1,0,0"), "--u"),
        (("--origin", "0,0,0", "--u", "1,0,0", "--v", "0,1,0", "--axis", "x"), "--axis"),
    ):
        assert told in refused("slice", scene, "-o", out, *arguments)
    assert "slices are saved as .svg, .pdf, .png" in refused("slice", scene, "-o", tmp_path / "cut.gif")
    assert not out.exists()


def test_examples(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    valve = importlib.import_module("valve_slice").cut(80)
    assert {one.kind for one in valve.outlines} == {"line", "ellipse", "hyperbola"}  # oblique, so none is a parabola
    assembly = importlib.import_module("assembly_slice").cut(120)
    assert {"water", "uranium dioxide", "steel"} <= {material.name for material in assembly.materials}
    assert not assembly.overlapping.any()
    assert all(one.left or one.right for one in assembly.outlines)
    assembly.save(tmp_path / "assembly.svg", "material")
    for name in ("valve_slice", "assembly_slice"):
        del sys.modules[name]
