"""Rules for LLVM code of kernels: it uses nothing that two processors or two C libraries answer differently.

Every object that is built follows them (`objects`), and so do the kernels that Numba compiles
(tests/engine/test_platforms.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

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
    r"NRT_\w+|Py[A-Z]\w+|_?Py_\w+",  # memory, and the wrappers
    r"numba_(?:adapt_ndarray|do_raise|unpickle|runtime_build_excinfo_struct)",
]
_REORDERED = re.compile(
    r"= (?:tail |musttail |notail )?(?:fadd|fsub|fmul|fdiv|frem|fneg|fcmp|call)"
    r" (?:fast|contract|reassoc|nsz|nnan|ninf|arcp|afn)\b.*|= frem .*"
)


def strange_functions(names: Iterable[str]) -> list[str]:
    """Return the functions that code calls, does not hold, and may not call."""
    return sorted(name for name in names if not any(re.fullmatch(rule, name) for rule in ALLOWED))


def reordered(code: str) -> list[str]:
    """Return the instructions of LLVM code that may be reordered or fused, or have a remainder of C's."""
    return _REORDERED.findall(code)
