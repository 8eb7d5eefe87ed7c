"""Memory of the system: errors where it has none, and systems that take none back."""

import mmap
import sys

import numpy as np
import pytest

from conicoid.prepare import mmap_arrays as apart


def test_a_lack_of_memory_is_called_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """NumPy raises this error, and callers expect it."""

    def refuse(*_: object, **__: object) -> None:
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(mmap, "mmap", refuse)
    with pytest.raises(MemoryError, match="8,000,000 more bytes"):
        apart.mapped_zeros(1_000_000, np.float64)
    assert not apart.mapped_zeros(10, np.float64).any()


def test_a_python_without_foreign_functions_gives_nothing_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ctypes", None)
    apart.trim_heap(1 << 20)
