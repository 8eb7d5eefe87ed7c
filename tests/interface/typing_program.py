"""A user's program, without regard to type hints: mypy reports nothing (`make check` runs it)."""

import numpy as np
import numpy.typing as npt

import conicoid as co

center = np.array([0.0, 0.0, 1.0])
lights = [co.AmbientLight(0.3), co.DirectionalLight(np.array([1, 2, -3]), 0.8)]
drilled = co.Sphere(1, center) - co.Cylinder([0, 0, -2], [0, 0, 2], 0.5)
scene = co.Scene(
    [co.Body(drilled.rotate("z", 30), "red"), co.Box([-1, -1, -1], np.ones(3)), co.Plane(np.array([0, 0, 1]), -2)],
    lights=lights,
    camera=co.Camera(np.array([0, -5, 2]), [0, 0, 0]),
)
hits = scene.first_hit(np.zeros((4, 3)), [1, 0, 0])
depths: npt.NDArray[np.float64] = hits.t
numbers: npt.NDArray[np.int32] = hits.body
which: npt.NDArray[np.bool_] = hits.hit
mean = float(hits.t[hits.hit].mean())
image = scene.render(width=8, height=6, samples=1, integrator="normals", seed=1, depth=3)
pixels = np.asarray(image)
for one in hits:
    if one:
        nearest = one.point.tolist()
for spans in scene.spans(np.zeros((4, 3)), [1, 0, 0]):
    lengths = spans.t_exit - spans.t_enter
far = co.Rays.concatenate([hits.spawn([0, 0, 1]), co.Rays([0, 0, 9], [0, 0, -1])])
view = co.Camera([0, -5, 2], np.zeros(3))
drawn = scene.render(width=8, height=6, camera=view, axes=True, labels=True)
places: npt.NDArray[np.float64] = view.project(hits.point, 8, 6)
turned = scene.replace(0, scene.bodies[0].shape.rotate("x", 10)).replace(camera=scene.fitting_camera(4 / 3))
turned.prepare(progress=lambda done, count: None)
hits.save("hits.npz")
again: co.Hits = co.Hits.concatenate([co.Hits.load("hits.npz"), hits])
kept: co.Spans = co.Spans.load("spans.npz")
plan: co.Image = scene.section("z", 0.5)
frames: int = co.turntable(turned, "spin.gif", frames=2, camera=view)
scene.rendered = 3  # type: ignore[attr-defined]  # an error: the comment would be one if hints were not found
