"""`Rays`, arrays of rays as queries take them, and `LazyRays`, which are computed where they are traced."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._jit.machine_code import empty_array, is_frozen
from .._util.arrays import FloatArray, ignore_fp_errors
from .._util.records import align_array
from .._util.validation import (
    DOMAIN,
    check_npz_path,
    check_path as checked_path,
    describe_kind,
    format_value,
    real_array,
    refuse_columns,
)
from ..kernels.threads import KernelRange, Progress, run_chunks
from .result import ShapedRecord, check_parts, extension

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene

# Arrays of rays

_REASONS = {
    1: "origin must be finite",
    2: "direction must be finite",
    3: "direction must not be zero",
    4: f"origin must be {DOMAIN} in every component",
    5: f"direction must be {DOMAIN} in every component",
}


def points_array(owner: str, field: str, values: Any, keep_single: bool = False) -> FloatArray:
    """Return `values` as a float64 array (..., 3). Raise ValueError, naming owner and field, for anything else.

    keep_single: whether an array of float32 remains one.
    """
    is_single = keep_single and type(values) is np.ndarray and values.dtype == np.float32 and values.flags.aligned
    array = values if is_single else real_array(owner, field, values, "an array of numbers (..., 3)")
    # [] has no axis of three, but means no rays
    if array.ndim == 1 and array.size == 0:
        array = array.reshape(0, 3)
    refuse_columns(owner, field, values)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{owner}: {field} must have shape (..., 3), got {array.shape}")
    return array


def find_invalid_ray(origins: FloatArray, directions: FloatArray) -> tuple[int, str] | None:
    """Return (index, reason) of the first ray of arrays (n, 3) that cannot be traced; None if all are valid."""
    from .hit_fields import first_invalid

    index, reason = first_invalid(origins, directions)
    if not reason:
        return None
    value = (origins if reason in (1, 4) else directions)[index]
    return index, f"{_REASONS[reason]}, got {tuple(value.tolist())}"


_NO_START = np.array([-1], np.int32)
_NO_START.flags.writeable = False


class Rays(ShapedRecord):
    """Rays of any leading shape, read-only.

    Parameters
    ----------
    origins, directions : array_like (..., 3)
        Finite float64 arrays that broadcast against each other. Directions may have any length except 0; t is in
        units of that length. They are copied, except 8,192 rays or more in two C-contiguous float64 arrays of one shape
        that are read-only and own their memory. Whoever writes to such an array later, through a view made before or
        after making it writable again, changes the rays.

    Raises
    ------
    ValueError
        For NaN, infinite or zero input, with the index of the first such ray.

    Notes
    -----
    Rays unpack to (origins, directions), so a loop over rays yields these two arrays. `rays[i]` is one ray,
    `rays[2:5]` are three, `len(rays)` is the length of the first axis, and `for hit in hits` gives the ray of each hit
    as `hit.rays`.

    Spawned rays store the number of the surface on which they start, and the key of its scene. In a scene with other
    surfaces they act as plain rays with the same origins and directions. Unpacking drops the surface.
    """

    __slots__ = ("_home", "_starts", "directions", "origins")
    __hash__ = None  # type: ignore[assignment]
    origins: FloatArray
    directions: FloatArray
    _starts: npt.NDArray[np.int32]  # surface numbers, -1 for none, or DEAD; one for all rays or one for each
    _home: bytes | None  # `PreparedScene.key` of the scene of these surfaces

    @ignore_fp_errors
    def __init__(self, origins: npt.ArrayLike, directions: npt.ArrayLike) -> None:
        o, d = points_array("Rays", "origins", origins, True), points_array("Rays", "directions", directions, True)
        try:
            shape = np.broadcast_shapes(o.shape, d.shape)
        except ValueError:
            raise ValueError(f"Rays: origins {o.shape} and directions {d.shape} do not broadcast together") from None
        # Many rays are checked on all threads, and kept without a copy where that is safe
        if math.prod(shape) >= _MANY:
            o, d, wrong = _check_many(o, d, shape)
        else:
            o, d = own_copy(o, shape), own_copy(d, shape)
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
        # The class refuses assignment, to itself as well
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
        """Return rays without validating them.

        starts: surface numbers, -1 or DEAD; home: the key of the scene of these surfaces.
        """
        rays = object.__new__(cls)
        rays._keep(origins, directions, starts, home)
        return rays

    @classmethod
    def _of_few(
        cls, lines: bytes, single: bool = False, start: npt.NDArray[np.int32] = _NO_START, home: bytes | None = None
    ) -> Rays:
        """Return a list of rays, or a single one, without validating them, from the bytes of origins and directions."""
        start.flags.writeable = False
        rays = object.__new__(cls)
        origins, directions = np.frombuffer(lines).reshape((2, 3) if single else (2, -1, 3))
        for name, value in zip(cls.__slots__, (home, start, directions, origins), strict=True):
            object.__setattr__(rays, name, value)
        return rays

    def _starts_in(self, scene: PreparedScene) -> npt.NDArray[np.int32]:
        """Return the surfaces of `scene` on which the rays start: -1 for all in a scene with other surfaces.

        DEAD rays, spawned from misses, stay dead in every scene.
        """
        starts = self._starts
        if not starts.size:
            return np.array([-1], np.int32)
        if (len(starts) == 1 and starts[0] < 0) or (self._home is not None and self._home == scene.key):
            return starts
        return np.minimum(starts, np.int32(-1))  # DEAD is below -1

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"Rays are read-only: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        """Return True if origins, directions and start surfaces are equal; never an array."""
        if not isinstance(other, Rays):
            return NotImplemented
        # One start for all equals the same start for each
        mine, its = (np.broadcast_to(r._starts, (r.origins.size // 3,)) for r in (self, other))
        pairs = (self.origins, other.origins), (self.directions, other.directions)
        if not all(np.array_equal(a, b, equal_nan=True) for a, b in pairs) or not np.array_equal(mine, its):
            return False
        return self._home == other._home or not (mine >= 0).any()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self)._spawned, (self.origins, self.directions, self._starts, self._home)

    @classmethod
    def concatenate(cls, parts: Iterable[Rays]) -> Rays:
        """Join rays along the first axis, like `np.concatenate`; a single ray counts as a row of one.

        Parameters
        ----------
        parts : iterable of Rays
            Spawned rays keep their start surfaces if all of these belong to one scene.

        Raises
        ------
        TypeError
            If a part is not a Rays.
        ValueError
            If `parts` is empty, or if shapes differ in another axis than the first.
        """
        return join_rays("Rays", check_parts(Rays, parts))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rays as a .npz file that `co.Rays.load`, `conicoid trace` and NumPy read.

        Parameters
        ----------
        path : path
            Must end with .npz. The complete file appears at once, or none.

        Raises
        ------
        ValueError
            For another suffix.
        OSError
            If the file cannot be written.
        """
        suffix = os.path.splitext(checked_path("save", path))[1].lower()
        if suffix in (".npy", ".csv"):
            both = "np.concatenate([*rays], axis=-1)"
            written = f"np.save(path, {both})" if suffix == ".npy" else f'np.savetxt(path, {both}, delimiter=",")'
            raise ValueError(
                f"save: path of rays must end with .npz, got {format_value(os.fspath(path))}; {written} writes that"
            )
        extension("rays.write")(check_npz_path("save", "rays", path), self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Rays:
        """Return the rays in a file.

        Parameters
        ----------
        path : path
            A file that `save` wrote, or another that `conicoid trace` reads (docs/files.md): a .npz file with arrays
            `origins` and `directions`, a .npy file (..., 6), a .csv or .parquet file, or a .zarr folder.

        Raises
        ------
        ValueError
            If the file has none of these formats, or intervals; the message names the file.
        OSError
            If the file cannot be read.
        """
        return extension("rays.read")(checked_path("load", path))

    @staticmethod
    def from_camera(camera: Any, width: int, height: int) -> LazyRays:
        """Return the rays of the pixels of a camera, computed in parts where they are traced, on workers too.

        Parameters
        ----------
        camera : Camera, OrthographicCamera or another camera
            For example `scene.camera`.
        width, height : int
            Pixels of the picture. The rays equal `camera.rays(width, height)` to the bit.

        Raises
        ------
        TypeError
            If `camera` is not a camera.
        """
        make = getattr(camera, "lazy_rays", None)
        if not callable(make):
            raise TypeError(
                f"from_camera: camera must be a Camera or an OrthographicCamera, got {describe_kind(camera)}"
            )
        rays = make(width, height)
        assert isinstance(rays, LazyRays)
        return rays

    @staticmethod
    def from_scan(geometry: Any) -> LazyRays:
        """Return the rays of all pixels of a scan, computed where they are traced.

        Parameters
        ----------
        geometry : ScanGeometry
            A scan of `co.ct`. Queries use its `interval` unless they get another one.

        Raises
        ------
        TypeError
            If `geometry` is not a scan.
        """
        rays = getattr(geometry, "lazy_rays", None)
        if not isinstance(rays, LazyRays):
            raise TypeError(f"from_scan: geometry must be one of co.ct, got {describe_kind(geometry)}")
        return rays

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape."""
        return self.origins.shape[:-1]

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.origins, self.directions))

    def __getitem__(self, index: Any) -> Rays:
        starts = self._starts
        if len(starts) > 1 or self.origins.size == 3:
            starts = np.atleast_1d(np.broadcast_to(starts, (self.origins.size // 3,)).reshape(self.shape)[index])
        if isinstance(index, tuple) and any(part is Ellipsis for part in index):  # it must not select x, y or z
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


def lines_of(rays: Rays) -> tuple[FloatArray, FloatArray]:
    """Return origins and directions, both (n, 3)."""
    return rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3)


def own_copy(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return a contiguous copy, broadcast to a shape."""
    whole = array if array.shape == shape else np.broadcast_to(array, shape)  # broadcast_to takes as long as one query
    return np.array(whole, dtype=np.float64, order="C")


_MANY = 3 << 13  # numbers in an array of rays that threads check and copy
_CHECK_CHUNK = 1 << 14  # rays that a thread takes at a time, at most


def _check_many(
    origins: Any, directions: Any, shape: tuple[int, ...]
) -> tuple[FloatArray, FloatArray, tuple[int, str] | None]:
    """Return frozen arrays as they are, and copies of others, as `own_copy` makes them, and the first invalid ray."""
    from .hit_fields import check_rays, copy_rays, copy_single_rays

    bad = np.zeros(1, np.int8)
    if _is_kept(origins, shape) and _is_kept(directions, shape):
        own = origins, directions
        work = KernelRange(check_rays, (origins.reshape(-1), directions.reshape(-1)), (bad,))
    else:
        own = empty_array(shape, np.float64), empty_array(shape, np.float64)
        is_single = origins.dtype == directions.dtype == np.float32
        both = (origins, directions) if is_single else (np.asarray(a, np.float64) for a in (origins, directions))
        rows = tuple(np.broadcast_to(array, shape).reshape(-1, 3) for array in both)
        kernel: Any = copy_single_rays if is_single else copy_rays
        work = KernelRange(kernel, rows, (own[0].reshape(-1, 3), own[1].reshape(-1, 3), bad))
    run_chunks(work, own[0].size // 3, _CHECK_CHUNK)
    lines = own[0].reshape(-1, 3), own[1].reshape(-1, 3)
    return *own, find_invalid_ray(*lines) if bad[0] else None


def uncopied_rays(origins: Any, directions: Any) -> Rays | None:
    """Return rays on two arrays as they are, unchecked, for a kernel that checks and copies them as it traces.

    None for arrays that it cannot read as they are, and for read-only ones of an array that is not.
    """
    for a in (origins, directions):
        if type(a) is not np.ndarray or a.dtype != np.float64 or not (a.flags.c_contiguous and a.flags.aligned):
            return None
        if not (a.flags.writeable or is_frozen(a)):
            return None
    shape = origins.shape
    if shape != directions.shape or origins.ndim < 2 or shape[-1] != 3 or origins.size < _MANY:
        return None
    return Rays._spawned(origins.view(), directions.view(), np.array([-1], np.int32))


def checked_rays(origins: Any, directions: Any) -> Rays:
    """Return rays for an answer that does not hold them: on the arrays themselves, where kernels can read these."""
    from .hit_fields import check_rays

    rays, bad = uncopied_rays(origins, directions), np.zeros(1, np.int8)
    if rays is not None:
        flat = rays.origins.reshape(-1), rays.directions.reshape(-1)
        run_chunks(KernelRange(check_rays, flat, (bad,)), rays.size, _CHECK_CHUNK)
    return Rays(origins, directions) if rays is None or bad[0] else rays


def _is_kept(array: Any, shape: tuple[int, ...]) -> bool:
    """Return whether rays keep an array of many as it is."""
    return array.shape == shape and array.dtype == np.float64 and array.flags.c_contiguous and is_frozen(array)


def join_rays(owner: str, parts: Sequence[Rays]) -> Rays:
    """Return `Rays.concatenate` of at least one part; messages name `owner`."""
    rows = [part if part.shape else part[None] for part in parts]
    if len({part.shape[1:] for part in rows}) > 1:
        shapes = ", ".join(str(part.shape) for part in rows[:8])
        raise ValueError(f"{owner}: parts must have shapes that differ in the first axis alone, got {shapes}")
    starts = [np.broadcast_to(part._starts, (part.origins.size // 3,)) for part in rows]
    origins, directions = (np.concatenate([p[k] for p in map(tuple, rows)]) for k in (0, 1))
    homes = {part._home for part in rows if (part._starts >= 0).any()}
    together = np.concatenate(starts)
    # Numbers of surfaces mean nothing across scenes
    if len(homes) > 1:
        return Rays._spawned(origins, directions, np.minimum(together, np.int32(-1)))
    return Rays._spawned(origins, directions, together, homes.pop() if homes else None)


def packets_of(count: int, width: int) -> int:
    """Return the number of packets: of squares in a picture of that width, or of 64 rays or points in a row."""
    return -(-width // 8) * -(-count // (8 * width)) if width else -(-count // 64)


def packet_progress(progress: Progress, packets: int, count: int) -> Progress:
    """Return a callback for packets of 64 rays or points that calls another with rays or points."""
    return lambda done, _: progress(count if done == packets else min(64 * done, count), count)


# Rays computed or read in parts, each where it is traced

_BLOCK = 1 << 12  # rays; their arrays (192 KiB) stay in the processor's cache while they are computed and checked


class LazyRays(ShapedRecord):
    """Rays of a camera, a scan or a file that are computed in parts, so that they take a few bytes until then.

    Every query accepts them in place of `Rays`; `to_rays()` returns them as `Rays`. Each ray has the same bits in
    whatever part it is computed.
    """

    _in_blocks = True
    """Whether the rays are computed, in blocks and by several threads, rather than read."""

    @property
    def interval(self) -> tuple[float, float]:
        """The default t_min and t_max of queries."""
        return 0.0, math.inf

    def to_rays(self) -> Rays:
        """Return all rays as `Rays`, 48 bytes each. These have no interval of their own: queries of them start at 0."""
        return self.part(0, self.size, self.shape)

    @ignore_fp_errors
    def part(self, begin: int, end: int, shape: tuple[int, ...] | None = None) -> Rays:
        """Return rays `begin` to `end` of the flat list, in which the last axis varies fastest.

        Parameters
        ----------
        begin, end : int
            The first ray, and the one after the last.
        shape : tuple of int, optional
            A shape of `end - begin` rays; (end - begin,) by default.

        Raises
        ------
        IndexError
            For rays that are not in the list.
        ValueError
            For a shape of more or fewer rays.
        """
        if not 0 <= begin <= end <= self.size:
            raise IndexError(f"part: begin and end must lie within 0 and {self.size}, got {begin} and {end}")
        if shape is not None and math.prod(shape) != end - begin:
            raise ValueError(f"part: shape must be one of {end - begin} rays, got {shape}")
        array_shape = (*((end - begin,) if shape is None else shape), 3)
        if not self._in_blocks:
            origins, directions = self._lines(begin, end)
            return Rays(origins.reshape(array_shape), directions.reshape(array_shape))
        origins, directions = empty_array(array_shape, np.float64), empty_array(array_shape, np.float64)
        bad = np.zeros(1, np.int8)
        work = self._work(begin, origins.reshape(-1, 3), directions.reshape(-1, 3), bad)
        run_chunks(work, end - begin, _CHECK_CHUNK if isinstance(work, KernelRange) else _BLOCK)
        if bad[0]:
            return Rays(origins, directions)  # raises for the first invalid ray
        return Rays._spawned(origins, directions, np.array([-1], np.int32))

    def _work(
        self, begin: int, origins: FloatArray, directions: FloatArray, bad: npt.NDArray[np.int8]
    ) -> Callable[[int, int], Any]:
        """Return the work that writes rays first..last of those from `begin` on; bad[0] = 1 if one is invalid."""

        def fill(first: int, last: int) -> None:
            lines = origins[first:last], directions[first:last]
            lines[0][:], lines[1][:] = self._lines(begin + first, begin + last)
            if find_invalid_ray(*lines) is not None:
                bad[0] = 1

        return fill

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        """Return origins and directions (n, 3) of rays `begin` to `end` of the flat list."""
        raise NotImplementedError

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        """Return lazy rays that include rays `begin` to `end` and pickle small, and the range of these rays in them."""
        return self, begin, end

    def __repr__(self) -> str:
        return f"{type(self).__name__}(shape={self.shape})"


class ArrayRays(LazyRays):
    """Rays in two arrays (n, 3), or one (n, 6), that may lie on a disk: a part reads only its own slice."""

    _in_blocks = False

    def __init__(self, origins: Any, directions: Any = None) -> None:
        self._origins, self._directions = origins, directions
        for name, array, last in (("origins", origins, 6 if directions is None else 3), ("directions", directions, 3)):
            shape = getattr(array, "shape", None)
            if array is not None and (shape is None or len(shape) != 2 or shape[1] != last):
                raise ValueError(f"rays: {name} must be an array of shape (n, {last}), got {shape}")
        if directions is not None and len(origins) != len(directions):
            raise ValueError(
                f"rays: origins and directions must have equal lengths, got {len(origins)} and {len(directions)}"
            )

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
