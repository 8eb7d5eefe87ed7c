from collections.abc import Iterator
from typing import Any

import pytest

from .browser import launch
from .mirrors.workbench import Workbench
from .mirrors.worlds import exact_world, random_world, tied_world


@pytest.fixture(scope="session")
def playwright_tool() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    with api.sync_playwright() as tool:
        yield tool


@pytest.fixture(scope="session")
def browser(playwright_tool: Any) -> Iterator[Any]:
    found = launch(playwright_tool)
    yield found
    found.close()


@pytest.fixture(scope="session")
def workbench(browser: Any) -> Iterator[Workbench]:
    bench = Workbench(browser)
    for make_world in (exact_world, random_world, tied_world):
        bench.load(make_world())
    yield bench
    bench.close()


@pytest.fixture
def no_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Export pages as if no engine for them were built."""
    monkeypatch.setattr("conicoid.viewer.html.read_engine", lambda: None)
