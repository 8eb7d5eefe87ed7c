"""Plain vectors and triangles are decided at once; what is decided so is what a closer look finds."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid._util import validation as validate

ODD: list[Any] = [
    0.0, -0.0, 1.0, -2.5, 3, True, None, "1", float("nan"), float("inf"), -float("inf"), 1e100, -1e100, 1e-100, -1e-100,
    1.0000000000000002e100, 9.999999999999999e-101, 5e-324, 1e200, np.float64(2), np.float32(2), np.int64(4), 10**400,
    Fraction(1, 2), 1j,
]  # fmt: skip


def outcome(value: Any, nonzero: bool) -> tuple[str, Any]:
    try:
        found = validate.check_vector("Sphere", "center", value, nonzero=nonzero)
    except ValueError as error:
        return "refused", str(error)
    assert all(type(x) is float for x in found)
    return "taken", list(map(str, found))


def check_alike(value: Any) -> None:
    for nonzero in (False, True):
        found = outcome(value, nonzero)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(validate, "_plain_vector", lambda _: None)
            assert outcome(value, nonzero) == found


def test_vectors_of_odd_numbers():
    for x, y in itertools.product(ODD, ODD):
        for made in (list, tuple):
            check_alike(made((x, y, 1.5)))
            check_alike(made((1.5, x, y)))
    assert outcome((0.0, -0.0, 0.0), True)[0] == "refused"


def test_vectors_of_odd_kinds():
    row = np.array([1.0, 2.0, 3.0])
    kinds = [
        row, row.astype(np.float32), row.astype(int), row.astype(bool), row[:2], row[None], np.array(1.0), row.astype(complex), row * np.nan,
        np.ma.masked_array(row, [0, 1, 0]), row.astype(object), np.array(["1", "2", "3"]), "123", b"123", {1.0, 2.0, 3.0},
        {1.0: 1, 2.0: 2, 3.0: 3}, [], (1.0, 2.0), (1.0, 2.0, 3.0, 4.0), iter([1.0, 2.0, 3.0]), 5, None, row[::-1], row.astype(">f8"),
    ]  # fmt: skip
    for value in kinds:
        if not hasattr(value, "__next__"):
            check_alike(value)
    assert outcome(row, True) == ("taken", ["1.0", "2.0", "3.0"])


def on_a_line(a: Any, b: Any, c: Any) -> bool:
    """In rational arithmetic."""
    p, q = ([Fraction(y) - Fraction(x) for x, y in zip(a, end, strict=True)] for end in (b, c))
    return all(p[i] * q[j] == p[j] * q[i] for i, j in ((0, 1), (0, 2), (1, 2)))


def triangles(seed: int) -> list[Any]:
    """Corners on a line, beside it by an ulp or a little more, of all sizes, and far off."""
    rng = np.random.default_rng(seed)
    a, step = rng.integers(-9, 10, 3) * 10.0 ** rng.integers(-3, 4), rng.normal(size=3) * 10.0 ** rng.uniform(-40, 40)
    b, c = a + step, a + step * rng.integers(-3, 4)
    bent = c * (1 + rng.integers(-1, 2, 3) * 2.0**-52)
    far = a + step * (1 + rng.normal(size=3) * 2.0 ** rng.integers(-60, 0))
    return [(a, b, corner) for corner in (a, b, c, bent, far)]


def test_flat_triangles_are_refused_and_no_others():
    taken = 0
    for corners in itertools.chain.from_iterable(map(triangles, range(200))):
        plain = [tuple(corner.tolist()) for corner in corners]
        if on_a_line(*plain):
            with pytest.raises(ValueError, match="Triangle: a, b, c must not lie on a line"):
                co.Triangle(*plain)
        else:
            taken += co.Triangle(*plain).a == plain[0]
    assert 100 < taken < 900


def test_a_colour_is_worked_out_once_and_refused_each_time():
    assert co.Body(co.Sphere(), "red").material is co.Body(co.Box(), "red").material
    for _ in range(2):
        with pytest.raises(ValueError, match="Body: material must be three linear numbers"):
            co.Body(co.Sphere(), "rad")
