"""Sinograms: the Shepp-Logan head against its closed form, and the same bits wherever they are made."""

from __future__ import annotations

import resource
import sys

import numpy as np
import pytest

import conicoid as co
from tests.adversarial.test_shepp_logan import HEAD, closed_form, head

from ..samples import sampled

SCANS = {
    "parallel": co.ct.parallel(np.arange(0, 180, 20.0), 24, spacing=0.09, offset=0.01),
    "fanflat": co.ct.fanflat(np.arange(0, 360, 45.0), 24, 3, 2, spacing=0.16, radius=5),
    "parallel3d": co.ct.parallel3d([0, 30, 91.5], 6, 8, spacing=(0.25, 0.3)),
    "cone": co.ct.cone(np.arange(0, 360, 60.0), 6, 8, 3, 2, spacing=(0.4, 0.5), offset=(0.1, 0)),
    "helical": co.ct.helical(np.arange(-360, 360, 60.0), 4, 8, 3, 2, pitch=0.5, spacing=(0.4, 0.3), radius=5),
    "rtk": co.ct.rtk([0, 77], 6, 6, 3, 5, spacing=(0.5, 0.5), out_of_plane_angle=3, in_plane_angle=5),
}


def exact(scan):
    """Sums of densities times chords along the rays of a scan, in 80-bit floats."""
    rays = co.Rays.from_scan(scan).to_rays()
    lines = zip(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3), strict=True)
    return np.array([closed_form(o[None], d)[0] for o, d in lines]).reshape(scan.shape)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="the closed form needs floats of 80 bits")
@pytest.mark.parametrize("name", sampled(SCANS, 3))
def test_the_head_against_its_closed_form(name):
    found = co.ct.project(head(), SCANS[name], HEAD[:, 0])
    assert found.max() > 0.2
    assert np.abs(found - exact(SCANS[name])).max() < 1e-12


def test_energies_files_and_lazy_arrays(tmp_path):
    scan, values = SCANS["cone"], HEAD[:, :2]
    local = co.ct.project(head(), scan, values)
    assert local.shape == (*scan.shape, 2)
    assert np.array_equal(local[..., 0], co.ct.project(head(), scan, HEAD[:, 0]))
    told = []
    with co.parallel.Processes(1) as pool:
        how = co.parallel.Workers(pool, chunk=77)
        kept = co.ct.project(head(), scan, values, executor=how, out=tmp_path / "sinogram.npy",
                             progress=lambda *step: told.append(step))  # fmt: skip
    assert np.array_equal(kept, local)
    assert np.array_equal(np.load(tmp_path / "sinogram.npy"), local)
    assert told[-1] == (local.size // 2, local.size // 2)
    da = pytest.importorskip("dask.array")
    lazy = co.ct.project(head(), scan, values, chunks=4)
    assert isinstance(lazy, da.Array)
    assert lazy.chunks[0] == (4, 2)
    assert np.array_equal(lazy.compute(scheduler="synchronous"), local)


def test_a_failure_leaves_no_file(tmp_path):
    def stop(done, count):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        co.ct.project(head(), SCANS["cone"], HEAD[:, 0], out=tmp_path / "sinogram.npy", progress=stop)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ValueError, match=r"project: out must end with .npy"):
        co.ct.project(head(), SCANS["cone"], HEAD[:, 0], out=tmp_path / "sinogram.tif")
    with pytest.raises(TypeError, match=r"project: geometry must be one of co.ct, got str"):
        co.ct.project(head(), "cone", HEAD[:, 0])


def test_rays_end_at_the_detector():
    # A ball behind the detector is not seen, and one that the source is in counts from there
    wall = co.Scene([co.Sphere(1, (0, 9, 0)), co.Sphere(1, (0, -5, 0))])
    scan = co.ct.fanflat([0], 1, 5, 3)
    assert co.ct.project(wall, scan, [1, 1]).tolist() == [[1.0]]


@pytest.mark.deep
@pytest.mark.skipif(sys.platform == "win32", reason="no resource")
def test_a_hundred_million_rays_in_two_gigabytes(tmp_path):
    """A tenth of a scan of 720 views of 1,200 x 1,200."""
    scan = co.ct.cone(np.arange(0, 360, 5.0), 1200, 1200, 3, 2, spacing=(0.004, 0.004))
    with co.parallel.Processes(2) as pool:
        found = co.ct.project(head(), scan, HEAD[:, 0], executor=pool, out=tmp_path / "sinogram.npy")
    most = (
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss + 2 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    )
    assert most * 1024 < 2 << 30
    some = found[::24, 100::500, 100::300]
    views, rows, columns = (
        x.ravel()
        for x in np.meshgrid(np.arange(0, 72, 24), np.arange(100, 1200, 500), np.arange(100, 1200, 300), indexing="ij")
    )
    places, sources = scan.pixels(views, rows, columns), scan.vectors[views, :3]
    wanted = [closed_form(o[None], p - o)[0] for o, p in zip(sources, places, strict=True)]
    assert np.abs(some.ravel() - np.array(wanted)).max() < 1e-12
