"""Scene files with mistakes, by what the mistake is in."""

from . import bodies, booleans, looks, motions, text

CASES = [case for module in (bodies, booleans, looks, motions, text) for case in module.CASES]
