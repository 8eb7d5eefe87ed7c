"""Jacobians of the walls of a shape by its numbers, from its own formulas evaluated with dual numbers.

A `Dual` is a `BigFloat` of 3000 bits with its derivatives, as floats, by the parameters that it depends on (forward
mode: Wengert, A simple automatic derivative evaluation program, CACM 7, 1964). Comparisons use the value alone. A zero
with a derivative is true, so that a formula does not skip a term that is zero now but changes.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NoReturn

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.bounds.support import plane_through, plane_uv
from ...geometry.bulk import Bulk
from ...geometry.cell import UV, Face, PolygonSheet, faces_of_tree, transform_uv
from ...geometry.facets import newell_normal
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Extrusion, Mesh, Polyhedron
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution, SphereSection
from ...geometry.shape import Boolean, ClippedSheet, PrimitiveSheet, PrimitiveSolid, Shape
from ...geometry.sheets import Wall as OpenWall
from ...geometry.surface import PlaneSurface, QuadricSurface, Surface
from ...geometry.transform import IDENTITY_MOTION, AxisFrame, Motion, Translate
from ...numerics import bigfloat, bigfloat as ex
from ...numerics.bigfloat import BigFloat, Symbol, exact
from . import parameters
from .quadric_form import FORM, MAP, PAIRS, form_of

Slopes = dict[int, float]
"""Number of a parameter -> derivative by it. Missing derivatives are zero."""

_RADIAN = math.pi / 180


class Dual(BigFloat, Symbol):
    """A number with its derivatives by parameters."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: BigFloat, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    @property
    def _unseen(self) -> NoReturn:
        """Refuse access to the digits: they have no derivative."""
        raise TypeError("a number with derivatives does not expose its digits")

    # The fields of `BigFloat`. A formula that read them would lose the derivatives.
    mantissa = exponent = off = _unseen

    def __add__(self, other: Any) -> Any:
        return _sum(self, other, 1.0)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return _sum(self, other, -1.0)

    def __rsub__(self, other: Any) -> Any:
        return _sum(-self, other, 1.0)

    def __neg__(self) -> Dual:
        return Dual(-self.value, {key: -slope for key, slope in self.slopes.items()})

    def __abs__(self) -> Dual:
        return -self if self.value < 0 else self

    def __mul__(self, other: Any) -> Any:
        if not is_finite(other):  # an infinite float has no derivative, and its product has none
            return float(self.value) * other
        value = value_of(other)
        return _depends_on(self.value * value, (self, float(value)), (other, float(self.value)))

    __rmul__ = __mul__

    def __pow__(self, power: int) -> Any:
        if power != 2:
            raise TypeError("only squares have derivatives here")
        return self * self

    def __truediv__(self, other: Any) -> Any:
        return _quotient(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _quotient(other, self)

    def __bool__(self) -> bool:
        return bool(self.value) or any(self.slopes.values())

    def __eq__(self, other: object) -> bool:
        if isinstance(other, float) and not math.isfinite(other):
            return False
        # The difference is false only if its value and all its derivatives are zero.
        return not (self - other)

    def __lt__(self, other: Any) -> bool:
        return _compare_values(operator.lt, self, other)

    def __le__(self, other: Any) -> bool:
        return _compare_values(operator.le, self, other)

    def __gt__(self, other: Any) -> bool:
        return _compare_values(operator.gt, self, other)

    def __ge__(self, other: Any) -> bool:
        return _compare_values(operator.ge, self, other)

    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> NoReturn:
        raise TypeError("a number with derivatives does not convert to float: use ex.rounded")

    def __repr__(self) -> str:
        return f"Slope({float(self.value)!r}, {self.slopes})"

    def exact(self) -> Dual:
        return self

    def settled(self) -> Dual:
        """Return the number with its value settled (`bigfloat.settled`) and the same derivatives."""
        return Dual(bigfloat.settled(self.value), self.slopes)

    def rounded(self) -> Dual:
        """Return the number itself: the step of rounding has no derivative."""
        return self

    def root(self) -> Any:
        """Return the square root. At zero its derivatives are NaN where those of the number are not 0."""
        value = bigfloat.sqrt(self.value)
        return _depends_on(value, (self, 0.5 / float(value))) if value else Dual(value, _unknown(self.slopes))

    def larger(self, other: Any, first: bool = True) -> Any:
        """Return the larger of two numbers.

        If the values are equal, the derivative by each parameter that moves them apart is NaN: either may become the
        larger.
        """
        if not is_finite(other) or self.value != value_of(other):
            return max(self, other)
        keys = self.slopes.keys() | slopes_of(other).keys()
        differing = [key for key in keys if self.slopes.get(key, 0.0) != slopes_of(other).get(key, 0.0)]
        return Dual(self.value, {**self.slopes, **dict.fromkeys(differing, math.nan)})

    def constant(self) -> Dual:
        return Dual(self.value, {})

    def sine_cosine(self) -> tuple[Any, Any]:
        """Return (sine, cosine) of the number as an angle in degrees."""
        s, c = bigfloat.sin_cos_degrees(float(self.value))
        return _depends_on(s, (self, _RADIAN * float(c))), _depends_on(c, (self, -_RADIAN * float(s)))


def value_of(x: Any) -> BigFloat:
    """Return the value of a number without its derivatives."""
    return x.value if isinstance(x, Dual) else exact(x)


def slopes_of(x: Any) -> Slopes:
    """Return the derivatives of a number; none for a plain one."""
    return x.slopes if isinstance(x, Dual) else {}


def is_finite(x: Any) -> bool:
    """Return whether x is anything but a float that is not finite."""
    return not isinstance(x, float) or math.isfinite(x)


def _depends_on(value: BigFloat, *parts: tuple[Any, float]) -> Dual:
    """Return a number whose derivatives follow by the chain rule from (number, partial derivative) pairs."""
    slopes: Slopes = {}
    for part, factor in parts:
        for key, slope in slopes_of(part).items():
            slopes[key] = slopes.get(key, 0.0) + factor * slope
    return Dual(value, slopes)


def _sum(a: Dual, b: Any, sign: float) -> Any:
    if not is_finite(b):
        return sign * b
    value = value_of(b)
    return _depends_on(a.value + (value if sign > 0 else -value), (a, 1.0), (b, sign))


def _quotient(a: Any, b: Any) -> Any:
    if not is_finite(b):
        return 0.0
    # d(a / b) = da / b - (a / b) db / b.
    above, below = value_of(a), value_of(b)
    value = above / below
    inverse = 1.0 / float(below)
    return _depends_on(value, (a, inverse), (b, -float(value) * inverse))


def _compare_values(how: Callable[[Any, Any], bool], a: Dual, b: Any) -> bool:
    """Compare by the values; an infinite float lies beyond all of them."""
    # Any finite value compares with an infinite float like 0.
    return how(0.0, b) if not is_finite(b) else how(a.value, value_of(b))


def _unknown(slopes: Slopes) -> Slopes:
    """Return NaN for each derivative that is not zero: no derivative exists."""
    return dict.fromkeys((key for key, slope in slopes.items() if slope), math.nan)


# Jacobians of the walls of a shape: the derivatives of each face's form and uv map by the numbers of the shape.
#
# They come from the shape's own formulas, evaluated with `Dual` numbers. A few primitives use other formulas here,
# since theirs read their numbers in ways that have no derivatives. A general quadric, for example, is stored about its
# principal axes, which come from eigenvectors; its derivatives do not need them. NaN marks a derivative that is not
# known or does not exist.


@dataclass(frozen=True)
class FormSurface:
    """A surface that is given by its form alone, about an anchor."""

    anchor: tuple[float, ...]
    form: list[Any]


def complete_primitive(shape: Any, slopes: Any) -> Any:
    """Return a primitive of duals, completed by the fields that its formulas cannot compute from duals."""
    if isinstance(shape, Polyhedron):
        vars(slopes)["_own_bounds"] = shape._own_bounds  # they only place the anchors, which moves no plane
    elif isinstance(shape, Ellipsoid) and shape.coefficients is not None:
        object.__setattr__(slopes, "radii", tuple(1 / ex.sqrt(c) for c in slopes.coefficients))
    return slopes


def special_faces(shape: Any, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]] | None:
    """Return the faces of a primitive that has formulas of its own here, after a motion; None for other shapes."""
    if isinstance(shape, Polyhedron):
        return _faces_of_polyhedron(shape, slopes, motion)
    if isinstance(shape, Mesh | Extrusion):
        return _faces_of_mesh(shape, slopes, motion)
    if not isinstance(shape, Quadric):
        return None
    q, surface = slopes.symmetric, shape.surface
    if isinstance(surface, PlaneSurface):
        # f = 2 B·x + C is the plane with the normal 2 B and the offset -C.
        normal = (2 * q[0][3], 2 * q[1][3], 2 * q[2][3])
        plane = plane_through(normal, -q[3][3])
        return iter(
            [
                (
                    0,
                    plane.moved(motion),
                    transform_uv(without_uv_slopes(plane_uv(plane), _axis_jump_parameters(normal)), motion),
                )
            ]
        )
    own = tuple(ex.exact(a) for a in surface.anchor)
    anchor = tuple(float(value_of(a)) for a in motion.carried(own))  # type: ignore[arg-type]
    uv = transform_uv(_center_uv(q, own), motion)
    return iter([(0, FormSurface(anchor, _form(q, motion, anchor)), uv)])


def _form(q: Sequence[Sequence[Any]], motion: Motion, anchor: tuple[float, ...]) -> list[Any]:
    """Return the form about an anchor in the world: (x, 1) Q (x, 1) with x = back (anchor + r) + shift."""
    back, shift = motion.inverse
    at = ex.exact_row(anchor)
    start = [sum((back[i][k] * at[k] for k in range(3)), shift[i]) for i in range(3)]
    slope = [sum((q[i][k] * start[k] for k in range(3)), q[i][3]) for i in range(3)]
    half = [[sum((q[i][k] * back[k][j] for k in range(3)), ex.ZERO) for j in range(3)] for i in range(3)]
    second = [sum((back[k][i] * half[k][j] for k in range(3)), ex.ZERO) for i, j in PAIRS]
    first = [sum((back[k][i] * slope[k] for k in range(3)), ex.ZERO) for i in range(3)]
    return [*second, *first, sum((start[k] * (slope[k] + q[k][3]) for k in range(3)), q[3][3])]


def _center_uv(q: Sequence[Sequence[Any]], anchor: tuple[Any, ...]) -> UV:
    """Return the uv map about the center c, which moves by -A⁻¹ (dA c + db); NaN if the quadric has no center."""
    # The anchor is the center only if A is regular and the gradient vanishes there.
    a = np.array([[float(value_of(q[i][k])) for k in range(3)] for i in range(3)])
    keys = sorted({key for row in q for number in row for key in slopes_of(number)})
    moves = [dict.fromkeys(keys, math.nan) for _ in range(3)]
    residue = [sum((q[i][k] * anchor[k] for k in range(3)), q[i][3]) for i in range(3)]
    size = np.abs(a).max() * max(1.0, *(abs(float(value_of(c))) for c in anchor))
    if np.linalg.cond(a) < 1e12 and all(abs(float(value_of(r))) <= 1e-12 * size for r in residue):
        change = np.array([[slopes_of(r).get(key, 0.0) for key in keys] for r in residue])
        shifts = -np.linalg.solve(a, change)
        moves = [dict(zip(keys, row, strict=True)) for row in shifts.tolist()]
    center = tuple(Dual(ex.exact(c), move) for c, move in zip(anchor, moves, strict=True))
    upright = UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
    return transform_uv(upright, Motion((Translate(center),)))  # type: ignore[arg-type]


def _faces_of_polyhedron(shape: Polyhedron, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """Yield the faces of a polyhedron. The derivatives of uv are unknown: the maps refer to a point near the solid."""
    keys = {key for number in itertools.chain(slopes.offsets, *slopes.normals) for key in slopes_of(number)}
    for number, (own, moving) in enumerate(zip(shape.surfaces, slopes.surfaces, strict=True)):
        yield number, moving.moved(motion), transform_uv(without_uv_slopes(plane_uv(own), keys), motion)


def _faces_of_mesh(shape: Mesh | Extrusion, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """Yield the faces of a mesh or an extrusion: planes through their corners, whatever parts they bound.

    The derivative by a corner that bends the plane is not known: for a mesh's face of more than three corners, and for
    several faces in one plane.
    """
    _, _, corners, faces = slopes._boundary()
    for number, members in shape.planes():
        # Three corners fix a plane; if there are more, a corner that moves alone bends it.
        bends = len(members) > 1 or (isinstance(shape, Mesh) and len(faces[members[0]]) > 3)
        own = [corners[k] for k in faces[members[0]]]
        normal, coordinates = newell_normal(own), [c for face in members for k in faces[face] for c in corners[k]]
        offset = sum((a * b for a, b in zip(normal, own[0], strict=True)), ex.ZERO)
        keys = {key for c in coordinates for key in slopes_of(c)} if bends else set()
        unknown = dict.fromkeys(keys, math.nan)
        plane = plane_through(normal, Dual(value_of(offset), {**slopes_of(offset), **unknown}), corners[0])
        uv = without_uv_slopes(plane_uv(plane), _axis_jump_parameters(normal) | keys)
        yield number, plane.moved(motion), transform_uv(uv, motion)


def level_edge_plane(shape: Revolution, face: Face) -> Surface:
    """Return the surface that an edge of a profile sweeps. A level edge sweeps a plane.

    The plane has no derivative by the height of one end, which would make it a cone.
    """
    # An edge joins two consecutive corners of the profile.
    ends = shape.profile[face.number], shape.profile[(face.number + 1) % len(shape.profile)]
    if not isinstance(face.surface, PlaneSurface):
        return face.surface
    x, y, sense = face.surface.normal
    unknown = {key: math.nan for _, z in ends for key in slopes_of(z)}
    height = value_of(ends[0][1])
    return PlaneSurface((x, y, sense), Dual(height * ex.exact(sense), unknown), (0.0, 0.0, height))


def without_uv_slopes(uv: UV, keys: Iterable[int]) -> UV:
    """Return a map without derivatives of u, and on flat faces of v, by some parameters."""
    unknown = dict.fromkeys(keys, math.nan)
    rows = [(*row[:3], Dual(value_of(row[3]), {**slopes_of(row[3]), **unknown})) for row in uv.matrix[:2]]
    return UV(uv.angular, (*rows, uv.matrix[2])) if unknown else uv  # type: ignore[arg-type]


def jump_parameters(primitive: Any) -> set[int]:
    """Return the parameters by which u jumps.

    u counts from the coordinate axis that is least along the axis of the shape, and jumps where two are equally so.
    """
    frames = [step for step in primitive.placement.steps if isinstance(step, AxisFrame) and step.reference is None]
    axis = frames[0].axis if frames else getattr(primitive, "normal", None)
    return set() if axis is None else _axis_jump_parameters(axis)


def _axis_jump_parameters(axis: Sequence[Any]) -> set[int]:
    """Return the parameters that change a least coordinate of an axis where two are equal: either becomes the least."""
    sizes = [abs(float(value_of(c))) for c in axis]
    tied = [c for c, size in zip(axis, sizes, strict=True) if size == min(sizes)]
    return {key for c in tied for key, slope in slopes_of(c).items() if slope} if len(tied) > 1 else set()


# --- Walls with their derivatives
#
# They are cached with the shape, as its lowered form is: an edit of one body evaluates that body alone.


@dataclass(frozen=True)
class WallJacobian:
    """The form of a face with its derivatives. Parameters are numbered within the shape."""

    anchor: FloatArray
    form: FloatArray  # (10,) about the anchor
    ids: Any  # (p,) the parameters that it depends on
    forms: FloatArray  # (p, 10) derivatives of the form
    maps: FloatArray  # (p, 12) derivatives of the map to uv, three rows of four, which takes world coordinates


def walls_of(shape: Shape) -> dict[int, WallJacobian]:
    """Return the walls of a shape by face number. Raise TypeError if its formulas have no derivatives."""
    cached: dict[int, WallJacobian] | None = shape.cache.get("walls")
    if cached is None:
        duals = parameters.map_numbers(shape, _take_duals(itertools.count()), parameters.replace_unchecked, None)
        cached = shape.cache["walls"] = _walls(shape, duals)
    return cached


def walls_of_one(shape: Bulk, index: int) -> dict[int, WallJacobian]:
    """Return `walls_of` one body of a `Bulk` shape, with parameters numbered within the whole shape."""
    cached: dict[int, dict[int, WallJacobian]] = shape.cache.setdefault("walls of one", {})
    if index not in cached:
        single = shape.single(index)
        cached[index] = _walls(single, _dual_bulk_item(shape, index, single))
    return cached[index]


def _take_duals(counter: Iterator[int]) -> parameters.Take:
    """Return a function that makes each number a dual with derivative 1 by the next parameter."""
    return lambda _, value: Dual(ex.exact(value), {next(counter): 1.0})


def _dual_bulk_item(shape: Bulk, index: int, single: Any) -> Any:
    """Return one body of a `Bulk` shape with duals, numbered in the order of `parameters.values_of`."""
    # The index of the body's first number in each column; the motion follows the columns.
    firsts, at = {}, 0
    for name in shape.columns:
        width = getattr(shape, name).size // len(shape)
        firsts[name], at = at + width * index, at + width * len(shape)
    moves = parameters.map_motion(shape.motion, _take_duals(itertools.count(at)), parameters.replace_unchecked, None)
    leaves = single.operands if isinstance(single, Boolean) else (single,)
    duals = []
    for leaf, primitive in enumerate(leaves):
        names = [field.name for field in dataclasses.fields(primitive) if field.init and field.name != "motion"]
        changes: dict[str, Any] = {}
        # A constant is no parameter and stays a plain number.
        for name, part in zip(names, parameters.columns_of_leaf(shape, leaf), strict=False):
            if isinstance(part, str):
                take = _take_duals(itertools.count(firsts[part]))
                changes[name] = parameters.map_value(getattr(primitive, name), take, parameters.replace_unchecked)
        if primitive is single:
            changes["motion"] = moves
        duals.append(parameters.replace_unchecked(primitive, changes))
    return (
        duals[0]
        if leaves == (single,)
        else parameters.replace_unchecked(single, {"operands": tuple(duals), "motion": moves})
    )


def _walls(shape: Shape, slopes: Any) -> dict[int, WallJacobian]:
    """Evaluate the walls of all leaves; face numbers of a leaf follow those of the leaves before it."""
    walls: dict[int, WallJacobian] = {}
    for leaf, own, outer in _leaves(shape, slopes, IDENTITY_MOTION):
        # Faces of a leaf are numbered after those of the leaves before it.
        first = max(walls, default=-1) + 1
        try:
            faces = list(_faces(leaf, own, outer))
        except TypeError as error:
            reason = "its formulas look at the digits of their numbers (float, Fraction, math), ex.rational does not"
            raise TypeError(f"{type(leaf).__name__}: it has no derivatives, as {reason}: {error}") from error
        for number, surface, uv in faces:
            walls[first + number] = _wall(surface, uv)
    return dict(sorted(walls.items()))


def _leaves(shape: Any, slopes: Any, outer: Motion) -> Iterator[tuple[Any, Any, Motion]]:
    """Yield (primitive, the same with duals, outer motion) from left to right.

    The outer motion is the one that follows the primitive's own motion.
    """
    # A stack of its own, so that deep Booleans do not exhaust the recursion of Python.
    waiting = [(shape, slopes, outer)]
    while waiting:
        one, own, after = waiting.pop()
        if isinstance(one, ClippedSheet):
            waiting.append((one.base, own.base, own.motion.then(after)))
        elif isinstance(one, Boolean):
            inner = own.motion.then(after)
            # Operands are pushed in reverse, so that the leftmost comes first.
            waiting += [(a, b, inner) for a, b in zip(one.operands[::-1], own.operands[::-1], strict=True)]
        else:
            yield one, own, after


def _faces(shape: Any, slopes: Any, outer: Motion) -> Iterator[tuple[int, Surface, UV]]:
    """Yield (number, surface, uv map) of the faces of a primitive, in the world."""
    primitive = complete_primitive(shape, slopes)
    if isinstance(primitive, OpenWall):  # a cut bounds the wall but moves no point of it
        for number, surface, uv in _faces(shape.solid, primitive.solid, primitive.motion.then(outer)):
            if number == primitive.face:
                yield 0, surface, uv
        return
    motion, jumping = primitive.under(outer), jump_parameters(primitive)
    if isinstance(primitive, PrimitiveSheet):
        sheet = primitive.sheet(motion)
        surface = sheet.plane if isinstance(sheet, PolygonSheet) else sheet.surface
        yield 0, surface, without_uv_slopes(sheet.uv, jumping)
        return
    if not isinstance(primitive, PrimitiveSolid):
        raise TypeError(f"{type(shape).__name__} has no derivatives: it is not a primitive")
    special = special_faces(shape, primitive, motion)
    if special is not None:
        yield from special
        return
    faces: dict[int, Face] = {}
    for face in faces_of_tree(primitive.tree()):
        faces.setdefault(face.number, face)
    for _, face in sorted(faces.items()):
        if isinstance(primitive, Revolution) and face.number < len(primitive.profile):
            surface = level_edge_plane(primitive, face)
        else:
            surface = _angle_face_surface(primitive, face)
        # Quadrics move their rows; `moved` would treat balls as a special case
        yield face.number, surface.moved_rows(motion), transform_uv(without_uv_slopes(face.uv, jumping), motion)


def _angle_face_surface(primitive: Any, face: Face) -> Surface:
    """Return the surface of a face, without derivatives by angles that change its kind or move only a part of it.

    A polar angle of 90 degrees gives a plane, which a change turns into a cone. Half a turn has one plane for both of
    its walls, and two polar angles may have one cone: each angle moves only one half of these.
    """
    surface = face.surface
    if isinstance(primitive, SphereSection) and face.number in (2, 3):
        if isinstance(surface, PlaneSurface):
            return _without_slopes(surface, slopes_of(primitive.polar[face.number - 2]))
        return (
            _without_slopes(surface, [key for angle in primitive.polar for key in slopes_of(angle)])
            if primitive.has_one_cone
            else surface
        )
    angles = getattr(primitive, "start_angle", None), getattr(primitive, "end_angle", None)
    if not isinstance(surface, PlaneSurface) or not all(isinstance(angle, Dual) for angle in angles):
        return surface
    normal_keys = {key for number in surface.normal[:2] for key in slopes_of(number)}
    first, last = (value_of(angle) for angle in angles)
    if not normal_keys & set(slopes_of(angles[0])) or float(last - first) != 180:
        return surface
    return _without_slopes(surface, [key for angle in angles for key in slopes_of(angle)])


def _without_slopes(surface: Surface, keys: Iterable[int]) -> Surface:
    """Return a surface whose derivatives by some parameters are NaN."""
    unknown = dict.fromkeys(keys, math.nan)
    numbers = surface.normal if isinstance(surface, PlaneSurface) else surface.squares
    x, y, z = (Dual(value_of(c), {**slopes_of(c), **unknown}) for c in numbers)
    if isinstance(surface, PlaneSurface):
        return dataclasses.replace(surface, normal=(x, y, z))
    return dataclasses.replace(surface, squares=(x, y, z))


def _wall(surface: Surface | Any, uv: UV) -> WallJacobian:
    """Convert a face to floats, with a row of derivatives for each parameter that moves it."""
    anchor = [float(value_of(a)) for a in surface.anchor]
    form = form_of(surface, anchor) if isinstance(surface, (PlaneSurface, QuadricSurface)) else surface.form
    numbers = [*form, *(number for row in uv.matrix for number in row)]
    # Derivatives that are 0 get no row; NaN is not 0 and gets one.
    ids = sorted({key for number in numbers for key, slope in slopes_of(number).items() if slope})
    table = np.zeros((len(ids), FORM + MAP))
    place = {key: row for row, key in enumerate(ids)}
    for column, number in enumerate(numbers):
        for key, slope in slopes_of(number).items():
            if key in place:
                table[place[key], column] = slope
    value = np.array([float(value_of(number)) for number in form])
    return WallJacobian(
        np.array(anchor), value, np.array(ids, np.int64), table[:, :FORM].copy(), table[:, FORM:].copy()
    )
