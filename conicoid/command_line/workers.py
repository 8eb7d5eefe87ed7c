"""Where commands do their work: here, on processes of this machine, or on a cluster of Dask."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

_PATIENCE = "30s"


@contextlib.contextmanager
def executor_of(command: str, workers: int | None, cluster: str | None, slurm: int | None) -> Iterator[Any]:
    """The executor that the options ask for; None for this process."""
    given = [name for name, x in (("--workers", workers), ("--cluster", cluster), ("--slurm", slurm)) if x is not None]
    if len(given) > 1:
        raise ValueError(f"{command}: give either {' or '.join(given)}")
    if workers is not None:
        from ..cluster import Processes

        with Processes(workers) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    elif cluster is not None:
        with _client(command, cluster) as client:
            yield client
    elif slurm is not None:
        with _jobs(command, slurm) as client:
            yield client
    else:
        yield None


def _client(command: str, address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise ImportError("--cluster needs Dask: pip install 'conicoid[cluster]'") from None
    try:
        return Client(address, timeout=_PATIENCE)
    except (OSError, ValueError, RuntimeError) as error:
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise ValueError(f"{command}: --cluster: no scheduler answers at {address[:80]!r} ({first})") from None


@contextlib.contextmanager
def _jobs(command: str, count: int) -> Iterator[Any]:
    """A client of a scheduler here whose workers are jobs of Slurm; they are cancelled in the end."""
    try:
        from dask_jobqueue import SLURMCluster
        from distributed import Client
    except ImportError:
        raise ImportError("--slurm needs dask-jobqueue: pip install dask-jobqueue 'conicoid[cluster]'") from None
    try:
        made = SLURMCluster(scheduler_options={"dashboard_address": ":0"})
    except (ValueError, TypeError) as error:
        told = " ".join(str(error).split())[:200]
        raise ValueError(f"{command}: --slurm: what a job takes is said in Dask's jobqueue.yaml ({told})") from None
    with made as jobs, Client(jobs, timeout=_PATIENCE) as client:
        jobs.scale(jobs=count)
        yield client
