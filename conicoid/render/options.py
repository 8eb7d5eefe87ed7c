"""Names of filters, tone curves, layers, colour keys and suffixes of slices, and numbers of samples.

The command line reads them at its start, so this module imports no NumPy.
"""

from __future__ import annotations

import os
from typing import Any, Literal, TypeAlias, get_args

BY = ("body", "material")
"""Keys by which slices are coloured and volume fractions are grouped."""
CURVES = (".svg", ".pdf")
PIXELS = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Suffixes of files with exact curves, and of files with pixels."""


def check_suffix(suffix: str, path: Any) -> None:
    """Raise ValueError for a suffix that slices are not saved as, ImportError for an .exr without OpenEXR."""
    from .._util.validation import format_value

    if suffix not in (*CURVES, *PIXELS):
        raise ValueError(
            f"Slice: slices are saved as {', '.join((*CURVES, *PIXELS))}, got {format_value(os.fspath(path))}"
        )
    if suffix == ".exr":
        from ..materials.image_file import import_openexr

        import_openexr()


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
