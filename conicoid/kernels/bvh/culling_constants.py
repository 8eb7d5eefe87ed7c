"""Constants of culling: the slack of every test of boxes and balls, with its reason, and the layout of beams and items.

Culling may keep items that a ray misses; it must never discard one that it meets. Its tests are rounded, by 2^-53 of
each result, so every test is loosened by more than its roundings can add up to. Error bounds of crossings are in
surface/doubt.py.
"""

from __future__ import annotations

from ..surface.doubt import RELATIVE, STARTING

BOX_SLACK = 1e-15
"""Slack of box tests as a share of |first| + |last|: both ends of a slab, (side - o) (1 / d), carry three roundings,
that of 1 / d included: 3.4e-16 of each."""

BALL_SLACK = 1e-13
"""Share of |center - o|² + r² that is added to the square of a half chord. r² - |center - foot d - o|² has some dozen
roundings of numbers up to that sum, about 1.4e-15 of it; the remaining slack moves both ends of the chord by more than
the roundings of foot and root do."""
BALL_LEAST = 1e-290
"""Absolute slack in place of `BALL_SLACK` where squares underflow."""
BALL_BOX = 1e-14
"""Share of r by which the box around a ball is widened, so that c ± r, rounded twice, contains the ball."""

ORIGIN_SLACK = STARTING * RELATIVE
"""Share of |x| by which boxes and balls are widened: the distance at which the origin of a ray may lie beside the
surface on which it starts. A ray within the outermost plane of a body would otherwise miss the body's own box."""
BOUNDS = 32 * 2.0**-53
"""Share of |x| by which boxes of leaves are wider than a shape's own bounds, which are sums of a few rounded
products."""
WALL = 1e-150
"""Least widening, for a ray within a wall at 0: times the slope `STEEPEST` it exceeds every t."""
ENTRY_SLACK = 4.0 * BOX_SLACK
"""Share of t by which the entry of a box may lie beyond the end of a ray that was shortened after the test: both are
rounded as in `BOX_SLACK`, and t stands for either."""
END, END_LEAST = 1e-15, 1e-300
"""Share of t, and least length, by which bodies are searched beyond the nearest hit, so that ties are found despite the
rounding of the sum of t and its error bound."""
STEEPEST = 1e290
"""1 / d of a ray along the walls of a box: finite, so that the ray lies on one side of each wall."""

PARALLEL = 1e-12
"""Cosine up to which axes of a quadric count as orthogonal, and planes as perpendicular to them.

This and the next constants are for the balls around cells (prepare/bvh/leaf_items.py)."""
ROUND_RAISED, ROUND_AWAY, ROUND_ROUNDED = 1e-6, 1e-9, 1e-12
"""Shares by which radii, distances and sums that cancel are raised there: far more than rounding and `PARALLEL` can
take away, whose effects are of first order in 1e-12."""

SHORT_SLACK = 2.0**-22
"""Share of |t| by which t in float32 are rounded outward (bvh/short_nodes.py): four roundings of 2^-24, as short nodes
have it."""
SHORT_NODE, SHORT_CHILDREN = 16, 10
"""Whole numbers of a short node, and where the codes of its children begin among them."""


# Layout of beams, of the items of a tile and of lists of rays

# A beam: corners of the origins, corners of the inverse directions, first and last t
LOW_O, HIGH_O, LOW_I, HIGH_I, FIRST, LAST = 0, 3, 6, 9, 12, 13
BEAM = 14  # floats of a beam

MOST_ITEMS = 4096
ITEM_ROW = MOST_ITEMS + 24  # not a multiple of a page: else all rows of an item would share a few lines of the cache
# Rows behind the six sides of the boxes: t of entry; the code of a node or leaf; the number of its box, -1 for none,
# or -2 - k where the item is ball k of that leaf
ENTERED, CODE, BOX_OR_BALL = 6 * ITEM_ROW, 7 * ITEM_ROW, 8 * ITEM_ROW
ITEMS_SIZE = 9 * ITEM_ROW
MOST_CHOSEN = 120  # most items that a packet takes at a time

FROM_THE_START = -(1 << 52)
"""Added to a ray's number on a list: it enters at t = -inf."""
