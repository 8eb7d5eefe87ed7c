"""Surfaces on a ray: compiled mathematics on floats and tuples, without objects, allocations or exceptions."""
