"""The grammar of regions, against Python's own operators of the same precedence, and its mistakes."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, strategies as st

from conicoid.io.openmc.region import (
    MAX_PARENTHESES,
    HalfSpaceNode,
    IntersectionNode,
    Region,
    UnionNode,
    list_half_spaces,
    parse_region,
)

from .evaluator import evaluate_region

SURFACES = (1, 2, 3)


def value(region: Region, negative: dict[int, bool]) -> bool:
    if isinstance(region, HalfSpaceNode):
        return negative[region.surface] != region.positive
    return (all if isinstance(region, IntersectionNode) else any)(value(part, negative) for part in region.parts)


def table(text: str) -> list[bool]:
    """What a region says for every combination of sides."""
    region = parse_region(text)
    return [
        value(region, dict(zip(SURFACES, sides, strict=True))) for sides in itertools.product([True, False], repeat=3)
    ]


def expected(text: str) -> list[bool]:
    rows = []
    for sides in itertools.product([True, False], repeat=3):
        # -2 and -1 are ~1 and ~0: truth in the lowest bit
        bits = {surface: int(side) for surface, side in zip(SURFACES, sides, strict=True)}
        rows.append(bool(evaluate_region(text, bits.__getitem__) & 1))
    return rows


SAME = {
    "1": "+1",
    "1 2": "1 & 2",
    "1 2 | 3": "(1 2) | 3",
    "1 | 2 3": "1 | (2 3)",
    "1 | 2 & 3": "1 | (2 & 3)",
    "~1 2": "(~1) 2",
    "~1 | 2": "(~1) | 2",
    "~(1 2)": "-1 | -2",
    "~(1 | -2)": "-1 2",
    "~~1": "1",
    "~(~1 ~(2 | -3))": "1 | 2 | -3",
    "1-2": "1 & -2",
    "1(2|3)": "1 & (2 | 3)",
    "(1)(2)": "1 2",
    "\t(1\n|2) -3 ": "(1 | 2) & -3",
    "-1|~2": "-1 | -2",
    "((((1))))": "1",
}


@pytest.mark.parametrize(("left", "right"), SAME.items())
def test_these_mean_the_same(left: str, right: str) -> None:
    assert table(left) == table(right) == expected(left) == expected(right)


texts = st.recursive(
    st.sampled_from(["1", "-1", "+2", "-2", "3", "-3"]),
    lambda inner: st.one_of(
        st.builds("({})".format, inner),
        st.builds("~({})".format, inner),
        st.builds("{} {}".format, inner, inner),
        st.builds("{} & {}".format, inner, inner),
        st.builds("{}|{}".format, inner, inner),
    ),
    max_leaves=20,
)


@given(texts)
def test_any_region_means_what_the_precedence_says(text: str) -> None:
    assert table(text) == expected(text)


@given(texts)
def test_no_complement_is_left_and_kinds_alternate(text: str) -> None:
    def check(region: Region) -> None:
        if not isinstance(region, HalfSpaceNode):
            assert len(region.parts) > 1
            for part in region.parts:
                assert type(part) is not type(region)
                check(part)

    check(parse_region(text))


def test_signs_and_numbers() -> None:
    assert list(list_half_spaces(parse_region("-12 (7 | +5) ~-3"))) == [
        HalfSpaceNode(12, False),
        HalfSpaceNode(7, True),
        HalfSpaceNode(5, True),
        HalfSpaceNode(3, True),
    ]
    assert parse_region("1 2 | 3 -4") == UnionNode(
        (
            IntersectionNode((HalfSpaceNode(1, True), HalfSpaceNode(2, True))),
            IntersectionNode((HalfSpaceNode(3, True), HalfSpaceNode(4, False))),
        )
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 |", "a surface, '~' or '(' must stand here (after '1 |')"),
        ("| 1", "a surface, '~' or '(' must stand here (after '|')"),
        ("1 & & 2", "a surface, '~' or '(' must stand here (after '1 & &')"),
        ("~", "a surface, '~' or '(' must stand here (after '~')"),
        ("()", "a surface, '~' or '(' must stand here (after '()')"),
        ("(1 2", "a ')' is missing (after '(1 2')"),
        ("1 2)", "a ')' without its '(' (after '1 2)')"),
        ("1 + 2", "'+ 2' is no half-space, '~', '&', '|' or parenthesis (after '1')"),
        ("1.5", "'.5' is no half-space"),
        ("a", "'a' is no half-space, '~', '&', '|' or parenthesis (at the beginning)"),
        ("1 # 2", "'# 2' is no half-space"),
        ("9" * 40, "is no half-space"),
    ],
)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(ValueError, match="region: ") as caught:
        parse_region(text)
    assert message in str(caught.value)


def test_depth_is_limited_and_length_is_not() -> None:
    deep = "(" * (MAX_PARENTHESES + 1) + "1" + ")" * (MAX_PARENTHESES + 1)
    with pytest.raises(ValueError, match=f"deeper than {MAX_PARENTHESES} levels"):
        parse_region(deep)
    with pytest.raises(ValueError, match="deeper than"):
        parse_region("(" * 100_000)
    assert parse_region("~" * 100_001 + "1") == HalfSpaceNode(1, False)
    assert len(list(list_half_spaces(parse_region("1 -2 | " * 50_000 + "3")))) == 100_001
