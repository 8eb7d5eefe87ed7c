"""An integrator whose samples can be continued, from files of those that there are: for tests of films."""

from __future__ import annotations

from conicoid.integrators import INTEGRATORS, Integrator

NAME = "spread"


def register() -> None:
    """Whitted's pictures, with samples by Sobol's points."""
    INTEGRATORS[NAME] = Integrator(NAME, "for tests", lit=True, options=("depth",), progressive=True, file="wave")


def unregister() -> None:
    """As it was."""
    INTEGRATORS.pop(NAME, None)
