"""Broken scene files: mistakes with their places, and the schema."""

import json
import math
import re
import tempfile
from pathlib import Path

import jsonschema
import pytest
from hypothesis import HealthCheck, given, settings

import conicoid as co
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.nodes import Node, ScalarNode, SequenceNode, is_null, is_text, parse_bool, parse_float
from conicoid.io.scene_file.scene_file import read_scene
from conicoid.io.scene_file.schema import scene_schema
from conicoid.io.scene_file.yaml_parser import parse_document

from .broken import CASES
from .strategies import scenes

# --- Every broken scene file is refused with its line, the mistake and the expected value, by the command too


def test_there_are_enough():
    assert len(CASES) >= 60
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_refused_with_line_and_reason(case, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_bytes(case.content)
    with pytest.raises(co.SceneFileError) as caught:
        read_scene(path)
    message = str(caught.value)
    for phrase in case.phrases:
        assert phrase in message
    matching = [line for line in message.splitlines() if case.phrases[0] in line]
    place = f"{re.escape(str(path))}:{case.line}:\\d+: " if case.line else f"{re.escape(str(path))}: "
    assert any(re.match(place, line) for line in matching), message
    assert len(message) < 20_000


# --- The published schema: valid itself, accepts files that load, rejects what editors should mark

ROOT = Path(__file__).resolve().parents[2]
VALIDATOR = jsonschema.Draft202012Validator(scene_schema())

TYPES = (
    "a word", "a list", "a number", "no bodies", "unknown section", "bodies as a word", "a body without shape",
    "misspelt key", "name is a number", "material is a number", "unknown shape", "lower case", "shape is a number",
    "two shapes in one", "no shape at all", "unknown field", "radius is text", "radius is a list", "center is short",
    "missing field", "range of one", "flag is a text", "matrix is small", "Boolean of nothing", "Boolean of a number",
    "Boolean with a mistake inside", "Boolean of a sheet", "sheet clipped by a sheet", "side that does not exist",
    "paint without a material", "paint on a list", "paint on a sheet", "paint is a color", "paint with a mistake inside", "unknown step", "short step",
    "rotate without axis", "balls without radii", "balls and a file", "unknown look", "unknown highlight", "lights as a mapping",
    "unknown light", "light without a place", "camera is a word", "camera misspelt", "background is half a color",
)  # fmt: skip


def plain(node: Node):
    """Return a node as a YAML 1.2 reader sees it."""
    if isinstance(node, SequenceNode):
        return [plain(item) for item in node.items]
    if not isinstance(node, ScalarNode):
        return {key: plain(item) for key, item in node.entries.items()}
    if is_null(node):
        return None
    if is_text(node):
        return node.text
    flag = parse_bool(node)
    return parse_float(node) if flag is None else flag


def tree(text: str):
    document = parse_document(text)
    root, problems = document.root, document.problems
    assert not problems
    return plain(root)


@pytest.mark.deep
def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    json.dumps(scene_schema(), allow_nan=False)


def test_every_shape_stands_in_it():
    assert set(REGISTRY) <= set(scene_schema()["$defs"])


@given(scenes())
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
def test_saved_files_are_valid(scene):
    with tempfile.TemporaryDirectory() as folder:
        co.save(scene, Path(folder) / "scene.yaml")
        VALIDATOR.validate(tree((Path(folder) / "scene.yaml").read_text(encoding="utf-8")))


def test_examples_are_valid():
    for path in sorted((ROOT / "examples").rglob("*.yaml")):
        VALIDATOR.validate(tree(path.read_text(encoding="utf-8")))
        co.load(path)


@pytest.mark.parametrize("name", TYPES)
def test_mistakes_of_type_are_invalid(name):
    (case,) = (case for case in CASES if case.name == name)
    assert not VALIDATOR.is_valid(tree(case.content.decode()))


def test_infinities_are_numbers():
    data = {"bodies": [{"shape": {"Ellipsoid": {"z_range": [-math.inf, 0.5]}}}]}
    assert VALIDATOR.is_valid(data)
