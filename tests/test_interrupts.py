"""Ctrl-C at any time: in kernels, in the compiler, in imports, in commands, and twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from .children import BOUND, COMMAND, ROOT, child, needs_signals
from .command_line import scene_file
from .machine_code import needs_compiler
from .samples import deep

pytestmark = needs_signals

NESTED = """
import sys, threading
import numpy as np
import conicoid as co

def nested(count):
    body = co.Sphere(1)
    for k in range(count):
        body = co.Sphere(1 + (k + 1) / count) - body
    return body

COUNT = 3000
shape = nested(COUNT)
scene = co.Scene([shape])

def rays(count, random=False):
    steps = np.linspace(0.1, 0.9, count)
    origins = np.stack([steps, 0.3 * steps, np.full(count, 5.0)], axis=1)
    directions = np.tile((0.0, 0.0, -1.0), (count, 1))
    if random:
        directions = np.random.default_rng(0).normal(size=(count, 3))
        origins = -5 * directions + 0.1
    return origins, directions

def touching(count):
    # along a tangent of a shell: doubtful
    radii = 1 + np.arange(1, count + 1) % COUNT / COUNT
    return np.stack([radii, 0 * radii, 0 * radii + 5], axis=1), (0.0, 0.0, -1.0)

def hits(found):
    return found.t, found.surface

ASKS = {
    "one tile": lambda n: hits(scene.first_hit(*rays(min(n, 1000)))),
    "in order": lambda n: hits(scene.first_hit(*rays(n))),
    "in no order": lambda n: hits(scene.first_hit(*rays(n, random=n > 4))),
    "doubtful": lambda n: hits(scene.first_hit(*touching(n))),
    "occluded": lambda n: (scene.occluded(*rays(n)),),
    "spans": lambda n: (scene.spans(*rays(n)).t_enter,),
    "doubtful spans": lambda n: (scene.spans(*touching(n)).t_enter,),
    "integral": lambda n: (scene.line_integral([1.0], *rays(n)),),
    "crossings": lambda n: (scene.crossings(*rays(n)).t,),
    "contains": lambda n: (scene.contains(rays(n)[0] * (1, 1, 0.1)),),
    "render": lambda n: (scene.render(n, 2, samples=1).pixels,),
    "measure": lambda n: (0,) if n < 5 else co.measure(shape, n),
    "check": lambda n: (0,) if n < 5 else co.check(scene, n),
    "lower": lambda n: (0,) if n < 5 else co.Scene([nested(n)])._prepared,
    "build": lambda n: (0,) if n < 5 else co.Scene([co.Spheres(np.random.default_rng(0).random((10 * n, 3)), 1e-3)])._prepared,
}
"""

ASKED = f"""{NESTED}
for name in sys.argv[1:]:
    before = ASKS[name](4)
    print(name, flush=True)
    try:
        ASKS[name](100_000)
        threading.Event().wait()  # on a machine that is done already
    except KeyboardInterrupt:
        print("stopped", flush=True)
    assert all(map(np.array_equal, ASKS[name](4), before)), name
"""


@pytest.mark.parametrize(
    "names",
    [
        ("one tile", "spans", "integral"),
        deep([
            "one tile", "in order", "in no order", "doubtful", "occluded", "spans", "doubtful spans", "integral",
            "crossings", "contains", "render", "measure", "check", "lower", "build",
        ]),
    ],
)  # fmt: skip
def test_long_work_stops_and_can_be_repeated(names):
    """Each of the slow rays crosses six thousand surfaces of one body: many minutes, in chunks of many seconds."""
    with child(ASKED, *names) as running:
        for name in names:
            assert running.line() == name, running.end()
            time.sleep(0.3)
            running.interrupt()
            assert running.line(BOUND) == "stopped", name
        assert running.end(300) == (0, "", "")


# In the compiler ------------------------------------------------------------------------------------

# A stand-in for LLVM at work: it lets other threads run, and ignores signals
COMPILING = """
import hashlib, threading
import numpy as np
import conicoid as co
from conicoid._jit import compiler as jit_functions

go_on = threading.Event()
finalize = jit_functions._KernelLibrary.finalize

def slow(self):
    print("begun", flush=True)
    while not go_on.is_set():
        hashlib.pbkdf2_hmac("sha256", b"", b"", {rounds})
    finalize(self)

jit_functions._KernelLibrary.finalize = slow
"""
UNTIL_TOLD, FOR_EVER = COMPILING.format(rounds=10**5), COMPILING.format(rounds=2**31 - 1)
RAYS = "co.Rays([(0.0, 0.0, 5.0)] * 2, (0.0, 0.0, -1.0))"
IN_A_CREW = f"from conicoid.kernels.threads import run_chunks; run_chunks(lambda a, b: {RAYS}, 4, 1)"


@needs_compiler
@pytest.mark.parametrize("call", [deep(RAYS), IN_A_CREW])
def test_the_compiler_is_not_waited_for(call, monkeypatch):
    monkeypatch.setenv("CONICOID_JIT", "own")
    with child(f"{FOR_EVER}\n{call}") as running:
        assert running.line() == "begun"
        running.interrupt()
        code, _, errors = running.end()
    assert code not in (0, 1)
    assert errors.splitlines()[-1] == "KeyboardInterrupt"


@needs_compiler
def test_interrupted_compilations_can_be_repeated(monkeypatch):
    monkeypatch.setenv("CONICOID_JIT", "own")
    again = f"except KeyboardInterrupt:\n    print('stopped', flush=True)\ngo_on.set()\nprint(len({RAYS}.origins))"
    with child(f"{UNTIL_TOLD}\ntry:\n    {RAYS}\n{again}") as running:
        assert running.line() == "begun"
        running.interrupt()
        assert running.line(BOUND) == "stopped"
        code, rest, errors = running.end(120)
    assert (code, rest.split()[-1], errors) == (0, "2", "")


# The first comes from outside. The program itself sends the second while it handles the first, and the third on its way
# out
THREE = """
import hashlib, signal
from conicoid.kernels import threads

def hang(begin, end):
    print("begun\\n", end="", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)

def join(crew, seconds, join=threads.join_threads):
    print("waiting\\n", end="", flush=True)
    signal.raise_signal(signal.SIGINT)
    join(crew, seconds)

threads.set_threads(2)
threads.join_threads = join
try:
    threads.run_chunks(hang, 8, 1)
finally:
    signal.raise_signal(signal.SIGINT)
"""


def test_a_second_and_a_third_one_during_the_first():
    with child(THREE) as running:
        assert running.line() == "begun"
        running.interrupt()
        code, out, errors = running.end()
    assert code == -signal.SIGINT
    assert "waiting" in out
    assert errors.count("Traceback") == 3
    assert errors.splitlines()[-1] == "KeyboardInterrupt"


# The command ----------------------------------------------------------------------------------------

WHEN_IMPORTED = f"""
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[0]:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(1000):
                pass

sys.argv = sys.argv[1:]
sys.meta_path.insert(0, Interrupting())
{COMMAND}
"""


EARLY = ["typer", "conicoid.cli.drawing", "numpy", "conicoid.kernels.tables"]
PROPER = "typer", "conicoid.cli.app"
"""Modules that plain commands do not import: see `command_line/plain.py`."""
LATE = [
    "conicoid.cli.app", "conicoid.scene.files", "yaml", "conicoid.scene.scene", "conicoid._jit.decorators",
    "conicoid.render.tiles", "PIL",
]  # fmt: skip


@pytest.mark.parametrize("module", [*EARLY, *(pytest.param(name, marks=pytest.mark.deep) for name in LATE)])
def test_while_something_is_imported(module, tmp_path):
    scene = scene_file(tmp_path)
    options = ["-o", tmp_path / "x.png", "--width", 8, "--height", 8]
    options += ["--samples=2"] if module in PROPER else []  # a command with samples is not plain
    with child(WHEN_IMPORTED, module, "render", scene, *options) as running:
        code, out, errors = running.end(300)
    assert (code, out) == (130, "")
    assert errors == "" or errors.endswith("interrupted\n")
    assert "Traceback" not in errors
    assert not list(tmp_path.glob("*x*.png"))


# A place in a command, at which the test makes it wait
HANGING = f"""
import importlib, signal, sys, threading
module, _, name = sys.argv[1].partition(":")
sys.argv = sys.argv[1:]

def hang(*_, **__):
    print("begun", flush=True)
    threading.Event().wait()

setattr(importlib.import_module(module), name, hang)
{COMMAND}
"""
PICTURE = ["-o", "x.png", "--width", 8, "--height", 8]
PLACES = [
    ("os:replace", ["trace", "scene.yaml", "rays.csv", "-o", "x.csv"], 1),
    ("conicoid.render.exposure:run_on", ["render", "scene.yaml", *PICTURE], 4),
]
FURTHER = [
    ("conicoid.prepare.lowering:lower", ["info", "scene.yaml"], 1),
    ("conicoid.prepare.lowering:lower", ["render", "scene.yaml", *PICTURE], 1),
    ("conicoid.render.exposure:run_on", ["render", "scene.yaml", *PICTURE], 1),
    ("os:replace", ["render", "scene.yaml", *PICTURE], 4),
    ("conicoid.io.scene_file.scene_file:read_scene", ["info", "scene.yaml"], 4),
    ("conicoid.apps.checks.check:check", ["info", "scene.yaml", "--check"], 1),
    ("conicoid.io.array_file:open_source", ["trace", "scene.yaml", "rays.csv", "-o", "x.csv"], 4),
    ("conicoid.io.openmc.importer:read", ["import", "geometry.xml", "-o", "x.yaml"], 1),
    ("conicoid.viewer.html:page", ["export", "scene.yaml", "x.html"], 1),
    ("conicoid.io.scene_file.schema:scene_schema", ["schema"], 4),
    ("conicoid.prepare.lowering:lower", ["view", "scene.yaml", "--no-browser"], 1),
]


@pytest.mark.parametrize(
    ("place", "arguments", "times"), [*PLACES, *(pytest.param(*case, marks=pytest.mark.deep) for case in FURTHER)]
)
def test_in_a_command(place, arguments, times, tmp_path):
    scene_file(tmp_path)
    (tmp_path / "rays.csv").write_text("0,0,5,0,0,-1\n")
    (tmp_path / "geometry.xml").write_text("<geometry></geometry>")
    with child(HANGING, place, *arguments, cwd=tmp_path) as running:
        while (line := running.line()) != "begun":
            assert line or running.process.poll() is None
        for _ in range(times):
            running.interrupt()
            time.sleep(0.02)
        code, _, errors = running.end()
    assert code == 130
    assert "Traceback" not in errors
    assert "Exception" not in errors
    if times == 1:
        assert errors.endswith("interrupted\n")
        assert sorted(path.name for path in tmp_path.iterdir()) == ["geometry.xml", "rays.csv", "scene.yaml"]


STARTING = """
import os, signal, sys
place = int(os.environ["PLACE"])
def hook(event, arguments):
    global place
    if event == "import" and (place < int(os.environ["PLACE"]) or arguments[0] == "conicoid.cli"):
        place -= 1
        if place < 0:
            os.kill(os.getpid(), signal.SIGINT)
if "conicoid" in " ".join(sys.orig_argv):
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.addaudithook(hook)
"""
"""The program sends Ctrl-C at an import, counted from that of `conicoid.cli`, the first large one, and at all later
ones.
"""


@needs_signals
@pytest.mark.parametrize("place", [0, 1, 2, 3, 5, 8, 13, 21, 34, 55])
@pytest.mark.parametrize("arguments", [["-m", "conicoid"], ["conicoid"]])
def test_control_c_while_the_command_starts(arguments, place, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(STARTING)
    (tmp_path / "conicoid").write_text(f"import sys\n{COMMAND}\n")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}", "PLACE": str(place)}
    ended = subprocess.run(
        [sys.executable, *arguments, "info", "nothing.yaml"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert ended.returncode in (130, -signal.SIGINT), ended.stderr
    assert ended.stderr in ("", "interrupted\n")
