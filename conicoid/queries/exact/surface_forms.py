"""Exact forms of the surfaces of a prepared scene, each computed on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...geometry.exact_crossings import IntegerForm, ball_form, surface_form

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene


def exact_form(scene: PreparedScene, surface: int) -> IntegerForm:
    """Return the exact form of a surface, which `scene.forms` caches."""
    form = scene.forms.get(surface)
    if form is None:
        exact = scene.lowered.exact
        if surface < len(exact):
            form = surface_form(exact[surface])
        else:  # a ball, whose form follows from its record in the tables
            x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
            form = ball_form((x, y, z), r)
        scene.forms[surface] = form
    return form
