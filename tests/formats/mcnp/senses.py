"""MCNP's surfaces at points, by the formulas of its manual, in floats: whether a point is on the positive side."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Sense = Callable[[Points], Mask]


def above(f: Callable[[Any, Any, Any], Any]) -> Sense:
    """Return whether f > 0."""
    return lambda p: np.asarray(f(p[:, 0], p[:, 1], p[:, 2]) > 0)


def beyond_any(*facets: Sense) -> Sense:
    """Return whether points are outside of a macrobody, on the positive side of some facet."""
    return lambda p: np.any([facet(p) for facet in facets], axis=0)


def plane(normal: Any, through: Any) -> Sense:
    return lambda p: (p - np.array(through, float)) @ np.array(normal, float) > 0


def tube(base: Any, height: Any, radius: float) -> Sense:
    """Compare with the distance from a line, as the length of a cross product."""
    axis = np.array(height, float) / np.linalg.norm(height)
    return lambda p: np.linalg.norm(np.cross(p - np.array(base, float), axis), axis=1) > radius


def frustum(base: Any, height: Any, first: float, last: float) -> Sense:
    """Compare the distance from a line with the radius at that height, of either sign."""
    size = float(np.linalg.norm(height))
    axis = np.array(height, float) / size

    def sense(p: Points) -> Mask:
        q = p - np.array(base, float)
        far = np.linalg.norm(np.cross(q, axis), axis=1)
        return np.asarray(far > np.abs(first + (last - first) * (q @ axis) / size))

    return sense


def oval_tube(base: Any, major: Any, minor: Any) -> Sense:
    u, v = np.array(major, float), np.array(minor, float)

    def sense(p: Points) -> Mask:
        q = p - np.array(base, float)
        return np.asarray(((q @ u) / (u @ u)) ** 2 + ((q @ v) / (v @ v)) ** 2 > 1)

    return sense


def foci(first: Any, second: Any, half: float) -> Sense:
    """Compare with the sum of the distances from two points."""
    a, b = np.array(first, float), np.array(second, float)
    return lambda p: np.linalg.norm(p - a, axis=1) + np.linalg.norm(p - b, axis=1) > 2 * half


def _ell_foci(first: Any, second: Any, half: float) -> tuple[Any, Any]:
    """The foci of MCNP's ELL: as far from the points on the axis as the points are from its middle."""
    a, b = np.array(first, float), np.array(second, float)
    to_focus = (b - a) / np.linalg.norm(b - a) * (half - np.linalg.norm(b - a) / 2)
    return (a + b) / 2 - to_focus, (a + b) / 2 + to_focus


def one_sheet(axis: int, apex: Any, square: float, nappe: int) -> Sense:
    """Return the sense of a cone whose negative side is within one nappe only."""

    def sense(p: Points) -> Mask:
        q = p - np.array(apex, float)
        t = q[:, axis]
        far = np.sqrt(np.delete(q, axis, axis=1).__pow__(2).sum(axis=1))
        return ~np.asarray((nappe * t > 0) & (far < np.sqrt(square) * np.abs(t)))

    return sense


_hex = [np.array([np.cos(np.pi / 3 * k), np.sin(np.pi / 3 * k), 0]) * 1.5 for k in range(3)]
_wed = np.array([[-1, -1, -2], [3, 0, 0], [0, 2, 0], [0, 0, 3]], float)
_arb = np.array([[-2, -2, -1], [2, -2, -1], [2, 2, -1], [-2, 2, -1], [0, 0, 2.5]], float)


def _arb_side(i: int, j: int, k: int) -> Sense:
    a, b, c = (_arb[n - 1] for n in (i, j, k))
    normal = np.cross(b - a, c - a)
    return plane(normal if normal @ (a - _arb.mean(axis=0)) > 0 else -normal, a)


SIMPLE: list[tuple[str, Sense]] = [
    ("p 1 -2 0.5 0.7", above(lambda x, y, z: x - 2 * y + 0.5 * z - 0.7)),
    ("px -0.4", above(lambda x, y, z: x + 0.4)),
    ("py 1.25", above(lambda x, y, z: y - 1.25)),
    ("pz 2-1", above(lambda x, y, z: z - 0.2)),
    # Three points: the origin is on the negative side; else (0, 0, inf) is on the positive one, and so on
    ("p 1 0 0  0 2 0  0 0 3", above(lambda x, y, z: x + y / 2 + z / 3 - 1)),
    ("p -1 0 0  0 2 0  0 0 3", above(lambda x, y, z: -x + y / 2 + z / 3 - 1)),
    ("p 1 0 0  0 1 0  1 1 -2", above(lambda x, y, z: x + y + z / 2 - 1)),
    ("p 0 0 0  1 0 1  0 1 -1", above(lambda x, y, z: z - x + y)),
    ("p 0 0 0  0 1 -1  1 0 1", above(lambda x, y, z: z - x + y)),
    ("p 0 0 0  0 0 1  1 2 0", above(lambda x, y, z: y - 2 * x)),
    ("p 0 0 0  0 0 1  0 -2 0", above(lambda x, y, z: x)),
    ("so 1.5", above(lambda x, y, z: x**2 + y**2 + z**2 - 2.25)),
    ("s 1 -0.5 0.25 2", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 + (z - 0.25) ** 2 - 4)),
    ("sph 1 -0.5 0.25 2", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 + (z - 0.25) ** 2 - 4)),
    ("sx -1 1.5", above(lambda x, y, z: (x + 1) ** 2 + y**2 + z**2 - 2.25)),
    ("sy -1 1.5", above(lambda x, y, z: x**2 + (y + 1) ** 2 + z**2 - 2.25)),
    ("sz -1 1.5", above(lambda x, y, z: x**2 + y**2 + (z + 1) ** 2 - 2.25)),
    ("cx 1.1", above(lambda x, y, z: y**2 + z**2 - 1.21)),
    ("cy 1.1", above(lambda x, y, z: x**2 + z**2 - 1.21)),
    ("cz 1.1", above(lambda x, y, z: x**2 + y**2 - 1.21)),
    ("c/x 1 -0.5 1.1", above(lambda x, y, z: (y - 1) ** 2 + (z + 0.5) ** 2 - 1.21)),
    ("c/y 1 -0.5 1.1", above(lambda x, y, z: (x - 1) ** 2 + (z + 0.5) ** 2 - 1.21)),
    ("c/z 1 -0.5 1.1", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 - 1.21)),
    ("kx 0.5 0.3", above(lambda x, y, z: y**2 + z**2 - 0.3 * (x - 0.5) ** 2)),
    ("ky 0.5 0.3 1", one_sheet(1, (0, 0.5, 0), 0.3, 1)),
    ("kz 0.5 0.3 -1", one_sheet(2, (0, 0, 0.5), 0.3, -1)),
    ("k/x 1 0.5 -0.25 0.6", above(lambda x, y, z: (y - 0.5) ** 2 + (z + 0.25) ** 2 - 0.6 * (x - 1) ** 2)),
    ("k/y 1 0.5 -0.25 0.6 -1", one_sheet(1, (1, 0.5, -0.25), 0.6, -1)),
    ("k/z 1 0.5 -0.25 0.6 1", one_sheet(2, (1, 0.5, -0.25), 0.6, 1)),
    (
        "sq 1 2 -0.5 0.2 -0.3 0.4 -1 0.5 -0.25 0.75",
        above(
            lambda x, y, z: (x - 0.5) ** 2 + 2 * (y + 0.25) ** 2 - 0.5 * (z - 0.75) ** 2
            + 2 * 0.2 * (x - 0.5) - 2 * 0.3 * (y + 0.25) + 2 * 0.4 * (z - 0.75) - 1
        ),
    ),
    (
        "gq 1 2 0.5 0.3 -0.2 0.4 0.1 -0.6 0.7 -2",
        above(
            lambda x, y, z: x**2 + 2 * y**2 + 0.5 * z**2 + 0.3 * x * y - 0.2 * y * z + 0.4 * z * x
            + 0.1 * x - 0.6 * y + 0.7 * z - 2
        ),
    ),
    ("gq 0 0 0 0 0 0 1 2 -1 -0.5", above(lambda x, y, z: x + 2 * y - z - 0.5)),
    ("x 0.75 2", above(lambda x, y, z: x - 0.75)),
    ("y -1 1.5  2 1.5", above(lambda x, y, z: x**2 + z**2 - 2.25)),
    ("z -1 0.5  1 1.5", one_sheet(2, (0, 0, -2), 0.25, 1)),
    ("x -1 2  1 0", one_sheet(0, (1, 0, 0), 1, -1)),
    ("z -1 0  0 1  1 0", above(lambda x, y, z: x**2 + y**2 + z**2 - 1)),
    ("x 0 0  1 1  4 2", above(lambda x, y, z: y**2 + z**2 - x)),
    ("y -1 2  0 1  1 2", above(lambda x, y, z: x**2 + z**2 - 3 * y**2 - 1)),
    ("ell 1 0 0  -1 0.5 1  2", foci(*_ell_foci((1, 0, 0), (-1, 0.5, 1), 2), 2)),
    ("ell 0 0 -2  0 0 2  6", above(lambda x, y, z: (x**2 + y**2) / 20 + z**2 / 36 - 1)),  # 4.4721² = 20: the manual
    (
        "ell 0.5 0 -0.25  0 0 2  -1",
        above(lambda x, y, z: (x - 0.5) ** 2 + y**2 + ((z + 0.25) / 2) ** 2 - 1),
    ),
]  # fmt: skip
"""Cards without their numbers, and their positive sides."""

BODIES: list[tuple[str, list[Sense]]] = [
    (
        "rpp -1 2 -0.5 1 -2 0.25",
        [plane(n, q) for n, q in (
            ((1, 0, 0), (2, 0, 0)), ((-1, 0, 0), (-1, 0, 0)), ((0, 1, 0), (0, 1, 0)), ((0, -1, 0), (0, -0.5, 0)),
            ((0, 0, 1), (0, 0, 0.25)), ((0, 0, -1), (0, 0, -2)),
        )],
    ),
    (
        "box -1 -1 -1  1 2 0  -2 1 0  0 0 2.5",
        [plane(n, q) for n, q in (
            ((1, 2, 0), (0, 1, -1)), ((-1, -2, 0), (-1, -1, -1)), ((-2, 1, 0), (-3, 0, -1)), ((2, -1, 0), (-1, -1, -1)),
            ((0, 0, 1), (-1, -1, 1.5)), ((0, 0, -1), (-1, -1, -1)),
        )],
    ),
    (
        "box -1 -1 -1  1 2 0  -2 1 0",
        [plane(n, q) for n, q in (
            ((1, 2, 0), (0, 1, -1)), ((-1, -2, 0), (-1, -1, -1)), ((-2, 1, 0), (-3, 0, -1)), ((2, -1, 0), (-1, -1, -1)),
        )],
    ),
    ("rcc 0.5 0 -1  0 0 2.5  1.25", [tube((0.5, 0, 0), (0, 0, 1), 1.25), plane((0, 0, 1), (0, 0, 1.5)),
                                    plane((0, 0, -1), (0, 0, -1))]),
    ("rcc -1 0 -1  1 2 1.5  1.25", [tube((-1, 0, -1), (1, 2, 1.5), 1.25), plane((1, 2, 1.5), (0, 2, 0.5)),
                                   plane((-1, -2, -1.5), (-1, 0, -1))]),
    ("trc 0 -1 0  0 2 0  2 0.5", [frustum((0, -1, 0), (0, 2, 0), 2, 0.5), plane((0, 1, 0), (0, 1, 0)),
                                 plane((0, -1, 0), (0, -1, 0))]),
    ("trc -1 0 -1  1 2 1.5  0 1.5", [frustum((-1, 0, -1), (1, 2, 1.5), 0, 1.5), plane((1, 2, 1.5), (0, 2, 0.5)),
                                    plane((-1, -2, -1.5), (-1, 0, -1))]),
    ("rec 0 0 -1  0 0 2  2 1 0  -0.5 1 0", [oval_tube((0, 0, -1), (2, 1, 0), (-0.5, 1, 0)), plane((0, 0, 1), (0, 0, 1)),
                                          plane((0, 0, -1), (0, 0, -1))]),
    ("rec 0 -1 0  0 2 1  0 -1 2  0.75", [oval_tube((0, -1, 0), (0, -1, 2), (0.75, 0, 0)),
                                       plane((0, 2, 1), (0, 1, 1)), plane((0, -2, -1), (0, -1, 0))]),
    ("rhp 0.25 -0.25 -1  0 0 2.5  1.5 0 0", [
        *(plane(sign * v, sign * v + [0.25, -0.25, 0]) for v in _hex for sign in (1, -1)),
        plane((0, 0, 1), (0, 0, 1.5)), plane((0, 0, -1), (0, 0, -1)),
    ]),
    ("hex 0 0 -1  0 0 2  1.5 0 0  0.5 1.5 0  -0.7 1.25 0", [
        *(plane(sign * np.array(v), sign * np.array(v)) for v in ((1.5, 0, 0), (0.5, 1.5, 0), (-0.7, 1.25, 0))
          for sign in (1, -1)),
        plane((0, 0, 1), (0, 0, 1)), plane((0, 0, -1), (0, 0, -1)),
    ]),
    ("wed -1 -1 -2  3 0 0  0 2 0  0 0 3", [
        plane((2, 3, 0), _wed[0] + _wed[1]), plane((-1, 0, 0), _wed[0]), plane((0, -1, 0), _wed[0]),
        plane((0, 0, 1), _wed[0] + _wed[3]), plane((0, 0, -1), _wed[0]),
    ]),
    ("arb -2 -2 -1  2 -2 -1  2 2 -1  -2 2 -1  0 0 2.5  0 0 0  0 0 0  0 0 0  1234 1250 2350 3450 4150 0", [
        _arb_side(1, 2, 3), _arb_side(1, 2, 5), _arb_side(2, 3, 5), _arb_side(3, 4, 5), _arb_side(4, 1, 5),
    ]),
]  # fmt: skip
"""Macrobodies with the positive sides of their facets."""
