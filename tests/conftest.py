"""For all tests: no message that any of them provokes is longer than a screen.

Where there is no compiler, as beside an installed wheel, the tests of the compiler and of what it builds are left out.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import pytest
from _pytest.raises import RaisesExc

from . import messages

OF_THE_COMPILER = [
    *("kernel_cache", "test_jit.py", "test_newest_numba.py", "numbers/test_bits.py", "numbers/test_elementary.py"),
    *("engine/test_assembly.py", "engine/test_items.py", "engine/test_pairs.py", "engine/test_simd_lists.py"),
    "engine/test_targets.py",
    *("native/test_arithmetic.py", "native/test_fma.py", "native/test_inspection.py", "native/test_signature.py"),
    *("native/test_wheels.py", "render/test_sampler.py", "shading/test_formulas.py"),
]
"""What inspects compiled code, calls a kernel's inner functions compiled alone, or links."""
collect_ignore = OF_THE_COMPILER if find_spec("numba") is None else []


def pytest_report_header() -> list[str]:
    """Said, so that nobody takes less for the whole."""
    return [f"no compiler: left out are {', '.join(collect_ignore)}"] if collect_ignore else []


@pytest.fixture(autouse=True)
def _messages_fit_on_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """What `pytest.raises` catches is looked at, where the package raised it."""
    leave = RaisesExc.__exit__

    def looked_at(self: Any, kind: Any, error: Any, trace: Any) -> bool:
        if error is not None and messages.is_ours(trace):
            messages.check(str(error))
        return leave(self, kind, error, trace)

    monkeypatch.setattr(RaisesExc, "__exit__", looked_at)
