"""The memory that an edited scene takes: no thread, fork, answer or file may still read it."""

import copy
import gc
import itertools
import linecache
import os
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.bvh.walk import ROWS
from conicoid.parallel.shared_state import open_scene_tables, source_version, write_tables
from conicoid.prepare.edits import buffer_pool as stores, in_place as exchange
from conicoid.prepare.edits.buffer_pool import BufferPool, EditState, FullEditState, SceneBuffer
from conicoid.prepare.edits.scene_edit import prepare_edit

from ..samples import deep, deeper, many
from .edits import bodies, content, moved, note_memory_taken, rewritten_leaves, same_answers, same_tables, slid
from .nodes import Nodes

# --- The memory that an edited scene takes: no thread, fork, answer or file may still read it


@pytest.fixture
def reuses(monkeypatch):
    return note_memory_taken(monkeypatch)


def test_the_memory_of_a_deleted_scene_is_reused(reuses):
    scene = bodies(30)
    places, hits = [scene._prepared.geometry.floats.ctypes.data], None
    for number in range(6):  # nobody else has it, so each takes its memory
        scene = scene.moved(str(number), (0, 0.1, 0))
        places.append(scene._prepared.geometry.floats.ctypes.data)
    assert reuses == 6 * [True]
    assert len(set(places)) == 1
    reuses.clear()
    for number in range(6):  # answers hold it until there are others: two take turns
        hits = scene.first_hit((0, 0, 9), (0, 0, -1))
        scene = scene.moved(str(number), (0, 0.1, 0))
        places.append(scene._prepared.geometry.floats.ctypes.data)
    del hits
    assert reuses == [False, True, True, True, True, True]
    assert len(set(places)) == 2
    first = bodies(30)
    first.prepare()
    reuses.clear()
    for number in range(5):  # as a slider does: each from the same scene
        now = first.moved("3", (0, 0.1 * number, 0))
        same_tables(now, co.Scene(now.bodies))
    assert reuses == [False, True, True, True, True]


@pytest.mark.parametrize("holder", [
    lambda scene: scene.first_hit((0, 0, 9), (0, 0, -1)), lambda scene: scene.spans((0, 0, 9), (0, 0, -1)),
    lambda scene: scene._prepared.lowered.tables.planes[3:5], lambda scene: scene._prepared.geometry.floats, lambda scene: scene._prepared.geometry,
    lambda scene: scene._prepared.lowered.boxes, lambda scene: scene._prepared.lowered.rest.quadrics[:1], lambda scene: scene._prepared,
    lambda scene: memoryview(scene._prepared.lowered.frames), lambda scene: scene.replace(background="red"),
    lambda scene: np.asarray(scene._prepared.rest.planes).reshape(-1, 7).T,
])  # fmt: skip
def test_any_part_of_a_scene_keeps_its_memory(holder):
    first = bodies(30)
    first.prepare()
    scene = first.moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    scene.prepare()
    numbers, floats = content(scene), scene._prepared.geometry.floats.ctypes.data
    reference = holder(scene)
    scene = scene.moved("3", (0.1, 0, 0))
    scene.prepare()
    for number in range(4, 12):
        scene = scene.moved(str(number), (0.1, 0, 0))
        assert scene._prepared.geometry.floats.ctypes.data != floats
    del reference
    again = first.moved("1", (0, 0, 0.1)).moved("2", (0, 0, 0.1))
    assert content(again)[:30] == numbers[:30]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")
def test_a_fork_edits_the_scene_of_its_parent():
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
        digest = write_tables(path, source_version(), one._prepared, (co.Scene, one._parts[1:], ()), pickle.dumps(one))
        sizes.append(path.stat().st_size)
        read = open_scene_tables(path, source_version(), digest)
        assert content(read)[:20] == content(scene)[:20]
    assert sizes[0] < 1.2 * sizes[1]


def test_pickles_and_copies_have_stamps_of_their_own(monkeypatch):
    """A stamp of another process is another edit, even if its number is the same."""
    scene = bodies(30)
    for number in range(4):
        scene = scene.moved(str(number), (0, 0.2, 0))
        scene.prepare()
    for copied in (lambda value: pickle.loads(pickle.dumps(value)), copy.deepcopy):
        copied_tables = copied(scene._prepared)
        assert type(copied_tables.edit_state) is EditState
        assert np.array_equal(copied_tables.edit_state.places.planes, scene._prepared.edit_state.places.planes)
        copied_tables.edit_state.places.planes[:] = np.nan  # its own numbers
        assert not np.isnan(scene._prepared.edit_state.places.planes).any()

    monkeypatch.setattr(stores, "_edits", itertools.count(100))  # as in one process
    there = edited(edited(scene._prepared, "10"), "3")
    sent = pickle.dumps(there)
    monkeypatch.setattr(stores, "_edits", itertools.count(100))  # as in another, which was forked before
    one = edited(pickle.loads(sent), "4")
    other = edited(one, "3")
    edited(one, "6")  # gone at once
    last = edited(other, "7")
    assert content(of(last)) == content(co.Scene(list(last.entries)))


def edited(prepared, name):
    """Return the tables with one body moved, without a scene."""
    edit = prepare_edit([prepared], co.Scene(list(prepared.entries)).moved(name, (0.2, 0.1, 0)).bodies)
    assert isinstance(edit.edit_state, FullEditState)
    return edit


def of(prepared):
    """Return a prepared scene."""
    scene = co.Scene(list(prepared.entries))
    scene._cached_prepared = prepared
    return scene


def test_equal_edits_have_equal_numbers_in_any_memory(reuses):
    """Numbers between tables, behind them and at places in no leaf are equal too, because they go into files."""
    first = bodies(300, 3, (co.Plane((0, 0, 1), -3), co.HalfSpace((1, 0, 0), -20)))
    first.prepare()
    alone, gaps = [], 0
    for holds in (False, True):
        reuses.clear()
        scenes, scene, tables = [], first, None
        for number in range(40):
            scene = scene.moved(str(number % 25), (0.1, 0, 0.01 * number))
            scene.prepare()
            scenes += [scene] if holds else []
            alone += [] if holds else [[part.tobytes() for part in scene._prepared.geometry]]
            tables = scene._prepared.lowered.tables
            of_no_leaf = tables.tree_order[int(scene._prepared.woods.places[-1]) :] < 0
            assert not tables.leaf_items.reshape(-1, ROWS)[of_no_leaf].any()
            gaps += of_no_leaf.sum()
        assert sum(reuses[1:]) > 20 or holds
        assert not any(reuses[1:]) or not holds
    assert gaps > 100
    for scene, numbers in zip(scenes, alone, strict=True):
        assert [part.tobytes() for part in scene._prepared.geometry] == numbers


def test_the_collector_of_cycles_does_not_look_into_arrays():
    """`stores` relies on this."""
    assert not gc.is_tracked(np.zeros(3))
    assert not gc.is_tracked(np.asarray(stores._TokenArray(np.zeros(3), stores._LifetimeToken())))


def test_a_scene_that_comes_back_out_of_a_cycle_that_was_gone():
    back, first = [], bodies(30)
    first.prepare()

    class Window:
        def __init__(self, scene):
            self.scene, self.own = scene, self

        def __del__(self):
            for number in range(3, 9):  # takes whatever memory is free
                first.moved("0", (0, 0, 0.1)).moved(str(number), (0.5, 0.1, 0)).prepare()
            back.append(self.scene)

    scene = first.moved("1", (0, 0, 0.1))
    scene.prepare()
    scene = scene.moved("2", (0, 0, 0.1))
    expected = content(scene)
    Window(scene)
    del scene
    gc.collect()
    assert content(back[0]) == expected


def test_memory_is_given_up_with_the_last_scene(monkeypatch):
    """All memory is released when all scenes that could reuse it are gone."""
    alive = itertools.count(), []

    class Watched(stores.SceneBuffer):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            alive[1].append(next(alive[0]))
            self.number = alive[1][-1]

        def __del__(self):
            alive[1].remove(self.number)

    monkeypatch.setattr(stores, "SceneBuffer", Watched)
    first = bodies(30)
    first.prepare()
    scene = first
    for number in range(5):
        scene = scene.moved(str(number), (0, 0.1, 0))
        scene.prepare()
    assert len(alive[1]) == 2  # those of the last one, and of the first
    del scene
    gc.collect()
    assert len(alive[1]) == 2  # one may be reused
    del first
    gc.collect()
    assert alive[1] == []


def test_much_memory_is_not_kept(monkeypatch, reuses):
    monkeypatch.setattr(stores, "MOST", 1000)
    scene = bodies(30)
    for number in range(5):
        scene = scene.moved(str(number), (0, 0.1, 0))
        scene.prepare()
    same_tables(scene, co.Scene(scene.bodies))
    assert reuses == []  # the scene before left nothing


# --- A new scene overwrites a scene that nobody holds: the same tables, to the bit


@pytest.mark.parametrize("holds", [deep(False), True])
def test_trees_that_grow_out_of_the_memory(monkeypatch, holds):
    """There is no room for larger trees. So all tables go into new memory, whether an answer holds the old one or not."""
    monkeypatch.setattr(stores, "_NODE", 0)
    grown = []
    begin = exchange.InPlaceEdit.geometry

    def noted(self, empty):
        before = self._buffer
        result = begin(self, empty)
        grown.append(before is not None and before is not self._buffer)
        return result

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
        before, after = rewritten_leaves(scene)
        assert before == after
    same_answers(scene, anew, rng)
    assert sum(grown) > 3


def test_an_endless_body_in_reused_memory(reuses):
    """The limits of an endless body depend on the size of the scene, though other bodies move."""
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
    assert reuses == len(changes) * [True]
    first, larger, as_large, smaller = limits[:4]
    assert first != larger
    assert larger == as_large
    assert as_large != smaller


# --- Memory that passes from scene to scene is nobody else's: edits broken off anywhere, threads that trace meanwhile


PACKAGE = str(Path(co.__file__).parent)
COUNT = 24
ABOVE = np.array([[3.0 * k + 0.1, 0.1, 50.0] for k in range(COUNT)])
DOWN = np.tile([0.0, 0.0, -1.0], (COUNT, 1))
MOVES = [(4, (0, 0, 0.25)), (7, (0.1, 0, 0)), (3, (0, 0.1, 0.5)), (8, (0, 0, 1.0))]


class Broken(BaseException):
    """The exception that breaks an edit off."""


def in_a_row() -> list[Any]:
    """Return balls, turned boxes and Booleans, each 1 high and 3 from the next."""
    box = co.Box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    kinds = co.Sphere(0.5), box.rotate("z", 20), box - co.Sphere(0.3)
    return [kinds[k % 3].translate((3.0 * k, 0, 0)) for k in range(COUNT)]


def scene_after(moves: int) -> co.Scene:
    """Return the scene after so many moves. Nobody holds the scenes between."""
    scene = co.Scene(in_a_row())
    scene.prepare()
    for name, motion in MOVES[:moves]:
        scene = scene.moved(name, motion)
        scene.prepare()
    return scene


def breaks_off(scene: co.Scene, line: int) -> bool:
    """Prepare a scene until so many lines of the package have run; return whether that broke it off."""
    left = line

    def count(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal left
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        left -= event == "line"
        # No signal comes between the end of a `with` and the release of its lock
        if left < 0 and not linecache.getline(frame.f_code.co_filename, frame.f_lineno).lstrip().startswith("with "):
            sys.settrace(None)
            raise Broken
        return count

    before = sys.gettrace()
    sys.settrace(count)
    try:
        scene.prepare()
    except Broken:
        return True
    finally:
        sys.settrace(before)
    return False


def check_breaks(moves: int, held: bool, every: int) -> None:
    """Break the last of some moves off at every so many lines. Both scenes must be right afterwards."""
    expected, parent = content(scene_after(moves)), content(scene_after(moves - 1))
    line, was_broken = every // 2, True
    while was_broken:
        scene = scene_after(moves - 1)
        keep = scene if held else None
        edited = scene.moved(*MOVES[moves - 1])
        del scene
        was_broken = breaks_off(edited, line)
        assert content(edited) == expected, line
        assert keep is None or content(keep) == parent, line
        line += every
    assert line > 20 * every


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # broken off where memory comes back
@pytest.mark.parametrize(("moves", "held", "every"), [
    (1, False, 307), (3, True, 307), *deeper((moves, held, 13) for moves in (1, 2, 3, 4) for held in (False, True)),
])  # fmt: skip
def test_an_edit_broken_off_leaves_scenes_whole(moves, held, every):
    check_breaks(moves, held, every)


def test_threads_that_trace_see_the_scene_that_they_took():
    """One thread moves bodies and others trace the newest scene. The heights of all bodies must belong to one scene."""
    boxes = [co.Box((3.0 * k - 0.5, -0.5, -0.5), (3.0 * k + 0.5, 0.5, 0.5)) for k in range(COUNT)]
    current = [(co.Scene(boxes), np.full(COUNT, 0.5))]

    def trace(seed: int) -> int:
        rng, count = np.random.default_rng(seed), 0
        for _ in range(200):
            scene, heights = current[0]
            hits = scene.first_hit(ABOVE, DOWN)
            if rng.random() < 0.5:  # an answer outlives its scene
                del scene
            count += int(np.array_equal(ABOVE[:, 2] - hits.t, heights))
            assert (np.asarray(hits.normal) == [0, 0, 1]).all()
        return count

    switching = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(2) as pool:
            readers = [pool.submit(trace, seed) for seed in range(2)]
            rng = np.random.default_rng(7)
            while not all(reader.done() for reader in readers):
                scene, heights = current[0]
                name, step = int(rng.integers(COUNT)), float(rng.choice([-0.25, 0.25]))
                current[0] = scene.moved(name, (0, 0, step)), heights + step * (np.arange(COUNT) == name)
                del scene
                current[0][0].prepare()
    finally:
        sys.setswitchinterval(switching)
    assert [reader.result() for reader in readers] == [200, 200]


def test_memory_is_taken_by_its_own_name_alone():
    stores = BufferPool()
    first, second = (SceneBuffer(np.zeros(1, np.int32), np.zeros(1)) for _ in range(2))
    stores.give(first)
    assert stores.take(second) is None
    reuses = stores.take(first)
    assert reuses is not None
    assert stores.take(first) is None


def test_a_claim_keeps_borrowed_memory_from_others():
    """A claim keeps the memory of a scene while another one is made from it, even if the holder of an array lets it go."""
    scene = scene_after(1)
    memory, boxes = scene._prepared.edit_state.memory, scene._prepared.lowered.boxes
    del scene
    claim = memory.claim()
    assert claim.buffer is None
    assert claim.token is not None
    del boxes
    assert memory.stores.take() is None
    del claim
    assert memory.stores.take() is not None
