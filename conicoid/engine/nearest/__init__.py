"""How far a point is from the walls of a scene: certified bounds, and the nearest points themselves."""
