"""Bodies that are not parsed one by one: the same trees, bodies and mistakes as if they were.

The oracle is the parser without this: trees of it, with every line and column, and scenes and messages made of them.
"""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import conicoid as co
from conicoid._util.files import SceneFileError
from conicoid.io.scene_file import body_patterns, scene_file, yaml_parser
from conicoid.io.scene_file.body_patterns import PatternDocument, PatternItem
from conicoid.io.scene_file.nodes import MappingNode, Node, ScalarNode, SequenceNode
from conicoid.io.scene_file.yaml_parser import YamlError

from ..samples import in_turn, quick, size

RELAXED = settings(max_examples=size(50, 150), deadline=None, suppress_health_check=list(HealthCheck))


def told(node: Node | None) -> Any:
    """All that there is of a tree."""
    if node is None:
        return None
    where = node.line, node.column, node.size
    if isinstance(node, ScalarNode):
        return (*where, node.text, node.plain)
    if isinstance(node, SequenceNode):
        return (*where, [told(item) for item in node.items])
    return (*where, {name: told(value) for name, value in node.entries.items()}, [told(key) for key in node.heads])


def plain_document(text: str) -> Any:
    try:
        return yaml_parser.parse_document(text)
    except YamlError as error:
        return error.problem


def check(text: str) -> int:
    """Compare both ways of parsing; how many bodies were cut out."""
    try:
        found = body_patterns.parse_patterned_document(text)
    except YamlError as error:
        assert plain_document(text) == error.problem
        return 0
    expected = plain_document(text)
    assert found.distinct == expected.distinct
    assert found.problems == expected.problems
    if found.bodies is None:
        assert told(found.root) == told(expected.root)
        return 0
    assert isinstance(found.root, MappingNode)
    assert isinstance(expected.root, MappingNode)
    whole = [item.parsed() if isinstance(item, PatternItem) else item for item in found.bodies]
    assert [told(item) for item in whole] == [told(item) for item in expected.root.entries["bodies"].items]
    assert [told(key) for key in found.root.heads] == [told(key) for key in expected.root.heads]
    for name, value in expected.root.entries.items():
        if name != "bodies":
            assert told(found.root.entries[name]) == told(value)
    return sum(isinstance(item, PatternItem) for item in found.bodies)


def parts(text: str, folder: Any) -> Any:
    try:
        found = scene_file.parse_scene(text, folder / "scene.yaml")
    except SceneFileError as error:
        return error.problems
    return found, repr(found)


def both_ways(text: str, folder: Any) -> Any:
    """What a scene file says, after a comparison with what it says without this."""
    found = parts(text, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            scene_file,
            "parse_patterned_document",
            lambda *given: PatternDocument(**vars(yaml_parser.parse_document(*given))),
        )
        assert parts(text, folder) == found
    return found


BLOCK = """\
  - shape:
      Sphere:
        radius: {0}
        center: [{1}, {2}, {3}]
    material: {4}
"""
FLOW = "  - {{shape: {{Sphere: {{radius: {0}, center: [{1}, {2}, {3}]}}}}, material: {4}}}\n"
NAMED = "  - name: {4}\n    shape: ball\n    move:\n      - {{scale: {0}}}\n      - {{translate: [{1}, {2}, {3}]}}\n"
SHAPES = "shapes:\n  ball: {Sphere: {}}\n"
FORMS = {"block": BLOCK, "flow": FLOW, "named": NAMED}


def scene(form: str, rows: list[tuple[str, ...]], *, after: str = "", before: str = SHAPES) -> str:
    return before + "bodies:\n" + "".join(form.format(*row) for row in rows) + after


def rows(count: int, seed: int = 1) -> list[tuple[str, ...]]:
    draw = random.Random(seed)
    return [(repr(draw.uniform(0.1, 1)), *(repr(draw.uniform(-9, 9)) for _ in "xyz"), f"w{k}") for k in range(count)]


WORDS = [
    "1", "-1", "0", "-0.0", "007", "1.", ".5", "-.5", "0.5e-3", "1e400", "1e99", "1_000", "0o7", "0x1F", ".inf",
    "-.Inf", ".nan", "yes", "no", "null", "~", "true", "False", "1:30", "2001-01-01", "", "'1'", '"1"', "+1", "1 2",
    "1e5 ", "1,5", "[1]", "{a: 1}", "&a 1", "*a", "!!float 1", "12345678901234567", "123456789012345678", "1e", "--1",
    "- 1", "? 1", "a: 1", "a # b", "1 # one", "|\n      x", "> \n      x", "'it''s'", '"a\\n"', "red", "w 1", "w  1 ",
    "w-1", "a.b/c (d)", "é", "a\n      b", "'a\n      b'", "#ff0000", "'#ff0000'", "\t1", "1\t", "a\u2028b", "a\x85b",
]  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_bodies_that_differ_in_words_are_cut_out(form, tmp_path):
    text = scene(FORMS[form], rows(60))
    assert check(text) >= 50
    if form == "named":
        made, _ = both_ways(text, tmp_path)
        assert [body.name for body in made.bodies] == [f"w{k}" for k in range(60)]


@pytest.mark.parametrize(("word", "form"), in_turn(WORDS, FORMS), ids=repr)
def test_any_word_in_any_place(form, word, tmp_path):
    """A word among many that are plain, and a dozen that are no longer plain; in one place also the first and last."""
    for place in range(5) if not quick() else (1, 2, 4):
        for those in ([10], [0], [23], range(5, 17)) if place == 2 else ([10], range(5, 17)):
            listed = rows(24)
            for k in those:
                listed[k] = (*listed[k][:place], word, *listed[k][place + 1 :])
            text = scene(FORMS[form], listed)
            check(text)
            if len(those) > 1 and place in (1, 4):
                both_ways(text, tmp_path)


@RELAXED
@given(
    st.lists(st.tuples(*[st.sampled_from(WORDS)] * 5), min_size=1, max_size=8),
    st.sampled_from(sorted(FORMS)), st.integers(0, 2**32), st.sampled_from(["", "\n", "# end\n", "camera: {}\n", "  - "]),
)  # fmt: skip
def test_random_words(unusual, form, seed, after):
    draw, listed = random.Random(seed), rows(30, seed)
    for row in unusual:
        listed[draw.randrange(30)] = row
    check(scene(FORMS[form], listed, after=after))


@RELAXED
@given(st.integers(0, 2**32), st.sampled_from(sorted(FORMS)), st.text("-[]{}:, \n\t'\"#&*!|>%?abe10.\\\r", max_size=4))
def test_damaged_texts(seed, form, inserted):
    """Letters put in, or some cut out, anywhere."""
    draw, text = random.Random(seed), scene(FORMS[form], rows(30, seed), after="lights: []\n")
    for _ in range(draw.randint(1, 3)):
        at = draw.randrange(len(text))
        text = text[:at] + inserted + text[at + draw.randint(0, 3) :]
    check(text)


@pytest.mark.deep
@settings(max_examples=20_000, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 2**32), st.sampled_from(sorted(FORMS)), st.text("-[]{}:, \n\t'\"#&*!|>%?abe10.\\\r", max_size=4))
def test_damaged_texts_at_length(seed, form, inserted):
    draw, text = random.Random(seed), scene(FORMS[form], rows(30, seed), after="lights: []\n")
    for _ in range(draw.randint(1, 3)):
        at = draw.randrange(len(text))
        text = text[:at] + inserted + text[at + draw.randint(0, 3) :]
    check(text)


def test_lines_that_only_look_like_bodies():
    """The same lines in a block of text, in quotes, in a comment, under another key, and once more behind."""
    many = "".join(FLOW.format(*row) for row in rows(40))
    assert check(f"note: |\n  bodies:\n{many}bodies:\n{many}") >= 30
    assert check(f"--- |\nbodies:\n{many}") == 0
    assert check(f"--- '\nbodies:\n{many}'\n") == 0
    assert check(f"bodies:\n{many}  - name: '\n{many}  '\n{many}") == 0
    assert check(f'bodies:\n{many}  - name: "\n{many}"\n') == 0
    assert check(f"bodies:\n{many}  - note: |\n{many}") >= 30
    assert check(f"bodies: [\n{many}]\n") == 0
    assert check(f"a: {{\nbodies:\n{many}}}\n") == 0
    assert check(f"bodies:\n{many}animation:\n{many}") >= 30
    assert check(f"bodies:\n{many}bodies:\n{many}") >= 30
    assert check(f"a: 1\nbodies: &all\n{many}more: *all\n") == 0
    assert check(f"bodies:\n{many}--- \n{many}") == 0
    assert check(f"bodies:\n{many}...\n") >= 30
    assert check(f"'bodies':\n{many}bodies:\n{many}") == 0
    assert check(f"? bodies\n:\n{many}") == 0
    assert check("%YAML 1.2\n---\nbodies:\n" + many) >= 30


@pytest.mark.parametrize("indent", ["", " ", "  ", "      "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_indents_and_ends_of_lines(indent, end):
    for form in FORMS.values():
        text = scene(form.replace("  -", "-", 1), rows(40), after="domain: ball\n")
        head, items = text.split("bodies:\n")
        items, section = items.split("domain")
        shifted = re.sub(r"^", indent, items, flags=re.MULTILINE).rstrip(" ")
        shifted = re.sub(r"\n" + indent + "    ", "\n" + indent + "  ", shifted)
        check((head + "bodies:\n" + shifted + "domain" + section).replace("\n", end))
    even = "".join(f"{indent}- {{shape: {{Sphere: {{radius: {row[0]}}}}}}}\n" for row in rows(40))
    assert check(f"bodies:\n{even}camera: {{}}\n".replace("\n", end)) >= 30
    assert check(f"bodies:\n# all\n\n{even}".replace("\n", end)) >= 30
    assert check(f"bodies:\n{even}".replace("\n", "\r")) == 0


def test_anchors_among_bodies():
    many = [FLOW.format(*row) for row in rows(40)]
    named = many.copy()
    named[20] = named[20].replace("- {", "- &here {")
    assert check("bodies:\n" + "".join(named)) >= 30
    named[30] = "  - *here\n"  # which stands in another line than its dash
    assert check("bodies:\n" + "".join(named)) == 0
    again = [line.replace("radius: ", "radius: &r ") for line in many]
    assert check("bodies:\n" + "".join(again) + "  - {shape: {Sphere: {radius: *r}}}\n") == 0
    again = [line.replace("Sphere: ", "Sphere: &s ") for line in many]
    assert check("bodies:\n" + "".join(again) + "  - {shape: {Sphere: *s}}\n") == 0


def test_keys_that_are_given_twice():
    twice = "  - {{shape: {{Sphere: {{radius: {0}}}}}, material: {4}, material: red}}\n"
    assert check(scene(twice, rows(40))) == 0
    assert len(body_patterns.parse_patterned_document(scene(twice, rows(40))).problems) == 40


def test_items_below_their_dashes():
    many = [FLOW.format(*row) for row in rows(40)]
    below = "  -\n    shape: {Sphere: {}}\n"
    for place in (0, 1, 20, 39, 40):
        check("bodies:\n" + "".join([*many[:place], below, *many[place:]]))
    assert check("bodies:\n" + "".join(many) + below) == 0


def test_mistakes_are_told_in_their_places(tmp_path):
    listed = rows(60)
    listed[20] = ("-1", *listed[20][1:])
    listed[30] = (*listed[30][:4], "w7")
    listed[40] = ("1e200", *listed[40][1:4], "'null'")
    listed[50] = (*listed[50][:4], "null")
    for form in FORMS.values():
        both_ways(scene(form, listed, before=SHAPES + "materials: {w1: {matte: {}}}\n"), tmp_path)
    problems = both_ways(scene(NAMED, listed), tmp_path)
    first = min(problems)
    assert (first.line, first.message) == (3 + 5 * 30 + 1, "name 'w7' is taken by the body in line 39")


def test_names_that_are_taken_by_bodies_left_in_the_text(tmp_path):
    listed = [(*row[:4], "same") for row in rows(30)]
    assert len(both_ways(scene(NAMED, listed), tmp_path)) == 29


def test_scenes_are_read_alike(tmp_path):
    made = co.Scene([
        thing
        for k in range(1, 40)
        for thing in (
            co.Sphere(k, (k / 7, 0, 1)), co.Box((0, 0, 0), (k, 1, 1)).rotate("x", k),
            (co.Sphere(k) - co.Box() - co.Cylinder((0, 0, -k), (0, 0, k), k / 3)).translate((k, 0, 0)),
            co.Body(co.Ellipsoid((1, 2, k), z_range=(-0.5, k / 50)), "red", f"body {k}"),
        )
    ])  # fmt: skip
    co.save(made, tmp_path / "scene.yaml")
    text = (tmp_path / "scene.yaml").read_text()
    assert check(text) > 100
    both_ways(text, tmp_path)
    assert co.load(tmp_path / "scene.yaml").bodies == made.bodies


def test_limits_hold(monkeypatch):
    text = scene(FLOW, rows(100))
    nodes = yaml_parser.parse_document(text).distinct
    monkeypatch.setattr(yaml_parser, "MAX_NODES", nodes)
    assert check(text) > 90
    monkeypatch.setattr(yaml_parser, "MAX_NODES", nodes - 1)
    with pytest.raises(YamlError, match="more than"):
        body_patterns.parse_patterned_document(text)
    check(text)


def test_progress_rises():
    text, seen = scene(FLOW, rows(9000)), []
    body_patterns.parse_patterned_document(text, seen.append)
    assert seen == sorted(seen)
    assert len(seen) > 2
    assert seen[-1] <= len(text)
