"""Rays against a lowered scene: the tree, the kernels, and the queries on arrays."""
