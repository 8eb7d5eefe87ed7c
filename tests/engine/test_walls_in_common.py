"""Bodies moved together that have walls in common, before or after: the same tables as from the beginning, to the bit.

Whose record stands for a wall is told by the records, not by the order of the bodies: so it may be that of a body
before or behind, in another piece of the tables.
"""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from .edits import note_memory_taken, same, same_answers


@pytest.fixture
def exchanged(monkeypatch):
    """One for each exchange: whether it took memory that was another scene's."""
    return note_memory_taken(monkeypatch)


def two(a, b):
    """Boxes a and b with a ball between them, and more behind, so that at most half of the bodies are moved."""
    ball, *others = (co.Sphere(0.25, (20 + 5 * k, 9, 9)) for k in range(3))
    return co.Scene([co.Body(co.Box(*a), name="a"), ball, co.Body(co.Box(*b), name="b"), *others])


def test_a_wall_that_was_ones_high_side_and_is_its_low_side(exchanged):
    old = two(((0, 0, 0), (1, 1, 1)), ((3, 1, 4), (4.7, 2.7, 5.7)))
    old.prepare()
    new = old.moved("a", (0.2, 1, 0.3)).moved("b", (2, 0, 3))
    assert new.spans((0.7, -5, 0.7), (0, 1, 0)).t_enter.tolist() == [6.0]  # from y = -5 to y = 0 + 1
    same(new)
    assert exchanged == [False]


def test_a_wall_of_one_behind_that_was_its_low_side_and_is_its_high_side(exchanged):
    """Whose record stands for a's wall both times is a wall of b: one further on, as is b when a ball is between."""
    old = two(((4, 0, 0), (5, 1, 1)), ((3, 1, 4), (4.5, 2.5, 5.5)))
    old.prepare()
    new = old.moved("a", (0, 0, 8)).moved("b", (0, -1.5, -4))  # b ends where a does, at y = 1
    same(new)
    same_answers(new, co.Scene(new.bodies), np.random.default_rng(1))
    assert exchanged == [False]


def test_a_wall_that_stays_in_common_with_one_of_another_piece(exchanged):
    """The record that stands for it stays where it is, but its row is told by how its own piece moves."""
    others = [co.Box((0, 0, 0), (1, 1, 1)).translate(at) for at in
              ((5.3, 5.1, 5.7), (8.3, 8.1, 8.7), (11.3, 12.1, 13.7), (21.3, 22.1, 23.7))]  # fmt: skip
    a, b = (co.Body(co.Box((0, 0, 0), (1, 1, 1)).translate((x, 0, 0)), name=str(x)) for x in (0, 1))
    old = co.Scene([a, *others[:2], b, *others[2:]])
    old.prepare()
    new = old.moved("0", (0.1, 0.2, 0.3)).moved("1", (0.1, 0.2, 0.3))
    same(new)
    assert exchanged == [False]


def test_a_wall_that_stays_in_common_with_the_next_body(exchanged):
    """Bodies that come one after the other are one piece: of these the memory of scenes that are gone is taken."""
    a, b = (co.Body(co.Box((0, 0, 0), (1, 1, 1)).translate((x, 0, 0)), name=str(x)) for x in (0, 1))
    scene = co.Scene([a, b, *(co.Sphere(0.25, (5 + k, 5, 5)) for k in range(4))])
    scene.prepare()
    for step in range(1, 6):
        scene = scene.moved("0", (0.1, 0.2 * step, 0.3)).moved("1", (0.1, 0.2 * step, 0.3))
        same(scene)
    assert exchanged == 5 * [True]
