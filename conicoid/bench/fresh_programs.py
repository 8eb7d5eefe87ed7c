"""The programs of `fresh`: a first hit on a ball from z = -3, which is at t = 2, and a small picture of a ball."""

from __future__ import annotations

OURS = "conicoid"

HITS = {
    OURS: """\
import conicoid as co
print(co.Scene([co.Sphere()]).first_hit((0, 0, -3), (0, 0, 1)).t)
""",
    "Embree": """\
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector
rays = RayMeshIntersector(trimesh.creation.box((2, 2, 2)))
points, _, _ = rays.intersects_location([(0, 0, -3)], [(0, 0, 1)], multiple_hits=False)
print(points[0, 2] + 3)
""",
    "Raysect": """\
from raysect.core import Point3D, Ray, Vector3D, World
from raysect.primitive import Sphere
world = World()
ball = Sphere(1, parent=world)
print(world.hit(Ray(Point3D(0, 0, -3), Vector3D(0, 0, 1))).ray_distance)
""",
    "Mitsuba": """\
import mitsuba as mi
mi.set_variant("scalar_rgb")
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
print(scene.ray_intersect(mi.Ray3f([0, 0, -3], [0, 0, 1])).t)
""",
}
"""Each prints t. Embree has triangles: a box of twelve, whose wall is where the ball's is."""

PICTURES = {
    OURS: """\
import conicoid as co
camera = co.Camera((0, 0, -5), (0, 0, 0), up=(0, 1, 0))
scene = co.Scene([co.Sphere()], lights=[co.PointLight((3, 4, -5))], camera=camera, background=(0, 0, 0))
scene.render(64, 48).save("picture.png")
""",
    "Raysect": """\
import matplotlib
matplotlib.use("agg")
from raysect.core import SerialEngine
from raysect.optical import ConstantSF, Point3D, World, d65_white, translate
from raysect.optical.material import Lambert, UniformSurfaceEmitter
from raysect.optical.observer import PinholeCamera, RGBPipeline2D
from raysect.primitive import Sphere
world = World()
ball = Sphere(1, world, material=Lambert(ConstantSF(0.8)))
light = Sphere(2, world, translate(3, 4, -8), UniformSurfaceEmitter(d65_white))
picture = RGBPipeline2D(display_progress=False)
camera = PinholeCamera((64, 48), parent=world, transform=translate(0, 0, -5), pipelines=[picture])
camera.pixel_samples, camera.spectral_bins, camera.quiet, camera.render_engine = 4, 15, True, SerialEngine()
camera.observe()
picture.save("picture.png")
""",
    "Mitsuba": """\
import mitsuba as mi
mi.set_variant("scalar_rgb")
view = mi.ScalarTransform4f().look_at(origin=[0, 0, -5], target=[0, 0, 0], up=[0, 1, 0])
film = {"type": "hdrfilm", "width": 64, "height": 48}
camera = {"type": "perspective", "to_world": view, "film": film, "sampler": {"type": "independent", "sample_count": 4}}
light = {"type": "point", "position": [3, 4, -5], "intensity": 50.0}
scene = {"type": "scene", "by": {"type": "direct"}, "ball": {"type": "sphere"}, "light": light, "camera": camera}
mi.util.write_bitmap("picture.png", mi.render(mi.load_dict(scene)), write_async=False)
""",
}
"""Each writes picture.png, 64 x 48 pixels, four rays each. Raysect has no lights but what shines: a ball does."""

POVRAY = """\
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0,0,-5> look_at <0,0,0> angle 50 }
light_source { <3,4,-5> rgb 1 }
sphere { <0,0,0>, 1 texture { pigment { rgb 0.8 } finish { diffuse 0.8 } } }
"""
"""The same picture as a scene file."""
