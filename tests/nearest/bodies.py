"""Bodies for tests of distances, each in two forms: as shapes, and as fields, negative inside, of NumPy alone."""

import numpy as np

import conicoid as co


class Field:
    """The largest or least of its parts, or v·A v + b·v + c about a center."""

    def __init__(self, parts=(), least=False, terms=None):
        self.parts, self.least, self.terms = parts, least, terms

    def __call__(self, p):
        if self.terms is not None:
            A, b, c, center = self.terms
            v = p - center
            return ((v @ A) * v).sum(-1) + v @ b + c
        return (np.min if self.least else np.max)([part(p) for part in self.parts], axis=0)

    def surfaces(self):
        """Return (A, b, c, center) of every surface."""
        return [self.terms] if self.terms is not None else [t for part in self.parts for t in part.surfaces()]

    def __neg__(self):
        if self.terms is not None:
            A, b, c, center = self.terms
            return Field(terms=(-A, -b, -c, center))
        return Field([-part for part in self.parts], not self.least)

    def moved(self, back, by):
        """Return the field moved by x -> M x + by, where `back` is the inverse of M."""
        if self.terms is not None:
            A, b, c, center = self.terms
            ahead = inverse(back)
            return Field(terms=(back.T @ A @ back, back.T @ b, c, ahead @ center + by))
        return Field([part.moved(back, by) for part in self.parts], self.least)

    def turned(self, turn):
        """Return the field turned by a matrix."""
        if self.terms is not None:
            A, b, c, center = self.terms
            return Field(terms=(turn @ A @ turn.T, turn @ b, c, turn @ center))
        return Field([part.turned(turn) for part in self.parts], self.least)


def quadric(A, b=(0, 0, 0), c=-1.0, center=(0, 0, 0)):
    """Return v·A v + b·v + c with v = p - center."""
    A, b, center = (np.asarray(x, np.longdouble) for x in (np.diag(A) if np.ndim(A) == 1 else A, b, center))
    return Field(terms=(A, b, np.longdouble(c), center))


def plane(n, offset):
    return quadric((0, 0, 0), n, -np.longdouble(offset))


def both(*fields):
    return Field(fields)


def any_of(*fields):
    return Field(fields, True)


def less(field, *others):
    return both(field, *(-f for f in others))


def box(low, high):
    e = np.eye(3)
    return both(*(plane(e[i], high[i]) for i in range(3)), *(plane(-e[i], -low[i]) for i in range(3)))


def ball(r, center=(0, 0, 0)):
    return quadric((1, 1, 1), c=-(np.longdouble(r) ** 2), center=center)


def rod(axis, r, center=(0, 0, 0)):
    """Return an endless cylinder along a coordinate axis."""
    squares = [1.0, 1.0, 1.0]
    squares[axis] = 0.0
    return quadric(squares, c=-(np.longdouble(r) ** 2), center=center)


def turned(field, sine, cosine):
    """Return the shape turned about z."""
    s, c = np.longdouble(sine), np.longdouble(cosine)
    return field.turned(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]], np.longdouble))


UP, DOWN = (0, 0, 1), (0, 0, -1)
CUBE, HALVES = co.Box((-1, -1, -1), (1, 1, 1)), box((-1, -1, -1), (1, 1, 1))
DRUM = co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)

BODIES = {
    "ball": (co.Sphere(1.5, (0.25, 0, 0)), ball(1.5, (0.25, 0, 0))),
    "ellipsoid": (co.Ellipsoid((1, 2, 0.5)), quadric((1, 0.25, 4))),
    "needle": (co.Ellipsoid((0.125, 0.125, 2)), quadric((64, 64, 0.25))),
    "box": (co.Box((-1, -0.5, -2), (1, 0.5, 0.75)), box((-1, -0.5, -2), (1, 0.5, 0.75))),
    "cylinder": (DRUM, both(rod(2, 0.5), plane(UP, 2), plane(DOWN, 2))),
    "cone": (
        co.Cone((0, 0, 0), (0, 0, 2), 1, 0),
        both(quadric((1, 1, -0.25), c=0, center=(0, 0, 2)), plane(DOWN, 0), plane(UP, 2)),
    ),
    "frustum": (
        co.Cone((0, 0, 0), (0, 0, 2), 1, 0.5),
        both(quadric((1, 1, -0.0625), (0, 0, 0.5), -1), plane(DOWN, 0), plane(UP, 2)),
    ),
    "bow tie": (
        co.DoubleCone(0.5, (-1, 1)),
        both(quadric((1, 1, -0.25), c=0), plane(DOWN, 1), plane(UP, 1)),
    ),
    "bowl": (co.EllipticParaboloid(1, 2, (0, 1.5)), both(quadric((1, 2, 0), (0, 0, -1), 0), plane(UP, 1.5))),
    "saddle": (
        co.HyperbolicParaboloid(1, 1.5, within=CUBE),
        both(quadric((1, -1.5, 0), (0, 0, -1), 0), HALVES),
    ),
    "waist": (co.OneSheetHyperboloid(4, 2, 1, (-1, 1.5)), both(quadric((4, 2, -1)), plane(DOWN, 1), plane(UP, 1.5))),
    "two bowls": (
        co.TwoSheetHyperboloid(1, 2, 4, (-1, 1)),
        both(quadric((1, 2, -4), c=1), plane(DOWN, 1), plane(UP, 1)),
    ),
    "trough": (co.ParabolicCylinder(0.5, within=CUBE), both(quadric((1, 0, 0), (0, -1, 0), 0), HALVES)),
    "flanks": (co.HyperbolicCylinder(4, 1, within=CUBE), both(quadric((4, -1, 0)), HALVES)),
    "oblique": (
        co.Quadric(coefficients=dict(xx=2, yy=1, zz=3, xy=0.5, yz=-1, xz=0.25, x=0.5, y=-0.25, z=1, constant=-1)),
        quadric([[2, 0.25, 0.125], [0.25, 1, -0.5], [0.125, -0.5, 3]], (0.5, -0.25, 1), -1),
    ),
    "tetrahedron": (
        co.Polyhedron([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)], [1, 1, 1, 1]),
        both(*(plane(n, 1) for n in ((1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)))),
    ),
    "drilled ball": (co.Sphere(1.25) - DRUM, less(ball(1.25), rod(2, 0.5))),
    "drilled box": (CUBE - DRUM, less(HALVES, rod(2, 0.5))),
    "lens": (co.Sphere(2, (0, 0, -1.5)) & co.Sphere(2, (0, 0, 1.5)), both(ball(2, (0, 0, -1.5)), ball(2, (0, 0, 1.5)))),
    "three balls": (
        co.Sphere(1) | co.Sphere(0.75, (1, 0, 0)) | co.Sphere(0.75, (0.25, 1, 0)),
        any_of(ball(1), ball(0.75, (1, 0, 0)), ball(0.75, (0.25, 1, 0))),
    ),
    "steinmetz": (
        co.Cylinder((-2, 0, 0), (2, 0, 0), 0.75) & co.Cylinder((0, -2, 0), (0, 2, 0), 0.75),
        both(rod(0, 0.75), rod(1, 0.75)),
    ),
    "cross": (
        co.Cylinder((-1, 0, 0), (1, 0, 0), 0.5) | co.Cylinder((0, -1, 0), (0, 1, 0), 0.5),
        any_of(
            both(rod(0, 0.5), plane((1, 0, 0), 1), plane((-1, 0, 0), 1)),
            both(rod(1, 0.5), plane((0, 1, 0), 1), plane((0, -1, 0), 1)),
        ),
    ),
    "unequal pipes": (
        co.Cylinder((-2, 0, 0), (2, 0, 0), 0.75) - co.Cylinder((0, -2, 0.125), (0, 2, 0.125), 0.5),
        less(both(rod(0, 0.75), plane((1, 0, 0), 2), plane((-1, 0, 0), 2)), rod(1, 0.5, (0, 0, 0.125))),
    ),
    "bitten egg": (
        co.Ellipsoid((1, 1.5, 0.75)) - co.Sphere(0.75, (0.5, 0.75, 0.25)),
        less(quadric((1, 1 / np.longdouble(2.25), 1 / np.longdouble(0.5625))), ball(0.75, (0.5, 0.75, 0.25))),
    ),
    "flush": (
        co.Box((-1, -1, -1), (0, 1, 1)) | co.Box((0, -1, -1), (1, 1, 0.5)),
        any_of(box((-1, -1, -1), (0, 1, 1)), box((0, -1, -1), (1, 1, 0.5))),
    ),
    "flush bite": (
        CUBE - co.Box((-0.5, -0.5, 0), (0.5, 0.5, 1)),
        less(
            HALVES,
            both(
                plane((1, 0, 0), 0.5),
                plane((-1, 0, 0), 0.5),
                plane((0, 1, 0), 0.5),
                plane((0, -1, 0), 0.5),
                plane(DOWN, 0),
            ),
        ),
    ),
    "turned": (
        (CUBE - co.Cylinder((0, 0, -2), (0, 0, 2), 0.75)).rotate("z", 30),
        turned(less(HALVES, rod(2, 0.75)), 0.5, np.sqrt(np.longdouble(3)) / 2),
    ),
    "wedge": (
        co.Cylinder((0, 0, 0), (0, 0, 1), 1, 0, 270, reference=(1, 0, 0)),
        both(rod(2, 1), plane(DOWN, 0), plane(UP, 1), any_of(plane((0, -1, 0), 0), plane((1, 0, 0), 0))),
    ),
}
"""Name: (the shape, its field). Fields are not distances; of flush walls only the sign counts."""


def random_body(rng):
    """Return (shape, field) of up to four turned and moved primitives in a random Boolean."""
    shape, field = _random_part(rng)
    for _ in range(rng.integers(1, 4)):
        other, its = _random_part(rng)
        kind = rng.integers(0, 3)
        if kind == 0:
            shape, field = shape | other, any_of(field, its)
        elif kind == 1:
            shape, field = shape - other, less(field, its)
        else:
            shape, field = shape & other, both(field, its)
    return shape, field


def _random_part(rng):
    """Return a primitive, turned and moved by a matrix of floats, which both the shape and the field take as it is."""
    a, b, c = rng.integers(4, 13, 3) / 8
    shape, field = [
        (co.Sphere(a), ball(a)),
        (co.Ellipsoid((a, b, c)), quadric([1 / np.longdouble(r) ** 2 for r in (a, b, c)])),
        (co.Cylinder((0, 0, -a), (0, 0, a), b), both(rod(2, b), plane(UP, a), plane(DOWN, a))),
        (co.Box((-a, -b, -c), (a, b, c)), box((-a, -b, -c), (a, b, c))),
        (co.DoubleCone(0.5, (-1, 1)), both(quadric((1, 1, -0.25), c=0), plane(DOWN, 1), plane(UP, 1))),
    ][rng.integers(0, 5)]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    if rng.integers(0, 3) == 0:
        turn = np.eye(3)[rng.permutation(3)]
    move = rng.integers(-6, 7, 3) / 8
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, move
    return shape.transform(matrix), field.moved(inverse(turn.astype(np.longdouble)), move)


def inverse(matrix):
    """Return the inverse of a matrix that is nearly a rotation, in extended precision."""
    found = matrix.T
    for _ in range(4):
        found = found @ (2 * np.eye(3) - matrix @ found)
    return found
