"""Trapezoids and wedges: between a rectangle and another, or an edge, above it."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

from . import exact as ex
from .prismatoid import Level, Prismatoid, Side, finite_range, plain_map
from .validate import nonnegative, number, numbers, positive
from .vector import Interval

_HALF = 0.5


class Rectangle(NamedTuple):
    """Its ends in x and in y, exact."""

    x: tuple[Any, Any]
    y: tuple[Any, Any]

    @property
    def is_face(self) -> bool:
        """Has it an area?"""
        return bool(self.x[0] < self.x[1] and self.y[0] < self.y[1])


@dataclass(frozen=True)
class BetweenRectangles(Prismatoid, abstract=True):
    """Between two rectangles along x and y, one above the other."""

    @abstractmethod
    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        """The lower and the upper."""

    def flanks(self) -> list[Side]:
        low, high = self.rectangles()
        x, y, z = self._scales()
        return [
            Side(-1.0, 0.0, -low.x[0], -high.x[0], plain_map(y, z)),
            Side(1.0, 0.0, low.x[1], high.x[1], plain_map(y, z)),
            Side(0.0, -1.0, -low.y[0], -high.y[0], plain_map(x, z)),
            Side(0.0, 1.0, low.y[1], high.y[1], plain_map(x, z)),
        ]

    def levels(self) -> tuple[Level, Level]:
        x, y, _ = self._scales()
        low, high = (
            Level([(a, b) for a in one.x for b in one.y], plain_map(x, y), one.is_face) for one in self.rectangles()
        )
        return low, high

    def _scales(self) -> tuple[tuple[Any, ...], ...]:
        """Rows of x, y and z, each scaled over the solid to [0, 1]."""
        one, other = self.rectangles()
        found = []
        for i, (low, high) in enumerate(
            (
                (min(one.x[0], other.x[0]), max(one.x[1], other.x[1])),
                (min(one.y[0], other.y[0]), max(one.y[1], other.y[1])),
                self.heights,
            )
        ):
            size = ex.exact(high) - ex.exact(low)
            found.append((*(ex.ONE / size if i == k else ex.ZERO for k in range(3)), -ex.exact(low) / size))
        return tuple(found)


def _about(middle: Any, size: Any) -> tuple[Any, Any]:
    """The ends of a size about its middle."""
    half = ex.rational(size) * ex.rational(_HALF)
    return ex.rational(middle) - half, ex.rational(middle) + half


@dataclass(frozen=True)
class Trapezoid(BetweenRectangles):
    """Between a rectangle at the lower end of `z_range` and another at the upper, all edges straight.

    `bottom` and `top` are their sizes (x, y), the lower one about the z axis, the upper one about `shift`, (x, y).
    Sizes may be 0, but not at both ends: with a top of (0, 0) it is a pyramid, of (3, 0) it has an edge there.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 low z, 5 high z; there is none where an end has no area. uv: the
    other two coordinates, in the order x, y, z, each scaled over the solid to [0, 1], as for `Box`.
    Source: the trapezoid of detector simulation (Trd in Geant4, "Book for Application Developers", solids).
    """

    bottom: tuple[float, float]
    top: tuple[float, float]
    z_range: Interval = (-1.0, 1.0)
    shift: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("bottom", "top"):
            sizes = numbers("Trapezoid", name, getattr(self, name), 2)
            object.__setattr__(self, name, tuple(nonnegative("Trapezoid", name, size) for size in sizes))
        for k, axis in enumerate("xy"):
            if self.bottom[k] == self.top[k] == 0:
                raise ValueError(f"Trapezoid: bottom[{k}] and top[{k}], its sizes in {axis}, must not both be 0")
        object.__setattr__(self, "z_range", finite_range("Trapezoid", self.z_range))
        object.__setattr__(self, "shift", numbers("Trapezoid", "shift", self.shift, 2))

    @property
    def heights(self) -> tuple[Any, Any]:
        return ex.rational(self.z_range[0]), ex.rational(self.z_range[1])

    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        (x, y), (a, b) = self.bottom, self.top
        above = Rectangle(_about(self.shift[0], a), _about(self.shift[1], b))
        return Rectangle(_about(0.0, x), _about(0.0, y)), above


@dataclass(frozen=True)
class Wedge(BetweenRectangles):
    """A rectangle with an edge above it: a roof, a ramp, a chisel.

    The rectangle is |x| <= length / 2, |y| <= width / 2 at z = 0. The edge is along x at z = height, y = `edge_shift`,
    `edge_length` long, about x = 0; without one as long as the rectangle, so that the wedge is a triangular prism. With
    edge_shift = width / 2 one side is upright: a right-angled wedge. Volume: width height (2 length + edge_length) / 6.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 the rectangle. uv: the other two coordinates, in the order x, y, z,
    each scaled over the solid to [0, 1], as for `Box`.
    """

    length: float
    width: float
    height: float
    edge_length: float | None = None
    edge_shift: float = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "width", "height"):
            object.__setattr__(self, name, positive("Wedge", name, getattr(self, name)))
        if self.edge_length is not None:
            object.__setattr__(self, "edge_length", nonnegative("Wedge", "edge_length", self.edge_length))
        object.__setattr__(self, "edge_shift", number("Wedge", "edge_shift", self.edge_shift))

    @property
    def heights(self) -> tuple[Any, Any]:
        return ex.rational(0.0), ex.rational(self.height)

    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        edge = self.length if self.edge_length is None else self.edge_length
        shift = ex.rational(self.edge_shift)
        base = Rectangle(_about(0.0, self.length), _about(0.0, self.width))
        return base, Rectangle(_about(0.0, edge), (shift, shift))
