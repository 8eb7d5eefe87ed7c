"""Certified answers, judged: an exact oracle, rays that are hard, and what must hold for each of them.

The oracle shares no code with the library, only the user's parameters. A shape is a Boolean formula over
polynomials with rational coefficients (`forms`, `solids`, `sheets`); a ray makes quadratics of them. Signs of
discriminants, equality and order of roots are decided exactly (`exact`, python-flint); in front of that stands a
filter in double-double arithmetic with error bounds over whole arrays of rays (`wide`, `filtered`).
"""
