"""Checks of scenes with known flaws: the findings, their sizes, and the rays that show them."""

import itertools
import math
import threading

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.checks.probe_rays import ProbeRays, ProbeScan

from ..command_line import run
from ..thread_counts import on_threads


def of_kind(findings: list[co.checks.Finding], kind: str) -> list[co.checks.Finding]:
    return [finding for finding in findings if finding.kind == kind]


def spans_of_finding(scene: co.Scene, finding: co.checks.Finding):
    return scene.spans(finding.origin, finding.direction)


EDGE = 4

CLEAN = {
    "nothing": [],
    "apart": [co.Sphere(), co.Box((2, -1, -1), (4, 1, 1)), co.Spheres([(0, 9, 0), (0, 12, 0)], 1)],
    "abutting": [co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1)), co.Box((0, 1, 0), (2, 2, 1))],
    "fitted": [
        co.Sphere() - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5),
        co.Sphere() & co.Cylinder((0, 0, -2), (0, 0, 2), 0.5),
    ],
    "half-spaces": [co.HalfSpace((0, 0, 1), 0.3), co.HalfSpace((0, 0, -1), -0.3)],
    "on a sheet": [co.Sphere(1, (0, 0, 1)), co.Plane((0, 0, 1), 0)],
    "cells": [
        co.Box((x / EDGE, y / EDGE, z / EDGE), ((x + 1) / EDGE, (y + 1) / EDGE, (z + 1) / EDGE))
        for x, y, z in itertools.product(range(EDGE), repeat=3)
    ],
    "moved together": [
        co.Box((0, 0, 0), (0.1, 1, 1)).rotate((1, 2, 3), 37).translate((5, 0, 0)),
        co.Box((0.1, 0, 0), (1, 1, 1)).rotate((1, 2, 3), 37).translate((5, 0, 0)),
    ],
}


@pytest.mark.parametrize("name", CLEAN)
def test_sound_scenes_have_no_findings(name: str):
    assert co.check(co.Scene(CLEAN[name]), rays=2000) == []


def test_overlaps_of_balls():
    """Two unit balls with centers 1.5 apart share a lens. No chord of it is longer than its rim's diameter."""
    scene = co.Scene([co.Body(co.Sphere(), name="left"), co.Sphere(1, (1.5, 0, 0)), co.Sphere(1, (5, 0, 0))])
    (finding,) = co.check(scene, rays=6000)
    assert (finding.kind, finding.bodies) == ("overlap", (0, 1))
    assert "bodies 0 (left) and 1 overlap" in finding.message
    rim = 2 * math.sqrt(1 - 0.75**2)
    assert 0.5 < finding.size <= rim
    spans = spans_of_finding(scene, finding)
    assert spans.body.tolist() in ([0, 1], [1, 0])
    assert min(spans.t_exit) - max(spans.t_enter) == pytest.approx(finding.size)
    assert str(finding).startswith("overlap: bodies 0 (left) and 1 overlap")


def test_all_overlaps_of_many_balls_are_true_and_almost_all_are_found():
    random = np.random.default_rng(5)
    centers = random.random((300, 3)) * 10
    scene = co.Scene([co.Spheres(centers, 0.5)])
    distance = np.linalg.norm(centers[:, None] - centers, axis=2)
    truth = {(i, j) for i, j in zip(*np.nonzero(np.triu(distance < 1, 1)), strict=True)}
    found = {finding.bodies for finding in co.check(scene, rays=60_000)}
    assert found <= truth
    deep = {(i, j) for i, j in truth if distance[i, j] < 0.9}
    assert deep <= found


LATTICE = """<geometry>
<surface id="1" type="z-cylinder" coeffs="0 0 0.3"/><surface id="2" type="z-cylinder" coeffs="0 0 0.4"/>
<surface id="3" type="z-plane" coeffs="0"/><surface id="4" type="z-plane" coeffs="2"/>
<surface id="5" type="z-cylinder" coeffs="0 0 9" boundary="vacuum"/>
<cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="2" region="1 -2"/>
<cell id="3" universe="1" material="3" region="2"/><cell id="4" universe="2" material="3" />
<lattice id="7" dimension="5 5" lower_left="-2.5 -2.5" pitch="1 1" outer="2" universes="{0}"/>
<cell id="9" fill="7" region="-5 3 -4"/></geometry>"""


@pytest.mark.parametrize("turned", [False, True])
def test_instances_overlap_where_written_out_bodies_do(turned: bool, tmp_path):
    """Rays through bodies of a lattice end at these.

    The pin that was moved overlaps its neighbours and leaves a gap behind it.
    """
    path = tmp_path / "geometry.xml"
    path.write_text(LATTICE.format("1 " * 25).replace('fill="7"', 'fill="7" rotation="0 0 30"' * turned or 'fill="7"'))
    scene = co.load_openmc(path)
    assert co.check(scene, rays=6000) == []
    scene = scene.moved(3 * 7, (0.05, 0.02, 0)).moved(3 * 12 + 1, (1, 1, 0)).without([3 * 20, 3 * 20 + 1])
    written = co.Scene([co.Body(body.shape, body.material, body.name) for body in scene.bodies], domain=scene.domain)
    found, expected = (co.check(each, rays=6000) for each in (scene, written))
    assert {(one.kind, one.bodies) for one in found} == {(one.kind, one.bodies) for one in expected}
    assert {one.kind for one in found} == {"overlap", "undefined"}
    for one, other in zip(found, expected, strict=True):
        if one.kind == "overlap":
            assert 0.3 * other.size < one.size < 3 * other.size
        assert len(spans_of_finding(scene, one).body) > 1


def test_a_body_within_another():
    scene = co.Scene([co.Box((-2, -2, -2), (2, 2, 2)), co.Sphere(0.01, (1, 1, 1))])
    (finding,) = co.check(scene, rays=3000)
    assert (finding.kind, finding.bodies) == ("overlap", (0, 1))
    assert finding.size == pytest.approx(0.02, rel=0.1)


def test_unbounded_bodies():
    scene = co.Scene([co.HalfSpace((0, 0, 1), 1), co.HalfSpace((0, 0, -1), 0), co.Sphere(0.5, (0, 0, 5))])
    found = co.check(scene, rays=3000)
    assert {finding.bodies for finding in found} == {(0, 1), (1, 2)}
    assert all(finding.kind == "overlap" for finding in found)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize(("end", "findings"), [(0.1 + 0.2, "an overlap"), (0.3 - 1e-12, "a gap")])
def test_walls_that_are_equal_up_to_rounding(end: float, findings: str, scale: float):
    scene = co.Scene([co.Box((0, 0, 0), (end, 1, 1)).scale(scale), co.Box((0.3, 0, 0), (1, 1, 1)).scale(scale)])
    found = co.check(scene, rays=3000)
    assert not of_kind(found, "overlap")
    (sliver,) = of_kind(found, "sliver")
    assert sliver.bodies == (0, 1)
    assert findings in sliver.message
    assert sliver.size == pytest.approx(abs(end - 0.3) * scale, rel=20 * 1e-16 / abs(end - 0.3) + 1e-3)
    near = of_kind(found, "near-coincidence")
    if abs(end - 0.3) < 1e-13:
        assert near[0].bodies == (0, 1)
        assert near[0].origin is not None
    crossings = scene.crossings(sliver.origin, sliver.direction).t
    assert (np.diff(crossings) <= 1e-9 * scale).any()


def test_a_film_left_by_a_cut_within_one_body():
    plate = co.Box((0, 0, 0), (1, 1, 0.1 + 0.2)) - co.Cylinder((0.5, 0.5, 0), (0.5, 0.5, 0.3), 0.2)
    found = co.check(co.Scene([plate]), rays=6000)
    (sliver,) = of_kind(found, "sliver")
    assert "a film in body 0" in sliver.message
    (near,) = of_kind(found, "near-coincidence")
    assert near.bodies == (0,)
    flush = co.Box((0, 0, 0), (1, 1, 0.3)) - co.Cylinder((0.5, 0.5, 0), (0.5, 0.5, 0.3), 0.2)
    assert co.check(co.Scene([flush]), rays=6000) == []


def test_curved_surfaces_that_are_nearly_equal():
    scene = co.Scene([co.Sphere(2) - co.Sphere(0.1 + 0.2), co.Sphere(0.3)])
    found = co.check(scene, rays=6000)
    assert [finding.kind for finding in found] == ["sliver", "near-coincidence"]
    rods = [
        co.Cylinder((0, 0, 0), (1, 1, 1), 0.5),
        co.Cylinder((0, 0, 0), (2, 2, 2), 0.5 * (1 + 2**-50)).translate((1, 1, 1)),
    ]
    assert [finding.kind for finding in co.check(co.Scene(rods), rays=6000)] == ["near-coincidence"]


def test_empty_bodies():
    scene = co.Scene(
        [
            co.Body(co.Sphere() - co.Sphere(), name="nothing"),
            co.Sphere() & co.Sphere(1, (5, 0, 0)),
            co.Sphere(1) - co.Box((-1, -1, -1), (1, 1, 1)),
            co.Sphere(1e-3, (9, 9, 9)) - co.Sphere(0.5e-3, (9, 9, 9)),
            co.Plane((0, 0, 1), 30) & co.Sphere(1),
        ]
    )
    found = co.check(scene, rays=3000)
    assert {finding.kind for finding in found} == {"empty"}
    assert sorted(finding.bodies[0] for finding in found) == [0, 1, 2, 4]
    assert all(finding.origin is None for finding in found)
    assert "body 0 (nothing) is empty" in found[0].message


_NEEDLES = """<geometry><cell id="1" fill="7" region="-1 2 -3 4 -5 6"/>
<surface id="1" type="x-plane" coeffs="20"/><surface id="2" type="x-plane" coeffs="-20"/>
<surface id="3" type="y-plane" coeffs="20"/><surface id="4" type="y-plane" coeffs="-20"/>
<surface id="5" type="z-plane" coeffs="0.4"/><surface id="6" type="z-plane" coeffs="-0.4"/>
<surface id="7" type="plane" coeffs="1 -1 0 0.001"/><surface id="8" type="plane" coeffs="1 -1 0 -0.001"/>
<surface id="9" type="z-plane" coeffs="0.001"/><surface id="10" type="z-plane" coeffs="-0.001"/>
<lattice id="7" dimension="40 40" lower_left="-20 -20" pitch="1 1" universes="{}"/>
<cell id="11" universe="2" material="1" region="-7 8 -9 10"/>
<cell id="12" universe="2" material="2" region="7 | -8 | 9 | -10"/></geometry>"""


def test_instances_are_empty_only_together(tmp_path):
    # Few of the rays through the box of a needle along x = y hit it, but many hit one of 1,600
    path = tmp_path / "needles.xml"
    path.write_text(_NEEDLES.format("2 " * 1600))
    assert not of_kind(co.check(co.load_openmc(path), rays=2000), "empty")


def test_the_same_seed_finds_the_same():
    scene = co.Scene([co.Sphere(), co.Sphere(1, (1, 0, 0)), co.Sphere(1, (0, 1, 0))])
    one, other, third = (co.check(scene, rays=600, seed=seed) for seed in (1, 1, 2))
    assert (
        [str(finding) for finding in one] == [str(finding) for finding in other] != [str(finding) for finding in third]
    )


def test_rays_are_a_number():
    with pytest.raises(ValueError, match="check: rays must be an integer >= 1, got 0"):
        co.check(co.Scene([co.Sphere()]), rays=0)
    with pytest.raises(ValueError, match="check: rays must be an integer <= 1,000,000,000, got 10000000000"):
        co.check(co.Scene([co.Sphere()]), rays=10**10)


def test_progress():
    calls: list[tuple[int, int]] = []
    co.check(co.Scene([co.Sphere()]), rays=60, progress=lambda done, total: calls.append((done, total)))
    assert calls[-1] == (6, 6)


def test_the_command_line_prints_the_same(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        "bodies:\n  - {name: ball, shape: {Sphere: {radius: 1}}}\n  - {shape: {Box: {low: [0.5, -1, -1], high: [4, 1, 1]}}}\n"
    )
    result = run("info", path, "--check", "--rays", "3000")
    assert result.exit_code == 3
    assert "findings  1\noverlap: bodies 0 (ball) and 1 overlap" in result.stdout
    assert "findings" not in run("info", path).stdout


def test_a_lamp_in_a_ceiling():
    """The first of two coincident walls is reported, and no light leaves an opaque body. So the lamp is never visible."""
    ceiling = co.Body(co.Box((-3, -3, 2), (3, 3, 2.1)), name="ceiling")
    for sheet in (co.Disc((0, 0, 2), (0, 0, -1), 0.5), co.Triangle((0, 0, 2), (1, 0, 2), (0, 1, 2))):
        lamp = co.Body(sheet, co.glow("white"), "lamp")
        (found,) = co.check(co.Scene([ceiling, lamp]), 2000)
        assert (found.kind, found.bodies) == ("overlap", (0, 1))
        assert found.message.startswith(
            "bodies 0 (ceiling) and 1 (lamp): the second lies in a wall of the first, or within"
        )
        for depth in (1e-6, 1e-3, 0.05, 0.1 - 1e-6):
            buried = co.Body(sheet.translate((0, 0, depth)), co.glow("white"), "lamp")
            for bodies in ([ceiling, buried], [buried, ceiling]):
                (found,) = co.check(co.Scene(bodies), 2000)
                assert found.kind == "overlap"
                assert set(found.bodies) == {0, 1}
            assert not co.check(co.Scene([co.Body(ceiling.shape, co.glass(1.5)), buried]), 2000)
            assert not co.check(co.Scene([ceiling, co.Body(buried.shape, name="a sheet that is no lamp")]), 2000)
        assert not co.check(co.Scene([lamp, ceiling]), 2000)
        assert not co.check(co.Scene([ceiling, co.Body(sheet.translate((0, 0, -0.5)), name="lamp")]), 2000)
    half = co.Body(co.Disc((3, 0, 2), (0, 0, -1), 0.5), name="half of it reaches out")
    assert not co.check(co.Scene([ceiling, half]), 2000)


def test_rays_for_coincidences_take_one_query_for_many_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    """There are 3 or 24 pairs of surfaces that nearly coincide, by gaps of 2^-44 between slabs.

    Both take equally many queries.
    """
    counts = []
    follow = ProbeScan.follow
    for pairs in (3, 24):
        calls: list[ProbeRays] = []
        monkeypatch.setattr(
            ProbeScan, "follow", lambda scan, rays, calls=calls: (calls.append(rays), follow(scan, rays))[1]
        )
        slabs = [co.Box((k + 2.0**-44, 0, 0), (k + 1, 1, 1)) for k in range(pairs + 1)]
        findings = co.check(co.Scene(slabs), rays=300)
        assert sum(finding.kind == "near-coincidence" for finding in findings) >= pairs
        counts.append(len(calls))
    assert counts[0] == counts[1]


def test_chunks_of_rays_are_on_all_threads_and_findings_do_not_depend_on_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nine balls overlap, and 30,000 rays make several chunks find each pair."""
    balls = [co.Sphere(1.0, (0.5 * (k % 3), 0.6 * (k // 3), 0.1 * k)) for k in range(9)]
    spans, mains = ProbeScan._spans, list[bool]()

    def record(scan: ProbeScan, rays: ProbeRays) -> None:
        mains.append(threading.current_thread() is threading.main_thread())
        spans(scan, rays)

    monkeypatch.setattr(ProbeScan, "_spans", record)

    def check() -> tuple[list[tuple[str, list[float]]], bool]:
        mains.clear()
        found = [(one.message, one.origin.tolist()) for one in co.check(co.Scene(balls), 30_000)]
        return found, mains.count(False) > 0

    found, off_main = zip(*on_threads(check, 1, 2, 5), strict=True)
    assert len(found[0]) >= 20
    assert found[0] == found[1] == found[2]
    assert off_main == (False, True, True)
