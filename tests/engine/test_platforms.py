"""The kernels that Numba compiles ask the machine for nothing that two machines answer differently.

The build holds machine code to the same: tests/native/test_arithmetic.py.
"""

import json

import pytest

from native.arithmetic import strange_functions

from ..children import child

pytestmark = pytest.mark.deep  # it compiles all kernels

PROGRAM = """
import gc, json, os, re
os.environ["CONICOID_JIT"] = "own"
import conicoid as co
from conicoid._jit.compiler import Kernel
from native.arithmetic import reordered

co.warmup()
kernels = [item for item in gc.get_objects() if isinstance(item, Kernel) and item.__module__.startswith("conicoid.")]
called, odd, names = {}, [], set()
for kernel in kernels:
    for version in kernel.overloads.values():
        code = version.library.get_llvm_str()
        names.add(kernel.__name__)
        for function in re.findall(r'^declare [^@]*@"?([^"(]+)', code, re.M):
            called.setdefault(function, []).append(kernel.__name__)
        odd += reordered(code)
print(json.dumps([sorted(names), called, odd]), flush=True)
"""


@pytest.fixture(scope="module")
def kernels():
    with child(PROGRAM) as running:
        names, called, odd = json.loads(running.line(3000))
        assert running.end(60)[0] == 0
    return names, called, odd


def test_no_kernel_calls_a_function_of_the_c_library(kernels):
    names, called, _ = kernels
    assert len(names) > 30
    assert "llvm.fma.f64" in called
    assert {name: called[name] for name in strange_functions(called)} == {}


def test_no_arithmetic_may_be_reordered_or_fused(kernels):
    assert kernels[2] == []
