"""Compiled mathematics on floats and tuples. Knows no objects, allocates nothing, raises nothing."""
