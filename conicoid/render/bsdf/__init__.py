"""Into which directions surfaces and media send light on: how much, and how such directions are drawn by chance.

All is in the frame of a point: z is the normal on the side that light is followed from, and both directions, `o` back
along the path and `i` on along it, point away from the surface.
"""

from __future__ import annotations


# What happens to light at a surface: one formula, one file; materials and lights as flat records.
