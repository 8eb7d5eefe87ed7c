"""Optiland's non-sequential tracer on Conicoid's geometry, with the real package."""

import numpy as np
import pytest

import conicoid as co

pytest.importorskip("optiland.nonsequential")

from optiland.coordinate_system import CoordinateSystem
from optiland.nonsequential import (
    CollimatedSourceConfig,
    DoubletConfig,
    IrradianceDetectorConfig,
    LensConfig,
    MirrorConfig,
    NSQMaterial,
    NSQScene,
    NumpyBackend,
    RayDatabaseConfig,
    Spectrum,
    Volume,
)
from optiland.nonsequential.sources.configs import PointSourceConfig

RAYS = 3000


def scene(z, radius=5.0, detector=60.0):
    """Return a source of parallel light at z = -20, and a detector, behind which nothing stands."""
    simulation = NSQScene()
    spectrum = Spectrum.monochromatic(0.5876)
    simulation.add_source(
        "sun", CoordinateSystem(z=-20), CollimatedSourceConfig(spectrum=spectrum, aperture_radius=radius)
    )
    simulation.add_detector("screen", CoordinateSystem(z=z), RayDatabaseConfig(width=detector, height=detector))
    simulation.add_detector(
        "behind",
        CoordinateSystem(z=-30, ry=np.pi),
        IrradianceDetectorConfig(width=400, height=400, num_pixels_x=8, num_pixels_y=8),
    )
    return simulation


def places_on_screen(result):
    """Return the places of rays on the screen, by the numbers of the rays."""
    rays = result.detectors["screen"]
    order = np.lexsort((np.asarray(rays.y), np.asarray(rays.x)))
    return np.column_stack([np.asarray(rays.x), np.asarray(rays.y)])[order], np.asarray(rays.flux)[order]


def simulate(simulation, **options):
    """Run one simulation, with its random numbers, by Optiland alone and by Conicoid."""
    theirs = simulation.trace(RAYS, seed=7, backend=NumpyBackend(seed=7), **options)
    ours = simulation.trace(RAYS, seed=7, backend=co.optics.OptilandBackend(seed=7), **options)
    return theirs, ours


def same(theirs, ours):
    """Compare the totals to rounding: the two differ in the last bits of places of rays."""
    for name in (
        "total_flux_in",
        "total_flux_detected",
        "total_flux_escaped",
        "total_flux_absorbed",
        "total_flux_lost",
    ):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-9, abs=1e-9), name
    assert ours.num_rays_escaped == theirs.num_rays_escaped
    assert ours.flux_conservation_error < 1e-12
    (mine, flux), (its, its_flux) = places_on_screen(ours), places_on_screen(theirs)
    assert mine.shape == its.shape
    assert mine == pytest.approx(its, abs=1e-7)
    assert flux == pytest.approx(its_flux, rel=1e-9)


@pytest.mark.parametrize("conics", [(0.0, 0.0), (-0.6, -2.0)])
def test_a_lens_of_optilands_is_traced_alike(conics):
    simulation = scene(50)
    simulation.add_lens(
        "lens", CoordinateSystem(z=3, rx=0.05), LensConfig(50, -60, 6, "N-BK7", 10, conic1=conics[0], conic2=conics[1])
    )
    same(*simulate(simulation))


def test_a_doublet_and_a_mirror_of_optilands_are_traced_alike():
    simulation = scene(-5, detector=300)
    simulation.add_doublet(
        "doublet", CoordinateSystem(z=0), DoubletConfig(61.5, -44.6, -130, 6, 2.5, "N-BK7", "N-SF5", 12)
    )
    simulation.add_mirror(
        "mirror", CoordinateSystem(z=40), MirrorConfig(radius=-80, conic=-1, aperture_radius=15, reflectance=0.9)
    )
    same(*simulate(simulation))


def test_a_lens_written_for_optiland_is_equal():
    """One closed solid stands in place of three surfaces."""
    built, message = scene(50), scene(50)
    built.add_lens("lens", CoordinateSystem(z=3), LensConfig(50, -60, 6, "N-BK7", 10))
    message.add_component(
        "lens", co.optics.optiland_component(co.Lens(50, -60, 6, 20), "N-BK7", cs=CoordinateSystem(z=3))
    )
    theirs = built.trace(RAYS, seed=7, backend=NumpyBackend(seed=7))
    for backend in (co.optics.OptilandBackend(seed=7), NumpyBackend(seed=7)):
        same(theirs, message.trace(RAYS, seed=7, backend=backend))


def test_booleans_that_optiland_refuses():
    """A ball lens has a bore. Outside of it rays go as through the ball, and inside of it straight on."""
    with pytest.raises(NotImplementedError):
        Volume.difference()
    with pytest.raises(NotImplementedError):
        Volume.intersection()
    glass = NSQMaterial.from_glass("N-BK7")
    ball, bored = scene(30, radius=4, detector=200), scene(30, radius=4, detector=200)
    bore = co.Cylinder((0, 0, -12), (0, 0, 12), 2)
    ball.add_component("ball", co.optics.optiland_component(co.Sphere(10), glass))
    bored.add_component("ball", co.optics.optiland_component(co.Sphere(10) - bore, glass))
    whole, pierced = (
        simulation.trace(RAYS, seed=3, backend=co.optics.OptilandBackend(seed=3)) for simulation in (ball, bored)
    )
    alone = bored.trace(RAYS, seed=3, backend=NumpyBackend(seed=3))
    assert pierced.total_flux_detected == pytest.approx(alone.total_flux_detected, rel=1e-9)
    assert pierced.flux_conservation_error < 1e-12
    rays = pierced.detectors["screen"]
    x, y, ways = np.asarray(rays.x), np.asarray(rays.y), np.asarray(rays.N)
    straight = ways == 1
    assert np.hypot(x, y)[straight].max() < 2
    # of a beam of radius 4 a quarter goes through the bore of radius 2
    assert straight.sum() / RAYS == pytest.approx(0.25, abs=0.03)
    focused = places_on_screen(whole)[0]
    assert len(focused) > 0.9 * RAYS


def test_no_light_leaks_between_three_touching_parts():
    """Half a ball stands on a plate, flush. Their union is one body, and the shared wall is not a surface."""
    simulation = scene(30, radius=3, detector=200)
    dome = (co.Sphere(6) & co.HalfSpace((0, 0, 1), 0)) | co.Cylinder((0, 0, 0), (0, 0, 2), 6)
    simulation.add_component("dome", co.optics.optiland_component(dome, "N-BK7"))
    lens = scene(30, radius=3, detector=200)
    lens.add_component("dome", co.optics.optiland_component(co.Lens(6, np.inf, 8, 12).translate((0, 0, -6)), "N-BK7"))
    one, other = (each.trace(RAYS, seed=5, backend=co.optics.OptilandBackend(seed=5)) for each in (simulation, lens))
    same(other, one)


def test_light_from_within_and_thin_walls():
    """A source is in a hollow ball thinner than 1e-9, by which Optiland distinguishes a ray's start from a hit."""
    source = NSQScene()
    source.add_source(
        "spark", CoordinateSystem(), PointSourceConfig(spectrum=Spectrum.monochromatic(0.5876), half_angle_deg=30)
    )
    source.add_detector("screen", CoordinateSystem(z=30), RayDatabaseConfig(width=200, height=200))
    shell = co.Sphere(5 + 1e-10) - co.Sphere(5)
    source.add_component("shell", co.optics.optiland_component(shell, "N-BK7"))
    result = source.trace(500, seed=1, backend=co.optics.OptilandBackend(seed=1))
    rays = result.detectors["screen"]
    # Straight through, because the walls are parallel: x / z is that of the direction.
    assert np.asarray(rays.x) == pytest.approx(30 * np.asarray(rays.L) / np.asarray(rays.N), abs=1e-7)
    assert result.total_flux_detected > 0.8
    assert result.diagnostics.medium_stack_underflows == 0


def test_lenses_that_are_no_solids_are_refused():
    with pytest.raises(TypeError, match="optiland_component: solid must be a solid, got Disc"):
        co.optics.optiland_component(co.Disc((0, 0, 0), (0, 0, 1), 1), "N-BK7")
    with pytest.raises(ValueError, match="optiland_component: solid must be of finite size"):
        co.optics.optiland_component(co.HalfSpace((0, 0, 1), 0), "N-BK7")
