"""Scenes from scenes: other cameras, lights, bodies. Unchanged parts are not computed again."""

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare import lower_shape as parts, lowering
from conicoid.prepare.edits import scene_edit as edited
from conicoid.prepare.prepared_scene import PreparedScene
from conicoid.prepare.tape import recordings

from .engine.edits import same_tables

RAYS = (np.random.default_rng(3).normal(size=(400, 3)) * 4, np.random.default_rng(4).normal(size=(400, 3)))


def _things() -> list[co.Body]:
    """Return bodies of every kind: cells, coincident walls, sheets, clipped sheets, polygons, balls, stretched ones."""
    drilled = co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.4).painted(co.matte("red"))
    turned = (co.Box((0, 0, 0), (1, 1, 1)) | co.Cone((0, 0, 1), (0, 0, 2), 0.5, 0)).rotate((1, 2, 3), 40)
    balls = co.Spheres(np.random.default_rng(1).normal(size=(30, 3)), 0.2)
    return [
        co.Body(drilled, "blue", "drilled"),
        co.Body(turned.translate((2, 0, 0)), name="turned"),
        co.Body(turned.translate((2, 0, 0)).rotate("z", 15).rotate("z", -15), name="the same again"),
        co.Body(co.Disc((0, 0, 3), (0, 0, 1), 2) - co.Sphere(1, (0, 0, 3)), name="ring"),
        co.Body(co.Polygon([(0, 0, -2), (1, 0, -2), (0, 1, -2)]).rotate("x", 10), name="polygon"),
        co.Body(balls, name="balls"),
        co.Body(balls.scale((1, 1, 2)).translate((0, 4, 0)), name="eggs"),
        co.Body(co.Plane((0, 0, 1), -3), name="floor"),
    ]


@pytest.fixture
def computed_shapes(monkeypatch):
    """Return the shapes that are lowered one after the other, because there is no recording that could lower them together."""
    monkeypatch.setattr(recordings, "RECORDINGS", recordings.RecordingCache())
    shapes: list[co.Shape] = []
    work = parts.compute_shape

    within = []

    def noted(shape):
        # The parts of a Boolean, which its box needs, are not bodies
        shapes.extend([shape] if not within else [])
        within.append(shape)
        try:
            return work(shape)
        finally:
            within.pop()

    monkeypatch.setattr(parts, "compute_shape", noted)
    return shapes


def test_only_new_bodies_are_lowered(computed_shapes):
    scene = co.Scene(_things())
    scene.prepare()
    assert len(computed_shapes) == 6
    moved = scene["drilled"].shape.rotate("x", 30)
    changed = scene.replace("drilled", moved)
    assert computed_shapes.count(moved) == 0
    changed.prepare()
    assert computed_shapes[6:] == [moved]
    co.Scene(reversed(scene.bodies)).prepare()
    assert len(computed_shapes) == 7


def test_other_lights_and_cameras_prepare_nothing(monkeypatch):
    scene = co.Scene(_things())
    scene.prepare()
    for name, module in (("lower", lowering), ("of", PreparedScene)):
        monkeypatch.setattr(module, name, None)
    light, camera = co.AmbientLight(1), co.Camera((0, -9, 0), (0, 0, 0))
    lit = scene.replace(lights=light, camera=camera, background="red")
    assert (lit.lights, lit.camera, lit.background, lit.bodies) == ((light,), camera, "red", scene.bodies)
    assert lit.replace(camera=None).camera is None
    assert lit._prepared is scene._prepared
    painted = scene.replace("drilled", co.Body(scene["drilled"].shape, "green", "new"))
    hit = painted.first_hit((0.7, 0, 5), (0, 0, -1))
    assert painted._prepared.geometry is scene._prepared.geometry
    assert hit.material == co.matte("green")
    assert hit.name == "new"
    assert scene.first_hit((0.7, 0, 5), (0, 0, -1)).name == "drilled"
    pictures = [scene.render(16, 12, samples=1, camera=view).pixels for view in (camera, scene.fitting_camera(4 / 3))]
    assert np.array_equal(pictures[0], scene.replace(camera=camera).render(16, 12, samples=1).pixels)
    assert np.array_equal(pictures[1], scene.render(16, 12, samples=1).pixels)


def test_bounds_are_computed_once_and_stay(monkeypatch):
    scene = co.Scene(_things())
    low = scene.bodies[0].shape.bounds[0]
    low -= 100
    assert scene.bodies[0].shape.bounds[0].tolist() == [-1, -1, -1]
    first = scene.fitting_camera(1.5)
    monkeypatch.setattr(co.Shape, "bounds", None)
    assert scene.fitting_camera(1.5) == first


def test_moved_added_and_without():
    scene = co.Scene(_things())
    scene.prepare()
    ball, quarter = co.Body(co.Sphere(0.5), "red", "ball"), co.Box().rotate("z", 90).motion
    assert scene.moved("turned", (1, 2, 3)).bodies[1] == scene.bodies[1].translate((1, 2, 3))
    matrix = np.eye(4)
    matrix[:3, 3] = 1, 0, 0
    assert scene.moved(0, matrix).bodies[0] == scene.bodies[0].transform(matrix)
    turned = scene.moved("balls", lambda shape: shape.rotate("z", 90))
    assert turned["balls"].shape.motion == scene["balls"].shape.motion.then(quarter)
    assert scene.added(ball).bodies == (*scene.bodies, ball)
    assert scene.added([ball, co.Box()], before="turned").bodies[:4] == (
        scene.bodies[0], ball, co.Body(co.Box()), scene.bodies[1],
    )  # fmt: skip
    assert scene.added(ball, before=0).bodies[0] is ball
    assert scene.without(["turned", 0]).bodies == scene.bodies[2:]
    changed = scene.without("floor").added(ball).moved("drilled", (0, 0, 1))
    assert (changed.lights, changed.camera, changed.notes) == (scene.lights, scene.camera, scene.notes)
    same_tables(changed, co.Scene(changed.bodies))
    assert co.Scene([]).added(ball).first_hit((0, 0, 5), (0, 0, -1)).t == 4.5


@pytest.mark.parametrize(("edit", "error", "message"), [
    (lambda s: s.replace('no', co.Sphere()), KeyError, "no body named 'no'; named bodies: 'drilled', 'turned'"),
    (lambda s: s.replace(99, co.Sphere()), IndexError, 'number must be at least 0 and below 66, got 99'),
    (lambda s: s.replace(7, co.Sphere()), ValueError, 'replace: body 7 is one ball of an entry of 30; name the entry instead'),
    (lambda s: s.replace('turned', 'red'), TypeError, 'replace: item must be a shape or a Body, got str'),
    (lambda s: s.replace('turned'), TypeError, 'replace: item must be a shape or a Body, got None'),
    (lambda s: s.replace(None, co.Sphere()), TypeError, 'replace: which must be the name of an entry or the number of its body, got None'),
    (lambda s: s.replace('turned', co.Body(co.Sphere(), name='floor')), ValueError, "are both named 'floor'"),
    (lambda s: s.moved("no", (1, 0, 0)), KeyError, "no body named 'no'"),
    (lambda s: s.moved(7, (1, 0, 0)), ValueError, "moved: body 7 is one ball of an entry of 30; name the entry instead"),
    (lambda s: s.moved("turned", 5), TypeError, r"moved: motion must be 3 numbers, a matrix \(4, 4\) or a function, got 5"),
    (lambda s: s.moved("turned", lambda shape: 5), TypeError, "moved: motion must return a shape, got int"),
    (lambda s: s.moved("turned", (1, 0, float("nan"))), ValueError, "translate: offset"),
    (lambda s: s.added("ball"), TypeError, "added: items must be a list of shapes and Bodies"),
    (lambda s: s.added(co.Sphere(), before=1.5), TypeError, "added: before must be the name of an entry or"),
    (lambda s: s.added(co.Sphere(), before=99), IndexError, "added: before must be at least 0 and below 66, got 99"),
    (lambda s: s.added(co.Body(co.Sphere(), name="floor")), ValueError, "are both named 'floor'"),
    (lambda s: s.without("no"), KeyError, "no body named 'no'"),
    (lambda s: s.without(None), TypeError, "without: which must be the name of an entry or"),
])  # fmt: skip
def test_refusals_of_edits(edit, error, message):
    with pytest.raises(error, match=message):
        edit(co.Scene(_things()))


def test_a_scene_shares_equal_parts_of_a_prepared_one(noted_calls):
    scene = co.Scene(_things())
    scene.prepare()
    again = co.Scene(_things())._reuse(scene)
    assert all(new is old for new, old in zip(again.bodies, scene.bodies, strict=True))
    lowered = noted_calls(edited, "lower", lambda bodies, stages: bodies)
    ball = co.Body(co.Sphere(0.5, (5, 5, 5)), name="ball")
    for things, new in (
        ([*_things()[:3], ball, *_things()[3:]], [ball]),
        ([*_things()[:2], ball, *_things()[3:]], [ball]),
        (_things()[1:], []),
    ):
        made = co.Scene(things)._reuse(scene)
        same_tables(made, co.Scene(things))
        assert lowered.pop() == new


def test_a_slider_changes_one_number_of_one_body():
    from conicoid.viewer.session import numbers_of, with_number

    scene = co.Scene(_things())
    scene.prepare()
    for item in (1, 3, 7):
        before = {number["path"][1]: number["value"] for number in numbers_of(scene, item)}
        for name, value in list(before.items())[:3]:
            changed = with_number(scene, item, name, value + 0.25)
            after = {number["path"][1]: number["value"] for number in numbers_of(changed, item)}
            assert after == before | {name: value + 0.25}
            assert [
                k for k, (new, old) in enumerate(zip(changed.bodies, scene.bodies, strict=True)) if new is not old
            ] == [item]
            assert changed._previous is scene._prepared


def test_preparing_reports_progress(computed_shapes):
    calls: list[tuple[int, int]] = []
    scene = co.Scene(_things())
    scene.prepare(lambda done, count: calls.append((done, count)))
    assert calls == [(i, 8) for i in range(1, 9)]
    scene.prepare(lambda done, count: calls.append((done, count)))
    assert len(calls) == 8
    with pytest.raises(TypeError, match="prepare: progress must be a function or None, got int"):
        scene.prepare(3)
