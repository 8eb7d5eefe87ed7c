"""Trees of boxes: how they are walked, and (in `build`) how they are built."""
