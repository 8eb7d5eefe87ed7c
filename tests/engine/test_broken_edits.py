"""Memory that goes from scene to scene is nobody else's: edits broken off anywhere, threads that trace meanwhile."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.edits.buffer_pool import BufferPool, SceneBuffer

from ..samples import in_turn
from .edits import content

PACKAGE = str(Path(co.__file__).parent)
COUNT = 24
ABOVE = np.array([[3.0 * k + 0.1, 0.1, 50.0] for k in range(COUNT)])
DOWN = np.tile([0.0, 0.0, -1.0], (COUNT, 1))
MOVES = [(4, (0, 0, 0.25)), (7, (0.1, 0, 0)), (3, (0, 0.1, 0.5)), (8, (0, 0, 1.0))]


class Broken(BaseException):
    """What an edit is broken off by."""


def in_a_row() -> list[Any]:
    """Balls, turned boxes and Booleans, each 1 high and 3 from the next."""
    box = co.Box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    kinds = co.Sphere(0.5), box.rotate("z", 20), box - co.Sphere(0.3)
    return [kinds[k % 3].translate((3.0 * k, 0, 0)) for k in range(COUNT)]


def after(moves: int) -> co.Scene:
    """The scene after so many moves, each made from the one before, of which nothing is left."""
    scene = co.Scene(in_a_row())
    scene.prepare()
    for name, motion in MOVES[:moves]:
        scene = scene.moved(name, motion)
        scene.prepare()
    return scene


def broken_off(scene: co.Scene, line: int) -> bool:
    """Prepare a scene until so many lines of the package have been run; was it broken off then?"""
    left = line

    def count(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal left
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        left -= event == "line"
        if left < 0:
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
    """Break the last of some moves off at every so manieth line; both scenes must be right afterwards."""
    expected, parent = content(after(moves)), content(after(moves - 1))
    line, was_broken = every // 2, True
    while was_broken:
        scene = after(moves - 1)
        keep = scene if held else None
        edited = scene.moved(*MOVES[moves - 1])
        del scene
        was_broken = broken_off(edited, line)
        assert content(edited) == expected, line
        assert keep is None or content(keep) == parent, line
        line += every
    assert line > 20 * every


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # broken off where memory comes back
@pytest.mark.parametrize(("moves", "held"), in_turn([1, 3], [False, True]))
def test_an_edit_broken_off_leaves_scenes_whole(moves, held):
    check_breaks(moves, held, 307)


@pytest.mark.deep
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("moves", [1, 2, 3, 4])
def test_an_edit_broken_off_at_many_lines_leaves_scenes_whole(moves, held):
    check_breaks(moves, held, 13)


def test_threads_that_trace_see_the_scene_that_they_took():
    """A thread moves bodies and others trace what they find; heights of all bodies belong to each scene."""
    boxes = [co.Box((3.0 * k - 0.5, -0.5, -0.5), (3.0 * k + 0.5, 0.5, 0.5)) for k in range(COUNT)]
    current = [(co.Scene(boxes), np.full(COUNT, 0.5))]

    def trace(seed: int) -> int:
        rng, seen = np.random.default_rng(seed), 0
        for _ in range(200):
            scene, heights = current[0]
            hits = scene.first_hit(ABOVE, DOWN)
            if rng.random() < 0.5:  # an answer outlives its scene
                del scene
            seen += int(np.array_equal(ABOVE[:, 2] - hits.t, heights))
            assert (np.asarray(hits.normal) == [0, 0, 1]).all()
        return seen

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


def test_memory_that_is_asked_for_by_name_is_not_taken_for_another():
    stores = BufferPool()
    first, second = (SceneBuffer(np.zeros(1, np.int32), np.zeros(1)) for _ in range(2))
    stores.give(first)
    assert stores.take(second) is None
    taken = stores.take(first)
    assert taken is not None
    assert stores.take(first) is None


def test_a_claim_keeps_memory_that_somebody_held_from_others():
    """Who holds an array of the scene may let it go while the scene is read by which another one is made from it."""
    scene = after(1)
    memory, boxes = scene._prepared.edit_state.memory, scene._prepared.lowered.boxes
    assert memory is not None
    del scene
    claim = memory.claim()
    assert claim is not None
    assert claim.buffer is None
    assert claim.token is not None
    del boxes
    assert memory.stores.take() is None
    del claim
    assert memory.stores.take() is not None
