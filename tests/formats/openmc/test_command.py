"""conicoid import"""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.io.scene_file import yaml_parser

from ...command_line import run
from .broken import CASES
from .models import EXAMPLE_FILES

PIN = EXAMPLE_FILES["pin"]


def test_a_geometry_becomes_a_scene_file(tmp_path: Path) -> None:
    output = tmp_path / "pin.yaml"
    result = run("import", PIN, "-o", output)
    assert result.exit_code == 0, result.output
    assert co.load(output) == co.load_openmc(PIN)
    assert "4 cells, 7 surfaces, 1 universe, 0 lattices" in result.stdout
    assert "boundary reflective: surfaces 4, 5, 6, 7" in result.stdout
    assert "material 1             1 body    uranium dioxide" in result.stdout
    assert result.stderr.splitlines() == [f"{PIN}: expands into 4 bodies", f"{output}: 4 bodies"]


def test_without_void(tmp_path: Path) -> None:
    run("import", EXAMPLE_FILES["assembly"], "-o", tmp_path / "a.json", "--no-void")
    assert len(co.load(tmp_path / "a.json").bodies) == 1133 - 264


@pytest.mark.parametrize("name", ["torus", "no XML", "unknown surface", "a circle"])
def test_mistakes_end_with_exit_code_2(name: str, tmp_path: Path) -> None:
    path = tmp_path / "geometry.xml"
    path.write_text(CASES[name][0])
    result = run("import", path, "-o", tmp_path / "out.yaml")
    assert result.exit_code == 2
    assert all(phrase in result.stderr for phrase in CASES[name][2])
    assert "Traceback" not in result.output
    assert not (tmp_path / "out.yaml").exists()


def test_limits_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = run("import", PIN, "-o", tmp_path / "out.yaml", "--max-bodies", 3)
    assert result.exit_code == 2
    assert "expands into 4 bodies" in result.stderr
    monkeypatch.setattr(yaml_parser, "MAX_NODES", 100)
    result = run("import", PIN, "-o", tmp_path / "out.yaml")
    assert result.exit_code == 2
    assert "a scene file holds at most 100 values, this scene takes" in result.stderr


def test_outputs_are_checked_first(tmp_path: Path) -> None:
    assert "scenes are saved as .yaml or .json" in run("import", PIN, "-o", tmp_path / "out.png").stderr
    assert run("import", PIN, "-o", tmp_path / "none" / "out.yaml").exit_code == 2
