"""What may be wrong with a scene: overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits."""
