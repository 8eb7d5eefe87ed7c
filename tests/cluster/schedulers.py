"""Real schedulers of Dask with worker processes of this machine."""

import contextlib
import socket
import subprocess
import sys
import threading


def cluster(workers, threads=1, **options):
    """Start a scheduler and its workers. Its page takes any free port, because another test may have one open."""
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=workers, threads_per_worker=threads, processes=True, dashboard_address=":0", **options
    )


class PersistentWorker:
    """A process of `dask worker`, which starts again whenever it ends, as under Kubernetes.

    Dask's nannies give up where a worker dies while they start it.
    """

    def __init__(self, address):
        self.command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
        self.started, self.ends = 0, threading.Event()
        self.thread = threading.Thread(target=self._keep, daemon=True)
        self.thread.start()

    def _keep(self):
        while not self.ends.is_set():
            process = subprocess.Popen(
                [*self.command, "--no-dashboard", "--no-nanny"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            self.started += 1
            while process.poll() is None and not self.ends.wait(0.2):
                pass
            process.kill()  # a graceful end waits half a minute for the worker's task
            process.wait(60)


@contextlib.contextmanager
def workers(*addresses):
    """Run a worker for each address until the block ends."""
    processes = [PersistentWorker(address) for address in addresses]
    try:
        yield processes
    finally:
        for one in processes:
            one.ends.set()
        for one in processes:
            one.thread.join(60)


# --- A connection that tests can cut: it forwards one port to another until it drops all


class Proxy:
    """Forward connections to `port` of this machine to `target`, both ways."""

    def __init__(self, target):
        self.target = target
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.lock, self.open, self.made = threading.Lock(), [], 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.server.accept()
                far = socket.create_connection(self.target)
                with self.lock:
                    self.made += 1
                    self.open += [near, far]
                for one, other in ((near, far), (far, near)):
                    threading.Thread(target=self._pass_on, args=(one, other), daemon=True).start()

    def _pass_on(self, one, other):
        with contextlib.suppress(OSError):
            while data := one.recv(1 << 16):
                other.sendall(data)
        self._end(one, other)

    def drop(self):
        """Cut all connections and return how many there were. New ones pass."""
        with self.lock:
            cut, self.open = self.open, []
        self._end(*cut)
        return len(cut) // 2

    def close(self):
        self.server.close()
        self.drop()

    @staticmethod
    def _end(*sockets):
        for each in sockets:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
