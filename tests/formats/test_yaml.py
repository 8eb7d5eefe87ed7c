"""YAML: its readers against PyYAML, and the tree with its lines."""

import gc
import math

import pytest
import yaml
from hypothesis import given, strategies as st

import conicoid as co
from conicoid.io.scene_file.nodes import (
    MappingNode,
    Node,
    ScalarNode,
    SequenceNode,
    is_null,
    is_text,
    parse_bool,
    parse_float,
    parse_int,
)
from conicoid.io.scene_file.writer import dump_yaml, format_scalar, format_text
from conicoid.io.scene_file.yaml_parser import YamlError, parse_document

from ..interruptions import Interruption
from .fuzzing.scene_cases import sources

# --- The meaning of words (YAML 1.2, section 10.3.2, with its own examples), and how they are written


def plain(text: str) -> ScalarNode:
    return ScalarNode(1, 1, text, plain=True)


@pytest.mark.parametrize(
    ("text", "value"),
    [("0", 0.0), ("-0", -0.0), ("3", 3.0), ("-19", -19.0), ("0o7", 7.0), ("0x3A", 58.0), ("0.", 0.0), ("-0.0", -0.0),
     (".5", 0.5), ("+12e03", 12000.0), ("-2E+05", -200000.0), ("1e-9", 1e-9), ("1e16", 1e16), (".inf", math.inf),
     ("-.Inf", -math.inf), ("+.INF", math.inf), ("007", 7.0), ("5e-324", 5e-324)],
)  # fmt: skip
def test_numbers(text, value):
    found = parse_float(plain(text))
    assert found == value
    assert math.copysign(1, found) == math.copysign(1, value)
    assert not is_text(plain(text))


@pytest.mark.parametrize("text", [".nan", ".NaN", ".NAN"])
def test_nan(text):
    assert math.isnan(parse_float(plain(text)))


@pytest.mark.parametrize(
    "text", ["no", "yes", "on", "off", "y", "n", "1_000", "1,5", "0b11", "1:30", "2001-01-01", "inf", "nan", "1e", "e5", "--1", "0xG", "TrUE", "nUll", "<<", "="]
)  # fmt: skip
def test_texts(text):
    assert is_text(plain(text))
    assert parse_float(plain(text)) is None
    assert parse_bool(plain(text)) is None


@pytest.mark.parametrize("text", ["null", "Null", "NULL", "~", ""])
def test_null(text):
    assert is_null(plain(text))
    assert not is_null(ScalarNode(1, 1, text, plain=False))


@pytest.mark.parametrize(
    ("text", "value"),
    [("true", True), ("True", True), ("TRUE", True), ("false", False), ("False", False), ("FALSE", False)],
)
def test_truth(text, value):
    assert parse_bool(plain(text)) is value
    assert parse_bool(ScalarNode(1, 1, text, plain=False)) is None


@pytest.mark.parametrize("text", ["1e400", "-1e400", "1e-400", "9" * 400, "0x" + "f" * 300])
def test_numbers_beyond_float64_are_not_bent(text):
    with pytest.raises(OverflowError):
        parse_float(plain(text))


@pytest.mark.parametrize(("text", "value"), [
    ("5", 5), ("+5", 5), ("-5", -5), ("0x10", 16), ("0o10", 8), *((text, None) for text in ("5.0", "1e3", "five", "9" * 30)),
])  # fmt: skip
def test_integers(text, value):
    assert parse_int(plain(text)) == value


@given(st.floats(allow_nan=False))
def test_written_floats_read_back_to_the_bit(value):
    text = format_scalar(value)
    again = parse_float(plain(text))
    assert again == value
    assert math.copysign(1, again) == math.copysign(1, value)


@given(st.floats(allow_nan=False))
def test_other_readers_agree_on_floats(value):
    """PyYAML itself reads YAML 1.1."""
    assert yaml.safe_load(f"a: {format_scalar(value)}\n")["a"] == value


@given(st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=30))
def test_written_texts_read_back(text):
    root = parse_document(f"a: {format_text(text)}\n{format_text(text)}: [{format_text(text)}]\n").root
    if text == "a":
        return
    assert root.entries["a"].text == text
    assert is_text(root.entries["a"])
    assert root.entries[text].items[0].text == text


@given(st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=30))
def test_other_readers_agree_on_texts(text):
    assert yaml.safe_load(f"a: {format_text(text)}\n") == {"a": text}


def test_long_things_take_several_lines():
    data = {
        "conicoid": 1,
        "bodies": [{"name": "a", "shape": {"Union": [{"Sphere": {"radius": float(i)}} for i in range(20)]}}],
    }
    text = dump_yaml(data)
    assert max(len(line) for line in text.splitlines()) <= 120
    assert yaml.safe_load(text) == data


def test_json_is_read():
    root = parse_document('{\n\t"a": [1, -2.5e3, true, null, "\\u00e9\\ud83d\\ude00\\/"]\n}').root
    items = root.entries["a"].items
    assert [parse_float(items[0]), parse_float(items[1]), parse_bool(items[2]), is_null(items[3])] == [
        1,
        -2500,
        True,
        True,
    ]
    assert items[4].text == "é😀/"


def test_a_backslash_before_an_escape_stays():
    root = parse_document(r'{"a": "\\ud83d\\ude00"}').root
    assert root.entries["a"].text == r"\ud83d\ude00"


def test_comments_and_directives_before_the_document():
    root = parse_document("# hello\n%YAML 1.2\n---\na: |\n  %x\n").root
    assert isinstance(root, MappingNode)
    with pytest.raises(YamlError, match="directive"):
        parse_document("%FOO bar\n---\na: 1\n")


# --- The tree of a scene file: lines, columns, counts and repeated keys; and reading as a whole, with its progress

# The tree


def same_places(node: Node, other: yaml.Node) -> None:
    """Compare with the tree of PyYAML's own composer, which also knows places."""
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
        document = parse_document(text)
        root, problems = document.root, document.problems
        assert problems == []
        same_places(root, yaml.compose(text, Loader=yaml.CSafeLoader))


def values_of(root: Node) -> int:
    """Return the number of values in a tree, keys among them, without aliases."""
    nodes: dict[int, Node] = {}
    pending = [root]
    while pending:
        node = pending.pop()
        if id(node) not in nodes:
            nodes[id(node)] = node
            pending += node.items if isinstance(node, SequenceNode) else []
            pending += [*node.heads, *node.entries.values()] if isinstance(node, MappingNode) else []
    return len(nodes)


def test_values_are_counted_once():
    for text in sources()[0]:
        found = parse_document(text)
        assert found.distinct == values_of(found.root)


def test_repeated_keys_know_the_first_one_of_their_own_mapping():
    """The reader drops the values of repeated keys, here mappings, so that mappings come and go before."""
    gone = "".join(f"a: {{x{k}: 1, x{k}: 2}}\n" for k in range(50))
    problems = parse_document(f"a: 1\n{gone}b:\n  c: 1\n  d: 2\n  c: 3\n  e: 4\n  e: 5\n").problems
    first = [problem.message.rpartition(" ")[2] for problem in problems]
    assert first[-2:] == ["53)", "56)"]
    assert sum(message == "1)" for message in first) == 50


def test_aliases_may_add_less_than_a_file_may_hold():
    text = "a: &a [" + "1, " * 1000 + "]\nb: [" + "*a, " * 999 + "]\n"
    with pytest.raises(YamlError, match="more than 1,000,000 values, aliases expanded"):
        parse_document(text.replace("*a, ", "*a, " * 2))
    assert parse_document(text).distinct == 1005


@pytest.mark.deep
def test_a_hundred_thousand_bodies(tmp_path):
    body = "- {name: body %d, shape: {Sphere: {radius: 2, center: [%d, 2, 3]}}, material: red}\n"
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "".join(body % (k, k) for k in range(100_000)))
    scene = co.load(tmp_path / "scene.yaml")
    assert len(scene.bodies) == 100_000
    assert scene["body 99999"].shape == co.Sphere(2, (99_999, 2, 3))


# Around the tree: the garbage collector, and progress


def test_the_collector_is_as_it_was(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Sphere: {}}}]\n")
    (tmp_path / "wrong.yaml").write_text("bodies: [{shape: {Sphere: 1}}]\n")
    during = []
    for on in (True, False):
        (gc.enable if on else gc.disable)()
        try:
            co.load(tmp_path / "scene.yaml", progress=lambda *_: during.append(gc.isenabled()))
            assert gc.isenabled() == on
            with pytest.raises(co.SceneFileError):
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
    with pytest.raises(KeyboardInterrupt):
        co.load(tmp_path / "scene.yaml", progress=Interruption())
    assert gc.isenabled()
