"""Arrays that live on a card: those of CuPy, PyTorch, JAX and Numba as arguments, and `DeviceArray` in answers.

An array comes by DLPack or by `__cuda_array_interface__`; the work waits for the tasks in its stream. Arrays of float64
in C order are used where they are. A kernel copies others: float32, gaps, another order of axes, repeated rows.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._util.validation import describe_kind, is_on_card
from ..kernels.ray import RayArrays
from ..prepare.prepared_scene import PreparedScene
from . import ray_queries
from .device import CardMemory, Device
from .rays import Rays

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

    def _row(self, number: int, shape: tuple[int, ...]) -> DeviceArray:
        """Return a row of two or three, which keeps the memory of all."""
        address = self._address + number * (self.size // self.shape[0]) * self.dtype.itemsize
        return DeviceArray(self._device, address, shape, self.dtype, self)

    def _part(self, first: int, last: int, count: int) -> list[int]:
        """Return the arguments of a kernel for rows first..last: address and length. One row stands for all `count`."""
        rows = self.shape[0]
        if rows != count:
            return [self._address, rows]
        return [self._address + first * (self.size // max(1, rows)) * self.dtype.itemsize, last - first]


def new_arrays(device: Device, *kinds: tuple[tuple[int, ...], Any]) -> list[DeviceArray]:
    """Return arrays of these shapes and types in one piece of memory, not initialised."""
    sizes = [-(-math.prod(shape) * np.dtype(dtype).itemsize // 256) * 256 for shape, dtype in kinds]
    memory = CardMemory(device.driver, sum(sizes))
    places = np.cumsum([memory.address, *sizes]).tolist()
    return [DeviceArray(device, place, *kind, memory) for place, kind in zip(places, kinds, strict=False)]


def upload(device: Device, array: Any) -> DeviceArray:
    """Return a copy of an array on the card."""
    (there,) = new_arrays(device, (array.shape, array.dtype))
    if array.size:
        device.send(there._address, np.ascontiguousarray(array))
    return there


def _copy_rows(few: DeviceArray, many: DeviceArray, which: Any, back: bool) -> None:
    """Copy the rows `which` of an array into another one, or back."""
    rows, width = upload(many._device, which), many.size // many.shape[0] * many.dtype.itemsize
    pair = (few, many) if back else (many, few)
    numbers = [n for each in pair for n in (each._address, each.size * each.dtype.itemsize)]
    numbers += [rows._address, len(which), width, int(back)]
    many._device.run_on_card("copy_rows", lambda first, last: numbers, len(which))


def fetch_rows(array: DeviceArray, which: Any) -> Any:
    """Return some rows of an array on the card, here; one row stands for all."""
    if array.shape[0] == 1:
        return np.asarray(array)
    (few,) = new_arrays(array._device, ((len(which), *array.shape[1:]), array.dtype))
    _copy_rows(few, array, which, False)
    return np.asarray(few)


def put_rows(array: DeviceArray, which: Any, values: Any) -> None:
    """Write some rows of an array on the card."""
    _copy_rows(upload(array._device, values), array, which, True)


# Arguments of a query


class CardView(NamedTuple):
    """An array of another library: numbers of a kind in any order, `steps` apart; None for C order."""

    address: int
    kind: str
    shape: tuple[int, ...]
    steps: tuple[int, ...] | None
    owner: Any

    def vectors(self, device: Device, shape: tuple[int, ...]) -> DeviceArray:
        """Return the vectors (n, 3) of float64, in C order, broadcast to a shape (..., 3)."""
        plain = [math.prod(self.shape[axis + 1 :]) for axis in range(len(self.shape))]
        steps, count = self.steps or plain, math.prod(shape) // 3
        is_plain = all(n <= 1 or have == want for n, have, want in zip(self.shape, steps, plain, strict=True))
        if self.shape == shape and ((self.kind == "f8" and is_plain) or count == 0):
            return DeviceArray(device, self.address, (count, 3), np.float64, self.owner)
        (copy,) = new_arrays(device, ((count, 3), "f8"))
        added = len(shape) - len(self.shape)
        each = [0 if n == 1 else step for n, step in zip(self.shape, steps, strict=True)]
        # Numba counts a negative place from the end of the array: the first number is that at the lowest address
        low = sum(min(0, (n - 1) * step) for n, step in zip(self.shape, each, strict=True))
        long = sum((n - 1) * abs(step) for n, step in zip(self.shape, each, strict=True)) + 1
        axes = [upload(device, np.array(axis, np.int64)) for axis in (shape[:-1], [0] * added + each)]
        numbers = [self.address + low * int(self.kind[1:]), long, *(n for x in axes for n in (x._address, x.size))]
        function = "copy_vectors" if self.kind == "f8" else "copy_single_vectors"
        device.run_on_card(function, lambda first, last: [*numbers, -low, copy._address, count], count)
        return copy


def view_of(query: str, name: str, value: Any, device: Device) -> CardView:
    """Return an array of another library, after its work there; raise TypeError or ValueError for a wrong one."""
    if not is_on_card(value):
        raise TypeError(f"{query}: {name} must be an array on the card, as the others are, got {describe_kind(value)}")
    view = CardView(*(_by_dlpack if hasattr(type(value), "__dlpack__") else _by_interface)(value, device))
    expected = f"{query}: {name} on a card must be"
    if view.kind not in ("f8", "f4"):
        raise ValueError(f"{expected} of float64 or float32, got one of {view.kind}")
    if len(view.shape) == 0 or view.shape[-1] != 3:
        raise ValueError(f"{expected} of shape (..., 3), got {view.shape}")
    if math.prod(view.shape) and device.driver.card_of(view.address) != 0:
        raise ValueError(f"{expected} on the first card, which Conicoid uses")
    return view


def _by_dlpack(value: Any, device: Device) -> tuple[Any, ...]:
    """Return address, type, shape, strides or None, and the owner of the memory."""
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
    if any(step % kind.itemsize for step in strides or ()):
        letters = f"{kind.str} in steps of {strides} bytes"
    return found["data"][0], letters, tuple(found["shape"]), steps, value


def find_flag(device: Device, function: str, numbers: list[int], count: int) -> bool:
    """Return whether a function that checks arrays has found anything; its last argument is a flag."""
    flag = upload(device, np.zeros(1, np.int8))
    device.run_on_card(function, lambda first, last: [*numbers, flag._address], count)
    return bool(np.asarray(flag)[0])


_CardRays: Any = RayArrays
"""With a `DeviceArray` for each field."""


class DeviceRays:
    """Rays in a card's memory, as `DeviceHits.spawn` returns them. Queries take them as they take `Rays`.

    They unpack to (origins, directions).

    Attributes
    ----------
    origins, directions : float64 (..., 3)
        As `DeviceArray`.
    shape : tuple of int
        The leading shape.
    """

    _is_on_card = True  # for `is_on_card`

    def __init__(self, shape: tuple[int, ...], lines: Sequence[DeviceArray], starts: DeviceArray, home: Any) -> None:
        self.shape, self._lines, self._starts, self._home = shape, lines, starts, home
        self.origins, self.directions = (each._as((*shape, 3)) for each in lines)

    def __iter__(self) -> Iterator[DeviceArray]:
        return iter((self.origins, self.directions))

    def __repr__(self) -> str:
        return f"DeviceRays(shape={self.shape})"

    def to_host(self) -> Rays:
        """Return a copy in the memory of the CPU."""
        o, d, starts = map(np.asarray, (*self, self._starts))
        return Rays._spawned(o, d, starts, self._home)

    def _arrays(self, query: str, scene: PreparedScene, t_min: Any, t_max: Any) -> Any:
        """Return rays and limits as kernels take them."""
        for name, value in (("t_min", t_min), ("t_max", t_max)):
            if is_on_card(value):
                raise TypeError(f"{query}: {name} must be a number or an array of NumPy's, got {describe_kind(value)}")
        starts, device = self._starts, self._starts._device
        limits = [ray_queries.limits_of(query, self, name, t) for name, t in (("t_min", t_min), ("t_max", t_max))]  # type: ignore[arg-type]
        if self._home is not None and self._home != scene.key:
            starts = upload(device, np.minimum(np.asarray(starts), np.int32(-1)))  # DEAD is below -1
        return _CardRays(*self._lines, *(upload(device, limit) for limit in limits), starts)


def rays_of(query: str, gpu: Device, origins: Any, directions: Any) -> DeviceRays:
    """Return the rays of a query's first two arguments."""
    if isinstance(origins, DeviceRays):
        if directions is not None:
            raise TypeError(f"{query}: directions must be left out where a DeviceRays is given")
        return origins
    views = [view_of(query, name, x, gpu) for name, x in (("origins", origins), ("directions", directions))]
    try:
        shape = np.broadcast_shapes(*(view.shape for view in views))
    except ValueError:
        raise ValueError(
            f"{query}: origins {views[0].shape} and directions {views[1].shape} do not broadcast together"
        ) from None
    lines = [view.vectors(gpu, shape) for view in views]
    count = len(lines[0])
    if find_flag(gpu, "check_rays", [*(n for each in lines for n in (each._address, each.size)), count], count):
        Rays(*(np.asarray(each._as(shape)) for each in lines))  # which raises
    return DeviceRays(shape[:-1], lines, upload(gpu, np.full(1, -1, np.int32)), None)
