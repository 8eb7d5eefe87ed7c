"""A surface on a ray as the documents work it out: their letters, numbers from exact arithmetic, rounded once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from ..engine.tables import SPHERE
from ..shapes import exact as ex
from ..shapes.surface import QuadricSurface
from . import sources
from .blocks import Block
from .blocks import Line as Words
from .line import Line
from .numbers import as_float, dot, root, rounded, told, vector
from .polynomial import Polynomial, Source, joined
from .steps import Board

_LETTERS = "AEHBCFDGIJ"


def board_of(source: Source, line: Line) -> Board:
    """The lecture's lines for a surface: of a ball, a circular cylinder, any other quadric, or a plane."""
    polynomial, exact = source.polynomial, source.exact
    if polynomial.is_flat:
        return plane_board(polynomial, line)
    if source.kind == SPHERE:
        return sphere_board(polynomial, line)
    if isinstance(exact, QuadricSurface) and is_circular_cylinder(exact):
        return cylinder_board(exact, line)
    return quadric_board(polynomial, line)


def plane_board(polynomial: Polynomial, line: Line) -> Board:
    """v_d = n·d, v_0 = q − n·o, t = v_0 / v_d."""
    normal, offset = [2 * half for half in polynomial.ten[6:9]], -polynomial.ten[9]
    slope, height = dot(normal, line.direction), offset - dot(normal, line.origin)
    numbers = {"v_d": as_float(slope), "v_0": as_float(height)}
    words = [
        Words(f"n = {vector(normal)}, q = {rounded(offset)}", sources.PLANE, 2),
        Words(f"v_d = n·d = {rounded(slope)}, v_0 = q − n·o = {rounded(height)}", "", 2),
    ]
    if not slope:
        words.append(Words("v_d = 0: parallel, no crossing", "", 2))
        return Board(tuple(words), numbers)
    numbers["t"] = as_float(height / slope)
    behind = "" if line.holds(height / slope) else f": not within {line.interval}"
    words.append(Words(f"t = v_0 / v_d = {told(numbers['t'])}{behind}", "", 2))
    return Board(tuple(words), numbers)


def sphere_board(polynomial: Polynomial, line: Line) -> Board:
    """The algebraic method and the geometric one."""
    center = [-half for half in polynomial.ten[6:9]]
    radius_squared = dot(center, center) - polynomial.ten[9]
    out = [o - c for o, c in zip(line.origin, center, strict=True)]
    a, b = line.square, dot(line.direction, out)
    c = dot(out, out) - radius_squared
    discriminant = b * b - a * c
    numbers = {"a": as_float(a), "B": as_float(b), "C": as_float(c), "D": as_float(discriminant)}
    unit = line.is_unit
    words: list[Block] = [
        Words(f"center S = {vector(center)}, r = {rounded(root(radius_squared))}", sources.SPHERE_ALGEBRAIC, 2),
        Words("t² + 2 B t + C = 0" if unit else f"a t² + 2 B t + C = 0, a = d·d = {rounded(a)}", "", 2),
        Words(f"B = (d, o − S) = {rounded(b)}", "", 2),
        Words(f"C = (o − S)² − r² = {rounded(c)}", "", 2),
        Words(f"D = B² − {'C' if unit else 'a C'} = {rounded(discriminant)}{_sign_of(discriminant)}", "", 2),
    ]
    words += _two_roots(("t₀ = −B − √D", "t₁ = −B + √D"), "" if unit else " / a", a, b, discriminant, line, numbers)
    words += _geometric(a, b, out, radius_squared, line, numbers)
    return Board(tuple(words), numbers)


def _sign_of(discriminant: Fraction) -> str:
    if discriminant < 0:
        return " < 0: no real root"
    return " = 0: it only touches" if not discriminant else ""


def _two_roots(
    said: tuple[str, str], over: str, a: Fraction, b: Fraction, discriminant: Fraction, line: Line,
    numbers: dict[str, float],
) -> list[Block]:  # fmt: skip
    """The roots of a t² + 2 b t + c, a > 0 or < 0, and which of the three cases it is."""
    if discriminant <= 0:
        return [Words("read as invisible: no crossing", sources.TOUCH, 2)] if not discriminant else []
    apart = root(discriminant)
    first, second = (-b - apart) / a, (-b + apart) / a
    numbers |= {"t0": as_float(first), "t1": as_float(second)}
    texts = [f"({one}){over}" if over else one for one in (part.split(" = ")[1] for part in said)]
    names = [part.split(" = ")[0] for part in said]
    words: list[Block] = [
        Words(f"{name} = {text} = {rounded(t)}", "", 2)
        for name, text, t in zip(names, texts, (first, second), strict=True)
    ]
    low, high = min(first, second), max(first, second)
    if high <= 0:
        case = f"{names[0]}, {names[1]} ≤ 0: it lies behind the origin"
    elif low < 0:
        case = (
            f"{names[0]} < 0 < {names[1]}: the ray starts between its crossings" if a > 0 else "one root on each side"
        )
    else:
        case = f"{names[0]}, {names[1]} > 0: both lie ahead"
    return [*words, Words(case, "", 2)]


def _geometric(
    a: Fraction, b: Fraction, out: Sequence[Fraction], radius_squared: Fraction, line: Line, numbers: dict[str, float]
) -> list[Block]:
    """t_ca, the squared distance of the line from the center, half the chord."""
    square = dot(out, out)
    nearest = -b / a
    beside = square - b * b / a
    half = (radius_squared - beside) / a
    where = "inside" if square < radius_squared else ("on the sphere" if square == radius_squared else "outside")
    numbers |= {
        "OC2": as_float(square), "t_ca": as_float(nearest), "h2": as_float(beside), "t_hc2": as_float(half),
    }  # fmt: skip
    words: list[Block] = [
        Words(f"OC² = {rounded(square)}, r² = {rounded(radius_squared)}: the origin is {where}",
              sources.SPHERE_GEOMETRIC, 2),
        Words(f"t_ca = (OC, d){'' if line.is_unit else ' / a'} = {rounded(nearest)}", "", 2),
    ]  # fmt: skip
    if nearest < 0 and square > radius_squared:
        return [*words, Words("t_ca < 0 and the origin is outside: the ray misses", "", 2)]
    scaled = "" if line.is_unit else " a"
    words += [
        Words(f"D² = OC² − t_ca²{scaled} = {rounded(beside)}, the squared distance of the line from S", "", 2),
        Words(f"t_hc² = {'r² − D²' if line.is_unit else '(r² − D²) / a'} = {rounded(half)}{_sign_of(half)}", "", 2),
    ]
    if half > 0:
        t = nearest - root(half) if square > radius_squared else nearest + root(half)
        numbers["t"] = as_float(t)
        sign = "−" if square > radius_squared else "+"
        words.append(Words(f"t = t_ca {sign} t_hc = {rounded(t)}", "", 2))
    return words


def quadric_board(polynomial: Polynomial, line: Line) -> Board:
    """a t² + b t + c = 0 with the coefficients of the ray tracing notes, which are 13.3 of the Clemson notes."""
    a, half, c = polynomial.on_ray(line.origin, line.direction)
    b, discriminant = 2 * half, 4 * (half * half - a * c)
    numbers = {"a": as_float(a), "b": as_float(b), "c": as_float(c), "D": as_float(discriminant)}
    letters = ", ".join(
        f"{letter} = {rounded(value)}" for letter, value in zip(_LETTERS, polynomial.ten, strict=True) if value
    )
    words: list[Block] = [
        Words(letters, sources.QUADRIC, 2),
        Words(
            f"a t² + b t + c = 0: a = uᵗQu = {rounded(a)}, b = 2 uᵗQp = {rounded(b)}, c = pᵗQp = {rounded(c)}", "", 2
        ),
    ]
    if not a:
        return Board((*words, *_without_square(b, c, line, numbers)), numbers)
    words.append(Words(f"b² − 4 a c = {rounded(discriminant)}{_sign_of(discriminant)}", "", 2))
    said = "t₀ = −b − √(b² − 4 a c)", "t₁ = −b + √(b² − 4 a c)"
    words += _two_roots(said, " / 2a", 2 * a, b, discriminant, line, numbers)
    return Board(tuple(words), numbers)


def _without_square(b: Fraction, c: Fraction, line: Line, numbers: dict[str, float]) -> list[Block]:
    if b:
        numbers["t"] = as_float(-c / b)
        behind = "" if line.holds(-c / b) else f": not within {line.interval}"
        return [Words(f"a = 0: t = −c / b = {rounded(-c / b)}{behind}", "", 2)]
    where = "inside" if c < 0 else ("on the surface" if not c else "outside")
    left_out = "docs/theory.md, section 14: the case that the notes leave out"
    return [Words(f"a = b = 0: the ray is {where} all along, as c = {rounded(c)}", left_out, 2)]


def is_circular_cylinder(surface: QuadricSurface) -> bool:
    """Is it X² + Y² = r² in own coordinates of unit axes?"""
    (x, y, z), linear = surface.squares, surface.linear
    if not (x == y and float(x) > 0 and not float(z)) or any(map(float, linear)) or not float(surface.constant) > 0:
        return False
    rows = [[float(value) for value in row] for row in surface.rows]
    return all(
        abs(sum(p * q for p, q in zip(rows[i], rows[j], strict=True)) - (i == j)) < 1e-14
        for i in range(3)
        for j in range(3)
    )


def cylinder_board(surface: QuadricSurface, line: Line) -> Board:
    """Equations (5) to (10) of Sasaki 2021, in the local frame of the cylinder."""
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
        Words(f"p₁ = {vector(start)}, r = {rounded(root(radius_squared))}", sources.CYLINDER, 2),
        Words(f"(2) R_X = {vector(rows[0])}, R_Y = {vector(rows[1])}, R_Z = {vector(rows[2])}", "", 2),
        Words(f"(5) (X₀, Y₀, Z₀) = {vector((x, y, z))}, (U, V, W) = {vector((u, v, w))}", "", 2),
        Words(
            f"(7) (U² + V²) t² + 2 (X₀U + Y₀V) t + X₀² + Y₀² − r² = 0: "
            f"{joined([(a, 't²'), (2 * b, 't'), (c, '')], told)} = 0", "", 2,
        ),
        Words(f"(8) D = {rounded(discriminant)}{_sign_of(discriminant) if a else ''}", "", 2),
    ]  # fmt: skip
    if not a:
        where = "inside" if c < 0 else ("on the wall" if not c else "outside")
        words.append(Words(f"U = V = 0: the ray runs along the axis, {where} all along", "", 2))
        return Board(tuple(words), numbers)
    if discriminant <= 0:
        touching = [Words("read as invisible: no crossing", sources.TOUCH, 2)] if not discriminant else []
        return Board((*words, *touching), numbers)
    for sign, name in ((-1, "t₋"), (1, "t₊")):
        t = (-b + sign * root(discriminant)) / a
        at = [x + t * u, y + t * v, z + t * w]
        angle = math.degrees(math.atan2(as_float(at[1]), as_float(at[0])))
        numbers |= {"t-" if sign < 0 else "t+": as_float(t), "Z-" if sign < 0 else "Z+": as_float(at[2])}
        numbers["angle-" if sign < 0 else "angle+"] = angle
        words.append(Words(f"(9) {name} = {rounded(t)}; (10) (X, Y, Z) = {vector(at)}; (12) θ = {angle:.6g}°", "", 2))
    return Board(tuple(words), numbers)
