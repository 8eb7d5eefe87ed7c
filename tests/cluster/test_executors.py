"""Queries on executors: the same bits as without, for every size of chunks, and plain messages for what cannot be."""

import multiprocessing
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.parallel import processes as own_processes, shared_state as recipe, workers as task
from conicoid.parallel.shared_state import source_version
from conicoid.parallel.workers import ChunkSize

from . import subject

# --- Queries on executors: the same bits as without, for every size of chunks, and plain messages for what cannot be


@pytest.mark.parametrize("chunk", [7, 4096, None])
def test_processes_answer_to_the_bit(processes, chunk):
    scene, rays = subject.scene(), subject.rays(5, 40)
    local = subject.answers(scene, rays)
    far = subject.answers(scene, rays, executor=co.parallel.Workers(processes, chunk=chunk))
    assert subject.differences(local, far) == []


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="processes are not forked here")
def test_pools_of_the_standard_library():
    scene, rays = subject.scene(), subject.rays(100)
    local = subject.answers(scene, rays)
    pools = ThreadPoolExecutor(2), ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork"))
    for pool in pools:
        with co.parallel.Workers(pool, chunk=33) as workers:
            assert subject.differences(local, subject.answers(scene, rays, executor=workers)) == []


def test_answers_know_the_scene(processes):
    scene, rays = subject.scene(), subject.rays(50)
    hits = scene.first_hit(rays, executor=processes)
    assert "ball" in hits.name
    again = scene.first_hit(hits.spawn((0.0, 0.0, 1.0)), executor=processes)  # they know the surface that they start on
    assert again == scene.first_hit(scene.first_hit(rays).spawn((0.0, 0.0, 1.0)))


def test_without_a_shared_disk_a_recipe_is_sent_on_demand(processes, monkeypatch):
    scene, rays = subject.large_scene(), subject.rays(600)
    monkeypatch.setattr(recipe.SharedObject, "_written", lambda self: None)  # as on a full disk
    far = scene.first_hit(rays, executor=co.parallel.Workers(processes, chunk=50))
    assert far == scene.first_hit(rays)


def test_damaged_recipes_are_not_unpickled(tmp_path):
    scene = subject.large_scene()
    reference = recipe.shared_scene(scene).reference()
    with open(reference.path, "r+b") as file:
        file.write(b"other")
    other = recipe.SharedReference(reference.key, None, reference.path)
    recipe._own_objects.pop(reference.key)
    assert recipe.find_shared(other) == ()


def test_progress_and_window(processes):
    calls = []
    workers = co.parallel.Workers(processes, chunk=10, window=3, progress=lambda *step: calls.append(step))
    subject.scene().occluded(subject.rays(100), executor=workers)
    assert calls[-1] == (100, 100)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)


class CountingPool(ThreadPoolExecutor):
    """An executor that counts tasks."""

    def __init__(self):
        super().__init__(1)
        self.futures = []

    def submit(self, *arguments):
        future = super().submit(*arguments)
        self.futures.append(future)
        return future


def test_memory_is_bounded_by_the_window():
    pool = CountingPool()
    workers = co.parallel.Workers(pool, chunk=10, window=4)
    parts = subject.scene().stream(subject.rays(1000), executor=workers)
    next(parts)
    assert len(pool.futures) <= 1 + 4 + 1  # the task for the version, and the window
    parts.close()
    pool.shutdown()


class IdlePool(ThreadPoolExecutor):
    """An executor that answers its version and never finishes another task."""

    def __init__(self):
        super().__init__(1)
        self.futures = []

    def submit(self, call, *arguments):
        if arguments == ("conicoid.__version__",):
            return super().submit(call, *arguments)
        self.futures.append(Future())
        return self.futures[-1]


def test_queued_tasks_are_cancelled():
    def interrupted(done, count):
        raise KeyboardInterrupt

    with IdlePool() as pool, pytest.raises(KeyboardInterrupt):
        workers = co.parallel.Workers(pool, chunk=10, window=5, progress=interrupted)
        subject.scene().occluded(subject.rays(1000), executor=workers)
    assert [future.cancelled() for future in pool.futures] == [True] * 5


def test_closed_executors_are_named(processes):
    closed = co.parallel.Processes(1)
    closed.shutdown()
    with pytest.raises(ValueError, match=r"first_hit: executor takes no more tasks, it was shut down"):
        subject.scene().first_hit(subject.rays(5), executor=closed)


@pytest.mark.parametrize("wrong", [3, "tcp://here:1", ThreadPoolExecutor, object()])
def test_other_objects_are_refused_as_executors(wrong):
    with pytest.raises(TypeError, match=r"first_hit: executor must be a concurrent.futures.Executor"):
        subject.scene().first_hit(subject.rays(5), executor=wrong)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(chunk=0), "Workers: chunk must be an integer >= 1, got 0"),
        (dict(window=1.5), "Workers: window must be an integer >= 1, got 1.5"),
        (dict(threads=-1), "Workers: threads must be an integer >= 1, got -1"),
    ],
)
def test_senseless_numbers(options, message):
    with pytest.raises(ValueError, match=re.escape(message)), ThreadPoolExecutor(1) as pool:
        co.parallel.Workers(pool, **options)


class OtherVersionPool(ThreadPoolExecutor):
    """Workers that answer with another version."""

    def __init__(self, version):
        super().__init__(1)
        self.version = version

    def submit(self, call, *arguments):
        if arguments == ("conicoid.__version__",):
            return super().submit(lambda: self.version)
        return super().submit(call, *arguments)


@pytest.mark.parametrize(
    ("version", "message"),
    [("0.0.9", f"have conicoid 0.0.9, and this process has {co.__version__}"), (None, "have no conicoid")],
)
def test_workers_of_another_version_are_refused(version, message):
    message = re.escape(f"first_hit: executor: its workers {message}")
    with OtherVersionPool(version) as pool, pytest.raises(ValueError, match=message):
        subject.scene().first_hit(subject.rays(5), executor=pool)


def test_a_worker_of_other_sources_refuses():
    version = "0.1.0 (sources 12345678)"
    message = f"has conicoid {source_version()}, and this process has {version}"
    with pytest.raises(ValueError, match=re.escape(message)):
        task.run_task(version, (), 1, os.getpid)


class BrokenPool(ThreadPoolExecutor):
    """A pool that breaks at its second task, as if a process had died."""

    def __init__(self):
        super().__init__(1)
        self.tasks = 0

    def submit(self, *arguments):
        self.tasks += 1
        if self.tasks == 2:
            future = Future()
            future.set_exception(BrokenProcessPool("a process died"))
            return future
        return super().submit(*arguments)


def test_a_broken_pool_is_made_again():
    scene, rays, pools = subject.scene(), subject.rays(100), []

    def make():
        pools.append(BrokenPool() if not pools else ThreadPoolExecutor(1))
        return pools[-1]

    with co.parallel.Workers(make, chunk=9) as workers:
        assert scene.first_hit(rays, executor=workers) == scene.first_hit(rays)
    assert len(pools) == 2
    with BrokenPool() as pool, pytest.raises(ValueError, match=r"executor is broken.*co.parallel.Processes\(n\)"):
        scene.first_hit(rays, executor=pool)


def test_chunks_follow_the_rate():
    pace = ChunkSize(None, 4096, 1 << 20, 2)
    assert next(pace.pieces(0, 10**9)) == (0, 4096)
    pace.saw(4096, 0.001)  # four million a second
    assert pace.size == 8 * 4096
    for _ in range(9):
        pace.saw(pace.size, pace.size / 4e6)
    assert pace.size == 1 << 20
    pace.saw(1 << 20, 4.0)
    assert pace.size == 1 << 18
    pieces = list(ChunkSize(None, 10, 1000, 2).pieces(0, 35))
    assert pieces == [(0, 10), (10, 20), (20, 30), (30, 35)]


def test_errors_of_tasks_reach_the_asker(processes):
    wrong = np.concatenate([subject.rays(9).origins, np.zeros((9, 3))], axis=1)  # a worker finds this out
    with pytest.raises(ValueError, match=r"Rays: direction must not be zero.* for ray\[0\]"):
        list(subject.scene().stream(wrong, executor=processes))


def test_threads_of_a_task():
    from conicoid.kernels.threads import limit_threads, thread_count

    co.set_threads(3)
    try:
        with limit_threads(1):
            assert thread_count() == 1
            others = []
            thread = threading.Thread(target=lambda: others.append(thread_count()))
            thread.start()
            thread.join()
        assert others == [3]  # it does not bind other threads
        assert thread_count() == 3
    finally:
        co.set_threads(None)


def test_tasks_of_processes_that_die(processes):
    first = processes.submit(os.getpid).result()
    with pytest.raises(co.parallel.processes.WorkerDeath), co.parallel.Processes(1, retries=1) as mortal:
        mortal.submit(os._exit, 1).result()
    assert processes.submit(pow, 2, 5).result() == 32
    assert first in processes.pids


@pytest.mark.skipif(os.name != "posix", reason="Windows has no masks of signals")
def test_control_c_while_a_process_starts(monkeypatch):
    """The terminal sends Ctrl-C to all processes. Those that were still importing printed a traceback and died."""
    program = f"import os, signal; os.kill(os.getpid(), signal.SIGINT); {own_processes._SERVE}"
    monkeypatch.setattr(own_processes, "_SERVE", program)
    with own_processes.Processes(1, retries=0) as pool:
        assert pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result() == set()


def test_tasks_that_take_too_long_are_ended():
    began = time.monotonic()
    with co.parallel.Processes(1, retries=0, timeout=1) as pool:
        slow = pool.submit(time.sleep, 3600)
        with pytest.raises(co.parallel.processes.WorkerDeath, match="took longer than timeout=1 s"):
            slow.result()
        assert pool.submit(abs, -1).result() == 1
    assert time.monotonic() - began < 600


# --- Arrays as a network brings them: read-only, and anywhere between the places of numbers


def unaligned(value):
    """Return an object whose arrays are views of one message, each at an odd byte."""
    buffers = []
    main = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    parts = [bytes(buffer.raw()) for buffer in buffers]
    message = b"".join(b"!" * (1 + len(part) % 2) + part for part in parts)
    views, at = [], 0
    for part in parts:
        at += 1 + len(part) % 2
        views.append(memoryview(message)[at : at + len(part)])
        at += len(part)
    return pickle.loads(main, buffers=views)


class Messenger(Executor):
    """One worker in this process, which exchanges all objects by messages."""

    _max_workers = 1

    def submit(self, call, /, *arguments, **named):
        future = Future()
        try:
            call, arguments, named = unaligned((call, arguments, named))
            future.set_result(unaligned(call(*arguments, **named)))
        except Exception as error:
            future.set_exception(error)
        return future


def test_a_message_is_not_aligned():
    array = unaligned([np.arange(3.0), np.arange(5.0)])[1]
    assert not array.flags.aligned
    assert not array.flags.writeable
    assert array.tolist() == [0, 1, 2, 3, 4]


def test_every_query():
    scene = subject.scene()
    rays = subject.rays(700)
    expected = subject.answers(scene, rays)
    assert subject.differences(expected, subject.answers(scene, rays, executor=Messenger())) == []


# --- The process of the user logs notes of workers once; nobody reads the logs of workers


@pytest.fixture
def overlap_warnings(caplog):
    """Return the warnings on overlaps from Conicoid's log."""
    return lambda: [r.getMessage() for r in caplog.records if "through two bodies at once" in r.getMessage()]


@pytest.mark.parametrize("kind", ["processes", "threads", "none"])
def test_overlaps_are_reported_once(kind, processes, overlap_warnings):
    scene, rays = subject.scene(), subject.rays(200)  # its ball and corners overlap
    pool = dict(processes=processes, threads=ThreadPoolExecutor(2), none=None)[kind]
    executor = None if pool is None else co.parallel.Workers(pool, chunk=20)
    scene.line_integral(subject.VALUES, rays, executor=executor)
    assert len(overlap_warnings()) == 1
    assert overlap_warnings()[0].startswith("line_integral: ")
    list(scene.stream(rays, "line_integral", values=subject.VALUES, executor=executor))
    scene.line_integral(subject.VALUES, rays)
    assert len(overlap_warnings()) == 1  # the log has the note of this scene already
    subject.scene().line_integral(subject.VALUES, rays, executor=executor)
    assert len(overlap_warnings()) == 2
    subject.scene().line_integral(subject.VALUES, rays, executor=executor, overlaps="both")
    assert len(overlap_warnings()) == 2


# --- Executors of other packages: loky's and MPI's


PROGRAM = """
from mpi4py import MPI
from mpi4py.futures import MPIPoolExecutor
import conicoid as co
from tests.cluster import subject
if __name__ == "__main__":
    scene, rays = subject.scene(), subject.rays(5, 40)
    with MPIPoolExecutor() as pool:
        assert pool.submit(MPI.COMM_WORLD.Get_rank).result() != 0  # another process runs it
        how = co.parallel.Workers(pool, chunk=33)
        far = subject.answers(scene, rays, executor=how)
        picture = scene.render(70, 40, executor=pool)
    assert subject.differences(subject.answers(scene, rays), far) == []
    assert (picture.pixels == scene.render(70, 40).pixels).all()
    print("the same,", MPI.COMM_WORLD.Get_size(), "processes")
"""


def test_mpi(tmp_path):
    pytest.importorskip("mpi4py", reason="mpi4py is not installed", exc_type=ImportError)
    launcher = shutil.which("mpiexec", path=os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])))
    if launcher is None:
        pytest.skip("no mpiexec is installed")
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [launcher, "-n", "3", sys.executable, "-m", "mpi4py.futures", tmp_path / "program.py"]
    paths = os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {
        "PYTHONPATH": paths,
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    }
    process = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)
    assert process.returncode == 0, process.stderr
    assert "the same, 3 processes" in process.stdout


@pytest.mark.parametrize("package", ["loky", "joblib.externals.loky"])
def test_loky(package):
    loky = pytest.importorskip(package)
    scene, rays = subject.scene(), subject.rays(5, 40)
    pool = loky.get_reusable_executor(max_workers=2)
    try:
        assert subject.differences(subject.answers(scene, rays), subject.answers(scene, rays, executor=pool)) == []
    finally:
        pool.shutdown(kill_workers=True)
