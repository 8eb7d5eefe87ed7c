"""Materials by index of many bodies in one entry of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from .arrays import real_array
from .base import Shape
from .bulk import Bulk
from .makers import as_material
from .validate import shown, what

Index = npt.NDArray[np.int32]


def checked_materials(shape: Shape, material: Any, materials: Any, index: Any) -> tuple[tuple[Any, ...], Index]:
    """(materials, the place of each body's among them), or a ValueError or TypeError."""
    if not isinstance(shape, Bulk):
        raise TypeError(f"Body: materials are for many bodies in one entry, such as Spheres, got {what(shape)}")
    if material is not None:
        raise ValueError("Body: material must be left out where materials are given")
    if materials is None:
        raise ValueError("Body: material_index must be left out, or go with materials")
    if isinstance(materials, (str, bytes)) or not isinstance(materials, Iterable):
        raise TypeError(f"Body: materials must be a list of materials and colours, got {what(materials)}")
    found = tuple(
        None if each is None else as_material(f"Body: materials[{i}]", each) for i, each in enumerate(materials)
    )
    return found, _checked_index(index, len(found), len(shape))


def _checked_index(index: Any, materials: int, bodies: int) -> Index:
    if index is None:
        if materials != bodies:
            found = f"{materials:,} materials for {bodies:,} bodies"
            raise ValueError(f"Body: materials must be as many as bodies where there is no material_index, got {found}")
        index = np.arange(bodies)
    values = real_array("Body", "material_index", index)
    if not (values == np.floor(values)).all():
        raise ValueError(f"Body: material_index must be integers, got {shown(index)}")
    if values.shape != (bodies,):
        raise ValueError(f"Body: material_index must have shape ({bodies},) as there are bodies, got {values.shape}")
    bad = np.flatnonzero((values < 0) | (values >= materials))
    if len(bad):
        found = f"at least 0 and below {materials}, got {values[bad[0]]:g}"
        raise ValueError(f"Body: material_index[{bad[0]}] must be {found}")
    result = values.astype(np.int32)
    result.flags.writeable = False
    return result
