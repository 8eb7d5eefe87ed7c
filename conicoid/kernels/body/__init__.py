"""One body and one ray: cells, Boolean bodies, sheets; crossings, ties, media."""
