"""Every slack of culling: by how much tests of boxes and balls are loosened, and why that suffices.

Culling may keep what a ray misses; it must never discard what it meets. Its tests are rounded, by 2^-53 of each
result, so every test is loosened by more than its roundings can add up to. Error bounds of crossings are another
matter: see surface/doubt.py.
"""

from __future__ import annotations

from ..surface.doubt import RELATIVE, STARTING

BOX_SLACK = 1e-15
"""Share of |first| + |last| by which a ray may miss a box: both ends of a slab, (side - o) (1 / d), carry three
roundings, that of 1 / d included: 3.4e-16 of each."""

BALL_SLACK = 1e-13
"""Share of |center - o|² + r² by which the square of a half chord is raised. r² - |center - foot d - o|² has some dozen
roundings of numbers up to that sum, about 1.4e-15 of it; what is left moves both ends of the chord by more than the
roundings of foot and root move them."""
BALL_LEAST = 1e-290
"""The same where squares underflow."""
BALL_BOX = 1e-14
"""Share of r by which the box around a ball is wider, so that c ± r, twice rounded, holds the ball."""

BESIDE = STARTING * RELATIVE
"""Share of |x| by which boxes and balls are wider, as far as the origin of a ray may lie beside the surface on which it
starts: a ray within the outermost plane of a body would miss the body's own box."""
BOUNDS = 32 * 2.0**-53
"""Share of |x| by which boxes of leaves are wider than what a shape says of itself: sums of a few rounded products."""
WALL = 1e-150
"""And at least this, for a ray within a wall at 0: over the slope of `STEEPEST` it is beyond all t."""
ENTRY_SLACK = 4.0 * BOX_SLACK
"""Share of t by which a box may be entered beyond the end of a ray that may have been shortened since: both are rounded
as those of `BOX_SLACK`, and t stands for either."""
END, END_LEAST = 1e-15, 1e-300
"""Share of t, and least length, by which a body is looked for beyond the nearest hit: so a tie is among what is found,
whatever the additions of t and what it may be off by have lost."""
STEEPEST = 1e290
"""1 / d of a ray along the walls of a box, finite: it lies on one side of each."""

PARALLEL = 1e-12
"""Cosine up to which axes of a quadric count as orthogonal, and planes as perpendicular to them.

This and what follows are for the balls of prepare/bvh/leaf_items.py."""
ROUND_RAISED, ROUND_AWAY, ROUND_ROUNDED = 1e-6, 1e-9, 1e-12
"""Shares by which radii, distances and sums that cancel are raised there: far more than rounding and PARALLEL, whose
effects are of first order in 1e-12, can take away."""


# Where the numbers of a beam, of the items of a tile and of lists of rays are.

# Numbers of a beam, in the order of its block: where it starts and ends in t comes last
LOW_O, HIGH_O, LOW_I, HIGH_I, FIRST, LAST = 0, 3, 6, 9, 12, 13
BEAM = 14

MOST_ITEMS = 4096
ITEM_ROW = MOST_ITEMS + 24  # not a multiple of a page: else all rows of an item shared a few lines of the cache
# Where the rows begin, after six of the boxes' sides: where it is entered; the code of a node or leaf; the number of
# its box, -1 for none, or -2 - k where the item is ball k of that leaf
ENTERED, CODE, BOX_OR_BALL = 6 * ITEM_ROW, 7 * ITEM_ROW, 8 * ITEM_ROW
ITEMS_SIZE = 9 * ITEM_ROW
MOST_CHOSEN = 120  # items that a packet takes at a time

FROM_THE_START = -(1 << 52)
"""Added to a ray's number: it enters at t = -inf."""
