"""Processes that the tests of one folder share."""

import pytest

import conicoid as co


@pytest.fixture(scope="package")
def processes():
    """Two worker processes: each takes a second of processor time to start."""
    with co.parallel.Processes(2) as pool:
        yield pool
