"""Light along many paths, against closed forms of optics."""

import math

import numpy as np
import pytest

import conicoid as co


def check_balance(paths, within=1e-12):
    """Check that no light is lost, and return the sums."""
    found = paths.balance()
    parts = found.escaped, found.in_media, found.at_walls, found.truncated
    assert sum(parts) == pytest.approx(found.emitted, rel=within)
    return found


def segments_of(paths, *mirrored):
    """Return the segments whose path was mirrored (True) and refracted (False) in this order, from the first wall on."""
    rows = np.flatnonzero(paths.level == 0)
    for is_mirrored in mirrored:
        rows = np.flatnonzero(np.isin(paths.parent, rows) & (paths.mirrored == is_mirrored))
    return rows


def turning_angles(paths, rows):
    """Return the angles in degrees between segments and their rays."""
    begun = paths.direction[np.argsort(paths.ray[paths.level == 0])][paths.ray[rows]]
    return np.degrees(np.arccos(np.clip((begun * paths.direction[rows]).sum(1), -1, 1)))


# ---- Angles ----


def prism(angle, glass):
    """Return a prism with its edge along z at the origin, opening downwards, and its half angle to both sides of -y."""
    half = math.radians(angle) / 2
    c, s = math.cos(half), math.sin(half)
    walls = [(c, s, 0), (-c, s, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    return co.Body(co.Polyhedron(walls, [0, 0, 4, 1, 1]), co.glass(glass))


@pytest.mark.parametrize("wavelength", [0.656, 0.589, 0.405])
@pytest.mark.parametrize("inside", [1, 2])
def test_the_rainbow(wavelength, inside):
    # Descartes: after k reflections light turns by D = k π + 2 i - 2 (k + 1) r, least where cos² i = (n² - 1) / (k (k + 2))
    n = co.optics.glass("water")(wavelength)
    cosine = math.sqrt((n * n - 1) / (inside * (inside + 2)))
    i, r = math.acos(cosine), math.asin(math.sin(math.acos(cosine)) / n)
    bow = abs(180 - (math.degrees(inside * math.pi + 2 * i - 2 * (inside + 1) * r)) % 360)
    heights = np.append(np.linspace(0.5, 0.999, 400), math.sin(i))
    rays = co.Rays(np.stack([-5 + 0 * heights, heights, 0 * heights], -1), (1, 0, 0))
    paths = co.optics.trace_paths(co.Scene([co.Body(co.Sphere(1), co.glass("water"))]), rays, 4, wavelength=wavelength)
    out = segments_of(paths, False, *[True] * inside, False)
    angles = 180 - turning_angles(paths, out)
    best = angles.max() if inside == 1 else angles.min()
    assert best == pytest.approx(bow, abs=1e-9)
    assert angles[paths.ray[out] == 400] == pytest.approx(bow, abs=1e-9)


def test_a_corner_cube_returns_light_by_total_reflection():
    third = 1 / math.sqrt(3)
    cube = co.Polyhedron([(-1, 0, 0), (0, -1, 0), (0, 0, -1), (third, third, third)], [0, 0, 0, 1])
    rng = np.random.default_rng(1)
    inward = -np.array([third] * 3) + rng.normal(0, 0.02, (50, 3))
    origins = np.array([third] * 3) * 2 + rng.normal(0, 0.05, (50, 3))
    paths = co.optics.trace_paths(co.Scene([co.Body(cube, co.glass(1.5168))]), co.Rays(origins, inward), 5)
    back = segments_of(paths, False, True, True, True, False)
    assert len(back) == 50
    assert turning_angles(paths, back) == pytest.approx(np.full(50, 180), abs=1e-5)
    # the three total reflections lose nothing
    within = segments_of(paths, False, True, True, True)
    assert paths.weight[within] == pytest.approx(paths.weight[segments_of(paths, False)][paths.ray[within]], rel=1e-15)
    check_balance(paths)


# ---- How much light ----


def slab(material, thickness=1.0):
    return co.Scene([co.Body(co.Box((-9, -9, 0), (9, 9, thickness)), material)])


DOWN = co.Rays((0.1, 0.2, 5), (0, 0, -1))


@pytest.mark.parametrize("absorption", [0.0, 0.7])
def test_a_plate_passes_the_sum_of_its_beams(absorption):
    # Without interference, and with Beer's law inside: T = (1 - R)² e / (1 - R² e²), e = exp(-α d)
    fade, share = math.exp(-absorption * 2.5), 0.04
    paths = co.optics.trace_paths(slab(co.glass(1.5, absorption=absorption), 2.5), DOWN, depth=60)
    out = paths.escaped & (paths.direction[:, 2] < 0)
    want = (1 - share) ** 2 * fade / (1 - share**2 * fade**2)
    assert paths.arriving[out].sum() == pytest.approx(want, rel=1e-14)
    assert (check_balance(paths).in_media > 0.5) == (absorption > 0)


def test_a_complex_index_absorbs_in_the_unit_of_the_scene():
    """Scenes of one plate in all units absorb alike. A scene without a unit has millimetres."""
    glass, found = co.glass(1.5 + 1e-5j), {}
    for unit, depth in ((None, 0.2), ("mm", 0.2), ("cm", 0.02), ("m", 0.2e-3), ("in", 0.2 / 25.4)):
        scene = slab(glass, depth).replace(unit=unit)
        paths = co.optics.trace_paths(scene, DOWN, depth=1, wavelength=0.5)
        inside = segments_of(paths, False)
        found[unit] = float(paths.arriving[inside][0] / paths.weight[inside][0])
    assert list(found.values()) == pytest.approx([math.exp(-4 * math.pi * 1e-5 / 0.5 * 200)] * 5, rel=1e-12)
    stated = co.optics.trace_paths(slab(glass, 0.2).replace(unit="cm"), DOWN, depth=1, wavelength=0.5, unit=1000)
    assert float(stated.arriving[inside][0] / stated.weight[inside][0]) == pytest.approx(found["mm"], rel=1e-12)


def test_mirrors_panes_and_opaque_bodies():
    scene = co.Scene([
        co.Body(co.Disc((0, 0, 3), (0, 0, 1), 1), co.Material(reflectivity=0.5, transparency=0.9)),
        co.Body(co.Disc((0, 0, 1), (0, 0, 1), 1), co.mirror(0.8)), co.Body(co.Disc((0, 0, 9), (0, 0, 1), 1), co.matte("red")),
    ])  # fmt: skip
    found = check_balance(co.optics.trace_paths(scene, DOWN, depth=1))
    assert found.at_walls == pytest.approx(0.5 * 0.1)
    paths = co.optics.trace_paths(scene, DOWN, depth=6)
    assert paths.weight[segments_of(paths, False, True)] == pytest.approx(0.45 * 0.8)
    assert paths.weight[segments_of(paths, True)] == pytest.approx(0.5)
    assert (paths.wall[segments_of(paths, True)] == 2).all()
    check_balance(paths)


def nested():
    """Return a ball of glass in a shell in water on an opaque floor, and a bubble."""
    return co.Scene([
        co.Body(co.Sphere(0.4, (0.2, 0, 0)), co.glass(1.0)), co.Body(co.Sphere(1), co.glass("N-SF11")),
        co.Body(co.Sphere(1.5), co.glass(1.6, absorption=0.05)), co.Body(co.Box((-3, -3, -3), (3, 3, 3)), co.glass("water")),
        co.Body(co.Box((-3, -3, -4), (3, 3, -3)), co.materials.conductor()), co.Body(co.Box((3, -3, -3), (4, 3, 3)), co.glass(1.4)),
    ])  # fmt: skip


def test_no_light_is_lost_over_twelve_levels_of_splitting():
    rng = np.random.default_rng(3)
    rays = co.Rays(rng.uniform(-2.5, 2.5, (40, 3)), rng.normal(size=(40, 3)))
    paths = co.optics.trace_paths(nested(), rays, depth=12, wavelength=rng.uniform(0.4, 0.7, 40))
    assert paths.level.max() == 12
    assert len(paths) > 10_000
    check_balance(paths)
    # and at each wall by itself
    shares = np.zeros(len(paths))
    np.add.at(shares, paths.parent[paths.parent >= 0], paths.weight[paths.parent >= 0])
    ends = ~paths.escaped
    left = paths.arriving - shares - paths.deposited - paths.lost
    assert np.abs(left[ends]).max() < 1e-15
    # children begin where their parents end
    child = np.flatnonzero(paths.parent >= 0)
    assert (paths.start[child] == paths.end[paths.parent[child]]).all()
    assert np.linalg.norm(paths.direction, axis=1) == pytest.approx(np.ones(len(paths)), rel=1e-14)


def test_choosing_is_right_on_average_and_comes_again():
    scene, rays = nested(), co.Rays(np.tile((0.1, 2.0, 5.0), (4000, 1)), (0.05, -0.3, -1))
    split = co.optics.trace_paths(scene, rays[:1], depth=14).balance()
    chosen = co.optics.trace_paths(scene, rays, depth=14, split=False, seed=1)
    again = co.optics.trace_paths(scene, rays, depth=14, split=False, seed=1)
    other = co.optics.trace_paths(scene, rays, depth=14, split=False, seed=2)
    assert (chosen.weight == again.weight).all()
    assert (chosen.parent == again.parent).all()
    assert len(chosen) != len(other) or (chosen.weight != other.weight).any()
    found = check_balance(chosen)
    sigma = np.sqrt(4000) * 0.5
    assert abs(found.escaped - 4000 * split.escaped) < 6 * sigma
    assert abs(found.at_walls - 4000 * split.at_walls) < 6 * sigma
    assert (np.bincount(chosen.parent[chosen.parent >= 0]) <= 1).all()  # one follows each


def test_weak_light_is_not_followed():
    all_of_it = co.optics.trace_paths(slab(co.glass(1.5)), DOWN, depth=20)
    most = co.optics.trace_paths(slab(co.glass(1.5)), DOWN, depth=20, least=0.01, weight=5.0)
    assert len(most) < len(all_of_it)
    assert (most.weight >= 0.05).all()
    assert check_balance(most).truncated > 0
    assert most.balance().emitted == 5


# ---- Where it goes ----


def test_an_ellipse_brings_light_from_one_focus_to_the_other_by_equal_ways():
    # half axes 5, 3: foci at ±4, every path is 10
    rng = np.random.default_rng(0)
    scene = co.Scene([co.Body(co.Ellipsoid((5, 3, 3)), co.mirror(1.0))])
    paths = co.optics.trace_paths(scene, co.Rays((-4, 0, 0), rng.normal(size=(100, 3))), depth=1)
    back = segments_of(paths, True)
    middle = paths.start[back]
    to_focus = np.array((4, 0, 0)) - middle
    assert np.abs(np.cross(paths.direction[back], to_focus)).max() < 1e-12
    ways = paths.length[paths.parent[back]] + np.linalg.norm(to_focus, axis=1)
    assert ways == pytest.approx(np.full(100, 10.0), rel=1e-14)


def test_a_hyperbolic_face_brings_parallel_light_to_its_far_focus():
    # Descartes: glass of index n behind z²/a² - r²/b² = 1, z <= -a, of eccentricity n; the other focus is at n a
    a, n = 2.0, 1.5168
    wide = 1 / (a * a * (n * n - 1))
    glass = co.TwoSheetHyperboloid(wide, wide, 1 / (a * a)) & co.HalfSpace((0, 0, 1), 0)
    starts = np.stack([np.linspace(-1.5, 1.5, 31), np.full(31, 0.2), np.full(31, -9.0)], -1)
    paths = co.optics.trace_paths(co.Scene([co.Body(glass, co.glass(n))]), co.Rays(starts, (0, 0, 1)), depth=1)
    assert (paths.body[paths.level == 0] == 0).all()
    out = segments_of(paths, False)
    to_focus = np.array((0, 0, n * a)) - paths.start[out]
    assert np.abs(np.cross(paths.direction[out], to_focus)).max() < 1e-12
    ways = paths.optical_path_from_start[paths.parent[out]] + np.linalg.norm(to_focus, axis=1)
    assert ways == pytest.approx(np.full(31, n * (9 - a) + n * a + a), rel=1e-14)


def test_cemented_and_immersed_bodies_have_one_wall():
    block = co.Box((-1, -1, 0), (1, 1, 1))
    below = co.Box((-1, -1, -1), (1, 1, 0))
    for other, bodies, lengths in ((1.5, [-1, 1, -1], [4, 2]), (1.6, [-1, 0, 1, -1], [4, 1, 1])):
        scene = co.Scene([co.Body(block, co.glass(1.5)), co.Body(below, co.glass(other))])
        paths = co.optics.trace_paths(scene, DOWN, depth=3)
        (through,) = segments_of(paths, *[False] * (len(bodies) - 1))
        chain = paths.chain(int(through))
        assert paths.escaped[through]
        assert paths.body[chain].tolist() == bodies  # of two that are the same to light the last
        assert paths.length[chain[:-1]].tolist() == lengths


def test_paths_end_at_opaque_neighbours():
    scene = co.Scene([co.Body(co.Box((-1, -1, 0), (1, 1, 1)), co.glass(1.5)),
                      co.Body(co.Box((-1, -1, -1), (1, 1, 0)), co.matte("black"))])  # fmt: skip
    for listed in (scene, co.Scene(list(scene.bodies)[::-1])):
        paths = co.optics.trace_paths(listed, DOWN, depth=4)
        assert segments_of(paths, False, False).size == 0
        assert check_balance(paths).at_walls == pytest.approx(0.96)


def test_fields_shapes_and_drawing():
    rays = co.Rays(np.zeros((2, 3, 3)) + (0, 0, 5), (0, 0, -2))
    paths = co.optics.trace_paths(slab(co.glass("N-BK7")), rays, depth=3, wavelength=[0.4, 0.5, 0.6])
    assert paths.ray[paths.level == 0].tolist() == list(range(6))
    assert paths.wavelength[:6].tolist() == [0.4, 0.5, 0.6] * 2
    inside = segments_of(paths, False)
    assert paths.index[inside] == pytest.approx(co.optics.glass("N-BK7")(paths.wavelength[inside]))
    assert (paths.body[inside] == 0).all()
    assert (paths.wall[inside] == 0).all()
    assert paths.length[inside] == pytest.approx(np.ones(6))
    assert np.isnan(paths.end[paths.escaped]).all()
    assert np.isinf(paths.length[paths.escaped]).all()
    assert paths.lines(2.0).shape == (len(paths), 2, 3)
    assert paths.chain(len(paths) - 1)[0] in range(6)
    assert repr(paths) == f"Paths({len(paths)} segments of 6 rays)"
    with pytest.raises(ValueError, match="read-only"):
        paths.weight[0] = 2
    assert len(co.optics.trace_paths(co.Scene([]), rays, depth=3)) == 6
    assert len(co.optics.trace_paths(co.Scene([]), co.Rays(np.zeros((0, 3)), np.zeros((0, 3))))) == 0


# --- Coats of single surfaces of lenses: shares on the axis by Fresnel's formula and that of a film of a quarter wave

CROWN, FLINT, FILM = (float(co.optics.glass(name)(0.55)) for name in ("N-BK7", "SF5", "MgF2"))
BARE = [((a - b) / (a + b)) ** 2 for a, b in ((1, CROWN), (CROWN, FLINT), (FLINT, 1))]
COATED = [((a * b - FILM**2) / (a * b + FILM**2)) ** 2 for a, b in ((1, CROWN), (CROWN, FLINT), (FLINT, 1))]
SURFACES = dict(radii=(62.8, -45.7, -128.2), thicknesses=(4, 2.5), diameter=20, materials=("N-BK7", "SF5"))


def _rows(coats):
    media, ends = (*SURFACES["materials"], None), (*SURFACES["thicknesses"], 90)
    rows = [
        dict(radius=radius, thickness=thickness, medium=medium, diameter=20, coating=coat)
        for radius, thickness, medium, coat in zip(SURFACES["radii"], ends, media, coats, strict=True)
    ]
    return co.optics.prescription(rows, 10.0).scene


@pytest.mark.parametrize("doublet", [lambda coats: co.Scene([*co.Doublet(**SURFACES, coatings=coats)]), _rows])
@pytest.mark.parametrize("coated", [(), (0,), (2,), (0, 2), (1,), (0, 1, 2)])
def test_each_surface_of_a_doublet_mirrors_by_its_own_coat(doublet, coated):
    coat = co.optics.Coating.quarter_wave([FILM], 0.55)
    scene = doublet([coat if k in coated else None for k in range(3)])
    paths = co.optics.trace_paths(scene, co.Rays([(0, 0, -20)], (0, 0, 1)), depth=3, wavelength=0.55)
    left, expected = 1.0, []
    for k in range(3):
        share = (COATED if k in coated else BARE)[k]
        expected.append(left * share)
        left *= 1 - share
    # A ray that a surface k mirrored first has left at level k + 1, on its way back
    for k, weight in enumerate(expected):
        mirrored = (paths.level == k + 1) & (paths.direction[:, 2] < 0) & np.isclose(paths.weight, weight, rtol=1e-9)
        assert mirrored.sum() == 1, (k, weight, paths.weight)


PANE, COAT = slab(co.glass("N-BK7")), co.optics.Coating.quarter_wave([1.38], 0.55)
ROWS = [
    dict(radius=50, thickness=4, medium=1.5, diameter=10),
    dict(radius=-50, thickness=9, diameter=10),
    dict(coating=COAT),
]
REFUSED = [
    *((lambda options=options: co.optics.trace_paths(PANE, DOWN, **options), message) for options, message in (
        (dict(wavelength=588.0), r"trace_paths: wavelength must be in μm, 0.5876 for the line d, got 588"),
        (dict(wavelength=5.88), r"'N-BK7': wavelength must be in \[0.3, 2.5\] μm"),
        (dict(wavelength=-1), "trace_paths: wavelength must be in μm"), (dict(weight=-1), "weight must be finite and >= 0"),
        (dict(depth=-1), "trace_paths: depth must be"), (dict(wavelength=[0.5, 0.6]), "wavelength must be one number, or one"),
        (dict(least=-1), "trace_paths: least must be >= 0"), (dict(unit=0), "trace_paths: unit must be > 0"))),
    (lambda: co.optics.trace_paths([], DOWN), "trace_paths: scene must be a Scene, got"),
    (lambda: co.optics.trace_paths(PANE, (0, 0, 1)), "trace_paths: rays must be a Rays"),
    (lambda: co.optics.prescription(ROWS, 4.0).bodies, r"rows\[2\]: coating must be None where there is no glass"),
    (lambda: co.optics.Row(medium="mirror", coating=COAT), "Row: coating must be None for a mirror"),
    (lambda: co.optics.Row(medium=1.5, coating=1.38), r"Row: coating must be a co\.optics\.Coating"),
    (lambda: co.Doublet(**SURFACES, coatings=[COAT]), "LensGroup: coatings must be 3 entries"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_impossible_paths_and_coats_are_refused(call, message):
    with pytest.raises((ValueError, TypeError), match=message):
        call()
