"""Queries of arrays that live on a card, and answers that stay there: CuPy, PyTorch, JAX, Numba.

An array comes by DLPack or by `__cuda_array_interface__`, without a copy; the work waits for what its stream holds. A
query returns when its work is done, since the CPU decides the doubtful rays. So an answer is complete, and any stream
may use it. Of each ray one byte travels, which says whether it is doubtful.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.validation import describe_kind, is_on_card
from ..kernels.body.hit import is_doubtful
from ..kernels.first_hits import HitBuffers
from ..kernels.ray import RayArrays
from . import points as at_points, ray_queries
from .device import CardMemory, Device, device_of
from .exact.doubtful_rays import resolve_bodies, resolve_hits
from .hits import Hits
from .rays import Rays

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene

# DLPack: an array as a C structure in a capsule

_CUDA = 2
_KINDS = {"i": 0, "u": 1, "f": 2, "b": 6}


class _Tensor(ctypes.Structure):
    _fields_ = (
        ("data", ctypes.c_void_p),
        ("place", ctypes.c_int32),
        ("card", ctypes.c_int32),
        ("ndim", ctypes.c_int32),
        ("kind", ctypes.c_uint8),
        ("bits", ctypes.c_uint8),
        ("lanes", ctypes.c_uint16),
        ("shape", ctypes.POINTER(ctypes.c_int64)),
        ("strides", ctypes.POINTER(ctypes.c_int64)),
        ("offset", ctypes.c_uint64),
        # Of the structure around it
        ("context", ctypes.c_void_p),
        ("deleter", ctypes.c_void_p),
    )


_NAME = b"dltensor"
_pointer_in = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)
_has_name = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p)(("PyCapsule_IsValid", ctypes.pythonapi))
_new_capsule = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)(
    ("PyCapsule_New", ctypes.pythonapi)
)
_loans: dict[int, tuple[Any, ...]] = {}
"""Tensors that other libraries hold, by their addresses, with the arrays behind them."""


def _end_capsule(capsule: int) -> None:
    """Forget a structure that nobody took out of its capsule."""
    if _has_name(capsule, _NAME):
        _loans.pop(_pointer_in(capsule, _NAME), None)


_taker = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_on_deletion, _on_end = _taker(lambda address: _loans.pop(address, None)), _taker(_end_capsule)


class DeviceArray:
    """An array in a card's memory: `cupy.asarray(x)` and `torch.from_dlpack(x)` share it, `np.asarray(x)` copies it.

    Attributes
    ----------
    shape : tuple of int
        The lengths of the axes.
    dtype : np.dtype
        The type of an element.
    size : int
        Number of elements.
    """

    def __init__(self, device: Device, address: int, shape: tuple[int, ...], dtype: Any, owner: Any) -> None:
        self.shape, self.dtype, self.size = shape, np.dtype(dtype), math.prod(shape)
        self._device, self._address, self._owner = device, address, owner

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        data = self._address, False
        return dict(shape=self.shape, typestr=self.dtype.str, data=data, strides=None, stream=None, version=3)

    def __dlpack_device__(self) -> tuple[int, int]:
        return _CUDA, 0

    def __dlpack__(
        self, *, stream: Any = None, max_version: Any = None, dl_device: Any = None, copy: Any = None
    ) -> Any:
        """Return the array in a capsule of DLPack's; its numbers are complete, whatever the stream."""
        if copy or dl_device not in (None, self.__dlpack_device__()):
            raise BufferError("DeviceArray: DLPack shares the array on its card, without a copy")
        lengths = (ctypes.c_int64 * len(self.shape))(*self.shape)
        kind, bits = _KINDS[self.dtype.kind], 8 * self.dtype.itemsize
        deleter = ctypes.cast(_on_deletion, ctypes.c_void_p)
        tensor = _Tensor(self._address, _CUDA, 0, len(self.shape), kind, bits, 1, lengths, None, 0, None, deleter)
        address = ctypes.addressof(tensor)
        _loans[address] = tensor, lengths, self
        return _new_capsule(address, _NAME, ctypes.cast(_on_end, ctypes.c_void_p))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        if copy is False:
            raise ValueError("DeviceArray: an array of NumPy's is a copy")
        array = np.empty(self.shape, self.dtype)
        if array.size:
            self._device.fetch(array, self._address)
        return array if dtype is None else array.astype(dtype)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("DeviceArray: that of a single ray or point has no length")
        return self.shape[0]

    def __repr__(self) -> str:
        return f"DeviceArray(shape={self.shape}, dtype={self.dtype})"

    def _as(self, shape: tuple[int, ...], dtype: Any = None) -> DeviceArray:
        """Return the same memory in another form."""
        return DeviceArray(self._device, self._address, shape, dtype or self.dtype, self._owner)

    def _part(self, first: int, last: int, count: int) -> list[int]:
        """Return what a kernel takes for rows first..last: address and length. One row stands for all `count` rows."""
        rows = self.shape[0]
        if rows != count:
            return [self._address, rows]
        return [self._address + first * (self.size // max(1, rows)) * self.dtype.itemsize, last - first]


def _new_arrays(device: Device, *kinds: tuple[tuple[int, ...], Any]) -> list[DeviceArray]:
    """Return arrays of these shapes and types in one piece of memory, not initialised."""
    sizes = [-(-math.prod(shape) * np.dtype(dtype).itemsize // 256) * 256 for shape, dtype in kinds]
    memory = CardMemory(device.driver, sum(sizes))
    places = np.cumsum([memory.address, *sizes]).tolist()
    return [DeviceArray(device, place, *kind, memory) for place, kind in zip(places, kinds, strict=False)]


def _upload(device: Device, array: Any) -> DeviceArray:
    """Return a copy of an array on the card."""
    (there,) = _new_arrays(device, (array.shape, array.dtype))
    if array.size:
        device.send(there._address, np.ascontiguousarray(array))
    return there


def _copy_rows(few: DeviceArray, many: DeviceArray, which: Any, back: bool) -> None:
    """Copy the rows `which` of an array into another one, or back."""
    rows, width = _upload(many._device, which), many.size // many.shape[0] * many.dtype.itemsize
    pair = (few, many) if back else (many, few)
    numbers = [n for each in pair for n in (each._address, each.size * each.dtype.itemsize)]
    numbers += [rows._address, len(which), width, int(back)]
    many._device.run_on_card("copy_rows", lambda first, last: numbers, len(which))


def _fetch_rows(array: DeviceArray, which: Any) -> Any:
    """Return some rows of an array on the card, here; one row stands for all."""
    if array.shape[0] == 1:
        return np.asarray(array)
    (few,) = _new_arrays(array._device, ((len(which), *array.shape[1:]), array.dtype))
    _copy_rows(few, array, which, False)
    return np.asarray(few)


def _put(array: DeviceArray, which: Any, values: Any) -> None:
    """Write some rows of an array on the card."""
    _copy_rows(_upload(array._device, values), array, which, True)


# Arguments of a query

_CardRays: Any = RayArrays
_CardHits: Any = HitBuffers
"""With a `DeviceArray` for each field."""


def _as_card_array(query: str, name: str, value: Any, device: Device) -> DeviceArray:
    """Return an array of another library, after its work there; raise TypeError or ValueError for a wrong one."""
    if not is_on_card(value):
        raise TypeError(f"{query}: {name} must be an array on the card, as the others are, got {describe_kind(value)}")
    address, kind, shape, strides, owner = (_by_dlpack if hasattr(type(value), "__dlpack__") else _by_interface)(
        value, device
    )
    expected = f"{query}: {name} on a card must be"
    if kind != "f8":
        raise ValueError(f"{expected} of float64, got one of {kind}")
    if len(shape) == 0 or shape[-1] != 3:
        raise ValueError(f"{expected} of shape (..., 3), got {shape}")
    count = math.prod(shape)
    steps = [math.prod(shape[axis + 1 :]) for axis in range(len(shape))]
    if count and any(n > 1 and have != want for n, have, want in zip(shape, strides or steps, steps, strict=True)):
        raise ValueError(f"{expected} contiguous, in C order, got strides of {tuple(strides)} numbers")
    if count and device.driver.card_of(address) != 0:
        raise ValueError(f"{expected} on the first card, which Conicoid uses")
    return DeviceArray(device, address, shape, np.float64, owner)


def _by_dlpack(value: Any, device: Device) -> tuple[Any, ...]:
    """Return address, type, shape, strides or None, and what holds the memory."""
    capsule = value.__dlpack__(stream=device.driver.number(device.lanes[0].stream))
    tensor = _Tensor.from_address(_pointer_in(id(capsule), _NAME))
    shape = tuple(tensor.shape[: tensor.ndim])
    strides = tuple(tensor.strides[: tensor.ndim]) if tensor.strides else None
    letter = {number: letter for letter, number in _KINDS.items()}.get(tensor.kind, "?") * (tensor.lanes == 1)
    # The capsule, which keeps its name, gives the memory back
    return (tensor.data or 0) + tensor.offset, f"{letter}{tensor.bits // 8}", shape, strides, (value, capsule)


def _by_interface(value: Any, device: Device) -> tuple[Any, ...]:
    """`_by_dlpack` by the interface of Numba and CuPy."""
    found = value.__cuda_array_interface__
    stream = found.get("stream", 1)  # older interfaces know the default stream alone
    # A stream of another card cannot be followed; the caller refuses such an array
    if stream is not None and math.prod(found["shape"]) and device.driver.card_of(found["data"][0]) == 0:
        device.driver.follow(device.lanes[0].stream, stream)
    kind = np.dtype(found["typestr"])
    strides = found.get("strides")
    steps = None if strides is None else tuple(step // kind.itemsize for step in strides)
    letters = kind.str[1:] if kind.isnative and found.get("mask") is None else f"{kind.str}, or masked"
    return found["data"][0], letters, tuple(found["shape"]), steps, value


def _flag(device: Device, function: str, *arrays: DeviceArray, count: int) -> bool:
    """Return whether a function that checks arrays has found anything."""
    flag = _upload(device, np.zeros(1, np.int8))
    numbers = [n for array in arrays for n in (array._address, array.shape[0])]
    numbers += [count, flag._address] if function == "check_rays" else [flag._address]
    device.run_on_card(function, lambda first, last: numbers, count)
    return bool(np.asarray(flag)[0])


def _open(query: str, executor: Any, device: str | None) -> Device:
    """Return the card. Raise TypeError where a query must not go there."""
    if query not in ("first_hit", "occluded", "contains", "body_at"):
        raise TypeError(f"{query}: arrays on a card are not taken; copy them to NumPy")
    if executor is not None:
        raise TypeError(f"{query}: executor must be left out for arrays on a card")
    found = device_of(query, device or "cuda")
    if found is None:
        raise TypeError(f"{query}: device must be 'cuda' for arrays on a card, got {device!r}")
    return found


def query_rays(
    scene: PreparedScene, query: str, executor: Any, device: str | None, origins: Any, directions: Any, t_min: Any,
    t_max: Any,
) -> DeviceHits | DeviceArray:  # fmt: skip
    """Return the first hits of rays on a card, or whether they are occluded."""
    gpu = _open(query, executor, device)
    o, d = (_as_card_array(query, name, x, gpu) for name, x in (("origins", origins), ("directions", directions)))
    if o.shape != d.shape:
        raise ValueError(f"{query}: origins and directions on a card must have one shape, got {o.shape} and {d.shape}")
    for name, value in (("t_min", t_min), ("t_max", t_max)):
        if is_on_card(value):
            raise TypeError(f"{query}: {name} must be a number or an array of NumPy's, got {describe_kind(value)}")
    shape, count = o.shape[:-1], o.size // 3
    if _flag(gpu, "check_rays", o._as((3 * count,)), d._as((3 * count,)), count=count):
        Rays(np.asarray(o), np.asarray(d))  # which raises
    limits = [ray_queries.limits_of(query, o._as(shape), name, t) for name, t in (("t_min", t_min), ("t_max", t_max))]  # type: ignore[arg-type]
    lines = o._as((count, 3)), d._as((count, 3))
    arrays = _CardRays(*lines, *(_upload(gpu, each) for each in (*limits, np.full(1, -1, np.int32))))
    return (_first_hit if query == "first_hit" else _occluded)(scene, gpu, arrays, shape)


def _first_hit(scene: PreparedScene, gpu: Device, rays: Any, shape: tuple[int, ...]) -> DeviceHits:
    count = rays.origins.shape[0]
    found = _CardHits(*_new_arrays(gpu, *(((count,), kind) for kind in ("f8", "i4", "i4", "i4", "i1"))))
    if not _trace(scene, gpu, "first_hits", rays, found):
        hits = ray_queries.first_hit(scene, _host_rays(rays), np.asarray(rays.t_min), np.asarray(rays.t_max), "cpu")
        return DeviceHits(scene, gpu, rays, shape, _CardHits(*(_upload(gpu, x) for x in hits._buffers)), hits._doubtful)
    doubtful = is_doubtful(np.asarray(found.turn)).nonzero()[0]
    if len(doubtful):
        some, few = (tuple(_fetch_rows(array, doubtful) for array in arrays) for arrays in (rays, found))
        arrays, decided, every = RayArrays(*some), HitBuffers(*few), np.arange(len(doubtful))
        tied = resolve_hits(scene, arrays, every, decided)
        for array, values in zip(found, decided, strict=True):
            _put(array, doubtful, values)
        doubtful = doubtful[tied]
    return DeviceHits(scene, gpu, rays, shape, found, doubtful)


def _occluded(scene: PreparedScene, gpu: Device, rays: Any, shape: tuple[int, ...]) -> DeviceArray:
    (result,) = _new_arrays(gpu, (rays.origins.shape[:1], "i1"))
    if not _trace(scene, gpu, "any_hits", rays, (result,)):
        answer = ray_queries.occluded(scene, _host_rays(rays), np.asarray(rays.t_min), np.asarray(rays.t_max), "cpu")
        return _upload(gpu, np.asarray(answer))._as(shape)
    doubtful = is_doubtful(np.asarray(result)).nonzero()[0]
    if len(doubtful):
        some = RayArrays(*(_fetch_rows(array, doubtful) for array in rays))
        hits = HitBuffers.new(len(doubtful))
        resolve_hits(scene, some, np.arange(len(doubtful)), hits)
        _put(result, doubtful, (hits.body >= 0).astype(np.int8))
    return result._as(shape, np.bool_)


def query_points(scene: PreparedScene, query: str, executor: Any, device: str | None, points: Any) -> DeviceArray:
    """Return the first body at each point on a card, or whether there is one."""
    gpu = _open(query, executor, device)
    given = _as_card_array(query, "points", points, gpu)
    shape, count = given.shape[:-1], given.size // 3
    flat = given._as((count, 3))
    if _flag(gpu, "check_points", flat, count=count):
        at_points.points_of(query, np.asarray(given))  # which raises
    bodies, undecided = _new_arrays(gpu, ((count,), "i4"), ((count,), "i1"))
    if _trace(scene, gpu, "first_bodies", (flat, _upload(gpu, at_points.BEFORE_FIRST)), (bodies, undecided)):
        doubtful = np.asarray(undecided).nonzero()[0]
        if len(doubtful):
            found = np.empty(len(doubtful), np.int32)
            resolve_bodies(scene, _fetch_rows(flat, doubtful), at_points.BEFORE_FIRST, np.arange(len(doubtful)), found)
            _put(bodies, doubtful, found)
    else:
        bodies = _upload(gpu, at_points.body_at(scene, np.asarray(flat), query, "cpu"))
    if query == "body_at":
        return bodies._as(shape)
    (result,) = _new_arrays(gpu, ((count,), "i1"))
    gpu.run_on_card("are_bodies", lambda first, last: [bodies._address, count, result._address, count], count)
    return result._as(shape, np.bool_)


def _trace(scene: PreparedScene, gpu: Device, function: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> bool:
    """Run a function with scratch memory on rays or points."""
    count = inputs[0].shape[0]

    def numbers(first: int, last: int) -> list[int]:
        return [n for array in (*inputs, *outputs) for n in array._part(first, last, count)]

    return gpu.run_on_card(function, numbers, count, scene)


def _host_rays(rays: Any) -> Rays:
    """Return rays as queries of the CPU take them."""
    return Rays._spawned(np.asarray(rays.origins), np.asarray(rays.directions), np.full(1, -1, np.int32))


class DeviceHits:
    """First hits of rays on a card, shaped like the rays. Each field is a `DeviceArray`, made when it is needed.

    They hold the arrays of the rays without a copy. Writing to these arrays changes fields that are computed later.

    Attributes
    ----------
    t : float64 (...)
        In units of the direction's length; inf for a miss.
    body, face, surface : int32 (...)
        Numbers; -1 for a miss.
    hit, entering, doubtful : bool (...)
        As those of `Hits`.
    point, normal : float64 (..., 3)
        NaN for a miss.
    uv : float64 (..., 2)
        NaN for a miss.
    shape : tuple of int
        That of `t`.
    """

    def __init__(
        self, scene: PreparedScene, device: Device, rays: Any, shape: tuple[int, ...], found: Any,
        doubtful: Any,
    ) -> None:  # fmt: skip
        self._scene, self._device, self._rays, self._found, self._doubtful = scene, device, rays, found, doubtful
        self.shape, self._count = shape, rays.origins.shape[0]

    def __repr__(self) -> str:
        return f"DeviceHits(shape={self.shape})"

    def to_host(self) -> Hits:
        """Return a copy in the memory of the CPU, which has all other fields."""
        o, d = (np.asarray(lines._as((*self.shape, 3))) for lines in self._rays[:2])
        rays = Rays._spawned(o, d, np.full(1, -1, np.int32))
        return Hits(self._scene, rays, HitBuffers(*map(np.asarray, self._found)), self._doubtful)

    def _fill(self, function: str, inputs: Sequence[Any], outputs: Sequence[Any], flag: Any = None) -> None:
        """Run a kernel of the CPU's on all rows; one that has a flag needs no tables."""
        n = self._count
        given, made = ([number for x in some for number in (x._address, n)] for some in (inputs, outputs))
        numbers = [*given, n, *made, *([] if flag is None else [flag._address])]
        self._device.run_on_card(function, lambda first, last: numbers, n, self._scene if flag is None else None)

    def _flags(self, function: str, array: Any) -> DeviceArray:
        """Return a number for each ray, 0 or 1, as bool."""
        n, (result,) = self._count, _new_arrays(self._device, ((self._count,), "i1"))
        self._device.run_on_card(function, lambda first, last: [array._address, n, result._address, n], n)
        return result._as(self.shape, np.bool_)

    @property
    def t(self) -> DeviceArray:
        return self._found.t._as(self.shape)

    @property
    def body(self) -> DeviceArray:
        return self._found.body._as(self.shape)

    @cached_property
    def hit(self) -> DeviceArray:
        return self._flags("are_bodies", self._found.body)

    @cached_property
    def entering(self) -> DeviceArray:
        return self._flags("are_entries", self._found.turn)

    @cached_property
    def doubtful(self) -> DeviceArray:
        flags = np.zeros(self._count, np.bool_)
        flags[self._doubtful] = True
        return _upload(self._device, flags)._as(self.shape)

    @cached_property
    def _faces(self) -> DeviceArray:
        (faces,) = _new_arrays(self._device, ((3, self._count), "i4"))
        self._fill("faces_of", self._found[2:], [faces])
        return faces

    def _row_of_faces(self, row: int) -> DeviceArray:
        faces = self._faces
        return DeviceArray(self._device, faces._address + 4 * row * self._count, self.shape, "i4", faces)

    @property
    def surface(self) -> DeviceArray:
        return self._row_of_faces(0)

    @property
    def face(self) -> DeviceArray:
        return self._row_of_faces(1)

    @cached_property
    def _points(self) -> DeviceArray:
        far, (points,) = (
            _upload(self._device, np.zeros(1, np.int8)),
            _new_arrays(self._device, ((self._count, 3), "f8")),
        )
        lines, found = self._rays[:2], self._found
        self._fill("hit_points", [*lines, found.t], [points], far)
        if np.asarray(far)[0]:
            (errors,) = _new_arrays(self._device, ((self._count,), "f8"))
            self._fill("refine_points", [*lines, found.t, found.turn, self._faces], [points, errors])
        return points

    @property
    def point(self) -> DeviceArray:
        return self._points._as((*self.shape, 3))

    @cached_property
    def normal(self) -> DeviceArray:
        n, (normals,) = self._count, _new_arrays(self._device, ((self._count, 3), "f8"))
        self._fill("normals_of", [self._faces, self._points], [normals])
        self._device.run_on_card("clear_negligible", lambda first, last: [normals._address, n], n)
        return normals._as((*self.shape, 3))

    @cached_property
    def uv(self) -> DeviceArray:
        (uv,) = _new_arrays(self._device, ((self._count, 2), "f8"))
        self._fill("uvs_of", [self._found.body, self._faces, self._points], [uv])
        return uv._as((*self.shape, 2))
