"""What is read at once is what is read word by word: the same bodies, and the same mistakes in the same places."""

from __future__ import annotations

import gc
import tempfile
from pathlib import Path
from random import Random
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings

import conicoid as co
from conicoid._util.file_errors import SceneFileError
from conicoid.io.scene_file import scene_file as scene_reader
from conicoid.io.scene_file.fast_bodies import PlainBodyReader
from conicoid.io.scene_file.nodes import MappingNode, Node, ScalarNode, SequenceNode
from conicoid.io.scene_file.scene_file import parse_scene
from conicoid.io.scene_file.writer import dump_yaml
from conicoid.io.scene_file.yaml_parser import YamlError, parse_document, parse_yaml

from .broken import CASES
from .fuzzing.mutations import text_damaged
from .fuzzing.scene_cases import prepare, sources
from .strategies import scenes

RELAXED = settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))


def outcome(text: str, folder: Path) -> tuple[Any, ...]:
    """What a scene file says, bodies and shapes that are one and the same among it; or what is wrong with it."""
    try:
        parts = parse_scene(text, folder / "scene.yaml")
    except SceneFileError as error:
        return error.problems
    things = [thing for body in parts.bodies for thing in (body, body.shape)]
    first = {id(thing): k for k, thing in reversed(list(enumerate(things)))}
    return parts, repr(parts), [first[id(thing)] for thing in things]


def check_alike(text: str, folder: Path) -> None:
    found = outcome(text, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PlainBodyReader, "read", lambda *_: None)
        patch.setattr(scene_reader, "build_alike_bodies", lambda *_: {})
        assert outcome(text, folder) == found


def damaged(seed: int) -> str:
    random, (texts, _, _) = Random(seed), sources()
    return text_damaged(random, random.choice(texts))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_mistakes_are_told_alike(case, tmp_path):
    check_alike(case.content.decode("utf-8", "replace"), tmp_path)


def test_damaged_files_are_read_alike(tmp_path):
    prepare(tmp_path)
    for seed in range(100):
        check_alike(damaged(seed), tmp_path)


@pytest.mark.deep
@pytest.mark.filterwarnings("ignore:.*is linear light:UserWarning")
def test_damaged_files_are_read_alike_at_length(tmp_path):
    prepare(tmp_path)
    for seed in range(100, 5000):
        check_alike(damaged(seed), tmp_path)


@RELAXED
@given(scenes())
def test_random_scenes_are_read_alike(scene):
    with tempfile.TemporaryDirectory() as folder:
        co.save(scene, Path(folder) / "scene.yaml")
        check_alike((Path(folder) / "scene.yaml").read_text(), Path(folder))


BODIES = [
    "{shape: {Sphere: {radius: 2, center: [1, .5, -1e-3]}}, material: red, name: ball}",
    "{shape: {Box: {}}}",
    "{shape: {Difference: [{Box: {}}, wheel, {Complement: {Sphere: {}}}]}, move: [{scale: 2}, {scale: [1, 2, 3]}]}",
    "{shape: {shape: wheel, move: [{rotate: {axis: -x, degrees: 30}}]}, move: [{translate: [1, 2, 3]}], material: a}",
    "{shape: wheel, material: '#ff8800'}",
    "{shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}}, move: &m [{rotate: {axis: [0, 0, 1], degrees: 5}}]}",
    "{shape: &s {Sphere: {}}, move: [{translate: [5, 0, 0]}]}",
    "{shape: {Cone: {start: [0, 0, 0], end: [0, 0, 1], start_radius: 1, end_radius: 0}}}",
    "{shape: {Box: {}}, move: [{transform: [[1, 2, 0, 0], [0, 1, 0, 5], [0, 0, 1, 0], [0, 0, 0, 1]]}, {scale: -1}]}",
    "{shape: {Ellipsoid: {radii: [1, 2, 3], z_range: null}}}",
]


def test_plain_bodies_are_not_left_to_the_other_reader(monkeypatch, tmp_path):
    text = "materials: {a: {matte: {}}}\nshapes: {wheel: {Sphere: {}}}\nbodies:\n" + "".join(f"- {b}\n" for b in BODIES)
    seen = []
    read = PlainBodyReader.read
    monkeypatch.setattr(PlainBodyReader, "read", lambda self, node: seen.append(read(self, node)) or seen[-1])
    outcome(text, tmp_path)
    assert [k for k, body in enumerate(seen) if body is None] == [len(BODIES) - 1]  # null is rare


REFUSED = [
    "- {shape: {Sphere: {}}, name: a}\n- {shape: {Sphere: {}}, name: a}\n",
    "- {shape: {Sphere: {radius: -1}}, name: a}\n- {shape: {Box: {}}, name: a}\n",
    "- {shape: {Sphere: {}}, move: [{scale: 1e99}, {scale: 1e99}]}\n",
    "- {shape: {Sphere: {radius: 1e200}}}\n- {shape: {Sphere: {radius: 1e-90, center: [1e-99, 0, 0]}}}\n",
    "- {shape: {Sphere: {radius: 1_0}}}\n- {shape: {Sphere: {radius: '1'}}}\n- {shape: {Sphere: {radius: 0x1}}}\n",
    "- &b {shape: &s {Union: [{Sphere: {}}, {Box: {}}]}, name: a}\n- *b\n- {shape: *s}\n",
    "- {shape: {Sphere: {radius: +2}}}\n- {shape: {Sphere: {radius: 007}}}\n- {shape: {Sphere: {center: [-0, -.0, 0]}}}\n",
    "- {shape: {Union: []}}\n- {shape: {Complement: {Plane: {normal: [0, 0, 1], offset: 0}}}}\n- {shape: {Union: [{Disc: 1}]}}\n",
    "- {shape: {Sphere: }, move: }\n- {shape: {Sphere: {}}, move: []}\n- {shape: {Sphere: {}}, material: null, name: null}\n",
    "- {shape: {Box: {}}, move: [{transform: [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}\n",
    "- {shape: {Box: {}}, move: [{scale: 0}]}\n- {shape: {Box: {}}, move: [{rotate: {axis: w, degrees: 1}}, {shear: 1}]}\n",
    "- {shape: {Box: {}}, material: }\n- {shape: {Box: {}}, material: glass}\n- {shape: {Box: {}}, material: 5}\n",
]


@pytest.mark.parametrize("bodies", REFUSED)
def test_odd_bodies_are_read_alike(bodies, tmp_path):
    check_alike(f"bodies:\n{bodies}", tmp_path)


def test_steps_of_a_body_that_is_read_twice_count_once(tmp_path):
    """Its operands are plain, and the body is not."""
    moves = ", ".join("{translate: [1, 0, 0]}" for _ in range(900))
    odd = f"- {{shape: {{Union: [{{Sphere: {{}}, move: [{moves}]}}, {{Sphere: {{radius: 0x1}}}}]}}}}\n"
    check_alike("bodies:\n" + odd * 9, tmp_path)


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
