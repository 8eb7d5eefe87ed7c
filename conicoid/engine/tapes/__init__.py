"""Formulas worked out for many bodies at once, as `shapes.traced` records them.

`wide`, `roots` and `rounding` have the numbers, of 253 bits and more with bounds; `tape` the operations on them, in a
line; `play` what Python hands over.
"""
