"""A drawing as the text of an SVG picture: exact arcs of conics, lines, dots and labels, in itself."""

from __future__ import annotations

import html
import math
from dataclasses import dataclass, field

import numpy as np

from ..shapes.vector import FloatArray
from .arcs import Arc
from .conics import ELLIPSE, HYPERBOLA, PARABOLA

_PIECES = 24
"""Cubic pieces of an arc of a hyperbola, which SVG has no exact command for."""


@dataclass
class Drawing:
    """A window of the plane, x0 <= x <= x1 and y0 <= y <= y1, `width` pixels wide."""

    x0: float
    x1: float
    y0: float
    y1: float
    width: int
    parts: list[str] = field(default_factory=list)

    @property
    def scale(self) -> float:
        """Pixels of a unit."""
        return self.width / (self.x1 - self.x0)

    @property
    def height(self) -> int:
        return round(self.scale * (self.y1 - self.y0))

    def at(self, place: FloatArray) -> tuple[float, float]:
        """A place in pixels, y downwards."""
        x, y = float(place[0]), float(place[1])
        return (x - self.x0) * self.scale, (self.y1 - y) * self.scale

    def _told(self, place: FloatArray) -> str:
        x, y = self.at(place)
        return f"{x:.3f} {y:.3f}"

    def arc(self, arc: Arc, style: str, about: str) -> None:
        """A wall; `about` is shown where the pointer rests on it."""
        self.parts.append(f'<path d="{self.path(arc)}" fill="none" {style}><title>{html.escape(about)}</title></path>')

    def path(self, arc: Arc) -> str:
        """The commands of an arc: A, Q and L are the conics themselves."""
        branch = arc.branch
        ends = branch.points(np.array([arc.first, (arc.first + arc.last) / 2, arc.last]))
        begin, middle, end = (self._told(place) for place in ends)
        if branch.kind == ELLIPSE:
            (ux, uy), (vx, vy) = branch.frame
            turn = -math.degrees(math.atan2(uy, ux))
            sweep = 0 if ux * vy - uy * vx > 0 else 1
            radii = f"{branch.a * self.scale:.3f} {branch.b * self.scale:.3f} {turn:.4f}"
            large = 1 if (arc.last - arc.first) / 2 > math.pi else 0
            return f"M {begin} A {radii} {large} {sweep} {middle} A {radii} {large} {sweep} {end}"
        if branch.kind == PARABOLA:
            s, t = arc.first, arc.last
            own = np.array([(s + t) / 2, branch.a * s * t + branch.b])
            return f"M {begin} Q {self._told(own @ np.array(branch.frame) + np.array(branch.center))} {end}"
        if branch.kind == HYPERBOLA:
            return f"M {begin} {' '.join(self._cubics(arc))}"
        return f"M {begin} L {end}"

    def _cubics(self, arc: Arc) -> list[str]:
        """An arc of a hyperbola in pieces that have its tangents."""
        branch, frame = arc.branch, np.array(arc.branch.frame)
        s = np.linspace(arc.first, arc.last, _PIECES + 1)
        step = (arc.last - arc.first) / _PIECES / 3
        slopes = np.stack([branch.a * np.sinh(s), branch.b * np.cosh(s)], axis=-1) @ frame * step
        places = branch.points(s)
        after, before = places + slopes, places - slopes
        return [
            f"C {self._told(after[k])} {self._told(before[k + 1])} {self._told(places[k + 1])}" for k in range(_PIECES)
        ]

    def line(self, begin: FloatArray, end: FloatArray, style: str) -> None:
        """A straight line."""
        (x, y), (u, v) = self.at(begin), self.at(end)
        self.parts.append(f'<line x1="{x:.2f}" y1="{y:.2f}" x2="{u:.2f}" y2="{v:.2f}" {style}/>')

    def lines(self, pairs: list[tuple[FloatArray, FloatArray]], style: str) -> None:
        """Many straight lines as one path."""
        if pairs:
            path = " ".join(f"M {self._told(begin)} L {self._told(end)}" for begin, end in pairs)
            self.parts.append(f'<path d="{path}" fill="none" {style}/>')

    def dot(self, place: FloatArray, radius: float, style: str) -> None:
        """A disc of some pixels."""
        x, y = self.at(place)
        self.parts.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius}" {style}/>')

    def arrow(self, place: FloatArray, style: str) -> None:
        """The head of an arrow to the right."""
        x, y = self.at(place)
        self.parts.append(
            f'<path d="M {x - 10:.2f} {y - 5:.2f} L {x:.2f} {y:.2f} L {x - 10:.2f} {y + 5:.2f} Z" {style}/>'
        )

    def text(self, x: float, y: float, text: str, style: str = "") -> None:
        """A label at a pixel."""
        halo = 'stroke="#ffffff" stroke-width="3" paint-order="stroke"'
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {halo} {style}>{html.escape(text)}</text>')

    def svg(self, below: int, about: str) -> str:
        """The picture, with some pixels of room below."""
        height = self.height + below
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {height}" width="{self.width}" '
            f'height="{height}" role="img" font-family="system-ui, sans-serif" font-size="13">'
        )
        back = f'<rect width="{self.width}" height="{height}" fill="#ffffff"/>'
        return "\n".join([head, f"<title>{html.escape(about)}</title>", back, *self.parts, "</svg>"])
