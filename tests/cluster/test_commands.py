"""`conicoid trace --chunk` and `conicoid render` with workers: what they write is what they write without."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import conicoid as co
from tests.command_line import run

from . import subject

COMMAND = (sys.executable, "-m", "conicoid")


@pytest.fixture
def files(tmp_path):
    """A scene and its rays in files; the folder."""
    rays = subject.rays(500)
    co.save(subject.scene(), tmp_path / "scene.yaml")
    table = np.concatenate([rays.origins, rays.directions], axis=1)
    np.save(tmp_path / "rays.npy", table)
    np.save(tmp_path / "picture.npy", table.reshape(20, 25, 6))
    lines = "\n".join(",".join(map(repr, row)) for row in table.tolist())
    (tmp_path / "rays.csv").write_text(f"ox,oy,oz,dx,dy,dz\n# five hundred\n{lines}\n")
    return tmp_path


def traced(files, rays, output, *options):
    result = run("trace", files / "scene.yaml", files / rays, "-o", files / output, *options)
    assert result.exit_code == 0, result.stderr
    return files / output


@pytest.mark.parametrize("rays", ["rays.npy", "rays.csv", "picture.npy"])
def test_chunks_write_the_same(files, rays):
    for options in ((), ("--spans",)):
        whole = traced(files, rays, "whole.csv", *options)
        parts = traced(files, rays, "parts.csv", *options, "--chunk", 37)
        assert parts.read_bytes() == whole.read_bytes()
    whole, parts = traced(files, rays, "whole.npz"), traced(files, rays, "parts.npz", "--chunk", 37)
    assert co.Hits.load(parts) == co.Hits.load(whole)
    assert sorted(path.suffix for path in files.iterdir() if path.is_dir()) == []


def test_workers_write_the_same(files):
    pytest.importorskip("OpenEXR")
    whole = traced(files, "rays.npy", "whole.csv")
    assert traced(files, "rays.npy", "parts.csv", "--chunk", 100, "--workers", 1).read_bytes() == whole.read_bytes()
    options = "--width", 70, "--height", 40
    for name, more in (("here", ()), ("there", ("--workers", 1, "--resume", files / "tiles"))):
        assert run("render", files / "scene.yaml", "-o", files / f"{name}.exr", *options, *more).exit_code == 0
    assert (files / "here.exr").read_bytes() == (files / "there.exr").read_bytes()
    assert not (files / "tiles").exists()  # it is done


def test_mistakes(files):
    scene = files / "scene.yaml"

    def told(*arguments):
        result = run(*arguments)
        assert result.exit_code == 2
        return result.stderr

    assert "--resume goes with --chunk" in told("trace", scene, files / "rays.npy", "-o", files / "x.csv", "--resume")
    assert "give either --workers or --cluster" in told(
        "render", scene, "-o", files / "x.png", "--workers", 2, "--cluster", "tcp://127.0.0.1:1"
    )
    bad = np.load(files / "rays.npy")
    bad[300, 3:] = 0
    np.save(files / "bad.npy", bad)
    assert "ray 300: direction must not be zero" in told(
        "trace", scene, files / "bad.npy", "-o", files / "x.csv", "--chunk", 64
    )
    assert "--resume goes on with it" in told("trace", scene, files / "bad.npy", "-o", files / "x.csv", "--chunk", 64)
    assert "holds results of other rays" in told(
        "trace", scene, files / "rays.npy", "-o", files / "x.csv", "--chunk", 64, "--resume"
    )


@pytest.mark.deep
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
@pytest.mark.parametrize("output", ["hits.csv", "hits.npz"])
def test_a_command_killed_twenty_times(tmp_path, output):
    co.save(subject.scene(), tmp_path / "scene.yaml")
    rays = subject.rays(300_000)
    np.save(tmp_path / "rays.npy", np.concatenate([rays.origins, rays.directions], axis=1))
    arguments = [*COMMAND, "trace", tmp_path / "scene.yaml", tmp_path / "rays.npy", "--chunk", "5000", "-o"]
    subprocess.run([*arguments, tmp_path / f"whole-{output}"], check=True)
    rng, killed = np.random.default_rng(1), 0
    state = tmp_path / f"{output}.parts" / "state.json"
    while killed < 20:
        child = subprocess.Popen([*arguments, tmp_path / output, "--resume"])
        before = state.stat().st_mtime_ns if state.exists() else 0
        while child.poll() is None and not (state.exists() and state.stat().st_mtime_ns > before):
            time.sleep(0.002)
        time.sleep(rng.uniform(0, 0.15))
        if child.poll() is None:
            child.send_signal(signal.SIGKILL)
            killed += 1
        child.wait()
    subprocess.run([*arguments, tmp_path / output, "--resume"], check=True)
    whole, found = tmp_path / f"whole-{output}", tmp_path / output
    if output.endswith(".csv"):
        assert found.read_bytes() == whole.read_bytes()
    else:
        assert co.Hits.load(found) == co.Hits.load(whole)
