"""For all tests: no message of an error is longer than a screen.

Where there is no compiler, as beside a wheel, pytest skips the tests of the compiler and of the build.
"""

import gc
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from _pytest.raises import RaisesExc
from hypothesis import HealthCheck, settings

from . import messages, samples

HERE = Path(__file__).parent
OF_THE_COMPILER = (
    *("test_jit.py", "test_newest_numba.py", "engine/test_targets.py"),
    *("native/test_fma.py", "native/test_signature.py", "native/test_wheels.py"),
)
"""Tests that inspect compiled code, or link."""
_COMPILES = re.compile(r"^(import|from) (numba|llvmlite|\.+(compiled|emulation|lab|processors))\b", re.MULTILINE)


def _compile() -> list[str]:
    """Let tests compile functions themselves, such as inner functions of kernels."""
    files = HERE.rglob("test_*.py")
    return [str(file.relative_to(HERE)) for file in files if _COMPILES.search(file.read_text(encoding="utf-8"))]


collect_ignore = sorted({*OF_THE_COMPILER, *_compile()}) if find_spec("numba") is None else []


def pytest_configure(config: pytest.Config) -> None:
    """Let `samples` know which cases this run takes; no example of Hypothesis fails because a machine is slow."""
    samples.choose(config.option.markexpr)
    settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.load_profile("any machine")


def pytest_pycollect_makeitem(collector: pytest.Collector, obj: Any) -> list[pytest.Item] | None:
    """Make no tests that this run does not take."""
    marks = getattr(obj, "pytestmark", ())
    own = isinstance(marks, list) and any(mark.name == "deep" for mark in marks)
    return [] if samples.quick() and (own or collector.get_closest_marker("deep")) else None


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep of each deep test as many cases as a run takes, of those that `-k` leaves."""
    cases = defaultdict(list)
    for item in items:
        if item.get_closest_marker("deep"):
            cases[item.nodeid.partition("[")[0]].append(item)
    left = {item for name, those in cases.items() for item in {*those} - {*samples.drawn(those, samples.CASES, name)}}
    config.hook.pytest_deselected(items=[item for item in items if item in left])
    items[:] = [item for item in items if item not in left]


def pytest_collection_finish() -> None:
    """Exempt the objects of collection from later garbage collections, which would visit all of them each time."""
    gc.collect()
    gc.freeze()


def pytest_report_header() -> list[str]:
    """State which part of the cases this run takes, so that nobody takes it for the whole."""
    drawn = [] if samples.quick() else [f"deep tests are drawn by DEEP_SEED={samples.SEED}"]
    return drawn + ([f"no compiler: left out are {', '.join(collect_ignore)}"] if collect_ignore else [])


@pytest.fixture(autouse=True, scope="session")
def _messages_fit_on_a_screen() -> Iterator[None]:
    """Check the length of every message of the package that `pytest.raises` catches."""
    leave = RaisesExc.__exit__

    def looked_at(self: Any, kind: Any, error: Any, trace: Any) -> bool:
        if error is not None and messages.is_ours(trace):
            messages.check(str(error))
        return leave(self, kind, error, trace)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RaisesExc, "__exit__", looked_at)
        yield


@pytest.fixture
def noted_calls(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Any]]:
    """Return a function that lists the calls of another one from now on: their arguments, or a `note` of them."""

    def listed(owner: Any, name: str, note: Callable[..., Any] = lambda *arguments, **_: arguments) -> list[Any]:
        calls, usual = list[Any](), getattr(owner, name)

        def noted(*arguments: Any, **options: Any) -> Any:
            calls.append(note(*arguments, **options))
            return usual(*arguments, **options)

        monkeypatch.setattr(owner, name, noted)
        return calls

    return listed
