"""`Image`: an array of light or of numbers per pixel that shows itself in notebooks and saves itself as a file."""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from .._util.arrays import ignore_fp_errors
from .._util.lazy_names import import_extra
from .._util.records import compare_by_value, restore_state
from .._util.text import check_choice
from .._util.validation import check_path as checked_path, format_value, is_masked, real_array
from ..materials.color import srgb_decode
from ..render.color_mapping import COLORMAPS, apply_colormap, apply_tone, check_exposure, check_tone
from ..render.film import Layers
from ..render.options import Tone

SUFFIXES = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Suffixes of the files that `Image.save` writes."""
Pixels = npt.NDArray[np.float32]


@compare_by_value("values", "pixels", "exposure", "tone", "layers")
class Image:
    """An image: linear colours (height, width, 3), or a number per pixel (height, width) seen through a colour map.

    An Image shows itself in a notebook. `pixels` (height, width, 3) float32 holds the visible linear light, `values`
    the array that was passed.

    Parameters
    ----------
    array
        Real numbers with rows from top to bottom. Colours in uint8 are read as sRGB bytes, as in PNG files. Colours in
        floats are linear light, 1 being white: a channel below 0, or NaN, is shown as 0, and one above 1 as 1.
    colormap
        "dusk" (dark blue over violet and orange to pale yellow, in even steps of lightness; the default), or "grey" or
        "gray". Only for a number per pixel, like `vmin` and `vmax`.
    vmin, vmax
        The numbers at the two ends of the map; by default the least and the greatest finite number. Numbers that are
        not finite are shown in pale grey.

    Raises
    ------
    ValueError
        For other shapes, for an unknown map, for vmin > vmax, and for floats that are all whole and reach from above 1
        to 255 or less, since these are bytes in another type.

    Warns
    -----
    UserWarning
        If most numbers of an array of floats are above 1, which is white, and some far above.
    """

    values: Any
    pixels: Pixels
    layers: Mapping[str, Any]
    """The arrays that `render(layers=...)` returned beside the light, by name."""
    noise: float | None = None
    """The error of the whole image: of previews, and where `render` got `noise` or layers of samples."""
    exposure: float = 0.0
    tone: Tone = "srgb"

    @ignore_fp_errors
    def __init__(
        self, array: npt.ArrayLike, *, colormap: str | None = None, vmin: float | None = None, vmax: float | None = None
    ) -> None:
        if is_masked(array):
            raise ValueError("Image: array must hold real numbers without masked entries")
        try:
            values = np.array(array)
        except ValueError:
            raise ValueError(f"Image: array must have rows of equal length, got {format_value(array)}") from None
        if values.dtype.kind not in "fiub":
            raise ValueError(f"Image: array must hold real numbers, got {values.dtype}")
        if values.size == 0 or not (values.ndim == 2 or (values.ndim == 3 and values.shape[2] == 3)):
            raise ValueError(f"Image: array must have shape (height, width, 3) or (height, width), got {values.shape}")
        name = _named_map(colormap)
        vmin, vmax = (None if end is None else _real(name, end) for name, end in (("vmin", vmin), ("vmax", vmax)))
        if values.ndim == 2:
            self._keep(values, apply_colormap(values, name, vmin, vmax))
            return
        for field, given in (("colormap", colormap), ("vmin", vmin), ("vmax", vmax)):
            if given is not None:
                raise ValueError(f"Image: {field} goes with a number per pixel, got colours, {values.shape}")
        _check_colors(values)
        self._keep(values, srgb_decode(values / 255) if values.dtype == np.uint8 else values)

    @classmethod
    def _of_light(cls, film: Pixels, layers: Mapping[str, Any] | None = None) -> Image:
        """Return an image of a film of linear light, with its layers. It keeps the arrays, and does not check them."""
        image = cls.__new__(cls)
        image._keep(film, film)
        if layers:
            for layer in layers.values():
                layer.setflags(write=False)
            image.layers = Layers(layers)
        return image

    @ignore_fp_errors
    def developed(self, exposure: float = 0.0, tone: Tone = "srgb") -> Image:
        """Return the same light with another exposure and tone curve.

        These change the display on screens and files of 8 or 16 bits; `pixels` and .exr files stay as they are.

        Parameters
        ----------
        exposure
            Stops; each doubles the brightness.
        tone
            The curve from light to displayed light: "srgb" clips at white; "filmic" (Hable) and "agx" (Sobotka) roll
            off bright light instead.

        Raises
        ------
        ValueError
            For another curve, and for an image of a number per pixel, which a colour map shows.
        """
        stops, curve = check_exposure("developed", exposure), check_tone("developed", tone)
        if self.values.ndim == 2:
            raise ValueError("developed: image must be of light, not a number per pixel through a colour map")
        other = type(self).__new__(type(self))
        vars(other).update(vars(self), exposure=stops, tone=curve)  # arrays are read-only, so both may hold them
        return other

    @ignore_fp_errors
    def denoised(self) -> Image:
        """Return the image with its noise removed by Intel's Open Image Denoise: to look at, not to measure.

        The layers "albedo" and "normal" improve the result: `render(layers=["albedo", "normal"])`.

        Raises
        ------
        ImportError
            If the extra `denoise` is not installed.
        ValueError
            For an image of a number per pixel.
        """
        if self.values.ndim == 2:
            raise ValueError("denoised: image must be of light, not a number per pixel through a colour map")
        other = type(self)._of_light(denoise(self.pixels, self.layers), self.layers)
        other.exposure, other.tone = self.exposure, self.tone
        return other

    @property
    def _display_light(self) -> Any:
        """The displayed light, linear: `pixels` after exposure and tone curve."""
        return apply_tone(self.pixels, self.exposure, self.tone)

    def _keep(self, values: Any, colors: Any) -> None:
        self.values, self.pixels = values, np.asarray(colors, dtype=np.float32)
        self.layers = Layers()
        self.values.setflags(write=False)
        self.pixels.setflags(write=False)

    def __getitem__(self, index: Any) -> Any:
        raise TypeError("Image: image.pixels[...] is linear light, np.asarray(image)[...] the bytes that are shown")

    if not TYPE_CHECKING:  # type checkers would accept arithmetic with images if they saw these methods

        def _no_number(self, *_: Any) -> NoReturn:
            raise TypeError("Image: pictures are no numbers: co.Image(2 * image.pixels) is one of twice the light")

        __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _no_number
        __pow__ = __neg__ = __abs__ = __lt__ = __le__ = __gt__ = __ge__ = __float__ = _no_number

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)

    @property
    def width(self) -> int:
        """The number of pixels in a row."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """The number of rows."""
        return int(self.pixels.shape[0])

    def save(self, path: str | os.PathLike[str], *, bits: int | None = None) -> None:
        """Save the image; an existing file is replaced only when the new one is complete.

        Parameters
        ----------
        path
            A file with one of these suffixes: .png (sRGB), .jpg or .jpeg (slightly lossy, 8 bits of sRGB), .webp
            (lossless, 8 bits of sRGB), or .exr (linear floats; for a number per pixel, the numbers themselves). An .exr
            file also holds the `layers`, as channels such as albedo.R.
        bits
            Bits per channel: 8 (default) or 16 for a .png; 32 (default) or 16, half floats, for an .exr, in which
            numbers of bodies and samples stay whole numbers of 32 bits.

        Raises
        ------
        ValueError
            For any other suffix or number of bits.
        ImportError
            For an .exr, if the extra `exr` is not installed.
        FileNotFoundError
            If the folder does not exist.
        """
        path = checked_path("Image", path)
        suffix = os.path.splitext(os.fspath(path))[1].lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"Image: pictures are saved as {', '.join(SUFFIXES)}, got {format_value(os.fspath(path))}")
        depths = {".png": (8, 16), ".exr": (32, 16)}.get(suffix, (8,))
        depth = depths[0] if bits is None else bits
        if isinstance(depth, bool) or depth not in depths:
            expected = " or ".join(map(str, sorted(depths)))
            raise ValueError(f"Image: bits of {suffix} must be {expected}, got {format_value(bits)}")
        if suffix == ".png":
            from .image_codecs import write_png

            write_png(path, self._display_light, depth)
        elif suffix == ".exr":
            from .image_codecs import write_exr

            write_exr(path, self.pixels if self.values.ndim == 3 else self.values, self.layers, depth == 16)
        else:
            from .image_codecs import write_photo

            write_photo(path, self._display_light, suffix)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """Return (height, width, 3) uint8 of sRGB, the bytes of a PNG file, for `np.asarray` and `plt.imshow`."""
        from .image_codecs import srgb_bytes

        if copy is False:
            raise ValueError("Image: the array of bytes is always made anew; image.pixels needs no copy")
        return srgb_bytes(self._display_light).astype(dtype or np.uint8, copy=False)

    def show(self) -> None:
        """Show the image in the notebook, or else in the viewer that Pillow finds on this machine."""
        if _in_notebook():
            front: Any = importlib.import_module("IPython.display")
            front.display(self)
            return
        import PIL.Image

        PIL.Image.fromarray(np.asarray(self), "RGB").show()

    def _repr_png_(self) -> bytes:
        from .image_codecs import png_bytes

        return png_bytes(self._display_light)

    def __repr__(self) -> str:
        return f"<Image {self.width} x {self.height}>"


def _in_notebook() -> bool:
    """Return True if IPython runs with a kernel, whose front end shows images."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _named_map(colormap: Any) -> str:
    """Return the name of a colour map, by default the first. Raise ValueError for an unknown one."""
    if colormap is None:
        return next(iter(COLORMAPS))
    name = "grey" if isinstance(colormap, str) and colormap == "gray" else colormap
    if not isinstance(name, str) or name not in COLORMAPS:
        check_choice("Image", "colormap", colormap, COLORMAPS)
    return name


_BYTE, _BRIGHT = 255, 16
"""The largest byte, and the light above which an array is far beyond white."""


def _check_colors(values: Any) -> None:
    """Raise ValueError, or warn, for colours that seem to be bytes in another type.

    As linear light they would be white nearly everywhere.
    """
    if values.dtype == np.uint8 or values.dtype.kind == "b":
        return
    most = values.max()
    if values.dtype.kind in "iu":
        if most > 1:
            raise ValueError(f"Image: array of integers up to {most} must be of uint8, sRGB bytes; got {values.dtype}")
        return
    if not most > 1 or values.min() < 0:
        return
    if most <= _BYTE and (values == np.round(values)).all():
        raise ValueError(
            f"Image: array of whole numbers up to {most:g} must be of uint8, sRGB bytes (array.astype('uint8')), or "
            f"linear light of which 1 is white; got {values.dtype}"
        )
    if most > _BRIGHT and np.count_nonzero(values > 1) * 2 > values.size:
        found = f"most numbers of the array, up to {most:g}, are beyond 1, which is white"
        expected = "colours are linear light, or sRGB bytes in uint8"
        warnings.warn(f"Image: {found}: {expected}", stacklevel=4)


def _real(field: str, value: Any) -> float:
    """Return a finite number of any magnitude. Raise ValueError for anything else."""
    number = real_array("Image", field, value, "a number")
    if number.ndim or not np.isfinite(number):
        raise ValueError(f"Image: {field} must be a finite number, got {format_value(value)}")
    return float(number)


# Noise removal by Open Image Denoise, an extra (pyoidn): a trained network, no physics.


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
    library = import_extra("pyoidn", "noise is taken out by pyoidn", "denoise")
    light = np.nan_to_num(np.maximum(pixels, 0.0), nan=0.0, posinf=0.0).astype(np.float32)
    guides: dict[str, Any] = {}
    if "albedo" in layers:
        guides["albedo"] = np.clip(layers["albedo"], 0.0, 1.0).astype(np.float32)
        if "normal" in layers:
            guides["normal"] = np.ascontiguousarray(layers["normal"], np.float32)
    return np.asarray(library.denoise(light, hdr=True, **guides), np.float32)
