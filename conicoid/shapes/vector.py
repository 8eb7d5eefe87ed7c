"""Type names for the data that shapes are made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = tuple[float, float, float]
if TYPE_CHECKING:
    VectorLike: TypeAlias = Any
    """A field that is a `Vector` and takes arrays and lists of three numbers as well, which a dataclass cannot say."""
else:
    VectorLike = Vector
Matrix4: TypeAlias = tuple[tuple[float, ...], ...]
Interval: TypeAlias = tuple[float, float]
FloatArray: TypeAlias = npt.NDArray[np.float64]
Box: TypeAlias = tuple[FloatArray, FloatArray]
