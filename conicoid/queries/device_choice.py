"""Which device answers queries of rays and points, and renders: the CPU or a GPU."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from .._util.environment import DEVICES, read_device
from .._util.process import fork_safe_lock
from .._util.validation import format_value

if TYPE_CHECKING:
    from .device import Device

_default_device: list[str] = []


def set_device(device: str | None) -> None:
    """Answer queries of rays, `contains` and `body_at`, and render, on a device from now on: "cpu" or "cuda".

    The answers are the same to the bit. One point, one ray and up to a thousand rays in a list stay on the CPU.
    Other queries stay there too, except for parts that call one of these.

    Parameters
    ----------
    device : {"cpu", "cuda"} or None
        None returns to the default: CONICOID_DEVICE, or the CPU.

    Raises
    ------
    ValueError
        For another name.
    ImportError, RuntimeError
        If a package, NVIDIA's driver or a card is missing.
    """
    if device is not None:
        device_of("set_device", device)
    _default_device[:] = [] if device is None else [device]


def device_of(query: str, device: str | None, are_few: bool = False) -> Device | None:
    """Return the GPU that answers a query, None for the CPU; `device` is the argument of the query.

    The CPU answers for few rays or points sooner than they travel, so they go to a card only if the call names it.
    """
    named = device if device is not None else _default_device[-1] if _default_device else read_device()
    if not isinstance(named, str) or named not in DEVICES:
        names = " or ".join(map(repr, DEVICES))
        raise ValueError(f"{query}: device must be {names}, got {format_value(device)}")
    found = None if named == "cpu" else _first_device()  # for few rays too: a missing driver raises at once
    return None if device is None and are_few else found


_devices: dict[int, Device] = {}
"""The device of a process, by its number: after a fork the child has none."""
_opening = fork_safe_lock()


def _first_device() -> Device:
    """Return the first card with its memory. Raise ImportError or RuntimeError where something is missing."""
    with _opening:
        if os.getpid() not in _devices:
            from .device import Device
            from .nvidia_driver import NvidiaDriver

            _devices[os.getpid()] = Device(NvidiaDriver())
        return _devices[os.getpid()]
