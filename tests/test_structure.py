"""The structure of the code base is within the limits of `benchmarks/structure.py`."""

import gc
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "conicoid"
MOST_FILES = 393
MOST_WORDS = 20
MOST_NAMES = 118
pytestmark = pytest.mark.skipif(not PACKAGE.is_dir(), reason="the package's source is not beside its tests")


@pytest.fixture(scope="module")
def structure() -> ModuleType:
    spec = importlib.util.spec_from_file_location("structure", ROOT / "benchmarks" / "structure.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def found(structure: ModuleType) -> dict[str, object]:
    gc.disable()  # it would walk through all trees again and again, and triple the time
    modules = structure.modules(PACKAGE)
    gc.enable()
    return modules


@pytest.fixture(scope="module")
def graph(structure: ModuleType, found: dict[str, object]) -> dict[str, set[str]]:
    return structure.arrows(found)


def test_no_circle_of_files(structure, graph):
    assert structure.circles(graph) == []


def test_at_most_twelve_floors_of_folders(structure, graph):
    floors = structure.floors(structure.folder_arrows(graph))
    assert max(floors.values()) <= 12, floors


def test_few_files(found):
    assert len(found) <= MOST_FILES


def test_one_hit_is_followed_in_eight_files(structure, found):
    files = {structure.defining_file(found, function) for function in structure.ONE_HIT}
    assert None not in files
    assert len(files) <= 8, files


def test_class_names_are_unique(structure, found):
    assert structure.class_doubles(found) == {}


def test_docstrings_are_in_plain_english(structure, found):
    assert len(structure.house_words(found)) <= MOST_WORDS


def test_about_a_hundred_names_in_the_root(structure):
    assert structure.public_names(PACKAGE) <= MOST_NAMES


def test_a_circle_is_found(structure):
    graph = {"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}
    assert structure.circles(graph) == [["a", "b", "c"]]


def test_floors_are_counted_from_the_ground(structure):
    assert structure.floors({"roof": {"room", "cellar"}, "room": {"cellar"}, "cellar": set()}) == {
        "cellar": 0,
        "room": 1,
        "roof": 2,
    }


def test_imports_are_found_wherever_they_stand(structure, tmp_path):
    places = (
        "",
        "def f():\n ",
        "class A:\n ",
        "try:\n pass\nexcept E:\n ",
        "try:\n pass\nfinally:\n ",
        "if 0:\n pass\nelse:\n ",
    )
    names = [f"example.m{k}" for k in range(len(places) + 1)]
    source = tmp_path / "m.py"
    text = [f"{place}from example import m{k}" for k, place in enumerate(places)]
    source.write_text("\n".join([*text, f"match 1:\n case 1:\n  import {names[-1]}\n"]))
    assert sorted(structure.Module("example.m", source).imports(dict.fromkeys(names))) == names


def test_house_words_are_found(structure, tmp_path):
    package = tmp_path / "example"
    package.mkdir()
    (package / "__init__.py").write_text('"""What is told of a shape."""\n\n\ndef f():\n    """Return the hit."""\n')
    assert [line for _, line in structure.house_words(structure.modules(package))] == ["What is told of a shape."]
