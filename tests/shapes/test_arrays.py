"""What callers pass as arrays: masked entries are found wherever they are, and are never read as NaN."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid._util.validation import is_masked

MASKED = np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0])
WHOLE = np.ma.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("values", "found"),
    [
        (MASKED, True), (WHOLE, False), ([MASKED], True), ([[1, 2, 3], MASKED], True), ((WHOLE, [1, 2, 3]), False),
        ([[1.0, 2.0, np.ma.masked]], True), ([WHOLE, [1, np.ma.masked]], True), ([[[[MASKED]]]], True),
        ([np.zeros(3)], False), ("text", False), (["text", b"bytes"], False), (range(3), False), ([], False), (3, False),
        (None, False),
    ],
)  # fmt: skip
def test_masked_entries(values, found):
    assert is_masked(values) == found


@pytest.mark.parametrize("origins", [[(0, 0, 1), (0, 0, np.ma.masked)], [np.zeros(3), MASKED]])
def test_they_are_refused_in_lists(origins):
    with pytest.raises(ValueError, match="Rays: origins must be an array of numbers .* without masked entries"):
        co.Rays(origins, (0, 0, 1))
