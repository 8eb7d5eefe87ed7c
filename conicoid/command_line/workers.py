"""Where commands do their work: here, on processes of this machine, or on a cluster of Dask."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Annotated, Any

import typer

WorkersOption = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes to do it, instead of threads.", show_default=False)
]
ClusterOption = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="Dask's scheduler to do it, as tcp://host:8786.", show_default=False
    ),
]  # fmt: skip
_PATIENCE = "30s"


@contextlib.contextmanager
def executor_of(command: str, workers: int | None, cluster: str | None) -> Iterator[Any]:
    """The executor that the options ask for; None for this process."""
    if workers is not None and cluster is not None:
        raise ValueError(f"{command}: give either --workers or --cluster")
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
