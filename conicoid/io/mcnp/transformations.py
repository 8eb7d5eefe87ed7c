"""Vectors and matrices of fractions, and MCNP's transformations (TR and TRCL).

`parse_transformation` reads the entries of a transformation and completes its matrix; `transform_surface` moves a
surface. Lengths are in cm, angles in degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property

from ..._util.records import dataclass
from ...numerics.portable_math import portable_sqrt, sin_cos_degrees
from ...numerics.rational import cross, dot3
from ..openmc.placement import (
    NO_ROTATION,
    ORIGIN,
    CellRotation,
    Point,
    Rows,
    UniversePlacement,
    invert_rows,
    rotation_by_matrix,
    rotation_error,
)
from ..openmc.surfaces import TERMS, ConeSurface, FlatSurface, GeneralSurface, RoundSurface, Surface


def to_point(values: Sequence[Fraction]) -> Point:
    """Return three values as a point."""
    x, y, z = values
    return x, y, z


def add_scaled(u: Point, v: Point, times: Fraction | int = 1) -> Point:
    """Return u + times v."""
    return u[0] + times * v[0], u[1] + times * v[1], u[2] + times * v[2]


def scale_vector(u: Point, times: Fraction | int) -> Point:
    """Return times u."""
    return u[0] * times, u[1] * times, u[2] * times


def apply_rows(rows: Rows, u: Point) -> Point:
    """Return the product of a matrix and a vector."""
    return dot3(rows[0], u), dot3(rows[1], u), dot3(rows[2], u)


def transpose(rows: Rows) -> Rows:
    """Return the transposed matrix."""
    a, b, c = rows
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])


def multiply_rows(a: Rows, b: Rows) -> Rows:
    """Return the product of two matrices."""
    x, y, z = (apply_rows(transpose(b), row) for row in a)
    return x, y, z


def outer_product(u: Point) -> Rows:
    """Return u uᵀ."""
    return scale_vector(u, u[0]), scale_vector(u, u[1]), scale_vector(u, u[2])


def add_rows(a: Rows, b: Rows, times: Fraction | int = 1) -> Rows:
    """Return a + times b."""
    return add_scaled(a[0], b[0], times), add_scaled(a[1], b[1], times), add_scaled(a[2], b[2], times)


def scale_rows(a: Rows, factor: Fraction | int) -> Rows:
    """Return factor a."""
    return scale_vector(a[0], factor), scale_vector(a[1], factor), scale_vector(a[2], factor)


_ONE, _ZERO = Fraction(1), Fraction(0)
IDENTITY: Rows = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


def dual_vectors(vectors: Sequence[Point]) -> list[Point]:
    """Return the dual basis of one to three vectors v: vectors w in their span with v[i]·w[j] = 1 if i = j, else 0.

    Raise ValueError if the vectors are linearly dependent.
    """
    duals = []
    for i, vector in enumerate(vectors):
        rest = [other for j, other in enumerate(vectors) if j != i]
        # Subtract the components along the other vectors: w must be perpendicular to all of them.
        if not rest:
            across = vector
        elif len(rest) == 1:
            across = add_scaled(vector, rest[0], -dot3(vector, rest[0]) / dot3(rest[0], rest[0]))
        else:
            across = cross(*rest)
        size = dot3(across, vector)
        if not size:
            raise ValueError("directions depend on each other")
        duals.append(scale_vector(across, 1 / size))
    return duals


# Transformations: an auxiliary coordinate system in the main one, and surfaces in it

MAX_ROTATION_ERROR = Fraction(1, 100)
"""Largest distance of a matrix from a rotation (`rotation_error`)."""


@dataclass(frozen=True)
class FrameChange:
    """The change x' = rows (x - origin) from main to auxiliary coordinates.

    `rows` are the auxiliary axes and `origin` is the auxiliary origin, both in main coordinates.
    """

    origin: Point = ORIGIN
    rows: Rows = IDENTITY
    is_free: bool = False  # the file defines one axis; the other two may be turned about it

    @cached_property
    def rotation(self) -> CellRotation:
        """The rotation of content from the auxiliary to the main system."""
        rotation = NO_ROTATION if self.rows == IDENTITY else rotation_by_matrix(self.rows)
        assert rotation is not None
        return rotation

    @property
    def skew(self) -> float:
        """The distance of the matrix from a rotation."""
        return rotation_error(self.rows)

    def __hash__(self) -> int:
        # One point is enough for a hash; equality compares all fields.
        return hash(self.origin)


def parse_transformation(values: Sequence[Fraction | None], degrees: bool) -> FrameChange:
    """Return the transformation of a TR card.

    Parameters
    ----------
    values
        Displacement (3), matrix (9 entries or fewer) and m; None for skipped entries. With m = -1 the displacement is
        that of the main origin in the auxiliary system.
    degrees
        Whether the matrix holds angles in degrees instead of cosines.

    Raises
    ------
    ValueError
        The entries are too many, do not complete a matrix, or the matrix is no rotation.

    """
    entries = [*values]
    if not 1 <= len(entries) <= 13:
        raise ValueError(f"a transformation has 1 to 13 numbers, got {len(entries)}")
    # m is the thirteenth entry, so all nine of the matrix stand before it
    flip = len(entries) == 13 and entries.pop() == -1
    if len(values) == 13 and not flip and values[-1] not in (1, None):
        raise ValueError("the last of 13 numbers of a transformation must be 1 or -1")
    # Entries that are skipped have the default 0
    shift = to_point([value or Fraction(0) for value in (*entries, None, None, None)[:3]])
    rest = [None if value is None else _cosine(value) if degrees else value for value in entries[3:]]
    rows, is_free = _complete_rows([*rest, *[None] * (9 - len(rest))])
    back = invert_rows(rows)
    # Cosines of three digits are off by a thousandth; a matrix farther off is no rotation, and shears bodies
    if back is None or rotation_error(rows) > MAX_ROTATION_ERROR:
        raise ValueError(
            f"the matrix of a transformation must be a rotation, it is {rotation_error(rows):.2g} away from one"
        )
    return FrameChange(scale_vector(apply_rows(back, shift), -1) if flip else shift, rows, is_free)


def _cosine(angle: Fraction) -> Fraction:
    """Return the cosine of an angle in degrees, exact where it is 0, ±1/2 or ±1."""
    # Fractions at these angles keep planes of hexagons and boxes where other planes of the deck are
    if angle % 60 == 0 or angle % 90 == 0:
        halves = {0: 2, 60: 1, 90: 0, 120: -1, 180: -2, 240: -1, 270: 0, 300: 1}
        return Fraction(halves[int(angle % 360)], 2)
    return Fraction(sin_cos_degrees(angle)[1])


def _complete_rows(cosines: list[Fraction | None]) -> tuple[Rows, bool]:
    """Return all nine cosines from 9, 6, 5, 3 or none, and True if MCNP is free to choose some of them."""
    rows = [cosines[0:3], cosines[3:6], cosines[6:9]]
    columns = [cosines[i::3] for i in range(3)]
    count = sum(value is not None for value in cosines)
    if count == 0:
        return IDENTITY, False
    if count == 9:
        return (to_point(rows[0]), to_point(rows[1]), to_point(rows[2])), False  # type: ignore[arg-type]
    whole_rows = [i for i in range(3) if None not in rows[i]]
    whole_columns = [i for i in range(3) if None not in columns[i]]
    if count == 6 and len(whole_rows) == 2:
        return _complete_two_rows(rows, whole_rows), False
    if count == 6 and len(whole_columns) == 2:
        return transpose(_complete_two_rows(columns, whole_columns)), False
    if count == 5 and len(whole_rows) == len(whole_columns) == 1:
        return _complete_cross(cosines, whole_rows[0], whole_columns[0]), False
    if count == 3 and whole_rows:
        return _complete_one_row(rows, whole_rows[0]), True
    if count == 3 and whole_columns:
        return transpose(_complete_one_row(columns, whole_columns[0])), True
    raise ValueError(
        "the matrix of a transformation is given by 9, 6, 5, 3 or none of its numbers, the 6 in two rows or columns, "
        f"the 5 in a row and a column, the 3 in a row or column; got {count} otherwise"
    )


def _complete_two_rows(lines: list[list[Fraction | None]], row_indices: list[int]) -> Rows:
    """Return the matrix whose third row is across the two known ones."""
    i, j = row_indices
    third = 3 - i - j
    a, b = to_point(lines[i]), to_point(lines[j])  # type: ignore[arg-type]
    # A right-handed frame, whichever row is missing
    across = cross(a, b) if (j - i) % 3 == 1 else cross(b, a)
    rows = {i: a, j: b, third: across}
    return rows[0], rows[1], rows[2]


def _complete_one_row(lines: list[list[Fraction | None]], row_index: int) -> Rows:
    """Return a matrix with two rows across the known one, the first of them as near to an axis as possible."""
    a = to_point(lines[row_index])  # type: ignore[arg-type]
    size = Fraction(portable_sqrt(dot3(a, a)))
    if not size:
        raise ValueError("an axis of a transformation must not be zero")
    # The axis most nearly perpendicular to `a`; of equal ones the first, so that the choice is defined.
    least = min(range(3), key=lambda i: (abs(a[i]), i))
    b = add_scaled(IDENTITY[least], a, -a[least] / dot3(a, a))
    b = scale_vector(b, 1 / Fraction(portable_sqrt(dot3(b, b))))
    rows = {row_index: a, (row_index + 1) % 3: b, (row_index + 2) % 3: scale_vector(cross(a, b), 1 / size)}
    return rows[0], rows[1], rows[2]


def _complete_cross(cosines: list[Fraction | None], row: int, column: int) -> Rows:
    """Return a rotation from one row and one column, which meet in c.

    The other four entries follow from the cofactors: each entry of a rotation equals its cofactor.
    """
    # The known entries in cyclic order, so that c comes first: row c a b, column c p q.
    places = ((0, 0), (0, 1), (0, 2), (1, 0), (2, 0))
    at = [cosines[3 * ((row + i) % 3) + (column + j) % 3] for i, j in places]
    c, a, b, p, q = (value or Fraction(0) for value in at)
    s = a * a + b * b
    if not s:
        raise ValueError("the row and the column of a transformation must not lie along each other: give more numbers")
    block = (
        (c, a, b),
        (p, (-a * c * p - b * q) / s, (-b * c * p + a * q) / s),
        (q, (-a * c * q + b * p) / s, (-b * c * q - a * p) / s),
    )
    x, y, z = (to_point([block[(i - row) % 3][(j - column) % 3] for j in range(3)]) for i in range(3))
    return x, y, z


def transform_surface(surface: Surface, change: FrameChange) -> Surface:
    """Return a surface of the auxiliary system in the main system."""
    if change.rotation.motion.is_identity:  # quarter turns keep the kind of every surface
        return surface.placed(UniversePlacement(change.rotation.turn, change.origin))
    rows = change.rows
    # A plane or a ball needs no general quadric, and stays comparable with others of its kind
    if isinstance(surface, FlatSurface):
        normal = apply_rows(transpose(rows), surface.normal)
        return FlatSurface(normal, surface.offset + dot3(normal, change.origin))
    back = invert_rows(rows)
    assert back is not None
    if isinstance(surface, RoundSurface) and surface.axis is None:  # a sphere stays one
        return RoundSurface(None, add_scaled(change.origin, apply_rows(back, surface.center)), surface.radius)
    # With x' = rows (x - origin), f(x') has the matrix rowsᵀ M rows about the moved point.
    matrix, linear, constant, shift = quadric_parts(surface)
    turned = multiply_rows(transpose(rows), multiply_rows(matrix, rows))
    place = add_scaled(change.origin, apply_rows(back, shift))
    return shift_quadric(turned, apply_rows(transpose(rows), linear), constant, place)


def quadric_parts(surface: RoundSurface | ConeSurface | GeneralSurface) -> tuple[Rows, Point, Fraction, Point]:
    """Return matrix, linear part and constant of a quadric about a point, and the point."""
    if isinstance(surface, GeneralSurface):
        f = dict(zip(TERMS, surface.coefficients, strict=True))
        xy, yz, xz = f["xy"] / 2, f["yz"] / 2, f["xz"] / 2
        matrix = ((f["xx"], xy, xz), (xy, f["yy"], yz), (xz, yz, f["zz"]))
        return matrix, (f["x"], f["y"], f["z"]), f["constant"], surface.shift
    along = -surface.square if isinstance(surface, ConeSurface) else Fraction(0)
    x, y, z = (scale_vector(IDENTITY[i], along if i == surface.axis else 1) for i in range(3))
    if isinstance(surface, ConeSurface):
        return (x, y, z), ORIGIN, Fraction(0), surface.apex
    return (x, y, z), ORIGIN, -(surface.radius**2), surface.center


def shift_quadric(matrix: Rows, linear: Point, constant: Fraction, shift: Point = ORIGIN) -> GeneralSurface:
    """Return the quadric (x - shift)ᵀ matrix (x - shift) + linear·(x - shift) + constant."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return GeneralSurface((xx, yy, zz, 2 * xy, 2 * yz, 2 * xz, *linear, constant), shift)
