"""An explanation: the steps of one ray as data, as text, as HTML, and as a figure."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .blocks import Block
from .steps import BodyStep, Crossing, Decision, SurfaceStep

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from ..scene import Scene
    from .figure import Figure


@dataclass(frozen=True)
class Explanation:
    """One ray worked out: what every body does with it, and why. `scene.explain` makes it.

    origin, direction, t_min, t_max   the ray, and the open interval that was asked for
    hit          the answer of `scene.first_hit`, which all this explains
    bodies       a `BodyStep` each: those that are met, and the first of those that are not
    missed       how many bodies more are left out by the tree of boxes
    surfaces     a `SurfaceStep` for each surface that was looked at, by its number
    crossings    all crossings in order, as `scene.crossings` has them
    decision     which formulas decided it, and with what bound

    `str()` is the text, a notebook shows it as HTML, `figure()` is a drawing.
    """

    origin: tuple[float, float, float]
    direction: tuple[float, float, float]
    t_min: float
    t_max: float
    hit: Hits
    bodies: tuple[BodyStep, ...]
    missed: int
    surfaces: dict[int, SurfaceStep]
    crossings: tuple[Crossing, ...]
    decision: Decision
    scene: Scene = field(repr=False)

    def __getitem__(self, which: Any) -> BodyStep:
        """The step of a body, by its number or name. A LookupError where it is none of `bodies`."""
        for step in self.bodies:
            if which in (step.body, step.name) and not isinstance(which, bool):
                return step
        known = ", ".join(repr(step.name) for step in self.bodies[:8])
        raise LookupError(f"explanation: no step of body {which!r}; there are {known}")

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """What is told, block by block."""
        from .telling import blocks_of

        return tuple(blocks_of(self))

    @property
    def text(self) -> str:
        """All of it for a terminal."""
        from .text import text_of

        return text_of(self.blocks)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        found = "a miss" if not self.hit.hit else f"t={float(self.hit.t)!r}"
        return f"Explanation(origin={self.origin}, direction={self.direction}, {found}; print it for all steps)"

    def figure(self, body: Any = None, width: int = 640) -> Figure:
        """A drawing of the ray in a plane: the exact sections of the bodies, and the crossings with their t.

        body: the number or name of the one through whose axis the plane goes; by default the one that is hit first.
        width: in pixels.
        """
        from .figure import figure_of

        return figure_of(self, body, width)

    @cached_property
    def svg(self) -> str:
        """`figure()` as the text of an SVG picture."""
        return self.figure().svg

    @property
    def html(self) -> str:
        """All of it as HTML in itself, with the figure: a part of a page, which asks nothing of the network."""
        from .markup import html_of

        return html_of(self.blocks, self.svg)

    def save(self, path: Any) -> None:
        """Write it to a file at `path`: as a page (.html), the drawing alone (.svg) or the text (.txt).

        Raises ValueError for other endings, OSError where it cannot be written.
        """
        from .saved import save

        save(self, path)

    def _repr_html_(self) -> str:
        return self.html


def page_of(title: str, body: str) -> str:
    """A whole page around a part of one."""
    style = "body { margin: 2rem auto; max-width: 60rem; padding: 0 1rem; }"
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{style}</style></head><body>\n{body}\n</body></html>\n"
    )


def plain(values: Any) -> tuple[float, ...]:
    """An array of floats as a tuple."""
    return tuple(np.asarray(values, np.float64).tolist())
