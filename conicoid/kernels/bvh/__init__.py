"""Bounding volume hierarchy: traversal of trees of boxes, and vector code for its culling tests.

prepare/bvh/ builds the trees.
"""
