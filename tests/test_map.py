"""Files and folders in the text of README, CONTRIBUTING, pages for developers and comments exist."""

import re
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "conicoid"
pytestmark = pytest.mark.skipif(not PACKAGE.is_dir(), reason="the package's source is not beside its tests")
NAMED = re.compile(r"(?<![\w./-])((?:[a-z_0-9]+/)*[a-z_0-9]+\.(?:py|js|glsl|c|h))(?![\w(])")
EXAMPLES = {"setup.py", "my_scene.py"}
"""Names of users' files."""

RECIPES = {
    *("conicoid/geometry/cooling_tower.py", "tests/shapes/test_cooling_tower.py"),
    *("conicoid/queries/thickness.py", "tests/engine/test_thickness.py"),
    *("conicoid/render/bsdf/dust.py", "lab.py", "tests/scattering/test_dust.py"),
    *("conicoid/render/integrators/curvature.py", "tests/integrators/test_curvature.py"),
}
"""Files that the reader of a recipe writes."""

COMMENTS = {
    ".py": re.compile(r'""".*?"""|#[^\n]*', re.S),
    **dict.fromkeys((".js", ".glsl", ".c", ".h"), re.compile(r"/\*.*?\*/|//[^\n]*", re.S)),
}
SOURCES = sorted(path for folder in (PACKAGE, ROOT / "native") for path in folder.rglob("*") if path.suffix in COMMENTS)


def folders() -> Iterator[str]:
    """Return the folders of README's map, as paths from the root."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = re.search(r"```\n(conicoid/\n.*?)```", text, re.S)
    assert block
    above = {0: ""}
    for line in block[1].splitlines():
        depth = len(line) - len(line.lstrip())
        for part in takewhile(lambda word: word.endswith(("/", ".py")), line.split()):
            path = above[max(d for d in above if d <= depth)] + part
            yield path
        above = {d: text for d, text in above.items() if d <= depth} | {depth + 2: path}


def test_the_folders_of_the_readme_are_there() -> None:
    named = list(folders())
    assert len(named) > 10
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_readme_names_every_folder() -> None:
    there = {f"conicoid/{path.name}/" for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert there - set(folders()) == set()


def missing_files(path: Path, words: str, places: tuple[Path, ...], known: set[str]) -> list[tuple[str, str]]:
    """Return (file, name) of the names in its words without a place that holds them."""
    names = set(NAMED.findall(words)) - known
    return [(path.name, name) for name in names if not any((place / name).exists() for place in places)]


def test_files_that_comments_name_are_there() -> None:
    """A path begins at the root, the package or the file's own folder."""
    found = []
    for path in SOURCES:
        words = "\n".join(COMMENTS[path.suffix].findall(path.read_text(encoding="utf-8")))
        found += missing_files(path, words, (ROOT, PACKAGE, path.parent, path.parent.parent), EXAMPLES)
    assert found == []


def test_files_that_pages_for_developers_name_are_there() -> None:
    """A name without a folder may be in any folder."""
    known = RECIPES | {path.name for path in SOURCES}
    pages = sorted((ROOT / "docs" / "dev").glob("*.md"))
    assert pages
    assert [missing_files(page, page.read_text(encoding="utf-8"), (ROOT, PACKAGE), known) for page in pages] == [
        []
    ] * len(pages)


def test_files_that_contributing_names_are_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    names = re.findall(r"`([a-z_0-9]+(?:/[a-z_0-9]+)+\.py)`", text)
    assert len(names) > 15
    assert [name for name in names if not ((PACKAGE / name).exists() or (ROOT / name).exists())] == []
