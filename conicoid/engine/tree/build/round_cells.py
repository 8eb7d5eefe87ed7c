"""Balls around cells, where they are tighter than those around the cells' boxes.

A cell that lies inside of  sum s_i y_i² + 2 b_i y_i - k = 0,  y = W (x - anchor),  and between planes across its axis
j has |x - c|² at most as large as the largest (y_j - m)² / |W_j|² + (k' - s_j y_j² - 2 b_j y_j) / steep, between the
planes: c is on the axis, halfway; k' = k + b_i² / s_i of the other two axes, and steep the lesser of their s_i |W_i|².
That is a parabola in y_j, largest at an end or at its vertex.
"""

from __future__ import annotations

import math

from ....compiler.jit import helper, inline
from ... import tables as table
from ...culling.slack import BESIDE, PARALLEL, ROUND_AWAY, ROUND_RAISED, ROUND_ROUNDED
from ...faces import cell_side, plane_side
from ...numbers.vectors import dot
from ...surface.quadric import Quadric, Sphere
from ...surface.records import load_plane, load_quadric, load_sphere
from ...tables import SPHERE, Geometry, integer

_LEAST, _MOST = 1e-250, 1e250  # beyond, products might overflow


@inline
def _none() -> Sphere:
    """No ball: one of infinite radius."""
    return Sphere(0.0, 0.0, 0.0, math.inf)


@inline
def _of_rows(quadric: Quadric, i: int, j: int) -> float:
    """W_i · W_j."""
    i, j = 3 + 3 * i, 3 + 3 * j
    return dot(quadric[i], quadric[i + 1], quadric[i + 2], quadric[j], quadric[j + 1], quadric[j + 2])


@inline
def _between(geometry: Geometry, cell: int, quadric: Quadric, j: int, away: float) -> tuple[float, float]:
    """What y_j lies between, by the planes across axis j; points of the cell are at most `away` from the anchor."""
    low, high, square = -math.inf, math.inf, _of_rows(quadric, j, j)
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        row = integer(geometry, table.SURFACE_ROW, integer(geometry, table.PLANE_SURFACE, slot))
        nx, ny, nz, over, ax, ay, az = load_plane(geometry, row)
        across = True
        for i in range(3):
            along = dot(nx, ny, nz, quadric[3 + 3 * i], quadric[4 + 3 * i], quadric[5 + 3 * i])
            across &= i == j or abs(along) <= PARALLEL * math.sqrt(_of_rows(quadric, i, i))
        if not across:
            continue
        along = dot(nx, ny, nz, quadric[3 + 3 * j], quadric[4 + 3 * j], quadric[5 + 3 * j])
        height = dot(nx, ny, nz, quadric.ax - ax, quadric.ay - ay, quadric.az - az) + over
        y, slack = -height * square / along, ROUND_AWAY * away * math.sqrt(square)
        if (along > 0.0) == (plane_side(geometry, slot) > 0):
            high = min(high, y + slack)
        else:
            low = max(low, y - slack)
    return low, high


@inline
def _along_axis(geometry: Geometry, cell: int, quadric: Quadric, j: int, away: float) -> Sphere:
    """A ball about a point on axis j; of infinite radius, if there is none."""
    a, b = (j + 1) % 3, (j + 2) % 3
    sa, sb, sj, bj, square = quadric[12 + a], quadric[12 + b], quadric[12 + j], quadric[15 + j], _of_rows(quadric, j, j)
    if not (sa > 0.0 and sb > 0.0):
        return _none()
    steep = min(sa * _of_rows(quadric, a, a), sb * _of_rows(quadric, b, b))
    if not (_LEAST < steep < _MOST and _LEAST < square < _MOST):
        return _none()
    ya, yb = -quadric[15 + a] / sa, -quadric[15 + b] / sb
    level, least = quadric.k + (ya * ya * sa + yb * yb * sb), abs(quadric.k) + (ya * ya * sa + yb * yb * sb)
    low, high = _between(geometry, cell, quadric, j, away)
    if sj > 0.0:
        half = math.sqrt(max(0.0, level + bj * bj / sj + ROUND_ROUNDED * (least + bj * bj / sj)) / sj)
        low, high = max(low, -bj / sj - half), min(high, -bj / sj + half)
    elif sj == 0.0 and bj != 0.0:
        end = (level + ROUND_ROUNDED * least) / (2.0 * bj)  # of a paraboloid: its vertex
        low, high = (low, min(high, end)) if bj > 0.0 else (max(low, end), high)
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        return _none()
    middle, largest = 0.5 * (low + high), 0.0
    bend = 1.0 / square - sj / steep
    vertex = (middle / square + bj / steep) / bend if bend < 0.0 else low
    for y in (low, high, min(max(vertex, low), high)):
        across = level - sj * y * y - 2.0 * bj * y + ROUND_ROUNDED * (least + abs(sj) * y * y + 2.0 * abs(bj * y))
        if not abs(across) < _MOST:
            return _none()
        largest = max(largest, (y - middle) * (y - middle) / square + max(across, 0.0) / steep)
    center = (0.0, 0.0, 0.0)
    for i in range(3):
        y = (middle if i == j else (ya if i == a else yb)) / _of_rows(quadric, i, i)
        k = 3 + 3 * i
        center = (center[0] + y * quadric[k], center[1] + y * quadric[k + 1], center[2] + y * quadric[k + 2])
    x, y, z = center[0] + quadric.ax, center[1] + quadric.ay, center[2] + quadric.az
    raised = math.sqrt(largest) * (1.0 + ROUND_RAISED) + BESIDE * (abs(x) + abs(y) + abs(z) + away)
    return Sphere(x, y, z, raised)


@helper
def around_cell(geometry: Geometry, cell: int, x: float, y: float, z: float, reach: float) -> Sphere:
    """A ball around a cell whose points are at most `reach` from (x, y, z); of infinite radius, if none is known."""
    surface, best = integer(geometry, table.CELL_QUADRIC, cell), _none()
    if surface < 0 or cell_side(geometry, cell) < 0 or not math.isfinite(reach):
        return best
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return load_sphere(geometry, row)
    quadric = load_quadric(geometry, row)
    for i in range(3):
        for j in range(i):
            if abs(_of_rows(quadric, i, j)) > PARALLEL * math.sqrt(_of_rows(quadric, i, i) * _of_rows(quadric, j, j)):
                return best
    away = reach + abs(x - quadric.ax) + abs(y - quadric.ay) + abs(z - quadric.az)
    for j in range(3):
        ball = _along_axis(geometry, cell, quadric, j, away)
        best = ball if ball.radius < best.radius else best
    return best
