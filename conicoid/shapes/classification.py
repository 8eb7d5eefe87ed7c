"""What a quadric can be, and how that is told."""

from __future__ import annotations

from dataclasses import dataclass

from .other_names import hinted
from .vector import Vector

SPHERE, ELLIPSOID = "sphere", "ellipsoid"
ONE_SHEET, TWO_SHEETS = "one-sheet hyperboloid", "two-sheet hyperboloid"
CONE = "elliptic cone"
BOWL, SADDLE = "elliptic paraboloid", "hyperbolic paraboloid"
TUBE, TROUGHS, TROUGH = "elliptic cylinder", "hyperbolic cylinder", "parabolic cylinder"
CROSSING, PARALLEL, DOUBLE = "crossing planes", "parallel planes", "double plane"
LINE, POINT, PLANE, EMPTY = "line", "point", "plane", "empty"

KINDS = (
    SPHERE, ELLIPSOID, ONE_SHEET, TWO_SHEETS, CONE, BOWL, SADDLE, TUBE, TROUGHS, TROUGH,
    CROSSING, PARALLEL, DOUBLE, LINE, POINT, PLANE, EMPTY,
)  # fmt: skip
DEGENERATE = KINDS[KINDS.index(CROSSING) :]

# (signs of A, signs of the 4 × 4 matrix), positive first, up to the sign of both
BY_SIGNS = {
    ((3, 0), (3, 1)): ELLIPSOID, ((3, 0), (4, 0)): EMPTY, ((3, 0), (3, 0)): POINT,
    ((2, 1), (2, 2)): ONE_SHEET, ((2, 1), (3, 1)): TWO_SHEETS, ((2, 1), (2, 1)): CONE,
    ((2, 0), (3, 1)): BOWL, ((2, 0), (2, 1)): TUBE, ((2, 0), (3, 0)): EMPTY, ((2, 0), (2, 0)): LINE,
    ((1, 1), (2, 2)): SADDLE, ((1, 1), (2, 1)): TROUGHS, ((1, 1), (1, 2)): TROUGHS, ((1, 1), (1, 1)): CROSSING,
    ((1, 0), (2, 1)): TROUGH, ((1, 0), (1, 1)): PARALLEL, ((1, 0), (2, 0)): EMPTY, ((1, 0), (1, 0)): DOUBLE,
    ((0, 0), (1, 1)): PLANE,
}  # fmt: skip

# Where the polynomial is negative after the sign has been made that of the table above, and where it is positive
SIDES = {
    SPHERE: ("within", "outside"), ELLIPSOID: ("within", "outside"),
    ONE_SHEET: ("around the last axis", "away from the last axis"),
    TWO_SHEETS: ("within the two sheets", "between the two sheets"),
    CONE: ("within the nappes", "outside the nappes"),
    BOWL: ("within the bowl", "outside the bowl"),
    SADDLE: ("where the last axis points", "where the last axis points"),
    TUBE: ("within", "outside"), TROUGH: ("within", "outside"),
    TROUGHS: ("between the branches", "within the branches"),
    CROSSING: ("the two wedges about the first axis", "the two wedges about the first axis"),
    PARALLEL: ("between the planes", "beyond the planes"),
    DOUBLE: ("the plane alone", "all of space"), LINE: ("the line alone", "all of space"),
    POINT: ("the point alone", "all of space"), EMPTY: ("nothing", "all of space"),
    PLANE: ("where the last axis points", "where the last axis points"),
}  # fmt: skip


@hinted
@dataclass(frozen=True)
class Classification:
    """A quadric by its kind, its place and its measures; what is not exact is rounded once.

    kind        one of `KINDS`; degenerate are crossing planes and all that follow them there
    inside      which side is inside, in words
    center      the center; of a cylinder the point of its axis (of a pair of planes, of a line: of what is common
                or midway) nearest to the origin; of a cone the apex; of paraboloids the vertex, of the parabolic
                cylinder and the plane the point of the line of vertices or of the plane nearest to the origin;
                None where there is no point at all
    axes        three unit vectors, right-handed. Last stands the axis that is unlike the others: of hyperboloids and
                cones the one with the other sign, of cylinders the ruling, of paraboloids the direction in which they
                open (of the parabolic cylinder the second), of a body of revolution its axis; a plane has its normal
                there, towards the inside. First stand the longest semi-axis, the real one of a hyperbolic cylinder,
                the normal of parallel planes
    semi_axes   along the first axes: half lengths, imaginary ones too; of paraboloids and the parabolic cylinder the
                radii of curvature at the vertex; of a cone the half-axes of the section at distance 1 from the apex,
                of crossing planes the slope; of parallel planes half their distance
    revolution  is it a surface of revolution?
    """

    kind: str
    inside: str
    center: Vector | None = None
    axes: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    semi_axes: tuple[float, ...] = ()
    revolution: bool = False

    @property
    def degenerate(self) -> bool:
        """Planes, lines, points and nothing."""
        return self.kind in DEGENERATE

    def __str__(self) -> str:
        words = [f"{self.kind} of revolution" if self.revolution and self.kind != SPHERE else self.kind]
        if self.center is not None:
            words.append(f"{_CENTERS.get(self.kind, 'center')} {_shown(self.center)}")
        if self.semi_axes:
            words.append(f"{_MEASURES.get(self.kind, 'semi-axes')} {', '.join(_number(a) for a in self.semi_axes)}")
        if self.center is not None and self.kind not in (SPHERE, POINT):
            words.append(f"axes {' '.join(_shown(axis) for axis in self.axes)}")
        return "; ".join([*words, f"inside: {self.inside}"])


_CENTERS = {CONE: "apex", BOWL: "vertex", SADDLE: "vertex", TROUGH: "vertex", POINT: "at"} | dict.fromkeys(
    (TUBE, TROUGHS, LINE, PLANE, DOUBLE, PARALLEL, CROSSING), "through"
)
_MEASURES = dict.fromkeys((BOWL, SADDLE, TROUGH), "radii of curvature") | {
    CONE: "half-axes at distance 1",
    CROSSING: "slope",
    PARALLEL: "half distance",
    SPHERE: "radius",
}


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")


def _shown(point: Vector) -> str:
    return f"({', '.join(_number(c) for c in point)})"
