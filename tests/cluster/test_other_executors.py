"""Executors of other packages: loky's and MPI's."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from . import subject

PROGRAM = """
from mpi4py import MPI
from mpi4py.futures import MPIPoolExecutor
import conicoid as co
from tests.cluster import subject
if __name__ == "__main__":
    scene, rays = subject.scene(), subject.rays(5, 40)
    with MPIPoolExecutor() as pool:
        assert pool.submit(MPI.COMM_WORLD.Get_rank).result() != 0  # it is done elsewhere
        how = co.parallel.Workers(pool, chunk=33)
        far = subject.answers(scene, rays, executor=how)
        picture = scene.render(70, 40, executor=pool)
    assert subject.differing(subject.answers(scene, rays), far) == []
    assert (picture.pixels == scene.render(70, 40).pixels).all()
    print("the same,", MPI.COMM_WORLD.Get_size(), "processes")
"""


def test_mpi(tmp_path):
    pytest.importorskip("mpi4py", reason="mpi4py is not installed", exc_type=ImportError)
    launcher = shutil.which("mpiexec", path=os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])))
    if launcher is None:
        pytest.skip("no mpiexec is installed")
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [launcher, "-n", "3", sys.executable, "-m", "mpi4py.futures", tmp_path / "program.py"]
    paths = os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {
        "PYTHONPATH": paths,
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    }
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    assert "the same, 3 processes" in done.stdout


@pytest.mark.parametrize("package", ["loky", "joblib.externals.loky"])
def test_loky(package):
    loky = pytest.importorskip(package)
    scene, rays = subject.scene(), subject.rays(5, 40)
    pool = loky.get_reusable_executor(max_workers=2)
    try:
        assert subject.differing(subject.answers(scene, rays), subject.answers(scene, rays, executor=pool)) == []
    finally:
        pool.shutdown(kill_workers=True)
