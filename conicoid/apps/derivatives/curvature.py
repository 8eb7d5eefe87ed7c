"""Principal curvatures of the walls at hits, in closed form.

The shape operator of f = 0 is the Hessian, projected on the tangent plane, divided by |∇f|. Its eigenvalues are the
principal curvatures, and its eigenvectors their directions (Goldman, Curvature formulas for implicit curves and
surfaces, 2005).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..._util.arrays import FloatArray
from ...queries.tangents import Curvature
from .quadric_form import forms_of

if TYPE_CHECKING:
    from ...queries.hits import Hits

Columns: TypeAlias = list[Any]
"""One array per component: x, y and z of many vectors, or the ten numbers of many forms."""


def curvature(hits: Hits) -> Curvature:
    """Implement `Hits.curvature`."""
    shape, n = hits.rays.shape, hits.size
    columns = np.full((8, n), np.nan)
    rows = np.flatnonzero(hits._found.body >= 0)
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
    size = np.sqrt(_dot(g, g))
    n = [component / size for component in g]
    u, v = _across(n)
    au, av = _times(form, u), _times(form, v)
    scale = side / size
    # The shape operator in the basis (u, v) is [[a, b], [b, c]], with the eigenvalues middle ± radius.
    a, b, c = scale * _dot(u, au), scale * _dot(u, av), scale * _dot(v, av)
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


def _dot(a: Columns, b: Columns) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
