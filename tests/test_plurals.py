"""One is one: messages and representations count in English, and name sizes in units that people read."""

from __future__ import annotations

import pytest

import conicoid as co
from conicoid.cli import app, report
from conicoid.io import openmc
from conicoid.io.openmc.importer import LegendEntry

BALL = co.Scene([co.Sphere(1)])


def test_representations():
    rays = ([(0, 0, -3)], (0, 0, 1))
    assert repr(BALL.first_hit(*rays)) == "Hits(shape=(1,), 1 of 1 ray hit)"
    assert repr(BALL.spans(*rays)) == "Spans(shape=(1,), 1 span)"
    assert repr(BALL.crossings(*rays)) == "Crossings(shape=(1,), 2 crossings)"
    assert repr(BALL.crossings((0, 0, -3), (0, 0, -1))) == "Crossings(shape=(), 0 crossings)"


def test_what_trace_says():
    assert app.trace_summary("first_hit", 1, 1) == "1 of 1 ray hit"
    assert app.trace_summary("spans", 1, 1) == "1 span of 1 ray"
    assert app.trace_summary("spans", 4000, 2) == "4,000 spans of 2 rays"


def test_what_info_says():
    lines = report.totals(BALL)
    assert any(" for 1 primitive: " in line for line in lines)
    many = co.Scene([co.Sphere()] * (report.LISTED + 1))
    assert report.list_bodies(many)[-1].strip() == "and 1 more entry"


def test_legends_stay_in_columns():
    one, two = (str(LegendEntry(1, "water", "blue", count)) for count in (1, 2))
    assert " 1 body " in one
    assert one.index("water") == two.index("water")


def test_sizes_have_units_that_fit(tmp_path):
    file = tmp_path / "geometry.xml"
    file.write_text(
        '<geometry><surface id="1" type="sphere" coeffs="0 0 0 1"/>'
        '<cell id="1" material="1" region="-1"/><cell id="2" material="1" region="1"/></geometry>'
    )
    with pytest.raises(co.SceneFileError) as refused:
        openmc.read(file, max_bodies=1)
    assert "expands into 2 bodies, at least 1.2 kB in memory" in str(refused.value)
