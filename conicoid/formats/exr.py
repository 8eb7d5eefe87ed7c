"""OpenEXR pictures: linear 32-bit floats, whatever their range."""

from __future__ import annotations

import errno
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
        try:
            OpenEXR.File(header, {"RGB" if data.ndim == 3 else "Y": data}).write(str(part))
        except RuntimeError as error:
            raise _as_os_error(str(error)) from None


def _as_os_error(text: str) -> OSError:
    """What the library says in its own words, as Python would say it."""
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO):
        if os.strerror(code) in text:
            return OSError(code, os.strerror(code))
    return OSError(errno.EIO, f"cannot be written: {text.splitlines()[0] if text else 'OpenEXR does not say why'}")
