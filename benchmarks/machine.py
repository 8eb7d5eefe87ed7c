"""The limits of a processor: fused multiply-adds, copies, and the latency of memory."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable

import llvmlite.binding as llvm
import numpy as np
from numba import njit

from conicoid.kernels.threads import run_chunks, thread_count

_CHAINS, _ROUNDS = 16, 20_000_000


def least(run: Callable[[], object], clock: Callable[[], float] = time.thread_time, times: int = 5) -> float:
    """Seconds of the fastest of some runs: of the processor, so that what runs beside it counts little."""
    seconds = []
    for _ in range(times):
        begin = clock()
        run()
        seconds.append(clock() - begin)
    return min(seconds)


def _fused_code(width: int) -> str:
    """LLVM's text of a loop over independent chains of fused multiply-adds in vectors of some doubles."""
    kind = f"<{width} x double>"
    names = [f"%a{k}" for k in range(_CHAINS)]
    begins = "\n".join(f"  {name} = phi {kind} [zeroinitializer, %entry], [{name}n, %loop]" for name in names)
    steps = "\n".join(f"  {a}n = call {kind} @llvm.fma.v{width}f64({kind} {a}, {kind} %x, {kind} %y)" for a in names)
    sums = [f"  %s{k} = fadd {kind} {f'%s{k - 1}' if k else 'zeroinitializer'}, %a{k}n" for k in range(_CHAINS)]
    return "\n".join([
        f"declare {kind} @llvm.fma.v{width}f64({kind}, {kind}, {kind})",
        "define double @chains(i64 %n, double %x1) {", "entry:",
        f"  %x0 = insertelement {kind} undef, double %x1, i32 0",
        f"  %x = shufflevector {kind} %x0, {kind} undef, <{width} x i32> zeroinitializer",
        f"  %y = fadd {kind} %x, %x", "  br label %loop", "loop:",
        "  %i = phi i64 [0, %entry], [%j, %loop]", begins, steps,
        "  %j = add i64 %i, 1", "  %more = icmp ult i64 %j, %n", "  br i1 %more, label %loop, label %done", "done:",
        *sums, f"  %r = extractelement {kind} %s{_CHAINS - 1}, i32 0", "  ret double %r", "}",
    ])  # fmt: skip


def fused_peak() -> float:
    """Operations a second of one core (a fused multiply-add is two), in doubles, with the widest vectors."""
    features = llvm.get_host_cpu_features()
    width = 8 if features.get("avx512f") else 4 if features.get("avx") else 2
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features.flatten(), opt=3)
    module = llvm.parse_assembly(_fused_code(width))
    with llvm.create_mcjit_compiler(module, machine) as engine:
        engine.finalize_object()
        address = engine.get_function_address("chains")
        chains = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64, ctypes.c_double)(address)
        seconds = least(lambda: chains(_ROUNDS, 0.5))
    return 2.0 * width * _CHAINS * _ROUNDS / seconds


def copy_bandwidth(size: int = 1 << 28) -> float:
    """Bytes a second, read and written together, of a copy by all threads."""
    source, target = np.ones(size // 8), np.zeros(size // 8)

    def copy(begin: int, end: int) -> None:
        target[begin:end] = source[begin:end]

    share = -(-len(source) // thread_count())
    return 2.0 * size / least(lambda: run_chunks(copy, len(source), share), time.perf_counter)


@njit
def _follow(following, steps):
    place = 0
    for _ in range(steps):
        place = following[place]
    return place


def latency(size: int) -> float:
    """Seconds until an address in a block of some bytes, anywhere in it, is read: each is known from the last."""
    lines = size // 64
    order = np.random.default_rng(0).permutation(lines)
    following = np.empty(8 * lines, np.int64)
    following[8 * order] = 8 * np.roll(order, -1)
    steps = min(lines, 1_000_000)
    _follow(following, 1)
    return least(lambda: _follow(following, steps), times=3) / steps
