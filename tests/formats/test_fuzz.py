"""Whatever stands in a file: it loads, or it is refused as a scene file; nothing else is ever raised."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from hypothesis import given, settings, strategies as st

from conicoid._util.files import SceneFileError
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.scene_file import read_scene
from conicoid.io.scene_file.schema import scene_schema
from conicoid.io.scene_file.writer import dump_yaml

from ..samples import size

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").rglob("*.yaml"))
TOKENS = ["{", "}", "[", "]", ":", ",", "- ", "\n", "  ", "&a ", "*a", "!x ", "'", '"', "#", "|", ">", "%", "~", ".nan", ".inf",
          "-1", "0", "1e999", "true", "Sphere", "Union", "move", "shape", "\0", "\ud7ff", "🙂", "\x85", "\u2028", "<<", "? "]  # fmt: skip
FUZZ = settings(max_examples=size(50, 150), deadline=None)


def survives(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_bytes(content)
        try:
            read_scene(path)
        except SceneFileError as error:
            assert str(error)
            assert all(problem.message for problem in error.problems)


@FUZZ
@given(st.binary(max_size=200))
def test_any_bytes(content):
    survives(content)


@FUZZ
@given(st.lists(st.sampled_from(TOKENS), max_size=40).map("".join))
def test_any_tokens(text):
    survives(text.encode())


@FUZZ
@given(st.data())
def test_scenes_with_random_edits(data):
    text = data.draw(st.sampled_from(EXAMPLES)).read_text(encoding="utf-8")
    for _ in range(data.draw(st.integers(1, 4))):
        begin = data.draw(st.integers(0, len(text)))
        end = min(len(text), begin + data.draw(st.integers(0, 12)))
        text = text[:begin] + data.draw(st.sampled_from([*TOKENS, ""])) + text[end:]
    survives(text.encode())


words = st.sampled_from([*REGISTRY, *scene_schema()["properties"], "name", "shape", "move", "material", "radius", "center", "file",
                         "operands", "translate", "scale", "phong", "Checker", "a", "b"])  # fmt: skip
leaves = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    words,
    st.text(st.characters(exclude_categories=("Cs",)), max_size=5),
)
trees = st.recursive(
    leaves, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(words, inner, max_size=3), max_leaves=20
)


@FUZZ
@given(st.dictionaries(st.sampled_from(["bodies", "shapes", "materials", "lights", "camera", "background"]), trees))
def test_any_tree(tree):
    survives(dump_yaml(tree).encode())


@FUZZ
@given(st.sampled_from(sorted(REGISTRY)), st.data())
def test_any_arguments_of_any_shape(name, data):
    fields = scene_schema()["$defs"][name]["properties"][name].get("properties", {"operands": None})
    values = st.one_of(trees, st.lists(st.floats(-2, 2), max_size=4), st.floats(-2, 2))
    names = sorted(fields) or ["operands"]  # `Nowhere` has no field: one that it does not know
    arguments: dict[str, Any] = data.draw(st.dictionaries(st.sampled_from(names), values))
    survives(dump_yaml({"bodies": [{"shape": {name: arguments}, "move": data.draw(trees)}]}).encode())
