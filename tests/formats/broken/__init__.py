"""Scene files with mistakes, grouped by the part that is wrong."""

from . import bodies, booleans, looks, motions, text

CASES = [case for module in (bodies, booleans, looks, motions, text) for case in module.CASES]
