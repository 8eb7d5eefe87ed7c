"""A picture that one can look at and save."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .colormap import COLORMAPS, mapped
from .shapes.arrays import is_masked, real_array
from .shapes.calm import calm
from .shapes.carried import restore
from .shapes.color import srgb_decode
from .shapes.validate import path as checked_path
from .shapes.validate import shown

SUFFIXES = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Of pictures' files."""
Pixels = npt.NDArray[np.float32]


class Image:
    """Linear colours (height, width, 3), or a number per pixel (height, width) seen through a colour map.

    array: any real numbers; rows from top to bottom. Colours in uint8 are taken for sRGB bytes, as PNG has them.
    colormap: "dusk" (dark blue over violet and orange to pale yellow, in even steps of lightness), or "grey" or "gray".
    vmin, vmax: the numbers at the two ends of the map; by default the least and the greatest finite one.
    Numbers that are not finite are shown in pale grey.

    `pixels` (height, width, 3) float32 is what is seen, `values` the array as it was given.
    Shows itself in a notebook. Raises ValueError for other shapes, for an unknown map and for vmin > vmax.
    """

    @calm
    def __init__(
        self, array: Any, *, colormap: str = "dusk", vmin: float | None = None, vmax: float | None = None
    ) -> None:
        if is_masked(array):
            raise ValueError("Image: array must hold real numbers without masked entries")
        try:
            values = np.array(array)
        except ValueError:
            raise ValueError(f"Image: array must have rows of equal length, got {shown(array)}") from None
        if values.dtype.kind not in "fiub":
            raise ValueError(f"Image: array must hold real numbers, got {values.dtype}")
        if values.size == 0 or not (values.ndim == 2 or (values.ndim == 3 and values.shape[2] == 3)):
            raise ValueError(f"Image: array must have shape (height, width, 3) or (height, width), got {values.shape}")
        colormap = "grey" if isinstance(colormap, str) and colormap == "gray" else colormap
        if not isinstance(colormap, str) or colormap not in COLORMAPS:
            raise ValueError(f"Image: colormap must be one of {', '.join(COLORMAPS)}, got {shown(colormap)}")
        if values.ndim == 3 and values.dtype.kind in "iu" and values.dtype != np.uint8 and values.max() > 1:
            raise ValueError(
                f"Image: array of integers up to {values.max()} must be of uint8, sRGB bytes; got {values.dtype}"
            )
        vmin, vmax = (None if end is None else _real(name, end) for name, end in (("vmin", vmin), ("vmax", vmax)))
        self.values = values
        if values.ndim == 2:
            colors = mapped(values, colormap, vmin, vmax)
        else:
            colors = srgb_decode(values / 255) if values.dtype == np.uint8 else values
        self.pixels: Pixels = np.asarray(colors, dtype=np.float32)
        self.values.setflags(write=False)
        self.pixels.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore(self, state)

    @property
    def width(self) -> int:
        """Pixels in a row."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.pixels.shape[0])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save as .png (sRGB, 8 bits) or .exr (linear floats; the numbers themselves if there is one per pixel).

        Also as .jpg or .jpeg, which loses a little, and .webp, lossless; both in 8 bits of sRGB.

        The file is replaced only when it is complete. Raises ValueError for any other suffix,
        FileNotFoundError if the folder does not exist.
        """
        path = checked_path("Image", path)
        suffix = Path(path).suffix.lower()
        if suffix == ".png":
            from .formats.png import write_png

            write_png(path, self.pixels)
        elif suffix == ".exr":
            from .formats.exr import write_exr

            write_exr(path, self.pixels if self.values.ndim == 3 else self.values)
        elif suffix in SUFFIXES:
            from .formats.photo import write_photo

            write_photo(path, self.pixels, suffix)
        else:
            raise ValueError(f"Image: pictures are saved as {', '.join(SUFFIXES)}, got {shown(os.fspath(path))}")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """(height, width, 3) uint8 of sRGB, what a PNG holds: for `np.asarray` and `plt.imshow`."""
        from .formats.png import srgb_bytes

        if copy is False:
            raise ValueError("Image: the array of bytes is always made anew; image.pixels needs no copy")
        return srgb_bytes(self.pixels).astype(dtype or np.uint8, copy=False)

    def show(self) -> None:
        """Show in the notebook, or else in the viewer that Pillow finds on this machine."""
        if _in_notebook():
            front: Any = importlib.import_module("IPython.display")
            front.display(self)
            return
        import PIL.Image

        PIL.Image.fromarray(np.asarray(self), "RGB").show()

    def _repr_png_(self) -> bytes:
        from .formats.png import png_bytes

        return png_bytes(self.pixels)

    def __repr__(self) -> str:
        return f"<Image {self.width} x {self.height}>"


def _in_notebook() -> bool:
    """Whether IPython runs with a kernel, whose front end shows pictures."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _real(field: str, value: Any) -> float:
    """Any finite number, of any magnitude."""
    found = real_array("Image", field, value, "a number")
    if found.ndim or not np.isfinite(found):
        raise ValueError(f"Image: {field} must be a finite number, got {shown(value)}")
    return float(found)
