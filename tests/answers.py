"""Answers of queries, compared field by field."""

import numpy as np

import conicoid as co

FIELDS = {
    co.Hits: ("t", "body", "face", "surface", "hit", "entering", "doubtful", "t_error", "point_error", "point",
              "local_point", "normal", "uv", "name", "material"),
    co.Spans: ("offsets", "t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "t_enter_error",
               "t_exit_error", "name", "material"),
    co.Crossings: ("offsets", "t", "body", "face", "surface", "entering", "point", "normal", "t_error", "name",
                   "material"),
}  # fmt: skip


def assert_same_fields(one, other):
    """Assert that all fields of two answers have the same shapes, types and numbers."""
    for field in FIELDS[type(one)]:
        a, b = getattr(one, field), getattr(other, field)
        assert np.shape(a) == np.shape(b), field
        assert getattr(a, "dtype", None) == getattr(b, "dtype", None), field
        assert np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"), field
