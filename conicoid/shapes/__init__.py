"""What a user can say: frozen dataclasses, data only.

Every file here that defines a shape registers it by defining it; scene files and the contract
tests find it in `REGISTRY`, for which all files are imported: whoever makes a ball needs only its own.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .base import REGISTERED, Shape, Sheet, Solid

if TYPE_CHECKING:
    REGISTRY: dict[str, type[Shape]]
    """Scene-file name -> class, for every shape a user can write."""

__all__ = ["REGISTRY", "Shape", "Sheet", "Solid"]


def __getattr__(name: str) -> Any:
    if name != "REGISTRY":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import pkgutil

    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    globals()["REGISTRY"] = REGISTERED
    return REGISTERED
