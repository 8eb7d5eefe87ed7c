"""Closed forms of what is turned about z through a part of a turn: cones, tubes, polycones, outlines, parts of balls.

Integrals over the profile, (r, z), times those of 1, cos φ, sin φ and their products over the azimuth.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..shapes.cone import Cone
from ..shapes.polycone import Polycone
from ..shapes.revolution import Revolution, rings_of
from ..shapes.rounded import sin_cos_degrees
from ..shapes.sphere_section import SphereSection
from ..shapes.tube import Tube
from ..shapes.vector import FloatArray
from .closed import Moments, own_area, own_moments

_NODES, _WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(3))  # exact up to degree 5


class Ring(NamedTuple):
    """Between two heights, from an inner radius to an outer one, each linear in z."""

    low: float
    high: float
    inner: tuple[float, float]
    outer: tuple[float, float]


class Azimuth(NamedTuple):
    """Integrals over the azimuth of 1, cos, sin, cos², cos sin, sin²."""

    one: float
    cos: float
    sin: float
    cos2: float
    mixed: float
    sin2: float
    is_full: bool


def azimuth(start: float, end: float) -> Azimuth:
    """From one angle to another, in degrees; of a full turn what cancels is 0 to the last bit."""
    turn = math.radians(end - start)
    if end - start == 360:
        return Azimuth(turn, 0.0, 0.0, turn / 2, 0.0, turn / 2, True)
    (s, c), (t, d) = sin_cos_degrees(start), sin_cos_degrees(end)
    double, mixed = (t * d - s * c) / 2, (t * t - s * s) / 2
    return Azimuth(turn, t - s, c - d, turn / 2 + double, mixed, turn / 2 - double, False)


def moments_of(profile: Iterable[float], about: Azimuth) -> Moments:
    """From the integrals over the profile of r, r z, r z², r², r² z, r³."""
    r, rz, rzz, rr, rrz, rrr = profile
    volume = about.one * r
    if volume == 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    mean = np.array([about.cos * rr, about.sin * rr, about.one * rz]) / volume
    xx, xy, yy, zz = about.cos2 * rrr, about.mixed * rrr, about.sin2 * rrr, about.one * rzz
    xz, yz = about.cos * rrz, about.sin * rrz
    spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / volume - np.outer(mean, mean)
    return Moments(volume, mean, spread)


def ring_sums(rings: Iterable[Ring]) -> FloatArray:
    """Integrals over the profile of r, r z, r z², r², r² z, r³, (6,), by Gauss's rule: exact here."""
    total = np.zeros(6)
    for low, high, inner, outer in rings:
        half = (high - low) / 2
        z, weight, share = low + half + half * _NODES, half * _WEIGHTS, (1 + _NODES) / 2
        a, b = (ends[0] + (ends[1] - ends[0]) * share for ends in (inner, outer))
        wide = weight * (b - a)  # kept apart, as squares of thin walls cancel
        one, two, three = wide * (a + b) / 2, wide * (a * a + a * b + b * b) / 3, wide * (a + b) * (a * a + b * b) / 4
        total += np.array([one.sum(), one @ z, one @ z**2, two.sum(), two @ z, three.sum()])
    return total


def ring_area(rings: Sequence[Ring], about: Azimuth) -> float:
    """The surface of rings from bottom to top, those that touch being one solid."""
    sides = sum(
        (ends[0] + ends[1]) / 2 * math.hypot(ends[1] - ends[0], ring.high - ring.low)
        for ring in rings
        for ends in (ring.inner, ring.outer)
    )
    below: dict[float, list[tuple[float, float]]] = {}
    above: dict[float, list[tuple[float, float]]] = {}
    for ring in rings:
        above.setdefault(ring.low, []).append((ring.inner[0], ring.outer[0]))
        below.setdefault(ring.high, []).append((ring.inner[1], ring.outer[1]))
    levels = sum(_differing(below.get(z, []), above.get(z, [])) for z in {*below, *above})
    walls = 0.0 if about.is_full else 2 * sum(_profile_area(ring) for ring in rings)
    return float(about.one * (sides + levels) + walls)


def _profile_area(ring: Ring) -> float:
    return (ring.high - ring.low) * (ring.outer[0] - ring.inner[0] + ring.outer[1] - ring.inner[1]) / 2


def _differing(one: list[tuple[float, float]], other: list[tuple[float, float]]) -> float:
    """∫ r dr over what is in one of two sets of intervals and not in the other."""
    ends = sorted({end for interval in (*one, *other) for end in interval})
    total = 0.0
    for a, b in itertools.pairwise(ends):
        inside = [any(low <= a and b <= high for low, high in intervals) for intervals in (one, other)]
        total += (b - a) * (a + b) / 2 if inside[0] != inside[1] else 0.0
    return total


def _rings(shape: Any) -> list[Ring]:
    if isinstance(shape, Tube):
        inner, outer = shape.inner_radius, shape.outer_radius
        return [Ring(0.0, shape.length, (inner, inner), (outer, outer))]
    if isinstance(shape, Cone):
        return [Ring(0.0, shape.length, (0.0, 0.0), (shape.start_radius, shape.end_radius))]
    if isinstance(shape, Polycone):
        return [Ring(a[0], b[0], (a[1], b[1]), (a[2], b[2])) for _, a, b in shape.stretches]
    return [Ring(*ring) for ring in rings_of(shape.profile)]


@own_moments.register(Tube)
@own_moments.register(Polycone)
@own_moments.register(Revolution)
@own_moments.register(Cone)
def _(shape: Any) -> Moments:
    return moments_of(ring_sums(_rings(shape)), azimuth(shape.start_angle, shape.end_angle))


@own_area.register(Tube)
@own_area.register(Polycone)
@own_area.register(Revolution)
@own_area.register(Cone)
def _(shape: Any) -> float:
    return ring_area(_rings(shape), azimuth(shape.start_angle, shape.end_angle))


@own_moments.register
def _(section: SphereSection) -> Moments:
    """∫ r dr dz and so on in polar coordinates r = ρ sin θ, z = ρ cos θ, with ρ dρ dθ in place of dr dz."""
    (s, c), (t, d) = (sin_cos_degrees(angle) for angle in section.polar)
    theta = math.radians(section.polar[1] - section.polar[0])
    a, b = section.inner_radius, section.radius
    second, third = (b - a) * (a * a + a * b + b * b) / 3, (b - a) * (a + b) * (a * a + b * b) / 4
    fourth = (b - a) * (a**4 + a**3 * b + a * a * b * b + a * b**3 + b**4) / 5
    sine, square = c - d, (theta - (t * d - s * c)) / 2
    profile = (
        second * sine, third * (t * t - s * s) / 2, fourth * (c**3 - d**3) / 3,
        third * square, fourth * (t**3 - s**3) / 3, fourth * (sine - (c**3 - d**3) / 3),
    )  # fmt: skip
    return moments_of(profile, azimuth(section.start_angle, section.end_angle))


@own_area.register
def _(section: SphereSection) -> float:
    (s, c), (t, d) = (sin_cos_degrees(angle) for angle in section.polar)
    about = azimuth(section.start_angle, section.end_angle)
    a, b = section.inner_radius, section.radius
    annulus = (b - a) * (a + b) / 2
    walls = 0.0 if about.is_full else 2 * annulus * math.radians(section.polar[1] - section.polar[0])
    return about.one * ((a * a + b * b) * (c - d) + annulus * (s + t)) + walls
