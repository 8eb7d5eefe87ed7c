"""Pictures as texels: each with its halves, quarters and so on (Williams, Pyramidal parametrics, 1983)."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..compiler.jit import inline

Texels: TypeAlias = npt.NDArray[np.float32]
REPEAT, CLAMP, MIRROR = range(3)


def halved(picture: Any) -> Any:
    """The picture at half its size, rounded up: each of its pixels the mean of what it covers."""
    for axis in range(2):
        count = picture.shape[axis]
        if count == 1:
            continue
        half = (count + 1) // 2
        edges = np.arange(half + 1) * (count / half)
        shape = [1, 1, 1]
        shape[axis] = half + 1
        sums = np.cumsum(picture, axis=axis, dtype=np.float64)
        sums = np.concatenate([np.zeros_like(sums.take([0], axis)), sums], axis=axis)
        low = np.minimum(edges.astype(int), count - 1)
        share = (edges - low).reshape(shape)
        at = sums.take(low, axis) * (1 - share) + sums.take(low + 1, axis) * share
        picture = np.diff(at, axis=axis) / (count / half)
    return picture


def pyramid(picture: Any) -> tuple[Any, int]:
    """((texels, 3) float32 of all levels one after the other, how many levels there are)."""
    levels = [picture]
    while max(levels[-1].shape[:2]) > 1:
        levels.append(halved(levels[-1]))
    return np.concatenate([np.asarray(level, np.float32).reshape(-1, 3) for level in levels]), len(levels)


@inline
def wrapped(i: int, count: int, wrap: int) -> int:
    """Which of `count` texels in a row stands for texel i."""
    if wrap == REPEAT:
        return i % count
    if wrap == CLAMP:
        return max(0, min(count - 1, i))
    i %= 2 * count
    return i if i < count else 2 * count - 1 - i


@inline
def texel(
    texels: Texels, first: int, width: int, height: int, wraps: tuple[int, int], u: float, v: float
) -> tuple[float, float, float]:
    """Between the four texels about (u, v), of a picture from (0, 0), its lower left corner, to (1, 1)."""
    x, y = u * width - 0.5, (1.0 - v) * height - 0.5
    left, top = np.floor(x), np.floor(y)
    a, b = x - left, y - top
    i0, i1 = wrapped(int(left), width, wraps[0]), wrapped(int(left) + 1, width, wraps[0])
    j0, j1 = wrapped(int(top), height, wraps[1]), wrapped(int(top) + 1, height, wraps[1])
    p, q, r, s = first + j0 * width + i0, first + j0 * width + i1, first + j1 * width + i0, first + j1 * width + i1
    w0, w1, w2, w3 = (1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b
    return (
        w0 * texels[p, 0] + w1 * texels[q, 0] + w2 * texels[r, 0] + w3 * texels[s, 0],
        w0 * texels[p, 1] + w1 * texels[q, 1] + w2 * texels[r, 1] + w3 * texels[s, 1],
        w0 * texels[p, 2] + w1 * texels[q, 2] + w2 * texels[r, 2] + w3 * texels[s, 2],
    )


@inline
def texel_of_size(
    texels: Texels, first: int, size: tuple[int, int, int], wraps: tuple[int, int], u: float, v: float, reach: float
) -> tuple[float, float, float]:
    """The colour about (u, v) of a picture of which `reach` texels are to be one; size is (width, height, levels)."""
    width, height, levels = size
    if not (abs(u) < 1e9 and abs(v) < 1e9):
        return 0.0, 0.0, 0.0
    finer, finer_width, finer_height, level = first, width, height, 0
    while reach > 1.0 and level < levels - 1:
        finer, finer_width, finer_height = first, width, height
        first, width, height = first + width * height, (width + 1) // 2, (height + 1) // 2
        reach, level = 0.5 * reach, level + 1
    r, g, b = texel(texels, first, width, height, wraps, u, v)
    if level == 0 or reach >= 1.0:
        return r, g, b
    share = 2.0 * reach - 1.0
    fr, fg, fb = texel(texels, finer, finer_width, finer_height, wraps, u, v)
    return fr + share * (r - fr), fg + share * (g - fg), fb + share * (b - fb)
