"""A fork while another thread is at work: the child can do all that the parent can."""

import gc
import os
import weakref

import pytest

from conicoid._util import process as forks

from .children import child
from .machine_code import needs_compiler

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")

PREPARING = """
import os, threading
import conicoid as co
from conicoid.prepare import lowering

begun, go_on, lower = threading.Event(), threading.Event(), lowering.lower
scene = co.Scene([co.Sphere(1)])
parent = os.getpid()

def slow(bodies):
    if os.getpid() == parent:
        begun.set()
        go_on.wait()
    return lower(bodies)

lowering.lower = slow
threading.Thread(target=lambda: scene._prepared).start()
begun.wait()
forked = os.fork()
if forked == 0:
    print(scene._prepared.lowered.body_count, flush=True)
    os._exit(0)
go_on.set()
print(os.waitpid(forked, 0)[1])
"""

COMPILING = """
import os, threading, time
import conicoid as co
from conicoid._jit import compiler as jit_functions

begun, forking = threading.Event(), threading.Event()
finalize = jit_functions._KernelLibrary.finalize
parent = os.getpid()

def slow(self):
    if os.getpid() == parent and not begun.is_set():
        begun.set()
        forking.wait()
        time.sleep(0.3)
    finalize(self)

jit_functions._KernelLibrary.finalize = slow
rays = lambda: co.Rays([(0.0, 0.0, 5.0)] * 2, (0.0, 0.0, -1.0))
threading.Thread(target=rays).start()
begun.wait()
forking.set()
forked = os.fork()
if forked == 0:
    print(len(rays().origins), flush=True)
    os._exit(0)
print(os.waitpid(forked, 0)[1])
"""

IMPORTING = """
import os, sys, threading, time
import conicoid as co

begun = threading.Event()

class Slow:
    def find_spec(self, name, *_):
        if name == "conicoid.prepare.lowering" and not begun.is_set():
            begun.set()
            time.sleep(0.3)

sys.meta_path.insert(0, Slow())
threading.Thread(target=lambda: co.Scene([co.Sphere(1)])._prepared).start()
begun.wait()
forked = os.fork()
if forked == 0:
    print(co.Scene([co.Sphere(1)])._prepared.lowered.body_count, flush=True)
    os._exit(0)
print(os.waitpid(forked, 0)[1])
"""

CACHING = """
import os, threading
import conicoid as co

begun, go_on, key = threading.Event(), threading.Event(), vars(type(co.Scene([])._prepared))["key"]
compute, parent = key.func, os.getpid()

def slow(prepared):
    if os.getpid() == parent:
        begun.set()
        go_on.wait()
    return compute(prepared)

key.func = slow
threading.Thread(target=lambda: co.Scene([co.Sphere(1)])._prepared.key).start()
begun.wait()
forked = os.fork()
if forked == 0:
    print(len(co.Scene([co.Sphere(1)])._prepared.key), flush=True)
    os._exit(0)
go_on.set()
print(os.waitpid(forked, 0)[1])
"""


@pytest.mark.parametrize(("program", "message"), [
    pytest.param(IMPORTING, "1", id="importing"), pytest.param(CACHING, "16", id="caching"),
    pytest.param(PREPARING, "1", id="preparing"), pytest.param(COMPILING, "2", id="compiling", marks=needs_compiler),
])  # fmt: skip
def test_a_child_of_a_busy_process_works(program, message, monkeypatch):
    if program == COMPILING:
        monkeypatch.setenv("CONICOID_JIT", "own")
    with child(program) as running:
        assert running.line(120) == message
        code, rest, errors = running.end(60)
    assert (code, rest) == (0, "0\n")
    assert "Traceback" not in errors


def test_locks_are_not_kept():
    lock = forks.fork_safe_lock()
    reference = weakref.ref(lock)
    del lock
    gc.collect()
    assert reference() is None
