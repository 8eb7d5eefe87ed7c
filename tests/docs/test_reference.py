"""The reference has every public name, once, with the first line of its docstring; docstrings become field lists."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

import conicoid as co
from docs.tools import docstrings, reference

PAGES = sorted((Path(__file__).resolve().parents[2] / "docs" / "reference").glob("*.md"))
INTERNAL: set[str] = set()
COMPLETE = "Scene Rays Hits Spans Crossings BodiesAt Distances Image optics.Paths section.Slice section.Voxels".split()


def listed() -> list[reference.Entry]:
    """Return the entries of all pages."""
    return [entry for page in PAGES for entry in reference.entries(page.read_text(encoding="utf-8"))]


def names(prefix: str) -> Counter[str]:
    """Return how often each name directly below a prefix is listed."""
    below = [entry.name.removeprefix(prefix) for entry in listed() if entry.name.startswith(prefix)]
    return Counter(name for name in below if "." not in name)


def test_every_public_name_is_in_the_reference():
    missing = set(co.__all__) - set(names("co."))
    assert not missing, f"add to a page of docs/reference: {', '.join(sorted(missing))}"


@pytest.mark.parametrize(
    "package",
    "checks ct derivatives explain materials measures optics parallel scene section".split(),
)
def test_public_packages_are_in_the_reference(package: str):
    assert set(names(f"co.{package}.")) == set(getattr(co, package).__all__)


def test_nothing_else_is_in_the_reference_and_nothing_twice():
    assert set(names("co.")) <= set(co.__all__)
    assert set(Counter(entry.name for entry in listed()).values()) == {1}


def test_members_that_are_listed_are_there():
    missing = [f"{entry.name}.{name}" for entry in listed() for name in entry.members if not _has(entry.target, name)]
    assert not missing


def _has(target: Any, name: str) -> bool:
    """Return whether a class has a member; fields without a default are annotations only."""
    return hasattr(target, name) or any(name in vars(owner).get("__annotations__", ()) for owner in target.__mro__)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_lines_of_the_reference_are_those_of_the_docstrings(page: Path):
    text = page.read_text(encoding="utf-8")
    assert reference.refreshed(text) == text, "run: python -m docs.tools.reference"
    assert not re.search(r"^ *- `\w[\w.]*`: ?$", text, re.MULTILINE), "a name without a docstring"


@pytest.mark.parametrize("name", COMPLETE)
def test_all_members_of_a_class_are_listed(name: str):
    (entry,) = (entry for entry in listed() if entry.name == f"co.{name}")
    missing = reference.members_of(entry.target) - INTERNAL - set(entry.members)
    assert not missing, f"add below co.{name}: {', '.join(sorted(missing))}"


def test_entries_become_directives():
    page = "- `co.Conic`: A cap.\n  - `sheet`: Return it.\n- `co.materials.WATER`: The index.\n"
    made = reference.directives(page)
    assert ".. autoclass:: conicoid.Conic\n   :members: sheet\n```" in made
    assert ".. autodata:: conicoid.materials.WATER\n\n   The index.\n```" in made


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


SECTIONS = """\
Return a_b.

Parameters
----------
t_min, t_max : float or (...)
    With a `Rays` by name, 2 * 3.
progress : callable, optional
    progress(done, count) is called.

Returns
-------
bool (...)

Attributes
----------
body, face : int32
    Numbers.

Raises
------
ValueError
    For t_min > t_max.

Notes
-----
Pickled ones keep t_min.
"""


def test_sections_keep_their_form_and_their_text_is_escaped():
    made = "\n".join(docstrings.sectioned(SECTIONS.splitlines()))
    assert made.startswith("Return a\\_b.\n\nParameters\n----------\nt_min, t_max : float or (...)\n")
    assert "\n    With a ``Rays`` by name, 2 \\* 3.\nprogress : callable, optional\n" in made
    assert "\nReturns\n-------\nbool (...)\n\nAttributes\n" in made
    assert made.endswith("Notes\n-----\nPickled ones keep t\\_min.\n\n")


def test_a_docstring_without_sections_is_prose():
    assert docstrings.sectioned(["One line of a_b."]) == ["One line of a\\_b.", ""]


def test_sections_become_field_lists():
    pytest.importorskip("sphinx")
    made = "\n".join(docstrings.rendered(SECTIONS.splitlines()))
    assert ":Parameters: * **t_min, t_max** (*float or (...)*) -- With a ``Rays`` by name, 2 \\* 3." in made
    assert "             * **progress** (*callable, optional*) -- progress(done, count) is called." in made
    assert ":returns: *bool (...)*" in made
    assert ":Attributes: **body, face** (*int32*) -- Numbers." in made
    assert ":raises ValueError: For t\\_min > t\\_max." in made
    assert ".. rubric:: Notes" in made
