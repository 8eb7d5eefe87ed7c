"""How an explanation is asked for: in Python, in a notebook, on the command line; and what is refused."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.explain.steps import OUTCOMES

from ..command_line import done, refused, run, written

SCENE = co.Scene(
    [co.Body(co.Sphere(1), name="ball"), co.Box((3, -1, -1), (5, 1, 1)), co.Spheres([(0, 9, 0), (0, 12, 0)], 1)]
)
RAY = (-3, 0.6, 0), (1, 0, 0)


def test_rays_and_bodies_by_name_and_number():
    found = SCENE.explain(co.Rays(*RAY))
    assert found.text == SCENE.explain(*RAY).text == str(found)
    assert [step.body for step in found.bodies] == [0, 1, 2, 3]
    assert found["ball"] is found[0]
    assert [step.body for step in SCENE.explain(*RAY, body="ball").bodies] == [0]
    assert [step.body for step in SCENE.explain(*RAY, body=np.int32(3)).bodies] == [3]
    assert {step.outcome for step in found.bodies} == {"hit", "crossed", "box missed"}
    assert set(OUTCOMES) >= {step.outcome for step in found.bodies}
    with pytest.raises(LookupError, match="no step of body 'bal'; there are 'ball', 'Box 1'"):
        found["bal"]


def test_a_spawned_ray_knows_where_it_starts():
    """Into the ball from (−0.8, 0.6, 0) along x: on the board t² + 2 B t = 0, B = −0.8; t = 0 is left out, t = 1.6 is met."""
    found = SCENE.explain(SCENE.first_hit(*RAY).spawn((1, 0, 0)))
    step = found.surfaces[int(found.hit.surface)]
    assert step.starts
    assert step.c == 0
    assert found.hit.t == pytest.approx(1.6, rel=1e-15)
    assert "the ray starts on this surface: its root t = 0 is removed, and −2b / a is left" in found.text
    outward = SCENE.explain(SCENE.first_hit(*RAY).spawn((-1, 0, 0)))
    assert outward[0].outcome == "started on"


@pytest.mark.parametrize(("arguments", "error", "message"), [
    (([[0, 0, 0]], [[1, 0, 0]]), ValueError, r"explain: origin and direction must be one ray, got rays of shape \(1,\); rays\[i\] is one of them"),
    (((0, 0, 0), (0, 0, 0)), ValueError, "direction must not be zero"),
    (((0, 0, 0),), TypeError, "explain: directions are missing"),
    ((*RAY, math.nan), ValueError, "explain: t_min must not be NaN"),
])  # fmt: skip
def test_what_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        SCENE.explain(*arguments)


def test_bodies_that_there_are_not():
    with pytest.raises(KeyError, match="no body named 'bal'"):
        SCENE.explain(*RAY, body="bal")
    with pytest.raises(IndexError, match="-1 stands for a miss"):
        SCENE.explain(*RAY, body=-1)


def test_steps_are_values():
    found = SCENE.explain(*RAY)
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.bodies[0].outcome = "missed"
    assert len(repr(found)) < 200


def test_an_empty_interval_and_an_empty_scene():
    assert "nothing is hit: t = ∞" in SCENE.explain(*RAY, t_min=2, t_max=1).text
    assert "nothing is hit: t = ∞" in co.Scene([]).explain(*RAY).text
    assert SCENE.explain(*RAY, t_min=2.5).hit.t == 3.8


def test_many_bodies_are_counted():
    """A thousand balls in a row along y: the ray along x meets the one at y = 0, the tree leaves out the rest."""
    found = co.Scene([co.Spheres([(0, 3 * k, 0) for k in range(1000)], 1)]).explain((-5, 0, 0), (1, 0, 0))
    assert len(found.bodies) + found.misses == 1000
    assert len(found.bodies) < 40
    assert f"the tree of boxes leaves out {found.misses} more bodies" in found.text


def test_html_stands_by_itself():
    text = co.Scene([co.Body(co.Sphere(1), name="a<b>&c")]).explain(*RAY)._repr_html_()
    assert text.count("<div") == text.count("</div>")
    assert "a&lt;b&gt;&amp;c" in text
    assert "a<b>" not in text
    assert "<i>t</i><sup>2</sup> + 2 <i>B</i> <i>t</i> + <i>C</i> = 0" in text
    assert re.search(r"<i>t</i><sub>0</sub> = .*= 2\.2</p>", text)
    assert "<svg" in text


def test_text_has_no_line_that_is_only_blanks_at_its_end():
    lines = SCENE.explain(*RAY).text.split("\n")
    assert lines[-1] == ""
    assert [line for line in lines if line != line.rstrip()] == []


def test_command(tmp_path):
    path = written(tmp_path)
    result = done("explain", path, "--ray", -3, 0.6, 0, 1, 0, 0, "--body", "ball", "--html", tmp_path / "why.html")
    assert result.stdout == co.load(path).explain(*RAY, body="ball").text
    assert "t₀ = −B − √D = 2.2" in result.stdout
    assert (tmp_path / "why.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    numbered = run("explain", path, "--ray", -3, 0.6, 0, 1, 0, 0, "--body", 1, "--t-max", 3)
    assert "Body 1 “Box 1”" in numbered.stdout
    assert "0 < t < 3" in numbered.stdout


def test_command_refuses(tmp_path):
    path = written(tmp_path)
    assert "requires 6 arguments" in run("explain", path, "--ray", 0, 0, 0, 1).output
    assert "no body named 'bal'" in refused("explain", path, "--ray", 0, 0, 0, 1, 0, 0, "--body", "bal")
    assert "body: number must be at least 0 and below 5, got 9" in refused(
        "explain", path, "--ray", 0, 0, 0, 1, 0, 0, "--body", 9
    )
    assert "the page is written as .html" in refused(
        "explain", path, "--ray", 0, 0, 0, 1, 0, 0, "--html", tmp_path / "x.pdf"
    )
    assert "direction must not be zero" in refused("explain", path, "--ray", 0, 0, 0, 0, 0, 0)


def test_a_sweep_counts_the_inputs_of_its_own_body():
    """x and y are in [0, 4] and [1, 3]: so is the ray from 0 and 1 on, of which the intersection needs both."""
    slab = co.Box((0, -1, -1), (4, 1, 1)) & co.Box((1, -2, -2), (3, 2, 2))
    scene = co.Scene([slab.translate((0, 9, 0)), slab])
    sweep = scene.explain((-5, 0, 0), (1, 0, 0), body=1).bodies[-1].sweep
    assert [(row.t, row.count, row.need) for row in sweep.rows] == [(5, 1, 2), (6, 2, 2), (8, 1, 2), (9, 0, 2)]
