"""The documentation is true: its code runs, its links have targets, every shape is in the table."""

import functools
import importlib.util
import inspect
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import conicoid as co
from conicoid import queries
from conicoid.geometry.registry import REGISTRY
from conicoid.geometry.shape import REGISTERED
from conicoid.render.integrators import INTEGRATORS, Integrator
from conicoid.scene import scene as scene_module

from .machine_code import needs_compiler
from .public_names import PUBLIC
from .samples import quick

ROOT = Path(__file__).resolve().parent.parent
LETTERS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
PAGES = [*(ROOT / name for name in LETTERS), *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def code_blocks(page: Path) -> list[str]:
    """Return the Python blocks of a page, each after empty lines so that line numbers are the page's."""
    text = page.read_text(encoding="utf-8")
    return ["\n" * text.count("\n", 0, found.start(1)) + found[1] for found in FENCE.finditer(text)]


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


RENDER = co.Scene.render
WITH_CODE = [page for page in PAGES if page.parent.name != "dev" and code_blocks(page)]


def draw_small(scene: co.Scene, width: int = 640, height: int = 480, *rest, **more) -> co.Image:
    """Draw a large picture in a sixteenth of its pixels."""
    parts = 4 if width > 320 else 1
    return RENDER(scene, width // parts, height // parts, *rest, **more)


@pytest.mark.parametrize("page", WITH_CODE, ids=name_of)
def test_code_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fast run takes fewer pixels, and fewer rays where a page leaves their number to the package."""
    monkeypatch.chdir(tmp_path)
    if quick():
        monkeypatch.setattr(co.Scene, "render", draw_small)
        monkeypatch.setattr(co, "check", functools.partial(co.check, rays=10_000))
        monkeypatch.setattr(importlib.import_module("conicoid.apps.measures.measure"), "RAYS", 50_000)
    namespace: dict[str, object] = {"__name__": "documentation"}
    for block in code_blocks(page):
        exec(compile(block, str(page), "exec"), namespace)


def test_links_lead_somewhere() -> None:
    links = [(page, target) for page in PAGES for target in LINK.findall(page.read_text(encoding="utf-8"))]
    for page, target in links:
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        found = page.parent / file if file else page
        assert found.exists(), f"{name_of(page)} links to {target}"
        if anchor:
            assert anchor in anchors(found), f"{name_of(page)} links to {target}"


def anchors(page: Path) -> set[str]:
    """Return GitHub's anchors of a page's headings."""
    headings = HEADING.findall(page.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_words_of_the_workshop_stay_there() -> None:
    """Sources have names, open intervals are in words, and pages explain a leaf or a cell where they name it."""
    texts = {
        name_of(page): page.read_text(encoding="utf-8")
        for page in PAGES
        if page.name not in ("CONTRIBUTING.md", "CHANGELOG.md") and page.parent.name != "dev"
    }
    for name, text in (texts | {name: public.__doc__ or "" for name, public in PUBLIC.items()}).items():
        assert not re.search(r"\bseeds? \d{3}\b", text, re.IGNORECASE), name
        assert "]t_min" not in text, name
        if re.search(r"\bleaf\b|\bleaves of\b", text):
            assert "*leaf*" in text, name
        if re.search(r"\bcells?\b", re.sub(r"(?s)```.*?```|`[^`]*`", "", text)):
            assert "*cell" in text or "theory.md#8-solids" in text or "OpenMC" in text, name


def test_every_shape_and_integrator_is_in_the_tables() -> None:
    shapes, pictures = ((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("shapes.md", "pictures.md"))
    own = [name for name in REGISTRY if REGISTRY[name].__module__.startswith("conicoid.")]
    assert [name for name in own if f"`{name}`" not in shapes] == []
    rows = [f'| `"{each.name}"` | {each.about} |' for each in INTEGRATORS.values()]
    assert set(rows) <= set(pictures.splitlines())


def recipe(name: str) -> list[str]:
    """Return the Python blocks of a recipe in docs/dev, each on the page's line numbers."""
    return list(code_blocks(ROOT / "docs" / "dev" / f"{name}.md"))


def load_module(monkeypatch: pytest.MonkeyPatch, name: str, code: str) -> ModuleType:
    """Return a module of the package with an example's code."""
    spec = importlib.util.spec_from_loader(name, loader=None)
    module = importlib.util.module_from_spec(spec)
    module.__package__ = name.rpartition(".")[0]
    monkeypatch.setitem(sys.modules, name, module)
    exec(compile(code, "docs/dev", "exec"), module.__dict__)
    return module


def run_tests(code: str) -> None:
    """Run the tests of an example."""
    namespace: dict[str, object] = {"__name__": "test_of_contributing"}
    exec(compile(code, "docs/dev", "exec"), namespace)
    tests = [value for key, value in namespace.items() if key.startswith("test_")]
    assert tests
    for run in tests:
        run()


def test_the_primitive_of_contributing_works(monkeypatch: pytest.MonkeyPatch) -> None:
    code, test = recipe("add-a-primitive")
    module = load_module(monkeypatch, "conicoid.geometry.cooling_tower", code)
    try:
        assert module.CoolingTower is REGISTRY["CoolingTower"]
        run_tests(test)
    finally:
        REGISTERED.pop("CoolingTower")


@needs_compiler
@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.deep)])
def test_the_integrator_of_contributing_works(whole: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its name selects it. A kernel of pictures compiles with it."""
    code, line, test = recipe("add-an-integrator")
    load_module(monkeypatch, "conicoid.render.integrators.curvature", code)
    (added,) = eval(line.strip(), {"Integrator": Integrator})
    monkeypatch.setitem(INTEGRATORS, added.name, added)
    with pytest.raises(ValueError, match="render: integrator must be one of .*, curvature, got 'photons'"):
        co.Scene([]).render(1, 1, integrator="photons")
    if whole:
        run_tests(test)


@needs_compiler
@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.deep)])
def test_the_query_of_contributing_works(whole: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has its place and its name. A kernel of rays compiles with it."""
    code, method, line, test = recipe("add-a-query")
    module = load_module(monkeypatch, "conicoid.queries.thickness", code)
    monkeypatch.setattr(queries, "thickness", module, raising=False)
    namespace = dict(vars(scene_module))
    exec(compile(method, "docs/dev", "exec"), namespace)
    monkeypatch.setattr(scene_module.Scene, "thickness", namespace["thickness"], raising=False)
    assert eval(f"{{{line.strip()}}}") == {"thickness": list(inspect.signature(co.Scene.thickness).parameters)[1]}
    if whole:
        run_tests(test)


@pytest.mark.deep
def test_the_examples_of_contributing_join_the_tree(tmp_path: Path) -> None:
    """The page's edits go into a copy of the tree. There the examples pass the tests for all of their kind."""
    for folder in ("conicoid", "native", "tests", "docs"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", *LETTERS):
        shutil.copy(ROOT / name, tmp_path)
    primitive, primitive_test = recipe("add-a-primitive")
    integrator, line, integrator_test = recipe("add-an-integrator")
    query, method, entry, query_test = recipe("add-a-query")
    for file, code in (
        ("conicoid/geometry/cooling_tower.py", primitive),
        ("conicoid/render/integrators/curvature.py", integrator),
        ("conicoid/queries/thickness.py", query),
        ("tests/shapes/test_cooling_tower.py", primitive_test),
        ("tests/integrators/test_curvature.py", integrator_test),
        ("tests/engine/test_thickness.py", query_test),
    ):
        assert not (tmp_path / file).exists()
        (tmp_path / file).write_text(code.lstrip(), encoding="utf-8")
    insert(tmp_path / "conicoid" / "render" / "integrators" / "__init__.py", line, before="    )\n}\n")
    insert(tmp_path / "conicoid" / "scene" / "scene.py", method, before="    # --- Explanations\n")
    insert(tmp_path / "conicoid" / "scene" / "scene.py", entry, before='    "line_integral": "values",\n')
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    build = [sys.executable, "-m", "native.build", "--in-place"]
    subprocess.run(build, cwd=tmp_path, env=environment, check=True, stdout=subprocess.DEVNULL)
    chosen = "CoolingTower or cooling_tower or curvature or thickness or nothing_is_left"
    folders = ("contract", "shapes/test_cooling_tower.py", "integrators", "render", "engine/test_thickness.py")
    paths = [f"tests/{path}" for path in (*folders, "test_warmup.py")]
    command = [sys.executable, "-m", "pytest", *paths, "-k", chosen, "-q"]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout
    program = "from conicoid._jit.machine_code import SHIPPED; print(*SHIPPED.kernels())"
    kernels = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert set(kernels.stdout.split()) >= {"curvature_tiles", "first_walls"}


def insert(file: Path, code: str, before: str) -> None:
    """Insert the code of an example into a file, indented, before a text that stands there once."""
    text = file.read_text(encoding="utf-8")
    assert text.count(before) == 1
    depth = "    " if code.lstrip().startswith("@") else 8 * " "
    lines = "".join(f"{depth}{each}".rstrip() + "\n" for each in code.strip().splitlines())
    file.write_text(text.replace(before, lines + before), encoding="utf-8")
