"""Decks with all parts of a geometry, and their meanings."""

from itertools import product

import numpy as np

from .evaluator import CellModel, Lattice, Model
from .senses import above, beyond_any, plane, tube

COS30, SIN30 = np.cos(np.pi / 6), 0.5
NONE = np.eye(3)
ABOUT_Z = np.array([[COS30, SIN30, 0], [-SIN30, COS30, 0], [0, 0, 1]])  # rows: the new axes, turned by 30° towards y
QUARTER = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])


def ball(x: float, y: float, z: float, r: float):  # type: ignore[no-untyped-def]
    return above(lambda a, b, c: (a - x) ** 2 + (b - y) ** 2 + (c - z) ** 2 - r * r)


def cuboid(*ends: float):  # type: ignore[no-untyped-def]
    """Return which points are outside of xmin xmax ymin ymax zmin zmax."""
    sides = []
    for axis in range(3):
        for sign, end in ((-1, ends[2 * axis]), (1, ends[2 * axis + 1])):
            sides.append(plane(sign * np.eye(3)[axis], end * np.eye(3)[axis]))
    return beyond_any(*sides)


def flat(axis: int, at: float):  # type: ignore[no-untyped-def]
    return plane(np.eye(3)[axis], at * np.eye(3)[axis])


REGIONS = Model(
    [
        CellModel("1 1 -10.4 -1 (2:-3) #(4 -5) imp:n=1", "-1 (2:-3) #(4 -5)"),
        CellModel("2 2 0.05 -1 #1 imp:n=1", "-1 #1"),
        CellModel("3 0 1 -6 #1 #2 #4 imp:n=1", "1 -6 #1 #2 #4"),
        CellModel("4 like 2 but trcl=(4 1 0.5) mat=3 rho=-1", "-1 #1", moved=((4, 1, 0.5), NONE)),
        CellModel("9 0 6 #4 imp:n=0", "6 #4", is_outside=True),
    ],
    {
        1: ("s 0 0 0 2", ball(0, 0, 0, 2)),
        2: ("px 0.3", flat(0, 0.3)),
        3: ("py -0.2", flat(1, -0.2)),
        4: ("pz 0.5", flat(2, 0.5)),
        5: ("cz 0.7", tube((0, 0, 0), (0, 0, 1), 0.7)),
        6: ("rpp -2.5 2.5 -2.5 2.5 -2.5 2.5", cuboid(-2.5, 2.5, -2.5, 2.5, -2.5, 2.5)),
    },
    "m1 92235 1\nm2 1001 2 8016 1\nm3 26000 -1",
)

ASYMMETRIC = {
    1: ("1 rpp -0.5 2 -0.25 1.5 -1 0.5", cuboid(-0.5, 2, -0.25, 1.5, -1, 0.5)),
}
COSINES = "0.8660254037844386 0.5 0  -0.5 0.8660254037844386 0  0 0 1"
TRANSFORMS: dict[str, tuple[str, tuple[object, object]]] = {
    "shift": ("tr1 1 -0.5 0.25", ((1, -0.5, 0.25), NONE)),
    "nine": (f"tr1 1 -0.5 0.25 {COSINES}", ((1, -0.5, 0.25), ABOUT_Z)),
    "degrees": ("*tr1 1 -0.5 0.25 30 60 90 120 30 90 90 90 0", ((1, -0.5, 0.25), ABOUT_Z)),
    "m = 1": (f"tr1 1 -0.5 0.25 {COSINES} 1", ((1, -0.5, 0.25), ABOUT_Z)),
    "m = -1": (f"tr1 1 -0.5 0.25 {COSINES} -1", (-ABOUT_Z.T @ np.array([1, -0.5, 0.25]), ABOUT_Z)),
    "quarter": ("tr1 0 0.5 0 0 1 0 -1 0 0 0 0 1", ((0, 0.5, 0), QUARTER)),
    "two rows": ("tr1 0 0 0 0.8660254037844386 0.5 0 -0.5 0.8660254037844386 0", ((0, 0, 0), ABOUT_Z)),
    "rows 1 and 3": ("tr1 0 0 0 0.8660254037844386 0.5 0 3j 0 0 1", ((0, 0, 0), ABOUT_Z)),
    "two columns": ("*tr1 0 0 0 30 60 j 120 30 j 90 90 j", ((0, 0, 0), ABOUT_Z)),
    "reflected": ("tr1 0 0 0 1 0 0 0 1 0 0 0 -1", ((0, 0, 0), np.diag([1, 1, -1]))),
}
"""Cards, with their origin and rows."""

_pin = {
    1: ("cz 0.4", tube((0, 0, 0), (0, 0, 1), 0.4)),
    2: ("c/z 0.1 0 0.5", tube((0.1, 0, 0), (0, 0, 1), 0.5)),
}
_pins = [
    CellModel("11 1 -10.4 -1 u=1 imp:n=1", "-1", 1),
    CellModel("12 2 -6.5 1 -2 u=1 imp:n=1", "1 -2", 1),
    CellModel("13 3 -1 1 2 u=1 imp:n=1", "1 2", 1),
    CellModel("21 3 -0.7 -3 u=2 imp:n=1", "-3", 2),
    CellModel("22 0 3 u=2 imp:n=1", "3", 2),
]
_LISTED = [1, 2, 1, 2, 0, 3, 1, 1, 2, 1, 5, 1]

SQUARE = Model(
    [
        *_pins,
        CellModel(
            "31 4 -2.7 -10 u=3 lat=1 imp:n=1 fill=-1:1 0:1 0:1\n     1 2 1  2 0 3\n     1 r 2\n     1 1(2) 1",
            "-10",
            3,
            lattice=Lattice(
                [(1.2, 0, 0), (0, 1.4, 0), (0, 0, 2)],
                {
                    (i, j, k): None if u == 3 else (1, ((0.1, 0.2, 0), QUARTER)) if u == 5 else u
                    for (k, j, i), u in zip(product((0, 1), (0, 1), (-1, 0, 1)), _LISTED, strict=True)
                    if u
                },
            ),
        ),
        CellModel("41 0 -20 fill=3(0.3 0 -0.5) imp:n=1", "-20", fill=3, into=((0.3, 0, -0.5), NONE)),
        CellModel("99 0 20 imp:n=0", "20", is_outside=True),
    ],
    {
        **_pin,
        3: ("so 0.55", ball(0, 0, 0, 0.55)),
        10: ("rpp -0.6 0.6 -0.7 0.7 -1 1", cuboid(-0.6, 0.6, -0.7, 0.7, -1, 1)),
        20: ("so 2.9", ball(0, 0, 0, 2.9)),
    },
    "m1 92235 1\nm2 40000 1\nm3 1001 1\nm4 13027 1\ntr2 0.1 0.2 0 0 1 0 -1 0 0 0 0 1",
)
"""Three by two by two elements: one missing, one of the lattice's own material, one turned."""

_h = 0.8
_a1 = np.array([2 * _h, 0, 0])
_a2 = np.array([_h, np.sqrt(3) * _h, 0])

HEXAGONS = Model(
    [
        *_pins,
        CellModel(
            "31 4 -2.7 -10 u=3 lat=2 imp:n=1 fill=-1:1 -1:1 0:1\n     1 2 1  2 1 3  1 1 2  9r",
            "-10",
            3,
            lattice=Lattice(
                [_a1, _a2, (0, 0, 1.5)],
                {
                    (i, j, k): None if u == 3 else u
                    for (k, j, i), u in zip(
                        product((0, 1), (-1, 0, 1), (-1, 0, 1)), [1, 2, 1, 2, 1, 3, 1, 1, 2, *[2] * 9], strict=True
                    )
                },
            ),
        ),
        CellModel("41 0 -20 *fill=3(0.3 0 -0.5 30 60 90 120 30 90 90 90 0) imp:n=1", "-20", fill=3,
                  into=((0.3, 0, -0.5), ABOUT_Z)),
        CellModel("99 0 20 imp:n=0", "20", is_outside=True),
    ],
    {
        **_pin,
        3: ("so 0.55", ball(0, 0, 0, 0.55)),
        10: (
            "rhp 0 0 -0.75 0 0 1.5 0.8 0 0",
            beyond_any(
                *(plane(s * v, s * v / 2) for v in (_a1, _a2, _a2 - _a1) for s in (1, -1)), flat(2, 0.75),
                plane((0, 0, -1), (0, 0, -0.75)),
            ),
        ),
        20: ("so 2.9", ball(0, 0, 0, 2.9)),
    },
    "m1 92235 1\nm2 40000 1\nm3 1001 1\nm4 13027 1",
)  # fmt: skip
"""It is within a turned cell."""

ENDLESS = Model(
    [
        *_pins,
        CellModel(
            "31 0 -4 5 -6 7 u=3 lat=1 fill=1",
            "-4 5 -6 7",
            3,
            lattice=Lattice([(1, -0.5, 0), (0, 1, 0)], {(i, j, 0): 1 for i in range(-5, 6) for j in range(-8, 9)}),
        ),
        CellModel("41 0 -20 fill=3", "-20", fill=3, moved=None),
        CellModel("99 0 20 imp:n=0", "20", is_outside=True),
    ],
    {
        **_pin,
        3: ("so 0.55", ball(0, 0, 0, 0.55)),
        4: ("px 0.5", flat(0, 0.5)),
        5: ("px -0.5", flat(0, -0.5)),
        6: ("p 0.5 1 0 0.6", plane((0.5, 1, 0), (0, 0.6, 0))),
        7: ("p 0.5 1 0 -0.4", plane((0.5, 1, 0), (0, -0.4, 0))),
        20: ("rcc 0 0 -1 0 0 2 2.5", beyond_any(tube((0, 0, 0), (0, 0, 1), 2.5), flat(2, 1),
                                               plane((0, 0, -1), (0, 0, -1)))),
    },
    "m1 92235 1\nm2 40000 1\nm3 1001 1",
)  # fmt: skip
"""Oblique columns without end, in a cylinder."""

MOVED = Model(
    [
        *_pins,
        CellModel("41 0 -20 fill=2 *trcl=(0.5 -0.25 0.1 30 60 90 120 30 90 90 90 0)", "-20", fill=2,
                  moved=((0.5, -0.25, 0.1), ABOUT_Z)),
        CellModel("42 0 -8 #41 fill=1", "-8 #41", fill=1),
        CellModel("99 0 #41 #42 imp:n=0", "#41 #42", is_outside=True),
    ],
    {
        **_pin,
        3: ("rpp 0 0.8 -0.4 0.5 -3 0.2", cuboid(0, 0.8, -0.4, 0.5, -3, 0.2)),
        8: ("1 c/x 0 0.2 1.9", tube((0, 0, 0.2), (1, 0, 0), 1.9)),
        20: ("box -1 -1 -1 2 0 0 0 2.5 0 0 0 2", cuboid(-1, 1, -1, 1.5, -1, 1)),
    },
    f"m1 92235 1\nm2 40000 1\nm3 1001 1\ntr1 0.1 0 0 {COSINES}",
    {8: ((0.1, 0, 0), ABOUT_Z)},
)  # fmt: skip

TURNED = Model(
    [
        *_pins,
        CellModel(
            "31 0 -10 u=3 lat=1 imp:n=1 fill=-1:2 -1:1 0:0 1 2 10r trcl=(0.2 0 0.1 0.8660254037844386 0.5 0"
            " -0.5 0.8660254037844386 0 0 0 1)",
            "-10",
            3,
            lattice=Lattice(
                [(1.2, 0, 0), (0, 1.4, 0), (0, 0, 2)],
                {
                    (i, j, k): 1 if (i, j, k) == (-1, -1, 0) else 2
                    for k, j, i in product((0,), range(-1, 2), range(-1, 3))
                },
            ),
            moved=((0.2, 0, 0.1), ABOUT_Z),
        ),
        CellModel("41 0 -20 fill=3 imp:n=1", "-20", fill=3),
        CellModel("99 0 20 imp:n=0", "20", is_outside=True),
    ],
    {
        **_pin,
        3: ("s 0.2 0 0 0.55", ball(0.2, 0, 0, 0.55)),
        10: ("rpp -0.6 0.6 -0.7 0.7 -1 1", cuboid(-0.6, 0.6, -0.7, 0.7, -1, 1)),
        20: ("so 2.9", ball(0, 0, 0, 2.9)),
    },
    "m1 92235 1\nm2 40000 1\nm3 1001 1",
)
"""A lattice that a TRCL turns, with its content."""

MODELS = {
    "regions": REGIONS,
    "square": SQUARE,
    "hexagons": HEXAGONS,
    "endless": ENDLESS,
    "moved": MOVED,
    "turned": TURNED,
}
