"""The recipe for a material works: its files and edits, made in a copy of the repository, pass its test."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ..machine_code import needs_compiler

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "dev" / "add-a-material.md"
FENCE = re.compile(r"^```(python|diff)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(kind: str) -> list[str]:
    """The fenced blocks of one language."""
    return [found[2] for found in FENCE.finditer(PAGE.read_text(encoding="utf-8")) if found[1] == kind]


def apply(diff: str, root: Path) -> None:
    """Make the edits of a diff without line numbers: each hunk's old lines must stand once in their file."""
    for part in re.split(r"^--- ", diff, flags=re.MULTILINE)[1:]:
        name, _, hunks = part.partition("\n")
        file = root / name
        text = file.read_text(encoding="utf-8")
        for hunk in re.split(r"^@@\n", hunks, flags=re.MULTILINE):
            lines = hunk.splitlines(keepends=True)
            old = "".join(line[1:] for line in lines if line[0] in " -")
            new = "".join(line[1:] for line in lines if line[0] in " +")
            assert text.count(f"\n{old}") == 1, f"{name} has not once:\n{old}"
            text = text.replace(f"\n{old}", f"\n{new}")
        file.write_text(text, encoding="utf-8")


def written_in_a_copy(tmp_path: Path) -> None:
    """Make the edits of the page in a copy of the package and of the tests of surfaces."""
    for folder in ("conicoid", "tests/scattering"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "_kernels*"))
    for file in ("pyproject.toml", *(f"tests/{name}.py" for name in ("__init__", "conftest", "messages", "samples"))):
        shutil.copy(ROOT / file, tmp_path / file)
    module, preset, test = blocks("python")
    (tmp_path / "conicoid/render/bsdf/dust.py").write_text(module, encoding="utf-8")
    (tmp_path / "tests/scattering/test_dust.py").write_text(test, encoding="utf-8")
    presets = tmp_path / "conicoid/materials/presets.py"
    text = presets.read_text(encoding="utf-8")
    presets.write_text(text.replace("\n_PRESETS = (", f"\n{preset}\n\n_PRESETS = ("), encoding="utf-8")
    for diff in blocks("diff"):
        apply(diff, tmp_path)


def test_the_recipe_for_a_material_fits_the_package(tmp_path: Path) -> None:
    """Its diffs apply, and what comes of them is Python."""
    written_in_a_copy(tmp_path)
    changed = [file for file in (tmp_path / "conicoid").rglob("*.py") if "dust" in file.read_text(encoding="utf-8")]
    assert len(changed) > 3
    for file in changed:
        compile(file.read_text(encoding="utf-8"), file.name, "exec")


@pytest.mark.deep  # kernels are compiled
@needs_compiler
@pytest.mark.parametrize("chosen", ["albedo or reciprocity", "picture"])
def test_the_recipe_for_a_material_works(tmp_path: Path, chosen: str) -> None:
    """By the short tests of the page, and by its pictures."""
    written_in_a_copy(tmp_path)
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "tests/scattering/test_dust.py",
        "-k",
        chosen,
    ]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
