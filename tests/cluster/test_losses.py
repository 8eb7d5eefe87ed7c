"""Workers, results and connections that are lost under Dask: the work goes on, or an error says that it does not."""

import sys
import threading
import time

import pytest

import conicoid as co
from conicoid.parallel.workers import ScheduledTask, Scheduler

from ..samples import sampled
from . import subject, tasks
from .schedulers import cluster, workers

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="signals"),
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(scope="module")
def client():
    """Return the client of a scheduler that gives a task up as soon as one worker has died with it.

    Dask's own limit is four.
    """
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        cluster(0) as scheduler,
        workers(scheduler.scheduler_address),
        distributed.Client(scheduler) as client,
    ):
        yield client


def result_of(executor, call, *arguments, patience=200, **options):
    """Return the result of a task, or fail if there is none after so many seconds."""
    until = time.monotonic() + patience

    def still(*_):
        assert time.monotonic() < until, "nothing comes back"

    course = Scheduler("test", co.parallel.Workers(executor, progress=still, **options), call, ())
    ((_, value),) = course.results(iter([ScheduledTask(0, 1, arguments)]), lambda *_: None, 1)
    return value


@pytest.mark.parametrize("of", sampled(["client", "its own executor"], 2))
def test_a_task_that_was_given_up_is_sent_again_as_another(client, tmp_path, of):
    executor = client if of == "client" else client.get_executor()
    assert result_of(executor, tasks.dies, tmp_path / "counts", 2) > 0


def test_a_worker_dies_while_its_result_is_fetched(client, tmp_path):
    with pytest.raises(ValueError, match="the second one fails by itself"):
        result_of(client, tasks.dies_in_transfer, tmp_path / "counts")


def test_a_client_may_be_closed_during_the_work(client):
    second = distributed.Client(client.scheduler.address)
    closing = threading.Timer(1.0, second.close)
    closing.start()
    with pytest.raises(ValueError, match="test: executor .*(shut down|lost its scheduler)"):
        result_of(second, tasks.slow, 60.0)
    closing.join()
    with pytest.raises(ValueError, match="first_hit: executor takes no more tasks"):
        subject.scene().first_hit(subject.rays(3), executor=second)
