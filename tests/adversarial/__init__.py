"""Rays that were chosen to break a tracer: through edges, rims and apexes, along faces, from walls, without end."""
