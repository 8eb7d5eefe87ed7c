"""A kernel that compiles in no time, declared as if it stood in the package; and processes that use it.

Each use has a process of its own, forked from one that has the compiler at hand (and declares nothing itself).
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import sys
import types
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

SOURCE = """
from conicoid._jit.decorators import kernel

@kernel()
def doubled(x):
    return 2.0 * x
"""
LIMIT = 300.0

posix_only = pytest.mark.skipif(sys.platform == "win32", reason="owners, modes, limits and signals of POSIX")


def declared() -> Any:
    from conicoid._jit.disk_cache import PACKAGE

    module = sys.modules["conicoid.tiny"] = types.ModuleType("conicoid.tiny")
    exec(compile(SOURCE, str(PACKAGE / "tiny.py"), "exec"), vars(module))
    return module.doubled


def used() -> tuple[float, list[str]]:
    """The kernel's answer, and the kernels that were compiled for it."""
    from conicoid._jit.decorators import on_compile

    compiled: list[str] = []
    with on_compile(compiled.append):
        return declared()(21.0), compiled


COMPILED, LOADED = (42.0, ["doubled"]), (42.0, [])


@dataclass
class Outcome:
    code: int | None
    """As of a process: negative for a signal; None if it had not ended after minutes."""
    value: Any
    errors: str

    @property
    def quiet(self) -> bool:
        return self.code == 0 and self.errors == ""

    @property
    def one_line(self) -> bool:
        return self.code == 0 and self.errors.count("\n") == 1 and self.errors.endswith("\n")


class Apart:
    """Something that is done in a process of its own, with a folder for kernels."""

    def __init__(self, folder: Path, work: Callable[..., Any], *arguments: Any) -> None:
        if sys.platform == "win32":
            pytest.skip("needs forks")
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([__name__, f"{__package__}.compiler"])
        self.pipe, other = context.Pipe()
        self._errors, errors = context.Pipe(duplex=False)
        self._process = context.Process(target=_child, args=(other, errors, folder, work, arguments))
        self._process.start()
        other.close()
        errors.close()

    def outcome(self) -> Outcome:
        value = None
        if self.pipe.poll(LIMIT):
            with contextlib.suppress(EOFError):
                value = self.pipe.recv()
        self._process.join(LIMIT)
        code = self._process.exitcode
        self._process.kill()
        with open(self._errors.fileno(), "rb", closefd=False) as errors:
            return Outcome(code, value, errors.read().decode())


def apart(folder: Path, work: Callable[..., Any] = used, *arguments: Any) -> Outcome:
    return Apart(folder, work, *arguments).outcome()


here: Any = None
"""In such a process: a pipe to the test."""


def _child(pipe: Any, errors: Any, folder: Path, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    global here
    os.dup2(errors.fileno(), 2)
    errors.close()
    os.environ["CONICOID_CACHE_DIR"] = str(folder)
    here = pipe
    pipe.send(work(*arguments))


def kept(folder: Path) -> Path:
    """The one file of a kernel below a folder."""
    (found,) = folder.rglob("*.nbc")
    return found
