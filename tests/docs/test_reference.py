"""The reference has every public name, once, and only those; docstrings become what autodoc can show."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

import conicoid as co
from docs.tools import docstrings

REFERENCE = Path(__file__).resolve().parents[2] / "docs" / "reference"
ENTRY = re.compile(r"^\.\. auto(?:class|function|exception|data):: (\w+)$", re.MULTILINE)


def listed() -> Counter[str]:
    return Counter(name for page in REFERENCE.glob("*.md") for name in ENTRY.findall(page.read_text(encoding="utf-8")))


def test_every_public_name_is_in_the_reference():
    missing = set(co.__all__) - set(listed())
    assert not missing, f"add to a page of docs/reference: {', '.join(sorted(missing))}"


@pytest.mark.parametrize(
    "package",
    "checks ct derivatives explain materials measures optics parallel scene section".split(),
)
def test_public_packages_are_in_the_reference(package: str):
    text = "".join(page.read_text(encoding="utf-8") for page in REFERENCE.glob("*.md"))
    names = set(re.findall(rf"^\.\. auto\w+:: conicoid\.{package}\.(\w+)$", text, re.MULTILINE))
    assert names == set(getattr(co, package).__all__)


def test_nothing_else_is_in_the_reference_and_nothing_twice():
    names = listed()
    assert set(names) <= set(co.__all__)
    assert set(names.values()) == {1}


def test_columns_are_kept_as_they_are_written():
    lines = ["What it is.", "", "t      the place", "body   its number", "", "Raises ValueError for others."]
    made = "\n".join(docstrings.structured(lines))
    assert "::\n\n   t      the place\n   body   its number\n" in made
    assert made.endswith("Raises ValueError for others.\n")


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("|x| <= a * b_i", r"\|x\| <= a \* b\_i"),
        ("`t_min` of ``a | b``", "``t_min`` of ``a | b``"),
        ("`Body`s, one", r"``Body``\ s, one"),
    ],
)
def test_marks_of_the_markup_are_escaped(written: str, shown: str):
    assert docstrings.escaped(written) == shown


def test_labels_begin_paragraphs():
    assert docstrings.structured(["Faces: 0 side.", "uv: (angle,", "height)"]) == [
        "", "Faces: 0 side.", "", "uv: (angle,", "height)", "",
    ]  # fmt: skip
