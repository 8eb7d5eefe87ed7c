"""The oracle itself against closed forms, so that it can fail."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co

from . import solids
from .cases import Case
from .compare import compare
from .formula import AllOf, AnyOf, Not
from .frames import chain
from .precision import mp, number
from .rays import rays
from .restricted import line
from .samples import KINDS, generator, random_case
from .sheets import cylinder_patch, disc, plane_sheet, polygon, sheet_crossings, triangle
from .trace import inside, trace

SQRT2, SQRT3 = mp.sqrt(2), mp.sqrt(3)
TINY = mp.mpf(10) ** -80


def times(formula, origin, direction, size=2, reach=100):
    return [c.t for c in trace(formula, line(origin, direction), number(size), number(reach)).crossings]


def close(found, expected):
    assert len(found) == len(expected), (found, expected)
    for a, b in zip(found, expected, strict=True):
        assert abs(a - b) <= TINY * (1 + abs(b)), (a, b)


def test_sphere_through_the_center_and_along_a_chord():
    ball = solids.sphere(radius=2, center=(1, 0, 0))
    close(times(ball, (-5, 0, 0), (1, 0, 0)), [4, 8])
    # half a chord at height 1: √(4 - 1)
    close(times(ball, (-5, 1, 0), (2, 0, 0)), [(6 - SQRT3) / 2, (6 + SQRT3) / 2])
    assert times(ball, (-5, 2, 0), (1, 0, 0)) == []  # touches


def test_ellipsoid_and_barrel():
    close(times(solids.ellipsoid((1, 2, 3)), (0, -10, 0), (0, 1, 0)), [8, 12])
    # at x = 0, y = 1: z = 3 √(1 - 1/4)
    close(times(solids.ellipsoid((1, 2, 3)), (0, 1, -5), (0, 0, 1)), [5 - 3 * SQRT3 / 2, 5 + 3 * SQRT3 / 2])
    close(times(solids.ellipsoid((1, 2, 3), (0, 0, 0), (-1, 2)), (0, 1, -5), (0, 0, 1)), [4, 7])


def test_box_diagonal():
    close(times(solids.box(), (-2, -2, -2), (1, 1, 1)), [1, 3])


def test_cylinder_in_free_orientation():
    # axis (1, 1, 0), length 2√2, radius 1; a ray along the axis, and one across at the middle
    body = solids.cylinder((0, 0, 0), (2, 2, 0), 1)
    close(times(body, (-1, -1, 0), (1, 1, 0)), [1, 3])
    close(times(body, (1, 1, -3), (0, 0, 1)), [2, 4])


def test_cylinder_wedge_angles_are_counter_clockwise():
    quarter = solids.cylinder((0, 0, 0), (0, 0, 1), 1, 0, 90, (1, 0, 7))
    assert inside(quarter, (0.5, 0.5, 0.5))
    for x, y in ((-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)):
        assert not inside(quarter, (x, y, 0.5))
    pacman = solids.cylinder((0, 0, 0), (0, 0, 1), 1, 0, 270, (1, 0, 7))
    assert [inside(pacman, (x, y, 0.5)) for x, y in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))] == [
        True,
        True,
        True,
        False,
    ]
    # y = -0.1: out of the disc at x = -√0.99, wall at 270° is x = 0
    close(times(pacman, (-2, Fraction(-1, 10), 0.5), (1, 0, 0)), [2 - mp.sqrt(mp.mpf(99)) / 10, 2])


def test_cone_radius_is_linear():
    body = solids.cone((0, 0, 0), (0, 0, 2), 1, 0.5)
    close(times(body, (-5, 0, 1), (1, 0, 0)), [number(4.25), number(5.75)])
    # in at the start cap, out by the side where r = 1 - z/4 = 0.75
    close(times(body, (0.75, 0, -1), (0, 0, 1)), [1, 2])


def test_double_cone_between_planes():
    body = solids.double_cone(slope=2, z_range=(-1, 3))
    # x = 2: cone |z| = 1 from below: outside the range at z = -1, enters at z = 1
    close(times(body, (2, 0, -10), (0, 0, 1)), [11, 13])
    assert times(body, (0, 0, -10), (0, 0, 1)) == [9, 13]


@pytest.mark.parametrize("h", [0.5, 2.0, 7.0])
def test_sections_of_canonical_quadrics(h):
    """At z = h: half axes √(h/A), √(h/E) of the paraboloid; √((1 ± H h²)/A) of the hyperboloids."""
    a, e, k = number(2.0), number(0.5), number(0.25)
    height = number(h)

    def half_axes(formula):
        along_x = times(formula, (-50, 0, h), (1, 0, 0))
        along_y = times(formula, (0, -50, h), (0, 1, 0))
        return [(along_x[1] - along_x[0]) / 2, (along_y[1] - along_y[0]) / 2] if along_x else []

    close(half_axes(solids.elliptic_paraboloid(2.0, 0.5)), [mp.sqrt(height / a), mp.sqrt(height / e)])
    close(
        half_axes(solids.SOLIDS["OneSheetHyperboloid"](2.0, 0.5, 0.25)),
        [mp.sqrt((1 + k * height**2) / x) for x in (a, e)],
    )
    two = half_axes(solids.SOLIDS["TwoSheetHyperboloid"](2.0, 0.5, 0.25))
    close(two, [mp.sqrt((k * height**2 - 1) / x) for x in (a, e)] if h > 2 else [])
    close(half_axes(solids.SOLIDS["EllipticCone"](2.0, 0.5, 0.25)), [mp.sqrt(k * height**2 / x) for x in (a, e)])
    close(half_axes(solids.elliptic_cylinder(2.0, 0.5)), [1 / mp.sqrt(a), 1 / mp.sqrt(e)])


def test_saddle_and_the_other_cylinders():
    # 2 x² - y²/2 = z: along z at (1, 1) the inside is above 3/2
    assert times(solids.hyperbolic_paraboloid(2, 0.5), (1, 1, 0), (0, 0, 1)) == [number(1.5)]
    close(times(solids.hyperbolic_cylinder(4, 1), (-5, 0, 0), (1, 0, 0)), [number(4.5), number(5.5)])
    close(times(solids.parabolic_cylinder(2), (-5, 4, 0), (1, 0, 0)), [1, 9])


def test_general_quadric_counts_products_once():
    # x y <= 1: on the diagonal, between -1 and 1
    close(times(solids.general(coefficients=dict(xy=1, constant=-1)), (-3, -3, 0), (1, 1, 0)), [2, 4])
    matrix = np.diag([1.0, 1.0, 1.0, -4.0])
    matrix[0, 3] = 2.0  # 2 x from one corner alone: the symmetric part counts
    close(times(solids.general(matrix=matrix), (-9, 0, 0), (1, 0, 0)), [8 - mp.sqrt(5), 8 + mp.sqrt(5)])


def test_motions_compose_first_to_last():
    turn = chain([("translate", (1, 0, 0)), ("rotate", (0, 0, 1), 90), ("scale", (2, 3, 4))])
    assert turn.point((0, 0, 0)) == (0, 3, 0)
    assert turn.point((0, 1, 1)) == (-2, 3, 4)
    third = chain([("rotate", (1, 1, 1), 120)])
    close(third.point((1, 2, 3)), [3, 1, 2])
    back = turn.inverse()
    close(back.point(turn.point((5, 6, 7))), [5, 6, 7])


def test_moved_solid():
    case = Case("Box", {"low": (-1, -1, -1), "high": (1, 1, 1)}, (0, 0, 0), 2, True, (("rotate", (0, 0, 1), 45),))
    close(times(case.reference(), (-5, 0, 0), (1, 0, 0)), [5 - SQRT2, 5 + SQRT2])


def test_booleans():
    a, b = solids.sphere(1), solids.sphere(1, (1, 0, 0))
    close(times(AnyOf((a, b)), (-5, 0, 0), (1, 0, 0)), [4, 7])
    close(times(AllOf((a, b)), (-5, 0, 0), (1, 0, 0)), [5, 6])
    close(times(AllOf((a, Not(b))), (-5, 0, 0), (1, 0, 0)), [4, 5])


def test_faces_and_cosines():
    found = trace(solids.box(), line((-5, 0, 0), (2, 0, 0)), number(2), number(9)).crossings
    assert [(c.entering, c.face, c.cosine) for c in found] == [(True, 0, -1), (False, 1, 1)]
    oblique = trace(solids.box(), line((-2, 0, 0), (3, 4, 0)), number(2), number(9)).crossings
    assert oblique == []
    slanted = trace(solids.half_space((0, 0, 2), 0), line((0, 0, 5), (3, 0, -4)), number(2), number(9)).crossings
    assert [c.cosine for c in slanted] == [number(Fraction(-4, 5))]


def test_disc_plane_and_polygons():
    def hits(sheet, origin, direction):
        return [
            (h.crossing.t, h.crossing.entering, h.on)
            for h in sheet_crossings(sheet, line(origin, direction), number(2), number(99))
        ]

    assert hits(plane_sheet((0, 0, 2), 4), (0, 0, 0), (0, 0, 1)) == [(2, False, True)]
    assert hits(plane_sheet((0, 0, 2), 4, one_sided=True), (0, 0, 0), (0, 0, 1)) == []
    assert hits(plane_sheet((0, 0, -2), -4, one_sided=True), (0, 0, 0), (0, 0, 1)) == [(2, True, True)]
    assert hits(disc((0, 0, 1), (0, 0, 1), 1), (0.5, 0.5, 0), (0, 0, 1)) == [(1, False, True)]
    assert hits(disc((0, 0, 1), (0, 0, 1), 1), (0.8, 0.8, 0), (0, 0, 1)) == []
    corners = ((0, 0, 0), (4, 0, 0), (0, 4, 0))
    assert hits(triangle(*corners), (1, 1, 3), (0, 0, -1)) == [(3, True, True)]
    assert hits(triangle(*corners), (3, 3, 3), (0, 0, -1)) == []
    star = polygon([(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)])
    assert hits(star, (2, 2, 3), (0, 0, -1)) == []
    assert hits(star, (2, 0.5, 3), (0, 0, -1)) == [(3, True, True)]
    assert [on for _, _, on in hits(star, (2, 1 - 2.0**-51, 3), (0, 0, -1))] == [None]


def test_patch_is_the_wall_alone():
    patch = cylinder_patch((0, 0, 0), (0, 0, 1), 1, 0, 90, (1, 0, 0))
    found = sheet_crossings(patch, line((-3, 0.6, 0.5), (1, 0, 0)), number(2), number(99))
    assert len(found) == 1
    close([found[0].crossing.t], [3 + mp.sqrt(1 - number(0.6) ** 2)])
    assert not found[0].crossing.entering


def test_the_band_of_a_sphere_is_its_inflation():
    """Past a unit sphere at height 1 + h from far away, h is in the band up to 2^-49 (distance + size)."""
    ball, ray_start, size = solids.sphere(1), number(-1000), number(2)
    eta = mp.mpf(2) ** -49 * 1002
    for h, expected in ((-1.5 * eta, False), (-0.5 * eta, True), (0.5 * eta, True), (1.5 * eta, False)):
        traced = trace(ball, line((ray_start, 1 + h, 0), (1, 0, 0)), size, number(10000))
        assert traced.in_band == expected, h
        assert len(traced.crossings) == (2 if h < 0 else 0)


def test_rim_of_a_cylinder_is_in_the_band_and_its_neighbourhood_is_not():
    """Downwards across the rim at x = -1: through the corner below it, or past it."""
    body = solids.cylinder((0, 0, 0), (0, 0, 1), 1)
    for h, expected in ((2.0**-40, False), (2.0**-51, True), (-(2.0**-51), True), (-(2.0**-40), False)):
        traced = trace(body, line((-3, 0, 2 + number(h)), (1, 0, -1)), number(2), number(99))
        assert traced.in_band == expected, h
        assert len(traced.crossings) == (2 if h > 0 else 0)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_random_cases_have_hits_misses_and_a_thin_band(kind):
    """The generators do their work: rays that hit, rays that miss, few in the band; crossings of bounded solids are even."""
    hits = misses = band = 0
    for index in range(8):
        random = generator(kind, 1000 + index)
        case = random_case(kind, random)
        reference, size = case.reference(), number(case.world_size)
        for o, d in zip(*rays(case, 8, random), strict=True):
            ray = line(o, d)
            reach = (mp.mpf(10) ** 7 * size + 2 * mp.norm(ray.origin)) / ray.speed
            if case.is_sheet:
                found = sheet_crossings(reference, ray, size, reach)
                certain = all(f.on is not None for f in found)
                count = len(found)
            else:
                traced = trace(reference, ray, size, reach)
                certain, count = not traced.in_band, len(traced.crossings)
                if case.bounded:
                    assert count % 2 == 0
            band += not certain
            hits += count > 0
            misses += count == 0
    assert hits >= 5
    assert misses >= 2
    assert band <= 20


class Wrong:
    """A library whose answers are spoilt: `spoil` changes the crossings of one ray."""

    def __init__(self, spoil):
        self.spoil = spoil

    def __getattr__(self, name):
        return getattr(co, name)

    def Scene(self, items):
        scene = co.Scene(items)

        def crossings(*rays, **limits):
            true = scene.crossings(*rays, **limits)
            t, entering, face = self.spoil(true.t.copy(), true.entering.copy(), true.face.copy())
            offsets = np.minimum(true.offsets, len(t))
            return SimpleNamespace(t=t, entering=entering, face=face, offsets=offsets)

        return SimpleNamespace(crossings=crossings, first_hit=scene.first_hit)


SPOILS = {
    "right": (lambda t, e, f: (t, e, f), ""),
    "a part in 1e12 off": (lambda t, e, f: (t * (1 + 1e-12), e, f), "wrong hit"),
    "the last is missing": (lambda t, e, f: (t[:-1], e[:-1], f[:-1]), "crossings instead of"),
    "moved far away": (lambda t, e, f: (np.where(np.arange(len(t)) == 0, t * 2, t), e, f), "wrong hit"),
    "inside out": (lambda t, e, f: (t, ~e, f), "entering is"),
    "another face": (lambda t, e, f: (t, e, f + 1), "face is"),
}


@pytest.mark.parametrize("spoil", SPOILS)
def test_the_comparison_sees_errors(spoil):
    """A ray through a box and a cylinder: every kind of error is reported as such, and a right answer is not."""
    change, complaint = SPOILS[spoil]
    for kind, parameters in (("Box", {}), ("Cylinder", {"start": (0, 0, -1), "end": (0, 0, 1), "radius": 1.0})):
        case = Case(kind, parameters, (0, 0, 0), 4)
        score = compare(case, Wrong(change), np.array([[-5.0, 0.25, 0.5]]), np.array([[2.0, 0, 0.125]]))
        assert any(complaint in failure for failure in score.failures) if complaint else not score.failures
