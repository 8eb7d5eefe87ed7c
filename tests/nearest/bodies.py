"""Bodies for tests of distances, each in two forms: as shapes, and as fields of the reference, in extended precision."""

from fractions import Fraction

import numpy as np

import conicoid as co

from ..reference.forms import PAIRS
from ..reference.items import Item, combined
from ..reference.random_items import axis, joined, pick, plain
from ..reference.solids import body, forms_of


def extended(number):
    """Return a number of the reference in extended precision."""
    exact = Fraction(int(number.fraction.p), int(number.fraction.q))
    return np.longdouble(float(exact)) + np.longdouble(float(exact - Fraction(float(exact))))


def polynomial(form):
    """Return (A, b, c) of x·A x + b·x + c."""
    matrix = np.zeros((4, 4), np.longdouble)
    for (i, j), k in zip(PAIRS, form.k, strict=True):
        matrix[i, j] = matrix[j, i] = extended(k) / (1 if i == j else 2)
    return matrix[:3, :3], 2 * matrix[:3, 3], matrix[3, 3]


class Field:
    """A formula of the reference in extended precision, negative inside. Values are not distances, and of flush walls
    only the sign counts.
    """

    def __init__(self, formula):
        self.formula, self.terms = formula, {id(form): polynomial(form) for form in forms_of(formula)}

    def surfaces(self):
        """Return (A, b, c) of every surface."""
        return [*self.terms.values()]

    def __call__(self, p, formula=None):
        kind, parts = formula or self.formula
        if kind == "not":
            return -self(p, parts)
        if kind == "cell":
            values = [((p @ A) * p).sum(-1) + p @ b + c for A, b, c in (self.terms[id(form)] for form in parts)]
        else:
            values = [self(p, part) for part in parts]
        return (np.min if kind == "any" else np.max)(values, axis=0)


def shape_and_field(item):
    return item.shape(co), Field(body(item).formula)


def solid(kind, **parameters):
    return Item(kind, parameters)


def ball(radius, center=(0, 0, 0)):
    return solid("Sphere", radius=radius, center=center)


def rod(start, end, radius):
    return solid("Cylinder", start=start, end=end, radius=radius)


def box(low, high):
    return solid("Box", low=low, high=high)


def less(*parts):
    return combined("Difference", *parts)


CUBE, DRUM, WITHIN = box((-1, -1, -1), (1, 1, 1)), rod((0, 0, -2), (0, 0, 2), 0.5), ((-1, -1, -1), (1, 1, 1))
TETRAHEDRON = [(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]
OBLIQUE = dict(xx=2, yy=1, zz=3, xy=0.5, yz=-1, xz=0.25, x=0.5, y=-0.25, z=1, constant=-1)
ITEMS = {
    "ball": ball(1.5, (0.25, 0, 0)),
    "ellipsoid": solid("Ellipsoid", radii=(1, 2, 0.5)),
    "needle": solid("Ellipsoid", radii=(0.125, 0.125, 2)),
    "box": box((-1, -0.5, -2), (1, 0.5, 0.75)),
    "cylinder": DRUM,
    "cone": solid("Cone", start=(0, 0, 0), end=(0, 0, 2), start_radius=1, end_radius=0),
    "frustum": solid("Cone", start=(0, 0, 0), end=(0, 0, 2), start_radius=1, end_radius=0.5),
    "bow tie": solid("DoubleCone", slope=0.5, z_range=(-1, 1)),
    "bowl": solid("EllipticParaboloid", A=1, E=2, z_range=(0, 1.5)),
    "saddle": solid("HyperbolicParaboloid", A=1, E=1.5, within=WITHIN),
    "waist": solid("OneSheetHyperboloid", A=4, E=2, H=1, z_range=(-1, 1.5)),
    "two bowls": solid("TwoSheetHyperboloid", A=1, E=2, H=4, z_range=(-1, 1)),
    "trough": solid("ParabolicCylinder", G=0.5, within=WITHIN),
    "flanks": solid("HyperbolicCylinder", A=4, E=1, within=WITHIN),
    "oblique": solid("Quadric", coefficients=OBLIQUE),
    "tetrahedron": solid("Polyhedron", normals=TETRAHEDRON, offsets=[1, 1, 1, 1]),
    "drilled ball": less(ball(1.25), DRUM),
    "drilled box": less(CUBE, DRUM),
    "lens": combined("Intersection", ball(2, (0, 0, -1.5)), ball(2, (0, 0, 1.5))),
    "three balls": combined("Union", ball(1), ball(0.75, (1, 0, 0)), ball(0.75, (0.25, 1, 0))),
    "steinmetz": combined("Intersection", rod((-2, 0, 0), (2, 0, 0), 0.75), rod((0, -2, 0), (0, 2, 0), 0.75)),
    "cross": combined("Union", rod((-1, 0, 0), (1, 0, 0), 0.5), rod((0, -1, 0), (0, 1, 0), 0.5)),
    "unequal pipes": less(rod((-2, 0, 0), (2, 0, 0), 0.75), rod((0, -2, 0.125), (0, 2, 0.125), 0.5)),
    "bitten egg": less(solid("Ellipsoid", radii=(1, 1.5, 0.75)), ball(0.75, (0.5, 0.75, 0.25))),
    "flush": combined("Union", box((-1, -1, -1), (0, 1, 1)), box((0, -1, -1), (1, 1, 0.5))),
    "flush bite": less(CUBE, box((-0.5, -0.5, 0), (0.5, 0.5, 1))),
    "turned": less(CUBE, rod((0, 0, -2), (0, 0, 2), 0.75)).moved(("rotate", (0, 0, 1), 30)),
    "wedge": Item("Cylinder", {**rod((0, 0, 0), (0, 0, 1), 1).parameters, "start_angle": 0, "end_angle": 270, "reference": (1, 0, 0)}),
}  # fmt: skip
BODIES = {name: shape_and_field(item) for name, item in ITEMS.items()}
"""Name: (the shape, its field)."""


def random_body(rng):
    """Return (shape, field) of up to four turned and moved primitives in a random Boolean."""
    parts = []
    for _ in range(rng.integers(2, 5)):
        part = plain(rng, str(pick(rng, ("Sphere", "Ellipsoid", "Cylinder", "Box", "Cone"))))
        turn = ("rotate", axis(rng), float(rng.choice([rng.uniform(0, 360), 90.0])))
        parts.append(part.moved(("scale", 0.25), turn, ("translate", tuple((rng.integers(-4, 5, 3) / 8).tolist()))))
    return shape_and_field(joined(rng, parts))
