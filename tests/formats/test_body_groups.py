"""Groups and patterns of bodies in scene files."""

import random
import re
import warnings
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import conicoid as co
from conicoid._util.records import pickle_state
from conicoid.io.scene_file import body_patterns, scene_file, scene_file as scene_reader, shape_reader, yaml_parser
from conicoid.io.scene_file.body_patterns import PatternDocument, PatternItem
from conicoid.io.scene_file.nodes import Node, ScalarNode, SequenceNode
from conicoid.io.scene_file.scene_file import parse_scene
from conicoid.io.scene_file.yaml_parser import YamlError

from ..samples import in_turn, quick

# --- Bodies that are built together: the same as if each were read alone, and the same mistakes in the same places. The
# oracle is the reader without groups, which reads one body after the other.

COUNT = 22
SHAPES = """\
materials:
  glossy: {plastic: {color: [0.5, 0.25, 1]}}
shapes:
  ball: {Sphere: {}}
  egg: {Sphere: {radius: 2}, move: [{scale: [1, 2, 0.5]}, {translate: [0, 0, 1]}]}
  block: {Difference: [{Box: {}}, {Sphere: {radius: 0.75}}]}
bodies:
"""
BODIES = {
    "sphere": "{{shape: {{Sphere: {{radius: {0}, center: [{1}, {2}, {3}]}}}}, material: {word}}}",
    "ellipsoid": "{{shape: {{Ellipsoid: {{radii: [{0}, {1}, {2}], z_range: [-0.5, {3}]}}}}}}",
    "moved": "{{name: {name}, shape: block, move: [{{scale: {0}}}, {{translate: [{1}, {2}, {3}]}}]}}",
    "moved again": "{{shape: egg, move: [{{scale: [{0}, 2, {1}]}}, {{rotate: {{axis: z, degrees: {2}}}}}]}}",
    "turned": "{{shape: {{Box: {{}}}}, move: [{{rotate: {{axis: [{0}, {1}, {2}], degrees: {3}}}}}]}}",
    "carried": "{{shape: ball, move: [{{transform: [[{0}, 0, 0, {1}], [0, {2}, 0, {3}], [0, 0, 1, 0], [0, 0, 0, 1]]}}]}}",
    "whole matrix": (
        "{{shape: ball, move: [{{transform: [[{0}, 0.1, 0, 1], [0.2, {1}, 0, 1], [0, 0, 1, 0], [0, 0, {2}, {3}]]}}]}}"
    ),
    "operands": (
        "{{shape: {{Difference: [{{Sphere: {{radius: {0}}}}}, {{Box: {{}}, move: [{{translate: [{1}, 0, {2}]}}]}}]}},"
        " move: [{{scale: {3}}}]}}"
    ),
    "outside": "{{shape: {{Complement: {{Sphere: {{radius: {0}}}, move: [{{scale: {1}}}]}}}}, move: [{{scale: {2}}}]}}",
    "sheet": "{{shape: {{Disc: {{radius: {0}, center: [{1}, {2}, {3}], normal: [0, 0, 1]}}}}, move: [{{scale: 2}}]}}",
    "moved inside": "{{shape: {{shape: ball, move: [{{translate: [{0}, 1, 2]}}]}}, move: [{{scale: {1}}}]}}",
    "cut sheet": "{{shape: {{Difference: [{{Disc: {{radius: {0}}}}}, {{Sphere: {{radius: {1}}}}}]}}}}",
    "the same": "{{shape: {{Sphere: {{radius: 0.5}}}}, name: {name}}}",
    "the same moved": "{{shape: ball, name: {name}, move: [{{translate: [1, 2, 3]}}]}}",
    "shared": "{{shape: ball, name: {name}, material: {word}}}",
    "referred": "{{shape: {word2}, move: [{{translate: [{0}, {1}, {2}]}}]}}",
    "unmoved": "{{shape: {{Sphere: {{radius: {0}}}}}, move: []}}",
    "unknown": "{{shape: {{Sphere: {{radius: {0}, size: 1}}}}}}",
    "integers": "{{shape: {{RegularPrism: {{sides: {0}, radius: {1}}}}}}}",
    "radians": "{{shape: {{Box: {{high: [{0}, 1, 1]}}}}, move: [{{rotate: {{axis: x, degrees: 1.5707963267948966}}}}]}}",
}
NUMBERS = [
    "0", "-0.0", "-1", "1e99", "1e-99", "1e-101", "1e100", "1e400", ".nan", ".inf", "1.5707963267948966", "x", "'1'",
    "[1]", "", "null", "1e50", "1e-50", "12345678901234567",
]  # fmt: skip


def lines(form: str, *, word: str = "red") -> list[str]:
    draw = random.Random(7)
    return [
        "  - " + BODIES[form].format(
            *(repr(draw.uniform(0.5, 3)) for _ in range(4)), name=f"n{k}", word=word, word2=["ball", "egg"][k % 2]
        )
        for k in range(COUNT)
    ]  # fmt: skip


def outcome(text: str) -> Any:
    """Return the content of a file, or its messages; and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            parts: Any = parse_scene(text, Path("scene.yaml"))
        except co.SceneFileError as error:
            return error.problems, [str(one.message) for one in caught]
    shapes = [body.shape for body in parts.bodies]
    same = [next(k for k, shape in enumerate(shapes) if shape is one) for one in shapes]
    fields = [
        (vars(body), type(body.shape), pickle_state(body.shape), body.shape.motion.reach) for body in parts.bodies
    ]
    return parts, repr(fields), same, [str(one.message) for one in caught]


def check(text: str) -> int:
    """Compare both ways; return how many bodies were built together."""
    together = 0

    def counted(*arguments: Any) -> Any:
        nonlocal together
        found = body_patterns.build_groups(*arguments)
        together += len(found)
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene_reader, "build_groups", counted)
        found = outcome(text)
        patch.setattr(scene_reader, "build_groups", lambda *_: {})
        assert outcome(text) == found
    return together


def is_left(form: str) -> bool:
    """Return whether the other reader takes a form of bodies, which holds more than numbers or causes a message."""
    return form in ("cut sheet", "unknown", "integers", "radians", "whole matrix")


@pytest.mark.parametrize("form", BODIES)
def test_bodies_are_made_together(form):
    together = check(SHAPES + "\n".join(lines(form)))
    assert (together == 0) == is_left(form)
    assert is_left(form) or together >= COUNT - 5  # those by which the pattern was learnt


def check_number(form: str, place: int, number: str) -> None:
    for those in ([5, 12], range(COUNT)) if place == 1 else ([5, 12],):
        listed = lines(form)
        for k in those:
            draw = random.Random(k)
            row = [repr(draw.uniform(0.5, 3)) for _ in range(4)]
            row[place] = number
            listed[k] = "  - " + BODIES[form].format(*row, name=f"n{k}", word="red", word2="egg")
        check(SHAPES + "\n".join(listed))


@pytest.mark.parametrize(("number", "form"), in_turn(NUMBERS, BODIES))
def test_any_number_in_any_place(form, number):
    """A fast run tries one place. Columns of templates with such numbers are in test_template.py."""
    for place in [(NUMBERS.index(number) + len(form)) % 4] if quick() else range(4):
        check_number(form, place, number)


@pytest.mark.parametrize("those", [[12], [5, 6, 17], range(COUNT)])
@pytest.mark.parametrize("word", ["glossy", "no colour", "'#ff0000'", "null", "true", "5", "''", "'5'", "ball"])
@pytest.mark.parametrize("form", ["sphere", "shared", "moved", "the same"])
def test_any_word(form, word, those):
    listed = lines(form)
    for k in those:
        listed[k] = lines(form, word=word)[k].replace(f"n{k}", word)
    check(SHAPES + "\n".join(listed))


def test_names_that_are_taken():
    listed = lines("moved")
    listed[16] = listed[16].replace("n16", "n9")
    assert check(SHAPES + "\n".join([*listed, *lines("shared")]))
    block = "  - shape: ball\n    name: n{0}\n    move:\n      - {{scale: {1}}}"
    listed = [block.format(k % 17, 1 + k / 64) for k in range(COUNT)]
    assert check(SHAPES + "\n".join(listed))


@pytest.mark.parametrize(
    ("form", "none"), [("turned", ["0", "0", "-0.0", "5"]), ("moved again", ["0.0", "0", "30", "1"])]
)
def test_axes_and_matrices_that_vanish(form, none):
    """Zeros stand in all places of a vector, where each number alone may be zero."""
    listed = lines(form)
    for k in (4, 12, 21):
        listed[k] = "  - " + BODIES[form].format(*none)
    assert check(SHAPES + "\n".join(listed))


def test_motions_that_leave_the_domain():
    """Each step is within the domain, and some products are not."""
    form = "{{shape: ball, move: [{{scale: {0}}}, {{scale: {1}}}, {{translate: [{2}, 0, 0]}}, {{scale: {3}}}]}}"
    large = SHAPES.replace(
        "egg: {Sphere: {radius: 2},", "egg: {Sphere: {radius: 2}, move: [{scale: 1e60}]}\n  other: {Sphere: {},"
    )
    assert large != SHAPES
    listed = [f"  - {{shape: egg, move: [{{scale: {1e20 if k in (7, 12) else 1 + k / 64!r}}}]}}" for k in range(COUNT)]
    listed[19] = "  - {shape: egg, move: [{scale: 1e60}]}"
    assert check(large + "\n".join(listed))
    for odd in (("1e60", "1e60", "1", "1"), ("1e-60", "1e-60", "1", "1"), ("1e60", "1e-60", "1e60", "1e60"),
                ("1e99", "1", "1", "1"), ("1e99", "9.99999", "1", "1"), ("1e60", "1e-60", "1", "1")):  # fmt: skip
        listed = ["  - " + form.format(repr(0.5 + k / 64), "2", repr(1 + k / 8), "3") for k in range(COUNT)]
        for k in (3, 11, 12, 17):
            listed[k] = "  - " + form.format(*odd)
        check(SHAPES + "\n".join(listed))


def test_limits_of_expansion_are_the_same_for_all_groups():
    """Parts and steps of all bodies count, up to the body with too many."""
    deep = ", ".join(["{Sphere: {}}"] * 400)
    steps = ", ".join(["{translate: [1, 0, 0]}"] * 300)
    shapes = f"shapes:\n  many: {{Union: [{deep}]}}\n  far: {{shape: many, move: [{steps}]}}\nbodies:\n"
    for name in ("many", "far"):
        bodies = [f"  - {{shape: {name}, move: [{{scale: {1 + k / 64!r}}}]}}" for k in range(200)]
        assert check(shapes + "\n".join(bodies))


def test_each_alias_of_a_body_counts(tmp_path, monkeypatch):
    text = "bodies: [&b {shape: {Union: [{Sphere: {}}, {Box: {}}]}}" + ", *b" * 14 + "]"
    monkeypatch.setattr(shape_reader, "PARTS_PER_VALUE", 0)
    monkeypatch.setattr(shape_reader, "FREE_PARTS", 15 * 4)
    assert len(parse_scene(text, tmp_path / "scene.yaml").bodies) == 15
    with pytest.raises(co.SceneFileError, match="too much for its length"):
        parse_scene(text.replace("]}}", "]}}, *b"), tmp_path / "scene.yaml")


# --- Bodies that are not parsed one by one: the same trees, bodies and mistakes as if they were. The oracle is the
# parser without patterns: its trees, with every line and column, and the scenes and messages from them.

RELAXED = settings(max_examples=50, deadline=None, suppress_health_check=list(HealthCheck))


def message(node: Node | None) -> Any:
    """Return the whole content of a tree."""
    if node is None:
        return None
    where = node.line, node.column, node.size
    if isinstance(node, ScalarNode):
        return (*where, node.text, node.plain)
    if isinstance(node, SequenceNode):
        return (*where, [message(item) for item in node.items])
    return (
        *where,
        {name: message(value) for name, value in node.entries.items()},
        [message(key) for key in node.heads],
    )


def plain_document(text: str) -> Any:
    try:
        return yaml_parser.parse_document(text)
    except YamlError as error:
        return error.problem


def check_pattern(text: str) -> int:
    """Compare both ways of parsing; return how many bodies were cut out."""
    try:
        found = body_patterns.parse_patterned_document(text)
    except YamlError as error:
        assert plain_document(text) == error.problem
        return 0
    expected = plain_document(text)
    assert found.distinct == expected.distinct
    assert found.problems == expected.problems
    if found.bodies is None:
        assert message(found.root) == message(expected.root)
        return 0
    whole = [item.parsed() if isinstance(item, PatternItem) else item for item in found.bodies]
    assert [message(item) for item in whole] == [message(item) for item in expected.root.entries["bodies"].items]
    assert [message(key) for key in found.root.heads] == [message(key) for key in expected.root.heads]
    for name, value in expected.root.entries.items():
        if name != "bodies":
            assert message(found.root.entries[name]) == message(value)
    return sum(isinstance(item, PatternItem) for item in found.bodies)


def parts(text: str, folder: Any) -> Any:
    try:
        found = scene_file.parse_scene(text, folder / "scene.yaml")
    except co.SceneFileError as error:
        return error.problems
    return found, repr(found)


def both_ways(text: str, folder: Any) -> Any:
    """Return the scene or message of a file, after a comparison with the other way."""
    found = parts(text, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            scene_file,
            "parse_patterned_document",
            lambda *arguments: PatternDocument(**vars(yaml_parser.parse_document(*arguments))),
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
PATTERN_SHAPES = "shapes:\n  ball: {Sphere: {}}\n"
FORMS = {"block": BLOCK, "flow": FLOW, "named": NAMED}


def scene(form: str, rows: list[tuple[str, ...]], *, after: str = "", before: str = PATTERN_SHAPES) -> str:
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
    assert check_pattern(text) >= 50
    if form == "named":
        count, _ = both_ways(text, tmp_path)
        assert [body.name for body in count.bodies] == [f"w{k}" for k in range(60)]


@pytest.mark.parametrize(("word", "form"), in_turn(WORDS, FORMS), ids=repr)
def test_any_word_in_any_place(form, word, tmp_path):
    """The word stands among many plain ones and a dozen that are no longer plain, in one place first and last."""
    for place in range(5) if not quick() else (1, 2, 4):
        for those in ([10], [0], [23], range(5, 17)) if place == 2 else ([10], range(5, 17)):
            listed = rows(24)
            for k in those:
                listed[k] = (*listed[k][:place], word, *listed[k][place + 1 :])
            text = scene(FORMS[form], listed)
            check_pattern(text)
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
    check_pattern(scene(FORMS[form], listed, after=after))


@RELAXED
@given(st.integers(0, 2**32), st.sampled_from(sorted(FORMS)), st.text("-[]{}:, \n\t'\"#&*!|>%?abe10.\\\r", max_size=4))
def test_damaged_texts(seed, form, inserted):
    """Letters are inserted or cut out anywhere."""
    draw, text = random.Random(seed), scene(FORMS[form], rows(30, seed), after="lights: []\n")
    for _ in range(draw.randint(1, 3)):
        at = draw.randrange(len(text))
        text = text[:at] + inserted + text[at + draw.randint(0, 3) :]
    check_pattern(text)


MANY = "".join(FLOW.format(*row) for row in rows(40))
LOOKS = [  # lines in a block of text, in quotes, in a comment, under another key, once more behind; are bodies cut out?
    (f"note: |\n  bodies:\n{MANY}bodies:\n{MANY}", True),
    (f"--- |\nbodies:\n{MANY}", False),
    (f"--- '\nbodies:\n{MANY}'\n", False),
    (f"bodies:\n{MANY}  - name: '\n{MANY}  '\n{MANY}", False),
    (f'bodies:\n{MANY}  - name: "\n{MANY}"\n', False),
    (f"bodies:\n{MANY}  - note: |\n{MANY}", True),
    (f"bodies: [\n{MANY}]\n", False),
    (f"a: {{\nbodies:\n{MANY}}}\n", False),
    (f"bodies:\n{MANY}animation:\n{MANY}", True),
    (f"bodies:\n{MANY}bodies:\n{MANY}", True),
    (f"a: 1\nbodies: &all\n{MANY}more: *all\n", False),
    (f"bodies:\n{MANY}--- \n{MANY}", False),
    (f"bodies:\n{MANY}...\n", True),
    (f"'bodies':\n{MANY}bodies:\n{MANY}", False),
    (f"? bodies\n:\n{MANY}", False),
    ("%YAML 1.2\n---\nbodies:\n" + MANY, True),
]


@pytest.mark.parametrize(("text", "are_cut"), LOOKS)
def test_lines_that_only_look_like_bodies(text, are_cut):
    count = check_pattern(text)
    assert count >= 30 if are_cut else count == 0


@pytest.mark.parametrize("indent", ["", " ", "  ", "      "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_indents_and_ends_of_lines(indent, end):
    for form in FORMS.values():
        text = scene(form.replace("  -", "-", 1), rows(40), after="domain: ball\n")
        head, items = text.split("bodies:\n")
        items, section = items.split("domain")
        shifted = re.sub(r"^", indent, items, flags=re.MULTILINE).rstrip(" ")
        shifted = re.sub(r"\n" + indent + "    ", "\n" + indent + "  ", shifted)
        check_pattern((head + "bodies:\n" + shifted + "domain" + section).replace("\n", end))
    even = "".join(f"{indent}- {{shape: {{Sphere: {{radius: {row[0]}}}}}}}\n" for row in rows(40))
    assert check_pattern(f"bodies:\n{even}camera: {{}}\n".replace("\n", end)) >= 30
    assert check_pattern(f"bodies:\n# all\n\n{even}".replace("\n", end)) >= 30
    assert check_pattern(f"bodies:\n{even}".replace("\n", "\r")) == 0


def test_anchors_among_bodies():
    many = [FLOW.format(*row) for row in rows(40)]
    named = many.copy()
    named[20] = named[20].replace("- {", "- &here {")
    assert check_pattern("bodies:\n" + "".join(named)) >= 30
    named[30] = "  - *here\n"  # which stands in another line than its dash
    assert check_pattern("bodies:\n" + "".join(named)) == 0
    again = [line.replace("radius: ", "radius: &r ") for line in many]
    assert check_pattern("bodies:\n" + "".join(again) + "  - {shape: {Sphere: {radius: *r}}}\n") == 0
    again = [line.replace("Sphere: ", "Sphere: &s ") for line in many]
    assert check_pattern("bodies:\n" + "".join(again) + "  - {shape: {Sphere: *s}}\n") == 0


def test_keys_that_are_given_twice():
    twice = "  - {{shape: {{Sphere: {{radius: {0}}}}}, material: {4}, material: red}}\n"
    assert check_pattern(scene(twice, rows(40))) == 0
    assert len(body_patterns.parse_patterned_document(scene(twice, rows(40))).problems) == 40


def test_items_below_their_dashes():
    many = [FLOW.format(*row) for row in rows(40)]
    below = "  -\n    shape: {Sphere: {}}\n"
    for place in (0, 1, 20, 39, 40):
        check_pattern("bodies:\n" + "".join([*many[:place], below, *many[place:]]))
    assert check_pattern("bodies:\n" + "".join(many) + below) == 0


def test_mistakes_are_reported_with_their_places(tmp_path):
    listed = rows(60)
    listed[20] = ("-1", *listed[20][1:])
    listed[30] = (*listed[30][:4], "w7")
    listed[40] = ("1e200", *listed[40][1:4], "'null'")
    listed[50] = (*listed[50][:4], "null")
    for form in FORMS.values():
        both_ways(scene(form, listed, before=PATTERN_SHAPES + "materials: {w1: {matte: {}}}\n"), tmp_path)
    problems = both_ways(scene(NAMED, listed), tmp_path)
    first = min(problems)
    assert (first.line, first.message) == (3 + 5 * 30 + 1, "name 'w7' is taken by the body in line 39")


def test_names_that_are_taken_by_bodies_left_in_the_text(tmp_path):
    listed = [(*row[:4], "same") for row in rows(30)]
    assert len(both_ways(scene(NAMED, listed), tmp_path)) == 29


def test_scenes_are_read_alike(tmp_path):
    scene = co.Scene([
        value
        for k in range(1, 40)
        for value in (
            co.Sphere(k, (k / 7, 0, 1)), co.Box((0, 0, 0), (k, 1, 1)).rotate("x", k),
            (co.Sphere(k) - co.Box() - co.Cylinder((0, 0, -k), (0, 0, k), k / 3)).translate((k, 0, 0)),
            co.Body(co.Ellipsoid((1, 2, k), z_range=(-0.5, k / 50)), "red", f"body {k}"),
        )
    ])  # fmt: skip
    co.save(scene, tmp_path / "scene.yaml")
    text = (tmp_path / "scene.yaml").read_text()
    assert check_pattern(text) > 100
    both_ways(text, tmp_path)
    assert co.load(tmp_path / "scene.yaml").bodies == scene.bodies


def test_limits_hold(monkeypatch):
    text = scene(FLOW, rows(100))
    nodes = yaml_parser.parse_document(text).distinct
    monkeypatch.setattr(yaml_parser, "MAX_NODES", nodes)
    assert check_pattern(text) > 90
    monkeypatch.setattr(yaml_parser, "MAX_NODES", nodes - 1)
    with pytest.raises(YamlError, match="more than"):
        body_patterns.parse_patterned_document(text)
    check_pattern(text)


def test_progress_rises():
    text, steps = scene(FLOW, rows(9000)), []
    body_patterns.parse_patterned_document(text, steps.append)
    assert steps == sorted(steps)
    assert len(steps) > 2
    assert steps[-1] <= len(text)
