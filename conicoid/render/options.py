"""Names of filters, tone curves and layers, and numbers of samples.

The command line reads them at its start, so this module imports no other.
"""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

Filter: TypeAlias = Literal["box", "tent", "gaussian", "mitchell", "blackman-harris"]
FILTERS: tuple[Filter, ...] = get_args(Filter)
Tone: TypeAlias = Literal["srgb", "filmic", "agx"]
TONES: tuple[Tone, ...] = get_args(Tone)

LAYERS = {
    "albedo": "the colours of what is first seen, without light: the mean of all samples, (h, w, 3)",
    "normal": "the outward unit normal at the pixel's centre, (h, w, 3); 0 where nothing is",
    "depth": "the distance from the camera at the pixel's centre, (h, w); inf where nothing is",
    "position": "the point of the world at the pixel's centre, (h, w, 3); NaN where nothing is",
    "body": "the number of the body at the pixel's centre, (h, w) integers; -1 where nothing is",
    "samples": "how many samples the pixel has, (h, w) integers",
    "error": "the standard error of its brightness as displayed, (h, w); see `noise`",
}
"""Name -> description."""

SAMPLES, MOST_SAMPLES = 4, 1 << 14
"""Samples of a pixel by default, and at most where only the noise is set."""
