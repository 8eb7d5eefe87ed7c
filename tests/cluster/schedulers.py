"""Real schedulers of Dask with worker processes of this machine."""

import contextlib
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
