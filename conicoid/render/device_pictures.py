"""Pictures by the threads of a GPU: each takes pixels begin, begin + step, ..., with all samples of one in order.

`native/ptx.py` compiles these functions to PTX, as those of `kernels/device.py`. On the CPU packets and queues trace
the rays of many pixels together; how a ray is traced changes no bit of its hit, and a pixel's light is summed up in the
order of the CPU, so pictures are the same to the bit.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ..kernels.body.scratch import LEAF_COUNT, Scratch
from ..kernels.device import PICTURE
from ..kernels.programs import forget_program
from ..kernels.tables import Floats, Geometry, Longs, Signs
from ..prepare.prepared_scene import PreparedScene
from ..queries.device import LANES
from . import integrators
from .camera_rays import CameraView
from .film import COUNT, SQUARES, SUMS, mean_pixels
from .integrators import INTEGRATORS
from .integrators.samples import Settings
from .lights.light_tables import PathLight, WhittedLight
from .tiles import SIDE, SQUARE, Film, luminance, sample_ray, tiles_of_squares

if TYPE_CHECKING:
    from ..queries.device import Device


def _module(name: str) -> Any:
    """Return the module of an integrator."""
    return importlib.import_module(f"{integrators.__name__}.{name}")


def _has_radiance(module: str) -> bool:
    """Return whether an integrator follows single rays."""
    return hasattr(_module(module), "radiance")


def _memory_of(module: str) -> Any:
    """Return the type of the memory of a thread that an integrator needs, or None."""
    return getattr(_module(module), "RayMemory", None)


def _function(integrator: str) -> Callable[..., None]:
    """Return the function that adds samples to pixels, with an integrator in it."""
    kind = INTEGRATORS[integrator]
    radiance = _module(kind.module).radiance

    def render(
        geometry: Geometry, view: CameraView, settings: Settings, width: int, height: int, last: int, most: int,
        pixels: Longs, before: Floats, sums: Floats, memory: Any, scratch: Scratch, begin: int, step: int,
    ) -> None:  # fmt: skip
        """Bring pixels begin, begin + step, ... to `last` samples, by at most so many more: write their new sums.

        before: their sums so far. Places in pixels are Sobol's where settings.sobol is 1.
        """
        forget_program(scratch.counts)
        scratch.found_leaves[LEAF_COUNT] = -1
        i = begin
        while i < len(pixels):
            pixel, first = pixels[i], int(before[i, COUNT])
            row, column = pixel // width, pixel % width
            red, green, blue, squares = before[i, 0], before[i, 1], before[i, 2], before[i, SQUARES]
            end = max(first, min(last, first + most))
            for sample in range(first, end):
                ray, weight = sample_ray(
                    view, settings, settings.sobol == 1, pixel, float(column), float(row), sample, width, height
                )
                r, g, b = radiance(geometry, scratch, memory, settings, ray, pixel, sample)
                r, g, b = weight * r, weight * g, weight * b
                light = luminance(r, g, b)
                red, green, blue, squares = red + r, green + g, blue + b, squares + light * light
            sums[i, 0], sums[i, 1], sums[i, 2], sums[i, SQUARES], sums[i, COUNT] = red, green, blue, squares, end
            i += step

    look = PathLight if kind.transports else WhittedLight if kind.lit else None
    render.__annotations__["settings"] = Annotated[Settings, {"look": look}]
    render.__annotations__["memory"] = _memory_of(kind.module)
    render.__name__ = render.__qualname__ = f"{PICTURE}{kind.module}"
    return render


PICTURES = {
    _function(name): {"pixels": "n", "before": f"n {SUMS}", "sums": f"out n {SUMS}"}
    for name, kind in INTEGRATORS.items()
    if name == kind.module and _has_radiance(name)
}
"""As `kernels.device.FUNCTIONS`, of the integrators that follow single rays."""


# A picture is sent as pieces of some tiles and some samples, so that each takes a part of a second: between them Python
# looks for Ctrl-C and reports progress, and no watchdog of a card ends a kernel.

_CHUNK = 1 << 16  # pixels of a stream: as many threads as a large card has at a time
_TILE = SIDE * SIDE
_FIRST, _LEAST, _MOST = 1 << 18, _TILE, 1 << 26
"""Rays of the camera in a piece: the first, and the limits for others."""
_SHORT, _LONG = 0.1, 0.4
"""Seconds: a piece that takes less is followed by a larger one, one that takes more by a smaller one."""


class DevicePictures:
    """The part of an exposure that a card computes."""

    def __init__(self, device: Device, scene: PreparedScene, integrator: str, view: CameraView, settings: Any) -> None:
        self._device, self._scene, kind = device, scene, INTEGRATORS[integrator]
        self._function = f"{PICTURE}{kind.module}"
        memory = _memory_of(kind.module)
        self._fits = _has_radiance(kind.module) and (memory is None or memory.holds(settings))
        self._constants = [*_flatten(view), *_flatten(settings._replace(sobol=int(kind.progressive or settings.sobol)))]
        self._rays = _FIRST

    def fill(
        self, film: Film, sums: Floats, squares: Signs, last: int, begun: int, begin: int, end: int,
        done: Callable[[Longs, int], None],
    ) -> bool:  # fmt: skip
        """Run tiles begin to end, as a kernel of tiles does.

        It calls `done` with tiles that are done, and how many are left. Returns False where the CPU must go on: the
        memory of a thread or of the card is too small.
        """
        height, width = film.shape[:2]
        tiles, samples = _wanted_tiles(squares, width, begin, end), max(1, last - begun)
        while self._fits and len(tiles) > 0:
            count = max(1, min(self._rays // _TILE, max(LANES * _CHUNK // _TILE, self._rays // (_TILE * samples))))
            most = max(1, self._rays // (_TILE * count))
            pixels = _pixels_of(tiles[:count], squares, width, height)
            part = sums.reshape(-1, SUMS)[pixels] if len(sums) else np.zeros((len(pixels), SUMS))
            while part[:, COUNT].min() < last:
                found, start = np.empty_like(part), monotonic()
                constants = [*self._constants, width, height, last, most]
                if not self._device.run(self._scene, self._function, [pixels, part], [found], constants, _CHUNK):
                    return False
                part, seconds = found, monotonic() - start
                self._rays = min(_MOST, 2 * self._rays) if seconds < _SHORT else self._rays
                self._rays = max(_LEAST, self._rays // 2) if seconds > _LONG else self._rays
            film.reshape(-1, 3)[pixels] = mean_pixels(part)
            if len(sums):
                sums.reshape(-1, SUMS)[pixels] = part
            finished, tiles = tiles[:count], tiles[count:]
            done(finished, len(tiles))
        return self._fits


def _flatten(value: Any, shape: str = "") -> list[Any]:
    """Return the arguments of a kernel for a value, as `Device.run` takes them; native/signature.py has the same order.

    A table is followed by its length along the axis whose length its shape leaves open.
    """
    if isinstance(value, np.ndarray):
        return [(value, *(n for word, n in zip(shape.split(), value.shape, strict=True) if not word.isdigit()))]
    if isinstance(value, tuple):
        names = getattr(value, "_fields", None) or [""] * len(value)
        shapes = getattr(value, "__shapes__", {})
        return [n for name, each in zip(names, value, strict=True) for n in _flatten(each, shapes.get(name, ""))]
    if isinstance(value, float):
        return [int(np.float64(value).view(np.int64))]
    return [] if value is None else [int(value)]


def _wanted_tiles(squares: Signs, width: int, begin: int, end: int) -> Longs:
    """Return the tiles from begin to end with squares that are wanted."""
    tiles: Longs = np.arange(begin, end)
    if len(squares) == 0:
        return tiles
    row, column = np.divmod(np.flatnonzero(squares), -(-width // SQUARE))
    return np.intersect1d(tiles, tiles_of_squares(row, column, width))


def _pixels_of(tiles: Longs, squares: Signs, width: int, height: int) -> Longs:
    """Return the numbers of the pixels of tiles, one square that is wanted after the other."""
    square, place = np.divmod(np.arange(_TILE), SQUARE * SQUARE)
    (top, left), (row, column) = np.divmod(square, SIDE // SQUARE), np.divmod(place, SQUARE)
    rows, columns = np.divmod(tiles[:, None], -(-width // SIDE))
    rows, columns = SIDE * rows + SQUARE * top + row, SIDE * columns + SQUARE * left + column
    inside = (rows < height) & (columns < width)
    rows, columns = rows[inside], columns[inside]
    if len(squares) > 0:
        wanted = squares[rows // SQUARE * -(-width // SQUARE) + columns // SQUARE] == 1
        rows, columns = rows[wanted], columns[wanted]
    return np.asarray(rows * width + columns)
