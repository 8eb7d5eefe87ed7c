"""What a user can say: frozen dataclasses, data only.

Every file here that defines a shape registers it by defining it; scene files and the contract
tests find it in `REGISTRY`.
"""

from __future__ import annotations

import importlib
import pkgutil

from .base import REGISTRY, Shape, Sheet, Solid

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")

__all__ = ["REGISTRY", "Shape", "Sheet", "Solid"]
