"""The documents that formulas come from, by the names of docs/theory.md."""

from __future__ import annotations

NOTES = "the ray tracing notes"
CLEMSON = "the Clemson notes"
SASAKI = "Sasaki 2021"
TEXTBOOK = "the graphics textbook"
ROTH = "Roth 1982"

SPHERE_ALGEBRAIC = f'{NOTES}, "ray and sphere", the algebraic method'
SPHERE_GEOMETRIC = f'{NOTES}, "ray and sphere", the geometric method'
PLANE = f'{NOTES}, "ray and plane"'
POLYGON = f'{NOTES}, "ray and polygon", even-odd'
AREAS = f"{NOTES}, barycentric coordinates"
BOX = f'{NOTES}, "ray and box"'
QUADRIC = f'{NOTES}, "ray and quadrics"; {CLEMSON} (13.3), (13.4)'
NORMAL = f'{NOTES}, "ray and quadrics", steps 6 and 7'
CYLINDER = f"{SASAKI} (2) to (10)"
CAPS = f"{CLEMSON}, caps"
FALSE = f"{TEXTBOOK}, false intersections; NA8FIR"
TOUCH = f"{TEXTBOOK}, tangency is invisibility"
ROOTS = f"{TEXTBOOK}, KVADR; Goldberg 1991"
BOOLEAN = f"{ROTH}; docs/theory.md, section 8"
MOMENT = "docs/theory.md, section 10"
STARTS = "docs/theory.md, section 12"
DOUBT = "docs/dev/exactness.md"
