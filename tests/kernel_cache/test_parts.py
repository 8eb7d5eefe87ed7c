"""A kernel that is made of other functions is kept under a name that says which; with one of somebody else's, it is not kept."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest
from numba.core.registry import cpu_target

from conicoid._jit.decorators import helper
from conicoid._jit.dispatch import PLAIN
from conicoid._jit.numba_cache import KernelCache
from conicoid.render.integrators import INTEGRATORS, Integrator
from conicoid.render.tiles import _tile_kernel

pytestmark = pytest.mark.skipif(PLAIN, reason="Numba's own njit keeps nothing")


def cache_of(monkeypatch: pytest.MonkeyPatch, file: str) -> KernelCache:
    """The cache of an integrator called "another", which a module of conicoid.render.integrators implements."""
    monkeypatch.setitem(INTEGRATORS, "another", Integrator("another", "", file=file))
    return _tile_kernel.__wrapped__("another")._cache


def test_it_is_kept(monkeypatch):
    assert cache_of(monkeypatch, "normals").cache_path is not None


def test_its_parts_are_in_its_name(monkeypatch):
    codegen = cpu_target.target_context.codegen()
    normals, again, whitted = (
        cache_of(monkeypatch, file)._file((), codegen) for file in ("normals", "normals", "whitted")
    )
    assert normals == again
    assert normals.startswith("another_tiles-")
    assert whitted.startswith("another_tiles-")
    assert normals != whitted


def test_what_the_sources_do_not_say_is_not_kept(monkeypatch):
    @helper
    def gather(geometry, scratch, memory, settings, samples):
        pass

    module = ModuleType("conicoid.render.integrators.elsewhere")
    module.gather = gather
    monkeypatch.setitem(sys.modules, module.__name__, module)
    assert cache_of(monkeypatch, "elsewhere").cache_path is None
