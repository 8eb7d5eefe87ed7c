"""Rays unpack to two arrays, so `zip(rays, hits)` would pair the origins with the first hit: it is refused."""

from __future__ import annotations

import math
import os
import threading
import weakref
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import with_attribute_hints
from .._util.hints import with_method_hints
from .._util.pickling import align_array
from .._util.validation import DOMAIN, check_npz_path, describe_kind, format_value, real_array, refuse_columns
from .._util.validation import check_path as checked_path
from ..kernels.threads import run_chunks
from .result import NoArray, check_parts

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene


_UNPACKING = threading.local()
"""Which iterator of this thread has given origins and not yet directions, as in no unpacking when others go on."""


class RayUnpacking(Iterator[FloatArray]):
    """Origins and directions, one after the other."""

    __slots__ = ("__weakref__", "_left")

    def __init__(self, origins: FloatArray, directions: FloatArray) -> None:
        self._left = [directions, origins]

    def __next__(self) -> FloatArray:
        _UNPACKING.iterator = None
        if not self._left:
            raise StopIteration
        array = self._left.pop()
        if self._left:
            _UNPACKING.iterator = weakref.ref(self)
        return array


def refuse_pairs(kind: str) -> None:
    """TypeError where the loop that goes on to the next answer goes over rays at the same time."""
    begun = getattr(_UNPACKING, "iterator", None)
    if begun is None or begun() is None:
        return
    _UNPACKING.iterator = None
    it = kind.lower()
    raise TypeError(
        f"{kind}: a loop over rays and {it} at once pairs the array of origins with the first of the {it}: "
        f"`for one in {it}` has the ray of each as one.rays"
    )


# Rays: origins and directions, and the surface each may start on.

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
        raise ValueError(f"{owner}: {field} must have shape (..., 3), got {array.shape}{_shape_hint(array.shape)}")
    return array


def _shape_hint(shape: tuple[int, ...]) -> str:
    """What to tell of an array of another shape."""
    if shape[-1:] == (6,):
        return "; origins and directions are two arrays, a[..., :3] and a[..., 3:]"
    return f"; its transpose, .T, has shape {shape[::-1]}" if len(shape) == 2 and shape[0] == 3 else ""


def find_invalid_ray(origins: FloatArray, directions: FloatArray) -> tuple[int, str] | None:
    """The first of some lines (n, 3) that cannot be traced, and why; None where there is none."""
    from .hit_fields import first_invalid

    index, reason = first_invalid(origins, directions)
    if not reason:
        return None
    value = (origins if reason in (1, 4) else directions)[index]
    return index, f"{_REASONS[reason]}, got {tuple(value.tolist())}"


@with_attribute_hints
@with_method_hints
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

    @ignore_fp_errors
    def __init__(self, origins: Any, directions: Any) -> None:
        o, d = points_array("Rays", "origins", origins), points_array("Rays", "directions", directions)
        try:
            shape = np.broadcast_shapes(o.shape, d.shape)
        except ValueError:
            raise ValueError(f"Rays: origins {o.shape} and directions {d.shape} do not broadcast together") from None
        o, d = _own_copy(o, shape), _own_copy(d, shape)
        wrong = find_invalid_ray(o.reshape(-1, 3), d.reshape(-1, 3))
        if wrong is not None:
            where = tuple(int(i) for i in np.unravel_index(wrong[0], shape[:-1])) if len(shape) > 1 else ()
            place = f" for ray[{', '.join(map(str, where))}]" if where else ""
            raise ValueError(f"Rays: {wrong[1]}{place}")
        self._keep(o, d, np.array([-1], np.int32))

    def _keep(
        self, origins: FloatArray, directions: FloatArray, starts: npt.NDArray[np.int32], home: bytes | None = None
    ) -> None:
        origins, directions, starts = map(align_array, (origins, directions, starts))
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

    def _starts_in(self, scene: PreparedScene) -> npt.NDArray[np.int32]:
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
        rows = [part if part.shape else part[None] for part in check_parts(Rays, parts)]
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
        from ..io.result_file import write_rays_file

        suffix = os.path.splitext(checked_path("save", path))[1].lower()
        if suffix in (".npy", ".csv"):
            both = "np.concatenate([*rays], axis=-1)"
            written = f"np.save(path, {both})" if suffix == ".npy" else f'np.savetxt(path, {both}, delimiter=",")'
            raise ValueError(
                f"save: path of rays must end with .npz, got {format_value(os.fspath(path))}; {written} writes that"
            )
        write_rays_file(check_npz_path("save", "rays", path), self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Rays:
        """The rays in the file at `path` that `save` wrote, or in one that `conicoid trace` reads (docs/files.md).

        Such are a .npz file with arrays `origins` and `directions`, a .npy file (..., 6), and a .csv file.
        Raises ValueError for what is no such file, naming it, and OSError where it cannot be read.
        """
        from ..io.result_file import read_rays_file

        return read_rays_file(checked_path("load", path))

    @staticmethod
    def from_camera(camera: Any, width: int, height: int) -> LazyRays:
        """`camera.rays(width, height)`, made where they are traced: part by part, and on workers by them."""
        made = getattr(camera, "lazy_rays", None)
        if not callable(made):
            hint = "; scene.rays(width, height) are those of the camera that fits, scene.fitting_camera() is that one"
            hint = hint if camera is None or hasattr(camera, "fitting_camera") else ""
            raise TypeError(
                f"from_camera: camera must be a Camera or an OrthographicCamera, got {describe_kind(camera)}{hint}"
            )
        found = made(width, height)
        assert isinstance(found, LazyRays)
        return found

    @staticmethod
    def from_scan(geometry: Any) -> LazyRays:
        """The rays of all pixels of a scan, the `geometry` of `co.ct`, made where they are traced.

        Queries follow them as far as the scan does, its `interval`, unless they are given another.
        """
        found = getattr(geometry, "lazy_rays", None)
        if not isinstance(found, LazyRays):
            raise TypeError(f"from_scan: geometry must be one of co.ct, got {describe_kind(geometry)}")
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
        return RayUnpacking(self.origins, self.directions)

    def __getitem__(self, index: Any) -> Rays:
        refuse_name_index(self, index)
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


_NAME_INDEX_HINTS = {
    "Hits": "; hits[hits.name == {0}] are those of a body",
    "Spans": "; spans.t_enter[spans.name == {0}] are those in a body, and so is any field",
    "Crossings": "; crossings.t[crossings.name == {0}] are those of a body, and so is any field",
}
"""What may be meant by a text as an index."""


def refuse_name_index(thing: Any, index: Any) -> None:
    """IndexError for the name of a field as an index."""
    if isinstance(index, str):
        kind = type(thing).__name__
        known = hasattr(type(thing), index) or index in getattr(thing, "__dict__", {})
        hint = f"; {kind.lower()}.{index} is a field" if known and not index.startswith("_") else ""
        if not known:
            hint = _NAME_INDEX_HINTS.get(kind, "").format(format_value(index))
        raise IndexError(f"{kind}: index must be numbers, slices or a mask, got {format_value(index)}{hint}")


def lines_of(rays: Rays) -> tuple[FloatArray, FloatArray]:
    """(origins, directions), both (n, 3)."""
    return rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3)


def _own_copy(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    whole = array if array.shape == shape else np.broadcast_to(array, shape)  # which costs as much as tracing a ray
    return np.array(whole, dtype=np.float64, order="C")


# Rays that are said and not yet made: each part of them is made where it is traced.

_BLOCK = 1 << 12


@with_attribute_hints
@with_method_hints
class LazyRays(NoArray):
    """Rays of a camera or a scan, which take a few bytes until they are traced, also on other machines.

    Every query takes them in place of `Rays`; `made()` has them as such. Those of any part are the same to the bit.
    """

    instead = "rays.made()"
    _in_blocks = True
    """Are they worked out, and not read?"""

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape."""
        raise NotImplementedError

    @property
    def interval(self) -> tuple[float, float]:
        """t_min and t_max of queries that say nothing else."""
        return 0.0, math.inf

    @property
    def ndim(self) -> int:
        """How many axes `shape` has."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """How many rays there are."""
        count = 1
        for length in self.shape:
            count *= length
        return count

    def __len__(self) -> int:
        return self.shape[0]

    if not TYPE_CHECKING:  # else checkers would let rays that are not made be told apart

        def __getitem__(self, index: Any) -> NoReturn:
            told = "rays.part(begin, end) are some of them, and rays.made()[...] any"
            raise TypeError(f"{type(self).__name__}: rays are made where they are traced: {told}")

        def __iter__(self) -> NoReturn:
            told = "origins, directions = rays.made() are two arrays of all"
            raise TypeError(f"{type(self).__name__}: rays are made where they are traced: {told}")

    def made(self) -> Rays:
        """All of them as `Rays`, 48 bytes each; these have no interval of their own, so queries of them start at 0."""
        return self.part(0, self.size, self.shape)

    @ignore_fp_errors
    def part(self, begin: int, end: int, shape: tuple[int, ...] | None = None) -> Rays:
        """Flat rays `begin` to `end`, counted with the last axis the fastest; in another shape of so many if given."""
        made = (*(shape or (end - begin,)), 3)
        if not self._in_blocks:
            origins, directions = self._lines(begin, end)
            return Rays(origins.reshape(made), directions.reshape(made))
        origins, directions = np.empty(made), np.empty(made)
        if self._fill_all(begin, origins.reshape(-1, 3), directions.reshape(-1, 3)):
            return Rays._spawned(origins, directions, np.array([-1], np.int32))
        return Rays(origins, directions)  # which says what is wrong, and where

    def _fill_all(self, begin: int, origins: FloatArray, directions: FloatArray) -> bool:
        """`_fill`, some at a time, that what is worked out stays near the processor, and by all threads: all right?"""
        wrong = []

        def fill(first: int, last: int) -> None:
            lines = origins[first:last], directions[first:last]
            self._fill(begin + first, *lines)
            if find_invalid_ray(*lines) is not None:
                wrong.append(first)

        run_chunks(fill, len(origins), _BLOCK)
        return not wrong

    def _fill(self, begin: int, origins: FloatArray, directions: FloatArray) -> None:
        """Write `_lines` from the flat ray `begin` on into arrays (n, 3)."""
        origins[:], directions[:] = self._lines(begin, begin + len(origins))

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        """Origins and directions (n, 3) of flat rays `begin` to `end`."""
        raise NotImplementedError

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        """What makes flat rays `begin` to `end`, in as few bytes as may be, and their numbers there."""
        return self, begin, end

    def __repr__(self) -> str:
        return f"{type(self).__name__}(shape={self.shape})"


class ArrayRays(LazyRays):
    """Rays in two arrays (n, 3), or one (n, 6), which may be on a disk: what is sliced is read, and nothing else."""

    _in_blocks = False

    def __init__(self, origins: Any, directions: Any = None) -> None:
        self._origins, self._directions = origins, directions
        for name, array, last in (("origins", origins, 6 if directions is None else 3), ("directions", directions, 3)):
            shape = getattr(array, "shape", None)
            if array is not None and (shape is None or len(shape) != 2 or shape[1] != last):
                raise ValueError(f"rays: {name} must be an array of shape (n, {last}), got {shape}")
        if directions is not None and len(origins) != len(directions):
            told = f"{len(origins)} and {len(directions)}"
            raise ValueError(f"rays: origins and directions must be as many, got {told}")

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self._origins),)

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        first = real_array("rays", "origins", self._origins[begin:end], "an array of numbers")
        if self._directions is None:
            return first[:, :3], first[:, 3:]
        return first, real_array("rays", "directions", self._directions[begin:end], "an array of numbers")

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        origins, directions = self._lines(begin, end)
        return ArrayRays(origins.copy(), directions.copy()), 0, end - begin
