"""The sheets: a surface, where on it the sheet is, and which way its normal points.

Crossings of a sheet are few, so each is judged by itself: it is certain if the root stands alone
and if the sheet's outline is farther from it than the displacement eta of `trace.py` can shift it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .formula import AllOf, Formula, Surface, Truth, carried, plane, quadric, slab
from .frames import Affine, axis_frame, translation
from .precision import ZERO, cross, dot, length, minus, mp, number, plus, vector
from .restricted import BAKED, BAND, Crossing, Line, Restricted
from .solids import HERE, sector


@dataclass(frozen=True, eq=False)
class Loop:
    """A closed polygon in the plane of a sheet: even-odd, by exact arithmetic in two coordinates."""

    points: tuple[tuple[Any, ...], ...]
    own: Affine = HERE

    def contains(self, point: Sequence[Any], normal: Sequence[Any]) -> bool:
        """Crossings of the half-line u > 0 by edges, v >= 0 counted as above."""
        drop = max(range(3), key=lambda i: abs(normal[i]))
        iu, iv = [i for i in range(3) if i != drop]
        odd = False
        for p, q in zip(self.points, self.points[1:] + self.points[:1], strict=True):
            pv, qv = p[iv] - point[iv], q[iv] - point[iv]
            if (pv < 0) == (qv < 0):
                continue
            pu, qu = p[iu] - point[iu], q[iu] - point[iu]
            odd ^= bool(pu - pv * (qu - pu) / (qv - pv) > 0)
        return odd

    def distance(self, point: Sequence[Any]) -> Any:
        """From a point to the nearest edge."""
        nearest = mp.inf
        for p, q in zip(self.points, self.points[1:] + self.points[:1], strict=True):
            along = minus(q, p)
            s = dot(minus(point, p), along) / dot(along, along)
            s = min(max(s, ZERO), mp.one)
            nearest = min(nearest, length(minus(point, plus(p, along, s))))
        return nearest


@dataclass(frozen=True, eq=False)
class SheetOracle:
    """`side` -1 turns the normal against the gradient of the surface; `clip` and `loop` bound the sheet."""

    surface: Surface
    clip: Formula | None = None
    loop: Loop | None = None
    side: int = 1
    one_sided: bool = False


@dataclass(frozen=True)
class SheetCrossing:
    """`certain` is None for a root that is on the sheet or not depending on the band."""

    crossing: Crossing
    slack: Any
    on: Truth


def sheet_crossings(sheet: SheetOracle, ray: Line, size: Any, reach: Any) -> list[SheetCrossing]:
    """Every root of the surface that may lie on the sheet, and every stretch that may have one; |t| < reach."""
    frames: dict[int, Any] = {}
    main = Restricted(sheet.surface, ray, size, frames)
    found = []
    doubtful = main.doubtful(reach)
    for root in main.roots:
        if abs(root) >= reach:
            continue
        holders = [span for span in doubtful if span[0] <= root <= span[1]]
        low, high = min(s[0] for s in holders), max(s[1] for s in holders)
        crossing = main.crossing(root, sheet.side, 0)
        on = _on_sheet(sheet, ray, size, (low, root, high), abs(crossing.cosine), frames)
        # a stretch that ends at +-reach leaves open which side the ray comes from
        alone = -reach < low and high < reach and sum(1 for other in main.roots if low <= other <= high) == 1
        if on is False or (sheet.one_sided and alone and crossing.cosine > 0):
            continue
        found.append(SheetCrossing(crossing, max(high - root, root - low), on if alone else None))
    for low, high in doubtful:
        if not any(low <= root <= high for root in main.roots):
            nowhere = Crossing((low + high) / 2, False, 0, ZERO)
            found.append(SheetCrossing(nowhere, (high - low) / 2, None))
    return sorted(found, key=lambda item: item.crossing.t)


def _on_sheet(
    sheet: SheetOracle, ray: Line, size: Any, around: tuple[Any, Any, Any], cosine: Any, frames: dict[int, Any]
) -> Truth:
    answers = (_in_clip(sheet, ray, size, around, frames), _in_loop(sheet, ray, size, around, cosine))
    return False if False in answers else None if None in answers else True


def _in_clip(sheet: SheetOracle, ray: Line, size: Any, around: tuple[Any, Any, Any], frames: dict[int, Any]) -> Truth:
    if sheet.clip is None:
        return True
    parts = {s: Restricted(s, ray, size, frames) for s in dict.fromkeys(sheet.clip.surfaces())}

    def below(surface: Surface, t: Any) -> Truth:
        return None if parts[surface].open_at(t) else parts[surface].below(t)

    values = {sheet.clip.truth(lambda s, t=t: below(s, t)) for t in around}
    return values.pop() if len(values) == 1 else None


def _in_loop(sheet: SheetOracle, ray: Line, size: Any, around: tuple[Any, Any, Any], cosine: Any) -> Truth:
    if sheet.loop is not None:
        own = sheet.loop.own
        point = own.point(ray.at(around[1]))
        shrink = length([x for row in own.rows for x in row])  # world distance >= own distance / shrink
        eta = BAND * (abs(around[1]) * ray.speed + size)
        if not sheet.surface.exact:
            eta += BAKED * length(ray.at(around[1]))
        normal = Restricted(sheet.surface, ray, size, {}).surface.terms
        own_normal = [sum((k for k, i, _ in normal if i == axis), ZERO) for axis in range(3)]
        if sheet.loop.distance(point) <= 4 * eta * shrink / cosine:
            return None
        return sheet.loop.contains(point, own_normal)
    return True


def clipped(sheet: SheetOracle, solid: Formula) -> SheetOracle:
    """The part of a sheet inside a solid."""
    clip = solid if sheet.clip is None else AllOf((sheet.clip, solid))
    return SheetOracle(sheet.surface, clip, sheet.loop, sheet.side, sheet.one_sided)


def sheet_carried(sheet: SheetOracle, back: Affine, exact: bool = False) -> SheetOracle:
    """Moved by the inverse of `back`. The gradient stays on its physical side, mirror or not."""
    surface = sheet.surface
    return SheetOracle(
        Surface(surface.terms, surface.own.after(back), surface.face, exact),
        None if sheet.clip is None else carried(sheet.clip, back, exact),
        None if sheet.loop is None else Loop(sheet.loop.points, sheet.loop.own.after(back)),
        sheet.side,
        sheet.one_sided,
    )


def flat(normal: Sequence[Any], offset: Any) -> Surface:
    return plane(HERE, normal, offset, 0).surface


def plane_sheet(normal: Any, offset: Any, one_sided: bool = False) -> SheetOracle:
    return SheetOracle(flat(normal, offset), one_sided=one_sided)


def disc(center: Any, normal: Any, radius: Any) -> SheetOracle:
    ball = quadric(translation(center).inverse(), (1, 1, 1), -(number(radius) ** 2))
    return SheetOracle(flat(normal, dot(vector(normal), vector(center))), clip=ball)


def polygon(vertices: Any) -> SheetOracle:
    """The vertices must be planar to the last bit: the plane is that of Newell's normal."""
    points = tuple(vector(v) for v in vertices)
    normal = (ZERO,) * 3
    for p, q in zip(points, points[1:] + points[:1], strict=True):
        normal = plus(normal, cross(p, q))
    offset = dot(normal, points[0])
    spread = max(abs(dot(normal, p) - offset) for p in points)
    assert spread <= mp.mpf(10) ** -60 * length(normal), "the reference needs exactly planar polygons"
    return SheetOracle(flat(normal, offset), loop=Loop(points))


def triangle(a: Any, b: Any, c: Any) -> SheetOracle:
    return polygon((a, b, c))


def cylinder_patch(start: Any, end: Any, radius: Any, start_angle: Any, end_angle: Any, reference: Any) -> SheetOracle:
    own = axis_frame(start, end, reference).inverse()
    height = length(minus(vector(end), vector(start)))
    wall = quadric(own, (1, 1, 0), -(number(radius) ** 2)).surface
    wedge = sector(own, start_angle, end_angle)
    return SheetOracle(wall, clip=AllOf((*slab(own, (0, height)), *([] if wedge is None else [wedge]))))


SHEETS: dict[str, Callable[..., SheetOracle]] = {
    "Plane": plane_sheet,
    "Disc": disc,
    "Triangle": triangle,
    "Polygon": polygon,
    "CylinderPatch": cylinder_patch,
}
