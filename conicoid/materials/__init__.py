"""Materials, textures, glasses, lights and backgrounds: data only."""
