"""The tree of a scene file: lines, columns, counts and repeated keys; and reading as a whole, with its progress."""

from __future__ import annotations

import gc

import pytest
import yaml

import conicoid as co
from conicoid._util.files import SceneFileError
from conicoid.io.scene_file.nodes import MappingNode, Node, ScalarNode, SequenceNode
from conicoid.io.scene_file.writer import dump_yaml
from conicoid.io.scene_file.yaml_parser import YamlError, parse_document, parse_yaml

from .fuzzing.scene_cases import sources

# The tree


def same_places(node: Node, other: yaml.Node) -> None:
    """The tree of PyYAML's own composer, which also knows where things stand."""
    pending = [(node, other)]
    while pending:
        mine, its = pending.pop()
        assert (mine.line, mine.column) == (its.start_mark.line + 1, its.start_mark.column + 1)
        if isinstance(mine, ScalarNode):
            assert mine.text == its.value
        elif isinstance(mine, SequenceNode):
            pending.extend(zip(mine.items, its.value, strict=True))
        else:
            assert [key.text for key in mine.heads] == list(mine.entries) == [key.value for key, _ in its.value]
            pending.extend(zip(mine.heads, (key for key, _ in its.value), strict=True))
            pending.extend(zip(mine.entries.values(), (value for _, value in its.value), strict=True))


def test_everything_stands_where_it_stands():
    texts, trees, _ = sources()
    for text in [*texts, *map(dump_yaml, trees)]:
        root, problems = parse_yaml(text)
        assert problems == []
        same_places(root, yaml.compose(text, Loader=yaml.CSafeLoader))


def values_of(root: Node) -> int:
    """How many values stand in a tree, keys among them, each alias as nothing."""
    seen: dict[int, Node] = {}
    pending = [root]
    while pending:
        node = pending.pop()
        if id(node) not in seen:
            seen[id(node)] = node
            pending += node.items if isinstance(node, SequenceNode) else []
            pending += [*node.heads, *node.entries.values()] if isinstance(node, MappingNode) else []
    return len(seen)


def test_values_are_counted_once():
    for text in sources()[0]:
        found = parse_document(text)
        assert found.distinct == values_of(found.root)


def test_repeated_keys_know_the_first_one_of_their_own_mapping():
    """Also where mappings came and went before: those that are values of repeated keys are not kept."""
    gone = "".join(f"a: {{x{k}: 1, x{k}: 2}}\n" for k in range(50))
    _, problems = parse_yaml(f"a: 1\n{gone}b:\n  c: 1\n  d: 2\n  c: 3\n  e: 4\n  e: 5\n")
    first = [problem.message.rpartition(" ")[2] for problem in problems]
    assert first[-2:] == ["53)", "56)"]
    assert sum(message == "1)" for message in first) == 50


def test_aliases_may_add_less_than_a_file_may_hold():
    text = "a: &a [" + "1, " * 1000 + "]\nb: [" + "*a, " * 999 + "]\n"
    with pytest.raises(YamlError, match="more than 1,000,000 values, aliases expanded"):
        parse_yaml(text.replace("*a, ", "*a, " * 2))
    assert parse_document(text).distinct == 1005


@pytest.mark.deep
def test_a_hundred_thousand_bodies(tmp_path):
    body = "- {name: body %d, shape: {Sphere: {radius: 2, center: [%d, 2, 3]}}, material: red}\n"
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "".join(body % (k, k) for k in range(100_000)))
    scene = co.load(tmp_path / "scene.yaml")
    assert len(scene.bodies) == 100_000
    assert scene["body 99999"].shape == co.Sphere(2, (99_999, 2, 3))


# What is around it


def test_the_collector_is_as_it_was(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Sphere: {}}}]\n")
    (tmp_path / "wrong.yaml").write_text("bodies: [{shape: {Sphere: 1}}]\n")
    during = []
    for on in (True, False):
        (gc.enable if on else gc.disable)()
        try:
            co.load(tmp_path / "scene.yaml", progress=lambda *_: during.append(gc.isenabled()))
            assert gc.isenabled() == on
            with pytest.raises(SceneFileError):
                co.load(tmp_path / "wrong.yaml")
            assert gc.isenabled() == on
            co.Scene([co.Sphere(1)]).prepare(progress=lambda *_: during.append(gc.isenabled()))
            assert gc.isenabled() == on
        finally:
            gc.enable()
    assert set(during) == {False}


def test_progress_rises_to_the_end(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "- {shape: {Sphere: {}}}\n" * 3000)
    calls: list[tuple[int, int]] = []
    co.load(tmp_path / "scene.yaml", progress=lambda done, count: calls.append((done, count)))
    done, counts = zip(*calls, strict=True)
    assert list(done) == sorted(done)
    assert len(set(counts)) == 1
    assert min(done) < counts[0] / 2 < max(done) <= counts[0]
    with pytest.raises(TypeError, match="load: progress must be a function or None, got str"):
        co.load(tmp_path / "scene.yaml", progress="bar")


def test_reading_can_be_interrupted(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "- {shape: {Sphere: {}}}\n" * 3000)

    def stop(done: int, count: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        co.load(tmp_path / "scene.yaml", progress=stop)
    assert gc.isenabled()
