"""The judge accepts right answers and sees each kind of wrong one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co

from .items import Item, combined
from .judge import Judge
from .random_shapes import generator
from .suite import compare

BOX = Item("Box", {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)})
BALL = Item("Sphere", {"radius": 1.25, "center": (0.0, 0.0, 0.0)})
CUBE = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
RAYS = (
    np.array([[-5.0, 0, 0], [-5.0, 0.5, 0.3], [0.0, 0, 0], [-5.0, 1.1, 0.1], [0.0, 9.0, 0.0]]),
    np.array([[1.0, 0, 0], [1.3, 0, 0.02], [0.0, 1, 1], [1.0, 0.01, 0.02], [0.0, 1.0, 0.0]]),
)
POINTS = np.array([[1.0, 1, 1], [1.125, 0, 0], [3.0, 0, 0]])
FIELDS = {
    "crossings": "offsets t t_error body face surface entering",
    "first_hit": "t t_error point point_error body face surface entering normal local_point uv doubtful",
    "spans": "offsets body t_enter t_exit t_enter_error t_exit_error enter_clipped exit_clipped",
}


class Altered:
    """A scene with one query whose answers are spoilt."""

    def __init__(self, scene, name, spoil):
        self._scene, self._name, self._spoil = scene, name, spoil

    def __getattr__(self, name):
        query = getattr(self._scene, name)
        if name != self._name:
            return query

        def spoilt(*rays, **limits):
            result = query(*rays, **limits)
            if name in FIELDS:
                fields = {field: np.array(getattr(result, field)) for field in FIELDS[name].split()}
                fields |= {"rays": result.rays} if name == "first_hit" else {}
                result = SimpleNamespace(**fields)
            return self._spoil(result)

        return spoilt


def judged(items, scene=None):
    judge = Judge(co, items)
    judge.scene = scene or judge.scene
    compare(generator("judge", 0), judge.rays(*RAYS))
    judge.membership(POINTS)
    return judge.score


def test_right_answers_pass():
    for items, rows in (([BOX], 8), ([combined("Union", BOX, BALL), BALL], 20)):
        score = judged(items)
        score.check()
        assert score.rows == rows
    assert score.slackness >= 1


@pytest.mark.parametrize(
    ("items", "other", "complaint"),
    [
        ([BALL], [co.Sphere(1.25 + 2.0**-50)], "crossings: t is further off than t_error"),
        ([BOX], [co.Polyhedron(CUBE, np.ones(6))], "crossings: face"),
        ([BOX], [co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(0.5)], "crossings: number"),
        ([BOX, BALL], [co.Sphere(1.25), co.Box()], "crossings: body"),
        ([BOX], [co.Box((-1, 0.5, -1), (1, 1, 1))], "first_hit: hit or miss"),
        ([BOX], [co.Box((-1, -1, -1), (1.125, 1, 1))], "body_at"),
        ([BOX], [~co.Box((-1, -1, -1), (1, 1, 1))], "crossings: entering"),
        ([BOX, BOX.moved(("translate", (0.0, 0.0, 0.0)))], [co.Box(), co.Box().translate((2.0**-50, 0, 0))], "crossings: surface"),
    ],
)  # fmt: skip
def test_another_scene_is_noticed(items, other, complaint):
    assert complaint in judged(items, co.Scene(other)).wrong


def changed(name, change):
    """Change one column where there is a row or a hit."""

    def spoil(result):
        column = getattr(result, name)
        some = np.isfinite(result.t) if hasattr(result, "doubtful") else slice(None)
        column[some] = change(column[some])
        return result

    return spoil


def without_last(result):
    for name, column in vars(result).items():
        setattr(result, name, np.minimum(column, len(result.t) - 1) if name == "offsets" else column[:-1])
    return result


def missed(name, value):
    def spoil(result):
        getattr(result, name)[np.isinf(result.t)] = value
        return result

    return spoil


def ulps(count):
    return lambda t: t + count * np.spacing(t)


SPOILS = {
    "a part in 1e12": ("crossings", changed("t", lambda t: t * (1 + 1e-12)), "crossings: t is further off than t_error"),
    "four units in the last place": ("crossings", changed("t", ulps(4)), "crossings: t is further off than t_error"),
    "far away": ("crossings", changed("t", lambda t: 2 * t), "crossings: t is further off than t_error"),
    "a missing crossing": ("crossings", without_last, "crossings: number"),
    "a small bound": ("crossings", changed("t_error", lambda e: e * 1e-3), "crossings: t is further off than t_error"),
    "a large bound": ("crossings", changed("t_error", lambda e: e + 1), "crossings: t_error is as large as a length"),
    "inside out": ("crossings", changed("entering", np.logical_not), "crossings: entering"),
    "another body": ("crossings", changed("body", lambda b: 1 - b), "crossings: body"),
    "another face": ("crossings", changed("face", lambda f: f + 1), "crossings: face"),
    "one surface": ("crossings", changed("surface", lambda s: 0 * s), "crossings: surface"),
    "NaN": ("crossings", changed("t_error", lambda e: e * np.nan), "crossings: t or t_error is not finite"),
    "no order": ("crossings", changed("t", lambda t: -t), "crossings: order of t"),
    "hits further on": ("first_hit", changed("t", ulps(4)), "first_hit: t is further off than t_error"),
    "hits of another face": ("first_hit", changed("face", lambda f: f + 1), "first_hit: face"),
    "a point beside": ("first_hit", changed("point", lambda p: p + 1e-14), "first_hit: point"),
    "a large error of the point": ("first_hit", changed("point_error", lambda e: e + 1e-9), "first_hit: point_error is large"),
    "a normal beside": ("first_hit", changed("normal", lambda n: n + 1e-13), "first_hit: normal"),
    "an inward normal": ("first_hit", changed("normal", lambda n: -n), "first_hit: normal"),
    "no uv": ("first_hit", changed("uv", lambda x: x * np.nan), "first_hit: uv is not finite"),
    "a miss somewhere": ("first_hit", missed("point", 0.0), "first_hit: point of a miss"),
    "a miss with an error": ("first_hit", missed("t_error", 1.0), "first_hit: t_error of a miss"),
    "no shadow": ("occluded", np.logical_not, "occluded"),
    "longer spans": ("spans", changed("t_exit", ulps(4)), "spans.t_exit: t is further off than t_error"),
    "backward spans": ("spans", changed("t_exit", lambda t: -t - 99), "spans: length"),
    "open spans": ("spans", changed("exit_clipped", np.logical_not), "spans: number"),
    "contains": ("contains", np.logical_not, "contains"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILS)
def test_wrong_answers_are_noticed(name):
    query, spoil, complaint = SPOILS[name]
    items = [combined("Union", BOX, BALL), BALL]
    scene = co.Scene([item.shape(co) for item in items])
    assert complaint in judged(items, Altered(scene, query, spoil)).wrong


def test_intervals_and_routes_are_compared():
    """Answers that are right over the whole line, but not between limits or of one ray alone."""
    scene = co.Scene([co.Box()])

    def within(query):
        return lambda *rays, **limits: getattr(scene, query)(
            *rays, **({**limits, "t_max": np.inf} if len(limits) == 2 else limits)
        )

    def alone(*rays, **limits):
        return scene.first_hit(*rays, **limits) if np.ndim(rays[0]) > 1 else scene.first_hit((0, 0, 9), (0, 0, 1))

    for query, complaint in (("crossings", "interval, a crossing is not within"), ("spans", "interval, spans and crossings"), ("occluded", "interval, occluded is not first_hit.t < inf")):  # fmt: skip
        altered = SimpleNamespace(
            **{name: getattr(scene, name) for name in (*FIELDS, "occluded", "body_at", "contains", "_prepared")}
        )
        setattr(altered, query, within(query))
        assert complaint in judged([BOX], altered).wrong
    altered = SimpleNamespace(
        **{name: getattr(scene, name) for name in (*FIELDS, "occluded", "body_at", "contains", "_prepared")}
    )
    altered.first_hit = alone
    assert "routes: t alone" in judged([BOX], altered).wrong
