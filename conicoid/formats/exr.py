"""OpenEXR pictures: linear 32-bit floats, whatever their range."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from .atomic import replacing


def write_exr(path: str | os.PathLike[str], values: Any) -> None:
    """Write (height, width, 3) as channels R, G, B, or (height, width) as the channel Y."""
    import OpenEXR

    data = np.ascontiguousarray(values, dtype=np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with replacing(path) as part:
        OpenEXR.File(header, {"RGB" if data.ndim == 3 else "Y": data}).write(str(part))
