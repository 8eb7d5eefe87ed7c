"""Formulas worked out for many bodies at once, as `shapes.traced` records them.

`lanes` plays them for many bodies side by side, by the numbers in four floats of `numbers.fourfold` (`lane_rows`,
`lane_angles`). What these leave open `tape` plays, body by body: `wide`, `roots` and `rounding` have its numbers of 253
bits and more, with bounds; `cut` takes these to four floats. `play` is what Python hands over.
"""
