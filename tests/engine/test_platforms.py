"""What kernels ask of the machine: nothing that two processors or two C libraries answer differently."""

from __future__ import annotations

import json
import re

import pytest

from ..children import child

PROGRAM = """
import gc, json, os, re
os.environ["CONICOID_JIT"] = "own"
import conicoid as co
from conicoid.compiler.functions import Kernel

co.warmup()
kernels = [item for item in gc.get_objects() if isinstance(item, Kernel) and item.__module__.startswith("conicoid.")]
called, odd, names = {}, [], set()
for kernel in kernels:
    for version in kernel.overloads.values():
        code = str(version.library._shared_module)
        names.add(kernel.__name__)
        for function in re.findall(r'^declare [^@]*@"?([^"(]+)', code, re.M):
            called.setdefault(function, []).append(kernel.__name__)
        flags = r"\\b(?:fast|contract|reassoc|nsz|nnan|ninf|arcp|afn)\\b"
        odd += re.findall(rf"= (?:fadd|fsub|fmul|fdiv|fneg|fcmp|frem|call) {flags}.*|.*\\bfrem\\b.*", code)
print(json.dumps([sorted(names), called, odd]), flush=True)
"""

EXACT = r"fma|sqrt|floor|fabs|copysign|is\.fpclass"
"""IEEE's: one answer each. None is taken from a C library where the processor has an instruction."""
WHOLE = r"(?:[us]max|[us]min|ctlz|cttz|ctpop|bswap|bitreverse|fsh[lr]|[us](?:add|sub|mul)\.(?:with\.overflow|sat))"
VECTOR = r"masked\.\w+|experimental\.vector\.\w+|vector\.reduce\.(?:add|and|or|xor|[us]max|[us]min)\.v\d+i\d+"
MEMORY = (
    r"memcpy|memset|memmove|prefetch|lifetime\.\w+|assume|trap|experimental\.noalias\.scope\.decl|x86\.atomic\.sub\.cc"
)
ALLOWED = [
    rf"llvm\.(?:{EXACT})\.(?:v\d+)?f64",
    rf"llvm\.{WHOLE}\.(?:v\d+)?i\d+",
    rf"llvm\.(?:{VECTOR})(?:\..*)?",
    rf"llvm\.(?:{MEMORY})(?:\..*)?",
    r"sqrt",  # LLVM makes an instruction of it, and every C library's is IEEE's
    r"NRT_\w+|Py[A-Z]\w+|_?Py_\w+|numba_(?:do_raise|unpickle|runtime_build_excinfo_struct)",  # memory, and the wrappers
]


@pytest.fixture(scope="module")
def kernels():
    with child(PROGRAM) as running:
        names, called, odd = json.loads(running.line(1200))
        assert running.end(60)[0] == 0
    return names, called, odd


def test_no_kernel_calls_a_function_of_the_c_library(kernels):
    names, called, _ = kernels
    assert len(names) > 30
    assert "llvm.fma.f64" in called
    strange = {name: users for name, users in called.items() if not any(re.fullmatch(rule, name) for rule in ALLOWED)}
    assert strange == {}


def test_no_arithmetic_may_be_reordered_or_fused(kernels):
    assert kernels[2] == []
