"""Rays: origins and directions, and the surface each may start on."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...shapes.arrays import real_array, refuse_columns
from ...shapes.calls import explained_methods
from ...shapes.calm import calm
from ...shapes.carried import aligned
from ...shapes.other_names import hinted
from ...shapes.validate import DOMAIN, npz_path, shown, what
from ...shapes.validate import path as checked_path
from ...shapes.vector import FloatArray
from .no_array import NoArray
from .parts import parts_of
from .unpacked import Unpacked

if TYPE_CHECKING:
    from ..prepared import Prepared
    from .lazy_rays import LazyRays


_REASONS = {
    1: "origin must be finite",
    2: "direction must be finite",
    3: "direction must not be zero",
    4: f"origin must be {DOMAIN} in every component",
    5: f"direction must be {DOMAIN} in every component",
}


def points_array(owner: str, field: str, values: Any) -> FloatArray:
    """`values` as a float64 array (..., 3); a named ValueError otherwise."""
    array = real_array(owner, field, values, "an array of numbers (..., 3)")
    if array.ndim == 1 and array.size == 0:
        array = array.reshape(0, 3)
    refuse_columns(owner, field, values)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{owner}: {field} must have shape (..., 3), got {array.shape}{_meant_by_shape(array.shape)}")
    return array


def _meant_by_shape(shape: tuple[int, ...]) -> str:
    """What to tell of an array of another shape."""
    if shape[-1:] == (6,):
        return "; origins and directions are two arrays, a[..., :3] and a[..., 3:]"
    return f"; its transpose, .T, has shape {shape[::-1]}" if len(shape) == 2 and shape[0] == 3 else ""


def first_wrong(origins: FloatArray, directions: FloatArray) -> tuple[int, str] | None:
    """The first of some lines (n, 3) that cannot be traced, and why; None where there is none."""
    from .fields import first_invalid

    index, reason = first_invalid(origins, directions)
    if not reason:
        return None
    value = (origins if reason in (1, 4) else directions)[index]
    return index, f"{_REASONS[reason]}, got {tuple(value.tolist())}"


@hinted
@explained_methods
class Rays(NoArray):
    """Rays of any leading shape: `origins` and `directions` (..., 3), read-only float64, which broadcast.

    Directions need not be unit; t is in units of their length. Unpacks to (origins, directions);
    the surfaces that spawned rays start on are then lost. So a loop over rays gives these two arrays and not ray after
    ray, and `zip(rays, hits)` is refused: `rays[i]` is one ray, `rays[2:5]` are three, `len(rays)` goes along the first
    axis, and `for hit in hits` has the ray of each as `hit.rays`.

    Spawned rays know the surface that they start on, by its number, and whose number that is: in a scene with
    other surfaces they are plain rays, with the same origins and directions.

    Raises ValueError for NaN, infinite or zero input, with the index of the first such ray.
    """

    __slots__ = ("_home", "_starts", "directions", "origins")
    __hash__ = None  # type: ignore[assignment]
    instead = "rays.origins and rays.directions"
    origins: FloatArray
    directions: FloatArray
    _starts: npt.NDArray[np.int32]  # numbers of surfaces, -1 for none, DEAD; one for all rays or one for each
    _home: bytes | None  # `Prepared.key` of the scene whose surfaces they are

    @calm
    def __init__(self, origins: Any, directions: Any) -> None:
        o, d = points_array("Rays", "origins", origins), points_array("Rays", "directions", directions)
        try:
            shape = np.broadcast_shapes(o.shape, d.shape)
        except ValueError:
            raise ValueError(f"Rays: origins {o.shape} and directions {d.shape} do not broadcast together") from None
        o, d = _own(o, shape), _own(d, shape)
        wrong = first_wrong(o.reshape(-1, 3), d.reshape(-1, 3))
        if wrong is not None:
            where = tuple(int(i) for i in np.unravel_index(wrong[0], shape[:-1])) if len(shape) > 1 else ()
            place = f" for ray[{', '.join(map(str, where))}]" if where else ""
            raise ValueError(f"Rays: {wrong[1]}{place}")
        self._keep(o, d, np.array([-1], np.int32))

    def _keep(
        self, origins: FloatArray, directions: FloatArray, starts: npt.NDArray[np.int32], home: bytes | None = None
    ) -> None:
        origins, directions, starts = map(aligned, (origins, directions, starts))
        for array in (origins, directions, starts):
            array.flags.writeable = False
        object.__setattr__(self, "origins", origins)
        object.__setattr__(self, "directions", directions)
        object.__setattr__(self, "_starts", starts)
        object.__setattr__(self, "_home", home)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"Rays are read-only: {name} cannot be set")

    @classmethod
    def _spawned(
        cls, origins: FloatArray, directions: FloatArray, starts: npt.NDArray[np.int32], home: bytes | None = None
    ) -> Rays:
        """Rays that start on surfaces (ids, or DEAD) of the scene of a key, without checking them again."""
        rays = object.__new__(cls)
        rays._keep(origins, directions, starts, home)
        return rays

    def _starts_in(self, scene: Prepared) -> npt.NDArray[np.int32]:
        """The surfaces of a scene that the rays start on. In one with other surfaces: none, and misses stay misses."""
        starts = self._starts
        if not starts.size:
            return np.array([-1], np.int32)
        if (len(starts) == 1 and starts[0] < 0) or (self._home is not None and self._home == scene.key):
            return starts
        return np.minimum(starts, np.int32(-1))

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"Rays are read-only: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        """Whether origins, directions and the surfaces that rays start on are equal; never an array."""
        if not isinstance(other, Rays):
            return NotImplemented
        mine, its = (np.broadcast_to(r._starts, (r.origins.size // 3,)) for r in (self, other))
        pairs = (self.origins, other.origins), (self.directions, other.directions)
        if not all(np.array_equal(a, b, equal_nan=True) for a, b in pairs) or not np.array_equal(mine, its):
            return False
        return self._home == other._home or not (mine >= 0).any()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self)._spawned, (self.origins, self.directions, self._starts, self._home)

    @classmethod
    def concatenate(cls, parts: Iterable[Rays]) -> Rays:
        """Rays one after the other along the first axis, like `np.concatenate`; single ones count as rows of one.

        Spawned rays among `parts` keep the surfaces that they start on if these are all of one scene. Raises TypeError
        for what is no Rays, ValueError for none at all and for shapes that do not fit.
        """
        rows = [part if part.shape else part[None] for part in parts_of(Rays, parts)]
        if len({part.shape[1:] for part in rows}) != 1:
            shapes = ", ".join(str(part.shape) for part in rows[:8]) or "none"
            raise ValueError(f"Rays: parts must have shapes that differ in the first axis alone, got {shapes}")
        starts = [np.broadcast_to(part._starts, (part.origins.size // 3,)) for part in rows]
        origins, directions = (np.concatenate([p[k] for p in map(tuple, rows)]) for k in (0, 1))
        homes = {part._home for part in rows if (part._starts >= 0).any()}
        together = np.concatenate(starts)
        if len(homes) > 1:
            return cls._spawned(origins, directions, np.minimum(together, np.int32(-1)))
        return cls._spawned(origins, directions, together, homes.pop() if homes else None)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rays as a .npz file at `path`, which `co.Rays.load` and `conicoid trace` read, as NumPy does.

        The file appears whole or not at all. Raises ValueError for another suffix, OSError where it cannot be written.
        """
        from ...formats.answer_file import write_rays_file

        suffix = os.path.splitext(checked_path("save", path))[1].lower()
        if suffix in (".npy", ".csv"):
            both = "np.concatenate([*rays], axis=-1)"
            written = f"np.save(path, {both})" if suffix == ".npy" else f'np.savetxt(path, {both}, delimiter=",")'
            raise ValueError(
                f"save: path of rays must end with .npz, got {shown(os.fspath(path))}; {written} writes that"
            )
        write_rays_file(npz_path("save", "rays", path), self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Rays:
        """The rays in the file at `path` that `save` wrote, or in one that `conicoid trace` reads (docs/files.md).

        Such are a .npz file with arrays `origins` and `directions`, a .npy file (..., 6), and a .csv file.
        Raises ValueError for what is no such file, naming it, and OSError where it cannot be read.
        """
        from ...formats.answer_file import read_rays_file

        return read_rays_file(checked_path("load", path))

    @staticmethod
    def from_camera(camera: Any, width: int, height: int) -> LazyRays:
        """`camera.rays(width, height)`, made where they are traced: part by part, and on workers by them."""
        from .lazy_rays import LazyRays

        made = getattr(camera, "lazy_rays", None)
        if not callable(made):
            hint = "; scene.rays(width, height) are those of the camera that fits, scene.fitting_camera() is that one"
            hint = hint if camera is None or hasattr(camera, "fitting_camera") else ""
            raise TypeError(f"from_camera: camera must be a Camera or an OrthographicCamera, got {what(camera)}{hint}")
        found = made(width, height)
        assert isinstance(found, LazyRays)
        return found

    @staticmethod
    def from_scan(geometry: Any) -> LazyRays:
        """The rays of all pixels of a scan, the `geometry` of `co.ct`, made where they are traced.

        Queries follow them as far as the scan does, its `interval`, unless they are given another.
        """
        from .lazy_rays import LazyRays

        found = getattr(geometry, "lazy_rays", None)
        if not isinstance(found, LazyRays):
            raise TypeError(f"from_scan: geometry must be one of co.ct, got {what(geometry)}")
        return found

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape."""
        return self.origins.shape[:-1]

    @property
    def ndim(self) -> int:
        """How many axes `shape` has; 0 for a single ray."""
        return self.origins.ndim - 1

    @property
    def size(self) -> int:
        """How many rays there are."""
        return self.origins.size // 3

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single ray has no length")
        return self.shape[0]

    def __iter__(self) -> Iterator[FloatArray]:
        return Unpacked(self.origins, self.directions)

    def __getitem__(self, index: Any) -> Rays:
        refuse_name(self, index)
        starts = self._starts
        if len(starts) > 1 or self.origins.size == 3:
            starts = np.atleast_1d(np.broadcast_to(starts, (self.origins.size // 3,)).reshape(self.shape)[index])
        if isinstance(index, tuple) and any(part is Ellipsis for part in index):  # which would reach x, y and z
            index = np.arange(self.size).reshape(self.shape)[index]
            o, d = (line[index] for line in lines_of(self))
        else:
            o, d = self.origins[index], self.directions[index]
        if o.shape[-1:] != (3,):
            raise IndexError(f"Rays: index {index!r} must select whole rays")
        return Rays._spawned(np.array(o), np.array(d), np.ascontiguousarray(starts.ravel(), dtype=np.int32), self._home)

    def __repr__(self) -> str:
        if not self.shape:
            return f"Rays({', '.join(str(tuple(part.tolist())) for part in self)})"
        return f"Rays(shape={self.shape})"


_OF_NAMES = {
    "Hits": "; hits[hits.name == {0}] are those of a body",
    "Spans": "; spans.t_enter[spans.name == {0}] are those in a body, and so is any field",
    "Crossings": "; crossings.t[crossings.name == {0}] are those of a body, and so is any field",
}
"""What may be meant by a text as an index."""


def refuse_name(thing: Any, index: Any) -> None:
    """IndexError for the name of a field as an index."""
    if isinstance(index, str):
        kind = type(thing).__name__
        known = hasattr(type(thing), index) or index in getattr(thing, "__dict__", {})
        hint = f"; {kind.lower()}.{index} is a field" if known and not index.startswith("_") else ""
        if not known:
            hint = _OF_NAMES.get(kind, "").format(shown(index))
        raise IndexError(f"{kind}: index must be numbers, slices or a mask, got {shown(index)}{hint}")


def lines_of(rays: Rays) -> tuple[FloatArray, FloatArray]:
    """(origins, directions), both (n, 3)."""
    return rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3)


def _own(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    whole = array if array.shape == shape else np.broadcast_to(array, shape)  # which costs as much as tracing a ray
    return np.array(whole, dtype=np.float64, order="C")
