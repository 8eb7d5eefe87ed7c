"""Quadric forms: surfaces as polynomials f(r) = r·A r + 2 B·r + C, r = x - anchor, about an anchor near the wall.

A form is ten numbers: (xx, yy, zz, xy, xz, yz) of A, three of B, and C. A plane has A = 0. The derivative f_p of a
surface by a parameter is a form too, about the same anchor: the wall moves by -f_p / |∇f| along its normal. Principal
curvatures of walls follow from forms in closed form. `SurfaceUsers` has the bodies of each surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from ..._util.arrays import FloatArray, unique_sorted
from ..._util.records import dataclass
from ...geometry.surface import PlaneSurface, QuadricSurface, Surface, expand_quadric
from ...kernels.programs import cells_of_leaves, leaves_of_programs
from ...kernels.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET, SPHERE, Tables
from ...numerics import bigfloat as ex
from ...numerics.rational import dot3
from ...queries.derivatives import Curvature
from ...queries.hits import Hits

FORM, MAP = 10, 12
"""Numbers of a form, and of a map to uv."""
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Indices in A of the first six numbers of a form."""


def form_of(surface: Surface, anchor: Sequence[float]) -> list[Any]:
    """Return the form of a surface about an anchor, in the numbers of the surface: floats, exact ones or duals."""
    if isinstance(surface, PlaneSurface):
        aside = tuple(ex.exact(a) - ex.exact(own) for a, own in zip(anchor, surface.anchor, strict=True))
        height = _height(surface)
        n = ex.exact_row(surface.normal)
        # f = normal·r + over. B is half the normal, since a form has 2 B·r.
        over = height + n[0] * aside[0] + n[1] * aside[1] + n[2] * aside[2]
        return [ex.ZERO] * 6 + [c * 0.5 for c in n] + [over]
    return _quadric_form(surface, anchor)


def _height(surface: PlaneSurface) -> Any:
    """Return normal·anchor - offset. It is not settled: it may be zero and yet have a derivative."""
    if surface.over is not None:
        return ex.exact(surface.over)
    n, a = ex.exact_row(surface.normal), ex.exact_row(surface.anchor)
    return n[0] * a[0] + n[1] * a[1] + n[2] * a[2] - ex.exact(surface.offset)


def _quadric_form(surface: QuadricSurface, anchor: Sequence[float]) -> list[Any]:
    """Return the form of Σ s y² + 2 b y - k with y = W r + e, e = W (anchor - own anchor)."""
    rows = [ex.exact_row(row) for row in surface.rows]
    s, b, k = ex.exact_row(surface.squares), ex.exact_row(surface.linear), ex.exact(surface.constant)
    aside = [ex.exact(a) - ex.exact(own) for a, own in zip(anchor, surface.anchor, strict=True)]
    e = [row[0] * aside[0] + row[1] * aside[1] + row[2] * aside[2] for row in rows]
    return expand_quadric(s, b, k, rows, e, ex.ZERO)


def shift_forms(forms: FloatArray, by: FloatArray) -> FloatArray:
    """Return forms (..., 10) about other anchors, which lie `by` (..., 3) from their own."""
    if not by.any():
        return forms
    second, first = matrix_of(forms), forms[..., 6:9]
    along = np.einsum("...ij,...j->...i", second, by)
    shifted = np.array(forms)
    shifted[..., 6:9] = first + along
    shifted[..., 9] += (by * (along + 2 * first)).sum(axis=-1)
    return shifted


def matrix_of(forms: FloatArray) -> FloatArray:
    """Return the matrices A (..., 3, 3) of forms (..., 10)."""
    xx, yy, zz, xy, xz, yz = (forms[..., i] for i in range(6))
    rows = (np.stack(row, axis=-1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    return np.stack(list(rows), axis=-2)


def forms_of(tables: Tables, surfaces: Any) -> tuple[FloatArray, FloatArray]:
    """Return (forms (n, 10), anchors (n, 3)) of surfaces, given by number, from the tables of a scene."""
    kinds, rows = tables.surface_kind[surfaces], tables.surface_row[surfaces]
    forms, anchors = np.zeros((len(kinds), FORM)), np.zeros((len(kinds), 3))
    flat, round_ = kinds == PLANE, kinds == SPHERE
    # Rows of planes: normal, value at the anchor, anchor.
    planes = tables.planes[rows[flat]]
    forms[flat, 6:9], forms[flat, 9], anchors[flat] = planes[:, :3] / 2, planes[:, 3], planes[:, 4:]
    # Rows of spheres: centre, which is the anchor, and radius.
    balls = tables.spheres[rows[round_]]
    forms[round_, :3], forms[round_, 9], anchors[round_] = 1.0, -(balls[:, 3] ** 2), balls[:, :3]
    rest = ~(flat | round_)
    # Rows of quadrics: anchor, W, squares s, linear b, constant k of Σ s y² + 2 b y - k, y = W r.
    quadrics = tables.whole_quadrics(rows[rest])
    w, s, b = quadrics[:, 3:12].reshape(-1, 3, 3), quadrics[:, 12:15], quadrics[:, 15:18]
    second = np.einsum("nki,nk,nkj->nij", w, s, w)
    forms[rest, :6] = np.stack([second[:, i, j] for i, j in PAIRS], axis=1)
    forms[rest, 6:9], forms[rest, 9] = np.einsum("nki,nk->ni", w, b), -quadrics[:, 18]
    anchors[rest] = quadrics[:, :3]
    return forms, anchors


def scale_between(own: FloatArray, other: FloatArray) -> FloatArray:
    """Return the factors (n,) between two forms of the same surfaces about the same anchors, own / other."""
    # Least squares over the entries of A, or over the normal of a plane.
    curved = (other[:, :6] != 0).any(axis=1)
    weight = np.where(curved[:, None], _SECOND, _FIRST)
    return (weight * own * other).sum(axis=1) / (weight * other**2).sum(axis=1)


_SECOND = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0])
_FIRST = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0])
"""Weights of the numbers of a form: those of A, where mixed terms count twice, and those of a plane's normal."""


# The bodies that have each surface


@dataclass(frozen=True)
class SurfaceUsers:
    """The bodies that have each surface, as pairs (surface, body) sorted by surface."""

    surface: Any
    body: Any

    @classmethod
    def of(cls, tables: Tables) -> SurfaceUsers:
        """Collect the pairs of balls, cells, regions, sheets and polygons."""
        kind, index, body = tables.entry_kind, tables.entry_index, np.arange(len(tables.entry_kind))
        # The index of a ball is its surface
        pairs = [(index[kind == BALL], body[kind == BALL])]
        # Surfaces of every cell: those of cell i are surface[order][first[i]:first[i + 1]]
        cell = np.repeat(np.arange(len(tables.cell_quadric)), np.diff(tables.cell_first))
        curved = np.flatnonzero(tables.cell_quadric >= 0)
        cell, surface = (
            np.concatenate([cell, curved]),
            np.concatenate([tables.plane_surface, tables.cell_quadric[curved]]),
        )
        order = np.argsort(cell, kind="stable")
        first = np.searchsorted(cell[order], np.arange(len(tables.cell_quadric) + 1))
        # Cells of every body: its own, or those of its program
        cells, owners = [index[kind == CELL]], [body[kind == CELL]]
        programs = [(index[kind == REGION], body[kind == REGION])]
        for sort, own, clip in (
            (SHEET, tables.sheet_surface, tables.sheet_program),
            (POLYGON, tables.polygon_surface, tables.polygon_program),
        ):
            pairs.append((own[index[kind == sort]], body[kind == sort]))
            clipped = clip[index[kind == sort]]
            programs.append((clipped[clipped >= 0], body[kind == sort][clipped >= 0]))
        for program, owner in programs:
            firsts, counts = (each[program] for each in leaves_of_programs(tables))
            leaves = np.repeat(firsts, counts) + _count_ranges(counts)
            cells.append(cells_of_leaves(tables, leaves))
            owners.append(np.repeat(owner, counts))
        used, by = np.concatenate(cells), np.concatenate(owners)
        counts = first[used + 1] - first[used]
        pairs.append((surface[order][np.repeat(first[used], counts) + _count_ranges(counts)], np.repeat(by, counts)))
        # Pairs as single numbers, which are sorted many times as fast as rows
        surfaces, bodies = (np.concatenate(column).astype(np.int64) for column in zip(*pairs, strict=True))
        return cls(*np.divmod(unique_sorted(surfaces * len(body) + bodies), max(len(body), 1)))

    def bodies(self, surface: int) -> Any:
        """Return the ids of the bodies that have a surface."""
        first, last = np.searchsorted(self.surface, (surface, surface + 1))
        return self.body[first:last]


def _count_ranges(counts: Any) -> Any:
    """Return 0 .. n - 1 for every n, one after the other."""
    return np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)


# Principal curvatures of the walls at hits
#
# The shape operator of f = 0 is the Hessian, projected on the tangent plane, divided by |∇f|. Its eigenvalues are the
# principal curvatures, and its eigenvectors their directions (Goldman, Curvature formulas for implicit curves and
# surfaces, 2005).

Columns: TypeAlias = list[Any]
"""One array per component: x, y and z of many vectors, or the ten numbers of many forms."""


def curvature(hits: Hits) -> Curvature:
    """Implement `Hits.curvature`."""
    shape, n = hits.rays.shape, hits.size
    columns = np.full((8, n), np.nan)
    rows = np.flatnonzero(hits._buffers.body >= 0)
    surface, _, side = hits._faces[:, rows]
    forms, anchors = forms_of(hits._scene.lowered.tables, surface)
    form = list(np.ascontiguousarray(forms.T))
    with np.errstate(all="ignore"):  # the apex of a cone has no normal: its rows become NaN
        r = list(np.ascontiguousarray((hits._points[rows] - anchors).T))
        g = [a + b for a, b in zip(_times(form, r), form[6:9], strict=True)]
        k, directions = _principal(form, g, side.astype(np.float64))
    columns[:, rows] = [*k, *directions[0], *directions[1]]
    k1, k2 = (row.reshape(shape)[()] for row in columns[:2])
    one, two = (np.ascontiguousarray(part.T).reshape((*shape, 3)) for part in (columns[2:5], columns[5:]))
    return Curvature(k1, k2, one, two)


def _principal(form: Columns, g: Columns, side: FloatArray) -> tuple[Columns, tuple[Columns, Columns]]:
    """Return ((k1, k2), their directions) from forms, half gradients g, and the side (+1 or -1) of the body."""
    size = np.sqrt(dot3(g, g))
    n = [component / size for component in g]
    u, v = _across(n)
    au, av = _times(form, u), _times(form, v)
    scale = side / size
    # The shape operator in the basis (u, v) is [[a, b], [b, c]], with the eigenvalues middle ± radius.
    a, b, c = scale * dot3(u, au), scale * dot3(u, av), scale * dot3(v, av)
    middle, half = (a + c) / 2, (a - c) / 2
    radius = np.hypot(half, b)
    # The eigenvector of the larger eigenvalue: (half + radius, b) or (b, radius - half), whichever does not cancel.
    first = half > 0
    x, y = np.where(first, half + radius, b), np.where(first, b, radius - half)
    length = np.hypot(x, y)
    round_ = length == 0  # equal curvatures: any pair of directions will do
    x, y = np.where(round_, 1.0, x / length), np.where(round_, 0.0, y / length)
    along = [x * p + y * q for p, q in zip(u, v, strict=True)]
    aside = [x * q - y * p for p, q in zip(u, v, strict=True)]
    return [middle + radius, middle - radius], (along, aside)


def _across(n: Columns) -> tuple[Columns, Columns]:
    """Return two unit vectors that are orthogonal to n and to each other.

    Source: Duff et al., Building an orthonormal basis, revisited, JCGT 2017.
    """
    x, y, z = n
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return [1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]


def _times(form: Columns, v: Columns) -> Columns:
    """Return A v."""
    xx, yy, zz, xy, xz, yz = form[:6]
    x, y, z = v
    return [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
