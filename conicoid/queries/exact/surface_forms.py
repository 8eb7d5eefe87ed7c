"""The surfaces of a prepared scene in exact arithmetic, each computed on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...geometry.exact_crossings import IntegerForm, ball_form, surface_form

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene


def exact_form(scene: PreparedScene, surface: int) -> IntegerForm:
    """A surface of the scene's table, exactly."""
    known = scene.forms.get(surface)
    if known is None:
        exact = scene.lowered.exact
        if surface < len(exact):
            known = surface_form(exact[surface])
        else:
            x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
            known = ball_form((x, y, z), r)
        scene.forms[surface] = known
    return known
