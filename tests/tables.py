"""Columns of the tables of prepared scenes, compared to the bit."""

import numpy as np


def columns(lowered) -> dict[str, np.ndarray]:
    """Return all columns of lowered bodies, by name."""
    own = {name: getattr(lowered, name) for name in ("boxes", "frames", "body_frame", "body_item")}
    rest = {f"rest of {name}": getattr(lowered.rest, name) for name in ("planes", "spheres", "quadrics", "vertices")}
    return lowered.tables._asdict() | own | rest


def assert_same_columns(one, other, but: set[str] = frozenset()) -> None:
    """Assert that lowered bodies have the same columns, but those that are named."""
    others = columns(other)
    for name, column in columns(one).items():
        if name not in but:
            assert (column.shape, column.dtype) == (others[name].shape, others[name].dtype), name
            assert np.ascontiguousarray(column).tobytes() == np.ascontiguousarray(others[name]).tobytes(), name
