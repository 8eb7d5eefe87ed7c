"""Messages: nouns and numbers agree, and no message is longer than a screen."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.cli import app, report
from conicoid.io import openmc
from conicoid.io.openmc.importer import LegendEntry

from . import messages
from .command_line import refused, run

# --- Messages about things with thousands of parts name the first few and count the rest

MANY = 3000
LONG = "a long name " * 400


def test_the_measure():
    assert messages.rows_of("a\nb") == 2
    assert messages.rows_of("x" * 101 + "\n\ny") == 4
    with pytest.raises(AssertionError, match="a message of 23 lines"):
        messages.check("x\n" * 23)


def _scene_of_many() -> co.Scene:
    return co.Scene([co.Body(co.Sphere(), name=f"{i} {LONG}") for i in range(MANY)])


@pytest.mark.parametrize("provoke", [
    lambda: _scene_of_many()["nobody"],
    lambda: _scene_of_many()[LONG],
    lambda: _scene_of_many()[10**4000],
    lambda: _scene_of_many().replace(LONG, co.Sphere()),
    lambda: co.Scene([co.Body(co.Sphere(), name=LONG)] * 2),
    lambda: co.Scene([LONG] * 9),
    lambda: co.Union([co.Sphere()] * MANY + [LONG]),
    lambda: co.Polygon(np.random.default_rng(0).random((MANY, 3))),
    lambda: co.Quadric(coefficients={f"{i}": 1.0 for i in range(MANY)}),
    lambda: co.Spheres(np.zeros((MANY, 2)), 1),
    lambda: co.Sphere(center=[0.1] * MANY),
    lambda: co.set_threads(10**400),
    lambda: co.set_threads(10**5000),
    lambda: co.set_threads(True),
    lambda: co.Image(np.zeros((3, 3)), colormap=LONG),
    lambda: co.Image(np.zeros((3, 3))).save(LONG),
    lambda: co.turntable(co.Sphere(), LONG),
    lambda: co.load(LONG),
    lambda: co.Hits.load(LONG),
    lambda: co.Scene([co.Sphere()]).spans((0, 0, 5), (0, 0, -1)).line_integral([1.0] * MANY),
    lambda: co.Scene([co.Sphere()]).first_hit(np.zeros((MANY, 2)), np.zeros((7, 3))),
    lambda: getattr(co, LONG),
])  # fmt: skip
def test_bad_input(provoke):
    """The messages themselves are measured by `conftest.py`."""
    with pytest.raises((ValueError, TypeError, LookupError, OSError, AttributeError)):
        provoke()


@pytest.mark.parametrize("content", [
    "bodies: [" + "{shape: {Spere: {}}}, " * MANY + "]",
    f"bodies: [{{shape: {{'{LONG}': {{}}}}}}]",
    f"bodies: [{{shape: '{LONG}'}}]\nshapes: {{{', '.join(f'shape {i}: {{Sphere: {{}}}}' for i in range(MANY))}}}",
    f"bodies: [{{shape: {{Sphere: {{radius: '{LONG}'}}}}}}]",
    f"bodies: [{{shape: {{Sphere: {{}}}}, material: '{LONG}'}}]",
    f"bodies: []\n'{LONG}': 3",
    "bodies: [" + f"{{shape: {{Sphere: {{radius: '{LONG}'}}}}, name: '{LONG}'}}, " * 50 + "]",
    "bodies: [" + "\x1b" * 5000 + "]",
    "[" * 3000,
])  # fmt: skip
def test_bad_scene_files(content, tmp_path):
    (tmp_path / "scene.yaml").write_text(content)
    told = refused("info", tmp_path / "scene.yaml")
    assert "scene.yaml" in told
    with pytest.raises(co.SceneFileError):
        co.load(tmp_path / "scene.yaml")


def test_bad_arguments_of_commands(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: []")
    for arguments in (
        ("info", LONG), ("render", tmp_path / "scene.yaml", "-o", LONG), ("info", tmp_path / "scene.yaml", LONG),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--integrator", LONG), (LONG,),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--position", LONG),
        ("turntable", tmp_path / "scene.yaml", "-o", LONG), ("render", tmp_path / "scene.yaml", f"--{LONG}"),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--width", LONG),
    ):  # fmt: skip
        result = run(*arguments)
        assert result.exit_code == 2, arguments
        assert messages.rows_of(result.stderr) <= messages.ROWS, (arguments[0], result.stderr[:3000])


# --- One is one: messages and representations count in English, and name sizes in units that people read

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
