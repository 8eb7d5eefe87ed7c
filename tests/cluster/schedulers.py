"""Real schedulers of Dask with worker processes of this machine."""

from __future__ import annotations


def cluster(workers, threads=1, **options):
    """A scheduler and its workers; its page is at any free port, as another test may have one open."""
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=workers, threads_per_worker=threads, processes=True, dashboard_address=":0", **options
    )
