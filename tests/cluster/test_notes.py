"""What would be logged on workers, where nobody reads it, is logged where the question is asked, once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

import conicoid as co

from . import subject


@pytest.fixture
def logged(caplog):
    """The warnings of Conicoid's log that tell of overlaps."""
    return lambda: [r.getMessage() for r in caplog.records if "through two bodies at once" in r.getMessage()]


@pytest.mark.parametrize("kind", ["processes", "threads", "none"])
def test_overlaps_are_told_once(kind, processes, logged):
    scene, rays = subject.scene(), subject.rays(200)  # whose ball and corners overlap
    pool = dict(processes=processes, threads=ThreadPoolExecutor(2), none=None)[kind]
    how = None if pool is None else co.parallel.Workers(pool, chunk=20)
    scene.line_integral(subject.VALUES, rays, executor=how)
    assert len(logged()) == 1
    assert logged()[0].startswith("line_integral: ")
    list(scene.stream(rays, "line_integral", values=subject.VALUES, executor=how))
    scene.line_integral(subject.VALUES, rays)
    assert len(logged()) == 1  # this scene was told of
    subject.scene().line_integral(subject.VALUES, rays, executor=how)
    assert len(logged()) == 2
    subject.scene().line_integral(subject.VALUES, rays, executor=how, overlaps="both")
    assert len(logged()) == 2
