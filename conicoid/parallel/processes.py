"""Worker processes of this machine, as an executor that outlives them.

Each is a fresh interpreter that reads tasks from its standard input, so no main module is imported again, as
`multiprocessing` does, and nothing is inherited but the path of modules. A process that dies, or takes longer for a
task than it may, costs its own task alone: another one takes over. They end with the process that started them.
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
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from typing import Any

from .._util.validation import as_integer, check_positive, format_value
from ..kernels.threads import thread_count

_SERVE = "from conicoid.parallel.processes import serve; serve()"


class WorkerDied(BrokenExecutor):
    """A process ended with its task, or was ended because it took too long, too often."""


class Processes(Executor):
    """`count` processes, by default one for each thread of this one.

    retries: how often a task is given to another process after one that died with it.
    timeout: seconds that a task may take before its process is ended and it counts as dead; None for any time.

    Functions and arguments are pickled, so functions are those of modules. As a context manager it shuts down in the
    end. Raises ValueError for senseless numbers.
    """

    def __init__(self, count: int | None = None, *, retries: int = 3, timeout: float | None = None) -> None:
        self._max_workers = thread_count() if count is None else _number("count", count, 1)
        self._retries = _number("retries", retries, 0)
        self._timeout = None if timeout is None else check_positive("Processes", "timeout", timeout)
        self._queue: queue.SimpleQueue[tuple[Future[Any], bytes] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._open = True
        self._crew: list[_Worker] = []

    @property
    def pids(self) -> tuple[int, ...]:
        """The numbers of the processes that are alive."""
        processes = [worker.process for worker in self._crew]
        return tuple(p.pid for p in processes if p is not None and p.poll() is None)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        data = pickle.dumps((fn, args, kwargs), protocol=5)
        with self._lock:
            if not self._open:
                raise RuntimeError("cannot schedule new futures after shutdown")
            future: Future[Any] = Future()
            self._queue.put((future, data))
            if len(self._crew) < self._max_workers:
                self._crew.append(_Worker(self._queue, self._retries, self._timeout))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        with self._lock:
            self._open = False
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
    """A thread that hands tasks to a process of its own, one after the other."""

    def __init__(self, tasks: queue.SimpleQueue[Any], retries: int, timeout: float | None) -> None:
        self.tasks, self.retries, self.timeout = tasks, retries, timeout
        self.process: subprocess.Popen[bytes] | None = None
        self.thread = threading.Thread(target=self.run, name="conicoid-worker", daemon=True)
        self.thread.start()

    def run(self) -> None:
        """Until there are no more tasks."""
        try:
            while (item := self.tasks.get()) is not None:
                future, data = item
                if future.set_running_or_notify_cancel():
                    try:
                        is_value, found = self.done(data)
                    except BaseException as error:
                        is_value, found = False, error
                    (future.set_result if is_value else future.set_exception)(found)
                del item, future, data
        finally:
            self.end()

    def done(self, data: bytes) -> tuple[bool, Any]:
        """(whether it is a value, the value or what was raised) of a task."""
        for _ in range(self.retries + 1):
            try:
                process = self.alive()
            except (OSError, EOFError):
                self.end()
                continue
            watch = None if self.timeout is None else threading.Timer(self.timeout, process.kill)
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
            found: tuple[bool, Any] = pickle.loads(answer)
            return found
        raise WorkerDied(f"{self.retries + 1} processes, one after the other, ended with the same task")

    def alive(self) -> subprocess.Popen[bytes]:
        """The process, or a new one."""
        if self.process is None or self.process.poll() is not None:
            self.end()
            paths = os.pathsep.join(dict.fromkeys(os.path.abspath(path) for path in sys.path))
            self.process = subprocess.Popen(
                [sys.executable, "-c", _SERVE],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env={**os.environ, "PYTHONPATH": paths},
            )
            receive(self.process.stdout)  # it is ready, so that no task pays for its start
        return self.process

    def end(self) -> None:
        """End the process: at once, as nobody waits for its answer."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            for pipe in (self.process.stdin, self.process.stdout):
                with contextlib.suppress(OSError):
                    if pipe is not None:
                        pipe.close()
            self.process = None


def send(pipe: Any, data: bytes) -> None:
    """Write one message: its length, and itself."""
    pipe.write(len(data).to_bytes(8, "little"))
    pipe.write(data)
    pipe.flush()


def receive(pipe: Any) -> bytes:
    """Read one message; EOFError where the other end is gone."""
    head = pipe.read(8)
    count = int.from_bytes(head, "little")
    data: bytes = pipe.read(count) if len(head) == 8 else b""
    if len(head) < 8 or len(data) < count:
        raise EOFError
    return data


def _number(name: str, value: Any, least: int) -> int:
    found = as_integer(value)
    if found is None or found < least:
        raise ValueError(f"Processes: {name} must be a whole number >= {least}, got {format_value(value)}")
    return found


# The other end of `Processes`: a process that does one task after the other.


def serve() -> None:
    """Answer tasks on standard input until it ends. What they print goes to standard error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asks
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
    """An exception as an answer; as its text where it cannot be pickled."""
    try:
        data = pickle.dumps((False, error), protocol=5)
        pickle.loads(data)
        return data
    except Exception:
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")), protocol=5)
