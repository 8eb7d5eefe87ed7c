"""Seed 001: caps by sorting the hits on body (b1 < b2) and cap planes (c1 < c2): six cases and the special ones.

The cylinder x² + z² <= 1, 0 <= y <= 1 in the plane z = 0: body at x = ±1, caps at y = 0 and 1. A ray
from (x, y) along (u, v) has b = (∓1 - x) / u and c = (0 - y) / v, (1 - y) / v.
"""

from __future__ import annotations

import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

CYLINDER = co.Cylinder((0, 0, 0), (0, 1, 0), 1)
BODY, LOW_CAP, HIGH_CAP = 0, 1, 2
NORMALS = {LOW_CAP: (0, -1, 0), HIGH_CAP: (0, 1, 0)}

# origin, direction, (c1, c2), (b1, b2), expected (enter, face), (exit, face)
GENERAL = {
    "1: c1 c2 b1 b2, miss": ((-4, -1), (1, 1), (1, 2), (3, 5), None),
    "2: c1 b1 c2 b2, body then cap": ((-2.5, -1), (1, 1), (1, 2), (1.5, 3.5), ((1.5, BODY), (2, HIGH_CAP))),
    "3: c1 b1 b2 c2, body then body": ((-3, -0.25), (4, 1), (0.25, 1.25), (0.5, 1), ((0.5, BODY), (1, BODY))),
    "4: b1 c1 b2 c2, cap then body": ((-2, -2.5), (1, 1), (2.5, 3.5), (1, 3), ((2.5, LOW_CAP), (3, BODY))),
    "5: b1 c1 c2 b2, cap then cap": ((-1.5, -1), (1, 1), (1, 2), (0.5, 2.5), ((1, LOW_CAP), (2, HIGH_CAP))),
    "6: b1 b2 c1 c2, miss": ((-2, -4), (1, 1), (4, 5), (1, 3), None),
}


@pytest.mark.parametrize("case", GENERAL)
def test_general_cases(case):
    (x, y), (u, v), caps, body, expected = GENERAL[case]
    assert (-y / v, (1 - y) / v) == caps
    assert ((-1 - x) / u, (1 - x) / u) == body
    found = spans(CYLINDER, (x, y, 0), (u, v, 0))
    if expected is None:
        assert found == []
        return
    (enter, enter_face), (leave, leave_face) = expected
    assert flat(found) == pytest.approx([enter, leave], **CLOSE)
    hit = first(CYLINDER, (x, y, 0), (u, v, 0))
    assert (hit.t, hit.face, hit.entering) == (pytest.approx(enter, **CLOSE), enter_face, True)
    assert hit.normal == pytest.approx(NORMALS.get(enter_face, (-1, 0, 0)), **CLOSE)
    middle = (enter + leave) / 2
    hit = first(CYLINDER, (x + u * middle, y + v * middle, 0), (u, v, 0))
    assert (hit.face, hit.entering) == (leave_face, False)
    assert hit.normal == pytest.approx(NORMALS.get(leave_face, (1, 0, 0)), **CLOSE)


@pytest.mark.parametrize("case", GENERAL)
def test_the_same_reversed_and_upside_down(case):
    (x, y), (u, v), _, _, expected = GENERAL[case]
    t = [] if expected is None else [expected[0][0], expected[1][0]]
    assert flat(spans(CYLINDER, (x, y, 0), (-u, -v, 0))) == pytest.approx([-s for s in reversed(t)], **CLOSE)
    assert flat(spans(CYLINDER, (x, 1 - y, 0), (u, -v, 0))) == pytest.approx(t, **CLOSE)


SPECIAL = {
    "tangent to the body": ((-3, 0.5, 1), (1, 0, 0), []),
    "tangent to the body, oblique": ((-3, -0.25, 1), (4, 1, 0), []),
    "parallel to the caps, between them": ((-3, 0.5, 0), (1, 0, 0), [2, 4]),
    "parallel to the caps, chord at z = 0.6": ((-3, 0.25, 0.6), (1, 0, 0), [2.2, 3.8]),
    "parallel to the caps, above": ((-3, 1.5, 0), (1, 0, 0), []),
    "missing the body": ((-3, 0.5, 2), (1, 0, 0), []),
    "missing, oblique": ((-3, -1, 1.5), (1, 1, 0), []),
    "parallel to the axis, inside": ((0.5, -2, 0.5), (0, 1, 0), [2, 3]),
    "parallel to the axis, outside": ((1, -2, 1), (0, 1, 0), []),
    "along a ruling: no crossing": ((1, -2, 0), (0, 1, 0), []),
}


@pytest.mark.parametrize("case", SPECIAL)
def test_special_cases(case):
    origin, direction, expected = SPECIAL[case]
    assert flat(spans(CYLINDER, origin, direction)) == pytest.approx(expected, **CLOSE)


def test_in_the_plane_of_a_cap_crossings_stay_even():
    for y in (0.0, 1.0):
        for direction in ((1, 0, 0), (0.6, 0, 0.8), (-3, 0, 1)):
            found = co.Scene([CYLINDER]).crossings((-3 * direction[0], y, -3 * direction[2]), direction)
            assert len(found.t) % 2 == 0


def test_both_caps_of_other_quadrics():
    """A paraboloid z >= x² + y² cut at z = 1 and 4, and two bowls cut on one side only."""
    bowl = co.EllipticParaboloid(1, 1, z_range=(1, 4))
    assert flat(spans(bowl, (0, 0, -1), (0, 0, 1))) == [2, 5]
    # x = 1.5: in by the body at z = 2.25, out by the cap
    assert flat(spans(bowl, (1.5, 0, 0), (0, 0, 1))) == pytest.approx([2.25, 4], **CLOSE)
    one = co.TwoSheetHyperboloid(1, 1, 1, z_range=(0, 3))
    assert flat(spans(one, (0, 0, -9), (0, 0, 1))) == pytest.approx([10, 12], **CLOSE)
