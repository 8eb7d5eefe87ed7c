"""Bounds of quadric solids: of a whole quadric by its dual, and of a quadric between planes by candidate points.

In coordinates along the principal axes f = Σ λ_i y_i² + 2 β·y + γ. If any λ is negative, the solid f <= 0 spans all of
space. Otherwise completing the squares leaves an ellipsoid or elliptic cylinder (Σ λ_i y_i² <= -γ), or a paraboloid,
which has linear terms along directions with λ = 0.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray, cross_rows, dot_rows, matmul_rows, row_lengths, unit_rows
from ..._util.records import dataclass
from ...numerics import bigfloat as ex
from ..surface import UPRIGHT, PlaneSurface, QuadricSurface
from .support import round_up


def quadric_ends(surface: QuadricSurface) -> list[float]:
    """Return (low x, y, z, high x, y, z) of the solid inside a quadric surface, rounded outward."""
    w = ex.exact_row(surface.rows[0]), ex.exact_row(surface.rows[1]), ex.exact_row(surface.rows[2])
    anchor = ex.exact_row(surface.anchor)
    columns = ex.inverse(w)
    low, high = [], []
    for i in range(3):
        # x_i = anchor_i + row i of W⁻¹ · y
        up, down = columns[i], (-columns[i][0], -columns[i][1], -columns[i][2])
        high.append(_shift_support(dual_support(surface, up), anchor[i]))
        low.append(0.0 - _shift_support(dual_support(surface, down), -anchor[i]))
    return [*low, *high]


def _shift_support(support: ex.BigFloat | float, shift: ex.BigFloat) -> float:
    if isinstance(support, float):
        return support
    return round_up(ex.cancelling_sum((support, shift)))


def dual_support(surface: QuadricSurface, direction: ex.Row) -> ex.BigFloat | float:
    """Return sup e·y over f <= 0 in the surface's own coordinates y, e = `direction`.

    The result is an exact number, or the float inf (unbounded) or -inf (empty).
    """
    squares, slopes = ex.exact_row(surface.squares), ex.exact_row(surface.linear)
    gamma = -ex.exact(surface.constant)
    if any(s < 0 for s in squares):
        return math.inf
    curved = [i for i in range(3) if squares[i]]
    flat = [i for i in range(3) if not squares[i]]
    # Complete the squares: y_i = z_i - β_i / λ_i
    gamma = ex.cancelling_sum([gamma, *(-slopes[i] * slopes[i] / squares[i] for i in curved)])
    center = [-direction[i] * slopes[i] / squares[i] for i in curved]
    spread = ex.cancelling_sum([ex.ZERO, *(direction[i] * direction[i] / squares[i] for i in curved)])
    if any(slopes[i] for i in flat):
        k = _multiple([direction[i] for i in flat], [slopes[i] for i in flat])
        if k is None or k < 0 or (spread and not k):
            return math.inf
        reach = (spread / k - k * gamma) / 2 if k else ex.ZERO
        return ex.cancelling_sum([reach, *center])
    if gamma > 0:
        return -math.inf
    if any(direction[i] for i in flat):
        return math.inf
    return ex.cancelling_sum([ex.sqrt(-gamma * spread), *center])


def _multiple(vector: list[ex.BigFloat], base: list[ex.BigFloat]) -> ex.BigFloat | None:
    """Return k with vector = k base, None if there is none."""
    lead = max(range(len(base)), key=lambda i: abs(base[i]))
    k = vector[lead] / base[lead]
    others = (j for j in range(len(base)) if j != lead)
    return None if any(ex.cancelling_sum((vector[j], -k * base[j])) for j in others) else k


# Whether a quadric solid between planes is bounded: the directions in which it may go to infinity
#
# A sequence of its points that leaves every ball does so along a v != 0 with n_i·v <= 0 and vᵀA v <= 0. Where A has no
# negative eigenvalue the solid is convex and v satisfies more: A v = 0 and l·v <= 0. The same holds where planes
# across them bound the axes of all negative eigenvalues, since the terms along those are then bounded.

_RECESSION_MARGIN = 2.0**-16
"""A cone of directions that is empty by less than this margin counts as not empty."""
_RECESSION_PARALLEL = 2.0**-49
"""Normals whose sine is below this count as parallel: they have no common edge."""
_RECESSION_SLACK = 2.0**-44
"""The margin of an edge grows by this over the sine of its two normals, as its rounding error does."""


def is_bounded(normals: FloatArray, squares: FloatArray, linear: FloatArray) -> bool:
    """Return True if Σ squares u² + 2 linear·u <= constant, normals·u <= offsets is certainly bounded.

    Parameters
    ----------
    normals : array (n, 3)
        Of unit length.
    squares : array (3,)
        Each 1, 0 or -1.
    linear : array (3,)
        The linear coefficients.
    """
    falling = [k for k in range(3) if squares[k] < 0]
    if falling and _only_zero(normals, squares):
        return True
    if not all(_planes_bound_axis(normals, k) for k in falling):
        return False
    rows = [normals]
    for k in range(3):
        if squares[k] > 0:
            rows.append(np.eye(3)[[k, k]] * ((1.0,), (-1.0,)))
    slope = np.where(squares == 0, linear, 0.0)
    if slope.any():
        rows.append(unit_rows(slope[None, :])[0])
    return _only_zero(np.concatenate(rows), np.zeros(3))


def _planes_bound_axis(normals: FloatArray, axis: int) -> bool:
    """Return True if two of the planes, exactly across a coordinate axis, bound it on both sides."""
    across = normals[(normals != 0).sum(axis=1) == 1][:, axis]
    return bool((across > 0).any() and (across < 0).any())


def _only_zero(normals: FloatArray, squares: FloatArray) -> bool:
    """Return True if no v != 0 has normals·v <= 0 and Σ squares v² <= 0, by a margin.

    The minimum of Σ squares v² over unit v lies on an axis, is stationary across one normal, or lies across two.
    """
    count = len(normals)
    in_planes = _stationary_directions(normals, squares)
    first, second = np.triu_indices(count, 1)
    edges = cross_rows(normals[first], normals[second])
    sine = row_lengths(edges)
    real = sine > _RECESSION_PARALLEL
    edges = edges[real] / sine[real, None]
    candidates = np.concatenate([np.eye(3), in_planes, edges])
    slack = np.concatenate(
        [np.full(3 + 2 * count, _RECESSION_MARGIN), _RECESSION_MARGIN + _RECESSION_SLACK / sine[real]]
    )
    flat = dot_rows(candidates * candidates, squares) <= 2 * slack
    rates = matmul_rows(candidates, normals.T)
    free = (rates <= slack[:, None]).all(axis=1) | (rates >= -slack[:, None]).all(axis=1)
    return not (flat & free).any()


def _stationary_directions(normals: FloatArray, squares: FloatArray) -> FloatArray:
    """Return for each normal the two unit vectors v across it at which Σ squares v² is stationary, (2 n, 3).

    In a basis of the plane across it the form is (p, q; q, r), and v a multiple of (q, -d ± sqrt(d² + q²)),
    d = (p - r) / 2.
    """
    a = unit_rows(cross_rows(normals, np.eye(3)[np.abs(normals).argmin(axis=1)]))[0]
    b = cross_rows(normals, a)
    d = (dot_rows(a * a, squares) - dot_rows(b * b, squares)) / 2
    q = dot_rows(a * b, squares)
    more = np.abs(d) + np.sqrt(d * d + q * q)
    x, y = np.where(d < 0, q, more), np.where(d < 0, more, q)  # the form without cancellation
    x = np.where(more > 0, x, 1.0)
    first = unit_rows(x[:, None] * a + y[:, None] * b)[0]
    return np.concatenate([first, cross_rows(normals, first)])


# The extent of a quadric solid between planes, along the axes of the world
#
# A linear function over {f <= 0} ∩ {n_i·x <= d_i} is largest, if at all, in a common point of three planes, where a
# line common to two planes meets f = 0, or at a stationary point of f = 0 or of its section by a plane. A stationary
# point for direction e has ∇f·a = 0 for all a across e (and n_i, in a section); ∇f·a = 0 is a plane. So all but the
# first are points where a line common to two planes meets f = 0. The points that no other plane cuts off count.
#
# All of this is done in floats, in coordinates in which f = Σ ±u_k² + 2 l·u - c (by congruence), about the anchor of
# the surface. Every point carries a bound of its own rounding error, by which tests are relaxed and values raised. A
# direction in which the solid cannot be shown to end stays infinite.
#
# Along axes without a square the unit is free: u = y / stretch holds for any stretch > 0, so the choice decides only
# how well floats resolve the solid, not the result. A good unit is the height at which planes cut the axis through the
# anchor. But a height may be a residue of rounding: the side of a box that touches a vertex lies 1e-17, or the least
# float, beside it. So cuts below 2^-40 of the largest, more than `_CUT_SLACK` leaves, set no unit, nor do those across
# the closed side of a bowl. With the unit H, the extents of a solid of height h have a relative error of
# 2^-46 sqrt(H / h): bounds of a solid that is really so low hold and are a little loose.

_CUT_SLACK = 2.0**-46
"""More than the relative rounding error of any chain of operations here."""
_PARALLEL_SINE = 2.0**-49
"""Sines and determinants of unit normals below this are rounding."""
_DISTINCT_SINE, _COINCIDENT_SHARE = 2.0**-36, 2.0**-40
"""Directions apart by more than the first in the world and by no more than the second in u cannot be distinguished."""
_FAR = 2.0**18
"""A limit for distances, in units of the linear term, constant and offsets. No point beyond it belongs to a solid that
ends by `_RECESSION_MARGIN`: its line is so nearly along a ruling or an asymptote that rounding decides where it is."""


_WIDEST = 500
"""Sizes beyond 2^±500 have no squares in float64."""
_RESIDUE = 2.0**-40
"""Cuts of this share of the largest may be residues of rounding."""


@dataclass(frozen=True)
class _CanonicalCut:
    """f = Σ squares u² + 2 linear·u - constant <= 0 with squares 1, 0, -1, and normals·u <= offsets, unit normals.

    World axis i is directions[i]·u, times the scale of `_canonical`, from the anchor.
    """

    squares: FloatArray
    linear: FloatArray
    constant: float
    normals: FloatArray
    offsets: FloatArray
    directions: FloatArray


def cut_quadric_bounds(surface: QuadricSurface, planes: Sequence[PlaneSurface]) -> BoxEnds:
    """Return (low, high) of the part of a quadric solid with every normal·x <= offset, rounded outward.

    low > high if that part is empty. An end that is not certain is infinite.

    Parameters
    ----------
    surface : QuadricSurface
        The solid is its inside.
    planes : sequence of PlaneSurface
        The half-spaces.
    """
    anchor = ex.exact_row(surface.anchor)
    with np.errstate(all="ignore"):
        cut, scale = _canonical(surface, anchor, planes)
        if cut is None:
            return np.full(3, -np.inf), np.full(3, np.inf)
        reaches = _reaches(cut)
    if min(reaches) == -math.inf:
        return np.full(3, np.inf), np.full(3, -np.inf)
    low, high = np.empty(3), np.empty(3)
    for i in range(3):
        high[i] = _unscale_reach(reaches[2 * i], scale, anchor[i])
        low[i] = -_unscale_reach(reaches[2 * i + 1], scale, -anchor[i])
    return low + 0.0, high


def _unscale_reach(reach: float, scale: float, shift: ex.BigFloat) -> float:
    return reach if math.isinf(reach) else round_up(ex.exact(reach) * ex.exact(scale) + shift)


def _canonical(
    surface: QuadricSurface, anchor: ex.Row, planes: Sequence[PlaneSurface]
) -> tuple[_CanonicalCut | None, float]:
    """Return (the problem in coordinates u, scale), y = scale · stretch · u; None if float64 cannot hold it."""
    columns, rows = ex.IDENTITY, ex.IDENTITY
    if surface.rows is not UPRIGHT:
        w = surface.rows
        columns = ex.inverse((ex.exact_row(w[0]), ex.exact_row(w[1]), ex.exact_row(w[2])))
        rows = ex.transpose(columns)
    squares = np.array([float(s) for s in surface.squares])
    linear = np.array([float(b) for b in surface.linear])
    normals, offsets = np.empty((len(planes), 3)), np.empty(len(planes))
    for k, plane in enumerate(planes):
        normal = ex.exact_row(plane.normal)
        normals[k] = [float(c) for c in (normal if rows is ex.IDENTITY else ex.apply(rows, normal))]
        offsets[k] = float(ex.cancelling_sum((ex.exact(plane.offset), -ex.dot(normal, anchor))))
    curved = squares != 0
    flat_stretch = _flat_stretch(squares, linear, float(surface.constant), normals, offsets)
    stretch = np.where(curved, 1 / np.sqrt(np.abs(squares)), flat_stretch)
    directions = np.array([[float(c) for c in row] for row in columns]) * stretch
    normals, size_of_normals = unit_rows(normals * stretch)
    offsets /= size_of_normals
    linear, constant = linear * stretch, float(surface.constant)
    size = max(math.sqrt(abs(constant)), float(np.abs(linear).max()), float(np.abs(offsets).max(initial=0.0)))
    exponent = math.frexp(size)[1] if math.isfinite(size) else _WIDEST
    if abs(exponent) >= _WIDEST:
        return None, 1.0
    scale = math.ldexp(1.0, exponent)
    cut = _CanonicalCut(np.sign(squares), linear / scale, constant / scale**2, normals, offsets / scale, directions)
    numbers = (normals, offsets, linear, directions, np.array([constant / scale**2]))
    held = all(np.isfinite(values).all() for values in numbers)
    return (cut if held and not _is_blurred(cut, planes) else None), scale


def _is_blurred(cut: _CanonicalCut, planes: Sequence[PlaneSurface]) -> bool:
    """Return True if planes or axes that differ in the world are parallel in u up to rounding, as across a needle.

    Their common lines and corners would be missing.
    """
    given = np.array([[float(c) for c in plane.normal] for plane in planes]).reshape(-1, 3)
    there, here = (unit_rows(np.concatenate(rows))[0] for rows in ((given, np.eye(3)), (cut.normals, cut.directions)))
    first, second = np.triu_indices(len(there), 1)
    sines = [row_lengths(cross_rows(rows[first], rows[second])) for rows in (there, here)]
    triples = np.array(list(itertools.combinations(range(len(there)), 3)))
    volumes = [np.abs(_volumes(*rows[triples].transpose(1, 0, 2))) for rows in (there, here)]
    return any(bool(((world > _DISTINCT_SINE) & (own <= _COINCIDENT_SHARE)).any()) for world, own in (sines, volumes))


def _volumes(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the determinants of rows a, b, c, each (n, 3)."""
    return dot_rows(a, cross_rows(b, c))


def _flat_stretch(
    squares: FloatArray, linear: FloatArray, constant: float, normals: FloatArray, offsets: FloatArray
) -> float:
    """Return the unit along axes without a square, in which a paraboloid is about as wide as high where it is cut."""
    flat = squares == 0
    slope = float(np.abs(linear[flat]).max(initial=0.0))
    if not slope:
        return 1 / math.sqrt(np.abs(squares).max())
    cuts = offsets[:, None] / normals
    # As high as a paraboloid is where planes cut it across
    across = (cuts**2 * np.abs(squares) / (2 * slope))[:, ~flat]
    width = float(across[np.isfinite(across)].max(initial=0.0))
    bowl = bool((squares >= 0).all())
    sides = [
        _finite(np.abs(cuts[sense * normals[:, k] > 0, k]))
        for k, sense in itertools.product(np.flatnonzero(flat), (1.0, -1.0))
        if not bowl or sense * linear[k] < 0
    ]
    least = _RESIDUE * max([width, *(float(side.max(initial=0.0)) for side in sides)])
    heights = [float(side[side > least].min()) for side in sides if (side > least).any()]
    height = max(heights) if heights else width or (abs(constant) or 1.0) / (2 * slope)
    return math.sqrt(height / (2 * slope))


def _finite(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def _reaches(cut: _CanonicalCut) -> list[float]:
    """Return max u·direction for +x, -x, +y, -y, +z, -z: inf if no end is certain, -inf if the solid is empty."""
    if is_bounded(cut.normals, cut.squares, cut.linear):
        points, errors = _points(cut)
        return [_largest(points, errors, sign * axis) for axis in cut.directions for sign in (1.0, -1.0)]
    reaches = []
    for axis in cut.directions:
        part = _slice_across(cut, axis)
        candidates = None
        for sign in (1.0, -1.0):
            inward = unit_rows(-sign * axis[None, :])[0]
            if not is_bounded(np.concatenate([part.normals, inward]), cut.squares, cut.linear):
                reaches.append(math.inf)
                continue
            candidates = candidates or _points(part)
            reaches.append(_largest(*candidates, sign * axis))
    return reaches


def _slice_across(cut: _CanonicalCut, direction: FloatArray) -> _CanonicalCut:
    """Return a slice of the solid that reaches as far along a direction as the whole.

    If f does not change along an axis across the direction, and no plane stops a point that moves along the axis, then
    neither the planes that it moves away from nor its place on the axis matter.
    """
    for k, sign in itertools.product(range(3), (1.0, -1.0)):
        is_free = cut.squares[k] == 0 and cut.linear[k] == 0 and direction[k] == 0
        rates = sign * cut.normals[:, k]
        if is_free and (rates <= 0).all():
            parallel, tie = rates == 0, np.eye(3)[[k, k]] * ((1.0,), (-1.0,))
            normals = np.concatenate([cut.normals[parallel], tie])
            return replace(cut, normals=normals, offsets=np.concatenate([cut.offsets[parallel], (0.0, 0.0)]))
    return cut


def _largest(points: FloatArray, errors: FloatArray, direction: FloatArray) -> float:
    return float((dot_rows(points, direction) + float(row_lengths(direction)) * errors).max(initial=-np.inf))


def _points(cut: _CanonicalCut) -> tuple[FloatArray, FloatArray]:
    """Return the points (n, 3) of the solid where a world coordinate may be largest, and their error bounds (n,)."""
    on_lines, line_errors = _line_points(cut, *_lines(cut))
    corners, corner_errors = _corners(cut)
    points, errors = np.concatenate([on_lines, corners]), np.concatenate([line_errors, corner_errors])
    size = row_lengths(points)
    slope = float(row_lengths(cut.linear))
    errors = errors + _CUT_SLACK * size
    # On the quadric (corners: inside) and not beyond any plane, as far as rounding can tell
    value = dot_rows(points * points, cut.squares) + 2 * dot_rows(points, cut.linear) - cut.constant
    terms = size * size + 2 * slope * size + abs(cut.constant)
    room = _CUT_SLACK * terms + (2 * (size + slope) + errors) * errors
    inside = (value <= room) & ((value >= -room) | (np.arange(len(value)) >= len(on_lines)))
    beyond = matmul_rows(points, cut.normals.T) - cut.offsets - _CUT_SLACK * np.abs(cut.offsets)
    inside &= (beyond <= errors[:, None]).all(axis=1) & ((size < _FAR) | (errors < size / 8))
    return points[inside], errors[inside]


def _lines(cut: _CanonicalCut) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return pairs of planes with a common line: normals (n, 2, 3), offsets (n, 2), precision of the normals (n,)."""
    count = len(cut.normals)
    first, second = np.triu_indices(count, 1)
    axes = unit_rows(cut.directions)[0]
    # Stationary in the section by each plane: across the axis and the normal
    across, sine = unit_rows(cross_rows(axes[:, None], cut.normals[None]).reshape(-1, 3))
    section, offset, weight = _gradient_planes(cut, across)
    # Stationary on the whole quadric: across the axis in two ways
    aside = unit_rows(cross_rows(axes, np.eye(3)[np.abs(axes).argmin(axis=1)]))[0]
    one, one_offset, one_weight = _gradient_planes(cut, aside)
    two, two_offset, two_weight = _gradient_planes(cut, cross_rows(axes, aside))
    ones = np.concatenate([cut.normals[first], np.tile(cut.normals, (3, 1)), one])
    twos = np.concatenate([cut.normals[second], section, two])
    near = np.concatenate([cut.offsets[first], np.tile(cut.offsets, 3), one_offset])
    far = np.concatenate([cut.offsets[second], offset, two_offset])
    exact = np.where(sine > _PARALLEL_SINE, weight, 0.0)
    weights = np.concatenate([np.ones(len(first)), exact, np.minimum(one_weight, two_weight)])
    return np.stack([ones, twos], axis=1), np.stack([near, far], axis=1), weights


def _gradient_planes(cut: _CanonicalCut, across: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the planes ∇f·a = 0 for unit vectors a (n, 3): unit normals, offsets, lengths of the normals before."""
    normals, size = unit_rows(cut.squares * across)
    return normals, -dot_rows(across, cut.linear) / size, size


def _line_points(
    cut: _CanonicalCut, normals: FloatArray, offsets: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the two points where the common line of each pair of planes meets f = 0, with error bounds."""
    one, two = normals[:, 0], normals[:, 1]
    along = cross_rows(one, two)
    sine = row_lengths(along)
    real = (sine > _PARALLEL_SINE) & (weights > _PARALLEL_SINE)
    one, two, along, sine = one[real], two[real], along[real], sine[real]
    near, far = offsets[real, 0, None], offsets[real, 1, None]
    foot = (near * cross_rows(two, along) + far * cross_rows(along, one)) / (sine * sine)[:, None]
    along = along / sine[:, None]
    # f = a t² + 2 b t + c on foot + t along, each with a bound of its error
    share = _CUT_SLACK / (sine * weights[real])
    size, slope = row_lengths(foot), float(row_lengths(cut.linear))
    reach = np.abs(near[:, 0]) + np.abs(far[:, 0]) + size
    a = dot_rows(along * along, cut.squares)
    b = dot_rows(along, cut.squares * foot + cut.linear)
    c = dot_rows(foot * foot, cut.squares) + 2 * dot_rows(foot, cut.linear) - cut.constant
    a_error, b_error = 2 * share, share * (reach + size + slope)
    c_error = share * (2 * (size + slope) * reach + abs(cut.constant))
    noise = 2 * np.abs(b) * b_error + np.abs(a) * c_error + np.abs(c) * a_error + b_error**2 + a_error * c_error
    # A line that touches within its error counts as one that cuts
    root = np.sqrt(b * b - a * c + noise)
    q = -(b + np.copysign(root, b))
    # If f vanishes along the whole line, its ends are corners
    meets = (root >= 0) & ((np.abs(a) > a_error) | (np.abs(b) > b_error) | (np.abs(c) > c_error))
    points, errors = [], []
    for t in (q / a, c / q):
        loss = a_error * t * t + 2 * b_error * np.abs(t) + c_error
        shift = np.where(loss > 0, loss / (2 * root), 0.0)
        known = meets & np.isfinite(t) & np.isfinite(shift)
        points.append((foot + t[:, None] * along)[known])
        errors.append((share * (reach + np.abs(t)) + shift)[known])
    return np.concatenate(points), np.concatenate(errors)


def _corners(cut: _CanonicalCut) -> tuple[FloatArray, FloatArray]:
    """Return the common points of three planes, with error bounds."""
    triples = np.array(list(itertools.combinations(range(len(cut.normals)), 3)), dtype=np.int64).reshape(-1, 3)
    (n, m, k), (d, e, f) = cut.normals[triples].transpose(1, 0, 2), cut.offsets[triples].T
    first, second, third = cross_rows(m, k), cross_rows(k, n), cross_rows(n, m)
    determinant = dot_rows(n, first)
    real = np.abs(determinant) > _PARALLEL_SINE
    determinant = determinant[real]
    points = (d[:, None] * first + e[:, None] * second + f[:, None] * third)[real] / determinant[:, None]
    size = row_lengths(points)
    return points, _CUT_SLACK * ((np.abs(d) + np.abs(e) + np.abs(f))[real] + size) / np.abs(determinant)
