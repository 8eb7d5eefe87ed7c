"""Worker processes of this machine, as an executor that survives the death of a process.

The pools of the standard library and of loky do not do three things. They cannot end a task that hangs: here a task has
a `timeout`, after which its process is killed (`watch`). They break as a whole when a process dies: here another
process takes over with the same task (the loop of `outcome_of`, `live_process`). And they import the main module again
in each process, so that a script needs `if __name__ == "__main__"`: here each process is a fresh interpreter that reads
tasks from its standard input (`serve`, `send` and `receive`) and inherits only the module path. All end with the
process that started them. Everything else is left to `concurrent.futures`.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from typing import Any

from .._util.validation import check_integer, check_positive
from ..kernels.threads import thread_count

_SERVE = "from conicoid.parallel.processes import serve; serve()"
"""The program of a worker process."""


class WorkerDeath(BrokenExecutor):
    """A process died with its task, or exceeded the time limit, more often than `retries` allows."""


class Processes(Executor):
    """An executor of processes on this machine.

    Functions and arguments are pickled, so functions must be those of modules. As a context manager it shuts down at
    the end.

    Parameters
    ----------
    count : int, optional
        Number of processes; by default one for each thread of this one.
    retries : int
        How often another process gets a task after one that died with it.
    timeout : float, optional
        Seconds for a task. After them its process is killed and counts as dead. None is any time.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    def __init__(self, count: int | None = None, *, retries: int = 3, timeout: float | None = None) -> None:
        self._max_workers = thread_count() if count is None else check_integer("Processes", "count", count, 1)
        self._retries = check_integer("Processes", "retries", retries, 0)
        self._timeout = None if timeout is None else check_positive("Processes", "timeout", timeout)
        self._queue: queue.SimpleQueue[tuple[Future[Any], bytes] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._is_open = True
        self._crew: list[_Worker] = []

    @property
    def pids(self) -> tuple[int, ...]:
        """The ids of the processes that are alive."""
        processes = [worker.process for worker in self._crew]
        return tuple(p.pid for p in processes if p is not None and p.poll() is None)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        data = pickle.dumps((fn, args, kwargs), protocol=5)
        # Under the lock no task can come after the end marks of `shutdown`.
        with self._lock:
            if not self._is_open:
                raise RuntimeError("cannot schedule new futures after shutdown")
            future: Future[Any] = Future()
            self._queue.put((future, data))
            if len(self._crew) < self._max_workers:
                self._crew.append(_Worker(self._queue, self._retries, self._timeout))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        with self._lock:
            self._is_open = False
            if cancel_futures:
                with contextlib.suppress(queue.Empty):
                    while (item := self._queue.get_nowait()) is not None:
                        item[0].cancel()
            for _ in self._crew:
                self._queue.put(None)
        if wait:
            for worker in self._crew:
                worker.thread.join()


class _Worker:
    """A thread that hands tasks to its own process, one after the other."""

    def __init__(self, tasks: queue.SimpleQueue[Any], retries: int, timeout: float | None) -> None:
        self.tasks, self.retries, self.timeout = tasks, retries, timeout
        self.process: subprocess.Popen[bytes] | None = None
        self.thread = threading.Thread(target=self.run, name="conicoid-worker", daemon=True)
        self.thread.start()

    def run(self) -> None:
        """Run tasks until there are no more."""
        try:
            while (item := self.tasks.get()) is not None:
                future, data = item
                if future.set_running_or_notify_cancel():
                    try:
                        is_value, outcome = self.outcome_of(data)
                    except BaseException as error:
                        is_value, outcome = False, error
                    (future.set_result if is_value else future.set_exception)(outcome)
                del item, future, data  # so that a waiting thread holds no result
        finally:
            self.end()

    def outcome_of(self, data: bytes) -> tuple[bool, Any]:
        """Return (is_value, the value or the exception) of a task."""
        late: list[bool] = []

        def expire(process: subprocess.Popen[bytes]) -> None:
            late.append(True)
            process.kill()

        # Each try has a live process: a dead one is replaced.
        for _ in range(self.retries + 1):
            try:
                process = self.live_process()
            except (OSError, EOFError):
                self.end()
                continue
            watch = None if self.timeout is None else threading.Timer(self.timeout, expire, (process,))
            if watch is not None:
                watch.daemon = True
                watch.start()
            try:
                send(process.stdin, data)
                answer = receive(process.stdout)
            except (OSError, EOFError):
                self.end()
                continue
            finally:
                if watch is not None:
                    watch.cancel()
            return pickle.loads(answer)
        if late:
            raise WorkerDeath(
                f"a task took longer than timeout={self.timeout:g} s in {len(late)} of {self.retries + 1} processes, "
                "which were ended"
            )
        raise WorkerDeath(f"{self.retries + 1} processes died in turn with the same task")

    def live_process(self) -> subprocess.Popen[bytes]:
        """Return the process; start a new one if it is dead."""
        if self.process is None or self.process.poll() is not None:
            self.end()
            # Absolute paths, as the module path may hold relative ones.
            paths = os.pathsep.join(dict.fromkeys(os.path.abspath(path) for path in sys.path))
            with _blocked_interrupts():
                self.process = subprocess.Popen(
                    [sys.executable, "-c", _SERVE],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    env={**os.environ, "PYTHONPATH": paths},
                )
            receive(self.process.stdout)  # wait until it is ready: its start is no part of a task's time limit
        return self.process

    def end(self) -> None:
        """Kill the process at once, as nobody waits for its answer."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            for pipe in (self.process.stdin, self.process.stdout):
                with contextlib.suppress(OSError):
                    if pipe is not None:
                        pipe.close()
            self.process = None


@contextlib.contextmanager
def _blocked_interrupts() -> Iterator[None]:
    """Block Ctrl-C in this thread and in processes that it starts, which else print a traceback before `serve` runs."""
    if os.name != "posix":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def send(pipe: Any, data: bytes) -> None:
    """Write one message: its length and its bytes."""
    pipe.write(len(data).to_bytes(8, "little"))
    pipe.write(data)
    pipe.flush()


def receive(pipe: Any) -> bytes:
    """Read one message. Raise EOFError if the other end is gone."""
    head = pipe.read(8)
    count = int.from_bytes(head, "little")
    data: bytes = pipe.read(count) if len(head) == 8 else b""
    if len(head) < 8 or len(data) < count:
        raise EOFError
    return data


# The other end of `Processes`: a process that runs one task after the other.


def serve() -> None:
    """Run the tasks on standard input until it ends. Their printed output goes to standard error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started this one
    if os.name == "posix":  # `_blocked_interrupts`
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # Keep both pipes under new numbers: standard output is redirected next, and answers must not mix with prints.
    tasks, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    sys.stdin = open(os.devnull)  # noqa: SIM115 - for the life of the process
    send(answers, b"ready")
    while True:
        try:
            data = receive(tasks)
        except EOFError:
            os._exit(0)
        try:
            call, arguments, keywords = pickle.loads(data)
            answer = pickle.dumps((True, call(*arguments, **keywords)), protocol=5)
        except BaseException as error:
            answer = _pickle_error(error)
        try:
            send(answers, answer)
        except OSError:
            os._exit(0)


def _pickle_error(error: BaseException) -> bytes:
    """Return a pickled exception; its text if it cannot be pickled."""
    try:
        data = pickle.dumps((False, error), protocol=5)
        pickle.loads(data)
        return data
    except Exception:
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")), protocol=5)
