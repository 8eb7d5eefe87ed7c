"""Tapes: formulas that `numerics.tracing` records for one body, played for many.

`interpreter` plays them for many bodies side by side, in numbers of four floats (`registers`). What these leave
undecided is computed in 3,000 bits, a body at a time. `recordings` turns recorded tapes into arrays, and keeps those of
the process.

User: every scene of more than some bodies; factor over 3,000 bits: 170 for oblique cylinders, 70 for turned Booleans of
two leaves (processor time, one thread, 2026-11-28).
"""
