"""A picture that one can look at and save."""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from ..._util.equality import compare_by_value
from ..._util.errstate import ignore_fp_errors
from ..._util.foreign_names import HintingType, with_attribute_hints
from ..._util.hints import closest_name, with_method_hints
from ..._util.pickling import restore_state
from ..._util.validation import check_path as checked_path
from ..._util.validation import format_value, is_masked, real_array
from ...materials.color import srgb_decode
from ...render.film.colormap import COLORMAPS, apply_colormap
from ...render.film.layers import Layers
from ...render.film.options import Tone
from ...render.film.tone import apply_tone, check_exposure, check_tone

SUFFIXES = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Of pictures' files."""
Pixels = npt.NDArray[np.float32]


@with_attribute_hints
@with_method_hints
@compare_by_value("values", "pixels", "exposure", "tone", "layers")
class Image(metaclass=HintingType):
    """Linear colours (height, width, 3), or a number per pixel (height, width) seen through a colour map.

    array: any real numbers; rows from top to bottom. Colours in uint8 are taken for sRGB bytes, as PNG has them.
        Colours in floats are linear light, of which 1 is white: a channel below 0, or NaN, is shown as 0, and one above
        1 as 1. Floats that are all whole, up to 255, are refused, since they are bytes in another type.
    colormap: "dusk" (dark blue over violet and orange to pale yellow, in even steps of lightness; the default), or
        "grey" or "gray". It goes with a number per pixel alone, as vmin and vmax do.
    vmin, vmax: the numbers at the two ends of the map; by default the least and the greatest finite one.
        Of a number per pixel, those that are not finite are shown in pale grey.

    `pixels` (height, width, 3) float32 is what is seen, `values` the array as it was given.
    Shows itself in a notebook. Raises ValueError for other shapes, for an unknown map and for vmin > vmax, and warns of
    floats most of which are beyond white, some far.
    """

    values: Any
    pixels: Pixels
    layers: Mapping[str, Any]
    """What `render(layers=...)` was asked for beside the light, by name."""
    noise: float | None = None
    """Of a preview, and where `noise` or the layers of samples were asked for: the error of the whole picture."""
    exposure: float = 0.0
    tone: Tone = "srgb"

    @ignore_fp_errors
    def __init__(
        self, array: Any, *, colormap: str | None = None, vmin: float | None = None, vmax: float | None = None
    ) -> None:
        if is_masked(array):
            raise ValueError("Image: array must hold real numbers without masked entries")
        try:
            values = np.array(array)
        except ValueError:
            raise ValueError(f"Image: array must have rows of equal length, got {format_value(array)}") from None
        if values.dtype.kind not in "fiub":
            hint = (
                "; a picture in a file is np.asarray(PIL.Image.open(path))"
                if isinstance(array, str | os.PathLike)
                else ""
            )
            raise ValueError(f"Image: array must hold real numbers, got {values.dtype}{hint}")
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
        """A film of linear light, which is not looked at again."""
        image = cls.__new__(cls)
        image._keep(np.array(film), film)
        if layers:
            for layer in layers.values():
                layer.setflags(write=False)
            image.layers = Layers(layers)
        return image

    @ignore_fp_errors
    def developed(self, exposure: float = 0.0, tone: Tone = "srgb") -> Image:
        """The same light shown otherwise: on screens and in files of 8 or 16 bits; `pixels` and .exr files stay.

        exposure: stops; each makes all twice as bright.
        tone: the curve from light to what is displayed: "srgb" cuts off at white; "filmic" (Hable) and "agx" (Sobotka)
            roll off what is bright, and take the place of the cut.
        Raises ValueError for another curve, and for a number per pixel, which a colour map shows.
        """
        stops, curve = check_exposure("developed", exposure), check_tone("developed", tone)
        if self.values.ndim == 2:
            raise ValueError("developed: image must be of light, not a number per pixel through a colour map")
        other = type(self).__new__(type(self))
        vars(other).update(vars(self), exposure=stops, tone=curve)
        return other

    @ignore_fp_errors
    def denoised(self) -> Image:
        """The same picture without its noise, as Intel's Open Image Denoise guesses it: to look at, not to measure.

        The layers "albedo" and "normal" help, `render(layers=["albedo", "normal"])`. Raises ImportError without the
        extra `denoise`, ValueError for a number per pixel.
        """
        from ...render.film.denoise import denoise

        if self.values.ndim == 2:
            raise ValueError("denoised: image must be of light, not a number per pixel through a colour map")
        other = type(self)._of_light(denoise(self.pixels, self.layers), self.layers)
        other.exposure, other.tone = self.exposure, self.tone
        return other

    @property
    def _shown(self) -> Any:
        """What is displayed, as linear light."""
        return apply_tone(self.pixels, self.exposure, self.tone)

    def _keep(self, values: Any, colors: Any) -> None:
        self.values, self.pixels = values, np.asarray(colors, dtype=np.float32)
        self.layers = Layers()
        self.values.setflags(write=False)
        self.pixels.setflags(write=False)

    def __getitem__(self, index: Any) -> Any:
        raise TypeError("Image: image.pixels[...] is linear light, np.asarray(image)[...] the bytes that are shown")

    if not TYPE_CHECKING:  # else checkers would let pictures be reckoned with

        def _no_number(self, *_: Any) -> NoReturn:
            raise TypeError("Image: pictures are no numbers: co.Image(2 * image.pixels) is one of twice the light")

        __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _no_number
        __pow__ = __neg__ = __abs__ = __lt__ = __le__ = __gt__ = __ge__ = __float__ = _no_number

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)

    @property
    def width(self) -> int:
        """Pixels in a row."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.pixels.shape[0])

    def save(self, path: str | os.PathLike[str], *, bits: int | None = None) -> None:
        """Save at `path` as .png (sRGB, 8 bits) or .exr (linear floats; of a number per pixel the numbers themselves).

        Also as .jpg or .jpeg, which loses a little, and .webp, lossless; both in 8 bits of sRGB. An .exr has the
        `layers` as well, as channels such as albedo.R.
        bits: 16 for a .png with as many for each channel, or an .exr of half floats, whose numbers of bodies and
            samples stay whole numbers of 32 bits; else 8 and 32.

        The file is replaced only when it is complete. Raises ValueError for any other suffix,
        FileNotFoundError if the folder does not exist.
        """
        path = checked_path("Image", path)
        suffix = os.path.splitext(os.fspath(path))[1].lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"Image: pictures are saved as {', '.join(SUFFIXES)}, got {format_value(os.fspath(path))}")
        depths = {".png": (8, 16), ".exr": (32, 16)}.get(suffix, (8,))
        chosen = depths[0] if bits is None else bits
        if isinstance(chosen, bool) or chosen not in depths:
            expected = " or ".join(map(str, sorted(depths)))
            raise ValueError(f"Image: bits of {suffix} must be {expected}, got {format_value(bits)}")
        if suffix == ".png":
            from .png import write_png

            write_png(path, self._shown, chosen)
        elif suffix == ".exr":
            from .codecs import write_exr

            write_exr(path, self.pixels if self.values.ndim == 3 else self.values, self.layers, chosen == 16)
        else:
            from .codecs import write_photo

            write_photo(path, self._shown, suffix)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """(height, width, 3) uint8 of sRGB, what a PNG holds: for `np.asarray` and `plt.imshow`."""
        from .codecs import srgb_bytes

        if copy is False:
            raise ValueError("Image: the array of bytes is always made anew; image.pixels needs no copy")
        return srgb_bytes(self._shown).astype(dtype or np.uint8, copy=False)

    def show(self) -> None:
        """Show in the notebook, or else in the viewer that Pillow finds on this machine."""
        if _in_notebook():
            front: Any = importlib.import_module("IPython.display")
            front.display(self)
            return
        import PIL.Image

        PIL.Image.fromarray(np.asarray(self), "RGB").show()

    def _repr_png_(self) -> bytes:
        from .png import png_bytes

        return png_bytes(self._shown)

    def __repr__(self) -> str:
        return f"<Image {self.width} x {self.height}>"


def _in_notebook() -> bool:
    """Whether IPython runs with a kernel, whose front end shows pictures."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _named_map(colormap: Any) -> str:
    """The name of a colour map, or of the default one."""
    if colormap is None:
        return next(iter(COLORMAPS))
    name = "grey" if isinstance(colormap, str) and colormap == "gray" else colormap
    if not isinstance(name, str) or name not in COLORMAPS:
        close = closest_name(name, COLORMAPS) if isinstance(name, str) else ""
        meant = f" (did you mean {close!r}?)" if close else ""
        other = "" if meant else "; Matplotlib shows others, plt.imshow(image.values, cmap=...)"
        raise ValueError(
            f"Image: colormap must be one of {', '.join(COLORMAPS)}, got {format_value(colormap)}{meant}{other}"
        )
    return name


_BYTE, _BRIGHT = 255, 16


def _check_colors(values: Any) -> None:
    """Refuse, or doubt, colours that are bytes in another type: they would be white nearly everywhere."""
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
    """Any finite number, of any magnitude."""
    found = real_array("Image", field, value, "a number")
    if found.ndim or not np.isfinite(found):
        raise ValueError(f"Image: {field} must be a finite number, got {format_value(value)}")
    return float(found)
