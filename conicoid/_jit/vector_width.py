"""How wide the vectors are that LLVM makes of loops over lanes: our choice for each processor, not LLVM's.

Of the processors with AVX-512 LLVM prefers 256 bits for all of Intel's, also for those that lose nothing by 512: half
as many instructions then do the same work. What is written in vectors of eight doubles has 512 bits wherever there are
registers for them, so that a preference for 256 would not even keep the clock of an older processor up.

A function says by an attribute what it prefers, so that other people's functions in the process keep LLVM's choice.
The width changes no result: neither way reorders arithmetic.
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
"""What only Sapphire Rapids and its successors have, and only AMD's: LLVM may not know the name, or guess another."""

_wish = read_vector_bits()


@functools.cache
def _bits(triple: str, processor: str, features: str, wish: int) -> int:
    if wish or not triple.startswith("x86_64"):
        return wish
    has = set(features.split(","))
    full_rate = processor in _FULL_RATE or any(some <= has for some in _FULL_RATE_FEATURES)
    return WIDE if full_rate else NARROW


def bits(codegen: Any) -> int:
    """The width for the processor that one of Numba's code generators makes code for; 0 where LLVM may choose.

    It is the most: a processor without AVX-512 has no vectors of 512 bits.
    """
    return _bits(*codegen.magic_tuple(), _wish)


def prefer_width(module: Any, width: int) -> None:
    """Let all functions that a module of `llvmlite.ir` defines prefer vectors of some bits; 0: what LLVM likes."""
    for function in module.functions if width else ():
        if not function.is_declaration:
            set.add(function.attributes, f'"prefer-vector-width"="{width}"')  # llvmlite's own `add` knows no such names


def describe_vectors() -> str:
    """For a report: what was chosen for this processor."""
    from numba.core.registry import cpu_target

    width = bits(cpu_target.target_context.codegen())
    return f"loops in vectors of up to {width} bits" if width else "loops in vectors of LLVM's choice"
