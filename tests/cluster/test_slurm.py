"""`--slurm`: dask-jobqueue's own cluster, with an `sbatch` that starts the job's script at once on this machine."""

import os
import stat
import subprocess
import sys

import pytest

import conicoid as co

from . import subject

pytest.importorskip("dask_jobqueue")

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="sh")

SBATCH = """#!/bin/sh
copy="{jobs}/job-$$.sh"
cp "$1" "$copy"
nohup setsid sh "$copy" > "$copy.log" 2>&1 < /dev/null &
echo $! >> "{jobs}/pids"
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
for job; do echo "$job" >> "{jobs}/cancelled"; kill -TERM -- "-$job" 2>/dev/null; done
exit 0
"""
CONFIG = "jobqueue:\n  slurm:\n    cores: 1\n    memory: 1GB\n    walltime: '00:10:00'\n"


@pytest.fixture
def slurm(tmp_path):
    """Return the environment of a machine whose Slurm has room."""
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        program = tmp_path / "bin" / name
        program.parent.mkdir(exist_ok=True)
        program.write_text(text.format(jobs=tmp_path))
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    (tmp_path / "dask").mkdir()
    (tmp_path / "dask" / "jobqueue.yaml").write_text(CONFIG)
    path = os.pathsep.join((str(tmp_path / "bin"), os.environ["PATH"]))
    return os.environ | {"PATH": path, "DASK_CONFIG": str(tmp_path / "dask")}


def test_a_picture_of_two_jobs(tmp_path, slurm):
    pytest.importorskip("OpenEXR")
    co.save(subject.scene(), tmp_path / "scene.yaml")
    command = [sys.executable, "-m", "conicoid", "render", tmp_path / "scene.yaml", "--width", "70", "--height", "40"]
    subprocess.run([*command, "-o", tmp_path / "far.exr", "--slurm", "2"], env=slurm, check=True, timeout=240)
    subprocess.run([*command, "-o", tmp_path / "near.exr"], check=True, timeout=240)
    assert (tmp_path / "far.exr").read_bytes() == (tmp_path / "near.exr").read_bytes()
    jobs = set((tmp_path / "pids").read_text().split())
    assert len(jobs) == 2
    assert set((tmp_path / "cancelled").read_text().split()) == jobs


def test_the_resources_of_a_job_are_required(tmp_path, slurm):
    co.save(subject.scene(), tmp_path / "scene.yaml")
    (tmp_path / "dask" / "jobqueue.yaml").unlink()
    command = [sys.executable, "-m", "conicoid", "render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png"]
    found = subprocess.run([*command, "--slurm", "2"], env=slurm, capture_output=True, text=True, timeout=240)
    assert found.returncode == 2
    assert "--slurm: Dask's jobqueue.yaml must state the resources of a job" in found.stderr
    assert not (tmp_path / "pids").exists()
