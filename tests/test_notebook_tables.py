"""Tables that notebooks show: rows of the right rays, escaped texts, and how many rows are left out."""

from __future__ import annotations

import re

import numpy as np

import conicoid as co
from conicoid._util.text import MOST_ROWS

SCENE = co.Scene([co.Body(co.Sphere(), "red", "a<b"), co.Box((2, 2, 2), (3, 3, 3))])
RAYS = co.Rays([[(0, 0, 5), (9, 9, 9)], [(2.5, 2.5, 9), (0, 0, 5)]], (0, 0, -1))


def rows(thing: object) -> list[list[str]]:
    """Return the texts of a table by row, the head first."""
    found = re.findall(r"<tr>(.*?)</tr>", thing._repr_html_())
    return [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in found]


def test_hits_have_a_row_for_each_ray():
    head, *found = rows(SCENE.first_hit(RAYS))
    assert head == ["ray", "t", "body", "name", "face", "entering", "point", "normal"]
    assert [row[0] for row in found] == ["0, 0", "0, 1", "1, 0", "1, 1"]
    assert [row[1] for row in found] == ["4", "inf", "6", "4"]  # from z = 5 to 1, and from 9 to 3
    assert [row[3] for row in found] == ["a&lt;b", "", "", "a&lt;b"]
    assert found[0][6:] == ["(0, 0, 1)", "(0, 0, 1)"]


def test_one_hit_is_one_row():
    assert rows(SCENE.first_hit((0, 0, 5), (0, 0, -1)))[1][:3] == ["", "4", "0"]


def test_long_tables_say_how_many_rows_they_leave_out():
    text = SCENE.first_hit(np.tile((0.0, 0.0, 5.0), (1000, 1)), (0, 0, -1))._repr_html_()
    assert text.count("<tr>") == MOST_ROWS + 1
    assert text.endswith("<p>and 980 more</p>")


def test_spans_and_crossings_name_the_ray_of_each_row():
    assert rows(SCENE.spans(RAYS)) == [
        ["ray", "t_enter", "t_exit", "body", "name"],
        ["0", "4", "6", "0", "a&lt;b"], ["2", "6", "7", "1", ""], ["3", "4", "6", "0", "a&lt;b"],
    ]  # fmt: skip
    head, *found = rows(SCENE.crossings(RAYS))
    assert head == ["ray", "t", "entering", "body", "face", "name"]
    assert [(row[0], row[1], row[2]) for row in found[:2]] == [("0", "4", "True"), ("0", "6", "False")]


def test_bodies_findings_and_prescriptions():
    assert rows(SCENE.bodies)[1][:3] == ["0", "a&lt;b", "Sphere"]
    assert rows(co.check(co.Scene([co.Sphere(), co.Sphere(1, (0.5, 0, 0))])))[1][:2] == ["overlap", "(0, 1)"]
    lens = co.optics.prescription([co.optics.Row(50, 4, 1.5, 20), co.optics.Row(-50, None, None, 20)], aperture=10)
    assert [row[0] for row in rows(lens)] == ["radius", "50", "-50"]
