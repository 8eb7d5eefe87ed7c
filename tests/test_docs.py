"""The documentation is true: its code runs, its links lead somewhere, every shape is in the table."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import conicoid as co
from conicoid.integrators import INTEGRATORS, Integrator
from conicoid.shapes import REGISTRY

ROOT = Path(__file__).resolve().parent.parent
LETTERS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
PAGES = [*(ROOT / name for name in LETTERS), *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def code_blocks(page: Path) -> list[str]:
    """The Python blocks of a page, each preceded by empty lines so that line numbers are the page's."""
    text = page.read_text(encoding="utf-8")
    return ["\n" * text.count("\n", 0, found.start(1)) + found[1] for found in FENCE.finditer(text)]


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


WITH_CODE = [page for page in PAGES if page.name != "CONTRIBUTING.md" and code_blocks(page)]


@pytest.mark.parametrize("page", WITH_CODE, ids=name_of)
def test_code_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {"__name__": "documentation"}
    for block in code_blocks(page):
        exec(compile(block, str(page), "exec"), namespace)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page: Path) -> None:
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        found = page.parent / file if file else page
        assert found.exists(), f"{name_of(page)} links to {target}"
        if anchor:
            assert anchor in anchors(found), f"{name_of(page)} links to {target}"


def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives to a page's headings."""
    headings = HEADING.findall(page.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize(
    "told",
    [page.read_text(encoding="utf-8") for page in PAGES if page.name not in ("CONTRIBUTING.md", "CHANGELOG.md")]
    + [getattr(co, name).__doc__ or "" for name in co.__all__],
)
def test_words_of_the_workshop_stay_there(told: str) -> None:
    """Sources have names, open intervals are said in words, and a leaf or a cell is explained where it is spoken of."""
    assert not re.search(r"\bseeds? \d{3}\b", told, re.IGNORECASE)
    assert "]t_min" not in told
    if re.search(r"\bleaf\b|\bleaves of\b", told):
        assert "*leaf*" in told
    if re.search(r"\bcells?\b", re.sub(r"(?s)```.*?```|`[^`]*`", "", told)):
        assert "*cell" in told or "theory.md#8-solids" in told or "OpenMC" in told


@pytest.mark.parametrize("name", [name for name in REGISTRY if REGISTRY[name].__module__.startswith("conicoid.")])
def test_every_shape_is_in_the_table(name: str) -> None:
    assert f"`{name}`" in (ROOT / "docs" / "shapes.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("each", INTEGRATORS.values(), ids=lambda each: each.name)
def test_every_integrator_is_in_the_table(each: Integrator) -> None:
    row = f'| `"{each.name}"` | {each.about} |'
    assert row in (ROOT / "docs" / "pictures.md").read_text(encoding="utf-8").splitlines()


@pytest.fixture
def added_primitive(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[ModuleType, str]]:
    """The example of CONTRIBUTING.md, loaded as the file it says it is, and the text of its test."""
    page = ROOT / "CONTRIBUTING.md"
    code, test = code_blocks(page)
    name = "conicoid.shapes.cooling_tower"
    spec = importlib.util.spec_from_loader(name, loader=None)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    module.__package__ = "conicoid.shapes"
    monkeypatch.setitem(sys.modules, name, module)
    exec(compile(code, str(page), "exec"), module.__dict__)
    yield module, test
    REGISTRY.pop("CoolingTower")


def test_the_primitive_of_contributing_works(added_primitive: tuple[ModuleType, str]) -> None:
    module, test = added_primitive
    assert module.CoolingTower is REGISTRY["CoolingTower"]
    namespace: dict[str, object] = {"__name__": "test_cooling_tower"}
    exec(compile(test, "CONTRIBUTING.md", "exec"), namespace)
    tests = [value for key, value in namespace.items() if key.startswith("test_")]
    assert tests
    for run in tests:
        assert callable(run)
        run()


@pytest.mark.deep
def test_the_primitive_of_contributing_joins_the_contract(tmp_path: Path) -> None:
    for folder in ("conicoid", "tests"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    code, _ = code_blocks(ROOT / "CONTRIBUTING.md")
    (tmp_path / "conicoid" / "shapes" / "cooling_tower.py").write_text(code, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "tests/contract", "-k", "CoolingTower", "-q"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "CONICOID_CACHE_DIR": str(tmp_path / "cache")}
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout
