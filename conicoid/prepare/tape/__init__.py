"""Tapes: formulas that `numerics.tracing` records for one body, played for many.

`interpreter` plays them for many bodies side by side, in numbers of four floats (`registers`). What these leave
undecided is computed in 3,000 bits, a body at a time. `recordings` turns recorded tapes into arrays, and keeps those of
the process.
"""
