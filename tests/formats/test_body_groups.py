"""Bodies that are made together: the same as if each were read alone, and the same mistakes in the same places.

The oracle is the reader without this, which reads one body after the other.
"""

from __future__ import annotations

import random
import warnings
from pathlib import Path
from typing import Any

import pytest

from conicoid._util.files import SceneFileError
from conicoid._util.value_objects import pickle_state
from conicoid.io.scene_file import body_patterns, scene_file as scene_reader, shape_reader
from conicoid.io.scene_file.scene_file import parse_scene

from ..samples import in_turn

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
    """Return what a file holds, or its messages; and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            parts: Any = parse_scene(text, Path("scene.yaml"))
        except SceneFileError as error:
            return error.problems, [str(one.message) for one in caught]
    shapes = [body.shape for body in parts.bodies]
    same = [next(k for k, shape in enumerate(shapes) if shape is one) for one in shapes]
    fields = [
        (vars(body), type(body.shape), pickle_state(body.shape), body.shape.motion.reach) for body in parts.bodies
    ]
    return parts, repr(fields), same, [str(one.message) for one in caught]


def check(text: str) -> int:
    """Compare both ways; how many bodies were made together."""
    together = 0

    def counted(*given: Any) -> Any:
        nonlocal together
        found = body_patterns.build_groups(*given)
        together += len(found)
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene_reader, "build_groups", counted)
        found = outcome(text)
        patch.setattr(scene_reader, "build_groups", lambda *_: {})
        assert outcome(text) == found
    return together


def is_left(form: str) -> bool:
    """Is a form of bodies left to the other reader, as more than numbers are in it or there is something to say?"""
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
def test_any_number_in_some_place(form, number):
    """Rows of columns have such numbers in test_template.py."""
    check_number(form, (NUMBERS.index(number) + len(form)) % 4, number)


@pytest.mark.deep
@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("form", BODIES)
def test_any_number_in_any_place(form, number):
    for place in range(4):
        check_number(form, place, number)


@pytest.mark.parametrize("word", ["glossy", "no colour", "'#ff0000'", "null", "true", "5", "''", "'5'", "ball"])
@pytest.mark.parametrize("form", ["sphere", "shared", "moved", "the same"])
def test_any_word(form, word):
    for those in ([12], [5, 6, 17], range(COUNT)):
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


def test_axes_and_matrices_that_vanish():
    """Zeros in all places of a vector, where each number alone may be zero."""
    for form, none in (("turned", ["0", "0", "-0.0", "5"]), ("moved again", ["0.0", "0", "30", "1"])):
        listed = lines(form)
        for k in (4, 12, 21):
            listed[k] = "  - " + BODIES[form].format(*none)
        assert check(SHAPES + "\n".join(listed))


def test_motions_that_leave_the_domain():
    """Each step is within it, and so are some products."""
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


def test_what_a_file_may_grow_to_is_counted_alike():
    """Parts and steps of all bodies, up to the body where there are too many."""
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
    with pytest.raises(SceneFileError, match="too much for its length"):
        parse_scene(text.replace("]}}", "]}}, *b"), tmp_path / "scene.yaml")
