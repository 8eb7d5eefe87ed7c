"""Arrays as a network brings them: read-only, and anywhere between the places of numbers."""

from __future__ import annotations

import pickle
from concurrent.futures import Executor, Future

import numpy as np

from . import subject


def brought(thing):
    """A thing whose arrays are views of one message, each at an odd place."""
    buffers = []
    told = pickle.dumps(thing, protocol=5, buffer_callback=buffers.append)
    parts = [bytes(buffer.raw()) for buffer in buffers]
    message = b"".join(b"!" * (1 + len(part) % 2) + part for part in parts)
    views, at = [], 0
    for part in parts:
        at += 1 + len(part) % 2
        views.append(memoryview(message)[at : at + len(part)])
        at += len(part)
    return pickle.loads(told, buffers=views)


class Messenger(Executor):
    """One worker, in this process, with whom all is exchanged by messages."""

    _max_workers = 1

    def submit(self, call, /, *arguments, **named):
        future = Future()
        try:
            call, arguments, named = brought((call, arguments, named))
            future.set_result(brought(call(*arguments, **named)))
        except Exception as error:
            future.set_exception(error)
        return future


def test_a_message_is_not_aligned():
    array = brought([np.arange(3.0), np.arange(5.0)])[1]
    assert not array.flags.aligned
    assert not array.flags.writeable
    assert array.tolist() == [0, 1, 2, 3, 4]


def test_every_query():
    scene = subject.scene()
    rays = subject.rays(700)
    wanted = subject.answers(scene, rays)
    assert subject.differing(wanted, subject.answers(scene, rays, executor=Messenger())) == []


def test_streams():
    scene, rays = subject.scene(), subject.rays(700)
    for query in ("first_hit", "spans", "crossings", "occluded"):
        parts = list(scene.stream(rays, query, executor=Messenger(), chunk=150))
        wanted = [getattr(scene, query)(rays[k : k + 150]) for k in range(0, 700, 150)]
        assert all(subject.same(a, b) for a, b in zip(parts, wanted, strict=True)), query
