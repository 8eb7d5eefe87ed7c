"""Noise that is taken out: pictures come nearer to what they are without it."""

from __future__ import annotations

import importlib.util
import sys

import numpy as np
import pytest

import conicoid as co


def picture():
    """Light of two colours, exactly and with noise."""
    exact = np.zeros((64, 64, 3), np.float32)
    exact[:, :32], exact[:, 32:] = (0.6, 0.2, 0.1), (0.1, 0.3, 0.5)
    noise = np.random.default_rng(6).normal(0, 0.15, exact.shape).astype(np.float32)
    return exact, np.maximum(exact * (1 + noise), 0)


@pytest.mark.skipif(importlib.util.find_spec("pyoidn") is None, reason="pyoidn is an extra")
def test_noise_is_taken_out_and_edges_stay():
    exact, noisy = picture()
    normal = np.broadcast_to(np.float32((0, 0, 1)), exact.shape).copy()
    for layers in ({}, {"albedo": exact.copy()}, {"albedo": exact.copy(), "normal": normal}):
        image = co.Image._of_light(noisy.copy(), layers).developed(1, "agx")
        found = image.denoised()
        assert np.abs(found.pixels - exact).mean() < 0.25 * np.abs(noisy - exact).mean()
        assert (found.exposure, found.tone) == (1, "agx")
        step = found.pixels[:, 32, 0] - found.pixels[:, 31, 0]
        assert step.mean() < (-0.4 if layers else -0.3)  # of -0.5
    assert (image.pixels == noisy).all()


def test_without_the_library_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(ImportError, match=r"pip install 'conicoid\[denoise\]'"):
        co.Image._of_light(picture()[1]).denoised()
    with pytest.raises(ValueError, match="not a number per pixel"):
        co.Image(np.zeros((2, 2))).denoised()
