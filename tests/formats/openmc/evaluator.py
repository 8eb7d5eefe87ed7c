"""OpenMC's rules for finding a point's cell, in plain NumPy, independent of Conicoid.

Surfaces are evaluated in the coordinates of the file. World coordinates go inward level by level: minus the
translation, times the rotation matrix; into the element of a rectangular lattice by `floor`, into that of a hexagonal
one by the nearest center. The cells and elements on the way in name a place.
"""

import functools
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from conicoid._util.records import FloatArray

Place = tuple[Any, ...]
"""(cell, ...) from the root inward: numbers of cells, and (lattice, index) for elements."""


def value(element: ElementTree.Element, name: str) -> str | None:
    child = element.find(name)
    return element.get(name, None if child is None else child.text)


def floats(element: ElementTree.Element, name: str) -> list[float]:
    return [float(word) for word in (value(element, name) or "").split()]


class Evaluator:
    """Find cells in one file."""

    def __init__(self, path: Path) -> None:
        root = ElementTree.parse(path).getroot()
        geometry = root if root.tag == "geometry" else root.find("geometry")
        assert geometry is not None
        self.surfaces = {
            int(value(e, "id") or 0): (value(e, "type") or "", floats(e, "coeffs")) for e in geometry.iter("surface")
        }
        self.cells = {int(value(e, "id") or 0): e for e in geometry.iter("cell")}
        self.universes: dict[int, list[int]] = {}
        for number, cell in self.cells.items():
            self.universes.setdefault(int(value(cell, "universe") or 0), []).append(number)
        self.lattices = {int(value(e, "id") or 0): e for tag in ("lattice", "hex_lattice") for e in geometry.iter(tag)}
        used = {int(value(cell, "fill") or -1) for cell in self.cells.values()}
        for lattice in self.lattices.values():
            used |= {int(word) for word in (value(lattice, "universes") or "").split()} | {
                int(value(lattice, "outer") or -1)
            }
        (self.root,) = set(self.universes) - used
        self.regions: dict[int, Callable[[dict[int, Any]], Any]] = {}

    def find(self, points: FloatArray) -> list[Place | None]:
        """Return the place of each point (n, 3), None where no cell is."""
        found: list[Place | None] = [None] * len(points)
        self._universe(self.root, np.asarray(points, float), np.arange(len(points)), (), found)
        return found

    def _universe(self, number: int, points: FloatArray, indices: Any, way: Place, found: list[Place | None]) -> None:
        free = np.ones(len(points), bool)
        for cell in self.universes[number]:
            inside = free & self._contains(cell, points)
            free &= ~inside
            if inside.any():
                self._cell(cell, points[inside], indices[inside], (*way, cell), found)

    def _cell(self, number: int, points: FloatArray, who: Any, way: Place, found: list[Place | None]) -> None:
        cell = self.cells[number]
        if value(cell, "fill") is None:
            for i in who:
                found[i] = way
            return
        fill = int(value(cell, "fill") or 0)
        if shift := floats(cell, "translation"):
            points = points - shift
        if turn := floats(cell, "rotation"):
            points = points @ rotation_matrix(turn).T
        if fill in self.universes:
            self._universe(fill, points, who, way, found)
            return
        lattice = self.lattices[fill]
        indices, centers, universes = (rectangular if lattice.tag == "lattice" else hexagonal)(lattice, points)
        outer = int(value(lattice, "outer") or -1)
        for index in np.unique(indices, axis=0):
            here = (indices == index).all(axis=1)
            universe = universes.get(tuple(index.tolist()), outer)
            if universe >= 0:
                own = points[here] - centers[here]
                self._universe(universe, own, who[here], (*way, (fill, *index.tolist())), found)

    def _contains(self, cell: int, points: FloatArray) -> Any:
        region = value(self.cells[cell], "region")
        if not (region or "").split():
            return np.ones(len(points), bool)
        return evaluate_region(region or "", lambda surface: self.value_of(surface, points) < 0)

    def value_of(self, surface: int, points: FloatArray) -> FloatArray:
        """Return f of a surface, from the table of OpenMC's documentation."""
        kind, c = self.surfaces[surface]
        x, y, z = points.T
        if kind == "quadric":
            terms = (x * x, y * y, z * z, x * y, y * z, x * z, x, y, z, np.ones_like(x))
            return sum((k * term for k, term in zip(c, terms, strict=True)), np.zeros_like(x))
        if kind == "plane":
            return c[0] * x + c[1] * y + c[2] * z - c[3]
        if kind == "sphere":
            return (x - c[0]) ** 2 + (y - c[1]) ** 2 + (z - c[2]) ** 2 - c[3] ** 2
        axis = "xyz".index(kind[0])
        if kind.endswith("plane"):
            return points[:, axis] - c[0]
        others = [i for i in range(3) if i != axis]
        if kind.endswith("cylinder"):
            return (points[:, others[0]] - c[0]) ** 2 + (points[:, others[1]] - c[1]) ** 2 - c[2] ** 2
        assert kind.endswith("cone")
        p = points - c[:3]
        return (p[:, others] ** 2).sum(axis=1) - c[3] * p[:, axis] ** 2


def evaluate_region(text: str, negative: Callable[[int], Any]) -> Any:
    """Evaluate a region as an expression of Python: `~` binds tighter than `&`, and `&` than `|`, as in OpenMC."""
    words = re.sub(r"([()|&~]|[-+]?[0-9]+)", r" \1 ", text).split()
    code: list[str] = []
    for word in words:
        starts = word[-1].isdigit() or word in "(~"
        if code and starts and (code[-1].endswith("]") or code[-1] == ")"):
            code.append("&")
        code.append(f"{'' if word[0] == '-' else '~'}side[{abs(int(word))}]" if word[-1].isdigit() else word)

    class Sides(dict[int, Any]):
        def __missing__(self, surface: int) -> Any:
            self[surface] = negative(surface)
            return self[surface]

    return eval(" ".join(code), {"side": Sides()})


def rotation_matrix(numbers: list[float]) -> FloatArray:
    """Return the matrix that multiplies a position (Cell::set_rotation in OpenMC's source)."""
    if len(numbers) == 9:
        return np.array(numbers).reshape(3, 3)
    phi, theta, psi = -np.radians(numbers)
    x = np.array([[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]])
    y = np.array([[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]])
    z = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
    return z @ y @ x


Located = tuple[Any, FloatArray, dict[tuple[int, ...], int]]


def rectangular(lattice: ElementTree.Element, points: FloatArray) -> Located:
    """Return index and center of each point's element, and the universe of each index."""
    low, pitch = floats(lattice, "lower_left"), floats(lattice, "pitch")
    shape = [int(n) for n in floats(lattice, "dimension")]
    n = len(shape)
    indices = np.floor((points[:, :n] - low) / pitch).astype(int)
    centers = np.zeros((len(points), 3))
    centers[:, :n] = low + (indices + 0.5) * pitch
    words = np.array([int(word) for word in (value(lattice, "universes") or "").split()])
    table = words.reshape(shape[::-1])
    # the rows are listed from the top
    table = table[::-1] if n == 2 else table[:, ::-1]
    universes = {index[::-1]: int(universe) for index, universe in np.ndenumerate(table)}
    return indices, centers, universes


def hexagonal(lattice: ElementTree.Element, points: FloatArray) -> Located:
    """Return the same by the nearest center of all that may be near."""
    rings = int(value(lattice, "n_rings") or 0)
    pitch, middle = floats(lattice, "pitch"), floats(lattice, "center")
    upright = (value(lattice, "orientation") or "y").strip() == "y"
    levels = int(value(lattice, "n_axial") or 0)
    basis = np.array([[np.sqrt(0.75), 0.5], [0, 1]] if upright else [[1, 0], [0.5, np.sqrt(0.75)]]) * pitch[0]
    own = points[:, :2] - middle[:2]
    first = np.floor(own @ np.linalg.inv(basis)).astype(int)
    around = np.array([(i, j) for i in (-1, 0, 1, 2) for j in (-1, 0, 1, 2)])
    candidates = first[:, None, :] + around
    distances = ((candidates @ basis - own[:, None, :]) ** 2).sum(axis=2)
    flat = candidates[np.arange(len(points)), distances.argmin(axis=1)]
    centers = np.zeros((len(points), 3))
    centers[:, :2] = flat @ basis + middle[:2]
    # rows from the top down, each from the left: by the positions of the centers themselves
    reach = range(1 - rings, rings)
    inside = np.array([(i, j) for i in reach for j in reach if abs(i + j) < rings])
    x, y = (inside @ basis).T
    order = inside[np.lexsort((np.round(x / pitch[0], 6), -np.round(y / pitch[0], 6)))]
    words = [int(word) for word in (value(lattice, "universes") or "").split()]
    if not levels:
        return flat, centers, dict(zip(map(tuple, order.tolist()), words, strict=True))
    bottom = middle[2] - 0.5 * levels * pitch[1]
    level = np.floor((points[:, 2] - bottom) / pitch[1]).astype(int)
    centers[:, 2] = bottom + (level + 0.5) * pitch[1]
    names = [(i, j, k) for k in range(levels) for i, j in order.tolist()]
    return np.column_stack([flat, level]), centers, dict(zip(names, words, strict=True))


@functools.cache
def place_of(name: str) -> Place:
    """Return a body's name as a place: the path from outside, then the cell; "outer" for elements outside of a lattice."""
    own, _, path = name.partition(" @ ")
    way: list[Any] = []
    for step in path.replace(", lattice", "; lattice").replace(", cell", "; cell").split("; ") if path else []:
        kind, number, *rest = step.split(" ", 2)
        if kind == "cell":
            way.append(int(number))
        elif rest == ["outer"]:
            way.append((int(number), "outer"))
        else:
            way.append((int(number), *(int(i) for i in rest[0].strip("[]").split(", "))))
    return (*way, int(own.split(" ", 2)[1]))


def same_place(found: Place | None, name: str | None) -> bool:
    """Return whether a body's name is the place that the evaluator found."""
    if found is None or name is None:
        return found is None and name is None
    named = place_of(name)
    if len(named) != len(found):
        return False
    for a, b in zip(named, found, strict=True):
        outer = isinstance(a, tuple) and a[1] == "outer" and isinstance(b, tuple) and a[0] == b[0]
        if a != b and not outer:
            return False
    return True
