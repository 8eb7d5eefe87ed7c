"""Scenes, answers, pictures and colors have the same bits with the arithmetic libraries of other processors.

NumPy, its BLAS and the C library have code of their own for each generation of processors. An option of each selects
the code of an older one.
"""

import json
import platform

import pytest

from ..children import child

PROGRAM = """
import hashlib, json
import numpy as np
import conicoid as co
from conicoid.render.color_mapping import apply_colormap
from conicoid.io.importers import palette_color
from conicoid.io.image_codecs import srgb_bytes
from conicoid.render.camera import fit_camera

random = np.random.default_rng(1)

def turned(shape):
    return shape.rotate((1, 2, 3), float(random.uniform(0, 360))).translate(tuple(random.uniform(-3, 3, 3)))

def digest(arrays):
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()[:16]

waist = co.Quadric(coefficients=dict(xx=1, xy=0.3, yy=2, zz=-0.5, z=0.7, constant=-1))
balls = co.Spheres(random.uniform(-4, 4, (400, 3)), 0.2)
shapes = [
    turned(co.Sphere(0.7)), turned(co.Cylinder((0, 0, 0), (1, 2, 0.3), 0.4, reference=(1, 0, 0), start_angle=17, end_angle=123)),
    turned(co.Cone((0, 0, 0), (0.3, 0.2, 1.7), 0.8, 0.2)), turned(co.Ellipsoid((1, 0.4, 0.3))), turned(co.Box() - co.Sphere(0.6)),
    turned(co.HyperbolicParaboloid(1, 0.7, within=co.Box((-1, -1, -1), (1, 1, 1)))), turned(co.Disc((0, 0, 0), (0.1, 0.2, 1), 0.5)),
    turned(waist & turned(co.Box((-2, -2, -2), (2, 2, 2)))), balls.rotate((1, 1, 0), 33), balls.rotate((1, 1, 0), 33).scale((1, 2, 1.5)),
]
items = [co.Body(shape, co.phong((0.7, 0.3, 0.2), specular=0.6)) for shape in shapes]
items.append(co.Body(co.Sphere(1.5), co.glass(absorption=(0.1, 0.5, 0.2))))
lights = [co.PointLight((9, 9, 9), 0.5), co.SpotLight((0, -9, 9), (0, 1, -1)), co.DirectionalLight((1, 1, -1.7), 0.5), co.AmbientLight(0.1)]
scene = co.Scene(items, lights=lights)
camera = co.Camera((7, -9, 5), (0, 0, 0), field_of_view=53.1)
image = scene.render(130, 100, samples=2, camera=camera)
hits = scene.first_hit(camera.rays(130, 100))
strewn = scene.first_hit(random.uniform(-9, 9, (20_000, 3)), random.normal(size=(20_000, 3)))
fields = ("t", "point", "normal", "uv", "t_error", "point_error", "body")
tables = scene._prepared.lowered.tables
print(json.dumps({name: digest(arrays) for name, arrays in {
    "tables": [table for name, table in zip(tables._fields, tables) if name != "leaf_items"],  # has room that nobody reads
    "bounds": [end for shape in shapes for end in shape.bounds],
    "cameras": [fit_camera(*scene.extent, 1.3, 7).lens, camera.lens, camera.rays(130, 100).directions, camera.project(hits.point, 130, 100)],
    "hits": [getattr(answer, name) for answer in (hits, strewn) for name in fields],
    "spans": [scene.spans(hits.rays).lengths()],
    "picture": [image.pixels, srgb_bytes(image.pixels)],
    "colours": [apply_colormap(random.uniform(-1, 1, 5000), "dusk")],
    "palette": [np.array([*map(palette_color, range(300))])],
}.items()}), flush=True)
"""

LIBRARIES = {
    "OPENBLAS_CORETYPE": "Nehalem",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3,X86_V4,AVX512_ICL,AVX512_SPR,AVX2,FMA3,AVX512F,AVX512_SKX",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX2_Usable,-FMA_Usable",
}
KERNELS = [{"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""} for name in ("x86-64-v2", "x86-64-v3")]


def digests(monkeypatch: pytest.MonkeyPatch, settings: dict[str, str]) -> dict[str, str]:
    with monkeypatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(name, value)
        patch.setenv("PYTHONWARNINGS", "ignore")  # NumPy warns about features that it does not know
        with child(PROGRAM) as running:
            line = running.line(1200)
            code, _, errors = running.end(60)
            assert code == 0, errors
    return json.loads(line)


def test_old_libraries_change_nothing(monkeypatch):
    usual = digests(monkeypatch, {})
    assert len(usual) == 8
    assert digests(monkeypatch, LIBRARIES) == usual


@pytest.mark.deep
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="kernels are compiled for levels of x86-64")
@pytest.mark.parametrize("settings", KERNELS, ids=lambda settings: settings["NUMBA_CPU_NAME"])
def test_kernels_for_old_processors_change_nothing(monkeypatch, settings):
    assert digests(monkeypatch, settings | LIBRARIES) == digests(monkeypatch, {})
