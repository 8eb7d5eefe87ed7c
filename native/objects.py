"""LLVM code of kernels to an object file for one level of processor, in two steps.

`python -m native.objects CODE TARGET BASE` links all kernels into one module and simplifies it, once for a target;
`python -m native.objects BASE TARGET LEVEL OUT` optimises that for a level and writes the object.

Every kernel gets an entry point that C can call, `int NAME(void *result, const int64_t *slots)`: each slot is one
argument as LLVM passes it, a number or a pointer. The result is what Numba's own functions write, the return value
their status: 0, -2 for nothing, else an error.
"""

from __future__ import annotations

import pickle
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir

from .arithmetic import reordered, strange_functions
from .targets import TARGETS, Level

PREFIX = "conicoid_entry_"
"""The prefix of entry points before a level gives them its own."""

DROPPED = llvm.Linkage.linkonce_any, llvm.Linkage.linkonce_odr

_WIDTHS = {"i64": ir.IntType(64), "i32": ir.IntType(32), "i8": ir.IntType(8), "i1": ir.IntType(1)}
_DOUBLE, _POINTER, _SLOT = ir.DoubleType(), ir.IntType(8).as_pointer(), ir.IntType(64)


def kind_of(text: str) -> Any:
    """Return LLVM's type of an argument."""
    if text.endswith("*"):
        return _POINTER
    return _DOUBLE if text == "double" else _WIDTHS[text]


def _entry(module: ir.Module, name: str, kernel: dict[str, Any]) -> None:
    """Return the entry point of a kernel."""
    kinds = [kind_of(each) for each in kernel["arguments"]]
    inner = ir.Function(module, ir.FunctionType(_WIDTHS["i32"], kinds), kernel["symbol"])
    outer = ir.Function(module, ir.FunctionType(_WIDTHS["i32"], [_POINTER, _SLOT.as_pointer()]), name)
    builder = ir.IRBuilder(outer.append_basic_block())
    error = builder.alloca(_POINTER)
    builder.store(ir.Constant(_POINTER, None), error)
    arguments = [outer.args[0], builder.bitcast(error, _POINTER)]
    for place, kind in enumerate(kinds[2:]):
        slot = builder.load(builder.gep(outer.args[1], [_WIDTHS["i32"](place)]))
        if kind == _POINTER:
            slot = builder.inttoptr(slot, _POINTER)
        elif kind == _DOUBLE:
            slot = builder.bitcast(slot, _DOUBLE)
        elif kind != _SLOT:
            slot = builder.trunc(slot, kind)
        arguments.append(slot)
    builder.ret(builder.call(inner, arguments))


def linked(
    kernels: dict[str, dict[str, Any]], codes: list[bytes], machine: Any, triple: str, prefix: str = PREFIX,
    put_entry: Callable[[ir.Module, str, dict[str, Any]], None] = _entry,
) -> Any:  # fmt: skip
    """Return one module of kernels and their entry points, whose names `prefix` begins and `put_entry` completes.

    Only these are seen from outside.
    """
    parts = []
    for number in sorted({number for kernel in kernels.values() for number in kernel["functions"]}):
        part = llvm.parse_bitcode(codes[number])
        part.data_layout, part.triple = str(machine.target_data), triple
        # Otherwise functions that no module before calls would be dropped, though later ones may call them
        for each in (*part.functions, *part.global_variables):
            if not each.is_declaration and each.linkage in DROPPED:
                each.linkage = "weak_odr"
        clean(part, machine)
        parts.append(part)
    # In pairs: LLVM looks through all of the receiving module at every link
    while len(parts) > 1:
        for first, second in zip(parts[::2], parts[1::2], strict=False):
            first.link_in(second)
        parts = parts[::2]
    whole = parts[0]
    entries = ir.Module("entries")
    entries.triple, entries.data_layout = triple, str(machine.target_data)
    for name, kernel in kernels.items():
        put_entry(entries, prefix + name, kernel)
    whole.link_in(llvm.parse_assembly(str(entries)))
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration:
            seen = each.name.startswith(prefix)
            each.linkage = "external" if seen else "internal"
            each.visibility = "hidden" if seen else "default"  # by the door, in the same library
    whole.verify()
    return whole


def clean(module: Any, machine: Any) -> None:
    """Put the variables of functions into registers, before each is copied into its callers: a quarter is left."""
    passes = llvm.create_new_module_pass_manager()
    passes.add_sroa_pass()
    passes.add_instruction_combine_pass()
    passes.run(module, llvm.create_pass_builder(machine, _tuning(0)))


def simplify(module: Any, machine: Any) -> None:
    """Run the cheap round in which Numba drops counts of references, for no level of processor in particular."""

    def with_passes(passes: Any) -> None:
        passes.add_loop_rotate_pass()
        passes.add_instruction_combine_pass()
        passes.add_jump_threading_pass()

    _run_passes(module, machine, 0, with_passes)


def optimize(module: Any, machine: Any, is_short: bool = False) -> None:
    """Run LLVM's best round, for one level of processor, on a module that `simplify` has seen.

    is_short: with less code, where a processor would wait for code.
    """
    _run_passes(module, machine, 2 if is_short else 3, lambda passes: None)


def _tuning(speed: int) -> Any:
    options = llvm.create_pipeline_tuning_options(speed_level=speed)
    options.loop_vectorization, options.slp_vectorization = speed == 3, False
    options.loop_unrolling = speed != 2
    return options


def _run_passes(module: Any, machine: Any, speed: int, more: Callable[[Any], None]) -> None:
    builder = llvm.create_pass_builder(machine, _tuning(speed))
    passes = builder.getModulePassManager()
    more(passes)
    passes.add_refprune_pass()
    passes.run(module, builder)


def hold(module: Any, other_file: Callable[[str], Any] = lambda name: "") -> None:
    """Refuse code whose answers another machine would not give to the bit (`arithmetic`).

    `other_file` returns a value for functions that are in an object of another file.
    """
    called = (each.name for each in module.functions if each.is_declaration)
    strange = strange_functions(name for name in called if not other_file(name))
    if strange:
        raise ValueError(f"kernels may not call {', '.join(strange)}")
    wrong = reordered(str(module))
    if wrong:
        raise ValueError(
            f"kernels have arithmetic that may be reordered: {wrong[0].strip()}, and {len(wrong) - 1} more"
        )


def machine_for(triple: str, level: Level, relocation: str = "pic") -> Any:
    """Return LLVM's back end for a level."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    options = dict(cpu=level.processor, features=level.features, opt=3, reloc=relocation, codemodel="default")
    return llvm.Target.from_triple(triple).create_target_machine(**options)


def write_base(code: str, target: str, out: str) -> None:
    """Write the module of all kernels that the levels of a target have in common, as bitcode."""
    chosen = TARGETS[target]
    machine = machine_for(chosen.triple, chosen.levels[0])
    whole = linked(*pickle.loads(Path(code).read_bytes()), machine, chosen.triple)
    simplify(whole, machine)
    Path(out).write_bytes(whole.as_bitcode())


def write_object(base: str, target: str, name: str, out: str) -> None:
    """Write the object of a level."""
    chosen = TARGETS[target]
    level = next(each for each in chosen.levels if each.name == name)
    machine = machine_for(chosen.triple, level)
    whole = llvm.parse_bitcode(Path(base).read_bytes())
    for function in whole.functions:
        if function.name.startswith(PREFIX):
            function.name = level.prefix + function.name.removeprefix(PREFIX)
    optimize(whole, machine)
    hold(whole)
    Path(out).write_bytes(machine.emit_object(whole))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a trace: its parent prints the message
    (write_base if len(sys.argv) == 4 else write_object)(*sys.argv[1:])
