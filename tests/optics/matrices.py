"""First-order optics by 2 × 2 matrices of (y, n u), for the tests alone, without code of the package."""

import math

import numpy as np


def first_order(rows):
    """Return efl, bfl, ffl, and the z of the foci and principal planes, from (radius, thickness, index or "mirror")."""
    total, before, side, vertices = np.eye(2), 1.0, 1, [0.0]
    for k, (radius, thickness, medium, *_) in enumerate(rows):
        if medium == "mirror":
            side, behind = -side, -before
        else:
            behind = side * medium
        total = np.array([[1, 0], [-(behind - before) / radius, 1]]) @ total
        before = behind
        if k < len(rows) - 1:
            total = np.array([[1, thickness / behind], [0, 1]]) @ total
            vertices.append(vertices[-1] + thickness)
    (a, _), (c, d) = total
    efl = -1 / c
    rear = vertices[-1] - before * a / c
    front = d / c
    return {
        "efl": efl, "bfl": abs(before) * -a / c, "ffl": front, "front_focus": front, "rear_focus": rear,
        "front_principal": front + efl, "rear_principal": rear - math.copysign(1, before) * efl,
    }  # fmt: skip
