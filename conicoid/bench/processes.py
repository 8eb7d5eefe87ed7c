"""Programs of Conicoid and of peers that time themselves: from lists of numbers to a first hit, and one body moved.

Each reads centers and radii from a file into lists, and prints its seconds and the t of the hit. What it imports, and
the first small scene of its process, are not timed.
"""

from __future__ import annotations

LISTS = {
    "conicoid": """\
import sys, time
import numpy as np
import conicoid as co
data = np.load("balls.npy").tolist()
o, d = (0.0, 0.0, -3.0), (0.01, 0.02, 1.0)
co.Scene([co.Sphere(1.0, (0.1 * k, 0.0, 0.0)) for k in range(10)]).first_hit(o, d)
begin = time.perf_counter()
scene = co.Scene([co.Sphere(r, (x, y, z)) for x, y, z, r in data])
t = scene.first_hit(o, d).t
print(time.perf_counter() - begin, t)
""",
    "Raysect": """\
import time
import numpy as np
from raysect.core import Point3D, Ray, Vector3D, World, translate
from raysect.primitive import Sphere
data = np.load("balls.npy").tolist()
begin = time.perf_counter()
world = World()
balls = [Sphere(r, parent=world, transform=translate(x, y, z)) for x, y, z, r in data]
direction = Vector3D(0.01, 0.02, 1.0)
found = world.hit(Ray(Point3D(0, 0, -3), direction))
t = found.ray_distance if found is not None else float("inf")
print(time.perf_counter() - begin, t)
""",
    "Mitsuba": """\
import time
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
data = np.load("balls.npy").tolist()
ray = mi.Ray3f([0, 0, -3], [0.01, 0.02, 1.0])
begin = time.perf_counter()
listed = {f"s{i}": {"type": "sphere", "center": [x, y, z], "radius": r} for i, (x, y, z, r) in enumerate(data)}
scene = mi.load_dict({"type": "scene", **listed})
t = scene.ray_intersect(ray).t
print(time.perf_counter() - begin, t)
""",
}
"""From lists to a first hit."""

MOVED = {
    "conicoid": LISTS["conicoid"].partition("begin =")[0]
    + """\
scene = co.Scene([co.Sphere(r, (x, y, z)) for x, y, z, r in data])
scene.first_hit(o, d)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    scene = scene.moved(k, (0.0, 0.0, -0.01))
    t = scene.first_hit(o, d).t
    times.append(time.perf_counter() - begin)
print(sorted(times)[4], t)
""",
    "Raysect": LISTS["Raysect"].partition("begin =")[0]
    + """\
world, direction = World(), Vector3D(0.01, 0.02, 1.0)
balls = [Sphere(r, parent=world, transform=translate(x, y, z)) for x, y, z, r in data]
ray = Ray(Point3D(0, 0, -3), direction)
world.hit(ray)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    balls[k].transform = translate(0, 0, -0.01) * balls[k].transform
    found = world.hit(ray)
    times.append(time.perf_counter() - begin)
t = found.ray_distance if found is not None else float("inf")
print(sorted(times)[4], t)
""",
    "Mitsuba": LISTS["Mitsuba"].partition("begin =")[0]
    + """\
move = mi.ScalarTransform4f().translate([0, 0, -0.01])
listed = {f"s{i}": {"type": "sphere", "center": [x, y, z], "radius": r} for i, (x, y, z, r) in enumerate(data)}
scene = mi.load_dict({"type": "scene", **listed})
scene.ray_intersect(ray)
parameters = mi.traverse(scene)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    name = f"s{k}.to_world"
    parameters[name] = move @ mi.ScalarTransform4f(parameters[name].matrix)
    parameters.update()
    t = scene.ray_intersect(ray).t
    times.append(time.perf_counter() - begin)
print(sorted(times)[4], t)
""",
}
"""One ball moved, to the next first hit: the median of eight, a ball each. Peers are told in their own way."""
