"""Scenes that nobody holds are written over by the ones that are made from them: the same tables, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.edits import buffer_pool as stores, in_place as exchange

from ..samples import deep, many
from .edits import bodies, moved, note_memory_taken, same_answers, same_tables, slid, written_anew
from .nodes import Nodes


@pytest.fixture
def taken(monkeypatch):
    return note_memory_taken(monkeypatch)


@pytest.mark.parametrize("holds", [deep(False), True])
def test_trees_that_grow_out_of_the_memory(monkeypatch, holds):
    """There is no room for more of them: all goes into new memory, that of answers that are held and of none."""
    monkeypatch.setattr(stores, "_NODE", 0)
    grown = []
    begin = exchange.InPlaceEdit.geometry

    def noted(self, empty):
        before = self._buffer
        made = begin(self, empty)
        grown.append(before is not None and before is not self._buffer)
        return made

    monkeypatch.setattr(exchange.InPlaceEdit, "geometry", noted)
    rng = np.random.default_rng(6)
    scene = bodies(300, 6, (co.Plane((0, 0, 1), -3),))
    for number in range(many(9, 24)):
        hits = scene.first_hit((0, 0, 9), (0, 0.1, -1))
        if not holds:
            del hits
        scene = (slid if number % 8 == 7 else moved)(scene, rng)
        anew = co.Scene(scene.bodies)
        same_tables(scene, anew)
        Nodes(scene).check()
        before, after = written_anew(scene)
        assert before == after
    same_answers(scene, anew, rng)
    assert sum(grown) > 3


def test_one_without_an_end_in_memory_that_is_written_over(taken):
    """The limits of what has no end depend on how large the scene is, though it is others that move."""
    ball, valley = co.Ellipsoid((1, 2, 3)), co.Quadric(np.diag([1.0, 2, -1, -1]))
    assert np.isinf(valley.bounds).any()
    scene = co.Scene([co.Cone((0, 0, k), (0, 0, k + 1), 1, 0.5) for k in range(3)] + 3 * [co.Sphere()] + [ball])
    scene.prepare()
    changes = [(6, valley), (3, co.Sphere(2, (100, 0, 0))), (4, co.Sphere(2, (5, 0, 0))), (3, co.Sphere(2, (1, 0, 0))),
               (6, ball), (3, co.Sphere(2, (50, 0, 0))), (6, valley)]  # fmt: skip
    limits = []
    for number, shape in changes:
        scene = scene.replace(number, shape)
        anew = co.Scene(scene.bodies)
        same_tables(scene, anew)
        limits.append(anew._prepared.lowered.tables.quadric_limits.tobytes())
    assert taken == len(changes) * [True]
    first, larger, as_large, smaller = limits[:4]
    assert first != larger
    assert larger == as_large
    assert as_large != smaller
