"""Entries exchanged for others in memory that was another scene's: the same tables as from the beginning, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.bvh.walk import ROWS
from conicoid.prepare.bvh.leaf_items import put_items
from conicoid.prepare.edits import in_place as exchange
from tests.engine.exchanges import CUBE, bodies, content, moved, note_memory_taken, slid, standing
from tests.engine.nodes import Nodes
from tests.engine.test_edited import same_answers, same_tables


@pytest.fixture
def taken(monkeypatch):
    return note_memory_taken(monkeypatch)


def leaves(scene):
    """The items of the leaves of the tree over the entries: each leaf's, by its first place."""
    found, tree = {}, Nodes(scene)
    tables, first = scene._prepared.lowered.tables, int(scene._prepared.woods.places[-1])
    items = tables.leaf_items
    assert len(items) == ROWS * (len(tables.tree_order) - first)
    for code in [*tree.children[tree.children < 0].tolist(), *(root for root in tree.roots if root < 0)]:
        place, count = (-code - 1) >> 4, (-code - 1) & 15
        if place >= first:
            found[place] = items[ROWS * (place - first) : ROWS * (place - first + count)].tobytes()
    return found


def written_anew(scene):
    """`leaves` after all have been written."""
    before = leaves(scene)
    copy = scene._prepared.geometry._replace(floats=scene._prepared.geometry.floats.copy())
    scene._prepared.lowered.tables.leaf_items[...] = 0.0
    put_items(scene._prepared.geometry, scene._prepared.lowered.boxes, int(scene._prepared.woods.places[-1]))
    after = leaves(scene)
    scene._prepared.geometry.floats[...] = copy.floats
    return before, after


@pytest.mark.parametrize(("seed", "count", "more"), [
    (0, 20, ()), (1, 120, ()), (2, 20, (co.Plane((0, 0, 1), -3), co.HalfSpace((1, 0, 0), -20))),
    (3, 40, (co.Spheres(np.random.default_rng(1).normal(size=(30, 3)), 0.2),)),
    (4, 25, (CUBE.translate((7, 0, 0)), CUBE.translate((9, 0, 0)), co.Spheres([(7.0, 5, 5)], 1.0), co.Sphere(1, (7, 5, 5)))),
])  # fmt: skip
def test_a_chain_of_exchanges_with_scenes_that_are_held(seed, count, more, taken):
    chain(bodies(count, seed, more), seed, moved, 14)
    assert sum(taken) > 2


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(5, 35))
def test_long_chains_of_exchanges(seed, taken):
    more = (co.Plane((0, 0, 1), -3),) if seed % 3 == 0 else ()
    chain(bodies(20 + 90 * (seed % 4), seed, more), seed, moved, 150)
    assert sum(taken) > 20


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(4, 24))
def test_long_chains_on_one_floor(seed):
    rng = np.random.default_rng(seed)
    more = [(), (co.Plane((0, 0, 1), 0),), (co.Spheres([(1, 1, 1), (2, 2, 2)], 0.2),)][seed % 3]
    first = co.Scene([*(co.Body(standing(rng), name=str(k)) for k in range(24 + 20 * (seed % 4))), *more])
    chain(first, seed, slid, 100)


@pytest.mark.parametrize(("seed", "more"), [
    (0, ()), (1, (co.Plane((0, 0, 1), 0),)), (2, (co.HalfSpace((0, 0, 1), 0),)),
    (3, (co.Spheres([(1, 1, 1), (2, 2, 2)], 0.2),)),
])  # fmt: skip
def test_what_stands_on_one_floor_is_slid_along_it(seed, more):
    rng = np.random.default_rng(seed)
    first = co.Scene([*(co.Body(standing(rng), name=str(k)) for k in range(24)), *more])
    chain(first, seed, slid, 20)


def chain(scene, seed, edit, edits):
    """Edits one after the other, each compared with the scene from the beginning, some scenes being held meanwhile."""
    rng = np.random.default_rng(seed)
    scene.prepare()
    held = [(scene, content(scene))] if seed % 2 else []
    for number in range(edits):
        scene = edit(scene if rng.random() < 0.8 or not held else held[-1][0], rng)
        fresh = co.Scene(scene.bodies)
        same_tables(scene, fresh)
        Nodes(scene).check()
        before, after = written_anew(scene)
        assert before == after
        if rng.random() < 0.3:
            held = [*held[-2:], (scene, content(scene))]
        for one, numbers in held:
            assert content(one) == numbers
        if number % 10 == 0:
            same_answers(scene, fresh, rng, 60)
            for one, _ in held:
                same_answers(one, co.Scene(one.bodies), rng, 60)


def test_a_chain_of_exchanges_that_write_all_rows(taken, monkeypatch):
    monkeypatch.setattr(exchange, "_MOST", 0)
    chain(bodies(30, 6, (co.Spheres([(1, 1, 1), (2, 2, 2)], 0.2),)), 6, moved, 20)
    assert sum(taken) > 4
