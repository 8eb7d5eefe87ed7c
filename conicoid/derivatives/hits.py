"""The derivatives of first hits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import lines_of
from ..engine.threads import run_chunks
from ..shapes.vector import FloatArray
from .asked import FORM, Cotangents, Tangents, array_of, change_of, handed_back, met, scene_of
from .backward import Asked, form_asked, of_crossings, of_normals, of_uv, walls_asked
from .forward import At, Columns, at_walls, moved, normals_moved, numbers_of, uv_moved
from .ties import sizes, tied_across, tied_within

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from .met import Met


def jvp(hits: Hits, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> Tangents:
    """`hits.jvp`"""
    prepared, shape, n = scene_of("jvp", hits), hits.rays.shape, hits.size
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    walls, lost = _walls(hits)
    change = change_of("jvp", prepared, hits, walls, parameters, d_parameters)
    rows = np.flatnonzero(hits._found.body >= 0)
    given, out = _Given(hits, rows), np.empty((9, len(rows)))
    do_columns, dd_columns = _turned(do, rows), _turned(dd, rows)
    blocks = walls.blocks(rows)

    def work(begin: int, end: int) -> None:
        for wall, some in blocks[begin:end]:
            with np.errstate(all="ignore"):
                at, side = given.at(walls, wall, some)
                form = None if change is None else numbers_of(change, wall)
                dt, dx = moved(at, _some(do_columns, some), _some(dd_columns, some), form)
                dn = normals_moved(at, dx, None if form is None else form[:FORM], side)
                duv = uv_moved(at, dx, None if form is None else form[FORM:], walls.angles(wall))
                _put(out, some, [dt, *dx, *dn, *duv])

    run_chunks(work, len(blocks), 1)
    parts = []
    for begin, end in ((0, 1), (1, 4), (4, 7), (7, 9)):
        found = np.full((n, end - begin), np.nan) if len(rows) < n else np.empty((n, end - begin))
        found[rows] = out[begin:end].T
        found[lost] = np.nan
        parts.append(found.reshape((*shape, end - begin)))
    return Tangents(parts[0][..., 0][()], *parts[1:])


def vjp(hits: Hits, parameters: Any, t: Any, point: Any, normal: Any, uv: Any) -> Cotangents:
    """`hits.vjp`"""
    prepared, shape, n = scene_of("vjp", hits), hits.rays.shape, hits.size
    widths = dict(t=1, point=3, normal=3, uv=2)
    given = {
        name: array_of("vjp", name, value, shape, widths[name])
        for name, value in dict(t=t, point=point, normal=normal, uv=uv).items()
    }
    active = _active(hits, [array for array in given.values() if array is not None])
    walls, lost = _walls(hits)
    lost = lost[active[lost]]
    rows = np.flatnonzero(active)
    own, of_rays = _Given(hits, rows), np.empty((6, len(rows)))
    columns = {name: _turned(array, rows) for name, array in given.items()}
    blocks = walls.blocks(rows)
    asked: list[Asked] = [Asked(wall, len(some)) for wall, some in blocks]

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            wall, some = blocks[k]
            with np.errstate(all="ignore"):
                at, side = own.at(walls, wall, some)
                wanted = {name: None if v is None else _some(v, some) for name, v in columns.items()}
                of_o, of_d = _asked_of(asked[k], at, side, walls.angles(wall), wanted)
                _put(of_rays, some, [*of_o, *of_d])

    run_chunks(work, len(blocks), 1)
    forms, maps = walls_asked(len(walls.body))
    for part in asked:
        part.put(forms, maps)
    forms[walls.place[lost]] = maps[walls.place[lost]] = np.nan
    found = handed_back("vjp", prepared, hits, walls, parameters, forms, maps)
    origins, directions = np.zeros((2, n, 3))
    origins[rows], directions[rows] = of_rays[:3].T, of_rays[3:].T
    origins[lost] = directions[lost] = np.nan
    return Cotangents(found, origins.reshape((*shape, 3)), directions.reshape((*shape, 3)))


def _asked_of(asked: Asked, at: At, side: Any, angular: Any, given: dict[str, Any]) -> tuple[Columns, Columns]:
    """Add what is asked of the walls of some crossings; what is asked of the rays' origins and directions."""
    of_x: Columns = [0.0, 0.0, 0.0] if given["point"] is None else given["point"]
    of_gradient = None
    if given["normal"] is not None:
        of_gradient, more = of_normals(at, given["normal"], side)
        of_x = [a + b for a, b in zip(of_x, more, strict=True)]
    if given["uv"] is not None:
        rows, more = of_uv(at, given["uv"], angular)
        of_x = [a + b for a, b in zip(of_x, more, strict=True)]
        for k, weight in enumerate(rows):
            asked.add_map(k, weight, at.x)
    of_value, of_o, of_d = of_crossings(at, 0.0 if given["t"] is None else given["t"][0], of_x)
    asked.forms = form_asked(at, of_value, of_gradient)
    return of_o, of_d


def _walls(hits: Hits) -> tuple[Met, Any]:
    """(the walls of hits, which of the hits have no derivative as walls tie there); kept with the hits."""
    known: tuple[Met, Any] | None = vars(hits).get("_met")
    if known is None:
        surface, face, _ = hits._faces
        known = met(hits._scene, hits._found.body, face, surface), _lost(hits)
        vars(hits)["_met"] = known
    return known


class _Given:
    """Some hits, by their rows, in columns: points, directions, t, and which side of the wall is out."""

    def __init__(self, hits: Hits, rows: Any) -> None:
        self.x, self.d = _turned(hits._points, rows), _turned(lines_of(hits.rays)[1], rows)
        self.t, self.side = hits._found.t[rows], hits._faces[2][rows]

    def at(self, walls: Met, wall: Any, some: Any) -> tuple[At, Any]:
        """(some of them on their walls, their sides)."""
        at = at_walls(walls.table, wall, _some(self.x, some), _some(self.d, some), self.t.take(some))
        return at, self.side.take(some)


def _lost(hits: Hits) -> Any:
    """Which hits are on more than one wall."""
    rows = np.flatnonzero(hits._found.body >= 0)
    surface, face, _ = hits._faces[:, rows]
    points, size = hits._points[rows], sizes(lines_of(hits.rays)[0][rows], hits._points[rows])
    tied = tied_within(hits._scene, hits._found.body[rows], face, points, size)
    tied |= tied_across(hits, rows, surface, size)
    return rows[tied]


def _turned(values: FloatArray | None, rows: Any) -> FloatArray | None:
    """Some rows of an array (n, k), or (n,), in columns (k, rows)."""
    if values is None:
        return None
    if values.ndim == 1:
        return np.ascontiguousarray(values[rows][None])
    return np.ascontiguousarray((values if len(rows) == len(values) else values[rows]).T)


def _some(columns: FloatArray | None, some: Any) -> Columns:
    """Some of each column; zeros if there are none."""
    return [0.0, 0.0, 0.0] if columns is None else [column.take(some) for column in columns]


def _put(out: FloatArray, some: Any, columns: Columns) -> None:
    for row, column in zip(out, columns, strict=True):
        row[some] = column


def _active(hits: Hits, given: list[FloatArray]) -> Any:
    """Of which rays anything is asked. Raises ValueError for what is asked of a miss."""
    active = np.zeros(hits.size, np.bool_)
    for array in given:
        for column in array.reshape(hits.size, -1).T:
            active |= column != 0
    bad = np.flatnonzero(active & (hits._found.body < 0))
    if len(bad):
        where = tuple(int(i) for i in np.unravel_index(bad[0], hits.rays.shape))
        raise ValueError(f"vjp: what is asked must be 0 for rays that hit nothing, as the ray {list(where)} does")
    return active
