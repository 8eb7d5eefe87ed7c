"""Where the numbers of a beam, of the items of a tile and of lists of rays are."""

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
