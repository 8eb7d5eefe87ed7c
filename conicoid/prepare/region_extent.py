"""The extent of regions between planes and quadrics, in floats: microseconds a body.

User: every scene with intersections; factor: 50 to 200 over `geometry.bounds`, whose 3000-bit numbers give the box to
the last bit. These boxes hold the body as surely, and are wider by at most some 10⁻⁹ of its size and
10⁻¹⁵ of its distance from the origin.

A box is narrowed in a frame of its own, u = (x - center) / scale along each axis, where it is [-1, 1]³. Planes become
n·u <= d with |n| = 1, quadrics f(u) = uᵀ Q u + 2 l·u - k <= 0 with max |Q| = 1. Both are relaxed by more than all
rounding so far, so that what follows may take their numbers as exact.

A coordinate over {f <= 0} between planes, the six sides of the box among them, is largest

- in a corner, common to three planes,
- where a line common to two planes meets f = 0,
- at a stationary point of f = 0 on a plane, or of f = 0 itself. With e the axis, ∇f·a = 0 for all a across e (and
  across the normal); ∇f·a = 0 is a plane again. So this is a line that meets f = 0, too.

These are the candidates; those that no plane cuts off count, by a bound of their own rounding error. The region is
compact, so that a coordinate is largest somewhere, and the gradients of the constraints that hold there with equality
and the axis are dependent: one of the cases above.
"""

from __future__ import annotations

import math

from .._jit.decorators import helper, inline, kernel
from ..kernels.tables import PLANE_SIZE, QUADRIC_SIZE, Floats, Signs

_ROUNDING = 2.0**-46
"""More than the relative rounding error of any chain of operations here."""
_LAST_DIGITS = 2.0**-50
"""More than the relative rounding error of a few operations."""
_RELAXED = 2.0**-42
"""Planes and quadrics are relaxed by this share of the terms that their numbers come from."""
_PARALLEL = 2.0**-44
"""Unit vectors whose sine is below this count as parallel, and gradients below this share of Q as constant."""
_TOLERANCE = 2.0**-40
"""A point beyond a plane by less still counts: so points on planes that count as parallel stand for one another."""
_MARGIN = 2.0**-36
"""The final box is wider by this, more than points that stand for one another are apart."""
_BLURRED = 2.0**-24
"""A box is not used if one of its ends is farther by twice this than what some point surely reaches."""
_WIDEST, _FAR = 4.0, 8.0
"""The ends of a box in u are at most the first, so that no point of it is as far from its center as the second."""
_SMALLER = 0.25, 1.0 - 2.0**-20
"""A box that shrinks below this share along an axis is narrowed again, in a frame of its new size: the second where
several quadrics cut it, since what one of them narrows may let another narrow it further."""
_ROUNDS = 4
_CLEAR = 2.0**-20
"""A body is empty if no point counts, nor would with all planes and the quadric so much farther out."""
_FLAT = 2.0**-30
"""The unit along an axis in which a box is flat, as a share of its width."""
MAX_PLANES = 64
"""Candidates grow with the third power of the number of planes."""
SIDES = 6


@inline
def norm(x: float, y: float, z: float) -> float:
    """Return the length of a vector."""
    return math.sqrt(x * x + y * y + z * z)


@inline
def _set_plane(work: Floats, row: int, x: float, y: float, z: float, offset: float) -> None:
    work[row, 0], work[row, 1], work[row, 2], work[row, 3] = x, y, z, offset


@helper
def _place_planes(planes: Floats, body: int, plane_count: int, frame: Floats, work: Floats) -> int:
    """Write the planes that cut the box to `work`, relaxed, and behind them the sides; return their number.

    The number is -1 if the box is outside of a plane.
    """
    count = 0
    for i in range(plane_count):
        at = PLANE_SIZE * i
        px, py, pz = planes[body, at] * frame[3], planes[body, at + 1] * frame[4], planes[body, at + 2] * frame[5]
        size = norm(px, py, pz)
        if not size > 0.0:
            continue
        nx, ny, nz, above = px / size, py / size, pz / size, planes[body, at + 3] / size
        x = planes[body, at] * (frame[0] - planes[body, at + 4]) / size
        y = planes[body, at + 1] * (frame[1] - planes[body, at + 5]) / size
        z = planes[body, at + 2] * (frame[2] - planes[body, at + 6]) / size
        offset = -(x + y + z + above)
        # Outward, so that the plane as it was meant lies within
        offset += _RELAXED * (abs(x) + abs(y) + abs(z) + abs(above) + 1.0)
        reach = abs(nx) * frame[6] + abs(ny) * frame[7] + abs(nz) * frame[8]
        # The whole box is on the inner side: the plane cuts nothing
        if reach <= offset:
            continue
        if -reach > offset:
            return -1
        _set_plane(work, count, nx, ny, nz, offset)
        count += 1
    _place_sides(work, count, frame)
    return count


@helper
def _place_sides(work: Floats, count: int, frame: Floats) -> None:
    """Write the sides of the box behind `count` planes; frame[6:9] and frame[9:12] are the ends up and down."""
    for k in range(3):
        for side in range(2):
            row = count + 2 * k + side
            _set_plane(work, row, 0.0, 0.0, 0.0, frame[6 + 3 * side + k])
            work[row, k] = 1.0 - 2.0 * side


@helper
def _place_quadric(quadrics: Floats, body: int, at: int, sense: float, frame: Floats, form: Floats) -> int:
    """Write (xx, yy, zz, xy, xz, yz, x, y, z, constant) of a quadric in u to `form`, relaxed.

    Return 1 if it may cut the box, 0 if it cuts nothing away, -1 if the box is outside of it.
    """
    for j in range(10):
        form[j] = 0.0
    constant = quadrics[body, at + 18]
    blur = abs(constant)
    rises = False
    for row in range(3):
        square, slope = sense * quadrics[body, at + 12 + row], sense * quadrics[body, at + 15 + row]
        rises = rises or square > 0.0
        w = at + 3 + 3 * row
        wx, wy, wz = quadrics[body, w], quadrics[body, w + 1], quadrics[body, w + 2]
        ax, ay, az = quadrics[body, at], quadrics[body, at + 1], quadrics[body, at + 2]
        # y of this row is shift + (x, y, z)·u; `most` bounds |y| and the terms of it, anchors and their rounding too
        shift = wx * (frame[0] - ax) + wy * (frame[1] - ay) + wz * (frame[2] - az)
        x, y, z = wx * frame[3], wy * frame[4], wz * frame[5]
        most = abs(wx * (frame[0] - ax)) + abs(wy * (frame[1] - ay)) + abs(wz * (frame[2] - az))
        most += 2.0 * (abs(x) + abs(y) + abs(z))
        anchor = (abs(wx * ax) + abs(wy * ay) + abs(wz * az)) * 2.0**-10  # its rounding, by 2⁻⁵³
        blur += (abs(square) * most + 2.0 * abs(slope)) * (most + 2.0 * anchor)
        form[0] += square * x * x
        form[1] += square * y * y
        form[2] += square * z * z
        form[3] += square * x * y
        form[4] += square * x * z
        form[5] += square * y * z
        rate = square * shift + slope
        form[6] += rate * x
        form[7] += rate * y
        form[8] += rate * z
        form[9] -= square * shift * shift + 2.0 * slope * shift
    form[9] += sense * constant + _RELAXED * blur
    if not rises:
        return 0
    largest = 0.0
    for j in range(6):
        largest = max(largest, abs(form[j]))
    if not (largest > 0.0 and largest < math.inf):
        return 0
    for j in range(10):
        # max |Q| = 1, on which all tolerances rely
        form[j] /= largest
    # The center of the box is the origin
    hx, hy, hz = max(frame[6], frame[9]), max(frame[7], frame[10]), max(frame[8], frame[11])
    mixed = 2.0 * (abs(form[3]) * hx * hy + abs(form[4]) * hx * hz + abs(form[5]) * hy * hz)
    linear = 2.0 * (abs(form[6]) * hx + abs(form[7]) * hy + abs(form[8]) * hz)
    squares = (form[0] * hx * hx, form[1] * hy * hy, form[2] * hz * hz)
    if max(squares[0], 0.0) + max(squares[1], 0.0) + max(squares[2], 0.0) + mixed + linear <= form[9]:
        return 0
    if min(squares[0], 0.0) + min(squares[1], 0.0) + min(squares[2], 0.0) - mixed - linear > form[9]:
        return -1
    return 1


@inline
def _value(form: Floats, x: float, y: float, z: float) -> float:
    """Return f."""
    square = form[0] * x * x + form[1] * y * y + form[2] * z * z
    mixed = form[3] * x * y + form[4] * x * z + form[5] * y * z
    return square + 2.0 * (mixed + form[6] * x + form[7] * y + form[8] * z) - form[9]


@inline
def _times_form(form: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return Q times a vector."""
    return (
        form[0] * x + form[3] * y + form[4] * z,
        form[3] * x + form[1] * y + form[5] * z,
        form[4] * x + form[5] * y + form[2] * z,
    )


@inline
def _slope(form: Floats) -> float:
    """Return |l|."""
    return norm(form[6], form[7], form[8])


@inline
def _reach_up(reach: Floats, side: int, end: float, error: float) -> None:
    """Let a point reach a side, at most and surely, with its error in that direction."""
    if end + error > reach[side]:
        reach[side] = end + error
    if end - error > reach[6 + side]:
        reach[6 + side] = end - error


@helper
def _consider(
    work: Floats,
    planes: int,
    reach: Floats,
    x: float,
    y: float,
    z: float,
    error: float,
    sx: float,
    sy: float,
    sz: float,
) -> None:
    """Let a point count if no plane cuts it off. It is right to within a ball of radius `error` and ± a vector s."""
    ex, ey, ez = error + abs(sx), error + abs(sy), error + abs(sz)
    if not (
        x + ex > reach[0]
        or y + ey > reach[1]
        or z + ez > reach[2]
        or ex - x > reach[3]
        or ey - y > reach[4]
        or ez - z > reach[5]
        or x - ex > reach[6]
        or y - ey > reach[7]
        or z - ez > reach[8]
        or -x - ex > reach[9]
        or -y - ey > reach[10]
        or -z - ez > reach[11]
    ):
        return
    for i in range(planes):
        nx, ny, nz, offset = work[i, 0], work[i, 1], work[i, 2], work[i, 3]
        room = error + abs(nx * sx + ny * sy + nz * sz) + _TOLERANCE * (1.0 + abs(offset))
        if nx * x + ny * y + nz * z - offset > room:
            return
    _reach_up(reach, 0, x, ex)
    _reach_up(reach, 1, y, ey)
    _reach_up(reach, 2, z, ez)
    _reach_up(reach, 3, -x, ex)
    _reach_up(reach, 4, -y, ey)
    _reach_up(reach, 5, -z, ez)


@helper
def _try_corners(work: Floats, planes: int, form: Floats, curved: bool, reach: Floats) -> None:
    """Try the points common to three planes."""
    slope = _slope(form)
    for i in range(planes):
        nx, ny, nz, nd = work[i, 0], work[i, 1], work[i, 2], work[i, 3]
        for j in range(i):
            mx, my, mz, md = work[j, 0], work[j, 1], work[j, 2], work[j, 3]
            cx, cy, cz = ny * mz - nz * my, nz * mx - nx * mz, nx * my - ny * mx
            # Parallel planes meet nowhere, or stand for one another
            if norm(cx, cy, cz) <= _PARALLEL:
                continue
            for h in range(j):
                px, py, pz, pd = work[h, 0], work[h, 1], work[h, 2], work[h, 3]
                determinant = px * cx + py * cy + pz * cz
                if abs(determinant) <= _PARALLEL:
                    continue
                # Cramer's rule: p (n × m) + n (m × p) + m (p × n), each with the offset of the third plane
                ax, ay, az = my * pz - mz * py, mz * px - mx * pz, mx * py - my * px
                bx, by, bz = py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx
                x = (pd * cx + nd * ax + md * bx) / determinant
                y = (pd * cy + nd * ay + md * by) / determinant
                z = (pd * cz + nd * az + md * bz) / determinant
                size = norm(x, y, z)
                # Beyond the box, which is at most `_FAR` wide: a side would cut it off
                if size > 2.0 * _FAR:
                    continue
                # The flatter the corner, the farther rounding moves it
                error = _ROUNDING * (abs(nd) + abs(md) + abs(pd) + size) / abs(determinant)
                if curved:
                    room = _TOLERANCE * (size * size + 2.0 * slope * size + abs(form[9]))
                    if _value(form, x, y, z) > room + (6.0 * size + 2.0 * slope + 3.0 * error) * error:
                        continue
                _consider(work, planes, reach, x, y, z, error, 0.0, 0.0, 0.0)


@helper
def _try_line(
    work: Floats, planes: int, form: Floats, reach: Floats,
    nx: float, ny: float, nz: float, nd: float, mx: float, my: float, mz: float, md: float, weight: float,
) -> None:  # fmt: skip
    """Try the points where the line common to two planes n·u = nd, m·u = md meets f = 0.

    `weight` is the least size of the vectors that the unit normals come from.
    """
    ax, ay, az = ny * mz - nz * my, nz * mx - nx * mz, nx * my - ny * mx
    sine = norm(ax, ay, az)
    if sine <= _PARALLEL or weight <= _PARALLEL:
        return
    square = sine * sine
    fx = (nd * (my * az - mz * ay) + md * (ay * nz - az * ny)) / square
    fy = (nd * (mz * ax - mx * az) + md * (az * nx - ax * nz)) / square
    fz = (nd * (mx * ay - my * ax) + md * (ax * ny - ay * nx)) / square
    ax, ay, az = ax / sine, ay / sine, az / sine
    size, share, slope = norm(fx, fy, fz), 4.0 * _ROUNDING / (sine * weight), _slope(form)
    far = abs(nd) + abs(md) + size
    if size > _FAR * (1.0 + share * far):
        return
    # f = a t² + 2 b t + c on foot + t along, each with a bound of its error
    qx, qy, qz = _times_form(form, ax, ay, az)
    a = qx * ax + qy * ay + qz * az
    b = qx * fx + qy * fy + qz * fz + form[6] * ax + form[7] * ay + form[8] * az
    c = _value(form, fx, fy, fz)
    a_error, b_error = 6.0 * share, share * (3.0 * (far + size) + slope)
    c_error = share * (2.0 * (3.0 * size + slope) * far + abs(form[9]))
    b_room = max(b_error, 2.0 * _FAR * a_error)
    # Where f is constant along the line, as far as rounding can tell, there is no crossing, or its ends are corners
    level = c_error + (4.0 * b_room + 2.0 * a_error * _FAR) * _FAR
    if abs(a) <= a_error and abs(b) <= b_room and (abs(c) > level or share < _BLURRED):
        return
    noise = 2.0 * abs(b) * b_error + abs(a) * c_error + abs(c) * a_error + b_error * b_error + a_error * c_error
    # A line that touches within its error counts as one that cuts
    inner = b * b - a * c + noise
    if not inner >= 0.0:
        return
    root = math.sqrt(inner)
    # As in `roots_of` of kernels/surface/quadric.py: without cancellation
    q = -(b + math.copysign(root, b))
    for which in range(2):
        over, under = (q, a) if which == 0 else (c, q)
        if under == 0.0:
            continue
        t = over / under
        # Far outside of the box, or NaN
        if not abs(t) < 1e9:
            continue
        loss = a_error * t * t + 2.0 * b_error * abs(t) + c_error
        error, shift = share * (far + abs(t)), loss / (2.0 * root) if loss > 0.0 else 0.0
        _consider(
            work, planes, reach, fx + t * ax, fy + t * ay, fz + t * az, error, shift * ax, shift * ay, shift * az
        )  # fmt: skip


@helper
def _try_gradient(
    work: Floats, planes: int, form: Floats, reach: Floats,
    nx: float, ny: float, nz: float, nd: float, weight: float, ax: float, ay: float, az: float,
) -> None:  # fmt: skip
    """Try the line common to a plane and to ∇f·a = 0, for a unit vector a."""
    gx, gy, gz = _times_form(form, ax, ay, az)
    size = norm(gx, gy, gz)
    if size <= _PARALLEL:
        return
    offset = -(form[6] * ax + form[7] * ay + form[8] * az) / size
    _try_line(
        work, planes, form, reach, nx, ny, nz, nd, gx / size, gy / size, gz / size, offset, min(weight, size)
    )  # fmt: skip


@helper
def _try_quadric(work: Floats, planes: int, form: Floats, reach: Floats) -> None:
    """Try all points of f = 0 where a coordinate may be largest."""
    for i in range(planes):
        nx, ny, nz, nd = work[i, 0], work[i, 1], work[i, 2], work[i, 3]
        for j in range(i):
            _try_line(
                work, planes, form, reach, nx, ny, nz, nd, work[j, 0], work[j, 1], work[j, 2], work[j, 3], 1.0
            )  # fmt: skip
        for k in range(3):
            # Stationary on the plane: across its normal and the axis
            ax, ay, az = (0.0, -nz, ny) if k == 0 else (nz, 0.0, -nx) if k == 1 else (-ny, nx, 0.0)
            sine = norm(ax, ay, az)
            if sine > _PARALLEL:
                _try_gradient(work, planes, form, reach, nx, ny, nz, nd, 1.0, ax / sine, ay / sine, az / sine)
    for k in range(3):
        # Stationary on the whole quadric: across the axis in two ways
        i, j = (k + 1) % 3, (k + 2) % 3
        gx, gy, gz = _times_form(form, 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        size = norm(gx, gy, gz)
        if size > _PARALLEL:
            _try_gradient(
                work, planes, form, reach, gx / size, gy / size, gz / size, -form[6 + i] / size, size,
                1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0,
            )  # fmt: skip


@inline
def _half(boxes: Floats, body: int, axis: int) -> float:
    """Return half the width of a box."""
    return 0.5 * boxes[body, 3 + axis] - 0.5 * boxes[body, axis]


@inline
def _place_frame(boxes: Floats, body: int, frame: Floats) -> bool:
    """Write the center, the scales, and the ends of a box in u, up and down; return False for an infinite box."""
    widest = max(_half(boxes, body, 0), max(_half(boxes, body, 1), _half(boxes, body, 2)))
    for k in range(3):
        half = _half(boxes, body, k)
        scale = half if half > 0.0 else _FLAT * widest
        frame[k] = 0.5 * boxes[body, k] + 0.5 * boxes[body, 3 + k]
        frame[3 + k] = scale
        frame[6 + k] = frame[9 + k] = half / scale + _LAST_DIGITS * (1.0 + abs(frame[k]) / scale)
        # Ends beyond [-1, 1] cover the rounding of the center, which a flat box far from the origin may be as thin as
        if not (scale > 1e-150 and scale < 1e150 and frame[6 + k] <= _WIDEST):
            return False
    return True


@helper
def _narrow(boxes: Floats, body: int, frame: Floats, work: Floats, count: int, reach: Floats) -> bool:
    """Narrow a box, and its sides in `work`, to what the points reach; return False if nothing is certain."""
    for side in range(6):
        # Where a sharp point reaches a side, blurred ones beyond it do no harm, as near the apex of a cone. NaN, too
        if not min(frame[6 + side], reach[side]) - reach[6 + side] <= 2.0 * _BLURRED:
            return False
    for k in range(3):
        up, down = reach[k] + _MARGIN, reach[3 + k] + _MARGIN
        high, low = frame[k] + frame[3 + k] * up, frame[k] - frame[3 + k] * down
        slack = _LAST_DIGITS * (abs(frame[k]) + frame[3 + k])
        frame[6 + k], frame[9 + k] = min(frame[6 + k], up), min(frame[9 + k], down)
        boxes[body, 3 + k], boxes[body, k] = min(boxes[body, 3 + k], high + slack), max(boxes[body, k], low - slack)
    _place_sides(work, count, frame)
    return True


@inline
def _clear_reach(reach: Floats) -> None:
    for side in range(6):
        reach[side], reach[6 + side] = -math.inf, -math.inf


@helper
def _is_void(work: Floats, count: int, form: Floats, curved: bool, reach: Floats) -> bool:
    """Return whether no point counts with `count` planes and f = 0 farther out; `reach` is that of no point."""
    for i in range(count):
        work[i, 3] += _CLEAR
    if curved:
        form[9] += _CLEAR * (1.0 + _slope(form) + abs(form[9]))
    _try_corners(work, count + SIDES, form, curved, reach)
    if curved:
        _try_quadric(work, count + SIDES, form, reach)
    return not reach[0] > -math.inf


@inline
def _empty(boxes: Floats, body: int) -> None:
    for k in range(3):
        boxes[body, k], boxes[body, 3 + k] = math.inf, -math.inf


@helper
def _narrow_once(
    planes: Floats, quadrics: Floats, senses: Signs, boxes: Floats, body: int,
    work: Floats, frame: Floats, form: Floats, reach: Floats,
) -> int:  # fmt: skip
    """Narrow the box of one body in its frame; return 1, 0 if it is not certain, -1 if the body is empty."""
    count = _place_planes(planes, body, len(work) - SIDES, frame, work)
    if count < 0:
        return -1
    rows, cut = count + SIDES, False
    for quadric in range(senses.shape[1]):
        cuts = _place_quadric(quadrics, body, QUADRIC_SIZE * quadric, float(senses[body, quadric]), frame, form)
        if cuts < 0:
            return -1
        if cuts == 0:
            continue
        cut = True
        _clear_reach(reach)
        _try_corners(work, rows, form, True, reach)
        _try_quadric(work, rows, form, reach)
        if not reach[0] > -math.inf:
            return -1 if _is_void(work, count, form, True, reach) else 0
        if not _narrow(boxes, body, frame, work, count, reach):
            return 0
    if not cut and count:
        _clear_reach(reach)
        _try_corners(work, rows, form, False, reach)
        if not reach[0] > -math.inf:
            return -1 if _is_void(work, count, form, False, reach) else 0
        if not _narrow(boxes, body, frame, work, count, reach):
            return 0
    return 1


@kernel(
    planes="n 7*p", quadrics="n 19*q", senses="n q", boxes="out n 6", certain="out n", work="out p+6 4",
    frame="out 12", form="out 10", reach="out 12",
)  # fmt: skip
def narrow_csg_boxes(
    planes: Floats, quadrics: Floats, senses: Signs, boxes: Floats, certain: Signs,
    work: Floats, frame: Floats, form: Floats, reach: Floats,
) -> None:  # fmt: skip
    """Narrow boxes around bodies by the planes and quadrics that contain these bodies.

    Parameters
    ----------
    planes : array (n, 7 p)
        Records of planes, with the body where their value is negative.
    quadrics : array (n, 19 q)
        Records of quadrics.
    senses : array (n, q)
        1 where the body is inside a quadric, -1 where it is outside.
    boxes : array (n, 6)
        Boxes that hold the bodies, which become narrower.
    certain : array (n,)
        1 for boxes that are right, 0 for those that floats do not decide.
    work, frame, form, reach : arrays
        Room.
    """
    smaller = _SMALLER[1] if senses.shape[1] > 1 else _SMALLER[0]
    for body in range(len(boxes)):
        certain[body] = 1
        for _ in range(_ROUNDS):
            empty = False
            for k in range(3):
                empty = empty or not boxes[body, k] <= boxes[body, 3 + k]
            if empty:
                _empty(boxes, body)
                break
            if not _place_frame(boxes, body, frame):
                certain[body] = 0
                break
            found = _narrow_once(planes, quadrics, senses, boxes, body, work, frame, form, reach)
            if found < 0:
                _empty(boxes, body)
                break
            if found == 0:
                certain[body] = 0
                break
            shrunk = False
            for k in range(3):
                shrunk = shrunk or _half(boxes, body, k) < smaller * frame[3 + k]
            if not shrunk:
                break


# Finite boxes around regions between planes, for `narrow_csg_boxes` to begin with
#
# A coordinate is largest over a region in a common point of three planes whose normals have the axis in their cone. So
# every such point of three planes bounds the coordinate, wherever the others are (duality), and the least bound is the
# tight one. Floats with a bound of their error decide which three are such planes, whatever the rounding of records.

_MOST_PLANES = 24
"""Of more planes only the first count: there are 2,024 triples of so many."""
FLOAT_ERROR = 2.0**-48
"""More than the relative rounding error of a record's number, and of a few operations."""
_LEAST_ENTRY = 1e-100
"""Planes with smaller entries of their normals do not count: products might underflow."""


@helper
def _offset_from_center(planes: Floats, body: int, plane: int) -> tuple[float, float]:
    """Return the offset of a plane about the anchor of the first, and a bound of its error, infinite if unused."""
    at = PLANE_SIZE * plane
    above = planes[body, at + 3]
    offset, terms, used = 0.0, 0.0, False
    for k in range(3):
        entry, anchor, center = planes[body, at + k], planes[body, at + 4 + k], planes[body, 4 + k]
        if entry != 0.0 and not abs(entry) > _LEAST_ENTRY:
            return 0.0, math.inf
        used = used or entry != 0.0
        offset += entry * (anchor - center)
        terms += abs(entry) * (abs(anchor) + abs(center))
    return offset - above, FLOAT_ERROR * (terms + abs(above)) if used else math.inf


@inline
def _cross_entry(planes: Floats, body: int, i: int, j: int, k: int) -> tuple[float, float]:
    """Return entry k of the cross product of two normals, and a bound of its error: zero where both terms are."""
    u, v = (k + 1) % 3, (k + 2) % 3
    forth = planes[body, PLANE_SIZE * i + u] * planes[body, PLANE_SIZE * j + v]
    back = planes[body, PLANE_SIZE * i + v] * planes[body, PLANE_SIZE * j + u]
    return forth - back, FLOAT_ERROR * (abs(forth) + abs(back))


@helper
def _bound_by_corner(planes: Floats, body: int, offsets: Floats, i: int, j: int, k: int, boxes: Floats) -> None:
    """Narrow a box by the corner of three planes, along each axis for which the corner is certainly an end."""
    unit, unit_error = 0.0, 0.0
    for axis in range(3):
        cross, error = _cross_entry(planes, body, j, k, axis)
        entry = planes[body, PLANE_SIZE * i + axis]
        unit += entry * cross
        unit_error += abs(entry) * error + FLOAT_ERROR * abs(entry * cross)
    size = abs(unit) - unit_error
    if not size > unit_error:
        return
    sense = 1.0 if unit > 0.0 else -1.0
    for axis in range(3):
        top, top_error, is_high, is_low = 0.0, 0.0, True, True
        for turn in range(3):
            first, second, third = (i, j, k) if turn == 0 else (j, k, i) if turn == 1 else (k, i, j)
            share, error = _cross_entry(planes, body, second, third, axis)
            # A share that is certainly not negative, or exactly zero
            is_high = is_high and sense * share >= error
            is_low = is_low and sense * share <= -error
            offset = offsets[first, 0]
            top += offset * share
            top_error += offsets[first, 1] * (abs(share) + error) + abs(offset) * (error + FLOAT_ERROR * abs(share))
        if not is_high and not is_low:
            continue
        center, at = planes[body, 4 + axis], top / unit
        # Twice, so that the rounding of these sums is within it too
        error = 2.0 * (top_error + abs(at) * unit_error) / size + FLOAT_ERROR * (abs(at) + abs(center))
        if not abs(at) + error < math.inf:
            continue
        if is_high:
            boxes[body, 3 + axis] = min(boxes[body, 3 + axis], at + error + center)
        if is_low:
            boxes[body, axis] = max(boxes[body, axis], at - error + center)


@kernel(planes="n 7*p", boxes="out n 6", offsets="out p 2")
def bound_by_corners(planes: Floats, boxes: Floats, offsets: Floats) -> None:
    """Narrow boxes, which may be infinite, as far as corners of three planes bound the regions between planes.

    Parameters
    ----------
    planes : array (n, 7 p)
        Records of planes, with the body where their value is negative. A normal of zeros does not count.
    boxes : array (n, 6)
        Boxes that hold the bodies, which become narrower.
    offsets : array (p, 2)
        Room.
    """
    count = min(len(offsets), _MOST_PLANES)
    for body in range(len(planes)):
        for plane in range(count):
            offsets[plane, 0], offsets[plane, 1] = _offset_from_center(planes, body, plane)
        for i in range(count):
            for j in range(i + 1, count):
                for k in range(j + 1, count):
                    if offsets[i, 1] < math.inf and offsets[j, 1] < math.inf and offsets[k, 1] < math.inf:
                        _bound_by_corner(planes, body, offsets, i, j, k, boxes)
