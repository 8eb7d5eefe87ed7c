"""How far a point is from the walls of a scene: certified bounds, and the nearest points themselves."""

from __future__ import annotations


# Lower bounds of the distance to the nearest wall, of 64 points together: what transport codes call safety.
