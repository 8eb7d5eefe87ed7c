"""Motion while the shutter is open: blur in closed form, stills where nothing moves, frames of films."""

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.render.film import SUMS, square_means

from ..interruptions import Interruption

WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
RADIUS, WAY = 0.3, 1.4
VIEW = co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), height=2.0)


def moving_ball(**track):
    """Return a white ball that goes from x = -0.7 to 0.7 in the first second."""
    ball = co.Body(co.Sphere(RADIUS, (-WAY / 2, 0, 0)), co.glow(1), "ball")
    tracks = co.scene.BodyTrack("ball", (0, 1), **(track or dict(translate=((0, 0, 0), (WAY, 0, 0)))))
    return co.Scene([ball], [co.AmbientLight(0)], VIEW, BLACK, animation=tracks)


def time_share(x, half):
    """Return the share of the time in which a body 2 half wide, on its way from -WAY / 2 to WAY / 2, covers x."""
    return max(0.0, min(WAY / 2, x + half) - max(-WAY / 2, x - half)) / WAY


@pytest.mark.parametrize("integrator", ["whitted", "path"])
def test_the_blur_of_a_ball_that_moves(integrator):
    """At height y its half chord is √(R² - y²); a pixel is 2 / 50 wide, a moment 1 / 128 of the time."""
    pixels = moving_ball().render(50, 50, 256, integrator, shutter=(0, 1), times=128).pixels[..., 0]
    places = -1 + (np.arange(50) + 0.5) * 2 / 50
    for row in (24, 20, 27):
        y = -(places[row])
        near, far = abs(y) - 1 / 50, abs(y) + 1 / 50
        halves = [math.sqrt(max(0.0, RADIUS**2 - part * part)) for part in (far, near)]
        low, high = (
            [time_share(abs(x) + sign / 50, half) for x in places] for sign, half in ((1, halves[0]), (-1, halves[1]))
        )
        assert (pixels[row] >= np.array(low) - 1 / 64).all()
        assert (pixels[row] <= np.array(high) + 1 / 64).all()
    total = pixels.sum() * (2 / 50) ** 2
    assert total == pytest.approx(math.pi * RADIUS**2, rel=5e-3)


def test_a_body_that_turns():
    """Half a disc turns once about z, so it covers each point of the disc half of the time."""
    half = co.Disc((0, 0, 0), (0, 0, 1), 0.9) & co.HalfSpace((0, 1, 0), 0)
    track = co.scene.BodyTrack("half", (0, 1), degrees=(0, 360))
    scene = co.Scene([co.Body(half, co.glow(1), "half")], [co.AmbientLight(0)], VIEW, BLACK, animation=track)
    pixels = scene.render(20, 20, 64, shutter=(0, 1)).pixels[..., 0]
    places = -0.95 + 0.1 * np.arange(20)
    inside = np.hypot(*np.meshgrid(places, places)) < 0.8
    assert pixels[inside] == pytest.approx(0.5, abs=0.06)
    assert pixels[inside].mean() == pytest.approx(0.5, abs=0.01)


def test_still_bodies_look_as_without_a_shutter():
    scene = co.Scene(
        [co.Body(co.Sphere(0.5), "red"), co.Body(co.Sphere(0.1, (0, 0, 2)), co.glow(9), "lamp")], [], VIEW, (0.1,) * 3,
        animation=co.scene.BodyTrack("lamp", (5, 6), translate=((0, 0, 0), (1, 0, 0))),
    )  # fmt: skip
    still = scene.render(24, 24, 12, "path").pixels
    assert (scene.render(24, 24, 12, "path", shutter=(0, 1), times=5).pixels == still).all()
    assert (scene.render(24, 24, 12, "path", shutter=(5, 6)).pixels != still).any()


def test_each_moment_is_an_exact_still():
    """One moment is the scene at the middle of the time, with its layers."""
    scene = moving_ball()
    one = scene.render(30, 20, 4, "path", shutter=(0, 0.5), times=1, layers=["depth", "body"])
    still = scene.at(0.25).render(30, 20, 4, "path", layers=["depth", "body"])
    assert (one.pixels == still.pixels).all()
    assert (one.layers["depth"] == still.layers["depth"]).all()
    assert scene.at(0.25)["ball"].shape.bounds[0][0] == pytest.approx(-WAY / 2 + WAY / 4 - RADIUS, abs=1e-15)


def test_a_camera_that_moves():
    camera = co.Camera((0, -5, 1), (0, 0, 0))
    track = co.scene.CameraTrack((0, 2), position=((0, -5, 1), (4, -5, 3)), field_of_view=(40, 20))
    scene = co.Scene([co.Sphere(1)], camera=camera, animation=[track])
    assert scene.at(1).camera == co.Camera((2, -5, 2), (0, 0, 0), field_of_view=30)
    assert scene.at(9).camera == co.Camera((4, -5, 3), (0, 0, 0), field_of_view=20)
    assert scene.camera == camera
    assert scene.at(0).animation == ()
    moved, still = (one.render(20, 15, 8, "path", shutter=(0, 2)) for one in (scene, scene.replace(animation=())))
    assert (moved.pixels != still.pixels).any()


def test_keys():
    """A key holds outside of the times. Between two the motion is linear, or smooth: 3 s² - 2 s³."""
    track = co.scene.BodyTrack("b", (1, 2, 4), translate=((0, 0, 0), (1, 0, 0), (1, 2, 0)), ease="smooth")
    ball = co.Sphere(1)
    assert track.moved(ball, 0.5) is ball
    for time, place in ((1.25, (3 / 16 - 2 / 64, 0, 0)), (2, (1, 0, 0)), (3, (1, 1, 0)), (7, (1, 2, 0))):
        low, high = track.moved(ball, time).bounds
        assert (low + high) / 2 == pytest.approx(place, abs=1e-15)
    turned = co.scene.BodyTrack("b", (0, 1), degrees=(0, 90), about=(1, 0, 0)).moved(co.Sphere(0.5), 1)
    assert (turned.bounds[0] + turned.bounds[1]) / 2 == pytest.approx((1, -1, 0), abs=1e-15)


def test_scene_files_and_pickles_keep_animations(tmp_path):
    import pickle

    scene = moving_ball().replace(animation=[
        co.scene.BodyTrack("ball", (0, 1, 3.5), translate=((0, 0, 0), (1, 0, 0), (0, 0.1, 0)), degrees=(0, 45, 90), axis=(1, 2, 3)),
        co.scene.CameraTrack((0, 1), look_at=((0, 0, 0), (1, 0, 0))), co.scene.LightTrack(0, (0, 1), intensity=(0, 2)),
    ])  # fmt: skip
    for name in ("scene.yaml", "scene.json"):
        co.save(scene, tmp_path / name)
        assert co.load(tmp_path / name) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert scene.replace(animation=None) != scene


FILE = """
camera: {position: [0, -6, 2], look_at: [0, 0, 0]}
bodies:
  - {name: top, shape: {Sphere: {radius: 1}}}
animation:
  - BodyTrack: {body: %s, times: [0, 1], degrees: [0, 90], axis: z}
"""


def test_a_file_that_moves_a_missing_body_is_refused(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(FILE % "top")
    assert co.load(path).animation[0].degrees == (0, 90)
    path.write_text(FILE % "topp")
    with pytest.raises(co.SceneFileError, match="unknown body 'topp'; .*top"):
        co.load(path)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: co.scene.BodyTrack("a", (0, 1)), ValueError, "translate or degrees must say how 'a' moves"),
        (lambda: co.scene.BodyTrack("a", (1, 0), degrees=(0, 1)), ValueError, "times must grow, got 1 before 0"),
        (lambda: co.scene.BodyTrack("a", (), degrees=()), ValueError, "times must be a list of one time or more"),
        (lambda: co.scene.BodyTrack("a", (0, 1), degrees=(0,)), ValueError, "degrees must be a list of 2"),
        (lambda: co.scene.BodyTrack("a", (0,), degrees=(0,), axis="w"), ValueError, "axis must be three numbers or one of"),
        (lambda: co.scene.BodyTrack("a", (0,), degrees=(0,), ease="fast"), ValueError, "ease must be one of"),
        (lambda: co.scene.CameraTrack((0, 1)), ValueError, "CameraTrack: position, look_at"),
        (lambda: co.Scene(co.Sphere(), animation=3), TypeError, "Scene: animation must be a list of"),
        (lambda: moving_ball().replace(camera=None, animation=co.scene.CameraTrack((0,), position=((0, 0, 9),))).at(0),
         ValueError, "at: the scene must have a camera"),
        (lambda: moving_ball().without("ball").at(0.5), KeyError, "no body named 'ball'"),
        (lambda: co.scene.LightTrack(0, (0, 1)), ValueError, "LightTrack: position, direction or intensity must say"),
        (lambda: co.scene.LightTrack(-1, (0,), intensity=(1,)), ValueError, "LightTrack: light must be the number of a light"),
        (lambda: co.scene.LightTrack(0, (0, 1), intensity=(1,)), ValueError, "intensity must be a list of 2"),
        (lambda: moving_ball().replace(animation=co.scene.LightTrack(1, (0,), intensity=(1,))).at(0),
         ValueError, "the scene has 1 light, from 0 on; a LightTrack moves light 1"),
        (lambda: moving_ball().replace(animation=co.scene.LightTrack(0, (0,), position=((0, 0, 1),))).at(0),
         ValueError, "position is nothing that a AmbientLight has"),
    ],
)  # fmt: skip
def test_refusals(make, error, message):
    with pytest.raises(error, match=message):
        make()


# ---- Resumed, and on workers ----


@pytest.mark.parametrize("integrator", ["whitted", "path"])
@pytest.mark.parametrize("at", [3, 9, 40])
def test_a_shutter_that_was_interrupted_goes_on(tmp_path, integrator, at):
    """A break may come in the middle of a moment. Finished work is not repeated."""
    scene, stop = moving_ball(), Interruption(at)
    options = dict(width=70, height=40, samples=12, integrator=integrator, shutter=(0, 1), times=5)
    whole = scene.render(**options).pixels
    try:
        scene.render(**options, resume=tmp_path / "file", progress=stop)
    except KeyboardInterrupt:
        assert len(stop.calls) == at
    assert (scene.render(**options, resume=tmp_path / "file").pixels == whole).all()
    done = []
    assert (scene.render(**options, resume=tmp_path / "file", progress=lambda *s: done.append(s)).pixels == whole).all()
    assert done == []
    for other in (dict(samples=13), dict(times=4), dict(shutter=(0, 0.9)), dict(camera=VIEW)):
        with pytest.raises(ValueError, match="holds parts of other work"):
            scene.render(**options | other, resume=tmp_path / "file")


@pytest.mark.parametrize("integrator", ["whitted", "path"])
def test_a_shutter_on_workers(tmp_path, integrator):
    from conicoid.parallel.workers import inline_workers

    options = dict(width=70, height=40, samples=12, integrator=integrator, shutter=(0, 1), times=5)
    workers, calls = inline_workers(), []
    workers.chunk = 1
    near = moving_ball().render(**options).pixels
    far = moving_ball().render(**options, executor=workers, progress=lambda *step: calls.append(step))
    assert (far.pixels == near).all()
    assert calls[-1][0] == calls[-1][1]
    assert (moving_ball().render(**options, executor=workers, resume=tmp_path / "file").pixels == near).all()
    assert (moving_ball().render(**options, resume=tmp_path / "file").pixels == near).all()


# ---- Until noise is gone ----

ROUND = 70  # samples, of 14 moments five each: the fewest that are 64 or more
UNTIL = dict(width=70, height=40, integrator="path", shutter=(0, 1), times=14, noise=0.02)


def test_noise_is_measured_after_all_moments():
    """One round is enough where all moments are alike.

    A pixel in the ball's way is black or white, depending on the moment.
    """
    image = moving_ball().render(**UNTIL, samples=5 * ROUND + 3, layers=("samples", "error"))
    samples, error = image.layers["samples"], image.layers["error"]
    assert set(np.unique(samples)) <= {k * ROUND for k in range(1, 6)} | {5 * ROUND + 3}
    places = np.abs((np.arange(40) + 0.5) / 20 - 1)
    assert (samples[places > RADIUS + 0.4] == ROUND).all()
    assert samples[18:22].max() == 5 * ROUND + 3
    rms = np.sqrt(square_means(error.astype(float) ** 2, 8))
    assert ((rms <= 0.02 * (1 + 1e-6)) | (samples[::8, ::8] == samples.max())).all()


def test_progress_goes_forward_where_some_are_done():
    calls = []
    moving_ball().render(**UNTIL, samples=3 * ROUND, progress=lambda done, count: calls.append(done / count))
    assert calls == sorted(calls)
    assert len(calls) > 14


def test_moments_write_their_changes(tmp_path):
    """Moments do not write every tile into the file. They write from time to time, and in the end."""
    moving_ball().render(**UNTIL, samples=3 * ROUND, resume=tmp_path / "file")
    assert (tmp_path / "file").stat().st_size < 1.5 * 70 * 40 * SUMS * 8 + 10_000


def test_noise_that_ends_the_work_leaves_the_mean_of_the_moments():
    """As many samples see each moment whenever the work ends.

    So within the noise it is the picture of that many samples.
    """
    until = moving_ball().render(**UNTIL | dict(noise=0.03)).pixels
    every = moving_ball().render(**UNTIL | dict(noise=None), samples=40 * ROUND).pixels
    assert until.sum() == pytest.approx(every.sum(), rel=5e-3)
    assert np.sqrt(((np.sqrt(until) - np.sqrt(every)) ** 2).mean()) < 0.03


def test_a_lower_limit_of_noise_continues_a_picture(tmp_path):
    from conicoid.parallel.workers import inline_workers

    scene, workers = moving_ball(), inline_workers()
    workers.chunk = 1
    options = UNTIL | dict(samples=3 * ROUND + 10)
    whole = scene.render(**options).pixels
    assert (scene.render(**options, executor=workers).pixels == whole).all()
    with pytest.raises(KeyboardInterrupt):
        scene.render(**options | dict(noise=0.1), resume=tmp_path / "file", progress=Interruption(20))
    scene.render(**options | dict(noise=0.1), resume=tmp_path / "file")
    assert (scene.render(**options, resume=tmp_path / "file").pixels == whole).all()
    assert (scene.render(**options, resume=tmp_path / "file", executor=workers).pixels == whole).all()
    scene.render(**options, resume=tmp_path / "file", progress=Interruption())  # nothing is left to do
    for other in (dict(samples=4 * ROUND), dict(noise=None), dict(times=13)):
        with pytest.raises(ValueError, match="holds parts of other work"):
            scene.render(**options | other, resume=tmp_path / "file")


# ---- Lights ----


def test_a_light_that_moves_away():
    """The floor under a light of intensity I at height h is I / h² bright. The mean of 1 / h² from 1 to 2 is 1 / 2."""
    light = co.PointLight((0, 0, 1), 1, falloff="inverse_square")
    floor = co.Body(co.Box((-9, -9, -1), (9, 9, 0)), co.matte(WHITE))
    above = co.OrthographicCamera((0, 0, 0.5), (0, 0, 0), up=(0, 1, 0), height=1e-6)
    track = co.scene.LightTrack(0, (0, 1), position=((0, 0, 1), (0, 0, 2)))
    scene = co.Scene(floor, [light], above, BLACK, animation=track)
    for time, height in ((-1, 1), (0.5, 1.5), (3, 2)):
        assert scene.at(time).lights[0].position == pytest.approx((0, 0, height))
        assert scene.at(time).render(1, 1, 1).pixels[0, 0] == pytest.approx([1 / height**2] * 3, rel=1e-6)
    radiance = scene.render(1, 1, 128, shutter=(0, 1), times=128).pixels[0, 0]
    assert radiance == pytest.approx([0.5] * 3, rel=2e-5)  # 128 moments: (f'(2) - f'(1)) / (24 · 128²) is 4.5e-6
    brighter = scene.replace(animation=co.scene.LightTrack(0, (0, 1), intensity=(1, 3)))
    assert brighter.at(0.5).render(1, 1, 1).pixels[0, 0] == pytest.approx([2] * 3, rel=1e-6)
