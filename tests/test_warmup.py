"""`co.warmup()` leaves no kernel uncompiled."""

import inspect

import pytest

from conicoid.scene.scene import QUERIES, Scene

from .children import child
from .machine_code import needs_compiler, needs_machine_code

CALLED = """
from conicoid._jit import decorators, machine_code
shipped, called = machine_code.entry, set()

def entry(name):
    found = shipped(name)
    def call(*arguments):
        called.add(name)
        return found(*arguments)
    return found and call

decorators.entry = entry
import conicoid as co
from native.signature import declared
every = {each.name for each in declared()}
from conicoid.prepare import prepared_scene
machine_code.SHIPPED = prepared_scene.SHIPPED = None  # otherwise there is nothing to warm up
co.warmup()
print(len(every), sorted(every - called), flush=True)
"""

PROGRAM = """
import sys
import conicoid as co, numpy as np
from conicoid.render.integrators import INTEGRATORS
from numba.core import event
from conicoid._jit.compiler import Kernel

co.warmup()
found = {
    f"{home}.{name}": item
    for home, module in list(sys.modules.items()) if home.startswith("conicoid.")
    for name, item in vars(module).items() if isinstance(item, Kernel) and item.py_func.__module__ == home
}
print(len(found), sorted(name for name, item in found.items() if not item.signatures), flush=True)

with event.install_recorder("numba:compile") as late:
    scene = co.Scene([
        co.Sphere(), co.Box((2, -1, -1), (3, 1, 1)) - co.Sphere(1.2, (2, 0, 0)), co.Plane((0, 0, 1), -9),
        co.Polygon([(5, 0, 0), (6, 0, 0), (5, 1, 0)]), co.Spheres([(0, 5, 0)], 1), co.Cylinder((9, 0, 0), (9, 3, 1), 1),
    ])
    some = np.random.default_rng(0)
    for count in (1, 100, 20_000):
        origins, directions = some.uniform(-3, 3, (2, count, 3))
        hits = scene.first_hit(origins, directions)
        for rays in (hits.rays, hits.spawn(some.normal(size=(count, 3)))):
            scene.occluded(rays)
            for answer in (scene.first_hit(rays), scene.spans(rays), scene.crossings(rays)):
                answer[:100].detached()
    scene.first_hit((1, 0, 5), (0, 0, -1))
    for integrator in INTEGRATORS:
        scene.render(16, 16, samples=1, integrator=integrator)
    co.measure(co.Sphere() - co.Box(), rays=1000)
    co.check(scene, rays=600)
print([entry.data["dispatcher"].py_func.__name__ for _, entry in late.buffer], flush=True)
"""


def test_the_table_of_queries_agrees_with_scene():
    """The table has their first arguments, and every method that takes an executor and makes no picture."""
    arguments = {
        name: list(inspect.signature(method).parameters)
        for name, method in vars(Scene).items()
        if callable(method) and not name.startswith("_")
    }
    assert {name: arguments[name][1] for name in QUERIES} == QUERIES
    assert {name for name, each in arguments.items() if "executor" in each} - {"render", "slice", "voxels"} <= set(
        QUERIES
    )


@needs_machine_code
def test_warmup_calls_every_kernel():
    """Each kernel has one signature, to which machine code holds its callers. So one call compiles all."""
    with child(CALLED) as running:
        count, left = running.line(300).split(" ", 1)
        assert int(count) > 20
        assert left == "[]"


@pytest.mark.deep
@needs_compiler
def test_nothing_is_left_to_be_compiled(monkeypatch):
    monkeypatch.setenv("CONICOID_JIT", "own")
    with child(PROGRAM) as running:
        count, left = running.line(1200).split(" ", 1)
        assert int(count) > 20
        assert left == "[]"
        assert running.line(1200) == "[]"
        assert running.end(60)[0] == 0
