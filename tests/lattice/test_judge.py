"""The judge of lattices sees what is wrong: answers of another scene, and of queries that do not agree."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from .intervals import Interval
from .items import Item, union
from .judge import Judge
from .kinds import generator
from .routes import Routes

BOX = Item("Box", {"low": (-1.0, -1.0, -1.0), "high": (1.0, 1.0, 1.0)})
BALL = Item("Sphere", {"radius": 1.25, "center": (0.0, 0.0, 0.0)})
CUBE = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
RAYS = np.array([[-5.0, 0, 0], [-5.0, 0.5, 0.25], [0.0, 0, 0]]), np.array([[1.0, 0, 0], [1.0, 0, 0], [0.0, 1, 1]])


class Altered:
    """A scene of which one query answers for other rays or other bodies."""

    def __init__(self, scene, name, query):
        self._scene, self._name, self._query = scene, name, query

    def __getattr__(self, name):
        return self._query if name == self._name else getattr(self._scene, name)


def judged(items, scene=None):
    judge = Judge(co, items)
    judge.scene = scene or judge.scene
    asked = judge.asked(*RAYS)
    good = asked.lists()
    asked.first(good)
    asked.spans(good)
    judge.membership(np.array([[1.0, 1, 1], [1.125, 0, 0], [3.0, 0, 0]]))
    Interval(asked, good, np.full(3, -np.inf), np.full(3, 4.0)).judge()
    Routes(asked).shuffled(generator("judge", 0))
    return judge.score.wrong


def test_what_is_right_is_right():
    assert not judged([BOX])
    assert not judged([union(BOX, BALL), BALL])


@pytest.mark.parametrize(
    ("items", "told", "expected"),
    [
        ([BALL], [co.Sphere(1.25 + 2.0**-50)], "crossings: t is further off than t_error"),
        ([BOX], [co.Polyhedron(CUBE, np.ones(6))], "crossings: face"),
        ([BOX], [co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(0.5)], "crossings: number"),
        ([BOX, BALL], [co.Sphere(1.25), co.Box()], "crossings: body"),
        ([BOX], [co.Box((-1, 0.5, -1), (1, 1, 1))], "first_hit: hit or miss"),
        ([BOX], [co.Box((-1, -1, -1), (1.125, 1, 1))], "body_at"),
    ],
)
def test_another_scene_is_noticed(items, told, expected):
    assert expected in judged(items, co.Scene(told))


def test_queries_that_disagree_are_noticed():
    scene = co.Scene([co.Box()])
    inverted = Altered(scene, "occluded", lambda *rays, **limits: ~scene.occluded(*rays, **limits))
    assert "interval, occluded is not first_hit.t < inf" in judged([BOX], inverted)
    shorter = Altered(scene, "spans", lambda *rays, **limits: co.Scene([co.Sphere(0.75)]).spans(*rays, **limits))
    wrong = judged([BOX], shorter)
    assert "spans.t_enter: t is further off than t_error" in wrong
    assert "interval, ends of spans and crossings" in wrong
