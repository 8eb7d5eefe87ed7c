"""Volume, area, centroid and inertia of shapes: in closed form, or from exact chords."""
