"""Queries on a prepared scene, and their arguments and results: rays, hits, spans, crossings, distances."""
