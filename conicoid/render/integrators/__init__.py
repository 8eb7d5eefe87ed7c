"""The ways to gather light along camera rays. An integrator is one file here and one line of the table below.

The table is data, so that messages, help and documentation can name integrators without the compiler.
docs/dev/add-an-integrator.md shows all that a file needs.
"""

from __future__ import annotations

from typing import NamedTuple


class Integrator(NamedTuple):
    """An integrator as data, before anything is compiled."""

    name: str
    about: str
    """The subject of its pictures, for help and documentation."""
    lit: bool = False
    """Does it need materials, lights and background (`samples.Settings.look`)?"""
    transports: bool = False
    """Does it need all that light transport does in their place?"""
    turns: int | None = None
    """How often it follows light at most, whatever `depth` says."""
    options: tuple[str, ...] = ()
    """Those options of `render` that mean nothing to some integrators and something to this one."""
    progressive: bool = False
    """Do its samples, those within a pixel among them, come from `sobol`, which need not know how many there are?"""
    file: str = ""
    """Its module in this folder, where that is not called as the integrator is."""

    @property
    def module(self) -> str:
        """The name of its module; integrators of one module have one kernel."""
        return self.file or self.name


INTEGRATORS = {
    each.name: each
    for each in (
        Integrator("whitted", "local light, shadows, mirrors and glass", lit=True, options=("depth",)),
        Integrator(
            "path",
            "light as it travels: lamps, soft shadows, colours that bleed, caustics; more samples, less noise",
            transports=True,
            options=("depth",),
            progressive=True,
        ),
        Integrator(
            "direct",
            "light that comes straight from lamps, lights and surroundings",
            transports=True,
            turns=1,
            progressive=True,
            file="path",
        ),
        Integrator("occlusion", "how much of an even sky each point sees", progressive=True),
        Integrator("normals", "the outward unit normal n of the first surface, as (1 + n) / 2"),
        Integrator("albedo", "the colour of the first surface, without light", lit=True),
    )
}
"""By the names that users write; the first is the default."""


def with_option(option: str) -> tuple[str, ...]:
    """The names of the integrators to which an option of `render` means something."""
    return tuple(each.name for each in INTEGRATORS.values() if option in each.options)
