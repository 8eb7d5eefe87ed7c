"""Bytes of sRGB: those of the formula, on both sides of every threshold between two of them."""

import numpy as np

from conicoid.io.image_codecs import _srgb_table, srgb_bytes


def by_formula(linear):
    """IEC 61966-2-1 with NumPy's power; good to some ulp."""
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_bytes_are_the_formula_rounded():
    values = np.concatenate([np.linspace(0, 1, 200_001), np.geomspace(1e-12, 1, 100_000), [5e-324, 1e-300]])
    exact = by_formula(values)
    clear = abs(exact - np.floor(exact) - 0.5) > 1e-9  # a rounding of the formula decides the others
    assert clear.mean() > 0.99
    assert np.array_equal(srgb_bytes(values)[clear], np.rint(exact[clear]))


def test_each_byte_begins_where_the_formula_says():
    _, thresholds = _srgb_table()
    wanted = np.arange(256)[1:] - 0.5  # rounding turns up there
    assert np.abs(by_formula(thresholds[:-1]) - wanted).max() < 1e-9
    assert srgb_bytes(thresholds[:-1]).tolist() == list(range(1, 256))
    assert srgb_bytes(np.nextafter(thresholds[:-1], 0)).tolist() == list(range(255))


def test_no_beginning_holds_two_thresholds():
    below, _ = _srgb_table()
    assert np.diff(below.astype(int)).max() == 1
    assert below[0] == 0


def test_what_is_no_light_is_black_and_too_much_is_white():
    values = np.array([[np.nan, -np.inf, -1.0, -0.0], [1.0, 1.5, np.inf, 1e30]])
    assert srgb_bytes(values).tolist() == [[0] * 4, [255] * 4]
    assert srgb_bytes(values.astype(np.float32)[:, ::2]).tolist() == [[0, 0], [255, 255]]
