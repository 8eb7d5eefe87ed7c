"""OpenEXR pictures: linear light, whatever its range, in floats of 32 or 16 bits, and layers of what else is known."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from .atomic import replacing

_AXES = {"normal": "XYZ", "position": "XYZ"}
"""What the channels of a layer are called that has no colours."""


def write_exr(
    path: str | os.PathLike[str], values: Any, layers: Mapping[str, Any] | None = None, half: bool = False
) -> None:
    """Write (height, width, 3) as channels R, G, B, or (height, width) as the channel Y.

    layers: arrays of as many pixels, as channels such as albedo.R, normal.X, depth.V and body.V. Integers become
        unsigned ones of 32 bits, in which -1 is the largest number.
    half: floats of 16 bits; what is too large for them becomes infinite.
    """
    import OpenEXR

    kind = np.float16 if half else np.float32
    data = _as_float(values, kind)
    channels = {"RGB" if data.ndim == 3 else "Y": data}
    for name, layer in (layers or {}).items():
        whole = np.asarray(layer).dtype.kind in "iu"
        array = np.asarray(layer).astype(np.uint32) if whole else _as_float(layer, kind)
        if array.ndim == 2:
            channels[f"{name}.V"] = np.ascontiguousarray(array)
            continue
        for k, letter in enumerate(_AXES.get(name, "RGB")):
            channels[f"{name}.{letter}"] = np.ascontiguousarray(array[..., k])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with replacing(path) as part:
        try:
            OpenEXR.File(header, channels).write(str(part))
        except RuntimeError as error:
            raise _as_os_error(str(error)) from None


def _as_float(values: Any, kind: Any) -> Any:
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(np.asarray(values).astype(kind))


def _as_os_error(text: str) -> OSError:
    """What the library says in its own words, as Python would say it."""
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO):
        if os.strerror(code) in text:
            return OSError(code, os.strerror(code))
    return OSError(errno.EIO, f"cannot be written: {text.splitlines()[0] if text else 'OpenEXR does not say why'}")
