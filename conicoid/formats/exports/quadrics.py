"""Quadric surfaces as pieces: ellipsoids, cylinders, cones, and bowls of revolution, in their own frame."""

from __future__ import annotations

from fractions import Fraction

from ...shapes import exact as ex
from ...shapes.motion import Motion
from ...shapes.steps import Scale, Step, Transform, Translate
from ...shapes.surface import UPRIGHT, QuadricSurface
from ...shapes.vector import Matrix4
from .axes import _TURNS
from .exported import Unsayable
from .pieces import Bowl, Combined, Egg, Frustum, Leaf, Node, Steps, Turned
from .rooms import Room

_CYCLES = {2: (0, 1, 2), 0: (1, 2, 0), 1: (2, 0, 1)}
"""Axes in cyclic order, the one that is turned about last."""


def curved(surface: QuadricSurface, room: Room) -> Node:
    """The inside of a quadric, as far as a room goes. Raises Unsayable for what is no such piece."""
    steps, is_rounded = _back(surface)
    squares = [ex.exact(value) for value in surface.squares]
    linear = [ex.exact(value) for value in surface.linear]
    constant = ex.exact(surface.constant)
    for axis, order in _CYCLES.items():
        a, b, c = (squares[i] for i in order)
        p, q, s = (linear[i] for i in order)
        if not (a > 0 and b > 0) or p or q:
            continue
        turn: Steps = () if axis == 2 else (Transform(_TURNS[axis]),)
        found = _about_z((a, b, c), s, constant, room.within(Motion((*turn, *steps))))
        if found is None:
            continue
        if isinstance(found, Combined):
            return Combined(found.kind, found.parts, (*found.steps, *turn, *steps))
        return Leaf(found.piece, (*found.steps, *turn, *steps), found.is_rounded or is_rounded)
    raise Unsayable("a quadric of it is no ellipsoid, cylinder, cone, paraboloid or hyperboloid of one sheet")


def _back(surface: QuadricSurface) -> tuple[Steps, bool]:
    """The steps from own coordinates y = rows (x - anchor), and whether they are rounded."""
    anchor = [ex.exact(value) for value in surface.anchor]
    shift = [ex.rounded(value) for value in anchor]
    is_rounded = any(ex.cancelling_sum((a, -ex.exact(b))) for a, b in zip(anchor, shift, strict=True))
    steps: list[Step] = []
    if surface.rows is not UPRIGHT:
        rows = tuple(ex.exact_row(row) for row in surface.rows)
        back = ex.inverse((rows[0], rows[1], rows[2]))
        numbers = [[ex.rounded(value) for value in row] for row in back]
        for exact_row, row in zip(back, numbers, strict=True):
            is_rounded = is_rounded or any(
                ex.cancelling_sum((a, -ex.exact(b))) for a, b in zip(exact_row, row, strict=True)
            )
        (a, b, c), (d, e, f), (g, h, i) = numbers
        if not any((b, c, d, f, g, h)):
            steps.append(Scale((a, e, i)))
        else:
            matrix: Matrix4 = ((a, b, c, 0.0), (d, e, f, 0.0), (g, h, i, 0.0), (0.0, 0.0, 0.0, 1.0))
            steps.append(Transform(matrix))
    if any(shift):
        steps.append(Translate((shift[0], shift[1], shift[2])))
    return tuple(steps), is_rounded


def _about_z(squares: ex.Row, s: ex.Exact, constant: ex.Exact, room: Room) -> Node | None:
    """a x² + b y² + c z² + 2 s z <= k with a, b > 0; None where another axis may do better."""
    a, b, c = squares
    if c > 0:
        if s or not constant > 0:
            return None
        radii = [_root(constant / square) for square in squares]
        x, y, z = (radius for radius, _ in radii)
        return Leaf(Egg((x, y, z)), (), not all(is_exact for _, is_exact in radii))
    steps: Steps = ()
    is_rounded = False
    if ex.cancelling_sum((a, -b)):
        factor, is_exact = _root(a / b)
        steps, is_rounded = (Scale((1.0, factor, 1.0)),), not is_exact
    g0, g1, g2 = (ex.cancelling_sum((value / a,)) for value in (constant, -2 * s, -c))
    box = room.within(Motion(steps)).box
    low, high = box.low[2], box.high[2]
    square = ex.cancelling_sum((g1 * g1, -4 * g0 * g2))
    if not g1 and not g2:
        if not g0 > 0:
            return None
        radius, is_exact = _root(g0)
        return Leaf(Frustum(radius, radius, low, high), steps, is_rounded or not is_exact)
    if g2 and not square:
        return _double_cone(g1, g2, low, high, steps, is_rounded)
    if g2 and (square > 0 or g0 < 0):
        return None  # two sheets
    rounded = is_rounded or any(map(ex.is_rounded, (g0, g1, g2)))
    return Leaf(Bowl(ex.fraction(g0), ex.fraction(g1), ex.fraction(g2), low, high), steps, rounded)


def _double_cone(g1: ex.Exact, g2: ex.Exact, low: float, high: float, steps: Steps, is_rounded: bool) -> Node:
    """x² + y² <= g2 (z - apex)²: both nappes, as far as the room goes."""
    apex, slope = ex.cancelling_sum((-g1 / (2 * g2),)), _root(g2)
    at = ex.rounded(apex)
    is_rounded = is_rounded or not slope[1] or bool(ex.cancelling_sum((apex, -ex.exact(at))))
    nappes: list[Node] = []
    for z in (low, high):
        radius = Fraction(slope[0]) * abs(Fraction(z) - Fraction(at))
        if (z < at) == (z == low) and radius:
            wide = float(radius)
            profile = ((0.0, at), (wide, z), (0.0, z))
            nappes.append(Leaf(Turned(profile), (), is_rounded or Fraction(wide) != radius))
    if not nappes:
        raise Unsayable("a part of it is empty")
    whole = nappes[0] if len(nappes) == 1 else Combined("union", tuple(nappes))
    if isinstance(whole, Leaf):
        return Leaf(whole.piece, steps, whole.is_rounded)
    return Combined(whole.kind, whole.parts, steps)


def _root(value: ex.Exact) -> tuple[float, bool]:
    """The square root as a float, and whether it is that exactly."""
    found = ex.cancelling_sum((ex.sqrt(value),))
    near = ex.rounded(found)
    return near, not ex.cancelling_sum((found, -ex.exact(near)))
