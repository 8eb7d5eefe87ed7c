"""Geometries that chance has spoilt: they are read, or refused with a message; nothing else happens.

They are read in a child process with 2 GiB of memory beyond what an idle one takes, and 10 s of the processor each.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from .mutations import mutated
from .spoilt_files import in_a_child

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is limited as Linux does it")


def test_spoilt_files_are_read_or_refused(tmp_path: Path) -> None:
    found = in_a_child(0, 40, tmp_path)
    assert found["wrong"] == []
    assert found["read"] > 3
    assert found["refused"] > 13


def test_both_forms_of_files_are_spoilt() -> None:
    names = [mutated(seed)[0] for seed in range(60)]
    assert 10 < names.count("model.xml") < 50


@pytest.mark.deep
@pytest.mark.parametrize("first", range(1000, 11000, 500))
def test_many_spoilt_files_are_read_or_refused(first: int, tmp_path: Path) -> None:
    """10⁴ files in all."""
    assert in_a_child(first, first + 500, tmp_path)["wrong"] == []
