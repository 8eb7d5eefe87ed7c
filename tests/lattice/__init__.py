"""Lattices: whole numbers, small angles and shared corners, judged in exact multiquadratic arithmetic.

Origins on corners, edges and axes, directions of small whole numbers, motions by multiples of 15 degrees: here roots
coincide, discriminants vanish and rays run within faces by the thousand, as random rays never do. The oracle shares no
code with the package: `field.py` numbers a + b sqrt 2 + c sqrt 3 + ..., `columns.py` the same for many rays at once,
`shapes.py` what a user says as polynomials over that field, `lines.py` their roots on rays, `order.py` which of
them are equal and which come first, `trace.py` crossings, `judge.py` the library's answers beside them.
"""
