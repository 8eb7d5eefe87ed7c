"""The derivatives of first hits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import lines_of
from .asked import Cotangents, Tangents, array_of, change_of, handed_back, met, scene_of
from .backward import asked_by
from .crossing import Crossings
from .forward import crossings_at, moved_by
from .ties import tied_hits

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from .met import Met


def jvp(hits: Hits, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> Tangents:
    """`hits.jvp`"""
    prepared, shape = scene_of("jvp", hits), hits.rays.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    walls, crossings = _walls(hits)
    change = change_of("jvp", prepared, hits, walls, parameters, d_parameters)
    t, *fields = moved_by(walls.rows, crossings, (change, do, dd), True)
    return Tangents(t.reshape(shape)[()], *(part.reshape((*shape, part.shape[1])) for part in fields))


def vjp(hits: Hits, parameters: Any, t: Any, point: Any, normal: Any, uv: Any) -> Cotangents:
    """`hits.vjp`"""
    prepared, shape = scene_of("vjp", hits), hits.rays.shape
    asked = [
        array_of("vjp", name, value, shape, width)
        for name, value, width in (("t", t, 1), ("point", point, 3), ("normal", normal, 3), ("uv", uv, 2))
    ]
    walls, crossings = _walls(hits)
    back, missed = asked_by(walls.rows, crossings, asked, parameters is not None)
    if missed >= 0:
        where = [int(i) for i in np.unravel_index(missed, shape)]
        raise ValueError(f"vjp: what is asked must be 0 for rays that hit nothing, as the ray {where} does")
    found = handed_back("vjp", prepared, hits, walls, parameters, back.walls)
    return Cotangents(found, back.origins.reshape((*shape, 3)), back.directions.reshape((*shape, 3)))


def _walls(hits: Hits) -> tuple[Met, Crossings]:
    """(the walls of hits, the hits as crossings on them); kept with the hits."""
    known: tuple[Met, Crossings] | None = vars(hits).get("_met")
    if known is None:
        surface, face, side = hits._faces
        walls = met(hits._scene, hits._found.body, face, surface)
        columns = walls.place, side, tied_hits(hits), hits._points, lines_of(hits.rays)[1], hits._found.t
        crossings = crossings_at(*columns)
        known = vars(hits)["_met"] = walls, crossings
    return known
