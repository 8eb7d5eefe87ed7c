"""The crossings of a ray with one entry of the scene's tree, whatever its kind, and the faces they lie on."""

from __future__ import annotations

from ...compiler.jit import helper, inline
from .. import tables as table
from ..ray import Ray, span_inverse
from ..surface.nearness import Nearness, along, at_start, beyond, lengths_of_ball, nearness_of
from ..surface.records import curved_roots, load_sphere
from ..tables import BALL, CELL, POLYGON, REGION, SHEET, Geometry, Ints, integer, whole
from ..tree.walk import scene_tree, walk
from .boolean import counts_in, left_out, put_crossing, region_crossings, region_sides, surface_of
from .cell import NO_PLACE, Spans, cell_spans, place_face
from .scratch import Scratch
from .sheet import polygon_crossings, sheet_crossings


@inline
def _end(scratch: Scratch, count: int, t: float, ray: Ray, surface: int, place: int, enters: int) -> int:
    if not counts_in(t, surface, ray):
        return count
    put_crossing(scratch, count, t, place, 1, enters)
    return count + 1


@inline
def cell_crossings(geometry: Geometry, scratch: Scratch, cell: int, ray: Ray) -> tuple[int, bool, bool]:
    """(number of crossings in (t_min, t_max), inside just after t_min, doubtful) of a single cell."""
    inverse = span_inverse(ray)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    return crossings_of_spans(geometry, scratch, ray, nearness, cell_spans(geometry, cell, ray, inverse))


@inline
def crossings_of_spans(
    geometry: Geometry, scratch: Scratch, ray: Ray, nearness: Nearness, found: Spans
) -> tuple[int, bool, bool]:
    """`cell_crossings` from the spans of the cell."""
    spans, in1, out1, a1, b1, in2, out2, a2, b2, unsure = found
    count, inside = 0, False
    for k in range(spans):
        t_in, t_out, a, b = (in1, out1, a1, b1) if k == 0 else (in2, out2, a2, b2)
        inside |= t_in <= ray[6] < t_out
        first, second = surface_of(geometry, a, t_in), surface_of(geometry, b, t_out)
        unsure |= at_start(t_in, first == ray[8], ray[6], nearness[0]) | at_start(
            t_out, second == ray[8], ray[6], nearness[0]
        )
        unsure |= beyond(t_in, nearness) | beyond(t_out, nearness)
        inside ^= left_out(t_in, first, ray) ^ left_out(t_out, second, ray)
        count = _end(scratch, count, t_in, ray, first, a, 1)
        count = _end(scratch, count, t_out, ray, second, b, 0)
    return count, inside, unsure


@inline
def ball_crossings(geometry: Geometry, scratch: Scratch, surface: int, ray: Ray) -> tuple[int, bool, bool]:
    """(number of crossings in (t_min, t_max), inside just after t_min, doubtful) of a ball."""
    inverse = span_inverse(ray)
    low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
    nearness = surface_nearness(geometry, surface, ray, inverse)
    unsure |= nearness[1] < 0.0
    if not crosses:
        return 0, False, unsure
    count, inside, doubtful = crossings_of_roots(scratch, surface, ray, nearness, low, high)
    return count, inside, unsure | doubtful


@inline
def crossings_of_roots(
    scratch: Scratch, surface: int, ray: Ray, nearness: Nearness, low: float, high: float
) -> tuple[int, bool, bool]:
    """`ball_crossings` from the roots of the ball."""
    unsure = at_start(low, surface == ray[8], ray[6], nearness[0]) | at_start(
        high, surface == ray[8], ray[6], nearness[0]
    )
    inside = (low <= ray[6] < high) ^ left_out(low, surface, ray) ^ left_out(high, surface, ray)
    count = _end(scratch, 0, low, ray, surface, NO_PLACE, 1)
    return _end(scratch, count, high, ray, surface, NO_PLACE, 0), inside, unsure


@inline
def surface_nearness(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> Nearness:
    """The nearness of a ball."""
    x, y, z, radius = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    return along(ray, inverse, lengths_of_ball(x, y, z, radius))


@inline
def entry_nearness(geometry: Geometry, entry: int, ray: Ray) -> Nearness:
    """The nearness of an entry of any kind."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    inverse = span_inverse(ray)
    if kind == BALL:
        return surface_nearness(geometry, index, ray, inverse)
    if kind == CELL:
        return nearness_of(geometry, table.CELL_LIMITS, index, ray, inverse)
    if kind == REGION:
        return nearness_of(geometry, table.PROGRAM_LIMITS, index, ray, inverse)
    if kind == SHEET:
        return nearness_of(geometry, table.SHEET_LIMITS, index, ray, inverse)
    return nearness_of(geometry, table.POLYGON_LIMITS, index, ray, inverse)


@inline
def crossed_face(geometry: Geometry, entry: int, place: int, sense: int) -> tuple[int, int, int]:
    """(surface, face number, side) of a crossing of an entry; side +1 where the gradient points out of the body."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    none, one = whole(0), whole(1)
    if kind == BALL:
        return index, none, one
    if kind == SHEET:
        return integer(geometry, table.SHEET_SURFACE, index), none, integer(geometry, table.SHEET_SIDE, index)
    if kind == POLYGON:
        return integer(geometry, table.POLYGON_SURFACE, index), none, integer(geometry, table.POLYGON_SIDE, index)
    surface, face, side = place_face(geometry, place)
    return surface, face, side * sense


@inline
def entry_crossings(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, limit: int) -> tuple[int, bool, bool]:
    """Crossings of an entry's body into scratch, in order of t: (number, inside just after t_min, doubtful)."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        return ball_crossings(geometry, scratch, index, ray)
    if kind == CELL:
        return cell_crossings(geometry, scratch, index, ray)
    if kind == REGION:
        return region_crossings(geometry, scratch, index, ray, limit)
    if kind == SHEET:
        count, unsure = sheet_crossings(geometry, scratch, index, ray)
    else:
        count, unsure = polygon_crossings(geometry, scratch, index, ray)
    return count, False, unsure


@inline
def is_solid(geometry: Geometry, entry: int) -> bool:
    return integer(geometry, table.ENTRY_KIND, entry) <= REGION


@helper
def entry_sides(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(inside just before t, inside just after t) of an entry's body; a sheet has no inside."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        low, high, _, crosses, _ = curved_roots(geometry, index, ray, span_inverse(ray))
        return crosses and low < t <= high, crosses and low <= t < high
    if kind == CELL:
        spans, in1, out1, _, _, in2, out2, _, _, _ = cell_spans(geometry, index, ray, span_inverse(ray))
        before = (spans > 0 and in1 < t <= out1) or (spans > 1 and in2 < t <= out2)
        return before, (spans > 0 and in1 <= t < out1) or (spans > 1 and in2 <= t < out2)
    if kind == REGION:
        return region_sides(geometry, scratch, index, ray, t)
    return False, False


@inline
def _sort(values: Ints, count: int) -> None:
    """Ascending, by Shell's sort."""
    gap = 1
    while gap < count // 2:
        gap = gap * 9 // 4 + 1
    while gap > 0:
        for i in range(gap, count):
            value, j = values[i], i
            while j >= gap and values[j - gap] > value:
                values[j] = values[j - gap]
                j -= gap
            values[j] = value
        gap = gap * 4 // 9


@helper
def collect(geometry: Geometry, scratch: Scratch, ray: Ray) -> int:
    """Put the entries whose boxes the ray meets within its interval into scratch, by number of body."""
    count = walk(geometry, scratch.way, scene_tree(geometry), ray, scratch.found)
    _sort(scratch.found, count)
    return count
