"""Width of the vectors that LLVM makes of loops over lanes, chosen for each processor in place of LLVM's preference.

For all Intel processors with AVX-512 LLVM prefers 256 bits, even for those that run 512 bits at full rate, where half
as many instructions do the same work. Code with explicit vectors of eight doubles uses 512 bits wherever registers
allow, so a preference for 256 would not even keep up the clock of an older processor.

An attribute of each function sets the width, so that functions of other packages in the process keep LLVM's choice. The
width changes no result: neither way reorders arithmetic.
"""

from __future__ import annotations

import functools
from typing import Any

from .._util.environment import read_vector_bits

NARROW, WIDE = 256, 512

_FULL_RATE = (
    "icelake-server", "sapphirerapids", "emeraldrapids", "graniterapids", "graniterapids-d", "diamondrapids",
    "znver4", "znver5",
)  # fmt: skip
"""Processors, by LLVM's names, that run 512 bits at their full rate.

Intel's servers since Ice Lake have two ports for fused multiply-adds of 512 bits, and a clock that hardly depends on
them. Zen 5 has units of 512 bits; Zen 4 halves each instruction, at no cost. Not Skylake, Cascade Lake and Cooper Lake,
which lower their clock, nor Intel's processors for desktops and laptops, which have one such port.
"""

_FULL_RATE_FEATURES = {"+avx512fp16"}, {"+avx512f", "+sse4a"}
"""Features that only Sapphire Rapids and its successors have, and only AMD's processors: LLVM may not know the name of
a processor, or report another."""

_wish = read_vector_bits()


@functools.cache
def _bits(triple: str, processor: str, features: str, wish: int) -> int:
    if wish or not triple.startswith("x86_64"):
        return wish
    has = set(features.split(","))
    full_rate = processor in _FULL_RATE or any(some <= has for some in _FULL_RATE_FEATURES)
    return WIDE if full_rate else NARROW


def bits(codegen: Any) -> int:
    """Return the width in bits for the processor of a code generator of Numba; 0 leaves the choice to LLVM.

    It is an upper limit: a processor without AVX-512 has no vectors of 512 bits.
    """
    return _bits(*codegen.magic_tuple(), _wish)


def prefer_width(module: Any, width: int) -> None:
    """Set the preferred vector width, in bits, of all functions that an `llvmlite.ir` module defines; 0 sets none."""
    for function in module.functions if width else ():
        if not function.is_declaration:
            set.add(function.attributes, f'"prefer-vector-width"="{width}"')  # llvmlite's own `add` knows no such names


def describe_vectors() -> str:
    """Return the vector width chosen for this processor, for a report."""
    from numba.core.registry import cpu_target

    width = bits(cpu_target.target_context.codegen())
    return f"loops in vectors of up to {width} bits" if width else "loops in vectors of LLVM's choice"
