"""The pages of the docs: recipes, figures, links, the reference."""

import ast
import inspect
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co
from docs.tools import docstrings, live, reference, theory
from docs.tools.links import problems

from ..machine_code import needs_compiler

# --- The page "Coming from another program" names only what exists: functions, arguments, methods and fields

PAGE = Path(__file__).resolve().parents[2] / "docs" / "coming-from.md"
ROW = re.compile(r"^\| (.+?) \| (.+?) \|$", re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")


def snippets() -> list[str]:
    """Return the code in the right-hand column of every table."""
    rows = ROW.findall(PAGE.read_text(encoding="utf-8").replace("\\|", "∪"))
    return sorted({code.replace("∪", "|") for _, right in rows for code in CODE.findall(right)})


@pytest.fixture(scope="module")
def things() -> dict[str, Any]:
    """Return an example of every name that the tables use."""
    a, b = co.Sphere(1), co.Box((0, 0, 0), (2, 2, 2))
    material = co.Material(properties={"density": 1.0})
    body = co.Body(a, material, "ball")
    scene = co.Scene([body])
    rays = co.Rays([(-3, 0, 0), (-3, 0, 0.5)], (1, 0, 0))
    lens = co.optics.prescription([(50, 6, "N-BK7"), (-50, None)], aperture=10)
    return {
        "co": co, "np": np, "a": a, "b": b, "solid": a, "body": body, "material": material, "scene": scene, "rays": rays,
        "hits": scene.first_hit(rays), "spans": scene.spans(rays), "crossings": scene.crossings(rays), "lens": lens,
        "image": co.Image(np.zeros((2, 2, 3))),
    }  # fmt: skip


def test_tables_have_their_rows():
    """Every program has a table of 8 to 18 rows."""
    text = PAGE.read_text(encoding="utf-8")
    for section in text.split("\n## ")[1:]:
        rows = len(ROW.findall(section.replace("\\|", "∪"))) - 1
        assert 8 <= rows <= 18, section.partition("\n")[0]


def test_right_hand_sides_exist(things: dict[str, Any]):
    """Every attribute of the code exists, and every call has arguments that the function takes."""
    codes = [code for code in snippets() if re.match(r"(co|[a-z]+)\.|[~-]", code)]
    for node in (node for code in codes for node in ast.walk(ast.parse(code, mode="eval"))):
        if isinstance(node, ast.Attribute):
            found(node, things)
        if isinstance(node, ast.Call) and (function := found(node.func, things)) is not None:
            keywords = {keyword.arg: None for keyword in node.keywords if keyword.arg}
            inspect.signature(function).bind(*node.args, **keywords)


def found(node: ast.expr, things: dict[str, Any]) -> Any:
    """Return the object that a dotted name means; None for the results of calls, which are not computed."""
    if isinstance(node, ast.Name):
        return things.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = found(node.value, things)
        return None if owner is None else getattr(owner, node.attr)
    return None


# --- The programs of the documentation draw its figures, and a page shows each

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


# --- The link checker of the site finds each fault of a small site, and nothing else


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "other.html").write_text('<h1 id="top">Other</h1><a href="../index.html#here">back</a>')
    (tmp_path / "picture name.png").write_bytes(b"")
    return tmp_path


@pytest.mark.parametrize(
    "link",
    [
        '<a href="sub/other.html#top">',
        '<a href="#here">',
        '<a href="sub/other.html?x=1">',
        '<img src="picture%20name.png">',
        '<img src="data:image/png;base64,">',
        '<a href="https://example.org/nowhere">',
        '<a href="mailto:a@example.org">',
    ],
)
def test_correct_pages_pass(site: Path, link: str):
    (site / "index.html").write_text(f'<p id="here">{link}')
    assert problems(site) == []


@pytest.mark.parametrize(
    ("link", "message"),
    [
        ('<a href="missing.html">', "no such file"),
        ('<a href="sub/other.html#bottom">', "no such place"),
        ('<a href="#there">', "no such place"),
        ('<img src="missing.png">', "no such file"),
        ('<iframe src="live/missing.html">', "no such file"),
        ('<a href="../outside.html">', "outside of the site"),
        ('<script src="https://example.org/x.js">', "another host"),
        ('<link rel="stylesheet" href="//example.org/x.css">', "another host"),
        ('<img src="https://example.org/x.png">', "another host"),
    ],
)
def test_wrong_pages_fail(site: Path, link: str, message: str):
    (site.parent / "outside.html").write_text("")
    (site / "index.html").write_text(f'<p id="here">{link}')
    (found,) = problems(site)
    assert found.startswith("index.html: ")
    assert message in found


# --- The recipe for a material works: its files and edits, made in a copy of the repository, pass its test

ROOT = Path(__file__).resolve().parent.parent.parent
RECIPE = ROOT / "docs" / "dev" / "add-a-material.md"
FENCE = re.compile(r"^```(python|diff)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(kind: str) -> list[str]:
    """Return the fenced blocks of one language."""
    return [found[2] for found in FENCE.finditer(RECIPE.read_text(encoding="utf-8")) if found[1] == kind]


def apply(diff: str, root: Path) -> None:
    """Apply a diff without line numbers: the old lines of each hunk must stand once in their file."""
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


def edited_copy(tmp_path: Path) -> None:
    """Apply the edits of the page to a copy of the package and of the tests of surfaces."""
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
    """The diffs of the page apply, and their result is Python."""
    edited_copy(tmp_path)
    changed = [file for file in (tmp_path / "conicoid").rglob("*.py") if "dust" in file.read_text(encoding="utf-8")]
    assert len(changed) > 3
    for file in changed:
        compile(file.read_text(encoding="utf-8"), file.name, "exec")


@pytest.mark.deep  # it compiles kernels
@needs_compiler
@pytest.mark.parametrize("chosen", ["albedo or reciprocity", "picture"])
def test_the_recipe_for_a_material_works(tmp_path: Path, chosen: str) -> None:
    """The short tests of the page pass, and so do its pictures."""
    edited_copy(tmp_path)
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


# --- The reference has every public name, once, with the first line of its docstring; docstrings become field lists

PAGES = sorted((Path(__file__).resolve().parents[2] / "docs" / "reference").glob("*.md"))
INTERNAL: set[str] = set()
COMPLETE = "Scene Rays Hits Spans Crossings BodiesAt Distances Image optics.Paths section.Slice section.Voxels".split()


def reference_entries() -> list[reference.Entry]:
    """Return the entries of all pages."""
    return [entry for page in PAGES for entry in reference.entries(page.read_text(encoding="utf-8"))]


def names(prefix: str) -> Counter[str]:
    """Return how often each name directly below a prefix is listed."""
    below = [entry.name.removeprefix(prefix) for entry in reference_entries() if entry.name.startswith(prefix)]
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
    assert set(Counter(entry.name for entry in reference_entries()).values()) == {1}


def test_members_that_are_listed_are_there():
    missing = [
        f"{entry.name}.{name}"
        for entry in reference_entries()
        for name in entry.members
        if not _has(entry.target, name)
    ]
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
    (entry,) = (entry for entry in reference_entries() if entry.name == f"co.{name}")
    missing = reference.members_of(entry.target) - INTERNAL - set(entry.members)
    assert not missing, f"add below co.{name}: {', '.join(sorted(missing))}"


def test_entries_become_directives():
    page = "- `co.Conic`: A cap.\n  - `sheet`: Return it.\n- `co.materials.WATER`: The index.\n"
    directives = reference.directives(page)
    assert ".. autoclass:: conicoid.Conic\n   :members: sheet\n```" in directives
    assert ".. autodata:: conicoid.materials.WATER\n\n   The index.\n```" in directives


def test_columns_are_kept_as_they_are_written():
    lines = ["What it is.", "", "t      the place", "body   its number", "", "Raises ValueError for others."]
    text = "\n".join(docstrings.structured(lines))
    assert "::\n\n   t      the place\n   body   its number\n" in text
    assert text.endswith("Raises ValueError for others.\n")


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
    text = "\n".join(docstrings.sectioned(SECTIONS.splitlines()))
    assert text.startswith("Return a\\_b.\n\nParameters\n----------\nt_min, t_max : float or (...)\n")
    assert "\n    With a ``Rays`` by name, 2 \\* 3.\nprogress : callable, optional\n" in text
    assert "\nReturns\n-------\nbool (...)\n\nAttributes\n" in text
    assert text.endswith("Notes\n-----\nPickled ones keep t\\_min.\n\n")


def test_a_docstring_without_sections_is_prose():
    assert docstrings.sectioned(["One line of a_b."]) == ["One line of a\\_b.", ""]


def test_sections_become_field_lists():
    pytest.importorskip("sphinx")
    text = "\n".join(docstrings.rendered(SECTIONS.splitlines()))
    assert ":Parameters: * **t_min, t_max** (*float or (...)*) -- With a ``Rays`` by name, 2 \\* 3." in text
    assert "             * **progress** (*callable, optional*) -- progress(done, count) is called." in text
    assert ":returns: *bool (...)*" in text
    assert ":Attributes: **body, face** (*int32*) -- Numbers." in text
    assert ":raises ValueError: For t\\_min > t\\_max." in text
    assert ".. rubric:: Notes" in text
