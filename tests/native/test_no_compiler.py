"""Where the package has machine code, no call loads a compiler into the process."""

import json

import pytest

from conicoid._jit.machine_code import SHIPPED

from ..children import ROOT, child

BARREL = ROOT / "examples" / "scenes" / "barrel.yaml"

PROGRAM = """
import json, sys, threading, urllib.request
from pathlib import Path
import numpy as np
import conicoid as co
from conicoid.cli.app import app
from conicoid.render.integrators import INTEGRATORS
from conicoid.viewer.server import Server
from conicoid.viewer.session import Session

seen = {}

def look(after):
    seen[after] = sorted(name for name in sys.modules if name.partition(".")[0] in ("numba", "llvmlite"))

barrel, folder = sys.argv[1], Path(sys.argv[2])
scene = co.Scene([co.Body(co.Sphere() - co.Box((0, 0, 0), (2, 2, 2)), name="cut"), co.Sphere(1, (1.5, 0, 0))])
directions = np.random.default_rng(0).normal(size=(64, 64, 3))
hits = scene.first_hit((0, 0, 5), directions)
hits.normal, hits.uv, hits.t_error, hits.point_error
scene.first_hit(hits.spawn(directions))
scene.first_hit(np.zeros((4096, 3)), directions.reshape(-1, 3))
scene.spans((0, 0, 5), directions).t_enter_error
scene.crossings((0, 0, 5), directions).t_error
scene.occluded((0, 0, 5), directions)
scene.contains(directions)
scene.body_at(directions)
co.Scene([co.Spheres(np.random.default_rng(1).random((20_000, 3)), 0.001)]).first_hit((0, 0, 5), (0, 0, -1))
look("queries")
for integrator in INTEGRATORS:
    scene.render(16, 16, samples=2, integrator=integrator)
look("pictures")
co.check(scene, 2000)
look("check")
co.measure(scene, rays=1000)
look("measure")
co.warmup()
look("warmup")
server = Server(Session(co.load(barrel), "barrel"))
threading.Thread(target=server.serve_forever, daemon=True).start()
ray = {"origin": [-5.0, 0.1, 0.2], "direction": [1.0, 0.01, 0.003]}
own = {"Origin": f"http://127.0.0.1:{server.server_port}", "Content-Type": "application/json"}
for name, body in (("", None), ("scene", None), ("preview.webp", None), ("pick", json.dumps(ray).encode())):
    urllib.request.urlopen(urllib.request.Request(server.url + name, body, own if body else {})).read()
server.shutdown()
look("viewer")
for words in (["info", barrel, "--check", "--rays", "1000"], ["info", "--system"],
              ["render", barrel, "-o", str(folder / "o.png"), "--width", "16", "--height", "16"],
              ["export", barrel, str(folder / "o.html")]):
    app(words, standalone_mode=False)
    look("conicoid " + words[0])
print("\\n" + json.dumps(seen), flush=True)
"""


@pytest.mark.skipif(SHIPPED is None, reason="the kernels of this checkout are compiled")
def test_no_compiler_is_imported(tmp_path):
    with child(PROGRAM, BARREL, tmp_path) as running:
        code, out, errors = running.end(120)
    assert code == 0, errors
    modules = json.loads(out.splitlines()[-1])
    assert len(modules) == 9
    assert {after: names for after, names in modules.items() if names} == {}
