from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from .browser import launch


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
