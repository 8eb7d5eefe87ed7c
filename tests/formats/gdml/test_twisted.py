"""Solids with twisted sides, against sections at each height."""

import numpy as np
import pytest

from .files import solid_scene
from .test_solids import DEG, in_phi, radius

BOTTOM = [(-4, -5), (-6, 4), (3, 6), (5, -3)]
TOP = [(-2, -6), (-5, 2), (2, 4), (6, -1)]


def corners(low, high):
    return " ".join(f'v{k}x="{x}" v{k}y="{y}"' for k, (x, y) in enumerate([*low, *high], 1))


def within_sections(p, low, high, half):
    """Corners go evenly from low to high; at its height a point is on one side of every edge (clockwise corners)."""
    share = ((p[:, 2] + half) / (2 * half))[:, None]
    at = [(1 - share) * a + share * b for a, b in zip(np.array(low, float), np.array(high, float), strict=True)]
    found = abs(p[:, 2]) <= half
    for a, b in zip(at, [*at[1:], at[0]], strict=True):
        d, q = b - a, p[:, :2] - a
        found &= d[:, 0] * q[:, 1] - d[:, 1] * q[:, 0] <= 0
    return found


def twisted_tube(p, twist, inner, outer, low, high, width):
    """In a section the sides are at ± width / 2 from atan(k z); radii at z = 0 grow by sqrt(1 + k² z²)."""
    z = p[:, 2]
    k = np.tan(twist / 2 * DEG) / max(abs(low), abs(high))
    grown = np.sqrt(1 + (k * z) ** 2)
    turned = np.arctan(k * z) / DEG
    inside = (z >= low) & (z <= high) & (radius(p) >= inner * grown) & (radius(p) <= outer * grown)
    return inside & (in_phi(p, turned - width / 2, width) if width < 360 else True)


C30 = np.cos(30 * DEG)
SOLIDS = {
    "arb8": (f'<arb8 name="s" {corners(BOTTOM, TOP)} dz="7"/>', lambda p: within_sections(p, BOTTOM, TOP, 7)),
    "counter-clockwise": (
        f'<arb8 name="s" {corners(BOTTOM[::-1], TOP[::-1])} dz="7"/>',
        lambda p: within_sections(p, BOTTOM, TOP, 7),
    ),
    "from an edge": (
        f'<arb8 name="s" {corners([(-4, -5), (-4, -5), (3, 6), (3, 6)], TOP)} dz="7"/>',
        lambda p: within_sections(p, [(-4, -5), (-4, -5), (3, 6), (3, 6)], TOP, 7),
    ),
    "trap": (
        '<trap name="s" z="14" y1="8" x1="4" x2="10" alpha1="0" y2="10" x3="9" x4="5" alpha2="20" aunit="deg"/>',
        lambda p: within_sections(
            p, [(-2, -4), (-5, 4), (5, 4), (2, -4)],
            [(x + y * np.tan(20 * DEG), y) for x, y in [(-4.5, -5), (-2.5, 5), (2.5, 5), (4.5, -5)]], 7,
        ),
    ),
    "twistedtubs": (
        '<twistedtubs name="s" twistedangle="60" endinnerrad="3" endouterrad="8" zlen="14" phi="70" aunit="deg"/>',
        lambda p: twisted_tube(p, 60, 3 * C30, 8 * C30, -7, 7, 70),
    ),
    "the other way": (
        '<twistedtubs name="s" twistedangle="-60" endinnerrad="3" endouterrad="8" zlen="14" phi="250" aunit="deg"/>',
        lambda p: twisted_tube(p, -60, 3 * C30, 8 * C30, -7, 7, 250),
    ),
    "segments": (
        '<twistedtubs name="s" twistedangle="60" endinnerrad="3" endouterrad="8" zlen="14" nseg="3" totphi="360"'
        ' aunit="deg"/>',
        lambda p: twisted_tube(p, 60, 3 * C30, 8 * C30, -7, 7, 120),
    ),
    "by middle radii": (
        '<twistedtubs name="s" twistedangle="100" midinnerrad="2" midouterrad="5" negativeEndz="-3" positiveEndz="8"'
        ' phi="360" aunit="deg"/>',
        lambda p: twisted_tube(p, 100, 2, 5, -3, 8, 360),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SOLIDS)
def test_a_twisted_solid_is_what_its_sections_say(tmp_path, name):
    text, inside = SOLIDS[name]
    scene = solid_scene(tmp_path, text, "s")
    assert not [note for note in scene.notes if "left out" in note]
    p = np.random.default_rng(6).uniform(-9, 9, (20_000, 3))
    expected = inside(p)
    assert 500 < expected.sum() < 15_000
    assert np.array_equal(np.asarray(scene.body_at(p)) == 0, expected)
    low, high = scene.bodies[0].shape.bounds
    assert (low >= -10).all()
    assert (high <= 10).all()
    assert (low <= p[expected].min(axis=0)).all()
    assert (high >= p[expected].max(axis=0)).all()


def test_a_section_that_bends_inward_is_left_out(tmp_path):
    # Half way the corner (2, 2) of a square is at (0, 0) - (1, 1) / 2, behind the line through its neighbours.
    low, high = [(-2, -2), (-2, 2), (2, 2), (2, -2)], [(-2, -2), (-2, 2), (-3, -3), (2, -2)]
    scene = solid_scene(tmp_path, f'<arb8 name="a" {corners(low, high)} dz="7"/><box name="s" x="1" y="1" z="1"/>', "s")
    assert any("between its ends is not convex" in note for note in scene.notes)
