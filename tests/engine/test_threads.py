"""Chunks of work on threads: every one once, whatever their sizes and however many threads there are."""

import gc
import itertools
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co
from conicoid._jit.machine_code import SHIPPED
from conicoid._util import process
from conicoid.kernels import threads
from conicoid.kernels.crossings import trace_rows
from conicoid.kernels.first_hits import HitBuffers, trace_first
from conicoid.kernels.tables import GATES, HALT, LEAVES
from conicoid.queries.hit_fields import first_invalid, hit_points
from conicoid.queries.ray_queries import arrays_of

from ..machine_code import needs_machine_code

SCENE = co.Scene([co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2)), co.Spheres([(3, 0, 0), (5, 0, 0)], 0.5)])
STEPS_OF_SCENE = 2 * 1 + 3  # a difference of two leaves has one gate; three entries


@pytest.fixture
def four_threads(request):
    """Compute on four threads, or on as many as an indirect parameter says."""
    co.set_threads(getattr(request, "param", 4))
    yield
    co.set_threads(None)


def few_threads(monkeypatch, most: int) -> list[threading.Thread]:
    """Simulate a system that gives no more than so many threads at a time."""
    begun: list[threading.Thread] = []
    start = threading.Thread.start

    def start_some(thread):
        if sum(other.is_alive() for other in begun) >= most:
            raise RuntimeError("can't start new thread")
        begun.append(thread)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", start_some)
    return begun


@pytest.mark.parametrize("most", [0, 1, 2])
def test_work_continues_with_fewer_threads(four_threads, monkeypatch, most):
    begun, done = few_threads(monkeypatch, most), []
    threads.run_chunks(lambda a, b: done.extend(range(a, b)), 1000, 7)
    assert sorted(done) == list(range(1000))
    assert not any(thread.is_alive() for thread in begun)
    picture = SCENE.render(40, 40, samples=1).pixels
    hits = SCENE.first_hit(np.tile((0.1, 0.2, 5.0), (5000, 1)), (0.0, 0.0, -1.0))
    monkeypatch.undo()
    assert np.array_equal(picture, SCENE.render(40, 40, samples=1).pixels)
    assert np.array_equal(hits.t, SCENE.first_hit(np.tile((0.1, 0.2, 5.0), (5000, 1)), (0.0, 0.0, -1.0)).t)


def test_an_error_in_the_calling_thread_is_raised(four_threads, monkeypatch):
    few_threads(monkeypatch, 0)

    def fail(a: int, b: int) -> None:
        raise MemoryError(a)

    with pytest.raises(MemoryError):
        threads.run_chunks(fail, 100, 1)
    with pytest.raises(MemoryError):
        process.run_interruptible(lambda: fail(0, 1), "x")


def test_an_error_ends_the_others(four_threads):
    """The other chunks check whether they must end, as kernels do. Only two of the chunks ever begin."""
    begun: list[int] = []

    def work(geometry, begin: int, end: int) -> None:
        begun.append(begin)
        if begin == 0:
            raise MemoryError
        while not geometry.places[HALT]:
            pass

    co.set_threads(2)
    with pytest.raises(MemoryError):
        threads.run_on(SCENE._prepared.geometry, work, 100, 1, 1)
    assert len(begun) <= 2
    assert SCENE._prepared.geometry.places[HALT] == 0


def interrupted_at(event: int, outcome: list[BaseException | None]) -> None:
    """Run chunks on threads; raise KeyboardInterrupt at a line of `threads` or of `threading` below it.

    It is not raised in other functions, because Python swallows exceptions of weak references and of the collector.
    """
    left = [event]

    def counts(frame):
        return frame is not None and frame.f_code.co_filename == threads.__file__

    def trace(frame, kind, argument):
        del kind, argument
        if not (counts(frame) or (frame.f_code.co_filename == threading.__file__ and counts(frame.f_back))):
            return None
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt
        return trace

    sys.settrace(trace)
    try:
        threads.run_chunks(lambda begin, end: time.sleep(5e-3), 8, 1)
        outcome.append(None)
    except BaseException as error:  # the test checks which one
        outcome.append(error)
    finally:
        sys.settrace(None)


@pytest.mark.parametrize("first", range(1, 5))
def test_an_interrupt_between_any_two_lines_ends_the_wait(first):
    """No lock stays taken, and no other error follows."""
    co.set_threads(2)
    try:
        for event in range(first, 160, 4):
            outcome: list[BaseException | None] = []
            waiting = threading.Thread(target=interrupted_at, args=(event, outcome), daemon=True)
            waiting.start()
            waiting.join(60)
            assert outcome, f"the wait goes on after an interrupt at line {event}"
            if outcome[0] is None:  # all lines are done; how often the wait looks depends on the machine
                assert event > 60
                break
            assert isinstance(outcome[0], KeyboardInterrupt), (event, outcome)
    finally:
        co.set_threads(None)


@pytest.mark.parametrize("progress", [None, lambda done, count: None])
@pytest.mark.parametrize("count", [1, 2, 999, 1000])
def test_every_chunk_once(four_threads, count, progress):
    ranges = []
    threads.run_on(SCENE._prepared.geometry, lambda geometry, a, b: ranges.append((a, b)), count, 100, 1, progress)
    ends = sorted(ranges)
    assert [ends[0][0], ends[-1][1]] == [0, count]
    assert all(before[1] == after[0] for before, after in itertools.pairwise(ends))
    assert max(b - a for a, b in ranges) <= 100


# The threads of the extension


POINTS = 50_001
LINES = np.random.default_rng(1).normal(size=(2, POINTS, 3))
LENGTHS_ALONG = np.random.default_rng(2).normal(size=POINTS)


def points(chunk: int = 7) -> np.ndarray:
    """Return points along lines, by a kernel in chunks."""
    found = np.full((POINTS, 3), np.nan)
    threads.run_chunks(
        threads.KernelRange(hit_points, (*LINES, LENGTHS_ALONG), (found, np.zeros(1, np.int8))), POINTS, chunk
    )
    return found


@pytest.mark.parametrize("four_threads", [1, 2, 5], indirect=True)
def test_a_kernel_does_its_whole_range_on_threads_of_the_extension(four_threads):
    one = points(POINTS)
    assert not np.isnan(one).any()
    for chunk in (1, 7, 4096):
        assert np.array_equal(points(chunk), one)
    found: list[np.ndarray] = []
    callers = [threading.Thread(target=lambda: found.append(points())) for _ in range(20)]
    for thread in callers:
        thread.start()
    for thread in callers:
        thread.join()
    assert len(found) == 20
    assert all(np.array_equal(each, one) for each in found)


@needs_machine_code
def test_indivisible_work_is_refused():
    found = np.zeros((POINTS, 3)), np.zeros(1, np.int8)
    good = (*LINES, LENGTHS_ALONG, 0, POINTS, *found)
    refused = [
        (hit_points, (*LINES, LENGTHS_ALONG, 2, 1, *found), 7), (hit_points, good, 0), (hit_points, good, -1),
        (first_invalid, tuple(LINES), 7), (hit_points, (*LINES, LENGTHS_ALONG, 0, POINTS + 1, *found), 7),
    ]  # fmt: skip
    for arguments in refused:
        with pytest.raises(ValueError, match="^(hit_points|first_invalid)"):
            SHIPPED.pieces(*arguments, None)
    for wrong in (np.zeros(POINTS - 1, np.int8), np.zeros(POINTS), np.zeros((POINTS, 2), np.int8)[:, 0], "marks"):
        with pytest.raises((TypeError, ValueError, BufferError)):
            SHIPPED.pieces(hit_points, good, 7, wrong)
    for arguments in (
        (hit_points, good),
        (hit_points, list(good), 7, None),
        (print, good, 7, None),
        (hit_points, good[1:], 7, None),
    ):
        with pytest.raises(TypeError):
            SHIPPED.pieces(*arguments)
    for calls in ([good], (good, list(good)), (good, good[1:]), good):
        with pytest.raises(TypeError):
            SHIPPED.calls(hit_points, calls)
    with pytest.raises(TypeError):
        SHIPPED.calls(print, (good,))
    pieces = SHIPPED.pieces(hit_points, good, 7, None)
    for count in (0, -1, 1 << 20):
        with pytest.raises(ValueError, match="number of threads"):
            pieces.start(count)
    pieces.stop()
    pieces.help()
    assert pieces.wait(0)
    assert pieces.done == 0
    assert not found[0].any()


@needs_machine_code
def test_a_stop_ends_the_pieces_of_all_threads():
    """One ray of the scene takes seconds. After the stop all memory is released."""
    body = co.Sphere(1)
    for k in range(1500):
        body = co.Sphere(1 + (k + 1) / 1500) - body
    scene = co.Scene([body])._prepared
    rays = co.Rays(np.tile((0.1, 0.2, 5.0), (5000, 1)), (0.0, 0.0, -1.0))
    arrays, found = arrays_of("x", scene, rays, 0.0, np.inf), HitBuffers.new(5000)
    geometry = scene.geometry._replace(places=scene.geometry.places.copy())
    pieces = SHIPPED.pieces(trace_first, (geometry, arrays, 0, 0, 5, found), 1, None)
    assert pieces.start(2) == 2
    with pytest.raises(ValueError, match="they have come"):
        pieces.start(2)
    assert not pieces.wait(50)
    with pytest.raises(ValueError, match="at work"):
        pieces.results()
    pieces.stop()
    geometry.places[HALT] = 1
    last = time.monotonic() + 20
    while not pieces.wait(100):
        assert time.monotonic() < last
    assert pieces.done < 5
    references = sys.getrefcount(geometry.places)
    del pieces
    released = sys.getrefcount(geometry.places)
    assert released < references


@needs_machine_code
def test_an_interrupt_while_the_extension_works_keeps_its_memory(monkeypatch):
    class Slow:
        """Pieces of work whose wait is interrupted."""

        def __init__(self, *arguments):
            self.pieces = SHIPPED.pieces(*arguments)

        def wait(self, milliseconds):
            if milliseconds:
                raise KeyboardInterrupt
            return self.pieces.wait(0)

        def __getattr__(self, name):
            return getattr(self.pieces, name)

    monkeypatch.setattr(threads, "SHIPPED", SimpleNamespace(pieces=Slow))
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    with pytest.raises(KeyboardInterrupt):
        points()
    assert len(threads._stragglers) == 1
    last = time.monotonic() + 20
    while not threads._stragglers[0].wait(0):
        assert time.monotonic() < last
    monkeypatch.undo()
    points()
    co.set_threads(2)
    points()
    co.set_threads(None)
    assert not threads._stragglers


@needs_machine_code
def test_two_hundred_threads_of_python_query_one_scene_at_once(four_threads):
    """The first thread prepares the scene, and all share the threads of the extension."""
    random = np.random.default_rng(8)
    origins, directions = random.uniform(-3, 3, (4000, 3)), random.normal(size=(4000, 3))
    queries = (
        lambda scene: scene.first_hit(origins, directions).t, lambda scene: scene.spans(origins, directions).t_enter,
        lambda scene: scene.crossings(origins, directions).t, lambda scene: scene.occluded(origins, directions),
        lambda scene: scene.lengths(origins, directions), lambda scene: scene.contains(origins),
        lambda scene: scene.first_hit(origins[0], directions[0]).t,
        lambda scene: scene.render(40, 40, samples=1).pixels, lambda scene: scene.voxels(((-1, -1, -1), (1, 1, 1)), 9).body,
    )  # fmt: skip
    scene, gate, found = co.Scene(SCENE.bodies), threading.Barrier(200), [None] * 200

    def answer_of(number: int) -> None:
        gate.wait()
        found[number] = queries[number % len(queries)](scene)

    crowd = [threading.Thread(target=answer_of, args=(number,)) for number in range(200)]
    for thread in crowd:
        thread.start()
    for thread in crowd:
        thread.join()
    expected = [query(SCENE) for query in queries]
    for number, answer in enumerate(found):
        assert answer is not None, number
        assert np.array_equal(answer, expected[number % len(queries)]), number


def test_calls_of_a_kernel_have_results_in_order(four_threads):
    bad = LINES.copy()
    rows = range(0, 500, 5)
    for k in rows[1::2]:
        bad[0, k + k % 5] = np.nan
    found = threads.run_calls(first_invalid, [(bad[0, k : k + 5], bad[1, k : k + 5]) for k in rows])
    assert found == [(k % 5, 1) if n % 2 else (-1, 0) for n, k in enumerate(rows)]
    assert threads.run_calls(first_invalid, []) == []


def rows_of_spans(chunk: int, **options) -> np.ndarray:
    """Return rows of spans of many rays, by a kernel that returns arrays."""
    origins = np.random.default_rng(0).normal(size=(64 * 50, 3))
    arrays = arrays_of("x", SCENE._prepared, co.Rays(origins, (0.1, 0.2, -1.0)), 0.0, np.inf)
    counts, doubts = np.zeros(len(origins), np.int32), np.zeros(len(origins), np.int8)
    work = threads.KernelRange(trace_rows, (arrays, 0, True), (counts, doubts))
    found = threads.run_on(SCENE._prepared.geometry, work, 50, chunk, len(origins), **options)
    found.sort(key=lambda piece: piece[0])
    assert [found[0][0], found[-1][1]] == [0, 50]
    assert all(before[1] == after[0] for before, after in itertools.pairwise(found))
    return np.concatenate([np.asarray(rows) for _, _, rows in found])


@pytest.mark.parametrize("four_threads", [1, 4], indirect=True)
def test_a_kernel_reports_its_progress_and_keeps_its_results(four_threads):
    one, reports, marks = rows_of_spans(50), [], np.zeros(50, np.int8)
    assert len(one) > 100
    assert np.array_equal(rows_of_spans(3), one)
    assert np.array_equal(rows_of_spans(1, progress=lambda *now: reports.append(now), marks=marks), one)
    assert reports[-1] == (50, 50)
    assert reports == sorted(reports)
    assert marks.all()


def test_an_error_of_progress_ends_the_work(four_threads):
    def refuse(done, count):
        raise OSError(count)

    for _ in range(2):
        with pytest.raises(OSError, match="50"):
            rows_of_spans(1, progress=refuse)
    assert threads.has_ended(20)


@needs_machine_code
def test_idle_threads_beyond_the_present_number_end():
    co.set_threads(60)
    points()
    co.set_threads(2)
    last = time.monotonic() + 20
    while SHIPPED.keep_threads(2) > 2:
        assert time.monotonic() < last
        time.sleep(0.01)
    assert np.array_equal(points(), points(POINTS))
    co.set_threads(None)


@pytest.mark.parametrize(("rays", "one"), [(700, True), (30_000, False)])
def test_few_rays_in_small_scenes_start_no_thread(four_threads, monkeypatch, rays, one):
    """A start takes longer than their work. Many rays are distributed."""
    shared: list[str] = []
    for name in ("_run_in_pool", "_run_on_threads"):
        run = getattr(threads, name)
        monkeypatch.setattr(threads, name, lambda *rest, run=run: (shared.append(run.__name__), run(*rest))[1])
    origins = np.random.default_rng(0).normal(size=(rays, 3))
    for query in (
        SCENE.first_hit,
        SCENE.occluded,
        SCENE.crossings,
        SCENE.spans,
        lambda points, _: SCENE.body_at(points),
    ):
        shared.clear()
        query(origins, (0.1, 0.2, -1.0))
        assert bool(shared) != one
        assert SHIPPED is None or "_run_on_threads" not in shared


def test_chunks_grow_while_they_are_short_and_shrink_when_they_are_long():
    assert [threads.next_size(size, 0.001, 32) for size in (1, 4, 16, 20, 32)] == [2, 8, 32, 32, 32]
    assert threads.next_size(16, 0.02, 32) == 16
    assert [threads.next_size(size, 1.0, 32) for size in (1, 32)] == [1, 1]
    assert threads.next_size(32, 0.08, 32) == 4  # as many as take 10 ms


def test_memory_of_a_thread_is_for_the_largest_body():
    one, two = co.Sphere(1.0) - co.Box(), co.Sphere(1.0, (5, 0, 0)) - co.Box((4, 0, 0), (5, 1, 1)) - co.Sphere(0.2)
    three = two | (co.Sphere(1.0, (9, 0, 0)) & co.Box((8, 0, 0), (9, 1, 1)))

    def most(scene: co.Scene) -> list[int]:
        return scene._prepared.geometry.places[[LEAVES, GATES]].tolist()

    assert most(co.Scene([co.Sphere(1.0)])) == [1, 1]
    assert most(co.Scene([one] * 3)) == [2, 1]
    assert most(co.Scene([one, two])) == [3, 1]
    assert most(co.Scene([one, three, two])) == [5, 3]  # the union, and each of its parts
    scene = co.Scene([co.Body(one, name="one"), co.Body(two, name="two")])
    scene.prepare()
    assert most(scene.replace("one", three)) == [5, 3]


def test_bodies_of_a_scene_with_many_gates_are_traced_in_turn():
    """There are more bodies than are counted together. Each body's counts begin anew for each ray."""
    square = co.Union([co.Sphere(0.4, (x, y, 0)) - co.Sphere(0.2, (x, y, 0)) for x in range(16) for y in range(16)])
    many = [square.translate((16 * k, 0, 0)) for k in range(130)]
    shell = co.Sphere(1.0, (5, 5, 4)) - co.Sphere(0.5, (5, 5, 4))
    half = co.Sphere(1.0, (5, 5, -4)) & co.HalfSpace((0, 0, 1), -4)
    bodies = [*many, shell, half]
    scene = co.Scene(bodies)
    assert scene._prepared.lowered.tables.gate_start.size > 1 << 15
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (50, 3)) + (5.0, 5.0, 9.0)
    spans = scene.spans(points, (0.0, 0.0, -1.0))
    assert len(spans.t_enter) > 150
    for number in (0, 130, 131):  # rays meet these
        body = bodies[number]
        alone, own = co.Scene([body]).spans(points, (0.0, 0.0, -1.0)), spans.body == number
        assert np.array_equal(spans.t_enter[own], alone.t_enter)
        assert np.array_equal(spans.t_exit[own], alone.t_exit)
    assert set(spans.body.tolist()) == {0, 130, 131}


@pytest.mark.parametrize(("rays", "in_other_thread"), [(1, False), ((1 << 24) // STEPS_OF_SCENE + 1, True)])
def test_long_work_leaves_the_main_thread_free_for_control_c(rays, in_other_thread):
    workers = []
    threads.run_on(SCENE._prepared.geometry, lambda *_: workers.append(threading.current_thread()), 1, 1, rays)
    assert (workers[0] is not threading.main_thread()) == in_other_thread


# --- The pause of the garbage collector


@pytest.mark.skipif(sys.implementation.name != "cpython", reason="generations are CPython's")
@pytest.mark.parametrize("many", [False, True])
def test_objects_are_old_after_a_pause_of_the_collector_that_made_many(many, monkeypatch):
    """The next collection would go through all old objects. Few stay young, so that garbage among them goes soon."""
    monkeypatch.setattr(process, "_MANY_OBJECTS", 1000 if many else 1 << 40)
    gc.unfreeze()  # the pause leaves frozen objects alone, such as those of a parent before a fork
    with process.pause_gc():
        objects = [[] for _ in range(5000)]
    assert gc.isenabled()
    old = set(map(id, gc.get_objects(generation=2)))
    assert (sum(id(each) in old for each in objects) == len(objects)) == many
