"""For all tests: no message that any of them provokes is longer than a screen."""

from __future__ import annotations

from typing import Any

import pytest
from _pytest.raises import RaisesExc

from . import messages


@pytest.fixture(autouse=True)
def _messages_fit_on_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """What `pytest.raises` catches is looked at, where the package raised it."""
    leave = RaisesExc.__exit__

    def looked_at(self: Any, kind: Any, error: Any, trace: Any) -> bool:
        if error is not None and messages.is_ours(trace):
            messages.check(str(error))
        return leave(self, kind, error, trace)

    monkeypatch.setattr(RaisesExc, "__exit__", looked_at)
