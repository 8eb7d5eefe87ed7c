"""The prism of the examples: its picture, small, and its least deviation by light itself."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def prism(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    yield importlib.import_module("prism")
    sys.modules.pop("prism", None)


def test_the_picture_has_all_colours(prism):
    pixels = prism.picture(None, 0.25).pixels
    assert np.isfinite(pixels).all()
    bright = pixels[pixels.max(axis=2) > 0.3]
    for channel in range(3):  # somewhere each is the brightest by far
        others = np.delete(bright, channel, axis=1).max(axis=1)
        assert (bright[:, channel] > 1.5 * others).any()


def test_the_beam_is_turned_by_the_least_deviation(prism):
    rays, _ = prism.beam(0.53)
    paths = co.optics.trace_paths(prism.prism(), rays[:, 0], depth=2, wavelength=0.53)
    out = paths.escaped & (paths.level == 2) & ~paths.mirrored
    out &= ~paths.mirrored[paths.parent]
    turned = np.degrees(np.arccos(paths.direction[out] @ rays.directions[0, 0]))
    assert turned == pytest.approx(np.full(prism.ACROSS, prism.least_deviation(0.53)), abs=1e-10)
