"""Surfaces on a ray solved as in the documents: their letters, with numbers from exact arithmetic, rounded once.

Planes, spheres, circular cylinders and other quadrics; then polygons and triangles; then slabs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from ...geometry.surface import QuadricSurface
from ...kernels.tables import SPHERE
from ...numerics import bigfloat as ex
from ...numerics.rational import dot
from .document import Block, Board, Citation, TextLine as Words
from .polynomial import (
    ExactRay,
    Polynomial,
    SurfaceSource,
    as_float,
    format_float,
    format_fraction,
    format_vector,
    join_terms,
    sqrt_fraction,
)

# Surfaces on a ray.

_LETTERS = "AEHBCFDGIJ"
"""Letters of the ten coefficients in the ray tracing notes."""


def board_of(source: SurfaceSource, line: ExactRay) -> Board:
    """Return the lecture's lines for a surface: a plane, a sphere, a circular cylinder, or any other quadric."""
    polynomial, exact = source.polynomial, source.exact
    if polynomial.is_flat:
        return plane_board(polynomial, line)
    if source.kind == SPHERE:
        return sphere_board(polynomial, line)
    if isinstance(exact, QuadricSurface) and is_circular_cylinder(exact):
        return cylinder_board(exact, line)
    return quadric_board(polynomial, line)


def plane_board(polynomial: Polynomial, line: ExactRay) -> Board:
    """Return the lines of a plane: v_d = n·d, v_0 = q − n·o, t = v_0 / v_d."""
    normal, offset = [2 * half for half in polynomial.ten[6:9]], -polynomial.ten[9]
    slope, height = dot(normal, line.direction), offset - dot(normal, line.origin)
    numbers = {"v_d": as_float(slope), "v_0": as_float(height)}
    words = [
        Words(f"n = {format_vector(normal)}, q = {format_fraction(offset)}", Citation.PLANE, 2),
        Words(f"v_d = n·d = {format_fraction(slope)}, v_0 = q − n·o = {format_fraction(height)}", "", 2),
    ]
    if not slope:
        words.append(Words("v_d = 0: parallel, no crossing", "", 2))
        return Board(tuple(words), numbers)
    numbers["t"] = as_float(height / slope)
    remark = "" if line.holds(height / slope) else f": not within {line.interval}"
    words.append(Words(f"t = v_0 / v_d = {format_float(numbers['t'])}{remark}", "", 2))
    return Board(tuple(words), numbers)


def sphere_board(polynomial: Polynomial, line: ExactRay) -> Board:
    """Return the lines of a sphere: the algebraic method, then the geometric one."""
    center = [-half for half in polynomial.ten[6:9]]
    radius_squared = dot(center, center) - polynomial.ten[9]
    out = [o - c for o, c in zip(line.origin, center, strict=True)]
    a, b = line.square, dot(line.direction, out)
    c = dot(out, out) - radius_squared
    discriminant = b * b - a * c
    numbers = {"a": as_float(a), "B": as_float(b), "C": as_float(c), "D": as_float(discriminant)}
    unit = line.is_unit
    words: list[Block] = [
        Words(
            f"center S = {format_vector(center)}, r = {format_fraction(sqrt_fraction(radius_squared))}",
            Citation.SPHERE_ALGEBRAIC,
            2,
        ),
        Words("t² + 2 B t + C = 0" if unit else f"a t² + 2 B t + C = 0, a = d·d = {format_fraction(a)}", "", 2),
        Words(f"B = (d, o − S) = {format_fraction(b)}", "", 2),
        Words(f"C = (o − S)² − r² = {format_fraction(c)}", "", 2),
        Words(f"D = B² − {'C' if unit else 'a C'} = {format_fraction(discriminant)}{_sign_of(discriminant)}", "", 2),
    ]
    words += _two_roots(("t₀ = −B − √D", "t₁ = −B + √D"), "" if unit else " / a", a, b, discriminant, numbers)
    words += _geometric(a, b, out, radius_squared, line, numbers)
    return Board(tuple(words), numbers)


def _sign_of(discriminant: Fraction) -> str:
    """Return the meaning of a discriminant that is not positive; nothing for a positive one."""
    if discriminant < 0:
        return " < 0: no real root"
    return " = 0: it only touches" if not discriminant else ""


def _two_roots(
    formulas: tuple[str, str], over: str, a: Fraction, b: Fraction, discriminant: Fraction, numbers: dict[str, float]
) -> list[Block]:  # fmt: skip
    """Return the roots of a t² + 2 b t + c, a > 0 or < 0, and which of the three cases it is; add them to `numbers`."""
    if discriminant <= 0:
        return [Words("read as invisible: no crossing", Citation.TOUCH, 2)] if not discriminant else []
    root = sqrt_fraction(discriminant)
    first, second = (-b - root) / a, (-b + root) / a
    numbers |= {"t0": as_float(first), "t1": as_float(second)}
    texts = [f"({one}){over}" if over else one for one in (part.split(" = ")[1] for part in formulas)]
    names = [part.split(" = ")[0] for part in formulas]
    words: list[Block] = [
        Words(f"{name} = {text} = {format_fraction(t)}", "", 2)
        for name, text, t in zip(names, texts, (first, second), strict=True)
    ]
    low, high = min(first, second), max(first, second)
    if high <= 0:
        # The three cases of the notes, by the signs of both roots
        case = f"{names[0]}, {names[1]} ≤ 0: it lies behind the origin"
    elif low < 0:
        case = (
            f"{names[0]} < 0 < {names[1]}: the ray starts between its crossings" if a > 0 else "one root on each side"
        )
    else:
        case = f"{names[0]}, {names[1]} > 0: both lie ahead"
    if a < 0:
        swapped = (
            f"a < 0: {names[0]} > {names[1]}, and the notes, which try {names[0]} first, would take the farther one"
        )
        words.append(Words(swapped, "docs/theory.md, section 14", 2))
    return [*words, Words(case, "", 2)]


def _geometric(
    a: Fraction,
    b: Fraction,
    out: Sequence[Fraction],
    radius_squared: Fraction,
    line: ExactRay,
    numbers: dict[str, float],
) -> list[Block]:
    """Return the geometric method: t_ca, the squared distance of the line from the center, half the chord."""
    square = dot(out, out)
    nearest = -b / a
    squared = square - b * b / a
    half = (radius_squared - squared) / a
    where = "inside" if square < radius_squared else ("on the sphere" if square == radius_squared else "outside")
    numbers |= {
        "OC2": as_float(square), "t_ca": as_float(nearest), "h2": as_float(squared), "t_hc2": as_float(half),
    }  # fmt: skip
    words: list[Block] = [
        Words(f"OC² = {format_fraction(square)}, r² = {format_fraction(radius_squared)}: the origin is {where}",
              Citation.SPHERE_GEOMETRIC, 2),
        Words(f"t_ca = (OC, d){'' if line.is_unit else ' / a'} = {format_fraction(nearest)}", "", 2),
    ]  # fmt: skip
    # The notes stop here, without the distance of the line
    if nearest < 0 and square > radius_squared:
        return [*words, Words("t_ca < 0 and the origin is outside: the ray misses", "", 2)]
    scaled = "" if line.is_unit else " a"
    words += [
        Words(
            f"D² = OC² − t_ca²{scaled} = {format_fraction(squared)}, the squared distance of the line from S",
            "",
            2,
        ),
        Words(
            f"t_hc² = {'r² − D²' if line.is_unit else '(r² − D²) / a'} = {format_fraction(half)}{_sign_of(half)}", "", 2
        ),
    ]
    if half > 0:
        t = nearest - sqrt_fraction(half) if square > radius_squared else nearest + sqrt_fraction(half)
        numbers["t"] = as_float(t)
        sign = "−" if square > radius_squared else "+"
        words.append(Words(f"t = t_ca {sign} t_hc = {format_fraction(t)}", "", 2))
    return words


def quadric_board(polynomial: Polynomial, line: ExactRay) -> Board:
    """Return the lines of a quadric: a t² + b t + c = 0 of the ray tracing notes, that is 13.3 of the Clemson notes."""
    a, half, c = polynomial.on_ray(line.origin, line.direction)
    b, discriminant = 2 * half, 4 * (half * half - a * c)
    numbers = {"a": as_float(a), "b": as_float(b), "c": as_float(c), "D": as_float(discriminant)}
    letters = ", ".join(
        f"{letter} = {format_fraction(value)}" for letter, value in zip(_LETTERS, polynomial.ten, strict=True) if value
    )
    words: list[Block] = [
        Words(letters, Citation.QUADRIC, 2),
        Words(
            f"a t² + b t + c = 0: a = uᵗQu = {format_fraction(a)}, b = 2 uᵗQp = "
            f"{format_fraction(b)}, c = pᵗQp = {format_fraction(c)}",
            "",
            2,
        ),
    ]
    if not a:
        return Board((*words, *_without_square(b, c, line, numbers)), numbers)
    words.append(Words(f"b² − 4 a c = {format_fraction(discriminant)}{_sign_of(discriminant)}", "", 2))
    formulas = "t₀ = −b − √(b² − 4 a c)", "t₁ = −b + √(b² − 4 a c)"
    words += _two_roots(formulas, " / 2a", 2 * a, b, discriminant, numbers)
    return Board(tuple(words), numbers)


def _without_square(b: Fraction, c: Fraction, line: ExactRay, numbers: dict[str, float]) -> list[Block]:
    """Return the root of b t + c, or on which side the ray is if b = 0 as well."""
    if b:
        numbers["t"] = as_float(-c / b)
        remark = "" if line.holds(-c / b) else f": not within {line.interval}"
        return [Words(f"a = 0: t = −c / b = {format_fraction(-c / b)}{remark}", "", 2)]
    where = "inside" if c < 0 else ("on the surface" if not c else "outside")
    left_out = "docs/theory.md, section 14: the case that the notes leave out"
    return [Words(f"a = b = 0: the ray is {where} all along, as c = {format_fraction(c)}", left_out, 2)]


def is_circular_cylinder(surface: QuadricSurface) -> bool:
    """Return True if a surface is X² + Y² = r² in its own coordinates with orthonormal axes."""
    (x, y, z), linear = surface.squares, surface.linear
    if not (x == y and float(x) > 0 and not float(z)) or any(map(float, linear)) or not float(surface.constant) > 0:
        return False
    rows = [[float(value) for value in row] for row in surface.rows]
    return all(
        abs(sum(p * q for p, q in zip(rows[i], rows[j], strict=True)) - (i == j)) < 1e-14
        for i in range(3)
        for j in range(3)
    )


def cylinder_board(surface: QuadricSurface, line: ExactRay) -> Board:
    """Return the lines of a circular cylinder: equations (5) to (10) of Sasaki 2021, in its local frame."""
    rows = [[ex.fraction(value) for value in row] for row in surface.rows]
    start = [ex.fraction(value) for value in surface.anchor]
    radius_squared = ex.fraction(surface.constant) / ex.fraction(surface.squares[0])
    aside = [o - p for o, p in zip(line.origin, start, strict=True)]
    x, y, z = (dot(row, aside) for row in rows)
    u, v, w = (dot(row, line.direction) for row in rows)
    a, b, c = u * u + v * v, x * u + y * v, x * x + y * y - radius_squared
    discriminant = b * b - a * c
    numbers = {name: as_float(value) for name, value in zip("XYZUVW", (x, y, z, u, v, w), strict=True)}
    numbers |= {"a": as_float(a), "b": as_float(b), "c": as_float(c), "D": as_float(discriminant)}
    words: list[Block] = [
        Words(
            f"p₁ = {format_vector(start)}, r = {format_fraction(sqrt_fraction(radius_squared))}", Citation.CYLINDER, 2
        ),
        Words(
            f"(2) R_X = {format_vector(rows[0])}, R_Y = {format_vector(rows[1])}, R_Z = {format_vector(rows[2])}", "", 2
        ),
        Words(f"(5) (X₀, Y₀, Z₀) = {format_vector((x, y, z))}, (U, V, W) = {format_vector((u, v, w))}", "", 2),
        Words(
            f"(7) (U² + V²) t² + 2 (X₀U + Y₀V) t + X₀² + Y₀² − r² = 0: "
            f"{join_terms([(a, 't²'), (2 * b, 't'), (c, '')], format_float)} = 0",
            "",
            2,
        ),
        Words(f"(8) D = {format_fraction(discriminant)}{_sign_of(discriminant) if a else ''}", "", 2),
    ]
    if not a:
        where = "inside" if c < 0 else ("on the wall" if not c else "outside")
        words.append(Words(f"U = V = 0: the ray runs along the axis, {where} all along", "", 2))
        return Board(tuple(words), numbers)
    if discriminant <= 0:
        touching = [Words("read as invisible: no crossing", Citation.TOUCH, 2)] if not discriminant else []
        return Board((*words, *touching), numbers)
    for sign, name in ((-1, "t₋"), (1, "t₊")):
        t = (-b + sign * sqrt_fraction(discriminant)) / a
        at = [x + t * u, y + t * v, z + t * w]
        angle = math.degrees(math.atan2(as_float(at[1]), as_float(at[0])))
        numbers |= {"t-" if sign < 0 else "t+": as_float(t), "Z-" if sign < 0 else "Z+": as_float(at[2])}
        numbers["angle-" if sign < 0 else "angle+"] = angle
        words.append(
            Words(
                f"(9) {name} = {format_fraction(t)}; (10) (X, Y, Z) = {format_vector(at)}; (12) θ = {angle:.6g}°", "", 2
            )
        )
    return Board(tuple(words), numbers)


# A polygon by even-odd, and a triangle by areas, at the crossing with the plane, as in the ray tracing notes.

_MOST = 24
"""Edges of a polygon that are shown one by one."""


def outline_board(corners: Sequence[Sequence[float]], plane: Polynomial, line: ExactRay) -> Board:
    """Drop a coordinate, move the point to the origin, count the edges that cross the positive u axis."""
    places = line.roots(plane)
    if not places:
        return Board((Words("the ray is parallel to the plane", Citation.PLANE, 2),), {})
    point, normal = line.at(places[0]), [2 * half for half in plane.ten[6:9]]
    # The largest component of the normal: the projection keeps the most area
    dropped = max(range(3), key=lambda k: abs(normal[k]))
    axes = [k for k in range(3) if k != dropped]
    shifted = [tuple(Fraction(corner[k]) - point[k] for k in axes) for corner in corners]
    more = " ..." if len(shifted) > _MOST else ""
    words: list[Block] = [
        Words(
            f"the ray crosses the plane at t = {format_fraction(places[0])}, at {format_vector(point)}",
            Citation.POLYGON,
            2,
        ),
        Words(
            f"its normal {format_vector(normal)} is largest along {'xyz'[dropped]}: that coordinate is dropped", "", 2
        ),
        Words(
            f"moved to the point: {', '.join(map(format_vector, shifted[:_MOST]))}{more}",
            "",
            2,
        ),
    ]
    numbers, count = {}, 0
    for k, ((ua, va), (ub, vb)) in enumerate(zip(shifted, [*shifted[1:], shifted[0]], strict=True)):
        # A corner on the axis counts as above it, so that it is not counted twice
        if (va < 0) == (vb < 0):
            continue
        at = ua - va * (ub - ua) / (vb - va)
        count += at > 0
        numbers[f"edge {k + 1}"] = as_float(at)
        if k < _MOST:
            side = "> 0: counted" if at > 0 else "≤ 0: not counted"
            words.append(Words(f"edge {k + 1} crosses the u axis at u = {format_fraction(at)} {side}", "", 2))
    numbers["crossings"] = count
    odd = "odd: inside" if count % 2 else "even: outside"
    words.append(Words(f"{count} crossing{'s' if count != 1 else ''}, {odd}", "", 2))
    if len(corners) == 3:
        words += _areas(shifted, numbers)
    return Board(tuple(words), numbers)


def _areas(corners: Sequence[tuple[Fraction, ...]], numbers: dict[str, float]) -> list[Block]:
    """Return barycentric coordinates of the origin as ratios of areas; nothing for a degenerate triangle."""
    a, b, c = corners

    def area(p: tuple[Fraction, ...], q: tuple[Fraction, ...], r: tuple[Fraction, ...]) -> Fraction:
        """Return the signed area of a triangle."""
        return ((q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])) / 2

    whole, zero = area(a, b, c), (Fraction(0), Fraction(0))
    # Three corners on a line
    if not whole:
        return []
    shares = [area(zero, b, c) / whole, area(a, zero, c) / whole, area(a, b, zero) / whole]
    numbers |= {name: as_float(share) for name, share in zip(("alpha", "beta", "gamma"), shares, strict=True)}
    inside = "inside" if min(shares) > 0 else ("on an edge" if min(shares) == 0 else "outside")
    coordinates = ", ".join(f"{name} = {format_fraction(share)}" for name, share in zip("αβγ", shares, strict=True))
    return [Words(f"as a triangle: {coordinates}: {inside}", Citation.AREAS, 2)]


# Planes of a cell in pairs: slabs, solved like a box of the ray tracing notes.

Slab: TypeAlias = tuple[str, Fraction, Fraction, Fraction, Fraction]
"""A name, low <= n·p <= high, n·o and n·d."""


def solve_slabs(slabs: Sequence[Slab], line: ExactRay) -> Board:
    """Return t_near and t_far after each slab, until one of them excludes a hit."""
    words: list[Block] = []
    numbers: dict[str, float] = {}
    near: Fraction | None = None
    far: Fraction | None = None
    for name, low, high, at, slope in slabs:
        source = Citation.BOX if not words else ""
        limits = (
            f"{name}: {format_fraction(low)} to {format_fraction(high)}, origin "
            f"{format_fraction(at)}, direction {format_fraction(slope)}"
        )
        if not slope:
            outside = at < low or at > high
            verdict = "outside: no hit" if outside else "between the planes for all t"
            words.append(Words(f"{limits}: parallel, {verdict}", source, 2))
            if outside:
                return Board(tuple(words), numbers)
            continue
        t1, t2 = (low - at) / slope, (high - at) / slope
        first, last = min(t1, t2), max(t1, t2)
        # The largest entry and the smallest exit so far
        near = first if near is None else max(near, first)
        far = last if far is None else min(far, last)
        numbers |= {f"{name} t1": as_float(t1), f"{name} t2": as_float(t2)}
        numbers |= {"t_near": as_float(near), "t_far": as_float(far)}
        swapped = ", swapped" if t2 < t1 else ""
        words.append(Words(f"{limits}: t₁ = {format_fraction(t1)}, t₂ = {format_fraction(t2)}{swapped}", source, 2))
        words.append(Words(f"t_near = {format_fraction(near)}, t_far = {format_fraction(far)}", "", 3))
        if near > far:
            words.append(Words("t_near > t_far: no hit", "", 3))
            return Board(tuple(words), numbers)
        if far < 0 <= line.t_min:
            words.append(Words("t_far < 0: it lies behind the origin", "", 3))
            return Board(tuple(words), numbers)
    if near is not None:
        words.append(Words("all slabs have t_near ≤ t_far: a hit", "", 2))
    return Board(tuple(words), numbers)
