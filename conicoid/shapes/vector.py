"""Type names for the data that shapes are made of."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = tuple[float, float, float]
Matrix4: TypeAlias = tuple[tuple[float, ...], ...]
Interval: TypeAlias = tuple[float, float]
FloatArray: TypeAlias = npt.NDArray[np.float64]
Box: TypeAlias = tuple[FloatArray, FloatArray]
