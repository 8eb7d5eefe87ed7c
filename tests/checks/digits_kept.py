"""What the conditioning report says of one shape."""

from __future__ import annotations

import math

import conicoid as co
from conicoid.apps.checks.conditioning import Conditioning, conditioning, digits

U = 2.0**-53
ALL = 53 * math.log10(2)


def only(shape: co.Shape, *others: co.Shape) -> Conditioning:
    found = conditioning(co.Scene([shape, *others]))
    assert [one.body for one in found] == list(range(1 + len(others)))
    return found[0]


def kept(shape: co.Shape) -> float:
    return float(digits(co.Scene([shape]))[0])
