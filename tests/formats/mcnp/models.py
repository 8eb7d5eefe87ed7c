"""MCNP's surfaces at points, by the formulas of its manual, in floats: whether a point is on the positive side."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

import conicoid as co

Points = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Sense = Callable[[Points], Mask]


def above(f: Callable[[Any, Any, Any], Any]) -> Sense:
    """Return whether f > 0."""
    return lambda p: np.asarray(f(p[:, 0], p[:, 1], p[:, 2]) > 0)


def beyond_any(*facets: Sense) -> Sense:
    """Return whether points are outside of a macrobody, on the positive side of some facet."""
    return lambda p: np.any([facet(p) for facet in facets], axis=0)


def plane(normal: Any, through: Any) -> Sense:
    return lambda p: (p - np.array(through, float)) @ np.array(normal, float) > 0


def tube(base: Any, height: Any, radius: float) -> Sense:
    """Compare with the distance from a line, as the length of a cross product."""
    axis = np.array(height, float) / np.linalg.norm(height)
    return lambda p: np.linalg.norm(np.cross(p - np.array(base, float), axis), axis=1) > radius


def frustum(base: Any, height: Any, first: float, last: float) -> Sense:
    """Compare the distance from a line with the radius at that height, of either sign."""
    size = float(np.linalg.norm(height))
    axis = np.array(height, float) / size

    def sense(p: Points) -> Mask:
        q = p - np.array(base, float)
        far = np.linalg.norm(np.cross(q, axis), axis=1)
        return np.asarray(far > np.abs(first + (last - first) * (q @ axis) / size))

    return sense


def oval_tube(base: Any, major: Any, minor: Any) -> Sense:
    u, v = np.array(major, float), np.array(minor, float)

    def sense(p: Points) -> Mask:
        q = p - np.array(base, float)
        return np.asarray(((q @ u) / (u @ u)) ** 2 + ((q @ v) / (v @ v)) ** 2 > 1)

    return sense


def foci(first: Any, second: Any, half: float) -> Sense:
    """Compare with the sum of the distances from two points."""
    a, b = np.array(first, float), np.array(second, float)
    return lambda p: np.linalg.norm(p - a, axis=1) + np.linalg.norm(p - b, axis=1) > 2 * half


def _ell_foci(first: Any, second: Any, half: float) -> tuple[Any, Any]:
    """The foci of MCNP's ELL: as far from the points on the axis as the points are from its middle."""
    a, b = np.array(first, float), np.array(second, float)
    to_focus = (b - a) / np.linalg.norm(b - a) * (half - np.linalg.norm(b - a) / 2)
    return (a + b) / 2 - to_focus, (a + b) / 2 + to_focus


def one_sheet(axis: int, apex: Any, square: float, nappe: int) -> Sense:
    """Return the sense of a cone whose negative side is within one nappe only."""

    def sense(p: Points) -> Mask:
        q = p - np.array(apex, float)
        t = q[:, axis]
        far = np.sqrt(np.delete(q, axis, axis=1).__pow__(2).sum(axis=1))
        return ~np.asarray((nappe * t > 0) & (far < np.sqrt(square) * np.abs(t)))

    return sense


_hex = [np.array([np.cos(np.pi / 3 * k), np.sin(np.pi / 3 * k), 0]) * 1.5 for k in range(3)]
_wed = np.array([[-1, -1, -2], [3, 0, 0], [0, 2, 0], [0, 0, 3]], float)
_arb = np.array([[-2, -2, -1], [2, -2, -1], [2, 2, -1], [-2, 2, -1], [0, 0, 2.5]], float)


def _arb_side(i: int, j: int, k: int) -> Sense:
    a, b, c = (_arb[n - 1] for n in (i, j, k))
    normal = np.cross(b - a, c - a)
    return plane(normal if normal @ (a - _arb.mean(axis=0)) > 0 else -normal, a)


SIMPLE: list[tuple[str, Sense]] = [
    ("p 1 -2 0.5 0.7", above(lambda x, y, z: x - 2 * y + 0.5 * z - 0.7)),
    ("px -0.4", above(lambda x, y, z: x + 0.4)),
    ("py 1.25", above(lambda x, y, z: y - 1.25)),
    ("pz 2-1", above(lambda x, y, z: z - 0.2)),
    # Three points: the origin is on the negative side; else (0, 0, inf) is on the positive one, and so on
    ("p 1 0 0  0 2 0  0 0 3", above(lambda x, y, z: x + y / 2 + z / 3 - 1)),
    ("p -1 0 0  0 2 0  0 0 3", above(lambda x, y, z: -x + y / 2 + z / 3 - 1)),
    ("p 1 0 0  0 1 0  1 1 -2", above(lambda x, y, z: x + y + z / 2 - 1)),
    ("p 0 0 0  1 0 1  0 1 -1", above(lambda x, y, z: z - x + y)),
    ("p 0 0 0  0 1 -1  1 0 1", above(lambda x, y, z: z - x + y)),
    ("p 0 0 0  0 0 1  1 2 0", above(lambda x, y, z: y - 2 * x)),
    ("p 0 0 0  0 0 1  0 -2 0", above(lambda x, y, z: x)),
    ("so 1.5", above(lambda x, y, z: x**2 + y**2 + z**2 - 2.25)),
    ("s 1 -0.5 0.25 2", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 + (z - 0.25) ** 2 - 4)),
    ("sph 1 -0.5 0.25 2", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 + (z - 0.25) ** 2 - 4)),
    ("sx -1 1.5", above(lambda x, y, z: (x + 1) ** 2 + y**2 + z**2 - 2.25)),
    ("sy -1 1.5", above(lambda x, y, z: x**2 + (y + 1) ** 2 + z**2 - 2.25)),
    ("sz -1 1.5", above(lambda x, y, z: x**2 + y**2 + (z + 1) ** 2 - 2.25)),
    ("cx 1.1", above(lambda x, y, z: y**2 + z**2 - 1.21)),
    ("cy 1.1", above(lambda x, y, z: x**2 + z**2 - 1.21)),
    ("cz 1.1", above(lambda x, y, z: x**2 + y**2 - 1.21)),
    ("c/x 1 -0.5 1.1", above(lambda x, y, z: (y - 1) ** 2 + (z + 0.5) ** 2 - 1.21)),
    ("c/y 1 -0.5 1.1", above(lambda x, y, z: (x - 1) ** 2 + (z + 0.5) ** 2 - 1.21)),
    ("c/z 1 -0.5 1.1", above(lambda x, y, z: (x - 1) ** 2 + (y + 0.5) ** 2 - 1.21)),
    ("kx 0.5 0.3", above(lambda x, y, z: y**2 + z**2 - 0.3 * (x - 0.5) ** 2)),
    ("ky 0.5 0.3 1", one_sheet(1, (0, 0.5, 0), 0.3, 1)),
    ("kz 0.5 0.3 -1", one_sheet(2, (0, 0, 0.5), 0.3, -1)),
    ("k/x 1 0.5 -0.25 0.6", above(lambda x, y, z: (y - 0.5) ** 2 + (z + 0.25) ** 2 - 0.6 * (x - 1) ** 2)),
    ("k/y 1 0.5 -0.25 0.6 -1", one_sheet(1, (1, 0.5, -0.25), 0.6, -1)),
    ("k/z 1 0.5 -0.25 0.6 1", one_sheet(2, (1, 0.5, -0.25), 0.6, 1)),
    (
        "sq 1 2 -0.5 0.2 -0.3 0.4 -1 0.5 -0.25 0.75",
        above(
            lambda x, y, z: (x - 0.5) ** 2 + 2 * (y + 0.25) ** 2 - 0.5 * (z - 0.75) ** 2
            + 2 * 0.2 * (x - 0.5) - 2 * 0.3 * (y + 0.25) + 2 * 0.4 * (z - 0.75) - 1
        ),
    ),
    (
        "gq 1 2 0.5 0.3 -0.2 0.4 0.1 -0.6 0.7 -2",
        above(
            lambda x, y, z: x**2 + 2 * y**2 + 0.5 * z**2 + 0.3 * x * y - 0.2 * y * z + 0.4 * z * x
            + 0.1 * x - 0.6 * y + 0.7 * z - 2
        ),
    ),
    ("gq 0 0 0 0 0 0 1 2 -1 -0.5", above(lambda x, y, z: x + 2 * y - z - 0.5)),
    ("x 0.75 2", above(lambda x, y, z: x - 0.75)),
    ("y -1 1.5  2 1.5", above(lambda x, y, z: x**2 + z**2 - 2.25)),
    ("z -1 0.5  1 1.5", one_sheet(2, (0, 0, -2), 0.25, 1)),
    ("x -1 2  1 0", one_sheet(0, (1, 0, 0), 1, -1)),
    ("z -1 0  0 1  1 0", above(lambda x, y, z: x**2 + y**2 + z**2 - 1)),
    ("x 0 0  1 1  4 2", above(lambda x, y, z: y**2 + z**2 - x)),
    ("y -1 2  0 1  1 2", above(lambda x, y, z: x**2 + z**2 - 3 * y**2 - 1)),
    ("ell 1 0 0  -1 0.5 1  2", foci(*_ell_foci((1, 0, 0), (-1, 0.5, 1), 2), 2)),
    ("ell 0 0 -2  0 0 2  6", above(lambda x, y, z: (x**2 + y**2) / 20 + z**2 / 36 - 1)),  # 4.4721² = 20: the manual
    (
        "ell 0.5 0 -0.25  0 0 2  -1",
        above(lambda x, y, z: (x - 0.5) ** 2 + y**2 + ((z + 0.25) / 2) ** 2 - 1),
    ),
]  # fmt: skip
"""Cards without their numbers, and their positive sides."""

BODIES: list[tuple[str, list[Sense]]] = [
    (
        "rpp -1 2 -0.5 1 -2 0.25",
        [plane(n, q) for n, q in (
            ((1, 0, 0), (2, 0, 0)), ((-1, 0, 0), (-1, 0, 0)), ((0, 1, 0), (0, 1, 0)), ((0, -1, 0), (0, -0.5, 0)),
            ((0, 0, 1), (0, 0, 0.25)), ((0, 0, -1), (0, 0, -2)),
        )],
    ),
    (
        "box -1 -1 -1  1 2 0  -2 1 0  0 0 2.5",
        [plane(n, q) for n, q in (
            ((1, 2, 0), (0, 1, -1)), ((-1, -2, 0), (-1, -1, -1)), ((-2, 1, 0), (-3, 0, -1)), ((2, -1, 0), (-1, -1, -1)),
            ((0, 0, 1), (-1, -1, 1.5)), ((0, 0, -1), (-1, -1, -1)),
        )],
    ),
    (
        "box -1 -1 -1  1 2 0  -2 1 0",
        [plane(n, q) for n, q in (
            ((1, 2, 0), (0, 1, -1)), ((-1, -2, 0), (-1, -1, -1)), ((-2, 1, 0), (-3, 0, -1)), ((2, -1, 0), (-1, -1, -1)),
        )],
    ),
    ("rcc 0.5 0 -1  0 0 2.5  1.25", [tube((0.5, 0, 0), (0, 0, 1), 1.25), plane((0, 0, 1), (0, 0, 1.5)),
                                    plane((0, 0, -1), (0, 0, -1))]),
    ("rcc -1 0 -1  1 2 1.5  1.25", [tube((-1, 0, -1), (1, 2, 1.5), 1.25), plane((1, 2, 1.5), (0, 2, 0.5)),
                                   plane((-1, -2, -1.5), (-1, 0, -1))]),
    ("trc 0 -1 0  0 2 0  2 0.5", [frustum((0, -1, 0), (0, 2, 0), 2, 0.5), plane((0, 1, 0), (0, 1, 0)),
                                 plane((0, -1, 0), (0, -1, 0))]),
    ("trc -1 0 -1  1 2 1.5  0 1.5", [frustum((-1, 0, -1), (1, 2, 1.5), 0, 1.5), plane((1, 2, 1.5), (0, 2, 0.5)),
                                    plane((-1, -2, -1.5), (-1, 0, -1))]),
    ("rec 0 0 -1  0 0 2  2 1 0  -0.5 1 0", [oval_tube((0, 0, -1), (2, 1, 0), (-0.5, 1, 0)), plane((0, 0, 1), (0, 0, 1)),
                                          plane((0, 0, -1), (0, 0, -1))]),
    ("rec 0 -1 0  0 2 1  0 -1 2  0.75", [oval_tube((0, -1, 0), (0, -1, 2), (0.75, 0, 0)),
                                       plane((0, 2, 1), (0, 1, 1)), plane((0, -2, -1), (0, -1, 0))]),
    ("rhp 0.25 -0.25 -1  0 0 2.5  1.5 0 0", [
        *(plane(sign * v, sign * v + [0.25, -0.25, 0]) for v in _hex for sign in (1, -1)),
        plane((0, 0, 1), (0, 0, 1.5)), plane((0, 0, -1), (0, 0, -1)),
    ]),
    ("hex 0 0 -1  0 0 2  1.5 0 0  0.5 1.5 0  -0.7 1.25 0", [
        *(plane(sign * np.array(v), sign * np.array(v)) for v in ((1.5, 0, 0), (0.5, 1.5, 0), (-0.7, 1.25, 0))
          for sign in (1, -1)),
        plane((0, 0, 1), (0, 0, 1)), plane((0, 0, -1), (0, 0, -1)),
    ]),
    ("wed -1 -1 -2  3 0 0  0 2 0  0 0 3", [
        plane((2, 3, 0), _wed[0] + _wed[1]), plane((-1, 0, 0), _wed[0]), plane((0, -1, 0), _wed[0]),
        plane((0, 0, 1), _wed[0] + _wed[3]), plane((0, 0, -1), _wed[0]),
    ]),
    ("arb -2 -2 -1  2 -2 -1  2 2 -1  -2 2 -1  0 0 2.5  0 0 0  0 0 0  0 0 0  1234 1250 2350 3450 4150 0", [
        _arb_side(1, 2, 3), _arb_side(1, 2, 5), _arb_side(2, 3, 5), _arb_side(3, 4, 5), _arb_side(4, 1, 5),
    ]),
]  # fmt: skip
"""Macrobodies with the positive sides of their facets."""


# --- Find the cell at a point by MCNP's rules, in floats: regions, universes, lattices and transformations. A model
# has everything twice: `text` is the deck, and the other fields are for this evaluator, written by hand


Change = tuple[Any, Any]
"""Origin and rows: x' = rows (x - origin)."""


@dataclass
class Lattice:
    """The steps from an element to the next, and the content of each: a universe, or None for the cell's own material."""

    ways: Any
    entries: dict[tuple[int, int, int], Any]


@dataclass
class CellModel:
    """A card, with its region, universe and filling for the evaluator."""

    text: str
    region: str
    u: int = 0
    fill: int | None = None
    into: Change | None = None
    moved: Change | None = None
    lattice: Lattice | None = None
    is_outside: bool = False

    @property
    def number(self) -> int:
        return int(self.text.split()[0])


@dataclass
class Model:
    """A deck and its meaning."""

    cells: list[CellModel]
    surfaces: dict[int, tuple[str, Sense]]
    data: str = ""
    moves: dict[int, Change] = field(default_factory=dict)  # of surfaces

    @property
    def text(self) -> str:
        cells = "\n".join(cell.text for cell in self.cells)
        surfaces = "\n".join(f"{number} {card}" for number, (card, _) in self.surfaces.items())
        return f"title\n{cells}\n\n{surfaces}\n\n{self.data}\n"

    def names(self, points: Points) -> list[str | None]:
        found: Any = np.full(len(points), None, object)
        self._find(0, points, np.arange(len(points)), (), found)
        return list(found)

    def _find(self, universe: int, points: Points, at: Any, path: tuple[str, ...], found: Any) -> None:
        for cell in self.cells:
            if cell.u != universe or cell.is_outside:
                continue
            if cell.lattice is not None:
                self._elements(cell, cell.lattice, points, at, path, found)
                continue
            inside = self.within(cell, points)
            if cell.fill is None:
                self._name(cell, at[inside], path, found)
            else:
                inner = carried(points[inside], cell.into or cell.moved)
                self._find(cell.fill, inner, at[inside], (*path, f"cell {cell.number}"), found)

    def _elements(self, cell: CellModel, lattice: Lattice, points: Points, at: Any, path: Any, found: Any) -> None:
        points = carried(points, cell.moved)
        for index, entry in lattice.entries.items():
            own = points - sum(
                (i * np.array(way, float) for i, way in zip(index, lattice.ways, strict=False)), np.zeros(3)
            )
            inside = self._region(cell.region, own)
            step = (*path, f"cell {cell.number}", f"lattice [{', '.join(map(str, index))}]")
            if entry is None:
                self._name(cell, at[inside], step, found)
                continue
            universe, change = entry if isinstance(entry, tuple) else (entry, None)
            self._find(universe, carried(own[inside], change), at[inside], step, found)

    def _name(self, cell: CellModel, at: Any, path: tuple[str, ...], found: Any) -> None:
        found[at] = f"cell {cell.number}" + (f" @ {', '.join(path)}" if path else "")

    def within(self, cell: CellModel, points: Points) -> Mask:
        """Return which points are in a cell's region."""
        return self._region(cell.region, carried(points, cell.moved))

    def _region(self, text: str, points: Points) -> Mask:
        """Evaluate the region by Python's operators, which bind as MCNP's do."""
        by_number = {cell.number: cell for cell in self.cells}
        functions: dict[str, Callable[..., Mask]] = {
            "S": lambda n: carried_sense(self.surfaces[n][1], self.moves.get(n), points),
            "C": lambda n: self.within(by_number[n], points),
        }
        words = re.findall(r"#\d+|[-+]?\d+|[#:()]", text)
        code = ""
        for before, word in zip(["", *words], words, strict=False):
            if before not in ("", ":", "(", "#") and word not in (":", ")"):
                code += " & "
            if word == ":":
                code += " | "
            elif word in ("(", ")"):
                code += word
            elif word == "#":
                code += "~"
            elif word[0] == "#":
                code += f"~C({word[1:]})"
            else:
                code += f"{'~' if word[0] == '-' else ''}S({word.lstrip('+-')})"
        return np.asarray(eval(code, functions))


def carried(points: Points, change: Change | None) -> Points:
    """Return main coordinates as auxiliary ones."""
    if change is None:
        return points
    origin, rows = change
    return (points - np.array(origin, float)) @ np.array(rows, float).T


def carried_sense(sense: Sense, change: Change | None, points: Points) -> Mask:
    return sense(carried(points, change))


# --- Decks with all parts of a geometry, and their meanings


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


# --- The decks of a test, and the cells at points of them


def load_deck(folder, text: str, **options: Any) -> co.Scene:
    """Return the scene of a deck."""
    path = folder / "deck.mcnp"
    path.write_text(text, encoding="utf-8")
    return co.load(path, **options)


def names_at(scene: co.Scene, points: Any) -> list[str | None]:
    """Return the name of the body at each point."""
    names = [body.name for body in scene.bodies]
    return [None if number < 0 else names[number] for number in np.asarray(scene.body_at(points)).tolist()]


def chosen(seed: int, count: int, reach: float) -> Any:
    """Return points in a cube about the origin."""
    return np.random.default_rng(seed).uniform(-reach, reach, (count, 3))
