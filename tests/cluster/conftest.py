"""Processes that the tests of one folder share."""

import numpy as np
import pytest

import conicoid as co

from . import subject


@pytest.fixture(scope="package")
def processes():
    """Two worker processes: each takes a second of processor time to start."""
    with co.parallel.Processes(2) as pool:
        yield pool


@pytest.fixture
def folder(tmp_path):
    """Write a scene, and its rays in files of several kinds: .npz of two kinds, .npy, a picture of rays, and .csv."""
    rays = subject.rays(500)
    co.save(subject.scene(), tmp_path / "scene.yaml")
    table = np.concatenate([rays.origins, rays.directions], axis=1)
    np.save(tmp_path / "rays.npy", table)
    np.save(tmp_path / "picture.npy", table.reshape(20, 25, 6))
    np.savez(tmp_path / "stored.npz", origins=rays.origins, directions=rays.directions)
    np.savez_compressed(tmp_path / "packed.npz", origins=rays.origins, directions=rays.directions)
    lines = "\n".join(",".join(map(repr, row)) for row in table.tolist())
    (tmp_path / "rays.csv").write_text(f"ox,oy,oz,dx,dy,dz\n# five hundred\n{lines}\n")
    return tmp_path
