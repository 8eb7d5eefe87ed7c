"""What the engine says about a ray of the page: only of what is shown."""

from __future__ import annotations

import pytest

import conicoid as co
from conicoid.viewer.picks import pick

FUEL = co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 1), name="fuel")
CLAD = co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1), name="clad")


@pytest.mark.parametrize("order", [(FUEL, CLAD), (CLAD, FUEL)])
def test_a_hidden_body_does_not_answer_for_the_wall_it_shares(order):
    """From the axis, the fuel's wall and the bore of the clad are one surface at t = 1; the clad ends at t = 2."""
    scene = co.Scene(list(order))
    hidden = [body.name for body in order].index("fuel")
    found = pick(scene, {"origin": [0, 0, 0], "direction": [1, 0, 0], "hidden": [hidden]})["found"]
    assert (found["name"], found["t"], found["entering"]) == ("clad", 1.0, True)
    assert found["point"] == [1.0, 0.0, 0.0]
    assert found["normal"] == [-1.0, 0.0, 0.0]  # out of the clad: towards the axis
    assert [(row["name"], row["t"]) for row in found["crossings"]] == [("clad", 1.0), ("clad", 2.0)]
    assert [(row["name"], row["enter"], row["exit"]) for row in found["spans"]] == [("clad", 1.0, 2.0)]


def test_nothing_is_found_where_everything_is_hidden():
    scene = co.Scene([FUEL, CLAD])
    assert pick(scene, {"origin": [0, 0, 0], "direction": [1, 0, 0], "hidden": [0, 1]}) == {"found": None}
