"""The surfaces of a prepared scene in exact arithmetic, each computed on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...exact.forms import Form, ball_form, form_of

if TYPE_CHECKING:
    from ..prepared import Prepared


def form(scene: Prepared, surface: int) -> Form:
    """A surface of the scene's table, exactly."""
    known = scene.forms.get(surface)
    if known is None:
        exact = scene.lowered.exact
        if surface < len(exact):
            known = form_of(exact[surface])
        else:
            x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
            known = ball_form((x, y, z), r)
        scene.forms[surface] = known
    return known
