"""The figures of the documentation are those that its programs draw, and each is shown."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from docs.tools import live, theory

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("name", theory.FIGURES)
def test_a_figure_of_the_theory(name: str):
    pixels = theory.FIGURES[name](0.2).pixels
    assert np.isfinite(pixels).all()
    assert len(np.unique(pixels.reshape(-1, 3).round(1), axis=0)) > 3  # several colours


def test_all_figures_of_the_theory_are_shown():
    shown = re.findall(r"images/theory_(\w+)\.webp", (DOCS / "theory.md").read_text(encoding="utf-8"))
    assert sorted(shown) == sorted(theory.FIGURES)


@pytest.mark.parametrize("page", sorted((DOCS / "tutorials").glob("*.md")), ids=lambda page: page.stem)
def test_figures_of_a_tutorial_are_saved_by_its_own_code(page: Path):
    text = page.read_text(encoding="utf-8")
    shown = re.findall(r"\]\(\.\./images/(\w+\.webp)\)", text)
    assert shown
    for name in shown:
        assert f'.save("{name}")' in text
        assert (DOCS / "images" / name).exists()


def test_every_picture_of_the_folder_is_shown_somewhere():
    text = "".join(page.read_text(encoding="utf-8") for page in [*DOCS.rglob("*.md"), DOCS.parent / "README.md"])
    for picture in (DOCS / "images").iterdir():
        assert f"images/{picture.name}" in text, picture.name


def test_live_scenes_are_programs_of_the_gallery():
    gallery = (DOCS / "gallery.md").read_text(encoding="utf-8")
    for name in live.SCENES:
        assert f"`{name}.py`" in gallery
        assert (live.EXAMPLES / f"{name}.py").exists()
