"""What `conicoid trace` writes, Python loads; what Python saves, `conicoid trace` reads; others are told what reads them."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.cli import app

from ..command_line import run

SCENE = co.Scene([
    co.Body(co.Sphere(1) - co.Sphere(0.5), co.matte("red", name="shell"), "ball"), co.Disc((0, 0, -3), (0, 0, 1), 2),
    co.Body(co.Spheres([(0, 3, 0), (3, 0, 0)], 0.5), "blue", "two"),
])  # fmt: skip
RNG = np.random.default_rng(3)
RAYS = co.Rays(RNG.normal(size=(6, 5, 3)) * 4, RNG.normal(size=(6, 5, 3)))


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.setattr(app, "PIECE", 7)
    SCENE.save(tmp_path / "scene.yaml")
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize("spawned", [False, True])
def test_hits_of_trace_are_hits(spawned, scene, tmp_path):
    rays = SCENE.first_hit(RAYS).spawn((0, 0.1, 1)) if spawned else RAYS
    rays.save(tmp_path / "rays.npz")
    result = run("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "hits.npz")
    assert result.exit_code == 0, result.output
    hits, expected = co.Hits.load(tmp_path / "hits.npz"), SCENE.first_hit(rays).detached()
    assert hits == expected
    assert hits.rays == rays
    assert hits.name.tolist() == expected.name.tolist()
    assert SCENE.first_hit(hits.spawn((0, 0, 1))) == SCENE.first_hit(expected.spawn((0, 0, 1)))
    with np.load(tmp_path / "hits.npz") as arrays:
        assert arrays["entering"].dtype == bool  # as docs/files.md says: it selects
        assert np.array_equal(arrays["t"][arrays["entering"]], expected.t[expected.entering])


def test_spans_of_trace_are_spans(scene, tmp_path):
    RAYS.save(tmp_path / "rays.npz")
    assert run("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "spans.npz", "--spans").exit_code == 0
    spans = co.Spans.load(tmp_path / "spans.npz")
    expected = SCENE.spans(RAYS.origins.reshape(-1, 3), RAYS.directions.reshape(-1, 3))
    assert spans == expected.detached()
    assert np.array_equal(spans.lengths(by="material"), expected.lengths(by="material"))


@pytest.mark.parametrize("rays", [np.zeros((0, 6)), np.array([9, 9, 9, 0, 0, 1.0])])
def test_hits_of_no_rays_and_of_one(rays, scene, tmp_path):
    np.save(tmp_path / "rays.npy", rays)
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "hits.npz").exit_code == 0
    assert co.Hits.load(tmp_path / "hits.npz") == SCENE.first_hit(rays[..., :3], rays[..., 3:]).detached()
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "spans.npz", "--spans").exit_code == 0
    assert len(co.Spans.load(tmp_path / "spans.npz").body) == 0


def test_rays_load_what_trace_reads(tmp_path):
    table = np.concatenate([RAYS.origins, RAYS.directions], axis=-1)
    np.save(tmp_path / "rays.npy", table)
    (tmp_path / "rays.csv").write_text("\n".join(",".join(map(repr, row)) for row in table.reshape(-1, 6).tolist()))
    np.savez(tmp_path / "rays.npz", origins=RAYS.origins, directions=RAYS.directions)
    assert co.Rays.load(tmp_path / "rays.npy") == co.Rays.load(tmp_path / "rays.npz") == RAYS
    assert co.Rays.load(tmp_path / "rays.csv") == co.Rays(table.reshape(-1, 6)[:, :3], table.reshape(-1, 6)[:, 3:])
    np.savez(tmp_path / "rays.npz", origins=RAYS.origins, directions=RAYS.directions, t_min=0.5)
    with pytest.raises(
        ValueError, match=r"rays.npz: .* also holds t_min; rays have no intervals: numpy.load reads them"
    ):
        co.Rays.load(tmp_path / "rays.npz")
    np.save(tmp_path / "rays.npy", [[0, 0, 0, 0, 0, 0.0]])
    with pytest.raises(ValueError, match=r"rays.npy: ray 0: direction must not be zero"):
        co.Rays.load(tmp_path / "rays.npy")


def test_other_files_are_told_what_reads_them(tmp_path):
    answers = {
        "hits": SCENE.first_hit(RAYS),
        "spans": SCENE.spans(RAYS),
        "crossings": SCENE.crossings(RAYS),
        "rays": RAYS,
    }
    for kind, answer in answers.items():
        answer.save(tmp_path / f"{kind}.npz")
    np.savez(tmp_path / "lengths.npz", lengths=SCENE.lengths(RAYS))
    for kind in answers:
        load = getattr(co, kind.capitalize()).load
        for other in answers:
            if other != kind:
                with pytest.raises(ValueError, match=rf"{other}.npz: is not a file of {kind}.save: .*; co.{other.capitalize()}"
                                   r".load reads it$"):  # fmt: skip
                    load(tmp_path / f"{other}.npz")
        with pytest.raises(ValueError, match=rf"is not a file of {kind}.save: .*; numpy.load reads any .npz file$"):
            load(tmp_path / "lengths.npz")
