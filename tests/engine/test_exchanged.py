"""Entries exchanged for others in memory that was another scene's: whoever holds a scene never sees that."""

from __future__ import annotations

import gc
import itertools
import os
import pickle
import threading

import numpy as np
import pytest

import conicoid as co
from conicoid.cluster.edition import edition
from conicoid.cluster.tables_file import opened, write_tables
from conicoid.engine.lowering.edited import exchange, stores
from conicoid.engine.lowering.edited.exchange import Exchange
from conicoid.engine.tree.build.leaf_items import put_items
from tests.engine.nodes import Nodes
from tests.engine.test_edited import same_answers, same_tables

CUBE = co.Box((-1, -1, -1), (1, 1, 1))


def bored(radius, at):
    """Five leaves, three pairs of whose walls are a pair of planes."""
    solid = CUBE & co.Sphere(1.3)
    for axis in np.eye(3):
        solid = solid - co.Cylinder((-2 * axis).tolist(), (2 * axis).tolist(), radius)
    return solid.scale(0.3).translate(at)


def anywhere(rng):
    """A body of one of many kinds, whose walls are no other body's."""
    at, turn = tuple(rng.uniform(-4, 4, 3).tolist()), (tuple(rng.normal(size=3).tolist()), float(rng.uniform(0, 180)))
    red = co.matte("red")
    many = CUBE
    for corner in rng.uniform(-1, 1, (14, 3)).tolist():
        many = many - co.Sphere(0.2, corner)
    kinds = [
        lambda: bored(0.3, at),
        lambda: co.Sphere(float(rng.uniform(0.2, 1)), at),
        lambda: co.Ellipsoid((1, 2, 0.5)).rotate(*turn).translate(at),
        lambda: CUBE.rotate(*turn).translate(at),
        lambda: co.Cylinder(at, (0, 0, 0), 0.3),
        lambda: (CUBE - co.Sphere(0.9, (1, 1, 1)).painted(red)).rotate(*turn).translate(at),
        lambda: many.rotate(*turn).translate(at),
        lambda: (co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Sphere(1)).rotate(*turn).translate(at),
        lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).rotate(*turn).translate(at),
        lambda: CUBE.scale(0.2).translate((float(rng.integers(-2, 3)), 0, 0)),  # walls that are others', too
    ]
    return kinds[-1 if rng.random() < 0.03 else rng.integers(0, len(kinds) - 1)]()


def bodies(count, seed=1, more=()):
    rng = np.random.default_rng(seed)
    return co.Scene([*(co.Body(anywhere(rng), name=str(k)) for k in range(count)), *more])


def moved(scene, rng):
    """One or two bodies moved, or exchanged for others of their kind or of any."""
    for _ in range(rng.integers(1, 3)):
        name = str(rng.integers(0, 20))
        motion = tuple(rng.uniform(-0.3, 0.3, 3).tolist())
        what = rng.integers(0, 20)
        if what == 0:
            scene = scene.replace(name, anywhere(rng))
        elif what < 5:
            scene = scene.moved(name, lambda shape: shape.rotate((1, 2, 3), 10))
        else:
            scene = scene.moved(name, motion)
    return scene


def standing(rng):
    """A body that stands on the floor z = 0, or is as high as others, or is the same ball as others."""
    x, y = rng.uniform(-4, 4, 2).tolist()
    kinds = [
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)),
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)) - co.Sphere(0.3, (x, y, 1)),
        lambda: co.Cylinder((x, y, 0), (x, y, 2), 0.2),
        lambda: ~co.HalfSpace((0, 0, 1), 0) & co.Sphere(1, (x, y, 0)),
        lambda: co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Ellipsoid((0.2, 0.2, 0.2)).rotate("x", 20).translate((1, 1, 1)),
        lambda: co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 2, 3), 30) & ~co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Disc((x, y, 2), (0, 0, 1), 0.5),
    ]
    return kinds[rng.integers(0, len(kinds))]()


def slid(scene, rng):
    """Bodies slid along the floor, or raised, or swapped with others that stand there."""
    for _ in range(rng.integers(1, 3)):
        name, what = str(rng.integers(0, 20)), rng.integers(0, 12)
        along = (*rng.uniform(-0.3, 0.3, 2).tolist(), 0.0)
        if what == 0:
            scene = scene.replace(name, standing(rng))
        elif what == 1:
            scene = scene.moved(name, (0, 0, 1))
        else:
            scene = scene.moved(name, along)
    return scene


@pytest.mark.parametrize(("seed", "more"), [
    (0, ()), (1, (co.Plane((0, 0, 1), 0),)), (2, (co.HalfSpace((0, 0, 1), 0),)),
    (3, (co.Spheres([(1, 1, 1), (2, 2, 2)], 0.2),)),
])  # fmt: skip
def test_what_stands_on_one_floor_is_slid_along_it(seed, more):
    rng = np.random.default_rng(seed)
    first = co.Scene([*(co.Body(standing(rng), name=str(k)) for k in range(24)), *more])
    chain(first, seed, slid, 60)


def leaves(scene):
    """The items of the leaves of the tree over the entries: each leaf's, by its first place."""
    found, tree = {}, Nodes(scene)
    items, first = scene.lowered.tables.leaf_items, int(scene.prepared.woods.places[-1])
    for code in [*tree.children[tree.children < 0].tolist(), *(root for root in tree.roots if root < 0)]:
        place, count = (-code - 1) >> 4, (-code - 1) & 15
        if place >= first:
            found[place] = items[8 * place : 8 * (place + count)].tobytes()
    return found


def written_anew(scene):
    """`leaves` after all have been written."""
    before = leaves(scene)
    copy = scene.geometry._replace(floats=scene.geometry.floats.copy())
    scene.lowered.tables.leaf_items[...] = 0.0
    put_items(scene.geometry, scene.lowered.boxes, int(scene.prepared.woods.places[-1]))
    after = leaves(scene)
    scene.geometry.floats[...] = copy.floats
    return before, after


def content(scene):
    """All numbers of a scene."""
    lowered, rest = scene.lowered, scene.lowered.rest
    parts = (*lowered.tables, lowered.boxes, lowered.frames, lowered.body_frame, lowered.body_item, rest.planes,
             rest.spheres, rest.quadrics, rest.vertices)  # fmt: skip
    return [part.tobytes() for part in parts]


@pytest.fixture
def taken(monkeypatch):
    """Whether each exchange found memory that was another scene's."""
    found, take = [], exchange._taken

    def noted(*arguments):
        opened, pieces = take(*arguments)
        found.append(opened is not None)
        return opened, pieces

    monkeypatch.setattr(exchange, "_taken", noted)
    return found


@pytest.mark.parametrize(("seed", "count", "more"), [
    (0, 20, ()), (1, 300, ()), (2, 20, (co.Plane((0, 0, 1), -3), co.HalfSpace((1, 0, 0), -20))),
    (3, 40, (co.Spheres(np.random.default_rng(1).normal(size=(30, 3)), 0.2),)),
    (4, 25, (CUBE.translate((7, 0, 0)), CUBE.translate((9, 0, 0)), co.Spheres([(7.0, 5, 5)], 1.0), co.Sphere(1, (7, 5, 5)))),
])  # fmt: skip
def test_a_chain_of_exchanges_with_scenes_that_are_held(seed, count, more, taken):
    chain(bodies(count, seed, more), seed, moved, 40)
    assert sum(taken) > 8


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


def test_the_memory_of_a_scene_that_is_gone_is_taken_again(taken):
    scene, places = bodies(30), []
    scene.prepare()
    for number in range(6):
        scene = scene.moved(str(number), (0, 0.1, 0))
        places.append(scene.geometry.floats.ctypes.data)
    assert taken == [False, False, True, True, True, True]
    assert len(set(places)) == 2
    first = bodies(30)
    first.prepare()
    taken.clear()
    for number in range(5):  # as a slider does: each from the same
        now = first.moved("3", (0, 0.1 * number, 0))
        same_tables(now, co.Scene(now.bodies))
    assert taken == [False, True, True, True, True]


@pytest.mark.parametrize("holder", [
    lambda scene: scene.first_hit((0, 0, 9), (0, 0, -1)), lambda scene: scene.spans((0, 0, 9), (0, 0, -1)),
    lambda scene: scene.lowered.tables.planes[3:5], lambda scene: scene.geometry.floats, lambda scene: scene.geometry,
    lambda scene: scene.lowered.boxes, lambda scene: scene.lowered.rest.quadrics[:1], lambda scene: scene.prepared,
    lambda scene: memoryview(scene.lowered.frames), lambda scene: scene.replace(background="red"),
    lambda scene: np.asarray(scene.prepared.rest.planes).reshape(-1, 7).T,
])  # fmt: skip
def test_whatever_is_left_of_a_scene_keeps_its_memory(holder):
    first = bodies(30)
    first.prepare()
    scene = first.moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    scene.prepare()
    numbers, floats = content(scene), scene.geometry.floats.ctypes.data
    held = holder(scene)
    scene = scene.moved("3", (0.1, 0, 0))
    scene.prepare()
    for number in range(4, 12):
        scene = scene.moved(str(number), (0.1, 0, 0))
        assert scene.geometry.floats.ctypes.data != floats
    del held
    again = first.moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    assert content(again)[:30] == numbers[:30]


def test_hits_of_a_scene_that_is_gone_say_what_they_said():
    rng = np.random.default_rng(2)
    scene = bodies(40)
    rays = rng.normal(size=(300, 3)) * 6, rng.normal(size=(300, 3))
    kept = []
    for number in range(12):
        scene = scene.moved(str(number), (0, 0.3, 0))
        hits = scene.first_hit(*rays)
        kept.append((hits, co.Scene(scene.bodies).first_hit(*rays)))
    scene = scene.moved("0", (0, 0, 2))
    scene.prepare()
    for hits, others in kept:  # worked out only now
        for name in ("point", "normal", "uv", "local_point", "entering", "t_error", "before", "after"):
            assert np.array_equal(getattr(hits, name), getattr(others, name), equal_nan=True), name


def test_threads_that_exchange_in_one_scene_at_once():
    scene, failed = bodies(60), []
    scene.prepare()
    before = content(scene)

    def work(seed):
        try:
            rng = np.random.default_rng(seed)
            for _ in range(6):
                mine = scene
                for _ in range(3):
                    mine = moved(mine, rng)
                    same_tables(mine, co.Scene(mine.bodies))
                same_answers(mine, co.Scene(mine.bodies), rng, 40)
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed, failed[0]
    assert content(scene) == before


def test_a_thread_that_asks_while_scenes_come_and_go():
    scene, rays = bodies(200), (np.random.default_rng(3).normal(size=(20_000, 3)) * 5, (0.1, 0.2, 1.0))
    scene = scene.moved("0", (0, 0, 0.1)).moved("1", (0, 0, 0.1))
    expected = [co.Scene(scene.bodies).first_hit(*rays).t]
    for number in range(2, 8):
        expected.append(co.Scene(moved_by(scene, number).bodies).first_hit(*rays).t)
    told, wrong = threading.Barrier(2), []

    def ask(one, number):
        told.wait()
        wrong.extend(number for _ in range(3) if not np.array_equal(one.first_hit(*rays).t, expected[number]))

    for number in range(8):
        now = scene if number in (0, 1) else moved_by(scene, number)
        now.prepare()
        thread = threading.Thread(target=ask, args=(now, 0 if number < 2 else number - 1))
        thread.start()
        del now
        told.wait()
        for other in range(10, 16):
            moved_by(scene, other).prepare()
        thread.join()
    assert wrong == []


def moved_by(scene, number):
    return scene.moved(str(number), (0, 0.01 * number, 0))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")
def test_a_fork_edits_what_its_parent_edits():
    scene = bodies(30).moved("0", (0, 0, 0.1)).moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    scene.prepare()
    before = content(scene)
    reading, writing = os.pipe()
    forked = os.fork()
    if forked == 0:
        right = 1
        try:
            mine = scene
            for number in range(3, 9):
                mine = mine.moved(str(number), (0.2, 0, 0))
                same_tables(mine, co.Scene(mine.bodies))
            right = 0 if content(scene) == before else 2
        finally:
            os.write(writing, bytes([right]))
            os._exit(0)
    mine = scene
    for number in range(8, 2, -1):
        mine = mine.moved(str(number), (0, 0.2, 0))
        same_tables(mine, co.Scene(mine.bodies))
    assert os.read(reading, 1) == b"\0"
    os.waitpid(forked, 0)
    assert content(scene) == before


def test_pickles_and_files_of_tables(tmp_path):
    scene = bodies(30)
    for number in range(5):
        scene = scene.moved(str(number), (0, 0.2, 0))
    scene.prepare()
    again = pickle.loads(pickle.dumps(scene))
    same_tables(scene, again)
    sizes = []
    for number, one in enumerate((scene, again)):
        path = tmp_path / f"{number}.tables"
        digest = write_tables(path, edition(), one.prepared, (co.Scene, one._parts[1:], ()), pickle.dumps(one))
        sizes.append(path.stat().st_size)
        read = opened(path, edition(), digest)
        assert content(read)[:20] == content(scene)[:20]
    assert sizes[0] < 1.2 * sizes[1]


def test_an_edit_that_is_broken_off_leaves_nothing_behind(monkeypatch):
    scene = bodies(30).moved("0", (0, 0, 0.1)).moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    scene.prepare()
    before = content(scene)
    fill = Exchange.fill

    def broken(self, *arguments):
        fill(self, *arguments)
        raise KeyboardInterrupt

    edited = scene.moved("3", (1, 0, 0)).moved("4", (1, 0, 0))
    monkeypatch.setattr(Exchange, "fill", broken)
    with pytest.raises(KeyboardInterrupt):
        edited.prepare()
    monkeypatch.undo()
    assert content(scene) == before
    same_tables(edited, co.Scene(edited.bodies))
    for number in range(5, 9):
        scene = scene.moved(str(number), (1, 0, 0))
        same_tables(scene, co.Scene(scene.bodies))


def test_memory_is_given_up_with_the_last_scene(monkeypatch):
    """Nobody keeps a scene's memory when all scenes that it might be taken for are gone."""
    alive = itertools.count(), []

    class Watched(stores.Store):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            alive[1].append(next(alive[0]))
            self.number = alive[1][-1]

        def __del__(self):
            alive[1].remove(self.number)

    monkeypatch.setattr(stores, "Store", Watched)
    first = bodies(30)
    first.prepare()
    scene = first
    for number in range(5):
        scene = scene.moved(str(number), (0, 0.1, 0))
        scene.prepare()
    assert len(alive[1]) == 2  # the last one's, and one to be taken
    del scene
    gc.collect()
    assert len(alive[1]) == 1
    del first
    gc.collect()
    assert alive[1] == []


def test_much_memory_is_not_kept(monkeypatch, taken):
    monkeypatch.setattr(stores, "MOST", 1000)
    scene = bodies(30)
    for number in range(5):
        scene = scene.moved(str(number), (0, 0.1, 0))
        scene.prepare()
    same_tables(scene, co.Scene(scene.bodies))
    assert taken == [False] * 4  # the first of five was prepared from the beginning
