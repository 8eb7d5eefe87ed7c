"""Noise removal by Open Image Denoise, an extra (pyoidn): a trained network, no physics."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import numpy as np


def denoise(pixels: Any, layers: Mapping[str, Any]) -> Any:
    """Return linear light (height, width, 3) float32 without noise.

    Parameters
    ----------
    pixels
        Linear light (height, width, 3).
    layers
        Layers of the picture by name, for edges and textures: "albedo", and "normal" beside it.

    Raises
    ------
    ImportError
        If pyoidn is not installed.

    """
    try:
        library: Any = importlib.import_module("pyoidn")
    except ImportError:
        raise ImportError("noise is taken out by pyoidn: pip install 'conicoid[denoise]'") from None
    light = np.nan_to_num(np.maximum(pixels, 0.0), nan=0.0, posinf=0.0).astype(np.float32)
    guides: dict[str, Any] = {}
    if "albedo" in layers:
        guides["albedo"] = np.clip(layers["albedo"], 0.0, 1.0).astype(np.float32)
        if "normal" in layers:
            guides["normal"] = np.ascontiguousarray(layers["normal"], np.float32)
    return np.asarray(library.denoise(light, hdr=True, **guides), np.float32)
