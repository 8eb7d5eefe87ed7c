"""Scene files with mistakes, by what the mistake is in; importing a module adds its cases to `CASES`."""

from . import bodies, booleans, looks, motions, text
from .case import CASES, Broken

__all__ = ["CASES", "Broken", "bodies", "booleans", "looks", "motions", "text"]
