"""Connections that break while work goes on: of workers to their scheduler, and of the client."""

import time

import pytest

import conicoid as co

from . import subject
from .schedulers import Proxy, cluster, workers

distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.filterwarnings(
    "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning", "ignore::RuntimeWarning"
)


@pytest.fixture
def wires():
    """Return (address, proxy) of a scheduler without workers behind a proxy, and its own address."""
    with cluster(0) as scheduler:
        host, _, port = scheduler.scheduler_address.removeprefix("tcp://").partition(":")
        proxy = Proxy((host, int(port)))
        try:
            yield f"tcp://127.0.0.1:{proxy.port}", proxy, scheduler.scheduler_address
        finally:
            proxy.close()


@pytest.mark.parametrize(
    ("broken", "times"),
    [("the asker's", 1), *(pytest.param(whose, 5, marks=pytest.mark.deep) for whose in ("a worker's", "the asker's"))],
)
def test_a_connection_that_breaks(wires, broken, times):
    over_proxy, proxy, directly = wires
    scene, rays = subject.scene(), subject.rays(100, 200)
    expected, cuts = scene.first_hit(rays), []
    of_worker, of_client = (over_proxy, directly) if broken == "a worker's" else (directly, over_proxy)
    addresses = {directly, of_worker}
    with workers(*addresses), distributed.Client(of_client) as client:
        client.wait_for_workers(len(addresses), timeout=120)
        until = time.monotonic() + 120

        def cut(done, count):
            assert time.monotonic() < until, "nothing comes back"
            if len(cuts) < times and done >= (len(cuts) + 1) * count // (times + 1):
                cuts.append(proxy.drop())

        executor = co.parallel.Workers(client, chunk=500, retries=20, progress=cut)
        assert scene.first_hit(rays, executor=executor) == expected
    assert len(cuts) == times
    assert cuts[0] > 0
