"""Where a peer keeps a body along its own z axis."""

from __future__ import annotations

import numpy as np

from .bodies import Floats, Vector


def along_axis(start: Vector, end: Vector) -> tuple[Floats, float]:
    """A rotation and shift (4, 4) that takes z to an axis along a coordinate axis and 0 to `start`, and its length.

    Both are exact: the rotation has entries 0, 1 and -1.
    """
    step = np.subtract(end, start)
    k = int(np.argmax(np.abs(step)))
    frame = np.eye(4)
    frame[:3, :3] = np.roll(np.eye(3), k + 1, axis=0)  # a cyclic exchange, which takes z to axis k
    if step[k] < 0:
        frame[:3, [0, 2]] *= -1  # half a turn about y
    frame[:3, 3] = start
    return frame, float(abs(step[k]))
